//! The Verilated top, from the emission or from Verilog files, cached by content.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use hoverlock_fixed_point::model::design::{DesignPoint, KT27};
use hoverlock_harness::{
    build::{Build, Initial, Trace},
    model::Library,
};
use sha2::{Digest, Sha256};

use super::{SimulationError, bench::INTERNALS};
use crate::design::buildable;
use crate::emission::{EmitError, File, committed, files_of, verilog_in};

/// The Verilated top, built once and cached by content.
#[derive(Debug, Clone)]
pub struct Simulator {
    library: Library,
    design: DesignPoint,
    plusargs: Vec<String>,
}

impl Simulator {
    /// A model of the committed Verilog, which is also what is synthesised. Without the project folder, of the
    /// emission.
    ///
    /// # Errors
    /// Where Verilator or the compiler fails.
    pub fn new() -> Result<Self, SimulationError> {
        Self::of_design(&KT27, None, Trace::None)
    }

    /// A model of a design: of the Verilog in a folder, or else of the committed Verilog for the default design and of
    /// the emission for others. With wave tracing it is a separate model, slower even if nothing is recorded.
    ///
    /// # Errors
    /// Where the design cannot be built, the folder has no Verilog, or Verilator or the compiler fails.
    pub fn of_design(design: &DesignPoint, folder: Option<&Path>, trace: Trace) -> Result<Self, SimulationError> {
        Self::build(design, &sources(design, folder)?, trace)
    }

    /// A model of these Verilog files of the default design.
    ///
    /// # Errors
    /// Where Verilator or the compiler fails.
    pub fn of(sources: &[PathBuf]) -> Result<Self, SimulationError> {
        Self::build(&KT27, sources, Trace::None)
    }

    fn build(design: &DesignPoint, sources: &[PathBuf], trace: Trace) -> Result<Self, SimulationError> {
        let build = Build::new("hoverlock_top").sources(sources).initial(Initial::Random).trace(trace);
        let build = INTERNALS.into_iter().fold(build, Build::internal);
        Ok(Self { library: build.compile()?, design: design.clone(), plusargs: Vec::new() })
    }

    /// The same model with command-line arguments for `$value$plusargs`.
    pub fn with_plusargs(self, plusargs: Vec<String>) -> Self {
        Self { plusargs, ..self }
    }

    /// The design whose bits are expected.
    pub fn design(&self) -> &DesignPoint {
        &self.design
    }

    /// The command-line arguments.
    pub fn plusargs(&self) -> &[String] {
        &self.plusargs
    }

    /// The Verilated top itself, for another bench.
    pub fn library(&self) -> &Library {
        &self.library
    }
}

/// The Verilog of a folder, the committed Verilog of the default design, or else the emission.
fn sources(design: &DesignPoint, folder: Option<&Path>) -> Result<Vec<PathBuf>, SimulationError> {
    buildable(design).map_err(EmitError::from)?;
    match folder {
        Some(folder) => verilog_in(folder).ok_or_else(|| EmitError::NoVerilog(folder.into()).into()),
        None => match committed().filter(|_| *design == KT27) {
            Some(committed) => Ok(committed),
            None => emitted(&files_of(design)?),
        },
    }
}

/// The emission as files in a folder named by content. Unchanged files keep their times, by which the harness finds the
/// built model.
fn emitted(files: &[File]) -> Result<Vec<PathBuf>, SimulationError> {
    let verilog: Vec<_> = files.iter().filter(|file| file.path.ends_with(".v")).collect();
    let mut digest = Sha256::new();
    verilog.iter().for_each(|file| digest.update(file.text.as_bytes()));
    let name: String = digest.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let folder = hoverlock_cache::folder()?.join("verilog").join(name);
    let mut sources = Vec::new();
    for file in verilog {
        let path = folder.join(file.path.trim_start_matches("verilog/"));
        put(&path, &file.text).map_err(|source| SimulationError::Write { path: path.clone(), source })?;
        sources.push(path);
    }
    Ok(sources)
}

/// Writes a file whole, unless it is there already.
fn put(path: &Path, text: &str) -> std::io::Result<()> {
    if std::fs::read(path).is_ok_and(|there| there == text.as_bytes()) {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.persist(path)?;
    Ok(())
}
