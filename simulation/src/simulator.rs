//! The Verilated top, from the emission or from Verilog files, cached by content.

use std::path::{Path, PathBuf};

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_harness::{
    build::{Build, Initial, Trace},
    model::Library,
};

use crate::{SimulationError, comparison::internals};
use hoverlock_rtl::emission::verilog::verilog;

/// The Verilated top, built once and cached by content.
#[derive(Debug, Clone)]
pub struct Simulator {
    library: Library,
    design: DesignPoint,
    plusargs: Vec<String>,
}

impl Simulator {
    /// Builds a model of the committed Verilog, which is also what is synthesised; without the project folder, of the
    /// emission.
    ///
    /// # Errors
    /// If Verilator or the compiler fails.
    pub fn new() -> Result<Self, SimulationError> {
        Self::of_design(&KT27, None, Trace::None)
    }

    /// Builds a model of a design: of the Verilog in a folder, or else of the committed Verilog for the default design
    /// and of the emission for others. With wave tracing it is a separate model, slower even if nothing is recorded.
    ///
    /// # Errors
    /// If the design cannot be built, the folder has no Verilog, or Verilator or the compiler fails.
    pub fn of_design(design: &DesignPoint, folder: Option<&Path>, trace: Trace) -> Result<Self, SimulationError> {
        Self::build(design, &verilog(design, folder)?, trace)
    }

    /// Builds a model of these Verilog files of a design.
    ///
    /// # Errors
    /// If Verilator or the compiler fails.
    pub fn of(design: &DesignPoint, sources: &[PathBuf]) -> Result<Self, SimulationError> {
        Self::build(design, sources, Trace::None)
    }

    /// Builds a model of these Verilog files of a design in which every register and memory can be written.
    ///
    /// # Errors
    /// If Verilator or the compiler fails.
    pub fn with_registers(design: &DesignPoint, sources: &[PathBuf]) -> Result<Self, SimulationError> {
        let build = Build::new("hoverlock_top").sources(sources).initial(Initial::Random).registers(true);
        Ok(Self { library: build.compile()?, design: design.clone(), plusargs: Vec::new() })
    }

    fn build(design: &DesignPoint, sources: &[PathBuf], trace: Trace) -> Result<Self, SimulationError> {
        let build = Build::new("hoverlock_top").sources(sources).initial(Initial::Random).trace(trace);
        let build = internals(design).iter().fold(build, |build, name| build.internal(name));
        Ok(Self { library: build.compile()?, design: design.clone(), plusargs: Vec::new() })
    }

    /// Returns the same model with command-line arguments for `$value$plusargs`.
    pub fn with_plusargs(self, plusargs: Vec<String>) -> Self {
        Self { plusargs, ..self }
    }

    /// Returns the design that the Verilog implements; its bit-true model gives the expected values.
    pub fn design(&self) -> &DesignPoint {
        &self.design
    }

    /// Returns the command-line arguments for `$value$plusargs`.
    pub fn plusargs(&self) -> &[String] {
        &self.plusargs
    }

    /// Returns the Verilated top itself, for another bench.
    pub fn library(&self) -> &Library {
        &self.library
    }
}
