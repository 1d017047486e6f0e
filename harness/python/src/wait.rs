//! What a coroutine can await: the classes `Task` and `Trigger` and those of the edges, without the operations that
//! start and resume tasks. Everything else of the binding refers to these classes; they refer to nothing but the
//! engine.
//!
//! A trigger object is its own iterator: `__await__` returns it, its first `__next__` yields it to the scheduler, the
//! second ends the wait with its result. So a wait allocates no object, and an edge trigger is made once for each
//! signal.

#![allow(unsafe_op_in_unsafe_fn, reason = "what pyo3 writes for the classes made by macros; no unsafe code is here")]

use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicBool, Ordering};

use hoverlock_harness::sim::{self, Dut, Outcome, TaskId};
use pyo3::exceptions::PyStopIteration;
use pyo3::prelude::*;

use crate::on_thread::OnThread;

/// How far a task is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Not ended, and perhaps not started.
    Running,
    /// The coroutine has returned.
    Done,
    /// The coroutine has raised an exception.
    Failed,
    /// The task was cancelled before its end.
    Cancelled,
}

/// A started coroutine. Awaiting it gives the coroutine's result, or raises the coroutine's exception.
///
/// >>> task = hoverlock.start_soon(drive(dut))
/// >>> result = await task
#[pyclass(frozen, generic, module = "hoverlock", weakref)]
pub struct Task {
    pub name: String,
    pub inner: OnThread<TaskState>,
}

/// The state of a task, which belongs to the thread of its simulation.
pub struct TaskState {
    pub dut: Dut,
    /// The engine's task, once it has started; `None` for the bench itself.
    pub id: Cell<Option<TaskId>>,
    /// The coroutine of a task that was created, but not started.
    pub unstarted: RefCell<Option<Py<PyAny>>>,
    pub state: Cell<State>,
    pub result: RefCell<Option<Py<PyAny>>>,
    pub exception: RefCell<Option<Py<PyAny>>>,
}

impl Task {
    /// Makes a running task without a coroutine.
    pub fn new(dut: Dut, name: &str) -> Task {
        let inner = TaskState {
            dut,
            id: Cell::new(None),
            unstarted: RefCell::default(),
            state: Cell::new(State::Running),
            result: RefCell::default(),
            exception: RefCell::default(),
        };
        Task { name: name.to_owned(), inner: OnThread::new(inner) }
    }

    /// Returns what the coroutine returned; Python's `None` before its end.
    pub fn result_or_none(&self, py: Python<'_>) -> Py<PyAny> {
        self.inner.own().result.borrow().as_ref().map_or_else(|| py.None(), |r| r.clone_ref(py))
    }
}

impl Drop for TaskState {
    fn drop(&mut self) {
        // The engine keeps how a task ended; nothing can ask for it any more.
        if let Some(id) = self.id.get() {
            self.dut.forget(id);
        }
    }
}

/// Where the result of a wait comes from.
pub enum ResultSource {
    /// The wait has no result.
    None,
    /// The result of the task.
    Task(Py<Task>),
    /// The result of the trigger that fired, for `First`.
    FirstOf(Vec<Py<Trigger>>),
    /// No result, for `Combine`. The parts are kept, because the engine forgets how a task ended when its object is
    /// dropped.
    AllOf(Vec<Py<Trigger>>),
}

/// An event that a coroutine can await. A trigger can be awaited again, also by several tasks at the same time.
///
/// >>> edge = RisingEdge(dut.clk)
/// >>> await edge
#[pyclass(subclass, frozen, module = "hoverlock")]
pub struct Trigger {
    /// Awaited, not yet yielded to the scheduler.
    fresh: AtomicBool,
    has_result: bool,
    inner: OnThread<TriggerState>,
}

struct TriggerState {
    engine: sim::Trigger,
    source: ResultSource,
    result: RefCell<Option<Py<PyAny>>>,
}

/// How far a wait is.
pub enum Progress {
    /// The scheduler resumes the coroutine when the trigger has fired.
    Pending,
    /// The trigger has fired, with this result if it has one.
    Fired(Option<Py<PyAny>>),
}

