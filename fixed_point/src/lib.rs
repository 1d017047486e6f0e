//! The algorithm of [`hoverlock_reference`] in integers: what the hardware computes, and what is measured about it.
//!
//! Word lengths are data, chosen at run time for sweeps; the design point that the hardware is built for is one constant.

pub mod analysis;
pub mod model;

#[cfg(test)]
mod pictures;
