//! Young and van Vliet 1995, "Recursive implementation of the Gaussian filter", Signal Processing 44, third order:
//!
//! ```text
//! b0 = 1.57825 + 2.44413 q + 1.4281 q^2 + 0.422205 q^3      b1 = 2.44413 q + 2.85619 q^2 + 1.26661 q^3
//! b2 = -(1.4281 q^2 + 1.26661 q^3)                          b3 = 0.422205 q^3
//! u[n] = B x[n] + (b1 u[n-1] + b2 u[n-2] + b3 u[n-3]) / b0,    B = 1 - (b1 + b2 + b3) / b0
//! ```
//!
//! and the same backwards (their equations 8c, 9). Published, for `sigma` of at least half a pixel (equation 11b):
//!
//! ```text
//! q = 0.98711 sigma - 0.96330                         for sigma >= 2.5
//! q = 3.97156 - 4.14554 sqrt(1 - 0.26891 sigma)       for 0.5 <= sigma <= 2.5
//! ```
//!
//! The two disagree at 2.5, where they give 1.504 and 1.598; the first is used. For `sigma` 5 the standard deviation of
//! the filter is 5.556, so [`Fit::Variance`](super::Fit::Variance) is offered too. Because of the printed digits
//! `b0 - b1 - b2 - b3` is `1.57825 + 1e-5 q^2` instead of a constant: 3 % at `q` 64, the limit of the range.

use super::cascade::{Cascade, Section};

/// The narrowest and the widest `sigma`, pixels.
pub const SIGMA_RANGE: (f64, f64) = (0.5, 64.0);

/// Returns the published `q` for `sigma` pixels.
pub fn published_q(sigma: f64) -> f64 {
    if sigma >= 2.5 { 0.98711 * sigma - 0.96330 } else { 3.97156 - 4.14554 * (1.0 - 0.26891 * sigma).sqrt() }
}

/// Returns the feedback coefficients `[b1, b2, b3] / b0`.
fn feedback(q: f64) -> [f64; 3] {
    let (q2, q3) = (q * q, q * q * q);
    let b0 = 1.57825 + 2.44413 * q + 1.4281 * q2 + 0.422205 * q3;
    let b1 = 2.44413 * q + 2.85619 * q2 + 1.26661 * q3;
    let b2 = -(1.4281 * q2 + 1.26661 * q3);
    let b3 = 0.422205 * q3;
    [b1 / b0, b2 / b0, b3 / b0]
}

/// Returns the filter with the given `q`, split into its real pole and its pair.
pub(crate) fn filter(q: f64) -> Cascade {
    let [a1, a2, a3] = feedback(q);
    // One real root of z^3 - a1 z^2 - a2 z - a3 is between 0 and 1: the polynomial is -a3 < 0 at 0 and B > 0 at 1.
    let (mut low, mut high) = (0.0, 1.0);
    let real = loop {
        let z = 0.5 * (low + high);
        if z <= low || z >= high {
            break z;
        }
        if ((z - a1) * z - a2) * z - a3 < 0.0 { low = z } else { high = z }
    };
    // (z - p)(z^2 - c1 z - c2): c1 = a1 - p, c2 = -a3/p.
    Cascade::new(vec![Section { a: [a1 - real, -a3 / real] }, Section::real(real)])
}

#[cfg(test)]
mod tests {
    use crate::smoothing::recursive::{Family, Fit, Recursive};

    #[test]
    fn coefficients_at_sigma_five_are_the_known_ones() {
        let filter = Recursive::design(Family::YoungVanVliet, Fit::Published, 5.0).unwrap();
        assert!((filter.parameter() - 3.972250).abs() <= 0.5e-6, "{}", filter.parameter());
        for (got, want) in filter.direct_form().a.iter().zip([2.22555139, -1.69070625, 0.43897167]) {
            assert!((got - want).abs() <= 0.5e-8, "{got} {want}");
        }
        assert!((filter.residuals().sigma_eff - 5.556).abs() <= 0.5e-3, "{}", filter.residuals().sigma_eff);
    }
}
