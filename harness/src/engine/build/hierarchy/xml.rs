//! The description as XML, `--xml-only`, of versions before 5.024.

use super::registers::{Access, Process, Reference};
use super::{Declaration, Design, EnumItems, Hierarchy, Module, PortDirection, Type, bound, constant, parameter};
use crate::engine::error::BuildError;

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

/// What an element does with the variables in it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Assigns the last element in it, which is the target.
    Assignment(Access),
    /// Selects bits, a word or a member of the first element in it; the others are its place.
    Selection,
    /// Joins values.
    Join,
    /// Uses them.
    Other,
}

impl Role {
    fn of(name: &str) -> Role {
        match name {
            "assign" => Role::Assignment(Access::Assigned),
            "assigndly" => Role::Assignment(Access::Clocked),
            "concat" | "concatn" => Role::Join,
            "sel" | "arraysel" | "wordsel" | "structsel" | "slicesel" => Role::Selection,
            _ => Role::Other,
        }
    }
}

/// An element of an `always` or `initial` block that is open.
struct Element {
    role: Role,
    /// Elements directly in it so far.
    children: usize,
    /// References of the block before the last of these began.
    before_last: usize,
    /// Whether a variable in it would be a target, if the element is in one.
    is_whole: bool,
}

/// What was read so far, and the elements that enclose the next tag.
#[derive(Default)]
struct Reader {
    design: Design,
    /// The enclosing module.
    module: Option<String>,
    /// The enclosing blocks, by name if they have one.
    blocks: Vec<String>,
    /// How many functions and tasks enclose the tag.
    functions: u32,
    /// The parameter whose value comes next.
    parameter: Option<String>,
    /// The enclosing array type: its number, its element's, whether it is packed, and its bounds so far.
    array: Option<(String, String, bool, Vec<i64>)>,
    /// The bounds so far of the enclosing instance, if it is an array of them.
    instances: Option<Vec<i64>>,
    /// The enclosing structure or union: its number and members.
    structure: Option<(String, Vec<(String, String)>)>,
    /// The enclosing enumeration, and its item.
    enumeration: Option<String>,
    item: Option<String>,
    /// The enclosing `always` or `initial` block, its open elements, and for each of its references whether it is the
    /// whole of an operand rather than an index.
    process: Option<Process>,
    elements: Vec<Element>,
    wholes: Vec<bool>,
}

impl Reader {
    fn read(&mut self, tag: &Tag<'_>) {
        self.read_reference(tag);
        match (tag.name, tag.closing) {
            ("module" | "iface", false) => self.begin_module(tag),
            ("module" | "iface", true) => self.module = None,
            ("begin", false) if !tag.empty => self.blocks.push(tag.get("name").unwrap_or_default()),
            ("begin", true) => drop(self.blocks.pop()),
            ("func" | "task", false) if !tag.empty => self.functions += 1,
            ("func" | "task", true) => self.functions = self.functions.saturating_sub(1),
            ("instance", false) => self.add_instance(tag),
            ("instance", true) => self.instances = None,
            ("range", true) => self.end_instances(),
            ("var", false) => self.add_variable(tag),
            ("var", true) => self.parameter = None,
            ("enumdtype", true) => self.enumeration = None,
            ("enumitem", false) => self.item = tag.get("name"),
            ("enumitem", true) => self.item = None,
            ("unpackarraydtype" | "packarraydtype", true) => self.end_array(),
            ("structdtype" | "uniondtype", true) => self.end_structure(tag.name),
            ("const", false) => self.add_constant(tag),
            (name, false) if name.ends_with("dtype") => self.add_type(tag),
            _ => {}
        }
    }

    /// Follows which variables a module refers to, and how.
    fn read_reference(&mut self, tag: &Tag<'_>) {
        if self.process.is_none() {
            match (tag.name, tag.closing) {
                ("always" | "initial" | "final" | "func" | "task", false) if !tag.empty && self.module.is_some() => {
                    self.process = Some(Process::default());
                }
                ("varref", false) => {
                    let blocks = self.named_blocks();
                    if let (Some(module), Some(name)) = (self.current(), tag.get("name")) {
                        module.references.add_outside(Reference { blocks, name, access: Access::Read });
                    }
                }
                _ => {}
            }
            return;
        }
        if tag.closing {
            self.end_element(tag.name);
        } else {
            self.begin_element(tag);
        }
    }

