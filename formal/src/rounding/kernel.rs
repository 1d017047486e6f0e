//! The largest difference of two smoothers, rounded outward in integers.
//!
//! ```text
//! d(y, x) = sum_{i,j} (u1[i] v1[j] - u2[i] v2[j]) pixel[i, j],    u, v >= 0,    sum u = sum v = 1
//! 0 <= pixel <= FS   =>   |d| <= FS S,    S = sum_{i,j} max(0, u1[i] v1[j] - u2[i] v2[j])
//! ```
//!
//! `S` is half the L1 norm of the difference, because the sum of all weights is 0. `u` are the weights of a column of
//! pixels, `v` those of a row, for the two smoothers of a pair.
//!
//! **Borders.** Each stage holds the border sample of its own input.
//!
//! - Below and to the left the stages that come first, `column_look_ahead` and `row_look_back`, see the border of the
//!   picture itself. The frame is a picture without this border whose samples beyond are equal. A bound for all
//!   pictures is one for those too.
//! - To the right `row_look_ahead` holds a sample of the stage before. The weights depend on the distance from the
//!   border, up to the reach `2^m - 1`. So `S` is the largest over these distances.
//! - Above, `recursion` starts from a row of look-ahead: row `y` has the weight `a^y`, `a = 1 - g`, of this row and of
//!   all above it on this row. `S` is the largest over the first rows, three reaches or more. Two rows below
//!   differ by at most `2 a^y` in the L1 norm of the weights of each smoother, so for the others `2 (a_1^y + a_2^y)`,
//!   `y` the last of these rows, is added.

use super::Smoother;

/// Fraction bits of a weight: 1 is `2^31`, and a product of two weights has 62.
const WEIGHT_BITS: u32 = 31;

/// The weights of the samples of a line, each bracketed by `low` and `high`, in units of `2^-31`.
struct Weights {
    low: Vec<u64>,
    high: Vec<u64>,
    /// Upper bound of the weight that the recursion has left on its first row.
    rest: u64,
}

/// Returns the number of rows from the upper border on that are computed one by one.
fn first_rows(reach: usize) -> usize {
    (3 * reach).max(32)
}

/// Returns an upper bound of `S` for two smoothers, in units of `2^-62`.
pub(super) fn largest_difference(narrow: &Smoother, wide: &Smoother, bits: u32) -> u128 {
    let reach = 1usize << narrow.g_j.len().max(wide.g_j.len());
    let lines = |positions: usize, vertical: bool| {
        let of = |smoother: &Smoother, from_border| weights(smoother, bits, reach, from_border, vertical);
        (0..positions).map(|from_border| [of(narrow, from_border), of(wide, from_border)]).collect::<Vec<_>>()
    };
    let (columns, rows) = (lines(first_rows(reach), true), lines(reach, false));
    let others: u64 = columns.last().map_or(0, |last| last.iter().map(|weights| weights.rest).sum());
    let pairs = columns.iter().flat_map(|column| rows.iter().map(move |row| positive_part(column, row)));
    pairs.max().unwrap_or(0) + (u128::from(others) << (WEIGHT_BITS + 1))
}

/// Returns an upper bound of `S` at one position.
fn positive_part([u1, u2]: &[Weights; 2], [v1, v2]: &[Weights; 2]) -> u128 {
    let row = |(u1, u2): (&u64, &u64)| -> u128 {
        if *u1 == 0 {
            return 0;
        }
        let products = v1.high.iter().zip(&v2.low);
        u128::from(products.map(|(v1, v2)| (u1 * v1).saturating_sub(u2 * v2)).sum::<u64>())
    };
    u1.high.iter().zip(&u2.low).map(row).sum()
}

