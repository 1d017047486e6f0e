//! `rtl` against `bit_true`: frames through the Verilated top, every smoothed sample, DoG, MaxDOG and record compared
//! bit for bit.
//!
//! The bench drives the top as a system does: pixels by Avalon-ST, registers by Avalon-MM, records by Avalon-ST. It
//! also reads a few internal signals, so that a difference is reported at the stage that causes it and not only in the
//! records.
//!
//! | module | content |
//! |---|---|
//! | `simulator` | from Verilog to a Verilated model |
//! | `job` | the stimulus: frames, faults, pauses |
//! | `expect` | the expected values, from `bit_true` |
//! | [`Top`] | the ports of the top between a source, a sink and a master of the harness |
//! | `stalls` | the pauses of source and sink |
//! | `comparison` | sends the frames and compares in each clock cycle |
//! | `planes`, `records` | the comparisons |
//! | `outcome` | the result |
//! | [`board`] | the top between camera, DMA and CPU, without a comparison: what a whole system sees |
//! | [`upsets`] | the top with faults in its registers and memories |
//! | `waves` | a window of a run as a wave file, and GTKWave's view of it |

pub mod board;
mod comparison;
mod expect;
mod job;
mod outcome;
mod planes;
mod records;
mod simulator;
mod stalls;
mod top;
pub mod upsets;
mod waves;

use std::{sync::mpsc::sync_channel, time::Instant};

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_harness::{BuildError, Error, ModelError, RecordingError};

use comparison::Comparison;
use expect::{Expectation, Oracle};
pub use hoverlock_harness::build::Trace;
pub use job::{Fault, Job, Streams};
pub use outcome::{FrameOutcome, Mismatch, Outcome};
pub use simulator::Simulator;
pub use top::{Top, simulation};
use waves::Recorder;
pub use waves::{Window, format_of, record, signals, view};

use hoverlock_rtl::emission::EmitError;

/// Why a run has no result.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// Verilator or the compiler did not make a model.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The model lacks a signal: the bench does not fit the Verilog.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The design point has no coefficients.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// There is no Verilog to simulate.
    #[error(transparent)]
    Emit(#[from] EmitError),
    /// The bench does not fit the register map.
    #[error("the register map has no register {0}")]
    Register(&'static str),
    /// The run failed, or its waves cannot be written.
    #[error(transparent)]
    Run(#[from] Error),
    /// The frames do not make a sequence in which a fault can be put.
    #[error("{0}")]
    Frames(&'static str),
    /// The board waits for an interrupt or for the DMA.
    #[error("frame {frame}: the hardware hangs: nothing came within {cycles} clock cycles")]
    Hangs {
        /// Frame, from 0.
        frame: usize,
        /// Cycles waited.
        cycles: u64,
    },
}

impl From<RecordingError> for SimulationError {
    fn from(error: RecordingError) -> Self {
        Error::from(error).into()
    }
}

/// Progress of a run.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Number of pixels sent.
    pub pixels: u64,
    /// Number of frames that came out.
    pub frames: usize,
    /// Clock cycles simulated.
    pub cycles: u64,
}

/// Runs frames through the hardware, back to back apart from the pauses, and compares everything.
///
/// # Errors
/// If the bench does not fit the model.
pub fn run(simulator: &Simulator, jobs: &[Job], streams: Streams) -> Result<Outcome, SimulationError> {
    run_with_progress(simulator, jobs, streams, &mut |_| ())
}

/// [`run`] with progress reports.
///
/// # Errors
/// As [`run`].
pub fn run_with_progress(
    simulator: &Simulator,
    jobs: &[Job],
    streams: Streams,
    progress: &mut dyn FnMut(Progress),
) -> Result<Outcome, SimulationError> {
    let comparison = Comparison::new(simulator, jobs, streams, None)?;
    beside(simulator.design(), jobs, |oracle| {
        let started = Instant::now();
        let mut outcome = comparison.run(oracle, progress)?;
        outcome.cycles_per_second = outcome.cycles as f64 / started.elapsed().as_secs_f64();
        Ok(outcome)
    })
}

/// The same with a recorder, up to its end.
fn record_window(
    simulator: &Simulator,
    jobs: &[Job],
    streams: Streams,
    recorder: Recorder<'_>,
) -> Result<(), SimulationError> {
    let comparison = Comparison::new(simulator, jobs, streams, Some(recorder))?;
    beside(simulator.design(), jobs, |oracle| comparison.run(oracle, &mut |_| ()).map(|_| ()))
}

/// Runs `work` while another thread computes `bit_true`, two frames ahead.
fn beside<T>(
    design: &DesignPoint,
    jobs: &[Job],
    work: impl FnOnce(&mut Oracle) -> Result<T, SimulationError>,
) -> Result<T, SimulationError> {
    let expectation = Expectation::new(design, jobs)?;
    let (sender, receiver) = sync_channel(1);
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for expected in expectation {
                if sender.send(expected).is_err() {
                    return;
                }
            }
        });
        let mut oracle = Oracle::new(receiver);
        oracle.frame(0);
        work(&mut oracle)
    })
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
