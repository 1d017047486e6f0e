//! Handles of ports, internals and memories, and the values read from them.

use std::sync::atomic::{AtomicU64, Ordering};

use hoverlock_harness::model::{Direction, SignalId, SignalInfo, Storage};
use hoverlock_harness::sim::{Dut, Memory, Signal, Wide};
use numpy::PyArray1;
use pyo3::IntoPyObjectExt;
use pyo3::basic::CompareOp;
use pyo3::exceptions::{PyAttributeError, PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyInt, PyIterator, PyList, PySlice, PyString, PyTuple};

use crate::errors::{self, RangeError};
use crate::on_thread::OnThread;
use crate::trigger::{FallingEdge, RisingEdge, ValueChange};

enum Access {
    Word(Signal),
    Wide(Wide),
}

/// A port or an internal signal.
///
/// >>> dut.enable.value = 1
/// >>> int(dut.count.value)
#[pyclass(frozen, module = "hoverlock", weakref)]
pub struct Handle {
    access: OnThread<Access>,
    info: OnThread<SignalInfo>,
    id: SignalId,
    width: u32,
    pub rising: PyOnceLock<Py<RisingEdge>>,
    pub falling: PyOnceLock<Py<FallingEdge>>,
    pub change: PyOnceLock<Py<ValueChange>>,
    spare: PyOnceLock<Py<Value>>,
}

impl Handle {
    pub fn new(dut: &Dut, info: SignalInfo) -> PyResult<Handle> {
        let (access, id) = if matches!(info.storage, Storage::Wide(_)) {
            let wide = dut.wide(&info.name).map_err(|e| errors::of_model(&e))?;
            let id = wide.id();
            (Access::Wide(wide), id)
        } else {
            let signal = dut.signal(&info.name).map_err(|e| errors::of_model(&e))?;
            let id = signal.id();
            (Access::Word(signal), id)
        };
        let width = info.width;
        let (rising, falling, change) = (PyOnceLock::new(), PyOnceLock::new(), PyOnceLock::new());
        let (access, info) = (OnThread::new(access), OnThread::new(info));
        Ok(Handle { access, info, id, width, rising, falling, change, spare: PyOnceLock::new() })
    }

    pub fn id(&self) -> SignalId {
        self.id
    }

    pub fn name(&self) -> &str {
        &self.info.get().name
    }

    pub fn width(&self) -> u32 {
        self.width
    }

    #[cold]
    fn write_other(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        if let Ok(text) = value.cast::<PyString>() {
            let text = text.to_str()?;
            if let Ok(code) = self.info.get().value_of(text) {
                return self.write_int(code.into_bound_py_any(value.py())?.cast::<PyInt>()?);
            }
            return self.write_int(&self.parse_binary(value.py(), text)?);
        }
        match value.call_method0("__index__") {
            Ok(index) => self.write_int(index.cast::<PyInt>()?),
            Err(_) => Err(PyTypeError::new_err(format!(
                "'{}' takes a whole number, a binary string or an enumeration's name, not {}",
                self.info.get().name,
                value.repr()?
            ))),
        }
    }

    fn parse_binary<'py>(&self, py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyInt>> {
        let digits: String = text.chars().filter(|c| *c != '_').collect();
        if digits.len() != self.width as usize || !digits.chars().all(|c| c == '0' || c == '1') {
            let names: Vec<&str> = self.info.get().items.iter().map(|(name, _)| name.as_str()).collect();
            let names = if names.is_empty() { String::new() } else { format!(", or one of {}", names.join(", ")) };
            return Err(PyValueError::new_err(format!(
                "'{text}' is not a value of '{}': {} digits 0 and 1 are wanted{names} (Verilator has no X and no Z)",
                self.info.get().name,
                self.width
            )));
        }
        Ok(py.get_type::<PyInt>().call1((digits, 2))?.cast_into::<PyInt>()?)
    }

    fn write_int(&self, value: &Bound<'_, PyInt>) -> PyResult<()> {
        match self.access.get() {
            Access::Word(signal) => match value.extract::<u64>() {
                Ok(word) => signal.set(word),
                Err(_) => match value.extract::<i64>() {
                    Ok(word) => signal.set_signed(word),
                    Err(_) => return Err(self.out_of_range(value)),
                },
            }
            .map_err(|e| errors::of_model(&e)),
            Access::Wide(wide) => {
                let py = value.py();
                let negative = value.lt(0)?;
                let value = if negative { value.add(self.modulus(py)?)? } else { value.clone().into_any() };
                let half = value.rshift(self.width - 1)?.is_truthy()?;
                if value.lt(0)? || value.rshift(self.width)?.is_truthy()? || (negative && !half) {
                    return Err(self.out_of_range(&value));
                }
                let bytes = self.width.div_ceil(32) as usize * 4;
                let bytes: Vec<u8> = value.call_method1("to_bytes", (bytes, "little"))?.extract()?;
                let words: Vec<u32> = bytes.as_chunks::<4>().0.iter().map(|w| u32::from_le_bytes(*w)).collect();
                wide.set(&words).map_err(|e| errors::of_model(&e))
            }
        }
    }

    fn modulus<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        1u32.into_bound_py_any(py)?.lshift(self.width)
    }

    fn out_of_range(&self, value: &Bound<'_, PyAny>) -> PyErr {
        RangeError::new_err(format!(
            "{value} does not fit '{}', which is {} bits wide",
            self.info.get().name,
            self.width
        ))
    }
}

