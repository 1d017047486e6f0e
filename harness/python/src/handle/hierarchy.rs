//! Levels of the hierarchy.

use pyo3::exceptions::PyAttributeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A level of the hierarchy. Its children are in its dictionary, where access is fastest. For any other name `_missing`
/// gives the exception.
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
