//! What the Verilog contains, read from Verilator's `--xml-only` output: instances, variables, signs and enumerations.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use crate::error::BuildError;

/// The named values of an enumeration.
pub type EnumItems = Vec<(String, u64)>;

/// A variable of one instance.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Variable {
    /// Name below the top module, `u_core.state`; a port of the top has no dot.
    pub path: String,
    /// The instance it is in, from the top module on: `top.u_core`.
    pub scope: String,
    /// The variable's own name.
    pub name: String,
    /// The module as written in the source, which a `.vlt` file wants.
    pub module: String,
    /// Whether the type is signed.
    pub signed: bool,
    /// The values' names, if its type is an enumeration.
    pub items: EnumItems,
    /// Whether it is a port of its module.
    pub port: bool,
    /// The indices on the left and on the right as declared, if it is an array of one dimension.
    pub range: Option<(i64, i64)>,
    /// Whether it belongs to a block, a function or a loop inside its module.
    pub nested: bool,
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Constant {
    /// A whole number of at most 64 bits, with its sign.
    Number(i128),
    /// A string.
    Text(String),
}

/// Everything named in the design.
#[derive(Debug, Clone, Default)]
pub struct Hierarchy {
    /// Variables of all instances, in the order of the source.
    pub variables: Vec<Variable>,
    /// Parameters and local parameters of all instances by their names below the top module.
    pub constants: Vec<(String, Constant)>,
}

/// An element's name and attributes as they stand in the file.
struct Tag<'a> {
    name: &'a str,
    attributes: &'a str,
    closing: bool,
    empty: bool,
}

impl<'a> Tag<'a> {
    fn get(&self, key: &str) -> Option<String> {
        let mut rest = self.attributes;
        while let Some(equals) = rest.find("=\"") {
            let name = rest[..equals].trim();
            let value_end = rest[equals + 2..].find('"')? + equals + 2;
            if name == key {
                return Some(unescape(&rest[equals + 2..value_end]));
            }
            rest = &rest[value_end + 1..];
        }
        None
    }
}

fn unescape(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'").replace("&amp;", "&")
}

fn tags(text: &str) -> impl Iterator<Item = Tag<'_>> {
    let mut rest = text;
    std::iter::from_fn(move || {
        loop {
            let start = rest.find('<')?;
            let end = start + rest[start..].find('>')?;
            let inner = &rest[start + 1..end];
            rest = &rest[end + 1..];
            if inner.starts_with(['?', '!']) {
                continue;
            }
            let closing = inner.starts_with('/');
            let empty = inner.ends_with('/');
            let inner = inner.trim_matches('/');
            let (name, attributes) = inner.split_once(' ').unwrap_or((inner, ""));
            return Some(Tag { name, attributes, closing, empty });
        }
    })
}

/// `4'hf`, `32'sh10`: the number behind the base.
fn constant(text: &str) -> Option<u64> {
    let digits = text.rsplit_once("'h").or_else(|| text.rsplit_once("'sh"))?.1;
    u64::from_str_radix(digits, 16).ok()
}

/// The value of a parameter: `32'shfffffffd` is -3, `&quot;text&quot;` a string; none if it is something else, or too wide.
fn parameter(text: &str) -> Option<Constant> {
    if let Some(inner) = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')) {
        return Some(Constant::Text(inner.to_owned()));
    }
    let value = i128::from(constant(text)?);
    let (width, base) = text.split_once('\'')?;
    let width: u32 = width.parse().ok().filter(|w| (1..=64).contains(w))?;
    let negative = base.starts_with('s') && value >> (width - 1) & 1 == 1;
    Some(Constant::Number(if negative { value - (1 << width) } else { value }))
}

#[derive(Default)]
struct Module {
    original: String,
    constants: Vec<(String, Constant)>,
    variables: Vec<(String, String, String, bool, bool)>, // name, type id, type name, port, nested
    instances: Vec<(String, String)>,                     // name below this module, with its generate blocks; module
}

/// All instances below and with one, as (hierarchical name, module), in the order of the source.
fn expand(modules: &HashMap<String, Module>, path: String, of: &str, depth: u32, into: &mut Vec<(String, String)>) {
    into.push((path.clone(), of.to_owned()));
    // No design is that deep: a limit all the same, since the file comes from outside.
    if let (Some(module), true) = (modules.get(of), depth < 200) {
        for (name, below) in &module.instances {
            expand(modules, format!("{path}.{name}"), below, depth + 1, into);
        }
    }
}

