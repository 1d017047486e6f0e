//! Priors of a pose fit and the views that result from it: attitude, height and ground slope with standard errors.

use crate::motion::orthophoto::{Attitude, View};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Standard deviation, m, of the height that the laser hits over relief.
const RELIEF_SIGMA_M: f64 = 3.0;

/// Prior standard deviation of the slope of the ground: 3 degrees.
const SLOPE_SIGMA: f64 = 0.052;

/// Chi squared (two degrees of freedom) of a slope above which the ground is not level; exceeded by chance once in 1000
/// flights.
const MAX_LEVEL_CHI2: f64 = 13.8;

/// The standard errors of one reading of IMU and laser rangefinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorErrors {
    /// Standard error of roll and of pitch of the IMU, radians.
    pub tilt: f64,
    /// Standard error of the yaw of the IMU, radians.
    pub heading: f64,
    /// Standard error of the range of the laser, m.
    pub range: f64,
}

/// The standard errors of attitude and height of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewErrors {
    /// Standard error of roll and of pitch, radians.
    pub tilt: f64,
    /// Standard error of the yaw, radians.
    pub heading: f64,
    /// Standard error of the height if the ground is a level plane, m.
    pub plane_height: f64,
    /// Standard error of the height over the mean of the ground if the ground has relief, m.
    pub relief_height: f64,
}

impl From<SensorErrors> for ViewErrors {
    /// Converts the standard errors of a single reading. Over relief the laser may hit any hill, so 3 m are added to
    /// the height error (root sum of squares).
    fn from(sensors: SensorErrors) -> Self {
        let SensorErrors { tilt, heading, range } = sensors;
        Self { tilt, heading, plane_height: range, relief_height: range.hypot(RELIEF_SIGMA_M) }
    }
}

/// A view with its standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Camera, attitude and height.
    pub view: View,
    /// Standard errors of attitude and height.
    pub errors: ViewErrors,
}

/// The prior of the ground below REF: the plane `depth + slope . (x, y) = height`, with `depth` and `(x, y)` in metres
/// from the camera, and its covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TerrainPrior {
    /// Height of the camera over the plane, m.
    pub height: f64,
    /// Slope of the plane along `X_e` and `Y_e`, m/m, positive where the ground rises.
    pub slope: Vector2<f64>,
    /// Covariance of height and slope.
    pub covariance: Matrix3<f64>,
    /// `true` if the laser beams of several frames determine the slope; a single beam does not.
    pub slope_is_measured: bool,
}

impl TerrainPrior {
    /// Returns the prior that a single laser reading gives: a level plane whose slope is known to 3 degrees.
    pub fn of(observation: &Observation) -> Self {
        let sigma = observation.errors.relief_height;
        let covariance =
            Matrix3::from_diagonal(&Vector3::new(sigma * sigma, SLOPE_SIGMA * SLOPE_SIGMA, SLOPE_SIGMA * SLOPE_SIGMA));
        Self { height: observation.view.height(), slope: Vector2::zeros(), covariance, slope_is_measured: false }
    }

    /// Returns `true` unless the slope differs significantly from 0.
    pub(super) fn may_be_level(&self) -> bool {
        let covariance = self.covariance.fixed_view::<2, 2>(1, 1).into_owned();
        covariance.try_inverse().is_some_and(|inverse| self.slope.dot(&(inverse * self.slope)) < MAX_LEVEL_CHI2)
    }
}

/// Attitude and height of a view after a fit, with their standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedView {
    /// Roll, pitch and yaw, radians.
    pub attitude: Attitude,
    /// Height over the fitted plane below the camera, m.
    pub height: f64,
    /// The larger standard error of roll and pitch, radians.
    pub tilt: f64,
    /// Standard error of the yaw, radians.
    pub heading: f64,
}
