//! Relief as correlated noise: `cov(e_i, e_j) = s^2 I [i = j] + rho^2 (g_i g_i^T [i = j] + g_i g_j^T [same cell]) / 2`.
//!
//! `e` is the residual of a pair (px), `g` how far its place in CUR moves per metre of ground height (px/m), `s` the
//! noise of places (px an axis), `rho` the standard deviation of the ground's height over the plane (m). Ground that is
//! high is high for its neighbours too: half of the variance is common to a cell of [`CELL`] px, half is each pair's
//! own. The common half is an unknown height of each cell with a prior of its own, taken out of the normal equations of
//! the pose by the Schur complement:
//!
//! `N = sum J^T W J - sum_cells b b^T / D`, `b = sum J^T W g`, `D = sum g^T W g + 2 / rho^2`, `W = (s^2 I + rho^2 g g^T
//! / 2)^-1`.
//!
//! `s` and `rho` are estimated from the residuals: across `g` there is `s` alone; along it `e^2` is `s^2 + rho^2 |g|^2`
//! on the mean. Whether there is relief at all is a question of evidence: twice the gain in log likelihood that `rho`
//! brings, at most [`EVIDENCE`] by chance. Where two frames are taken from one place `g` is 0, no relief can be seen,
//! and none matters. Pairs weigh as in Huber's fit, by their length in the metric of `W`.

use crate::motion::model::Pair;
use crate::motion::robust::{scale, weight};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// Side of a cell of common height, px of REF.
pub const CELL: f64 = 128.0;

/// Cells along an edge; what lies beyond belongs to the last.
const CELLS: usize = 16;

/// Twice the gain in log likelihood above which relief is believed: chi squared of one freedom exceeds it once in 600.
pub const EVIDENCE: f64 = 10.0;

/// Median of the length of a normal deviate.
const MEDIAN_NORMAL: f64 = 0.674_489_750_196_081_7;

/// Residuals count at most this many of their standard deviations when `rho` is estimated.
const CLIP: f64 = 3.0;

/// Rounds of the estimate of `rho`; its weights depend on it.
const ROUNDS: usize = 4;

/// Side of the square of samples that a place is measured on, px.
pub const SUPPORT: f64 = 17.0;

/// A pair, linearised.
#[derive(Debug, Clone, Copy)]
pub struct Linear<const N: usize> {
    /// Place in REF, px.
    pub place: Vector2<f64>,
    /// By how much the place in CUR moves with each unknown.
    pub slopes: [Vector2<f64>; N],
    /// `g`, px/m.
    pub parallax: Vector2<f64>,
    /// `e`, px.
    pub error: Vector2<f64>,
}

/// `s` and `rho`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Noise of places, px an axis.
    pub places: f64,
    /// Standard deviation of the ground's height, m; 0 where the ground is a plane.
    pub relief: f64,
}

impl Noise {
    /// The noise of a plane's pairs: `least` at least, and `freedoms` of the fit given back. `values` is memory.
    pub fn of_plane<const N: usize>(pairs: &[Linear<N>], least: f64, freedoms: usize, values: &mut Vec<f64>) -> Self {
        values.clear();
        values.extend(pairs.iter().map(|pair| pair.error.norm_squared()));
        let s = scale(values) * given_back(pairs.len(), freedoms);
        Self { places: s.max(least), relief: 0.0 }
    }

    /// The noise of pairs over relief.
    pub fn of_relief<const N: usize>(pairs: &[Linear<N>], least: f64, freedoms: usize, values: &mut Vec<f64>) -> Self {
        values.clear();
        values.extend(pairs.iter().map(|pair| along_and_across(pair).1.abs()));
        let middle = values.len() / 2;
        let median = values.select_nth_unstable_by(middle, f64::total_cmp).1;
        let s = (*median / MEDIAN_NORMAL * given_back(pairs.len(), freedoms)).max(least);
        let mut rho2 = 0.0;
        for _ in 0..ROUNDS {
            let (mut above, mut below) = (0.0, 0.0);
            for pair in pairs {
                let g2 = pair.parallax.norm_squared();
                let v = s * s + rho2 * g2;
                let e2 = along_and_across(pair).0.powi(2).min(if rho2 > 0.0 { CLIP * CLIP * v } else { f64::INFINITY });
                above += (e2 - s * s) * g2 / (v * v);
                below += g2 * g2 / (v * v);
            }
            rho2 = if below > 0.0 { (above / below).max(0.0) } else { 0.0 };
        }
        Self { places: s, relief: rho2.sqrt() }
    }

