//! The autopilot: holds attitude, heading, height and position.
//!
//! | loop | input | rate |
//! |---|---|---|
//! | attitude ([`attitude`]) | inertial sensor | every step |
//! | heading | yaw of the inertial sensor | every step |
//! | height | barometer; accelerometer between readings | every step |
//! | position | delayed fixes of position and velocity; accelerometer, attitude between ([`navigation`]) | every step |
//!
//! **Position.** `e` is the estimated position and `v` the velocity over the ground. `d` is the acceleration that tilt
//! does not explain: the drag of gusts by the accelerometer, and the attitude error by the filter:
//!
//! ```text
//! a = K_v (limit(-K_x e) - v),    tilt = (d - a) / g
//! ```
//!
//! Height is held in the same way; there `d` is the downward acceleration that was not commanded.
//!
//! **Without fixes** the position is held by the inertial sensor for [`COAST_S`]; after that the autopilot holds a
//! level attitude. The weight of the position loop's tilt goes from 1 to 0 within [`FADE_S`], and back when fixes
//! return, so that no command jumps.

pub mod attitude;
pub mod navigation;

use crate::aircraft::GRAVITY;
use crate::aircraft::lynx::Derivatives;
use crate::sensors::{self, Inertial};
use attitude::AttitudeLoop;
use nalgebra::{Matrix2, Vector2, Vector3, Vector4};
use navigation::{AccelerationNoise, AxisFilter, Reading};

/// Time for which the position is held without a fix.
const COAST_S: f64 = 1.0;
/// Time in which the weight of the position loop changes between 0 and 1.
const FADE_S: f64 = 2.0;
/// Largest tilt that the position loop commands, rad: 3.5 degrees, which with gusts and overshoot stays within 5.
const MAX_TILT: f64 = 3.5 * std::f64::consts::PI / 180.0;

/// `K_x` (1/s), `K_v` (1/s) and the largest speed towards the position (m/s).
const POSITION_LOOP: [f64; 3] = [0.8, 1.8, 0.7];
/// Largest rate of the tilt command, rad/s: 15 degrees a second.
const MAX_TILT_RATE: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Time constant of the drag estimate.
const DRAG_TIME_S: f64 = 0.3;
/// `K_z` (1/s), `K_w` (1/s), the largest climb rate (m/s) and the largest vertical acceleration (m/s^2).
const HEIGHT_LOOP: [f64; 4] = [0.8, 2.0, 2.5, 1.5];
/// Time constant of the estimate of vertical gusts.
const HEAVE_TIME_S: f64 = 0.5;
/// Smallest standard errors assumed for a vision fix and for a reading of the barometer.
const MIN_ERRORS_M: [f64; 2] = [0.005, 0.2];
/// Smallest standard error assumed for the velocity of a vision fix: that of a position of 5 mm in a second.
const MIN_VELOCITY_ERROR_M_S: f64 = 0.005;

/// The source of the position that is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// Vision fixes.
    #[default]
    Vision,
    /// The inertial sensor alone; fixes are ignored.
    ImuOnly,
}

/// The vision estimate of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Displacement from the reference to the camera along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// Covariance, m^2. The two axes are filtered separately, with the diagonal.
    pub covariance: Matrix2<f64>,
    /// Velocity of the camera along `X_e` and `Y_e`, m/s, with its covariance, m^2/s^2.
    pub velocity: Option<(Vector2<f64>, Matrix2<f64>)>,
    /// Estimated height, m. The loops do not use it.
    pub height: Option<f64>,
    /// Estimated yaw, rad. The loops do not use it.
    pub yaw: Option<f64>,
    /// Time of the exposure, s.
    pub exposed: f64,
}

/// The autopilot of one flight.
#[derive(Debug, Clone)]
pub struct Autopilot {
    hold: Hold,
    step: f64,
    noise_model: AccelerationNoise,
    attitude: AttitudeLoop,
    position: [AxisFilter; 2],
    vertical: AxisFilter,
    drag: Vector2<f64>,
    tilt: Vector2<f64>,
    heave: f64,
    downward: f64,
    weight: f64,
    newest: f64,
}

