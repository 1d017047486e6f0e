//! Bus models of the engine: streams and memory-mapped masters and memories, and whole frames as numpy arrays.

use std::cell::RefCell;
use std::future::Future;
use std::rc::Rc;

use hoverlock_harness::bus::bulk::{Bulk, Element, Options, Report};
use hoverlock_harness::bus::stream::{self, Dialect, Frame, Ports, Rules};
use hoverlock_harness::bus::{Pause, Reset, avalon_mm, axi_lite};
use hoverlock_harness::sim::{self, Clock, Dut, Signal, Sim, TaskId};
use hoverlock_harness::{Error, Time};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::errors;
use crate::gil;
use crate::handle::Handle;
use crate::simulation;
use crate::trigger::Trigger;

fn failed(py: Python<'_>) -> impl FnOnce(Error) -> PyErr {
    move |error| errors::exception(py, error)
}

fn signal_of(dut: &Dut, handle: &Handle) -> PyResult<Signal> {
    dut.signal(handle.name()).map_err(|e| errors::of_model(&e))
}

fn reset_of(dut: &Dut, reset: Option<&Handle>, active: bool) -> PyResult<Option<Reset>> {
    let signal = reset.map(|handle| signal_of(dut, handle)).transpose()?;
    Ok(signal.map(|signal| if active { Reset::high(&signal) } else { Reset::low(&signal) }))
}

fn dialect_of(bus: &str, ready_latency: u32) -> PyResult<Dialect> {
    match bus {
        "avalon" => Ok(Dialect::Avalon { ready_latency }),
        "axi" => Ok(Dialect::Axi),
        _ => Err(PyValueError::new_err(format!("no stream '{bus}': avalon or axi"))),
    }
}

/// Nothing: never; a number: with that probability, from the seed; a list: as it says, again and again.
fn pause_of(pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<Pause> {
    let Some(pause) = pause else { return Ok(Pause::Never) };
    if let Ok(probability) = pause.extract::<f64>() {
        if !(0.0..1.0).contains(&probability) {
            return Err(PyValueError::new_err(format!("a probability from 0 to less than 1, not {probability}")));
        }
        return Ok(if probability == 0.0 { Pause::Never } else { Pause::random(probability, seed) });
    }
    let pattern = pause.try_iter()?.map(|hold| hold?.is_truthy()).collect::<PyResult<Vec<bool>>>()?;
    if pattern.iter().all(|hold| *hold) {
        return Err(PyValueError::new_err("a pattern that always holds back lets nothing through"));
    }
    Ok(Pause::pattern(pattern))
}

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
    task: Engine,
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
        Ok(Symbols { task: Engine { id: task.id(), dut }, value })
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

/// A task of the engine that Python waits for; forgotten with the object.
struct Engine {
    dut: Dut,
    id: TaskId,
}

impl Engine {
    fn ended(&self) -> Trigger {
        Trigger::new(sim::Trigger::Join(self.id))
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.dut.forget(self.id);
    }
}

/// An access of a master that is under way.
#[pyclass(unsendable, module = "hoverlock._core")]
pub struct Access {
    task: Engine,
    value: Rc<RefCell<Option<(u64, u64)>>>,
}

#[pymethods]
impl Access {
    fn ended(&self) -> Trigger {
        self.task.ended()
    }

    /// The word read, and the response.
    fn value(&self) -> (u64, u64) {
        self.value.borrow().unwrap_or_default()
    }
}

fn access(name: &str, work: impl Future<Output = Result<(u64, u64), Error>> + 'static) -> PyResult<Access> {
    let value = Rc::new(RefCell::new(None));
    let slot = value.clone();
    let dut = simulation::current()?;
    let task = dut.spawn(name, async move {
        *slot.borrow_mut() = Some(work.await?);
        Ok::<(), Error>(())
    });
    Ok(Access { task: Engine { id: task.id(), dut }, value })
}

/// A burst of a master that is under way.
#[pyclass(unsendable, module = "hoverlock._core")]
pub struct Burst {
    task: Engine,
    words: Rc<RefCell<Vec<u64>>>,
}

#[pymethods]
impl Burst {
    fn ended(&self) -> Trigger {
        self.task.ended()
    }

    /// The words read; none of a write.
    fn words<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        PyArray1::from_vec(py, self.words.take())
    }
}

