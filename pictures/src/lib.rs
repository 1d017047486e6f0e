//! Picture files to planes of 16-bit luma, `I = (299 R + 587 G + 114 B + 500) / 1000`, within limits; and seeded
//! degradations of such planes ([`conditions`]).
//!
//! Luma (ITU-R BT.601 weights) is computed in the bit depth of the source. Alpha is ignored. An 8-bit value `v` becomes
//! the 16-bit value `257 v`, so that white stays full scale. A hash ([`sha256`]) identifies the decoded plane, not the
//! file: the same pixels in another container have the same hash.
//!
//! Picture files are untrusted, so they are read in two steps. [`PictureFile::open`] reads the header, and rejects
//! anything that is not a regular file or exceeds the [`Limits`]. [`PictureFile::decode`] decodes row by row if the
//! format allows it, and rejects truncated and damaged files, for which the decoders would return grey without an
//! error.

pub mod conditions;
mod decode;
mod error;
mod file;
pub mod folder;
mod jpeg;
mod luma;
mod pnm;
mod source;

use std::path::{Path, PathBuf};

use hoverlock_reference::image::plane::Plane;
use sha2::{Digest, Sha256};

pub use error::PictureError;
pub use file::PictureFile;

/// Default limit of the size of a picture, million pixels: the features of two such pictures are found within 1 GB.
pub const DEFAULT_MAX_MEGAPIXELS: u32 = 50;

/// A decoded picture with its path.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Path of the file, as given.
    pub path: PathBuf,
    /// 16-bit luma, DN (`0 ..= 65535`), upright.
    pub luma: Plane<u16>,
    /// Bits of the samples of the file, 8 or 16.
    pub source_bits: u32,
}

/// The limits of the size of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Largest number of pixels.
    pub max_pixels: u64,
    /// Largest number of bytes of the file.
    pub max_bytes: u64,
}

impl Limits {
    /// Returns the limits of pictures of `megapixels` million pixels: files of at most 16 bytes a pixel (RGBA of 16
    /// bits has 8), but always of up to 64 MB.
    pub fn from_megapixels(megapixels: u32) -> Self {
        let max_pixels = u64::from(megapixels) * 1_000_000;
        Self { max_pixels, max_bytes: (16 * max_pixels).max(64_000_000) }
    }
}

impl Default for Limits {
    /// Returns the limits for [`DEFAULT_MAX_MEGAPIXELS`].
    fn default() -> Self {
        Self::from_megapixels(DEFAULT_MAX_MEGAPIXELS)
    }
}

/// Returns `(x, y, width, height)` of the centre of a picture of `size` (w, h) that fits a `frame` of (W, H):
/// `x = floor((w - W) / 2)`, `y = floor((h - H) / 2)`, or the whole side if the picture is smaller.
pub fn centred_crop(size: (usize, usize), frame: (usize, usize)) -> (usize, usize, usize, usize) {
    let (width, height) = (size.0.min(frame.0), size.1.min(frame.1));
    ((size.0 - width) / 2, (size.1 - height) / 2, width, height)
}

/// The centre of a picture, cropped to the size of a frame.
#[derive(Debug, Clone)]
pub struct Crop {
    /// 16-bit luma of the crop, DN.
    pub luma: Plane<u16>,
    /// Column of the picture at which the crop begins, 0 if the picture is no wider than the frame.
    pub x: usize,
    /// Row of the picture at which the crop begins, 0 if the picture is no taller than the frame.
    pub y: usize,
}

