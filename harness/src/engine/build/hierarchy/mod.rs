//! Instances, variables and types of the Verilog, from Verilator's description of the design: [`json`] in newer
//! versions, [`xml`] in older ones. Both readers fill the same tables; here they become one list of variables.

mod json;
mod registers;
mod xml;

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use crate::engine::error::BuildError;

use registers::References;

pub use json::parse as parse_json;
pub use xml::parse as parse_xml;

/// The named values of an enumeration.
pub type EnumItems = Vec<(String, u64)>;

/// The kind of value that a variable holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// Bits: a scalar, a vector, an enumeration, a packed array or structure.
    Bits {
        /// The width in bits; of one element if it is an array.
        width: u32,
    },
    /// A `real`.
    Real,
    /// A `string`.
    Text,
    /// Anything else, which cannot be accessed.
    Other,
}

/// A field of a packed structure or union.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Field {
    /// Its name; of nested structures with dots, `header.kind`.
    pub name: String,
    /// The position of its lowest bit.
    pub low: u32,
    /// Its number of bits.
    pub width: u32,
    /// Whether its type is signed.
    pub signed: bool,
}

/// The direction of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum PortDirection {
    /// Driven by the bench.
    Input,
    /// Driven by the design.
    Output,
    /// Both.
    Inout,
}

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
    /// What it holds.
    pub kind: Kind,
    /// The indices of the leftmost and the rightmost bit, as declared; those of a value's bits if it has no such.
    pub bits: (i64, i64),
    /// Whether the type is signed.
    pub signed: bool,
    /// The values' names, if its type is an enumeration.
    pub items: EnumItems,
    /// The fields, if it is a packed structure or union; of one element if it is an array.
    pub fields: Vec<Field>,
    /// The direction, if it is a port of its module.
    pub port: Option<PortDirection>,
    /// The indices on the left and on the right of each unpacked dimension, outermost first, as declared.
    pub dimensions: Vec<(i64, i64)>,
    /// Whether it belongs to a function, a task or an unnamed block of its module.
    pub nested: bool,
    /// Whether it keeps its value between clock edges: a register, or a memory that a clock writes.
    pub register: bool,
}

/// A step of the path from a variable to a value in it: `.low` or `[1]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// To a member of a structure.
    Member(String),
    /// To an element of an array, counted from its lowest index.
    Element(u64),
}

/// A value in a variable that is a structure, or an array of structures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The way to it.
    pub steps: Vec<Step>,
    /// The value as a variable of its own, `pair.low` or `pairs[1].low`.
    pub variable: Variable,
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
    /// The values in each variable that is a structure, or an array of structures, by the variable's path. Older
    /// descriptions do not tell packed structures from others: those are here too, whole and by member.
    pub structures: HashMap<String, Vec<Part>>,
}

/// Returns the number of a constant like `4'hf` or `32'sh10`.
fn constant(text: &str) -> Option<u64> {
    let digits = text.rsplit_once("'h").or_else(|| text.rsplit_once("'sh"))?.1;
    u64::from_str_radix(digits, 16).ok()
}

/// Returns the bound of an array, of 32 bits in two's complement, with a sign or without.
fn bound(text: &str) -> Option<i64> {
    Some(i64::from(constant(text)? as u32 as i32))
}

/// Returns the value of a parameter: `32'shfffffffd` is -3, `1.5` a `real`, `&quot;text&quot;` a string; `None` for
/// anything else.
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

/// A module or an interface as Verilator describes it.
#[derive(Default)]
struct Module {
    original: String,
    constants: Vec<(String, Constant)>,
    variables: Vec<Declaration>,
    /// The name below this module, with its generate blocks, and the module.
    instances: Vec<(String, String)>,
    references: References,
}

impl Module {
    /// Adds an instance of a module or an interface; with the bounds of an array, one for each index.
    fn add_instances(&mut self, path: String, of: String, bounds: Option<(i64, i64)>) {
        match bounds {
            None => self.instances.push((path, of)),
            Some((left, right)) => {
                let indices = left.min(right)..=left.max(right);
                self.instances.extend(indices.map(|at| (format!("{path}[{at}]"), of.clone())));
            }
        }
    }
}

