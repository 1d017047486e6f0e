//! Times with a unit.

use hoverlock_harness::Time;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Converts a number with a unit (`fs`, `ps`, `ns`, `us`, `ms`, `sec`, `s` or `step`) into a time; integers are exact.
/// A `step` is 1 ps, the time precision that models are built with.
///
/// # Errors
/// `ValueError` for another unit, a negative time or one that does not fit.
pub fn time_of(value: &Bound<'_, PyAny>, unit: &str) -> PyResult<Time> {
    let (value, unit) = if unit == "step" { (value.clone(), "ps") } else { (value.clone(), unit) };
    let from_unit: fn(u64) -> Time = match unit {
        "fs" => Time::fs,
        "ps" => Time::ps,
        "ns" => Time::ns,
        "us" => Time::us,
        "ms" => Time::ms,
        "s" | "sec" => Time::s,
        _ => return Err(PyValueError::new_err(format!("no unit '{unit}': fs, ps, ns, us, ms, sec or step"))),
    };
    if let Ok(whole) = value.extract::<u64>() {
        return Ok(from_unit(whole));
    }
    let number: f64 = value.extract()?;
    Time::from_unit(number, unit).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Converts a number with a unit into a time that is a whole number of steps of 1 ps, rounded as `mode` says: `error`,
/// `round`, `ceil` or `floor`.
///
/// # Errors
/// Those of [`time_of`], and `ValueError` for another mode, or with `error` for a time between two steps.
pub fn rounded(value: &Bound<'_, PyAny>, unit: &str, mode: &str) -> PyResult<Time> {
    let py = value.py();
    let options = PyDict::new(py);
    options.set_item("round_mode", mode)?;
    let steps = py.import("hoverlock.cocotb.utils")?.getattr("get_sim_steps")?.call((value, unit), Some(&options))?;
    time_of(&steps, "step")
}

/// Converts a number with a unit into femtoseconds.
#[pyfunction]
pub fn femtoseconds(time: &Bound<'_, PyAny>, unit: &str) -> PyResult<u64> {
    time_of(time, unit).map(Time::as_fs)
}
