//! Avalon-MM, AXI4-Lite and AXI4: masters and memories; the checker of AXI4.

use std::cell::RefCell;
use std::future::Future;
use std::rc::Rc;

use hoverlock_harness::Error;
use hoverlock_harness::bus::{MemoryContents, Pause, avalon_mm, axi_lite, axi4};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::common::{EngineTask, failed, pause_of, reset_of, signal_of};
use crate::handle::Handle;
use crate::on_thread::OnThread;
use crate::running;
use crate::wait::Trigger;

/// The word read and the response, once the access has ended.
type Answer = Rc<RefCell<Option<(u64, u64)>>>;

/// An access of a master in progress.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct Access {
    task: OnThread<EngineTask>,
    value: OnThread<Answer>,
}

#[pymethods]
impl Access {
    fn ended(&self) -> PyResult<Trigger> {
        Ok(self.task.get()?.ended())
    }

    /// Returns the word read and the response.
    fn value(&self) -> PyResult<(u64, u64)> {
        Ok(self.value.get()?.borrow().unwrap_or_default())
    }
}

fn access(name: &str, work: impl Future<Output = Result<(u64, u64), Error>> + 'static) -> PyResult<Access> {
    let value: Answer = Rc::default();
    let slot = value.clone();
    let dut = running::current()?;
    let task = dut.spawn(name, async move {
        *slot.borrow_mut() = Some(work.await?);
        Ok::<(), Error>(())
    });
    Ok(Access { task: OnThread::new(EngineTask { id: task.id(), dut }), value: OnThread::new(value) })
}

/// A burst of a master in progress.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct Burst {
    task: OnThread<EngineTask>,
    answer: OnThread<Rc<RefCell<Words>>>,
}

/// The words read, and the response.
type Words = (Vec<u64>, u64);

#[pymethods]
impl Burst {
    fn ended(&self) -> PyResult<Trigger> {
        Ok(self.task.get()?.ended())
    }

    /// Returns the words read; an empty array for a write.
    fn words<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u64>>> {
        Ok(PyArray1::from_vec(py, std::mem::take(&mut self.answer.get()?.borrow_mut().0)))
    }

    /// Returns the response; 0 for a bus without responses.
    fn response(&self) -> PyResult<u64> {
        Ok(self.answer.get()?.borrow().1)
    }
}

fn burst(name: &str, work: impl Future<Output = Result<Words, Error>> + 'static) -> PyResult<Burst> {
    let answer = Rc::new(RefCell::default());
    let slot = answer.clone();
    let dut = running::current()?;
    let task = dut.spawn(name, async move {
        *slot.borrow_mut() = work.await?;
        Ok::<(), Error>(())
    });
    Ok(Burst { task: OnThread::new(EngineTask { id: task.id(), dut }), answer: OnThread::new(answer) })
}

/// A master of one of the buses.
enum MasterOf {
    Avalon(avalon_mm::Master),
    Axi(axi_lite::Master),
    Axi4(axi4::Master),
}

const NO_BURSTS: &str = "this bus has no bursts";
const WORDS_IN_BURSTS: &str = "AXI4: a word is a burst of one";

/// A master that reads and writes registers of the design.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawMaster {
    master: OnThread<MasterOf>,
}

#[pymethods]
impl RawMaster {
    #[new]
    fn new(py: Python<'_>, prefix: &str, clock: &Handle, bus: &str, read_latency: u64) -> PyResult<RawMaster> {
        let dut = running::current()?;
        let clock = signal_of(&dut, clock)?;
        let master = match bus {
            "axi" => MasterOf::Axi(axi_lite::Master::new(&dut, &clock, prefix).map_err(failed(py))?),
            "axi4" => MasterOf::Axi4(axi4::Master::new(&dut, &clock, prefix).map_err(failed(py))?),
            _ => MasterOf::Avalon(avalon_mm::Master::new(&dut, &clock, prefix, read_latency).map_err(failed(py))?),
        };
        Ok(RawMaster { master: OnThread::new(master) })
    }

