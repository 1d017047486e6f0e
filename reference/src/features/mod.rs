//! From smoothed planes to described feature points: DoG, maxima, MaxLBP.
//!
//! [`extractor`] is the whole chain in clear f64; [`fast`] is the same chain in f32 at flight speed.

pub mod dog;
pub mod extractor;
pub mod fast;
pub mod feature;
pub mod lbp;
pub mod maxima;
pub mod maxlbp;
pub mod repeatability;
