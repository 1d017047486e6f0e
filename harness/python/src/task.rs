//! Tasks: coroutines of Python that the engine resumes.

use std::cell::{Cell, RefCell};

use hoverlock_harness::sim::{Coroutine, Dut, Outcome, Step, TaskId};
use pyo3::exceptions::{PyStopIteration, PyTypeError};
use pyo3::ffi;
use pyo3::intern;
use pyo3::prelude::*;

use crate::errors::{self, CancelledError, Raised, SimulationError};
use crate::gil;
use crate::simulation;
use crate::trigger::{self, Trigger};

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Running,
    Done,
    Failed,
    Cancelled,
}

/// A started coroutine. Awaiting it gives the coroutine's result, or raises the coroutine's exception.
///
/// >>> task = hoverlock.start_soon(drive(dut))
/// >>> result = await task
#[pyclass(unsendable, generic, module = "hoverlock", weakref)]
pub struct Task {
    dut: Dut,
    id: Cell<Option<TaskId>>,
    name: String,
    state: Cell<State>,
    result: RefCell<Option<Py<PyAny>>>,
    exception: RefCell<Option<Py<PyAny>>>,
}

impl Task {
    pub fn new(dut: Dut, name: &str) -> Task {
        Task {
            dut,
            id: Cell::new(None),
            name: name.to_owned(),
            state: Cell::new(State::Running),
            result: RefCell::default(),
            exception: RefCell::default(),
        }
    }

    /// The engine's task.
    pub fn id(&self) -> PyResult<TaskId> {
        self.id.get().ok_or_else(|| SimulationError::new_err("the bench itself cannot be awaited or cancelled"))
    }

    /// The result, `None` while there is none.
    pub fn result_or_none(&self, py: Python<'_>) -> Py<PyAny> {
        self.result.borrow().as_ref().map_or_else(|| py.None(), |r| r.clone_ref(py))
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        // The engine keeps how a task ended; nothing can ask for it any more.
        if let Some(id) = self.id.get() {
            self.dut.forget(id);
        }
    }
}

#[pymethods]
impl Task {
    fn __await__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        trigger::join(slf)?.call_method0("__await__")
    }

    /// A trigger that fires when the task has ended; its result is that of the task.
    fn join<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, Trigger>> {
        trigger::join(slf)
    }

    /// The same as `join()` (cocotb 2's name).
    #[getter]
    fn complete<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, Trigger>> {
        trigger::join(slf)
    }

    /// Cancels the task; its `finally` blocks run. False if it had ended already. `msg` is ignored; cocotb 2 has it.
    #[pyo3(signature = (msg = None))]
    fn cancel(&self, msg: Option<&str>) -> PyResult<bool> {
        let _ = msg;
        let running = self.state.get() == State::Running;
        if running {
            self.dut.cancel(self.id()?);
        }
        Ok(running)
    }

    /// The same as `cancel()` (cocotb 1's name).
    fn kill(&self) -> PyResult<()> {
        self.cancel(None).map(|_| ())
    }

    /// Whether the task has ended, for any reason.
    fn done(&self) -> bool {
        self.state.get() != State::Running
    }

    /// Whether the task was cancelled.
    fn cancelled(&self) -> bool {
        self.state.get() == State::Cancelled
    }

    /// What the coroutine returned; raises the coroutine's exception, or `CancelledError`.
    fn result(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        match self.state.get() {
            State::Done => Ok(self.result_or_none(py)),
            State::Cancelled => Err(CancelledError::new_err(format!("task '{}' was cancelled", self.name))),
            State::Failed => Err(PyErr::from_value(self.exception(py)?.into_bound(py))),
            State::Running => Err(SimulationError::new_err(format!("task '{}' has not ended yet", self.name))),
        }
    }

    /// The coroutine's exception, or None.
    fn exception(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        if self.state.get() == State::Running {
            return Err(SimulationError::new_err(format!("task '{}' has not ended yet", self.name)));
        }
        Ok(self.exception.borrow().as_ref().map_or_else(|| py.None(), |e| e.clone_ref(py)))
    }

    /// The task's name.
    fn get_name(&self) -> &str {
        &self.name
    }

    fn __repr__(&self) -> String {
        let state = match self.state.get() {
            State::Running => "running",
            State::Done => "done",
            State::Failed => "failed",
            State::Cancelled => "cancelled",
        };
        format!("<Task '{}' {state}>", self.name)
    }
}

/// A Python coroutine as a coroutine of the engine.
pub struct PyCoroutine {
    coroutine: Py<PyAny>,
    task: Py<Task>,
    /// What it awaits.
    waiting: Option<Py<Trigger>>,
    /// Whether that has a result.
    result_due: bool,
}

impl PyCoroutine {
    pub fn new(coroutine: Py<PyAny>, task: Py<Task>) -> PyCoroutine {
        PyCoroutine { coroutine, task, waiting: None, result_due: false }
    }

    /// Resumes the coroutine.
    #[inline]
    fn send(&self, py: Python<'_>) -> Result<Sent, PyErr> {
        let mut given: *mut ffi::PyObject = std::ptr::null_mut();
        // SAFETY: the lock is held, all pointers are live objects; on success `given` is a reference that is ours.
        let (status, given) = unsafe {
            let status = ffi::PyIter_Send(self.coroutine.as_ptr(), ffi::Py_None(), &mut given);
            (status, Bound::from_owned_ptr_or_opt(py, given).map(Bound::unbind))
        };
        match (status, given) {
            (ffi::PySendResult::PYGEN_NEXT, Some(given)) => Ok(Sent::Yielded(given)),
            (ffi::PySendResult::PYGEN_RETURN, Some(given)) => Ok(Sent::Returned(given)),
            _ => Err(PyErr::fetch(py)),
        }
    }

