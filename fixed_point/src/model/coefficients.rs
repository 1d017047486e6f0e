//! Raw integer coefficients of the lerps from `sigma`.
//!
//! ```text
//! g = 1 - a,    g_j = 1 / (1 + a^(2^j)),  j = 0 .. m-1,    raw = round(2^F g)  in  1 .. 2^F - 1
//! ```
//!
//! `a` is the pole of the first-order filter in full `f64`; each coefficient is rounded separately, from the unrounded
//! `a`, to `u0.F`. With any rounding a lerp has DC gain 1 and is stable. `m` stages span `2^m - 1` samples and omit the
//! part `a^(2^m)` of the sum `sum_k a^k`. `m` follows from the largest part that may be omitted.

pub mod direct_form;
pub mod export;
pub mod set;

use hoverlock_design::MAX_FRACTION_BITS;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_reference::smoothing::recursive::first_order;
use hoverlock_reference::smoothing::smoother::Response;

use crate::model::stages::{self, StageCoefficients};

/// Largest number of look-ahead stages. `2^12` samples are more than the rows of any frame.
pub const MAX_LOOK_AHEAD: u32 = 12;

/// Why coefficients cannot be designed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CoefficientError {
    /// The filter itself cannot be designed.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// No fraction bits, or more than [`MAX_FRACTION_BITS`].
    #[error("{0} fraction bits are not possible: choose 1 to {MAX_FRACTION_BITS}")]
    FractionBits(u32),
    /// No look-ahead stages, or more than [`MAX_LOOK_AHEAD`].
    #[error("a look-ahead of {0} stages is not possible: choose 1 to {MAX_LOOK_AHEAD} (m stages span 2^m - 1 samples)")]
    LookAhead(u32),
    /// `g` rounds to 0 (the recursion would not follow its input) or to 1 (it would not smooth).
    #[error(
        "g = 1 - a = {g} rounds to {raw} in u0.{fraction_bits}, outside 1 to 2^{fraction_bits} - 1: \
         take more fraction bits"
    )]
    Gain {
        /// The unrounded coefficient.
        g: f64,
        /// The raw integer it rounds to.
        raw: u64,
        /// Number of fraction bits.
        fraction_bits: u32,
    },
    /// No integers near the exact coefficients make a stable filter of DC gain 1.
    #[error(
        "no rounding of the order-{order} filter of sigma {sigma} to {frac_bits} fraction bits is stable \
         with DC gain 1: take more fraction bits or a lower order"
    )]
    NoRounding {
        /// Poles of each side.
        order: usize,
        /// `sigma` of the filter, pixels.
        sigma: f64,
        /// Number of fraction bits.
        frac_bits: u32,
    },
    /// The look-ahead error is not between 0 and 1.
    #[error("a look-ahead error of {0} is not possible: choose more than 0 and less than 1")]
    Error(f64),
    /// The look-ahead error needs more than [`MAX_LOOK_AHEAD`] stages.
    #[error("a look-ahead error of {error} at the pole {a} needs more than {MAX_LOOK_AHEAD} stages")]
    ErrorTooSmall {
        /// The look-ahead error.
        error: f64,
        /// The pole of the filter.
        a: f64,
    },
}

/// The raw coefficients of the lerps of one smoother.
#[derive(Debug, Clone, PartialEq)]
pub struct LerpCoefficients {
    /// The `sigma` they were designed for, pixels.
    pub sigma: f64,
    /// The pole, unrounded.
    pub a: f64,
    /// `F` of `u0.F`.
    pub frac_bits: u32,
    /// `round(2^F (1 - a))`: the coefficient of the recursion.
    pub g: u32,
    /// `round(2^F / (1 + a^(2^j)))` for `j = 0 .. m-1`: the look-ahead stages.
    pub g_j: Vec<u32>,
    /// Stages whose coefficient rounds to 1, which `u0.F` cannot represent. They saturate at `2^F - 1`. Such a stage
    /// only adds error; use a shorter look-ahead.
    pub saturated: Vec<u32>,
}

impl From<LerpCoefficients> for StageCoefficients<u32> {
    fn from(designed: LerpCoefficients) -> Self {
        Self { g: designed.g, g_j: designed.g_j }
    }
}

