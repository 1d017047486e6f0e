//! The model level `rtl`: the feature extractor as hardware, bit-identical to the model level `bit_true`.

#![allow(clippy::reversed_empty_ranges, reason = "a loop over the parts that a design has, which may be none")]

/// Writes a comment into the emitted Verilog. It has no effect in rust-hdl's simulator.
macro_rules! comment {
    ($text:tt) => {};
}

pub mod cells;
pub mod core;
pub mod design;
pub mod emission;
pub mod extractor;
pub mod registers;
pub mod smoother;
pub mod top;
