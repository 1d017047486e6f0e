//! Gusts with Dryden's spectra: a frozen field that passes the helicopter at the speed `V`.
//!
//! ```text
//! Phi_u(w) = s^2 (2 L / pi V) / (1 + (L w / V)^2)                             along the wind
//! Phi_v(w) = s^2 (  L / pi V) (1 + 3 (L w / V)^2) / (1 + (L w / V)^2)^2       across it, and vertical
//! ```
//!
//! The spectra are one-sided: their integral over `w` from 0 is `s^2`. Scales and intensities are those for low
//! altitude of MIL-F-8785C (1980), section 3.7, with `h` in feet: `L_w = h`,
//! `L_u = L_v = h / (0.177 + 0.000823 h)^1.2`, `s_u = s_v = s_w / (0.177 + 0.000823 h)^0.4`, `s_w = 0.1 W20`, with
//! `W20` the wind at 20 feet.
//!
//! **The speed in hover.** In forward flight `V` is the airspeed; in hover it is the speed of the wind. The
//! specification relates the intensity to a wind, `W20 = s_w / 0.1`; `V` is that or the mean wind, whichever is faster.
//! With gusts of 3 m/s at 50 m it is 19 m/s, for a correlation time of 11 s. A slower `V` would make the gusts slower
//! and easier to reject.
//!
//! **Discretisation** is exact at any step: `x_k+1 = F x_k + n`, the covariance of `n` being `P - F P F^T` with the
//! stationary covariance `P`, so that the variance is the specified one from the first sample on.

use crate::random::{Purpose, normal, stream};
use nalgebra::{Matrix2, Vector2, Vector3};
use rand_chacha::ChaCha8Rng;

/// Length of a foot, m.
const FOOT: f64 = 0.3048;

/// The parameters of the wind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Climate {
    /// Rms of each horizontal component of the gusts, m/s.
    pub gust_rms: f64,
    /// Mean wind, towards `X_e` and `Y_e`, m/s.
    pub mean: Vector2<f64>,
    /// Height over ground, m.
    pub height: f64,
}

/// A component of the gusts: intensity and time scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component {
    /// Rms of the component, m/s.
    pub rms: f64,
    /// Time scale `L / V`, s.
    pub time: f64,
}

impl Climate {
    /// Returns the components along the wind, across it, and vertical.
    pub fn components(&self) -> [Component; 3] {
        let feet = self.height / FOOT;
        let shape = 0.177 + 0.000823 * feet;
        let vertical = self.gust_rms * libm::pow(shape, 0.4);
        let speed = (vertical / 0.1).max(self.mean.norm());
        let horizontal_scale = self.height / libm::pow(shape, 1.2);
        let part =
            |rms: f64, scale: f64| Component { rms, time: if speed > 0.0 { scale / speed } else { f64::INFINITY } };
        let horizontal = part(self.gust_rms, horizontal_scale);
        [horizontal, horizontal, part(vertical, self.height)]
    }
}

/// The wind at the helicopter over time.
#[derive(Debug, Clone)]
pub struct Wind {
    mean: Vector3<f64>,
    /// A gust that comes on top.
    gust: Vector3<f64>,
    /// Unit vector along the wind.
    along: Vector2<f64>,
    longitudinal: FirstOrder,
    lateral: SecondOrder,
    vertical: SecondOrder,
    random: ChaCha8Rng,
}

impl Wind {
    /// Creates the wind from a seed, for steps of `step` seconds.
    pub fn new(climate: &Climate, seed: u64, step: f64) -> Self {
        let mut random = stream(seed, Purpose::Wind);
        let [longitudinal, lateral, vertical] = climate.components();
        Self {
            mean: climate.mean.push(0.0),
            gust: Vector3::zeros(),
            along: climate.mean.try_normalize(1e-9).unwrap_or(Vector2::x()),
            longitudinal: FirstOrder::new(longitudinal, step, &mut random),
            lateral: SecondOrder::new(lateral, step, &mut random),
            vertical: SecondOrder::new(vertical, step, &mut random),
            random,
        }
    }

    /// Returns the velocity of the air in the world, m/s.
    pub fn velocity(&self) -> Vector3<f64> {
        let across = Vector2::new(-self.along.y, self.along.x);
        let horizontal = self.along * self.longitudinal.value() + across * self.lateral.value();
        self.mean + self.gust + horizontal.push(self.vertical.value())
    }

    /// Sets the velocity of a gust that comes on top, m/s.
    pub fn set_gust(&mut self, velocity: Vector3<f64>) {
        self.gust = velocity;
    }

