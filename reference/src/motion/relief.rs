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
//! **Moments.** The unknowns move a place only through the homography, `J = M D` with `D = dH / d unknowns` (9 x N, the
//! same for all pairs) and `M = A (x) p^T / z`, `A = (1, 0, -x'; 0, 1, -y')`, where `(x', y')` is the place in CUR and
//! `z` its depth. So `sum J^T W J = D^T (sum A^T W A (x) p p^T / z^2) D`: 36 sums over the pairs, whatever N is.
//!
//! `s` and `rho` are estimated from the residuals: across `g` there is `s` alone; along it `e^2` is `s^2 + rho^2 |g|^2`
//! on the mean. Whether there is relief at all is a question of evidence: twice the gain in log likelihood that `rho`
//! brings, at most [`EVIDENCE`] by chance. Where two frames are taken from one place `g` is 0, no relief can be seen,
//! and none matters. Pairs weigh as in Huber's fit, by their length in the metric of `W`.

use crate::motion::budget::Budget;
use crate::motion::model::Pair;
use crate::motion::robust::{scale, weight};
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

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

/// Work units of sorting a place among the others and looking at it, by instructions on the ARM.
const PLACE_WORK: usize = 64;

/// A pair under the present homography.
#[derive(Debug, Clone, Copy)]
pub struct Residual {
    /// Place in REF, px.
    place: Vector2<f64>,
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
    /// Of the place `p` (px of REF) with the image `H p` (homogeneous), `g` (px/m) and `e` (px).
    pub fn new(place: Vector2<f64>, image: Vector3<f64>, parallax: Vector2<f64>, error: Vector2<f64>) -> Self {
        let g2 = parallax.norm_squared();
        // Without parallax both axes are noise; which is called which does not matter.
        let g = if g2 > 0.0 { parallax / g2.sqrt() } else { Vector2::x() };
        let along = error.dot(&g);
        Self { place, image, parallax, error, g2, along2: along * along, across: error.perp(&g).abs() }
    }
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
    pub fn of_plane(pairs: &[Residual], least: f64, freedoms: usize, values: &mut Vec<f64>) -> Self {
        values.clear();
        values.extend(pairs.iter().map(|pair| pair.error.norm_squared()));
        let s = scale(values) * given_back(pairs.len(), freedoms);
        Self { places: s.max(least), relief: 0.0 }
    }

    /// The noise of pairs over relief.
    pub fn of_relief(pairs: &[Residual], least: f64, freedoms: usize, values: &mut Vec<f64>) -> Self {
        values.clear();
        values.extend(pairs.iter().map(|pair| pair.across));
        let middle = values.len() / 2;
        let median = values.select_nth_unstable_by(middle, f64::total_cmp).1;
        let s = (*median / MEDIAN_NORMAL * given_back(pairs.len(), freedoms)).max(least);
        let s2 = s * s;
        let mut rho2 = 0.0;
        for _ in 0..ROUNDS {
            let (mut above, mut below) = (0.0, 0.0);
            for &Residual { g2, along2, .. } in pairs {
                let v = s2 + rho2 * g2;
                let e2 = if rho2 > 0.0 { along2.min(CLIP * CLIP * v) } else { along2 };
                let share = g2 / (v * v);
                above += (e2 - s2) * share;
                below += g2 * share;
            }
            rho2 = if below > 0.0 { (above / below).max(0.0) } else { 0.0 };
        }
        Self { places: s, relief: rho2.sqrt() }
    }

    /// Twice the gain in log likelihood over the same noise without relief.
    pub fn evidence(&self, pairs: &[Residual]) -> f64 {
        let s2 = self.places * self.places;
        let gain = |pair: &Residual| {
            let v = s2 + self.relief * self.relief * pair.g2;
            let e2 = pair.along2.min(CLIP * CLIP * v);
            e2 / s2 - e2 / v - libm::log(v / s2)
        };
        pairs.iter().map(gain).sum()
    }

    /// Squared length of a pair's error in the metric of its whole noise.
    pub fn length2(&self, pair: &Residual) -> f64 {
        let s2 = self.places * self.places;
        pair.along2 / (s2 + self.relief * self.relief * pair.g2) + pair.across * pair.across / s2
    }
}

/// By how much the variance of Huber's fit exceeds what the weights alone say, `E[psi^2] E[w] / E[psi']^2` with `psi =
/// w e` (Huber, 1981, section 7.6): 1 for normal errors within 3 %, more where many pairs are further off. At least 1.
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

/// By how much the variance of a sum of the pairs' errors exceeds that of independent ones. Errors of places nearer
/// than [`SUPPORT`] along both axes come of the same samples, as far as their supports overlap: 1 where none do.
/// `places` is memory. Nothing where `budget` ends.
pub fn overlap(pairs: &[Pair], places: &mut Vec<Vector2<f64>>, budget: &mut Budget) -> Option<f64> {
    places.clear();
    places.extend(pairs.iter().map(|pair| pair.reference));
    places.sort_unstable_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    let (mut shared, mut first) = (0.0, 0);
    for (i, a) in places.iter().enumerate() {
        while a.y - places[first].y >= SUPPORT {
            first += 1;
        }
        if !budget.spend(PLACE_WORK + i - first) {
            return None;
        }
        for b in &places[first..i] {
            let x = (a.x - b.x).abs();
            if x < SUPPORT {
                shared += (1.0 - x / SUPPORT) * (1.0 - (a.y - b.y) / SUPPORT);
            }
        }
    }
    Some(1.0 + 2.0 * shared / pairs.len().max(1) as f64)
}

