//! Worst-case error of each model level, derived from the coefficients. Tests check every level against these bounds.
//!
//! Every lerp is a weighted mean of its two inputs. A smoother is therefore a weighted mean too: it does not amplify an
//! error of its input, and the errors of successive stages add.
//!
//! - **Integers against the same coefficients in f64.** Each lerp rounds by at most half a state LSB. The `m` column
//!   look-ahead stages add `m / 2`. In the recursion behind them `|e[r]| <= (1 - g) |e[r-1]| + g m / 2 + 1/2`, from
//!   `|e[0]| <= m / 2`, stays within `m / 2 + 1/(2 g)`: the second term is the dead band, within which a state does not
//!   follow its input. With `2 m` stages along the rows `|e| <= 1/(2 g) + 3 m / 2` state LSB.
//! - **Rounded coefficients.** A coefficient error of `delta` gives an error of `|delta| |q - p| <= |delta| R`, `R` the
//!   range of the picture (largest less smallest pixel): `|e| <= (|delta_g| / g + 3 sum_j |delta_j|) R`, `g` the
//!   rounded one.
//! - **Finite look-ahead.** A chain over `2^m` samples omits the weight `a^(2^m)` and distributes it over the other
//!   samples: `a^(2^m) R` for each of three chains.
//! - **Recursion in place of the Gaussian.** With `h` and `w` the two impulse responses, the error of one pass is at
//!   most half the l1 norm of their difference times `R`; both passes add: `||h - w||_1 R`. Repeating the border sample
//!   of each pass, not of the picture, changes the weights of the samples beyond the border: `a^(y + 1) R + a^(W - x)
//!   R` more.
//!
//! **Saturation.** `d_k` at a position is a weighted sum of pixels; it is largest with white where the weight is
//! positive and black elsewhere, so `|d_k| <= FS sum of the positive weights` (the negative weights have the same sum).
//! At the left and lower borders, where the first pass of a line comes from, weights fall together, which lessens the
//! sum: the frame is one without that border whose samples beyond it are equal. At the right border the stages hold a
//! sample of the stage before, so the weights change with the position, up to one reach from the border. At the upper
//! border the recursion starts from a row of look-ahead: the weight `a^y` of the rows above is on that row. From three
//! of the longest reaches on, and at least 32 rows, it is added to the sum in full, so the largest over the positions
//! up to there from the upper right corner bounds that of any frame.

use hoverlock_reference::image::plane::Plane;
use rayon::prelude::*;

use crate::model::stages::{Stage, StageCoefficients};

/// Returns the largest difference of an integer smoother from the same coefficients in f64, LSB of the state.
pub fn rounding(coefficients: &StageCoefficients<f64>) -> f64 {
    dead_band(coefficients.g) + 1.5 * coefficients.g_j.len() as f64
}

/// Returns the dead band, `1/(2 g)` LSB: the settled state of the recursion differs from a constant input by less.
fn dead_band(g: f64) -> f64 {
    0.5 / g
}

/// Returns the largest difference of a smoother with rounded coefficients from the unrounded one, relative to the range
/// of the picture.
pub fn coefficient(unrounded: &StageCoefficients<f64>, rounded: &StageCoefficients<f64>) -> f64 {
    let reach: f64 = unrounded.g_j.iter().zip(&rounded.g_j).map(|(from, to)| (from - to).abs()).sum();
    (unrounded.g - rounded.g).abs() / rounded.g + 3.0 * reach
}

/// Returns the largest difference of a smoother with finite look-ahead from the infinite one, relative to the range of
/// the picture.
pub fn reach(unrounded: &StageCoefficients<f64>) -> f64 {
    let a = 1.0 - unrounded.g;
    3.0 * a.powf((unrounded.g_j.len() as f64).exp2())
}

/// Computes `||h - w||_1` of two symmetric impulse responses `h[0 ..]` and `w[0 ..]`: the largest difference of the two
/// smoothers away from the borders, relative to the range of the picture.
pub fn response_difference(h: &[f64], w: &[f64]) -> f64 {
    let at = |half: &[f64], n: usize| half.get(n).copied().unwrap_or(0.0);
    let side = |n: usize| if n == 0 { 1.0 } else { 2.0 };
    (0..h.len().max(w.len())).map(|n| side(n) * (at(h, n) - at(w, n)).abs()).sum()
}

/// Computes the largest `|d_k|` of any frame before rounding, relative to full scale.
pub fn largest_difference(narrow: &StageCoefficients<f64>, wide: &StageCoefficients<f64>) -> f64 {
    let reach = 1usize << narrow.g_j.len().max(wide.g_j.len());
    // Below this row the weight `a^y` of a smoother, which the recursion leaves on its first row, may be anywhere.
    let rows = (3 * reach).max(32);
    let length = rows + 2 * reach;
    let moved = [narrow, wide].map(|coefficients| 2.0 * (1.0 - coefficients.g).powi(rows as i32));
    let down = [narrow, wide].map(|coefficients| {
        let weights = weights(coefficients, length, true);
        (0..=rows).map(|y| weights.row(y).to_vec()).collect::<Vec<_>>()
    });
    let along = [narrow, wide].map(|coefficients| {
        let weights = weights(coefficients, length, false);
        (0..=reach).map(|from_end| weights.row(length - 1 - from_end).to_vec()).collect::<Vec<_>>()
    });
    let largest = (0..=rows)
        .into_par_iter()
        .map(|y| {
            let positions = along[0].iter().zip(&along[1]);
            positions.map(|(narrow, wide)| positive_part(&down[0][y], narrow, &down[1][y], wide)).fold(0.0, f64::max)
        })
        .reduce(|| 0.0, f64::max);
    largest + moved.iter().sum::<f64>()
}

