//! A folder of frames with the data that belong to it: telemetry, and homographies fitted to the pictures.

pub mod calibration;
mod frame;
pub mod inertial;
mod pseudo_truth;
mod table;
pub mod telemetry;
mod writer;

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use hoverlock_arm::calibration::Calibration;
use hoverlock_arm::message::{InertialSample, Telemetry};
use hoverlock_pictures::folder::{self, FolderError};
use hoverlock_pictures::{Limits, PictureError};
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;

pub use frame::FrameFile;
pub use inertial::InertialError;
pub use pseudo_truth::{PseudoTruth, PseudoTruthError};
pub use telemetry::TelemetryError;
pub use writer::{frame_name, inertial_header, inertial_rows, is_frame, png, telemetry_header, telemetry_row};

use crate::Monitor;
use crate::toml_file::TomlFileError;

/// File name of the telemetry in the folder.
pub const TELEMETRY: &str = "telemetry.csv";

/// File name of the samples of the inertial sensor in the folder.
pub const INERTIAL: &str = "inertial.csv";
/// File name of the camera's calibration in the folder.
pub const CALIBRATION: &str = "calibration.toml";
/// File name of the homographies in the folder.
pub const HOMOGRAPHIES: &str = "pseudo_gt.csv";

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Assumed range, m. Range and field of view only set the length of a metre. A tilt known to 5 degrees at 60 m gives a
/// standard error above the metre at which the flight program refuses; at 20 m the real sequences give estimates.
const ASSUMED_RANGE_M: f64 = 20.0;

/// Assumed field of view, degrees.
const ASSUMED_FIELD_OF_VIEW_DEG: f64 = 50.0;

/// Assumed standard errors.
const ASSUMED_SENSORS: SensorErrors = SensorErrors { tilt: 5.0 * DEGREE, heading: 10.0 * DEGREE, range: 1.0 };

/// Assumed interval between frames, s. It exceeds the age up to which a displacement predicts the next one, so that no
/// frame is searched near the position of the frame before.
const ASSUMED_INTERVAL_S: f64 = 2.0;

/// Specific force down of a vehicle that hovers, m/s^2.
const HOVER_FORCE_M_PER_S2: RangeInclusive<f64> = -15.0..=-5.0;

/// The assumed telemetry in words.
pub const ASSUMED_TELEMETRY: &str = "assumed: roll, pitch and yaw 0, range 20 m, field of view 50 degrees, frames 2 s \
                                     apart; standard errors 5 degrees of tilt, 10 of heading, 1 m of range";

/// The frames of a folder with their data; see [`read`].
pub struct Sequence {
    /// The frames, all of one size: at least two.
    pub frames: Vec<FrameFile>,
    /// Telemetry of each frame.
    pub telemetry: Vec<Telemetry>,
    /// Samples of the inertial sensor, the oldest first; none if the folder has no table of them.
    pub inertial: Vec<InertialSample>,
    /// Calibration of the camera, if the folder has one.
    pub calibration: Option<Calibration>,
    /// The folder has no telemetry.
    pub is_telemetry_assumed: bool,
    /// Position of each frame by the homographies of the folder; that of the first frame is 0.
    pub pseudo_truths: Vec<Option<PseudoTruth>>,
}