fn burst(name: &str, work: impl Future<Output = Result<Vec<u64>, Error>> + 'static) -> PyResult<Burst> {
    let words = Rc::new(RefCell::default());
    let slot = words.clone();
    let dut = simulation::current()?;
    let task = dut.spawn(name, async move {
        *slot.borrow_mut() = work.await?;
        Ok::<(), Error>(())
    });
    Ok(Burst { task: Engine { id: task.id(), dut }, words })
}

enum Speaks {
    Avalon(avalon_mm::Master),
    Axi(axi_lite::Master),
}

/// Reads and writes registers.
#[pyclass(unsendable, module = "hoverlock._core")]
pub struct RawMaster {
    speaks: Speaks,
}

#[pymethods]
impl RawMaster {
    #[new]
    fn new(py: Python<'_>, prefix: &str, clock: &Handle, bus: &str, read_latency: u64) -> PyResult<RawMaster> {
        let dut = simulation::current()?;
        let clock = signal_of(&dut, clock)?;
        let speaks = if bus == "axi" {
            Speaks::Axi(axi_lite::Master::new(&dut, &clock, prefix).map_err(failed(py))?)
        } else {
            Speaks::Avalon(avalon_mm::Master::new(&dut, &clock, prefix, read_latency).map_err(failed(py))?)
        };
        Ok(RawMaster { speaks })
    }

    fn set_pause(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        match &self.speaks {
            Speaks::Avalon(_) => {
                Err(PyTypeError::new_err("an Avalon-MM master does not hold back: await between accesses"))
            }
            Speaks::Axi(master) => {
                master.set_pause(pause_of(pause, seed)?);
                Ok(())
            }
        }
    }

    fn write(&self, address: u64, data: u64, bytes: Option<u64>) -> PyResult<Access> {
        match &self.speaks {
            Speaks::Avalon(master) => {
                let master = master.clone();
                access("write", async move {
                    match bytes {
                        Some(bytes) => master.write_bytes(address, data, bytes).await?,
                        None => master.write(address, data).await?,
                    }
                    Ok((0, 0))
                })
            }
            Speaks::Axi(master) => {
                let master = master.clone();
                access("write", async move {
                    let response = match bytes {
                        Some(bytes) => master.write_bytes(address, data, bytes).await?,
                        None => master.write(address, data).await?,
                    };
                    Ok((0, response as u64))
                })
            }
        }
    }

    fn read(&self, address: u64) -> PyResult<Access> {
        match &self.speaks {
            Speaks::Avalon(master) => {
                let master = master.clone();
                access("read", async move { Ok((master.read(address).await?, 0)) })
            }
            Speaks::Axi(master) => {
                let master = master.clone();
                access("read", async move {
                    let (word, response) = master.read(address).await?;
                    Ok((word, response as u64))
                })
            }
        }
    }

    fn write_burst(
        &self,
        address: u64,
        words: Vec<u64>,
        pause: Option<&Bound<'_, PyAny>>,
        seed: u64,
    ) -> PyResult<Burst> {
        let (master, pause) = (self.avalon()?.clone(), pause_of(pause, seed)?);
        burst("write_burst", async move {
            master.write_burst(address, &words, pause).await?;
            Ok(Vec::new())
        })
    }

    fn read_burst(&self, address: u64, count: usize) -> PyResult<Burst> {
        let master = self.avalon()?.clone();
        burst("read_burst", async move { master.read_burst(address, count).await })
    }
}

