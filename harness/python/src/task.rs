//! Tasks: coroutines of Python that the engine resumes.

use std::cell::{Cell, RefCell};

use hoverlock_harness::sim::{self, Coroutine, Dut, Outcome, Step, TaskId};
use pyo3::exceptions::{PyStopIteration, PyTypeError};
use pyo3::ffi;
use pyo3::intern;
use pyo3::prelude::*;

use crate::errors::{self, Raised, SimulationError};
use crate::gil;
use crate::on_thread::OnThread;
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
#[pyclass(frozen, generic, module = "hoverlock", weakref)]
pub struct Task {
    name: String,
    inner: OnThread<Inner>,
}

struct Inner {
    dut: Dut,
    id: Cell<Option<TaskId>>,
    /// The coroutine of a task that was made, but not started.
    unstarted: RefCell<Option<Py<PyAny>>>,
    state: Cell<State>,
    result: RefCell<Option<Py<PyAny>>>,
    exception: RefCell<Option<Py<PyAny>>>,
}

impl Task {
    pub fn new(dut: Dut, name: &str) -> Task {
        let inner = Inner {
            dut,
            id: Cell::new(None),
            unstarted: RefCell::default(),
            state: Cell::new(State::Running),
            result: RefCell::default(),
            exception: RefCell::default(),
        };
        Task { name: name.to_owned(), inner: OnThread::new(inner) }
    }

    /// The engine's task.
    fn id(&self) -> PyResult<TaskId> {
        let id = self.inner.get()?.id.get();
        id.ok_or_else(|| SimulationError::new_err("the bench itself cannot be awaited or cancelled"))
    }

    /// The engine's task, to be waited for in the simulation that runs; one that was not started starts.
    pub fn joined(&self, slf: &Bound<'_, Task>) -> PyResult<TaskId> {
        let inner = self.inner.get()?;
        if !simulation::current()?.is_same(&inner.dut) {
            let text = format!("task '{}' belongs to another simulation than the one that runs", self.name);
            return Err(SimulationError::new_err(text));
        }
        run_now(slf)?;
        self.id()
    }

    /// The result, `None` while there is none.
    pub fn result_or_none(&self, py: Python<'_>) -> Py<PyAny> {
        self.inner.own().result.borrow().as_ref().map_or_else(|| py.None(), |r| r.clone_ref(py))
    }
}

