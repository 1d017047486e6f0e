//! The first of several waits, and all of them.

use hoverlock_harness::sim;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::task;
use crate::wait::{ResultSource, Task, Trigger};

/// The first of several triggers, tasks or coroutines; the other waits are cancelled. The result is the trigger that
/// fired, or the result of the task that ended.
///
/// >>> first = await First(RisingEdge(dut.done), Timer(1, "us"))
#[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
pub struct First {}

#[pymethods]
impl First {
    #[new]
    #[pyo3(signature = (*triggers))]
    fn new(triggers: &Bound<'_, PyTuple>) -> PyResult<PyClassInitializer<Self>> {
        if triggers.is_empty() {
            return Err(PyValueError::new_err("First of nothing"));
        }
        let parts = parts(triggers)?;
        let py = triggers.py();
        let base =
            Trigger::with_result(sim::Trigger::first(engine_triggers(py, &parts)?), ResultSource::FirstOf(parts));
        Ok(PyClassInitializer::from(base).add_subclass(First {}))
    }
}

/// All of several triggers, tasks or coroutines. If a task among them fails, its error is raised at once. All of none
/// only lets other tasks run.
///
/// >>> await Combine(RisingEdge(dut.a_done), RisingEdge(dut.b_done))
#[pyclass(extends = Trigger, subclass, frozen, module = "hoverlock")]
pub struct Combine {}

#[pymethods]
impl Combine {
    #[new]
    #[pyo3(signature = (*triggers))]
    fn new(triggers: &Bound<'_, PyTuple>) -> PyResult<PyClassInitializer<Self>> {
        if triggers.is_empty() {
            return Ok(PyClassInitializer::from(Trigger::new(sim::Trigger::Yield)).add_subclass(Combine {}));
        }
        let parts = parts(triggers)?;
        let engine = sim::Trigger::combine(engine_triggers(triggers.py(), &parts)?);
        let base = Trigger::with_result(engine, ResultSource::AllOf(parts));
        Ok(PyClassInitializer::from(base).add_subclass(Combine {}))
    }
}

/// Returns the engine's triggers.
fn engine_triggers(py: Python<'_>, parts: &[Py<Trigger>]) -> PyResult<Vec<sim::Trigger>> {
    parts.iter().map(|part| part.bind(py).get().engine().cloned()).collect()
}

/// Converts the arguments of a class into triggers.
fn parts(of: &Bound<'_, PyTuple>) -> PyResult<Vec<Py<Trigger>>> {
    of.iter().map(|item| as_trigger(&item).map(Bound::unbind)).collect()
}

/// Returns the trigger itself, or one for the end of a task or coroutine; a coroutine is started.
fn as_trigger<'py>(item: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Trigger>> {
    if let Ok(trigger) = item.cast::<Trigger>() {
        return Ok(trigger.clone());
    }
    if let Ok(task) = item.cast::<Task>() {
        return task::join(task);
    }
    if task::is_coroutine(item) {
        return task::join(&task::start(item, None)?);
    }
    Err(PyTypeError::new_err(format!("{} is neither a trigger nor a task nor a coroutine", item.repr()?)))
}