    fn set_pause(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        match self.master.get()? {
            MasterOf::Avalon(_) => Err(PyTypeError::new_err("this master does not pause: await between accesses")),
            MasterOf::Axi(master) => {
                master.set_pause(pause_of(pause, seed)?);
                Ok(())
            }
            MasterOf::Axi4(master) => {
                master.set_pause(pause_of(pause, seed)?);
                Ok(())
            }
        }
    }

    fn write(&self, address: u64, data: u64, bytes: Option<u64>) -> PyResult<Access> {
        match self.master.get()? {
            MasterOf::Avalon(master) => {
                let master = master.clone();
                access("write", async move {
                    match bytes {
                        Some(bytes) => master.write_bytes(address, data, bytes).await?,
                        None => master.write(address, data).await?,
                    }
                    Ok((0, 0))
                })
            }
            MasterOf::Axi(master) => {
                let master = master.clone();
                access("write", async move {
                    let response = match bytes {
                        Some(bytes) => master.write_bytes(address, data, bytes).await?,
                        None => master.write(address, data).await?,
                    };
                    Ok((0, response as u64))
                })
            }
            MasterOf::Axi4(_) => Err(PyTypeError::new_err(WORDS_IN_BURSTS)),
        }
    }

    fn read(&self, address: u64) -> PyResult<Access> {
        match self.master.get()? {
            MasterOf::Avalon(master) => {
                let master = master.clone();
                access("read", async move { Ok((master.read(address).await?, 0)) })
            }
            MasterOf::Axi(master) => {
                let master = master.clone();
                access("read", async move {
                    let (word, response) = master.read(address).await?;
                    Ok((word, response as u64))
                })
            }
            MasterOf::Axi4(_) => Err(PyTypeError::new_err(WORDS_IN_BURSTS)),
        }
    }

    fn write_burst(
        &self,
        address: u64,
        words: Vec<u64>,
        pause: Option<&Bound<'_, PyAny>>,
        seed: u64,
    ) -> PyResult<Burst> {
        let pause: Pause = pause_of(pause, seed)?;
        match self.master.get()? {
            MasterOf::Avalon(master) => {
                let master = master.clone();
                burst("write_burst", async move {
                    master.write_burst(address, &words, pause).await?;
                    Ok((Vec::new(), 0))
                })
            }
            MasterOf::Axi4(master) => {
                let master = master.clone();
                burst("write_burst", async move { Ok((Vec::new(), master.write_burst(address, &words).await? as u64)) })
            }
            _ => Err(PyTypeError::new_err(NO_BURSTS)),
        }
    }

    fn read_burst(&self, address: u64, count: usize) -> PyResult<Burst> {
        match self.master.get()? {
            MasterOf::Avalon(master) => {
                let master = master.clone();
                burst("read_burst", async move { Ok((master.read_burst(address, count).await?, 0)) })
            }
            MasterOf::Axi4(master) => {
                let master = master.clone();
                burst("read_burst", async move {
                    let (words, response) = master.read_burst(address, count).await?;
                    Ok((words, response as u64))
                })
            }
            _ => Err(PyTypeError::new_err(NO_BURSTS)),
        }
    }
}

/// A memory of one of the buses.
enum MemoryOf {
    Avalon(avalon_mm::Memory),
    Axi(axi_lite::Memory),
    Axi4(axi4::Memory),
}

impl MemoryOf {
    fn contents(&self) -> &MemoryContents {
        match self {
            MemoryOf::Avalon(memory) => memory,
            MemoryOf::Axi(memory) => memory,
            MemoryOf::Axi4(memory) => memory,
        }
    }
}

