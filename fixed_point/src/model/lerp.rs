//! The one cell that builds every filter: `y = p + round(c (q - p))`, `c = code 2^-F` in `[0, 1)`.
//!
//! On sign and magnitude, with `d = |q - p|`: `t = (code d + 2^(F-1)) >> F`, `y = p + t` where `q >= p`, else `p - t`.
//! All of it is unsigned, so it takes one unsigned multiplier (18 x 16 bits at the design point, an 18x18 of the Arria V).
//!
//! - It rounds half away from `p`, the same in both directions: exchanging the signs of all words exchanges the sign of
//!   the result, so there is no bias.
//! - `y` lies between `p` and `q`: `t <= (d (2^F - 1) + 2^(F-1)) / 2^F < d + 1/2`, and `t` is whole, so `t <= d`. Nothing
//!   built from it can overflow, saturate or grow in width, and a constant passes unchanged whatever the coefficients.
//! - It errs by half an LSB at most.

use crate::model::coefficients::MAX_FRACTION_BITS;

/// `p + round(c (q - p))` with the coefficient `c = code / 2^fraction_bits`.
///
/// Wants `code < 2^fraction_bits` and `1 <= fraction_bits <= `[`MAX_FRACTION_BITS`]: checked where coefficients are made.
#[inline]
pub fn lerp(p: u32, q: u32, code: u32, fraction_bits: u32) -> u32 {
    debug_assert!((1..=MAX_FRACTION_BITS).contains(&fraction_bits) && code >> fraction_bits == 0);
    let product = u64::from(code) * u64::from(p.abs_diff(q));
    let t = ((product + (1 << (fraction_bits - 1))) >> fraction_bits) as u32;
    if q >= p { p + t } else { p - t }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A word of up to 32 bits and a coefficient of up to 31, extremes included.
    fn cell() -> impl Strategy<Value = (u32, u32, u32, u32)> {
        (1..=32u32, 1..=MAX_FRACTION_BITS).prop_flat_map(|(bits, fraction_bits)| {
            let max = (u64::MAX >> (64 - bits)) as u32;
            let word = prop_oneof![6 => 0..=max, 1 => Just(0), 1 => Just(max)];
            let top = (1u32 << fraction_bits) - 1;
            let code = prop_oneof![6 => 0..=top, 1 => Just(0), 1 => Just(top)];
            (word.clone(), word, code, Just(fraction_bits))
        })
    }

    #[test]
    fn halves_go_away_from_p() {
        // c = 1/2: 0 -> 5 gives 2.5, away from p = 0 is 3; from p = 5 the way of 2.5 is rounded up, so 5 - 3.
        assert_eq!((lerp(0, 5, 1, 1), lerp(5, 0, 1, 1)), (3, 2));
        // The largest word and the largest coefficient of the design point.
        assert_eq!(lerp(0, 262_143, 65535, 16), 262_139);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn stays_between_its_inputs((p, q, code, fraction_bits) in cell()) {
            let y = lerp(p, q, code, fraction_bits);
            prop_assert!((p.min(q)..=p.max(q)).contains(&y), "{y}");
        }

        #[test]
        fn errs_by_half_an_lsb_at_most((p, q, code, fraction_bits) in cell()) {
            // In units of 2^-F LSB everything is whole, so the comparison is exact.
            let exact = (i128::from(p) << fraction_bits) + i128::from(code) * (i128::from(q) - i128::from(p));
            let error = (i128::from(lerp(p, q, code, fraction_bits)) << fraction_bits) - exact;
            prop_assert!(error.abs() <= 1 << (fraction_bits - 1), "{error} / 2^{fraction_bits}");
        }

        #[test]
        fn is_odd_symmetric((p, q, code, fraction_bits) in cell()) {
            // Complementing every bit reflects the number line; the cell must not notice.
            prop_assert_eq!(lerp(!p, !q, code, fraction_bits), !lerp(p, q, code, fraction_bits));
        }

        #[test]
        fn rises_with_the_coefficient((p, q, code, fraction_bits) in cell()) {
            prop_assume!(code > 0);
            let (less, more) = (lerp(p, q, code - 1, fraction_bits), lerp(p, q, code, fraction_bits));
            prop_assert!(p.abs_diff(more) >= p.abs_diff(less));
        }
    }
}
