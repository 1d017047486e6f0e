//! `I = (299 R + 587 G + 114 B + 500) / 1000`: a picture file becomes one plane of 16-bit camera words.
//!
//! Luma (ITU-R BT.601 weights) is taken in the source's own depth, alpha is ignored, and an 8-bit value `v` fills 16 bits as
//! `257 v`, so that white stays full scale. The decoded plane, not the file, is what a hash names: the same pixels in
//! another container are the same picture.

use std::fs;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageFormat, ImageReader};
use sha2::{Digest, Sha256};

use crate::image::plane::Plane;

/// Widest frame of the design point; a wider picture is cropped at its centre where fixed point or hardware runs.
pub const FRAME_WIDTH: usize = 1024;
/// Tallest frame of the design point.
pub const FRAME_HEIGHT: usize = 768;

/// Why a file is not a usable picture. Each message names the file, the reason and what to do.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file cannot be opened or read.
    #[error("{path}: cannot be read: {reason}; check the name and its permissions")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The path is a folder.
    #[error("{path}: is a folder, not a picture; name one picture file")]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// The file has no bytes.
    #[error("{path}: is empty (0 bytes); fetch or save the picture again")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The content is of no known picture format, whatever the name says.
    #[error("{path}: is not a picture of a known format; give PNG, JPEG, TIFF, BMP, PNM or WebP")]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The content is damaged, cut short, or too large to decode.
    #[error("{path}: cannot be decoded: {reason}; fetch or save the picture again")]
    Decode {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// Samples are floating point: there is no full scale to map to the camera word.
    #[error("{path}: holds floating-point samples, which have no full scale; convert it to 8 or 16 bits")]
    Depth {
        /// The file.
        path: PathBuf,
    },
    /// The picture is smaller than the work needs.
    #[error(
        "{path}: is {width} x {height}, and this needs at least {least_width} x {least_height}; give a larger picture"
    )]
    Small {
        /// The file.
        path: PathBuf,
        /// Its columns.
        width: usize,
        /// Its rows.
        height: usize,
        /// Columns needed.
        least_width: usize,
        /// Rows needed.
        least_height: usize,
    },
    /// All pixels are equal: no feature can exist.
    #[error("{path}: every pixel is {value}, so there is nothing to match; give a picture of the ground")]
    Constant {
        /// The file.
        path: PathBuf,
        /// The one code.
        value: u16,
    },
}

/// A decoded picture and where it came from.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The file, as given.
    pub path: PathBuf,
    /// 16-bit luma codes, `0 ..= 65535`.
    pub luma: Plane<u16>,
    /// Bits of the source's samples, 8 or 16.
    pub source_bits: u32,
}

/// A picture cut to the frame of the design point.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The cut plane, at most [`FRAME_WIDTH`] x [`FRAME_HEIGHT`].
    pub luma: Plane<u16>,
    /// Column of the picture at which the frame begins: `floor((w - 1024) / 2)`, 0 where nothing was cut.
    pub x: usize,
    /// Row of the picture at which the frame begins.
    pub y: usize,
}

