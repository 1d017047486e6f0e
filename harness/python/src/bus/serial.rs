//! SPI and I2C: masters, a peripheral and a memory.

use hoverlock_harness::Time;
use hoverlock_harness::bus::i2c::{self, Line};
use hoverlock_harness::bus::spi::{self, Format, Half, Lines, Order};
use hoverlock_harness::sim::Dut;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::registers::{access, burst};
use super::{Access, Burst, Sending, failed, signal_of};
use crate::handle::Handle;
use crate::on_thread::OnThread;
use crate::simulation;
use crate::trigger::Trigger;

type HandleRef<'py> = PyRef<'py, Handle>;

/// The four lines of SPI and how words are sent on them.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawSpi(OnThread<(Lines, Format)>);

#[pymethods]
impl RawSpi {
    #[new]
    fn new(
        lines: [HandleRef<'_>; 4],
        bits: u32,
        idle_high: bool,
        trailing: bool,
        highest_first: bool,
        select_high: bool,
    ) -> PyResult<Self> {
        let dut = simulation::current()?;
        let [sclk, mosi, miso, cs] = lines.each_ref().map(|handle| signal_of(&dut, handle));
        let lines = Lines { sclk: sclk?, mosi: mosi?, miso: miso?, cs: cs? };
        let order = if highest_first { Order::HighestFirst } else { Order::LowestFirst };
        let format = Format { idle_high, trailing, bits, order, select_high };
        Ok(RawSpi(OnThread::new((lines, format))))
    }
}

/// Drives a peripheral in the design.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawSpiMaster(OnThread<spi::Master>);

#[pymethods]
impl RawSpiMaster {
    /// `half`: half a period of `sclk` in femtoseconds, or in cycles of `clock` where there is one.
    #[new]
    fn new(py: Python<'_>, spi: &RawSpi, half: u64, clock: Option<HandleRef<'_>>) -> PyResult<Self> {
        let dut = simulation::current()?;
        let half = match clock {
            Some(clock) => Half::Cycles(signal_of(&dut, &clock)?, half),
            None => Half::Time(Time::fs(half)),
        };
        let (lines, format) = spi.0.get()?;
        Ok(RawSpiMaster(OnThread::new(spi::Master::new(&dut, lines, *format, half).map_err(failed(py))?)))
    }

    /// Begins to send words; the words that come back are those of the burst.
    fn transfer(&self, words: Vec<u64>) -> PyResult<Burst> {
        let master = self.0.get()?.clone();
        burst("spi transfer", async move { Ok((master.transfer(&words).await?, 0)) })
    }
}

/// Answers a master in the design.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawSpiPeripheral(OnThread<spi::Peripheral>);

#[pymethods]
impl RawSpiPeripheral {
    #[new]
    fn new(py: Python<'_>, spi: &RawSpi) -> PyResult<Self> {
        let dut = simulation::current()?;
        let (lines, format) = spi.0.get()?;
        Ok(RawSpiPeripheral(OnThread::new(spi::Peripheral::new(&dut, lines, *format).map_err(failed(py))?)))
    }

    fn answer(&self, py: Python<'_>, words: Vec<u64>) -> PyResult<()> {
        self.0.get()?.answer(&words).map_err(failed(py))
    }

    /// The next word, if it has come.
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

/// An open-drain line.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawI2cLine(OnThread<(Dut, Line)>);

#[pymethods]
impl RawI2cLine {
    /// The level that the design gives, its tristate control if it has one, and the input for the model's side; the
    /// first is an `inout` where there is no input.
    #[new]
    fn new(
        py: Python<'_>,
        level: HandleRef<'_>,
        tristate: Option<HandleRef<'_>>,
        drive: Option<HandleRef<'_>>,
    ) -> PyResult<Self> {
        let dut = simulation::current()?;
        let level = signal_of(&dut, &level)?;
        let drive = drive.map(|handle| signal_of(&dut, &handle)).transpose()?;
        let line = match (tristate, drive) {
            (None, drive) => Line::new(&level, drive.as_ref().unwrap_or(&level)),
            (Some(tristate), Some(drive)) => Line::pad(&dut, &level, &signal_of(&dut, &tristate)?, &drive),
            (Some(_), None) => {
                return Err(PyTypeError::new_err(
                    "a tristate control without the design's input: give sda_o and scl_o, which the model drives",
                ));
            }
        };
        Ok(RawI2cLine(OnThread::new((dut, line.map_err(failed(py))?))))
    }
}

/// Reads and writes devices of the design.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawI2cMaster(OnThread<i2c::Master>);

#[pymethods]
impl RawI2cMaster {
    #[new]
    fn new(py: Python<'_>, scl: &RawI2cLine, sda: &RawI2cLine, rate: u64) -> PyResult<Self> {
        let (dut, scl) = scl.0.get()?;
        let master = i2c::Master::new(dut, scl.clone(), sda.0.get()?.1.clone(), rate).map_err(failed(py))?;
        Ok(RawI2cMaster(OnThread::new(master)))
    }

