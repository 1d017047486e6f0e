//! Instances, variables, signs and enumerations of the Verilog, read from Verilator's `--xml-only` output.

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
    /// Whether it belongs to a function, a task or an unnamed block of its module.
    pub nested: bool,
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Constant {
    /// A whole number of at most 64 bits, with its sign.
    Number(i128),
    /// A wider one, without its sign: hexadecimal digits.
    Wide(String),
    /// A `real`.
    Real(f64),
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

/// An element's name and attributes.
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

/// The value of a parameter: `32'shfffffffd` is -3, `1.5` a `real`, `&quot;text&quot;` a string; none if it is
/// something else.
fn parameter(text: &str) -> Option<Constant> {
    if let Some(inner) = text.strip_prefix('"').and_then(|t| t.strip_suffix('"')) {
        return Some(Constant::Text(inner.to_owned()));
    }
    let Some((width, base)) = text.split_once('\'') else { return text.parse().ok().map(Constant::Real) };
    let width: u32 = width.parse().ok().filter(|w| *w > 0)?;
    if width > 64 {
        let digits = text.rsplit_once('h')?.1;
        return digits.chars().all(|c| c.is_ascii_hexdigit()).then(|| Constant::Wide(digits.to_owned()));
    }
    let value = i128::from(constant(text)?);
    let negative = base.starts_with('s') && value >> (width - 1) & 1 == 1;
    Some(Constant::Number(if negative { value - (1 << width) } else { value }))
}

#[derive(Default)]
struct Module {
    original: String,
    constants: Vec<(String, Constant)>,
    variables: Vec<Declaration>,
    /// The name below this module, with its generate blocks, and the module.
    instances: Vec<(String, String)>,
}

/// A variable as its module declares it.
struct Declaration {
    name: String,
    /// The named blocks it is in, such as `lane[0]`, with a dot after each.
    blocks: String,
    type_id: String,
    type_name: String,
    port: bool,
    nested: bool,
}

/// All instances below and with one, as (hierarchical name, module), in the order of the source.
fn expand(modules: &HashMap<String, Module>, path: String, of: &str, depth: u32, into: &mut Vec<(String, String)>) {
    into.push((path.clone(), of.to_owned()));
    // No design is 200 levels deep: the limit guards against a file that refers to itself.
    if let (Some(module), true) = (modules.get(of), depth < 200) {
        for (name, below) in &module.instances {
            expand(modules, format!("{path}.{name}"), below, depth + 1, into);
        }
    }
}

/// The types of the design, by Verilator's number for each.
#[derive(Default)]
struct Types {
    signed: HashMap<String, bool>,
    /// The element's type of an array, the base type of an enumeration.
    element: HashMap<String, String>,
    /// The indices on the left and on the right of each dimension.
    bounds: HashMap<String, Vec<i64>>,
    /// By the enumeration's name.
    enumerations: HashMap<String, EnumItems>,
}

impl Types {
    fn is_signed<'a>(&'a self, mut id: &'a str) -> bool {
        while let Some(of) = self.element.get(id) {
            id = of;
        }
        self.signed.get(id).copied().unwrap_or(false)
    }

    /// The indices of an array of one dimension.
    fn range(&self, id: &str) -> Option<(i64, i64)> {
        match self.bounds.get(id).map(Vec::as_slice) {
            Some([left, right]) => Some((*left, *right)),
            _ => None,
        }
    }

    /// The items of an enumeration, looked for in the module, in the design and in packages.
    fn items(&self, module: &str, type_name: &str) -> EnumItems {
        if type_name.is_empty() || type_name == "logic" {
            return EnumItems::new();
        }
        let (tail, of_package) = (format!(".{type_name}"), format!("::{type_name}"));
        let in_package = || {
            let named = self.enumerations.iter();
            let named = named.filter(|(name, _)| name.ends_with(&tail) || name.ends_with(&of_package));
            named.min_by_key(|(name, _)| *name).map(|found| found.1)
        };
        self.enumerations
            .get(&format!("{module}.{type_name}"))
            .or_else(|| self.enumerations.get(type_name))
            .or_else(in_package)
            .cloned()
            .unwrap_or_default()
    }
}