    /// Advances by one step.
    pub fn advance(&mut self) {
        self.longitudinal.advance(&mut self.random);
        self.lateral.advance(&mut self.random);
        self.vertical.advance(&mut self.random);
    }
}

/// A first-order filter `1 / (1 + T s)` driven by white noise.
#[derive(Debug, Clone, Copy)]
pub struct FirstOrder {
    value: f64,
    kept: f64,
    fresh: f64,
}

impl FirstOrder {
    /// Creates the filter with a random value from its stationary distribution.
    pub fn new(component: Component, step: f64, random: &mut ChaCha8Rng) -> Self {
        let Component { rms, time } = component;
        let kept = libm::exp(-step / time);
        let fresh = rms * (-libm::expm1(-2.0 * step / time)).sqrt();
        Self { value: rms * normal(random), kept, fresh }
    }

    /// Returns the present value.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Advances by one step.
    pub fn advance(&mut self, random: &mut ChaCha8Rng) {
        self.value = self.kept * self.value + self.fresh * normal(random);
    }
}

/// A second-order filter `(1 + sqrt 3 T s) / (1 + T s)^2` driven by white noise. It is two equal lags in series, `x1`
/// and `x2`, with `y = (sqrt 3 x1 + (1 - sqrt 3) x2) rms / sqrt 2`. With variance 1 of `x1`, that of `x2` is 1/2, as is
/// their covariance.
#[derive(Debug, Clone, Copy)]
struct SecondOrder {
    state: Vector2<f64>,
    transition: Matrix2<f64>,
    /// Cholesky factor of the covariance of the noise that a step adds.
    fresh: Matrix2<f64>,
    output: Vector2<f64>,
}

impl SecondOrder {
    fn new(component: Component, step: f64, random: &mut ChaCha8Rng) -> Self {
        let Component { rms, time } = component;
        let stationary = Matrix2::new(1.0, 0.5, 0.5, 0.5);
        let kept = libm::exp(-step / time);
        let transition = Matrix2::new(kept, 0.0, kept * step / time, kept);
        let fresh = lower_triangle(&(stationary - transition * stationary * transition.transpose()));
        let root = 3.0f64.sqrt();
        let output = Vector2::new(root, 1.0 - root) * (rms / 2.0f64.sqrt());
        let state = lower_triangle(&stationary) * Vector2::new(normal(random), normal(random));
        Self { state, transition, fresh, output }
    }

    fn value(&self) -> f64 {
        self.output.dot(&self.state)
    }

    fn advance(&mut self, random: &mut ChaCha8Rng) {
        let fresh = Vector2::new(normal(random), normal(random));
        self.state = self.transition * self.state + self.fresh * fresh;
    }
}

/// Returns the Cholesky factor of a covariance; variances that rounding makes negative count as 0.
fn lower_triangle(covariance: &Matrix2<f64>) -> Matrix2<f64> {
    let first = covariance[(0, 0)].max(0.0).sqrt();
    let below = if first > 0.0 { covariance[(1, 0)] / first } else { 0.0 };
    Matrix2::new(first, 0.0, below, (covariance[(1, 1)] - below * below).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMPONENT: Component = Component { rms: 3.0, time: 2.7 };

    /// A step leaves the stationary covariance as it is, and two steps are one of twice the length.
    #[test]
    fn steps_are_exact() {
        let mut random = stream(1, Purpose::Wind);
        for step in [0.005, 0.1, 3.0] {
            let first = [step, 2.0 * step].map(|step| FirstOrder::new(COMPONENT, step, &mut random));
            let variance = first[0].kept.powi(2) + (first[0].fresh / COMPONENT.rms).powi(2);
            assert!((variance - 1.0).abs() < 1e-12, "{step} s: {variance}");
            assert!((first[0].kept.powi(2) - first[1].kept).abs() < 1e-12);
            let second = [step, 2.0 * step].map(|step| SecondOrder::new(COMPONENT, step, &mut random));
            let stationary = Matrix2::new(1.0, 0.5, 0.5, 0.5);
            let SecondOrder { transition, fresh, output, .. } = second[0];
            let after = transition * stationary * transition.transpose() + fresh * fresh.transpose();
            assert!((after - stationary).norm() < 1e-12, "{step} s: {after}");
            assert!((transition * transition - second[1].transition).norm() < 1e-12);
            assert!((output.dot(&(stationary * output)) - COMPONENT.rms.powi(2)).abs() < 1e-12);
        }
    }
}
