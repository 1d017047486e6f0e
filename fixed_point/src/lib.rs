//! The algorithm of [`hoverlock_reference`] in fixed point: the model of the hardware and its analysis, and the
//! refinement on the frames that the processor does in integers.
//!
//! Word lengths are data, so that sweeps can vary them at run time. The design point of the hardware is one constant.

#[cfg(feature = "analysis")]
pub mod analysis;
pub mod model;
pub mod refinement;

#[cfg(test)]
mod pictures;
