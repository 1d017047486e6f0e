//! First order repeated: `P` passes of the filter with one pole each way (Alvarez and Mazorra 1994, "Signal and image
//! restoration using shock filters and anisotropic diffusion", the implicit scheme of the heat equation).
//!
//! ```text
//! lambda = sigma^2 / (2 P),    a = (1 + 2 lambda - sqrt(1 + 4 lambda)) / (2 lambda),    P = 1 .. 4
//! ```
//!
//! With this pole the variance of the impulse response, `2 P a/(1 - a)^2`, is `sigma^2`: one pass at `sigma` 2 has `a`
//! 0.5. All causal passes run first, then all anticausal ones; on an unbounded line the order does not matter.

use super::cascade::{Cascade, Section};

/// Largest number of passes.
pub const PASSES_MAX: usize = 4;

/// Returns the pole `a` of each pass for the variance `sigma^2`, `sigma` in pixels.
pub fn pole(sigma: f64, passes: usize) -> f64 {
    let lambda = sigma * sigma / (2.0 * passes as f64);
    // The same with numerator and denominator multiplied by the conjugate: the difference would lose digits at small
    // lambda.
    2.0 * lambda / (1.0 + 2.0 * lambda + (1.0 + 4.0 * lambda).sqrt())
}

/// Returns the filter of `passes` passes with the pole `a`.
pub(crate) fn filter(a: f64, passes: usize) -> Cascade {
    Cascade::new(vec![Section::real(a); passes])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pole_is_the_known_one() {
        assert_eq!(pole(2.0, 1), 0.5);
    }

    #[test]
    fn the_variance_is_exact() {
        for passes in 1..=PASSES_MAX {
            for sigma in [0.5, 1.0, 2.0, 5.12, 256.0] {
                let a = pole(sigma, passes);
                let variance = 2.0 * passes as f64 * a / (1.0 - a).powi(2);
                assert!((variance / (sigma * sigma) - 1.0).abs() < 1e-12, "{passes} passes, sigma {sigma}: {variance}");
            }
        }
    }
}
