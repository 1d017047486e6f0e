//! The sampled Gaussian: the model level `ideal`, and the reference of every other smoother:
//!
//! ```text
//! w[n] = exp(-n^2 / (2 sigma^2)) / sum_k exp(-k^2 / (2 sigma^2)),    n = -R .. R,    sum w = 1
//! ```
//!
//! `sigma` in pixels, `0.5 ..= 256`. A narrower Gaussian is distorted by the sampling: at 0.5 `sqrt(sum n^2 w)` is
//! 0.463, at 0.3 it is 0.09. `R = ceil(sigma sqrt(2 * 53 ln 2))`, about `8.6 sigma`: the first weight omitted is below
//! `2^-53` of the middle one, the rounding of an `f64`. Samples beyond the border repeat the border sample; a direct
//! convolution has no second pass, so both rules of [`Border`](crate::smoothing::recursive::border::Border) are the
//! same here.

use crate::smoothing::design::{DesignError, SIGMA_MAX, check_sigma};
use crate::smoothing::separable::{LANES, Lanes};
use multiversion::multiversion;

/// The narrowest `sigma`, pixels.
pub const SIGMA_MIN: f64 = 0.5;

/// The sampled Gaussian of one `sigma`.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussian {
    sigma: f64,
    weights: Vec<f64>,
}

impl Gaussian {
    /// Samples and normalises the Gaussian of `sigma` pixels.
    ///
    /// # Errors
    /// `sigma` is not within `0.5 ..= 256`.
    pub fn design(sigma: f64) -> Result<Self, DesignError> {
        check_sigma("the sampled Gaussian", sigma, (SIGMA_MIN, SIGMA_MAX))?;
        let radius = (sigma * (2.0 * 53.0 * std::f64::consts::LN_2).sqrt()).ceil() as usize;
        Ok(Self { sigma, weights: unit_sum_half(sigma, radius + 1) })
    }

    /// Returns the `sigma` of the design, pixels.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// Returns the weights `w[0 ..= R]`; the other half mirrors them.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns the gain `sum w[n] cos(omega n)` at `omega` radians per pixel.
    pub fn frequency_response(&self, omega: f64) -> f64 {
        let tail: f64 = self.weights.iter().enumerate().skip(1).map(|(n, w)| w * (omega * n as f64).cos()).rev().sum();
        self.weights[0] + 2.0 * tail
    }

    /// Convolves a tile in place.
    pub(crate) fn filter(&self, tile: &mut [Lanes]) {
        let radius = self.weights.len() - 1;
        let (Some(&first), Some(&last)) = (tile.first(), tile.last()) else { return };
        let mut padded = Vec::with_capacity(tile.len() + 2 * radius);
        padded.resize(radius, first);
        padded.extend_from_slice(tile);
        padded.resize(tile.len() + 2 * radius, last);
        convolve(&padded, &self.weights, tile);
    }
}

/// Returns the first `len` weights `w[0 ..]` of the unit-sum sampled Gaussian; the sum is over both halves.
pub fn unit_sum_half(sigma: f64, len: usize) -> Vec<f64> {
    let mut weights: Vec<f64> = (0..len).map(|n| (-0.5 * (n as f64 / sigma).powi(2)).exp()).collect();
    // From the tail inwards: small terms are added first.
    let sum = weights[0] + 2.0 * weights[1..].iter().rev().sum::<f64>();
    for w in &mut weights {
        *w /= sum;
    }
    weights
}

/// Convolves, `y[n] = x[n] + sum_k w[k] (x[n-k] + x[n+k] - 2 x[n])`. Written with differences, so that a constant
/// passes unchanged to the last bit. `padded` has `R` samples more than `out` at either end.
#[multiversion(targets("x86_64+avx2"))]
fn convolve(padded: &[Lanes], weights: &[f64], out: &mut [Lanes]) {
    let radius = weights.len() - 1;
    for (n, out) in out.iter_mut().enumerate() {
        let window = &padded[n..=n + 2 * radius];
        let (before, from_centre) = window.split_at(radius);
        let (centre, after) = (&from_centre[0], &from_centre[1..]);
        let mut sum = [0.0; LANES];
        // From the tail inwards: small terms are added first.
        for ((left, right), w) in before.iter().zip(after.iter().rev()).zip(weights[1..].iter().rev()) {
            for l in 0..LANES {
                sum[l] += w * ((left[l] + right[l]) - 2.0 * centre[l]);
            }
        }
        for l in 0..LANES {
            out[l] = centre[l] + sum[l];
        }
    }
}
