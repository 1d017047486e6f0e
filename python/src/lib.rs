//! `hoverlock_models._native`: the bit-true model and the coefficient generator on numpy arrays. Users import
//! `hoverlock_models`, which checks the arguments and names the fields of the records.

mod bit_true;
mod coefficients;

#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::bit_true::{BitTrue, emission_value};
    #[pymodule_export]
    use crate::coefficients::{lerp_coefficients, look_ahead_of};
}

/// Converts an error of the libraries into a `ValueError` of one line.
fn value_error(error: impl std::fmt::Display) -> pyo3::PyErr {
    pyo3::exceptions::PyValueError::new_err(error.to_string())
}
