//! The emission of a design other than the one that this binary was compiled for.
//!
//! rust-hdl has widths in its types, so the emitter is compiled for a design: cargo builds the binary
//! `hoverlock-emitter` from the sources of the project with `HOVERLOCK_DESIGN`, and runs it. That takes seconds, and a
//! minute the first time, when its libraries are compiled; the result is kept in the cache folder under the hash of the
//! design and of the sources.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::Command,
};

use hoverlock_design::DesignPoint;
use sha2::{Digest, Sha256};

use super::File;

/// An error that leaves another design without an emission.
#[derive(Debug, thiserror::Error)]
pub enum OtherError {
    /// The sources are missing.
    #[error(
        "{}: no sources; the emitter is compiled for a design, so other designs than the default need the project",
        .0.display()
    )]
    NoSources(PathBuf),
    /// cargo cannot be started.
    #[error("cargo, which compiles the emitter for the design, cannot be started: {0}; install Rust")]
    NoCargo(std::io::Error),
    /// The emitter cannot be built, or refuses the design.
    #[error("the emitter of the design fails: {0}")]
    Fails(String),
    /// There is no cache folder.
    #[error(transparent)]
    Cache(#[from] hoverlock_cache::NoCacheFolder),
    /// A file cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
}

fn at(path: &Path) -> impl FnOnce(std::io::Error) -> OtherError {
    let path = path.to_path_buf();
    move |source| OtherError::File { path, source }
}

/// Emits all generated files of any design: compiles the emitter for it with cargo, which takes seconds, or reads an
/// earlier result from the cache.
///
/// # Errors
/// If the sources or cargo are missing, or the emitter fails.
pub fn files(design: &DesignPoint) -> Result<Vec<File>, OtherError> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = design.to_toml();
    let mut digest = Sha256::new();
    digest.update(&text);
    for source in sources(&project)? {
        digest.update(fs::read(&source).map_err(at(&source))?);
    }
    let name: String = digest.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let folder = hoverlock_cache::folder()?.join("emission");
    let kept = folder.join(format!("{name}.json"));
    if let Ok(emitted) = fs::read(&kept)
        && let Ok(files) = serde_json::from_slice(&emitted)
    {
        hoverlock_cache::touch(&kept);
        return Ok(files);
    }
    fs::create_dir_all(&folder).map_err(at(&folder))?;
    let mut file = tempfile::NamedTempFile::new_in(&folder).map_err(at(&folder))?;
    file.write_all(text.as_bytes()).map_err(at(&folder))?;
    let emitted = emit(&project, file.path(), &folder.join("target"))?;
    let files = serde_json::from_slice(&emitted).map_err(|error| OtherError::Fails(error.to_string()))?;
    let mut whole = tempfile::NamedTempFile::new_in(&folder).map_err(at(&folder))?;
    whole.write_all(&emitted).map_err(at(&folder))?;
    whole.persist(&kept).map_err(|error| error.error).map_err(at(&kept))?;
    hoverlock_cache::prune(&folder, hoverlock_cache::MAX_UNUSED_AGE);
    Ok(files)
}

/// Builds the emitter for a design file and runs it. Its target folder is in the cache folder, so that the lock and the
/// files of the project's own builds stay out of it; all projects of a user share its libraries.
fn emit(project: &Path, design: &Path, target: &Path) -> Result<Vec<u8>, OtherError> {
    let mut cargo = Command::new("cargo");
    cargo.current_dir(project).args(["run", "--quiet", "--locked", "--package", "hoverlock-rtl"]);
    cargo.args(["--features", "emitter", "--bin", "hoverlock-emitter", "--profile", "emitter"]);
    cargo.arg("--target-dir").arg(target);
    // Variables that cargo sets for what it runs would make it build everything again.
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy().into_owned();
        if name.starts_with("CARGO_PKG_")
            || name.starts_with("CARGO_MANIFEST_")
            || ["OUT_DIR", "CARGO_TARGET_DIR"].contains(&name.as_str())
        {
            cargo.env_remove(name);
        }
    }
    let run = cargo.env("HOVERLOCK_DESIGN", design).output().map_err(OtherError::NoCargo)?;
    if run.status.success() {
        return Ok(run.stdout);
    }
    let messages = String::from_utf8_lossy(&run.stderr);
    let is_reason = |line: &&str| line.starts_with("error") || line.starts_with("the design");
    let reason = messages.lines().map(str::trim).find(is_reason);
    Err(OtherError::Fails(reason.or(messages.lines().last()).unwrap_or("no reason given").to_owned()))
}

/// Returns the files that the emission depends on besides the design, sorted.
fn sources(project: &Path) -> Result<Vec<PathBuf>, OtherError> {
    let mut files = ["Cargo.lock", "registers/build.rs", "registers/map.toml"].map(|name| project.join(name)).to_vec();
    let folders = ["rtl/build", "rtl/src", "rtl/quartus", "registers/src", "design/src", "fixed_point/src/model"];
    let mut folders: Vec<PathBuf> =
        folders.into_iter().chain(["reference/src/features"]).map(|folder| project.join(folder)).collect();
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).map_err(|_| OtherError::NoSources(folder.clone()))?;
        for entry in entries {
            let path = entry.map_err(at(&folder))?.path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    let endings = ["rs", "template", "lock", "toml", "md", "sdc", "qpf", "qsf"];
    files.retain(|file| file.extension().is_some_and(|ending| endings.iter().any(|known| ending == *known)));
    files.sort();
    Ok(files)
}