impl Picture {
    /// Reads and decodes `path`.
    ///
    /// # Errors
    /// Where it cannot be read, is no picture, is damaged, or holds floating-point samples.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, PictureError> {
        let path = path.as_ref().to_path_buf();
        let read = |reason| PictureError::Read { path: path.clone(), reason };
        if fs::metadata(&path).map_err(read)?.is_dir() {
            return Err(PictureError::Folder { path });
        }
        let mut bytes = Vec::new();
        fs::File::open(&path).and_then(|mut file| file.read_to_end(&mut bytes)).map_err(read)?;
        if bytes.is_empty() {
            return Err(PictureError::Empty { path });
        }
        let ends = jpeg_ends(&bytes);
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(read)?;
        match reader.format() {
            None => return Err(PictureError::Format { path }),
            // The decoder fills what a JPEG lacks with grey and says nothing.
            Some(ImageFormat::Jpeg) if !ends => {
                return Err(PictureError::Decode { path, reason: "the JPEG is cut short".into() });
            }
            Some(_) => {}
        }
        let decoded = reader
            .decode()
            .map_err(|error| PictureError::Decode { path: path.clone(), reason: one_line(&error.to_string()) })?;
        let Some((luma, source_bits)) = luma16(&decoded) else { return Err(PictureError::Depth { path }) };
        Ok(Self { path, luma, source_bits })
    }

    /// Hands the picture on where it has at least `width` x `height` pixels and at least two different codes.
    ///
    /// # Errors
    /// Where it is smaller, or constant.
    pub fn require(self, width: usize, height: usize) -> Result<Self, PictureError> {
        if self.luma.width() < width || self.luma.height() < height {
            return Err(PictureError::Small {
                path: self.path,
                width: self.luma.width(),
                height: self.luma.height(),
                least_width: width,
                least_height: height,
            });
        }
        let value = self.luma[(0, 0)];
        if self.luma.as_slice().iter().all(|&code| code == value) {
            return Err(PictureError::Constant { path: self.path, value });
        }
        Ok(self)
    }

    /// The centre of the picture that fits the frame of the design point.
    pub fn frame(&self) -> Frame {
        let width = self.luma.width().min(FRAME_WIDTH);
        let height = self.luma.height().min(FRAME_HEIGHT);
        let (x, y) = ((self.luma.width() - width) / 2, (self.luma.height() - height) / 2);
        let luma = Plane::from_fn(width, height, |column, row| self.luma[(x + column, y + row)]);
        Frame { luma, x, y }
    }

    /// SHA-256 of the decoded plane: width and height as 32-bit, then the codes in raster order as 16-bit, little-endian.
    pub fn sha256(&self) -> String {
        sha256(&self.luma)
    }
}

impl Frame {
    /// Whether `picture` was larger than this frame.
    pub fn is_cropped_from(&self, picture: &Picture) -> bool {
        (self.luma.width(), self.luma.height()) != (picture.luma.width(), picture.luma.height())
    }
}

/// SHA-256 of a plane of camera words, in hexadecimal: width and height as 32-bit, then the codes in raster order as
/// 16-bit, all little-endian.
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

/// The folder of real nadir pictures: `HOVERLOCK_DATA`, or `shared/data` beside the project. They are too large, and some
/// of them of too particular a licence, to be part of it; tests that need them say so on stderr and pass over.
pub fn data_dir() -> Option<PathBuf> {
    let named = std::env::var_os("HOVERLOCK_DATA").map(PathBuf::from);
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    Some(named.unwrap_or_else(beside)).filter(|folder| folder.is_dir())
}

/// The folder into which `make demo` puts the aerial photographs of Debian's `opencv-doc`, where it exists.
pub fn newcomer_dir() -> Option<PathBuf> {
    let cache = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let home = || Some(PathBuf::from(std::env::var_os("HOME")?).join(".cache"));
    Some(cache.or_else(home)?.join("hoverlock/pictures")).filter(|folder| folder.is_dir())
}

/// The luma plane and the depth of the source, or nothing for floating-point samples.
fn luma16(decoded: &DynamicImage) -> Option<(Plane<u16>, u32)> {
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let plane = |samples| Plane::from_vec(width, height, samples).ok();
    let eight = |value: u32| (257 * value) as u16;
    let of = |r: u32, g: u32, b: u32| (299 * r + 587 * g + 114 * b + 500) / 1000;
    match decoded {
        DynamicImage::ImageLuma8(image) => Some((plane(image.pixels().map(|p| eight(p.0[0].into())).collect())?, 8)),
        DynamicImage::ImageLumaA8(image) => Some((plane(image.pixels().map(|p| eight(p.0[0].into())).collect())?, 8)),
        DynamicImage::ImageLuma16(image) => Some((plane(image.pixels().map(|p| p.0[0]).collect())?, 16)),
        DynamicImage::ImageLumaA16(image) => Some((plane(image.pixels().map(|p| p.0[0]).collect())?, 16)),
        DynamicImage::ImageRgb8(image) => {
            let luma = |p: &image::Rgb<u8>| eight(of(p.0[0].into(), p.0[1].into(), p.0[2].into()));
            Some((plane(image.pixels().map(luma).collect())?, 8))
        }
        DynamicImage::ImageRgba8(image) => {
            let luma = |p: &image::Rgba<u8>| eight(of(p.0[0].into(), p.0[1].into(), p.0[2].into()));
            Some((plane(image.pixels().map(luma).collect())?, 8))
        }
        DynamicImage::ImageRgb16(image) => {
            let luma = |p: &image::Rgb<u16>| of(p.0[0].into(), p.0[1].into(), p.0[2].into()) as u16;
            Some((plane(image.pixels().map(luma).collect())?, 16))
        }
        DynamicImage::ImageRgba16(image) => {
            let luma = |p: &image::Rgba<u16>| of(p.0[0].into(), p.0[1].into(), p.0[2].into()) as u16;
            Some((plane(image.pixels().map(luma).collect())?, 16))
        }
        _ => None,
    }
}

