//! Frames of a hover as a folder that `hoverlock cosim` reads.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hoverlock_arm::message::Telemetry;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use image::{ImageBuffer, ImageFormat, Luma};
use std::io::Cursor;

use crate::output::write_file;

const HEADER: &str = "time_s,roll_deg,pitch_deg,yaw_deg,range_m,fov_deg,tilt_se_deg,heading_se_deg,range_se_m\n";

/// Frames as they are written; the table comes at the end.
pub struct Saved {
    folder: PathBuf,
    table: String,
}

impl Saved {
    /// Into a folder that exists.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), table: HEADER.into() }
    }

    /// A frame, and its row of the table.
    pub fn frame(&mut self, number: usize, frame: &Plane<u16>, telemetry: &Telemetry) -> Result<()> {
        let path = self.folder.join(format!("{number:05}.png"));
        let picture: ImageBuffer<Luma<u16>, &[u16]> =
            ImageBuffer::from_raw(frame.width() as u32, frame.height() as u32, frame.as_slice())
                .context("a frame has as many samples as its size says")?;
        let mut png = Cursor::new(Vec::new());
        picture.write_to(&mut png, ImageFormat::Png).with_context(|| format!("{}: not encoded", path.display()))?;
        write_file(&path, &png.into_inner())?;
        let Telemetry { time_us, attitude, range, field_of_view, sensors, .. } = telemetry;
        let Attitude { roll, pitch, yaw } = attitude;
        let SensorErrors { tilt, heading, range: error } = sensors;
        let angles = [roll, pitch, yaw].map(|angle| angle.to_degrees().to_string()).join(",");
        let [view, tilt, heading] = [field_of_view, tilt, heading].map(|angle| angle.to_degrees());
        let time = *time_us as f64 / 1e6;
        self.table += &format!("{time},{angles},{range},{view},{tilt},{heading},{error}\n");
        Ok(())
    }

    /// Writes the table.
    pub fn keep(self) -> Result<()> {
        write_file(&self.folder.join("telemetry.csv"), self.table.as_bytes())
    }
}
