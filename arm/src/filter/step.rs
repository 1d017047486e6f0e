//! Samples of the IMU with their intervals.

use nalgebra::Vector3;

/// A sample of the IMU with its interval.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// Angular velocity about the camera's axes, rad/s.
    pub rates: Vector3<f64>,
    /// Specific force along the camera's axes, m/s^2.
    pub force: Vector3<f64>,
    /// Duration, s.
    pub seconds: f64,
}

impl Step {
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
