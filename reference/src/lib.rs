//! The Hoverlock algorithm in floating point: clear before fast, one module per step.
//!
//! A down-looking camera sees the ground; features of the current frame are matched with those of a reference frame, and
//! the displacement along `X_e` and `Y_e` follows. Each module opens with the equation it implements. Planes hold pixel
//! codes of the 16-bit camera word, `0 ..= 65535`, whatever the sample type.

pub mod conditions;
pub mod dog;
pub mod estimate;
pub mod extractor;
pub mod fast;
pub mod feature;
pub mod gaussian;
pub mod lbp;
pub mod matching;
pub mod maxima;
pub mod maxlbp;
pub mod motion;
pub mod orthophoto;
pub mod picture;
pub mod plane;
pub mod pose;
pub mod ransac;
pub mod recursive;
pub mod repeatability;
mod separable;
pub mod smoother;
