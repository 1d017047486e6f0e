//! Converts errors of the engine into Python exceptions; the classes are defined in `hoverlock/errors.py`.

use hoverlock_harness::sim::Failure;
use hoverlock_harness::{BuildError, Error, ModelError, SimError};
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::gil;

mod python {
    #![allow(missing_docs, reason = "the classes are documented where they are defined, in Python")]
    pyo3::import_exception!(hoverlock.errors, HoverlockError);
    pyo3::import_exception!(hoverlock.errors, BuildError);
    pyo3::import_exception!(hoverlock.errors, NoSuchSignal);
    pyo3::import_exception!(hoverlock.errors, RangeError);
    pyo3::import_exception!(hoverlock.errors, NotWritable);
    pyo3::import_exception!(hoverlock.errors, NotForceable);
    pyo3::import_exception!(hoverlock.errors, ReadOnlyError);
    pyo3::import_exception!(hoverlock.errors, SimulationError);
    pyo3::import_exception!(hoverlock.errors, TriggerError);
    pyo3::import_exception!(hoverlock.errors, DeadlockError);
    pyo3::import_exception!(hoverlock.errors, SimTimeoutError);
    pyo3::import_exception!(hoverlock.errors, VerilogError);
    pyo3::import_exception!(hoverlock.errors, VerilogFinished);
    pyo3::import_exception!(hoverlock.errors, ProtocolError);
}

pub use python::{RangeError, SimulationError, TriggerError};

/// A Python exception carried through the engine by a failed task.
pub struct Raised(Py<PyAny>);

impl Raised {
    /// Wraps an exception as a failure of the engine; returns the failure and the exception.
    pub fn failure(py: Python<'_>, error: PyErr) -> (Failure, Py<PyAny>) {
        let text = error.to_string();
        // With its traceback, which `value` alone would not have on older interpreters.
        let exception = error.into_value(py).into_any();
        (Failure::with_payload(text, Raised(exception.clone_ref(py))), exception)
    }
}

impl Drop for Raised {
    fn drop(&mut self) {
        // The engine may drop a failure without the interpreter's lock; dropping the exception needs it.
        gil::resume();
    }
}

/// Returns the exception for an error of the engine.
pub fn exception(py: Python<'_>, error: Error) -> PyErr {
    of_error(py, &error)
}

fn of_error(py: Python<'_>, error: &Error) -> PyErr {
    match error {
        Error::Build(e) => of_build(e),
        Error::Model(e) => of_model(e),
        Error::Sim(e) => of_sim(py, e),
        Error::Protocol(e) => python::ProtocolError::new_err(e.to_string()),
        other => python::HoverlockError::new_err(other.to_string()),
    }
}

/// Returns the exception for an error in building a model from Verilog.
pub fn of_build(error: &BuildError) -> PyErr {
    python::BuildError::new_err(error.to_string())
}

/// Returns the exception for a wrong use of a model.
pub fn of_model(error: &ModelError) -> PyErr {
    let text = error.to_string();
    match error {
        ModelError::NoSuchSignal { .. } => {
            // The engine's message names the call of the Rust builder: put that of `Design` in its place.
            let text =
                text.replace("add .internal(\"", "Design(..., internals=[\"").replace("\") to the build)", "\"]))");
            python::NoSuchSignal::new_err(text)
        }
        ModelError::NotForceable { .. } => {
            let text =
                text.replace("add .forceable(\"", "Design(..., forceable=[\"").replace("\") to the build", "\"])");
            python::NotForceable::new_err(text)
        }
        ModelError::InoutNotDrivable { .. } => python::NotWritable::new_err(text),
        ModelError::NotReachable { .. } => python::NoSuchSignal::new_err(text),
        ModelError::OutOfRange { .. } => python::RangeError::new_err(text),
        ModelError::Address { .. } => PyIndexError::new_err(text),
        ModelError::NotWritable { .. } => python::NotWritable::new_err(text),
        ModelError::WriteInReadOnly { .. } => python::ReadOnlyError::new_err(text),
        ModelError::NoSuchEnumItem { .. } => PyValueError::new_err(text),
        ModelError::TooWide { .. } | ModelError::WrongShape { .. } => PyTypeError::new_err(text),
        _ => python::SimulationError::new_err(text),
    }
}

/// Returns the exception for a simulation that ended early.
pub fn of_sim(py: Python<'_>, error: &SimError) -> PyErr {
    let text = error.to_string();
    match error {
        SimError::TaskFailed { failure, .. } => of_failure(py, failure),
        SimError::Cancelled { .. } => cancelled(py, &text),
        SimError::Deadlock { .. } | SimError::NoProgress { .. } => python::DeadlockError::new_err(text),
        SimError::TimeLimit { .. }
        | SimError::WallClock { .. }
        | SimError::Timeout { .. }
        | SimError::TooManyCycles { .. } => python::SimTimeoutError::new_err(text),
        SimError::Verilog { .. } => python::VerilogError::new_err(text),
        SimError::Finished { .. } => python::VerilogFinished::new_err(text),
        SimError::WrongRegion { .. } => python::TriggerError::new_err(text),
        SimError::BadTime(_) => PyValueError::new_err(text),
        _ => python::SimulationError::new_err(text),
    }
}

/// Returns the exception of a wait for a cancelled task. It is also an instance of `asyncio`'s class if the bench has
/// imported `asyncio`.
pub fn cancelled(py: Python<'_>, text: &str) -> PyErr {
    let made = py.import("hoverlock.errors").and_then(|m| m.call_method1("cancelled", (text,)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Returns the exception that is raised in a cancelled task, or `None` if the bench has not imported `asyncio` and so
/// cannot catch it.
pub fn asyncio_cancelled(py: Python<'_>) -> Option<PyErr> {
    let made = py.import("hoverlock.errors").and_then(|m| m.call_method0("asyncio_cancelled")).ok()?;
    (!made.is_none()).then(|| PyErr::from_value(made))
}

/// Returns the exception that a coroutine raised, or the one for an error of the engine.
pub fn of_failure(py: Python<'_>, failure: &Failure) -> PyErr {
    if let Some(raised) = failure.payload::<Raised>() {
        return PyErr::from_value(raised.0.bind(py).clone());
    }
    if let Some(error) = failure.payload::<SimError>() {
        return of_sim(py, error);
    }
    if let Some(error) = failure.payload::<ModelError>() {
        return of_model(error);
    }
    if let Some(error) = failure.payload::<Error>() {
        return of_error(py, error);
    }
    python::SimulationError::new_err(failure.message().to_owned())
}
