//! Relief as correlated noise: `cov(e_i, e_j) = s^2 I [i = j] + rho^2 (g_i g_i^T [i = j] + g_i g_j^T [same cell]) / 2`.
//!
//! `e` is the residual of a pair (px), `g` the movement of its position in CUR per metre of ground height (px/m), `s`
//! the noise of positions (px per axis), `rho` the standard deviation of the ground's height over the plane (m).
//! Neighbouring ground has similar height: half of the variance is common to a cell of 128 px, half is independent
//! between pairs. The common half is an unknown height of each cell with its own prior, eliminated from the normal
//! equations of the pose by the Schur complement:
//!
//! `N = sum J^T W J - sum_cells b b^T / D`, `b = sum J^T W g`, `D = sum g^T W g + 2 / rho^2`, `W = (s^2 I + rho^2 g g^T
//! / 2)^-1`.
//!
//! **Moments.** The unknowns move a position only through the homography, `J = M D` with `D = dH / d unknowns` (9 x N,
//! the same for all pairs) and `M = A (x) p^T / z`, `A = (1, 0, -x'; 0, 1, -y')`, where `(x', y')` is the position in
//! CUR and `z` its depth. So `sum J^T W J = D^T (sum A^T W A (x) p p^T / z^2) D`: 36 sums over the pairs for any N.
//!
//! `s` and `rho` are estimated from the residuals: across `g` the variance is `s^2`; along it the mean of `e^2` is
//! `s^2 + rho^2 |g|^2`. The ground is taken to have relief if the evidence (twice the gain in log likelihood by `rho`)
//! exceeds `MIN_EVIDENCE`. Between two frames from the same position `g` is 0: relief is invisible and irrelevant.
//! Pairs are weighted as in Huber's fit, by the length of their error in the metric of `W`.

use crate::motion::budget::Budget;
use crate::motion::model::Pair;
use crate::motion::robust::{scale, weight};
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Side of a cell of common height, px of REF.
const CELL_SIDE_PX: f64 = 128.0;

/// Cells along an edge; positions beyond the last cell belong to it.
const CELLS: usize = 16;

/// Evidence (twice the gain in log likelihood) above which the ground has relief. Chi squared of one degree of freedom
/// exceeds it once in 600.
pub(crate) const MIN_EVIDENCE: f64 = 10.0;

/// Median of the absolute value of a normal deviate.
const MEDIAN_NORMAL: f64 = 0.674_489_750_196_081_7;

/// Standard deviations at which residuals are clipped when `rho` is estimated.
const CLIP_SIGMAS: f64 = 3.0;

/// Rounds of the estimate of `rho`, whose weights depend on `rho`.
const ROUNDS: usize = 4;

/// Side of the square of samples that determine a position, px.
const SUPPORT_SIDE_PX: f64 = 17.0;

/// Work units of sorting and visiting a position, from instruction counts on the ARM.
const POSITION_WORK: usize = 64;

/// The error of a pair under a homography, with the direction in which relief moves it.
#[derive(Debug, Clone, Copy)]
pub struct Residual {
    /// Position in REF, px.
    position: Vector2<f64>,
    /// `H p`, homogeneous.
    image: Vector3<f64>,
    /// `g`, px/m.
    parallax: Vector2<f64>,
    /// `e`, px.
    error: Vector2<f64>,
    /// `|g|^2`.
    g2: f64,
    /// `e^2` along `g`, px^2.
    along2: f64,
    /// `|e|` across `g`, px.
    across: f64,
}

impl Residual {
    /// Splits the error `e` (px) of the position `p` (px of REF) along and across the parallax `g` (px/m). `image` is
    /// `H p`, homogeneous.
    pub fn new(position: Vector2<f64>, image: Vector3<f64>, parallax: Vector2<f64>, error: Vector2<f64>) -> Self {
        let g2 = parallax.norm_squared();
        // Without parallax both axes are noise, and any direction serves.
        let g = if g2 > 0.0 { parallax / g2.sqrt() } else { Vector2::x() };
        let along = error.dot(&g);
        Self { position, image, parallax, error, g2, along2: along * along, across: error.perp(&g).abs() }
    }
}

/// Returns the square of a residual of variance `v`, clipped at three standard deviations.
pub fn clipped(e2: f64, v: f64) -> f64 {
    e2.min(CLIP_SIGMAS * CLIP_SIGMAS * v)
}

