//! The samples of the inertial sensor: a CSV table with one row per sample.

use std::path::{Path, PathBuf};

use hoverlock_arm::message::{Inertial, InertialSample, encode_inertial};
use serde::Deserialize;

use super::table::{MAX_TIME_S, reason};

/// The columns of the table.
pub(super) const COLUMNS: [&str; 7] = [
    "time_s",
    "rate_x_rad_per_s",
    "rate_y_rad_per_s",
    "rate_z_rad_per_s",
    "force_x_m_per_s2",
    "force_y_m_per_s2",
    "force_z_m_per_s2",
];

/// A row of the table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    time_s: f64,
    rate_x_rad_per_s: f64,
    rate_y_rad_per_s: f64,
    rate_z_rad_per_s: f64,
    force_x_m_per_s2: f64,
    force_y_m_per_s2: f64,
    force_z_m_per_s2: f64,
}

/// Why a table of samples was refused.
#[derive(Debug, thiserror::Error)]
pub enum InertialError {
    /// The table is a folder, a device or a FIFO.
    #[error("{path}: the table of the inertial sensor is not a regular file", path = .0.display())]
    NotAFile(PathBuf),
    /// The table cannot be read.
    #[error("{path}: the table of the inertial sensor cannot be read: {source}")]
    Csv {
        /// The table.
        path: PathBuf,
        /// The error of the CSV parser.
        source: csv::Error,
    },
    /// The header has other columns.
    #[error(
        "{path}: the table of the inertial sensor has the columns {columns}, all of them and no others",
        path = .0.display(),
        columns = COLUMNS.join(",")
    )]
    Columns(PathBuf),
    /// A row has a value out of range, or a time that does not grow.
    #[error("{path}: row {row} of the table of the inertial sensor: {reason}")]
    Row {
        /// The table.
        path: PathBuf,
        /// Number of the row, from 1.
        row: usize,
        /// What is wrong with the row.
        reason: String,
    },
}

/// Reads a table of samples in the order of their times.
///
/// # Errors
/// The table cannot be read, has another column, a value out of range, or times that do not grow.
pub fn read(path: &Path) -> Result<Vec<InertialSample>, InertialError> {
    // A device or a FIFO may never end.
    if !path.is_file() {
        return Err(InertialError::NotAFile(path.into()));
    }
    let unread = |source| InertialError::Csv { path: path.into(), source };
    let mut rows =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_path(path).map_err(unread)?;
    let header = rows.headers().map_err(unread)?.clone();
    let has = |column: &&str| header.iter().any(|name| name == *column);
    if header.len() != COLUMNS.len() || !COLUMNS.iter().all(has) {
        return Err(InertialError::Columns(path.into()));
    }
    let mut samples: Vec<InertialSample> = Vec::new();
    for row in rows.deserialize::<Row>() {
        let refused = |reason: String| InertialError::Row { path: path.into(), row: samples.len() + 1, reason };
        let row = row.map_err(|error| refused(reason(&error, &header)))?;
        if !(0.0..=MAX_TIME_S).contains(&row.time_s) {
            return Err(refused(format!("time_s is {}, and must be 0 to {MAX_TIME_S}", row.time_s)));
        }
        let sample = InertialSample {
            time_us: (1e6 * row.time_s).round() as u64,
            rates: [row.rate_x_rad_per_s, row.rate_y_rad_per_s, row.rate_z_rad_per_s],
            force: [row.force_x_m_per_s2, row.force_y_m_per_s2, row.force_z_m_per_s2],
        };
        if let Err(error) = Inertial::parse(&encode_inertial(&[sample])) {
            return Err(refused(error.to_string()));
        }
        if samples.last().is_some_and(|last| last.time_us >= sample.time_us) {
            return Err(refused("time_s does not grow".into()));
        }
        samples.push(sample);
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_with_other_columns_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("inertial.csv");
        let read_text = |text: &str| {
            std::fs::write(&table, text).unwrap();
            read(&table)
        };
        let header = COLUMNS.join(",");
        assert_eq!(read_text(&format!("{header}\n0.5,0,0,0,0,0,-9.8\n")).unwrap()[0].time_us, 500_000);
        let turned = COLUMNS.iter().rev().copied().collect::<Vec<_>>().join(",");
        let sample = read_text(&format!("{turned}\n-9.8,0,0,0,0,0.25,0.5\n")).unwrap()[0];
        assert_eq!((sample.time_us, sample.rates, sample.force), (500_000, [0.25, 0.0, 0.0], [0.0, 0.0, -9.8]));
        let error = read_text(&format!("{header}\n0.5,0,0,0,0,0,-9.8\n0.6,0,,0,0,0,-9.8\n")).unwrap_err().to_string();
        assert!(error.ends_with("row 2 of the table of the inertial sensor: rate_y_rad_per_s is no number"), "{error}");
        for text in ["hello\n", "", "time_s\n", &format!("{header},more\n")] {
            assert!(matches!(read_text(text), Err(InertialError::Columns(_))), "{text}");
        }
    }
}
