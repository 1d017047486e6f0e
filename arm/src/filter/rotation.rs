//! Rotations as vectors, rad.

use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Returns the matrix of the cross product with a vector.
pub(super) fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

/// Returns the rotation by a vector, rad (Rodrigues).
pub fn exponential(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    let k = skew(v);
    if angle < 1e-9 {
        return Matrix3::identity() + k;
    }
    let (sin, cos) = libm::sincos(angle);
    Matrix3::identity() + k * (sin / angle) + k * k * ((1.0 - cos) / (angle * angle))
}

/// Returns the vector of a rotation by at most half a turn, rad.
pub(super) fn logarithm(r: &Matrix3<f64>) -> Vector3<f64> {
    let v = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) / 2.0;
    let sine = v.norm().min(1.0);
    let angle = libm::asin(sine);
    if r.trace() >= 1.0 {
        return if sine < 1e-6 { v } else { v * (angle / sine) };
    }
    // Beyond a quarter of a turn; `r + r^T - (trace - 1) I` is `axis axis^T` times a number that is not small there.
    let square = r + r.transpose() - Matrix3::identity() * (r.trace() - 1.0);
    let axis = square.column(square.diagonal().imax()).normalize();
    axis * (PI - angle).copysign(axis.dot(&v))
}

/// Returns the rotation next to a matrix that rounding has disturbed.
pub(super) fn orthonormal(r: &Matrix3<f64>) -> Matrix3<f64> {
    let x = r.column(0).normalize();
    let y = r.column(1) - x * x.dot(&r.column(1));
    let y = y.normalize();
    Matrix3::from_columns(&[x, y, x.cross(&y)])
}
