//! Pictures as arguments of a verb.

use std::path::Path;

use anyhow::Result;
use hoverlock_pictures::folder::remarks;
use hoverlock_pictures::{DEFAULT_MAX_MEGAPIXELS, Limits, Picture, PictureFile};

use crate::output::say;

/// The limit on the size of a picture.
#[derive(clap::Args)]
pub struct Limit {
    /// Largest size of a picture, million pixels
    #[arg(
        long,
        value_name = "N",
        default_value_t = DEFAULT_MAX_MEGAPIXELS,
        value_parser = clap::value_parser!(u32).range(1..=2000)
    )]
    max_megapixels: u32,
}

impl Limit {
    /// Returns the option that sets the limit again; nothing if it is the default.
    pub fn option(&self) -> String {
        let changed = self.max_megapixels != DEFAULT_MAX_MEGAPIXELS;
        if changed { format!(" --max-megapixels {}", self.max_megapixels) } else { String::new() }
    }

    /// Returns the limits on the size of a picture.
    pub fn limits(&self) -> Limits {
        Limits::from_megapixels(self.max_megapixels)
    }
}

/// Decodes a picture of at least `min_side` x `min_side` pixels that are not all equal. Says on stderr if it is turned
/// or mirrored, and if only its centre of `frame` columns and rows will be used.
pub fn open(path: &Path, limit: &Limit, min_side: usize, frame: Option<(usize, usize)>) -> Result<Picture> {
    decode(PictureFile::open(path, &limit.limits())?, min_side, frame)
}

/// Does the same as [`open`] for a picture with telemetry, whose pixels stay as stored.
pub fn open_of_sensor(path: &Path, limit: &Limit, min_side: usize, frame: Option<(usize, usize)>) -> Result<Picture> {
    decode(PictureFile::open(path, &limit.limits())?.as_stored(), min_side, frame)
}

fn decode(file: PictureFile, min_side: usize, frame: Option<(usize, usize)>) -> Result<Picture> {
    let file = file.require(min_side, min_side)?;
    remarks(&file, frame).iter().for_each(|remark| say(remark));
    Ok(file.decode()?.require(min_side, min_side)?)
}