impl Picture {
    /// Reads and decodes `path` within the default [`Limits`].
    ///
    /// # Errors
    /// As [`PictureFile::open`] and [`PictureFile::decode`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, PictureError> {
        PictureFile::open(path, &Limits::default())?.decode()
    }

    /// Returns the picture if it has at least `min_width` x `min_height` pixels.
    ///
    /// # Errors
    /// The picture is smaller.
    pub fn require_size(self, min_width: usize, min_height: usize) -> Result<Self, PictureError> {
        check_size(&self.path, (self.luma.width(), self.luma.height()), (min_width, min_height))?;
        Ok(self)
    }

    /// Returns the picture if it has at least `min_width` x `min_height` pixels and at least two different values.
    ///
    /// # Errors
    /// The picture is smaller, or all pixels are equal.
    pub fn require(self, min_width: usize, min_height: usize) -> Result<Self, PictureError> {
        let picture = self.require_size(min_width, min_height)?;
        let value = picture.luma[(0, 0)];
        if picture.luma.as_slice().iter().all(|&code| code == value) {
            return Err(PictureError::NoContrast { path: picture.path, value });
        }
        Ok(picture)
    }

    /// Crops the picture to its centre of at most `width` x `height` pixels.
    pub fn crop(&self, width: usize, height: usize) -> Crop {
        let (x, y, width, height) = centred_crop((self.luma.width(), self.luma.height()), (width, height));
        let luma = Plane::from_fn(width, height, |column, row| self.luma[(x + column, y + row)]);
        Crop { luma, x, y }
    }

    /// Returns the hash of the luma plane; see [`sha256`].
    pub fn sha256(&self) -> String {
        sha256(&self.luma)
    }
}

