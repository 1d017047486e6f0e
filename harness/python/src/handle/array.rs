//! Memories, and ports that are arrays, of any number of dimensions.

use std::sync::Arc;

use hoverlock_harness::model::{Direction, SignalInfo, Storage};
use hoverlock_harness::sim::{Dut, Memory};
use numpy::PyArray1;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyInt, PyIterator, PyList};

use super::names::{direction_name, own_name, path};
use super::number::{number_of, words_of_int};
use super::value::{Stored, Value};
use crate::errors::{self, RangeError};
use crate::on_thread::OnThread;

/// A memory, or a port that is an array. With several dimensions, `dut.rows[1]` is an array too.
///
/// >>> dut.u_ram.cells[5].value = 7
/// >>> dut.u_ram.cells.value = program
/// >>> numpy.asarray(dut.u_ram.cells)
/// >>> dut.rows[1][0].value
#[pyclass(frozen, module = "hoverlock", weakref)]
pub struct ArrayHandle {
    memory: OnThread<Memory>,
    name: String,
    top: Arc<str>,
    direction: Direction,
    width: u32,
    signed: bool,
    wide: bool,
    real: bool,
    /// The declared left and right index of each dimension, this array's own first.
    dimensions: Vec<(i64, i64)>,
    /// Index, in the memory, of the element with the lowest indices.
    base: i64,
}

fn length(ends: (i64, i64)) -> i64 {
    ends.0.abs_diff(ends.1) as i64 + 1
}

impl ArrayHandle {
    pub fn new(dut: &Dut, top: &Arc<str>, info: SignalInfo) -> PyResult<ArrayHandle> {
        let memory = OnThread::new(dut.memory(&info.name).map_err(|e| errors::of_model(&e))?);
        let SignalInfo { name, direction, width, signed, range, storage, real, mut dimensions, .. } = info;
        let (left, right) = range.unwrap_or((0, 0));
        if dimensions.is_empty() {
            dimensions.push((left, right));
        }
        let wide = matches!(storage, Storage::Wide(_));
        Ok(ArrayHandle {
            memory,
            name,
            top: top.clone(),
            direction,
            width,
            signed,
            wide,
            real,
            dimensions,
            base: left.min(right),
        })
    }

    fn ends(&self) -> (i64, i64) {
        self.dimensions[0]
    }

    /// Returns the indices from left to right, as declared.
    fn indices(&self) -> Vec<i64> {
        let (left, right) = self.ends();
        if left <= right { (left..=right).collect() } else { (right..=left).rev().collect() }
    }

    /// Converts an index of this dimension into an index of the memory.
    fn flat(&self, index: i64) -> PyResult<i64> {
        let (left, right) = self.ends();
        let (low, high) = (left.min(right), left.max(right));
        if index < low || index > high {
            let text = format!("address {index} is outside of '{}', which has {low} to {high}", self.name);
            return Err(PyIndexError::new_err(text));
        }
        let stride: i64 = self.dimensions[1..].iter().map(|ends| length(*ends)).product();
        Ok(self.base + (index - low) * stride)
    }

    /// Returns the array at an index; for arrays of several dimensions.
    fn row(&self, index: i64) -> PyResult<ArrayHandle> {
        Ok(ArrayHandle {
            memory: OnThread::new(self.memory.get()?.clone()),
            name: format!("{}[{index}]", self.name),
            top: self.top.clone(),
            direction: self.direction,
            width: self.width,
            signed: self.signed,
            wide: self.wide,
            real: self.real,
            dimensions: self.dimensions[1..].to_vec(),
            base: self.flat(index)?,
        })
    }

    fn read(&self, flat: i64) -> PyResult<Value> {
        let memory = self.memory.get()?;
        let bits = if self.wide {
            Stored::Wide(memory.get_words(flat).map_err(|e| errors::of_model(&e))?.into_boxed_slice())
        } else {
            Stored::word(memory.get(flat).map_err(|e| errors::of_model(&e))?)
        };
        Ok(Value { bits, width: self.width, signed: self.signed })
    }

    /// Returns a `Value`, or a `float` for a `real`.
    fn element<'py>(&self, py: Python<'py>, flat: i64) -> PyResult<Bound<'py, PyAny>> {
        if self.real {
            let value = self.memory.get()?.get_real(flat).map_err(|e| errors::of_model(&e))?;
            return value.into_bound_py_any(py);
        }
        self.read(flat)?.into_bound_py_any(py)
    }

    fn write(&self, flat: i64, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let memory = self.memory.get()?;
        if self.real {
            let text = || PyTypeError::new_err(format!("'{}' takes numbers, not {value}", self.name));
            let value = value.extract::<f64>().map_err(|_| text())?;
            return memory.set_real(flat, value).map_err(|e| errors::of_model(&e));
        }
        let (name, width) = (&self.name, self.width);
        let whole = number_of(value, name)
            .map_err(|_| PyTypeError::new_err(format!("'{name}' takes integers, not {value}")))?;
        let unfit = || RangeError::new_err(format!("{whole} does not fit '{name}', which is {width} bits wide"));
        if self.wide {
            let words = words_of_int(whole.cast::<PyInt>()?, width)?.ok_or_else(unfit)?;
            return memory.set_words(flat, &words).map_err(|e| errors::of_model(&e));
        }
        let word = match (whole.extract::<u64>(), whole.extract::<i64>()) {
            (Ok(word), _) => word,
            (_, Ok(word)) if width >= 64 || word >= -(1 << (width - 1)) => {
                word as u64 & (u64::MAX >> (64 - width.min(64)))
            }
            _ => return Err(unfit()),
        };
        memory.set(flat, word).map_err(|e| errors::of_model(&e))
    }

    /// Returns the memory indices of all elements, from left to right as declared.
    fn all(&self) -> PyResult<Vec<i64>> {
        if self.dimensions.len() == 1 {
            return self.indices().into_iter().map(|index| self.flat(index)).collect();
        }
        let mut found = Vec::new();
        for index in self.indices() {
            found.extend(self.row(index)?.all()?);
        }
        Ok(found)
    }
}

