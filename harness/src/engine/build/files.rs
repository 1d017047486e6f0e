//! Files of a build's own folder.

use std::path::{Path, PathBuf};

use crate::engine::error::BuildError;

pub(super) fn read(path: &Path) -> Result<String, BuildError> {
    std::fs::read_to_string(path).map_err(|source| BuildError::Cache { path: path.to_owned(), source })
}

pub(super) fn write(path: &Path, text: &str) -> Result<(), BuildError> {
    std::fs::write(path, text).map_err(|source| BuildError::Cache { path: path.to_owned(), source })
}

pub(super) fn files_in(folder: &Path) -> Result<Vec<PathBuf>, BuildError> {
    let entries = std::fs::read_dir(folder).map_err(|source| BuildError::Cache { path: folder.to_owned(), source })?;
    Ok(entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
}