    fn begin_element(&mut self, tag: &Tag<'_>) {
        let blocks = self.named_blocks();
        let Some(process) = &mut self.process else { return };
        let mut is_whole = true;
        // A delay of an assignment comes after its target.
        if let Some(parent) = self.elements.last_mut().filter(|_| tag.name != "delay") {
            is_whole = match parent.role {
                Role::Assignment(_) => true,
                Role::Join => parent.is_whole,
                Role::Selection => parent.is_whole && parent.children == 0,
                Role::Other => false,
            };
            parent.children += 1;
            parent.before_last = process.references.len();
        }
        if tag.name == "senitem" {
            process.has_edge |= matches!(tag.get("edgeType").as_deref(), Some("POS" | "NEG" | "BOTH"));
        }
        if let (true, Some(name)) = (tag.name == "varref", tag.get("name")) {
            process.references.push(Reference { blocks, name, access: Access::Read });
            self.wholes.push(is_whole);
        }
        if !tag.empty {
            self.elements.push(Element { role: Role::of(tag.name), children: 0, before_last: 0, is_whole });
        }
    }

    fn end_element(&mut self, closed: &str) {
        let Some(process) = &mut self.process else { return };
        match self.elements.pop() {
            Some(Element { role: Role::Assignment(access), before_last, .. }) => {
                let targets = process.references.iter_mut().zip(&self.wholes).skip(before_last);
                targets.filter(|(_, whole)| **whole).for_each(|(reference, _)| reference.access = access);
            }
            Some(_) => {}
            // The block itself.
            None => {
                self.wholes.clear();
                let process = self.process.take().unwrap_or_default();
                if let Some(module) = self.current() {
                    match closed {
                        "func" | "task" => module.references.add_task(process.references),
                        _ => module.references.add(process),
                    }
                }
            }
        }
    }

    /// Returns the enclosing named blocks, with a dot after each.
    fn named_blocks(&self) -> String {
        self.blocks.iter().filter(|block| !block.is_empty()).map(|block| format!("{block}.")).collect()
    }

    fn current(&mut self) -> Option<&mut Module> {
        self.design.modules.get_mut(self.module.as_ref()?)
    }

    fn begin_module(&mut self, tag: &Tag<'_>) {
        let name = tag.get("name").unwrap_or_default();
        if tag.get("topModule").is_some() {
            self.design.top = Some((name.clone(), name.clone()));
        }
        self.blocks.clear();
        let original = tag.get("origName").unwrap_or_else(|| name.clone());
        self.design.modules.insert(name.clone(), Module { original, ..Module::default() });
        self.module = Some(name).filter(|_| !tag.empty);
    }

    fn add_instance(&mut self, tag: &Tag<'_>) {
        let (Some(name), Some(of)) = (tag.get("name"), tag.get("defName")) else { return };
        let mut path: Vec<&str> = self.blocks.iter().map(String::as_str).filter(|b| !b.is_empty()).collect();
        path.push(&name);
        let path = path.join(".");
        self.instances = Some(Vec::new()).filter(|_| !tag.empty);
        if let Some(module) = self.current() {
            module.instances.push((path, of));
        }
    }

    /// Replaces the instance added last by one for each index of its range.
    fn end_instances(&mut self) {
        if let Some([left, right]) = self.instances.take().as_deref()
            && let (left, right) = (*left, *right)
            && let Some(module) = self.current()
            && let Some((path, of)) = module.instances.pop()
        {
            module.add_instances(path, of, Some((left, right)));
        }
    }

    fn add_variable(&mut self, tag: &Tag<'_>) {
        // A reference to an interface is no variable of the model.
        if tag.get("vartype").as_deref() == Some("ifaceref") {
            return;
        }
        let is_constant = tag.get("param").is_some() || tag.get("localparam").is_some();
        self.parameter = tag.get("name").filter(|_| is_constant && !tag.empty);
        let nested = self.functions > 0 || self.blocks.iter().any(String::is_empty);
        let blocks = self.named_blocks();
        if let (Some(module), Some(name), false) = (self.current(), tag.get("name"), is_constant) {
            module.variables.push(Declaration {
                name,
                blocks,
                type_id: tag.get("dtype_id").unwrap_or_default(),
                type_name: tag.get("vartype").unwrap_or_default(),
                port: tag.get("dir").map(|direction| match direction.as_str() {
                    "input" => PortDirection::Input,
                    "inout" => PortDirection::Inout,
                    _ => PortDirection::Output,
                }),
                nested,
            });
        }
    }

    /// Adds a constant: a bound of an array, the value of a parameter, or that of an enumeration's item.
    fn add_constant(&mut self, tag: &Tag<'_>) {
        let Some(text) = tag.get("name") else { return };
        if let Some((.., bounds)) = &mut self.array {
            bounds.extend(bound(&text));
        } else if let Some(bounds) = &mut self.instances {
            bounds.extend(bound(&text));
        } else if self.parameter.is_some() {
            let name = self.parameter.take();
            if let (Some(module), Some(name), Some(value)) = (self.current(), name, parameter(&text)) {
                module.constants.push((name, value));
            }
        } else if let (Some(of), Some(name), Some(value)) = (&self.enumeration, &self.item, constant(&text)) {
            self.design.types.enumerations.entry(of.clone()).or_default().push((name.clone(), value));
        }
    }

