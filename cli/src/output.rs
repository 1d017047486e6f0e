//! The output of a verb: text on stdout and stderr, and files.

use std::fmt::Write as _;
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use anstyle::{AnsiColor, Style};
use anyhow::{Context, Result, bail};
use serde::{Serialize, Serializer};
use tempfile::{Builder, TempPath};

use crate::interrupt::{Pending, remove_if_alone};

/// Writes `text` to stdout, with colours only on a terminal. A closed pipe (`| head`) is not an error.
pub fn print(text: &str) -> Result<()> {
    let mut stdout = anstream::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.context("stdout cannot be written"),
    }
}

/// Writes `value` to stdout as one JSON object.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    let mut text = serde_json::to_string_pretty(value).context("the result cannot be written as JSON")?;
    text.push('\n');
    print(&text)
}

/// Writes one line to stderr. Control characters are escaped, so that it stays one line. A stderr that is closed or
/// full costs remarks, and no results.
pub fn say(text: &str) {
    let _ = writeln!(io::stderr().lock(), "hoverlock: {}", visible(text));
}

/// Returns a verdict in bold, green or red on a terminal.
pub fn verdict(pass: bool, text: &str) -> String {
    let style = Style::new().bold().fg_color(Some(if pass { AnsiColor::Green } else { AnsiColor::Red }.into()));
    format!("{style}{text}{style:#}")
}

/// Escapes control characters, so that a newline in a file name does not make a second line.
pub fn visible(text: &str) -> String {
    text.chars().fold(String::new(), |mut shown, char| {
        if char.is_control() {
            // Writing to a String cannot fail.
            let _ = write!(shown, "{}", char.escape_default());
        } else {
            shown.push(char);
        }
        shown
    })
}

/// Returns a path for a table or a message, with control characters escaped.
pub fn shown(path: &Path) -> String {
    visible(&path.display().to_string())
}

/// Quotes a path for a shell. One that begins with a dash would be taken for an option.
pub fn quoted(path: &Path) -> String {
    let text = path.to_string_lossy();
    if text.len() > 1 && text.starts_with('-') { quote(&format!("./{text}")) } else { quote(&text) }
}

/// Quotes a word for a shell.
pub fn quote(word: &str) -> String {
    let plain = |char: char| char.is_ascii_alphanumeric() || "_-./+=:,@%".contains(char);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Returns the command as typed, without the folder of the program.
pub fn command() -> String {
    let quoted = std::env::args_os().skip(1).map(|word| quote(&word.to_string_lossy()));
    std::iter::once("hoverlock".to_owned()).chain(quoted).collect::<Vec<_>>().join(" ")
}

/// Serialises a path. Bytes that are not UTF-8 are replaced, because JSON cannot represent them.
pub fn lossy<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// Does the same as [`lossy`] for a path that may be missing.
pub fn lossy_option<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    match path {
        Some(path) => serializer.serialize_some(&path.to_string_lossy()),
        None => serializer.serialize_none(),
    }
}

/// Does the same as [`lossy`] for a list.
pub fn lossy_list<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

/// What is wrong with a file that is not to be written.
const READ_ONLY: &str = "is read-only; make it writable, or name another file";

/// Checks a file that is to be written: its extension is that of its format, it is not a folder, a device or read-only,
/// and it is not one of the inputs. Makes its folder before the work, and returns it: it goes again if it stays empty.
pub fn prepare_target(option: &str, path: &Path, endings: &[&str], inputs: &[&Path]) -> Result<Folder> {
    let name = path.display();
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !endings.contains(&ending) {
        bail!("{option} {name}: the name must end in .{}", endings.join(" or ."));
    }
    let folder = Folder::holding(path).with_context(|| format!("{option} {name}"))?;
    let Ok(there) = fs::metadata(path) else { return Ok(folder) };
    if there.is_dir() {
        bail!("{option} {name}: is a folder; name a file");
    }
    if !there.is_file() {
        bail!("{option} {name}: is there and is not a regular file; name another file");
    }
    if there.permissions().readonly() {
        bail!("{option} {name}: {READ_ONLY}");
    }
    let same =
        |input: &&Path| fs::metadata(input).is_ok_and(|input| (input.dev(), input.ino()) == (there.dev(), there.ino()));
    if inputs.iter().any(same) {
        bail!("{option} {name}: is one of the inputs; name another file");
    }
    Ok(folder)
}

/// Returns the file that is written in place of a path: the target of a link, or the path itself.
///
/// # Errors
/// It is a link to nothing, whose target would be created.
pub fn target(path: &Path) -> Result<PathBuf> {
    let there = path.canonicalize();
    if there.is_err() && path.is_symlink() {
        bail!("{}: is a link to nothing; name another file, or remove it", path.display());
    }
    Ok(there.unwrap_or_else(|_| path.to_owned()))
}

/// Removes a result of an earlier run. A link stays one, as in [`Aside`]: its target is emptied.
pub fn discard(path: &Path) -> Result<()> {
    let discarded = if path.is_symlink() { File::create(path).map(drop) } else { fs::remove_file(path) };
    discarded.with_context(|| format!("{}: cannot be replaced; check its permissions", path.display()))
}

/// A file that is written under a temporary name in its final folder. It is removed if it is not kept, and by a signal.
pub struct Aside {
    file: TempPath,
    path: PathBuf,
    _pending: Option<Pending>,
}

