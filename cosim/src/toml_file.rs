//! Files in TOML: scenarios and calibrations.

use std::path::{Path, PathBuf};

use hoverlock_edss::{strict, toml_text};
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, Deserializer, Error};

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// Its name in errors.
    name: &'static str,
    /// Largest number of bytes, and the same in words.
    max_bytes: u64,
    limit: &'static str,
}

/// A scenario.
pub(crate) const SCENARIO: Kind = Kind { name: "scenario", max_bytes: 1 << 20, limit: "1 MiB" };
/// A calibration of the camera.
pub(crate) const CALIBRATION: Kind = Kind { name: "calibration", max_bytes: 1 << 16, limit: "64 KiB" };

/// Why a file was refused.
#[derive(Debug, thiserror::Error)]
pub enum TomlFileError {
    /// The file could not be read.
    #[error("{name} {path}: cannot be read: {source}", name = kind.name)]
    Read {
        /// What it should hold.
        kind: Kind,
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The path is a folder, a device, a FIFO, or a file that is too large.
    #[error("{name} {path}: not a regular file of at most {limit}", name = kind.name, limit = kind.limit)]
    NotAFile {
        /// What it should hold.
        kind: Kind,
        /// The path.
        path: PathBuf,
    },
    /// The file does not hold what it should.
    #[error("{name} {path}: {why}", name = kind.name)]
    Invalid {
        /// What it should hold.
        kind: Kind,
        /// The file.
        path: PathBuf,
        /// What is wrong, on one line.
        why: String,
    },
}

impl Kind {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// It cannot be read, is no regular file, or is too large.
    pub(crate) fn read(self, path: &Path) -> Result<String, TomlFileError> {
        let read = |source| TomlFileError::Read { kind: self, path: path.into(), source };
        let about = std::fs::metadata(path).map_err(read)?;
        if !about.is_file() || about.len() > self.max_bytes {
            return Err(TomlFileError::NotAFile { kind: self, path: path.into() });
        }
        std::fs::read_to_string(path).map_err(read)
    }

    /// Parses the text of a file.
    ///
    /// # Errors
    /// The text is not TOML, has an unknown key, or a value of another type.
    pub(crate) fn parse<T: DeserializeOwned>(self, text: &str, path: &Path) -> Result<T, TomlFileError> {
        let table = DeTable::parse(text).map_err(|error| self.located(text, path, "", None, &error))?;
        self.deserialize(text, path, table)
    }

    /// Converts the table of a text, or what is left of it.
    ///
    /// # Errors
    /// The table has an unknown key, or a value of another type.
    pub(crate) fn deserialize<T: DeserializeOwned>(
        self,
        text: &str,
        path: &Path,
        table: Spanned<DeTable<'_>>,
    ) -> Result<T, TomlFileError> {
        let keys = table.get_ref().clone();
        strict::deserialize(Deserializer::from(table))
            .map_err(|error| self.located(text, path, "", Some(&keys), &error))
    }

    /// Returns the error of a text with its line, `place` and the key of `keys` that it is about.
    pub(crate) fn located(
        self,
        text: &str,
        path: &Path,
        place: &str,
        keys: Option<&DeTable<'_>>,
        error: &Error,
    ) -> TomlFileError {
        let start = error.span().map_or(0, |span| span.start);
        // Other messages name the key.
        let key = keys.filter(|_| error.message().starts_with("invalid")).map(|keys| toml_text::key_at(keys, start));
        let key = key.filter(|key| !key.is_empty()).map_or(String::new(), |key| format!("{key}: "));
        self.invalid(path, format!("line {}: {place}{key}{}", toml_text::line(text, start), toml_text::message(error)))
    }

    /// Returns the error of a file with what is wrong in it.
    pub(crate) fn invalid(self, path: &Path, why: String) -> TomlFileError {
        TomlFileError::Invalid { kind: self, path: path.into(), why }
    }
}
