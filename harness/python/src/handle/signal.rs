//! The handle of a signal: a port or an internal signal.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use hoverlock_harness::build::{EnumItems, Field};
use hoverlock_harness::model::{Direction, SignalId, SignalInfo, Storage};
use hoverlock_harness::sim::{Dut, Signal, Wide};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyInt, PyString};

use super::forcing::Change;
use super::number::{has_unknown, number_of, resolve, word_of, words_of_int};
use super::value::{Stored, Value};
use crate::errors::{self, RangeError};
use crate::on_thread::OnThread;
use crate::wait::{FallingEdge, RisingEdge, ValueChange};

pub(super) enum Access {
    Word(Signal),
    Wide(Wide),
}

/// A port or an internal signal.
///
/// >>> dut.enable.value = 1
/// >>> int(dut.count.value)
#[pyclass(frozen, module = "hoverlock", weakref)]
pub struct Handle {
    pub(super) access: OnThread<Access>,
    dut: OnThread<Dut>,
    id: SignalId,
    pub(super) name: String,
    pub(super) top: Arc<str>,
    pub(super) direction: Direction,
    pub(super) width: u32,
    /// The indices of the leftmost and the rightmost bit, as declared.
    pub(super) range: (i64, i64),
    pub(super) signed: bool,
    pub(super) items: EnumItems,
    pub(super) fields: Vec<Field>,
    pub rising: PyOnceLock<Py<RisingEdge>>,
    pub falling: PyOnceLock<Py<FallingEdge>>,
    pub change: PyOnceLock<Py<ValueChange>>,
    spare: PyOnceLock<Py<Value>>,
}

impl Handle {
    pub fn new(dut: &Dut, top: &Arc<str>, info: SignalInfo) -> PyResult<Handle> {
        let (access, id) = if matches!(info.storage, Storage::Wide(_)) {
            let wide = dut.wide(&info.name).map_err(|e| errors::of_model(&e))?;
            let id = wide.id();
            (Access::Wide(wide), id)
        } else {
            let signal = dut.signal(&info.name).map_err(|e| errors::of_model(&e))?;
            let id = signal.id();
            (Access::Word(signal), id)
        };
        let SignalInfo { name, direction, width, bits: range, signed, items, fields, .. } = info;
        let (rising, falling, change) = (PyOnceLock::new(), PyOnceLock::new(), PyOnceLock::new());
        Ok(Handle {
            access: OnThread::new(access),
            dut: OnThread::new(dut.clone()),
            id,
            name,
            top: top.clone(),
            direction,
            width,
            range,
            signed,
            items,
            fields,
            rising,
            falling,
            change,
            spare: PyOnceLock::new(),
        })
    }

    pub fn id(&self) -> SignalId {
        self.id
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns an error on another thread than the simulation's.
    pub fn check_thread(&self) -> PyResult<()> {
        self.access.get().map(|_| ())
    }

    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the value.
    ///
    /// # Errors
    /// `SimulationError` on another thread than the simulation's.
    #[inline]
    pub fn read<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Value>> {
        let bits = match self.access.get()? {
            Access::Word(signal) => {
                let word = signal.get();
                // Most values are used once. An object without other references is reused, which halves the cost of a
                // read.
                if let Some(spare) = self.spare.get(py)
                    // SAFETY: a live object, and the interpreter's lock is held, so nobody else counts meanwhile.
                    && unsafe { pyo3::ffi::Py_REFCNT(spare.as_ptr()) } == 1
                    && let Stored::Word(old) = &spare.get().bits
                {
                    old.store(word, Ordering::Relaxed);
                    return Ok(spare.bind(py).clone());
                }
                Stored::word(word)
            }
            Access::Wide(wide) => Stored::Wide(wide.get().into_boxed_slice()),
        };
        let value = Bound::new(py, Value { bits, width: self.width, signed: self.signed })?;
        // The first object is kept for reuse; while it is referred to elsewhere, reads allocate new ones.
        let _ = self.spare.set(py, value.clone().unbind());
        Ok(value)
    }

    /// Writes an integer, binary digits, the name of an enumeration item, or a `Force`, `Freeze` or `Release`. The
    /// model takes it when all tasks of this round have run.
    ///
    /// # Errors
    /// `RangeError` if it does not fit, `TypeError` or `ValueError` if it is no value of the signal, `NotWritable` for
    /// outputs.
    #[inline]
    pub fn write(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        if let Access::Word(signal) = self.access.get()?
            && let Some(word) = word_of(value)
        {
            return signal.set(word).map_err(|e| errors::of_model(&e));
        }
        if let Ok(read) = value.cast::<Value>() {
            return self.write_int(read.borrow().int(value.py())?.cast::<PyInt>()?);
        }
        match value.cast::<PyInt>() {
            Ok(whole) => self.write_int(whole),
            Err(_) => self.write_other(value),
        }
    }

    /// Returns the declared index of the bit at a place counted from the right.
    pub fn index_at(&self, place: u32) -> i64 {
        let (left, right) = self.range;
        if left < right { right - i64::from(place) } else { right + i64::from(place) }
    }

    /// Forces, freezes or releases the `width` bits from `low` on.
    #[cold]
    pub(super) fn change(&self, change: &Change<'_>, low: u32, width: u32) -> PyResult<()> {
        if self.direction == Direction::Input {
            // Only the bench drives an input: its value stays until the next write.
            return match change {
                Change::Force(value) => self.write_bits(value, low, width),
                Change::Freeze | Change::Release => Ok(()),
            };
        }
        let forcing = self.dut.get()?.forcing(&self.name).map_err(|e| errors::of_model(&e))?;
        change.make(&forcing, &self.name, low, width)
    }

    /// Writes the `width` bits from `low` on; the others stay as they are.
    pub(super) fn write_bits(&self, value: &Bound<'_, PyAny>, low: u32, width: u32) -> PyResult<()> {
        let py = value.py();
        let given = number_of(value, &self.name)?;
        let one = 1u32.into_bound_py_any(py)?;
        let size = one.lshift(width)?;
        let given = if given.lt(0)? { given.add(&size)? } else { given };
        if given.lt(0)? || given.ge(&size)? {
            return Err(RangeError::new_err(format!("{value} does not fit {width} bits of '{}'", self.name)));
        }
        let (mask, given) = (size.sub(&one)?.lshift(low)?, given.lshift(low)?);
        match self.access.get()? {
            Access::Word(signal) => signal.set_bits(mask.extract()?, given.extract()?),
            Access::Wide(wide) => {
                let words = |number: &Bound<'_, PyAny>| -> PyResult<Vec<u32>> {
                    words_of_int(number.cast::<PyInt>()?, self.width)?.ok_or_else(|| self.out_of_range(number))
                };
                wide.set_bits(&words(&mask)?, &words(&given)?)
            }
        }
        .map_err(|e| errors::of_model(&e))
    }