impl Drop for Inner {
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
    fn cancel(&self, py: Python<'_>, msg: Option<&str>) -> PyResult<bool> {
        let _ = msg;
        let inner = self.inner.get()?;
        let running = inner.state.get() == State::Running;
        if let Some(coroutine) = inner.unstarted.take() {
            inner.state.set(State::Cancelled);
            coroutine.call_method0(py, intern!(py, "close"))?;
        } else if running {
            inner.dut.cancel(self.id()?);
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

/// A Python coroutine as a coroutine of the engine.
pub struct PyCoroutine {
    coroutine: Py<PyAny>,
    /// How its type resumes it.
    send: ffi::sendfunc,
    lock: gil::Lock,
    task: Py<Task>,
    /// What it awaits; while it runs, the edge that it awaited.
    waiting: Option<Py<Trigger>>,
    /// Whether that is an edge alone.
    for_edge: bool,
    /// Whether that has a result.
    result_due: bool,
}

impl PyCoroutine {
    pub fn new(coroutine: Bound<'_, PyAny>, task: Py<Task>) -> PyCoroutine {
        // SAFETY: the type of a live object; its table of slots may be missing.
        let own = unsafe { (*coroutine.get_type_ptr()).tp_as_async.as_ref().and_then(|slots| slots.am_send) };
        let send = own.unwrap_or(ffi::PyIter_Send);
        PyCoroutine {
            coroutine: coroutine.unbind(),
            send,
            lock: gil::Lock::here(),
            task,
            waiting: None,
            for_edge: false,
            result_due: false,
        }
    }

    /// Resumes the coroutine.
    #[inline]
    fn send(&self, py: Python<'_>) -> Result<Sent, PyErr> {
        let mut given: *mut ffi::PyObject = std::ptr::null_mut();
        // SAFETY: the lock is held, all pointers are live objects; on success `given` is a reference that is ours.
        let (status, given) = unsafe {
            let status = (self.send)(self.coroutine.as_ptr(), ffi::Py_None(), &mut given);
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

    /// Resumes the coroutine with what its wait gave.
    #[inline(never)]
    fn resume_with(&mut self, py: Python<'_>, outcome: Outcome) -> Step {
        let waited = if self.for_edge { None } else { self.waiting.take() };
        let sent = match outcome {
            Outcome::Start => self.send(py),
            Outcome::Fired | Outcome::First(..) => {
                if self.result_due
                    && let Some(waited) = &waited
                {
                    Trigger::settle(waited.bind(py), &outcome);
                }
                self.send(py)
            }
            Outcome::Failed(failure) | Outcome::Refused(failure) => {
                self.for_edge = false;
                self.throw(py, errors::of_failure(py, &failure))
            }
            _ => self.throw(py, errors::cancelled(py, "the task waited for was cancelled")),
        };
        self.go_on(py, sent)
    }

    /// What the coroutine does after it ran to its next wait, or to its end.
    #[inline(never)]
    fn go_on(&mut self, py: Python<'_>, mut sent: Result<Sent, PyErr>) -> Step {
        loop {
            match sent {
                Ok(Sent::Yielded(yielded)) => match yielded.into_bound(py).cast_into::<Trigger>() {
                    Ok(trigger) => {
                        let (what, gives_result) = trigger.get().wait();
                        self.for_edge = matches!(what, sim::Trigger::Edge(..) | sim::Trigger::Edges(..));
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
                    let task = self.task.get().inner.own();
                    task.state.set(State::Done);
                    *task.result.borrow_mut() = Some(result);
                    return Step::Done;
                }
                Err(error) => return self.failed(py, error),
            }
        }
    }

    #[cold]
    fn failed(&self, py: Python<'_>, error: PyErr) -> Step {
        let task = self.task.get().inner.own();
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
        let py = self.lock.resume();
        if self.for_edge && matches!(outcome, Outcome::Fired) {
            return match self.send(py) {
                Ok(Sent::Yielded(yielded)) if self.waiting.as_ref().is_some_and(|w| w.is(&yielded)) => Step::Again,
                sent => self.go_on(py, sent),
            };
        }
        self.resume_with(py, outcome)
    }

    fn cancel(&mut self) {
        let py = self.lock.resume();
        self.task.get().inner.own().state.set(State::Cancelled);
        let coroutine = self.coroutine.bind(py);
        // A coroutine can catch the cancellation only by asyncio's name for it, which it has imported then. One that
        // goes on after it is closed.
        if let Some(error) = errors::asyncio_cancelled(py) {
            let thrown = coroutine.call_method1(intern!(py, "throw"), (error.value(py),));
            if let Err(raised) = &thrown
                && !raised.value(py).is(error.value(py))
                && !raised.is_instance_of::<PyStopIteration>(py)
            {
                raised.clone_ref(py).write_unraisable(py, Some(coroutine));
            }
        }
        if let Err(error) = coroutine.call_method0(intern!(py, "close")) {
            // No task waits for this one that could get the exception.
            error.write_unraisable(py, Some(self.coroutine.bind(py)));
        }
    }
}

impl Drop for PyCoroutine {
    fn drop(&mut self) {
        self.lock.resume();
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
    make(coro, name, "create_task")
}

/// Starts a coroutine, or a task that was not started; a task that runs is returned unchanged.
pub fn start<'py>(coro: &Bound<'py, PyAny>, name: Option<&str>) -> PyResult<Bound<'py, Task>> {
    let task = match coro.cast::<Task>() {
        Ok(task) => task.clone(),
        Err(_) => make(coro, name, "start_soon")?,
    };
    run_now(&task)?;
    Ok(task)
}

fn make<'py>(coro: &Bound<'py, PyAny>, name: Option<&str>, what: &str) -> PyResult<Bound<'py, Task>> {
    if !is_coroutine(coro) {
        let hint = if coro.is_callable() { format!(": call it, {what}(f())") } else { String::new() };
        return Err(PyTypeError::new_err(format!("{what} takes a coroutine, not {}{hint}", coro.repr()?)));
    }
    let dut = simulation::current()?;
    let py = coro.py();
    let name = match name {
        Some(name) => name.to_owned(),
        None => coro.getattr("__qualname__").and_then(|n| n.extract()).unwrap_or_else(|_| "task".to_owned()),
    };
    let task = Task::new(dut, &name);
    *task.inner.own().unstarted.borrow_mut() = Some(coro.clone().unbind());
    Bound::new(py, task)
}

/// Starts a task that was made and not started.
fn run_now(task: &Bound<'_, Task>) -> PyResult<()> {
    let inner = task.get().inner.get()?;
    if let Some(coroutine) = inner.unstarted.take() {
        let coroutine = PyCoroutine::new(coroutine.into_bound(task.py()), task.clone().unbind());
        inner.id.set(Some(inner.dut.spawn_coroutine(&task.get().name, Box::new(coroutine))));
    }
    Ok(())
}
