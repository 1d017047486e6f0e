//! Memories, and ports that are arrays.

use std::sync::Arc;

use hoverlock_harness::model::{Direction, SignalInfo};
use hoverlock_harness::sim::{Dut, Memory};
use numpy::PyArray1;
use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyList};

use super::bits::number_of;
use super::direction_name;
use super::value::{Stored, Value};
use crate::errors::{self, RangeError};
use crate::on_thread::OnThread;

/// A memory, or a port that is an array.
///
/// >>> dut.u_ram.cells[5].value = 7
/// >>> dut.u_ram.cells.value = program
/// >>> numpy.asarray(dut.u_ram.cells)
#[pyclass(frozen, module = "hoverlock", weakref)]
pub struct ArrayHandle {
    memory: OnThread<Memory>,
    name: String,
    top: Arc<str>,
    direction: Direction,
    width: u32,
    signed: bool,
    /// The index on the left and that on the right, as declared.
    ends: (i64, i64),
}

impl ArrayHandle {
    pub fn new(dut: &Dut, top: &Arc<str>, info: SignalInfo) -> PyResult<ArrayHandle> {
        let memory = OnThread::new(dut.memory(&info.name).map_err(|e| errors::of_model(&e))?);
        let SignalInfo { name, direction, width, signed, range, .. } = info;
        Ok(ArrayHandle { memory, name, top: top.clone(), direction, width, signed, ends: range.unwrap_or((0, 0)) })
    }

    fn left_to_right(&self) -> PyResult<Vec<u64>> {
        let mut words = self.memory.get()?.to_vec();
        if self.ends.0 > self.ends.1 {
            words.reverse();
        }
        Ok(words)
    }

    /// A value in the encoding of an element.
    fn encode(&self, value: &Bound<'_, PyAny>) -> PyResult<u64> {
        let (name, width) = (&self.name, self.width);
        let whole = number_of(value, name)
            .map_err(|_| PyTypeError::new_err(format!("'{name}' takes integers, not {value}")))?;
        if let Ok(word) = whole.extract::<u64>() {
            return Ok(word);
        }
        match whole.extract::<i64>() {
            Ok(word) if width >= 64 || word >= -(1 << (width - 1)) => {
                Ok(word as u64 & (u64::MAX >> (64 - width.min(64))))
            }
            _ => Err(RangeError::new_err(format!("{whole} does not fit '{name}', which is {width} bits wide"))),
        }
    }
}

#[pymethods]
impl ArrayHandle {
    /// The element at an index as declared in the Verilog.
    fn __getitem__(slf: &Bound<'_, Self>, index: i64) -> PyResult<Element> {
        // The engine's error names memory and bounds.
        slf.get().memory.get()?.get(index).map_err(|e| errors::of_model(&e))?;
        Ok(Element { array: slf.clone().unbind(), index })
    }

    fn __len__(&self) -> usize {
        self.ends.0.abs_diff(self.ends.1) as usize + 1
    }

    /// All elements, from left to right as declared: `[0:15]` begins with element 0, `[15:0]` with element 15.
    #[getter]
    fn get_value(&self) -> PyResult<Vec<Value>> {
        let value = |word| Value { bits: Stored::word(word), width: self.width, signed: self.signed };
        Ok(self.left_to_right()?.into_iter().map(value).collect())
    }

    /// Writes elements, from the left on.
    #[setter]
    fn set_value(&self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = values.try_iter()?.map(|v| self.encode(&v?)).collect::<PyResult<Vec<_>>>()?;
        if values.len() > self.__len__() {
            return Err(PyIndexError::new_err(format!(
                "{} values for '{}', which has {} elements",
                values.len(),
                self.name,
                self.__len__()
            )));
        }
        let (left, right) = self.ends;
        let memory = self.memory.get()?;
        let step = if left <= right { 1 } else { -1 };
        let indices = (0..).map(|at| left + step * at);
        values
            .into_iter()
            .zip(indices)
            .try_for_each(|(word, index)| memory.set(index, word))
            .map_err(|e| errors::of_model(&e))
    }

    /// The same as assigning to `value`.
    fn setimmediatevalue(&self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(values)
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let (left, right) = slf.get().ends;
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
        let array = PyArray1::from_vec(py, self.left_to_right()?).into_any();
        dtype.filter(|d| !d.is_none()).map_or(Ok(array.clone()), |d| array.call_method1("astype", (d,)))
    }

    /// The memory's own name, without those of the instances it is in.
    #[getter]
    fn _name(&self) -> &str {
        self.name.rsplit('.').next().unwrap_or(&self.name)
    }

    /// The name from the top module on.
    #[getter]
    fn _path(&self) -> String {
        format!("{}.{}", self.top, self.name)
    }

    /// The type, by cocotb's name.
    #[getter]
    fn _type(&self) -> &'static str {
        "GPI_ARRAY"
    }

    /// The index on the left and that on the right, as declared.
    #[getter]
    fn _range(&self) -> (i64, i64) {
        self.ends
    }

    /// A logger with the name of the memory.
    #[getter]
    fn _log<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("hoverlock.log")?.getattr("log")?.call_method1("getChild", (&self.name,))
    }

    /// `input`, `output`, `inout` or `internal`.
    #[getter]
    fn direction(&self) -> &'static str {
        direction_name(self.direction)
    }

    fn __repr__(&self) -> String {
        let (a, b) = self.ends;
        format!("<{} {} [{}:0] [{a}:{b}]>", direction_name(self.direction), self.name, self.width - 1)
    }
}

/// An element of a memory.
///
/// >>> dut.u_ram.cells[5].value = 7
#[pyclass(frozen, module = "hoverlock")]
pub struct Element {
    array: Py<ArrayHandle>,
    index: i64,
}

#[pymethods]
impl Element {
    /// The value. A write is put when all tasks of this round have run.
    #[getter]
    fn get_value(&self) -> PyResult<Value> {
        let array = self.array.get();
        let word = array.memory.get()?.get(self.index).map_err(|e| errors::of_model(&e))?;
        Ok(Value { bits: Stored::word(word), width: array.width, signed: array.signed })
    }

    #[setter]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let array = self.array.get();
        let word = array.encode(value)?;
        array.memory.get()?.set(self.index, word).map_err(|e| errors::of_model(&e))
    }

    /// The same as assigning to `value`.
    fn setimmediatevalue(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(value)
    }

    /// The width in bits.
    fn __len__(&self) -> usize {
        self.array.get().width as usize
    }

    /// The memory's own name and the index.
    #[getter]
    fn _name(&self) -> String {
        format!("{}[{}]", self.array.get()._name(), self.index)
    }

    /// The name from the top module on, and the index.
    #[getter]
    fn _path(&self) -> String {
        format!("{}[{}]", self.array.get()._path(), self.index)
    }

    fn __int__(&self) -> PyResult<u64> {
        self.array.get().memory.get()?.get(self.index).map_err(|e| errors::of_model(&e))
    }

    fn __repr__(&self) -> String {
        format!("<element {}[{}]>", self.array.get().name, self.index)
    }
}