    #[cold]
    fn write_other(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        if let Some(change) = Change::of(value)? {
            return self.change(&change, 0, self.width);
        }
        if let Ok(text) = value.cast::<PyString>() {
            let text = text.to_str()?;
            if let Some((_, code)) = self.items.iter().find(|(name, _)| name == text) {
                return self.write_int((*code).into_bound_py_any(value.py())?.cast::<PyInt>()?);
            }
            return self.write_int(&self.parse_binary(value.py(), text)?);
        }
        let py = value.py();
        if let Ok(deposited) = value.getattr(intern!(py, "_deposited")) {
            return self.write(&deposited);
        }
        // A `LogicArray` or a `Logic` with digits such as `X`.
        if let Ok(resolvable) = value.getattr(intern!(py, "is_resolvable"))
            && !resolvable.is_truthy()?
        {
            return self.write_int(&self.parse_binary(py, value.str()?.to_str()?)?);
        }
        match value.call_method0("__index__") {
            Ok(index) => self.write_int(index.cast::<PyInt>()?),
            Err(_) => Err(PyTypeError::new_err(format!(
                "'{}' takes an integer, a binary string or the name of an enumeration item, not {}",
                self.name,
                value.repr()?
            ))),
        }
    }

    fn parse_binary<'py>(&self, py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyInt>> {
        let mut digits: String = text.chars().filter(|c| *c != '_').collect();
        if self.direction == Direction::Inout {
            // `Z` is a bit that the bench does not drive; if the design does not drive it either, it reads 0.
            digits = digits.replace(['Z', 'z'], "0");
        }
        if digits.len() == self.width as usize && has_unknown(&digits) {
            digits = resolve(py, &self.name, &digits)?;
        }
        if digits.len() != self.width as usize || !digits.chars().all(|c| c == '0' || c == '1') {
            let names: Vec<&str> = self.items.iter().map(|(name, _)| name.as_str()).collect();
            let names = if names.is_empty() { String::new() } else { format!(", or one of {}", names.join(", ")) };
            return Err(PyValueError::new_err(format!(
                "'{text}' is not a value of '{}': {} digits 0 and 1 are expected{names} (Verilator has no X and no Z)",
                self.name, self.width
            )));
        }
        Ok(py.get_type::<PyInt>().call1((digits, 2))?.cast_into::<PyInt>()?)
    }

    pub(super) fn write_int(&self, value: &Bound<'_, PyInt>) -> PyResult<()> {
        match self.access.get()? {
            Access::Word(signal) => match value.extract::<u64>() {
                Ok(word) => signal.set(word),
                Err(_) => match value.extract::<i64>() {
                    Ok(word) => signal.set_signed(word),
                    Err(_) => return Err(self.out_of_range(value)),
                },
            }
            .map_err(|e| errors::of_model(&e)),
            Access::Wide(wide) => {
                let words = words_of_int(value, self.width)?.ok_or_else(|| self.out_of_range(value))?;
                wide.set(&words).map_err(|e| errors::of_model(&e))
            }
        }
    }

    fn out_of_range(&self, value: &Bound<'_, PyAny>) -> PyErr {
        RangeError::new_err(format!("{value} does not fit '{}', which is {} bits wide", self.name, self.width))
    }
}
