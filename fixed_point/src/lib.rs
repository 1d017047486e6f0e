//! The algorithm of [`hoverlock_reference`] taken down to integers, one cause of error at a time.
//!
//! Word lengths are data, chosen at run time for sweeps; the design point that the hardware is built for is one constant.

pub mod acceptance;
pub mod bit_true;
pub mod bounds;
pub mod coefficients;
pub mod design;
pub mod displacement;
pub mod format;
pub mod ladder;
pub mod lerp;
pub mod measure;
pub mod range;
pub mod resources;
pub mod stages;
pub mod swift;
pub mod worst_case;

#[cfg(test)]
mod pictures;
