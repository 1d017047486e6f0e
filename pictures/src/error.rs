//! Why a file is not a usable picture.

use std::io;
use std::path::PathBuf;

/// Why a file is not a usable picture. Each message names the file, the reason and what to do.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {reason}; check the name and its permissions", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The path is a folder.
    #[error("{}: is a folder, not a picture; name one picture file", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// The path is a device, a FIFO or a socket.
    #[error("{}: is not a regular file; name a picture file, or - to read one from standard input", .path.display())]
    Irregular {
        /// The device, FIFO or socket.
        path: PathBuf,
    },
    /// A picture is expected from standard input, which is a terminal.
    #[error("-: standard input is a terminal; send a picture into it, or name a picture file")]
    Terminal,
    /// The file has no bytes.
    #[error("{}: is empty (0 bytes); fetch or save the picture again", .path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file has more bytes than any picture within the limit.
    #[error(
        "{}: has {} bytes, and the limit is {limit}; give a smaller picture, or raise the limit (--max-megapixels)",
        .path.display(),
        .bytes.map_or_else(|| format!("more than {limit}"), |bytes| bytes.to_string())
    )]
    Heavy {
        /// The file.
        path: PathBuf,
        /// Its bytes, where they are known.
        bytes: Option<u64>,
        /// Bytes allowed.
        limit: u64,
    },
    /// The picture has more pixels than the limit.
    #[error(
        "{}: is {width} x {height}, {:.1} megapixels, and the limit is {limit}; give a smaller picture, or raise the \
         limit (--max-megapixels)",
        .path.display(),
        *.width as f64 * *.height as f64 / 1e6
    )]
    Large {
        /// The file.
        path: PathBuf,
        /// Its columns.
        width: usize,
        /// Its rows.
        height: usize,
        /// Megapixels allowed.
        limit: u64,
    },
    /// The content is of no known picture format, whatever the name says.
    #[error("{}: is not a picture of a known format; give PNG, JPEG, TIFF, BMP, PNM or WebP", .path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The content is a picture that is not decoded here.
    #[error("{}: is {what}; convert it to {}", .path.display(), .to)]
    Convert {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: String,
        /// To what it may be converted.
        to: &'static str,
    },
    /// The content is damaged or cut short.
    #[error("{}: cannot be decoded: {reason}; fetch or save the picture again", .path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// The picture is smaller than the work needs.
    #[error(
        "{}: is {width} x {height}, and this needs at least {least_width} x {least_height}; give a larger picture",
        .path.display()
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
    #[error("{}: every pixel is {value}, so there is nothing to match; give a picture of the ground", .path.display())]
    Constant {
        /// The file.
        path: PathBuf,
        /// The one value, DN.
        value: u16,
    },
}
