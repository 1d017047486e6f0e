//! Navigation along one axis: a Kalman filter of position, velocity and the slow error of the acceleration.
//!
//! ```text
//! dx/dt = v,    dv/dt = a + b,    db/dt = white noise
//! ```
//!
//! `a` is measured by accelerometer and attitude sensor, so that gusts need no model; `b` is the error of that: bias,
//! and gravity by an error of attitude. A fix of position, and of velocity if it has one, arrives late. The filter
//! keeps its states of the last second. It applies a fix to the state at the time of the fix and repeats the later
//! steps with the stored accelerations. The result is the same as if the fix had arrived immediately.

use nalgebra::{Matrix3, Vector3};
use std::collections::VecDeque;

/// Time for which earlier states are kept.
const HISTORY_S: f64 = 1.0;

/// The noise model of the acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccelerationNoise {
    /// Rms of the white noise in one step, m/s^2.
    pub white: f64,
    /// Rms of the constant error, m/s^2.
    pub constant: f64,
    /// Rms of the wander, m/s^2.
    pub wander: f64,
    /// Time constant of the wander, s.
    pub time: f64,
}

/// A measured position (m) or velocity (m/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// In m or m/s.
    pub value: f64,
    /// In m^2 or m^2/s^2.
    pub variance: f64,
}

/// The state of the filter at one time.
#[derive(Debug, Clone, Copy)]
struct FilterState {
    time: f64,
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Acceleration from here to the next state.
    acceleration: f64,
}

impl FilterState {
    /// Updates by a reading of element `i` of the mean.
    fn correct(&mut self, i: usize, reading: Reading) {
        let covariance = self.covariance;
        let gain = covariance.column(i) / (covariance[(i, i)] + reading.variance);
        self.mean += gain * (reading.value - self.mean[i]);
        let mut kept = Matrix3::identity();
        kept.column_mut(i).axpy(-1.0, &gain, 1.0);
        // Joseph's form stays symmetric and positive.
        self.covariance = kept * covariance * kept.transpose() + gain * gain.transpose() * reading.variance;
    }
}

/// A Kalman filter for one axis.
#[derive(Debug, Clone)]
pub struct AxisFilter {
    noise_model: AccelerationNoise,
    step: f64,
    now: FilterState,
    past: VecDeque<FilterState>,
}

impl AxisFilter {
    /// Creates a filter at a position (m) and velocity 0, with the standard errors `error` (m, m/s).
    pub fn new(noise_model: AccelerationNoise, step: f64, time: f64, position: f64, error: [f64; 2]) -> Self {
        let AccelerationNoise { constant, wander, .. } = noise_model;
        let variances = Vector3::new(error[0] * error[0], error[1] * error[1], constant * constant + wander * wander);
        let now = FilterState {
            time,
            mean: Vector3::new(position, 0.0, 0.0),
            covariance: Matrix3::from_diagonal(&variances),
            acceleration: 0.0,
        };
        Self { noise_model, step, now, past: VecDeque::new() }
    }

    /// Returns the position, m.
    pub fn position(&self) -> f64 {
        self.now.mean.x
    }

    /// Returns the velocity, m/s.
    pub fn velocity(&self) -> f64 {
        self.now.mean.y
    }

    /// Returns the estimate of `b`, m/s^2, which the measured acceleration lacks.
    pub fn correction(&self) -> f64 {
        self.now.mean.z
    }

    /// Advances by one step with a measured acceleration, m/s^2.
    pub fn advance(&mut self, acceleration: f64) {
        self.now.acceleration = acceleration;
        self.past.push_back(self.now);
        if self.past.len() as f64 * self.step > HISTORY_S {
            self.past.pop_front();
        }
        self.now = self.next(&self.now);
    }

    fn next(&self, from: &FilterState) -> FilterState {
        let h = self.step;
        let AccelerationNoise { white, wander, time, .. } = self.noise_model;
        let transition = Matrix3::new(1.0, h, h * h / 2.0, 0.0, 1.0, h, 0.0, 0.0, 1.0);
        let mut covariance = transition * from.covariance * transition.transpose();
        covariance[(1, 1)] += white * white * h * h;
        covariance[(2, 2)] += 2.0 * wander * wander * h / time;
        let driven = Vector3::new(h * h / 2.0, h, 0.0) * from.acceleration;
        FilterState { time: from.time + h, mean: transition * from.mean + driven, covariance, acceleration: 0.0 }
    }

