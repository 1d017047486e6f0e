//! The stages of one smoother, for any arithmetic: two-sided smoothing as a chain of lerps, `y = p + c (q - p)`.
//!
//! With the pole `a`, `g = 1 - a` and `g_j = 1 / (1 + a^(2^j))`, `u` the input of a stage, `m` the look-ahead in
//! stages:
//!
//! - `column_look_ahead_j`, `j = m-1 .. 0`: `y[r] = lerp(p = u[min(r + 2^j, H-1)], q = u[r], g_j)`,
//! - `recursion`, vertical: `s[0] = u[0]`, `s[r] = lerp(p = s[r-1], q = u[r], g)`,
//! - `row_look_back_j`, `j = 0 .. m-1`: `y[c] = lerp(p = u[max(c - 2^j, 0)], q = u[c], g_j)`,
//! - `row_look_ahead_j`, `j = 0 .. m-1`: `y[c] = lerp(p = u[min(c + 2^j, W-1)], q = u[c], g_j)`.
//!
//! `m` such stages in series are `sum_{k < 2^m} a^k u[n + k]`, scaled to sum 1, as `prod_j (1 + a^(2^j) z^(2^j))`.
//! Every stage repeats the border sample of its own input. A lerp of two equal samples is that sample, so the last row
//! of every column look-ahead stage is the last row of the picture.
//!
//! The longest column stage comes first, because its rows are pixels: they are the shortest words, and all smoothers
//! share them in one memory.

use hoverlock_reference::image::plane::Plane;

use hoverlock_design::Format;

/// The coefficients of one smoother.
#[derive(Debug, Clone, PartialEq)]
pub struct StageCoefficients<C> {
    /// `g` of the recursion.
    pub g: C,
    /// `g_j` of the stages over `2^j` samples, `j = 0 .. m-1`.
    pub g_j: Vec<C>,
}

impl StageCoefficients<f64> {
    /// Computes the unrounded coefficients of the pole `a` in `(0, 1)`.
    pub fn of_pole(a: f64, look_ahead: u32) -> Self {
        // Squared from stage to stage: a^(2^j).
        let powers = std::iter::successors(Some(a), |power| Some(power * power));
        Self { g: 1.0 - a, g_j: powers.take(look_ahead as usize).map(|power| 1.0 / (1.0 + power)).collect() }
    }
}

impl StageCoefficients<u32> {
    /// Returns the values of the raw integers.
    pub fn values(&self, format: Format) -> StageCoefficients<f64> {
        let value = |raw: u32| format.value(i64::from(raw));
        StageCoefficients { g: value(self.g), g_j: self.g_j.iter().copied().map(value).collect() }
    }
}

/// One stage of the chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Down the columns, a lerp with the row `2^j` below.
    ColumnLookAhead(u32),
    /// The causal recursion down the columns.
    Recursion,
    /// Along the rows, a lerp with the column `2^j` to the left.
    RowLookBack(u32),
    /// Along the rows, a lerp with the column `2^j` to the right.
    RowLookAhead(u32),
}

impl Stage {
    /// Returns the stages of a smoother with look-ahead `m`, in order: `1 + 3 m` stages.
    pub fn chain(m: u32) -> impl Iterator<Item = Stage> {
        let up = (0..m).rev().map(Stage::ColumnLookAhead);
        let left = (0..m).map(Stage::RowLookBack);
        let right = (0..m).map(Stage::RowLookAhead);
        up.chain(std::iter::once(Stage::Recursion)).chain(left).chain(right)
    }

    /// Applies this stage alone to its input.
    pub fn apply<T: Copy, C: Copy>(
        self,
        u: &Plane<T>,
        coefficients: &StageCoefficients<C>,
        lerp: impl Fn(T, T, C) -> T,
    ) -> Plane<T> {
        match self {
            Stage::Recursion => recursion(u, |p, q| lerp(p, q, coefficients.g)),
            Stage::ColumnLookAhead(j) => column_look_ahead(u, 1 << j, |p, q| lerp(p, q, coefficients.g_j[j as usize])),
            Stage::RowLookBack(j) => row_look_back(u, 1 << j, |p, q| lerp(p, q, coefficients.g_j[j as usize])),
            Stage::RowLookAhead(j) => row_look_ahead(u, 1 << j, |p, q| lerp(p, q, coefficients.g_j[j as usize])),
        }
    }
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Stage::Recursion => f.pad("recursion"),
            Stage::ColumnLookAhead(j) => f.pad(&format!("column_look_ahead_{j}")),
            Stage::RowLookBack(j) => f.pad(&format!("row_look_back_{j}")),
            Stage::RowLookAhead(j) => f.pad(&format!("row_look_ahead_{j}")),
        }
    }
}

/// Runs the whole chain and passes the output of every stage to `each`, in order.
pub fn smooth<T: Copy, C: Copy>(
    x: &Plane<T>,
    coefficients: &StageCoefficients<C>,
    lerp: impl Fn(T, T, C) -> T,
    mut each: impl FnMut(Stage, &Plane<T>),
) -> Plane<T> {
    let mut plane = None;
    for stage in Stage::chain(coefficients.g_j.len() as u32) {
        let output = stage.apply(plane.as_ref().unwrap_or(x), coefficients, &lerp);
        each(stage, &output);
        plane = Some(output);
    }
    plane.expect("every chain has a recursion")
}

