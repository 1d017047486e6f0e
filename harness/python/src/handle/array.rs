//! Memories, and ports that are arrays.

use hoverlock_harness::model::SignalInfo;
use hoverlock_harness::sim::{Dut, Memory};
use numpy::PyArray1;
use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyInt, PyIterator, PyList, PyString};

use super::direction_name;
use super::value::{Stored, Value};
use crate::errors::{self, RangeError};

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

    /// A value in the encoding of an element.
    fn encode(&self, value: &Bound<'_, PyAny>) -> PyResult<u64> {
        let (name, width) = (&self.info.name, self.info.width);
        let whole = match value.cast::<PyString>() {
            Ok(text) => value.py().get_type::<PyInt>().call1((text, 2)),
            Err(_) => value.call_method0("__index__"),
        };
        let whole = whole.map_err(|_| PyTypeError::new_err(format!("'{name}' takes integers, not {value}")))?;
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
            // The engine's error names memory and bounds.
            this.memory.get(index).map_err(|e| errors::of_model(&e))?;
        }
        Ok(Element { array: slf.clone().unbind(), index })
    }

    fn __len__(&self) -> usize {
        self.memory.len()
    }

    /// All elements, from left to right as declared: `[0:15]` begins with element 0, `[15:0]` with element 15.
    #[getter]
    fn get_value(&self) -> Vec<Value> {
        let value = |word| Value { bits: Stored::word(word), width: self.info.width, signed: self.info.signed };
        self.left_to_right().into_iter().map(value).collect()
    }

    /// Writes elements, from the left on.
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

    /// The same as assigning to `value`.
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

    /// For `numpy.asarray(dut.u_ram.cells)`: the elements from left to right, as `uint64`.
    #[pyo3(signature = (dtype = None, copy = None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        // The result is always a copy.
        let _ = copy;
        let array = PyArray1::from_vec(py, self.left_to_right()).into_any();
        dtype.filter(|d| !d.is_none()).map_or(Ok(array.clone()), |d| array.call_method1("astype", (d,)))
    }

    /// The name below the top module.
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
    /// The value. A write is put when all tasks of this round have run.
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

    /// The same as assigning to `value`.
    fn setimmediatevalue(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(value)
    }

    /// The width in bits.
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
