//! A plane of samples in raster order.

pub mod plane;
