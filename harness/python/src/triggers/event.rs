//! Events and locks between the tasks of a bench.

use std::cell::{Cell, RefCell};
use std::sync::{Mutex, MutexGuard, PoisonError};

use hoverlock_harness::sim;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{PyTraverseError, PyVisit};

use crate::errors;
use crate::on_thread::OnThread;
use crate::running;
use crate::wait::Trigger;

/// An event. It belongs to the simulation in which it is used, and keeps its state for the next one.
#[pyclass(frozen, subclass, module = "hoverlock._core", name = "RawEvent")]
pub struct RawEvent {
    /// The argument of the last `set`.
    data: Mutex<Option<Py<PyAny>>>,
    /// Whether it is set, before any simulation runs.
    flag: OnThread<Cell<bool>>,
    event: OnThread<RefCell<Option<sim::Event>>>,
}

impl RawEvent {
    /// Returns the engine's event in the running simulation, created at its first use there.
    fn event(slf: &Bound<'_, Self>) -> PyResult<sim::Event> {
        let this = slf.get();
        let mut slot = this.event.get()?.borrow_mut();
        if let Some(event) = slot.as_ref()
            && running::is_current(|dut| dut.has_event(event))
        {
            return Ok(event.clone());
        }
        let dut = running::current()?;
        let is_set = slot.as_ref().map_or(this.flag.get()?.get(), sim::Event::is_set);
        let name: String = slf.getattr(intern!(slf.py(), "name"))?.str()?.extract()?;
        let event = dut.event(&name);
        if is_set {
            event.set();
        }
        *slot = Some(event.clone());
        Ok(event)
    }

    /// Stores the state while no simulation runs.
    fn put(&self, is_set: bool) -> PyResult<()> {
        *self.event.get()?.borrow_mut() = None;
        self.flag.get()?.set(is_set);
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, Option<Py<PyAny>>> {
        self.data.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl RawEvent {
    /// Ignores the arguments: the Python class derived from this one sets `name` in its `__init__`.
    #[new]
    #[pyo3(signature = (*_args, **_named))]
    fn new(_args: &Bound<'_, PyTuple>, _named: Option<&Bound<'_, PyDict>>) -> Self {
        RawEvent {
            data: Mutex::default(),
            flag: OnThread::new(Cell::new(false)),
            event: OnThread::new(RefCell::default()),
        }
    }

    /// Sets the event: all tasks that wait for it continue.
    #[pyo3(signature = (data = None))]
    fn set(slf: &Bound<'_, Self>, data: Option<Py<PyAny>>) -> PyResult<()> {
        if data.is_some() {
            slf.call_method0(intern!(slf.py(), "_set_with_data"))?;
        }
        // The old data is dropped after the lock is released, because dropping it may run any Python.
        let _old = std::mem::replace(&mut *slf.get().lock(), data);
        if !running::is_running() {
            return slf.get().put(true);
        }
        RawEvent::event(slf)?.set();
        Ok(())
    }

    /// Clears the event.
    fn clear(slf: &Bound<'_, Self>) -> PyResult<()> {
        if !running::is_running() {
            return slf.get().put(false);
        }
        RawEvent::event(slf)?.clear();
        Ok(())
    }

    /// Whether the event is set.
    fn is_set(&self) -> PyResult<bool> {
        let flag = self.flag.get()?.get();
        Ok(self.event.get()?.borrow().as_ref().map_or(flag, sim::Event::is_set))
    }

    /// A trigger: the event is set, or is set already.
    fn wait(slf: &Bound<'_, Self>) -> PyResult<Trigger> {
        Ok(Trigger::new(RawEvent::event(slf)?.trigger()))
    }

    /// The argument of the last `set`, or None.
    #[getter]
    fn data(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.lock().as_ref().map(|data| data.clone_ref(py))
    }

    #[setter]
    fn set_data(&self, data: Option<Py<PyAny>>) {
        let _old = std::mem::replace(&mut *self.lock(), data);
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.lock().as_ref().map_or(Ok(()), |data| visit.call(data))
    }

    fn __clear__(&self) {
        let _old = self.lock().take();
    }
}

/// A lock. It belongs to the simulation in which it is used, and is free at the beginning of each.
#[pyclass(frozen, module = "hoverlock._core", name = "RawLock")]
pub struct RawLock {
    name: String,
    lock: OnThread<RefCell<Option<sim::Lock>>>,
}

#[pymethods]
impl RawLock {
    #[new]
    fn new(name: String) -> Self {
        RawLock { name, lock: OnThread::new(RefCell::default()) }
    }

    fn locked(&self) -> PyResult<bool> {
        let slot = self.lock.get()?.borrow();
        Ok(match (slot.as_ref(), running::current()) {
            (Some(lock), Ok(dut)) => dut.has_lock(lock) && lock.is_locked(),
            _ => false,
        })
    }

    fn acquire(&self) -> PyResult<Trigger> {
        let dut = running::current()?;
        let mut slot = self.lock.get()?.borrow_mut();
        if let Some(lock) = slot.as_ref().filter(|lock| dut.has_lock(lock)) {
            return Ok(Trigger::new(lock.trigger()));
        }
        let lock = dut.lock(&self.name);
        let trigger = Trigger::new(lock.trigger());
        *slot = Some(lock);
        Ok(trigger)
    }

    fn release(&self) -> PyResult<()> {
        match self.lock.get()?.borrow().as_ref().filter(|lock| lock.is_locked()) {
            Some(lock) => {
                lock.release();
                Ok(())
            }
            None => Err(errors::TriggerError::new_err(format!(
                "the lock '{}' was released, but no task holds it",
                self.name
            ))),
        }
    }
}
