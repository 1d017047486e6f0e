//! Avalon-ST and AXI4-Stream: sources, sinks and monitors.

use std::cell::RefCell;
use std::rc::Rc;

use hoverlock_harness::Error;
use hoverlock_harness::bus::stream::{self, Dialect, Frame, Ports, Rules};
use hoverlock_harness::sim::Dut;
use numpy::PyArray1;
use pyo3::prelude::*;

use super::common::{EngineTask, dialect_of, failed, pause_of, reset_of, signal_of};
use crate::handle::Handle;
use crate::on_thread::OnThread;
use crate::running;
use crate::wait::Trigger;

fn ports_of(py: Python<'_>, dut: &Dut, prefix: &str, dialect: Dialect, symbol_bits: Option<u32>) -> PyResult<Ports> {
    let ports = Ports::find(dut, prefix, dialect).map_err(failed(py))?;
    match symbol_bits {
        Some(bits) => ports.symbols_of(bits).map_err(failed(py)),
        None => Ok(ports),
    }
}

/// Symbols, channel (`tid`), error (`tuser`), destination (`tdest`).
type FrameParts<'py> = (Bound<'py, PyArray1<u64>>, u64, u64, u64);

fn parts_of(py: Python<'_>, frame: Frame) -> FrameParts<'_> {
    (PyArray1::from_vec(py, frame.symbols), frame.channel, frame.error, frame.destination)
}

/// A wait for symbols of a stream without packets.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct Symbols {
    task: OnThread<EngineTask>,
    value: OnThread<Rc<RefCell<Vec<u64>>>>,
}

#[pymethods]
impl Symbols {
    fn ended(&self) -> PyResult<Trigger> {
        Ok(self.task.get()?.ended())
    }

    fn value<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u64>>> {
        Ok(PyArray1::from_vec(py, self.value.get()?.take()))
    }
}

/// The driver of a stream.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawSource {
    source: OnThread<stream::Source>,
}

#[pymethods]
impl RawSource {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        py: Python<'_>,
        prefix: &str,
        clock: &Handle,
        bus: &str,
        ready_latency: u32,
        symbol_bits: Option<u32>,
        reset: Option<PyRef<'_, Handle>>,
        reset_active: bool,
    ) -> PyResult<RawSource> {
        let dut = running::current()?;
        let ports = ports_of(py, &dut, prefix, dialect_of(bus, ready_latency)?, symbol_bits)?;
        let reset = reset_of(&dut, reset.as_deref(), reset_active)?;
        let source = stream::Source::new(&dut, &signal_of(&dut, clock)?, ports, reset).map_err(failed(py))?;
        Ok(RawSource { source: OnThread::new(source) })
    }

    fn send(&self, py: Python<'_>, symbols: Vec<u64>, channel: u64, error: u64, destination: u64) -> PyResult<()> {
        self.source.get()?.send(&Frame { symbols, channel, error, destination, ..Frame::default() }).map_err(failed(py))
    }

    fn set_pause(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        self.source.get()?.set_pause(pause_of(pause, seed)?);
        Ok(())
    }

    fn clear(&self) -> PyResult<()> {
        self.source.get()?.clear();
        Ok(())
    }

    fn drained(&self) -> PyResult<Trigger> {
        Ok(Trigger::new(self.source.get()?.idle().trigger()))
    }

    fn sent(&self) -> PyResult<u64> {
        Ok(self.source.get()?.sent())
    }

    fn pending(&self) -> PyResult<usize> {
        Ok(self.source.get()?.pending())
    }
}

/// A sink, which drives `ready`, or a monitor, which drives nothing.
enum Receiver {
    Sink(stream::Sink),
    Monitor(stream::Monitor),
}

/// The receiver of a stream: a sink or a monitor.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawListener {
    receiver: OnThread<Receiver>,
}

macro_rules! either {
    ($self:ident, $name:ident => $call:expr) => {
        match $self.receiver.get()? {
            Receiver::Sink($name) => $call,
            Receiver::Monitor($name) => $call,
        }
    };
}

#[pymethods]
impl RawListener {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        py: Python<'_>,
        drives: bool,
        prefix: &str,
        clock: &Handle,
        bus: &str,
        ready_latency: u32,
        symbol_bits: Option<u32>,
        reset: Option<PyRef<'_, Handle>>,
        reset_active: bool,
        strict: bool,
    ) -> PyResult<RawListener> {
        let dut = running::current()?;
        let ports = ports_of(py, &dut, prefix, dialect_of(bus, ready_latency)?, symbol_bits)?;
        let reset = reset_of(&dut, reset.as_deref(), reset_active)?;
        let rules = if strict { Rules::Strict } else { Rules::Recorded };
        let clock = signal_of(&dut, clock)?;
        let receiver = if drives {
            Receiver::Sink(stream::Sink::new(&dut, &clock, ports, reset, rules).map_err(failed(py))?)
        } else {
            Receiver::Monitor(stream::Monitor::new(&dut, &clock, ports, reset, rules).map_err(failed(py))?)
        };
        Ok(RawListener { receiver: OnThread::new(receiver) })
    }

    fn try_recv<'py>(&self, py: Python<'py>) -> PyResult<Option<FrameParts<'py>>> {
        Ok(either!(self, l => l.try_recv()).map(|frame| parts_of(py, frame)))
    }

    fn recv_symbols(&self, count: usize) -> PyResult<Symbols> {
        let value = Rc::new(RefCell::default());
        let slot = value.clone();
        let dut = running::current()?;
        let task = either!(self, l => {
            let listener = l.clone();
            dut.spawn("recv_symbols", async move {
                *slot.borrow_mut() = listener.recv_symbols(count).await;
                Ok::<(), Error>(())
            })
        });
        Ok(Symbols { task: OnThread::new(EngineTask { id: task.id(), dut }), value: OnThread::new(value) })
    }

    fn clear(&self) -> PyResult<()> {
        either!(self, l => l.clear());
        Ok(())
    }

    fn arrived(&self) -> PyResult<Trigger> {
        Ok(Trigger::new(either!(self, l => l.arrived()).trigger()))
    }

    fn set_pause(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        if let Receiver::Sink(sink) = self.receiver.get()? {
            sink.set_pause(pause_of(pause, seed)?);
        }
        Ok(())
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(either!(self, l => l.len()))
    }

    fn beats(&self) -> PyResult<u64> {
        Ok(either!(self, l => l.beats()))
    }

    fn violations(&self) -> PyResult<Vec<String>> {
        Ok(either!(self, l => l.violations()).iter().map(ToString::to_string).collect())
    }
}
