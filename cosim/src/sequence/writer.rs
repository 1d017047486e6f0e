//! Frames and tables in the form that [`super::read`] reads.

use std::io::Cursor;

use hoverlock_arm::message::{InertialSample, Telemetry};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _, ImageError};

use super::{inertial, telemetry};

/// Returns the file name of a frame.
pub fn frame_name(number: usize) -> String {
    format!("{number:05}.png")
}

/// Returns `true` if a file name is one that [`frame_name`] gives to a frame.
pub fn is_frame(name: &str) -> bool {
    name.strip_suffix(".png")
        .is_some_and(|number| number.len() >= 5 && number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Encodes a frame as a PNG file of 16-bit samples.
///
/// # Errors
/// The PNG encoder fails.
pub fn png(frame: &Plane<u16>) -> Result<Vec<u8>, ImageError> {
    let mut png = Cursor::new(Vec::new());
    // The encoder takes 16-bit samples in native byte order.
    let bytes: Vec<u8> = frame.as_slice().iter().flat_map(|sample| sample.to_ne_bytes()).collect();
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    PngEncoder::new(&mut png).write_image(&bytes, width, height, ExtendedColorType::L16)?;
    Ok(png.into_inner())
}

/// Returns the header of the file [`super::TELEMETRY`], a line.
pub fn telemetry_header() -> String {
    telemetry::COLUMNS.join(",") + "\n"
}

/// Returns the row of a frame in the file [`super::TELEMETRY`], a line.
pub fn telemetry_row(telemetry: &Telemetry) -> String {
    let Telemetry { time_us, attitude, range, field_of_view, sensors, .. } = telemetry;
    let Attitude { roll, pitch, yaw } = attitude;
    let SensorErrors { tilt, heading, range: error } = sensors;
    let angles = [roll, pitch, yaw].map(|angle| angle.to_degrees().to_string()).join(",");
    let [view, tilt, heading] = [field_of_view, tilt, heading].map(|angle| angle.to_degrees());
    let time = *time_us as f64 / 1e6;
    format!("{time},{angles},{range},{view},{tilt},{heading},{error}\n")
}

/// Returns the header of the file [`super::INERTIAL`], a line.
pub fn inertial_header() -> String {
    inertial::COLUMNS.join(",") + "\n"
}

/// Returns the rows of samples in the file [`super::INERTIAL`], a line each.
pub fn inertial_rows(samples: &[InertialSample]) -> String {
    let row = |sample: &InertialSample| {
        let values = sample.rates.iter().chain(&sample.force).map(f64::to_string).collect::<Vec<_>>().join(",");
        format!("{},{values}\n", sample.time_us as f64 / 1e6)
    };
    samples.iter().map(row).collect()
}
