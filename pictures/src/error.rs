//! Errors of reading a picture file.

use std::io;
use std::path::PathBuf;

/// An error of reading a picture file. Each message states the file, the reason and a remedy.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {reason}; check the name and its permissions", .path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The path is a folder.
    #[error("{}: is a folder, not a picture; name one picture file", .path.display())]
    IsFolder {
        /// Path of the folder.
        path: PathBuf,
    },
    /// The path is a device, a FIFO or a socket.
    #[error("{}: is not a regular file; name a picture file, or - to read one from standard input", .path.display())]
    NotRegularFile {
        /// Path of the device, FIFO or socket.
        path: PathBuf,
    },
    /// A picture is expected from standard input, which is a terminal.
    #[error("-: standard input is a terminal; send a picture into it, or name a picture file")]
    StdinIsTerminal,
    /// The file has no bytes.
    #[error("{}: is empty (0 bytes); fetch or save the picture again", .path.display())]
    EmptyFile {
        /// Path of the file.
        path: PathBuf,
    },
    /// The file has more bytes than the limit.
    #[error(
        "{}: has {} bytes, and the limit is {limit}; give a smaller picture, or raise the limit (--max-megapixels)",
        .path.display(),
        .bytes.map_or_else(|| format!("more than {limit}"), |bytes| bytes.to_string())
    )]
    FileTooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Bytes of the file; `None` for standard input, which was not read to its end.
        bytes: Option<u64>,
        /// Largest number of bytes.
        limit: u64,
    },
    /// The picture has more pixels than the limit.
    #[error(
        "{}: is {width} x {height}, {:.1} megapixels, and the limit is {limit_megapixels}; give a smaller \
         picture, or raise the limit (--max-megapixels)",
        .path.display(),
        *.width as f64 * *.height as f64 / 1e6
    )]
    TooManyPixels {
        /// Path of the file.
        path: PathBuf,
        /// Columns of the picture.
        width: usize,
        /// Rows of the picture.
        height: usize,
        /// Largest number of megapixels.
        limit_megapixels: u64,
    },
    /// The content is not of a known picture format; the file name is ignored.
    #[error("{}: is not a picture of a known format; give PNG, JPEG, TIFF, BMP, PNM or WebP", .path.display())]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
    },
    /// The content is of a picture format, or has samples, that this crate does not decode.
    #[error("{}: is {what}; convert it to {}", .path.display(), .convert_to)]
    UnsupportedFormat {
        /// Path of the file.
        path: PathBuf,
        /// Format or samples of the file, with an article.
        what: String,
        /// Formats or samples that are supported.
        convert_to: &'static str,
    },
    /// The content is damaged or truncated.
    #[error("{}: cannot be decoded: {reason}; fetch or save the picture again", .path.display())]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// Message of the decoder.
        reason: String,
    },
    /// The picture is smaller than required.
    #[error(
        "{}: is {width} x {height}, and this needs at least {min_width} x {min_height}; give a larger picture",
        .path.display()
    )]
    TooSmall {
        /// Path of the file.
        path: PathBuf,
        /// Columns of the picture.
        width: usize,
        /// Rows of the picture.
        height: usize,
        /// Smallest number of columns.
        min_width: usize,
        /// Smallest number of rows.
        min_height: usize,
    },
    /// All pixels are equal, so that no feature exists.
    #[error("{}: every pixel is {value}, so there is nothing to match; give a picture of the ground", .path.display())]
    NoContrast {
        /// Path of the file.
        path: PathBuf,
        /// Value of all pixels, DN.
        value: u16,
    },
}