impl Trigger {
    /// Makes a trigger whose wait has no result.
    pub fn new(engine: sim::Trigger) -> Trigger {
        Trigger::with_result(engine, ResultSource::None)
    }

    /// Makes a trigger whose wait has the result that `source` names.
    pub fn with_result(engine: sim::Trigger, source: ResultSource) -> Trigger {
        let has_result = !matches!(source, ResultSource::None | ResultSource::AllOf(_));
        let inner = OnThread::new(TriggerState { engine, source, result: RefCell::default() });
        Trigger { fresh: AtomicBool::new(false), has_result, inner }
    }

    /// Returns the engine's trigger.
    ///
    /// # Errors
    /// `SimulationError` on another thread than the simulation's.
    #[inline]
    pub fn engine(&self) -> PyResult<&sim::Trigger> {
        Ok(&self.inner.get()?.engine)
    }

    /// Returns the engine's trigger, and whether a wait for it has a result.
    #[inline]
    pub fn wait(&self) -> (sim::Trigger, bool) {
        (self.inner.own().engine.clone(), self.has_result)
    }

    /// Begins a wait.
    #[inline(always)]
    pub fn begin(&self) -> PyResult<()> {
        self.inner.get()?;
        self.fresh.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Continues a wait: `Pending` at the first call, `Fired` when the coroutine is resumed.
    #[inline(always)]
    pub fn proceed(&self) -> PyResult<Progress> {
        // No exchange: the interpreter's lock is held.
        if self.fresh.load(Ordering::Relaxed) {
            self.fresh.store(false, Ordering::Relaxed);
            return Ok(Progress::Pending);
        }
        Ok(Progress::Fired(if self.has_result { self.inner.get()?.result.take() } else { None }))
    }

    /// Stores the result of a wait; `proceed` returns it.
    pub fn store_result(slf: &Bound<'_, Trigger>, outcome: &Outcome) {
        let result = Trigger::result_of(slf, outcome);
        *slf.get().inner.own().result.borrow_mut() = Some(result);
    }

    fn result_of(slf: &Bound<'_, Trigger>, outcome: &Outcome) -> Py<PyAny> {
        let py = slf.py();
        match (&slf.get().inner.own().source, outcome) {
            (ResultSource::Task(task), _) => task.get().result_or_none(py),
            (ResultSource::FirstOf(parts), Outcome::First(index, inner)) => {
                Trigger::result_of(parts[*index].bind(py), inner)
            }
            _ => slf.clone().into_any().unbind(),
        }
    }
}

#[pymethods]
impl Trigger {
    fn __await__(slf: Bound<'_, Self>) -> PyResult<Bound<'_, Self>> {
        slf.get().begin()?;
        Ok(slf)
    }

    fn __iter__(slf: Bound<'_, Self>) -> PyResult<Bound<'_, Self>> {
        Self::__await__(slf)
    }

    fn __next__<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, Self>>> {
        match slf.get().proceed()? {
            Progress::Pending => Ok(Some(slf.clone())),
            Progress::Fired(None) => Ok(None),
            // In a tuple, so that a result that is a tuple is not unpacked.
            Progress::Fired(Some(result)) => Err(PyStopIteration::new_err((result,))),
        }
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        if let ResultSource::Task(task) = &slf.get().inner.get()?.source {
            return Ok(format!("the end of {}", task.bind(slf.py()).repr()?));
        }
        Ok(format!("{}()", slf.get_type().name()?))
    }
}

macro_rules! edge_class {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[pyclass(extends = Trigger, frozen, module = "hoverlock")]
        pub struct $name {
            /// Name of the signal, with the bit if it is one of several.
            #[pyo3(get)]
            pub signal_name: String,
        }
    };
}

edge_class!(
    /// The change of a one-bit signal from 0 to 1.
    ///
    /// >>> await RisingEdge(dut.clk)
    RisingEdge
);
edge_class!(
    /// The change of a one-bit signal from 1 to 0.
    ///
    /// >>> await FallingEdge(dut.clk)
    FallingEdge
);
edge_class!(
    /// Any change of a signal's value.
    ///
    /// >>> await ValueChange(dut.state)
    ValueChange
);