    /// Twice the gain in log likelihood over the same noise without relief.
    pub fn evidence<const N: usize>(&self, pairs: &[Linear<N>]) -> f64 {
        let s2 = self.places * self.places;
        let gain = |pair: &Linear<N>| {
            let v = s2 + self.relief * self.relief * pair.parallax.norm_squared();
            let e2 = along_and_across(pair).0.powi(2).min(CLIP * CLIP * v);
            e2 / s2 - e2 / v - libm::log(v / s2)
        };
        pairs.iter().map(gain).sum()
    }
}

/// By how much the variance of Huber's fit exceeds what the weights alone say, `E[psi^2] E[w] / E[psi']^2` with `psi =
/// w e` (Huber, 1981, section 7.6): 1 for normal errors within 3 %, more where many pairs are further off. At least 1.
pub fn excess<const N: usize>(pairs: &[Linear<N>], noise: &Noise) -> f64 {
    let s2 = noise.places * noise.places;
    let (mut force, mut weights, mut slope) = (0.0, 0.0, 0.0);
    for pair in pairs {
        let g = pair.parallax;
        let variance = s2 + noise.relief * noise.relief * g.norm_squared();
        let (along, across) = along_and_across(pair);
        let length2 = along * along / variance + across * across / s2;
        let w = weight(length2, 1.0);
        // Two axes share `psi^2`; beyond the limit only the direction across the error is stiff.
        force += 0.5 * w * w * length2;
        weights += w;
        slope += if w < 1.0 { 0.5 * w } else { 1.0 };
    }
    (force * weights / (slope * slope)).max(1.0)
}

/// By how much the variance of a sum of the pairs' errors exceeds that of independent ones. Errors of places nearer
/// than [`SUPPORT`] along both axes come of the same samples, as far as their supports overlap: 1 where none do.
pub fn overlap(pairs: &[Pair]) -> f64 {
    let mut shared = 0.0;
    for (i, a) in pairs.iter().enumerate() {
        for b in &pairs[..i] {
            let [x, y] = (a.reference - b.reference).abs().into();
            if x < SUPPORT && y < SUPPORT {
                shared += (1.0 - x / SUPPORT) * (1.0 - y / SUPPORT);
            }
        }
    }
    1.0 + 2.0 * shared / pairs.len().max(1) as f64
}

/// `J^T W J` and `J^T W e` of all pairs, the heights of the cells taken out.
pub fn normal_equations<const N: usize>(
    pairs: &[Linear<N>],
    noise: &Noise,
    cells: &mut Cells<N>,
) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
    let (mut normal, mut gradient) = (SMatrix::zeros(), SVector::zeros());
    let s2 = noise.places * noise.places;
    let half = 0.5 * noise.relief * noise.relief;
    cells.clear();
    for pair in pairs {
        let (g, e) = (pair.parallax, pair.error);
        let w = (Matrix2::identity() - g * g.transpose() * (half / (s2 + half * g.norm_squared()))) / s2;
        // The cell's height belongs to the expected length.
        let v = Matrix2::identity() - g * g.transpose() * (2.0 * half / (s2 + 2.0 * half * g.norm_squared()));
        let w = w * weight(e.dot(&(v * e)) / s2, 1.0);
        let j = SMatrix::<f64, 2, N>::from_fn(|axis, k| pair.slopes[k][axis]);
        let weighted = j.transpose() * w;
        normal += weighted * j;
        gradient += weighted * e;
        if noise.relief > 0.0 {
            let cell = cells.of(pair.place);
            cell.b += weighted * g;
            cell.d += g.dot(&(w * g));
            cell.e += g.dot(&(w * e));
        }
    }
    if noise.relief > 0.0 {
        for cell in cells.all.iter().filter(|cell| cell.d > 0.0) {
            let d = cell.d + 1.0 / half;
            normal -= cell.b * cell.b.transpose() / d;
            gradient -= cell.b * (cell.e / d);
        }
    }
    (normal, gradient)
}