impl RawMaster {
    fn avalon(&self) -> PyResult<&avalon_mm::Master> {
        match &self.speaks {
            Speaks::Avalon(master) => Ok(master),
            Speaks::Axi(_) => Err(PyTypeError::new_err("AXI4-Lite has no bursts")),
        }
    }
}

enum Answers {
    Avalon(avalon_mm::Memory),
    Axi(axi_lite::Memory),
}

/// A memory that a master in the design reads and writes.
#[pyclass(unsendable, module = "hoverlock._core")]
pub struct RawMemory {
    answers: Answers,
}

#[pymethods]
impl RawMemory {
    #[new]
    fn new(
        py: Python<'_>,
        prefix: &str,
        clock: &Handle,
        bus: &str,
        reset: Option<PyRef<'_, Handle>>,
        reset_active: bool,
    ) -> PyResult<RawMemory> {
        let dut = simulation::current()?;
        let clock = signal_of(&dut, clock)?;
        let reset = reset_of(&dut, reset.as_deref(), reset_active)?;
        let answers = if bus == "axi" {
            Answers::Axi(axi_lite::Memory::new(&dut, &clock, prefix, reset).map_err(failed(py))?)
        } else {
            Answers::Avalon(avalon_mm::Memory::new(&dut, &clock, prefix, reset).map_err(failed(py))?)
        };
        Ok(RawMemory { answers })
    }

    fn set_stall(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        let pause = pause_of(pause, seed)?;
        match &self.answers {
            Answers::Avalon(memory) => memory.set_stall(pause),
            Answers::Axi(memory) => memory.set_stall(pause),
        }
        Ok(())
    }

    /// How many cycles an answer takes, drawn anew for each read.
    fn set_latency(&self, least: u64, most: u64, seed: u64) -> PyResult<()> {
        if least == 0 || most < least {
            return Err(PyValueError::new_err(format!("a latency of {least} to {most} cycles: 1 at least, most last")));
        }
        match &self.answers {
            Answers::Avalon(memory) => memory.set_latency(least, most, seed),
            Answers::Axi(_) => return Err(PyTypeError::new_err("AXI4-Lite answers when `stall` lets it")),
        }
        Ok(())
    }

    /// How far apart the addresses of a burst's words are.
    fn set_step(&self, step: u64) -> PyResult<()> {
        match &self.answers {
            Answers::Avalon(memory) => memory.set_step(step),
            Answers::Axi(_) => return Err(PyTypeError::new_err("AXI4-Lite has no bursts")),
        }
        Ok(())
    }

    /// Words from an address on, `step` addresses apart.
    fn read<'py>(&self, py: Python<'py>, address: u64, count: usize, step: u64) -> Bound<'py, PyArray1<u64>> {
        PyArray1::from_vec(py, (0..count as u64).map(|at| self.__getitem__(address + at * step)).collect())
    }

    /// Writes words from an address on.
    fn write(&self, address: u64, words: Vec<u64>, step: u64) {
        (0..).zip(words).for_each(|(at, word): (u64, u64)| self.__setitem__(address + at * step, word));
    }

    fn __getitem__(&self, address: u64) -> u64 {
        match &self.answers {
            Answers::Avalon(memory) => memory.get(address),
            Answers::Axi(memory) => memory.get(address),
        }
    }

    fn __setitem__(&self, address: u64, word: u64) {
        match &self.answers {
            Answers::Avalon(memory) => memory.set(address, word),
            Answers::Axi(memory) => memory.set(address, word),
        }
    }

    fn accesses(&self) -> u64 {
        match &self.answers {
            Answers::Avalon(memory) => memory.accesses(),
            Answers::Axi(memory) => memory.accesses(),
        }
    }
}

/// What a transfer is asked for.
pub struct Transfer<'a> {
    pub input: &'a str,
    pub output: &'a str,
    pub dialect: Dialect,
    pub clock: Clock,
    /// Words, or as many as are sent unless packets are counted.
    pub expect: Option<usize>,
    pub options: Options,
}

