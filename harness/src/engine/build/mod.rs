//! Verilog to a loaded model: sources + top + parameters + defines + flags -> Verilator -> shared library.
//!
//! [`Build`] describes a build, [`Build::compile`] runs it. A model that was built before is found again by a hash of
//! everything it depends on: the shim, the tools, flags, names and contents of the sources, and a manifest of all
//! files that Verilator read besides (includes). Several processes may build at once: each key has a lock, and a build
//! happens in a folder of its own that is renamed into place. A killed build leaves at most such a folder, which the
//! next build removes.
//!
//! Built models lie in the [cache folder](hoverlock_cache). After each build, models that were not used for 30 days are
//! removed, and those used longest ago while all together are larger than a limit. A model that is being loaded or
//! built is never removed.
//!
//! A Verilator newer than the harness knows is tried on a small design before its first use: ports, memories, arrays,
//! wide values and waves must be what they should be, else it is refused.
//!
//! Environment: `HOVERLOCK_CACHE` (the cache folder), `HOVERLOCK_CACHE_LIMIT` (the size of built models in MiB, 2048
//! if not set), `VERILATOR` and `CXX` (the tools).

mod diagnostic;
mod files;
mod generated;
mod hierarchy;
mod job;
mod manifest;
mod model_cache;
mod ports;
mod runtime;
mod tool;
mod trial;
mod unity;
mod unknown_warnings;

pub(crate) use unity::INTERFACE;

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use diagnostic::{Diagnostic, Severity};
pub use hierarchy::{Constant, EnumItems, Field, Kind, PortDirection, Variable};

use crate::engine::error::BuildError;
use crate::engine::model::Library;

/// Which waves a model can write. Built-in tracing costs a few percent of the speed while no file is open, and makes
/// the model 20 to 60 times slower while one is, so the traced model is a separate build.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Trace {
    /// None: the fastest model.
    #[default]
    None,
    /// Value change dump: large, read by all viewers.
    Vcd,
    /// GTKWave's compact format; needs zlib's headers.
    Fst,
}

/// Which coverage a model counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Coverage {
    /// Lines and branches.
    pub line: bool,
    /// Bits that went up and down.
    pub toggle: bool,
    /// `cover` statements.
    pub user: bool,
}

impl Coverage {
    /// All kinds.
    pub const ALL: Coverage = Coverage { line: true, toggle: true, user: true };

    pub(crate) fn any(self) -> bool {
        self.line || self.toggle || self.user
    }
}

/// The initial values of registers without a reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Initial {
    /// Zeros: repeatable, but hides a missing reset.
    #[default]
    Zero,
    /// Random bits from the instance's seed: finds a missing reset. Verilator has two states, so there is no X to find
    /// it by.
    Random,
}

/// The value of a module parameter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Parameter {
    /// A number.
    Integer(i128),
    /// A string, without its quotes.
    Text(String),
    /// Verilog text, such as `32'hdead_beef`.
    Verilog(String),
}

macro_rules! parameter_from {
    ($($t:ty),*) => { $(impl From<$t> for Parameter {
        fn from(value: $t) -> Self { Parameter::Integer(i128::from(value)) }
    })* };
}
parameter_from!(u8, u16, u32, u64, i8, i16, i32, i64, bool);

impl From<&str> for Parameter {
    fn from(text: &str) -> Self {
        Parameter::Text(text.to_owned())
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Verilator takes a plain number as 32 bits.
            Parameter::Integer(n) if *n >= -(1 << 31) && *n < 1 << 31 => write!(f, "{n}"),
            Parameter::Integer(n) if *n < 0 => write!(f, "-64'sh{:x}", n.unsigned_abs()),
            Parameter::Integer(n) => write!(f, "64'h{n:x}"),
            Parameter::Text(text) => write!(f, "\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")),
            Parameter::Verilog(text) => f.write_str(text),
        }
    }
}

/// The description of a model to build.
///
/// ```no_run
/// use hoverlock_harness::build::Build;
/// let library = Build::new("counter").source("rtl/counter.v").parameter("WIDTH", 8).compile()?;
/// # Ok::<(), hoverlock_harness::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Build {
    pub(crate) top: String,
    pub(crate) sources: Vec<PathBuf>,
    pub(crate) includes: Vec<PathBuf>,
    pub(crate) parameters: BTreeMap<String, Parameter>,
    pub(crate) defines: BTreeMap<String, Option<String>>,
    pub(crate) flags: Vec<String>,
    pub(crate) internals: Vec<String>,
    pub(crate) registers: bool,
    pub(crate) forceable: Vec<String>,
    pub(crate) trace: Trace,
    pub(crate) coverage: Coverage,
    pub(crate) initial: Initial,
    pub(crate) assertions: bool,
    pub(crate) warnings_are_errors: bool,
    pub(crate) timescale: String,
    pub(crate) verilator: Option<PathBuf>,
    pub(crate) cache: Option<PathBuf>,
    pub(crate) cache_limit: Option<u64>,
    /// Whether this is the trial of a Verilator that the harness does not know.
    pub(crate) on_trial: bool,
}

