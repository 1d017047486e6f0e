//! Verilator's generated C++: tables of public variables, classes and their members, structures.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::files::{files_in, read, write};
use super::hierarchy::Step;
use crate::engine::error::BuildError;

/// The generated tables of public variables.
pub(super) struct Tables {
    /// The expression of each variable's member, such as `TOP__g.lane__DOT__i`, by scope and name.
    pub members: HashMap<(String, String), String>,
}

impl Tables {
    pub fn read(generated: &Path) -> Result<Tables, BuildError> {
        let mut text = String::new();
        for path in symbol_files(generated)? {
            text.push_str(&read(&path)?);
        }
        let scopes: HashMap<&str, &str> = text.lines().filter_map(configured).collect();
        let of_line = |line| {
            let (scope, name, member) = inserted(line)?;
            Some((((*scopes.get(scope)?).to_owned(), name.to_owned()), member.to_owned()))
        };
        Ok(Tables { members: text.lines().filter_map(of_line).collect() })
    }

    /// Returns the variables, as (scope, name), that the tables list but that are no number in the generated classes.
    /// Older versions list whatever was asked for: a `genvar` or an interface's reference, which no class has, so that
    /// the C++ does not compile; and a queue, as if it were one byte.
    pub fn unreachable(&self, generated: &Path) -> Result<HashSet<(String, String)>, BuildError> {
        let symbols = read(&generated.join("Vdut__Syms.h"))?;
        let classes = classes_in(&symbols);
        let mut numbers: HashMap<&str, HashSet<String>> = HashMap::new();
        let mut found = HashSet::new();
        for (name, expression) in &self.members {
            let Some((instance, member)) = expression.split_once('.') else { continue };
            let Some(class) = classes.get(instance) else { continue };
            if !numbers.contains_key(class) {
                numbers.insert(class, numbers_of(&read(&generated.join(format!("{class}.h")))?));
            }
            if !numbers[class].contains(member) {
                found.insert(name.clone());
            }
        }
        Ok(found)
    }
}

/// The C++ structures that Verilator generates for unpacked structures.
pub(super) struct Structures {
    /// The class of each instance.
    classes: HashMap<String, String>,
    /// The types of the members of each class and structure.
    members: HashMap<String, HashMap<String, String>>,
}

impl Structures {
    pub fn read(generated: &Path) -> Result<Structures, BuildError> {
        let symbols = read(&generated.join("Vdut__Syms.h"))?;
        let classes = classes_in(&symbols).into_iter().map(|(instance, class)| (instance.to_owned(), class.to_owned()));
        let mut members = HashMap::new();
        for path in files_in(generated)?.iter().filter(|path| path.extension().is_some_and(|e| e == "h")) {
            add_members(&read(path)?, &mut members);
        }
        Ok(Structures { classes: classes.collect(), members })
    }

    /// Returns the type of a member, if it is a structure or an array of structures.
    pub fn of_member(&self, expression: &str) -> Option<&str> {
        let (instance, member) = expression.split_once('.')?;
        let found = self.members.get(self.classes.get(instance)?)?.get(member)?;
        self.is_structure(found).then_some(found)
    }

    /// Returns `true` if a type is a structure, or an array of structures.
    fn is_structure(&self, kind: &str) -> bool {
        let mut element = kind;
        while let Some((inner, _)) = element_of(element) {
            element = inner;
        }
        element.contains("__struct") && self.members.contains_key(element)
    }

    /// Returns the C++ suffix that selects a part of a value of type `of`, such as `[1].__PVT__low` for an element and
    /// a member; `None` if the type has no such part, or the part is a structure itself.
    pub fn expression<'a>(&'a self, mut of: &'a str, steps: &[Step]) -> Option<String> {
        let mut expression = String::new();
        for step in steps {
            match step {
                Step::Element(at) => {
                    let (inner, length) = element_of(of)?;
                    let _ = write!(expression, "[{}]", Some(at).filter(|at| **at < length)?);
                    of = inner;
                }
                Step::Member(name) => {
                    let members = self.members.get(of)?;
                    let found = [format!("__PVT__{name}"), name.clone()];
                    let (member, kind) = found.iter().find_map(|name| members.get_key_value(name))?;
                    let _ = write!(expression, ".{member}");
                    of = kind;
                }
            }
        }
        (!self.is_structure(of)).then_some(expression)
    }
}

