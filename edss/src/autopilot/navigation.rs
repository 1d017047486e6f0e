//! Where the helicopter is along one axis: a Kalman filter of position, velocity and an acceleration's slow error.
//!
//! ```text
//! dx/dt = v,    dv/dt = a + b,    db/dt = white noise
//! ```
//!
//! `a` is what accelerometer and attitude say, so that the gusts are measured and need no model; `b` is what they are
//! wrong by: bias, and gravity seen through an error of attitude. A position arrives late. The filter keeps what it
//! knew at each step of the last second, goes back to when the position was true, corrects there, and comes forward
//! again over the accelerations it has kept: the same numbers as if the position had come at once.

use nalgebra::{Matrix3, Vector3};
use std::collections::VecDeque;

/// How long the past is kept, s.
pub const MEMORY: f64 = 1.0;

/// What the filter is told about its input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// White noise of an acceleration, m/s^2 in one step.
    pub white: f64,
    /// Constant part of its error, root mean square, m/s^2.
    pub constant: f64,
    /// Root mean square of its wander, m/s^2.
    pub wander: f64,
    /// Time constant of the wander, s.
    pub time: f64,
}

#[derive(Debug, Clone, Copy)]
struct Moment {
    time: f64,
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Acceleration from here to the next moment.
    acceleration: f64,
}

/// The filter.
#[derive(Debug, Clone)]
pub struct Axis {
    quality: Quality,
    step: f64,
    now: Moment,
    past: VecDeque<Moment>,
}

impl Axis {
    /// At a position, standing still, each with its standard error (m, m/s).
    pub fn new(quality: Quality, step: f64, time: f64, position: f64, error: [f64; 2]) -> Self {
        let Quality { constant, wander, .. } = quality;
        let variances = Vector3::new(error[0] * error[0], error[1] * error[1], constant * constant + wander * wander);
        let now = Moment {
            time,
            mean: Vector3::new(position, 0.0, 0.0),
            covariance: Matrix3::from_diagonal(&variances),
            acceleration: 0.0,
        };
        Self { quality, step, now, past: VecDeque::new() }
    }

    /// Position, m.
    pub fn position(&self) -> f64 {
        self.now.mean.x
    }

    /// Velocity, m/s.
    pub fn velocity(&self) -> f64 {
        self.now.mean.y
    }

    /// What the accelerations are wrong by, m/s^2: to be added to them.
    pub fn correction(&self) -> f64 {
        self.now.mean.z
    }

    /// One step on with a measured acceleration, m/s^2.
    pub fn advance(&mut self, acceleration: f64) {
        self.now.acceleration = acceleration;
        self.past.push_back(self.now);
        if self.past.len() as f64 * self.step > MEMORY {
            self.past.pop_front();
        }
        self.now = self.next(&self.now);
    }

    fn next(&self, from: &Moment) -> Moment {
        let h = self.step;
        let Quality { white, wander, time, .. } = self.quality;
        let transition = Matrix3::new(1.0, h, h * h / 2.0, 0.0, 1.0, h, 0.0, 0.0, 1.0);
        let mut covariance = transition * from.covariance * transition.transpose();
        covariance[(1, 1)] += white * white * h * h;
        covariance[(2, 2)] += 2.0 * wander * wander * h / time;
        let driven = Vector3::new(h * h / 2.0, h, 0.0) * from.acceleration;
        Moment { time: from.time + h, mean: transition * from.mean + driven, covariance, acceleration: 0.0 }
    }

    /// A position (m) that was true at a time (s), with its variance (m^2). What is older than the filter's memory is
    /// left aside.
    pub fn correct(&mut self, time: f64, position: f64, variance: f64) {
        let half = self.step / 2.0;
        if time > self.now.time - half {
            Self::weigh(&mut self.now, position, variance);
            return;
        }
        let Some(back) = self.past.iter().rposition(|moment| moment.time <= time + half) else { return };
        if self.past[back].time < time - half {
            return;
        }
        Self::weigh(&mut self.past[back], position, variance);
        for i in back + 1..self.past.len() {
            let acceleration = self.past[i].acceleration;
            self.past[i] = Moment { acceleration, ..self.next(&self.past[i - 1]) };
        }
        let last = self.past[self.past.len() - 1];
        self.now = self.next(&last);
    }

