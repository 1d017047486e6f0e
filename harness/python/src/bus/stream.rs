//! Avalon-ST and AXI4-Stream: sources, sinks and monitors.

use std::cell::RefCell;
use std::rc::Rc;

use hoverlock_harness::Error;
use hoverlock_harness::bus::stream::{self, Dialect, Frame, Ports, Rules};
use hoverlock_harness::sim::Dut;
use numpy::PyArray1;
use pyo3::prelude::*;

use super::{EngineTask, dialect_of, failed, pause_of, reset_of, signal_of};
use crate::handle::Handle;
use crate::simulation;
use crate::trigger::Trigger;

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

/// Symbols of a stream without packets that are waited for.
#[pyclass(unsendable, module = "hoverlock._core")]
pub struct Symbols {
    task: EngineTask,
    value: Rc<RefCell<Vec<u64>>>,
}

#[pymethods]
impl Symbols {
    fn ended(&self) -> Trigger {
        self.task.ended()
    }

    fn value<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        PyArray1::from_vec(py, self.value.take())
    }
}

/// Drives a stream.
#[pyclass(unsendable, module = "hoverlock._core")]
pub struct RawSource {
    source: stream::Source,
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
        let dut = simulation::current()?;
        let ports = ports_of(py, &dut, prefix, dialect_of(bus, ready_latency)?, symbol_bits)?;
        let reset = reset_of(&dut, reset.as_deref(), reset_active)?;
        let source = stream::Source::new(&dut, &signal_of(&dut, clock)?, ports, reset).map_err(failed(py))?;
        Ok(RawSource { source })
    }

    fn send(&self, py: Python<'_>, symbols: Vec<u64>, channel: u64, error: u64, destination: u64) -> PyResult<()> {
        self.source.send(&Frame { symbols, channel, error, destination }).map_err(failed(py))
    }

    fn set_pause(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        self.source.set_pause(pause_of(pause, seed)?);
        Ok(())
    }

    fn drained(&self) -> Trigger {
        Trigger::new(self.source.idle().trigger())
    }

    fn sent(&self) -> u64 {
        self.source.sent()
    }

    fn pending(&self) -> usize {
        self.source.pending()
    }
}

enum Hears {
    Sink(stream::Sink),
    Monitor(stream::Monitor),
}

/// Takes a stream, or listens to one.
#[pyclass(unsendable, module = "hoverlock._core")]
pub struct RawListener {
    hears: Hears,
}

macro_rules! either {
    ($self:ident, $name:ident => $call:expr) => {
        match &$self.hears {
            Hears::Sink($name) => $call,
            Hears::Monitor($name) => $call,
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
        let dut = simulation::current()?;
        let ports = ports_of(py, &dut, prefix, dialect_of(bus, ready_latency)?, symbol_bits)?;
        let reset = reset_of(&dut, reset.as_deref(), reset_active)?;
        let rules = if strict { Rules::Strict } else { Rules::Recorded };
        let clock = signal_of(&dut, clock)?;
        let hears = if drives {
            Hears::Sink(stream::Sink::new(&dut, &clock, ports, reset, rules).map_err(failed(py))?)
        } else {
            Hears::Monitor(stream::Monitor::new(&dut, &clock, ports, reset, rules).map_err(failed(py))?)
        };
        Ok(RawListener { hears })
    }

    fn try_recv<'py>(&self, py: Python<'py>) -> Option<FrameParts<'py>> {
        either!(self, l => l.try_recv()).map(|frame| parts_of(py, frame))
    }

    fn recv_symbols(&self, count: usize) -> PyResult<Symbols> {
        let value = Rc::new(RefCell::default());
        let slot = value.clone();
        let dut = simulation::current()?;
        let task = either!(self, l => {
            let listener = l.clone();
            dut.spawn("recv_symbols", async move {
                *slot.borrow_mut() = listener.recv_symbols(count).await;
                Ok::<(), Error>(())
            })
        });
        Ok(Symbols { task: EngineTask { id: task.id(), dut }, value })
    }

    fn arrived(&self) -> Trigger {
        Trigger::new(either!(self, l => l.arrived()).trigger())
    }

    fn set_pause(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        if let Hears::Sink(sink) = &self.hears {
            sink.set_pause(pause_of(pause, seed)?);
        }
        Ok(())
    }

    fn __len__(&self) -> usize {
        either!(self, l => l.len())
    }

    fn beats(&self) -> u64 {
        either!(self, l => l.beats())
    }

    fn violations(&self) -> Vec<String> {
        either!(self, l => l.violations()).iter().map(ToString::to_string).collect()
    }
}
