//! The coefficient generator of the smoothers.

use hoverlock_fixed_point::model::coefficients::{LerpCoefficients, look_ahead_for};
use pyo3::prelude::*;

use crate::value_error;

/// Designs the smoother of a sigma, in pixels. Returns `(a, g, [g_j], saturated stages)`: the pole `a`, the raw
/// integers `g` and `g_j`, whose LSB is 2^-`frac_bits`, and the indices of the stages whose `g_j` saturates.
#[pyfunction]
pub fn lerp_coefficients(sigma: f64, look_ahead: u32, frac_bits: u32) -> PyResult<(f64, u32, Vec<u32>, Vec<u32>)> {
    let c = LerpCoefficients::design(sigma, look_ahead, frac_bits).map_err(value_error)?;
    Ok((c.a, c.g, c.g_j, c.saturated))
}

/// Returns the smallest number of look-ahead stages that omit at most the fraction `error`, between 0 and 1, of the
/// infinite sum of a filter with the pole `a`.
#[pyfunction]
pub fn look_ahead_of(a: f64, error: f64) -> PyResult<u32> {
    look_ahead_for(a, error).map_err(value_error)
}
