//! The autopilot: it holds attitude, heading, height and place.
//!
//! | loop | from | at |
//! |---|---|---|
//! | attitude ([`attitude`]) | inertial sensor | every step |
//! | heading | its yaw | every step |
//! | height | barometer; accelerometer between | every step |
//! | place | vision's displacement, late; accelerometer and attitude between ([`navigation`]) | every step |
//!
//! **Place.** With the estimated position `e` and velocity `v` over the ground, and `d` the acceleration that is not
//! from tilt (the gust's drag, as the accelerometer feels it, and what the attitude is wrong by, as the filter found):
//!
//! ```text
//! a = K_v (limit(-K_x e) - v),    tilt = (d - a) / g
//! ```
//!
//! Height is held in the same way, `d` being the downward acceleration that the blades were not asked for.
//!
//! **Without fixes** it flies on by the inertial sensor for [`COAST`], then holds a level attitude: the weight of the
//! place loop's tilt runs from 1 to 0 within [`FADE`], and back when fixes return, so that no command jumps.

pub mod attitude;
pub mod navigation;

use crate::aircraft::GRAVITY;
use crate::aircraft::lynx::Derivatives;
use crate::sensors::{self, Inertial};
use attitude::AttitudeLoop;
use nalgebra::{Matrix2, Vector2, Vector3, Vector4};
use navigation::{Axis, Quality};

/// How long the place is held without a fix, s.
pub const COAST: f64 = 1.0;
/// How long the place loop takes to let go and to take hold again, s.
pub const FADE: f64 = 2.0;
/// Largest tilt the place loop asks for, rad: 3.5 degrees, so that gusts and overshoot leave it within 5.
pub const TILT: f64 = 3.5 * std::f64::consts::PI / 180.0;

/// `K_x` (1/s), `K_v` (1/s) and the speed towards the place that is never exceeded (m/s).
const PLACE: [f64; 3] = [0.8, 1.8, 0.7];
/// Largest rate of the tilt command, rad/s: 15 degrees a second.
const TILT_RATE: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Time constant in which the drag is felt, s.
const DRAG: f64 = 0.3;
/// `K_z` (1/s), `K_w` (1/s), the climb rate (m/s) and the vertical acceleration (m/s^2) that are never exceeded.
const HEIGHT: [f64; 4] = [0.8, 2.0, 2.5, 1.5];
/// Time constant in which a vertical gust is felt, s.
const HEAVE: f64 = 0.5;
/// Standard errors of a vision fix and of a reading of the barometer are never taken for less, m.
const LEAST_ERROR: [f64; 2] = [0.005, 0.2];

/// From what the place is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// Vision's fixes.
    #[default]
    Vision,
    /// The inertial sensor alone; fixes are not looked at.
    ImuOnly,
}

/// What vision says of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// From the reference to the camera along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// Its covariance, m^2; the two axes are filtered apart, by the diagonal.
    pub covariance: Matrix2<f64>,
    /// Height that vision found, m. The loops do not use it.
    pub height: Option<f64>,
    /// Yaw that vision found, rad. The loops do not use it.
    pub yaw: Option<f64>,
    /// When the frame was exposed, s.
    pub exposed: f64,
}

/// The autopilot of one flight.
#[derive(Debug, Clone)]
pub struct Autopilot {
    hold: Hold,
    step: f64,
    quality: Quality,
    attitude: AttitudeLoop,
    place: [Axis; 2],
    vertical: Axis,
    drag: Vector2<f64>,
    tilt: Vector2<f64>,
    heave: f64,
    downward: f64,
    weight: f64,
    newest: f64,
}

impl Autopilot {
    /// At a height (m) at a time (s), for an inertial sensor of a tilt error (rad); none where the aircraft cannot be
    /// commanded.
    pub fn new(derivatives: &Derivatives, tilt: f64, height: f64, time: f64, step: f64) -> Option<Self> {
        let share = |i: usize| GRAVITY * tilt * sensors::SHARES[i].sqrt();
        let quality = Quality {
            white: sensors::FORCE_NOISE.hypot(share(3)),
            constant: sensors::FORCE_BIAS.hypot(share(0)),
            wander: share(2),
            time: sensors::WANDER,
        };
        Some(Self {
            hold: Hold::Vision,
            step,
            quality,
            attitude: AttitudeLoop::new(derivatives)?,
            place: [0, 1].map(|_| Axis::new(quality, step, time, 0.0, [0.05, 0.1])),
            vertical: Axis::new(quality, step, time, -height, [0.5, 0.1]),
            drag: Vector2::zeros(),
            tilt: Vector2::zeros(),
            heave: 0.0,
            downward: 0.0,
            weight: 1.0,
            newest: time,
        })
    }

