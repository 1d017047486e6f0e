//! A text file that grows by whole lines, so that a run that was stopped can be continued.

use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// Why a journal could not be read or extended.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The file could not be read.
    #[error("{path}: cannot be read: {source}")]
    Read {
        /// The file of the journal.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file could not be written.
    #[error("{path}: cannot be written: {source}; {}", remedy(.source))]
    Write {
        /// The file of the journal.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// Returns what helps against an error of writing.
fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space",
        _ => "check its folder and permissions, or name another file",
    }
}

/// Checks that lines can be appended, before the work that makes them. A file that was not there is not left.
///
/// # Errors
/// The file cannot be written.
pub fn check(path: &Path) -> Result<(), JournalError> {
    let is_new = !path.exists();
    let refused = |source| JournalError::Write { path: path.into(), source };
    OpenOptions::new().create(true).append(true).open(path).map_err(refused)?;
    if is_new { fs::remove_file(path).map_err(refused) } else { Ok(()) }
}

/// Returns the whole lines of a journal; an empty text if there is no file. Removes an incomplete last line from the
/// file.
///
/// # Errors
/// The file cannot be read, or an incomplete last line cannot be removed.
pub fn read(path: &Path) -> Result<String, JournalError> {
    let mut text = match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(String::new()),
        text => text.map_err(|source| JournalError::Read { path: path.into(), source })?,
    };
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    if whole < text.len() {
        text.truncate(whole);
        let file = OpenOptions::new().write(true).open(path);
        file.and_then(|file| file.set_len(whole as u64))
            .map_err(|source| JournalError::Write { path: path.into(), source })?;
    }
    Ok(text)
}

/// Appends lines. `lines` makes them; its argument is `true` if the journal is empty, so that it can begin with a
/// header.
///
/// # Errors
/// The file cannot be written, or `lines` fails.
pub fn append<E: From<JournalError>>(path: &Path, lines: impl FnOnce(bool) -> Result<Vec<u8>, E>) -> Result<(), E> {
    let refused = |source| JournalError::Write { path: path.into(), source };
    let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(refused)?;
    let is_empty = file.metadata().map_or(0, |metadata| metadata.len()) == 0;
    let lines = lines(is_empty)?;
    Ok(file.write_all(&lines).map_err(refused)?)
}