/// Returns the type of the elements of a `VlUnpacked<CData, 3>`, and their number.
fn element_of(kind: &str) -> Option<(&str, u64)> {
    let (inner, length) = kind.strip_prefix("VlUnpacked<")?.strip_suffix('>')?.rsplit_once(',')?;
    Some((inner, length.trim().parse().ok()?))
}

/// Adds the members of the classes and structures of a generated header with their types, without comments.
fn add_members(header: &str, into: &mut HashMap<String, HashMap<String, String>>) {
    let mut inside = String::new();
    for line in header.lines().map(str::trim) {
        if let Some(opened) = line.strip_suffix('{').map(str::trim_end) {
            let opened = opened.split_once(" final").map_or(opened, |(name, _)| name);
            if opened.starts_with("struct ") || opened.starts_with("class ") {
                inside = opened.split(' ').next_back().unwrap_or_default().to_owned();
            }
        } else if let Some((kind, name)) = line.strip_suffix(';').and_then(|line| line.rsplit_once(' ')) {
            let mut plain = String::new();
            let mut rest = kind;
            while let Some((before, after)) = rest.split_once("/*") {
                plain.push_str(before);
                rest = after.split_once("*/").map_or("", |(_, after)| after);
            }
            plain.push_str(rest);
            into.entry(inside.clone()).or_default().insert(name.to_owned(), plain);
        }
    }
}

/// Returns the class of each instance: `Vdut_child   TOP__child;`.
pub(super) fn classes_in(symbols: &str) -> HashMap<&str, &str> {
    let lines = symbols.lines().filter_map(|line| line.trim().strip_suffix(';')?.split_once(' '));
    lines.map(|(class, instance)| (instance.trim(), class)).collect()
}

/// Returns the members of the generated top that its code assigns, other than at the model's creation.
pub(super) fn driven_ports(generated: &Path) -> Result<HashSet<String>, BuildError> {
    let mut driven = HashSet::new();
    for path in files_in(generated)?.iter().filter(|path| path.extension().is_some_and(|e| e == "cpp")) {
        driven.extend(assigned_in(&read(path)?));
    }
    Ok(driven)
}

/// Returns the members that lines such as `vlSelf->a[1U] = ...` and `VL_ASSIGNSEL_WI(.., vlSelf->a, ..)` assign. A
/// function that has the member among its arguments counts, because some write to them. The value 0 does not count: a
/// net without a driver gets it once, at the model's creation.
fn assigned_in(code: &str) -> HashSet<String> {
    let mut found = HashSet::new();
    let statements = code.lines().flat_map(|line| line.split(';')).map(str::trim);
    for line in statements.filter(|line| !is_reset(line)) {
        let target = match line.find(" = ") {
            Some(at) => &line[..at],
            None if line.starts_with("VL_") => line,
            None => continue,
        };
        for head in ["vlSelf->", "vlSymsp->TOP."] {
            let members = target.split(head).skip(1);
            let is_name = |c: char| c.is_alphanumeric() || c == '_';
            found.extend(members.map(|rest| rest.split(|c| !is_name(c)).next().unwrap_or_default().to_owned()));
        }
    }
    found
}

/// Removes the statements that reset the members of ports, and returns the ports that had any: older versions declare a
/// port that is an unpacked structure as a number, so that these statements do not compile. One that the design uses
/// has others, which still do not.
pub(super) fn drop_resets_of_members(generated: &Path, ports: &[&str]) -> Result<HashSet<String>, BuildError> {
    let mut found = HashSet::new();
    for path in files_in(generated)?.iter().filter(|path| path.extension().is_some_and(|e| e == "cpp")) {
        let (text, of) = without_resets(&read(path)?, ports);
        if !of.is_empty() {
            write(path, &text)?;
            found.extend(of);
        }
    }
    Ok(found)
}

/// Returns the code without lines such as `vlSelf->port.member = 0;`, and the ports of these lines.
fn without_resets(code: &str, ports: &[&str]) -> (String, HashSet<String>) {
    let mut found = HashSet::new();
    let mut kept = String::with_capacity(code.len());
    for line in code.lines() {
        let member = line.trim().strip_prefix("vlSelf->").and_then(|member| member.strip_suffix(';'));
        let member = member.filter(|member| is_reset(member));
        match member.and_then(|member| member.split_once('.')).filter(|(port, _)| ports.contains(port)) {
            Some((port, _)) => drop(found.insert(port.to_owned())),
            None => kept.extend([line, "\n"]),
        }
    }
    (kept, found)
}

