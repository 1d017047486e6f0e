//! The lerp of a coefficient of 16 bits in signed 32-bit arithmetic.

/// A coefficient prepared for [`cell`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Gain {
    /// `c`, or `2^16 - c` where that is smaller; at most `2^15`.
    pub raw: i32,
    /// `raw` is the complement.
    pub complement: bool,
}

impl Gain {
    pub fn new(raw: u32) -> Self {
        let complement = raw > 1 << 15;
        let raw = if complement { (1 << 16) - raw } else { raw };
        Self { raw: raw as i32, complement }
    }

    /// Returns `true` if the product must be split to fit 32 bits.
    pub fn split(self) -> bool {
        self.raw > 8191
    }
}

/// Computes `p + round(c (q - p))`. The arithmetic never overflows. Wrapping operators let builds with overflow checks
/// be vectorised.
#[inline(always)]
pub(super) fn cell<const COMPLEMENT: bool, const SPLIT: bool>(p: i32, q: i32, raw: i32) -> i32 {
    let e = q.wrapping_sub(p);
    let m = e >> 31;
    let bias = if COMPLEMENT { 0x7fffi32.wrapping_sub(m) } else { 0x8000i32.wrapping_add(m) };
    let t = if SPLIT {
        let low = (raw.wrapping_mul(e & 3).wrapping_add(bias)) >> 2;
        raw.wrapping_mul(e >> 2).wrapping_add(low) >> 14
    } else {
        raw.wrapping_mul(e).wrapping_add(bias) >> 16
    };
    if COMPLEMENT { q.wrapping_sub(t) } else { p.wrapping_add(t) }
}

/// Calls `$body` with the cell for a coefficient, so that the selection is outside the loops.
macro_rules! with_cell {
    ($gain:expr, $cell:ident => $body:expr) => {{
        let gain: $crate::model::simd::cell::Gain = $gain;
        let raw = gain.raw;
        match (gain.complement, gain.split()) {
            (false, false) => {
                let $cell = |p, q| $crate::model::simd::cell::cell::<false, false>(p, q, raw);
                $body
            }
            (false, true) => {
                let $cell = |p, q| $crate::model::simd::cell::cell::<false, true>(p, q, raw);
                $body
            }
            (true, false) => {
                let $cell = |p, q| $crate::model::simd::cell::cell::<true, false>(p, q, raw);
                $body
            }
            (true, true) => {
                let $cell = |p, q| $crate::model::simd::cell::cell::<true, true>(p, q, raw);
                $body
            }
        }
    }};
}
pub(super) use with_cell;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::bit_true::BitTrue;
    use crate::model::lerp::lerp;
    use hoverlock_design::KT27;

    fn by_gain(p: i32, q: i32, gain: Gain) -> i32 {
        with_cell!(gain, cell => cell(p, q))
    }

    /// Checks all differences for one coefficient. Except for the final sum, the result depends on `q - p` only.
    fn every_difference(raw: u32) {
        const TOP: i32 = 65535 << 2;
        let gain = Gain::new(raw);
        for e in 0..=TOP {
            assert_eq!(by_gain(0, e, gain), lerp(0, e as u32, raw, 16) as i32, "{raw} x {e}");
            assert_eq!(by_gain(TOP, TOP - e, gain), lerp(TOP as u32, (TOP - e) as u32, raw, 16) as i32, "{raw} x -{e}");
        }
    }

    #[test]
    fn cell_is_the_lerp_for_every_difference_and_design_coefficient() {
        for coefficients in BitTrue::new(&KT27).unwrap().coefficients() {
            every_difference(coefficients.g);
            coefficients.g_j.iter().for_each(|raw| every_difference(*raw));
        }
        // Both ends of the range of each formula.
        for raw in [1, 8191, 8192, 32767, 32768, 32769, 57344, 57345, 65535] {
            every_difference(raw);
        }
    }

    #[test]
    fn cell_is_the_lerp_for_every_coefficient_at_the_extremes() {
        for raw in 1..1u32 << 16 {
            let gain = Gain::new(raw);
            for e in [1, 2, 3, 4, 5, 131_070, 131_072, 262_135, 262_137, 262_138, 262_139, 262_140] {
                for (p, q) in [(0, e), (e, 0)] {
                    assert_eq!(by_gain(p, q, gain), lerp(p as u32, q as u32, raw, 16) as i32, "{raw}: {p} {q}");
                }
            }
        }
    }
}