#[pymethods]
impl Handle {
    /// The value now; written, it is put when all tasks of this round have run.
    #[getter]
    #[inline]
    fn get_value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Value>> {
        let bits = match self.access.get() {
            Access::Word(signal) => {
                let word = signal.get();
                // Most values are looked at and dropped: one that nobody else holds serves again, which halves a read.
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
        let value = Bound::new(py, Value { bits, width: self.width, signed: self.info.get().signed })?;
        // The first is kept; if it stays in use elsewhere, reads make new ones.
        let _ = self.spare.set(py, value.clone().unbind());
        Ok(value)
    }

    #[setter]
    #[inline]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        if let Access::Word(signal) = self.access.get()
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

    /// As assigning to `value`.
    fn set(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(value)
    }

    /// As reading `value`.
    fn get<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Value>> {
        self.get_value(py)
    }

    /// As assigning to `value`: a model in this process knows no write that is more immediate.
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

    /// Its name below the top module.
    #[getter]
    fn _name(&self) -> &str {
        &self.info.get().name
    }

    /// Its name below the top module.
    #[getter]
    fn _path(&self) -> &str {
        &self.info.get().name
    }

    /// A logger by its name.
    #[getter]
    fn _log<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("hoverlock.log")?.getattr("log")?.call_method1("getChild", (self.name(),))
    }

    /// `input`, `output`, `inout` or `internal`.
    #[getter]
    fn direction(&self) -> &'static str {
        direction_name(self.info.get().direction)
    }

    /// Whether its Verilog type is signed.
    #[getter]
    fn is_signed(&self) -> bool {
        self.info.get().signed
    }

    /// The name of its value, if its type is an enumeration that has it.
    #[getter]
    fn value_name(&self) -> Option<&str> {
        match self.access.get() {
            Access::Word(signal) => self.info.get().item(signal.get()),
            Access::Wide(_) => None,
        }
    }

    fn __len__(&self) -> usize {
        self.width as usize
    }

    /// `dut.bus[3]` is a bit, `dut.bus[7:4]` several, to be read and written; they have no edges of their own.
    fn __getitem__(slf: &Bound<'_, Self>, index: &Bound<'_, PyAny>) -> PyResult<Bits> {
        let (low, width) = span(index, slf.get().width)?;
        Ok(Bits { handle: slf.clone().unbind(), low, width })
    }

    /// Compares its value, except with another handle: with that, whether they are one. `dut.bus <= 3` is cocotb 1's
    /// old way to write.
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
        format!("<{} {} [{}:0]>", direction_name(self.info.get().direction), self.info.get().name, self.width - 1)
    }
}

/// The number of an `int` (or `bool`) that fits 64 bits; shorter than pyo3's way, which looks for `__index__` first.
#[inline]
fn word_of(value: &Bound<'_, PyAny>) -> Option<u64> {
    let whole = value.cast::<PyInt>().ok()?;
    // SAFETY: a live `int`, and the interpreter's lock is held.
    unsafe {
        let word = pyo3::ffi::PyLong_AsUnsignedLongLong(whole.as_ptr());
        if word == u64::MAX && !pyo3::ffi::PyErr_Occurred().is_null() {
            pyo3::ffi::PyErr_Clear();
            return None;
        }
        Some(word)
    }
}

