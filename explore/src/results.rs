//! The results of earlier searches: a file to which each result is appended when it is measured.
//!
//! Results are outcomes of checks on pictures ([`KnownResults`]) or of flights.

use std::collections::HashMap;
use std::path::Path;

use hoverlock_reports::journal::{self, JournalError};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::measure::PartOutcome;

/// Results by the hash of everything they depend on.
pub type KnownResults = HashMap<String, PartOutcome>;

/// Why results could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The file could not be read or written.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A line of the file is not a result.
    #[error("{path}: line {line} is no result of this command; move the file away: {source}")]
    Line {
        /// The file of results.
        path: String,
        /// Number of the line, from 1.
        line: usize,
        /// The error of the JSON parser.
        source: serde_json::Error,
    },
    /// A result could not be written as JSON.
    #[error("a result cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Reads the results of earlier searches, one JSON object a line. Returns no results if there is no file.
///
/// # Errors
/// The file cannot be read, or one of its lines is not a result.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<HashMap<String, T>, ResultsError> {
    let parse = |(index, line): (usize, &str)| {
        serde_json::from_str::<(String, T)>(line).map_err(|source| ResultsError::Line {
            path: path.display().to_string(),
            line: index + 1,
            source,
        })
    };
    journal::read(path)?.lines().enumerate().map(parse).collect()
}

/// Appends a result to the file.
///
/// # Errors
/// The file cannot be written.
pub fn append(path: &Path, key: &str, outcome: &impl Serialize) -> Result<(), ResultsError> {
    let line = serde_json::to_string(&(key, outcome))? + "\n";
    journal::append(path, |_| Ok(line.into_bytes()))
}
