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
//! - Above and to the left the stages that look back come first: `recursion` and `row_look_back` see the border of the
//!   picture itself. The frame is a picture without this border whose samples beyond are equal. A bound for all
//!   pictures is one for those too.
//! - Below and to the right `column_look_ahead` and `row_look_ahead` hold a sample of the stage before. The weights
//!   depend on the distance from the border, up to the reach `2^m - 1`. So `S` is the largest over these distances.

use super::Smoother;

/// Fraction bits of a weight: 1 is `2^31`, and a product of two weights has 62.
const WEIGHT_BITS: u32 = 31;

/// The weights of the samples of a line, each bracketed by `low` and `high`, in units of `2^-31`.
struct Weights {
    low: Vec<u64>,
    high: Vec<u64>,
    /// Upper bound of the total weight of all samples before the first.
    rest: u64,
}

/// Returns an upper bound of `S` for two smoothers, in units of `2^-62`.
pub(super) fn largest_difference(narrow: &Smoother, wide: &Smoother, bits: u32) -> u128 {
    let reach = 1usize << narrow.g_j.len().max(wide.g_j.len());
    let lines = |vertical: bool| {
        let of = |smoother: &Smoother, from_end| weights(smoother, bits, reach, from_end, vertical);
        (0..reach).map(|from_end| [of(narrow, from_end), of(wide, from_end)]).collect::<Vec<_>>()
    };
    let (columns, rows) = (lines(true), lines(false));
    let pairs = columns.iter().flat_map(|column| rows.iter().map(move |row| positive_part(column, row)));
    pairs.max().unwrap_or(0)
}

/// Returns an upper bound of `S` at one position; the weight of omitted samples is added in full.
fn positive_part([u1, u2]: &[Weights; 2], [v1, v2]: &[Weights; 2]) -> u128 {
    let row = |(u1, u2): (&u64, &u64)| -> u128 {
        if *u1 == 0 {
            return 0;
        }
        let products = v1.high.iter().zip(&v2.low);
        u128::from(products.map(|(v1, v2)| (u1 * v1).saturating_sub(u2 * v2)).sum::<u64>())
    };
    let left_out = u128::from(u1.rest + v1.rest) << (WEIGHT_BITS + 1);
    u1.high.iter().zip(&u2.low).map(row).sum::<u128>() + left_out
}

/// Computes the weights of the samples of a line in the output `from_end` before the last. Goes from the last stage to
/// the first; each stage passes the weight of its output on to its two inputs.
fn weights(smoother: &Smoother, bits: u32, reach: usize, from_end: usize, vertical: bool) -> Weights {
    let length = if vertical { 5 * reach } else { 3 * reach };
    let at = length - 1 - from_end;
    let mut line = Weights { low: vec![0; length], high: vec![0; length], rest: 0 };
    (line.low[at], line.high[at]) = (1 << WEIGHT_BITS, 1 << WEIGHT_BITS);
    for (j, &g) in smoother.g_j.iter().enumerate().rev() {
        line.spread(g, bits, |n| (n + (1 << j)).min(length - 1));
    }
    if vertical {
        line.recursion(smoother.g, bits);
    } else {
        for (j, &g) in smoother.g_j.iter().enumerate().rev() {
            // Weights do not get to the first sample: the line is longer than both reaches.
            line.spread(g, bits, |n| n.saturating_sub(1 << j));
        }
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

    /// Passes the weights through the recursion `s[n] = g x[n] + (1 - g) s[n-1]`; the remainder at the first sample is
    /// the weight of all samples before it.
    fn recursion(&mut self, g: u32, bits: u32) {
        let (g, rest) = (u64::from(g), (1u64 << bits) - u64::from(g));
        let (mut low, mut high) = (0, 0);
        for n in (0..self.low.len()).rev() {
            (low, high) = (low + self.low[n], high + self.high[n]);
            (self.low[n], self.high[n]) = ((low * g) >> bits, (high * g).div_ceil(1 << bits));
            (low, high) = ((low * rest) >> bits, (high * rest).div_ceil(1 << bits));
        }
        self.rest = high;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_bracket_those_in_floating_point() {
        let smoother = Smoother { g: 24536, g_j: vec![40315, 47101, 56830] };
        for (vertical, from_end) in [(true, 0), (true, 3), (true, 7), (false, 0), (false, 2), (false, 7)] {
            let line = weights(&smoother, 16, 8, from_end, vertical);
            // The smoother on the unit samples, forward.
            for n in 0..line.low.len() {
                let mut u: Vec<f64> = (0..line.low.len()).map(|k| f64::from(u8::from(k == n))).collect();
                let length = u.len();
                let g = |raw: u32| f64::from(raw) / 65536.0;
                if vertical {
                    for k in 1..length {
                        u[k] = u[k - 1] + g(smoother.g) * (u[k] - u[k - 1]);
                    }
                } else {
                    for (j, &raw) in smoother.g_j.iter().enumerate() {
                        let before = |k: usize| u[k.saturating_sub(1 << j)];
                        u = (0..length).map(|k| before(k) + g(raw) * (u[k] - before(k))).collect();
                    }
                }
                for (j, &raw) in smoother.g_j.iter().enumerate() {
                    let after = |k: usize| u[(k + (1 << j)).min(length - 1)];
                    u = (0..length).map(|k| after(k) + g(raw) * (u[k] - after(k))).collect();
                }
                let expected = u[length - 1 - from_end] * f64::from(1u32 << WEIGHT_BITS);
                let (low, high) =
                    (line.low[n] as f64, line.high[n] as f64 + if n == 0 { line.rest as f64 } else { 0.0 });
                assert!(low - 0.01 <= expected && expected <= high + 0.01, "{vertical} {n}: {low} {expected} {high}");
                assert!(high - low < 1e3, "{n}: {low} {high}");
            }
        }
    }
}