/// What the design gave, and `(cycles, sent, received, packets)`.
pub type Transferred<'py> = (Bound<'py, PyAny>, (u64, usize, usize, usize));

impl<'a> Transfer<'a> {
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    pub fn new(
        py: Python<'_>,
        dut: &Dut,
        input: &'a str,
        output: &'a str,
        bus: &str,
        ready_latency: u32,
        clock: &str,
        period: u64,
        idle: Option<&Bound<'_, PyAny>>,
        stall: Option<&Bound<'_, PyAny>>,
        seed: u64,
        packet: usize,
        expect: Option<usize>,
        packets: usize,
        most_cycles: u64,
    ) -> PyResult<Transfer<'a>> {
        let (idle, stall) = (pause_of(idle, seed)?, pause_of(stall, seed ^ 0x9E37_79B9_7F4A_7C15)?);
        let dialect = dialect_of(bus, ready_latency)?;
        let clock = dut.clock(clock, Time::fs(period)).map_err(failed(py))?;
        let options = Options { idle, stall, packet, expect: 0, packets, most_cycles };
        Ok(Transfer { input, output, dialect, clock, expect, options })
    }

    /// Sends an array of the words that the input's storage has, and gives one of the output's.
    pub fn run<'py>(&self, sim: &mut Sim, words: &Bound<'py, PyAny>) -> PyResult<Transferred<'py>> {
        let kind = words.cast::<PyUntypedArray>()?.dtype().to_string();
        let bits =
            sim.dut().wide(&format!("{}{}", self.output, if self.dialect == Dialect::Axi { "tdata" } else { "data" }));
        let bits = bits.map_err(|e| errors::of_model(&e))?.width();
        match kind.as_str() {
            "uint8" => self.from::<u8>(sim, words, bits),
            "uint16" => self.from::<u16>(sim, words, bits),
            "uint32" => self.from::<u32>(sim, words, bits),
            "uint64" => self.from::<u64>(sim, words, bits),
            _ => Err(PyTypeError::new_err(format!("words are uint8, uint16, uint32 or uint64, not {kind}"))),
        }
    }

    fn from<'py, I>(&self, sim: &mut Sim, words: &Bound<'py, PyAny>, bits: u32) -> PyResult<Transferred<'py>>
    where
        I: Element + numpy::Element + Sync,
    {
        match bits {
            0..=8 => self.between::<I, u8>(sim, words),
            9..=16 => self.between::<I, u16>(sim, words),
            33..=64 => self.between::<I, u64>(sim, words),
            _ => self.between::<I, u32>(sim, words),
        }
    }

    fn between<'py, I, O>(&self, sim: &mut Sim, words: &Bound<'py, PyAny>) -> PyResult<Transferred<'py>>
    where
        I: Element + numpy::Element,
        O: Element + numpy::Element,
    {
        let py = words.py();
        let words: PyReadonlyArray1<'py, I> = words.extract()?;
        let mut bulk =
            Bulk::<I, O>::new(&sim.dut(), &self.clock, self.input, self.output, self.dialect).map_err(failed(py))?;
        let words = words.as_slice()?;
        let (parts, parts_out) = bulk.parts();
        let mut options = self.options.clone();
        options.expect = match self.expect {
            Some(count) => count,
            None if options.packets > 0 => 0,
            None => words.len() / parts,
        };
        let mut received = Vec::new();
        let ended = bulk.transfer(sim, words, &mut received, &options);
        // A long transfer gave the interpreter's lock back.
        gil::resume();
        let report: Report = ended.map_err(failed(py))?;
        let received = PyArray1::from_vec(py, received);
        let received = if parts_out == 1 {
            received.into_bound_py_any(py)?
        } else {
            received.reshape([report.received, parts_out])?.into_bound_py_any(py)?
        };
        Ok((received, (report.cycles, report.sent, report.received, report.packets)))
    }
}
