//! Last least squares: `min sum rho(|p' - H p| / s)`, Huber's `rho`, over the pairs within `dist`, to convergence.
//!
//! `rho(u) = u^2 / 2` up to `u = k` and `k u - k^2 / 2` beyond, so that a pair pulls with at most the force it has at
//! `k s` (Huber, 1964). Minimised by reweighted least squares, `w = min(1, k s / |e|)`. The scale `s` (px an axis) is
//! the median of `|e|` over 1.1774, which is what it is for errors normal along both axes; half of the pairs may be
//! worse without moving it.
//!
//! The search stops at its first sufficient sample, and a few rounds of least squares on that sample's inliers may stop
//! half way when it was drawn among neighbours. Here the rounds end when the motion does.

use crate::motion::budget::Budget;
use crate::motion::model::{Model, Pair, squared_error, transfer};
use crate::motion::ransac::{FIT_WORK, PAIR_WORK};
use nalgebra::{Matrix3, Vector2};

/// Huber's `k`, in `s`: of errors normal along both axes, 32 % are longer.
pub const HUBER: f64 = 1.5;

/// Median length of a vector whose coordinates are normal with variance 1: `sqrt(2 ln 2)`.
const MEDIAN_LENGTH: f64 = 1.177_410_022_515_474_7;

/// The scale is not believed to be below this, px: far below what a place is known to.
const LEAST_SCALE: f64 = 1e-6;

/// Rounds at most; each gains a digit at least where few pairs are outliers.
const ROUNDS: usize = 30;

/// [`settle`] ends when no corner of the pairs' bounding box moves by more, px.
const SETTLED: f64 = 1e-4;

/// Standard deviation of an axis of the errors `|e|^2`, px, by their median; the order of `squared` changes. 0 without
/// errors.
pub fn scale(squared: &mut [f64]) -> f64 {
    if squared.is_empty() {
        return 0.0;
    }
    let middle = squared.len() / 2;
    squared.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt() / MEDIAN_LENGTH
}

/// Weight of a pair with the squared error `e2` where the scale is `s`.
pub fn weight(e2: f64, s: f64) -> f64 {
    let limit = HUBER * s;
    if e2 <= limit * limit { 1.0 } else { limit / e2.sqrt() }
}

/// One over the square of the denominator of `H p`, for [`Model::fit_round`].
pub(crate) fn by_denominator(h: &Matrix3<f64>, pair: &Pair) -> f64 {
    let [x, y] = pair.reference.into();
    let denominator = h[(2, 0)] * x + h[(2, 1)] * y + h[(2, 2)];
    1.0 / (denominator * denominator)
}

/// Memory of [`settle_in`], to be used again.
#[derive(Debug, Clone, Default)]
pub struct SettleBuffers {
    squared: Vec<f64>,
    pub(crate) weights: Vec<f64>,
}

impl SettleBuffers {
    /// Memory for `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self { squared: Vec::with_capacity(pairs), weights: Vec::with_capacity(pairs) }
    }
}

/// The motion near `start` that fits the pairs with `e^2 < dist` (px^2) best; `start` where they determine none.
pub fn settle(model: Model, start: Matrix3<f64>, pairs: &[Pair], dist: f64) -> Matrix3<f64> {
    let (mut budget, mut buffers) = (Budget::UNLIMITED, SettleBuffers::default());
    settle_in(model, start, pairs, dist, SETTLED, &mut budget, &mut buffers)
}