pub fn direction_name(direction: Direction) -> &'static str {
    match direction {
        Direction::Input => "input",
        Direction::Output => "output",
        Direction::Inout => "inout",
        Direction::Internal => "internal",
    }
}

/// Atomic only so that the object may be shared; see `Handle::get_value` for when it is written.
enum Stored {
    Word(AtomicU64),
    Wide(Box<[u32]>),
}

impl Stored {
    fn word(word: u64) -> Stored {
        Stored::Word(AtomicU64::new(word))
    }
}

/// A value read from a signal: a whole number that knows its width. Compares and calculates as its unsigned number.
///
/// >>> dut.count.value + 1
/// >>> dut.data.value[7:4].binstr
#[pyclass(module = "hoverlock", frozen)]
pub struct Value {
    bits: Stored,
    width: u32,
    signed: bool,
}

impl Value {
    #[inline]
    fn int<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match &self.bits {
            Stored::Word(word) => word.load(Ordering::Relaxed).into_bound_py_any(py),
            Stored::Wide(words) => {
                let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
                py.get_type::<PyInt>().call_method1("from_bytes", (bytes.as_slice(), "little"))
            }
        }
    }

    fn bit(&self, at: u32) -> u32 {
        match &self.bits {
            Stored::Word(word) => (word.load(Ordering::Relaxed) >> at & 1) as u32,
            Stored::Wide(words) => words[(at / 32) as usize] >> (at % 32) & 1,
        }
    }

    /// Some of its bits as a value of their own.
    fn part(&self, low: u32, width: u32) -> Value {
        if let Stored::Word(word) = &self.bits {
            let word = word.load(Ordering::Relaxed);
            let mask = if width >= 64 { u64::MAX } else { (1 << width) - 1 };
            return Value { bits: Stored::word(word >> low & mask), width, signed: false };
        }
        let bits = if width <= 64 {
            Stored::word((0..width).fold(0, |value, b| value | u64::from(self.bit(low + b)) << b))
        } else {
            let mut words = vec![0u32; width.div_ceil(32) as usize];
            for b in 0..width {
                words[(b / 32) as usize] |= self.bit(low + b) << (b % 32);
            }
            Stored::Wide(words.into_boxed_slice())
        };
        Value { bits, width, signed: false }
    }
}

#[pymethods]
impl Value {
    #[inline]
    fn __int__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    fn __index__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    #[inline]
    fn __bool__(&self) -> bool {
        match &self.bits {
            Stored::Word(word) => word.load(Ordering::Relaxed) != 0,
            Stored::Wide(words) => words.iter().any(|w| *w != 0),
        }
    }

