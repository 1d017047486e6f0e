//! Faults in the registers and memories of any Verilog while it runs: single-event upsets and stuck bits, drawn at
//! random over bits and clock cycles, and what comes of each. One Verilated model serves all faults: it is built with
//! [`Build::registers`](hoverlock_harness::build::Build::registers), and a fault writes a bit between two clock edges.
//!
//! | module | content |
//! |---|---|
//! | [`state`] | the registers and memories of a model, and a bit of them |
//! | [`draw`] | faults, and how they are drawn from a seed |
//! | [`class`] | what comes of a fault, counts of it, and their confidence intervals |
//! | [`campaign`] | many faults on several threads |
//! | [`core`] | a bench for any core, which compares its outputs with those of the run without a fault |
//! | [`table`] | the outcome of a campaign as CSV and Markdown |
//!
//! Which variables are registers is in [`SignalInfo::register`](hoverlock_harness::model::SignalInfo::register): those
//! that an `always` block with an edge assigns. Latches are none of them.

pub mod campaign;
pub mod class;
pub mod core;
pub mod draw;
pub mod state;
pub mod table;
