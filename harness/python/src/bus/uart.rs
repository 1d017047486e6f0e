//! UART: source and sink.

use hoverlock_harness::Time;
use hoverlock_harness::bus::uart::{Format, Parity, Sink, Source};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::{Sending, failed, signal_of};
use crate::handle::Handle;
use crate::on_thread::OnThread;
use crate::simulation;
use crate::trigger::Trigger;

fn format_of(bit: u64, bits: u32, parity: Option<&str>, stop_bits: u32) -> PyResult<Format> {
    let parity = match parity {
        None => None,
        Some("even") => Some(Parity::Even),
        Some("odd") => Some(Parity::Odd),
        Some(other) => return Err(PyValueError::new_err(format!("parity is 'even', 'odd' or None, not '{other}'"))),
    };
    Ok(Format { bits, parity, stop_bits, bit: Time::fs(bit) })
}

/// Drives a line into the design.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawUartSource(OnThread<Source>);

#[pymethods]
impl RawUartSource {
    #[new]
    fn new(py: Python<'_>, line: &Handle, bit: u64, bits: u32, parity: Option<&str>, stop_bits: u32) -> PyResult<Self> {
        let dut = simulation::current()?;
        let line = signal_of(&dut, line)?;
        let format = format_of(bit, bits, parity, stop_bits)?;
        Ok(RawUartSource(OnThread::new(Source::new(&dut, &line, format).map_err(failed(py))?)))
    }

    /// Begins to send characters.
    fn send(&self, values: Vec<u64>) -> PyResult<Sending> {
        let source = self.0.get()?.clone();
        Sending::begin("uart send", async move { source.send(&values).await })
    }
}

/// Listens to a line out of the design.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawUartSink(OnThread<Sink>);

#[pymethods]
impl RawUartSink {
    #[new]
    fn new(py: Python<'_>, line: &Handle, bit: u64, bits: u32, parity: Option<&str>, stop_bits: u32) -> PyResult<Self> {
        let dut = simulation::current()?;
        let line = signal_of(&dut, line)?;
        let format = format_of(bit, bits, parity, stop_bits)?;
        Ok(RawUartSink(OnThread::new(Sink::new(&dut, &line, format).map_err(failed(py))?)))
    }

    /// The next character, if it has come.
    fn try_recv(&self) -> PyResult<Option<u64>> {
        Ok(self.0.get()?.try_recv())
    }

    fn arrived(&self) -> PyResult<Trigger> {
        Ok(Trigger::new(self.0.get()?.arrived().trigger()))
    }

    fn count(&self) -> PyResult<u64> {
        Ok(self.0.get()?.count())
    }
}