    #[inline]
    fn __richcmp__<'py>(&self, other: &Bound<'py, PyAny>, op: CompareOp) -> PyResult<Bound<'py, PyAny>> {
        let py = other.py();
        if let Stored::Word(word) = &self.bits
            && let Some(whole) = word_of(other)
        {
            return op.matches(word.load(Ordering::Relaxed).cmp(&whole)).into_bound_py_any(py);
        }
        if let Ok(text) = other.cast::<PyString>() {
            return self.binstr().into_bound_py_any(py)?.rich_compare(text, op);
        }
        if let Ok(value) = other.cast::<Value>() {
            return self.int(py)?.rich_compare(value.get_int(py)?, op);
        }
        self.int(py)?.rich_compare(other, op)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.int(py)?.hash()
    }

    fn __len__(&self) -> usize {
        self.width as usize
    }

    /// Bit by bit, highest first, as the digits are written.
    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let value = slf.get();
        let bits = (0..value.width).rev().map(|at| value.part(at, 1));
        PyList::new(slf.py(), bits.map(|v| Bound::new(slf.py(), v)).collect::<PyResult<Vec<_>>>()?)?.try_iter()
    }

    fn __reversed__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let value = slf.get();
        let bits = (0..value.width).map(|at| value.part(at, 1));
        PyList::new(slf.py(), bits.map(|v| Bound::new(slf.py(), v)).collect::<PyResult<Vec<_>>>()?)?.try_iter()
    }

    /// `value[3]` is bit 3, `value[7:0]` the lowest eight, as in Verilog.
    fn __getitem__(&self, index: &Bound<'_, PyAny>) -> PyResult<Value> {
        let (low, width) = span(index, self.width)?;
        Ok(self.part(low, width))
    }

    /// The unsigned number.
    #[getter]
    fn integer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    /// The number in two's complement.
    #[getter]
    fn signed_integer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let whole = self.int(py)?;
        if self.width > 0 && self.bit(self.width - 1) == 1 {
            whole.sub(1u32.into_bound_py_any(py)?.lshift(self.width)?)
        } else {
            Ok(whole)
        }
    }

    /// The unsigned number, by cocotb 2's name.
    fn to_unsigned<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    /// The number in two's complement, by cocotb 2's name.
    fn to_signed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.signed_integer(py)
    }

    /// Its digits, highest first.
    #[getter]
    fn binstr(&self) -> String {
        (0..self.width).rev().map(|at| if self.bit(at) == 1 { '1' } else { '0' }).collect()
    }

    /// Always: Verilator has two states.
    #[getter]
    fn is_resolvable(&self) -> bool {
        true
    }

    /// Bits.
    #[getter]
    fn n_bits(&self) -> u32 {
        self.width
    }

    /// Its bytes, highest first.
    #[getter]
    fn buff<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)?.call_method1("to_bytes", (self.width.div_ceil(8), "big"))
    }

    /// Its bytes: `"big"` or `"little"` end first.
    #[pyo3(signature = (byteorder = "big"))]
    fn to_bytes<'py>(&self, py: Python<'py>, byteorder: &str) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)?.call_method1("to_bytes", (self.width.div_ceil(8), byteorder))
    }

    /// The value itself: what cocotb 1's handles called it.
    fn get_value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    fn __str__(&self) -> String {
        self.binstr()
    }

    fn __format__<'py>(&self, py: Python<'py>, spec: &str) -> PyResult<Bound<'py, PyAny>> {
        if spec.is_empty() {
            return self.binstr().into_bound_py_any(py);
        }
        self.int(py)?.call_method1("__format__", (spec,))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("{}'d{}", self.width, self.int(py)?))
    }

    // What it calculates is a plain whole number, of any size.

    fn __add__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.add(other)
    }

    fn __radd__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.add(self.int(other.py())?)
    }

    fn __sub__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.sub(other)
    }

    fn __rsub__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.sub(self.int(other.py())?)
    }

    fn __mul__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.mul(other)
    }

    fn __rmul__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.mul(self.int(other.py())?)
    }

    fn __truediv__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.div(other)
    }

    fn __rtruediv__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.div(self.int(other.py())?)
    }

    fn __floordiv__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.floor_div(other)
    }

    fn __rfloordiv__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.floor_div(self.int(other.py())?)
    }

    fn __mod__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.rem(other)
    }

    fn __rmod__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.rem(self.int(other.py())?)
    }

    fn __and__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.bitand(other)
    }

    fn __rand__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.bitand(self.int(other.py())?)
    }

    fn __or__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.bitor(other)
    }

    fn __ror__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.bitor(self.int(other.py())?)
    }

    fn __xor__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.bitxor(other)
    }

    fn __rxor__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.bitxor(self.int(other.py())?)
    }

    fn __lshift__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.lshift(other)
    }

    fn __rlshift__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.lshift(self.int(other.py())?)
    }

    fn __rshift__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.rshift(other)
    }

    fn __rrshift__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        other.rshift(self.int(other.py())?)
    }

    fn __pow__<'py>(&self, other: &Bound<'py, PyAny>, modulus: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.pow(other, modulus)
    }

    fn __neg__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)?.neg()
    }

    fn __abs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    fn __divmod__<'py>(&self, other: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.int(other.py())?.divmod(other)
    }

    fn __invert__(&self) -> Value {
        let bits = match &self.bits {
            Stored::Word(word) => {
                Stored::word(!word.load(Ordering::Relaxed) & (u64::MAX >> (64 - self.width.clamp(1, 64))))
            }
            Stored::Wide(words) => {
                let mut words: Vec<u32> = words.iter().map(|w| !w).collect();
                if !self.width.is_multiple_of(32)
                    && let Some(top) = words.last_mut()
                {
                    *top &= (1 << (self.width % 32)) - 1;
                }
                Stored::Wide(words.into_boxed_slice())
            }
        };
        Value { bits, width: self.width, signed: self.signed }
    }
}

