//! Python coroutines as coroutines of the engine.

use hoverlock_harness::sim::{self, Coroutine, Outcome, Step};
use pyo3::exceptions::{PyStopIteration, PyTypeError};
use pyo3::ffi;
use pyo3::intern;
use pyo3::prelude::*;

use crate::errors::{self, Raised};
use crate::gil;
use crate::running;
use crate::wait::{State, Task, Trigger};

/// A Python coroutine as a coroutine of the engine.
pub struct PyCoroutine {
    coroutine: Py<PyAny>,
    /// The slot `am_send` of its type, which resumes it.
    send: ffi::sendfunc,
    lock: gil::Lock,
    task: Py<Task>,
    /// The trigger that it awaits; while it runs, the edge that it awaited last.
    waiting: Option<Py<Trigger>>,
    /// Whether `waiting` is an edge trigger, which has no result.
    for_edge: bool,
    /// Whether `waiting` has a result.
    has_result: bool,
}

impl PyCoroutine {
    /// Wraps the coroutine of `task`; call it on the simulation's thread.
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
            has_result: false,
        }
    }

    /// Resumes the coroutine.
    #[inline]
    fn send(&self, py: Python<'_>) -> Result<Sent, PyErr> {
        let mut given: *mut ffi::PyObject = std::ptr::null_mut();
        // SAFETY: the lock is held, all pointers are live objects; on success `given` is a new reference.
        let (status, given) = unsafe {
            let status =
                running::with_task(&self.task, || (self.send)(self.coroutine.as_ptr(), ffi::Py_None(), &mut given));
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
        let thrown =
            running::with_task(&self.task, || self.coroutine.bind(py).call_method1("throw", (error.into_value(py),)));
        match thrown {
            Ok(yielded) => Ok(Sent::Yielded(yielded.unbind())),
            Err(e) if e.is_instance_of::<PyStopIteration>(py) => {
                Ok(Sent::Returned(e.value(py).getattr("value").map_or_else(|_| py.None(), Bound::unbind)))
            }
            Err(e) => Err(e),
        }
    }

    /// Resumes the coroutine with the outcome of its wait.
    #[inline(never)]
    fn resume_with(&mut self, py: Python<'_>, outcome: Outcome) -> Step {
        let waited = if self.for_edge { None } else { self.waiting.take() };
        let sent = match outcome {
            Outcome::Start => self.send(py),
            Outcome::Fired | Outcome::First(..) => {
                if self.has_result
                    && let Some(waited) = &waited
                {
                    Trigger::store_result(waited.bind(py), &outcome);
                }
                self.send(py)
            }
            Outcome::Failed(failure) | Outcome::Refused(failure) => {
                self.for_edge = false;
                self.throw(py, errors::of_failure(py, &failure))
            }
            _ => self.throw(py, errors::cancelled(py, "the task waited for was cancelled")),
        };
        self.next_step(py, sent)
    }

    /// Returns the engine's next step after the coroutine ran to its next wait, or to its end.
    #[inline(never)]
    fn next_step(&mut self, py: Python<'_>, mut sent: Result<Sent, PyErr>) -> Step {
        loop {
            match sent {
                Ok(Sent::Yielded(yielded)) => match yielded.into_bound(py).cast_into::<Trigger>() {
                    Ok(trigger) => {
                        let (engine, has_result) = trigger.get().wait();
                        self.for_edge = matches!(engine, sim::Trigger::Edge(..) | sim::Trigger::Edges(..));
                        self.has_result = has_result;
                        self.waiting = Some(trigger.unbind());
                        return Step::Wait(engine);
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

/// What a resumed coroutine did.
enum Sent {
    /// It awaits this object.
    Yielded(Py<PyAny>),
    /// It has ended with this result.
    Returned(Py<PyAny>),
}

impl Coroutine for PyCoroutine {
    #[inline]
    fn resume(&mut self, outcome: Outcome) -> Step {
        let py = self.lock.resume();
        if self.for_edge && matches!(outcome, Outcome::Fired) {
            return match self.send(py) {
                Ok(Sent::Yielded(yielded)) if self.waiting.as_ref().is_some_and(|w| w.is(&yielded)) => Step::Again,
                sent => self.next_step(py, sent),
            };
        }
        self.resume_with(py, outcome)
    }

    fn cancel(&mut self) {
        let py = self.lock.resume();
        self.task.get().inner.own().state.set(State::Cancelled);
        let coroutine = self.coroutine.bind(py);
        // A coroutine can only catch the cancellation by asyncio's name for it, so by then asyncio is imported. A
        // coroutine that continues after the exception is closed.
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
