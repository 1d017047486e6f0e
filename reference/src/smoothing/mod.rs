//! Smoothing by `sigma` pixels: the sampled Gaussian, its recursive approximations, and one type for all of them.

pub mod design;
pub mod gaussian;
pub mod recursive;
mod separable;
pub mod smoother;
