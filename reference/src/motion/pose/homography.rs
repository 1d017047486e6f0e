//! The plane-induced homography, its derivatives by the unknowns, and the residuals of pairs under it.

use crate::motion::model::Pair;
use crate::motion::orthophoto::Attitude;
use crate::motion::pose::solver::{UNKNOWNS, Unknowns};
use crate::motion::relief::Residual;
use nalgebra::{Matrix3, Vector3};

/// The constant factors of the homography.
pub(super) struct Cameras {
    /// `K^-1` of REF.
    pub(super) from: Matrix3<f64>,
    /// `K` of CUR.
    pub(super) to: Matrix3<f64>,
}

impl Cameras {
    /// Computes `H` and its derivative by each unknown.
    pub(super) fn homography(&self, unknowns: &Unknowns) -> (Matrix3<f64>, [Matrix3<f64>; UNKNOWNS]) {
        let [tx, ty, tz, roll_c, pitch_c, yaw_c, h, roll_r, pitch_r, yaw_r, slope_x, slope_y] = (*unknowns).into();
        let into_current = Attitude { roll: roll_c, pitch: pitch_c, yaw: yaw_c }.factors();
        let from_reference = Attitude { roll: roll_r, pitch: pitch_r, yaw: yaw_r }.factors();
        let left = self.to * rotation(&into_current, None).transpose();
        let right = rotation(&from_reference, None) * self.from;
        let (t, normal) = (Vector3::new(tx, ty, tz), Vector3::new(slope_x, slope_y, 1.0));
        let b = Matrix3::identity() * h - t * normal.transpose();
        let (b_right, left_b) = (b * right, left * b);
        let (seen, moved) = (normal.transpose() * right, left * t);
        let by_displacement = |row: usize| left.column(row) * -seen;
        let by_slope = |column: usize| -moved * right.row(column);
        let by_current = |k: usize| self.to * rotation(&into_current, Some(k)).transpose() * b_right;
        let by_reference = |k: usize| left_b * rotation(&from_reference, Some(k)) * self.from;
        let derivatives = [
            by_displacement(0),
            by_displacement(1),
            by_displacement(2),
            by_current(0),
            by_current(1),
            by_current(2),
            left * right,
            by_reference(0),
            by_reference(1),
            by_reference(2),
            by_slope(0),
            by_slope(1),
        ];
        (left * b_right, derivatives)
    }
}

/// Writes the error `p' - H p` and the parallax of each pair into `residuals`. `height_derivative` is the derivative of
/// `H` by the height of the camera. Returns `None` if a position maps behind the camera.
pub(super) fn linearise<'pairs>(
    h: &Matrix3<f64>,
    height_derivative: &Matrix3<f64>,
    pairs: impl Iterator<Item = &'pairs Pair>,
    residuals: &mut Vec<Residual>,
) -> Option<()> {
    residuals.clear();
    for pair in pairs {
        let p = pair.reference.push(1.0);
        let image = h * p;
        if image.z.is_nan() || image.z <= 0.0 {
            return None;
        }
        let position = image.xy() / image.z;
        let error = pair.current - position;
        if !(error.x.is_finite() && error.y.is_finite()) {
            return None;
        }
        let change = height_derivative * p;
        // Ground that is a metre higher moves as if the camera were a metre lower.
        let parallax = (position * change.z - change.xy()) / image.z;
        residuals.push(Residual::new(pair.reference, image, parallax, error));
    }
    Some(())
}

/// Returns `R`, or its derivative by roll (0), pitch (1) or yaw (2). The derivative of a rotation about an axis by its
/// angle is the cross product with the axis times the rotation.
fn rotation(factors: &[Matrix3<f64>; 3], derivative_by: Option<usize>) -> Matrix3<f64> {
    let axes = [Vector3::<f64>::y(), -Vector3::x(), Vector3::z()];
    let mut factors = *factors;
    if let Some(k) = derivative_by {
        factors[k] = axes[k].cross_matrix() * factors[k];
    }
    let [roll, pitch, yaw] = factors;
    yaw * pitch * roll
}