    /// Resumes the coroutine by raising an exception in it.
    #[cold]
    fn throw(&self, py: Python<'_>, error: PyErr) -> Result<Sent, PyErr> {
        match self.coroutine.bind(py).call_method1("throw", (error.into_value(py),)) {
            Ok(yielded) => Ok(Sent::Yielded(yielded.unbind())),
            Err(e) if e.is_instance_of::<PyStopIteration>(py) => {
                Ok(Sent::Returned(e.value(py).getattr("value").map_or_else(|_| py.None(), Bound::unbind)))
            }
            Err(e) => Err(e),
        }
    }

    #[cold]
    fn failed(&self, py: Python<'_>, error: PyErr) -> Step {
        let task = self.task.borrow(py);
        task.state.set(State::Failed);
        let (failure, exception) = Raised::failure(py, error);
        *task.exception.borrow_mut() = Some(exception);
        Step::Failed(failure)
    }
}

enum Sent {
    Yielded(Py<PyAny>),
    Returned(Py<PyAny>),
}

impl Coroutine for PyCoroutine {
    #[inline]
    fn resume(&mut self, outcome: Outcome) -> Step {
        let py = gil::resume();
        let waited = self.waiting.take();
        let mut sent = match outcome {
            Outcome::Start => self.send(py),
            Outcome::Fired | Outcome::First(..) => {
                if self.result_due
                    && let Some(waited) = &waited
                {
                    Trigger::settle(waited.bind(py), &outcome);
                }
                self.send(py)
            }
            Outcome::Failed(failure) | Outcome::Refused(failure) => self.throw(py, errors::of_failure(py, &failure)),
            _ => self.throw(py, CancelledError::new_err("the task waited for was cancelled")),
        };
        loop {
            match sent {
                Ok(Sent::Yielded(yielded)) => match yielded.into_bound(py).cast_into::<Trigger>() {
                    Ok(trigger) => {
                        let (what, gives_result) = trigger.get().wait();
                        self.result_due = gives_result;
                        self.waiting = Some(trigger.unbind());
                        return Step::Wait(what);
                    }
                    Err(error) => {
                        let found = error.into_inner();
                        let kind = found.get_type().name().map_or_else(|_| "object".to_owned(), |n| n.to_string());
                        sent = self.throw(
                            py,
                            PyTypeError::new_err(format!(
                                "a coroutine awaited an object ({kind}) that is not a hoverlock trigger; \
                                 asyncio's own awaitables cannot be used in a bench"
                            )),
                        );
                    }
                },
                Ok(Sent::Returned(result)) => {
                    let task = self.task.borrow(py);
                    task.state.set(State::Done);
                    *task.result.borrow_mut() = Some(result);
                    return Step::Done;
                }
                Err(error) => return self.failed(py, error),
            }
        }
    }

    fn cancel(&mut self) {
        let py = gil::resume();
        self.task.borrow(py).state.set(State::Cancelled);
        if let Err(error) = self.coroutine.bind(py).call_method0("close") {
            // No task waits for this one that could get the exception.
            error.write_unraisable(py, Some(self.coroutine.bind(py)));
        }
    }
}

impl Drop for PyCoroutine {
    fn drop(&mut self) {
        gil::resume();
    }
}

/// Whether it has a coroutine's methods.
pub fn is_coroutine(item: &Bound<'_, PyAny>) -> bool {
    ["send", "throw", "close"].iter().all(|name| item.hasattr(*name).unwrap_or(false))
}

/// Starts a coroutine as a task. It begins to run after the tasks that are ready already. A task or a clock, which runs
/// already, is returned unchanged.
///
/// >>> task = start_soon(drive(dut))
#[pyfunction]
#[pyo3(signature = (coro, name = None))]
pub fn start_soon<'py>(coro: &Bound<'py, PyAny>, name: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
    if coro.hasattr(intern!(coro.py(), "_runs_already"))? {
        return Ok(coro.clone());
    }
    start(coro, name).map(Bound::into_any)
}

/// Starts a coroutine; a task is returned unchanged.
pub fn start<'py>(coro: &Bound<'py, PyAny>, name: Option<&str>) -> PyResult<Bound<'py, Task>> {
    if let Ok(task) = coro.cast::<Task>() {
        return Ok(task.clone());
    }
    if !is_coroutine(coro) {
        let hint = if coro.is_callable() { ": call it, start_soon(f())" } else { "" };
        return Err(PyTypeError::new_err(format!("start_soon takes a coroutine, not {}{hint}", coro.repr()?)));
    }
    let dut = simulation::current()?;
    let py = coro.py();
    let name = match name {
        Some(name) => name.to_owned(),
        None => coro.getattr("__qualname__").and_then(|n| n.extract()).unwrap_or_else(|_| "task".to_owned()),
    };
    let task = Bound::new(py, Task::new(dut.clone(), &name))?;
    let coroutine = PyCoroutine::new(coro.clone().unbind(), task.clone().unbind());
    let id = dut.spawn_coroutine(&name, Box::new(coroutine));
    task.borrow().id.set(Some(id));
    Ok(task)
}
