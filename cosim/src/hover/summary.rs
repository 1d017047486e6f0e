//! The frames of a hover and their statistics.

use hoverlock_arm::message::Telemetry;
use hoverlock_edss::flight::Row as Truth;
use nalgebra::{Matrix2, Vector2};
use serde::Serialize;

use crate::chain::{FeatureSource, FlightLine, FlightProgram};

/// A frame of a hover.
#[derive(Debug, Clone)]
pub struct Row {
    /// True state at the exposure.
    pub truth: Truth,
    /// True position at the exposure of the reference along `X_e` and `Y_e`, m.
    pub origin: Vector2<f64>,
    /// The line of the flight program.
    pub line: FlightLine,
    /// The readings of the sensors.
    pub telemetry: Telemetry,
    /// Position of the helicopter without vision along `X_e` and `Y_e`, m.
    pub blind: Vector2<f64>,
    /// The frame shows no texture that stays in place.
    pub is_blind: bool,
}

impl Row {
    /// Returns the true position along `X_e` and `Y_e`, m.
    pub fn position(&self) -> Vector2<f64> {
        Vector2::new(self.truth.x, self.truth.y)
    }

    /// Returns the true displacement from the reference along `X_e` and `Y_e`, m.
    pub fn displacement(&self) -> Vector2<f64> {
        self.position() - self.origin
    }

    /// Returns estimate less truth along `X_e` and `Y_e`, m; `None` without an estimate.
    pub fn error(&self) -> Option<Vector2<f64>> {
        Some(self.line.displacement()? - self.displacement())
    }

    /// Returns the normalised squared error, 2 on average if the covariance is true; `None` without an estimate.
    pub fn normalised_squared_error(&self) -> Option<f64> {
        let [xx, xy, yx, yy] = self.line.covariance_m2?;
        let error = self.error()?;
        Some(error.dot(&(Matrix2::new(xx, xy, yx, yy).try_inverse()? * error)))
    }

    /// Returns `true` if the error exceeds the protection level of the estimate.
    pub fn is_misleading(&self) -> bool {
        self.error().zip(self.line.protection_level_m).is_some_and(|(error, level)| error.norm() > level)
    }
}

/// The statistics of a hover. Serialised, they are the JSON object of `hoverlock hover`.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Every check passes.
    pub pass: bool,
    /// Name or file of the scene.
    pub scene: String,
    /// The source of the features.
    pub features: FeatureSource,
    /// The place where the flight program ran.
    #[serde(rename = "estimator")]
    pub flight_program: FlightProgram,
    /// Seed of wind, sensors, camera and scene.
    pub seed: u64,
    /// Duration of the hover, s.
    pub seconds: f64,
    /// Height over the mean ground, m.
    pub height_m: f64,
    /// Rms of each horizontal component of the gusts, m/s.
    pub gusts_m_s: f64,
    /// Rms distance from the target, m.
    pub rms_m: f64,
    /// Largest distance from the target, m.
    pub max_m: f64,
    /// Largest `rms_m` that passes; `None` over water, where no position can be held.
    pub bound_m: Option<f64>,
    /// `rms_m` of the helicopter with its IMU only.
    pub imu_only_rms_m: f64,
    /// `max_m` of the helicopter with its IMU only.
    pub imu_only_max_m: f64,
    /// Rms of estimate less truth, m; `None` without an estimate.
    pub error_rms_m: Option<f64>,
    /// Number of frames.
    pub frames: usize,
    /// Number of frames with an estimate.
    pub estimates: usize,
    /// Share of the frames with an estimate, of those that show the ground, after the first that has one; `None`
    /// without an estimate.
    pub available: Option<f64>,
    /// Number of frames whose error exceeds the protection level of their estimate.
    pub misleading: usize,
    /// Number of frames without an estimate after the first that has one.
    pub lost: usize,
    /// Longest time without an estimate, s.
    pub longest_loss_s: f64,
    /// Number of frames that were the reference.
    pub references: usize,
    /// Largest roll or pitch, degrees.
    pub tilt_max_deg: f64,
    /// Number of clock cycles simulated; `None` without simulated hardware.
    pub cycles: Option<u64>,
    /// Duration of the run, s.
    pub wall_s: f64,
    /// The checks that fail, in words.
    pub reason: Option<String>,
}