/// Computes the weights of the samples of a line in the output that is `from_border` samples from the border: below the
/// first of a column, before the last of a row. Goes from the last stage to the first; each stage passes the weight of
/// its output on to its two inputs.
fn weights(smoother: &Smoother, bits: u32, reach: usize, from_border: usize, vertical: bool) -> Weights {
    // Weights do not get to the other end: a line is longer than the distance and both reaches.
    let length = if vertical { first_rows(reach) + reach } else { 3 * reach };
    let at = if vertical { from_border } else { length - 1 - from_border };
    let mut line = Weights { low: vec![0; length], high: vec![0; length], rest: 0 };
    (line.low[at], line.high[at]) = (1 << WEIGHT_BITS, 1 << WEIGHT_BITS);
    let ahead = |j: usize| move |n: usize| (n + (1 << j)).min(length - 1);
    let stages = || smoother.g_j.iter().copied().enumerate();
    if vertical {
        line.recursion(smoother.g, bits);
        stages().for_each(|(j, g)| line.spread(g, bits, ahead(j)));
    } else {
        stages().rev().for_each(|(j, g)| line.spread(g, bits, ahead(j)));
        stages().rev().for_each(|(j, g)| line.spread(g, bits, |n| n.saturating_sub(1 << j)));
    }
    line
}

impl Weights {
    /// Passes the weights through a stage `y[n] = g u[n] + (1 - g) u[other(n)]`.
    fn spread(&mut self, g: u32, bits: u32, other: impl Fn(usize) -> usize) {
        let (g, rest) = (u64::from(g), (1u64 << bits) - u64::from(g));
        let (mut low, mut high) = (vec![0; self.low.len()], vec![0; self.high.len()]);
        for n in 0..low.len() {
            low[n] += (self.low[n] * g) >> bits;
            high[n] += (self.high[n] * g).div_ceil(1 << bits);
            low[other(n)] += (self.low[n] * rest) >> bits;
            high[other(n)] += (self.high[n] * rest).div_ceil(1 << bits);
        }
        (self.low, self.high) = (low, high);
    }

    /// Passes the weights through the recursion `s[n] = g u[n] + (1 - g) s[n-1]`, `s[0] = u[0]`.
    fn recursion(&mut self, g: u32, bits: u32) {
        let (g, rest) = (u64::from(g), (1u64 << bits) - u64::from(g));
        let (mut low, mut high) = (0, 0);
        for n in (1..self.low.len()).rev() {
            (low, high) = (low + self.low[n], high + self.high[n]);
            (self.low[n], self.high[n]) = ((low * g) >> bits, (high * g).div_ceil(1 << bits));
            (low, high) = ((low * rest) >> bits, (high * rest).div_ceil(1 << bits));
        }
        (self.low[0], self.high[0]) = (low + self.low[0], high + self.high[0]);
        self.rest = self.high[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_bracket_those_in_floating_point() {
        let smoother = Smoother { g: 24536, g_j: vec![40315, 47101, 56830] };
        for (vertical, from_border) in [(true, 0), (true, 3), (true, 23), (false, 0), (false, 2), (false, 7)] {
            let line = weights(&smoother, 16, 8, from_border, vertical);
            // The smoother on the unit samples, forward.
            for n in 0..line.low.len() {
                let mut u: Vec<f64> = (0..line.low.len()).map(|k| f64::from(u8::from(k == n))).collect();
                let length = u.len();
                let g = |raw: u32| f64::from(raw) / 65536.0;
                let mut stages: Vec<_> = smoother.g_j.iter().enumerate().collect();
                if vertical {
                    stages.reverse();
                } else {
                    for &(j, &raw) in &stages {
                        let before = |k: usize| u[k.saturating_sub(1 << j)];
                        u = (0..length).map(|k| before(k) + g(raw) * (u[k] - before(k))).collect();
                    }
                }
                for (j, &raw) in stages {
                    let after = |k: usize| u[(k + (1 << j)).min(length - 1)];
                    u = (0..length).map(|k| after(k) + g(raw) * (u[k] - after(k))).collect();
                }
                if vertical {
                    for k in 1..length {
                        u[k] = u[k - 1] + g(smoother.g) * (u[k] - u[k - 1]);
                    }
                }
                let at = if vertical { from_border } else { length - 1 - from_border };
                let expected = u[at] * f64::from(1u32 << WEIGHT_BITS);
                let (low, high) = (line.low[n] as f64, line.high[n] as f64);
                assert!(low - 0.01 <= expected && expected <= high + 0.01, "{vertical} {n}: {low} {expected} {high}");
                assert!(high - low < 1e3, "{n}: {low} {high}");
            }
        }
    }
}