/// The sums from which `rho^2` is estimated, `sum (e^2 - s^2) w / sum |g|^2 w` with `w = |g|^2 / v^2`.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReliefSums {
    above: f64,
    below: f64,
}

impl ReliefSums {
    /// Adds a residual: `|g|^2`, its square along `g`, the variance `s^2` that it has without relief (px^2), and the
    /// `rho^2` so far (m^2), which weights it.
    pub fn push(&mut self, g2: f64, along2: f64, s2: f64, rho2: f64) {
        let v = s2 + rho2 * g2;
        let share = g2 / (v * v);
        self.above += (along2 - s2) * share;
        self.below += g2 * share;
    }

    /// Returns `rho^2`, m^2; 0 without parallax.
    pub fn variance(&self) -> f64 {
        if self.below > 0.0 { (self.above / self.below).max(0.0) } else { 0.0 }
    }
}

/// The noise of the residuals: `s` and `rho`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Noise of positions `s`, px per axis.
    pub position: f64,
    /// Standard deviation of the ground's height over the plane `rho`, m; 0 for a plane.
    pub relief: f64,
}

impl Noise {
    /// Estimates the noise of pairs on a plane, at least `min_px`. `parameters` is the number of parameters of the fit,
    /// which makes the residuals smaller than the noise. `values` is reusable memory.
    pub fn of_plane(pairs: &[Residual], min_px: f64, parameters: usize, values: &mut Vec<f64>) -> Self {
        values.clear();
        values.extend(pairs.iter().map(|pair| pair.error.norm_squared()));
        let s = scale(values) * bias_correction(pairs.len(), parameters);
        Self { position: s.max(min_px), relief: 0.0 }
    }

    /// Estimates the noise and the relief of pairs over hills. Arguments as in [`Noise::of_plane`].
    pub fn of_relief(pairs: &[Residual], min_px: f64, parameters: usize, values: &mut Vec<f64>) -> Self {
        values.clear();
        values.extend(pairs.iter().map(|pair| pair.across));
        let middle = values.len() / 2;
        let median = values.select_nth_unstable_by(middle, f64::total_cmp).1;
        let s = (*median / MEDIAN_NORMAL * bias_correction(pairs.len(), parameters)).max(min_px);
        let s2 = s * s;
        let mut rho2 = 0.0;
        for _ in 0..ROUNDS {
            let mut sums = ReliefSums::default();
            for &Residual { g2, along2, .. } in pairs {
                // The first round has no scale to clip at.
                let e2 = if rho2 > 0.0 { clipped(along2, s2 + rho2 * g2) } else { along2 };
                sums.push(g2, e2, s2, rho2);
            }
            rho2 = sums.variance();
        }
        Self { position: s, relief: rho2.sqrt() }
    }

    /// Returns twice the gain in log likelihood over the same noise without relief.
    pub fn evidence(&self, pairs: &[Residual]) -> f64 {
        let s2 = self.position * self.position;
        let gain = |pair: &Residual| {
            let v = s2 + self.relief * self.relief * pair.g2;
            let e2 = clipped(pair.along2, v);
            e2 / s2 - e2 / v - libm::log(v / s2)
        };
        pairs.iter().map(gain).sum()
    }

    /// Returns the squared length of a pair's error in standard deviations of its noise and relief.
    pub fn length2(&self, pair: &Residual) -> f64 {
        let s2 = self.position * self.position;
        pair.along2 / (s2 + self.relief * self.relief * pair.g2) + pair.across * pair.across / s2
    }
}

/// Returns the factor, at least 1, by which the variance of Huber's fit exceeds the inverse of the normal matrix:
/// `E[psi^2] E[w] / E[psi']^2` with `psi = w e` (Huber, 1981, section 7.6). 1 within 3 % for normal errors, more for
/// errors with long tails.
pub fn excess(pairs: &[Residual], noise: &Noise) -> f64 {
    let (mut force, mut weights, mut slope) = (0.0, 0.0, 0.0);
    for pair in pairs {
        let length2 = noise.length2(pair);
        let w = weight(length2, 1.0);
        // Two axes share `psi^2`; beyond the limit only the direction across the error is stiff.
        force += 0.5 * w * w * length2;
        weights += w;
        slope += if w < 1.0 { 0.5 * w } else { 1.0 };
    }
    (force * weights / (slope * slope)).max(1.0)
}

