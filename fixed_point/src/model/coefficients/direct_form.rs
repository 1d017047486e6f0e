//! Integer direct forms of any filter family, with DC gain exactly 1 and all poles inside the unit circle.
//!
//! ```text
//! A_i ~ 2^F a_i,    cascade:   B = 2^F - sum A_i,                             B >= 1
//!                   parallel:  sum B_i + sum B_ahead_i = 2^F - sum A_i,       sum >= 1
//! ```
//!
//! Rounding each coefficient separately guarantees neither: an error of one LSB in `sum A` changes the DC gain by
//! `1/B`, which is large for poles near `z = 1`. Therefore all integer feedback coefficients within two LSB of the
//! exact values are tried. The sum of the feed-forward coefficients follows from them (in parallel form one tap absorbs
//! the rounding error, each tap in turn). Unstable candidates are discarded. Of the others the one with the frequency
//! response nearest to the unquantised filter is selected; by Parseval's theorem its impulse response is nearest in the
//! l2 norm.

use super::{CoefficientError, check_fraction_bits};
use hoverlock_reference::smoothing::recursive::direct_form::{DirectForm, Structure};
use std::f64::consts::PI;

/// Largest distance of a feedback coefficient from its exact value, LSB.
const STEPS: i64 = 2;

/// Samples of the frequency response in the comparison of candidates.
const FREQUENCIES: usize = 96;

/// The raw integers of [`DirectForm`], in units of `2^-F`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IntegerDirectForm {
    /// `F`: fraction bits of every coefficient.
    pub frac_bits: u32,
    /// Cascade or parallel.
    pub structure: Structure,
    /// `A[1 ..= order]`.
    pub a: Vec<i64>,
    /// Feed-forward coefficients `B[0 ..]`.
    pub b: Vec<i64>,
    /// `B_ahead[1 ..= order]`, empty in a cascade.
    pub b_ahead: Vec<i64>,
}

impl IntegerDirectForm {
    /// Finds the best rounding of a filter of `sigma` pixels.
    ///
    /// # Errors
    /// The number of bits is out of range, or no rounding near the exact values is stable with DC gain 1.
    pub fn round(exact: &DirectForm, sigma: f64, frac_bits: u32) -> Result<Self, CoefficientError> {
        check_fraction_bits(frac_bits)?;
        // The response of a smoother above 8 / sigma is negligible.
        let band = PI.min(8.0 / sigma);
        let wanted: Vec<(f64, _)> = (0..FREQUENCIES)
            .map(|k| (k as f64 + 0.5) / FREQUENCIES as f64 * band)
            .map(|omega| (omega, exact.frequency_response(omega)))
            .collect();
        let error = |form: &DirectForm| -> f64 {
            wanted.iter().map(|(omega, wanted)| (form.frequency_response(*omega) - wanted).norm_sqr()).sum()
        };
        let scale = f64::from(frac_bits).exp2();
        let round =
            |values: &[f64]| -> Vec<i64> { values.iter().map(|value| (value * scale).round() as i64).collect() };
        let nearest = Self {
            frac_bits,
            structure: exact.structure,
            a: round(&exact.a),
            b: round(&exact.b),
            b_ahead: round(&exact.b_ahead),
        };
        let mut best: Option<(f64, Self)> = None;
        for a in neighbours(&nearest.a) {
            for candidate in nearest.with_feedback(a) {
                let form = candidate.real();
                if !form.is_stable() {
                    // The other taps of this candidate share its poles.
                    break;
                }
                let error = error(&form);
                if best.as_ref().is_none_or(|(least, _)| error < *least) {
                    best = Some((error, candidate));
                }
            }
        }
        best.map(|(_, form)| form).ok_or(CoefficientError::NoRounding { order: exact.a.len(), sigma, frac_bits })
    }

    /// Returns the candidates with this feedback and DC gain 1. The list is empty if the feed-forward coefficients
    /// would sum to 0 or less.
    fn with_feedback(&self, a: Vec<i64>) -> Vec<Self> {
        let sum = (1i64 << self.frac_bits) - a.iter().sum::<i64>();
        if sum < 1 {
            return Vec::new();
        }
        match self.structure {
            Structure::Cascade => vec![Self { a, b: vec![sum], ..self.clone() }],
            Structure::Parallel => {
                let left_over = sum - self.b.iter().chain(&self.b_ahead).sum::<i64>();
                (0..self.b.len() + self.b_ahead.len())
                    .map(|tap| {
                        let mut candidate = Self { a: a.clone(), ..self.clone() };
                        let taps = candidate.b.iter_mut().chain(&mut candidate.b_ahead);
                        taps.skip(tap).take(1).for_each(|raw| *raw += left_over);
                        candidate
                    })
                    .collect()
            }
        }
    }

    /// Returns the values of the raw integers.
    pub fn real(&self) -> DirectForm {
        let scale = (-f64::from(self.frac_bits)).exp2();
        let values = |raw: &[i64]| raw.iter().map(|&raw| raw as f64 * scale).collect();
        DirectForm { structure: self.structure, a: values(&self.a), b: values(&self.b), b_ahead: values(&self.b_ahead) }
    }

    /// Returns numerator and denominator of the DC gain, in units of `2^-F`. They are equal, because the gain is
    /// exactly 1. For a cascade it is the gain of either pass.
    pub fn dc_gain(&self) -> (i64, i64) {
        let feed_forward = self.b.iter().chain(&self.b_ahead).sum();
        (feed_forward, (1i64 << self.frac_bits) - self.a.iter().sum::<i64>())
    }

