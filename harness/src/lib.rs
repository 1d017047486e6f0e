//! A test-bench engine for Verilog.
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
