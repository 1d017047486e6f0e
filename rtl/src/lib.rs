//! the model level `rtl`: the feature extractor as hardware, bit-identical to the bit-true model.

/// Puts a comment into the emitted Verilog; nothing in the simulation.
macro_rules! comment {
    ($text:tt) => {};
}

pub mod cells;
pub mod core;
pub mod emission;
pub mod estimate;
pub mod extractor;
pub mod registers;
pub mod simulation;
pub mod smoother;
pub mod top;