/// A decoder's message on one line, so that a diagnostic stays one line.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Whether an end of image (FF D9) follows the last start of a scan (FF DA); in a scan's data every FF is followed by 00 or a restart.
fn jpeg_ends(bytes: &[u8]) -> bool {
    let last = |marker: [u8; 2]| bytes.windows(2).rposition(|pair| pair == marker);
    matches!((last([0xff, 0xda]), last([0xff, 0xd9])), (Some(scan), Some(end)) if scan < end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, Rgb, Rgba};

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
    fn bad_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("text.png"), "not a picture").unwrap();
        fs::write(at("empty.png"), "").unwrap();
        let image = DynamicImage::ImageLuma8(ImageBuffer::from_fn(64, 64, |x, y| Luma([(x * y) as u8])));
        image.save(at("whole.png")).unwrap();
        let whole = fs::read(at("whole.png")).unwrap();
        fs::write(at("short.png"), &whole[..whole.len() / 2]).unwrap();
        assert!(matches!(Picture::open(at("none.png")), Err(PictureError::Read { .. })));
        assert!(matches!(Picture::open(folder.path()), Err(PictureError::Folder { .. })));
        assert!(matches!(Picture::open(at("text.png")), Err(PictureError::Format { .. })));
        assert!(matches!(Picture::open(at("empty.png")), Err(PictureError::Empty { .. })));
        assert!(matches!(Picture::open(at("short.png")), Err(PictureError::Decode { .. })));
        let floats = DynamicImage::ImageRgb32F(ImageBuffer::from_pixel(2, 2, Rgb([f32::NAN, 0.0, 1.0])));
        floats.save(at("floats.tiff")).unwrap();
        assert!(matches!(Picture::open(at("floats.tiff")), Err(PictureError::Depth { .. })));
    }

    #[test]
    fn requirements_are_checked() {
        let plane = Plane::from_fn(64, 32, |x, _| x as u16);
        let picture = Picture { path: "p".into(), luma: plane, source_bits: 16 };
        assert!(picture.clone().require(64, 32).is_ok());
        assert!(matches!(picture.clone().require(65, 32), Err(PictureError::Small { .. })));
        assert!(matches!(picture.require(64, 33), Err(PictureError::Small { .. })));
        let constant = Picture { path: "p".into(), luma: Plane::filled(4, 4, 7), source_bits: 16 };
        assert!(matches!(constant.require(1, 1), Err(PictureError::Constant { value: 7, .. })));
    }

    #[test]
    fn the_frame_is_the_centre() {
        let plane = Plane::from_fn(1027, 771, |x, y| (x + 3 * y) as u16);
        let picture = Picture { path: "p".into(), luma: plane, source_bits: 16 };
        let frame = picture.frame();
        assert_eq!((frame.x, frame.y), (1, 1));
        assert_eq!((frame.luma.width(), frame.luma.height()), (1024, 768));
        assert_eq!(frame.luma[(0, 0)], 4);
        assert!(frame.is_cropped_from(&picture));
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
