//! From Verilator's C++ to one shared library: the table of ports, one file that includes all others (a unity build),
//! the runtime's objects.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::diagnostic;
use super::hierarchy::{self, Hierarchy, Variable};
use super::tool::{self, Verilator};
use super::{Build, Initial, PortRecord, Record, Trace, modules_in};
use crate::error::{BuildError, nearest};

pub(super) const SHIM: &str = include_str!("shim.cpp");
pub(super) const HOOKS: &str = include_str!("runtime_hooks.h");
/// The header that every model includes first, precompiled beside the runtime's objects.
const PREFIX: &str = "prefix.h";
/// Incremented whenever the shim's functions change.
pub(crate) const INTERFACE: u32 = 1;

/// The flags of every C++ compilation. Symbols are hidden and not unique, so that several models in one process do not
/// share the runtime's globals.
pub(super) const CXX_FLAGS: [&str; 10] = [
    "-std=c++17",
    "-O3",
    "-fPIC",
    "-w",
    "-fno-gnu-unique",
    "-fvisibility=hidden",
    "-fvisibility-inlines-hidden",
    "-DVL_TIME_CONTEXT",
    "-DVERILATOR=1",
    "-DVM_SC=0",
];

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
    pub fn make(&self, runtime: impl FnOnce(&Path) -> Result<PathBuf, BuildError>) -> Result<Record, BuildError> {
        self.verilator.check_version()?;
        let root = self.verilator.root()?;
        let hierarchy = self.read_hierarchy()?;
        let internals = self.choose_internals(&hierarchy)?;
        let generated = self.folder.join("out");
        let mut warnings = self.verilate(&internals)?;
        let odd = unreachable(&generated)?;
        if !odd.is_empty() {
            let is_odd = |v: &&Variable| odd.contains(&(v.scope.clone(), v.name.clone()));
            let odd: HashSet<_> = internals.iter().filter(is_odd).map(|v| (&v.module, &v.name)).collect();
            let rest: Vec<Variable> =
                internals.iter().filter(|v| !odd.contains(&(&v.module, &v.name))).cloned().collect();
            std::fs::remove_dir_all(&generated)
                .map_err(|source| BuildError::Cache { path: generated.clone(), source })?;
            warnings = self.verilate(&rest)?;
        }
        let header = read(&generated.join("Vdut.h"))?;
        let ports = self.write_unity(&generated, &header)?;
        self.compile(&root, &generated, &runtime(&root)?)?;
        let named = |name: &str| hierarchy.variables.iter().find(|v| v.port && v.path == name);
        let of_top = hierarchy.variables.iter().filter(|v| v.port && v.scope == self.build.top);
        let odd_ports = of_top.map(|v| v.path.clone()).filter(|name| !ports.contains(name)).collect();
        Ok(Record {
            top: self.build.top.clone(),
            ports: ports
                .into_iter()
                .map(|name| {
                    let (signed, range, items) =
                        named(&name).map_or((false, None, Vec::new()), |v| (v.signed, v.range, v.items.clone()));
                    PortRecord { name, signed, range, items }
                })
                .collect(),
            internals,
            constants: hierarchy.constants.iter().take(20_000).cloned().collect(),
            odd_ports,
            names: hierarchy.variables.iter().take(20_000).map(|v| v.path.clone()).collect(),
            trace: self.build.trace,
            coverage: self.build.coverage.any(),
            initial: self.build.initial,
            warnings,
            manifest: self.read_manifest(&generated)?,
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

    fn read_hierarchy(&self) -> Result<Hierarchy, BuildError> {
        let output = self.verilator_command(&["--xml-only", "--xml-output", "design.xml", "--Mdir", "xml"])?;
        self.check_output(&output)?;
        hierarchy::parse(&read(&self.folder.join("design.xml"))?)
    }

    fn choose_internals(&self, hierarchy: &Hierarchy) -> Result<Vec<Variable>, BuildError> {
        let inner = || hierarchy.variables.iter().filter(|v| !v.port || v.path.contains('.'));
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

    fn verilate(&self, internals: &[Variable]) -> Result<Vec<diagnostic::Diagnostic>, BuildError> {
        let mut wanted: Vec<(&str, &str)> = internals.iter().map(|v| (v.module.as_str(), v.name.as_str())).collect();
        wanted.sort();
        wanted.dedup();
        let mut config = String::from("`verilator_config\n");
        for (module, variable) in wanted {
            // Writing to a String cannot fail.
            let _ = writeln!(config, "public_flat_rw -module \"{module}\" -var \"{variable}\"");
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

    /// Writes the table of ports and the unity file; gives the ports' names as written in the Verilog.
    fn write_unity(&self, generated: &Path, header: &str) -> Result<Vec<String>, BuildError> {
        let mut names = Vec::new();
        let mut table = String::from("#define HV_PORTS(HV_PORT)");
        for port in header.lines().filter_map(parse_port) {
            let name = demangle(port.member);
            let _ = write!(table, " \\\n    HV_PORT(\"{name}\", {}, {}, {})", port.member, port.width, port.direction);
            names.push(name);
        }
        let direct = u8::from(is_plain_eval(&read(&generated.join("Vdut.cpp"))?));
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
        write(&self.folder.join("unity.cpp"), &unity)?;
        Ok(names)
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
        }
        check_compiler(&tool::run(&mut command)?, self.build.trace)
    }

    /// All files that Verilator read, except the sources, its own program and the file written for it.
    fn read_manifest(&self, generated: &Path) -> Result<Vec<(PathBuf, String)>, BuildError> {
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
            if !self.sources.contains(&path) {
                let hash = super::model_cache::hash_file(&path)?;
                manifest.push((path, hash));
            }
        }
        manifest.sort();
        manifest.dedup();
        Ok(manifest)
    }
}

/// The names of the files that were read, in lines like `S  99 10338340 1795274662 ... "a b/t.v"`. Quotes in a name are
/// not escaped. (In the list for `make`, names with blanks cannot be told apart.)
fn files_read(text: &str) -> Vec<&str> {
    let quoted = |line: &'_ str| -> Option<(usize, usize)> { Some((line.find('"')? + 1, line.rfind('"')?)) };
    let lines = text.lines().filter(|line| line.starts_with("S "));
    lines.filter_map(|line| quoted(line).and_then(|(from, to)| line.get(from..to))).collect()
}

/// Compiles Verilator's runtime for one kind of model.
pub(super) fn compile_runtime(
    compiler: &Path,
    root: &Path,
    trace: Trace,
    coverage: bool,
    folder: &Path,
) -> Result<(), BuildError> {
    let command = || {
        let mut command = Command::new(compiler);
        command.current_dir(folder).args(CXX_FLAGS).args(trace_flags(trace));
        command.arg(format!("-DVM_COVERAGE={}", u8::from(coverage))).args(include_flags(root));
        command
    };
    write(&folder.join("runtime_hooks.h"), HOOKS)?;
    for file in runtime_files(trace, coverage) {
        let mut command = command();
        command.args(["-include", "runtime_hooks.h", "-c", "-o", &format!("{file}.o")]);
        command.arg(root.join("include").join(format!("{file}.cpp")));
        check_compiler(&tool::run(&mut command)?, trace)?;
    }
    // The headers that every model includes, precompiled: half of a small model's compile time. A compiler that does
    // not take the precompiled header reads the text.
    let mut prefix = format!("{HOOKS}\n");
    let mut headers = vec![
        "cstdarg",
        "cstdio",
        "cstring",
        "exception",
        "stdexcept",
        "string",
        "type_traits",
        "vector",
        "verilated.h",
    ];
    headers.extend(["verilated_dpi.h", "verilated_syms.h", "verilated_sym_props.h"]);
    match trace {
        Trace::None => {}
        Trace::Vcd => headers.push("verilated_vcd_c.h"),
        Trace::Fst => headers.push("verilated_fst_c.h"),
    }
    for header in headers {
        let _ = writeln!(prefix, "#include <{header}>");
    }
    write(&folder.join(PREFIX), &prefix)?;
    let mut command = command();
    command.args(["-x", "c++-header", "-o", &format!("{PREFIX}.gch"), PREFIX]);
    check_compiler(&tool::run(&mut command)?, trace)
}

/// The runtime's objects in their folder.
pub(super) fn runtime_objects(folder: &Path, trace: Trace, coverage: bool) -> Vec<PathBuf> {
    runtime_files(trace, coverage).iter().map(|file| folder.join(format!("{file}.o"))).collect()
}

/// The runtime's files a kind of model needs.
fn runtime_files(trace: Trace, coverage: bool) -> Vec<&'static str> {
    let mut files = vec!["verilated", "verilated_threads"];
    match trace {
        Trace::None => {}
        Trace::Vcd => files.push("verilated_vcd_c"),
        Trace::Fst => files.push("verilated_fst_c"),
    }
    if coverage {
        files.push("verilated_cov");
    }
    files
}

fn trace_flags(trace: Trace) -> [&'static str; 3] {
    match trace {
        Trace::None => ["-DVM_TRACE=0", "-DVM_TRACE_VCD=0", "-DVM_TRACE_FST=0"],
        Trace::Vcd => ["-DVM_TRACE=1", "-DVM_TRACE_VCD=1", "-DVM_TRACE_FST=0"],
        Trace::Fst => ["-DVM_TRACE=1", "-DVM_TRACE_VCD=0", "-DVM_TRACE_FST=1"],
    }
}

fn include_flags(root: &Path) -> [String; 2] {
    let include = root.join("include");
    [format!("-I{}", include.display()), format!("-I{}", include.join("vltstd").display())]
}

fn check_compiler(output: &std::process::Output, trace: Trace) -> Result<(), BuildError> {
    if output.status.success() {
        return Ok(());
    }
    let text = String::from_utf8_lossy(&output.stderr);
    if trace == Trace::Fst && text.contains("zlib.h") {
        return Err(BuildError::ToolMissing {
            tool: "zlib.h".into(),
            hint: "FST waves need it (Debian: apt-get install zlib1g-dev); VCD waves do not".into(),
        });
    }
    let lines: Vec<&str> = text.lines().filter(|l| l.contains("error") || l.contains("undefined")).take(20).collect();
    let output = if lines.is_empty() { text.trim().to_owned() } else { lines.join("\n") };
    Err(BuildError::Compiler { output })
}

/// What is listed in the generated tables of variables, but is no number in the generated classes, as (scope, name).
/// Verilator lists whatever was asked for: a `genvar` or an interface's reference, which no class has, so that the C++
/// does not compile; and a queue, as if it were one byte.
fn unreachable(generated: &Path) -> Result<HashSet<(String, String)>, BuildError> {
    let text = read(&generated.join("Vdut__Syms.cpp"))?;
    // `Vdut_child   TOP__child;` names the class of an instance.
    let symbols = read(&generated.join("Vdut__Syms.h"))?;
    let classes: HashMap<&str, &str> = symbols
        .lines()
        .filter_map(|line| line.trim().strip_suffix(';')?.split_once(' '))
        .map(|(class, instance)| (instance.trim(), class))
        .collect();
    let scopes: HashMap<&str, &str> = text.lines().filter_map(configured).collect();
    let mut members: HashMap<&str, HashSet<String>> = HashMap::new();
    let mut found = HashSet::new();
    for (scope, name, instance, member) in text.lines().filter_map(inserted) {
        let Some(class) = classes.get(instance) else { continue };
        if !members.contains_key(class) {
            members.insert(class, numbers_of(&read(&generated.join(format!("{class}.h")))?));
        }
        if let Some(scope) = scopes.get(scope).filter(|_| !members[class].contains(member)) {
            found.insert(((*scope).to_owned(), name.to_owned()));
        }
    }
    Ok(found)
}

/// The scope's variable and its name in a line like `__Vscope_t__lane.configure(this, name(), "t.lane", ...`.
fn configured(line: &str) -> Option<(&str, &str)> {
    let (scope, rest) = line.trim().split_once(".configure(this, name(), \"")?;
    Some((scope, rest.split_once('"')?.0))
}

/// Scope, name, instance and member in a line like `__Vscope_t.varInsert(__Vfinal,"i", &(TOP__t.i), ...`.
fn inserted(line: &str) -> Option<(&str, &str, &str, &str)> {
    let (scope, rest) = line.trim().split_once(".varInsert(__Vfinal,\"")?;
    let (name, rest) = rest.split_once('"')?;
    let (instance, member) = rest.split_once("&(")?.1.split_once(')')?.0.split_once('.')?;
    Some((scope, name, instance, member))
}

/// The members of a generated class that are vectors, `real`, strings, or arrays of these.
fn numbers_of(header: &str) -> HashSet<String> {
    const TYPES: [&str; 8] = ["CData", "SData", "IData", "QData", "VlWide", "VlUnpacked", "double", "std::string"];
    let is_number = |line: &&str| {
        let port = line.starts_with("VL_IN") || line.starts_with("VL_OUT");
        let odd = ["VlQueue", "VlAssocArray", "VlClassRef"].iter().any(|odd| line.contains(odd));
        !odd && line.ends_with(';') && (port || TYPES.iter().any(|kind| line.starts_with(kind)))
    };
    let names = header
        .lines()
        .map(str::trim)
        .filter(is_number)
        .flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_').map(str::to_owned));
    names.collect()
}

/// Whether `eval_step`, after the first call, only evaluates the root and ends threads that a model without threads
/// does not have.
fn is_plain_eval(text: &str) -> bool {
    let Some((_, body)) = text.split_once("::eval_step() {\n") else { return false };
    let plain = |l: &&str| !l.starts_with("VL_DEBUG_IF") && !l.starts_with("//") && !l.starts_with('#');
    let statements: Vec<&str> = body.lines().map(str::trim).filter(plain).take(13).collect();
    statements
        == [
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
            "",
        ]
}

struct HeaderPort<'a> {
    member: &'a str,
    width: u32,
    direction: u32,
}

/// `VL_IN8(&name,7,0);`, `VL_OUTW(&name,69,0,3);`, `VL_IN8((&name)[4],7,0);`.
fn parse_port(line: &str) -> Option<HeaderPort<'_>> {
    let rest = line.trim().strip_prefix("VL_")?;
    let (kind, arguments) = rest.split_once('(')?;
    let direction = match kind.trim_end_matches(|c: char| c.is_ascii_digit() || c == 'W') {
        "IN" => 0,
        "OUT" => 1,
        "INOUT" => 2,
        _ => return None,
    };
    let arguments = arguments.strip_suffix(");")?;
    let mut fields = arguments.split(',');
    let name = fields.next()?;
    let member = name.trim_start_matches(['(', '&']).split([')', '[']).next()?;
    let (msb, lsb): (i64, i64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some(HeaderPort { member, width: u32::try_from(msb - lsb + 1).ok()?, direction })
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
        let port = parse_port("    VL_OUTW(&wide,69,0,3);").unwrap();
        assert_eq!((port.member, port.width, port.direction), ("wide", 70, 1));
        let port = parse_port("    VL_INOUT8(&io__024x,3,0);").unwrap();
        assert_eq!((port.member, port.width, port.direction), ("io__024x", 4, 2));
        let port = parse_port("VL_IN16((&taps)[4],8,0);").unwrap();
        assert_eq!((port.member, port.width, port.direction), ("taps", 9, 0));
        assert!(parse_port("    VL_UNCOPYABLE(Vdut);  ///< Copying not allowed").is_none());
    }

    #[test]
    fn files_read_have_blanks_and_quotes() {
        let text = "# DESCRIPTION: S\nC \"--cc a b.v\"\nS  99  1  2  3  2  3 \"/p/a b.v\"\n\
                    S 0 0 0 0 1 0 \"/q\"u/i.vh\"\nT  5  1  2  3  2  3 \"out/V.cpp\"\n";
        assert_eq!(files_read(text), ["/p/a b.v", "/q\"u/i.vh"]);
        let variables = [("b", "$b"), ("c", "${c}"), ("e", "$(e)"), ("g_1", "$g_1"), ("h", "$h"), ("j", "$j")];
        assert_eq!(variables_in("/a $b/${c}d/$(e)/$/f$g_1$h-i$j"), variables);
        assert_eq!(variables_in("/a/${b"), []);
    }

    #[test]
    fn lines_of_the_tables_are_read() {
        let line =
            "        __Vscope_g__lane.varInsert(__Vfinal,\"i\", &(TOP__g.lane__DOT__i), false, VLVT_UINT32,0,1 ,31,0);";
        assert_eq!(inserted(line), Some(("__Vscope_g__lane", "i", "TOP__g", "lane__DOT__i")));
        assert_eq!(inserted("        //UNSUP __Vscope_g.varInsert(__Vfinal"), None);
        let line =
            "    __Vscope_g__lane.configure(this, name(), \"g.lane[0]\", \"lane[0]\", 0, VerilatedScope::SCOPE_OTHER);";
        assert_eq!(configured(line), Some(("__Vscope_g__lane", "g.lane[0]")));
        let header = "    CData/*7:0*/ byte;\n  VL_IN8(__PVT__clk,0,0);\n VlQueue<IData/*31:0*/> q;\n\
                      VlUnpacked<VlWide<4>/*99:0*/, 4> wide;\n VlUnpacked<VlQueue<CData/*0:0*/>, 2> qs;\n double r;";
        let found = numbers_of(header);
        assert!(["byte", "__PVT__clk", "wide", "r"].iter().all(|name| found.contains(*name)));
        assert!(["q", "qs"].iter().all(|name| !found.contains(*name)));
    }

    #[test]
    fn mangled_names_come_back() {
        assert_eq!(demangle("video__024data"), "video$data");
        assert_eq!(demangle("plain_name__0"), "plain_name__0");
        assert_eq!(demangle("a__05Fb"), "a_b");
    }
}