impl Build {
    /// Creates a build of module `top`, without sources.
    pub fn new(top: impl Into<String>) -> Build {
        Build {
            top: top.into(),
            sources: Vec::new(),
            includes: Vec::new(),
            parameters: BTreeMap::new(),
            defines: BTreeMap::new(),
            flags: Vec::new(),
            internals: Vec::new(),
            registers: false,
            forceable: Vec::new(),
            trace: Trace::None,
            coverage: Coverage::default(),
            initial: Initial::Zero,
            assertions: true,
            warnings_are_errors: false,
            timescale: "1ns/1ps".into(),
            verilator: None,
            cache: None,
            cache_limit: None,
            on_trial: false,
        }
    }

    /// Adds a Verilog or SystemVerilog file.
    pub fn source(mut self, path: impl Into<PathBuf>) -> Build {
        self.sources.push(path.into());
        self
    }

    /// Adds several files.
    pub fn sources<P: Into<PathBuf>>(mut self, paths: impl IntoIterator<Item = P>) -> Build {
        self.sources.extend(paths.into_iter().map(Into::into));
        self
    }

    /// Adds a folder for `` `include `` and for modules named like their files.
    pub fn include(mut self, folder: impl Into<PathBuf>) -> Build {
        self.includes.push(folder.into());
        self
    }

    /// Sets a parameter of the top module.
    pub fn parameter(mut self, name: impl Into<String>, value: impl Into<Parameter>) -> Build {
        self.parameters.insert(name.into(), value.into());
        self
    }

    /// Defines a macro without a value.
    pub fn define(mut self, name: impl Into<String>) -> Build {
        self.defines.insert(name.into(), None);
        self
    }

    /// Defines a macro with a value.
    pub fn define_as(mut self, name: impl Into<String>, value: impl fmt::Display) -> Build {
        self.defines.insert(name.into(), Some(value.to_string()));
        self
    }

    /// Passes a flag to Verilator unchanged.
    pub fn verilator_flag(mut self, flag: impl Into<String>) -> Build {
        self.flags.push(flag.into());
        self
    }

    /// Makes internal signals and memories accessible by hierarchical name below the top; `*` matches any text. What is
    /// accessible cannot be optimised away: everything (`*`) costs a third of the speed or more.
    pub fn internal(mut self, pattern: impl Into<String>) -> Build {
        self.internals.push(pattern.into());
        self
    }

    /// Makes all registers and memories accessible, and those that are outputs of the top too, for
    /// [`Model::set_bit`](crate::engine::model::Model::set_bit). [`SignalInfo::register`] says which they are.
    ///
    /// [`SignalInfo::register`]: crate::engine::model::SignalInfo::register
    pub fn registers(mut self, yes: bool) -> Build {
        self.registers = yes;
        self
    }

    /// Makes internal vectors forceable, and accessible, by hierarchical name below the top; `*` matches any text. The
    /// model checks at each use of such a signal whether it is forced.
    pub fn forceable(mut self, pattern: impl Into<String>) -> Build {
        self.forceable.push(pattern.into());
        self
    }

    /// Builds in waves.
    pub fn trace(mut self, trace: Trace) -> Build {
        self.trace = trace;
        self
    }

    /// Builds in coverage counters.
    pub fn coverage(mut self, coverage: Coverage) -> Build {
        self.coverage = coverage;
        self
    }

    /// Sets the initial values of registers without a reset.
    pub fn initial(mut self, initial: Initial) -> Build {
        self.initial = initial;
        self
    }

    /// Sets whether `assert` in the Verilog is checked (default: yes).
    pub fn assertions(mut self, on: bool) -> Build {
        self.assertions = on;
        self
    }

    /// Sets whether Verilator's warnings fail the build (default: no, see [`Library::warnings`]).
    pub fn warnings_are_errors(mut self, yes: bool) -> Build {
        self.warnings_are_errors = yes;
        self
    }

    /// Sets time unit and precision of modules without a `timescale` (default: `1ns/1ps`).
    pub fn timescale(mut self, text: impl Into<String>) -> Build {
        self.timescale = text.into();
        self
    }

