//! The calibration of camera and inertial sensor: their errors as they were measured, each with its standard error.
//!
//! | name | error | values | limits |
//! |---|---|---|---|
//! | `k1` | radial distortion of normalised coordinates (Brown 1966) | 1 | -1 to 1 |
//! | `readout_s` | time from the read-out of the first row to that of the last, s | 1 | 0 to 0.1 |
//! | `focal` | relative error of the focal length that the telemetry's field of view gives | 1 | -0.1 to 0.1 |
//! | `principal_px` | pixel on the optical axis, less the centre of the frame | 2 | -1000 to 1000 |
//! | `boresight_deg` | roll, pitch and yaw of the camera relative to the inertial sensor | 3 | -5 to 5 |
//! | `gyro_bias_deg_per_s` | bias of the gyroscopes about the axes of the inertial sensor | 3 | -5 to 5 |
//! | `force_bias_m_per_s2` | bias of the accelerometers along the same axes | 3 | -5 to 5 |
//!
//! A direction with normalised coordinates `u` is seen at `c + f (1 + focal) u (1 + k1 |u|^2)`, where `c` is the centre
//! and `principal_px`. The rotation of the camera is that of the inertial sensor times that of `boresight_deg`.
//!
//! The filter goes on to estimate the first three and the biases from what a flight shows. What is not known of
//! principal point and bore-sight counts as an error of the attitude reading, which it resembles.
//!
//! **Without a calibration** the standard errors are those of a camera that nobody has calibrated, principal point and
//! bore-sight are 0, and the standard errors of the telemetry include them. Biases are 0 with the standard errors of a
//! small inertial sensor whose readings were averaged on the ground.

use crate::line::Estimate;
use crate::message::{CALIBRATION, MessageError, Telemetry};
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, ViewError};
use nalgebra::{Matrix3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// Errors of camera and inertial sensor.
const ERRORS: usize = 7;
/// Name, number of values, and least and largest value of each; a standard error is 0 to the largest value.
const LIMITS: [(&str, usize, f64, f64); ERRORS] = [
    ("k1", 1, -1.0, 1.0),
    ("readout_s", 1, 0.0, 0.1),
    ("focal", 1, -0.1, 0.1),
    ("principal_px", 2, -1000.0, 1000.0),
    ("boresight_deg", 3, -5.0, 5.0),
    ("gyro_bias_deg_per_s", 3, -5.0, 5.0),
    ("force_bias_m_per_s2", 3, -5.0, 5.0),
];
/// Values of all of them.
const VALUES: usize = 14;
/// Size of a payload.
const PAYLOAD_BYTES: usize = 8 * (VALUES + ERRORS);

/// What was measured of an error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "{ value = .., sigma = .. }")]
pub struct Measured<T> {
    /// Its value or values.
    pub value: T,
    /// Standard error of each.
    pub sigma: f64,
}

/// A calibration; units and limits are those of the [module](self).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Calibration {
    /// Radial distortion.
    pub k1: Measured<f64>,
    /// Read-out time.
    pub readout_s: Measured<f64>,
    /// Relative error of the focal length.
    pub focal: Measured<f64>,
    /// Offset of the principal point.
    pub principal_px: Measured<[f64; 2]>,
    /// Bore-sight.
    pub boresight_deg: Measured<[f64; 3]>,
    /// Bias of the gyroscopes.
    pub gyro_bias_deg_per_s: Measured<[f64; 3]>,
    /// Bias of the accelerometers.
    pub force_bias_m_per_s2: Measured<[f64; 3]>,
}

impl Default for Calibration {
    /// Returns that of a camera that nobody has calibrated. Its standard errors are assumptions.
    fn default() -> Self {
        Self {
            k1: Measured { value: 0.0, sigma: 0.05 },
            readout_s: Measured { value: 0.0, sigma: 0.015 },
            focal: Measured { value: 0.0, sigma: 0.01 },
            principal_px: Measured { value: [0.0; 2], sigma: 0.0 },
            boresight_deg: Measured { value: [0.0; 3], sigma: 0.0 },
            gyro_bias_deg_per_s: Measured { value: [0.0; 3], sigma: 1e-3f64.to_degrees() },
            force_bias_m_per_s2: Measured { value: [0.0; 3], sigma: 0.04 },
        }
    }
}

