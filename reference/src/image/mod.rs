//! A plane of samples in raster order, and samples between its pixels.

pub mod bicubic;
pub mod fourier;
pub mod plane;
