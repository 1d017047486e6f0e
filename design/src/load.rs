//! Loads designs as a user names them: built in, in a file, or as changes of `kt27`.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

use toml::Table;

use crate::file::{entry, parse};
use crate::{DesignError, DesignPoint, KT27, SHIPPED};

/// The reason why a design could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// There is no design and no file of this name.
    #[error(
        "{path}: no such file, and no design of that name; the names are {names}",
        path = .0.display(),
        names = names()
    )]
    Unknown(PathBuf),
    /// A change is neither `KEY=VALUE` nor a file.
    #[error("{} is neither KEY=VALUE nor a configuration file", .0.display())]
    NeitherChangeNorFile(PathBuf),
    /// The path is a folder, a device or a FIFO.
    #[error("{path}: the {kind} is not a regular file")]
    NotAFile {
        /// The path as given.
        path: PathBuf,
        /// `design` or `configuration`.
        kind: &'static str,
    },
    /// The file could not be read.
    #[error("{path}: the {kind} cannot be read: {source}")]
    Read {
        /// The file that was to be read.
        path: PathBuf,
        /// `design` or `configuration`.
        kind: &'static str,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is not a valid design.
    #[error("{path}: {source}")]
    File {
        /// The file that was to be read.
        path: PathBuf,
        /// The error of the parser.
        source: DesignError,
    },
    /// A design is not valid.
    #[error(transparent)]
    Design(#[from] DesignError),
}

fn names() -> String {
    SHIPPED.map(|(name, _)| name).join(", ")
}

impl DesignPoint {
    /// Loads a design by its name, or from a design file.
    ///
    /// # Errors
    /// There is neither, or the file is not a valid design.
    pub fn load(name: &OsStr) -> Result<Self, LoadError> {
        if let Some(shipped) = name.to_str().and_then(Self::shipped) {
            return Ok(shipped);
        }
        let path = Path::new(name);
        if !path.exists() {
            return Err(LoadError::Unknown(path.into()));
        }
        let text = read(path, "design")?;
        Self::from_file(&text).map_err(|source| LoadError::File { path: path.into(), source })
    }

    /// Returns this design with changes, which are made together: `KEY=VALUE`, or a configuration file with some of the
    /// keys. Of a key that is changed twice the later value counts.
    ///
    /// # Errors
    /// A file cannot be read, or the changed design is not valid.
    pub fn with_changes(&self, changes: &[impl AsRef<OsStr>]) -> Result<Self, LoadError> {
        let mut table = Table::new();
        let mut files: BTreeMap<String, &Path> = BTreeMap::new();
        for change in changes.iter().map(AsRef::as_ref) {
            let path = Path::new(change);
            match change.to_str() {
                Some(change) if change.contains('=') && !path.exists() => {
                    let (key, value) = entry(change)?;
                    files.remove(&key);
                    table.insert(key, value);
                }
                _ if !path.exists() => return Err(LoadError::NeitherChangeNorFile(path.into())),
                _ => {
                    let text = read(path, "configuration")?;
                    let of_file = |source| LoadError::File { path: path.into(), source };
                    let changes = parse(&text).map_err(of_file)?;
                    files.extend(changes.keys().map(|key| (key.clone(), path)));
                    table.extend(changes);
                }
            }
        }
        self.changed(&table).map_err(|source| match source.key().and_then(|key| files.get(key)) {
            Some(&path) => LoadError::File { path: path.into(), source },
            None => source.into(),
        })
    }

    /// Loads a design by its name, from a design file, or as changes of [`KT27`] separated by commas.
    ///
    /// # Errors
    /// Those of [`DesignPoint::load`] and [`DesignPoint::with_changes`], or a key is changed twice.
    pub fn load_or_change(name: &str) -> Result<Self, LoadError> {
        if !name.contains('=') {
            return Self::load(name.as_ref());
        }
        let changes = separate(name);
        let keys: Vec<&str> =
            changes.iter().filter_map(|change| change.split_once('=')).map(|(key, _)| key.trim()).collect();
        if let Some((_, twice)) = keys.iter().enumerate().find(|(at, key)| keys[..*at].contains(key)) {
            return Err(DesignError::Twice { key: (*twice).to_owned() }.into());
        }
        KT27.with_changes(&changes)
    }
}

/// Separates changes at the commas outside lists.
fn separate(text: &str) -> Vec<&str> {
    let (mut parts, mut from, mut depth) = (Vec::new(), 0, 0_i32);
    for (at, char) in text.char_indices() {
        match char {
            '[' => depth += 1,
            ']' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[from..]);
    parts
}

fn read(path: &Path, kind: &'static str) -> Result<String, LoadError> {
    // A device or a FIFO may never end.
    if path.exists() && !path.is_file() {
        return Err(LoadError::NotAFile { path: path.into(), kind });
    }
    std::fs::read_to_string(path).map_err(|source| LoadError::Read { path: path.into(), kind, source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_separated_outside_lists_and_a_key_is_changed_once() {
        let design = DesignPoint::load_or_change("look_ahead=[5,5,5],dog_bits=14").unwrap();
        assert_eq!((&*design.look_ahead, design.dog_bits), (&[5, 5, 5][..], 14));
        let error = DesignPoint::load_or_change("dog_bits=14,state=u16.1, dog_bits=15").unwrap_err().to_string();
        assert_eq!(error, "the key `dog_bits` is changed twice; give each key once");
    }

    #[test]
    fn a_change_that_is_neither_a_value_nor_a_file_says_what_it_should_be() {
        let error = KT27.with_changes(&["dog_bits"]).unwrap_err().to_string();
        assert_eq!(error, "dog_bits is neither KEY=VALUE nor a configuration file");
    }

    #[test]
    fn an_error_names_the_file_that_the_value_is_from() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("part.toml");
        std::fs::write(&file, "dog_bits = 99\nwidth = 640\n").unwrap();
        let error = |changes: &[&OsStr]| KT27.with_changes(changes).unwrap_err().to_string();
        let [file, height, width, bits] =
            [file.as_os_str(), "height=480".as_ref(), "width=-1".as_ref(), "dog_bits=12".as_ref()];
        assert!(error(&[file, height]).contains("part.toml: dog_bits = 99 is not possible"));
        assert!(error(&[file, bits, width]).starts_with("width = -1"));
        assert_eq!(KT27.with_changes(&[file, bits]).unwrap().width, 640);
    }
}
