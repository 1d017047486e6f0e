//! From Verilator's C++ to one shared library: the table of ports, one file that includes all others (a unity build),
//! the runtime's objects.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::diagnostic;
use super::hierarchy::{self, Hierarchy, PortDirection, Step, Variable};
use super::runtime::{CXX_FLAGS, PREFIX, check_compiler, include_flags, needs_lz4, runtime_objects, trace_flags};
use super::tool::{self, Verilator, Version};
use super::{Build, Initial, Record, Trace, modules_in};
use crate::engine::error::{BuildError, nearest};

pub(super) const SHIM: &str = include_str!("shim.cpp");
/// Incremented whenever the shim's functions change.
pub(crate) const INTERFACE: u32 = 3;

/// Splits each `inout` of the top into an input and two outputs: value and enable. Older versions do not have it.
const SPLIT_INOUTS: &str = "--pins-inout-enables";

/// Paths of one build, all absolute.
pub(super) struct Workshop<'a> {
    pub build: &'a Build,
    pub verilator: &'a Verilator,
    pub compiler: &'a Path,
    pub sources: &'a [PathBuf],
    pub includes: &'a [PathBuf],
    pub folder: &'a Path,
}

impl Workshop<'_> {
    /// Runs Verilator and the compiler in the folder, which makes `model.so`. `runtime` gives the folder of the
    /// runtime's objects for a Verilator root.
    pub fn make(
        &self,
        version: &Version,
        runtime: impl FnOnce(&Path) -> Result<PathBuf, BuildError>,
    ) -> Result<Record, BuildError> {
        let root = self.verilator.root()?;
        let hierarchy = self.read_hierarchy(version)?;
        let forceable = self.choose_forceable(&hierarchy)?;
        let mut internals = self.choose_internals(&hierarchy)?;
        internals.extend(forceable.iter().filter(|v| !internals.contains(v)).cloned().collect::<Vec<_>>());
        let generated = self.folder.join("out");
        let of_top = hierarchy.variables.iter().filter(|v| v.port.is_some() && v.scope == self.build.top);
        // A build that splits them itself drives the halves itself.
        let split_by_flag = self.build.flags.iter().any(|flag| flag == SPLIT_INOUTS);
        let has_inouts = of_top.clone().any(|v| v.port == Some(PortDirection::Inout)) && !split_by_flag;
        let (mut warnings, drivable) = self.verilate_with_inouts(&internals, &forceable, has_inouts)?;
        let mut tables = Tables::read(&generated)?;
        let odd = tables.unreachable(&generated)?;
        if !odd.is_empty() {
            let is_odd = |v: &&Variable| odd.contains(&(v.scope.clone(), v.name.clone()));
            let odd: HashSet<_> = internals.iter().filter(is_odd).map(|v| (&v.module, &v.name)).collect();
            let rest: Vec<Variable> =
                internals.iter().filter(|v| !odd.contains(&(&v.module, &v.name))).cloned().collect();
            std::fs::remove_dir_all(&generated)
                .map_err(|source| BuildError::Cache { path: generated.clone(), source })?;
            let forceable: Vec<Variable> = forceable.iter().filter(|v| rest.contains(v)).cloned().collect();
            warnings = self.verilate(&rest, &forceable, drivable)?;
            tables = Tables::read(&generated)?;
        }
        let header = read(&generated.join("Vdut.h"))?;
        let mut signals = ports(&header, &of_top.clone().collect::<Vec<_>>());
        let mut odd: Vec<String> =
            of_top.filter(|v| !signals.iter().any(|(port, _)| port.name == v.name)).map(|v| v.path.clone()).collect();
        let structures = Structures::read(&generated)?;
        for variable in std::mem::take(&mut internals) {
            let Some(member) = tables.members.get(&(variable.scope.clone(), variable.name.clone())) else {
                odd.push(variable.path);
                continue;
            };
            let Some(structure) = structures.of_member(member) else {
                signals.push((variable, member.clone()));
                continue;
            };
            for part in hierarchy.structures.get(&variable.path).into_iter().flatten() {
                if let Some(below) = structures.expression(structure, &part.steps) {
                    signals.push((part.variable.clone(), format!("{member}{below}")));
                }
            }
            odd.push(variable.path);
        }
        if drivable {
            // Only the two halves of an `inout` have such names: Verilator refuses a design that has them already.
            let is_half = |name: &str| {
                let of = name.strip_suffix("__out").or_else(|| name.strip_suffix("__en"));
                of.is_some_and(|of| signals.iter().any(|(v, _)| v.name == of && v.port == Some(PortDirection::Inout)))
            };
            let halves: Vec<bool> = signals.iter().map(|(v, _)| v.scope.is_empty() && is_half(&v.name)).collect();
            let mut halves = halves.into_iter();
            signals.retain(|_| !halves.next().unwrap_or(false));
        }
        let overrides = Overrides::new(&generated, &signals, &forceable, drivable)?;
        self.write_unity(&generated, &signals, &overrides)?;
        self.compile(&root, &generated, &runtime(&root)?)?;
        Ok(Record {
            top: self.build.top.clone(),
            signals: signals.into_iter().map(|(variable, _)| variable).collect(),
            odd,
            drivable_inouts: drivable || split_by_flag,
            constants: hierarchy.constants.iter().take(20_000).cloned().collect(),
            names: hierarchy.variables.iter().take(20_000).map(|v| v.path.clone()).collect(),
            trace: self.build.trace,
            coverage: self.build.coverage.any(),
            initial: self.build.initial,
            warnings,
            manifest: self.read_manifest(&generated, &root)?,
            library_hash: String::new(),
        })
    }

    fn verilator_command(&self, arguments: &[&str]) -> Result<std::process::Output, BuildError> {
        let mut command = Command::new(&self.verilator.path);
        command.current_dir(self.folder).args(arguments);
        command.args(self.build.verilator_arguments(self.sources, self.includes));
        // Verilator replaces `$name` in a path by the variable's value: here by a value that leaves the path unchanged.
        for path in self.sources.iter().chain(self.includes) {
            command.envs(variables_in(&path.to_string_lossy()));
        }
        tool::run(&mut command)
    }

    fn read_hierarchy(&self, version: &Version) -> Result<Hierarchy, BuildError> {
        if version.has_json() {
            let output = ["--json-only", "--json-only-output", "design.json", "--Mdir", "json"];
            self.check_output(&self.verilator_command(&output)?)?;
            return hierarchy::parse_json(&read(&self.folder.join("design.json"))?, &self.build.top);
        }
        // Optimised, the description would lack nets that are only another name of an expression.
        let output = self.verilator_command(&["--xml-only", "--xml-output", "design.xml", "--Mdir", "xml", "-O0"])?;
        self.check_output(&output)?;
        hierarchy::parse_xml(&read(&self.folder.join("design.xml"))?)
    }

    fn choose_internals(&self, hierarchy: &Hierarchy) -> Result<Vec<Variable>, BuildError> {
        let inner = || hierarchy.variables.iter().filter(|v| v.port.is_none() || v.path.contains('.'));
        for pattern in &self.build.internals {
            // `*` may match nothing.
            if pattern != "*" && !inner().any(|v| hierarchy::matches(pattern, &v.path)) {
                return Err(BuildError::NoSuchInternal {
                    name: pattern.clone(),
                    top: self.build.top.clone(),
                    nearest: nearest(pattern, inner().map(|v| v.path.as_str())),
                });
            }
        }
        // `*` means what modules declare: Verilator removes loop variables and the like.
        let wanted = |v: &&Variable| {
            self.build.internals.iter().any(|p| hierarchy::matches(p, &v.path) && !(p == "*" && v.nested))
        };
        Ok(inner().filter(wanted).cloned().collect())
    }

    /// The variables to make forceable: those that a pattern names, of vectors.
    fn choose_forceable(&self, hierarchy: &Hierarchy) -> Result<Vec<Variable>, BuildError> {
        let refused = |name: &str, reason| BuildError::BadOption { what: "forceable", value: name.to_owned(), reason };
        let mut found: Vec<Variable> = Vec::new();
        for pattern in &self.build.forceable {
            let is_port = |v: &&Variable| v.port.is_some() && !v.path.contains('.');
            let matching = || hierarchy.variables.iter().filter(|v| hierarchy::matches(pattern, &v.path));
            let is_vector =
                |v: &&Variable| matches!(v.kind, hierarchy::Kind::Bits { .. }) && v.dimensions.is_empty() && !v.nested;
            let chosen: Vec<Variable> = matching().filter(|v| !is_port(v) && is_vector(v)).cloned().collect();
            if !chosen.is_empty() || pattern == "*" {
                found.extend(chosen);
            } else if matching().any(|v| is_port(&v)) {
                return Err(refused(pattern, "a port of the top: force the signal inside that drives it"));
            } else if matching().next().is_some() {
                return Err(refused(pattern, "no vector: arrays, `real` and variables of functions cannot be forced"));
            } else {
                return Err(BuildError::NoSuchInternal {
                    name: pattern.clone(),
                    top: self.build.top.clone(),
                    nearest: nearest(pattern, hierarchy.variables.iter().map(|v| v.path.as_str())),
                });
            }
        }
        Ok(found)
    }

    /// Runs Verilator; with the `inout`s of the top split into what comes in and what goes out, if this version can.
    /// The second value tells whether it did.
    fn verilate_with_inouts(
        &self,
        internals: &[Variable],
        forceable: &[Variable],
        has_inouts: bool,
    ) -> Result<(Vec<diagnostic::Diagnostic>, bool), BuildError> {
        match self.verilate(internals, forceable, has_inouts) {
            Err(BuildError::Verilog { diagnostics })
                if diagnostics.iter().any(|d| d.message.contains(&format!("Invalid option: {SPLIT_INOUTS}"))) =>
            {
                Ok((self.verilate(internals, forceable, false)?, false))
            }
            other => other.map(|warnings| (warnings, has_inouts)),
        }
    }

    fn verilate(
        &self,
        internals: &[Variable],
        forceable: &[Variable],
        split_inouts: bool,
    ) -> Result<Vec<diagnostic::Diagnostic>, BuildError> {
        let mut config = String::from("`verilator_config\n");
        for (attribute, variables) in [("public_flat_rw", internals), ("forceable", forceable)] {
            let mut wanted: Vec<_> = variables.iter().map(|v| (v.module.as_str(), v.name.as_str())).collect();
            wanted.sort();
            wanted.dedup();
            for (module, variable) in wanted {
                // Writing to a String cannot fail.
                let _ = writeln!(config, "{attribute} -module \"{module}\" -var \"{variable}\"");
            }
        }
        write(&self.folder.join("public.vlt"), &config)?;
        let unique = match self.build.initial {
            Initial::Zero => "0",
            Initial::Random => "unique",
        };
        let mut arguments = vec!["--cc", "--prefix", "Vdut", "--Mdir", "out", "-O3", "--x-initial", unique];
        arguments.extend(["--x-assign", if self.build.initial == Initial::Random { "unique" } else { "0" }]);
        match self.build.trace {
            Trace::None => {}
            Trace::Vcd => arguments.extend(["--trace", "--trace-structs"]),
            Trace::Fst => arguments.extend(["--trace-fst", "--trace-structs"]),
        }
        let coverage = self.build.coverage;
        let kinds = [
            (coverage.line, "--coverage-line"),
            (coverage.toggle, "--coverage-toggle"),
            (coverage.user, "--coverage-user"),
        ];
        arguments.extend(kinds.iter().filter(|(on, _)| *on).map(|(_, flag)| *flag));
        if split_inouts {
            arguments.push(SPLIT_INOUTS);
        }
        if !forceable.is_empty() {
            // This optimiser of older versions puts the expression assigned in the place of the forced net.
            arguments.push("-fno-dfg");
        }
        arguments.push("public.vlt");
        let output = self.verilator_command(&arguments)?;
        self.check_output(&output)
    }

    /// The warnings of a run that succeeded; the error of one that failed.
    fn check_output(&self, output: &std::process::Output) -> Result<Vec<diagnostic::Diagnostic>, BuildError> {
        let text = String::from_utf8_lossy(&output.stderr);
        let mut diagnostics = diagnostic::parse(&text);
        diagnostics.iter_mut().for_each(|told| self.complete_name(told));
        if output.status.success() {
            return Ok(diagnostics);
        }
        if diagnostics.iter().any(|d| d.message.contains("--top-module") && d.message.contains("not found")) {
            let modules = modules_in(self.sources);
            let mut near = nearest(&self.build.top, modules.iter().map(String::as_str));
            if near.is_empty() {
                near = modules.into_iter().take(5).collect();
            }
            return Err(BuildError::NoSuchTop { top: self.build.top.clone(), nearest: near });
        }
        if diagnostics.is_empty() {
            let reason = format!("{} ({})", text.trim(), output.status);
            return Err(BuildError::Unexpected { what: "failure", reason });
        }
        Err(BuildError::Verilog { diagnostics })
    }

    /// Verilator names files up to their first blank: completes the name to that of the one source that begins so and
    /// has the quoted line. Verilator quotes the line after the preprocessor: a line with a macro is not found, and
    /// the name stays as it is.
    fn complete_name(&self, told: &mut diagnostic::Diagnostic) {
        let number = format!("{} | ", told.line);
        let Some(quoted) = told.context.iter().find_map(|line| line.trim_start().strip_prefix(&number)) else { return };
        let is_meant = |source: &&PathBuf| {
            let goes_on = source.to_str().and_then(|s| s.strip_prefix(&told.file)).is_some_and(|s| s.starts_with(' '));
            let line = |text: String| text.lines().nth(told.line.saturating_sub(1) as usize).map(str::to_owned);
            goes_on && std::fs::read_to_string(source).ok().and_then(line).is_some_and(|l| l.trim_end() == quoted)
        };
        let mut meant = self.sources.iter().filter(is_meant);
        if let (Some(source), None) = (meant.next(), meant.next()) {
            told.file = source.display().to_string();
        }
    }

    /// Writes the table of signals and the unity file.
    fn write_unity(
        &self,
        generated: &Path,
        signals: &[(Variable, String)],
        overrides: &Overrides,
    ) -> Result<(), BuildError> {
        let mut table = String::from("#define HV_SIGNALS(HV_SIGNAL)");
        for (_, member) in signals {
            let _ = write!(table, " \\\n    HV_SIGNAL({member})");
        }
        for (name, places) in [("HV_FORCED", &overrides.forced), ("HV_INOUTS", &overrides.inouts)] {
            let _ = write!(table, "\n#define {name}(HV_SIGNAL)");
            for at in places {
                let _ = write!(table, " \\\n    HV_SIGNAL({at}, {})", signals[*at].1);
            }
        }
        let any = u8::from(!overrides.forced.is_empty() || !overrides.inouts.is_empty());
        let _ = write!(table, "\n#define HV_OVERRIDES {any}");
        let mut evaluation = read(&generated.join("Vdut.cpp"))?;
        if !has_classes(generated)? {
            evaluation = evaluation.replace("    vlSymsp->__Vm_deleter.deleteAll();\n", "");
        }
        let direct = u8::from(is_plain_eval(&evaluation));
        let mut unity = format!(
            "#define HV_INTERFACE {INTERFACE}\n#define HV_MODEL Vdut\n#define HV_DIRECT_EVAL {direct}\n{table}\n\n\
             #include \"Vdut__Syms.h\"\n"
        );
        let mut files: Vec<String> = std::fs::read_dir(generated)
            .map_err(|source| BuildError::Cache { path: generated.to_owned(), source })?
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|name| name.ends_with(".cpp"))
            .collect();
        files.sort();
        for file in files {
            let _ = writeln!(unity, "#include \"{file}\"");
        }
        unity.push_str("#include \"shim.cpp\"\n");
        write(&self.folder.join("shim.cpp"), SHIM)?;
        write(&self.folder.join("unity.cpp"), &unity)
    }

    fn compile(&self, root: &Path, generated: &Path, runtime: &Path) -> Result<(), BuildError> {
        let mut command = Command::new(self.compiler);
        command.current_dir(self.folder).args(CXX_FLAGS);
        command.args(trace_flags(self.build.trace));
        command.arg(format!("-DVM_COVERAGE={}", u8::from(self.build.coverage.any())));
        command.arg(format!("-I{}", generated.display())).args(include_flags(root));
        command.arg("-include").arg(runtime.join(PREFIX));
        command.args(["-shared", "-Wl,-Bsymbolic", "-o", "model.so", "unity.cpp"]);
        command.args(runtime_objects(runtime, self.build.trace, self.build.coverage.any())).arg("-lpthread");
        if self.build.trace == Trace::Fst {
            command.arg("-lz");
            if needs_lz4(root) {
                command.arg("-llz4");
            }
        }
        check_compiler(&tool::run(&mut command)?, self.build.trace)
    }

    /// All files that Verilator read, except the sources, its own program and the file written for it.
    fn read_manifest(&self, generated: &Path, root: &Path) -> Result<Vec<(PathBuf, String)>, BuildError> {
        let text = read(&generated.join("Vdut__verFiles.dat"))?;
        let names = files_read(&text);
        // Verilator lists the part of a name before its first blank, too, as if it were a file.
        let is_cut = |name: &str| {
            let longer = |other: &&str| other.strip_prefix(name).is_some_and(|rest| rest.starts_with([' ', '\t']));
            names.iter().any(longer) && !self.folder.join(name).is_file()
        };
        let own = |name: &str| name.ends_with("verilator_bin") || name == "public.vlt";
        let mut manifest = Vec::new();
        for name in names.iter().filter(|name| !own(name) && !is_cut(name)) {
            let path = super::absolute(&self.folder.join(name))?;
            // Its own library goes with the program, whose change makes another key.
            if !self.sources.contains(&path) && !path.starts_with(root) {
                let hash = super::model_cache::hash_file(&path)?;
                manifest.push((path, hash));
            }
        }
        manifest.sort();
        manifest.dedup();
        Ok(manifest)
    }
}

