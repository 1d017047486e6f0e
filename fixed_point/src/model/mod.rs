//! What the hardware computes: number formats, filter coefficients, and the bit-true model from pixels to feature records.
//!
//! Nothing here measures anything; see [`crate::analysis`]. [`bit_true`] works for any design; [`simd`] gives the same bits
//! for the formats of the design point at tens of megapixels a second.

pub mod bit_true;
pub mod coefficients;
pub mod design;
pub mod format;
pub mod lerp;
pub mod simd;
pub mod stages;