/// The same with memory that is used again and with bounded work: where `budget` ends it, the motion of the last round.
/// It ends when no corner moves by more than `tolerance` (px).
pub fn settle_in(
    model: Model,
    start: Matrix3<f64>,
    pairs: &[Pair],
    dist: f64,
    tolerance: f64,
    budget: &mut Budget,
    buffers: &mut SettleBuffers,
) -> Matrix3<f64> {
    let corners = corners(pairs);
    let mut best = start;
    let SettleBuffers { squared, weights } = buffers;
    for _ in 0..ROUNDS {
        if !budget.spend(FIT_WORK + 8 * PAIR_WORK * pairs.len()) {
            break;
        }
        // First the squared errors, then the weights.
        weights.clear();
        weights.extend(pairs.iter().map(|pair| squared_error(&best, pair)));
        squared.clear();
        squared.extend(weights.iter().filter(|e2| **e2 < dist));
        let s = scale(squared).max(LEAST_SCALE);
        for (w, pair) in weights.iter_mut().zip(pairs) {
            *w = if *w < dist { weight(*w, s) * by_denominator(&best, pair) } else { 0.0 };
        }
        let Ok(h) = model.fit_round(pairs, weights) else { break };
        let settled = corners.iter().all(|&corner| match (transfer(&h, corner), transfer(&best, corner)) {
            (Some(a), Some(b)) => (a - b).norm_squared() < tolerance * tolerance,
            _ => false,
        });
        best = h;
        if settled {
            break;
        }
    }
    best
}

/// Of the box about the pairs' places in REF.
fn corners(pairs: &[Pair]) -> [Vector2<f64>; 4] {
    let mut low = Vector2::repeat(f64::INFINITY);
    let mut high = Vector2::repeat(f64::NEG_INFINITY);
    for pair in pairs {
        low = low.inf(&pair.reference);
        high = high.sup(&pair.reference);
    }
    [low, Vector2::new(high.x, low.y), high, Vector2::new(low.x, high.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    fn truth() -> Matrix3<f64> {
        Matrix3::new(1.02, -0.05, 12.0, 0.05, 1.01, -7.0, 2e-5, -1e-5, 1.0)
    }

    /// 300 pairs with 0.1 px of noise, of which `wild` have 1.5 px and lean to one side.
    fn pairs(seed: u64, wild: usize) -> Vec<Pair> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..300)
            .map(|i| {
                let reference = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
                let noise = Vector2::new(normal(&mut rng), normal(&mut rng));
                let lean = if i < wild { noise + Vector2::new(1.5, 0.0) } else { 0.1 * noise };
                Pair { reference, current: transfer(&truth(), reference).unwrap() + lean }
            })
            .collect()
    }

    fn miss(h: &Matrix3<f64>) -> f64 {
        let centre = Vector2::new(511.5, 383.5);
        (transfer(h, centre).unwrap() - transfer(&truth(), centre).unwrap()).norm()
    }

    #[test]
    fn pairs_that_lean_pull_less_than_in_least_squares() {
        let (mut plain, mut robust) = (0.0, 0.0);
        for seed in 0..20 {
            let pairs = pairs(seed, 40);
            let start = Model::Homography.fit(&pairs).unwrap();
            plain += miss(&start) / 20.0;
            robust += miss(&settle(Model::Homography, start, &pairs, 9.0)) / 20.0;
        }
        assert!(plain > 0.15 && robust < 0.3 * plain, "{plain:.4} px plain, {robust:.4} px robust");
    }

    /// Started half a picture's worth of perspective away, as from a sample among neighbours.
    #[test]
    fn where_it_starts_does_not_matter() {
        let pairs = pairs(3, 0);
        let good = settle(Model::Homography, truth(), &pairs, 9.0);
        // Right at the top left, 6 px off at the bottom right.
        let bent = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3e-6, 3e-6, 1.0) * truth();
        let found = settle(Model::Homography, bent, &pairs, 9.0);
        assert!((found - good).abs().max() < 1e-4, "{found} {good}");
    }

    #[test]
    fn the_scale_is_that_of_an_axis() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut squared: Vec<f64> =
            (0..4000).map(|_| 0.25 * (normal(&mut rng).powi(2) + normal(&mut rng).powi(2))).collect();
        let s = scale(&mut squared);
        assert!((s - 0.5).abs() < 0.03, "{s}");
        assert_eq!(scale(&mut []), 0.0);
    }
}
