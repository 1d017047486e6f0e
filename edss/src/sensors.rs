//! The sensors: an inertial sensor that measures attitude, rates and acceleration; a laser rangefinder on the optical
//! axis; a barometer.
//!
//! **Attitude.** `reading(t) = truth(t - latency) + bias + misalignment + wander(t) + white(t)`, for roll, pitch and
//! yaw. The variance asked for is divided among these as in [`VARIANCE_SHARES`]. It is that over many flights: within
//! one flight the error varies about a constant part. Misalignment is a rotation of the sensor relative to the camera
//! and affects rates and acceleration, too. Bias and wander are errors of the attitude alone.

use crate::random::{Purpose, normal, stream};
use crate::wind::{Component, FirstOrder};
use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Shares of the variance of an attitude error: constant bias, constant misalignment, wander (first order,
/// [`WANDER_TIME_S`]), white noise.
pub const VARIANCE_SHARES: [f64; 4] = [0.35, 0.05, 0.35, 0.25];
/// Time constant of the wander.
pub const WANDER_TIME_S: f64 = 5.0;
/// Age of a reading of the inertial sensor.
pub const LATENCY_S: f64 = 0.01;
/// Rms constant error of an angular rate, rad/s: 0.02 degrees a second; drawn for each axis and flight.
const RATE_BIAS: f64 = 0.02 * std::f64::consts::PI / 180.0;
/// Rms white noise of an angular rate, rad/s: 0.05 degrees a second.
const RATE_NOISE: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Rms constant error of an acceleration, m/s^2: two thousandths of gravity; drawn for each axis and flight.
pub const FORCE_BIAS: f64 = 0.02;
/// Rms white noise of an acceleration, m/s^2.
pub const FORCE_NOISE: f64 = 0.05;

/// A reading of the inertial sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    /// Roll, pitch and yaw of the camera, rad.
    pub attitude: Attitude,
    /// Angular velocity about the camera's axes, rad/s.
    pub rates: Vector3<f64>,
    /// Specific force (acceleration minus gravity) along the camera's axes, m/s^2.
    pub force: Vector3<f64>,
}

/// An inertial sensor with its errors.
#[derive(Debug, Clone)]
pub struct Imu {
    /// Constant errors of roll, pitch, yaw, rad.
    constant: Vector3<f64>,
    /// Rotation of the sensor relative to the camera, rad about the camera's axes.
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
    /// Creates a sensor at the state `truth`, with the rms errors `tilt` and `heading` (rad), for steps of `step`
    /// seconds.
    pub fn new(tilt: f64, heading: f64, truth: &Inertial, seed: u64, step: f64) -> Self {
        let mut random = stream(seed, Purpose::Imu);
        let rms = Vector3::new(tilt, tilt, heading);
        let share = |i: usize| rms * VARIANCE_SHARES[i].sqrt();
        let mut drawn = |rms: Vector3<f64>| normals(&mut random).component_mul(&rms);
        let constant = drawn(share(0));
        let misalignment = drawn(share(1));
        let rate_bias = drawn(Vector3::repeat(RATE_BIAS));
        let force_bias = drawn(Vector3::repeat(FORCE_BIAS));
        let wander = [0, 1, 2].map(|axis| {
            let component = Component { rms: share(2)[axis], time: WANDER_TIME_S };
            FirstOrder::new(component, step, &mut random)
        });
        let age = (LATENCY_S / step).round() as usize;
        let past = std::iter::repeat_n(*truth, age).collect();
        let white = share(3);
        let mut imu =
            Self { constant, misalignment, wander, white, rate_bias, force_bias, past, reading: *truth, random };
        imu.advance(truth);
        imu
    }

