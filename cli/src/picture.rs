//! Pictures as a verb takes them: files, folders of files, or standard input, within a limit.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use hoverlock_pictures::{Limits, MEGAPIXELS, Picture, PictureFile, centre};

use crate::output::say;

/// Endings by which the pictures of a folder are known.
const ENDINGS: [&str; 14] =
    ["bmp", "dib", "jpeg", "jpg", "pam", "pbm", "pgm", "png", "pnm", "ppm", "tif", "tiff", "webp", "jpe"];

/// How large a picture may be.
#[derive(clap::Args)]
pub struct Limit {
    /// Million pixels a picture may have at most
    #[arg(
        long,
        value_name = "N",
        default_value_t = MEGAPIXELS,
        value_parser = clap::value_parser!(u32).range(1..=2000)
    )]
    max_megapixels: u32,
}

/// Decodes a picture of at least `least` x `least` pixels that are not all equal. Says on stderr if it is turned or
/// mirrored, and before it is decoded if only its centre of `frame` columns and rows will be used.
pub fn open(path: &Path, limit: &Limit, least: usize, frame: Option<(usize, usize)>) -> Result<Picture> {
    let file = PictureFile::open(path, &Limits::of_megapixels(limit.max_megapixels))?.require(least, least)?;
    let name = path.display();
    if let Some(how) = file.orientation() {
        say(&format!("{name}: {how}, as its orientation tag asks"));
    }
    if let Some(frame) = frame {
        let (size, (x, y, width, height)) = (file.size(), centre(file.size(), frame));
        if size != (width, height) {
            let (of_width, of_height) = size;
            say(&format!(
                "{name}: {of_width}x{of_height} is larger than the frame; taking its centre {width}x{height} \
                 at ({x}, {y})"
            ));
        }
    }
    Ok(file.decode()?.require(least, least)?)
}

/// The files that are named, and in place of a folder the pictures in it by name.
pub fn listed(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    if paths.iter().filter(|path| *path == Path::new("-")).count() > 1 {
        bail!("- stands for standard input, which can be read once; name the other picture as a file");
    }
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            files.extend(pictures(path)?);
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

fn pictures(folder: &Path) -> Result<Vec<PathBuf>> {
    let unreadable = || format!("{}: the folder cannot be read", folder.display());
    let ends = |path: &Path| {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
    };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        if ends(&path) && path.is_file() {
            found.push(path);
        }
    }
    if found.is_empty() {
        bail!("{}: the folder holds no picture; name a folder of pictures, or picture files", folder.display());
    }
    found.sort();
    Ok(found)
}