/// Computes the weights of a pass: row `n` holds the weights of all samples of a line in sample `n` after the vertical
/// or the horizontal pass.
fn weights(coefficients: &StageCoefficients<f64>, length: usize, vertical: bool) -> Plane<f64> {
    let mut plane = Plane::from_fn(length, length, |x, y| f64::from(u8::from(x == y)));
    for stage in Stage::chain(coefficients.g_j.len() as u32) {
        if vertical == matches!(stage, Stage::Recursion | Stage::ColumnLookAhead(_)) {
            plane = stage.apply(&plane, coefficients, |p, q, c| p + c * (q - p));
        }
    }
    if vertical { plane } else { plane.transposed() }
}

/// Computes `sum_{i,j} max(0, u1[i] v1[j] - u2[i] v2[j])`.
fn positive_part(u1: &[f64], v1: &[f64], u2: &[f64], v2: &[f64]) -> f64 {
    let row = |u1: f64, u2: f64| v1.iter().zip(v2).map(|(v1, v2)| (u1 * v1 - u2 * v2).max(0.0)).sum::<f64>();
    // A row without weight adds nothing.
    u1.iter().zip(u2).filter(|(u1, _)| **u1 > 0.0).map(|(u1, u2)| row(*u1, *u2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::bit_true::BitTrue;
    use crate::model::lerp::lerp;
    use hoverlock_design::KT27;
    use proptest::prelude::*;

    /// `FS` in state LSB.
    const FULL_SCALE: f64 = 65535.0 * 4.0;

    #[test]
    fn saturation_is_impossible_at_the_design_point() {
        let model = BitTrue::new(&KT27).unwrap();
        let coefficients: Vec<_> =
            model.coefficients().iter().map(|coefficients| coefficients.values(KT27.coefficient)).collect();
        for k in 0..2 {
            let share = largest_difference(&coefficients[k], &coefficients[k + 1]);
            let largest = share * FULL_SCALE + rounding(&coefficients[k]) + rounding(&coefficients[k + 1]);
            // (|d| + 1) >> 1 passes 2^15 - 1 from |d| = 65535 on.
            assert!(largest < 65535.0, "pair {k}: {share} of full scale, {largest} LSB");

            // The picture with the largest |d| in mid-frame reaches the bound within the rounding, and does not
            // saturate.
            let size = 401;
            let centre = size / 2;
            let [narrow, wide] = [k, k + 1].map(|smoother| {
                [true, false].map(|vertical| weights(&coefficients[smoother], size, vertical).row(centre).to_vec())
            });
            let weight = |x: usize, y: usize| narrow[0][y] * narrow[1][x] - wide[0][y] * wide[1][x];
            let worst = Plane::from_fn(size, size, |x, y| if weight(x, y) > 0.0 { u16::MAX } else { 0 });
            let planes = model.planes(&worst);
            let reached = f64::from(planes.signed_dog[k][(centre, centre)]);
            let expected = positive_part(&narrow[0], &narrow[1], &wide[0], &wide[1]) * FULL_SCALE;
            assert!(
                (reached - expected).abs() <= rounding(&coefficients[k]) + rounding(&coefficients[k + 1]),
                "{reached} {expected}"
            );
            assert!(reached <= largest && reached > 0.97 * largest, "pair {k}: {reached} of {largest}");
            assert_eq!(planes.saturated, [0, 0]);
        }
    }

    #[test]
    fn largest_difference_of_full_scale_is_that_of_the_design() {
        // 0.243 FS for the coarse pair with filters of endless reach; a reach of 31 and 63 takes nothing visible off
        // it.
        let coefficients = [(2.0, 5), (3.2, 5), (5.12, 6)].map(|(sigma, m)| {
            StageCoefficients::of_pole(hoverlock_reference::smoothing::recursive::first_order::pole(sigma).unwrap(), m)
        });
        assert!((largest_difference(&coefficients[0], &coefficients[1]) - 0.236).abs() < 0.0005);
        assert!((largest_difference(&coefficients[1], &coefficients[2]) - 0.243).abs() < 0.0005);
    }

    proptest! {
        #[test]
        fn the_recursion_settles_within_its_dead_band(
            from in 0u32..1 << 20, to in 0u32..1 << 20, fraction_bits in 6..20u32, part in 0.02..0.98f64,
        ) {
            let raw = (part * f64::from(1u32 << fraction_bits)) as u32;
            let g = f64::from(raw) / f64::from(1u32 << fraction_bits);
            let mut state = from;
            loop {
                let next = lerp(state, to, raw, fraction_bits);
                if next == state {
                    break;
                }
                prop_assert!(next.abs_diff(to) < state.abs_diff(to), "the state must approach the input");
                state = next;
            }
            let rest = f64::from(state.abs_diff(to));
            prop_assert!(rest < dead_band(g), "{rest} LSB, g = {g}");
            // The bound is tight: one LSB further out the state still moves.
            let outer = dead_band(g).ceil() as u32;
            prop_assert!(lerp(to, to + outer, raw, fraction_bits) != to);
        }
    }
}
