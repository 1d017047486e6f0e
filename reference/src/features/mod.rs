//! Feature points and descriptors from smoothed planes: DoG, maxima, MaxLBP.
//!
//! [`extractor`] is the reference in f64. [`fast`] is the same chain in f32, for every use where speed matters.

pub mod dog;
pub mod extractor;
pub mod fast;
pub mod feature;
pub mod maxima;
pub mod maxlbp;