/// A number of a calibration is outside its limits.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name}.{part} is {number}, and must be {least} to {most}")]
pub struct CalibrationError {
    /// Name of the error.
    pub name: &'static str,
    /// `value` or `sigma`.
    pub part: &'static str,
    /// The number.
    pub number: f64,
    /// The least that it may be.
    pub least: f64,
    /// The most that it may be.
    pub most: f64,
}

impl Calibration {
    /// Returns the calibration if its numbers are within their limits.
    ///
    /// # Errors
    /// The first number that is not.
    pub fn checked(self) -> Result<Self, CalibrationError> {
        let (values, sigmas) = self.numbers();
        let mut values = &values[..];
        for ((name, count, least, most), sigma) in LIMITS.into_iter().zip(sigmas) {
            let (of_this, rest) = values.split_at(count);
            values = rest;
            let parts = of_this.iter().map(|value| ("value", *value, least)).chain([("sigma", sigma, 0.0)]);
            for (part, number, least) in parts {
                if !(least..=most).contains(&number) {
                    return Err(CalibrationError { name, part, number, least, most });
                }
            }
        }
        Ok(self)
    }

    /// Returns all values and all standard errors, in the order of the table.
    fn numbers(&self) -> ([f64; VALUES], [f64; ERRORS]) {
        let Self { k1, readout_s, focal, principal_px, boresight_deg, gyro_bias_deg_per_s, force_bias_m_per_s2 } = self;
        let ([x, y], [roll, pitch, yaw]) = (principal_px.value, boresight_deg.value);
        let ([p, q, r], [u, v, w]) = (gyro_bias_deg_per_s.value, force_bias_m_per_s2.value);
        (
            [k1.value, readout_s.value, focal.value, x, y, roll, pitch, yaw, p, q, r, u, v, w],
            [
                k1.sigma,
                readout_s.sigma,
                focal.sigma,
                principal_px.sigma,
                boresight_deg.sigma,
                gyro_bias_deg_per_s.sigma,
                force_bias_m_per_s2.sigma,
            ],
        )
    }

    /// Inverts [`Calibration::numbers`].
    fn of_numbers(values: [f64; VALUES], sigmas: [f64; ERRORS]) -> Self {
        let [k1, readout, focal, x, y, roll, pitch, yaw, p, q, r, u, v, w] = values;
        let [of_k1, of_readout, of_focal, of_principal, of_boresight, of_gyro, of_force] = sigmas;
        Self {
            k1: Measured { value: k1, sigma: of_k1 },
            readout_s: Measured { value: readout, sigma: of_readout },
            focal: Measured { value: focal, sigma: of_focal },
            principal_px: Measured { value: [x, y], sigma: of_principal },
            boresight_deg: Measured { value: [roll, pitch, yaw], sigma: of_boresight },
            gyro_bias_deg_per_s: Measured { value: [p, q, r], sigma: of_gyro },
            force_bias_m_per_s2: Measured { value: [u, v, w], sigma: of_force },
        }
    }

    /// Decodes the payload of a message.
    ///
    /// # Errors
    /// If the length is wrong, or a number is outside its limits.
    pub fn parse(payload: &[u8]) -> Result<Self, MessageError> {
        let bytes: &[u8; PAYLOAD_BYTES] =
            payload.try_into().map_err(|_| MessageError::Length { kind: CALIBRATION, bytes: payload.len() })?;
        let (numbers, _) = bytes.as_chunks();
        let number = |i: usize| f64::from_le_bytes(numbers[i]);
        let calibration = Self::of_numbers(std::array::from_fn(number), std::array::from_fn(|i| number(VALUES + i)));
        calibration.checked().map_err(|error| MessageError::Reading(error.name))
    }

    /// Encodes the calibration as the payload of a message.
    pub fn encode(&self) -> Vec<u8> {
        let (values, sigmas) = self.numbers();
        values.into_iter().chain(sigmas).flat_map(f64::to_le_bytes).collect()
    }

