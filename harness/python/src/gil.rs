//! The interpreter's lock while a simulation runs.
//!
//! A coroutine is resumed up to millions of times a second, too often to take and release the lock each time. So `run`
//! keeps it, and releases it when no Python runs: after a few milliseconds of simulation in which no coroutine was
//! resumed. The next resume takes it again.

use std::cell::Cell;
use std::rc::Rc;

use pyo3::ffi;
use pyo3::prelude::*;

struct State {
    /// The thread's state while the lock is given back, otherwise null.
    saved: Cell<*mut ffi::PyThreadState>,
    /// Whether Python ran since `pause` was last called.
    ran: Cell<bool>,
}

thread_local! {
    static STATE: Rc<State> = Rc::new(State { saved: Cell::new(std::ptr::null_mut()), ran: Cell::new(false) });
}

/// The lock as the simulations of this thread hold it. To ask for it costs more than to use it: what uses it often
/// keeps it.
#[derive(Clone)]
pub struct Lock(Rc<State>);

impl Lock {
    /// That of this thread.
    pub fn here() -> Lock {
        STATE.with(|state| Lock(state.clone()))
    }

    /// Takes the lock again if it was given back; for code that a running simulation calls.
    #[inline(always)]
    pub fn resume<'a>(&self) -> Python<'a> {
        self.0.ran.set(true);
        if !self.0.saved.get().is_null() {
            take_back(&self.0);
        }
        // SAFETY: only called below methods of `Simulation` that run it, which were called from Python on this thread;
        // the lock is held unless `pause` gave it back, and `take_back` has undone that.
        unsafe { Python::assume_attached() }
    }
}

/// The same for what does so rarely.
pub fn resume<'a>() -> Python<'a> {
    Lock::here().resume()
}

#[cold]
fn take_back(state: &State) {
    let saved = state.saved.replace(std::ptr::null_mut());
    // SAFETY: `saved` came from `PyEval_SaveThread` on this thread and is used once.
    unsafe { ffi::PyEval_RestoreThread(saved) };
}

/// Called every few milliseconds by a running simulation: looks for signals such as Ctrl-C, and gives the lock back if
/// no Python ran since the last call.
pub fn pause() -> PyResult<()> {
    let ran = STATE.with(|state| state.ran.get());
    resume().check_signals()?;
    STATE.with(|state| state.ran.set(false));
    if !ran {
        // SAFETY: the lock is held. Until `resume`, this thread runs the scheduler, the model and bus models, none of
        // which touches Python; what they call back (coroutines, listeners, exceptions they drop) begins with `resume`.
        let saved = unsafe { ffi::PyEval_SaveThread() };
        STATE.with(|state| state.saved.set(saved));
    }
    Ok(())
}

/// Exists while a simulation runs: when it is dropped, the lock is taken again.
pub struct Running;

impl Drop for Running {
    fn drop(&mut self) {
        resume();
    }
}
