//! The errors of a bench, those of the engine included. Each message says what is wrong, where, why, and what to do.

use std::path::PathBuf;

use super::failure::Failure;
use super::report::StuckReport;
use crate::engine::error::{BuildError, ModelError, RecordingError, place_text};
use crate::engine::time::Time;

/// Any error of the harness.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the fields are the parts of the message")]
pub enum Error {
    /// Verilog did not become a loaded model.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A name, a value or a memory address that the model does not have.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The simulation stopped before the bench had finished.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A bus rule was broken.
    #[error(transparent)]
    Protocol(#[from] Violation),
    /// The bench reports an error.
    #[error("{0}")]
    Bench(String),
    /// A file of waves, coverage or reports cannot be written or read.
    #[error("{path}: {source}", path = path.display())]
    File { path: PathBuf, source: std::io::Error },
}

impl Error {
    /// Creates an error of the bench itself: a wrong value, an unexpected response.
    pub fn bench(text: impl Into<String>) -> Self {
        Error::Bench(text.into())
    }
}

impl From<RecordingError> for Error {
    fn from(error: RecordingError) -> Error {
        match error {
            RecordingError::Model(error) => Error::Model(error),
            RecordingError::File { path, source } => Error::File { path, source },
        }
    }
}

/// A broken rule of a bus.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{bus} at {time}: {rule}")]
pub struct Violation {
    /// The bus, by the prefix of its signals.
    pub bus: String,
    /// What was wrong.
    pub rule: String,
    /// Simulation time.
    pub time: Time,
}

/// A reason why a simulation ended before its bench did.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the fields are the parts of the message")]
pub enum SimError {
    /// A task failed, and no task waited for it.
    #[error("task '{task}' failed at {time}: {failure}")]
    TaskFailed { task: String, time: Time, failure: Failure },
    /// A task that was waited for was cancelled.
    #[error("task '{task}' was cancelled")]
    Cancelled { task: String },
    /// No event can come any more, and the bench still waits.
    #[error("no event can come any more at {}, and the bench still waits:\n{report}", report.time)]
    Deadlock { report: StuckReport },
    /// The limit of simulation time was reached.
    #[error("simulation time limit of {limit} reached; the tasks wait:\n{report}")]
    TimeLimit { limit: Time, report: StuckReport },
    /// The wall-clock limit was reached.
    #[error("wall-clock limit of {seconds} s reached at {}; the tasks wait:\n{report}", report.time)]
    WallClock { seconds: f64, report: StuckReport },
    /// Tasks and model react to each other without end in one time step.
    #[error("no end of changes at {}: {rounds} rounds in one time step; the tasks wait:\n{report}", report.time)]
    NoProgress { rounds: u32, report: StuckReport },
    /// `$finish` before the bench was done.
    #[error("the Verilog called $finish at {time}{} before the bench was done", place_text(file, *line))]
    Finished { file: String, line: u32, time: Time },
    /// `$stop`, `$error` or `$fatal` in the Verilog.
    #[error("{time}: {message}{}", place_text(file, *line))]
    Verilog { message: String, file: String, line: u32, time: Time },
    /// The span of `with_timeout` was over.
    #[error("timeout of {limit} at {time}")]
    Timeout { limit: Time, time: Time },
    /// A condition that a bench waited for did not hold at any edge within the limit.
    #[error("a condition did not hold within {limit} cycles of '{clock}', until {time}")]
    TooManyCycles { clock: String, limit: u64, time: Time },
    /// A trigger was awaited in a region where it cannot come.
    #[error("{trigger} awaited in {region} at {time}: {reason}")]
    WrongRegion { trigger: &'static str, region: &'static str, time: Time, reason: &'static str },
    /// The run was interrupted (Ctrl-C).
    #[error("interrupted at {time}")]
    Interrupted { time: Time },
    /// A signal of another simulation was awaited.
    #[error("the signal awaited belongs to another simulation: handles and triggers live as long as their `dut`")]
    OtherSimulation,
    /// A time or a count that is not possible.
    #[error("{0}")]
    BadTime(String),
}