    /// Advances by one step to the state `truth`.
    pub fn advance(&mut self, truth: &Inertial) {
        self.past.push_back(*truth);
        let Some(Inertial { attitude, rates, force }) = self.past.pop_front() else { return };
        self.wander.iter_mut().for_each(|wander| wander.advance(&mut self.random));
        let wander = Vector3::from_fn(|i, _| self.wander[i].value());
        let turn = self.misalignment;
        // Roll is a rotation about y, pitch one about x in the opposite sense.
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

    /// Adds to the constant errors of angular rates (rad/s) and specific force (m/s^2).
    pub fn add_bias(&mut self, rates: &Vector3<f64>, force: &Vector3<f64>) {
        self.rate_bias += rates;
        self.force_bias += force;
    }

    /// Returns the latest reading.
    pub fn reading(&self) -> &Inertial {
        &self.reading
    }
}

/// A laser rangefinder with white noise.
#[derive(Debug, Clone)]
pub struct Laser {
    noise: f64,
    random: ChaCha8Rng,
}

impl Laser {
    /// Creates a rangefinder with an rms noise, m.
    pub fn new(noise: f64, seed: u64) -> Self {
        Self { noise, random: stream(seed, Purpose::Laser) }
    }

    /// Returns the reading for a true range, m.
    pub fn read(&mut self, range: f64) -> f64 {
        range + self.noise * normal(&mut self.random)
    }
}

/// Rms drift of the barometer, m, and its time constant, s: weather and the pressure of the rotor.
const BAROMETER_DRIFT: [f64; 2] = [0.3, 60.0];
/// Rms white noise of a reading of the barometer, m.
const BAROMETER_NOISE_M: f64 = 0.1;

/// A barometric altimeter: the true height, a drift (Gauss-Markov, first order) and white noise.
#[derive(Debug, Clone)]
pub struct Barometer {
    drift: f64,
    keep: f64,
    random: ChaCha8Rng,
}

impl Barometer {
    /// Creates an altimeter that is read every `interval` seconds.
    pub fn new(seed: u64, interval: f64) -> Self {
        let mut random = stream(seed, Purpose::Barometer);
        let drift = BAROMETER_DRIFT[0] * normal(&mut random);
        Self { drift, keep: libm::exp(-interval / BAROMETER_DRIFT[1]), random }
    }

