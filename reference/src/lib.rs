//! The Hoverlock algorithm in floating point, one module per step.
//!
//! A down-looking camera sees the ground; features of the current frame are matched with those of a reference frame,
//! and the displacement along `X_e` and `Y_e` follows. Each module opens with the equation it implements. Samples are
//! in DN (digital numbers) of the 16-bit camera, `0 ..= 65535`, whatever their type.
//!
//! | folder | step |
//! |---|---|
//! | [`image`] | the plane of samples that every step reads and writes |
//! | [`smoothing`] | the Gaussian and its recursive approximations |
//! | [`features`] | DoG, maxima, MaxLBP descriptors |
//! | [`motion`] | matching, RANSAC, and the displacement in pixels and metres |

pub mod features;
pub mod image;
pub mod motion;
pub mod smoothing;