/// Returns the factor, at least 1, by which the variance of a sum of the pairs' errors exceeds that of independent
/// errors. The errors of positions less than 17 px apart along both axes are correlated, because their supports share
/// samples. `positions` is reusable memory. Returns `None` if `budget` is exhausted.
pub fn overlap(pairs: &[Pair], positions: &mut Vec<Vector2<f64>>, budget: &mut Budget) -> Option<f64> {
    positions.clear();
    positions.extend(pairs.iter().map(|pair| pair.reference));
    positions.sort_unstable_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    let (mut shared, mut first) = (0.0, 0);
    for (i, a) in positions.iter().enumerate() {
        while a.y - positions[first].y >= SUPPORT_SIDE_PX {
            first += 1;
        }
        if !budget.spend(POSITION_WORK + i - first) {
            return None;
        }
        for b in &positions[first..i] {
            let x = (a.x - b.x).abs();
            if x < SUPPORT_SIDE_PX {
                shared += (1.0 - x / SUPPORT_SIDE_PX) * (1.0 - (a.y - b.y) / SUPPORT_SIDE_PX);
            }
        }
    }
    Some(1.0 + 2.0 * shared / pairs.len().max(1) as f64)
}

/// Computes the normal matrix `sum J^T W J` and the right-hand side `sum J^T W e` of a least-squares step over all
/// pairs, with the heights of the cells eliminated. `derivatives[k]` is the derivative of the homography `H` with
/// respect to unknown `k`; `cells` is reusable memory.
pub fn normal_equations<const N: usize>(
    pairs: &[Residual],
    derivatives: &[Matrix3<f64>; N],
    noise: &Noise,
    cells: &mut Cells,
) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
    // Blocks of the symmetric A^T W A, and in each the sums of x^2, x y, x, y^2, y, 1.
    let mut blocks = [[0.0; 6]; 6];
    let mut gradient = Moments::zeros();
    let s2 = noise.position * noise.position;
    let half = 0.5 * noise.relief * noise.relief;
    cells.clear();
    for pair in pairs {
        let (g, e) = (pair.parallax, pair.error);
        let [x, y] = pair.position.into();
        let inverse = 1.0 / pair.image.z;
        let [u, v] = [pair.image.x * inverse, pair.image.y * inverse];
        // The weight is from the whole variance, including the common height of the cell.
        let k = weight(noise.length2(pair), 1.0) / s2;
        let own = k * half / (s2 + half * pair.g2);
        let (xx, xy, yy) = (k - own * g.x * g.x, -own * g.x * g.y, k - own * g.y * g.y);
        // M^T times a force, as three rows of three.
        let moment = |force: Vector2<f64>| {
            let a = [force.x * inverse, force.y * inverse];
            let a = [a[0], a[1], -(u * a[0] + v * a[1])];
            Moments::from([a[0] * x, a[0] * y, a[0], a[1] * x, a[1] * y, a[1], a[2] * x, a[2] * y, a[2]])
        };
        gradient += moment(Vector2::new(xx * e.x + xy * e.y, xy * e.x + yy * e.y));
        if half > 0.0 {
            let weighted = Vector2::new(xx * g.x + xy * g.y, xy * g.x + yy * g.y);
            let cell = cells.of(pair.position);
            cell.b += moment(weighted);
            cell.d += weighted.dot(&g);
            cell.e += weighted.dot(&e);
        }
        let [xx, xy, yy] = [xx, xy, yy].map(|w| w * inverse * inverse);
        let (xz, yz) = (-(u * xx + v * xy), -(u * xy + v * yy));
        let zz = -(u * xz + v * yz);
        for (sums, a) in blocks.iter_mut().zip([xx, xy, xz, yy, yz, zz]) {
            let (ax, ay) = (a * x, a * y);
            sums[0] += ax * x;
            sums[1] += ax * y;
            sums[2] += ax;
            sums[3] += ay * y;
            sums[4] += ay;
            sums[5] += a;
        }
    }
    /// Index of each element of a symmetric 3 x 3 matrix among its six distinct ones.
    const SYMMETRIC: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
    let mut normal = SMatrix::<f64, 9, 9>::from_fn(|row, column| {
        blocks[SYMMETRIC[row / 3][column / 3]][SYMMETRIC[row % 3][column % 3]]
    });
    if half > 0.0 {
        for cell in cells.all.iter().filter(|cell| cell.d > 0.0) {
            let d = cell.d + 1.0 / half;
            normal -= cell.b * (cell.b / d).transpose();
            gradient -= cell.b * (cell.e / d);
        }
    }
    let by = SMatrix::<f64, 9, N>::from_fn(|element, k| derivatives[k][(element / 3, element % 3)]);
    (by.transpose() * (normal * by), by.transpose() * gradient)
}

