//! The cache folder: built models, netlists, downloaded pictures and other files that can be created again.
//!
//! It is `$HOVERLOCK_CACHE` if that is set, else `$XDG_CACHE_HOME/hoverlock`, else `$HOME/.cache/hoverlock`. Each kind
//! of file has a subfolder; those of built models are `models`, `runtime`, `locks` and `aside`.

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Time since the last use after which a file may be removed: 30 days.
pub const MAX_UNUSED_AGE: Duration = Duration::from_secs(30 * 24 * 3600);

/// The error that no environment variable determines the cache folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no cache folder: neither HOVERLOCK_CACHE nor XDG_CACHE_HOME nor HOME is set; set HOVERLOCK_CACHE to a folder")]
pub struct NoCacheFolder;

/// Returns the path of the cache folder, which need not exist yet.
///
/// # Errors
/// If none of `HOVERLOCK_CACHE`, `XDG_CACHE_HOME` and `HOME` is set.
pub fn folder() -> Result<PathBuf, NoCacheFolder> {
    folder_from(|name| std::env::var_os(name))
}

fn folder_from(variable: impl Fn(&str) -> Option<OsString>) -> Result<PathBuf, NoCacheFolder> {
    let path = |name| variable(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    if let Some(folder) = path("HOVERLOCK_CACHE") {
        return Ok(folder);
    }
    // The XDG base directory specification: a relative path is invalid and is ignored.
    let base = path("XDG_CACHE_HOME").filter(|folder| folder.is_absolute());
    let base = base.or_else(|| path("HOME").map(|home| home.join(".cache")));
    base.map(|folder| folder.join("hoverlock")).ok_or(NoCacheFolder)
}

/// Marks a file of the cache as used now, so that [`prune`] keeps it. Has no effect if the cache is not writable.
pub fn touch(file: &Path) {
    if let Ok(file) = File::options().append(true).open(file) {
        // The files of a read-only cache remain usable.
        let _ = file.set_modified(SystemTime::now());
    }
}

/// Removes the files directly in `folder` that were last written or touched more than `max_age` ago, and returns their
/// number. Files that cannot be removed are skipped.
pub fn prune(folder: &Path, max_age: Duration) -> usize {
    let Some(oldest) = SystemTime::now().checked_sub(max_age) else { return 0 };
    let Ok(entries) = fs::read_dir(folder) else { return 0 };
    let old = entries.flatten().filter(|entry| {
        let metadata = entry.metadata().ok().filter(fs::Metadata::is_file);
        metadata.and_then(|metadata| metadata.modified().ok()).is_some_and(|used| used < oldest)
    });
    old.filter(|entry| fs::remove_file(entry.path()).is_ok()).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(variables: &[(&str, &str)]) -> Result<PathBuf, NoCacheFolder> {
        folder_from(|name| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| value.into()))
    }

    #[test]
    fn the_first_variable_that_is_set_decides() {
        let (own, xdg, home) = (("HOVERLOCK_CACHE", "/own"), ("XDG_CACHE_HOME", "/xdg"), ("HOME", "/home/me"));
        assert_eq!(found(&[home, xdg, own]), Ok("/own".into()));
        assert_eq!(found(&[home, xdg]), Ok("/xdg/hoverlock".into()));
        assert_eq!(found(&[home]), Ok("/home/me/.cache/hoverlock".into()));
        assert_eq!(found(&[]), Err(NoCacheFolder));
    }

    #[test]
    fn empty_variables_and_a_relative_xdg_folder_count_as_not_set() {
        let empty = [("HOVERLOCK_CACHE", ""), ("XDG_CACHE_HOME", ""), ("HOME", "/home/me")];
        assert_eq!(found(&empty), Ok("/home/me/.cache/hoverlock".into()));
        assert_eq!(found(&[("XDG_CACHE_HOME", "xdg"), ("HOME", "/home/me")]), Ok("/home/me/.cache/hoverlock".into()));
    }

    #[test]
    fn prune_removes_unused_files_and_keeps_touched_ones() {
        let folder = tempfile::tempdir().unwrap();
        let [old, used, new] = ["old", "used", "new"].map(|name| folder.path().join(name));
        for file in [&old, &used, &new] {
            fs::write(file, "netlist").unwrap();
        }
        let long_ago = SystemTime::now() - 2 * MAX_UNUSED_AGE;
        for file in [&old, &used] {
            File::options().append(true).open(file).unwrap().set_modified(long_ago).unwrap();
        }
        touch(&used);
        assert_eq!(prune(folder.path(), MAX_UNUSED_AGE), 1);
        assert!(!old.exists() && used.exists() && new.exists());
        assert_eq!(fs::read_to_string(&used).unwrap(), "netlist");
        assert_eq!(prune(&folder.path().join("missing"), MAX_UNUSED_AGE), 0);
    }
}