/// Columns that are smoothed together: the strip of a frame of 768 rows of 8 bytes a sample fits into an L2 cache.
const STRIP: usize = 32;

/// Runs the whole chain without showing its stages. The samples are those of [`smooth`], computed in place: strips of
/// columns first, then row by row, so that they are in the cache from stage to stage.
pub fn smoothed<T: Copy, C: Copy>(
    mut plane: Plane<T>,
    coefficients: &StageCoefficients<C>,
    lerp: impl Fn(T, T, C) -> T,
) -> Plane<T> {
    let mut strip = Vec::new();
    for left in (0..plane.width()).step_by(STRIP) {
        let columns = left..(left + STRIP).min(plane.width());
        strip.clear();
        plane.rows().for_each(|row| strip.extend_from_slice(&row[columns.clone()]));
        smooth_columns(&mut strip, columns.len(), coefficients, &lerp);
        for (y, row) in strip.chunks_exact(columns.len()).enumerate() {
            plane.row_mut(y)[columns.clone()].copy_from_slice(row);
        }
    }
    let mut line = plane.row(0).to_vec();
    for y in 0..plane.height() {
        smooth_row(plane.row_mut(y), &mut line, &coefficients.g_j, &lerp);
    }
    plane
}

/// Applies the column stages to the rows of a strip of `width` columns.
fn smooth_columns<T: Copy, C: Copy>(
    strip: &mut [T],
    width: usize,
    coefficients: &StageCoefficients<C>,
    lerp: &impl Fn(T, T, C) -> T,
) {
    let last = strip.len() / width - 1;
    for (j, g) in coefficients.g_j.iter().enumerate().rev() {
        // The row ahead has not been changed yet. The last row is the same before and after every stage.
        for r in 0..last {
            let ahead = (r + (1 << j)).min(last);
            let (before, after) = strip.split_at_mut(ahead * width);
            let here = &mut before[r * width..(r + 1) * width];
            here.iter_mut().zip(&*after).for_each(|(y, ahead)| *y = lerp(*ahead, *y, *g));
        }
    }
    for r in 1..=last {
        let (before, after) = strip.split_at_mut(r * width);
        let above = &before[(r - 1) * width..];
        after[..width].iter_mut().zip(above).for_each(|(s, above)| *s = lerp(*above, *s, coefficients.g));
    }
}

/// Applies the row stages to a row; `line` is work memory of its length.
fn smooth_row<T: Copy, C: Copy>(row: &mut [T], line: &mut [T], g_j: &[C], lerp: &impl Fn(T, T, C) -> T) {
    let width = row.len();
    // Two stages for each coefficient, so the result is in `row` again.
    let (mut from, mut to) = (row, line);
    for (j, g) in g_j.iter().enumerate() {
        let (reach, first) = ((1 << j).min(width), from[0]);
        let (held, inner) = to.split_at_mut(reach);
        held.iter_mut().zip(&*from).for_each(|(y, here)| *y = lerp(first, *here, *g));
        let pairs = from.iter().zip(&from[reach..]);
        inner.iter_mut().zip(pairs).for_each(|(y, (back, here))| *y = lerp(*back, *here, *g));
        std::mem::swap(&mut from, &mut to);
    }
    for (j, g) in g_j.iter().enumerate() {
        let (reach, last) = ((1 << j).min(width), from[width - 1]);
        let (inner, held) = to.split_at_mut(width - reach);
        let pairs = from[reach..].iter().zip(&*from);
        inner.iter_mut().zip(pairs).for_each(|(y, (ahead, here))| *y = lerp(*ahead, *here, *g));
        held.iter_mut().zip(&from[width - reach..]).for_each(|(y, here)| *y = lerp(last, *here, *g));
        std::mem::swap(&mut from, &mut to);
    }
}

fn recursion<T: Copy>(x: &Plane<T>, lerp: impl Fn(T, T) -> T) -> Plane<T> {
    let width = x.width();
    let mut s = x.clone();
    for r in 1..x.height() {
        let (above, below) = s.as_mut_slice().split_at_mut(r * width);
        for (s, before) in below[..width].iter_mut().zip(&above[(r - 1) * width..]) {
            *s = lerp(*before, *s);
        }
    }
    s
}

fn column_look_ahead<T: Copy>(u: &Plane<T>, distance: usize, lerp: impl Fn(T, T) -> T) -> Plane<T> {
    let last = u.height() - 1;
    let mut y = u.clone();
    for r in 0..u.height() {
        for (y, ahead) in y.row_mut(r).iter_mut().zip(u.row((r + distance).min(last))) {
            *y = lerp(*ahead, *y);
        }
    }
    y
}