/// Reads the XML.
pub fn parse(text: &str) -> Result<Hierarchy, BuildError> {
    let mut top: Option<String> = None;
    // The blocks the tag at hand is in, by name if they have one.
    let mut blocks: Vec<String> = Vec::new();
    let mut modules: HashMap<String, Module> = HashMap::new();
    let mut signed: HashMap<String, bool> = HashMap::new();
    let mut element_type: HashMap<String, String> = HashMap::new();
    let mut enumerations: HashMap<String, EnumItems> = HashMap::new();
    let mut module: Option<String> = None;
    let mut enumeration: Option<String> = None;
    let mut item: Option<String> = None;
    let mut parameter_name: Option<String> = None;
    let mut functions = 0u32;
    let mut array: Option<String> = None;
    let mut bounds: HashMap<String, Vec<i64>> = HashMap::new();
    for tag in tags(text) {
        match (tag.name, tag.closing) {
            ("module", false) => {
                let name = tag.get("name").unwrap_or_default();
                if tag.get("topModule").is_some() {
                    top = Some(name.clone());
                }
                blocks.clear();
                let original = tag.get("origName").unwrap_or_else(|| name.clone());
                modules.insert(name.clone(), Module { original, ..Module::default() });
                module = Some(name).filter(|_| !tag.empty);
            }
            ("module", true) => module = None,
            ("begin", false) if !tag.empty => blocks.push(tag.get("name").unwrap_or_default()),
            ("begin", true) => {
                blocks.pop();
            }
            ("func" | "task", false) if !tag.empty => functions += 1,
            ("func" | "task", true) => functions = functions.saturating_sub(1),
            ("instance", false) => {
                if let (Some(into), Some(name), Some(of)) =
                    (module.as_ref().and_then(|m| modules.get_mut(m)), tag.get("name"), tag.get("defName"))
                {
                    let mut path: Vec<&str> = blocks.iter().map(String::as_str).filter(|b| !b.is_empty()).collect();
                    path.push(&name);
                    into.instances.push((path.join("."), of));
                }
            }
            ("var", false) => {
                let constant = tag.get("param").is_some() || tag.get("localparam").is_some();
                parameter_name = tag.get("name").filter(|_| constant && !tag.empty);
                if let (Some(into), Some(name), false) =
                    (module.as_ref().and_then(|m| modules.get_mut(m)), tag.get("name"), constant)
                {
                    into.variables.push((
                        name,
                        tag.get("dtype_id").unwrap_or_default(),
                        tag.get("vartype").unwrap_or_default(),
                        tag.get("dir").is_some(),
                        !blocks.is_empty() || functions > 0,
                    ));
                }
            }
            ("var", true) => parameter_name = None,
            ("enumdtype", false) => enumeration = tag.get("name"),
            ("enumdtype", true) => enumeration = None,
            ("enumitem", false) => item = tag.get("name"),
            ("enumitem", true) => item = None,
            ("const", false) if array.is_some() => {
                if let (Some(of), Some(Constant::Number(bound))) =
                    (&array, tag.get("name").as_deref().and_then(parameter))
                {
                    bounds.entry(of.clone()).or_default().push(bound as i64);
                }
            }
            ("unpackarraydtype", true) => array = None,
            ("const", false) if parameter_name.is_some() => {
                if let (Some(into), Some(name), Some(value)) = (
                    module.as_ref().and_then(|m| modules.get_mut(m)),
                    parameter_name.take(),
                    tag.get("name").as_deref().and_then(parameter),
                ) {
                    into.constants.push((name, value));
                }
            }
            ("const", false) => {
                if let (Some(of), Some(name), Some(value)) =
                    (&enumeration, &item, tag.get("name").as_deref().and_then(constant))
                {
                    enumerations.entry(of.clone()).or_default().push((name.clone(), value));
                }
            }
            (_, false) if tag.name.ends_with("dtype") => {
                if let Some(id) = tag.get("id") {
                    if tag.name == "unpackarraydtype" && !tag.empty {
                        array = Some(id.clone());
                    }
                    if let Some(of) = tag.get("sub_dtype_id") {
                        element_type.insert(id.clone(), of);
                    }
                    signed.insert(id, tag.get("signed").as_deref() == Some("true"));
                }
            }
            _ => {}
        }
    }
    let Some(top) = top else {
        return Err(BuildError::Unexpected { what: "XML", reason: "it names no top module".into() });
    };
    let mut instances = Vec::new();
    expand(&modules, top.clone(), &top, 0, &mut instances);
    let is_signed = |type_id: &str| {
        let mut id = type_id;
        while let Some(of) = element_type.get(id) {
            id = of.as_str();
        }
        signed.get(id).copied().unwrap_or(false)
    };
    let range_of = |type_id: &str| match bounds.get(type_id).map(Vec::as_slice) {
        Some([left, right]) => Some((*left, *right)),
        _ => None,
    };
    let items_of = |module: &str, type_name: &str| -> EnumItems {
        if type_name.is_empty() || type_name == "logic" {
            return EnumItems::new();
        }
        let tail = format!(".{type_name}");
        let own = format!("{module}.{type_name}");
        enumerations
            .get(&own)
            .or_else(|| enumerations.get(type_name))
            .or_else(|| {
                enumerations.iter().filter(|(name, _)| name.ends_with(&tail)).min_by_key(|(name, _)| *name).map(|f| f.1)
            })
            .cloned()
            .unwrap_or_default()
    };
    let (mut variables, mut constants) = (Vec::new(), Vec::new());
    for (scope, of) in &instances {
        let Some(module) = modules.get(of) else { continue };
        let prefix = scope.split_once('.').map(|(_, below)| format!("{below}.")).unwrap_or_default();
        constants.extend(module.constants.iter().map(|(name, value)| (format!("{prefix}{name}"), value.clone())));
        for (name, type_id, type_name, port, nested) in &module.variables {
            variables.push(Variable {
                path: format!("{prefix}{name}"),
                scope: scope.clone(),
                name: name.clone(),
                module: module.original.clone(),
                signed: is_signed(type_id),
                items: items_of(of, type_name),
                port: *port,
                range: range_of(type_id),
                nested: *nested,
            });
        }
    }
    Ok(Hierarchy { variables, constants })
}

