//! Signals that have no bits: `real` and `string`.

use std::sync::Arc;

use hoverlock_harness::model::Direction;
use hoverlock_harness::sim::{Dut, Real, Text};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};

use super::names::{direction_name, own_name, path};
use crate::errors;
use crate::on_thread::OnThread;

/// A `real` port or internal signal. Its value is a `float`.
///
/// >>> dut.gain.value = 1.25
#[pyclass(frozen, module = "hoverlock", weakref)]
pub struct RealHandle {
    real: OnThread<Real>,
    name: String,
    top: Arc<str>,
    direction: Direction,
}

impl RealHandle {
    pub fn new(dut: &Dut, top: &Arc<str>, name: String, direction: Direction) -> PyResult<RealHandle> {
        let real = OnThread::new(dut.real(&name).map_err(|e| errors::of_model(&e))?);
        Ok(RealHandle { real, name, top: top.clone(), direction })
    }
}

#[pymethods]
impl RealHandle {
    /// The value. The model takes a write when all tasks of this round have run.
    #[getter]
    fn get_value(&self) -> PyResult<f64> {
        Ok(self.real.get()?.get())
    }

    #[setter]
    fn set_value(&self, value: f64) -> PyResult<()> {
        self.real.get()?.set(value).map_err(|e| errors::of_model(&e))
    }

    /// The same as assigning to `value`.
    fn setimmediatevalue(&self, value: f64) -> PyResult<()> {
        self.set_value(value)
    }

    /// The signal's own name, without the names of the instances that contain it.
    #[getter]
    fn _name(&self) -> &str {
        own_name(&self.name)
    }

    /// The path, from the top module.
    #[getter]
    fn _path(&self) -> String {
        path(&self.top, &self.name)
    }

    /// The type, in cocotb's notation.
    #[getter]
    fn _type(&self) -> &'static str {
        "GPI_REAL"
    }

    /// `input`, `output`, `inout` or `internal`.
    #[getter]
    fn direction(&self) -> &'static str {
        direction_name(self.direction)
    }

    fn __float__(&self) -> PyResult<f64> {
        self.get_value()
    }

    fn __repr__(&self) -> String {
        format!("<{} real {}>", direction_name(self.direction), self.name)
    }
}

/// A `string` inside the design. Its value is `bytes`, as in cocotb.
///
/// >>> dut.u_core.message.value = b"begin"
#[pyclass(frozen, module = "hoverlock", weakref)]
pub struct TextHandle {
    text: OnThread<Text>,
    name: String,
    top: Arc<str>,
}

impl TextHandle {
    pub fn new(dut: &Dut, top: &Arc<str>, name: String) -> PyResult<TextHandle> {
        let text = OnThread::new(dut.text(&name).map_err(|e| errors::of_model(&e))?);
        Ok(TextHandle { text, name, top: top.clone() })
    }
}

#[pymethods]
impl TextHandle {
    /// The bytes. The model takes a write, of bytes or a string, when all tasks of this round have run.
    #[getter]
    fn get_value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.text.get()?.get()))
    }

    #[setter]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let text = self.text.get()?;
        if let Ok(bytes) = value.cast::<PyBytes>() {
            text.set(bytes.as_bytes())
        } else if let Ok(string) = value.cast::<PyString>() {
            text.set(string.to_str()?.as_bytes())
        } else {
            return Err(PyTypeError::new_err(format!(
                "'{}' takes bytes or a string, not {}",
                self.name,
                value.repr()?
            )));
        }
        .map_err(|e| errors::of_model(&e))
    }

    /// The same as assigning to `value`.
    fn setimmediatevalue(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(value)
    }

    /// The signal's own name, without the names of the instances that contain it.
    #[getter]
    fn _name(&self) -> &str {
        own_name(&self.name)
    }

    /// The path, from the top module.
    #[getter]
    fn _path(&self) -> String {
        path(&self.top, &self.name)
    }

    /// The type, in cocotb's notation.
    #[getter]
    fn _type(&self) -> &'static str {
        "GPI_STRING"
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.text.get()?.get().len())
    }

    fn __repr__(&self) -> String {
        format!("<string {}>", self.name)
    }
}