/// Returns `true` for a statement, without its semicolon, that resets a variable.
fn is_reset(statement: &str) -> bool {
    statement.contains("VL_RAND_RESET") || [" = 0U", " = 0ULL", " = 0"].iter().any(|zero| statement.ends_with(zero))
}

/// Returns `true` if a generated class holds objects of the Verilog's classes.
pub(super) fn has_classes(generated: &Path) -> Result<bool, BuildError> {
    for path in files_in(generated)? {
        if path.extension().is_some_and(|e| e == "h") && read(&path)?.contains("VlClass") {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Returns the path of `Vdut__Syms.cpp`, or of the several files of newer versions.
fn symbol_files(generated: &Path) -> Result<Vec<PathBuf>, BuildError> {
    let is_one = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.starts_with("Vdut__Syms") && name.ends_with(".cpp")
    };
    Ok(files_in(generated)?.into_iter().filter(is_one).collect())
}

/// Returns the scope's variable and its name in a line like `__Vscope_t__lane.configure(this, name(), "t.lane", ...`
/// or, in newer versions, `__Vscopep_t__lane = new VerilatedScope{this, "t.lane", ...`.
fn configured(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    let (scope, rest) =
        line.split_once(".configure(this, name(), \"").or_else(|| line.split_once(" = new VerilatedScope{this, \""))?;
    Some((scope, rest.split_once('"')?.0))
}

/// Returns scope, name and member of a line like `__Vscope_t.varInsert(__Vfinal,"i", &(TOP__t.i), ...` or, in newer
/// versions, `__Vscopep_t->varInsert("i", &(TOP__t.i), ...`. Variables that the tables cannot hold are listed in
/// comments.
fn inserted(line: &str) -> Option<(&str, &str, &str)> {
    let line = line.trim();
    let line = line.strip_prefix("//UNSUP ").unwrap_or(line);
    let heads = [".varInsert(__Vfinal,\"", "->forceableVarInsert(\"", "->varInsert(\""];
    let (scope, rest) = heads.iter().find_map(|head| line.split_once(head))?;
    let (name, rest) = rest.split_once("\", &(")?;
    Some((scope, name, rest.split_once(')')?.0))
}

/// Returns the members of a generated class that are vectors, `real`, strings, structures, or arrays of these.
pub(super) fn numbers_of(header: &str) -> HashSet<String> {
    const TYPES: [&str; 8] = ["CData", "SData", "IData", "QData", "VlWide", "VlUnpacked", "double", "std::string"];
    let is_number = |line: &&str| {
        let port = line.starts_with("VL_IN") || line.starts_with("VL_OUT");
        let odd = ["VlQueue", "VlAssocArray", "VlClassRef"].iter().any(|odd| line.contains(odd));
        let structure = line.starts_with("Vdut_") && line.contains("__struct");
        !odd && line.ends_with(';') && (port || structure || TYPES.iter().any(|kind| line.starts_with(kind)))
    };
    let names = header
        .lines()
        .map(str::trim)
        .filter(is_number)
        .flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_').map(str::to_owned));
    names.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_tables_are_read() {
        let line =
            "        __Vscope_g__lane.varInsert(__Vfinal,\"i\", &(TOP__g.lane__DOT__i), false, VLVT_UINT32,0,1 ,31,0);";
        assert_eq!(inserted(line), Some(("__Vscope_g__lane", "i", "TOP__g.lane__DOT__i")));
        let newer =
            "    __Vscopep_g->varInsert(\"m\", &(TOP.g__DOT__m), false, VLVT_UINT16, VLVD_NODIR, 1, 1 ,0,15 ,15,0);";
        assert_eq!(inserted(newer), Some(("__Vscopep_g", "m", "TOP.g__DOT__m")));
        let forceable = "__Vscopep_g->forceableVarInsert(\"f\", &(TOP.g__DOT__f), false, VLVT_UINT8, \
                         &(TOP.f__VforceRd), {__Vscopep_g->varInsert(\"f__VforceEn\", &(TOP.f__VforceEn), false)}, 0);";
        assert_eq!(inserted(forceable), Some(("__Vscopep_g", "f", "TOP.g__DOT__f")));
        let comment =
            "  //UNSUP __Vscope_g.varInsert(__Vfinal,\"grid\", &(TOP.grid), false, VLVT_UINT8,0,3 ,3,0 ,0,1 ,0,2);";
        assert_eq!(inserted(comment), Some(("__Vscope_g", "grid", "TOP.grid")));
        let constant =
            "__Vscopep_g->varInsert(\"W\", const_cast<void*>(static_cast<const void*>(&(TOP.g__DOT__W))), true";
        assert_eq!(inserted(constant), None);
        let line =
            "    __Vscope_g__lane.configure(this, name(), \"g.lane[0]\", \"lane[0]\", 0, VerilatedScope::SCOPE_OTHER);";
        assert_eq!(configured(line), Some(("__Vscope_g__lane", "g.lane[0]")));
        let newer = "    __Vscopep_g__lane = new VerilatedScope{this, \"g.lane[0]\", \"lane[0]\", \"<null>\", 0};";
        assert_eq!(configured(newer), Some(("__Vscopep_g__lane", "g.lane[0]")));
        let header = "    CData/*7:0*/ byte;\n  VL_IN8(__PVT__clk,0,0);\n VlQueue<IData/*31:0*/> q;\n\
                      VlUnpacked<VlWide<4>/*99:0*/, 4> wide;\n VlUnpacked<VlQueue<CData/*0:0*/>, 2> qs;\n double r;";
        let found = numbers_of(header);
        assert!(["byte", "__PVT__clk", "wide", "r"].iter().all(|name| found.contains(*name)));
        assert!(["q", "qs"].iter().all(|name| !found.contains(*name)));
    }

    #[test]
    fn assigned_members_are_found() {
        let code = "    vlSelf->a = VL_RAND_RESET_I(1);\n    vlSelf->c = 0U;\n    vlSelf->b = vlSelf->c;\n    \
                    vlSelf->w[1U] = 2U;\n    VL_ASSIGNSEL_WI(70,8,3U, vlSelf->v, vlSelf->d);\n    \
                    if (vlSelf->e) {\n    vlSymsp->TOP.p = vlSelf->f;";
        let found = assigned_in(code);
        assert!(["b", "w", "v", "p"].iter().all(|name| found.contains(*name)), "{found:?}");
        assert!(["a", "c", "e", "f"].iter().all(|name| !found.contains(*name)), "{found:?}");
    }

    #[test]
    fn resets_of_ports_that_are_structures_are_dropped() {
        let kept = "    vlSelf->pair.low = 1U;\n    vlSelf->clk = VL_RAND_RESET_I(1);\n";
        let code = format!("    vlSelf->pair.low = VL_RAND_RESET_I(1);\n    vlSelf->pair.high = 0;\n{kept}");
        let (found, of) = without_resets(&code, &["pair", "clk"]);
        assert_eq!(found, kept);
        assert!(of.len() == 1 && of.contains("pair"));
    }

    #[test]
    fn structures_are_read_from_the_headers() {
        let header = "struct Vdut_in__struct1 {\n    CData/*3:0*/ lo;\n};\nstruct Vdut_t__struct0 {\n    \
                      VlWide<3>/*70:0*/ __PVT__b;\n    VlUnpacked<Vdut_in__struct1, 2> __PVT__in;\n\n    \
                      bool operator==(const Vdut_t__struct0& rhs) const {\n        return b == rhs.b;\n    }\n};\n\
                      class alignas(VL_CACHE_LINE_BYTES) Vdut___024root final {\n    Vdut_t__struct0 g__DOT__s;\n    \
                      VlUnpacked<Vdut_in__struct1, 2> g__DOT__m;\n    CData/*0:0*/ g__DOT__x;\n};";
        let mut members = HashMap::new();
        add_members(header, &mut members);
        let classes = HashMap::from([("TOP".to_owned(), "Vdut___024root".to_owned())]);
        let structures = Structures { classes, members };
        let member = |name: &str| Step::Member(name.into());
        assert_eq!(structures.of_member("TOP.g__DOT__x"), None);
        let whole = structures.of_member("TOP.g__DOT__s").unwrap();
        let low = [member("in"), Step::Element(1), member("lo")];
        assert_eq!(structures.expression(whole, &low).as_deref(), Some(".__PVT__in[1].lo"));
        assert_eq!(structures.expression(whole, &[member("b")]).as_deref(), Some(".__PVT__b"));
        assert_eq!(structures.expression(whole, &[member("none")]), None);
        let array = structures.of_member("TOP.g__DOT__m").unwrap();
        assert_eq!(structures.expression(array, &[Step::Element(2), member("lo")]), None, "there are two");
    }
}
