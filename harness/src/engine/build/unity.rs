//! The unity file: one C++ file that includes all others and the table of signals, compiled to one shared library.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use super::Trace;
use super::files::{read, write};
use super::generated::{classes_in, has_classes, numbers_of};
use super::hierarchy::{PortDirection, Variable};
use super::job::BuildJob;
use super::runtime::{CXX_FLAGS, PREFIX, check_compiler, include_flags, needs_lz4, runtime_objects, trace_flags};
use super::tool;
use crate::engine::error::BuildError;

pub(super) const SHIM: &str = include_str!("shim.cpp");
/// The version of the shim's functions: incremented whenever one of them changes.
pub(crate) const INTERFACE: u32 = 3;

impl BuildJob<'_> {
    /// Writes the table of signals and the unity file.
    pub(super) fn write_unity(
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

    pub(super) fn compile(&self, root: &Path, generated: &Path, runtime: &Path) -> Result<(), BuildError> {
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
}

/// The signals whose value is not the design's alone, by their indices in the table.
pub(super) struct Overrides {
    /// Those that can be forced.
    forced: Vec<usize>,
    /// The `inout`s of the top that the bench may drive.
    inouts: Vec<usize>,
}

impl Overrides {
    pub fn new(
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

/// Returns `true` if `eval_step`, after the first call, only evaluates the root and ends threads that a model without
/// threads does not have. (Newer versions also delete objects of classes there; the caller removes that line for a
/// model without classes.)
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
