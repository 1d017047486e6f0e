//! The arithmetic cell of every filter, linear interpolation (lerp): `y = p + round(c (q - p))`, `c = raw 2^-F` in `[0,
//! 1)`.
//!
//! In sign and magnitude, with `d = |q - p|`: `t = (raw d + 2^(F-1)) >> F`, `y = p + t` where `q >= p`, else `p - t`.
//! All operands are unsigned, so it needs one unsigned multiplier (18 x 16 bits at the design point, an 18x18 of the
//! Arria V).
//!
//! - It rounds half away from `p`, the same in both directions: negating all operands negates
//!   the result, so there is no bias.
//! - `y` lies between `p` and `q`: `t <= (d (2^F - 1) + 2^(F-1)) / 2^F < d + 1/2`, and `t` is whole, so `t <= d`. A
//!   filter of lerps cannot overflow, saturate or grow in width, and passes a constant unchanged with any coefficients.
//! - Its rounding error is at most half an LSB.

use hoverlock_design::MAX_FRACTION_BITS;

/// Interpolates: `p + round(c (q - p))` with the coefficient `c = raw / 2^fraction_bits`.
///
/// Requires `raw < 2^fraction_bits` and `1 <= fraction_bits <= `[`MAX_FRACTION_BITS`]: checked where coefficients are
/// designed.
#[inline]
pub fn lerp(p: u32, q: u32, raw: u32, fraction_bits: u32) -> u32 {
    debug_assert!((1..=MAX_FRACTION_BITS).contains(&fraction_bits) && raw >> fraction_bits == 0);
    let product = u64::from(raw) * u64::from(p.abs_diff(q));
    let t = ((product + (1 << (fraction_bits - 1))) >> fraction_bits) as u32;
    if q >= p { p + t } else { p - t }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Samples of up to 32 bits and a coefficient of up to 31, extremes included.
    fn cell() -> impl Strategy<Value = (u32, u32, u32, u32)> {
        (1..=32u32, 1..=MAX_FRACTION_BITS).prop_flat_map(|(bits, fraction_bits)| {
            let max = (u64::MAX >> (64 - bits)) as u32;
            let sample = prop_oneof![6 => 0..=max, 1 => Just(0), 1 => Just(max)];
            let top = (1u32 << fraction_bits) - 1;
            let raw = prop_oneof![6 => 0..=top, 1 => Just(0), 1 => Just(top)];
            (sample.clone(), sample, raw, Just(fraction_bits))
        })
    }

    #[test]
    fn halves_go_away_from_p() {
        // c = 1/2: 0 -> 5 gives 2.5, away from p = 0 is 3; from p = 5 the way of 2.5 is rounded up, so 5 - 3.
        assert_eq!((lerp(0, 5, 1, 1), lerp(5, 0, 1, 1)), (3, 2));
        // The largest sample and the largest coefficient of the design point.
        assert_eq!(lerp(0, 262_143, 65535, 16), 262_139);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn stays_between_its_inputs((p, q, raw, fraction_bits) in cell()) {
            let y = lerp(p, q, raw, fraction_bits);
            prop_assert!((p.min(q)..=p.max(q)).contains(&y), "{y}");
        }

        #[test]
        fn rounding_error_is_at_most_half_an_lsb((p, q, raw, fraction_bits) in cell()) {
            // In units of 2^-F LSB everything is whole, so the comparison is exact.
            let exact = (i128::from(p) << fraction_bits) + i128::from(raw) * (i128::from(q) - i128::from(p));
            let error = (i128::from(lerp(p, q, raw, fraction_bits)) << fraction_bits) - exact;
            prop_assert!(error.abs() <= 1 << (fraction_bits - 1), "{error} / 2^{fraction_bits}");
        }

        #[test]
        fn negated_operands_negate_the_result((p, q, raw, fraction_bits) in cell()) {
            // Complementing every bit mirrors the number range.
            prop_assert_eq!(lerp(!p, !q, raw, fraction_bits), !lerp(p, q, raw, fraction_bits));
        }

        #[test]
        fn a_larger_coefficient_moves_further_from_p((p, q, raw, fraction_bits) in cell()) {
            prop_assume!(raw > 0);
            let (less, more) = (lerp(p, q, raw - 1, fraction_bits), lerp(p, q, raw, fraction_bits));
            prop_assert!(p.abs_diff(more) >= p.abs_diff(less));
        }
    }
}
