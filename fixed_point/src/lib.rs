//! The algorithm of [`hoverlock_reference`] in fixed point: the model of the hardware, and its analysis.
//!
//! Word lengths are data, so that sweeps can vary them at run time. The design point of the hardware is one constant.

#[cfg(feature = "analysis")]
pub mod analysis;
pub mod model;

#[cfg(test)]
mod pictures;
