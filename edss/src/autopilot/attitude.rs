//! Attitude loop: blade angles that turn the helicopter as it is told.
//!
//! ```text
//! blades = B^-1 (K (wanted - attitude) + K_I integral - D rates - C rates, climb)
//! ```
//!
//! `B` is the published effect of the four blade angles on the accelerations in roll, pitch, yaw and downwards, so that
//! each is asked for by itself; `C` is the published coupling of the rates (roll by pitch rate, and so on) without
//! their damping, which is left to the rotor. Each axis then has `s^3 + d s^2 + K s + K_I = (s + l)(s^2 + (d - l) s +
//! w^2)`, with `d` the published damping plus `D`:
//!
//! | axis | published damping | `d` | `w` | `l` |
//! |---|---|---|---|---|
//! | roll | 11.6 /s | 13 /s | 5 rad/s | 1.5 /s |
//! | pitch | 2.0 /s | 8 /s | 4 rad/s | 1.0 /s |
//! | yaw | 0.7 /s | 3 /s | 1.5 rad/s | 0.4 /s |
//!
//! The quadratic factor is damped by 0.87 or more; what a gust turns the helicopter by is undone within `1 / l`.

use crate::aircraft::lynx::Derivatives;
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// `d`, `w` and `l` of roll, pitch and yaw.
const AXES: [[f64; 3]; 3] = [[13.0, 5.0, 1.5], [8.0, 4.0, 1.0], [3.0, 1.5, 0.4]];
/// Largest integral of an attitude error, rad s.
const INTEGRAL: f64 = 0.2;

/// The loop, in forward, right, down and the signs of flight mechanics.
#[derive(Debug, Clone)]
pub struct AttitudeLoop {
    /// Accelerations in roll, pitch, yaw, down -> blade angles.
    allocation: Matrix4<f64>,
    coupling: Matrix3<f64>,
    stiffness: Vector3<f64>,
    integral_gain: Vector3<f64>,
    damping: Vector3<f64>,
    integral: Vector3<f64>,
}

impl AttitudeLoop {
    /// For an aircraft; none where its blade angles do not command the four accelerations.
    pub fn new(derivatives: &Derivatives) -> Option<Self> {
        let rows = [0, 1, 2, 5];
        let effect = Matrix4::from_fn(|row, column| derivatives.control[(rows[row], column)]);
        let own = derivatives.stability.fixed_view::<3, 3>(0, 0).diagonal();
        let coupling = derivatives.stability.fixed_view::<3, 3>(0, 0) - Matrix3::from_diagonal(&own);
        let of = |gain: fn([f64; 3]) -> f64| Vector3::from_fn(|axis, _| gain(AXES[axis]));
        Some(Self {
            allocation: effect.try_inverse()?,
            coupling,
            stiffness: of(|[d, w, l]| w * w + l * (d - l)),
            integral_gain: of(|[_, w, l]| w * w * l),
            damping: of(|[d, ..]| d) + own,
            integral: Vector3::zeros(),
        })
    }

    /// Blade angles from trim (rad) for an error of attitude (wanted less measured, rad), rates (rad/s) and a wanted
    /// downward acceleration (m/s^2), over a step (s).
    pub fn blades(&mut self, error: &Vector3<f64>, rates: &Vector3<f64>, downward: f64, step: f64) -> Vector4<f64> {
        self.integral = (self.integral + error * step).map(|sum| sum.clamp(-INTEGRAL, INTEGRAL));
        let angular = self.stiffness.component_mul(error) + self.integral_gain.component_mul(&self.integral)
            - self.damping.component_mul(rates)
            - self.coupling * rates;
        self.allocation * angular.push(downward)
    }
}
