//! The Python methods of a signal's handle.

use pyo3::IntoPyObjectExt;
use pyo3::basic::CompareOp;
use pyo3::prelude::*;

use super::bits::{Bits, field};
use super::names::{direction_name, own_name, path};
use super::range::span;
use super::signal::{Access, Handle};
use super::value::Value;
use crate::wait::{FallingEdge, RisingEdge, ValueChange};

#[pymethods]
impl Handle {
    /// The value. The model takes a write when all tasks of this round have run.
    #[getter]
    fn get_value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Value>> {
        self.read(py)
    }

    #[setter]
    fn set_value(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.write(value)
    }

    /// The same as assigning to `value`.
    fn set(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.write(value)
    }

    /// The same as reading `value`.
    fn get<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Value>> {
        self.read(py)
    }

    /// The same as assigning to `value`: there is no write that is more immediate.
    fn setimmediatevalue(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.write(value)
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

    /// The signal's own name, without the names of the instances that contain it.
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
        match (self.width, self.items.is_empty()) {
            (_, false) => "GPI_ENUM",
            (1, _) => "GPI_LOGIC",
            _ => "GPI_LOGIC_ARRAY",
        }
    }

    /// The indices of the leftmost and the rightmost bit, as declared.
    #[getter]
    fn _range(&self) -> (i64, i64) {
        self.range
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

    /// Bits of the signal, by the indices of its declaration: `dut.bus[3]` or `dut.bus[7:4]`. They are read and written
    /// like a signal.
    fn __getitem__(slf: &Bound<'_, Self>, index: &Bound<'_, PyAny>) -> PyResult<Bits> {
        let (low, width) = span(index, slf.get().range)?;
        Ok(Bits { handle: slf.clone().unbind(), low, width, signed: false, field: String::new() })
    }

    /// A field of a packed structure: `dut.beat.tag.value`. A field of a structure inside it has another dot.
    fn __getattr__(slf: &Bound<'_, Self>, name: &str) -> PyResult<Bits> {
        field(slf, "", name)
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
            CompareOp::Eq | CompareOp::Ne => slf.get().read(py)?.into_any().rich_compare(other, op),
            CompareOp::Le => {
                slf.get().write(other)?;
                Ok(py.None().into_bound(py))
            }
            _ => Ok(py.NotImplemented().into_bound(py)),
        }
    }

    fn __hash__(slf: &Bound<'_, Self>) -> usize {
        slf.as_ptr() as usize >> 4
    }

    fn __int__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.read(py)?.get().int(py)
    }

    fn __repr__(&self) -> String {
        format!("<{} {} [{}:0]>", direction_name(self.direction), self.name, self.width - 1)
    }
}
