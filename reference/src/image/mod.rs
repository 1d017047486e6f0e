//! From a picture file to a plane of 16-bit luma samples, and seeded degradations of such a plane.

#[cfg(feature = "pictures")]
pub mod conditions;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod plane;
