//! Values read from signals.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use pyo3::IntoPyObjectExt;
use pyo3::basic::CompareOp;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyList, PyString};

use super::number::{int_of_words, word_of};
use super::range::{span, span_from_left};

/// Whether positions in a value count from the left, as in cocotb 1.
static LEFT_FIRST: AtomicBool = AtomicBool::new(false);

/// Sets whether positions in a value count from the left.
#[pyfunction]
pub fn count_bits_from_left(yes: bool) {
    LEFT_FIRST.store(yes, Ordering::Relaxed);
}

/// The bits of a value. The word is atomic so that the object can be shared; `Handle::read` writes it only while there
/// is no other reference.
pub(super) enum Stored {
    Word(AtomicU64),
    Wide(Box<[u32]>),
}

impl Stored {
    pub fn word(word: u64) -> Stored {
        Stored::Word(AtomicU64::new(word))
    }
}

/// A value read from a signal: an integer with a width. It compares and calculates as an unsigned integer.
///
/// >>> dut.count.value + 1
/// >>> dut.data.value[7:4].binstr
#[pyclass(module = "hoverlock", frozen)]
pub struct Value {
    pub(super) bits: Stored,
    pub(super) width: u32,
    pub(super) signed: bool,
}

impl Value {
    #[inline]
    pub fn int<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match &self.bits {
            // The interpreter converts a signed number into an `int` faster than an unsigned one.
            Stored::Word(word) => match word.load(Ordering::Relaxed).cast_signed() {
                word @ 0.. => word.into_bound_py_any(py),
                word => word.cast_unsigned().into_bound_py_any(py),
            },
            Stored::Wide(words) => int_of_words(py, words),
        }
    }

    fn bit(&self, at: u32) -> u32 {
        match &self.bits {
            Stored::Word(word) => (word.load(Ordering::Relaxed) >> at & 1) as u32,
            Stored::Wide(words) => words[(at / 32) as usize] >> (at % 32) & 1,
        }
    }

    /// Returns `width` bits, of which `low` is the lowest, as a value.
    pub(super) fn part(&self, low: u32, width: u32) -> Value {
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
    /// Makes a value of binary digits (`type(dut.data.value)("0110")`), or of a whole number and its range or width, as
    /// cocotb's `LogicArray` and `BinaryValue` are made.
    ///
    /// # Errors
    /// `ValueError` for digits other than 0 and 1, `OverflowError` for a number that does not fit its width.
    #[new]
    #[pyo3(signature = (value, range = None))]
    fn new(value: &Bound<'_, PyAny>, range: Option<&Bound<'_, PyAny>>) -> PyResult<Value> {
        let kind = value.py().import("hoverlock.cocotb.types")?.getattr("LogicArray")?;
        let digits = kind.call1((value, range))?.str()?;
        let digits = digits.to_str()?;
        if digits.chars().any(|digit| digit != '0' && digit != '1') {
            return Err(PyValueError::new_err(format!(
                "'{digits}': the value of a signal has the digits 0 and 1 only"
            )));
        }
        let word_at = |end: usize| {
            let part = &digits.as_bytes()[end.saturating_sub(32)..end];
            part.iter().fold(0u32, |word, digit| word << 1 | u32::from(*digit == b'1'))
        };
        let words: Vec<u32> = (0..digits.len().div_ceil(32)).map(|at| word_at(digits.len() - 32 * at)).collect();
        let bits = match words[..] {
            [] => Stored::word(0),
            [low] => Stored::word(u64::from(low)),
            [low, high] => Stored::word(u64::from(high) << 32 | u64::from(low)),
            _ => Stored::Wide(words.into_boxed_slice()),
        };
        Ok(Value { bits, width: digits.len() as u32, signed: false })
    }

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
            return self.int(py)?.rich_compare(value.borrow().int(py)?, op);
        }
        self.int(py)?.rich_compare(other, op)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.int(py)?.hash()
    }

    /// The value itself, as it never changes.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    /// The value itself, as it never changes.
    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __len__(&self) -> usize {
        self.width as usize
    }

    /// The bits, highest first.
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

    /// `value[3]` is bit 3, `value[7:0]` the lowest eight, as in Verilog. With the version 1.9 of the alias,
    /// positions count from the left: `value[0]` is the highest bit, `value[0:7]` the highest eight.
    fn __getitem__(&self, index: &Bound<'_, PyAny>) -> PyResult<Value> {
        let (low, width) = if LEFT_FIRST.load(Ordering::Relaxed) {
            span_from_left(index, self.width)?
        } else {
            span(index, (i64::from(self.width) - 1, 0))?
        };
        Ok(self.part(low, width))
    }

    /// The value as an unsigned integer.
    #[getter]
    fn integer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    /// The value as a signed integer in two's complement.
    #[getter]
    fn signed_integer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let whole = self.int(py)?;
        if self.width > 0 && self.bit(self.width - 1) == 1 {
            whole.sub(1u32.into_bound_py_any(py)?.lshift(self.width)?)
        } else {
            Ok(whole)
        }
    }

    /// The value as an unsigned integer (cocotb 2's name).
    fn to_unsigned<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)
    }

    /// The value as a signed integer in two's complement (cocotb 2's name).
    fn to_signed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.signed_integer(py)
    }

    /// The binary digits, highest first.
    #[getter]
    fn binstr(&self) -> String {
        (0..self.width).rev().map(|at| if self.bit(at) == 1 { '1' } else { '0' }).collect()
    }

    /// Always true: Verilator has two states.
    #[getter]
    fn is_resolvable(&self) -> bool {
        true
    }

    /// The value itself: there is no digit to resolve. Of cocotb's `LogicArray`.
    #[pyo3(signature = (resolver = None))]
    fn resolve<'py>(slf: Bound<'py, Self>, resolver: Option<&Bound<'py, PyAny>>) -> Bound<'py, Self> {
        let _ = resolver;
        slf
    }

    /// The bits' positions, highest first.
    #[getter]
    fn range<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let kind = py.import("hoverlock.cocotb.types")?.getattr("Range")?;
        kind.call1((i64::from(self.width) - 1, "downto", 0))
    }

    /// The width in bits.
    #[getter]
    fn n_bits(&self) -> u32 {
        self.width
    }

    /// The bytes, highest first.
    #[getter]
    fn buff<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)?.call_method1("to_bytes", (self.width.div_ceil(8), "big"))
    }

    /// The bytes, highest (`"big"`) or lowest (`"little"`) first.
    #[pyo3(signature = (byteorder = "big"))]
    fn to_bytes<'py>(&self, py: Python<'py>, byteorder: &str) -> PyResult<Bound<'py, PyAny>> {
        self.int(py)?.call_method1("to_bytes", (self.width.div_ceil(8), byteorder))
    }

    /// The value as an unsigned integer (cocotb 1's name).
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

    // Arithmetic gives a plain `int`.

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