    /// Returns the camera of a frame of `width` x `height` px with its principal point, and the readings of the
    /// inertial sensor as those of the camera.
    ///
    /// # Errors
    /// The field of view of the readings is not that of a camera.
    pub fn seen_by(&self, [width, height]: [usize; 2], readings: &Telemetry) -> Result<(Camera, Telemetry), ViewError> {
        let camera = Camera::with_field_of_view(width, height, readings.field_of_view)?;
        let readings = self.of_camera(readings, camera.focal());
        Ok((camera.with_offset(Vector2::from(self.principal_px.value)), readings))
    }

    /// Returns the rotation from the camera to the inertial sensor; `None` if they are aligned.
    pub(crate) fn boresight(&self) -> Option<Matrix3<f64>> {
        let [roll, pitch, yaw] = self.boresight_deg.value.map(f64::to_radians);
        let boresight = Attitude { roll, pitch, yaw };
        // A rotation and back would change the last bits of an attitude.
        (boresight != Attitude::default()).then(|| boresight.rotation())
    }

    /// Returns the biases of gyroscopes (rad/s) and accelerometers (m/s^2) about the axes of the camera, and the
    /// standard error of each.
    pub(crate) fn biases(&self) -> [(Vector3<f64>, f64); 2] {
        let Self { gyro_bias_deg_per_s: gyro, force_bias_m_per_s2: force, .. } = self;
        let boresight = self.boresight();
        let of_camera = |bias: Vector3<f64>| boresight.map_or(bias, |boresight| boresight.tr_mul(&bias));
        let rates = Vector3::from(gyro.value.map(f64::to_radians));
        [(of_camera(rates), gyro.sigma.to_radians()), (of_camera(Vector3::from(force.value)), force.sigma)]
    }

    /// Returns the readings of the inertial sensor as those of the camera, which has the focal length `focal` (px).
    fn of_camera(&self, readings: &Telemetry, focal: f64) -> Telemetry {
        let attitude = match self.boresight() {
            Some(boresight) => Attitude::of_rotation(&(readings.attitude.rotation() * boresight)),
            None => readings.attitude,
        };
        let SensorErrors { tilt, heading, range } = readings.sensors;
        let boresight = self.boresight_deg.sigma.to_radians();
        let tilt = libm::hypot(libm::hypot(tilt, boresight), self.principal_px.sigma / focal);
        let sensors = SensorErrors { tilt, heading: libm::hypot(heading, boresight), range };
        Telemetry { attitude, sensors, ..*readings }
    }