/// Returns the SHA-256 of a plane in hexadecimal. The hashed bytes are width and height as 32-bit numbers, then the
/// samples in raster order as 16-bit numbers, all little-endian.
pub fn sha256(plane: &Plane<u16>) -> String {
    let mut hash = Sha256::new();
    for side in [plane.width(), plane.height()] {
        hash.update((side as u32).to_le_bytes());
    }
    for row in plane.rows() {
        let bytes: Vec<u8> = row.iter().flat_map(|code| code.to_le_bytes()).collect();
        hash.update(&bytes);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the folder of real nadir pictures, or `None` if it does not exist: `HOVERLOCK_DATA`, or `shared/data` beside
/// the project. Their size and licences keep them out of the project; tests that need them report on stderr and skip.
pub fn data_dir() -> Option<PathBuf> {
    let named = std::env::var_os("HOVERLOCK_DATA").map(PathBuf::from);
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    Some(named.unwrap_or_else(beside)).filter(|folder| folder.is_dir())
}

/// Returns the folder into which `make demo` puts the aerial photographs of Debian's `opencv-doc`, or `None` if it does
/// not exist.
pub fn demo_dir() -> Option<PathBuf> {
    Some(hoverlock_cache::folder().ok()?.join("pictures")).filter(|folder| folder.is_dir())
}

/// Checks that a picture of `size` (columns, rows) has at least the columns and rows of `min`.
fn check_size(path: &Path, size: (usize, usize), min: (usize, usize)) -> Result<(), PictureError> {
    if size.0 >= min.0 && size.1 >= min.1 {
        return Ok(());
    }
    let ((width, height), (min_width, min_height)) = (size, min);
    Err(PictureError::TooSmall { path: path.to_path_buf(), width, height, min_width, min_height })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageBuffer, Luma, Rgb, Rgba};
    use std::fs;

    fn saved(name: &str, image: &DynamicImage) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        image.save(&path).unwrap();
        (folder, path)
    }

    #[test]
    fn eight_bits_fill_sixteen() {
        let image = DynamicImage::ImageLuma8(ImageBuffer::from_fn(2, 1, |x, _| Luma([if x == 0 { 1 } else { 255 }])));
        let (_folder, path) = saved("a.png", &image);
        let picture = Picture::open(path).unwrap();
        assert_eq!(picture.luma.as_slice(), [257, 65535]);
        assert_eq!(picture.source_bits, 8);
    }

    #[test]
    fn luma_rounds_in_the_source_depth() {
        // 299 * 10 + 587 * 20 + 114 * 31 + 500 = 18764: 18 in 8 bits, 4626 in 16; 16-bit samples keep their own depth.
        let rgb = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(1, 1, Rgb([10, 20, 31])));
        let (_folder, path) = saved("a.png", &rgb);
        assert_eq!(Picture::open(path).unwrap().luma.as_slice(), [18 * 257]);
        let rgba = DynamicImage::ImageRgba16(ImageBuffer::from_pixel(1, 1, Rgba([65535u16, 65535, 65535, 0])));
        let (_folder, path) = saved("b.png", &rgba);
        let white = Picture::open(path).unwrap();
        assert_eq!((white.luma.as_slice(), white.source_bits), (&[65535][..], 16));
    }

    #[test]
    fn unusable_files_give_the_right_error() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("text.png"), "not a picture").unwrap();
        fs::write(at("empty.png"), "").unwrap();
        let image = DynamicImage::ImageLuma8(ImageBuffer::from_fn(64, 64, |x, y| Luma([(x * y) as u8])));
        image.save(at("whole.png")).unwrap();
        let whole = fs::read(at("whole.png")).unwrap();
        fs::write(at("short.png"), &whole[..whole.len() / 2]).unwrap();
        assert!(matches!(Picture::open(at("none.png")), Err(PictureError::Read { .. })));
        assert!(matches!(Picture::open(folder.path()), Err(PictureError::IsFolder { .. })));
        assert!(matches!(Picture::open(at("text.png")), Err(PictureError::UnknownFormat { .. })));
        assert!(matches!(Picture::open(at("empty.png")), Err(PictureError::EmptyFile { .. })));
        assert!(matches!(Picture::open(at("short.png")), Err(PictureError::Damaged { .. })));
        let floats = DynamicImage::ImageRgb32F(ImageBuffer::from_pixel(2, 2, Rgb([f32::NAN, 0.0, 1.0])));
        floats.save(at("floats.tiff")).unwrap();
        assert!(matches!(Picture::open(at("floats.tiff")), Err(PictureError::UnsupportedFormat { .. })));
    }

    #[test]
    fn requirements_are_checked() {
        let plane = Plane::from_fn(64, 32, |x, _| x as u16);
        let picture = Picture { path: "p".into(), luma: plane, source_bits: 16 };
        assert!(picture.clone().require(64, 32).is_ok());
        assert!(matches!(picture.clone().require(65, 32), Err(PictureError::TooSmall { .. })));
        assert!(matches!(picture.require(64, 33), Err(PictureError::TooSmall { .. })));
        let constant = Picture { path: "p".into(), luma: Plane::filled(4, 4, 7), source_bits: 16 };
        assert!(matches!(constant.require(1, 1), Err(PictureError::NoContrast { value: 7, .. })));
    }

    #[test]
    fn the_frame_is_the_centre() {
        let plane = Plane::from_fn(1027, 771, |x, y| (x + 3 * y) as u16);
        let picture = Picture { path: "p".into(), luma: plane, source_bits: 16 };
        let frame = picture.crop(1024, 768);
        assert_eq!((frame.x, frame.y), (1, 1));
        assert_eq!((frame.luma.width(), frame.luma.height()), (1024, 768));
        assert_eq!(frame.luma[(0, 0)], 4);
    }

    #[test]
    fn the_hash_sees_shape_and_codes() {
        let flat = Plane::from_vec(4, 1, vec![1u16, 2, 3, 4]).unwrap();
        let square = Plane::from_vec(2, 2, vec![1u16, 2, 3, 4]).unwrap();
        let other = Plane::from_vec(2, 2, vec![1u16, 2, 3, 5]).unwrap();
        assert_ne!(sha256(&flat), sha256(&square));
        assert_ne!(sha256(&square), sha256(&other));
        // Known answer: sha256sum of the 16 bytes 02000000 02000000 0100 0200 0300 0400.
        assert_eq!(sha256(&square), "debe39aa6005e1722f929935581cc70f81f87ecd0e0f2cc872d195dbe6fab829");
    }
}
