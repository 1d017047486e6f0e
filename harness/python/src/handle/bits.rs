//! Bits of a signal.

use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyInt, PySlice, PyString};

use super::forcing::Change;
use super::signal::{Handle, has_unknown, resolve};
use super::value::Value;

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

/// The same with positions from the left, both included: `[0]` is the highest bit, `[0:7]` are the highest eight.
pub(super) fn span_from_left(index: &Bound<'_, PyAny>, of_width: u32) -> PyResult<(u32, u32)> {
    let last = i64::from(of_width) - 1;
    let within = |i: i64| {
        let at = if i < 0 { i + last + 1 } else { i };
        u32::try_from(at)
            .ok()
            .filter(|at| *at < of_width)
            .ok_or_else(|| PyIndexError::new_err(format!("position {i} of a value of {of_width} bits")))
    };
    let Ok(slice) = index.cast::<PySlice>() else { return Ok((of_width - 1 - within(index.extract()?)?, 1)) };
    let end = |name: &str, default: i64| -> PyResult<u32> {
        let bound = slice.getattr(name)?;
        within(if bound.is_none() { default } else { bound.extract()? })
    };
    let (left, right) = (end("start", 0)?, end("stop", last)?);
    if left > right || !slice.getattr("step")?.is_none() {
        return Err(PyIndexError::new_err(format!("[{left}:{right}]: positions count from the left, as in cocotb 1")));
    }
    Ok((of_width - 1 - right, right - left + 1))
}

/// The number that is written to a part of a signal: an integer, or binary digits.
pub(super) fn number_of<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = value.py();
    let digits = match value.cast::<PyString>() {
        Ok(text) => Some(text.to_str()?.to_owned()),
        Err(_) => match value.getattr(intern!(py, "is_resolvable")) {
            Ok(resolvable) if !resolvable.is_truthy()? => Some(value.str()?.to_str()?.to_owned()),
            _ => None,
        },
    };
    match digits {
        Some(digits) if has_unknown(&digits) => py.get_type::<PyInt>().call1((resolve(py, name, &digits)?, 2)),
        Some(digits) => py.get_type::<PyInt>().call1((digits, 2)),
        None => value.call_method0("__index__"),
    }
}

/// Some bits of a signal.
///
/// >>> dut.leds[2].value = 1
/// >>> dut.bus[7:4].value
/// >>> await RisingEdge(dut.leds[2])
#[pyclass(frozen, module = "hoverlock._core")]
pub struct Bits {
    pub(super) handle: Py<Handle>,
    pub(super) low: u32,
    pub(super) width: u32,
    pub(super) signed: bool,
    /// The field of a packed structure that they are, else empty.
    pub(super) field: String,
}

impl Bits {
    /// The signal and the position of a single bit.
    pub fn single(&self, py: Python<'_>, what: &str) -> PyResult<(Py<Handle>, u8)> {
        let handle = self.handle.bind(py).get();
        match u8::try_from(self.low) {
            Ok(at) if self.width == 1 && handle.width() <= 64 => Ok((self.handle.clone_ref(py), at)),
            _ => Err(PyTypeError::new_err(format!(
                "{what} takes a signal, or one bit of at most 64, not {}: use ValueChange of the signal",
                self.__repr__(py)
            ))),
        }
    }
}

#[pymethods]
impl Bits {
    /// The value of these bits. A write leaves the signal's other bits as they are, or as they were written before.
    #[getter]
    fn get_value(&self, py: Python<'_>) -> PyResult<Value> {
        let part = self.handle.bind(py).get().get_value(py)?.get().part(self.low, self.width);
        Ok(Value { signed: self.signed, ..part })
    }

    #[setter]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let handle = self.handle.bind(value.py()).get();
        match Change::of(value)? {
            Some(change) => handle.change(&change, self.low, self.width),
            None => handle.write_bits(value, self.low, self.width),
        }
    }

    /// A field of the structure that these bits are.
    fn __getattr__(&self, py: Python<'_>, name: &str) -> PyResult<Bits> {
        let below = if self.field.is_empty() { "[]" } else { &self.field };
        Handle::field(self.handle.bind(py), below, name)
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
