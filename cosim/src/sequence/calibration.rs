//! The file of the calibration of camera and IMU.
//!
//! ```toml
//! k1 = { value = -0.021, sigma = 0.001 }
//! focal = { value = 0.0012, sigma = 0.0003 }
//! principal_px = { value = [3.1, -1.4], sigma = 0.4 }
//! ```
//!
//! The keys are those of [`hoverlock_arm::calibration`]. An error that is missing is that of
//! [`Calibration::default`].

use std::path::Path;

use hoverlock_arm::calibration::Calibration;

use crate::toml_file::{CALIBRATION, TomlFileError};

/// Reads a calibration.
///
/// # Errors
/// The file cannot be read, has an unknown key, or a number outside its limits.
pub fn read(path: &Path) -> Result<Calibration, TomlFileError> {
    let calibration: Calibration = CALIBRATION.parse(&CALIBRATION.read(path)?, path)?;
    calibration.checked().map_err(|error| CALIBRATION.invalid(path, error.to_string()))
}

/// Returns the content of the file of a calibration.
///
/// # Errors
/// The writer of TOML fails.
pub fn text(calibration: &Calibration) -> Result<String, toml::ser::Error> {
    toml::to_string(calibration)
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
            ("k1 = 3\n", "line 1: k1: invalid type: integer `3`, expected { value = .., sigma = .. }"),
            ("k1 = { value = 0.1 }\n", "line 1: missing field `sigma`"),
            ("focal = { value = nan, sigma = 0.1 }\n", "focal.value is NaN, and must be -0.1 to 0.1"),
            ("readout_s = { value = 0.01, sigma = -1.0 }\n", "readout_s.sigma is -1, and must be 0 to 0.1"),
            ("principal_px = { value = [1.0], sigma = 1.0 }\n", "line 1: principal_px.value: invalid length 1"),
            (
                "principal_px = { value = [1.0, 2.0, 3.0], sigma = 1.0 }\n",
                "line 1: principal_px.value: invalid length 3",
            ),
            ("k1 = [0.1, 0.01]\n", "line 1: k1: invalid type: sequence, expected { value = .., sigma = .. }"),
        ] {
            let refused = read_text(text).unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
        assert!(matches!(read(folder.path()), Err(TomlFileError::NotAFile { .. })));
    }
}
