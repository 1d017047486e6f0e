//! The errors of the engine. Each message says what is wrong, where, why, and what to do.

use std::path::PathBuf;

use super::build::Diagnostic;
use super::time::Time;

/// A reason why Verilog did not become a loaded model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the fields are the parts of the message")]
pub enum BuildError {
    /// A tool is not installed.
    #[error("{tool} was not found: {hint}")]
    ToolMissing { tool: String, hint: String },
    /// The version of Verilator cannot be used: it is too old, or it is unknown to the harness and failed its trial.
    #[error("verilator {found} at {path} cannot be used: {reason}", path = path.display())]
    VersionUnsupported { found: String, path: PathBuf, reason: String },
    /// A source or an include folder does not exist or cannot be read.
    #[error("{path}: {source}", path = path.display())]
    Source { path: PathBuf, source: std::io::Error },
    /// No Verilog source was given.
    #[error("no Verilog source was given for top module '{top}'")]
    NoSources { top: String },
    /// A name or a value that cannot be put on Verilator's command line.
    #[error("{what} '{value}' is not valid: {reason}")]
    BadOption { what: &'static str, value: String, reason: &'static str },
    /// The sources have no such module.
    #[error("no module '{top}' in the sources{}", nearest_text(nearest))]
    NoSuchTop { top: String, nearest: Vec<String> },
    /// An internal signal asked for by name does not exist.
    #[error("no internal signal '{name}' in '{top}'{}", nearest_text(nearest))]
    NoSuchInternal { name: String, top: String, nearest: Vec<String> },
    /// Verilator refused the Verilog.
    #[error("verilator found errors in the Verilog:\n{}", diagnostics_text(diagnostics))]
    Verilog { diagnostics: Vec<Diagnostic> },
    /// The C++ compiler failed on what Verilator wrote.
    #[error("the C++ compiler failed on the generated model:\n{output}")]
    Compiler { output: String },
    /// A program could not be started.
    #[error("{program} could not be run: {source}")]
    Spawn { program: String, source: std::io::Error },
    /// The folder of built models cannot be used.
    #[error("the cache folder {path} cannot be used: {source}; set HOVERLOCK_CACHE to a writable folder",
        path = path.display())]
    Cache { path: PathBuf, source: std::io::Error },
    /// No variable says where the cache folder is.
    #[error(transparent)]
    NoCacheFolder(#[from] hoverlock_cache::NoCacheFolder),
    /// A built model cannot be loaded, even after a fresh build.
    #[error("the built model {path} cannot be loaded: {reason}", path = path.display())]
    Load { path: PathBuf, reason: String },
    /// An output of Verilator does not have the expected format.
    #[error("verilator's {what} cannot be read: {reason}")]
    Unexpected { what: &'static str, reason: String },
}

/// A wrong use of a model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the fields are the parts of the message")]
pub enum ModelError {
    /// No port or public signal of that name.
    #[error("no signal '{name}' in '{top}'{}", nearest_text(nearest))]
    NoSuchSignal { name: String, top: String, nearest: Vec<String> },
    /// The signal exists, but is of a type that cannot be accessed.
    #[error(
        "'{name}' of '{top}' cannot be accessed: only vectors, arrays of vectors, `real` and internal `string` can, \
         not queues, events and classes, and of an unpacked structure inside the design its fields alone, \
         '{name}.field'"
    )]
    NotReachable { name: String, top: String },
    /// A value that does not fit the width.
    #[error("{value} does not fit '{signal}', which is {width} bits wide ({low} to {high})")]
    OutOfRange { signal: String, value: String, width: u32, low: String, high: String },
    /// A signal wider than 64 bits, asked for as a number.
    #[error("'{signal}' is {width} bits wide: use `wide` in place of `signal`")]
    TooWide { signal: String, width: u32 },
    /// A write of some bits whose value has others.
    #[error("the value for some bits of '{signal}' has others: clear those that its mask does not have")]
    OutsideOfMask { signal: String },
    /// A memory asked for as a signal, or a signal as a memory.
    #[error("'{signal}' {is}: use `{instead}`")]
    WrongShape { signal: String, is: &'static str, instead: &'static str },
    /// An address outside a memory.
    #[error("address {index} is outside of '{memory}', which has {first} to {last}")]
    Address { memory: String, index: i64, first: i64, last: i64 },
    /// A write to an output.
    #[error("'{signal}' is an output of '{top}' and cannot be written")]
    NotWritable { signal: String, top: String },
    /// A write through a handle that outlived its simulation.
    #[error("'{signal}' belongs to a simulation that has ended: each test has a model of its own")]
    Ended { signal: String },
    /// A write in the region `ReadOnly`.
    #[error("'{signal}' was written in ReadOnly at {time}: write after NextTimeStep, or in ReadWrite")]
    WriteInReadOnly { signal: String, time: Time },
    /// A name that the enumeration does not have.
    #[error("'{signal}' has no value named '{name}'{}", nearest_text(nearest))]
    NoSuchEnumItem { signal: String, name: String, nearest: Vec<String> },
    /// A signal that was not made forceable.
    #[error("'{signal}' cannot be forced: {}", if *is_port {
        "it is a port of the top; force the signal inside that drives it".to_owned()
    } else {
        format!("add .forceable(\"{signal}\") to the build")
    })]
    NotForceable { signal: String, is_port: bool },
    /// The signal has no such bit.
    #[error("'{signal}' has no bit {bit}: it has {width} bits, the lowest is bit 0")]
    NoSuchBit { signal: String, bit: u32, width: u32 },
    /// The saved registers are not of this model.
    #[error("the {bytes} bytes of saved registers are not those of '{top}'")]
    OtherRegisters { top: String, bytes: usize },
    /// A bit was to be changed in something that no clock writes.
    #[error("'{signal}' is no register or memory that a clock writes: its drivers decide its value")]
    NotRegister { signal: String },
    /// An `inout` of a model whose Verilator does not let a bench drive it.
    #[error(
        "'{signal}' is an inout, which a bench cannot drive on this Verilator: it has no --pins-inout-enables, \
         which newer ones have (5.048 does)"
    )]
    InoutNotDrivable { signal: String },
    /// A signal of a kind that the harness does not record.
    #[error("'{signal}' {reason}")]
    NotRecordable { signal: String, reason: &'static str },
    /// The model was built without the option.
    #[error("{what} needs a model built with {with}")]
    NotBuiltIn { what: &'static str, with: &'static str },
    /// The model failed in an evaluation and cannot be evaluated any more.
    #[error("the model '{top}' stopped: {message}{}", place_text(file, *line))]
    Dead { top: String, message: String, file: String, line: u32 },
    /// No instance can be made.
    #[error("an instance of '{top}' cannot be made: {reason}")]
    Instance { top: String, reason: String },
}

