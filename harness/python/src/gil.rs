//! The interpreter's lock while a simulation runs.
//!
//! A coroutine is resumed up to millions of times a second, too often to take and release the lock each time. So `run`
//! keeps the lock, and releases it after a few milliseconds of simulation in which no coroutine was resumed. The next
//! resume takes it again.

use std::cell::Cell;
use std::rc::Rc;

use pyo3::ffi;
use pyo3::prelude::*;

struct State {
    /// The thread's state while the lock is released, otherwise null.
    saved: Cell<*mut ffi::PyThreadState>,
    /// Whether Python ran since `pause` was last called.
    ran: Cell<bool>,
}

thread_local! {
    static STATE: Rc<State> = Rc::new(State { saved: Cell::new(std::ptr::null_mut()), ran: Cell::new(false) });
}

/// A handle to the lock of this thread's simulations. Code that uses it often keeps the handle, because `Lock::here`
/// costs more than `resume`.
#[derive(Clone)]
pub struct Lock(Rc<State>);

impl Lock {
    /// Returns the handle of this thread.
    pub fn here() -> Lock {
        STATE.with(|state| Lock(state.clone()))
    }

    /// Takes the lock again if it was released; for code that a running simulation calls.
    #[inline(always)]
    pub fn resume<'a>(&self) -> Python<'a> {
        self.0.ran.set(true);
        if !self.0.saved.get().is_null() {
            take_back(&self.0);
        }
        // SAFETY: only called below methods of `Simulation` that run it, which were called from Python on this thread;
        // the lock is held unless `pause` released it, and `take_back` has undone that.
        unsafe { Python::assume_attached() }
    }
}

/// Takes the lock again if it was released, as `Lock::resume` does, for code that needs it rarely.
pub fn resume<'a>() -> Python<'a> {
    Lock::here().resume()
}

#[cold]
fn take_back(state: &State) {
    let saved = state.saved.replace(std::ptr::null_mut());
    // SAFETY: `saved` came from `PyEval_SaveThread` on this thread and is used once.
    unsafe { ffi::PyEval_RestoreThread(saved) };
}

/// Checks for signals such as Ctrl-C, and releases the lock if no Python ran since the last call. A running simulation
/// calls this every few milliseconds.
///
/// # Errors
/// The exception that the signal's handler raises, such as `KeyboardInterrupt`.
pub fn pause() -> PyResult<()> {
    let ran = STATE.with(|state| state.ran.get());
    resume().check_signals()?;
    STATE.with(|state| state.ran.set(false));
    if !ran {
        // SAFETY: the lock is held. Until `resume`, this thread runs the scheduler, the model and bus models, none of
        // which touches Python; their callbacks (coroutines, listeners, exceptions they drop) begin with `resume`.
        let saved = unsafe { ffi::PyEval_SaveThread() };
        STATE.with(|state| state.saved.set(saved));
    }
    Ok(())
}

/// A guard of a running simulation: takes the lock again when it is dropped.
pub struct Running;

impl Drop for Running {
    fn drop(&mut self) {
        resume();
    }
}