impl Autopilot {
    /// Creates an autopilot at a height (m) and a time (s), for an inertial sensor with an rms tilt error `tilt` (rad).
    /// Returns `None` if the blade angles cannot command all four accelerations.
    pub fn new(derivatives: &Derivatives, tilt: f64, height: f64, time: f64, step: f64) -> Option<Self> {
        let share = |i: usize| GRAVITY * tilt * sensors::VARIANCE_SHARES[i].sqrt();
        let noise_model = AccelerationNoise {
            white: sensors::FORCE_NOISE.hypot(share(3)),
            constant: sensors::FORCE_BIAS.hypot(share(0)),
            wander: share(2),
            time: sensors::WANDER_TIME_S,
        };
        Some(Self {
            hold: Hold::Vision,
            step,
            noise_model,
            attitude: AttitudeLoop::new(derivatives)?,
            position: [0, 1].map(|_| AxisFilter::new(noise_model, step, time, 0.0, [0.05, 0.1])),
            vertical: AxisFilter::new(noise_model, step, time, -height, [0.5, 0.1]),
            drag: Vector2::zeros(),
            tilt: Vector2::zeros(),
            heave: 0.0,
            downward: 0.0,
            weight: 1.0,
            newest: time,
        })
    }

    /// Makes the position at `time` (s), which is now, the one to hold.
    pub fn engage(&mut self, time: f64) {
        self.position = [0, 1].map(|_| AxisFilter::new(self.noise_model, self.step, time, 0.0, [0.05, 0.1]));
        self.newest = time;
    }

    /// Sets the source of the position that is held.
    pub fn set_hold(&mut self, hold: Hold) {
        self.hold = hold;
    }

    /// Applies a fix. A position or velocity that is not a finite number is ignored, and so is a velocity without one.
    pub fn apply_fix(&mut self, fix: &Fix) {
        let is_finite = |value: &Vector2<f64>, covariance: &Matrix2<f64>| {
            value.iter().chain(covariance).all(|element| element.is_finite())
        };
        if self.hold == Hold::ImuOnly || !is_finite(&fix.displacement, &fix.covariance) {
            return;
        }
        let known = fix.velocity.filter(|(velocity, covariance)| is_finite(velocity, covariance));
        for (i, axis) in self.position.iter_mut().enumerate() {
            let reading = |value: &Vector2<f64>, covariance: &Matrix2<f64>, error: f64| Reading {
                value: value[i],
                variance: covariance[(i, i)].max(error * error),
            };
            let position = reading(&fix.displacement, &fix.covariance, MIN_ERRORS_M[0]);
            let velocity = known.map(|(velocity, covariance)| reading(&velocity, &covariance, MIN_VELOCITY_ERROR_M_S));
            axis.correct(fix.exposed, position, velocity);
        }
        self.newest = self.newest.max(fix.exposed);
    }

    /// Applies a reading of the barometer (m) at a time (s). The laser is not used for height: its beam sweeps over
    /// hills and roofs, and the helicopter would climb and sink with every tilt.
    pub fn apply_height(&mut self, time: f64, height: f64) {
        self.vertical.correct(time, Reading { value: -height, variance: MIN_ERRORS_M[1] * MIN_ERRORS_M[1] }, None);
    }

    /// Returns the estimated displacement from the held position, m.
    pub fn position(&self) -> Vector2<f64> {
        Vector2::new(self.position[0].position(), self.position[1].position())
    }

