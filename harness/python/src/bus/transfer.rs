//! Whole frames as numpy arrays, without the scheduler.

use hoverlock_harness::Time;
use hoverlock_harness::bus::bulk::{Bulk, Element, Options, Report};
use hoverlock_harness::bus::stream::Dialect;
use hoverlock_harness::sim::{Clock, Dut, Sim};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::common::{dialect_of, failed, pause_of};
use crate::errors;
use crate::gil;

/// The arguments of `Session.transfer`: the attributes of `hoverlock.transfer.TransferOptions`.
#[derive(FromPyObject)]
pub struct TransferOptions<'py> {
    input: String,
    output: String,
    bus: String,
    ready_latency: u32,
    clock: String,
    /// Period of the clock, in femtoseconds.
    period: u64,
    idle: Option<Bound<'py, PyAny>>,
    stall: Option<Bound<'py, PyAny>>,
    seed: u64,
    packet: usize,
    expect: Option<usize>,
    packets: usize,
    most_cycles: u64,
}

/// A transfer that is ready to run.
pub struct Transfer {
    input: String,
    output: String,
    dialect: Dialect,
    clock: Clock,
    /// Beats to receive. `None`: as many as are sent, or no limit if packets are counted.
    expect: Option<usize>,
    options: Options,
}

/// The array received from the design, and `(cycles, sent, received, packets)`.
pub type Transferred<'py> = (Bound<'py, PyAny>, (u64, usize, usize, usize));

impl Transfer {
    pub fn new(py: Python<'_>, dut: &Dut, asked: TransferOptions<'_>) -> PyResult<Transfer> {
        let idle = pause_of(asked.idle.as_ref(), asked.seed)?;
        // Another sequence than that of `idle`, from the same seed.
        let stall = pause_of(asked.stall.as_ref(), asked.seed ^ 0x9E37_79B9_7F4A_7C15)?;
        let dialect = dialect_of(&asked.bus, asked.ready_latency)?;
        let clock = dut.clock(&asked.clock, Time::fs(asked.period)).map_err(failed(py))?;
        let (packet, packets, max_cycles) = (asked.packet, asked.packets, asked.most_cycles);
        let options = Options { idle, stall, packet, expect: 0, packets, max_cycles };
        Ok(Transfer { input: asked.input, output: asked.output, dialect, clock, expect: asked.expect, options })
    }

    /// Sends an array, whose element type is that of the input's storage, and returns one with that of the output's.
    pub fn run<'py>(&self, sim: &mut Sim, samples: &Bound<'py, PyAny>) -> PyResult<Transferred<'py>> {
        let kind = samples.cast::<PyUntypedArray>()?.dtype().to_string();
        let data = if self.dialect == Dialect::Axi { "tdata" } else { "data" };
        let output = sim.dut().wide(&format!("{}{data}", self.output)).map_err(|e| errors::of_model(&e))?;
        match kind.as_str() {
            "uint8" => self.from::<u8>(sim, samples, output.width()),
            "uint16" => self.from::<u16>(sim, samples, output.width()),
            "uint32" => self.from::<u32>(sim, samples, output.width()),
            "uint64" => self.from::<u64>(sim, samples, output.width()),
            _ => Err(PyTypeError::new_err(format!("samples are uint8, uint16, uint32 or uint64, not {kind}"))),
        }
    }

    fn from<'py, I>(&self, sim: &mut Sim, samples: &Bound<'py, PyAny>, bits: u32) -> PyResult<Transferred<'py>>
    where
        I: Element + numpy::Element + Sync,
    {
        match bits {
            0..=8 => self.between::<I, u8>(sim, samples),
            9..=16 => self.between::<I, u16>(sim, samples),
            33..=64 => self.between::<I, u64>(sim, samples),
            _ => self.between::<I, u32>(sim, samples),
        }
    }

    fn between<'py, I, O>(&self, sim: &mut Sim, samples: &Bound<'py, PyAny>) -> PyResult<Transferred<'py>>
    where
        I: Element + numpy::Element,
        O: Element + numpy::Element,
    {
        let py = samples.py();
        let samples: PyReadonlyArray1<'py, I> = samples.extract()?;
        let mut bulk =
            Bulk::<I, O>::new(&sim.dut(), &self.clock, &self.input, &self.output, self.dialect).map_err(failed(py))?;
        let samples = samples.as_slice()?;
        let (parts, parts_out) = bulk.parts();
        let mut options = self.options.clone();
        options.expect = match self.expect {
            Some(count) => count,
            None if options.packets > 0 => 0,
            None => samples.len() / parts,
        };
        let mut received = Vec::new();
        let ended = bulk.transfer(sim, samples, &mut received, &options);
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
