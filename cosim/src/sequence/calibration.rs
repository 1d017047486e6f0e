//! The file of the camera's calibration.
//!
//! ```toml
//! k1 = { value = -0.021, sigma = 0.001 }
//! focal = { value = 0.0012, sigma = 0.0003 }
//! principal_px = { value = [3.1, -1.4], sigma = 0.4 }
//! ```
//!
//! The keys are those of [`hoverlock_arm::calibration`]. An error that has none is that of a camera which nobody has
//! calibrated.

use std::path::{Path, PathBuf};

use hoverlock_arm::calibration::Calibration;

/// Largest number of bytes of a calibration.
const MAX_BYTES: u64 = 1 << 16;

/// Why a calibration was refused.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file could not be read.
    #[error("calibration {path}: cannot be read: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The path is a folder, a device, a FIFO, or a file of more than 64 KiB.
    #[error("calibration {path}: not a regular file of at most 64 KiB", path = .0.display())]
    NotAFile(PathBuf),
    /// The file is not a valid calibration.
    #[error("calibration {path}: {why}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong, on one line.
        why: String,
    },
}

/// Reads a calibration.
///
/// # Errors
/// The file cannot be read, has an unknown key, or a number outside its limits.
pub fn read(path: &Path) -> Result<Calibration, CalibrationError> {
    let read = |source| CalibrationError::Read { path: path.into(), source };
    let about = std::fs::metadata(path).map_err(read)?;
    if !about.is_file() || about.len() > MAX_BYTES {
        return Err(CalibrationError::NotAFile(path.into()));
    }
    let text = std::fs::read_to_string(path).map_err(read)?;
    let invalid = |why: String| CalibrationError::Invalid { path: path.into(), why };
    let calibration: Calibration = toml::from_str(&text).map_err(|error| invalid(fault(&text, &error)))?;
    calibration.checked().map_err(|error| invalid(error.to_string()))
}

/// Returns the content of the file of a calibration.
///
/// # Errors
/// The writer of TOML fails.
pub fn text(calibration: &Calibration) -> Result<String, toml::ser::Error> {
    toml::to_string(calibration)
}

/// Returns what is wrong with a text in TOML, with its line.
pub(crate) fn fault(text: &str, error: &toml::de::Error) -> String {
    let start = error.span().map_or(0, |span| span.start);
    let line = text.as_bytes()[..start.min(text.len())].iter().filter(|&&byte| byte == b'\n').count() + 1;
    format!("line {line}: {}", error.message().split_whitespace().collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_calibration_is_refused_by_its_line_or_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("calibration.toml");
        let read_text = |text: &str| {
            std::fs::write(&file, text).unwrap();
            read(&file).map_err(|error| error.to_string())
        };
        let calibration = read_text("k1 = { value = -0.02, sigma = 0.001 }\n").unwrap();
        assert_eq!((calibration.k1.value, calibration.k1.sigma), (-0.02, 0.001));
        assert_eq!(calibration.focal, Calibration::default().focal);
        assert_eq!(read_text(&text(&calibration).unwrap()), Ok(calibration));
        assert_eq!(read_text(""), Ok(Calibration::default()));
        for (text, why) in [
            ("\nk3 = 1\n", "line 2: unknown field `k3`"),
            ("k1 = 3\n", "line 1: invalid type: integer `3`, expected { value = .., sigma = .. }"),
            ("k1 = { value = 0.1 }\n", "line 1: missing field `sigma`"),
            ("focal = { value = nan, sigma = 0.1 }\n", "focal.value is NaN, and must be -0.1 to 0.1"),
            ("readout_s = { value = 0.01, sigma = -1.0 }\n", "readout_s.sigma is -1, and must be 0 to 0.1"),
            ("principal_px = { value = [1.0], sigma = 1.0 }\n", "line 1: invalid length 1"),
        ] {
            let refused = read_text(text).unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
        assert!(matches!(read(folder.path()), Err(CalibrationError::NotAFile(_))));
    }
}
