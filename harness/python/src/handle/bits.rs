//! Bits of a signal.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyInt, PySlice, PyString};

use super::signal::{Access, Handle};
use super::value::{Stored, Value};
use crate::errors::RangeError;

/// The lowest bit and the width that an index names: `[3]` or, higher bit first as in Verilog, `[7:4]`.
pub(super) fn span(index: &Bound<'_, PyAny>, of_width: u32) -> PyResult<(u32, u32)> {
    let within = |i: i64| {
        u32::try_from(i)
            .ok()
            .filter(|i| *i < of_width)
            .ok_or_else(|| PyIndexError::new_err(format!("bit {i} of a value of {of_width} bits")))
    };
    let Ok(slice) = index.cast::<PySlice>() else { return Ok((within(index.extract()?)?, 1)) };
    let end = |name: &str, default: i64| -> PyResult<i64> {
        let bound = slice.getattr(name)?;
        if bound.is_none() { Ok(default) } else { bound.extract() }
    };
    let (high, low) = (within(end("start", i64::from(of_width) - 1)?)?, within(end("stop", 0)?)?);
    if high < low || !slice.getattr("step")?.is_none() {
        return Err(PyIndexError::new_err(format!("[{high}:{low}]: write the higher bit first, as in Verilog")));
    }
    Ok((low, high - low + 1))
}

/// Some bits of a signal.
///
/// >>> dut.leds[2].value = 1
/// >>> dut.bus[7:4].value
#[pyclass(frozen, module = "hoverlock._core")]
pub struct Bits {
    pub(super) handle: Py<Handle>,
    pub(super) low: u32,
    pub(super) width: u32,
}

#[pymethods]
impl Bits {
    /// The value of these bits. A write leaves the signal's other bits as they are, or as they were written before.
    #[getter]
    fn get_value(&self, py: Python<'_>) -> PyResult<Value> {
        Ok(self.handle.bind(py).get().get_value(py)?.get().part(self.low, self.width))
    }

    #[setter]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let py = value.py();
        let handle = self.handle.bind(py).get();
        let given = match value.cast::<PyString>() {
            Ok(text) => py.get_type::<PyInt>().call1((text, 2))?,
            Err(_) => value.call_method0("__index__")?,
        };
        let one = 1u32.into_bound_py_any(py)?;
        let size = one.lshift(self.width)?;
        let given = if given.lt(0)? { given.add(&size)? } else { given };
        if given.lt(0)? || given.ge(&size)? {
            return Err(RangeError::new_err(format!(
                "{value} does not fit {} bits of '{}'",
                self.width,
                handle.name()
            )));
        }
        let whole = match handle.access.get() {
            Access::Word(signal) => Stored::word(signal.get_pending()),
            Access::Wide(wide) => Stored::Wide(wide.get_pending().into_boxed_slice()),
        };
        let whole = Value { bits: whole, width: handle.width(), signed: false }.int(py)?;
        let mask = size.sub(&one)?.lshift(self.low)?;
        let kept = whole.sub(whole.bitand(&mask)?)?;
        handle.write_int(kept.bitor(given.lshift(self.low)?)?.cast::<PyInt>()?)
    }

    fn __int__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.get_value(py)?.int(py)
    }

    fn __len__(&self) -> usize {
        self.width as usize
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("<{}[{}:{}]>", self.handle.bind(py).get().name(), self.low + self.width - 1, self.low)
    }
}