/// A memory that a master in the design reads and writes.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawMemory {
    answers: OnThread<MemoryOf>,
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
        let dut = running::current()?;
        let clock = signal_of(&dut, clock)?;
        let reset = reset_of(&dut, reset.as_deref(), reset_active)?;
        let answers = match bus {
            "axi" => axi_lite::Memory::new(&dut, &clock, prefix, reset).map(MemoryOf::Axi),
            "axi4" => axi4::Memory::new(&dut, &clock, prefix, reset).map(MemoryOf::Axi4),
            _ => avalon_mm::Memory::new(&dut, &clock, prefix, reset).map(MemoryOf::Avalon),
        };
        let answers = answers.map_err(failed(py))?;
        Ok(RawMemory { answers: OnThread::new(answers) })
    }

    fn set_stall(&self, pause: Option<&Bound<'_, PyAny>>, seed: u64) -> PyResult<()> {
        let pause = pause_of(pause, seed)?;
        match self.answers.get()? {
            MemoryOf::Avalon(memory) => memory.set_stall(pause),
            MemoryOf::Axi(memory) => memory.set_stall(pause),
            MemoryOf::Axi4(memory) => memory.set_stall(pause),
        }
        Ok(())
    }

    /// Sets the range of the read latency, in cycles; each read draws its latency from it.
    fn set_latency(&self, least: u64, most: u64, seed: u64) -> PyResult<()> {
        if least == 0 || most < least {
            return Err(PyValueError::new_err(format!(
                "a latency of {least} to {most} cycles: at least 1 is needed, and the range must not be empty"
            )));
        }
        match self.answers.get()? {
            MemoryOf::Avalon(memory) => memory.set_latency(least, most, seed),
            _ => return Err(PyTypeError::new_err("of Avalon-MM only: use `stall`")),
        }
        Ok(())
    }

    /// Sets the distance between the addresses of a burst's words.
    fn set_step(&self, step: u64) -> PyResult<()> {
        match self.answers.get()? {
            MemoryOf::Avalon(memory) => memory.set_step(step),
            _ => return Err(PyTypeError::new_err("of Avalon-MM only")),
        }
        Ok(())
    }

    /// Returns `count` words that start at an address and are `step` addresses apart.
    fn read<'py>(&self, py: Python<'py>, address: u64, count: usize, step: u64) -> PyResult<Bound<'py, PyArray1<u64>>> {
        let words: PyResult<Vec<u64>> = (0..count as u64).map(|at| self.__getitem__(address + at * step)).collect();
        Ok(PyArray1::from_vec(py, words?))
    }

    /// Writes words that start at an address and are `step` addresses apart.
    fn write(&self, address: u64, words: Vec<u64>, step: u64) -> PyResult<()> {
        (0..).zip(words).try_for_each(|(at, word): (u64, u64)| self.__setitem__(address + at * step, word))
    }

    fn __getitem__(&self, address: u64) -> PyResult<u64> {
        Ok(self.answers.get()?.contents().get(address))
    }

    fn __setitem__(&self, address: u64, word: u64) -> PyResult<()> {
        self.answers.get()?.contents().set(address, word);
        Ok(())
    }

    fn accesses(&self) -> PyResult<u64> {
        Ok(self.answers.get()?.contents().accesses())
    }
}

/// Checks both sides of an AXI4 bus without driving it.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawChecker(OnThread<axi4::Checker>);

#[pymethods]
impl RawChecker {
    #[new]
    fn new(
        py: Python<'_>,
        prefix: &str,
        clock: &Handle,
        reset: Option<PyRef<'_, Handle>>,
        reset_active: bool,
    ) -> PyResult<RawChecker> {
        let dut = running::current()?;
        let clock = signal_of(&dut, clock)?;
        let reset = reset_of(&dut, reset.as_deref(), reset_active)?;
        Ok(RawChecker(OnThread::new(axi4::Checker::new(&dut, &clock, prefix, reset).map_err(failed(py))?)))
    }

    /// Returns the numbers of bursts written and read so far.
    fn bursts(&self) -> PyResult<(u64, u64)> {
        Ok(self.0.get()?.bursts())
    }
}