/// What was read so far, and the elements that enclose the next tag.
#[derive(Default)]
struct Reader {
    top: Option<String>,
    modules: HashMap<String, Module>,
    types: Types,
    /// The enclosing module.
    module: Option<String>,
    /// The enclosing blocks, by name if they have one.
    blocks: Vec<String>,
    /// How many functions and tasks enclose the tag.
    functions: u32,
    /// The parameter whose value comes next.
    parameter: Option<String>,
    /// The enclosing array type.
    array: Option<String>,
    /// The enclosing enumeration, and its item.
    enumeration: Option<String>,
    item: Option<String>,
}

impl Reader {
    fn read(&mut self, tag: &Tag<'_>) {
        match (tag.name, tag.closing) {
            ("module", false) => self.begin_module(tag),
            ("module", true) => self.module = None,
            ("begin", false) if !tag.empty => self.blocks.push(tag.get("name").unwrap_or_default()),
            ("begin", true) => drop(self.blocks.pop()),
            ("func" | "task", false) if !tag.empty => self.functions += 1,
            ("func" | "task", true) => self.functions = self.functions.saturating_sub(1),
            ("instance", false) => self.add_instance(tag),
            ("var", false) => self.add_variable(tag),
            ("var", true) => self.parameter = None,
            ("enumdtype", false) => self.enumeration = tag.get("name"),
            ("enumdtype", true) => self.enumeration = None,
            ("enumitem", false) => self.item = tag.get("name"),
            ("enumitem", true) => self.item = None,
            ("unpackarraydtype", true) => self.array = None,
            ("const", false) => self.add_constant(tag),
            (name, false) if name.ends_with("dtype") => self.add_type(tag),
            _ => {}
        }
    }

    fn current(&mut self) -> Option<&mut Module> {
        self.modules.get_mut(self.module.as_ref()?)
    }

    fn begin_module(&mut self, tag: &Tag<'_>) {
        let name = tag.get("name").unwrap_or_default();
        if tag.get("topModule").is_some() {
            self.top = Some(name.clone());
        }
        self.blocks.clear();
        let original = tag.get("origName").unwrap_or_else(|| name.clone());
        self.modules.insert(name.clone(), Module { original, ..Module::default() });
        self.module = Some(name).filter(|_| !tag.empty);
    }

    fn add_instance(&mut self, tag: &Tag<'_>) {
        let (Some(name), Some(of)) = (tag.get("name"), tag.get("defName")) else { return };
        let mut path: Vec<&str> = self.blocks.iter().map(String::as_str).filter(|b| !b.is_empty()).collect();
        path.push(&name);
        let path = path.join(".");
        if let Some(module) = self.current() {
            module.instances.push((path, of));
        }
    }

    fn add_variable(&mut self, tag: &Tag<'_>) {
        let is_constant = tag.get("param").is_some() || tag.get("localparam").is_some();
        self.parameter = tag.get("name").filter(|_| is_constant && !tag.empty);
        let nested = self.functions > 0 || self.blocks.iter().any(String::is_empty);
        let blocks = self.blocks.iter().filter(|block| !block.is_empty()).map(|block| format!("{block}.")).collect();
        if let (Some(module), Some(name), false) = (self.current(), tag.get("name"), is_constant) {
            module.variables.push(Declaration {
                name,
                blocks,
                type_id: tag.get("dtype_id").unwrap_or_default(),
                type_name: tag.get("vartype").unwrap_or_default(),
                port: tag.get("dir").is_some(),
                nested,
            });
        }
    }

    /// A bound of an array, the value of a parameter, or that of an enumeration's item.
    fn add_constant(&mut self, tag: &Tag<'_>) {
        let Some(text) = tag.get("name") else { return };
        if let Some(of) = &self.array {
            if let Some(Constant::Number(bound)) = parameter(&text) {
                self.types.bounds.entry(of.clone()).or_default().push(bound as i64);
            }
        } else if self.parameter.is_some() {
            let name = self.parameter.take();
            if let (Some(module), Some(name), Some(value)) = (self.current(), name, parameter(&text)) {
                module.constants.push((name, value));
            }
        } else if let (Some(of), Some(name), Some(value)) = (&self.enumeration, &self.item, constant(&text)) {
            self.types.enumerations.entry(of.clone()).or_default().push((name.clone(), value));
        }
    }