    /// The place to be held is where the helicopter is now, s.
    pub fn engage(&mut self, time: f64) {
        self.place = [0, 1].map(|_| Axis::new(self.quality, self.step, time, 0.0, [0.05, 0.1]));
        self.newest = time;
    }

    /// From what the place is held from now on.
    pub fn set_hold(&mut self, hold: Hold) {
        self.hold = hold;
    }

    /// A fix. One that is no number is left aside.
    pub fn take(&mut self, fix: &Fix) {
        if self.hold == Hold::ImuOnly || !fix.displacement.iter().all(|along| along.is_finite()) {
            return;
        }
        for (i, axis) in self.place.iter_mut().enumerate() {
            let variance = fix.covariance[(i, i)].max(LEAST_ERROR[0] * LEAST_ERROR[0]);
            axis.correct(fix.exposed, fix.displacement[i], variance);
        }
        self.newest = self.newest.max(fix.exposed);
    }

    /// A reading of the barometer, m, at a time, s. Height is not the laser's: its beam sweeps over hills and roofs,
    /// and a helicopter that followed it would climb and sink with every tilt.
    pub fn height(&mut self, time: f64, height: f64) {
        self.vertical.correct(time, -height, LEAST_ERROR[1] * LEAST_ERROR[1]);
    }

    /// Where it believes to be, from the place it holds, m.
    pub fn position(&self) -> Vector2<f64> {
        Vector2::new(self.place[0].position(), self.place[1].position())
    }

    /// How much of the tilt is the place loop's: 1 while it holds the place, 0 in attitude hold.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Blade angles from trim (rad) at a time (s), for a wanted height (m) and its rate of climb (m/s).
    pub fn advance(&mut self, time: f64, inertial: &Inertial, height: [f64; 2]) -> Vector4<f64> {
        let Inertial { attitude, rates, force } = *inertial;
        let acceleration = attitude.rotation() * force + Vector3::new(0.0, 0.0, GRAVITY);
        for (axis, acceleration) in self.place.iter_mut().zip(acceleration.iter()) {
            axis.advance(*acceleration);
        }
        self.vertical.advance(acceleration.z);

        let holds = self.hold == Hold::ImuOnly || time - self.newest <= COAST;
        let target = if holds { 1.0 } else { 0.0 };
        let most = self.step / FADE;
        self.weight += (target - self.weight).clamp(-most, most);

        let wanted = self.wanted_tilt(attitude.yaw, &force) * self.weight;
        let most = TILT_RATE * self.step;
        self.tilt += (wanted - self.tilt).map(|change| change.clamp(-most, most));

        // Forward, right and down: the signs of roll and pitch, and of the axis they are about, change.
        let error = Vector3::new(attitude.roll - self.tilt.x, attitude.pitch - self.tilt.y, -attitude.yaw);
        let rates = Vector3::new(-rates.y, rates.x, rates.z);
        self.downward = self.wanted_downward(acceleration.z, height);
        self.attitude.blades(&error, &rates, self.downward, self.step)
    }

    /// Roll and pitch, in the camera's signs.
    fn wanted_tilt(&mut self, yaw: f64, force: &Vector3<f64>) -> Vector2<f64> {
        let [by_place, by_speed, fastest] = PLACE;
        let (sin, cos) = libm::sincos(yaw);
        let to_heading = Matrix2::new(cos, sin, -sin, cos);
        self.drag += (force.xy() - self.drag) * (self.step / DRAG);
        let along = |value: fn(&Axis) -> f64| to_heading * Vector2::new(value(&self.place[0]), value(&self.place[1]));
        let speed = along(Axis::position).map(|error| (-by_place * error).clamp(-fastest, fastest));
        let acceleration = (speed - along(Axis::velocity)) * by_speed;
        let tilt = (self.drag + along(Axis::correction) - acceleration) / GRAVITY;
        tilt.map(|angle| angle.clamp(-TILT, TILT))
    }

    /// What the blades are to add to the downward acceleration, m/s^2, for a measured one.
    fn wanted_downward(&mut self, measured: f64, [height, climb]: [f64; 2]) -> f64 {
        let [by_error, by_speed, fastest, strongest] = HEIGHT;
        let gust = measured + self.vertical.correction() - self.downward;
        self.heave += (gust - self.heave) * (self.step / HEAVE);
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

    /// `tilt -> -g tilt -> v -> x`, the attitude loop between: 41 degrees and 9 dB at least.
    #[test]
    fn the_place_loop_has_margins() {
        let [by_place, by_speed, _] = PLACE;
        for axis in [0, 1] {
            let open = |s: Complex<f64>| (s + by_place) * by_speed / (s * s) * loops(axis, s)[1] * (-s * 0.0075).exp();
            let [phase, gain] = margins(open);
            let told = format!("axis {axis}: {phase:.1} degrees, {gain:.1} dB");
            eprintln!("{told}");
            assert!(phase > 40.0 && gain > 9.0, "{told}");
        }
    }
}