    /// Uses this Verilator instead of `$VERILATOR` or `verilator`.
    pub fn verilator(mut self, path: impl Into<PathBuf>) -> Build {
        self.verilator = Some(path.into());
        self
    }

    /// Keeps built models in this folder instead of the [cache folder](hoverlock_cache).
    pub fn cache(mut self, folder: impl Into<PathBuf>) -> Build {
        self.cache = Some(folder.into());
        self
    }

    /// Limits the built models to this many bytes, instead of `$HOVERLOCK_CACHE_LIMIT` or 2 GiB.
    pub fn cache_limit(mut self, bytes: u64) -> Build {
        self.cache_limit = Some(bytes);
        self
    }

    /// Builds the model, or finds it in the cache, and loads it.
    ///
    /// # Errors
    /// [`BuildError`]: an option or a file is wrong, a tool is missing or too old, Verilator or the C++ compiler
    /// refuses the design, or the cache folder cannot be used.
    pub fn compile(&self) -> Result<Library, BuildError> {
        self.check()?;
        model_cache::load_or_build(self)
    }

    fn check(&self) -> Result<(), BuildError> {
        if self.sources.is_empty() {
            return Err(BuildError::NoSources { top: self.top.clone() });
        }
        let names = std::iter::once(("top module", &self.top))
            .chain(self.parameters.keys().map(|n| ("parameter", n)))
            .chain(self.defines.keys().map(|n| ("macro", n)));
        for (what, name) in names {
            let plain = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
            if name.is_empty() || !name.chars().all(plain) || name.starts_with(|c: char| c.is_ascii_digit()) {
                return Err(BuildError::BadOption { what, value: name.clone(), reason: "not a Verilog name" });
            }
        }
        for path in self.sources.iter().chain(&self.includes) {
            std::fs::metadata(path).map_err(|source| BuildError::Source { path: path.clone(), source })?;
        }
        Ok(())
    }

    /// Returns Verilator's arguments in every kind of run, in a fixed order; paths are absolute.
    fn verilator_arguments(&self, sources: &[PathBuf], includes: &[PathBuf]) -> Vec<String> {
        let mut arguments: Vec<String> =
            ["--top-module", &self.top, "--no-timing", "--timescale", &self.timescale].map(str::to_owned).to_vec();
        if !self.warnings_are_errors {
            arguments.push("-Wno-fatal".into());
        }
        if self.assertions {
            arguments.push("--assert".into());
        }
        arguments.extend(self.parameters.iter().map(|(name, value)| format!("-G{name}={value}")));
        arguments.extend(self.defines.iter().map(|(name, value)| match value {
            Some(value) => format!("-D{name}={value}"),
            None => format!("-D{name}"),
        }));
        arguments.extend(includes.iter().map(|folder| format!("-I{}", folder.display())));
        arguments.extend(self.flags.iter().cloned());
        arguments.extend(sources.iter().map(|s| s.display().to_string()));
        arguments
    }
}

/// The description of a built model, kept beside the shared library.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Record {
    pub top: String,
    /// Ports, then internals, in the order of the shim's table.
    pub signals: Vec<Variable>,
    /// Ports and internals asked for that the shim's table does not have.
    pub unreachable: Vec<String>,
    /// Whether the bench may drive the `inout`s of the top.
    pub drivable_inouts: bool,
    /// Parameters by name.
    pub constants: Vec<(String, Constant)>,
    /// All names of the hierarchy, for the nearest names in errors.
    pub names: Vec<String>,
    pub trace: Trace,
    pub coverage: bool,
    pub initial: Initial,
    pub warnings: Vec<Diagnostic>,
    /// Every other file that Verilator read, with the hash of its contents.
    pub manifest: Vec<(PathBuf, String)>,
    pub library_hash: String,
}

/// Returns the modules declared in the sources, for the error about a top that does not exist.
fn modules_in(sources: &[PathBuf]) -> Vec<String> {
    let mut found = Vec::new();
    for path in sources {
        let Ok(text) = std::fs::read_to_string(path) else { continue };
        let mut words = text.split_whitespace();
        while let Some(word) = words.next() {
            if word == "module"
                && let Some(next) = words.next()
            {
                let name: String = next.chars().take_while(|c| c.is_alphanumeric() || *c == '_' || *c == '$').collect();
                found.push(name);
            }
        }
    }
    found
}

fn absolute(path: &Path) -> Result<PathBuf, BuildError> {
    path.canonicalize().map_err(|source| BuildError::Source { path: path.to_owned(), source })
}
