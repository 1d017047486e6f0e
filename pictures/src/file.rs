//! Opening a picture file in two steps: the header, with its size and orientation, and then the pixels.

use std::path::{Path, PathBuf};

use hoverlock_reference::image::plane::Plane;
use image::metadata::Orientation;

use crate::decode::ImageReader;
use crate::{Limits, Picture, PictureError, check_size, source};

/// A picture file whose header was read: its size is known and within the limits, its pixels are not decoded yet.
pub struct PictureFile {
    path: PathBuf,
    reader: ImageReader,
    as_stored: bool,
}

impl PictureFile {
    /// Opens `path`, or standard input for `-`, and reads the header.
    ///
    /// # Errors
    /// The file cannot be read, is not a regular file, is not a picture of a known format, or exceeds `limits`.
    pub fn open(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, PictureError> {
        let path = path.as_ref().to_path_buf();
        let reader = ImageReader::new(source::open(&path, limits)?, limits).map_err(|error| error.with_path(&path))?;
        let (width, height) = reader.stored_size();
        let pixels = width as u64 * height as u64;
        if pixels > limits.max_pixels {
            let limit_megapixels = limits.max_pixels / 1_000_000;
            return Err(PictureError::TooManyPixels { path, width, height, limit_megapixels });
        }
        Ok(Self { path, reader, as_stored: false })
    }

    /// Returns the path of the file, as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the file as one whose pixels stay as they are stored, whatever its orientation tag asks: field of view
    /// and attitude of a camera are about the columns and rows of its sensor.
    pub fn as_stored(self) -> Self {
        Self { as_stored: true, ..self }
    }

    /// Returns `true` if there is an orientation tag that is not followed.
    pub(crate) fn ignores_orientation(&self) -> bool {
        self.as_stored && self.reader.orientation() != Orientation::NoTransforms
    }

    /// Returns the orientation that is followed.
    fn followed(&self) -> Orientation {
        if self.as_stored { Orientation::NoTransforms } else { self.reader.orientation() }
    }

    /// Returns columns and rows of the picture that is decoded.
    pub fn size(&self) -> (usize, usize) {
        let (width, height) = self.reader.stored_size();
        if exchanges_sides(self.followed()) { (height, width) } else { (width, height) }
    }

    /// Describes how the picture is turned or mirrored when it is decoded. `None` if its pixels stay as stored.
    pub fn orientation(&self) -> Option<&'static str> {
        match self.followed() {
            Orientation::NoTransforms => None,
            Orientation::Rotate90 => Some("turned by 90 degrees clockwise"),
            Orientation::Rotate180 => Some("turned by 180 degrees"),
            Orientation::Rotate270 => Some("turned by 90 degrees anticlockwise"),
            Orientation::FlipHorizontal => Some("mirrored left to right"),
            Orientation::FlipVertical => Some("mirrored top to bottom"),
            Orientation::Rotate90FlipH => Some("turned by 90 degrees clockwise and mirrored left to right"),
            Orientation::Rotate270FlipH => Some("turned by 90 degrees anticlockwise and mirrored left to right"),
        }
    }

    /// Returns the file if the picture has at least `min_width` x `min_height` pixels.
    ///
    /// # Errors
    /// The picture is smaller.
    pub fn require(self, min_width: usize, min_height: usize) -> Result<Self, PictureError> {
        check_size(&self.path, self.size(), (min_width, min_height))?;
        Ok(self)
    }

    /// Decodes the pixels, and turns them upright unless they stay as stored.
    ///
    /// # Errors
    /// The file is truncated or damaged, or its samples have no full scale.
    pub fn decode(self) -> Result<Picture, PictureError> {
        let orientation = self.followed();
        let Self { path, reader, .. } = self;
        let (width, height) = reader.stored_size();
        let damaged = |reason: &str| PictureError::Damaged { path: path.clone(), reason: reason.to_owned() };
        let decoded = reader.decode().map_err(|error| error.with_path(&path))?;
        let luma = Plane::from_vec(width, height, decoded.luma)
            .map_err(|_| damaged("it holds more or fewer pixels than its header says"))?;
        Ok(Picture { luma: upright(luma, orientation), source_bits: decoded.source_bits, path })
    }
}

/// Returns `true` if an orientation exchanges columns and rows.
fn exchanges_sides(orientation: Orientation) -> bool {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    matches!(orientation, Rotate90 | Rotate90FlipH | Rotate270 | Rotate270FlipH)
}

/// Turns and mirrors a stored plane upright.
fn upright(stored: Plane<u16>, orientation: Orientation) -> Plane<u16> {
    let (width, height) = (stored.width(), stored.height());
    let (right, bottom) = (width - 1, height - 1);
    let at: fn(usize, usize, usize, usize) -> (usize, usize) = match orientation {
        Orientation::NoTransforms => return stored,
        Orientation::FlipHorizontal => |x, y, right, _| (right - x, y),
        Orientation::Rotate180 => |x, y, right, bottom| (right - x, bottom - y),
        Orientation::FlipVertical => |x, y, _, bottom| (x, bottom - y),
        Orientation::Rotate90FlipH => |x, y, _, _| (y, x),
        Orientation::Rotate90 => |x, y, _, bottom| (y, bottom - x),
        Orientation::Rotate270FlipH => |x, y, right, bottom| (right - y, bottom - x),
        Orientation::Rotate270 => |x, y, right, _| (right - y, x),
    };
    let (width, height) = if exchanges_sides(orientation) { (height, width) } else { (width, height) };
    Plane::from_fn(width, height, |x, y| stored[at(x, y, right, bottom)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageBuffer, Luma};

    #[test]
    fn every_orientation_is_the_one_that_image_applies() {
        let stored = Plane::from_fn(5, 3, |x, y| (10 * y + x) as u16);
        for exif in 1..=8 {
            let orientation = Orientation::from_exif(exif).unwrap();
            let buffer = ImageBuffer::<Luma<u16>, _>::from_raw(5, 3, stored.as_slice().to_vec()).unwrap();
            let mut expected = DynamicImage::ImageLuma16(buffer);
            expected.apply_orientation(orientation);
            let turned = upright(stored.clone(), orientation);
            assert_eq!(
                (turned.width() as u32, turned.height() as u32),
                (expected.width(), expected.height()),
                "{exif}"
            );
            assert_eq!(turned.as_slice(), expected.to_luma16().as_raw().as_slice(), "{exif}");
        }
    }
}
