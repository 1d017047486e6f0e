//! Which simulation runs on this thread.

use std::cell::{Cell, RefCell};

use hoverlock_harness::sim::{Dut, Region};
use pyo3::ffi;
use pyo3::prelude::*;

use crate::errors::SimulationError;
use crate::wait::Task;

thread_local! {
    /// The task whose coroutine runs on this thread; null if none runs.
    static TASK: Cell<*mut ffi::PyObject> = const { Cell::new(std::ptr::null_mut()) };
    /// The simulations that are running on this thread, the innermost last.
    static RUNNING: RefCell<Vec<Dut>> = const { RefCell::new(Vec::new()) };
}

/// Returns the simulation that runs on this thread.
///
/// # Errors
/// `SimulationError` if none runs.
pub fn current() -> PyResult<Dut> {
    RUNNING
        .with_borrow(|running| running.last().cloned())
        .ok_or_else(|| SimulationError::new_err("no simulation is running: this can only be used from inside a test"))
}

/// Returns `true` if a simulation runs on this thread and `is_it` accepts it.
pub fn is_current(is_it: impl FnOnce(&Dut) -> bool) -> bool {
    RUNNING.with_borrow(|running| running.last().is_some_and(is_it))
}

/// Returns `true` if a simulation runs on this thread.
pub fn is_running() -> bool {
    RUNNING.with_borrow(|running| !running.is_empty())
}

/// Calls `work`, which runs the coroutine of `task`.
#[inline]
pub fn with_task<T>(task: &Py<Task>, work: impl FnOnce() -> T) -> T {
    /// Restores the task that ran before, also when `work` panics.
    struct Restore(*mut ffi::PyObject);
    impl Drop for Restore {
        fn drop(&mut self) {
            TASK.set(self.0);
        }
    }
    let _restore = Restore(TASK.replace(task.as_ptr()));
    work()
}

/// The task that runs.
///
/// >>> current_task().get_name()
#[pyfunction]
pub fn current_task(py: Python<'_>) -> PyResult<Py<PyAny>> {
    // SAFETY: `with_task` has a reference to the task for as long as the pointer is set.
    unsafe { Bound::from_borrowed_ptr_or_opt(py, TASK.get()) }
        .map(Bound::unbind)
        .ok_or_else(|| SimulationError::new_err("no task is running: current_task is called from a coroutine"))
}

/// A guard: the simulation is the current one of this thread until the guard is dropped.
pub struct Entered;

impl Entered {
    /// Makes `dut` the current simulation of this thread.
    pub fn new(dut: Dut) -> Entered {
        RUNNING.with_borrow_mut(|running| running.push(dut));
        Entered
    }
}

impl Drop for Entered {
    fn drop(&mut self) {
        RUNNING.with_borrow_mut(|running| drop(running.pop()));
    }
}

/// Returns the simulation time in femtoseconds; 0 if no simulation runs.
#[pyfunction]
pub fn now() -> u64 {
    RUNNING.with_borrow(|running| running.last().map_or(0, |dut| dut.now().as_fs()))
}

/// Returns the region of the time step: `Active`, `ReadWrite` or `ReadOnly`.
#[pyfunction]
pub fn region() -> PyResult<&'static str> {
    Ok(match current()?.region() {
        Region::Active => "Active",
        Region::ReadWrite => "ReadWrite",
        Region::ReadOnly => "ReadOnly",
    })
}
