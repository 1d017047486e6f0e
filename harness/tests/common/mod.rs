//! What the tests share: designs by name, and a fresh simulation.
#![allow(dead_code, reason = "each test file uses its part")]

pub mod buses;

use std::path::PathBuf;

use hoverlock_harness::Error;
use hoverlock_harness::build::Build;
use hoverlock_harness::sim::Sim;

/// A build of a design of `tests/designs`.
pub fn build(top: &str) -> Build {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/designs");
    let verilog = folder.join(format!("{top}.v"));
    let source = if verilog.exists() { verilog } else { folder.join(format!("{top}.sv")) };
    Build::new(top).source(source)
}

/// A fresh simulation of it.
pub fn sim(build: Build) -> Sim {
    let library =
        build.compile().expect("these tests need verilator 5.006 and g++: run `make test`, which installs them");
    Sim::new(library.instance().expect("an instance")).expect("a simulation")
}

/// Runs a bench that must end well.
pub fn run(sim: &mut Sim, bench: impl Future<Output = Result<(), Error>>) {
    if let Err(error) = sim.run(bench) {
        panic!("{error}");
    }
}
