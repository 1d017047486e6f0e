//! The attitude loop: computes the blade angles that bring the helicopter to the commanded attitude.
//!
//! ```text
//! blades = B^-1 (K (wanted - attitude) + K_I integral - D rates - C rates, climb)
//! ```
//!
//! `B` is the published effect of the four blade angles on the accelerations in roll, pitch, yaw and downwards; its
//! inverse decouples the four commands. `C` is the published coupling of the rates (roll by pitch rate, and so on)
//! without their damping, which the rotor provides. Each axis then has
//! `s^3 + d s^2 + K s + K_I = (s + l)(s^2 + (d - l) s + w^2)`, with `d` the published damping plus `D`. A disturbance
//! by a gust decays within `1 / l`. With servo, latency and sampling in the loop, a test computes these margins:
//!
//! | axis | published damping | `d` | `w` | `l` | phase margin | gain margin |
//! |---|---|---|---|---|---|---|
//! | roll | 11.6 /s | 18 /s | 8 rad/s | 2.0 /s | 52 degrees | 18 dB |
//! | pitch | 2.0 /s | 12 /s | 6 rad/s | 1.5 /s | 41 degrees | 14 dB |
//! | yaw | 0.7 /s | 5.5 /s | 3 rad/s | 1.0 /s | 51 degrees | 21 dB |

use crate::aircraft::lynx::Derivatives;
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// `d` (1/s), `w` (rad/s) and `l` (1/s) of the module documentation, for roll, pitch and yaw.
const POLES: [[f64; 3]; 3] = [[18.0, 8.0, 2.0], [12.0, 6.0, 1.5], [5.5, 3.0, 1.0]];
/// Limit of the integral of an attitude error, rad s.
const MAX_INTEGRAL: f64 = 0.2;

/// The gains and the integrals of the loop, in forward, right, down axes and aerospace signs.
#[derive(Debug, Clone)]
pub struct AttitudeLoop {
    /// Matrix from accelerations in roll, pitch, yaw and downwards to blade angles.
    allocation: Matrix4<f64>,
    coupling: Matrix3<f64>,
    stiffness: Vector3<f64>,
    integral_gain: Vector3<f64>,
    damping: Vector3<f64>,
    integral: Vector3<f64>,
}

impl AttitudeLoop {
    /// Computes the gains for an aircraft. Returns `None` if its blade angles cannot command the four accelerations.
    pub fn new(derivatives: &Derivatives) -> Option<Self> {
        let rows = [0, 1, 2, 5];
        let effect = Matrix4::from_fn(|row, column| derivatives.control[(rows[row], column)]);
        let own = derivatives.stability.fixed_view::<3, 3>(0, 0).diagonal();
        let coupling = derivatives.stability.fixed_view::<3, 3>(0, 0) - Matrix3::from_diagonal(&own);
        let of = |gain: fn([f64; 3]) -> f64| Vector3::from_fn(|axis, _| gain(POLES[axis]));
        Some(Self {
            allocation: effect.try_inverse()?,
            coupling,
            stiffness: of(|[d, w, l]| w * w + l * (d - l)),
            integral_gain: of(|[_, w, l]| w * w * l),
            damping: of(|[d, ..]| d) + own,
            integral: Vector3::zeros(),
        })
    }

    /// Advances by a step (s) and returns the blade angles from trim (rad), for an attitude error (commanded minus
    /// measured, rad), rates (rad/s) and a commanded downward acceleration (m/s^2).
    pub fn blades(&mut self, error: &Vector3<f64>, rates: &Vector3<f64>, downward: f64, step: f64) -> Vector4<f64> {
        self.integral = (self.integral + error * step).map(|sum| sum.clamp(-MAX_INTEGRAL, MAX_INTEGRAL));
        let angular = self.stiffness.component_mul(error) + self.integral_gain.component_mul(&self.integral)
            - self.damping.component_mul(rates)
            - self.coupling * rates;
        self.allocation * angular.push(downward)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use nalgebra::Complex;

    /// Transfer function from a command to a blade: a servo of 40 ms, a latency of 10 ms, and one and a half steps of 5
    /// ms on average.
    fn servo(s: Complex<f64>) -> Complex<f64> {
        (-s * 0.0175).exp() / (s * 0.04 + 1.0)
    }

    /// Returns the open loop of an axis, and the closed loop from commanded to true attitude.
    pub(in crate::autopilot) fn loops(axis: usize, s: Complex<f64>) -> [Complex<f64>; 2] {
        let built = AttitudeLoop::new(&Derivatives::lynx()).unwrap();
        let published = -Derivatives::lynx().stability[(axis, axis)];
        let command = built.integral_gain[axis] / s + built.stiffness[axis];
        let plant = servo(s) / (s * (s + published));
        let open = (command + s * built.damping[axis]) * plant;
        [open, command * plant / (open + 1.0)]
    }

    /// Returns the smallest phase margin (degrees) and gain margin (dB) of an open loop.
    pub(in crate::autopilot) fn margins(open: impl Fn(Complex<f64>) -> Complex<f64>) -> [f64; 2] {
        let at = |k: i32| open(Complex::new(0.0, 10f64.powf(f64::from(k) / 1000.0)));
        let (mut phase, mut gain) = (f64::INFINITY, f64::INFINITY);
        for k in -2000..2000 {
            let (here, next) = (at(k), at(k + 1));
            if (here.norm() - 1.0) * (next.norm() - 1.0) < 0.0 {
                phase = phase.min((-here).arg().to_degrees().abs());
            }
            if here.im * next.im < 0.0 && here.re < 0.0 && here.norm() < 1.0 {
                gain = gain.min(-20.0 * here.norm().log10());
            }
        }
        [phase, gain]
    }

    /// Checks the table in the module documentation.
    #[test]
    fn margins_are_as_stated() {
        for (axis, stated) in [[52.0, 18.0], [41.0, 14.0], [51.0, 21.0]].into_iter().enumerate() {
            let [phase, gain] = margins(|s| loops(axis, s)[0]);
            let found = format!("axis {axis}: {phase:.1} degrees, {gain:.1} dB");
            eprintln!("{found}");
            assert!((phase - stated[0]).abs() < 1.0 && (gain - stated[1]).abs() < 1.0, "{found}");
        }
    }

    /// The blade angles for one acceleration cause that one and no other.
    #[test]
    fn the_four_accelerations_are_decoupled() {
        let derivatives = Derivatives::lynx();
        let built = AttitudeLoop::new(&derivatives).unwrap();
        for axis in 0..4 {
            let wanted = Vector4::from_fn(|i, _| if i == axis { 0.3 } else { 0.0 });
            let given = derivatives.control * (built.allocation * wanted);
            let given = Vector4::new(given[0], given[1], given[2], given[5]);
            assert!((given - wanted).norm() < 1e-12, "{given}");
        }
    }
}