/// `J^T W J` and `J^T W e` of all pairs, the heights of the cells taken out. `derivatives` are those of `H` by the
/// unknowns.
pub fn normal_equations<const N: usize>(
    pairs: &[Residual],
    derivatives: &[Matrix3<f64>; N],
    noise: &Noise,
    cells: &mut Cells,
) -> (SMatrix<f64, N, N>, SVector<f64, N>) {
    // Blocks of the symmetric A^T W A, and in each the sums of x^2, x y, x, y^2, y, 1.
    let mut blocks = [[0.0; 6]; 6];
    let mut gradient = Moments::zeros();
    let s2 = noise.places * noise.places;
    let half = 0.5 * noise.relief * noise.relief;
    cells.clear();
    for pair in pairs {
        let (g, e) = (pair.parallax, pair.error);
        let [x, y] = pair.place.into();
        let inverse = 1.0 / pair.image.z;
        let [u, v] = [pair.image.x * inverse, pair.image.y * inverse];
        // The cell's height belongs to the expected length, not to the noise.
        let k = weight(noise.length2(pair), 1.0) / s2;
        let own = k * half / (s2 + half * pair.g2);
        let (xx, xy, yy) = (k - own * g.x * g.x, -own * g.x * g.y, k - own * g.y * g.y);
        // M^T of a force, as three rows of three.
        let moment = |force: Vector2<f64>| {
            let a = [force.x * inverse, force.y * inverse];
            let a = [a[0], a[1], -(u * a[0] + v * a[1])];
            Moments::from([a[0] * x, a[0] * y, a[0], a[1] * x, a[1] * y, a[1], a[2] * x, a[2] * y, a[2]])
        };
        gradient += moment(Vector2::new(xx * e.x + xy * e.y, xy * e.x + yy * e.y));
        if half > 0.0 {
            let weighted = Vector2::new(xx * g.x + xy * g.y, xy * g.x + yy * g.y);
            let cell = cells.of(pair.place);
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
    /// Of the elements of a symmetric 3 x 3 matrix among the six that it has.
    const PLACES: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
    let mut normal =
        SMatrix::<f64, 9, 9>::from_fn(|row, column| blocks[PLACES[row / 3][column / 3]][PLACES[row % 3][column % 3]]);
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

/// Of the elements of `H`, row by row.
type Moments = SVector<f64, 9>;

/// Sums of the cells, to be used again and again.
#[derive(Debug, Clone)]
pub struct Cells {
    all: Vec<Cell>,
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    b: Moments,
    d: f64,
    e: f64,
}

impl Cells {
    /// Room for all cells.
    pub fn new() -> Self {
        Self { all: vec![Cell { b: Moments::zeros(), d: 0.0, e: 0.0 }; CELLS * CELLS] }
    }

    fn clear(&mut self) {
        self.all.fill(Cell { b: Moments::zeros(), d: 0.0, e: 0.0 });
    }

    fn of(&mut self, place: Vector2<f64>) -> &mut Cell {
        // `as` takes what is negative or not a number to the first cell.
        let index = |v: f64| ((v / CELL) as usize).min(CELLS - 1);
        &mut self.all[index(place.y) * CELLS + index(place.x)]
    }
}

impl Default for Cells {
    fn default() -> Self {
        Self::new()
    }
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

    /// 400 pairs, 0.05 px of noise, heights of `relief` m seen with a parallax of up to 2 px/m; every third pair has
    /// `tail` times the noise.
    fn pairs(relief: f64, tail: f64) -> Vec<Residual> {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut pair = |i: usize| {
            let parallax = Vector2::new(2.0 * rng.random::<f64>(), 1.0 - 2.0 * rng.random::<f64>());
            let s = if i.is_multiple_of(3) { 0.05 * tail } else { 0.05 };
            let noise = Vector2::new(normal(&mut rng), normal(&mut rng)) * s;
            let error = noise + parallax * (relief * normal(&mut rng));
            let place = Vector2::new(100.0 * (i % 20) as f64, 100.0 * (i / 20) as f64);
            Residual::new(place, place.push(1.0), parallax, error)
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
            let pairs = [50.0, 50.0 + x].map(|x| Pair { reference: Vector2::new(x, 50.0), current: Vector2::zeros() });
            overlap(&pairs, &mut Vec::new(), &mut Budget::UNLIMITED.clone()).unwrap()
        };
        assert_eq!([0.0, 8.5, 17.0].map(apart), [2.0, 1.5, 1.0]);
    }
}
