//! Template refinement: `min over d of sum_u |B I(p + u) - a B J(q + A (u + d)) - b|^2` on the raw frames, `I` of REF
//! and `J` of CUR, `B` the smoothing with cubic B-spline weights (module `spline`).
//!
//! The position of a feature is that of a maximum of a smoothed difference, accurate to a few tenths of a pixel. The
//! frames allow more: 12 x 12 samples about the position in REF, 2 px apart, are compared with those of CUR, warped by
//! the estimate. `p` is the pixel of REF nearest to the position, so that REF is not interpolated; `q` is where the
//! motion of the whole frame maps `p`, `A` its derivative there; the unknown is `d`, in pixels of REF. `a` and `b` are
//! gain and offset of the exposure: normalising both patches to mean 0 and norm 1 eliminates them, and the product of
//! the patches is then the normalised cross correlation (NCC).
//!
//! Lucas and Kanade (1981), with the gradient of REF in place of that of the moving patch (inverse compositional, Baker
//! and Matthews, 2004), so that the 2 x 2 normal equations are set up and inverted once a patch. Three steps from the
//! motion of the frame are as good as ten from the matched position, whose own error is larger.
//!
//! A pair is dropped if the patch leaves a frame, if its gradients have one direction only, if it moves by more than
//! 2 px, or if the NCC stays below 0.5: waves, leaves and noise differ between the frames.

mod spline;
mod template;

use crate::image::plane::Plane;
use crate::motion::estimate::Estimate;
use crate::motion::model::{Pair, derivative, squared_error, transfer};
use crate::motion::robust::{refit, scale};
use nalgebra::{Matrix3, Vector2};
use template::Template;
pub use template::{AREA, MIN_EIGENVALUE_RATIO, REACH_PX, SIDE, STRIDE};

/// Number of pairs that are refined, the best first.
const MAX_REFINED_PAIRS: usize = 400;

/// Smallest distance of two refined pairs along at least one axis, px: a third of a patch. Patches that share samples
/// share their error, and still 400 of them give a better displacement than 200 without overlap.
const MIN_SEPARATION_PX: f64 = 8.0;

/// Smallest NCC of a refined pair.
pub const MIN_NCC: f64 = 0.5;

/// Largest movement of a pair, px of REF. Inliers are within 3 px of the motion.
pub const MAX_MOVEMENT_PX: f64 = 2.0;

/// Number of steps of a patch.
const STEPS: usize = 3;

/// Smallest number of refined pairs that replaces the estimate.
const MIN_PAIRS: usize = 12;

/// Largest error of an inlier among the refined pairs, in standard deviations per axis of their residual.
const INLIER_SIGMAS: f64 = 4.0;

/// A pair after refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinedPair {
    /// `p`, a whole pixel of REF, and its position in CUR.
    pub pair: Pair,
    /// Normalised cross correlation of the two patches, at most 1.
    pub ncc: f64,
}

/// Refines the pair of the pixel nearest to `position` in REF under the motion `h`. Returns `None` if it is dropped.
pub fn refined_pair(
    reference: &Plane<u16>,
    current: &Plane<u16>,
    h: &Matrix3<f64>,
    position: Vector2<f64>,
) -> Option<RefinedPair> {
    let p = position.map(f64::round);
    let template = Template::of(reference, p)?;
    let (q, a) = (transfer(h, p)?, derivative(h, p)?);
    let mut d = Vector2::zeros();
    for _ in 0..STEPS {
        d += template.step(current, q + a * d, &a)?.0;
        if d.norm_squared() > MAX_MOVEMENT_PX * MAX_MOVEMENT_PX {
            return None;
        }
    }
    let found = q + a * d;
    let (_, ncc) = template.step(current, found, &a)?;
    (ncc >= MIN_NCC).then_some(RefinedPair { pair: Pair { reference: p, current: found }, ncc })
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
        if let Some(refined) = refined_pair(reference, current, &estimate.homography, position) {
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

#[cfg(test)]
mod bias;
#[cfg(test)]
mod tests;
