//! Arguments and errors that the bus models share.

use hoverlock_harness::Error;
use hoverlock_harness::bus::stream::Dialect;
use hoverlock_harness::bus::{Pause, Reset};
use hoverlock_harness::sim::{self, Dut, Signal, TaskId};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors;
use crate::handle::Handle;
use crate::wait::Trigger;

pub(super) fn failed(py: Python<'_>) -> impl FnOnce(Error) -> PyErr {
    move |error| errors::exception(py, error)
}

pub(super) fn signal_of(dut: &Dut, handle: &Handle) -> PyResult<Signal> {
    dut.signal(handle.name()).map_err(|e| errors::of_model(&e))
}

pub(super) fn reset_of(dut: &Dut, reset: Option<&Handle>, active: bool) -> PyResult<Option<Reset>> {
    let signal = reset.map(|handle| signal_of(dut, handle)).transpose()?;
    Ok(signal.map(|signal| if active { Reset::high(&signal) } else { Reset::low(&signal) }))
}

pub(super) fn dialect_of(bus: &str, ready_latency: u32) -> PyResult<Dialect> {
    match bus {
        "avalon" => Ok(Dialect::Avalon { ready_latency }),
        "axi" => Ok(Dialect::Axi),
        _ => Err(PyValueError::new_err(format!("no stream '{bus}': avalon or axi"))),
    }
}

/// Converts a pause: `None` is never, a number is the probability of a pause in each cycle, a list is a repeated
/// pattern (true: pause).
pub(super) fn pause_of(pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<Pause> {
    let Some(pause) = pause else { return Ok(Pause::Never) };
    if let Ok(probability) = pause.extract::<f64>() {
        if !(0.0..1.0).contains(&probability) {
            return Err(PyValueError::new_err(format!("a probability from 0 to less than 1, not {probability}")));
        }
        return Ok(if probability == 0.0 { Pause::Never } else { Pause::random(probability, seed) });
    }
    let pattern = pause.try_iter()?.map(|hold| hold?.is_truthy()).collect::<PyResult<Vec<bool>>>()?;
    if pattern.iter().all(|hold| *hold) {
        return Err(PyValueError::new_err("a pattern that always pauses lets nothing through"));
    }
    Ok(Pause::pattern(pattern))
}

/// A task of the engine that Python waits for; its slot is freed with the object.
pub(super) struct EngineTask {
    pub dut: Dut,
    pub id: TaskId,
}

impl EngineTask {
    /// Returns a trigger that fires when the task ends.
    pub fn ended(&self) -> Trigger {
        Trigger::new(sim::Trigger::Join(self.id))
    }
}

impl Drop for EngineTask {
    fn drop(&mut self) {
        self.dut.forget(self.id);
    }
}
