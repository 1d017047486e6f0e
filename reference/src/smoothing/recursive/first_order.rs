//! The two-sided first-order filter, the model level `recursive`:
//!
//! ```text
//! H(z) = A^2 / ((b0 - b1 z)(b0 - b1 z^-1)),    A = b0 - b1,    a = b1/b0,    h[n] = (1 - a)/(1 + a) a^|n|
//! ```
//!
//! The pole `a` makes `sum_n (h[n] - w[n])^2` smallest, `w` the unit-sum sampled Gaussian of `sigma` pixels, over `+-20
//! sigma`. Because `h` is fixed by `a` alone, the smallest sum is where its derivative
//!
//! ```text
//! sum_n (h[n] - w[n]) dh[n]/da = 0,    dh/da = -2/(1 + a)^2 a^|n| + (1 - a)/(1 + a) |n| a^(|n| - 1)
//! ```
//!
//! vanishes: negative for small `a` (the exponential is too narrow), positive for large. The fit is coarse, because
//! an exponential has a peak and long tails: its l2 error is about 20 %. The stability of the features is measured
//! separately.

use crate::smoothing::design::{DesignError, SIGMA_MAX, check_sigma};
use crate::smoothing::gaussian::{SIGMA_MIN, unit_sum_half};

/// Returns the pole `a = b1/b0` of the least-squares fit to the Gaussian of `sigma` pixels, to the precision of an
/// `f64`.
///
/// # Errors
/// `sigma` is not within `0.5 ..= 256`.
pub fn pole(sigma: f64) -> Result<f64, DesignError> {
    check_sigma("the first-order filter", sigma, (SIGMA_MIN, SIGMA_MAX))?;
    let weights = unit_sum_half(sigma, (20.0 * sigma).ceil() as usize + 1);
    let slope = |a: f64| {
        let (scale, scale_slope) = ((1.0 - a) / (1.0 + a), -2.0 / (1.0 + a).powi(2));
        // p runs over a^(n-1); at n = 0 the second part of dh/da has the factor |n| = 0.
        let (mut p, mut sum) = (1.0, (scale - weights[0]) * scale_slope);
        for (n, w) in weights.iter().enumerate().skip(1) {
            sum += 2.0 * (scale * p * a - w) * (scale_slope * p * a + scale * n as f64 * p);
            p *= a;
        }
        sum
    };
    let (mut low, mut high) = (0.0, 1.0);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Ok(middle);
        }
        if slope(middle) < 0.0 { low = middle } else { high = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoothing::smoother::Smoother;

    #[test]
    fn poles_and_residuals_are_the_known_ones() {
        for (sigma, a, l2) in
            [(1.0, 0.413876, 20.9), (2.0, 0.625615, 20.7), (3.2, 0.739042, 19.3), (5.12, 0.825284, 18.4)]
        {
            let pole = pole(sigma).unwrap();
            assert!((pole - a).abs() <= 0.5e-6, "sigma {sigma}: {pole}");
            let residuals = Smoother::first_order(sigma).unwrap().residuals();
            assert!((100.0 * residuals.l2 - l2).abs() <= 0.05, "sigma {sigma}: {}", residuals.l2);
        }
    }

    #[test]
    fn no_neighbouring_pole_fits_better() {
        for sigma in [SIGMA_MIN, 0.7, 2.0, 5.12, 37.0, 256.0] {
            let weights = unit_sum_half(sigma, (20.0 * sigma).ceil() as usize + 1);
            let squares = |a: f64| -> f64 {
                let difference = |n: usize| (1.0 - a) / (1.0 + a) * a.powi(n as i32) - weights[n];
                (1..weights.len()).map(|n| 2.0 * difference(n).powi(2)).sum::<f64>() + difference(0).powi(2)
            };
            let a = pole(sigma).unwrap();
            for step in [1e-3, 1e-2, 0.1] {
                let (lower, higher) = (a - step * a, a + step * (1.0 - a));
                assert!(squares(a) < squares(lower) && squares(a) < squares(higher), "sigma {sigma}, step {step}");
            }
        }
    }

    #[test]
    fn impossible_sigmas_are_refused() {
        for sigma in [0.0, -1.0, 0.49, 256.1, 1e9, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let message = pole(sigma).unwrap_err().to_string();
            assert!(message.contains("first-order") && message.contains("0.5 to 256 px"), "{message}");
        }
    }
}
