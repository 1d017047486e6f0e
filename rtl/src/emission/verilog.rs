//! The Verilog files of a design on the disk: what is simulated, estimated and proved.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use hoverlock_design::{DesignPoint, KT27};
use sha2::{Digest, Sha256};

use super::{EmitError, File, committed, files_of, verilog_in};

/// Returns the Verilog files of a folder, the committed ones of the default design, or else the emission.
///
/// # Errors
/// If the design cannot be built or emitted, or the folder has no Verilog.
pub fn verilog(design: &DesignPoint, folder: Option<&Path>) -> Result<Vec<PathBuf>, EmitError> {
    design.check_buildable()?;
    match folder {
        Some(folder) => verilog_in(folder).ok_or_else(|| EmitError::NoVerilog(folder.into())),
        None => match committed().filter(|_| design.of_hardware() == *KT27) {
            Some(committed) => Ok(committed),
            None => emitted(&files_of(design)?),
        },
    }
}

/// Writes the emission into a folder named by content, and returns the files. Unchanged files keep their times, by
/// which the harness finds the built model.
fn emitted(files: &[File]) -> Result<Vec<PathBuf>, EmitError> {
    let verilog: Vec<_> = files.iter().filter_map(|file| Some((file.module()?, &file.text))).collect();
    let mut digest = Sha256::new();
    verilog.iter().for_each(|(_, text)| digest.update(text.as_bytes()));
    let name: String = digest.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let folder = hoverlock_cache::folder()?.join("verilog").join(name);
    let mut sources = Vec::new();
    for (name, text) in verilog {
        let path = folder.join(name);
        put(&path, text).map_err(|source| EmitError::Write { path: path.clone(), source })?;
        sources.push(path);
    }
    Ok(sources)
}

/// Writes a file whole, unless it is there already.
fn put(path: &Path, text: &str) -> std::io::Result<()> {
    if std::fs::read(path).is_ok_and(|there| there == text.as_bytes()) {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.persist(path)?;
    Ok(())
}
