//! From a picture file to a plane of 16-bit luma samples, and seeded degradations of such a plane.

pub mod conditions;
pub mod picture;
pub mod plane;
