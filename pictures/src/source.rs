//! The bytes of a picture: a regular file, or standard input read to its end.

use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, IsTerminal as _, Read};
use std::path::Path;

use crate::{Limits, PictureError};

/// The seekable bytes of a file.
pub(crate) enum Source {
    File(BufReader<File>),
    Memory(Cursor<Vec<u8>>),
}

/// Opens a regular file, or reads standard input to its end.
pub(crate) fn open(path: &Path, limits: &Limits) -> Result<Source, PictureError> {
    let read = |reason| PictureError::Read { path: path.to_path_buf(), reason };
    let too_large = |bytes| PictureError::FileTooLarge { path: path.to_path_buf(), bytes, limit: limits.max_bytes };
    let empty = || PictureError::EmptyFile { path: path.to_path_buf() };
    if path == Path::new("-") {
        let stdin = io::stdin();
        if stdin.is_terminal() {
            return Err(PictureError::StdinIsTerminal);
        }
        let mut bytes = Vec::new();
        stdin.lock().take(limits.max_bytes + 1).read_to_end(&mut bytes).map_err(read)?;
        return match bytes.len() as u64 {
            0 => Err(empty()),
            length if length > limits.max_bytes => Err(too_large(None)),
            _ => Ok(Source::Memory(Cursor::new(bytes))),
        };
    }
    // Checked before the file is opened: opening a FIFO waits for its writer.
    let metadata = fs::metadata(path).map_err(read)?;
    if metadata.is_dir() {
        return Err(PictureError::IsFolder { path: path.to_path_buf() });
    }
    if !metadata.is_file() {
        return Err(PictureError::NotRegularFile { path: path.to_path_buf() });
    }
    match metadata.len() {
        0 => Err(empty()),
        length if length > limits.max_bytes => Err(too_large(Some(length))),
        _ => Ok(Source::File(BufReader::new(File::open(path).map_err(read)?))),
    }
}