fn row_look_back<T: Copy>(u: &Plane<T>, distance: usize, lerp: impl Fn(T, T) -> T) -> Plane<T> {
    let reach = distance.min(u.width());
    let mut y = u.clone();
    for r in 0..u.height() {
        let (line, first) = (u.row(r), u.row(r)[0]);
        let (held, inner) = y.row_mut(r).split_at_mut(reach);
        held.iter_mut().for_each(|y| *y = lerp(first, *y));
        inner.iter_mut().zip(line).for_each(|(y, back)| *y = lerp(*back, *y));
    }
    y
}

fn row_look_ahead<T: Copy>(u: &Plane<T>, distance: usize, lerp: impl Fn(T, T) -> T) -> Plane<T> {
    let reach = distance.min(u.width());
    let mut y = u.clone();
    for r in 0..u.height() {
        let (line, last) = (u.row(r), u.row(r)[u.width() - 1]);
        let (inner, held) = y.row_mut(r).split_at_mut(u.width() - reach);
        inner.iter_mut().zip(&line[reach..]).for_each(|(y, ahead)| *y = lerp(*ahead, *y));
        held.iter_mut().for_each(|y| *y = lerp(last, *y));
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn float(p: f64, q: f64, c: f64) -> f64 {
        p + c * (q - p)
    }

    #[test]
    fn stages_are_in_the_order_of_the_data() {
        let names: Vec<_> = Stage::chain(2).map(|stage| stage.to_string()).collect();
        assert_eq!(
            names,
            [
                "column_look_ahead_1",
                "column_look_ahead_0",
                "recursion",
                "row_look_back_0",
                "row_look_back_1",
                "row_look_ahead_0",
                "row_look_ahead_1"
            ]
        );
    }

    #[test]
    fn impulse_is_the_geometric_series() {
        // One impulse, read where no stage saw a border: the response at (dx, dy) is the product of the one-dimensional
        // series.
        let (a, m) = (0.6f64, 3u32);
        let n = 1i32 << m;
        let size = 61usize;
        let centre = 30i32;
        let x = Plane::from_fn(size, size, |c, r| if (c, r) == (30, 30) { 1.0 } else { 0.0 });
        let y = smooth(&x, &StageCoefficients::of_pole(a, m), float, |_, _| ());
        let series: f64 = (0..n).map(|k| a.powi(k)).sum();
        let one = |k: i32| if (0..n).contains(&k) { a.powi(k) / series } else { 0.0 };
        // Causal and anticausal halves convolved: the recursion has no end, the product form ends after 2^m - 1
        // samples.
        let column =
            |d: i32| (0..n).map(|k| one(k) * if d + k >= 0 { (1.0 - a) * a.powi(d + k) } else { 0.0 }).sum::<f64>();
        let row = |d: i32| (0..n).map(|k| one(k) * one(d + k)).sum::<f64>();
        for r in 0..size as i32 - n {
            for c in 0..size as i32 {
                let expected = column(r - centre) * row(c - centre);
                assert!((y[(c as usize, r as usize)] - expected).abs() < 1e-15, "({c}, {r})");
            }
        }
    }

    proptest! {
        #[test]
        fn smoothing_in_place_gives_the_samples_of_the_stages(
            (width, height) in (1..100usize, 1..60usize), seed: u64, a in 0.1..0.95f64, m in 1..7u32,
        ) {
            let sample = |x: usize, y: usize| {
                (seed.wrapping_add(1 + (x + 128 * y) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f64
            };
            let (picture, coefficients) = (Plane::from_fn(width, height, sample), StageCoefficients::of_pole(a, m));
            let shown = smooth(&picture, &coefficients, float, |_, _| ());
            prop_assert_eq!(smoothed(picture, &coefficients, float), shown);
        }

        #[test]
        fn each_stage_computes_its_equation(
            (width, height) in (1..20usize, 1..20usize), seed: u64, a in 0.1..0.95f64, m in 1..6u32,
        ) {
            let sample = |x: usize, y: usize| {
                (seed.wrapping_add(1 + (x + 64 * y) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f64
            };
            let coefficients = StageCoefficients::of_pole(a, m);
            let mut u = Plane::from_fn(width, height, sample);
            for stage in Stage::chain(m) {
                let y = stage.apply(&u, &coefficients, float);
                for r in 0..height {
                    for c in 0..width {
                        let reach = |j: u32| 1usize << j;
                        let (p, q, coefficient) = match stage {
                            Stage::Recursion if r == 0 => (u[(c, 0)], u[(c, 0)], coefficients.g),
                            Stage::Recursion => (y[(c, r - 1)], u[(c, r)], coefficients.g),
                            Stage::ColumnLookAhead(j) => {
                                (u[(c, (r + reach(j)).min(height - 1))], u[(c, r)], coefficients.g_j[j as usize])
                            }
                            Stage::RowLookBack(j) => {
                                (u[(c.saturating_sub(reach(j)), r)], u[(c, r)], coefficients.g_j[j as usize])
                            }
                            Stage::RowLookAhead(j) => {
                                (u[((c + reach(j)).min(width - 1), r)], u[(c, r)], coefficients.g_j[j as usize])
                            }
                        };
                        prop_assert_eq!(y[(c, r)], float(p, q, coefficient), "{} at ({}, {})", stage, c, r);
                    }
                }
                u = y;
            }
        }
    }
}
