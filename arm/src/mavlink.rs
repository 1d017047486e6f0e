//! Estimates as MAVLink messages for an autopilot.
//!
//! The message is `ODOMETRY`: it has position, attitude, covariance, quality and a reset counter, PX4 and ArduPilot
//! accept it, and the next message makes up for a lost one. The alternatives have less: `LANDING_TARGET` is the
//! position of a landing place and not of the helicopter. `VISION_POSITION_DELTA` is the motion since the last message:
//! each delta has the error of two estimates, and a lost one is missing from the sum permanently.
//! `VISION_POSITION_ESTIMATE` has no quality.
//!
//! Frames are `MAV_FRAME_LOCAL_FRD`, whose origin is the camera at the reference, and `MAV_FRAME_BODY_FRD`, the only
//! pair that both autopilots take. With the top of the picture forward, `x = -Y_e`, `y = X_e`, `z = Z_e`, and roll
//! and pitch change their sign ([`hoverlock_reference::motion::orthophoto`]). Forward is where the telemetry's yaw
//! is 0.
//!
//! The filter provides the covariance of `x` and `y`. Those of `z` and the attitude are the sensors', which are upper
//! bounds. The velocity, along the axes of the body, is the filter's, too. Without samples of the IMU it is unknown: it
//! and its covariance are sent as not a number. So are the angular rates, which the autopilot's own gyros measure.
//! Configure the autopilot to use position, velocity and yaw from this source: one that derives the velocity from the
//! positions holds its place less well (decision 067).
//!
//! Framing, sequence and check are those of `mavlink-core`. The body is written here, because the dialect crate would
//! compile 1.7 MB of source for two minutes for this one message.

use crate::line::{Estimate, Line, Status, Velocity};
use mavlink_core::bytes_mut::BytesMut;
use mavlink_core::error::{EncoderError, ParserError};
use mavlink_core::{Dialect, MAVLinkV2MessageRaw, MavHeader, MavlinkVersion};
use nalgebra::{Matrix3, Vector3};

/// An encoder of `ODOMETRY` messages, with their sequence number and reset counter.
pub struct OdometryStream {
    message: MAVLinkV2MessageRaw,
    sequence: u8,
    /// Captured references, modulo 256.
    references: u8,
}

/// `MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY`.
const COMPONENT_ID: u8 = 197;
/// The vehicle: all of its components send the same number.
const SYSTEM_ID: u32 = 1;

impl Default for OdometryStream {
    fn default() -> Self {
        Self { message: MAVLinkV2MessageRaw::new(), sequence: 0, references: 0 }
    }
}