/// A variable as its module declares it.
struct Declaration {
    name: String,
    /// The named blocks it is in, such as `lane[0]`, with a dot after each.
    blocks: String,
    type_id: String,
    type_name: String,
    port: Option<PortDirection>,
    nested: bool,
}

/// Returns all instances below and with one, as (hierarchical name, module), in the order of the source.
fn expand(modules: &HashMap<String, Module>, path: String, of: &str, depth: u32, into: &mut Vec<(String, String)>) {
    into.push((path.clone(), of.to_owned()));
    // No design is 200 levels deep: the limit guards against a file that refers to itself.
    if let (Some(module), true) = (modules.get(of), depth < 200) {
        for (name, below) in &module.instances {
            expand(modules, format!("{path}.{name}"), below, depth + 1, into);
        }
    }
}

/// A type.
enum Type {
    /// A built-in one, by its keyword, with the indices of its leftmost and its rightmost bit.
    Basic { keyword: String, bits: Option<(i64, i64)>, signed: bool },
    /// An array of another.
    Array { of: String, bounds: (i64, i64), packed: bool },
    /// Members by name, the highest bits first where it is packed. Older descriptions do not say whether it is packed.
    Struct { members: Vec<(String, String)>, packed: Option<bool> },
    /// Members over each other.
    Union { members: Vec<(String, String)> },
    /// Another name of a type, or an enumeration on it.
    Same { of: String },
}

/// The types of the design, by Verilator's number for each.
#[derive(Default)]
struct Types {
    types: HashMap<String, Type>,
    /// By the enumeration's name.
    enumerations: HashMap<String, EnumItems>,
    /// The enumeration's name by its number.
    enumeration_names: HashMap<String, String>,
}

/// The most values of one variable that get names of their own.
const MOST_PARTS: usize = 4096;

/// No type is 64 levels deep: the limit guards against a description that refers to itself.
const DEPTH: u32 = 64;

impl Types {
    /// Returns the type behind names and enumerations.
    fn resolve<'a>(&'a self, mut id: &'a str) -> Option<&'a Type> {
        for _ in 0..DEPTH {
            match self.types.get(id)? {
                Type::Same { of } => id = of,
                other => return Some(other),
            }
        }
        None
    }

    /// Returns the width of a packed type in bits, or `None` if it is not packed.
    fn width(&self, id: &str, depth: u32) -> Option<u32> {
        if depth > DEPTH {
            return None;
        }
        let width = |id: &String| self.width(id, depth + 1);
        match self.resolve(id)? {
            Type::Basic { bits, .. } => bits.and_then(|(left, right)| u32::try_from(left.abs_diff(right) + 1).ok()),
            Type::Array { of, bounds: (left, right), packed: true } => {
                u32::try_from(left.abs_diff(*right) + 1).ok()?.checked_mul(width(of)?)
            }
            Type::Array { .. } | Type::Same { .. } => None,
            Type::Struct { packed: Some(false), .. } => None,
            Type::Struct { members, .. } => members.iter().try_fold(0u32, |sum, (_, of)| sum.checked_add(width(of)?)),
            Type::Union { members } => members.iter().map(|(_, of)| width(of)).max().flatten(),
        }
    }