    /// Returns the estimate of the camera's pose with the attitude of the inertial sensor.
    pub fn of_sensor(&self, estimate: Estimate) -> Estimate {
        let Some(boresight) = self.boresight() else { return estimate };
        let attitude = Attitude::of_rotation(&(estimate.attitude.rotation() * boresight.transpose()));
        Estimate { attitude, yaw_rad: attitude.yaw, ..estimate }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Step;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    /// Returns a calibration whose numbers are within their limits.
    fn any_calibration() -> impl Strategy<Value = Calibration> {
        let measured =
            |least: f64, most: f64| (least..=most, 0.0..=most).prop_map(|(value, sigma)| Measured { value, sigma });
        let principal = (prop::array::uniform2(-1000.0..=1000.0), 0.0..=1000.0);
        let boresight = (prop::array::uniform3(-5.0..=5.0), 0.0..=5.0);
        let lens = (measured(-1.0, 1.0), measured(0.0, 0.1), measured(-0.1, 0.1));
        let bias =
            || (prop::array::uniform3(-5.0..=5.0), 0.0..=5.0).prop_map(|(value, sigma)| Measured { value, sigma });
        (lens, principal, boresight, [bias(), bias()]).prop_map(
            |((k1, readout_s, focal), (x_y, px), (angles, deg), [gyro, force])| Calibration {
                k1,
                readout_s,
                focal,
                principal_px: Measured { value: x_y, sigma: px },
                boresight_deg: Measured { value: angles, sigma: deg },
                gyro_bias_deg_per_s: gyro,
                force_bias_m_per_s2: force,
            },
        )
    }

    proptest! {
        #[test]
        fn decoding_inverts_encoding(calibration in any_calibration()) {
            prop_assert_eq!(Calibration::parse(&calibration.encode()), Ok(calibration));
        }

        /// Any number outside its limits is refused by its name.
        #[test]
        fn numbers_outside_their_limits_are_refused(
            calibration in any_calibration(), index in 0..VALUES + ERRORS,
            wrong in prop::sample::select(vec![f64::NAN, f64::INFINITY, -1e4, 1e4]),
        ) {
            let mut payload = calibration.encode();
            payload[8 * index..8 * index + 8].copy_from_slice(&wrong.to_le_bytes());
            let of_values = LIMITS.iter().flat_map(|(name, count, ..)| std::iter::repeat_n(*name, *count));
            let name = of_values.chain(LIMITS.map(|(name, ..)| name)).nth(index).unwrap();
            prop_assert_eq!(Calibration::parse(&payload), Err(MessageError::Reading(name)));
        }

        /// Readings of the sensor become those of the camera, and the estimate of the camera becomes one of the sensor.
        #[test]
        fn the_bore_sight_turns_there_and_back(
            calibration in any_calibration(), angles in prop::array::uniform3(-0.5..0.5f64),
        ) {
            let [roll, pitch, yaw] = angles;
            let readings = Telemetry {
                frame: 1,
                time_us: 1,
                attitude: Attitude { roll, pitch, yaw },
                range: 50.0,
                field_of_view: 0.87,
                sensors: SensorErrors { tilt: 1e-3, heading: 1e-3, range: 0.1 },
            };
            let of_camera = calibration.of_camera(&readings, 1000.0);
            let [a, b, c] = calibration.boresight_deg.value.map(f64::to_radians);
            let boresight = Attitude { roll: a, pitch: b, yaw: c }.rotation();
            let expected = readings.attitude.rotation() * boresight;
            prop_assert!((of_camera.attitude.rotation() - expected).norm() < 1e-12);
            let gravity = Step { rates: Vector3::zeros(), force: Vector3::new(0.0, 0.0, 9.8), seconds: 0.005 };
            let level = of_camera.attitude.rotation() * gravity.turned(&boresight).force;
            let of_readings = readings.attitude.rotation() * gravity.force;
            prop_assert!((level - of_readings).norm() < 1e-12);
            let estimate = Estimate {
                x_e_m: 1.0,
                y_e_m: 2.0,
                z_e_m: 3.0,
                yaw_rad: of_camera.attitude.yaw,
                covariance_m2: [1.0, 0.0, 0.0, 1.0],
                velocity: None,
                protection_level_m: 5.0,
                quality: 9,
                inliers: 8,
                matches: 9,
                keyframe: None,
                attitude: of_camera.attitude,
                sensors: readings.sensors,
            };
            let of_sensor = calibration.of_sensor(estimate);
            prop_assert!((of_sensor.attitude.rotation() - readings.attitude.rotation()).norm() < 1e-12);
            prop_assert!((of_sensor.yaw_rad - yaw).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_not_known_of_the_axis_is_an_error_of_the_attitude() {
        let mut calibration = Calibration::default();
        let readings = Telemetry {
            frame: 1,
            time_us: 1,
            attitude: Attitude { roll: 0.1, pitch: -0.2, yaw: 0.3 },
            range: 50.0,
            field_of_view: 0.87,
            sensors: SensorErrors { tilt: 3e-3, heading: 5e-3, range: 0.1 },
        };
        assert_eq!(calibration.of_camera(&readings, 1000.0), readings);
        calibration.principal_px.sigma = 4.0;
        let sensors = calibration.of_camera(&readings, 1000.0).sensors;
        assert!((sensors.tilt - 5e-3).abs() < 1e-12 && sensors.heading == 5e-3);
        (calibration.principal_px.sigma, calibration.boresight_deg.sigma) = (0.0, 4e-3f64.to_degrees());
        let sensors = calibration.of_camera(&readings, 1000.0).sensors;
        assert!((sensors.tilt - 5e-3).abs() < 1e-12 && (sensors.heading - 41f64.sqrt() * 1e-3).abs() < 1e-12);
    }
}