    /// Applies a fix: position, and velocity if it is known, at a time (s). A fix older than [`HISTORY_S`] is ignored.
    pub fn correct(&mut self, time: f64, position: Reading, velocity: Option<Reading>) {
        let update = |state: &mut FilterState| {
            state.correct(0, position);
            if let Some(velocity) = velocity {
                state.correct(1, velocity);
            }
        };
        let half = self.step / 2.0;
        if time > self.now.time - half {
            update(&mut self.now);
            return;
        }
        let Some(back) = self.past.iter().rposition(|state| state.time <= time + half) else { return };
        if self.past[back].time < time - half {
            return;
        }
        update(&mut self.past[back]);
        for i in back + 1..self.past.len() {
            let acceleration = self.past[i].acceleration;
            self.past[i] = FilterState { acceleration, ..self.next(&self.past[i - 1]) };
        }
        let last = self.past[self.past.len() - 1];
        self.now = self.next(&last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, normal, stream};

    const STEP: f64 = 0.005;
    const NOISE: AccelerationNoise = AccelerationNoise { white: 1.0, constant: 0.03, wander: 0.02, time: 5.0 };

    fn axis() -> AxisFilter {
        AxisFilter::new(NOISE, STEP, 0.0, 0.0, [0.05, 0.1])
    }

    #[test]
    fn a_late_fix_has_the_effect_of_an_immediate_one() {
        let mut random = stream(1, Purpose::Imu);
        let accelerations: Vec<f64> = (0..400).map(|_| normal(&mut random)).collect();
        let (mut prompt, mut late) = (axis(), axis());
        let at = |step: usize| Reading { value: 0.1 * step as f64, variance: 4e-4 };
        // Every second fix has a velocity.
        let velocity = |step: usize| step.is_multiple_of(2).then_some(Reading { value: 20.0, variance: 1e-4 });
        for (step, acceleration) in accelerations.iter().enumerate() {
            // A fix every 13th step, 20 steps late, so that fixes overlap.
            if step % 13 == 0 {
                prompt.correct(step as f64 * STEP, at(step), velocity(step));
            }
            if let Some(exposed) = step.checked_sub(20).filter(|exposed| exposed % 13 == 0) {
                late.correct(exposed as f64 * STEP, at(exposed), velocity(exposed));
            }
            prompt.advance(*acceleration);
            late.advance(*acceleration);
        }
        // The fixes that are still missing.
        for exposed in (380..400usize).filter(|exposed| exposed % 13 == 0) {
            late.correct(exposed as f64 * STEP, at(exposed), velocity(exposed));
        }
        assert!((late.now.mean - prompt.now.mean).norm() < 1e-12, "{:?} {:?}", late.now, prompt.now);
        assert!((late.now.covariance - prompt.now.covariance).norm() < 1e-12);
    }

    /// With noise as modelled, the mean of the squared error over its covariance is 3. With 400 runs its standard error
    /// is 0.12; four times that is allowed.
    #[test]
    fn the_covariance_is_consistent() {
        for has_velocity in [false, true] {
            let normalised = mean_normalised_squared_error(400, has_velocity);
            assert!((2.5..3.5).contains(&normalised), "{normalised}");
        }
    }

    fn mean_normalised_squared_error(runs: u64, has_velocity: bool) -> f64 {
        let mut sum = 0.0;
        for seed in 0..runs {
            let mut random = stream(seed, Purpose::Imu);
            let mut draw = |rms: f64| rms * normal(&mut random);
            let mut axis = axis();
            let start = NOISE.constant.hypot(NOISE.wander);
            let mut truth = Vector3::new(draw(0.05), draw(0.1), draw(start));
            let walk = NOISE.wander * (2.0 * STEP / NOISE.time).sqrt();
            for step in 0..600 {
                if step % 13 == 0 {
                    let position = Reading { value: truth.x + draw(0.02), variance: 4e-4 };
                    let velocity = Reading { value: truth.y + draw(0.03), variance: 9e-4 };
                    axis.correct(f64::from(step) * STEP, position, has_velocity.then_some(velocity));
                }
                // The acceleration is 0: what is measured is the error.
                let (noise, measured) = (draw(NOISE.white), 0.3);
                axis.advance(measured);
                let driven = measured + truth.z;
                truth.x += STEP * truth.y + STEP * STEP / 2.0 * driven;
                truth.y += STEP * (driven + noise);
                truth.z += draw(walk);
            }
            let error = axis.now.mean - truth;
            sum += error.dot(&(axis.now.covariance.try_inverse().unwrap() * error));
        }
        sum / runs as f64
    }

    #[test]
    fn a_fix_older_than_the_history_is_ignored() {
        let mut axis = axis();
        (0..400).for_each(|_| axis.advance(0.1));
        let before = axis.now.mean;
        let far = Reading { value: 10.0, variance: 1e-4 };
        axis.correct(0.5, far, None);
        assert_eq!(axis.now.mean, before);
        axis.correct(1.5, far, None);
        assert!(axis.position() > 9.0, "{}", axis.position());
    }
}
