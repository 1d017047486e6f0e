//! Bits of a signal.

use pyo3::exceptions::{PyAttributeError, PyTypeError};
use pyo3::prelude::*;

use super::forcing::Change;
use super::signal::Handle;
use super::value::Value;

/// A bit or a range of bits of a signal, readable and writable like a signal.
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
    /// Path of the packed structure's field that these bits are; empty for other bits.
    pub(super) field: String,
}

impl Bits {
    /// Returns the signal and the place of a single bit, counted from the right.
    ///
    /// # Errors
    /// `TypeError` for several bits, or for a signal of more than 64; `what` is the class that the message names.
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
        let part = self.handle.bind(py).get().read(py)?.get().part(self.low, self.width);
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

    /// A field inside the structure that these bits are.
    fn __getattr__(&self, py: Python<'_>, name: &str) -> PyResult<Bits> {
        let below = if self.field.is_empty() { "[]" } else { &self.field };
        field(self.handle.bind(py), below, name)
    }

    fn __int__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.get_value(py)?.int(py)
    }

    fn __len__(&self) -> usize {
        self.width as usize
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let handle = self.handle.bind(py).get();
        format!("<{}[{}:{}]>", handle.name(), handle.index_at(self.low + self.width - 1), handle.index_at(self.low))
    }
}

/// Returns the field `name` of a packed structure; `below` is the field that contains it, empty for the whole signal.
///
/// # Errors
/// `AttributeError` with the names of the fields.
pub(super) fn field(signal: &Bound<'_, Handle>, below: &str, name: &str) -> PyResult<Bits> {
    let handle = signal.get();
    let path = if below.is_empty() { name.to_owned() } else { format!("{below}.{name}") };
    match handle.fields.iter().find(|field| field.name == path) {
        Some(field) => Ok(Bits {
            handle: signal.clone().unbind(),
            low: field.low,
            width: field.width,
            signed: field.signed,
            field: path,
        }),
        None => {
            let names: Vec<&str> = handle.fields.iter().map(|field| field.name.as_str()).collect();
            let fields =
                if names.is_empty() { String::new() } else { format!("; its fields are {}", names.join(", ")) };
            Err(PyAttributeError::new_err(format!("'{}' has no attribute '{path}'{fields}", handle.name)))
        }
    }
}
