//! The cache folder: built models, netlists, downloaded pictures, and whatever else can be made again.
//!
//! `$HOVERLOCK_CACHE` if it is set, else `$XDG_CACHE_HOME/hoverlock`, else `$HOME/.cache/hoverlock`. Each user of the
//! folder has a subfolder of its own; those of built models are `models`, `runtime`, `locks` and `aside`.

use std::ffi::OsString;
use std::path::PathBuf;

/// No variable of the environment says where the cache folder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no cache folder: neither HOVERLOCK_CACHE nor XDG_CACHE_HOME nor HOME is set; set HOVERLOCK_CACHE to a folder")]
pub struct NoCacheFolder;

/// The cache folder. It need not exist yet.
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
}
