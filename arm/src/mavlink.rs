//! Estimates as MAVLink messages for an autopilot.
//!
//! The message is `ODOMETRY`. `LANDING_TARGET` says where to land and not where the helicopter is.
//! `VISION_POSITION_DELTA` is a motion since the last message: each delta has the error of two estimates, and one
//! that is lost is missing from the sum for good. `VISION_POSITION_ESTIMATE` has no quality. `ODOMETRY` has
//! position, attitude, covariance, quality and a count of references, PX4 and ArduPilot take it, and a lost one
//! costs nothing.
//!
//! Frames are `MAV_FRAME_LOCAL_FRD`, whose origin is the camera at the reference, and `MAV_FRAME_BODY_FRD`, the only
//! pair that both autopilots take. With the top of the picture forward, `x = -Y_e`, `y = X_e`, `z = Z_e`, and roll
//! and pitch change their sign ([`hoverlock_reference::motion::orthophoto`]). Forward is where the telemetry's yaw
//! is 0.
//!
//! The pose fit gives the covariance of `x` and `y`. Those of `z` and the attitude are the sensors', which the fit
//! can only improve. Velocities are not measured: not a number, as is their covariance; take position and yaw from
//! this source, velocity from another.
//!
//! Framing, sequence and check come from `mavlink-core`. The body is written here: the dialect crate would make this
//! one message out of 1.7 MB of source, two minutes of compiling.

use crate::line::{Estimate, Line, Status};
use mavlink_core::bytes_mut::BytesMut;
use mavlink_core::error::{EncoderError, ParserError};
use mavlink_core::{Dialect, MAVLinkV2MessageRaw, MavHeader, MavlinkVersion};

/// Sends the estimates of one program.
pub struct Stream {
    message: MAVLinkV2MessageRaw,
    sequence: u8,
    references: u8,
}

/// `MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY`.
const COMPONENT: u8 = 197;
/// The vehicle; one and the same for all of its components.
const SYSTEM: u32 = 1;

impl Default for Stream {
    fn default() -> Self {
        Self { message: MAVLinkV2MessageRaw::new(), sequence: 0, references: 0 }
    }
}

impl Stream {
    /// The message of a line with an estimate; none for the others. A new reference moves the origin: it is counted,
    /// and the next message says so.
    pub fn message(&mut self, line: &Line) -> Option<&[u8]> {
        if line.status == Status::Reference {
            self.references = self.references.wrapping_add(1);
        }
        let (estimate, time_us) = line.estimate.zip(line.time_us)?;
        let header = MavHeader { system_id: SYSTEM, component_id: COMPONENT, sequence: self.sequence };
        self.sequence = self.sequence.wrapping_add(1);
        let odometry = Odometry { time_us, estimate, references: self.references };
        self.message.serialize_message_with_dialect(header, &OdometryOnly, &odometry).ok()?;
        Some(self.message.raw_bytes())
    }
}

/// `ODOMETRY`, message 331 of the dialect `common`.
struct Odometry {
    time_us: u64,
    estimate: Estimate,
    references: u8,
}

/// The identity of `ODOMETRY`.
const ODOMETRY: u32 = 331;
/// What its definition adds to the check, so that a receiver with another definition refuses it.
const EXTRA_CRC: u8 = 91;

/// `MAV_FRAME_LOCAL_FRD`.
const LOCAL_FRD: u8 = 20;
/// `MAV_FRAME_BODY_FRD`.
const BODY_FRD: u8 = 12;
/// `MAV_ESTIMATOR_TYPE_VISION`.
const VISION: u8 = 2;

impl Odometry {
    /// `w, x, y, z` of the body's attitude, turned by yaw, then pitch, then roll of flight mechanics.
    fn quaternion(&self) -> [f64; 4] {
        let attitude = self.estimate.attitude;
        let half = |angle: f64| (libm::cos(angle / 2.0), libm::sin(angle / 2.0));
        let ((cr, sr), (cp, sp), (cy, sy)) = (half(-attitude.roll), half(-attitude.pitch), half(attitude.yaw));
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    }

    /// Upper triangle of the covariance of `x, y, z, roll, pitch, yaw`, row by row.
    fn covariance(&self) -> [f64; 21] {
        let [xx, xy, _, yy] = self.estimate.covariance_m2;
        let sensors = self.estimate.sensors;
        let mut upper = [0.0; 21];
        // x is -Y_e and y is X_e.
        (upper[0], upper[1], upper[6]) = (yy, -xy, xx);
        // Z_e is the difference of two ranges.
        upper[11] = 2.0 * sensors.range * sensors.range;
        (upper[15], upper[18]) = (sensors.tilt * sensors.tilt, sensors.tilt * sensors.tilt);
        upper[20] = sensors.heading * sensors.heading;
        upper
    }
}

/// A dialect of one message, that is sent and never received.
struct OdometryOnly;

impl Dialect for OdometryOnly {
    type Message = Odometry;
    type EncodeError = EncoderError;

    fn message_id(&self, _message: &Odometry) -> u32 {
        ODOMETRY
    }

    fn extra_crc(&self, message_id: u32) -> Option<u8> {
        (message_id == ODOMETRY).then_some(EXTRA_CRC)
    }

    fn decode(&self, _version: MavlinkVersion, id: u32, _payload: &[u8]) -> Result<Odometry, ParserError> {
        Err(ParserError::UnknownMessage { id })
    }

    /// The fields by size, the extensions last: 233 bytes.
    fn encode(&self, _: MavlinkVersion, message: &Odometry, payload: &mut [u8]) -> Result<usize, EncoderError> {
        let Estimate { x_e_m, y_e_m, z_e_m, quality, .. } = message.estimate;
        let mut body = BytesMut::new(payload);
        body.put_u64_le(message.time_us);
        let velocities = [f64::NAN; 6];
        let numbers = [-y_e_m, x_e_m, z_e_m].into_iter().chain(message.quaternion()).chain(velocities);
        // The first of a covariance says that it is not known.
        let of_velocities = (0..21).map(|i| if i == 0 { f64::NAN } else { 0.0 });
        for number in numbers.chain(message.covariance()).chain(of_velocities) {
            body.put_f32_le(number as f32);
        }
        [LOCAL_FRD, BODY_FRD, message.references, VISION].into_iter().for_each(|byte| body.put_u8(byte));
        // Per cent, 1 the worst; 0 would mean not known. It is never 0, so that no end of zeros must be cut off.
        body.put_i8((100 * u16::from(quality)).div_ceil(255) as i8);
        Ok(body.len())
    }
}
