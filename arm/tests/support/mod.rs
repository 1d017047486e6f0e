//! A stream as FPGA and sensors would send it in a flight, from a folder of real frames.

#![allow(dead_code)] // each test uses a part of it

pub mod adversarial;
pub mod scene;

use hoverlock_arm::framing::Decoder;
use hoverlock_arm::line::Line;
use hoverlock_arm::message::{self, Command, Telemetry};
use hoverlock_arm::navigator::{Navigator, Next};
pub use hoverlock_arm::source::Source;
use hoverlock_design::KT27;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_fixed_point::model::threshold::ThresholdController;
use hoverlock_pictures::Picture;
use hoverlock_reference::motion::model::Pair;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use std::io;
use std::path::{Path, PathBuf};

/// Range of the first frame, m: an assumption, as the height of the pictures is unknown.
const RANGE: f64 = 60.0;

/// Field of view, radians.
const FIELD_OF_VIEW: f64 = 0.87;

/// Time between frames, microseconds. The pictures are seconds and up to 280 px apart, more than the gate of a
/// predicted displacement.
const FRAME_US: u64 = 2_000_000;

/// Frames from one reference to the next. Neighbouring frames overlap by at least half, others often by too little.
const REFERENCE: usize = 2;

/// Standard errors for pictures without sensor readings. Roll and pitch are unknown, and a drone tilts by several
/// degrees; range and yaw are from `pseudo_gt.csv`.
const SENSORS: SensorErrors = SensorErrors { tilt: 0.1, heading: 0.05, range: 2.0 };

/// Returns `true` if a stream has rows of pixels.
pub fn has_pixels(source: &Source) -> bool {
    let kind = message::PIXELS.to_le_bytes();
    source.messages.iter().any(|message| message.get(4..8) == Some(&kind[..]))
}

/// Sends a byte stream through the flight program, to its end or to the command to stop. `seen` is called with each
/// line and the inliers of the last estimate.
pub fn fly(mut bytes: &[u8], mut navigator: Navigator, mut seen: impl FnMut(Line, &[Pair])) {
    let (mut decoder, mut lines) = (Decoder::default(), Vec::new());
    let (mut more, mut next) = (true, Next::Continue);
    while more && next != Next::Stop {
        more = decoder.read(&mut bytes).unwrap();
        while next != Next::Stop
            && let Some(raw) = decoder.message()
        {
            next = navigator.take(&raw, &mut |line| lines.push(line.clone())).unwrap();
            lines.drain(..).for_each(|line| seen(line, navigator.inliers()));
        }
    }
    navigator.finish(&mut |line| lines.push(line.clone()));
    lines.into_iter().for_each(|line| seen(line, navigator.inliers()));
}

/// Returns all lines of a byte stream.
pub fn flown(bytes: &[u8], navigator: Navigator) -> Vec<Line> {
    let mut lines = Vec::new();
    fly(bytes, navigator, |line, _| lines.push(line));
    lines
}

/// Creates a stream from a folder of `NN.png`: registers, then telemetry and records of each frame, and the command to
/// capture before every second frame. The records are those of the bit-true model with settled thresholds. Range and
/// yaw follow scale and rotation of neighbouring frames in `pseudo_gt.csv`; roll and pitch, which are unknown, are 0.
///
/// # Errors
/// If a file cannot be read.
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
            source.send_registers(frame.width(), frame.height()).unwrap();
            // As if the camera had viewed this ground for a while.
            model.frame(&frame, controller.thresholds());
            controller.settle(model.maxima());
        }
        if number % REFERENCE == 0 {
            source.send(message::COMMAND, &Command::Capture.encode()).unwrap();
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
        source.send_pixels(telemetry.frame, &frame).unwrap();
        source.send_frame(&telemetry, features, &thresholds).unwrap();
        controller.finish_frame(model.maxima());
    }
    Ok(source)
}

/// Returns rotation (radians) and scale from the previous frame to frame `number`, if they are known.
fn motion(csv: &str, number: usize) -> Option<(f64, f64)> {
    let pair = format!("{},{number},1,", number.checked_sub(1)?);
    let row = csv.lines().find(|line| line.starts_with(&pair))?;
    let mut end = row.rsplit(',');
    let scale: f64 = end.next()?.parse().ok()?;
    let rotation: f64 = end.next()?.parse().ok()?;
    Some((rotation.to_radians(), scale))
}