impl LerpCoefficients {
    /// Designs and rounds the coefficients of the first-order filter of `sigma` pixels with `look_ahead` stages.
    ///
    /// # Errors
    /// `sigma`, the look-ahead or the number of bits is out of range, or `g` rounds to 0 or 1.
    pub fn design(sigma: f64, look_ahead: u32, frac_bits: u32) -> Result<Self, CoefficientError> {
        Self::of_pole(sigma, first_order::pole(sigma)?, look_ahead, frac_bits)
    }

    /// Rounds the coefficients of a filter with the pole `a`; `sigma` is stored only.
    ///
    /// # Errors
    /// The look-ahead or the number of bits is out of range, or `g` rounds to 0 or 1.
    pub fn of_pole(sigma: f64, a: f64, look_ahead: u32, frac_bits: u32) -> Result<Self, CoefficientError> {
        check_fraction_bits(frac_bits)?;
        if !(1..=MAX_LOOK_AHEAD).contains(&look_ahead) {
            return Err(CoefficientError::LookAhead(look_ahead));
        }
        let one = 1u64 << frac_bits;
        let round = |value: f64| (value * one as f64).round() as u64;
        let g = round(1.0 - a);
        if g == 0 || g >= one {
            return Err(CoefficientError::Gain { g: 1.0 - a, raw: g, fraction_bits: frac_bits });
        }
        let exact = std::iter::successors(Some(a), |p| Some(p * p)).map(|p| 1.0 / (1.0 + p));
        let mut saturated = Vec::new();
        let g_j = (0..look_ahead)
            .zip(exact)
            .map(|(j, g_j)| {
                let raw = round(g_j);
                if raw >= one {
                    saturated.push(j);
                }
                raw.min(one - 1) as u32
            })
            .collect();
        Ok(Self { sigma, a, frac_bits, g: g as u32, g_j, saturated })
    }

    /// Returns the vertical and the horizontal impulse response of the rounded coefficients, in f64 arithmetic.
    pub fn impulse_responses(&self) -> [Response; 2] {
        let value = |raw: u32| f64::from(raw) * (-f64::from(self.frac_bits)).exp2();
        let coefficients = StageCoefficients { g: value(self.g), g_j: self.g_j.iter().copied().map(value).collect() };
        // The recursion decays as (1 - g)^n. The line is long enough for 2^-70 on both sides, and for the look-ahead.
        let tail = (-70.0 * std::f64::consts::LN_2 / (-coefficients.g).ln_1p()).ceil() as usize;
        let centre = tail.max(1 << self.look_ahead());
        let impulse = |n: usize| f64::from(u8::from(n == centre));
        let length = 2 * centre + 1;
        [Plane::from_fn(1, length, |_, y| impulse(y)), Plane::from_fn(length, 1, |x, _| impulse(x))].map(|line| {
            let response = stages::smoothed(line, &coefficients, |p, q, c| p + c * (q - p));
            Response::new(response.into_vec(), centre)
        })
    }

    /// Returns the number of look-ahead stages, `m`.
    pub fn look_ahead(&self) -> u32 {
        self.g_j.len() as u32
    }
}

/// Checks the number of fraction bits.
///
/// # Errors
/// It is not within `1 ..= MAX_FRACTION_BITS`.
pub(crate) fn check_fraction_bits(frac_bits: u32) -> Result<(), CoefficientError> {
    if (1..=MAX_FRACTION_BITS).contains(&frac_bits) { Ok(()) } else { Err(CoefficientError::FractionBits(frac_bits)) }
}

/// Returns the part of the sum that `look_ahead` stages omit: `a^(2^m)`.
pub(super) fn look_ahead_error(a: f64, look_ahead: u32) -> f64 {
    a.powf(f64::from(look_ahead).exp2())
}

