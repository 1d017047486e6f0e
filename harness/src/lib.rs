//! A test-bench engine for Verilog: coroutines and triggers as in cocotb, on Verilator, without a process or VPI
//! between.
//!
//! | module | what it does |
//! |---|---|
//! | [`build`] | Verilog to a loaded [`model::Library`], built once for the same content |
//! | [`model`] | one instance of a model: signals by name, evaluation, messages |
//! | [`sim`] | time, clocks and tasks around a model; the order of a time step |
//! | [`bus`] | drivers, monitors and checkers for Avalon and AXI |
//! | [`wave`], [`coverage`] | recorded signals, counted coverage |
//!
//! The engine drives any Verilog that Verilator takes without delays and DPI.
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

pub mod build;
pub mod bus;
pub mod coverage;
mod error;
pub mod model;
pub mod sim;
mod time;
pub mod wave;

pub use error::{BuildError, Error, ModelError, SimError, nearest};
pub use time::Time;

#[doc = include_str!("../docs/tutorial-rust.md")]
pub mod tutorial {}