/// A vector over the elements of `H`, row by row.
type Moments = SVector<f64, 9>;

/// Reusable memory for the sums of the cells.
#[derive(Debug, Clone)]
pub struct Cells {
    all: Vec<Cell>,
}

/// The sums of one cell: `b`, `D`, and `sum g^T W e`.
#[derive(Debug, Clone, Copy)]
struct Cell {
    b: Moments,
    d: f64,
    e: f64,
}

impl Cells {
    /// Allocates all cells.
    pub fn new() -> Self {
        Self { all: vec![Cell { b: Moments::zeros(), d: 0.0, e: 0.0 }; CELLS * CELLS] }
    }

    fn clear(&mut self) {
        self.all.fill(Cell { b: Moments::zeros(), d: 0.0, e: 0.0 });
    }

    /// Returns the cell of a position, px of REF.
    fn of(&mut self, position: Vector2<f64>) -> &mut Cell {
        // `as` converts negative numbers and NaN to 0, the first cell.
        let index = |v: f64| ((v / CELL_SIDE_PX) as usize).min(CELLS - 1);
        &mut self.all[index(position.y) * CELLS + index(position.x)]
    }
}

impl Default for Cells {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the factor from the residual of `2 n` errors to their standard deviation, `sqrt(2 n / (2 n - parameters))`.
fn bias_correction(pairs: usize, parameters: usize) -> f64 {
    let n = 2 * pairs;
    (n as f64 / n.saturating_sub(parameters).max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Sum of twelve uniform numbers: variance 1.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    /// Returns 400 pairs with 0.05 px of noise and heights of `relief` m rms seen with a parallax of up to 2 px/m;
    /// every third pair has `tail` times the noise.
    fn pairs(relief: f64, tail: f64) -> Vec<Residual> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut pair = |i: usize| {
            let parallax = Vector2::new(2.0 * rng.random::<f64>(), 1.0 - 2.0 * rng.random::<f64>());
            let s = if i.is_multiple_of(3) { 0.05 * tail } else { 0.05 };
            let noise = Vector2::new(normal(&mut rng), normal(&mut rng)) * s;
            let error = noise + parallax * (relief * normal(&mut rng));
            let position = Vector2::new(100.0 * (i % 20) as f64, 100.0 * (i / 20) as f64);
            Residual::new(position, position.push(1.0), parallax, error)
        };
        (0..400).map(&mut pair).collect()
    }

    #[test]
    fn relief_is_found_if_and_only_if_there_is_some() {
        let mut values = Vec::new();
        let hills = pairs(0.5, 1.0);
        let noise = Noise::of_relief(&hills, 0.02, 8, &mut values);
        assert!((noise.relief - 0.5).abs() < 0.05 && (noise.position - 0.05).abs() < 0.007, "{noise:?}");
        assert!(noise.evidence(&hills) > 100.0 * MIN_EVIDENCE);
        let flat = pairs(0.0, 1.0);
        assert!(Noise::of_relief(&flat, 0.02, 8, &mut values).evidence(&flat) < MIN_EVIDENCE);
    }

    #[test]
    fn tails_add_to_the_variance() {
        let mut values = Vec::new();
        let mut of = |tail: f64| {
            let pairs = pairs(0.0, tail);
            excess(&pairs, &Noise::of_plane(&pairs, 0.02, 8, &mut values))
        };
        assert!((1.0..1.1).contains(&of(1.0)), "{}", of(1.0));
        assert!(of(10.0) > 1.05, "{}", of(10.0));
    }

    #[test]
    fn pairs_of_the_same_samples_count_once() {
        let apart = |x: f64| {
            let pairs = [50.0, 50.0 + x].map(|x| Pair { reference: Vector2::new(x, 50.0), current: Vector2::zeros() });
            overlap(&pairs, &mut Vec::new(), &mut Budget::UNLIMITED.clone()).unwrap()
        };
        assert_eq!([0.0, 8.5, 17.0].map(apart), [2.0, 1.5, 1.0]);
    }
}
