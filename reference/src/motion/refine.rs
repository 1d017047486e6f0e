//! Template refinement: `min over d of sum_u |I(p + u) - a J(q + A (u + d)) - b|^2` on the raw frames, `I` of REF and
//! `J` of CUR.
//!
//! The position of a feature is that of a maximum of a smoothed difference, accurate to a few tenths of a pixel. The
//! frames allow more: the 17 x 17 samples about the position in REF are compared with those of CUR, warped by the
//! estimate. `p` is the pixel of REF nearest to the position, so that REF is not interpolated; `A` is the derivative of
//! the motion there, `q` the matched position moved by `A` to `p`; the unknown is `d`, in pixels of REF. `a` and `b`
//! are gain and offset of the exposure: normalising both patches to mean 0 and norm 1 eliminates them, and the product
//! of the patches is then the normalised cross correlation (NCC).
//!
//! Lucas and Kanade (1981), with the gradient of REF in place of that of the moving patch (inverse compositional, Baker
//! and Matthews, 2004), so that the 2 x 2 normal equations are set up and inverted once a patch. `J` is interpolated
//! bilinearly between four samples.
//!
//! A pair is dropped if the patch leaves a frame, if its gradients have one direction only, if the steps do not
//! converge, if it moves by more than 2 px, or if the NCC stays below 0.5: waves, leaves and noise differ between the
//! frames.

use crate::image::plane::Plane;
use crate::motion::estimate::Estimate;
use crate::motion::model::{Pair, squared_error, transfer};
use crate::motion::robust::{refit, scale};
use nalgebra::{Matrix2, Matrix3, Vector2};

/// Distance from the centre of a patch to its outermost samples: 17 x 17 samples.
const PATCH_RADIUS: usize = 8;

/// Number of pairs that are refined, the best first; more do not improve the motion.
const MAX_REFINED_PAIRS: usize = 200;

/// Smallest distance of two refined pairs along at least one axis, px. Patches that share samples share their error.
const MIN_SEPARATION_PX: f64 = SIDE as f64;

/// Smallest NCC of a refined pair.
const MIN_NCC: f64 = 0.5;

/// Largest movement of a pair, px of REF: a little more than the error of the parabola.
const MAX_MOVEMENT_PX: f64 = 2.0;

/// Largest number of steps of a patch.
const MAX_STEPS: usize = 10;

/// Length of a step below which a patch has converged, px.
const CONVERGENCE_STEP_PX: f64 = 0.005;

/// Smallest ratio of the eigenvalues of the normal matrix.
const MIN_EIGENVALUE_RATIO: f64 = 0.02;

/// Smallest number of refined pairs that replaces the estimate.
const MIN_PAIRS: usize = 12;

/// Largest error of an inlier among the refined pairs, in standard deviations per axis of their residual.
const INLIER_SIGMAS: f64 = 4.0;

/// Side of a patch, samples.
const SIDE: usize = 2 * PATCH_RADIUS + 1;
/// Samples of a patch.
const AREA: usize = SIDE * SIDE;

/// A pair after refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RefinedPair {
    /// `p`, a whole pixel of REF, and its position in CUR.
    pair: Pair,
    /// Normalised cross correlation of the two patches, at most 1.
    ncc: f64,
}

/// Refines a pair under the motion `h`. Returns `None` if the pair is dropped.
fn refined_pair(reference: &Plane<u16>, current: &Plane<u16>, h: &Matrix3<f64>, pair: &Pair) -> Option<RefinedPair> {
    let p = pair.reference.map(f64::round);
    let template = Template::of(reference, p)?;
    let a = derivative(h, p)?;
    let q = pair.current + a * (p - pair.reference);
    let mut d = Vector2::zeros();
    for _ in 0..MAX_STEPS {
        let (step, _) = template.step(current, q + a * d, &a)?;
        d += step;
        if d.norm_squared() > MAX_MOVEMENT_PX * MAX_MOVEMENT_PX {
            return None;
        }
        if step.norm_squared() < CONVERGENCE_STEP_PX * CONVERGENCE_STEP_PX {
            let position = q + a * d;
            let (_, ncc) = template.step(current, position, &a)?;
            return (ncc >= MIN_NCC).then_some(RefinedPair { pair: Pair { reference: p, current: position }, ncc });
        }
    }
    None
}