impl Aside {
    /// Creates an empty file. In place of a link its target is written; a file that is there keeps its permissions.
    pub fn new(path: &Path) -> Result<Self> {
        let target = target(path)?;
        let permissions = fs::metadata(&target).ok().map(|there| there.permissions());
        if permissions.as_ref().is_some_and(Permissions::readonly) {
            bail!("{}: {READ_ONLY}", path.display());
        }
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut pending = None;
        let file = Builder::new()
            .prefix(".hoverlock")
            .make_in(folder, |temporary| {
                // The file is registered before it exists, so that a signal always finds it.
                pending = Some(Pending::new(temporary));
                // The permissions of any new file, reduced by the user's mask.
                File::options().write(true).create_new(true).mode(0o666).open(temporary)
            })
            .with_context(|| unwritable(path))?
            .into_temp_path();
        if let Some(permissions) = permissions {
            fs::set_permissions(&file, permissions).with_context(|| unwritable(path))?;
        }
        Ok(Self { _pending: pending, file, path: target })
    }

    /// Returns the temporary path.
    pub fn temporary(&self) -> &Path {
        &self.file
    }

    fn write(path: &Path, bytes: &[u8]) -> Result<Self> {
        let aside = Self::new(path)?;
        fs::write(&aside.file, bytes).with_context(|| unwritable(path))?;
        Ok(aside)
    }

    /// Gives the file its final name.
    pub fn keep(self) -> Result<()> {
        self.file.persist(&self.path).map_err(|refused| refused.error).with_context(|| unwritable(&self.path))
    }
}

/// Reads a marker; an empty text if there is none.
fn read_marker(path: &Path) -> Result<String> {
    let Ok(there) = fs::symlink_metadata(path) else { return Ok(String::new()) };
    let remedy = "remove it, or name another folder";
    if !there.is_file() {
        bail!("{}: is not a regular file; {remedy}", path.display());
    }
    fs::read_to_string(path).with_context(|| format!("{}: cannot be read as text; {remedy}", path.display()))
}

/// Returns the message of a file that cannot be written.
pub fn unwritable(path: &Path) -> String {
    format!("{}: cannot be written; check the folder, its permissions and the space left", path.display())
}

/// Files that belong together. All of them are written under temporary names before the first gets its final name.
#[derive(Default)]
pub struct Batch(Vec<Aside>);

impl Batch {
    /// Writes one file under a temporary name.
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        if path.is_dir() {
            bail!("{}: is a folder, and a file of this name is to be written", path.display());
        }
        self.0.push(Aside::write(path, bytes)?);
        Ok(())
    }

    /// Gives all files their final names.
    pub fn keep(self) -> Result<()> {
        self.0.into_iter().try_for_each(Aside::keep)
    }
}

/// Writes a file under a temporary name and renames it, so that it is complete or does not exist.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    Aside::write(path, bytes)?.keep()
}

/// Removes a file of an earlier run if it is there.
pub fn remove_earlier(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("{}: of an earlier run, cannot be removed", shown(path)))
        }
        _ => Ok(()),
    }
}

/// File in a folder of results that names the verbs which write there, one a line.
pub const MARKER: &str = ".hoverlock";

/// A folder to write into. Folders that had to be created are removed again, also by a signal, if they stay empty.
#[must_use]
pub struct Folder {
    /// The marker, if it was written now.
    marker: Option<(PathBuf, Pending)>,
    made: Vec<(PathBuf, Pending)>,
}

impl Folder {
    /// Creates the folder and those above it.
    pub fn new(path: &Path) -> Result<Self> {
        let missing: Vec<&Path> =
            path.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists()).collect();
        let made = missing.into_iter().map(|folder| (folder.to_owned(), Pending::new(folder))).collect();
        let made = Self { marker: None, made };
        fs::create_dir_all(path).with_context(|| {
            format!("{}: cannot be made a folder; check the path and its permissions", path.display())
        })?;
        Ok(made)
    }

    /// Creates the folder of a file, and those above it.
    pub fn holding(file: &Path) -> Result<Self> {
        Self::new(file.parent().unwrap_or(Path::new("")))
    }

    /// Creates the folder for the results of a verb, and a file in it that names the verb. `files` are names that the
    /// verb will write.
    ///
    /// # Errors
    /// One of the files exists, and the folder is not one of this verb; one of them is a link to nothing; the marker
    /// is not a text file; or no file can be written there.
    pub fn of(path: &Path, verb: &str, files: &[&str]) -> Result<Self> {
        let (marker, owner) = (path.join(MARKER), format!("hoverlock {verb}"));
        let found = read_marker(&marker)?;
        let owners: Vec<&str> = found.lines().collect();
        let is_owner = owners.contains(&owner.as_str());
        let taken = files.iter().map(|name| path.join(name)).find(|file| !is_owner && file.exists());
        if let Some(file) = taken {
            bail!("{}: is not a file of {owner}; name another folder, or remove it", file.display());
        }
        files.iter().try_for_each(|name| target(&path.join(name)).map(drop))?;
        let mut folder = Self::new(path)?;
        if owners.is_empty() {
            folder.marker = Some((marker.clone(), Pending::new(&marker)));
        }
        let added = if is_owner { found } else { format!("{found}{owner}\n") };
        write_file(&marker, added.as_bytes())?;
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if let Some((marker, _pending)) = self.marker.take() {
            remove_if_alone(&marker);
        }
        // The deepest folder first. A folder with a file in it is not removed.
        for (folder, _pending) in self.made.drain(..) {
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_on_one_line_and_are_quoted_for_a_shell() {
        assert_eq!(visible("a\nb\tc\u{1b}[31m ü"), "a\\nb\\tc\\u{1b}[31m ü");
        assert_eq!(quote("sub/run.gtkw"), "sub/run.gtkw");
        assert_eq!(quote("my run.gtkw"), "'my run.gtkw'");
        assert_eq!(quote("it's"), r"'it'\''s'");
    }
}
