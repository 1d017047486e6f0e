//! Where the helicopter is along one axis: a Kalman filter of position, velocity and an acceleration's slow error.
//!
//! ```text
//! dx/dt = v,    dv/dt = a + b,    db/dt = white noise
//! ```
//!
//! `a` is what accelerometer and attitude say, so that the gusts are measured and need no model; `b` is what they are
//! wrong by: bias, and gravity seen through an error of attitude. A position arrives late. The filter keeps what it knew
//! at each step of the last second, goes back to when the position was true, corrects there, and comes forward again
//! over the accelerations it has kept: the same numbers as if the position had come at once.

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