/// Whether a name fits a pattern in which `*` stands for anything.
pub fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, tail)) => name
            .strip_prefix(head)
            .is_some_and(|rest| (0..=rest.len()).any(|at| rest.is_char_boundary(at) && matches(tail, &rest[at..]))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const XML: &str = r#"<?xml version="1.0" ?><verilator_xml><cells>
      <cell loc="c" name="t" submodname="t" hier="t"><cell name="u" submodname="sub__W8" hier="t.u"/></cell></cells>
      <netlist><module name="t" origName="t" topModule="1">
        <var name="W" dtype_id="1" vartype="logic" param="true"><const name="32'sh8" dtype_id="1"/></var>
        <var name="N" dtype_id="1" vartype="logic" localparam="true"><const name="4'shd" dtype_id="1"/></var>
        <var name="S" dtype_id="1" vartype="string" param="true"><const name="&quot;a b&quot;" dtype_id="1"/></var>
        <var name="a$b" dtype_id="1" dir="input" vartype="logic" origName="a__024b"/>
        <begin name="lane"><var name="g" dtype_id="1" vartype="integer"/></begin><begin name="lane[0]"><instance name="u" defName="sub__W8"/></begin></module>
      <module name="sub__W8" origName="sub"><var name="mem" dtype_id="7" vartype=""/><var name="st" dtype_id="2" vartype="st_t"/></module>
      <typetable><basicdtype id="1" name="logic" left="3" right="0" signed="true"/><basicdtype id="2" name="logic"/>
      <enumdtype id="9" name="sub__W8.st_t" sub_dtype_id="2"><enumitem name="IDLE"><const name="2'h0"/></enumitem>
      <enumitem name="RUN"><const name="2'h2"/></enumitem></enumdtype>
      <unpackarraydtype id="7" sub_dtype_id="1"><range><const name="32'shf"/><const name="32'sh0"/></range></unpackarraydtype></typetable></netlist></verilator_xml>"#;

    #[test]
    fn signs_instances_and_enumerations_are_found() {
        let found = parse(XML).unwrap().variables;
        let paths: Vec<&str> = found.iter().map(|v| v.path.as_str()).collect();
        assert_eq!(paths, ["a$b", "g", "lane[0].u.mem", "lane[0].u.st"]);
        assert!(found[1].nested && !found[0].nested && !found[2].nested);
        let found: Vec<_> = found.into_iter().filter(|v| !v.nested).collect();
        assert!(found[0].signed && found[0].port);
        assert!(found[1].signed && !found[1].port, "a memory has its element's sign");
        assert_eq!((found[1].range, found[0].range), (Some((15, 0)), None));
        assert_eq!(found[2].items, [("IDLE".to_owned(), 0), ("RUN".to_owned(), 2)]);
        assert_eq!((found[2].module.as_str(), found[2].scope.as_str()), ("sub", "t.lane[0].u"));
    }

    #[test]
    fn parameters_have_their_values() {
        let number = |name: &str, value| (name.to_owned(), Constant::Number(value));
        let found = parse(XML).unwrap().constants;
        assert_eq!(found, [number("W", 8), number("N", -3), ("S".to_owned(), Constant::Text("a b".to_owned()))]);
    }

    #[test]
    fn a_star_stands_for_anything() {
        assert!(matches("u_core.*", "u_core.alu.sum"));
        assert!(matches("*.state", "u_core.state"));
        assert!(matches("*", "x"));
        assert!(!matches("u_core.*", "u_cor"));
        assert!(!matches("state", "states"));
    }
}
