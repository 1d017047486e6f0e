//! The result of a frame as a line of JSON.
//!
//! `status` is `estimate`; `late` if the work limit ended the search and the estimate is the best so far; `reference`
//! if the frame was captured as the reference; otherwise `none` with a `reason`. Numbers have as many digits as they
//! need to be read back to the same bits, and are formatted by the same code on every machine.

use crate::message::{MessageError, Trailer};
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::{Attitude, ViewError};
use hoverlock_reference::motion::ransac::RansacError;
use hoverlock_reference::motion::refusal::Refusal;
use serde::{Serialize, Serializer};
use std::fmt::Display;

/// Features that a frame needs at least, to be captured as well as to be estimated.
pub const MIN_FEATURES: usize = 8;

/// The kind of result that a frame has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The frame has an estimate.
    Estimate,
    /// The frame has an estimate from a search that the work limit ended.
    Late,
    /// The frame was captured as the reference.
    Reference,
    /// The frame has no estimate, for the given reason.
    None,
}

/// The reason why a frame has no estimate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// No register block has been received yet.
    #[error("the registers of the hardware have not been read yet")]
    Registers,
    /// The records are not a valid packet.
    #[error(transparent)]
    Message(#[from] MessageError),
    /// The feature with this index is outside the frame.
    #[error("feature {0} lies outside the frame")]
    Outside(usize),
    /// The hardware reports the frame as damaged, with these error bits of its trailer.
    #[error("the hardware reports a damaged frame, error bits 0x{0:04x}")]
    Damaged(u16),
    /// The telemetry of the frame was not received before the next frame.
    #[error("no telemetry for this frame")]
    Telemetry,
    /// The frame has too few features for any estimate: a constant picture has none.
    #[error("the frame shows {0} features, and {MIN_FEATURES} are needed")]
    Features(usize),
    /// No reference has been captured.
    #[error("no reference; send the command to capture one")]
    Reference,
    /// The frame matches the reference, which has not been confirmed yet.
    #[error("the reference is not confirmed yet: it must be found again for half a second, or two if little of it is")]
    Unconfirmed,
    /// By the prediction the frame shows none of the keyframes at a similar scale.
    #[error("no keyframe is in view at a similar scale")]
    OutOfView,
    /// By its readings the camera does not see the ground.
    #[error(transparent)]
    View(#[from] ViewError),
    /// Too few landmarks of a keyframe agree with one pose.
    #[error("no estimate: {0} landmarks agree")]
    Sightings(usize),
    /// The equations of the fit to this number of landmarks are singular, as with a lens that folds.
    #[error("no estimate: no pose can be fitted to the {0} landmarks that were matched")]
    Singular(usize),
    /// The pictures show a motion that the prediction excludes.
    #[error("no estimate: pictures and sensors disagree (chi squared {0:.0})")]
    Implausible(f64),
    /// The standard error is a metre or more.
    #[error("no estimate: the displacement is known to {0:.2} m only")]
    Uncertain(f64),
    /// The work limit ended the frame before the fit.
    #[error("no estimate: the work allowed ended before the fit")]
    Work,
    /// The matches show the pattern of the sensor.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The search found no motion.
    #[error(transparent)]
    Motion(#[from] RansacError),
}

/// The result of a frame, as it is written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Line {
    /// Frame number in the trailer; `None` if the trailer is not readable.
    pub frame: Option<u32>,
    /// Time in the telemetry, microseconds.
    pub time_us: Option<u64>,
    /// Number of the frame with which this one was matched, if any.
    pub reference: Option<u32>,
    /// Kind of the result.
    pub status: Status,
    /// Reason for the lack of an estimate.
    #[serde(serialize_with = "as_text")]
    pub reason: Option<Reason>,
    /// The estimate, if there is one.
    #[serde(flatten)]
    pub estimate: Option<Estimate>,
    /// Features used.
    pub features: usize,
    /// Features not used: dropped or withheld by the hardware, or above the program's limit.
    pub dropped: usize,
    /// Work units spent, see [`hoverlock_reference::motion::budget`].
    pub work: u64,
}

/// The pose of the camera relative to the origin, the captured reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Displacement along `X_e`, m.
    pub x_e_m: f64,
    /// Displacement along `Y_e`, m.
    pub y_e_m: f64,
    /// Displacement along `Z_e`, downwards, m.
    pub z_e_m: f64,
    /// Yaw of the frame, radians.
    pub yaw_rad: f64,
    /// Covariance of `X_e` and `Y_e`: xx, xy, yx, yy, m^2; what errors are on the mean. The protection level is that of
    /// rare ones.
    pub covariance_m2: [f64; 4],
    /// Velocity of the camera; `None` without samples of the IMU for half a second, as then only places are known.
    #[serde(flatten)]
    pub velocity: Option<Velocity>,
    /// Protection level: the radius about the estimate that the true displacement leaves in one frame of 100 000, m.
    pub protection_level_m: f64,
    /// `255 / (1 + protection level / 0.5 m)`, at least 1.
    pub quality: u8,
    /// Matches that agree with the estimated motion.
    pub inliers: usize,
    /// Features matched with the keyframe.
    pub matches: usize,
    /// Number of the keyframe.
    #[serde(skip)]
    pub keyframe: Option<u32>,
    /// Fitted attitude of the camera.
    #[serde(skip)]
    pub attitude: Attitude,
    /// Standard errors of the frame's sensor readings.
    #[serde(skip)]
    pub sensors: SensorErrors,
}

/// The velocity of the camera along `X_e`, `Y_e` and `Z_e` at the time of the telemetry, which is up to 5 ms off that
/// of the exposure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Velocity {
    /// Its components, m/s.
    pub velocity_m_s: [f64; 3],
    /// Their covariance, row by row, m^2/s^2.
    pub velocity_covariance_m2_s2: [f64; 9],
}

impl Line {
    /// Creates the line of a frame with this trailer, as yet without an estimate or a reason.
    pub fn new(trailer: Option<&Trailer>) -> Self {
        Self {
            frame: trailer.map(|trailer| trailer.frame),
            time_us: None,
            reference: None,
            status: Status::None,
            reason: None,
            estimate: None,
            features: 0,
            dropped: trailer.map_or(0, |trailer| trailer.dropped as usize + trailer.withheld as usize),
            work: 0,
        }
    }

    /// Replaces the contents of `text` by the line as JSON, with a newline. Allocates only if `text` lacks capacity.
    pub fn write(&self, text: &mut Vec<u8>) {
        text.clear();
        // Writing to memory does not fail, and every map key is a string.
        serde_json::to_writer(&mut *text, self).unwrap_or_else(|error| unreachable!("{error}"));
        text.push(b'\n');
    }
}

fn as_text<S: Serializer>(reason: &Option<impl Display>, serializer: S) -> Result<S::Ok, S::Error> {
    match reason {
        Some(reason) => serializer.collect_str(reason),
        None => serializer.serialize_none(),
    }
}