    /// Returns the weight of the position loop's tilt: 1 while it holds the position, 0 in attitude hold.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Advances by one step to `time` (s) and returns the blade angles from trim (rad). `height` is the commanded
    /// height (m) and climb rate (m/s).
    pub fn advance(&mut self, time: f64, inertial: &Inertial, height: [f64; 2]) -> Vector4<f64> {
        let Inertial { attitude, rates, force } = *inertial;
        let acceleration = attitude.rotation() * force + Vector3::new(0.0, 0.0, GRAVITY);
        for (axis, acceleration) in self.position.iter_mut().zip(acceleration.iter()) {
            axis.advance(*acceleration);
        }
        self.vertical.advance(acceleration.z);

        let holds = self.hold == Hold::ImuOnly || time - self.newest <= COAST_S;
        let target = if holds { 1.0 } else { 0.0 };
        let max_change = self.step / FADE_S;
        self.weight += (target - self.weight).clamp(-max_change, max_change);

        let wanted = self.wanted_tilt(attitude.yaw, &force) * self.weight;
        let max_change = MAX_TILT_RATE * self.step;
        self.tilt += (wanted - self.tilt).map(|change| change.clamp(-max_change, max_change));

        // The attitude loop uses forward, right, down: roll and pitch change their sign and their axis.
        let error = Vector3::new(attitude.roll - self.tilt.x, attitude.pitch - self.tilt.y, -attitude.yaw);
        let rates = Vector3::new(-rates.y, rates.x, rates.z);
        self.downward = self.wanted_downward(acceleration.z, height);
        self.attitude.blades(&error, &rates, self.downward, self.step)
    }

    /// Returns the roll and pitch to command, rad, in the camera's signs.
    fn wanted_tilt(&mut self, yaw: f64, force: &Vector3<f64>) -> Vector2<f64> {
        let [by_position, by_speed, fastest] = POSITION_LOOP;
        let (sin, cos) = libm::sincos(yaw);
        let to_heading = Matrix2::new(cos, sin, -sin, cos);
        self.drag += (force.xy() - self.drag) * (self.step / DRAG_TIME_S);
        let along = |value: fn(&AxisFilter) -> f64| {
            to_heading * Vector2::new(value(&self.position[0]), value(&self.position[1]))
        };
        let speed = along(AxisFilter::position).map(|error| (-by_position * error).clamp(-fastest, fastest));
        let acceleration = (speed - along(AxisFilter::velocity)) * by_speed;
        let tilt = (self.drag + along(AxisFilter::correction) - acceleration) / GRAVITY;
        tilt.map(|angle| angle.clamp(-MAX_TILT, MAX_TILT))
    }

    /// Returns the downward acceleration to command, m/s^2, for the measured one.
    fn wanted_downward(&mut self, measured: f64, [height, climb]: [f64; 2]) -> f64 {
        let [by_error, by_speed, fastest, strongest] = HEIGHT_LOOP;
        let gust = measured + self.vertical.correction() - self.downward;
        self.heave += (gust - self.heave) * (self.step / HEAVE_TIME_S);
        let speed = (-by_error * (self.vertical.position() + height)).clamp(-fastest, fastest) - climb;
        let acceleration = (speed - self.vertical.velocity()) * by_speed;
        acceleration.clamp(-strongest, strongest) - self.heave
    }
}

#[cfg(test)]
mod tests {
    use super::attitude::tests::{loops, margins};
    use super::*;
    use nalgebra::Complex;

    /// `tilt -> -g tilt -> v -> x` with the attitude loop in series: at least 40 degrees and 9 dB.
    #[test]
    fn the_position_loop_has_margins() {
        let [by_position, by_speed, _] = POSITION_LOOP;
        for axis in [0, 1] {
            let open =
                |s: Complex<f64>| (s + by_position) * by_speed / (s * s) * loops(axis, s)[1] * (-s * 0.0075).exp();
            let [phase, gain] = margins(open);
            let found = format!("axis {axis}: {phase:.1} degrees, {gain:.1} dB");
            eprintln!("{found}");
            assert!(phase > 40.0 && gain > 9.0, "{found}");
        }
    }
}