    fn add_type(&mut self, tag: &Tag<'_>) {
        let Some(id) = tag.get("id") else { return };
        if tag.name == "unpackarraydtype" && !tag.empty {
            self.array = Some(id.clone());
        }
        if let Some(of) = tag.get("sub_dtype_id") {
            self.types.element.insert(id.clone(), of);
        }
        self.types.signed.insert(id, tag.get("signed").as_deref() == Some("true"));
    }

    /// The hierarchy, from the top module down.
    fn finish(self) -> Result<Hierarchy, BuildError> {
        let Some(top) = self.top else {
            return Err(BuildError::Unexpected { what: "XML", reason: "it names no top module".into() });
        };
        let mut instances = Vec::new();
        expand(&self.modules, top.clone(), &top, 0, &mut instances);
        let mut hierarchy = Hierarchy::default();
        for (scope, of) in &instances {
            let Some(module) = self.modules.get(of) else { continue };
            let prefix = scope.split_once('.').map(|(_, below)| format!("{below}.")).unwrap_or_default();
            let constants = module.constants.iter().map(|(name, value)| (format!("{prefix}{name}"), value.clone()));
            hierarchy.constants.extend(constants);
            hierarchy.variables.extend(module.variables.iter().map(|declared| Variable {
                path: format!("{prefix}{}{}", declared.blocks, declared.name),
                scope: format!("{scope}.{}", declared.blocks).trim_end_matches('.').to_owned(),
                name: declared.name.clone(),
                module: module.original.clone(),
                signed: self.types.is_signed(&declared.type_id),
                items: self.types.items(of, &declared.type_name),
                port: declared.port,
                range: self.types.range(&declared.type_id),
                nested: declared.nested,
            }));
        }
        Ok(hierarchy)
    }
}

/// Reads the XML.
pub fn parse(text: &str) -> Result<Hierarchy, BuildError> {
    let mut reader = Reader::default();
    tags(text).for_each(|tag| reader.read(&tag));
    reader.finish()
}

/// Whether a name fits a pattern in which `*` matches any text.
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
        <var name="R" dtype_id="1" vartype="real" param="true"><const name="1.5" dtype_id="1"/></var>
        <var name="K" dtype_id="1" vartype="logic" param="true"><const name="100'h1000000000000000f"/></var>
        <var name="a$b" dtype_id="1" dir="input" vartype="logic" origName="a__024b"/>
        <begin name="lane"><var name="g" dtype_id="1" vartype="integer"/></begin>
        <begin name="lane[0]"><var name="q" dtype_id="2" vartype="logic"/><instance name="u" defName="sub__W8"/></begin>
        <func name="f"><var name="f" dtype_id="2" vartype="logic"/></func></module>
      <module name="sub__W8" origName="sub"><var name="mem" dtype_id="7" vartype=""/>
        <var name="st" dtype_id="2" vartype="st_t"/></module>
      <typetable><basicdtype id="1" name="logic" left="3" right="0" signed="true"/><basicdtype id="2" name="logic"/>
      <enumdtype id="9" name="sub__W8.st_t" sub_dtype_id="2"><enumitem name="IDLE"><const name="2'h0"/></enumitem>
      <enumitem name="RUN"><const name="2'h2"/></enumitem></enumdtype>
      <unpackarraydtype id="7" sub_dtype_id="1"><range><const name="32'shf"/><const name="32'sh0"/></range>
      </unpackarraydtype></typetable></netlist></verilator_xml>"#;

    #[test]
    fn signs_instances_and_enumerations_are_found() {
        let found = parse(XML).unwrap().variables;
        let paths: Vec<&str> = found.iter().map(|v| v.path.as_str()).collect();
        assert_eq!(paths, ["a$b", "lane.g", "lane[0].q", "f", "lane[0].u.mem", "lane[0].u.st"]);
        assert_eq!((found[2].scope.as_str(), found[2].nested), ("t.lane[0]", false));
        assert!(found[3].nested, "a function's variable");
        let found: Vec<_> = found.into_iter().filter(|v| !v.nested && !v.path.contains(['g', 'q'])).collect();
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
        let other = [
            ("S".to_owned(), Constant::Text("a b".to_owned())),
            ("R".to_owned(), Constant::Real(1.5)),
            ("K".to_owned(), Constant::Wide("1000000000000000f".to_owned())),
        ];
        assert_eq!(found[..2], [number("W", 8), number("N", -3)]);
        assert_eq!(found[2..], other);
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