/// Why a folder of frames was refused.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// The path is not a folder.
    #[error("{path}: is no folder; name a folder of frames", path = .0.display())]
    NotAFolder(PathBuf),
    /// The folder could not be read or has no picture.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The folder has one picture only.
    #[error("{path}: holds one picture; a sequence has at least two, the first is the reference", path = .0.display())]
    OnePicture(PathBuf),
    /// A picture could not be read.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A picture has another size than those before.
    #[error("{path}: is {width}x{height}, and the frames before are {first_width}x{first_height}")]
    Size {
        /// The picture of another size.
        path: PathBuf,
        /// Columns of this picture.
        width: usize,
        /// Rows of this picture.
        height: usize,
        /// Columns of the pictures before.
        first_width: usize,
        /// Rows of the pictures before.
        first_height: usize,
    },
    /// The telemetry was refused.
    #[error(transparent)]
    Telemetry(#[from] TelemetryError),
    /// The samples of the inertial sensor were refused.
    #[error(transparent)]
    Inertial(#[from] InertialError),
    /// There are samples of the inertial sensor, and no times of the frames.
    #[error(
        "{inertial}: its samples need the times of the frames, and there is no {telemetry}; add it, or move the \
         samples away"
    )]
    InertialAlone {
        /// The table of the samples.
        inertial: PathBuf,
        /// The telemetry that is missing.
        telemetry: PathBuf,
    },
    /// The calibration was refused.
    #[error(transparent)]
    Calibration(#[from] TomlFileError),
    /// The homographies were refused.
    #[error(transparent)]
    PseudoTruth(#[from] PseudoTruthError),
}

/// Reads a folder of pictures in the order of [`folder::pictures_in`], with the optional files [`TELEMETRY`],
/// [`INERTIAL`], [`CALIBRATION`] and [`HOMOGRAPHIES`].
///
/// Pictures larger than the `largest` frame (columns, rows) are cropped to their centre. Field of view, read-out time
/// and times of telemetry and calibration, which are those of the whole picture, are converted to those of the frame.
/// The monitor receives a remark if pictures are turned or cropped, if samples of the inertial sensor do not fit the
/// frames or a hover, and if the homographies belong to no frame. A picture of one value is a frame.
///
/// Each picture is decoded once, so that a damaged one is refused before the first frame is processed.
///
/// # Errors
/// The folder has fewer than two pictures, pictures of different sizes, a picture with fewer than 64 rows or columns,
/// samples of the inertial sensor without telemetry, or a file that cannot be read.
pub fn read(
    folder: &Path,
    limits: &Limits,
    largest: (usize, usize),
    monitor: &dyn Monitor,
) -> Result<Sequence, SequenceError> {
    if !folder.is_dir() {
        return Err(SequenceError::NotAFolder(folder.into()));
    }
    let files = folder::pictures_in(folder)?;
    if files.len() < 2 {
        return Err(SequenceError::OnePicture(folder.into()));
    }
    let [table, samples] = [TELEMETRY, INERTIAL].map(|name| folder.join(name));
    let is_telemetry_assumed = !is_there(&table);
    // The assumed times are those of no clock.
    if is_telemetry_assumed && is_there(&samples) {
        return Err(SequenceError::InertialAlone { inertial: samples, telemetry: table });
    }
    let frames = check_all(files, limits, largest, monitor)?;
    let first = &frames[0];
    let mut telemetry =
        if is_telemetry_assumed { assumed(frames.len()) } else { telemetry::read(&table, frames.len())? };
    let file = folder.join(CALIBRATION);
    let mut calibration = is_there(&file).then(|| calibration::read(&file)).transpose()?;
    // Telemetry and calibration are those of the whole picture; the frame is its centre.
    for readings in &mut telemetry {
        readings.field_of_view = 2.0 * (first.part() * (readings.field_of_view / 2.0).tan()).atan();
    }
    if let Some(calibration) = &mut calibration {
        let [begin, part] = first.readout();
        if !is_telemetry_assumed {
            let begin_us = (1e6 * begin * calibration.readout_s.value).round() as u64;
            telemetry.iter_mut().for_each(|readings| readings.time_us += begin_us);
        }
        calibration.readout_s.value *= part;
        calibration.readout_s.sigma *= part;
    }
    let inertial = if is_there(&samples) { inertial::read(&samples)? } else { Vec::new() };
    for remark in [remark_on_times(&inertial, &telemetry), remark_on_force(&inertial)].into_iter().flatten() {
        monitor.remark(&format!("{}: {remark}", samples.display()));
    }
    let table = folder.join(HOMOGRAPHIES);
    let mut pseudo_truths = vec![None; frames.len()];
    if is_there(&table) {
        pseudo_truths = pseudo_truth::read(&table, first, &telemetry)?;
        if pseudo_truths[1..].iter().all(Option::is_none) {
            monitor.remark(&format!("{}: no homography gives the position of a frame after frame 0", table.display()));
        }
    }
    Ok(Sequence { frames, telemetry, inertial, calibration, is_telemetry_assumed, pseudo_truths })
}

/// Checks the pictures of a sequence, which have one size.
fn check_all(
    files: Vec<PathBuf>,
    limits: &Limits,
    largest: (usize, usize),
    monitor: &dyn Monitor,
) -> Result<Vec<FrameFile>, SequenceError> {
    let _step = monitor.long_step("checking the pictures");
    let mut frames = Vec::<FrameFile>::new();
    let mut others = 0;
    for path in files {
        let (frame, remarks) = FrameFile::check(path, limits, largest)?;
        let frame = match frames.first() {
            Some(first) => frame.require_size_of(first)?,
            None => frame,
        };
        if frames.is_empty() {
            remarks.iter().for_each(|remark| monitor.remark(remark));
        } else {
            others += usize::from(!remarks.is_empty());
        }
        frames.push(frame);
    }
    if others > 0 {
        monitor.remark(&format!("{others} more of these pictures are turned or cropped"));
    }
    Ok(frames)
}

/// Returns `true` if a folder has an entry of this path; a link to nothing is one, which cannot be read.
fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Returns a remark if there are samples of the inertial sensor, and none between the first and the last frame.
fn remark_on_times(inertial: &[InertialSample], telemetry: &[Telemetry]) -> Option<String> {
    let (first, last) = (telemetry.first()?.time_us, telemetry.last()?.time_us);
    let [begin, end] = [inertial.first()?, inertial.last()?].map(|sample| sample.time_us);
    let outside = !inertial.iter().any(|sample| (first..=last).contains(&sample.time_us));
    outside.then(|| {
        let [begin, end, first, last] = [begin, end, first, last].map(|time_us| time_us as f64 / 1e6);
        format!("no sample is between the frames: samples are from {begin} to {end} s, frames from {first} to {last} s")
    })
}

/// Returns a remark if the mean specific force down is not near that of a hover.
fn remark_on_force(inertial: &[InertialSample]) -> Option<String> {
    let sum: f64 = inertial.iter().map(|sample| sample.force[2]).sum();
    let mean = sum / inertial.len() as f64;
    let is_odd = !inertial.is_empty() && !HOVER_FORCE_M_PER_S2.contains(&mean);
    is_odd.then(|| {
        format!("the mean specific force down is {mean:.2} m/s^2, and that of a hover is -9.81; check unit and sign")
    })
}

/// Returns the assumed telemetry of a number of frames.
fn assumed(frames: usize) -> Vec<Telemetry> {
    let of_frame = |frame: usize| Telemetry {
        frame: frame as u32,
        time_us: (1e6 * ASSUMED_INTERVAL_S * frame as f64) as u64,
        attitude: Attitude::default(),
        range: ASSUMED_RANGE_M,
        field_of_view: ASSUMED_FIELD_OF_VIEW_DEG * DEGREE,
        sensors: ASSUMED_SENSORS,
    };
    (0..frames).map(of_frame).collect()
}
