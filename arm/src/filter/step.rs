//! Samples of the IMU with their intervals.

use nalgebra::{Matrix3, Vector3};

/// A sample of the IMU with its interval.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// Angular velocity about the axes of the inertial sensor, rad/s.
    pub rates: Vector3<f64>,
    /// Specific force along the same axes, m/s^2.
    pub force: Vector3<f64>,
    /// Duration, s.
    pub seconds: f64,
}

impl Step {
    /// Returns the step about the axes of a camera; `boresight` is the rotation from them to those of the step.
    pub fn turned(&self, boresight: &Matrix3<f64>) -> Self {
        Self { rates: boresight.tr_mul(&self.rates), force: boresight.tr_mul(&self.force), ..*self }
    }

    /// Returns successive steps as one with their mean; one step is returned as it is.
    pub fn merged(steps: &[Self]) -> Self {
        let [first, rest @ ..] = steps else {
            return Self { rates: Vector3::zeros(), force: Vector3::zeros(), seconds: 0.0 };
        };
        rest.iter().fold(*first, |sum, step| {
            let seconds = sum.seconds + step.seconds;
            let mean = |a: &Vector3<f64>, b: &Vector3<f64>| (a * sum.seconds + b * step.seconds) / seconds;
            Self { rates: mean(&sum.rates, &step.rates), force: mean(&sum.force, &step.force), seconds }
        })
    }
}
