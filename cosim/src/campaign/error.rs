//! Errors of a campaign.

use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

use hoverlock_design::LoadError;
use hoverlock_edss::camera::FRAME_SIZE;
use hoverlock_reports::journal::JournalError;

use crate::hover::{HoverError, SceneFileError};
use crate::monitor::BoxError;

/// Why a campaign was not completed.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// Float features were combined with several designs.
    #[error("float features have no word lengths; choose other features, or no design beside kt27")]
    FloatHasNoWords,
    /// The frames of a design are smaller than those of the simulated camera.
    #[error(
        "the design {name} takes {width} x {height} px at most, and the camera's frames have {} x {}: copy its \
         file and change width and height",
        FRAME_SIZE.0,
        FRAME_SIZE.1
    )]
    SmallDesign {
        /// The name of the design.
        name: String,
        /// Columns of its frames.
        width: u32,
        /// Rows of its frames.
        height: u32,
    },
    /// A scene could not be loaded.
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// A design could not be loaded.
    #[error(transparent)]
    Design(#[from] LoadError),
    /// Scene or design of a point are not those of the campaign.
    #[error(
        "scene {scene} or design {design} has other numbers here than where the campaign began: copy the files from \
         there"
    )]
    OtherInputs {
        /// Scene of the point.
        scene: String,
        /// Design of the point.
        design: String,
    },
    /// A point could not be flown.
    #[error(transparent)]
    Hover(#[from] HoverError),
    /// A random flight could not be flown.
    #[error("flight {number} of seed {seed}: {source}")]
    Flight {
        /// Seed of the campaign.
        seed: u64,
        /// Number of the flight.
        number: u32,
        /// The error of the scenario or of the hover.
        source: BoxError,
    },
    /// A flight without a failure was to be shrunk.
    #[error("flight {number} of seed {seed} does not fail")]
    NoFailure {
        /// Seed of the campaign.
        seed: u64,
        /// Number of the flight.
        number: u32,
    },
    /// The table could not be read or written.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The file of the table begins with another header.
    #[error("{path}: not a table of this command; name another file", path = .0.display())]
    OtherFile(PathBuf),
    /// The table has a row that is not a point.
    #[error("{path}: not a table of this command; move it away: {source}")]
    Table {
        /// The table of the campaign.
        path: PathBuf,
        /// The error of the CSV parser.
        source: csv::Error,
    },
    /// A text is not a row of the table.
    #[error("not a row of the table: {0}")]
    Row(#[from] csv::Error),
    /// A text that should be a row of the table is empty.
    #[error("an empty row")]
    EmptyRow,
    /// A thread has panicked.
    #[error("the thread of a point has panicked")]
    Panic,
    /// The cluster has not returned all points.
    #[error("{flown} of {points} points came back")]
    MissingPoints {
        /// Number of points with a result.
        flown: usize,
        /// Number of all points.
        points: usize,
    },
    /// There is no Python interpreter of this name.
    #[error(
        "{python}: no such program; name a Python with the module {module} in HOVERLOCK_PYTHON",
        python = .python.display()
    )]
    PythonMissing {
        /// The interpreter that was named.
        python: OsString,
        /// The module that it must have.
        module: &'static str,
    },
    /// The Python module could not be started, written or read.
    #[error("Dask: {step}: {source}")]
    Python {
        /// The step that failed.
        step: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The Python module has failed.
    #[error("Dask {scheduler}: {python} has failed ({status}): {message}; HOVERLOCK_PYTHON names another Python")]
    PythonFailed {
        /// Address of the scheduler.
        scheduler: String,
        /// The interpreter.
        python: String,
        /// Exit status of Python.
        status: ExitStatus,
        /// The last line that the module wrote to stderr.
        message: String,
    },
    /// The caller has stopped the campaign.
    #[error(transparent)]
    Stopped(BoxError),
}
