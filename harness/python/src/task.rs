//! Operations of tasks: start, await, cancel.

use hoverlock_harness::sim::{self, TaskId};
use pyo3::exceptions::PyTypeError;
use pyo3::intern;
use pyo3::prelude::*;

use crate::coroutine::PyCoroutine;
use crate::errors::{self, SimulationError};
use crate::running;
use crate::wait::{ResultSource, State, Task, Trigger};

#[pymethods]
impl Task {
    fn __await__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        join(slf)?.call_method0("__await__")
    }

    /// A trigger that fires when the task has ended; its result is that of the task.
    fn join<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, Trigger>> {
        join(slf)
    }

    /// The same as `join()` (cocotb 2's name).
    #[getter]
    fn complete<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, Trigger>> {
        join(slf)
    }

    /// Cancels the task; its `finally` blocks run. False if it had ended already. `msg` is ignored; cocotb 2 has it.
    #[pyo3(signature = (msg = None))]
    fn cancel(&self, py: Python<'_>, msg: Option<&str>) -> PyResult<bool> {
        let _ = msg;
        let inner = self.inner.get()?;
        let running = inner.state.get() == State::Running;
        if let Some(coroutine) = inner.unstarted.take() {
            inner.state.set(State::Cancelled);
            coroutine.call_method0(py, intern!(py, "close"))?;
        } else if running {
            inner.dut.cancel(engine_task(self)?);
        }
        Ok(running)
    }

    /// The same as `cancel()` (cocotb 1's name).
    fn kill(&self, py: Python<'_>) -> PyResult<()> {
        self.cancel(py, None).map(|_| ())
    }

    /// Whether the task has ended, for any reason.
    fn done(&self) -> PyResult<bool> {
        Ok(self.inner.get()?.state.get() != State::Running)
    }

    /// Whether the task was cancelled.
    fn cancelled(&self) -> PyResult<bool> {
        Ok(self.inner.get()?.state.get() == State::Cancelled)
    }

    /// What the coroutine returned; raises the coroutine's exception, or `CancelledError`.
    fn result(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        match self.inner.get()?.state.get() {
            State::Done => Ok(self.result_or_none(py)),
            State::Cancelled => Err(errors::cancelled(py, &format!("task '{}' was cancelled", self.name))),
            State::Failed => Err(PyErr::from_value(self.exception(py)?.into_bound(py))),
            State::Running => Err(SimulationError::new_err(format!("task '{}' has not ended yet", self.name))),
        }
    }

    /// The coroutine's exception, or None.
    fn exception(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let inner = self.inner.get()?;
        if inner.state.get() == State::Running {
            return Err(SimulationError::new_err(format!("task '{}' has not ended yet", self.name)));
        }
        Ok(inner.exception.borrow().as_ref().map_or_else(|| py.None(), |e| e.clone_ref(py)))
    }

    /// The task's name.
    fn get_name(&self) -> &str {
        &self.name
    }

    fn __repr__(&self) -> PyResult<String> {
        let inner = self.inner.get()?;
        let state = match inner.state.get() {
            State::Running if inner.unstarted.borrow().is_some() => "not started",
            State::Running => "running",
            State::Done => "done",
            State::Failed => "failed",
            State::Cancelled => "cancelled",
        };
        Ok(format!("<Task '{}' {state}>", self.name))
    }
}

/// Returns `true` if the object has the methods of a coroutine.
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

/// Makes a task of a coroutine, which starts when it is awaited or given to `start_soon`.
///
/// >>> task = create_task(drive(dut))
/// >>> await task
#[pyfunction]
#[pyo3(signature = (coro, name = None))]
pub fn create_task<'py>(coro: &Bound<'py, PyAny>, name: Option<&str>) -> PyResult<Bound<'py, Task>> {
    if let Ok(task) = coro.cast::<Task>() {
        return Ok(task.clone());
    }
    create(coro, name, "create_task")
}

/// Starts a coroutine, or a task that was not started; a task that runs is returned unchanged.
pub fn start<'py>(coro: &Bound<'py, PyAny>, name: Option<&str>) -> PyResult<Bound<'py, Task>> {
    let task = match coro.cast::<Task>() {
        Ok(task) => task.clone(),
        Err(_) => create(coro, name, "start_soon")?,
    };
    start_if_new(&task)?;
    Ok(task)
}

/// Creates a task that is not started; `caller` is the function that an error names.
fn create<'py>(coro: &Bound<'py, PyAny>, name: Option<&str>, caller: &str) -> PyResult<Bound<'py, Task>> {
    if !is_coroutine(coro) {
        let hint = if coro.is_callable() { format!(": call it, {caller}(f())") } else { String::new() };
        return Err(PyTypeError::new_err(format!("{caller} takes a coroutine, not {}{hint}", coro.repr()?)));
    }
    let dut = running::current()?;
    let py = coro.py();
    let name = match name {
        Some(name) => name.to_owned(),
        None => coro.getattr("__qualname__").and_then(|n| n.extract()).unwrap_or_else(|_| "task".to_owned()),
    };
    let task = Task::new(dut, &name);
    *task.inner.own().unstarted.borrow_mut() = Some(coro.clone().unbind());
    Bound::new(py, task)
}

/// Starts a task that was created and not started; any other stays as it is.
fn start_if_new(task: &Bound<'_, Task>) -> PyResult<()> {
    let inner = task.get().inner.get()?;
    if let Some(coroutine) = inner.unstarted.take() {
        let coroutine = PyCoroutine::new(coroutine.into_bound(task.py()), task.clone().unbind());
        inner.id.set(Some(inner.dut.spawn_coroutine(&task.get().name, Box::new(coroutine))));
    }
    Ok(())
}

/// Returns the engine's task.
///
/// # Errors
/// `SimulationError` for the bench itself, which has no task in the engine.
fn engine_task(task: &Task) -> PyResult<TaskId> {
    let id = task.inner.get()?.id.get();
    id.ok_or_else(|| SimulationError::new_err("the bench itself cannot be awaited or cancelled"))
}

/// Returns a trigger that fires when the task ends; its result is that of the task. Starts a task that was not started.
///
/// # Errors
/// `SimulationError` if the task belongs to another simulation than the running one.
pub fn join<'py>(task: &Bound<'py, Task>) -> PyResult<Bound<'py, Trigger>> {
    let this = task.get();
    if !running::current()?.is_same(&this.inner.get()?.dut) {
        let text = format!("task '{}' belongs to another simulation than the one that runs", this.name);
        return Err(SimulationError::new_err(text));
    }
    start_if_new(task)?;
    let engine = sim::Trigger::Join(engine_task(this)?);
    Bound::new(task.py(), Trigger::with_result(engine, ResultSource::Task(task.clone().unbind())))
}
