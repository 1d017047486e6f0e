//! Positions from homographies that were fitted to the pictures of a folder.

use std::path::{Path, PathBuf};

use hoverlock_arm::message::Telemetry;
use hoverlock_reference::motion::model::{Pair, transfer};
use hoverlock_reference::motion::orthophoto::{Camera, View};
use hoverlock_reference::motion::pose;
use nalgebra::{Matrix3, Vector2};
use serde::Deserialize;

use super::FrameFile;
use super::table::reason;

/// Columns and rows of the grid of points that represents a homography.
const GRID: (usize, usize) = (12, 9);

/// The position of a frame by the homographies of the folder.
#[derive(Debug, Clone, Copy)]
pub struct PseudoTruth {
    /// Displacement from frame 0 along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// The homographies of the frames between were multiplied, because the table has none from frame 0.
    pub is_chained: bool,
}

impl PseudoTruth {
    /// Returns the position relative to that of another frame: the reference, if it is not frame 0.
    pub(crate) fn relative_to(&self, origin: &Self) -> Self {
        Self { displacement: self.displacement - origin.displacement, is_chained: self.is_chained || origin.is_chained }
    }
}

/// Why a table of homographies was refused. Every message begins with the path.
#[derive(Debug, thiserror::Error)]
pub enum PseudoTruthError {
    /// It is a folder, a device or a FIFO.
    #[error("{path}: the table of homographies is not a regular file", path = .0.display())]
    NotAFile(PathBuf),
    /// It could not be read.
    #[error("{path}: the homographies cannot be read: {source}")]
    Table {
        /// The table of homographies.
        path: PathBuf,
        /// The error of the CSV parser.
        source: csv::Error,
    },
    /// A row could not be parsed, or has a value that is not a finite number.
    #[error("{path}: row {row} of the homographies: {reason}")]
    Row {
        /// The table of homographies.
        path: PathBuf,
        /// Number of the row, from 1.
        row: usize,
        /// What is wrong with the row.
        reason: String,
    },
}

/// A row of the table: the homography from frame `reference` to `frame`, valid if `ok` is 1.
#[derive(Deserialize)]
struct Row {
    #[serde(rename = "ref")]
    reference: usize,
    frame: usize,
    ok: u8,
    h00: Option<f64>,
    h01: Option<f64>,
    h02: Option<f64>,
    h10: Option<f64>,
    h11: Option<f64>,
    h12: Option<f64>,
    h20: Option<f64>,
    h21: Option<f64>,
    h22: Option<f64>,
}

impl Row {
    fn homography(&self) -> Option<Matrix3<f64>> {
        let Self { h00, h01, h02, h10, h11, h12, h20, h21, h22, .. } = *self;
        (self.ok == 1).then_some(())?;
        Some(Matrix3::new(h00?, h01?, h02?, h10?, h11?, h12?, h20?, h21?, h22?))
    }
}

/// Reads a table of homographies and returns the position of each frame. A position is that of the pose fit, with the
/// same telemetry, of a grid of points that the homography moves, so an estimate differs from it by its features and
/// matches alone. The frames are as large as `first`; `telemetry` has a row for each.
pub(super) fn read(
    table: &Path,
    first: &FrameFile,
    telemetry: &[Telemetry],
) -> Result<Vec<Option<PseudoTruth>>, PseudoTruthError> {
    // A device may never end, and opening a FIFO waits for its writer.
    if !table.is_file() {
        return Err(PseudoTruthError::NotAFile(table.into()));
    }
    let refused = |source| PseudoTruthError::Table { path: table.into(), source };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(table).map_err(refused)?;
    // Without a header there are no rows, and no error.
    let header = reader.headers().map_err(refused)?.clone();
    let mut rows: Vec<Row> = Vec::new();
    for row in reader.deserialize() {
        let refused = |reason: String| PseudoTruthError::Row { path: table.into(), row: rows.len() + 1, reason };
        let row: Row = row.map_err(|error| refused(reason(&error, &header)))?;
        if row.homography().is_some_and(|h| !h.iter().all(|v| v.is_finite())) {
            return Err(refused("a value is not a finite number".into()));
        }
        rows.push(row);
    }
    let (left, top) = first.corner();
    let corner = Vector2::new(left as f64, top as f64);
    let moved = |reference: usize, frame: usize| {
        let row = rows.iter().find(|row| (row.reference, row.frame) == (reference, frame))?;
        Some(Matrix3::new_translation(&-corner) * row.homography()? * Matrix3::new_translation(&corner))
    };
    let mut before = Some(Matrix3::identity());
    let mut truths = vec![Some(PseudoTruth { displacement: Vector2::zeros(), is_chained: false })];
    for frame in 1..telemetry.len() {
        let direct = moved(0, frame);
        let homography = direct.or_else(|| Some(moved(frame - 1, frame)? * before?));
        before = homography;
        truths.push(homography.and_then(|homography| {
            let displacement = displacement(&homography, first.size(), [telemetry[0], telemetry[frame]])?;
            Some(PseudoTruth { displacement, is_chained: direct.is_none() })
        }));
    }
    Ok(truths)
}

/// Returns the displacement that the pose fit gives for a homography; `None` if too little of the frame stays in view
/// or the telemetry contradicts it.
fn displacement(
    homography: &Matrix3<f64>,
    (width, height): (usize, usize),
    readings: [Telemetry; 2],
) -> Option<Vector2<f64>> {
    let (columns, rows) = GRID;
    let (right, bottom) = (width as f64 - 1.0, height as f64 - 1.0);
    let node = |i: usize| {
        let (column, row) = (i % columns, i / columns);
        let part = |k: usize, of: usize| k as f64 / (of - 1) as f64;
        Vector2::new(right * part(column, columns), bottom * part(row, rows))
    };
    let pairs: Vec<Pair> = (0..columns * rows)
        .filter_map(|i| Some(Pair { reference: node(i), current: transfer(homography, node(i))? }))
        .filter(|pair| (0.0..=right).contains(&pair.current.x) && (0.0..=bottom).contains(&pair.current.y))
        .collect();
    let view = |readings: &Telemetry| {
        let camera = Camera::with_field_of_view(width, height, readings.field_of_view).ok()?;
        View::new(camera, readings.attitude, readings.range).ok()
    };
    let fit = pose::fit(&view(&readings[0])?, &view(&readings[1])?, &readings[1].sensors, &pairs, u8::MAX);
    fit.ok().map(|pose| pose.displacement)
}