    fn add_type(&mut self, tag: &Tag<'_>) {
        let Some(id) = tag.get("id") else { return };
        let of = tag.get("sub_dtype_id");
        match (tag.name, of) {
            ("memberdtype", Some(of)) => {
                if let (Some((_, members)), Some(name)) = (&mut self.structure, tag.get("name")) {
                    members.push((name, of));
                }
            }
            ("unpackarraydtype" | "packarraydtype", Some(of)) if !tag.empty => {
                self.array = Some((id, of, tag.name == "packarraydtype", Vec::new()));
            }
            ("structdtype" | "uniondtype", _) if !tag.empty => self.structure = Some((id, Vec::new())),
            ("enumdtype", Some(of)) => {
                self.enumeration = tag.get("name").filter(|_| !tag.empty);
                if let Some(name) = tag.get("name") {
                    self.design.types.enumerations.insert(name.clone(), EnumItems::new());
                    self.design.types.enumeration_names.insert(id.clone(), name);
                }
                self.design.types.types.insert(id, Type::Same { of });
            }
            ("refdtype" | "constdtype", Some(of)) => {
                self.design.types.types.insert(id, Type::Same { of });
            }
            ("basicdtype", _) => {
                let bound = |key: &str| tag.get(key).and_then(|text| text.parse::<i64>().ok());
                let bits = Some((bound("left").unwrap_or(0), bound("right").unwrap_or(0)));
                let signed = tag.get("signed").as_deref() == Some("true");
                let keyword = tag.get("name").unwrap_or_default();
                self.design.types.types.insert(id, Type::Basic { keyword, bits, signed });
            }
            _ => {}
        }
    }

    fn end_array(&mut self) {
        if let Some((id, of, packed, bounds)) = self.array.take()
            && let [left, right] = bounds[..]
        {
            self.design.types.types.insert(id, Type::Array { of, bounds: (left, right), packed });
        }
    }

    fn end_structure(&mut self, name: &str) {
        if let Some((id, members)) = self.structure.take() {
            let structure = |members| Type::Struct { members, packed: None };
            let found = if name == "uniondtype" { Type::Union { members } } else { structure(members) };
            self.design.types.types.insert(id, found);
        }
    }
}

/// Reads the XML.
pub fn parse(text: &str) -> Result<Hierarchy, BuildError> {
    let mut reader = Reader::default();
    tags(text).for_each(|tag| reader.read(&tag));
    reader.design.expand("XML")
}

#[cfg(test)]
mod tests {
    use super::super::{Constant, Kind};
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
        assert!(found[0].signed && found[0].port == Some(PortDirection::Input));
        assert!(found[1].signed && found[1].port.is_none(), "a memory has its element's sign");
        assert_eq!((&found[1].dimensions[..], &found[0].dimensions[..]), (&[(15, 0)][..], &[][..]));
        assert_eq!((found[1].kind, found[2].kind), (Kind::Bits { width: 4 }, Kind::Bits { width: 1 }));
        assert_eq!(found[2].items, [("IDLE".to_owned(), 0), ("RUN".to_owned(), 2)]);
        assert_eq!((found[2].module.as_str(), found[2].scope.as_str()), ("sub", "t.lane[0].u"));
    }

    #[test]
    fn interfaces_are_instances_and_their_references_are_no_variables() {
        let xml = r#"<module name="t" topModule="1"><instance name="bus" defName="st_if"><port name="clk">
            <const name="1'h1"/></port></instance><var name="bus__Viftop" dtype_id="3" vartype="ifaceref"/>
            <instance name="pair" defName="st_if"><range><const name="32'h2"/><const name="32'h1"/></range>
            <port name="clk"><const name="1'h0"/></port></instance><instance name="u" defName="m"/></module>
          <module name="m"><var name="s" dtype_id="3" vartype="ifaceref"/></module>
          <iface name="st_if"><var name="data" dtype_id="2" vartype="logic"/></iface>
          <typetable><basicdtype id="2" name="logic" left="7" right="0"/><ifacerefdtype id="3"/></typetable>"#;
        let found = parse(xml).unwrap().variables;
        let paths: Vec<&str> = found.iter().map(|v| v.path.as_str()).collect();
        assert_eq!(paths, ["bus.data", "pair[1].data", "pair[2].data"]);
        assert_eq!((found[1].scope.as_str(), found[1].module.as_str()), ("t.pair[1]", "st_if"));
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
}
