//! The readings of IMU, laser and zoom at each frame: a CSV table with one row per frame.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use hoverlock_arm::message::Telemetry;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use serde::Deserialize;

use super::table::{MAX_TIME_S, reason};

/// Frame rate of a table without times, Hz.
const DEFAULT_FRAME_RATE: f64 = 15.0;

/// Standard errors of a row that has none: tilt and heading, degrees, and range, m.
const DEFAULT_STANDARD_ERRORS: [f64; 3] = [0.2, 1.0, 0.1];

/// The columns that a table can have.
pub(super) const COLUMNS: [&str; 9] =
    ["time_s", "roll_deg", "pitch_deg", "yaw_deg", "range_m", "fov_deg", "tilt_se_deg", "heading_se_deg", "range_se_m"];

/// Least and largest range of a row, m: those of a laser that a hover simulates, too.
pub(crate) const MIN_RANGE_M: f64 = 0.1;
/// See [`MIN_RANGE_M`].
pub(crate) const MAX_RANGE_M: f64 = 1e4;

/// A row of the table in its own units.
#[derive(Deserialize)]
struct Row {
    time_s: Option<f64>,
    roll_deg: f64,
    pitch_deg: f64,
    yaw_deg: f64,
    range_m: f64,
    fov_deg: f64,
    tilt_se_deg: Option<f64>,
    heading_se_deg: Option<f64>,
    range_se_m: Option<f64>,
}

/// Why a table of telemetry was refused. Every message begins with the path.
#[derive(Debug, thiserror::Error)]
pub enum TelemetryError {
    /// The file could not be opened.
    #[error("{path}: the telemetry cannot be read: {source}")]
    Open {
        /// The table of telemetry.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is a folder, a device or a FIFO.
    #[error("{path}: the telemetry is not a regular file", path = .0.display())]
    NotAFile(PathBuf),
    /// The header could not be read.
    #[error("{path}: the telemetry is no table: {source}")]
    Header {
        /// The table of telemetry.
        path: PathBuf,
        /// The error of the CSV parser.
        source: csv::Error,
    },
    /// The header has an unknown column.
    #[error(
        "{path}: no column of telemetry is named `{column}`; the columns are {columns}",
        columns = COLUMNS.join(", ")
    )]
    UnknownColumn {
        /// The table of telemetry.
        path: PathBuf,
        /// The unknown column.
        column: String,
    },
    /// A row could not be parsed, or a value is out of range.
    #[error("{path}: row {row} of the telemetry: {reason}")]
    Row {
        /// The table of telemetry.
        path: PathBuf,
        /// Number of the row, from 1.
        row: usize,
        /// What is wrong with the row.
        reason: String,
    },
    /// The number of rows is not the number of pictures.
    #[error("{path}: {rows} rows of telemetry for {frames} pictures; give one row for each, in order")]
    RowCount {
        /// The table of telemetry.
        path: PathBuf,
        /// Number of rows.
        rows: usize,
        /// Number of pictures.
        frames: usize,
    },
    /// The time of a row is not later than that of the row before.
    #[error("{path}: row {row} of the telemetry: time_s does not grow")]
    Time {
        /// The table of telemetry.
        path: PathBuf,
        /// Number of the row, from 1.
        row: usize,
    },
}

/// Reads a table with one row for each of `frames` frames, numbered from 0.
///
/// # Errors
/// The table cannot be read, has an unknown column, a value out of range, times that do not grow, or another number of
/// rows.
pub fn read(path: &Path, frames: usize) -> Result<Vec<Telemetry>, TelemetryError> {
    let unreadable = |source| TelemetryError::Open { path: path.into(), source };
    // A device may never end, and opening a FIFO waits for its writer.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(TelemetryError::NotAFile(path.into()));
    }
    let file = File::open(path).map_err(unreadable)?;
    let mut table = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(file);
    let header = table.headers().map_err(|source| TelemetryError::Header { path: path.into(), source })?.clone();
    if let Some(unknown) = header.iter().find(|column| !COLUMNS.contains(column)) {
        return Err(TelemetryError::UnknownColumn { path: path.into(), column: unknown.into() });
    }
    let mut rows = Vec::new();
    for row in table.deserialize::<Row>() {
        let number = rows.len();
        let refused = |reason: String| TelemetryError::Row { path: path.into(), row: number + 1, reason };
        let row = row.map_err(|error| refused(reason(&error, &header)))?;
        row.check().map_err(refused)?;
        rows.push(row.telemetry(number as u32));
    }
    if rows.len() != frames {
        return Err(TelemetryError::RowCount { path: path.into(), rows: rows.len(), frames });
    }
    if let Some(late) = rows.windows(2).position(|pair| pair[1].time_us <= pair[0].time_us) {
        return Err(TelemetryError::Time { path: path.into(), row: late + 2 });
    }
    Ok(rows)
}

impl Row {
    /// Checks that every value is in the range of its sensor.
    fn check(&self) -> Result<(), String> {
        let error = |value: Option<f64>| value.unwrap_or(1.0);
        let bounds = [
            ("time_s", self.time_s.unwrap_or(0.0), 0.0, MAX_TIME_S),
            ("roll_deg", self.roll_deg, -80.0, 80.0),
            ("pitch_deg", self.pitch_deg, -80.0, 80.0),
            ("yaw_deg", self.yaw_deg, -360.0, 360.0),
            ("range_m", self.range_m, MIN_RANGE_M, MAX_RANGE_M),
            ("fov_deg", self.fov_deg, 0.1, 170.0),
            ("tilt_se_deg", error(self.tilt_se_deg), 1e-6, 90.0),
            ("heading_se_deg", error(self.heading_se_deg), 1e-6, 180.0),
            ("range_se_m", error(self.range_se_m), 1e-6, 1e4),
        ];
        match bounds.into_iter().find(|(_, value, min, max)| !(min..=max).contains(&value)) {
            Some((column, value, min, max)) => Err(format!("{column} is {value}, and must be {min} to {max}")),
            None => Ok(()),
        }
    }

    /// Converts the row to SI units and radians.
    fn telemetry(&self, frame: u32) -> Telemetry {
        let [tilt, heading, range] = DEFAULT_STANDARD_ERRORS;
        Telemetry {
            frame,
            time_us: (1e6 * self.time_s.unwrap_or(f64::from(frame) / DEFAULT_FRAME_RATE)).round() as u64,
            attitude: Attitude {
                roll: self.roll_deg.to_radians(),
                pitch: self.pitch_deg.to_radians(),
                yaw: self.yaw_deg.to_radians(),
            },
            range: self.range_m,
            field_of_view: self.fov_deg.to_radians(),
            sensors: SensorErrors {
                tilt: self.tilt_se_deg.unwrap_or(tilt).to_radians(),
                heading: self.heading_se_deg.unwrap_or(heading).to_radians(),
                range: self.range_se_m.unwrap_or(range),
            },
        }
    }
}
