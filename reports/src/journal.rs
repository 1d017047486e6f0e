//! A text file that grows by whole lines, so that a run that was stopped can be continued.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// Why a journal could not be read or extended.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// Another process has locked the file.
    #[error("{path}: another run is writing it; wait for its end, or name another folder or file", path = .0.display())]
    Locked(PathBuf),
    /// The path is a folder, a device or a FIFO.
    #[error("{path}: not a regular file; name another file", path = .0.display())]
    NotAFile(PathBuf),
    /// The path is a link to nothing.
    #[error("{path}: is a link to nothing; name another file", path = .0.display())]
    LinkToNothing(PathBuf),
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

/// The lock of a journal: while it lives, no other process can lock the same journal. The system releases it when the
/// process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    file: File,
    path: PathBuf,
    is_new: bool,
}

impl Lock {
    /// Locks a journal. A file that is not there is created; it is removed with the lock if it is still empty.
    ///
    /// # Errors
    /// Another process has locked the file, or it is not a regular one, or cannot be opened or created.
    pub fn new(path: &Path) -> Result<Self, JournalError> {
        loop {
            let is_new = !path.exists();
            if is_new && path.is_symlink() {
                return Err(JournalError::LinkToNothing(path.into()));
            }
            // A device or a FIFO may never end.
            if !is_new && !path.is_file() {
                return Err(JournalError::NotAFile(path.into()));
            }
            let file = if is_new {
                let created = OpenOptions::new().create(true).append(true).open(path);
                created.map_err(|source| JournalError::Write { path: path.into(), source })?
            } else {
                File::open(path).map_err(|source| JournalError::Read { path: path.into(), source })?
            };
            // A file system without locks is used without.
            if let Err(TryLockError::WouldBlock) = file.try_lock() {
                return Err(JournalError::Locked(path.into()));
            }
            // The process that had the lock may have replaced or removed the file since it was opened here.
            let is_same = |there: fs::Metadata| {
                file.metadata().is_ok_and(|locked| (locked.dev(), locked.ino()) == (there.dev(), there.ino()))
            };
            if fs::metadata(path).is_ok_and(is_same) {
                return Ok(Self { file, path: path.into(), is_new });
            }
        }
    }

    /// Checks that lines can be appended, before the work that makes them.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn check_append(&self) -> Result<(), JournalError> {
        let opened = OpenOptions::new().append(true).open(&self.path);
        opened.map(drop).map_err(|source| JournalError::Write { path: self.path.clone(), source })
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if self.is_new && self.file.metadata().is_ok_and(|locked| locked.len() == 0) {
            let _ = fs::remove_file(&self.path);
        }
    }
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
