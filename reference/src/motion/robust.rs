//! Robust refit after the search: `min sum rho(|p' - H p| / s)`, Huber's `rho`, over the pairs within a radius.
//!
//! `rho(u) = u^2 / 2` up to `u = k` and `k u - k^2 / 2` beyond, so that the influence of a pair is bounded by that at
//! `k s` (Huber, 1964). Minimised by reweighted least squares, `w = min(1, k s / |e|)`. The scale `s` (px per axis) is
//! the median of `|e|` over 1.1774, which is the standard deviation of errors normal along both axes; errors of less
//! than half of the pairs do not move it.
//!
//! The search stops at its first sufficient sample, and a few rounds of least squares on the inliers of a sample of
//! neighbours may stop half way. The rounds here continue to convergence.

use crate::motion::budget::{Budget, FIT_WORK, PAIR_WORK};
use crate::motion::model::{Model, Pair, squared_error, transfer};
use nalgebra::{Matrix3, Vector2};

/// Huber's `k`, in units of `s`: 32 % of errors normal along both axes are longer.
const HUBER_K: f64 = 1.5;

/// Median length of a vector whose coordinates are normal with variance 1: `sqrt(2 ln 2)`.
const MEDIAN_LENGTH: f64 = 1.177_410_022_515_474_7;

/// Smallest scale assumed, px: far below the accuracy of a position.
const MIN_SCALE_PX: f64 = 1e-6;

/// Largest number of rounds; each gains at least one digit if few pairs are outliers.
const MAX_ROUNDS: usize = 30;

/// Movement of the corners of the pairs' bounding box, px, below which [`refit`] has converged.
const CONVERGENCE_STEP_PX: f64 = 1e-4;

/// Estimates the standard deviation per axis, px, from the median of the squared errors `|e|^2` (px^2). Reorders
/// `squared`. Returns 0 if there are no errors.
pub fn scale(squared: &mut [f64]) -> f64 {
    if squared.is_empty() {
        return 0.0;
    }
    let middle = squared.len() / 2;
    squared.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt() / MEDIAN_LENGTH
}

/// Returns Huber's weight of a pair with the squared error `e2` (px^2) for the scale `s` (px).
pub fn weight(e2: f64, s: f64) -> f64 {
    let limit = HUBER_K * s;
    if e2 <= limit * limit { 1.0 } else { limit / e2.sqrt() }
}

/// Returns one over the square of the denominator of `H p`, the weight that [`Model::fit_round`] expects.
pub(crate) fn inverse_squared_denominator(h: &Matrix3<f64>, pair: &Pair) -> f64 {
    let [x, y] = pair.reference.into();
    let denominator = h[(2, 0)] * x + h[(2, 1)] * y + h[(2, 2)];
    1.0 / (denominator * denominator)
}

/// Reusable memory of [`refit_in`].
#[derive(Debug, Clone, Default)]
pub struct RefitBuffers {
    squared: Vec<f64>,
    pub(crate) weights: Vec<f64>,
}

impl RefitBuffers {
    /// Allocates memory for `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self { squared: Vec::with_capacity(pairs), weights: Vec::with_capacity(pairs) }
    }
}

/// Fits the motion near `start` to the pairs with `e^2 < max_squared_error` (px^2). Returns `start` if they do not
/// determine one.
pub fn refit(model: Model, start: Matrix3<f64>, pairs: &[Pair], max_squared_error: f64) -> Matrix3<f64> {
    let (mut budget, mut buffers) = (Budget::UNLIMITED, RefitBuffers::default());
    refit_in(model, start, pairs, max_squared_error, CONVERGENCE_STEP_PX, &mut budget, &mut buffers)
}

/// Fits as [`refit`] does, with reusable memory and bounded work: if `budget` is exhausted, returns the motion of the
/// last round. Converges when no corner of the pairs' bounding box moves by more than `convergence_step` (px).
pub fn refit_in(
    model: Model,
    start: Matrix3<f64>,
    pairs: &[Pair],
    max_squared_error: f64,
    convergence_step: f64,
    budget: &mut Budget,
    buffers: &mut RefitBuffers,
) -> Matrix3<f64> {
    let corners = corners(pairs);
    let mut best = start;
    let RefitBuffers { squared, weights } = buffers;
    for _ in 0..MAX_ROUNDS {
        if !budget.spend(FIT_WORK + 8 * PAIR_WORK * pairs.len()) {
            break;
        }
        // First the squared errors, then the weights.
        weights.clear();
        weights.extend(pairs.iter().map(|pair| squared_error(&best, pair)));
        squared.clear();
        squared.extend(weights.iter().filter(|e2| **e2 < max_squared_error));
        let s = scale(squared).max(MIN_SCALE_PX);
        for (w, pair) in weights.iter_mut().zip(pairs) {
            *w = if *w < max_squared_error { weight(*w, s) * inverse_squared_denominator(&best, pair) } else { 0.0 };
        }
        let Ok(h) = model.fit_round(pairs, weights) else { break };
        let converged = corners.iter().all(|&corner| match (transfer(&h, corner), transfer(&best, corner)) {
            (Some(a), Some(b)) => (a - b).norm_squared() < convergence_step * convergence_step,
            _ => false,
        });
        best = h;
        if converged {
            break;
        }
    }
    best
}

/// Returns the corners of the bounding box of the positions in REF.
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

    /// Returns 300 pairs with 0.1 px of noise, of which `biased` have 1 px of noise and an offset of 1.5 px.
    fn pairs(seed: u64, biased: usize) -> Vec<Pair> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..300)
            .map(|i| {
                let reference = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
                let noise = Vector2::new(normal(&mut rng), normal(&mut rng));
                let lean = if i < biased { noise + Vector2::new(1.5, 0.0) } else { 0.1 * noise };
                Pair { reference, current: transfer(&truth(), reference).unwrap() + lean }
            })
            .collect()
    }

    fn miss(h: &Matrix3<f64>) -> f64 {
        let centre = Vector2::new(511.5, 383.5);
        (transfer(h, centre).unwrap() - transfer(&truth(), centre).unwrap()).norm()
    }

    #[test]
    fn biased_pairs_have_less_influence_than_in_least_squares() {
        let (mut plain, mut robust) = (0.0, 0.0);
        for seed in 0..20 {
            let pairs = pairs(seed, 40);
            let start = Model::Homography.fit(&pairs).unwrap();
            plain += miss(&start) / 20.0;
            robust += miss(&refit(Model::Homography, start, &pairs, 9.0)) / 20.0;
        }
        assert!(plain > 0.15 && robust < 0.3 * plain, "{plain:.4} px plain, {robust:.4} px robust");
    }

    /// Starts 6 px off at one corner, as after a sample of neighbours.
    #[test]
    fn the_result_does_not_depend_on_the_start() {
        let pairs = pairs(3, 0);
        let good = refit(Model::Homography, truth(), &pairs, 9.0);
        // Right at the top left, 6 px off at the bottom right.
        let bent = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3e-6, 3e-6, 1.0) * truth();
        let found = refit(Model::Homography, bent, &pairs, 9.0);
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
