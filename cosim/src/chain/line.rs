//! The lines of the flight program.

use nalgebra::{Matrix2, Vector2};
use serde::Deserialize;

use crate::pages::estimates::Estimate;

/// The keys of a line of the flight program that are used here.
#[derive(Debug, Clone, Deserialize)]
pub struct FlightLine {
    /// `reference`, `estimate`, `late` or `none`.
    pub status: String,
    /// Why there is no estimate.
    pub reason: Option<String>,
    /// Number of the reference frame.
    pub reference: Option<usize>,
    /// Displacement along `X_e`, m.
    pub x_e_m: Option<f64>,
    /// Displacement along `Y_e`, m.
    pub y_e_m: Option<f64>,
    /// Displacement along `Z_e`, m.
    pub z_e_m: Option<f64>,
    /// Turn about the vertical since the reference, rad.
    pub yaw_rad: Option<f64>,
    /// Covariance of the displacement: xx, xy, yx, yy, m^2.
    pub covariance_m2: Option<[f64; 4]>,
    /// Velocity of the camera along `X_e`, `Y_e` and `Z_e`, m/s.
    pub velocity_m_s: Option<[f64; 3]>,
    /// Covariance of the velocity, row by row, m^2/s^2.
    pub velocity_covariance_m2_s2: Option<[f64; 9]>,
    /// Protection level, m.
    pub protection_level_m: Option<f64>,
    /// Quality, 0 to 255.
    pub quality: Option<u8>,
    /// Number of inliers.
    pub inliers: Option<usize>,
    /// Number of matches.
    pub matches: Option<usize>,
    /// Number of features.
    pub features: usize,
}

impl FlightLine {
    /// Returns `true` if the frame was captured as the reference.
    pub fn is_reference(&self) -> bool {
        self.status == "reference"
    }

    /// Returns the displacement along `X_e` and `Y_e`, m.
    pub fn displacement(&self) -> Option<Vector2<f64>> {
        Some(Vector2::new(self.x_e_m?, self.y_e_m?))
    }

    /// Returns the velocity along `X_e` and `Y_e`, m/s, and its covariance, m^2/s^2.
    pub fn velocity(&self) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let ([x, y, _], [xx, xy, _, yx, yy, ..]) = (self.velocity_m_s?, self.velocity_covariance_m2_s2?);
        Some((Vector2::new(x, y), Matrix2::new(xx, xy, yx, yy)))
    }

    /// Returns the estimate in the form that pages take.
    pub fn estimate(&self) -> Option<Estimate> {
        let [xx, _, _, yy] = self.covariance_m2?;
        Some(Estimate {
            displacement: self.displacement()?.into(),
            sigma: [xx.sqrt(), yy.sqrt()],
            quality: self.quality?,
            inliers: self.inliers?,
            matches: self.matches?,
        })
    }
}
