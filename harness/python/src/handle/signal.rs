//! The handle of a signal: a port or an internal one.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use hoverlock_harness::build::{EnumItems, Field};
use hoverlock_harness::model::{Direction, SignalId, SignalInfo, Storage};
use hoverlock_harness::sim::{Dut, Signal, Wide};
use pyo3::IntoPyObjectExt;
use pyo3::basic::CompareOp;
use pyo3::exceptions::{PyAttributeError, PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyInt, PyString};

use super::bits::{Bits, number_of, span};
use super::forcing::Change;
use super::value::{Stored, Value, word_of, words_of_int};
use super::{direction_name, own_name, path};
use crate::errors::{self, RangeError};
use crate::on_thread::OnThread;
use crate::trigger::{FallingEdge, RisingEdge, ValueChange};

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
    name: String,
    top: Arc<str>,
    direction: Direction,
    width: u32,
    signed: bool,
    items: EnumItems,
    fields: Vec<Field>,
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
        let SignalInfo { name, direction, width, signed, items, fields, .. } = info;
        let (rising, falling, change) = (PyOnceLock::new(), PyOnceLock::new(), PyOnceLock::new());
        Ok(Handle {
            access: OnThread::new(access),
            dut: OnThread::new(dut.clone()),
            id,
            name,
            top: top.clone(),
            direction,
            width,
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

    /// An error on another thread than the simulation's.
    pub fn check_thread(&self) -> PyResult<()> {
        self.access.get().map(|_| ())
    }

    pub fn width(&self) -> u32 {
        self.width
    }

    /// The field of that name below another, if the type is a packed structure.
    pub(super) fn field(slf: &Bound<'_, Self>, below: &str, name: &str) -> PyResult<Bits> {
        let handle = slf.get();
        let path = if below.is_empty() { name.to_owned() } else { format!("{below}.{name}") };
        match handle.fields.iter().find(|field| field.name == path) {
            Some(field) => Ok(Bits {
                handle: slf.clone().unbind(),
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

    /// Forces, freezes or releases the `width` bits from `low` on.
    #[cold]
    pub(super) fn change(&self, change: &Change<'_>, low: u32, width: u32) -> PyResult<()> {
        if self.direction == Direction::Input {
            // Nothing but the bench drives it: its value stays until the next write.
            return match change {
                Change::Force(value) => self.write_bits(value, low, width),
                Change::Freeze | Change::Release => Ok(()),
            };
        }
        let forcing = self.dut.get()?.forcing(&self.name).map_err(|e| errors::of_model(&e))?;
        change.make(&forcing, &self.name, low, width)
    }

    /// Writes the `width` bits from `low` on; the others stay as they are, or as they were written before.
    pub(super) fn write_bits(&self, value: &Bound<'_, PyAny>, low: u32, width: u32) -> PyResult<()> {
        let py = value.py();
        let given = number_of(value, &self.name)?;
        let one = 1u32.into_bound_py_any(py)?;
        let size = one.lshift(width)?;
        let given = if given.lt(0)? { given.add(&size)? } else { given };
        if given.lt(0)? || given.ge(&size)? {
            return Err(RangeError::new_err(format!("{value} does not fit {width} bits of '{}'", self.name)));
        }
        let whole = match self.access.get()? {
            Access::Word(signal) => Stored::word(signal.get_pending()),
            Access::Wide(wide) => Stored::Wide(wide.get_pending().into_boxed_slice()),
        };
        let whole = Value { bits: whole, width: self.width, signed: false }.int(py)?;
        let mask = size.sub(&one)?.lshift(low)?;
        let kept = whole.sub(whole.bitand(&mask)?)?;
        self.write_int(kept.bitor(given.lshift(low)?)?.cast::<PyInt>()?)
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
        // A `LogicArray` or a `Logic` with digits that are no numbers.
        let py = value.py();
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
            // A bit that the bench lets go: where the design does not drive it either, it reads 0.
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

/// Whether there are digits among them that a signal here cannot have, and no others.
pub(super) fn has_unknown(digits: &str) -> bool {
    digits.chars().all(|c| "01XZUWLH-xzuwlh".contains(c)) && digits.contains(|c| c != '0' && c != '1')
}

/// Digits with `X`, `Z` and the like as digits 0 and 1, if the bench has asked for that.
pub(super) fn resolve(py: Python<'_>, name: &str, digits: &str) -> PyResult<String> {
    py.import("hoverlock.unknown")?.call_method1("resolve", (name, digits))?.extract()
}

#[pymethods]
impl Handle {
    /// The value. A write is put when all tasks of this round have run.
    #[getter]
    #[inline]
    pub fn get_value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Value>> {
        let bits = match self.access.get()? {
            Access::Word(signal) => {
                let word = signal.get();
                // Most values are used once: an object that nothing else refers to is reused, which halves the cost of
                // a read.
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

    #[setter]
    #[inline]
    pub fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
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

    /// The same as assigning to `value`.
    fn set(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(value)
    }

    /// The same as reading `value`.
    fn get<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Value>> {
        self.get_value(py)
    }

    /// The same as assigning to `value`: there is no more immediate write.
    fn setimmediatevalue(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(value)
    }

    /// `RisingEdge` of this signal.
    #[getter]
    fn rising_edge<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().get_type::<RisingEdge>().call1((slf,))
    }

    /// `FallingEdge` of this signal.
    #[getter]
    fn falling_edge<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().get_type::<FallingEdge>().call1((slf,))
    }

    /// `ValueChange` of this signal.
    #[getter]
    fn value_change<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().get_type::<ValueChange>().call1((slf,))
    }

    /// The signal's own name, without those of the instances it is in.
    #[getter]
    fn _name(&self) -> &str {
        own_name(&self.name)
    }

    /// The name from the top module on.
    #[getter]
    fn _path(&self) -> String {
        path(&self.top, &self.name)
    }

    /// The type, by cocotb's name.
    #[getter]
    fn _type(&self) -> &'static str {
        match (self.width, self.items.is_empty()) {
            (_, false) => "GPI_ENUM",
            (1, _) => "GPI_LOGIC",
            _ => "GPI_LOGIC_ARRAY",
        }
    }

    /// The highest and the lowest bit.
    #[getter]
    fn _range(&self) -> (u32, u32) {
        (self.width - 1, 0)
    }

    /// A logger with the name of the signal.
    #[getter]
    fn _log<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("hoverlock.log")?.getattr("log")?.call_method1("getChild", (self.name(),))
    }

    /// `input`, `output`, `inout` or `internal`.
    #[getter]
    fn direction(&self) -> &'static str {
        direction_name(self.direction)
    }

    /// Whether the Verilog type is signed.
    #[getter]
    fn is_signed(&self) -> bool {
        self.signed
    }

    /// The name of the value, if the type is an enumeration that has it; otherwise None.
    #[getter]
    fn value_name(&self) -> PyResult<Option<&str>> {
        Ok(match self.access.get()? {
            Access::Word(signal) => {
                let value = signal.get();
                self.items.iter().find(|(_, code)| *code == value).map(|(name, _)| name.as_str())
            }
            Access::Wide(_) => None,
        })
    }

    fn __len__(&self) -> usize {
        self.width as usize
    }

    /// `dut.bus[3]` is one bit, `dut.bus[7:4]` are several. They can be read and written, but not awaited.
    fn __getitem__(slf: &Bound<'_, Self>, index: &Bound<'_, PyAny>) -> PyResult<Bits> {
        let (low, width) = span(index, slf.get().width)?;
        Ok(Bits { handle: slf.clone().unbind(), low, width, signed: false, field: String::new() })
    }

    /// A field of a packed structure: `dut.beat.tag.value`. Those of structures in it follow with another dot.
    fn __getattr__(slf: &Bound<'_, Self>, name: &str) -> PyResult<Bits> {
        Handle::field(slf, "", name)
    }

    /// Compares the value; with another handle, whether both are the same. `dut.bus <= 3` writes, as in early cocotb 1.
    fn __richcmp__<'py>(
        slf: &Bound<'py, Self>,
        other: &Bound<'py, PyAny>,
        op: CompareOp,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let is_handle = other.is_instance_of::<Handle>();
        match op {
            CompareOp::Eq | CompareOp::Ne if is_handle || other.is_none() => {
                (slf.is(other) == matches!(op, CompareOp::Eq)).into_bound_py_any(py)
            }
            CompareOp::Eq | CompareOp::Ne => slf.get().get_value(py)?.into_any().rich_compare(other, op),
            CompareOp::Le => {
                slf.get().set_value(other)?;
                Ok(py.None().into_bound(py))
            }
            _ => Ok(py.NotImplemented().into_bound(py)),
        }
    }

    fn __hash__(slf: &Bound<'_, Self>) -> usize {
        slf.as_ptr() as usize >> 4
    }

    fn __int__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.get_value(py)?.get().int(py)
    }

    fn __repr__(&self) -> String {
        format!("<{} {} [{}:0]>", direction_name(self.direction), self.name, self.width - 1)
    }
}