/// Returns the shortest look-ahead that omits at most `error`: the smallest `m >= 1` with `a^(2^m) <= error`.
///
/// # Errors
/// `error` is not between 0 and 1, or needs more than [`MAX_LOOK_AHEAD`] stages.
pub fn look_ahead_for(a: f64, error: f64) -> Result<u32, CoefficientError> {
    if !(error > 0.0 && error < 1.0) {
        return Err(CoefficientError::Error(error));
    }
    (1..=MAX_LOOK_AHEAD).find(|&m| look_ahead_error(a, m) <= error).ok_or(CoefficientError::ErrorTooSmall { error, a })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_design_point_has_the_coefficients_of_the_specification() {
        for (sigma, g, g_j) in [
            (2.0, 24536, vec![40315, 47101, 56830, 64033, 65500]),
            (3.2, 17102, vec![37685, 42386, 50478, 60180, 65021]),
            (5.12, 11450, vec![35905, 38984, 44768, 53931, 62636, 65396]),
        ] {
            let coefficients = LerpCoefficients::design(sigma, g_j.len() as u32, 16).unwrap();
            assert_eq!((coefficients.g, &coefficients.g_j), (g, &g_j), "sigma {sigma}");
            assert!(coefficients.saturated.is_empty());
            // The design point's look-ahead is what a wanted error of 1e-4 asks for.
            assert_eq!(look_ahead_for(coefficients.a, 1e-4), Ok(coefficients.look_ahead()), "sigma {sigma}");
        }
    }

    #[test]
    fn a_coefficient_that_rounds_to_one_saturates_and_is_listed() {
        // At sigma 2 a^(2^5) = 3e-7: 65536 (1 - 3e-7) rounds to 65536.
        let coefficients = LerpCoefficients::design(2.0, 6, 16).unwrap();
        assert_eq!((coefficients.g_j[5], coefficients.saturated), (65535, vec![5]));
    }

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        let refused =
            |sigma, look_ahead, bits| LerpCoefficients::design(sigma, look_ahead, bits).unwrap_err().to_string();
        assert!(refused(2.0, 5, 0).contains("0 fraction bits"));
        assert!(refused(2.0, 5, 200).contains("200 fraction bits"));
        assert!(refused(2.0, 0, 16).contains("look-ahead of 0"));
        assert!(refused(2.0, 99, 16).contains("look-ahead of 99"));
        assert!(refused(1e9, 5, 16).contains("sigma 1000000000"));
        assert!(refused(256.0, 5, 4).contains("rounds to 0 in u0.4"));
        for error in [0.0, 1.0, -1.0, f64::NAN] {
            assert!(look_ahead_for(0.5, error).is_err());
        }
        assert!(look_ahead_for(0.9999, 1e-300).is_err());
    }

    proptest! {
        #[test]
        fn raw_coefficients_are_within_half_an_lsb(
            sigma in 0.5..64.0f64, look_ahead in 1..=MAX_LOOK_AHEAD, bits in 8..=MAX_FRACTION_BITS,
        ) {
            let coefficients = LerpCoefficients::design(sigma, look_ahead, bits).unwrap();
            let one = f64::from(bits).exp2();
            prop_assert!((f64::from(coefficients.g) / one - (1.0 - coefficients.a)).abs() <= 0.5 / one);
            for (j, raw) in (0..).zip(&coefficients.g_j) {
                let gain = 1.0 / (1.0 + look_ahead_error(coefficients.a, j));
                let allowed = if coefficients.saturated.contains(&j) { 1.0 } else { 0.5 + 1e-6 };
                prop_assert!((f64::from(*raw) / one - gain).abs() <= allowed / one, "stage {}", j);
                prop_assert!(f64::from(*raw) >= 0.5 * one, "a stage coefficient is at least a half");
            }
        }

        #[test]
        fn the_look_ahead_is_the_shortest_within_the_error(sigma in 0.5..64.0f64, exponent in 1..12i32) {
            let (a, error) = (first_order::pole(sigma).unwrap(), 10f64.powi(-exponent));
            let m = look_ahead_for(a, error).unwrap();
            // Against the sum itself, not its closed form: sum_{k >= 2^m} a^k / sum_k a^k.
            let left_out = |m: u32| (1u32 << m..1 << 14).map(|k| a.powi(k as i32)).sum::<f64>() * (1.0 - a);
            prop_assert!(left_out(m) <= error * (1.0 + 1e-6));
            prop_assert!(m == 1 || left_out(m - 1) > error * (1.0 - 1e-6));
        }
    }
}
