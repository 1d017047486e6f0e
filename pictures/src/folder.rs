//! Pictures as a user names them: files, and folders of files.

use std::cmp::Ordering;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::{PictureFile, centred_crop};

/// File name extensions by which the pictures of a folder are recognised.
const EXTENSIONS: [&str; 14] =
    ["bmp", "dib", "jpeg", "jpg", "pam", "pbm", "pgm", "png", "pnm", "ppm", "tif", "tiff", "webp", "jpe"];

/// An error of listing pictures.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// Standard input was named more than once.
    #[error("- stands for standard input, which can be read once; name the other picture as a file")]
    StandardInputTwice,
    /// A folder could not be read.
    #[error("{path}: the folder cannot be read: {source}")]
    Read {
        /// Path of the folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A folder has no picture.
    #[error("{path}: the folder holds no picture; name a folder of pictures, or picture files", path = .0.display())]
    NoPicture(PathBuf),
}

/// Returns the files that are named; a folder is replaced by its pictures in the order of [`pictures_in`].
///
/// # Errors
/// A folder cannot be read or has no picture, or standard input is named twice.
pub fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>, FolderError> {
    if paths.iter().filter(|path| *path == Path::new("-")).count() > 1 {
        return Err(FolderError::StandardInputTwice);
    }
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            files.extend(pictures_in(path)?);
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

/// Returns the pictures of a folder by name, runs of digits by their number: `2.png` comes before `10.png`. Hidden
/// files are left out: other systems put some beside pictures.
///
/// # Errors
/// The folder cannot be read or has no picture.
pub fn pictures_in(folder: &Path) -> Result<Vec<PathBuf>, FolderError> {
    let refused = |source| FolderError::Read { path: folder.into(), source };
    let is_picture = |path: &Path| {
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        !is_hidden && extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
    };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(refused)? {
        let path = entry.map_err(refused)?.path();
        if is_picture(&path) && path.is_file() {
            found.push(path);
        }
    }
    if found.is_empty() {
        return Err(FolderError::NoPicture(folder.into()));
    }
    found.sort_by(|a, b| cmp_natural(a, b));
    Ok(found)
}

/// Compares the names of two files of a folder, runs of digits by their number. Names that are equal then, such as
/// `1.png` and `01.png`, are compared by their bytes.
fn cmp_natural(a: &Path, b: &Path) -> Ordering {
    natural_key(a).cmp(natural_key(b)).then_with(|| a.cmp(b))
}

/// Returns the parts of a file name whose order is that of the name: a byte, or a run of digits as the byte of a digit,
/// the length of the number without leading zeros, and its digits.
fn natural_key(path: &Path) -> impl Iterator<Item = (u8, usize, &[u8])> {
    let name = path.file_name().unwrap_or(path.as_os_str()).as_encoded_bytes();
    name.chunk_by(|a, b| a.is_ascii_digit() && b.is_ascii_digit()).map(|part| match part[0] {
        byte if byte.is_ascii_digit() => {
            let zeros = part.iter().take_while(|digit| **digit == b'0').count();
            (b'0', part.len() - zeros, &part[zeros..])
        }
        byte => (byte, 0, part),
    })
}

/// Returns what a user should know about a picture before it is decoded: that it is turned or mirrored, or that its
/// orientation tag is ignored, and that only its centre of `frame` columns and rows is used.
pub fn remarks(file: &PictureFile, frame: Option<(usize, usize)>) -> Vec<String> {
    let name = file.path().display();
    let mut remarks = Vec::new();
    if let Some(orientation) = file.orientation() {
        remarks.push(format!("{name}: {orientation}, as its orientation tag asks"));
    }
    if file.ignores_orientation() {
        remarks
            .push(format!("{name}: taken as stored, not as its orientation tag asks: telemetry is about the sensor"));
    }
    if let Some(frame) = frame {
        let (size, (x, y, width, height)) = (file.size(), centred_crop(file.size(), frame));
        if size != (width, height) {
            let (whole_width, whole_height) = size;
            remarks.push(format!(
                "{name}: {whole_width}x{whole_height} is larger than the frame; taking its centre {width}x{height} at \
                 ({x}, {y})"
            ));
        }
    }
    remarks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let names = [
            "0.png",
            "01.png",
            "1.png",
            "2.png",
            "10.png",
            "99999999999999999999998.png",
            "99999999999999999999999.png",
            "a.png",
            "a1b9.png",
            "a1b10.png",
            "a2b1.png",
        ];
        for name in names.iter().rev() {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let found = expand(&[folder.path().into()]).unwrap();
        assert_eq!(found, names.map(|name| folder.path().join(name)));
    }
}