    /// Returns the reading for a true height, m.
    pub fn read(&mut self, height: f64) -> f64 {
        let reading = height + self.drift + BAROMETER_NOISE_M * normal(&mut self.random);
        let grown = (1.0 - self.keep * self.keep).sqrt();
        self.drift = self.keep * self.drift + BAROMETER_DRIFT[0] * grown * normal(&mut self.random);
        reading
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over flights the error has the variances of drift and noise together; within a second hardly more than the
    /// noise's. 2000 flights know a standard deviation to 1.6 %.
    #[test]
    fn the_barometer_drifts_slowly() {
        let (mut whole, mut within) = (0.0, 0.0);
        for seed in 0..2000 {
            let mut barometer = Barometer::new(seed, 0.05);
            let first = barometer.read(50.0) - 50.0;
            let last = (0..20).map(|_| barometer.read(50.0) - 50.0).last().unwrap_or(first);
            whole += first * first;
            within += (last - first).powi(2);
        }
        let rms = |sum: f64| (sum / 2000.0f64).sqrt();
        assert!((rms(whole) - 0.1f64.hypot(0.3)).abs() < 0.02, "{}", rms(whole));
        // 2 x 0.1^2, and 2 x 0.3^2 (1 - exp(-1 / 60)).
        assert!((rms(within) - 0.1517).abs() < 0.01, "{}", rms(within));
    }

    const STEP: f64 = 0.005;
    const TILT: f64 = 0.0035;
    const HEADING: f64 = 0.009;

    fn hover() -> Inertial {
        Inertial {
            attitude: Attitude { roll: 0.02, pitch: -0.01, yaw: 0.3 },
            rates: Vector3::zeros(),
            force: Vector3::new(0.1, 0.0, -9.8),
        }
    }

    fn errors(attitude: &Attitude) -> Vector3<f64> {
        let truth = hover().attitude;
        Vector3::new(attitude.roll - truth.roll, attitude.pitch - truth.pitch, attitude.yaw - truth.yaw)
    }

    /// Over flights the whole error has the root mean square asked for; within a flight its changing part has the
    /// shares of wander and white noise. 3000 flights know a variance to 2.6 %; four times that is allowed.
    #[test]
    fn errors_have_the_root_mean_square_asked_for() {
        let (flights, steps) = (3000, 40);
        let (mut whole, mut jumps) = (Vector3::zeros(), Vector3::zeros());
        for seed in 0..flights {
            let mut imu = Imu::new(TILT, HEADING, &hover(), seed, STEP);
            (0..steps).for_each(|_| imu.advance(&hover()));
            let before = errors(&imu.reading().attitude);
            imu.advance(&hover());
            let now = errors(&imu.reading().attitude);
            whole += now.component_mul(&now);
            jumps += (now - before).component_mul(&(now - before));
        }
        for (axis, rms) in [TILT, TILT, HEADING].into_iter().enumerate() {
            let whole = whole[axis] / flights as f64 / (rms * rms);
            assert!((whole - 1.0).abs() < 0.105, "axis {axis}: {whole} of the variance");
            // Two white errors; the wander changes little in a step.
            let expected = 2.0 * VARIANCE_SHARES[3] + 2.0 * VARIANCE_SHARES[2] * STEP / WANDER_TIME_S;
            let jumps = jumps[axis] / flights as f64 / (rms * rms) / expected;
            assert!((jumps - 1.0).abs() < 0.105, "axis {axis}: jumps of {jumps} of their variance");
        }
        assert!((VARIANCE_SHARES.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// The mean over a long flight is its bias and misalignment; what is left wanders with its time constant.
    #[test]
    fn bias_stays_and_wander_forgets() {
        let mut imu = Imu::new(TILT, HEADING, &hover(), 7, STEP);
        let steps = 400_000;
        let readings: Vec<f64> = std::iter::repeat_with(|| {
            imu.advance(&hover());
            errors(&imu.reading().attitude).x
        })
        .take(steps)
        .collect();
        let mean = readings.iter().sum::<f64>() / steps as f64;
        let constant = imu.constant.x + imu.misalignment.y;
        // The wander has 2000 s / (2 * 5 s) free values: 0.59 / sqrt(200) of the root mean square, 0.00015.
        assert!((mean - constant).abs() < 0.0006, "{mean}, constant {constant}");
        let lag = (WANDER_TIME_S / STEP) as usize;
        let product = |lag: usize| {
            let pairs = readings.iter().zip(&readings[lag..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (steps - lag) as f64
        };
        let kept = product(lag) / (TILT * TILT * VARIANCE_SHARES[2]);
        assert!((kept - (-1.0f64).exp()).abs() < 0.25, "{kept} after the time constant");
    }

    /// A misaligned sensor sees the same horizontal acceleration: what its attitude is off by, its axes are.
    #[test]
    fn misalignment_turns_attitude_and_acceleration_together() {
        let mut imu = Imu::new(0.0, 0.0, &hover(), 3, STEP);
        imu.misalignment = Vector3::new(0.002, -0.003, 0.001);
        imu.force_bias = Vector3::zeros();
        let level = |inertial: &Inertial| inertial.attitude.rotation() * inertial.force;
        let mut sum = Vector3::zeros();
        for _ in 0..40_000 {
            imu.advance(&hover());
            sum += level(imu.reading());
        }
        let off = sum / 40_000.0 - level(&hover());
        // 0.003 rad of gravity would be 0.03; second order and the mean of the noise are 0.001.
        assert!(off.norm() < 0.002, "{off}");
        let Attitude { roll, .. } = imu.reading().attitude;
        assert!((roll - hover().attitude.roll + 0.003).abs() < 1e-9);
    }

    #[test]
    fn a_reading_is_as_old_as_the_latency() {
        let mut imu = Imu::new(0.0, 0.0, &hover(), 3, STEP);
        imu.misalignment = Vector3::zeros();
        let turned = |yaw: f64| Inertial { attitude: Attitude { yaw, ..Attitude::default() }, ..hover() };
        let ages = (LATENCY_S / STEP) as usize;
        for step in 0..10 {
            imu.advance(&turned(step as f64));
            let expected = step as f64 - ages as f64;
            assert!(expected < 0.0 || (imu.reading().attitude.yaw - expected).abs() < 1e-12, "step {step}");
        }
    }

    #[test]
    fn the_laser_has_the_noise_asked_for() {
        let mut laser = Laser::new(0.1, 5);
        let errors: Vec<f64> = (0..20_000).map(|_| laser.read(50.0) - 50.0).collect();
        let mean = errors.iter().sum::<f64>() / 2e4;
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / 2e4;
        assert!(mean.abs() < 0.003 && (variance / 0.01 - 1.0).abs() < 0.04, "{mean} {variance}");
    }
}
