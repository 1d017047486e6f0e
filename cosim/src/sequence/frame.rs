//! A picture file of a sequence. Its pixels are decoded for the time that they are needed: a recording of ten minutes
//! does not fit into memory.

use std::path::{Path, PathBuf};

use hoverlock_pictures::{Limits, PictureFile, centred_crop, folder};
use hoverlock_reference::image::plane::Plane;

use super::SequenceError;

/// Smallest width and height of a frame that the hardware takes, px.
const MIN_SIDE: usize = 64;

/// A picture file of a sequence. The frame is the centre of the picture, at most as large as a frame of the design.
#[derive(Debug, Clone)]
pub struct FrameFile {
    path: PathBuf,
    /// Columns and rows of the whole picture.
    whole: (usize, usize),
    /// Columns and rows of the largest frame.
    largest: (usize, usize),
    limits: Limits,
}

impl FrameFile {
    /// Checks a file and the pixels in it. Returns remarks with it if its orientation tag is ignored, or it is cropped
    /// to the columns and rows of the `largest` frame.
    ///
    /// # Errors
    /// The file cannot be read, is damaged or beyond the limits, or the picture has fewer than 64 rows or columns.
    pub(super) fn check(
        path: PathBuf,
        limits: &Limits,
        largest: (usize, usize),
    ) -> Result<(Self, Vec<String>), SequenceError> {
        let file = PictureFile::open(&path, limits)?.as_stored().require(MIN_SIDE, MIN_SIDE)?;
        let (whole, remarks) = (file.size(), folder::remarks(&file, Some(largest)));
        file.decode()?;
        Ok((Self { path, whole, largest, limits: limits.clone() }, remarks))
    }

    /// Returns this file if its picture is as large as that of `other`.
    ///
    /// # Errors
    /// It is not.
    pub(super) fn require_size_of(self, other: &Self) -> Result<Self, SequenceError> {
        check_size(&self.path, self.whole, other.whole)?;
        Ok(self)
    }

    /// Returns the name of the file.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// Returns columns and rows of the frame.
    pub fn size(&self) -> (usize, usize) {
        let (_, _, width, height) = centred_crop(self.whole, self.largest);
        (width, height)
    }

    /// Returns the pixel of the picture at which the frame begins.
    pub(super) fn corner(&self) -> (usize, usize) {
        let (x, y, _, _) = centred_crop(self.whole, self.largest);
        (x, y)
    }

    /// Returns the columns of the frame over those of the picture.
    pub(super) fn part(&self) -> f64 {
        self.size().0 as f64 / self.whole.0 as f64
    }

    /// Returns the time at which the first row of the frame is read out, and the time from there to its last row, both
    /// over the time from the first to the last row of the picture.
    pub(super) fn readout(&self) -> [f64; 2] {
        let steps = self.whole.1 as f64 - 1.0;
        [self.corner().1 as f64 / steps, (self.size().1 as f64 - 1.0) / steps]
    }

    /// Decodes the frame, DN.
    ///
    /// # Errors
    /// The file was changed after it was checked: it cannot be read, is damaged, or has another size.
    pub fn decode(&self) -> Result<Plane<u16>, SequenceError> {
        let picture = PictureFile::open(&self.path, &self.limits)?.as_stored().decode()?;
        check_size(&self.path, (picture.luma.width(), picture.luma.height()), self.whole)?;
        let (width, height) = self.largest;
        Ok(picture.crop(width, height).luma)
    }
}

/// Checks that a picture is as large as those before.
fn check_size(path: &Path, size: (usize, usize), first: (usize, usize)) -> Result<(), SequenceError> {
    if size == first {
        return Ok(());
    }
    let ((width, height), (first_width, first_height)) = (size, first);
    Err(SequenceError::Size { path: path.into(), width, height, first_width, first_height })
}