/// A reason why a file of waves or coverage was not written or read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the fields are the parts of the message")]
pub enum RecordingError {
    /// The model does not have the signal, or was built without waves or coverage.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The file cannot be written or read.
    #[error("{path}: {source}", path = path.display())]
    File { path: PathBuf, source: std::io::Error },
}

/// Returns at most five candidates nearest to a name, by edit distance, ignoring case. A candidate that differs in more
/// than a third of its letters is left out, unless it contains the name.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let wanted = name.to_lowercase();
    let limit = wanted.chars().count().div_ceil(3);
    let mut scored: Vec<(usize, &str)> = candidates
        .into_iter()
        .filter_map(|candidate| {
            let lower = candidate.to_lowercase();
            let tail = lower.rsplit('.').next().unwrap_or(&lower);
            let distance = edit_distance(&wanted, &lower).min(1 + edit_distance(&wanted, tail));
            (distance <= limit || lower.contains(&wanted)).then_some((distance, candidate))
        })
        .collect();
    scored.sort();
    scored.dedup();
    scored.into_iter().take(5).map(|(_, candidate)| candidate.to_owned()).collect()
}

/// Computes the Levenshtein distance, one row at a time.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

fn nearest_text(nearest: &[String]) -> String {
    if nearest.is_empty() { String::new() } else { format!("; nearest: {}", nearest.join(", ")) }
}

/// Returns ` (file:line)`, or nothing if the file is not known.
pub(crate) fn place_text(file: &str, line: u32) -> String {
    if file.is_empty() { String::new() } else { format!(" ({file}:{line})") }
}

fn diagnostics_text(diagnostics: &[Diagnostic]) -> String {
    let mut lines: Vec<String> = diagnostics.iter().take(20).map(|d| format!("  {d}")).collect();
    if diagnostics.len() > lines.len() {
        lines.push(format!("  ... and {} more", diagnostics.len() - lines.len()));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_finds_its_neighbours() {
        let names = ["clk", "rst_n", "data_in", "data_out", "u_core.data_in"];
        assert_eq!(nearest("dat_in", names), ["data_in", "u_core.data_in"]);
        assert_eq!(nearest("CLK", names)[0], "clk");
        assert!(nearest("completely_else", names).is_empty());
    }
}