/// Refines the best inliers of an estimate on the frames and fits the motion to them. Matches, pairs and inliers of the
/// result are the refined ones. `max_squared_error` (px^2) is that of the search. Returns the estimate unchanged if
/// fewer than 12 pairs remain.
pub fn refined(estimate: Estimate, reference: &Plane<u16>, current: &Plane<u16>, max_squared_error: f64) -> Estimate {
    let (mut matches, mut pairs) = (Vec::with_capacity(MAX_REFINED_PAIRS), Vec::with_capacity(MAX_REFINED_PAIRS));
    for &i in &estimate.inliers {
        let position = estimate.pairs[i].reference;
        let is_near = |pair: &Pair| (pair.reference - position).amax() < MIN_SEPARATION_PX;
        if pairs.len() == MAX_REFINED_PAIRS || pairs.iter().any(is_near) {
            continue;
        }
        if let Some(refined) = refined_pair(reference, current, &estimate.homography, &estimate.pairs[i]) {
            matches.push(estimate.matches[i]);
            pairs.push(refined.pair);
        }
    }
    if pairs.len() < MIN_PAIRS {
        return estimate;
    }
    let homography = refit(estimate.model, estimate.homography, &pairs, max_squared_error);
    let mut squared: Vec<f64> = pairs.iter().map(|pair| squared_error(&homography, pair)).collect();
    let limit = (INLIER_SIGMAS * scale(&mut squared)).powi(2).min(max_squared_error);
    let inliers: Vec<usize> = (0..pairs.len()).filter(|&i| squared_error(&homography, &pairs[i]) <= limit).collect();
    if inliers.len() < MIN_PAIRS {
        return estimate;
    }
    let sum: f64 = inliers.iter().map(|&i| squared_error(&homography, &pairs[i])).sum();
    let rms = (sum / inliers.len() as f64).sqrt();
    Estimate { homography, matches, pairs, inliers, rms, ..estimate }
}

/// Returns the derivative of the position in CUR by the position in REF, or `None` if `p` maps behind the camera.
fn derivative(h: &Matrix3<f64>, p: Vector2<f64>) -> Option<Matrix2<f64>> {
    let q = transfer(h, p)?;
    let depth = h[(2, 0)] * p.x + h[(2, 1)] * p.y + h[(2, 2)];
    Some(Matrix2::from_fn(|row, column| (h[(row, column)] - q[row] * h[(2, column)]) / depth))
}

/// A patch of REF, normalised to mean 0 and norm 1, with its gradient and the inverse of the normal matrix.
struct Template {
    samples: [f64; AREA],
    slopes: [Vector2<f64>; AREA],
    inverse: Matrix2<f64>,
}

impl Template {
    /// Cuts the patch about the whole pixel `p`. Returns `None` if the patch or its neighbours leave the frame, or if
    /// its gradients have one direction only.
    fn of(frame: &Plane<u16>, p: Vector2<f64>) -> Option<Self> {
        let margin = (PATCH_RADIUS + 1) as f64;
        let inside = |v: f64, size: usize| v >= margin && v + margin < size as f64;
        if !(inside(p.x, frame.width()) && inside(p.y, frame.height())) {
            return None;
        }
        let (left, top) = (p.x as usize - PATCH_RADIUS, p.y as usize - PATCH_RADIUS);
        let (mut samples, mut slopes) = ([0.0; AREA], [Vector2::zeros(); AREA]);
        for v in 0..SIDE {
            let rows = [top + v - 1, top + v, top + v + 1].map(|y| &frame.row(y)[left - 1..left + SIDE + 1]);
            for u in 0..SIDE {
                let at = |row: usize, column: usize| f64::from(rows[row][u + column]);
                samples[v * SIDE + u] = at(1, 1);
                slopes[v * SIDE + u] = 0.5 * Vector2::new(at(1, 2) - at(1, 0), at(2, 1) - at(0, 1));
            }
        }
        let norm = normalise(&mut samples)?;
        let mut normal = Matrix2::zeros();
        let mut along = Vector2::zeros();
        let mut mean = Vector2::zeros();
        for (slope, sample) in slopes.iter_mut().zip(&samples) {
            *slope /= norm;
            mean += *slope / AREA as f64;
            along += *slope * *sample;
        }
        // The part of a displacement that gain and offset explain as well is removed.
        for (slope, sample) in slopes.iter_mut().zip(&samples) {
            *slope -= mean + along * *sample;
            normal += *slope * slope.transpose();
        }
        let eigenvalues = normal.symmetric_eigenvalues();
        let has_two_directions = eigenvalues.min() > MIN_EIGENVALUE_RATIO * eigenvalues.max();
        has_two_directions.then(|| normal.try_inverse()).flatten().map(|inverse| Self { samples, slopes, inverse })
    }

