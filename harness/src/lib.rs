//! Test benches for Verilog in Rust: coroutines and triggers as in cocotb, on Verilator in the same process, without
//! VPI.
//!
//! | half | module | what it does |
//! |---|---|---|
//! | engine | [`build`] | turns Verilog into a loaded [`model::Library`], built once for the same content |
//! | | [`model`] | one instance of a model: signals by name, evaluation, messages |
//! | | [`wave`], [`coverage`] | records signals, counts coverage |
//! | bench | [`sim`] | time, clocks and tasks around a model; the order of a time step |
//! | | [`bus`] | drivers, monitors and checkers for Avalon and AXI |
//!
//! The bench uses the engine, never the other way round. The [tutorial] shows both.
//!
//! The harness drives any Verilog that Verilator accepts without delays and DPI.
//!
//! ```
//! use hoverlock_harness::build::Build;
//! use hoverlock_harness::sim::{Sim, expect_equal};
//! use hoverlock_harness::{Error, Time};
//!
//! # let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/designs/counter.v");
//! let library = Build::new("counter").source(source).parameter("WIDTH", 8).compile()?;
//! let mut sim = Sim::new(library.instance()?)?;
//! let dut = sim.dut();
//! dut.clock("clk", Time::ns(10))?;
//! sim.run(async {
//!     let (clk, count) = (dut.signal("clk")?, dut.signal("count")?);
//!     dut.signal("enable")?.set(1)?;
//!     dut.signal("step")?.set(3)?;
//!     clk.cycles(10).await;
//!     expect_equal("count before the tenth edge", count.get(), 27)
//! })?;
//! # Ok::<(), Error>(())
//! ```
//!
//! A `Library` may be used by all threads. A `Model` may move from one thread to another. A `Sim` stays on the thread
//! that made it.
//!
//! How Verilator is used: each instance has a context of its own, set before every call. `vl_finish`, `vl_stop` and
//! `vl_fatal` are replaced by functions that record the event and let the evaluation finish. Printed text is caught.
//! The symbols of each library are hidden from the others. A model is compiled as one file, Verilator's runtime only
//! once.

#![warn(clippy::missing_errors_doc)]

mod bench;
mod engine;

pub use bench::error::{Error, SimError};
pub use bench::{bus, sim};
pub use engine::error::{BuildError, ModelError, RecordingError, nearest};
pub use engine::time::{InvalidTime, Time};
pub use engine::{build, coverage, model, wave};

#[doc = include_str!("../docs/tutorial-rust.md")]
pub mod tutorial {}
