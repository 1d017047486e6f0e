//! What every decoder produces: the luma of a picture, or an error that does not know its file yet.

use std::io;
use std::path::Path;

use crate::PictureError;

/// A [`PictureError`] without the path of the file.
#[derive(Debug)]
pub(super) enum DecodeError {
    UnknownFormat,
    UnsupportedFormat { what: String, convert_to: &'static str },
    Damaged(String),
    Read(io::Error),
}

impl DecodeError {
    /// Returns an error for a damaged or truncated file.
    pub(super) fn damaged(reason: impl Into<String>) -> Self {
        Self::Damaged(reason.into())
    }

    /// Returns an error for a known format or kind of samples that is not decoded.
    pub(super) fn unsupported(what: impl Into<String>, convert_to: &'static str) -> Self {
        Self::UnsupportedFormat { what: what.into(), convert_to }
    }

    /// Adds the path of the file.
    pub(super) fn with_path(self, path: &Path) -> PictureError {
        let path = path.to_path_buf();
        match self {
            Self::UnknownFormat => PictureError::UnknownFormat { path },
            Self::UnsupportedFormat { what, convert_to } => PictureError::UnsupportedFormat { path, what, convert_to },
            Self::Damaged(reason) => PictureError::Damaged { path, reason },
            Self::Read(reason) => PictureError::Read { path, reason },
        }
    }
}

impl From<io::Error> for DecodeError {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { truncated() } else { Self::Read(error) }
    }
}

/// Returns the error for a file that ends too early.
pub(super) fn truncated() -> DecodeError {
    DecodeError::damaged("it is cut short")
}

/// The luma of a picture in raster order, before it is turned upright.
pub(super) struct Decoded {
    pub(super) luma: Vec<u16>,
    /// Bits of the samples of the file, 8 or 16.
    pub(super) source_bits: u32,
}

/// The interleaved samples of whole pixels, as a decoder returns them.
pub(super) enum Samples<'a> {
    U8(&'a [u8]),
    U16(&'a [u16]),
    /// 16-bit samples as bytes in the order of this machine.
    NativeEndian(&'a [u8]),
    /// 16-bit samples as bytes, most significant first.
    BigEndian(&'a [u8]),
}

impl Decoded {
    /// Allocates memory for `pixels` pixels.
    pub(super) fn with_capacity(pixels: usize, source_bits: u32) -> Self {
        Self { luma: Vec::with_capacity(pixels), source_bits }
    }

    /// Appends the luma of pixels of 1 to 4 channels: grey, grey and alpha, RGB, RGB and alpha.
    pub(super) fn push(&mut self, samples: Samples, channels: usize) {
        let of = |pixel: &[u16]| match *pixel {
            [r, g, b, ..] => ((299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) + 500) / 1000) as u16,
            [grey, ..] => grey,
            [] => 0,
        };
        let fill = if self.source_bits == 8 { 257 } else { 1 };
        let mut pixel = [0u16; 4];
        let pixel = &mut pixel[..channels.min(4)];
        match samples {
            Samples::U8(samples) => self.luma.extend(samples.chunks_exact(channels).map(|from| {
                pixel.iter_mut().zip(from).for_each(|(to, from)| *to = u16::from(*from));
                fill * of(pixel)
            })),
            Samples::U16(samples) => self.luma.extend(samples.chunks_exact(channels).map(|from| fill * of(from))),
            Samples::NativeEndian(bytes) => self.luma.extend(bytes.chunks_exact(2 * channels).map(|from| {
                pixel.iter_mut().zip(from.as_chunks().0).for_each(|(to, from)| *to = u16::from_ne_bytes(*from));
                of(pixel)
            })),
            Samples::BigEndian(bytes) => self.luma.extend(bytes.chunks_exact(2 * channels).map(|from| {
                pixel.iter_mut().zip(from.as_chunks().0).for_each(|(to, from)| *to = u16::from_be_bytes(*from));
                of(pixel)
            })),
        }
    }
}
