//! A file that grows by whole lines: what was appended before a run was stopped is there for the next one.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::path::Path;

use anyhow::{Context, Result};

use crate::output::write_file;

/// Its whole lines; none where there is no file. A last line that was cut off is taken out of the file.
pub fn read(path: &Path) -> Result<String> {
    let mut text = match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(String::new()),
        text => text.with_context(|| format!("{}: cannot be read", path.display()))?,
    };
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    if whole < text.len() {
        text.truncate(whole);
        write_file(path, text.as_bytes())?;
    }
    Ok(text)
}

/// Appends lines; `lines` is told whether they are the first.
pub fn append(path: &Path, lines: impl FnOnce(bool) -> Result<Vec<u8>>) -> Result<()> {
    let file = OpenOptions::new().create(true).append(true).open(path);
    let mut file = file.with_context(|| format!("{}: cannot be written", path.display()))?;
    let first = file.metadata().map_or(0, |metadata| metadata.len()) == 0;
    let lines = lines(first)?;
    file.write_all(&lines).with_context(|| format!("{}: cannot be written; free some space", path.display()))
}