/// The bits that an index names: `[3]` one, `[7:4]` several, higher bit first, as in Verilog.
fn span(index: &Bound<'_, PyAny>, of_width: u32) -> PyResult<(u32, u32)> {
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
    handle: Py<Handle>,
    low: u32,
    width: u32,
}

#[pymethods]
impl Bits {
    /// Their value; written, the other bits keep what they have or what was written to them before.
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
        let whole = Value { bits: whole, width: handle.width, signed: false }.int(py)?;
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

trait ReadInt<'py> {
    fn get_int(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>>;
}

impl<'py> ReadInt<'py> for Bound<'py, Value> {
    fn get_int(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.borrow().int(py)
    }
}

/// A memory, or a port that is an array.
///
/// >>> dut.u_ram.cells[5].value = 7
/// >>> dut.u_ram.cells.value = program
/// >>> numpy.asarray(dut.u_ram.cells)
#[pyclass(unsendable, module = "hoverlock", weakref)]
pub struct ArrayHandle {
    memory: Memory,
    info: SignalInfo,
}

impl ArrayHandle {
    pub fn new(dut: &Dut, info: SignalInfo) -> PyResult<ArrayHandle> {
        let memory = dut.memory(&info.name).map_err(|e| errors::of_model(&e))?;
        Ok(ArrayHandle { memory, info })
    }

    /// The index on the left and that on the right, as declared.
    fn ends(&self) -> (i64, i64) {
        self.info.range.unwrap_or((0, 0))
    }

    fn left_to_right(&self) -> Vec<u64> {
        let mut words = self.memory.to_vec();
        let (left, right) = self.ends();
        if left > right {
            words.reverse();
        }
        words
    }

    /// A value as an element holds it.
    fn encode(&self, value: &Bound<'_, PyAny>) -> PyResult<u64> {
        let (name, width) = (&self.info.name, self.info.width);
        let whole = match value.cast::<PyString>() {
            Ok(text) => value.py().get_type::<PyInt>().call1((text, 2)),
            Err(_) => value.call_method0("__index__"),
        };
        let whole = whole.map_err(|_| PyTypeError::new_err(format!("'{name}' takes whole numbers, not {value}")))?;
        if let Ok(word) = whole.extract::<u64>() {
            return Ok(word);
        }
        match whole.extract::<i64>() {
            Ok(word) if width >= 64 || word >= -(1 << (width - 1)) => Ok(word as u64 & self.info.mask()),
            _ => Err(RangeError::new_err(format!("{whole} does not fit '{name}', which is {width} bits wide"))),
        }
    }
}

#[pymethods]
impl ArrayHandle {
    /// The element at an index as declared in the Verilog.
    fn __getitem__(slf: &Bound<'_, Self>, index: i64) -> PyResult<Element> {
        let this = slf.borrow();
        let (a, b) = this.ends();
        if index < a.min(b) || index > a.max(b) {
            // What the engine says of it names memory and bounds.
            this.memory.get(index).map_err(|e| errors::of_model(&e))?;
        }
        Ok(Element { array: slf.clone().unbind(), index })
    }

    fn __len__(&self) -> usize {
        self.memory.len()
    }

    /// All elements, from left to right as declared: of `[0:15]` number 0 first, of `[15:0]` number 15.
    #[getter]
    fn get_value(&self) -> Vec<Value> {
        let value = |word| Value { bits: Stored::word(word), width: self.info.width, signed: self.info.signed };
        self.left_to_right().into_iter().map(value).collect()
    }

    /// Writes elements from the left on, such as a program.
    #[setter]
    fn set_value(&self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = values.try_iter()?.map(|v| self.encode(&v?)).collect::<PyResult<Vec<_>>>()?;
        if values.len() > self.memory.len() {
            return Err(PyIndexError::new_err(format!(
                "{} values for '{}', which has {} elements",
                values.len(),
                self.info.name,
                self.memory.len()
            )));
        }
        let (left, right) = self.ends();
        let step = if left <= right { 1 } else { -1 };
        let indices = (0..).map(|at| left + step * at);
        values
            .into_iter()
            .zip(indices)
            .try_for_each(|(word, index)| self.memory.set(index, word))
            .map_err(|e| errors::of_model(&e))
    }

