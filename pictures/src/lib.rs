//! `I = (299 R + 587 G + 114 B + 500) / 1000`: a picture file becomes one plane of 16-bit luma.
//!
//! Luma (ITU-R BT.601 weights) is taken in the source's own depth, alpha is ignored, and an 8-bit value `v` fills 16
//! bits as `257 v`, so that white stays full scale. The decoded plane, not the file, is what a hash names: the same
//! pixels in another container are the same picture.
//!
//! A picture comes from outside, so it is read in two steps. [`PictureFile::open`] reads the header, and refuses what
//! is no regular file or is larger than the [`Limits`]. [`PictureFile::decode`] then decodes row by row where the
//! format allows it, and refuses a file that is cut short or damaged: the decoders would fill in grey and say nothing.

pub mod conditions;
mod decode;
mod error;
pub mod folder;
mod jpeg;
mod pnm;

use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, IsTerminal as _, Read};
use std::path::{Path, PathBuf};

use image::metadata::Orientation;
use sha2::{Digest, Sha256};

pub use error::PictureError;
use hoverlock_reference::image::plane::Plane;

/// Million pixels a picture may have by default: the features of two such pictures are found within 1 GB.
pub const MEGAPIXELS: u32 = 50;

/// A decoded picture and where it came from.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The file, as given.
    pub path: PathBuf,
    /// 16-bit luma, DN, `0 ..= 65535`, upright.
    pub luma: Plane<u16>,
    /// Bits of the source's samples, 8 or 16.
    pub source_bits: u32,
}

/// What a picture may be at most.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Pixels.
    pub pixels: u64,
    /// Bytes of the file.
    pub bytes: u64,
}

impl Limits {
    /// So many million pixels, and files of at most 16 bytes a pixel (RGBA of 16 bits takes 8), but no less than 64 MB.
    pub fn of_megapixels(megapixels: u32) -> Self {
        let pixels = u64::from(megapixels) * 1_000_000;
        Self { pixels, bytes: (16 * pixels).max(64_000_000) }
    }
}

impl Default for Limits {
    /// [`MEGAPIXELS`].
    fn default() -> Self {
        Self::of_megapixels(MEGAPIXELS)
    }
}

/// A picture file whose header was read: its size is known and within the limits, its pixels are not decoded yet.
pub struct PictureFile {
    path: PathBuf,
    pending: decode::Pending,
}

impl PictureFile {
    /// Opens `path`, or standard input for `-`, and reads the header.
    ///
    /// # Errors
    /// Where it cannot be read, is not a regular file, is not a picture, or exceeds `limits`.
    pub fn open(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, PictureError> {
        let path = path.as_ref().to_path_buf();
        let source = source(&path, limits)?;
        let pending = decode::Pending::new(source, limits).map_err(|refusal| refusal.at(&path))?;
        let (width, height) = pending.stored_size();
        let pixels = width as u64 * height as u64;
        if pixels > limits.pixels {
            return Err(PictureError::Large { path, width, height, limit: limits.pixels / 1_000_000 });
        }
        Ok(Self { path, pending })
    }

    /// The file, as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Columns and rows of the picture, upright.
    pub fn size(&self) -> (usize, usize) {
        let (width, height) = self.pending.stored_size();
        if turns(self.pending.orientation()) { (height, width) } else { (width, height) }
    }

    /// How the file asks to be turned or mirrored; nothing where it is stored upright.
    pub fn orientation(&self) -> Option<&'static str> {
        match self.pending.orientation() {
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

    /// Hands the file on where the picture has at least `width` x `height` pixels.
    ///
    /// # Errors
    /// Where it is smaller.
    pub fn require(self, width: usize, height: usize) -> Result<Self, PictureError> {
        enough(&self.path, self.size(), (width, height))?;
        Ok(self)
    }

    /// Decodes the pixels and turns them upright.
    ///
    /// # Errors
    /// Where the file is cut short or damaged, or its samples have no full scale.
    pub fn decode(self) -> Result<Picture, PictureError> {
        let Self { path, pending } = self;
        let (width, height) = pending.stored_size();
        let orientation = pending.orientation();
        let refused = |reason: &str| PictureError::Decode { path: path.clone(), reason: reason.to_owned() };
        let decoded = pending.decode().map_err(|refusal| refusal.at(&path))?;
        let luma = Plane::from_vec(width, height, decoded.luma)
            .map_err(|_| refused("it holds more or fewer pixels than its header says"))?;
        Ok(Picture { luma: upright(luma, orientation), source_bits: decoded.source_bits, path })
    }
}

/// The bytes of a file, seekable.
enum Source {
    File(BufReader<File>),
    Memory(Cursor<Vec<u8>>),
}

/// Opens a regular file, or takes what comes through standard input.
fn source(path: &Path, limits: &Limits) -> Result<Source, PictureError> {
    let read = |reason| PictureError::Read { path: path.to_path_buf(), reason };
    let heavy = |bytes| PictureError::Heavy { path: path.to_path_buf(), bytes, limit: limits.bytes };
    let empty = || PictureError::Empty { path: path.to_path_buf() };
    if path == Path::new("-") {
        let stdin = io::stdin();
        if stdin.is_terminal() {
            return Err(PictureError::Terminal);
        }
        let mut bytes = Vec::new();
        stdin.lock().take(limits.bytes + 1).read_to_end(&mut bytes).map_err(read)?;
        return match bytes.len() as u64 {
            0 => Err(empty()),
            length if length > limits.bytes => Err(heavy(None)),
            _ => Ok(Source::Memory(Cursor::new(bytes))),
        };
    }
    // Asked before it is opened: opening a FIFO waits for its writer.
    let about = fs::metadata(path).map_err(read)?;
    if about.is_dir() {
        return Err(PictureError::Folder { path: path.to_path_buf() });
    }
    if !about.is_file() {
        return Err(PictureError::Irregular { path: path.to_path_buf() });
    }
    match about.len() {
        0 => Err(empty()),
        length if length > limits.bytes => Err(heavy(Some(length))),
        _ => Ok(Source::File(BufReader::new(File::open(path).map_err(read)?))),
    }
}

/// Whether an orientation exchanges columns and rows.
fn turns(orientation: Orientation) -> bool {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    matches!(orientation, Rotate90 | Rotate90FlipH | Rotate270 | Rotate270FlipH)
}

/// The plane as it is to be seen.
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
    let (width, height) = if turns(orientation) { (height, width) } else { (width, height) };
    Plane::from_fn(width, height, |x, y| stored[at(x, y, right, bottom)])
}

/// Whether a picture of `size` has the `least` columns and rows.
fn enough(path: &Path, size: (usize, usize), least: (usize, usize)) -> Result<(), PictureError> {
    if size.0 >= least.0 && size.1 >= least.1 {
        return Ok(());
    }
    let ((width, height), (least_width, least_height)) = (size, least);
    Err(PictureError::Small { path: path.to_path_buf(), width, height, least_width, least_height })
}

/// `x = floor((w - W) / 2)`, `y = floor((h - H) / 2)`, width and height: the centre of a picture of `size` (w, h) that
/// fits a `frame` of (W, H).
pub fn centre(size: (usize, usize), frame: (usize, usize)) -> (usize, usize, usize, usize) {
    let (width, height) = (size.0.min(frame.0), size.1.min(frame.1));
    ((size.0 - width) / 2, (size.1 - height) / 2, width, height)
}

/// The centre of a picture, cut to the size of a frame.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The cut plane.
    pub luma: Plane<u16>,
    /// Column of the picture at which the frame begins, 0 if the picture is no wider than the frame.
    pub x: usize,
    /// Row of the picture at which the frame begins, 0 if the picture is no taller than the frame.
    pub y: usize,
}

