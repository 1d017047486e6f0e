//! Template refinement: `min over d of sum_u |I(p + u) - a J(q + A (u + d)) - b|^2` on the raw frames, `I` of REF and
//! `J` of CUR.
//!
//! A feature's place is that of a maximum of a smoothed difference, known to some tenths of a pixel. The frames know
//! more: the 17 x 17 samples about the place in REF are compared with those of CUR, warped by the estimate. `p` is the
//! pixel of REF nearest to the place, so that REF is not interpolated; `A` is the derivative of the motion there, `q`
//! the matched place moved by `A` to `p`; `d`, in pixels of REF, is what is sought. `a` and `b` are gain and offset of
//! the exposure: both patches are brought to mean 0 and norm 1, which takes them out, and their product is then the
//! normalised cross correlation (NCC).
//!
//! Lucas and Kanade (1981), with the gradient of REF in place of that of the moving patch (inverse compositional, Baker
//! and Matthews, 2004), so that the 2 x 2 normal equations are made and inverted once a patch. `J` is interpolated
//! linearly between four samples.
//!
//! A pair is dropped where the patch leaves a frame, where its gradients have one direction only, where the step does
//! not settle, where it went further than [`REACH`], and where the NCC stays below [`LEAST_NCC`]: waves, leaves and
//! noise are not the same twice.

use crate::image::plane::Plane;
use crate::motion::estimate::Estimate;
use crate::motion::model::{Pair, squared_error, transfer};
use crate::motion::robust::{scale, settle};
use nalgebra::{Matrix2, Matrix3, Vector2};

/// Half the side of a patch, less one half: 17 x 17.
pub const HALF: usize = 8;

/// Pairs that are refined, the best first; more gain nothing.
pub const MOST: usize = 200;

/// Refined pairs are at least this far apart along one axis, px. Patches that share samples share their error.
pub const APART: f64 = SIDE as f64;

/// Least NCC of a refined pair.
pub const LEAST_NCC: f64 = 0.5;

/// Furthest a pair is moved, px of REF: what the parabola leaves, and some.
pub const REACH: f64 = 2.0;

/// Steps a patch takes at most.
const STEPS: usize = 10;

/// A step below this ends the refinement of a patch, px.
const SETTLED: f64 = 0.005;

/// The smaller eigenvalue of the normal matrix is at least this part of the larger.
const LEAST_ROUNDNESS: f64 = 0.02;

/// Fewer refined pairs than this leave the estimate as it is.
const FEWEST: usize = 12;

/// Refined pairs vote within this many standard deviations an axis of their own residual.
const VOTE: f64 = 4.0;

const SIDE: usize = 2 * HALF + 1;
const AREA: usize = SIDE * SIDE;

/// A pair after refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refined {
    /// `p`, a whole pixel of REF, and its place in CUR.
    pub pair: Pair,
    /// Normalised cross correlation of the two patches, at most 1.
    pub ncc: f64,
}

/// The pair refined under the motion `h`; nothing where it is dropped.
pub fn refined_pair(reference: &Plane<u16>, current: &Plane<u16>, h: &Matrix3<f64>, pair: &Pair) -> Option<Refined> {
    let p = pair.reference.map(f64::round);
    let template = Template::of(reference, p)?;
    let a = derivative(h, p)?;
    let q = pair.current + a * (p - pair.reference);
    let mut d = Vector2::zeros();
    for _ in 0..STEPS {
        let (step, _) = template.step(current, q + a * d, &a)?;
        d += step;
        if d.norm_squared() > REACH * REACH {
            return None;
        }
        if step.norm_squared() < SETTLED * SETTLED {
            let place = q + a * d;
            let (_, ncc) = template.step(current, place, &a)?;
            return (ncc >= LEAST_NCC).then_some(Refined { pair: Pair { reference: p, current: place }, ncc });
        }
    }
    None
}

/// The estimate with its best inliers refined and the motion fitted to them; as it was where too few stand the
/// comparison. Matches and pairs are then the refined ones.
pub fn refined(estimate: Estimate, reference: &Plane<u16>, current: &Plane<u16>, dist: f64) -> Estimate {
    let (mut matches, mut pairs) = (Vec::with_capacity(MOST), Vec::with_capacity(MOST));
    for &i in &estimate.inliers {
        let place = estimate.pairs[i].reference;
        let taken = |pair: &Pair| (pair.reference - place).amax() < APART;
        if pairs.len() == MOST || pairs.iter().any(taken) {
            continue;
        }
        if let Some(refined) = refined_pair(reference, current, &estimate.homography, &estimate.pairs[i]) {
            matches.push(estimate.matches[i]);
            pairs.push(refined.pair);
        }
    }
    if pairs.len() < FEWEST {
        return estimate;
    }
    let homography = settle(estimate.model, estimate.homography, &pairs, dist);
    let mut squared: Vec<f64> = pairs.iter().map(|pair| squared_error(&homography, pair)).collect();
    let limit = (VOTE * scale(&mut squared)).powi(2).min(dist);
    let inliers: Vec<usize> = (0..pairs.len()).filter(|&i| squared_error(&homography, &pairs[i]) <= limit).collect();
    if inliers.len() < FEWEST {
        return estimate;
    }
    let sum: f64 = inliers.iter().map(|&i| squared_error(&homography, &pairs[i])).sum();
    let rms = (sum / inliers.len() as f64).sqrt();
    Estimate { homography, matches, pairs, inliers, rms, ..estimate }
}