/// The names of the files that were read, in lines like `S  99 10338340 1795274662 ... "a b/t.v"`; newer versions put a
/// hash in quotes before the name. Quotes in a name are not escaped. (In the list for `make`, names with blanks cannot
/// be told apart.)
fn files_read(text: &str) -> Vec<&str> {
    let quoted = |line: &'_ str| -> Option<(usize, usize)> {
        let (mut from, to) = (line.find('"')? + 1, line.rfind('"')?);
        let is_hash = |text: &str| {
            text == "unhashed"
                || text.len() == 40 && text.chars().all(|c| c.is_ascii_alphanumeric() || "+/=_-@".contains(c))
        };
        let first = line.get(from..)?.split_once("\" \"");
        if let Some((hash, _)) = first.filter(|(hash, _)| is_hash(hash)) {
            from += hash.len() + 3;
        }
        Some((from, to))
    };
    let lines = text.lines().filter(|line| line.starts_with("S "));
    lines.filter_map(|line| quoted(line).and_then(|(from, to)| line.get(from..to))).collect()
}

/// The generated tables of public variables.
struct Tables {
    /// The expression of each variable's member, such as `TOP__g.lane__DOT__i`, by scope and name.
    members: HashMap<(String, String), String>,
}

impl Tables {
    fn read(generated: &Path) -> Result<Tables, BuildError> {
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

    /// What is listed, but is no number in the generated classes, as (scope, name). Older versions list whatever was
    /// asked for: a `genvar` or an interface's reference, which no class has, so that the C++ does not compile; and a
    /// queue, as if it were one byte.
    fn unreachable(&self, generated: &Path) -> Result<HashSet<(String, String)>, BuildError> {
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

/// The structures of the generated code, of unpacked ones of the Verilog.
struct Structures {
    /// The class of each instance.
    classes: HashMap<String, String>,
    /// The types of the members of each class and structure.
    members: HashMap<String, HashMap<String, String>>,
}

impl Structures {
    fn read(generated: &Path) -> Result<Structures, BuildError> {
        let symbols = read(&generated.join("Vdut__Syms.h"))?;
        let classes = classes_in(&symbols).into_iter().map(|(instance, class)| (instance.to_owned(), class.to_owned()));
        let mut members = HashMap::new();
        for path in files_in(generated)?.iter().filter(|path| path.extension().is_some_and(|e| e == "h")) {
            add_members(&read(path)?, &mut members);
        }
        Ok(Structures { classes: classes.collect(), members })
    }

    /// The type of a member, if it is a structure or an array of structures.
    fn of_member(&self, expression: &str) -> Option<&str> {
        let (instance, member) = expression.split_once('.')?;
        let found = self.members.get(self.classes.get(instance)?)?.get(member)?;
        self.is_structure(found).then_some(found)
    }

    /// Whether a type is a structure, or an array of structures.
    fn is_structure(&self, kind: &str) -> bool {
        let mut element = kind;
        while let Some((inner, _)) = element_of(element) {
            element = inner;
        }
        element.contains("__struct") && self.members.contains_key(element)
    }

    /// What leads in C++ from a value of a type to a value in it; none if the types do not go that way, or it is a
    /// structure itself.
    fn expression<'a>(&'a self, mut of: &'a str, steps: &[Step]) -> Option<String> {
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

/// The type of the elements of a `VlUnpacked<CData, 3>`, and their number.
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

/// The class of each instance: `Vdut_child   TOP__child;`.
fn classes_in(symbols: &str) -> HashMap<&str, &str> {
    let lines = symbols.lines().filter_map(|line| line.trim().strip_suffix(';')?.split_once(' '));
    lines.map(|(class, instance)| (instance.trim(), class)).collect()
}

/// Signals whose value is not the design's alone, by their places in the table.
struct Overrides {
    /// Those that can be forced.
    forced: Vec<usize>,
    /// The `inout`s of the top that the bench may drive.
    inouts: Vec<usize>,
}

impl Overrides {
    fn new(
        generated: &Path,
        signals: &[(Variable, String)],
        forceable: &[Variable],
        drivable: bool,
    ) -> Result<Overrides, BuildError> {
        let symbols = read(&generated.join("Vdut__Syms.h"))?;
        let classes = classes_in(&symbols);
        let mut forced = Vec::new();
        for (at, (variable, expression)) in signals.iter().enumerate() {
            if !forceable.contains(variable) {
                continue;
            }
            let Some((instance, member)) = expression.split_once('.') else { continue };
            let Some(class) = classes.get(instance) else { continue };
            if numbers_of(&read(&generated.join(format!("{class}.h")))?).contains(&format!("{member}__VforceEn")) {
                forced.push(at);
            }
        }
        let is_inout = |v: &Variable| v.port == Some(PortDirection::Inout) && !v.path.contains('.');
        let inouts =
            signals.iter().enumerate().filter(|(_, (v, _))| drivable && is_inout(v) && v.dimensions.is_empty());
        Ok(Overrides { forced, inouts: inouts.map(|(at, _)| at).collect() })
    }
}

/// Whether a generated class holds objects of the Verilog's classes.
fn has_classes(generated: &Path) -> Result<bool, BuildError> {
    for path in files_in(generated)? {
        if path.extension().is_some_and(|e| e == "h") && read(&path)?.contains("VlClass") {
            return Ok(true);
        }
    }
    Ok(false)
}

/// `Vdut__Syms.cpp`, or the several files of newer versions.
fn symbol_files(generated: &Path) -> Result<Vec<PathBuf>, BuildError> {
    let is_one = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.starts_with("Vdut__Syms") && name.ends_with(".cpp")
    };
    Ok(files_in(generated)?.into_iter().filter(is_one).collect())
}

fn files_in(folder: &Path) -> Result<Vec<PathBuf>, BuildError> {
    let entries = std::fs::read_dir(folder).map_err(|source| BuildError::Cache { path: folder.to_owned(), source })?;
    Ok(entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
}

/// The scope's variable and its name in a line like `__Vscope_t__lane.configure(this, name(), "t.lane", ...` or, in
/// newer versions, `__Vscopep_t__lane = new VerilatedScope{this, "t.lane", ...`.
fn configured(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    let (scope, rest) =
        line.split_once(".configure(this, name(), \"").or_else(|| line.split_once(" = new VerilatedScope{this, \""))?;
    Some((scope, rest.split_once('"')?.0))
}

/// Scope, name and member in a line like `__Vscope_t.varInsert(__Vfinal,"i", &(TOP__t.i), ...` or, in newer versions,
/// `__Vscopep_t->varInsert("i", &(TOP__t.i), ...`. What the tables cannot hold is there as a comment.
fn inserted(line: &str) -> Option<(&str, &str, &str)> {
    let line = line.trim();
    let line = line.strip_prefix("//UNSUP ").unwrap_or(line);
    let heads = [".varInsert(__Vfinal,\"", "->forceableVarInsert(\"", "->varInsert(\""];
    let (scope, rest) = heads.iter().find_map(|head| line.split_once(head))?;
    let (name, rest) = rest.split_once("\", &(")?;
    Some((scope, name, rest.split_once(')')?.0))
}

/// The members of a generated class that are vectors, `real`, strings, structures, or arrays of these.
fn numbers_of(header: &str) -> HashSet<String> {
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

/// Whether `eval_step`, after the first call, only evaluates the root and ends threads that a model without threads
/// does not have. (Newer versions also delete objects of classes there; the caller takes that line out for a model that
/// has none.)
fn is_plain_eval(text: &str) -> bool {
    const OLDER: [&str; 12] = [
        "Vdut___024root___eval_debug_assertions(&(vlSymsp->TOP));",
        "if (VL_UNLIKELY(!vlSymsp->__Vm_didInit)) {",
        "vlSymsp->__Vm_didInit = true;",
        "Vdut___024root___eval_static(&(vlSymsp->TOP));",
        "Vdut___024root___eval_initial(&(vlSymsp->TOP));",
        "Vdut___024root___eval_settle(&(vlSymsp->TOP));",
        "}",
        "Verilated::mtaskId(0);",
        "Vdut___024root___eval(&(vlSymsp->TOP));",
        "Verilated::endOfThreadMTask(vlSymsp->__Vm_evalMsgQp);",
        "Verilated::endOfEval(vlSymsp->__Vm_evalMsgQp);",
        "}",
    ];
    const NEWER: [&str; 10] = [
        "Vdut___024root___eval_debug_assertions(&(vlSymsp->TOP));",
        "if (VL_UNLIKELY(!vlSymsp->__Vm_didInit)) {",
        "Vdut___024root___eval_static(&(vlSymsp->TOP));",
        "Vdut___024root___eval_initial(&(vlSymsp->TOP));",
        "Vdut___024root___eval_settle(&(vlSymsp->TOP));",
        "vlSymsp->__Vm_didInit = true;",
        "}",
        "Vdut___024root___eval(&(vlSymsp->TOP));",
        "Verilated::endOfEval(vlSymsp->__Vm_evalMsgQp);",
        "}",
    ];
    let Some((_, body)) = text.split_once("::eval_step() {\n") else { return false };
    let plain = |l: &&str| !l.starts_with("VL_DEBUG_IF") && !l.starts_with("//") && !l.starts_with('#');
    let body = body.lines().map(str::trim).filter(plain).take_while(|line| !line.is_empty());
    let statements: Vec<&str> = body.collect();
    statements == OLDER || statements == NEWER
}

/// The ports of the generated class, as variables and the expressions of their members: in the order of the source,
/// then those that the description does not have.
fn ports(header: &str, described: &[&Variable]) -> Vec<(Variable, String)> {
    let place = |name: &str| described.iter().position(|v| v.name == name);
    let mut found: Vec<(usize, Variable, String)> = Vec::new();
    for line in header.lines() {
        let Some((member, declared)) = parse_port(line) else { continue };
        let name = demangle(member);
        let expression = format!("TOP.{member}");
        match (place(&name), declared) {
            (Some(at), _) => found.push((at, described[at].clone(), expression)),
            (None, Some((port, width))) => {
                let variable = Variable {
                    path: name.clone(),
                    scope: String::new(),
                    name,
                    module: String::new(),
                    kind: hierarchy::Kind::Bits { width },
                    signed: false,
                    items: Vec::new(),
                    fields: Vec::new(),
                    port: Some(port),
                    dimensions: Vec::new(),
                    nested: false,
                };
                found.push((usize::MAX, variable, expression));
            }
            (None, None) => {}
        }
    }
    found.sort_by_key(|(at, ..)| *at);
    found.into_iter().map(|(_, variable, expression)| (variable, expression)).collect()
}

/// The member and, where the line tells them, direction and width: `VL_IN8(&name,7,0);`, `VL_OUTW(&name,69,0,3);`,
/// `VL_IN8((&name)[4],7,0);`, `double &name;`, `VlUnpacked<CData/*3:0*/, 2> &name;`.
fn parse_port(line: &str) -> Option<(&str, Option<(PortDirection, u32)>)> {
    let line = line.trim();
    let Some(rest) = line.strip_prefix("VL_") else {
        let (kind, member) = line.strip_suffix(';')?.rsplit_once('&')?;
        let is_port = kind.starts_with("VlUnpacked<") || kind.trim() == "double" || kind.trim() == "std::string";
        return is_port.then_some((member, None));
    };
    let (kind, arguments) = rest.split_once('(')?;
    let direction = match kind.trim_end_matches(|c: char| c.is_ascii_digit() || c == 'W') {
        "IN" => PortDirection::Input,
        "OUT" => PortDirection::Output,
        "INOUT" => PortDirection::Inout,
        _ => return None,
    };
    let arguments = arguments.strip_suffix(");")?;
    let mut fields = arguments.split(',');
    let name = fields.next()?;
    let member = name.trim_start_matches(['(', '&']).split([')', '[']).next()?;
    let (msb, lsb): (i64, i64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some((member, Some((direction, u32::try_from(msb - lsb + 1).ok()?))))
}

/// `video__024data` is `video$data`: Verilator writes characters that C++ does not allow as `__0` and two hexadecimal
/// digits.
fn demangle(member: &str) -> String {
    let mut name = String::new();
    let mut rest = member;
    while let Some(at) = rest.find("__0") {
        let code = rest.get(at + 3..at + 5).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match code {
            Some(code) if code.is_ascii_graphic() => {
                name.push_str(&rest[..at]);
                name.push(char::from(code));
                rest = &rest[at + 5..];
            }
            _ => {
                name.push_str(&rest[..at + 3]);
                rest = &rest[at + 3..];
            }
        }
    }
    name + rest
}

/// `$name`, `${name}` and `$(name)` in a path: the names, and how they are written.
fn variables_in(path: &str) -> Vec<(&str, &str)> {
    let variable = |(at, _): (usize, &str)| {
        let rest = &path[at + 1..];
        let bracket = usize::from(rest.starts_with(['{', '(']));
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let length = rest[bracket..].find(|c| !is_name(c)).unwrap_or(rest.len() - bracket);
        let name = rest.get(bracket..bracket + length).filter(|name| !name.is_empty())?;
        Some((name, path.get(at..at + 1 + length + 2 * bracket)?))
    };
    path.match_indices('$').filter_map(variable).collect()
}

fn read(path: &Path) -> Result<String, BuildError> {
    std::fs::read_to_string(path).map_err(|source| BuildError::Cache { path: path.to_owned(), source })
}

fn write(path: &Path, text: &str) -> Result<(), BuildError> {
    std::fs::write(path, text).map_err(|source| BuildError::Cache { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_read_from_the_header() {
        assert_eq!(parse_port("    VL_OUTW(&wide,69,0,3);"), Some(("wide", Some((PortDirection::Output, 70)))));
        assert_eq!(parse_port("    VL_INOUT8(&io__024x,3,0);"), Some(("io__024x", Some((PortDirection::Inout, 4)))));
        assert_eq!(parse_port("VL_IN16((&taps)[4],8,0);"), Some(("taps", Some((PortDirection::Input, 9)))));
        assert_eq!(parse_port("    VlUnpacked<VlUnpacked<CData/*3:0*/, 3>, 2> &grid;"), Some(("grid", None)));
        assert_eq!(parse_port("    double &gain;"), Some(("gain", None)));
        assert!(parse_port("    VL_UNCOPYABLE(Vdut);  ///< Copying not allowed").is_none());
        assert!(parse_port("    Vdut_beats* const& __PVT__link;").is_none());
    }

    #[test]
    fn evaluations_of_known_text_are_plain() {
        let newer = "void Vdut::eval_step() {\n    VL_DEBUG_IF(x);\n#ifdef VL_DEBUG\n    // Debug assertions\n    \
                     Vdut___024root___eval_debug_assertions(&(vlSymsp->TOP));\n#endif  // VL_DEBUG\n    \
                     if (VL_UNLIKELY(!vlSymsp->__Vm_didInit)) {\n\
                     Vdut___024root___eval_static(&(vlSymsp->TOP));\n\
                     Vdut___024root___eval_initial(&(vlSymsp->TOP));\n Vdut___024root___eval_settle(&(vlSymsp->TOP));\n\
                     vlSymsp->__Vm_didInit = true;\n    }\n    Vdut___024root___eval(&(vlSymsp->TOP));\n    // Clean\n\
                     Verilated::endOfEval(vlSymsp->__Vm_evalMsgQp);\n}\n\nvoid";
        assert!(is_plain_eval(newer));
        assert!(!is_plain_eval(&newer.replace("// Clean", "vlSymsp->__Vm_threadPoolp->wait();")));
        assert!(!is_plain_eval("void Vdut::other() {\n}\n"));
    }

    #[test]
    fn files_read_have_blanks_and_quotes() {
        let text = "# DESCRIPTION: S\nC \"--cc a b.v\"\nS  99  1  2  3  2  3 \"/p/a b.v\"\n\
                    S 0 0 0 0 1 0 \"/q\"u/i.vh\"\nT  5  1  2  3  2  3 \"out/V.cpp\"\n";
        assert_eq!(files_read(text), ["/p/a b.v", "/q\"u/i.vh"]);
        let newer = "S  9  1  2  3  2  3 \"unhashed\" \"/p/bin\"\n\
                     S  9  1  2  3  2  3 \"czBlEFkcTVulpaEel4J0W5bCKNEsN5Xd0FA2B2DC\" \"/p/a\" \"b.v\"\n";
        assert_eq!(files_read(newer), ["/p/bin", "/p/a\" \"b.v"]);
        let variables = [("b", "$b"), ("c", "${c}"), ("e", "$(e)"), ("g_1", "$g_1"), ("h", "$h"), ("j", "$j")];
        assert_eq!(variables_in("/a $b/${c}d/$(e)/$/f$g_1$h-i$j"), variables);
        assert_eq!(variables_in("/a/${b"), []);
    }

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

    #[test]
    fn mangled_names_come_back() {
        assert_eq!(demangle("video__024data"), "video$data");
        assert_eq!(demangle("plain_name__0"), "plain_name__0");
        assert_eq!(demangle("a__05Fb"), "a_b");
    }
}