#[pymethods]
impl ArrayHandle {
    /// The element, or the array, at an index as declared in the Verilog.
    fn __getitem__<'py>(slf: &Bound<'py, Self>, index: i64) -> PyResult<Bound<'py, PyAny>> {
        if slf.get().dimensions.len() > 1 {
            return slf.get().row(index)?.into_bound_py_any(slf.py());
        }
        slf.get().memory.get()?;
        let flat = slf.get().flat(index)?;
        Element { array: slf.clone().unbind(), index, flat }.into_bound_py_any(slf.py())
    }

    fn __len__(&self) -> usize {
        length(self.ends()) as usize
    }

    /// All elements, from left to right as declared: `[0:15]` begins with element 0, `[15:0]` with element 15. With
    /// several dimensions, a list of lists.
    #[getter]
    fn get_value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for index in self.indices() {
            if self.dimensions.len() > 1 {
                list.append(self.row(index)?.get_value(py)?)?;
            } else {
                list.append(self.element(py, self.flat(index)?)?)?;
            }
        }
        Ok(list)
    }

    /// Writes elements, from the left.
    #[setter]
    fn set_value(&self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        let values = values.try_iter()?.collect::<PyResult<Vec<_>>>()?;
        if values.len() > self.__len__() {
            return Err(PyIndexError::new_err(format!(
                "{} values for '{}', which has {} elements",
                values.len(),
                self.name,
                self.__len__()
            )));
        }
        for (index, value) in self.indices().into_iter().zip(&values) {
            if self.dimensions.len() > 1 {
                self.row(index)?.set_value(value)?;
            } else {
                self.write(self.flat(index)?, value)?;
            }
        }
        Ok(())
    }

    /// The same as assigning to `value`.
    fn setimmediatevalue(&self, values: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set_value(values)
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        let elements = slf.get().indices().into_iter().map(|index| Self::__getitem__(slf, index));
        PyList::new(slf.py(), elements.collect::<PyResult<Vec<_>>>()?)?.try_iter()
    }

    /// For `numpy.asarray(dut.u_ram.cells)`: the elements from left to right, as `uint64`; wider ones as `object`,
    /// `real`s as `float64`.
    #[pyo3(signature = (dtype = None, copy = None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        // The result is always a copy.
        let _ = copy;
        let all = self.all()?;
        let array = if self.real {
            let memory = self.memory.get()?;
            let values = all.iter().map(|at| memory.get_real(*at).map_err(|e| errors::of_model(&e)));
            PyArray1::from_vec(py, values.collect::<PyResult<Vec<f64>>>()?).into_any()
        } else if self.wide {
            let values = all.iter().map(|at| self.read(*at)?.int(py)).collect::<PyResult<Vec<_>>>()?;
            py.import("numpy")?.call_method1("array", (values, "object"))?
        } else {
            let memory = self.memory.get()?;
            let words = all.iter().map(|at| memory.get(*at).map_err(|e| errors::of_model(&e)));
            PyArray1::from_vec(py, words.collect::<PyResult<Vec<u64>>>()?).into_any()
        };
        let shape: Vec<i64> = self.dimensions.iter().map(|ends| length(*ends)).collect();
        let array = array.call_method1("reshape", (shape,))?;
        dtype.filter(|d| !d.is_none()).map_or(Ok(array.clone()), |d| array.call_method1("astype", (d,)))
    }

    /// The memory's own name, without the names of the instances that contain it.
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
        "GPI_ARRAY"
    }

    /// The left and the right index, as declared.
    #[getter]
    fn _range(&self) -> (i64, i64) {
        self.ends()
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
        let bounds: String = self.dimensions.iter().map(|(a, b)| format!("[{a}:{b}]")).collect();
        let kind = if self.real { "real".to_owned() } else { format!("[{}:0]", self.width - 1) };
        format!("<{} {} {kind} {bounds}>", direction_name(self.direction), self.name)
    }
}

/// An element of a memory.
///
/// >>> dut.u_ram.cells[5].value = 7
#[pyclass(frozen, module = "hoverlock")]
pub struct Element {
    array: Py<ArrayHandle>,
    index: i64,
    /// Index of the element in the memory.
    flat: i64,
}

#[pymethods]
impl Element {
    /// The value. The model takes a write when all tasks of this round have run.
    #[getter]
    fn get_value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array.get().element(py, self.flat)
    }

    #[setter]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.array.get().write(self.flat, value)
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

    /// The path from the top module, with the index.
    #[getter]
    fn _path(&self) -> String {
        format!("{}[{}]", self.array.get()._path(), self.index)
    }

    fn __int__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.get_value(py)?.call_method0("__int__")
    }

    /// The value of a `real`.
    fn __float__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.get_value(py)?.call_method0("__float__")
    }

    fn __repr__(&self) -> String {
        format!("<element {}[{}]>", self.array.get().name, self.index)
    }
}