    /// Returns the next step, px of REF, and the NCC for the patch of CUR about `centre`, or `None` if it leaves the
    /// frame or is uniform.
    fn step(&self, current: &Plane<u16>, centre: Vector2<f64>, a: &Matrix2<f64>) -> Option<(Vector2<f64>, f64)> {
        let mut patch = [0.0; AREA];
        let half = PATCH_RADIUS as f64;
        let across = a.column(0).into_owned();
        for v in 0..SIDE {
            let mut q = centre + a * Vector2::new(-half, v as f64 - half);
            for u in 0..SIDE {
                patch[v * SIDE + u] = bilinear(current, q)?;
                q += across;
            }
        }
        normalise(&mut patch)?;
        let (mut gradient, mut ncc) = (Vector2::zeros(), 0.0);
        for ((sample, slope), patch) in self.samples.iter().zip(&self.slopes).zip(&patch) {
            gradient += *slope * (sample - patch);
            ncc += sample * patch;
        }
        Some((self.inverse * gradient, ncc))
    }
}

/// Normalises samples to mean 0 and norm 1 and returns the norm they had, or `None` if all are equal.
fn normalise(samples: &mut [f64; AREA]) -> Option<f64> {
    let mean = samples.iter().sum::<f64>() / AREA as f64;
    let mut squares = 0.0;
    for sample in samples.iter_mut() {
        *sample -= mean;
        squares += *sample * *sample;
    }
    let norm = squares.sqrt();
    (norm > 0.0).then(|| {
        samples.iter_mut().for_each(|sample| *sample /= norm);
        norm
    })
}

