//! The result of a frame as a line of JSON.
//!
//! `status` is `estimate`; `late` where the work allowed ended the search early and the estimate is the best so far;
//! `reference`
//! where the frame became the reference; `none` with a `reason` otherwise. Numbers are written with as many digits as
//! they
//! need to be read back to the same bits, by the same code on every machine.

use crate::message::{MessageError, Trailer};
use hoverlock_reference::motion::orthophoto::{Attitude, ViewError};
use hoverlock_reference::motion::pose::{Pose, PoseError, Sensors};
use hoverlock_reference::motion::ransac::RansacError;
use serde::{Serialize, Serializer};
use std::fmt::Display;

/// Whether there is an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// There is one.
    Estimate,
    /// There is one, of a search that ended early.
    Late,
    /// The frame is the new reference.
    Reference,
    /// There is none.
    None,
}

/// Why there is no estimate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// No register block has come yet.
    #[error("the registers of the hardware have not been read yet")]
    Registers,
    /// The records are not those of a frame.
    #[error(transparent)]
    Message(#[from] MessageError),
    /// A feature lies outside the frame.
    #[error("feature {0} lies outside the frame")]
    Outside(usize),
    /// The hardware found the frame short, interrupted or refused.
    #[error("the hardware reports a damaged frame, error bits 0x{0:04x}")]
    Damaged(u16),
    /// No telemetry came for the frame, neither before it nor before the next.
    #[error("no telemetry for this frame")]
    Telemetry,
    /// No reference has been captured.
    #[error("no reference; send the command to capture one")]
    Reference,
    /// The reference has been found again, but not late enough.
    #[error("the reference is not proved yet: it must be found again half a second after it was captured")]
    Unproved,
    /// The camera has zoomed since the reference.
    #[error("the field of view has changed since the reference; capture a new one")]
    Zoom,
    /// The readings describe no view of the ground.
    #[error(transparent)]
    View(#[from] ViewError),
    /// The features give no motion.
    #[error(transparent)]
    Motion(#[from] RansacError),
    /// The motion gives no pose.
    #[error(transparent)]
    Pose(#[from] PoseError),
}

/// The result of a frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Line {
    /// Number of the frame, as in its trailer; null where that is not readable.
    pub frame: Option<u32>,
    /// Time of the telemetry, microseconds.
    pub time_us: Option<u64>,
    /// Number of the frame that this one was compared with; null where there is none.
    pub reference: Option<u32>,
    /// Whether there is an estimate.
    pub status: Status,
    /// Why there is none.
    #[serde(serialize_with = "as_text")]
    pub reason: Option<Reason>,
    /// The estimate.
    #[serde(flatten)]
    pub estimate: Option<Estimate>,
    /// Features taken.
    pub features: usize,
    /// Features left out: dropped by the hardware, or more than the program takes.
    pub dropped: usize,
    /// Work units spent, see [`hoverlock_reference::motion::budget`].
    pub work: u64,
}

/// Where the camera is, seen from the origin: the reference that was captured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Along `X_e`, m.
    pub x_e_m: f64,
    /// Along `Y_e`, m.
    pub y_e_m: f64,
    /// Along `Z_e`, that is down, m.
    pub z_e_m: f64,
    /// Yaw of the frame, radians.
    pub yaw_rad: f64,
    /// Covariance of `X_e` and `Y_e`: xx, xy, yx, yy, m^2.
    pub covariance_m2: [f64; 4],
    /// 0 ..= 255; at least 1 in an estimate.
    pub quality: u8,
    /// Matches that agree.
    pub inliers: usize,
    /// Matches.
    pub matches: usize,
    /// Attitude of the camera.
    #[serde(skip)]
    pub attitude: Attitude,
    /// What the frame's sensors are good for.
    #[serde(skip)]
    pub sensors: Sensors,
}

impl Estimate {
    /// The pose of `inliers` out of `matches`.
    pub fn of(pose: &Pose, inliers: usize, matches: usize, sensors: Sensors) -> Self {
        let c = pose.covariance;
        Self {
            x_e_m: pose.displacement.x,
            y_e_m: pose.displacement.y,
            z_e_m: pose.descent,
            yaw_rad: pose.current.attitude.yaw,
            covariance_m2: [c[(0, 0)], c[(0, 1)], c[(1, 0)], c[(1, 1)]],
            quality: pose.quality,
            inliers,
            matches,
            attitude: pose.current.attitude,
            sensors,
        }
    }
}

impl Line {
    /// The line of a frame without an estimate yet.
    pub fn of(trailer: Option<&Trailer>) -> Self {
        Self {
            frame: trailer.map(|trailer| trailer.frame),
            time_us: None,
            reference: None,
            status: Status::None,
            reason: None,
            estimate: None,
            features: 0,
            dropped: trailer.map_or(0, |trailer| trailer.dropped as usize),
            work: 0,
        }
    }

    /// Writes the line, replacing what `text` holds; with enough memory in `text` none is allocated.
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