impl OdometryStream {
    /// Returns the message of a line with an estimate, or `None`. A line of a captured reference increments the reset
    /// counter of the following messages, as its frame is a new origin.
    pub fn message(&mut self, line: &Line) -> Option<&[u8]> {
        if line.status == Status::Reference {
            self.references = self.references.wrapping_add(1);
        }
        let (estimate, time_us) = line.estimate.zip(line.time_us)?;
        let header = MavHeader { system_id: SYSTEM_ID, component_id: COMPONENT_ID, sequence: self.sequence };
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

/// Message number of `ODOMETRY`.
const ODOMETRY_ID: u32 = 331;
/// `CRC_EXTRA` of `ODOMETRY`: derived from the definition of the message, so that a receiver with another one refuses
/// it.
const EXTRA_CRC: u8 = 91;

/// `MAV_FRAME_LOCAL_FRD`.
const LOCAL_FRD: u8 = 20;
/// `MAV_FRAME_BODY_FRD`.
const BODY_FRD: u8 = 12;
/// `MAV_ESTIMATOR_TYPE_VISION`.
const VISION: u8 = 2;

impl Odometry {
    /// Returns `w, x, y, z` of the body's attitude: rotations by yaw, then pitch, then roll, with aerospace signs.
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

    /// Returns the upper triangle of the covariance of `x, y, z, roll, pitch, yaw`, row by row; m^2 and rad^2.
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

    /// Returns velocity and angular rates about the axes of the body, m/s and rad/s, and the upper triangle of their
    /// covariance, row by row. What is not known is not a number.
    fn twist(&self) -> ([f64; 6], [f64; 21]) {
        let (mut twist, mut upper) = ([f64::NAN; 6], [f64::NAN; 21]);
        if let Some(Velocity { velocity_m_s, velocity_covariance_m2_s2 }) = self.estimate.velocity {
            // Forward is the camera's -y, and right its x.
            let camera_to_body = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
            let to_body = camera_to_body * self.estimate.attitude.rotation().transpose();
            let velocity = to_body * Vector3::from(velocity_m_s);
            let c = to_body * Matrix3::from_row_slice(&velocity_covariance_m2_s2) * to_body.transpose();
            twist[..3].copy_from_slice(velocity.as_slice());
            (upper[0], upper[1], upper[2]) = (c.m11, c.m12, c.m13);
            (upper[6], upper[7], upper[11]) = (c.m22, c.m23, c.m33);
        }
        (twist, upper)
    }
}

/// The dialect of this one message, which is only sent.
struct OdometryOnly;

impl Dialect for OdometryOnly {
    type Message = Odometry;
    type EncodeError = EncoderError;

    fn message_id(&self, _message: &Odometry) -> u32 {
        ODOMETRY_ID
    }

    fn extra_crc(&self, message_id: u32) -> Option<u8> {
        (message_id == ODOMETRY_ID).then_some(EXTRA_CRC)
    }

    fn decode(&self, _version: MavlinkVersion, id: u32, _payload: &[u8]) -> Result<Odometry, ParserError> {
        Err(ParserError::UnknownMessage { id })
    }

    /// Writes the fields in order of size, the extensions last: 233 bytes.
    fn encode(&self, _: MavlinkVersion, message: &Odometry, payload: &mut [u8]) -> Result<usize, EncoderError> {
        let Estimate { x_e_m, y_e_m, z_e_m, quality, .. } = message.estimate;
        let mut body = BytesMut::new(payload);
        body.put_u64_le(message.time_us);
        let (twist, of_twist) = message.twist();
        let numbers = [-y_e_m, x_e_m, z_e_m].into_iter().chain(message.quaternion()).chain(twist);
        for number in numbers.chain(message.covariance()).chain(of_twist) {
            body.put_f32_le(number as f32);
        }
        [LOCAL_FRD, BODY_FRD, message.references, VISION].into_iter().for_each(|byte| body.put_u8(byte));
        // Per cent, 1 the worst; 0 would mean unknown. MAVLink 2 cuts off trailing zeros; this byte is never 0.
        body.put_i8((100 * u16::from(quality)).div_ceil(255) as i8);
        Ok(body.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::motion::observation::SensorErrors;
    use hoverlock_reference::motion::orthophoto::Attitude;
    use nalgebra::{Quaternion, UnitQuaternion};

    /// Turned back by the quaternion of the message, the velocity of the body is that along `-Y_e`, `X_e`, `Z_e`, with
    /// its covariance.
    #[test]
    fn the_velocity_is_along_the_axes_of_the_body() {
        let velocity_m_s = [0.7, -0.4, 0.2];
        let covariance = Matrix3::new(4e-4, 1e-4, -2e-4, 1e-4, 9e-4, 3e-4, -2e-4, 3e-4, 6e-4);
        let mut velocity_covariance_m2_s2 = [0.0; 9];
        velocity_covariance_m2_s2.copy_from_slice(covariance.as_slice());
        let estimate = Estimate {
            x_e_m: 0.0,
            y_e_m: 0.0,
            z_e_m: 0.0,
            yaw_rad: 0.9,
            covariance_m2: [1e-4, 0.0, 0.0, 1e-4],
            velocity: Some(Velocity { velocity_m_s, velocity_covariance_m2_s2 }),
            protection_level_m: 0.05,
            quality: 231,
            inliers: 9,
            matches: 9,
            keyframe: None,
            attitude: Attitude { roll: 0.2, pitch: -0.3, yaw: 0.9 },
            sensors: SensorErrors { tilt: 3e-3, heading: 1e-2, range: 0.1 },
        };
        let odometry = Odometry { time_us: 1, estimate, references: 1 };
        let ([vx, vy, vz, rates @ ..], upper) = odometry.twist();
        let [w, x, y, z] = odometry.quaternion();
        let to_local = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner();
        let local = to_local * Vector3::new(vx, vy, vz);
        assert!((local - Vector3::new(0.4, 0.7, 0.2)).norm() < 1e-12, "{local}");
        let [xx, xy, xz, _, _, _, yy, yz, _, _, _, zz, ..] = upper;
        let of_local = to_local * Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * to_local.transpose();
        let expected = Matrix3::new(9e-4, -1e-4, -3e-4, -1e-4, 4e-4, -2e-4, -3e-4, -2e-4, 6e-4);
        assert!((of_local - expected).norm() < 1e-15, "{of_local}");
        assert!(rates.iter().chain(&upper[3..6]).all(|value| value.is_nan()), "{rates:?} {upper:?}");
    }
}
