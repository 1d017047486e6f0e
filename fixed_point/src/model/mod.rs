//! The model of the hardware: number formats, filter coefficients, and the bit-true model from pixels to feature
//! records.
//!
//! [`bit_true`] supports any design. [`simd`] gives the same bits for the formats of the design point at tens of
//! megapixels per second; [`fastest`] chooses. [`crate::analysis`] measures both.

pub mod bit_true;
pub mod coefficients;
pub mod design;
pub mod fastest;
pub mod lerp;
pub mod record;
pub mod record_limit;
pub mod simd;
pub mod stages;
pub mod threshold;