    /// Returns the unpacked dimensions, outermost first, and the number of the elements' type.
    fn dimensions<'a>(&'a self, mut id: &'a str) -> (Vec<(i64, i64)>, &'a str) {
        let mut found = Vec::new();
        while let Some(Type::Array { of, bounds, packed: false }) = self.resolve(id) {
            found.push(*bounds);
            id = of;
            if found.len() > DEPTH as usize {
                break;
            }
        }
        (found, id)
    }

    fn kind(&self, id: &str) -> Kind {
        match self.resolve(id) {
            Some(Type::Basic { keyword, .. }) if keyword == "real" || keyword == "shortreal" => Kind::Real,
            Some(Type::Basic { keyword, .. }) if keyword == "string" => Kind::Text,
            Some(Type::Basic { keyword, .. }) if keyword == "event" || keyword == "chandle" => Kind::Other,
            _ => self.width(id, 0).map_or(Kind::Other, |width| Kind::Bits { width }),
        }
    }

    /// Returns the indices of the leftmost and the rightmost bit.
    fn bits(&self, id: &str) -> (i64, i64) {
        match self.resolve(id) {
            Some(Type::Basic { bits: Some(bits), .. }) => *bits,
            _ => (i64::from(self.width(id, 0).unwrap_or(1)) - 1, 0),
        }
    }

    fn is_signed(&self, id: &str) -> bool {
        match self.resolve(id) {
            Some(Type::Basic { signed, .. }) => *signed,
            _ => false,
        }
    }

    /// Returns the fields of a packed structure or union, those of nested ones after it.
    fn fields(&self, id: &str, prefix: &str, base: u32, depth: u32) -> Vec<Field> {
        let (members, stacked) = match self.resolve(id) {
            Some(Type::Struct { members, .. }) => (members, true),
            Some(Type::Union { members }) => (members, false),
            _ => return Vec::new(),
        };
        let mut found = Vec::new();
        let Some(mut top) = self.width(id, 0).filter(|_| depth < DEPTH) else { return found };
        for (name, of) in members {
            let Some(width) = self.width(of, 0) else { return Vec::new() };
            let low = if stacked { top - width } else { 0 };
            if stacked {
                top = low;
            }
            let name = format!("{prefix}{name}");
            found.push(Field { name: name.clone(), low: base + low, width, signed: self.is_signed(of) });
            found.extend(self.fields(of, &format!("{name}."), base + low, depth + 1));
        }
        found
    }

    /// Adds the values in a structure, or an array of structures; `into` has more than [`MOST_PARTS`] where they are
    /// too many. A value of another type is added itself, as is a structure that may be packed, before its members.
    fn add_parts(&self, module: &str, id: &str, part: &Part, into: &mut Vec<Part>) {
        if into.len() > MOST_PARTS || part.steps.len() > DEPTH as usize {
            return;
        }
        let (dimensions, element) = self.dimensions(id);
        let below = |name: String, step: Step| {
            let mut below = part.clone();
            below.variable.path.push_str(&name);
            below.steps.push(step);
            below
        };
        let unpacked = match self.resolve(element) {
            Some(Type::Struct { members, packed }) if *packed != Some(true) => Some((members, packed.is_none())),
            _ => None,
        };
        if unpacked.is_none_or(|(_, unsure)| unsure) && !part.steps.is_empty() {
            into.push(Part {
                variable: Variable {
                    kind: self.kind(element),
                    bits: self.bits(element),
                    signed: self.is_signed(element),
                    items: self.items(module, "", element),
                    fields: self.fields(element, "", 0, 0),
                    dimensions,
                    ..part.variable.clone()
                },
                steps: part.steps.clone(),
            });
        }
        let Some((members, _)) = unpacked else { return };
        if let Some(Type::Array { of, bounds: (left, right), packed: false }) = self.resolve(id) {
            let lowest = *left.min(right);
            for at in 0..=left.abs_diff(*right).min(MOST_PARTS as u64) {
                let name = format!("[{}]", lowest.saturating_add_unsigned(at));
                self.add_parts(module, of, &below(name, Step::Element(at)), into);
            }
            return;
        }
        for (name, of) in members {
            self.add_parts(module, of, &below(format!(".{name}"), Step::Member(name.clone())), into);
        }
    }

    /// Returns the items of an enumeration: by its number, else by the name of its type, which is looked for in the
    /// module, in the design and in packages.
    fn items(&self, module: &str, type_name: &str, id: &str) -> EnumItems {
        let mut at = id;
        for _ in 0..DEPTH {
            if let Some(name) = self.enumeration_names.get(at) {
                return self.enumerations.get(name).cloned().unwrap_or_default();
            }
            match self.types.get(at) {
                Some(Type::Same { of }) => at = of,
                _ => break,
            }
        }
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

/// Everything read from a description.
#[derive(Default)]
struct Design {
    /// The top module's name, and the key of its module.
    top: Option<(String, String)>,
    modules: HashMap<String, Module>,
    types: Types,
}

impl Design {
    /// Returns the hierarchy, from the top module down.
    fn expand(self, what: &'static str) -> Result<Hierarchy, BuildError> {
        let Some((top, key)) = self.top else {
            return Err(BuildError::Unexpected { what, reason: "it names no top module".into() });
        };
        let mut instances = Vec::new();
        expand(&self.modules, top, &key, 0, &mut instances);
        let mut hierarchy = Hierarchy::default();
        for (scope, of) in &instances {
            let Some(module) = self.modules.get(of) else { continue };
            let prefix = scope.split_once('.').map(|(_, below)| format!("{below}.")).unwrap_or_default();
            let constants = module.constants.iter().map(|(name, value)| (format!("{prefix}{name}"), value.clone()));
            hierarchy.constants.extend(constants);
            let registers = module.references.registers(&module.variables);
            for (declared, register) in module.variables.iter().zip(registers) {
                let (dimensions, element) = self.types.dimensions(&declared.type_id);
                let variable = Variable {
                    path: format!("{prefix}{}{}", declared.blocks, declared.name),
                    scope: format!("{scope}.{}", declared.blocks).trim_end_matches('.').to_owned(),
                    name: declared.name.clone(),
                    module: module.original.clone(),
                    kind: self.types.kind(element),
                    bits: self.types.bits(element),
                    signed: self.types.is_signed(element),
                    items: self.types.items(of, &declared.type_name, element),
                    fields: self.types.fields(element, "", 0, 0),
                    port: declared.port,
                    dimensions,
                    nested: declared.nested,
                    register,
                };
                if let Some(Type::Struct { .. }) = self.types.resolve(element) {
                    let mut parts = Vec::new();
                    let whole = Part { steps: Vec::new(), variable: variable.clone() };
                    self.types.add_parts(of, &declared.type_id, &whole, &mut parts);
                    if parts.len() <= MOST_PARTS {
                        hierarchy.structures.insert(variable.path.clone(), parts);
                    }
                }
                hierarchy.variables.push(variable);
            }
        }
        Ok(hierarchy)
    }
}

/// Returns `true` if a name matches a pattern in which `*` stands for any text.
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

    #[test]
    fn a_star_stands_for_anything() {
        assert!(matches("u_core.*", "u_core.alu.sum"));
        assert!(matches("*.state", "u_core.state"));
        assert!(matches("*", "x"));
        assert!(!matches("u_core.*", "u_cor"));
        assert!(!matches("state", "states"));
    }

    #[test]
    fn fields_stand_where_the_language_puts_them() {
        let basic = |width: i64, signed| Type::Basic { keyword: "logic".into(), bits: Some((width - 1, 0)), signed };
        let named = |name: &str, of: &str| (name.to_owned(), of.to_owned());
        let mut types = Types::default();
        types.types.insert("4".into(), basic(4, false));
        types.types.insert("8".into(), basic(8, true));
        types
            .types
            .insert("in".into(), Type::Struct { packed: Some(true), members: vec![named("a", "4"), named("b", "8")] });
        types.types.insert("u".into(), Type::Union { members: vec![named("pair", "in"), named("low", "4")] });
        types.types.insert(
            "out".into(),
            Type::Struct { packed: Some(true), members: vec![named("u", "u"), named("tail", "4")] },
        );
        types.types.insert("loop".into(), Type::Struct { packed: Some(true), members: vec![named("again", "loop")] });
        let found: Vec<_> = types.fields("out", "", 0, 0).into_iter().map(|f| (f.name, f.low, f.width)).collect();
        let at = |name: &str, low, width| (name.to_owned(), low, width);
        let expected = [at("u", 4, 12), at("u.pair", 4, 12), at("u.pair.a", 12, 4), at("u.pair.b", 4, 8)];
        assert_eq!(found[..4], expected);
        assert_eq!(found[4..], [at("u.low", 4, 4), at("tail", 0, 4)]);
        assert_eq!((types.kind("out"), types.kind("loop")), (Kind::Bits { width: 16 }, Kind::Other));
    }
}
