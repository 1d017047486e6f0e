//! Verilator's runtime, compiled once for each kind of model; and the flags of every C++ compilation.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::Trace;
use super::tool;
use crate::engine::error::BuildError;

pub(super) const HOOKS: &str = include_str!("runtime_hooks.h");
/// The header that every model includes first, precompiled beside the runtime's objects.
pub(super) const PREFIX: &str = "prefix.h";
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
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|source| BuildError::Cache { path, source })
    };
    write("runtime_hooks.h", HOOKS)?;
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
    headers.extend(["verilated_dpi.h", "verilated_syms.h"]);
    match trace {
        Trace::None => {}
        Trace::Vcd => headers.push("verilated_vcd_c.h"),
        Trace::Fst => headers.push("verilated_fst_c.h"),
    }
    for header in headers {
        let _ = writeln!(prefix, "#include <{header}>");
    }
    write(PREFIX, &prefix)?;
    let mut command = command();
    command.args(["-x", "c++-header", "-o", &format!("{PREFIX}.gch"), PREFIX]);
    check_compiler(&tool::run(&mut command)?, trace)
}

/// Returns the runtime's objects in their folder.
pub(super) fn runtime_objects(folder: &Path, trace: Trace, coverage: bool) -> Vec<PathBuf> {
    runtime_files(trace, coverage).iter().map(|file| folder.join(format!("{file}.o"))).collect()
}

/// Returns the runtime's files a kind of model needs.
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

pub(super) fn trace_flags(trace: Trace) -> [&'static str; 3] {
    match trace {
        Trace::None => ["-DVM_TRACE=0", "-DVM_TRACE_VCD=0", "-DVM_TRACE_FST=0"],
        Trace::Vcd => ["-DVM_TRACE=1", "-DVM_TRACE_VCD=1", "-DVM_TRACE_FST=0"],
        Trace::Fst => ["-DVM_TRACE=1", "-DVM_TRACE_VCD=0", "-DVM_TRACE_FST=1"],
    }
}

pub(super) fn include_flags(root: &Path) -> [String; 2] {
    let include = root.join("include");
    [format!("-I{}", include.display()), format!("-I{}", include.join("vltstd").display())]
}

pub(super) fn check_compiler(output: &std::process::Output, trace: Trace) -> Result<(), BuildError> {
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
    if trace == Trace::Fst && (text.contains("lz4.h") || text.contains("-llz4")) {
        return Err(BuildError::ToolMissing {
            tool: "lz4.h".into(),
            hint: "this Verilator's FST waves need it (Debian: apt-get install liblz4-dev); VCD waves do not".into(),
        });
    }
    let lines: Vec<&str> = text.lines().filter(|l| l.contains("error") || l.contains("undefined")).take(20).collect();
    let output = if lines.is_empty() { text.trim().to_owned() } else { lines.join("\n") };
    Err(BuildError::Compiler { output })
}

/// Returns `true` if this version's FST waves are packed by the lz4 library.
pub(super) fn needs_lz4(root: &Path) -> bool {
    root.join("include/fstcpp").is_dir()
}