impl Picture {
    /// Reads and decodes `path` within the default [`Limits`].
    ///
    /// # Errors
    /// Those of [`PictureFile::open`] and [`PictureFile::decode`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, PictureError> {
        PictureFile::open(path, &Limits::default())?.decode()
    }

    /// Hands the picture on where it has at least `width` x `height` pixels and at least two different values.
    ///
    /// # Errors
    /// Where it is smaller, or constant.
    pub fn require(self, width: usize, height: usize) -> Result<Self, PictureError> {
        enough(&self.path, (self.luma.width(), self.luma.height()), (width, height))?;
        let value = self.luma[(0, 0)];
        if self.luma.as_slice().iter().all(|&code| code == value) {
            return Err(PictureError::Constant { path: self.path, value });
        }
        Ok(self)
    }

    /// The centre of the picture that fits a frame of `width` x `height`.
    pub fn crop(&self, width: usize, height: usize) -> Frame {
        let (x, y, width, height) = centre((self.luma.width(), self.luma.height()), (width, height));
        let luma = Plane::from_fn(width, height, |column, row| self.luma[(x + column, y + row)]);
        Frame { luma, x, y }
    }

    /// SHA-256 of the decoded plane: width and height as 32-bit, then the samples in raster order as 16-bit,
    /// little-endian.
    pub fn sha256(&self) -> String {
        sha256(&self.luma)
    }
}

/// SHA-256 of a plane of 16-bit samples, in hexadecimal: width and height as 32-bit, then the samples in raster order
/// as 16-bit, all little-endian.
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

/// The folder of real nadir pictures: `HOVERLOCK_DATA`, or `shared/data` beside the project. They are too large, and
/// some of them of too particular a licence, to be part of it; tests that need them say so on stderr and skip.
pub fn data_dir() -> Option<PathBuf> {
    let named = std::env::var_os("HOVERLOCK_DATA").map(PathBuf::from);
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    Some(named.unwrap_or_else(beside)).filter(|folder| folder.is_dir())
}

/// The folder into which `make demo` puts the aerial photographs of Debian's `opencv-doc`, where it exists.
pub fn newcomer_dir() -> Option<PathBuf> {
    Some(hoverlock_cache::folder().ok()?.join("pictures")).filter(|folder| folder.is_dir())
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageBuffer, Luma, Rgb, Rgba};

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
        assert!(matches!(Picture::open(at("floats.tiff")), Err(PictureError::Convert { .. })));
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
        let frame = picture.crop(1024, 768);
        assert_eq!((frame.x, frame.y), (1, 1));
        assert_eq!((frame.luma.width(), frame.luma.height()), (1024, 768));
        assert_eq!(frame.luma[(0, 0)], 4);
    }

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