/// `dH/dp`: how the place in CUR moves with that in REF.
fn derivative(h: &Matrix3<f64>, p: Vector2<f64>) -> Option<Matrix2<f64>> {
    let q = transfer(h, p)?;
    let depth = h[(2, 0)] * p.x + h[(2, 1)] * p.y + h[(2, 2)];
    Some(Matrix2::from_fn(|row, column| (h[(row, column)] - q[row] * h[(2, column)]) / depth))
}

/// The patch of REF, of mean 0 and norm 1, and what a step needs of its gradient.
struct Template {
    samples: [f64; AREA],
    slopes: [Vector2<f64>; AREA],
    inverse: Matrix2<f64>,
}

impl Template {
    /// About the whole pixel `p`; nothing where the patch and its neighbours leave the frame or tell one direction
    /// only.
    fn of(frame: &Plane<u16>, p: Vector2<f64>) -> Option<Self> {
        let margin = (HALF + 1) as f64;
        let inside = |v: f64, size: usize| v >= margin && v + margin < size as f64;
        if !(inside(p.x, frame.width()) && inside(p.y, frame.height())) {
            return None;
        }
        let (left, top) = (p.x as usize - HALF, p.y as usize - HALF);
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
        // What gain and offset explain of a displacement is no evidence of it.
        for (slope, sample) in slopes.iter_mut().zip(&samples) {
            *slope -= mean + along * *sample;
            normal += *slope * slope.transpose();
        }
        let eigenvalues = normal.symmetric_eigenvalues();
        let round = eigenvalues.min() > LEAST_ROUNDNESS * eigenvalues.max();
        round.then(|| normal.try_inverse()).flatten().map(|inverse| Self { samples, slopes, inverse })
    }

    /// The displacement still to go, px of REF, and the NCC, where the middle of the patch is at `place` in CUR.
    fn step(&self, current: &Plane<u16>, place: Vector2<f64>, a: &Matrix2<f64>) -> Option<(Vector2<f64>, f64)> {
        let mut patch = [0.0; AREA];
        let half = HALF as f64;
        let across = a.column(0).into_owned();
        for v in 0..SIDE {
            let mut q = place + a * Vector2::new(-half, v as f64 - half);
            for u in 0..SIDE {
                patch[v * SIDE + u] = linear(current, q)?;
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

/// Brings samples to mean 0 and norm 1 and returns the norm they had; nothing where they are all alike.
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

fn linear(frame: &Plane<u16>, q: Vector2<f64>) -> Option<f64> {
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

    /// Ground without an end: smooth hills of light at many scales.
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

    /// The place, and its match off by `miss`.
    fn pair(x: f64, y: f64, miss: Vector2<f64>) -> Pair {
        let reference = Vector2::new(x, y);
        Pair { reference, current: transfer(&motion(), reference).unwrap() + miss }
    }

    #[test]
    fn a_match_half_a_pixel_off_is_brought_home_under_another_gain() {
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
    fn what_cannot_be_compared_is_dropped() {
        let (reference, current) = frames();
        let none = |reference: &Plane<u16>, current: &Plane<u16>, pair: Pair| {
            assert_eq!(refined_pair(reference, current, &motion(), &pair), None, "{pair:?}");
        };
        // Patches that leave either frame; a match further off than the reach; a flat frame; a single edge.
        none(&reference, &current, pair(5.0, 70.0, Vector2::zeros()));
        none(&reference, &current, pair(196.0, 70.0, Vector2::zeros()));
        none(&reference, &current, Pair { current: Vector2::new(3.0, 80.0), ..pair(60.0, 70.0, Vector2::zeros()) });
        none(&reference, &current, pair(60.0, 70.0, Vector2::new(3.0, 0.0)));
        none(&Plane::filled(200, 150, 9u16), &current, pair(60.0, 70.0, Vector2::zeros()));
        none(&reference, &Plane::filled(200, 150, 9u16), pair(60.0, 70.0, Vector2::zeros()));
        let edge = Plane::from_fn(200, 150, |x, _| if x < 60 { 100u16 } else { 900 });
        none(&edge, &edge, Pair { reference: Vector2::new(60.0, 70.0), current: Vector2::new(60.0, 70.0) });
        // Ground that is not the same twice.
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
        // Off by up to half a pixel, to the right on the whole.
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
        // Too few that stand the comparison leave it as it was.
        let flat = Plane::filled(200, 150, 9u16);
        assert_eq!(refined(before.clone(), &reference, &flat, 9.0), before);
    }
}
