//! Frames and telemetry in the form that [`super::read`] reads.

use std::io::Cursor;

use hoverlock_arm::message::{InertialSample, Telemetry};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _, ImageError};

const HEADER: &str = "time_s,roll_deg,pitch_deg,yaw_deg,range_m,fov_deg,tilt_se_deg,heading_se_deg,range_se_m\n";

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

/// Encodes frames as PNG files and collects their telemetry. It writes no files.
pub struct SequenceWriter {
    table: String,
    inertial: String,
}

impl Default for SequenceWriter {
    fn default() -> Self {
        Self { table: HEADER.into(), inertial: super::inertial::COLUMNS.join(",") + "\n" }
    }
}

impl SequenceWriter {
    /// Adds a row to the table, and returns file name and content of the frame.
    ///
    /// # Errors
    /// The PNG encoder fails.
    pub fn add(
        &mut self,
        number: usize,
        frame: &Plane<u16>,
        telemetry: &Telemetry,
    ) -> Result<(String, Vec<u8>), ImageError> {
        let png = png(frame)?;
        let Telemetry { time_us, attitude, range, field_of_view, sensors, .. } = telemetry;
        let Attitude { roll, pitch, yaw } = attitude;
        let SensorErrors { tilt, heading, range: error } = sensors;
        let angles = [roll, pitch, yaw].map(|angle| angle.to_degrees().to_string()).join(",");
        let [view, tilt, heading] = [field_of_view, tilt, heading].map(|angle| angle.to_degrees());
        let time = *time_us as f64 / 1e6;
        self.table += &format!("{time},{angles},{range},{view},{tilt},{heading},{error}\n");
        Ok((format!("{number:05}.png"), png))
    }

    /// Adds samples of the inertial sensor, later ones than those before.
    pub fn add_inertial(&mut self, samples: &[InertialSample]) {
        for sample in samples {
            let values = sample.rates.iter().chain(&sample.force).map(f64::to_string).collect::<Vec<_>>().join(",");
            self.inertial += &format!("{},{values}\n", sample.time_us as f64 / 1e6);
        }
    }

    /// Returns the samples of the inertial sensor so far as CSV with a header, the content of the file
    /// [`super::INERTIAL`].
    pub fn inertial_table(&self) -> &str {
        &self.inertial
    }

    /// Returns the telemetry of all frames added so far as CSV with a header, the content of the file
    /// [`super::TELEMETRY`].
    pub fn table(&self) -> &str {
        &self.table
    }
}