    fn weigh(moment: &mut Moment, position: f64, variance: f64) {
        let covariance = moment.covariance;
        let gain = covariance.column(0) / (covariance[(0, 0)] + variance);
        moment.mean += gain * (position - moment.mean.x);
        let kept = Matrix3::identity() - gain * Vector3::x().transpose();
        // Joseph's form stays symmetric and positive.
        moment.covariance = kept * covariance * kept.transpose() + gain * gain.transpose() * variance;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, normal, stream};

    const STEP: f64 = 0.005;
    const QUALITY: Quality = Quality { white: 1.0, constant: 0.03, wander: 0.02, time: 5.0 };

    fn axis() -> Axis {
        Axis::new(QUALITY, STEP, 0.0, 0.0, [0.05, 0.1])
    }

    /// A position that comes late leaves the same numbers as one that came at once.
    #[test]
    fn a_late_position_counts_as_if_it_had_come_at_once() {
        let mut random = stream(1, Purpose::Imu);
        let accelerations: Vec<f64> = (0..400).map(|_| normal(&mut random)).collect();
        let (mut prompt, mut late) = (axis(), axis());
        for (step, acceleration) in accelerations.iter().enumerate() {
            // Every 13th step; they come 20 steps late, when another was exposed meanwhile.
            if step % 13 == 0 {
                prompt.correct(step as f64 * STEP, 0.1 * step as f64, 4e-4);
            }
            if let Some(exposed) = step.checked_sub(20).filter(|exposed| exposed % 13 == 0) {
                late.correct(exposed as f64 * STEP, 0.1 * exposed as f64, 4e-4);
            }
            prompt.advance(*acceleration);
            late.advance(*acceleration);
        }
        // Those that have not come yet.
        for exposed in (380..400).filter(|exposed| exposed % 13 == 0) {
            late.correct(f64::from(exposed) * STEP, 0.1 * f64::from(exposed), 4e-4);
        }
        assert!((late.now.mean - prompt.now.mean).norm() < 1e-12, "{:?} {:?}", late.now, prompt.now);
        assert!((late.now.covariance - prompt.now.covariance).norm() < 1e-12);
    }

    /// Fed as it is told, its errors are those it states: the mean of the squared error over its covariance is 3. 400
    /// runs know it to 0.12; four times that is allowed.
    #[test]
    fn the_covariance_is_true() {
        let runs = 400;
        let mut sum = 0.0;
        for seed in 0..runs {
            let mut random = stream(seed, Purpose::Imu);
            let mut draw = |rms: f64| rms * normal(&mut random);
            let mut axis = axis();
            let start = QUALITY.constant.hypot(QUALITY.wander);
            let mut truth = Vector3::new(draw(0.05), draw(0.1), draw(start));
            let walk = QUALITY.wander * (2.0 * STEP / QUALITY.time).sqrt();
            for step in 0..600 {
                if step % 13 == 0 {
                    axis.correct(f64::from(step) * STEP, truth.x + draw(0.02), 4e-4);
                }
                // The acceleration is 0: what is measured is the error.
                let (noise, told) = (draw(QUALITY.white), 0.3);
                axis.advance(told);
                let driven = told + truth.z;
                truth.x += STEP * truth.y + STEP * STEP / 2.0 * driven;
                truth.y += STEP * (driven + noise);
                truth.z += draw(walk);
            }
            let error = axis.now.mean - truth;
            sum += error.dot(&(axis.now.covariance.try_inverse().unwrap() * error));
        }
        let normalised = sum / runs as f64;
        assert!((2.5..3.5).contains(&normalised), "{normalised}");
    }

    #[test]
    fn what_is_older_than_the_memory_is_left_aside() {
        let mut axis = axis();
        (0..400).for_each(|_| axis.advance(0.1));
        let before = axis.now.mean;
        axis.correct(0.5, 10.0, 1e-4);
        assert_eq!(axis.now.mean, before);
        axis.correct(1.5, 10.0, 1e-4);
        assert!(axis.position() > 9.0, "{}", axis.position());
    }
}
