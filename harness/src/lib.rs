//! A test-bench engine for Verilog: cocotb's habits on Verilator, near the simulator's own speed.
//!
//! [`build`] turns Verilog into a loaded [`model::Library`], found again by content; [`model::Model`] is one instance of
//! it; [`sim::Sim`] puts time, clocks and tasks around it, in regions whose order is written down there; [`bus`] drives
//! and checks Avalon and AXI buses; [`wave`] and [`coverage`] keep what happened. It knows nothing of what the Verilog
//! is for, and drives any that Verilator takes (no delays in the Verilog, no DPI).
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
//! Threads: a `Library` is for all of them, a `Model` may move from one to another, a `Sim` stays where it was made.
//!
//! What Verilator needs to be treated well, and is here: a context for each instance, set before every call; own
//! `vl_finish`, `vl_stop` and `vl_fatal`, which record and let the evaluation finish; printed text caught on its way;
//! symbols of each library hidden from the others; one unity file and a runtime compiled once.

#![warn(clippy::missing_errors_doc)]

pub mod build;
pub mod bus;
pub mod cache;
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