    fn start(&self) -> PyResult<Sending> {
        let master = self.0.get()?.clone();
        Sending::begin("i2c start", async move { master.start().await })
    }

    fn stop(&self) -> PyResult<Sending> {
        let master = self.0.get()?.clone();
        Sending::begin("i2c stop", async move { master.stop().await })
    }

    /// The value is 1 if the byte was acknowledged.
    fn send(&self, byte: u8) -> PyResult<Access> {
        let master = self.0.get()?.clone();
        access("i2c send", async move { Ok((u64::from(master.send(byte).await?), 0)) })
    }

    fn recv(&self, acknowledge: bool) -> PyResult<Access> {
        let master = self.0.get()?.clone();
        access("i2c recv", async move { Ok((u64::from(master.recv(acknowledge).await?), 0)) })
    }

    fn write(&self, address: u8, bytes: Vec<u8>) -> PyResult<Sending> {
        let master = self.0.get()?.clone();
        Sending::begin("i2c write", async move { master.write(address, &bytes).await })
    }

    fn read(&self, address: u8, count: usize) -> PyResult<Burst> {
        let master = self.0.get()?.clone();
        burst("i2c read", async move {
            let bytes = master.read(address, count).await?;
            Ok((bytes.into_iter().map(u64::from).collect(), 0))
        })
    }

    /// In femtoseconds.
    fn stretched(&self) -> PyResult<u64> {
        Ok(self.0.get()?.stretched().as_fs())
    }
}

/// A memory device for a master in the design.
#[pyclass(frozen, module = "hoverlock._core")]
pub struct RawI2cMemory {
    memory: OnThread<i2c::Memory>,
    size: usize,
}

#[pymethods]
impl RawI2cMemory {
    #[new]
    fn new(py: Python<'_>, scl: &RawI2cLine, sda: &RawI2cLine, address: u8, size: usize) -> PyResult<Self> {
        let (dut, scl) = scl.0.get()?;
        let memory = i2c::Memory::new(dut, scl.clone(), sda.0.get()?.1.clone(), address, size).map_err(failed(py))?;
        Ok(RawI2cMemory { memory: OnThread::new(memory), size })
    }

    /// Bytes from an address on.
    fn read(&self, at: usize, count: usize) -> PyResult<Vec<u8>> {
        self.check(at, count)?;
        let memory = self.memory.get()?;
        Ok((at..at + count).map(|at| memory.get(at)).collect())
    }

    fn write(&self, at: usize, bytes: Vec<u8>) -> PyResult<()> {
        self.check(at, bytes.len())?;
        let memory = self.memory.get()?;
        (at..).zip(bytes).for_each(|(at, byte)| memory.set(at, byte));
        Ok(())
    }

    /// In femtoseconds.
    fn set_stretch(&self, span: u64) -> PyResult<()> {
        self.memory.get()?.set_stretch(Time::fs(span));
        Ok(())
    }

    fn accesses(&self) -> PyResult<u64> {
        Ok(self.memory.get()?.accesses())
    }
}

impl RawI2cMemory {
    fn check(&self, at: usize, count: usize) -> PyResult<()> {
        if at.checked_add(count).is_some_and(|end| end <= self.size) {
            return Ok(());
        }
        Err(PyValueError::new_err(format!("{count} bytes from {at:#x} on in a memory of {} bytes", self.size)))
    }
}
