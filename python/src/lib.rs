//! `hoverlock_models._native`: the bit-true model and the coefficient generator on numpy arrays, and the co-simulation.
//! Users import `hoverlock_models`, which checks the arguments and names the fields of records and results.

mod bit_true;
mod coefficients;
mod cosim;

#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::bit_true::{BitTrue, emission_value};
    #[pymodule_export]
    use crate::coefficients::{lerp_coefficients, look_ahead_of};
    #[pymodule_export]
    use crate::cosim::{HoverOutcome, ReplayOutcome, fly_hover, fly_point, replay_sequence};
}

/// Converts an error of the libraries into a `ValueError` of one line.
fn value_error(error: impl std::fmt::Display) -> pyo3::PyErr {
    pyo3::exceptions::PyValueError::new_err(error.to_string())
}
