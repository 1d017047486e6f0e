//! What the helicopter knows of itself: an inertial sensor with an attitude of its own, and a laser rangefinder on the
//! optical axis.
//!
//! **Attitude.** `reading(t) = truth(t - latency) + bias + misalignment + wander(t) + white(t)`, for roll, pitch and
//! yaw. The one root mean square asked for is shared out by variance, see [`SHARES`]: over many flights a reading is
//! off by that much, within one flight by the changing part about a constant one. Misalignment turns the sensor in the
//! camera: its rates and its acceleration are turned with it. Bias and wander are errors of the attitude alone.

use crate::random::{Purpose, normal, stream};
use crate::wind::{Component, FirstOrder};
use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Shares of the variance of an attitude error: constant bias, constant misalignment, wander (first order, [`WANDER`]),
/// white noise.
pub const SHARES: [f64; 4] = [0.35, 0.05, 0.35, 0.25];
/// Time constant of the wander, s.
pub const WANDER: f64 = 5.0;
/// Age of a reading, s.
pub const LATENCY: f64 = 0.01;
/// Constant error of an angular rate, rad/s: 0.02 degrees a second; drawn for each axis and flight.
const RATE_BIAS: f64 = 0.02 * std::f64::consts::PI / 180.0;
/// White error of an angular rate, rad/s: 0.05 degrees a second.
const RATE_NOISE: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Constant error of an acceleration, m/s^2: two thousandths of gravity; drawn for each axis and flight.
pub const FORCE_BIAS: f64 = 0.02;
/// White error of an acceleration, m/s^2.
pub const FORCE_NOISE: f64 = 0.05;

/// One reading of the inertial sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    /// Roll, pitch and yaw of the camera.
    pub attitude: Attitude,
    /// Angular velocity about the camera's axes, rad/s.
    pub rates: Vector3<f64>,
    /// Acceleration less gravity, along the camera's axes, m/s^2.
    pub force: Vector3<f64>,
}

/// The inertial sensor.
#[derive(Debug, Clone)]
pub struct Imu {
    /// Roll, pitch, yaw.
    constant: Vector3<f64>,
    /// Turn of the sensor's axes against the camera's, rad about the camera's axes.
    misalignment: Vector3<f64>,
    wander: [FirstOrder; 3],
    white: Vector3<f64>,
    rate_bias: Vector3<f64>,
    force_bias: Vector3<f64>,
    past: VecDeque<Inertial>,
    reading: Inertial,
    random: ChaCha8Rng,
}

fn normals(random: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(random))
}

impl Imu {
    /// The sensor of a flight that starts with `truth`; root mean squares of tilt and heading in rad, steps in s.
    pub fn new(tilt: f64, heading: f64, truth: &Inertial, seed: u64, step: f64) -> Self {
        let mut random = stream(seed, Purpose::Imu);
        let rms = Vector3::new(tilt, tilt, heading);
        let share = |i: usize| rms * SHARES[i].sqrt();
        let mut drawn = |rms: Vector3<f64>| normals(&mut random).component_mul(&rms);
        let constant = drawn(share(0));
        let misalignment = drawn(share(1));
        let rate_bias = drawn(Vector3::repeat(RATE_BIAS));
        let force_bias = drawn(Vector3::repeat(FORCE_BIAS));
        let wander = [0, 1, 2].map(|axis| {
            let component = Component { rms: share(2)[axis], time: WANDER };
            FirstOrder::new(component, step, &mut random)
        });
        let age = (LATENCY / step).round() as usize;
        let past = std::iter::repeat_n(*truth, age).collect();
        let white = share(3);
        let mut imu =
            Self { constant, misalignment, wander, white, rate_bias, force_bias, past, reading: *truth, random };
        imu.advance(truth);
        imu
    }

    /// One step on, to a moment when `truth` is so.
    pub fn advance(&mut self, truth: &Inertial) {
        self.past.push_back(*truth);
        let Some(Inertial { attitude, rates, force }) = self.past.pop_front() else { return };
        self.wander.iter_mut().for_each(|wander| wander.advance(&mut self.random));
        let wander = Vector3::from_fn(|i, _| self.wander[i].value());
        let turn = self.misalignment;
        // Tilt of the sensor's axis towards X is a turn about y; towards Y, one about x the other way.
        let turned = Vector3::new(turn.y, -turn.x, turn.z);
        let error = self.constant + turned + wander + normals(&mut self.random).component_mul(&self.white);
        self.reading = Inertial {
            attitude: Attitude {
                roll: attitude.roll + error.x,
                pitch: attitude.pitch + error.y,
                yaw: attitude.yaw + error.z,
            },
            rates: rates - turn.cross(&rates) + self.rate_bias + normals(&mut self.random) * RATE_NOISE,
            force: force - turn.cross(&force) + self.force_bias + normals(&mut self.random) * FORCE_NOISE,
        };
    }

    /// The newest reading.
    pub fn reading(&self) -> &Inertial {
        &self.reading
    }
}

/// The laser rangefinder.
#[derive(Debug, Clone)]
pub struct Laser {
    noise: f64,
    random: ChaCha8Rng,
}

impl Laser {
    /// With a root mean square of noise, m.
    pub fn new(noise: f64, seed: u64) -> Self {
        Self { noise, random: stream(seed, Purpose::Laser) }
    }

    /// What it reads at a true range, m.
    pub fn read(&mut self, range: f64) -> f64 {
        range + self.noise * normal(&mut self.random)
    }
}