    /// As assigning to `value`.
    fn setimmediatevalue(&self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(values)
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let (left, right) = slf.borrow().ends();
        let element = |index| Bound::new(slf.py(), Element { array: slf.clone().unbind(), index });
        let elements: PyResult<Vec<_>> = if left <= right {
            (left..=right).map(element).collect()
        } else {
            (right..=left).rev().map(element).collect()
        };
        PyList::new(slf.py(), elements?)?.try_iter()
    }

    /// For `numpy.asarray(dut.u_ram.cells)`: the elements from left to right.
    #[pyo3(signature = (dtype = None, copy = None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        // It is a copy always.
        let _ = copy;
        let array = PyArray1::from_vec(py, self.left_to_right()).into_any();
        dtype.filter(|d| !d.is_none()).map_or(Ok(array.clone()), |d| array.call_method1("astype", (d,)))
    }

    /// Its name below the top module.
    #[getter]
    fn _name(&self) -> &str {
        &self.info.name
    }

    /// `input`, `output`, `inout` or `internal`.
    #[getter]
    fn direction(&self) -> &'static str {
        direction_name(self.info.direction)
    }

    fn __repr__(&self) -> String {
        let (a, b) = self.ends();
        format!("<{} {} [{}:0] [{a}:{b}]>", direction_name(self.info.direction), self.info.name, self.info.width - 1)
    }
}

/// An element of a memory.
///
/// >>> dut.u_ram.cells[5].value = 7
#[pyclass(unsendable, module = "hoverlock")]
pub struct Element {
    array: Py<ArrayHandle>,
    index: i64,
}

#[pymethods]
impl Element {
    /// Its value; written, it is put when all tasks of this round have run.
    #[getter]
    fn get_value(&self, py: Python<'_>) -> PyResult<Value> {
        let array = self.array.borrow(py);
        let word = array.memory.get(self.index).map_err(|e| errors::of_model(&e))?;
        Ok(Value { bits: Stored::word(word), width: array.info.width, signed: array.info.signed })
    }

    #[setter]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let array = self.array.borrow(value.py());
        let word = array.encode(value)?;
        array.memory.set(self.index, word).map_err(|e| errors::of_model(&e))
    }

    /// As assigning to `value`.
    fn setimmediatevalue(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(value)
    }

    /// Bits.
    fn __len__(&self, py: Python<'_>) -> usize {
        self.array.borrow(py).info.width as usize
    }

    /// The memory's name and the index.
    #[getter]
    fn _name(&self, py: Python<'_>) -> String {
        format!("{}[{}]", self.array.borrow(py).info.name, self.index)
    }

    fn __int__(&self, py: Python<'_>) -> PyResult<u64> {
        self.array.borrow(py).memory.get(self.index).map_err(|e| errors::of_model(&e))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("<element {}[{}]>", self.array.borrow(py).info.name, self.index)
    }
}

/// Ports and internals of a simulation, by name, in the order of the Verilog.
pub fn all<'py>(py: Python<'py>, dut: &Dut) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for info in dut.signals() {
        let name = info.name.clone();
        if info.range.is_some() {
            if matches!(info.storage, Storage::Wide(_)) {
                continue;
            }
            list.append((name, Bound::new(py, ArrayHandle::new(dut, info)?)?))?;
        } else {
            list.append((name, Bound::new(py, Handle::new(dut, info)?)?))?;
        }
    }
    Ok(list)
}

/// A level of the hierarchy; its children stand in its dictionary, where reading them costs least. A name that is not
/// there is asked of `_missing`, which gives the exception.
#[pyclass(subclass, dict, module = "hoverlock._core")]
pub struct HierarchyBase {}

#[pymethods]
impl HierarchyBase {
    #[new]
    #[pyo3(signature = (*_arguments))]
    fn new(_arguments: &Bound<'_, PyTuple>) -> HierarchyBase {
        HierarchyBase {}
    }

    fn __getattr__(slf: &Bound<'_, Self>, name: &str) -> PyResult<Py<PyAny>> {
        if name.starts_with('_') {
            return Err(PyAttributeError::new_err(format!("no attribute '{name}'")));
        }
        Err(PyErr::from_value(slf.call_method1("_missing", (name,))?))
    }
}
