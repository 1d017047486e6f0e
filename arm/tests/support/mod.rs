//! A stream as the FPGA and the sensors of a flight would make it, out of a folder of real frames.

#![allow(dead_code)] // each test uses a part of it

pub mod scene;

use hoverlock_arm::message::{self, Command, Telemetry};
pub use hoverlock_arm::source::Source;
use hoverlock_design::KT27;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_fixed_point::model::threshold::{ThresholdController, count_per_scale};
use hoverlock_pictures::Picture;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use std::io;
use std::path::{Path, PathBuf};

/// Range of the first frame, m: the pictures do not tell their height.
const RANGE: f64 = 60.0;

/// Field of view, radians.
const FIELD_OF_VIEW: f64 = 0.87;

/// Time between frames, microseconds. The pictures are seconds apart: up to 280 px, beyond the gate of a fresh
/// displacement.
const FRAME_US: u64 = 2_000_000;

/// Frames from one reference to the next. Neighbours share half of their ground and more, frames further apart often
/// too little.
const REFERENCE: usize = 2;

/// The pictures come without the readings of an IMU and a laser. Roll and pitch are not known at all: a drone leans by
/// some degrees. Range and yaw are followed by `pseudo_gt.csv`.
const SENSORS: SensorErrors = SensorErrors { tilt: 0.1, heading: 0.05, range: 2.0 };

/// The stream of a folder `NN.png`: registers, then telemetry and records of each frame, out of the bit-true model with
/// thresholds that have settled, and the command to capture before every second frame. Range and yaw follow scale and
/// rotation of neighbours in `pseudo_gt.csv`; roll and pitch are 0, as the pictures do not tell them.
///
/// # Errors
/// Where a file cannot be read.
pub fn sequence(folder: &Path) -> io::Result<Source> {
    let text = std::fs::read_to_string(folder.join("pseudo_gt.csv"))?;
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    files.retain(|path| path.extension().is_some_and(|extension| extension == "png"));
    files.sort();
    let mut model = SimdBitTrue::new(&KT27).map_err(io::Error::other)?;
    let mut controller = ThresholdController::new(&KT27);
    let mut source = Source::default();
    let (mut yaw, mut range) = (0.0, RANGE);
    for (number, path) in files.iter().enumerate() {
        let frame = Picture::open(path).map_err(io::Error::other)?.crop(KT27.width as usize, KT27.height as usize).luma;
        if number == 0 {
            source.send_registers(frame.width(), frame.height());
            // A camera that has looked at this ground for a while.
            model.frame(&frame, controller.thresholds());
            controller.settle(|thresholds| count_per_scale(&model.planes().features(thresholds)));
        }
        if number % REFERENCE == 0 {
            source.send(message::COMMAND, &Command::Capture.encode());
        }
        if let Some((rotation, scale)) = motion(&text, number) {
            yaw -= rotation;
            range /= scale;
        }
        let telemetry = Telemetry {
            frame: number as u32,
            time_us: FRAME_US * number as u64,
            attitude: Attitude { yaw, ..Attitude::default() },
            range,
            field_of_view: FIELD_OF_VIEW,
            sensors: SENSORS,
        };
        let features = model.frame(&frame, controller.thresholds());
        let thresholds = controller.thresholds().to_vec();
        source.send_frame(&telemetry, features, &thresholds);
        controller.finish_frame(&count_per_scale(features));
    }
    Ok(source)
}

/// Rotation (radians) and scale from the frame before to frame `number`, where they are known.
fn motion(csv: &str, number: usize) -> Option<(f64, f64)> {
    let pair = format!("{},{number},1,", number.checked_sub(1)?);
    let row = csv.lines().find(|line| line.starts_with(&pair))?;
    let mut end = row.rsplit(',');
    let scale: f64 = end.next()?.parse().ok()?;
    let rotation: f64 = end.next()?.parse().ok()?;
    Some((rotation.to_radians(), scale))
}