    /// Returns the number of bits that every coefficient fits in two's complement.
    pub fn width(&self) -> u32 {
        let raw = self.a.iter().chain(&self.b).chain(&self.b_ahead);
        raw.map(|&raw| 65 - (if raw < 0 { !raw } else { raw }).leading_zeros()).max().unwrap_or(1)
    }
}

/// Returns all raw integers within [`STEPS`] of the given ones, component by component.
fn neighbours(raw: &[i64]) -> Vec<Vec<i64>> {
    raw.iter().fold(vec![Vec::new()], |partial, &raw| {
        let extended = |head: Vec<i64>| {
            (raw - STEPS..=raw + STEPS).map(move |next| head.iter().copied().chain([next]).collect::<Vec<i64>>())
        };
        partial.into_iter().flat_map(extended).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::MAX_FRACTION_BITS;
    use hoverlock_reference::smoothing::recursive::{Family, Recursive};
    use hoverlock_reference::smoothing::smoother::Residuals;
    use proptest::prelude::*;

    fn any_family() -> impl Strategy<Value = Family> {
        prop::sample::select(Family::all().collect::<Vec<_>>())
    }

    fn round(family: Family, sigma: f64, bits: u32) -> Result<(DirectForm, IntegerDirectForm), CoefficientError> {
        let exact = Recursive::design(family, family.fits()[0], sigma)?.direct_form();
        let rounded = IntegerDirectForm::round(&exact, sigma, bits)?;
        Ok((exact, rounded))
    }

    #[test]
    fn the_first_order_filter_is_rounded_to_nearest() {
        let (_, form) = round(Family::FirstOrder, 2.0, 16).unwrap();
        // a = 0.625615: 41000.3 of 65536; B is what is left, the g of the lerp.
        assert_eq!((form.a, form.b), (vec![41000], vec![24536]));
    }

    #[test]
    fn more_bits_give_a_smaller_error() {
        for family in Family::all() {
            let error = |bits| {
                let (exact, rounded) = round(family, 3.2, bits).unwrap();
                Residuals::between(&rounded.real().impulse_response(), &exact.impulse_response()).l2
            };
            assert!(error(20) < 0.3 * error(14) && error(26) < 0.3 * error(20), "{family:?}");
        }
    }

    #[test]
    fn too_few_bits_are_refused() {
        for bits in [0, 32, 200] {
            assert_eq!(round(Family::YoungVanVliet, 5.0, bits).unwrap_err(), CoefficientError::FractionBits(bits),);
        }
        // Four bits cannot distinguish poles 1 - O(1/sigma) from 1.
        let message = round(Family::YoungVanVliet, 30.0, 4).unwrap_err().to_string();
        assert!(message.contains("4 fraction bits") && message.contains("sigma 30"), "{message}");
    }

    /// In few bits poles come to lie on the unit circle itself, where stability is a matter of the last bit.
    #[test]
    fn poles_on_the_circle_are_refused() {
        let family = Family::VanVlietYoungVerbeek { order: 4 };
        if let Ok((_, rounded)) = round(family, 4.697367608898545, 3) {
            let response = rounded.real().impulse_response();
            let dc_gain = Residuals::between(&response, &response).dc_gain;
            assert!((dc_gain - 1.0).abs() < 1e-6, "{dc_gain}");
        }
    }

    #[test]
    fn the_width_is_the_least_number_of_bits() {
        let form = |a: i64| IntegerDirectForm {
            frac_bits: 4,
            structure: Structure::Cascade,
            a: vec![a],
            b: vec![1],
            b_ahead: vec![],
        };
        for (raw, width) in [(1, 2), (127, 8), (128, 9), (-128, 8), (-129, 9), (-1, 2)] {
            assert_eq!(form(raw).width(), width, "{raw}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn dc_is_exact_and_poles_are_inside(
            family in any_family(), sigma in 0.5..10.0f64, bits in 1..=MAX_FRACTION_BITS,
        ) {
            match round(family, sigma, bits) {
                Ok((_, rounded)) => {
                    let (numerator, denominator) = rounded.dc_gain();
                    prop_assert!(numerator == denominator && denominator >= 1);
                    prop_assert!(rounded.real().is_stable());
                    // By simulation as well: the response of an unstable filter would not end, nor sum to 1.
                    let response = rounded.real().impulse_response();
                    let dc_gain = Residuals::between(&response, &response).dc_gain;
                    prop_assert!((dc_gain - 1.0).abs() < 1e-6, "{}", dc_gain);
                }
                // With enough bits a rounding always exists.
                Err(error) => prop_assert!(bits < 14, "{}", error),
            }
        }

        #[test]
        fn constants_pass_unchanged_in_integers(
            sigma in 0.5..10.0f64, bits in 14..=24u32, value in 0i64..1 << 18, family in any_family(),
        ) {
            let (_, rounded) = round(family, sigma, bits).unwrap();
            if rounded.structure == Structure::Cascade {
                // In the settled state of a constant the next output, rounded half up, is the constant.
                let sum = rounded.a.iter().chain(&rounded.b).map(|raw| raw * value).sum::<i64>();
                prop_assert_eq!((sum + (1 << (bits - 1))) >> bits, value);
            }
        }
    }
}
