//! The engine: from Verilog to a model in this process, its signals, its evaluation, its waves and coverage. It knows
//! no clock, no task and no bus.
//!
//! | module | content |
//! |---|---|
//! | [`build`] | runs Verilator and the compiler, caches built models |
//! | [`model`] | one instance of a model: signals, evaluation, messages |
//! | [`wave`], [`coverage`] | recorded signals, counted coverage |
//! | [`time`], [`error`] | what all of them share |

pub mod build;
pub mod coverage;
pub mod error;
pub mod model;
pub mod time;
pub mod wave;