/// Returns the sample at `q`, bilinear between four pixels, or `None` outside the frame.
fn bilinear(frame: &Plane<u16>, q: Vector2<f64>) -> Option<f64> {
    let inside = q.x >= 0.0 && q.y >= 0.0 && q.x < (frame.width() - 1) as f64 && q.y < (frame.height() - 1) as f64;
    inside.then(|| {
        let (x, y) = (q.x as usize, q.y as usize);
        let (s, t) = (q.x - x as f64, q.y - y as f64);
        let [upper, lower] = [frame.row(y), frame.row(y + 1)].map(|row| {
            let (l, r) = (f64::from(row[x]), f64::from(row[x + 1]));
            l + s * (r - l)
        });
        upper + t * (lower - upper)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::matching::Match;
    use crate::motion::model::Model;

    /// Returns the brightness of an unbounded ground: smooth waves at many scales.
    fn ground(p: Vector2<f64>) -> f64 {
        let wave = |x: f64, y: f64| (p.x * x + p.y * y).sin();
        30_000.0
            + 4000.0 * (wave(0.21, 0.13) + wave(-0.17, 0.29) + wave(0.05, -0.35) + wave(0.41, 0.02) + wave(0.11, 0.47))
    }

    fn frame(to_ground: &Matrix3<f64>, gain: f64, offset: f64) -> Plane<u16> {
        Plane::from_fn(200, 150, |x, y| {
            let p = transfer(to_ground, Vector2::new(x as f64, y as f64)).unwrap();
            (gain * ground(p) + offset) as u16
        })
    }

    /// 3 degrees, 3 % larger, a little oblique.
    fn motion() -> Matrix3<f64> {
        Matrix3::new(1.03, -0.054, 5.3, 0.054, 1.03, -4.7, 2e-5, -1e-5, 1.0)
    }

    fn frames() -> (Plane<u16>, Plane<u16>) {
        (frame(&Matrix3::identity(), 1.0, 0.0), frame(&motion().try_inverse().unwrap(), 0.7, 3000.0))
    }

    /// Returns a pair whose position in CUR is off by `miss`, px.
    fn pair(x: f64, y: f64, miss: Vector2<f64>) -> Pair {
        let reference = Vector2::new(x, y);
        Pair { reference, current: transfer(&motion(), reference).unwrap() + miss }
    }

    #[test]
    fn a_match_half_a_pixel_off_is_corrected_under_another_gain() {
        let (reference, current) = frames();
        let mut refined = 0;
        for (x, y) in [(60.3, 70.4), (99.6, 40.2), (120.0, 90.0), (80.5, 100.4)] {
            let before = pair(x, y, Vector2::new(0.6, -0.4));
            let Some(after) = refined_pair(&reference, &current, &motion(), &before) else { continue };
            let miss = (after.pair.current - transfer(&motion(), after.pair.reference).unwrap()).norm();
            assert!(miss < 0.03 && after.ncc > 0.99, "({x}, {y}): {miss} px, NCC {}", after.ncc);
            assert!((after.pair.reference - before.reference).abs().max() <= 0.5);
            refined += 1;
        }
        assert_eq!(refined, 4);
    }

    #[test]
    fn pairs_that_cannot_be_compared_are_dropped() {
        let (reference, current) = frames();
        let none = |reference: &Plane<u16>, current: &Plane<u16>, pair: Pair| {
            assert_eq!(refined_pair(reference, current, &motion(), &pair), None, "{pair:?}");
        };
        // Patches that leave either frame; a match too far off; a uniform frame; a single edge.
        none(&reference, &current, pair(5.0, 70.0, Vector2::zeros()));
        none(&reference, &current, pair(196.0, 70.0, Vector2::zeros()));
        none(&reference, &current, Pair { current: Vector2::new(3.0, 80.0), ..pair(60.0, 70.0, Vector2::zeros()) });
        none(&reference, &current, pair(60.0, 70.0, Vector2::new(3.0, 0.0)));
        none(&Plane::filled(200, 150, 9u16), &current, pair(60.0, 70.0, Vector2::zeros()));
        none(&reference, &Plane::filled(200, 150, 9u16), pair(60.0, 70.0, Vector2::zeros()));
        let edge = Plane::from_fn(200, 150, |x, _| if x < 60 { 100u16 } else { 900 });
        none(&edge, &edge, Pair { reference: Vector2::new(60.0, 70.0), current: Vector2::new(60.0, 70.0) });
        // Ground that differs between the frames.
        let other = Plane::from_fn(200, 150, |x, y| ((x * 7919 + y * 104_729) % 6007) as u16);
        none(&reference, &other, pair(60.0, 70.0, Vector2::zeros()));
    }

    fn estimate(pairs: Vec<Pair>) -> Estimate {
        let one = Match { reference: 0, current: 0, distance: 0.0, response_difference: 0.0 };
        let homography = Model::Similarity.fit(&pairs).unwrap();
        let (matches, inliers) = (vec![one; pairs.len()], (0..pairs.len()).collect());
        Estimate { homography, model: Model::Homography, matches, pairs, inliers, rms: 0.5, quality: 200 }
    }

    #[test]
    fn the_motion_follows_the_refined_pairs() {
        let (reference, current) = frames();
        // Off by up to half a pixel, with a bias to the right.
        let miss = |i: usize| Vector2::new(0.4 + 0.1 * (i % 3) as f64, 0.2 * (i % 5) as f64 - 0.4);
        let pairs: Vec<Pair> =
            (0..48).map(|i| pair(30.0 + 18.0 * (i % 8) as f64, 30.0 + 17.0 * (i / 8) as f64, miss(i))).collect();
        let before = estimate(pairs);
        let after = refined(before.clone(), &reference, &current, 9.0);
        let centre = Vector2::new(99.5, 74.5);
        let miss = |h: &Matrix3<f64>| (transfer(h, centre).unwrap() - transfer(&motion(), centre).unwrap()).norm();
        let (was, is) = (miss(&before.homography), miss(&after.homography));
        assert!(was > 0.4 && is < 0.02, "{was} px before, {is} px after");
        assert!(after.inliers.len() >= 30 && after.rms < 0.05 && after.matches.len() == after.pairs.len());
        assert_eq!((after.quality, after.model), (200, Model::Homography));
        // Too few refined pairs leave the estimate unchanged.
        let flat = Plane::filled(200, 150, 9u16);
        assert_eq!(refined(before.clone(), &reference, &flat, 9.0), before);
    }
}