/// Sums of the cells, to be used again and again.
#[derive(Debug, Clone)]
pub struct Cells<const N: usize> {
    all: Vec<Cell<N>>,
}

#[derive(Debug, Clone, Copy)]
struct Cell<const N: usize> {
    b: SVector<f64, N>,
    d: f64,
    e: f64,
}

impl<const N: usize> Cells<N> {
    /// Room for all cells.
    pub fn new() -> Self {
        Self { all: vec![Cell { b: SVector::zeros(), d: 0.0, e: 0.0 }; CELLS * CELLS] }
    }

    fn clear(&mut self) {
        self.all.fill(Cell { b: SVector::zeros(), d: 0.0, e: 0.0 });
    }

    fn of(&mut self, place: Vector2<f64>) -> &mut Cell<N> {
        // `as` takes what is negative or not a number to the first cell.
        let index = |v: f64| ((v / CELL) as usize).min(CELLS - 1);
        &mut self.all[index(place.y) * CELLS + index(place.x)]
    }
}

impl<const N: usize> Default for Cells<N> {
    fn default() -> Self {
        Self::new()
    }
}

fn along_and_across<const N: usize>(pair: &Linear<N>) -> (f64, f64) {
    let length = pair.parallax.norm();
    // Without parallax both axes are noise; which is called which does not matter.
    let g = if length > 0.0 { pair.parallax / length } else { Vector2::x() };
    (pair.error.dot(&g), pair.error.perp(&g))
}

/// Of `2 n` errors the fit has made `freedoms` vanish.
fn given_back(pairs: usize, freedoms: usize) -> f64 {
    let n = 2 * pairs;
    (n as f64 / n.saturating_sub(freedoms).max(1) as f64).sqrt()
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

    fn at(x: f64, y: f64) -> Linear<1> {
        let zero = Vector2::zeros();
        Linear { place: Vector2::new(x, y), slopes: [Vector2::x()], parallax: zero, error: zero }
    }

    /// 400 pairs, 0.05 px of noise, heights of `relief` m seen with a parallax of up to 2 px/m; every third pair has
    /// `tail` times the noise.
    fn pairs(relief: f64, tail: f64) -> Vec<Linear<1>> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut pair = |i: usize| {
            let parallax = Vector2::new(2.0 * rng.random::<f64>(), 1.0 - 2.0 * rng.random::<f64>());
            let s = if i.is_multiple_of(3) { 0.05 * tail } else { 0.05 };
            let noise = Vector2::new(normal(&mut rng), normal(&mut rng)) * s;
            let error = noise + parallax * (relief * normal(&mut rng));
            Linear { parallax, error, ..at(100.0 * (i % 20) as f64, 100.0 * (i / 20) as f64) }
        };
        (0..400).map(&mut pair).collect()
    }

    #[test]
    fn relief_is_found_where_there_is_some() {
        let mut values = Vec::new();
        let hills = pairs(0.5, 1.0);
        let noise = Noise::of_relief(&hills, 0.02, 8, &mut values);
        assert!((noise.relief - 0.5).abs() < 0.05 && (noise.places - 0.05).abs() < 0.007, "{noise:?}");
        assert!(noise.evidence(&hills) > 100.0 * EVIDENCE);
        let flat = pairs(0.0, 1.0);
        assert!(Noise::of_relief(&flat, 0.02, 8, &mut values).evidence(&flat) < EVIDENCE);
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
            overlap(&[50.0, 50.0 + x].map(|x| Pair { reference: Vector2::new(x, 50.0), current: Vector2::zeros() }))
        };
        assert_eq!([0.0, 8.5, 17.0].map(apart), [2.0, 1.5, 1.0]);
    }
}
