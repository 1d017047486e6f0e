//! Effect of quantisation on the measured displacement: a known motion is estimated from `streaming` and from
//! `bit_true`.
//!
//! A second view is made of a picture by a known similarity about its centre (shift within 24 px, turn within 2
//! degrees, scale within 2 %; cubic convolution, Keys 1981, `a = -1/2`, border sample held), both views get independent
//! noise, and the motion is estimated from the features of each level. The displacement is the motion of the picture's
//! centre, px. The *difference* between the levels is caused by quantisation. The *error* of a level against the known
//! motion also includes noise and interpolation.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector2};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use serde::Serialize;

use hoverlock_pictures::conditions::Condition;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::estimator::Estimator;
use hoverlock_reference::motion::model::{Model, transfer};
use hoverlock_reference::motion::ransac::Ransac;

use crate::analysis::acceptance::{Reference, Selected};
use crate::analysis::bounds::{Bounds, Check, Sense};
use crate::analysis::levels::{Level, Levels};

/// One known motion and the estimates of the two levels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Displacement {
    /// The known displacement of the centre, px.
    pub known: [f64; 2],
    /// `streaming`: the estimate, or `None` if it failed.
    pub reference: Option<Found>,
    /// `bit_true`: the estimate, or `None` if it failed.
    pub test: Option<Found>,
    /// Distance between the two estimates, px; infinite where one of them is missing.
    pub difference_px: f64,
}

/// An estimated displacement of the centre of the picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Displacement of the centre, px.
    pub displacement: [f64; 2],
    /// Distance from the known displacement, px.
    pub error_px: f64,
    /// Matches of the last round.
    pub matches: usize,
    /// Inliers of the motion.
    pub inliers: usize,
}

/// A picture before and after known motions, with the features and estimates of `streaming`. They are the same for
/// every design that differs in word lengths alone and has the same step of thresholds,
/// [`threshold_step`](crate::analysis::acceptance::threshold_step).
#[derive(Debug, Clone)]
pub struct Motions {
    before: View,
    moved: Vec<Moved>,
    centre: Vector2<f64>,
}

/// A frame, and the thresholds and features of `streaming` on it.
#[derive(Debug, Clone)]
struct View {
    frame: Arc<Plane<u16>>,
    thresholds: Vec<f64>,
    features: Vec<Feature>,
}

/// The picture after one known motion.
#[derive(Debug, Clone)]
struct Moved {
    known: Vector2<f64>,
    view: View,
    reference: Option<Found>,
}

impl View {
    fn new(levels: &Levels, frame: Arc<Plane<u16>>, bounds: &Bounds) -> Self {
        let reference = Reference::of(levels.planes(Level::Streaming, &frame), bounds);
        let Selected { thresholds, features, .. } = reference.selected(levels.design()).into_owned();
        Self { frame, thresholds, features }
    }

    fn bit_true(&self, levels: &Levels) -> Vec<Feature> {
        levels.bit_true_frame(&self.frame, &self.thresholds).1
    }
}

impl Motions {
    /// Makes `motions` seeded motions of `picture` under `condition`, and estimates them from `streaming`.
    pub fn new(levels: &Levels, picture: &Plane<u16>, condition: &Condition, bounds: &Bounds, motions: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(bounds.seeds.motion);
        let motions: Vec<Matrix3<f64>> = (0..motions).map(|_| similarity(&mut random, picture)).collect();
        let centre = Vector2::new((picture.width() - 1) as f64 / 2.0, (picture.height() - 1) as f64 / 2.0);
        let before = Arc::new(condition.apply(picture, bounds.seeds.of(condition)));
        let moved = |(motion, h): (usize, &Matrix3<f64>)| {
            let known = transfer(h, centre)? - centre;
            let frame = condition.apply(&warp(picture, h)?, bounds.seeds.motion + 1 + motion as u64);
            Some((known, Arc::new(frame)))
        };
        let moved = motions.par_iter().enumerate().filter_map(moved).collect();
        Self::of_frames(levels, before, moved, centre, bounds)
    }

    /// Returns the same frames before and after the same motions, estimated from `streaming` of another design.
    #[must_use]
    pub fn with_streaming_of(&self, levels: &Levels, bounds: &Bounds) -> Self {
        let moved = self.moved.iter().map(|moved| (moved.known, moved.view.frame.clone())).collect();
        Self::of_frames(levels, self.before.frame.clone(), moved, self.centre, bounds)
    }

    /// Estimates known motions of `centre`, each with the frame after it.
    fn of_frames(
        levels: &Levels,
        before: Arc<Plane<u16>>,
        moved: Vec<(Vector2<f64>, Arc<Plane<u16>>)>,
        centre: Vector2<f64>,
        bounds: &Bounds,
    ) -> Self {
        let before = View::new(levels, before, bounds);
        let moved = moved.into_par_iter().map(|(known, frame)| {
            let view = View::new(levels, frame, bounds);
            let reference = found(&before.features, &view.features, centre, known);
            Moved { known, view, reference }
        });
        let moved = moved.collect();
        Self { before, moved, centre }
    }

    /// Returns why no design can be judged by these motions: `streaming` has too few features before them, or does not
    /// find one of them.
    pub fn unfit(&self, bounds: &Bounds) -> Option<String> {
        let minimum = bounds.features.minimum;
        let of_scale = |k: usize| self.before.features.iter().filter(|feature| usize::from(feature.scale) == k).count();
        let poor = (0..self.before.thresholds.len()).map(|k| (k, of_scale(k))).find(|(_, count)| *count < minimum);
        if let Some((k, count)) = poor {
            return Some(format!("streaming has {count} features at scale {k}, and a verdict needs {minimum}"));
        }
        let none = self.moved.iter().all(|moved| moved.reference.is_none());
        none.then(|| format!("none of {} known motions is estimated from streaming", self.moved.len()))
    }

    /// Estimates the motions from another level in floating point, with thresholds of the same rank. `None` stands for
    /// a motion that is not found.
    pub fn estimates(&self, levels: &Levels, level: Level, bounds: &Bounds) -> Vec<Option<Found>> {
        let features = |view: &View| Reference::of(levels.planes(level, &view.frame), bounds).features().to_vec();
        let before = features(&self.before);
        self.moved.par_iter().map(|moved| found(&before, &features(&moved.view), self.centre, moved.known)).collect()
    }

    /// Estimates the motions from `bit_true` of a design with the same `streaming`.
    pub fn displacements(&self, levels: &Levels) -> Vec<Displacement> {
        let before = self.before.bit_true(levels);
        let measure = |Moved { known, view, reference }: &Moved| {
            let test = found(&before, &view.bit_true(levels), self.centre, *known);
            let difference_px = match (reference, &test) {
                (Some(a), Some(b)) => (Vector2::from(a.displacement) - Vector2::from(b.displacement)).norm(),
                _ => f64::INFINITY,
            };
            Displacement { known: (*known).into(), reference: reference.clone(), test, difference_px }
        };
        self.moved.par_iter().map(measure).collect()
    }
}

/// Estimates the motion of `centre` from two lists of features.
fn found(before: &[Feature], after: &[Feature], centre: Vector2<f64>, known: Vector2<f64>) -> Option<Found> {
    let estimator =
        Estimator { ransac: Ransac { model: Model::Similarity, ..Ransac::default() }, ..Estimator::default() };
    let estimate = estimator.estimate(before, after).ok()?;
    let displacement = transfer(&estimate.homography, centre)? - centre;
    Some(Found {
        displacement: displacement.into(),
        error_px: (displacement - known).norm(),
        matches: estimate.matches.len(),
        inliers: estimate.inliers.len(),
    })
}

/// Draws a similarity about the centre of the picture.
fn similarity(random: &mut ChaCha8Rng, picture: &Plane<u16>) -> Matrix3<f64> {
    let mut within = |reach: f64| reach * (2.0 * f64::from(random.next_u32()) / f64::from(u32::MAX) - 1.0);
    let (tx, ty) = (within(24.0), within(24.0));
    let (turn, scale) = (within(2.0).to_radians(), 1.0 + within(0.02));
    let (a, b) = (scale * turn.cos(), scale * turn.sin());
    let (cx, cy) = ((picture.width() - 1) as f64 / 2.0, (picture.height() - 1) as f64 / 2.0);
    Matrix3::new(a, -b, cx - a * cx + b * cy + tx, b, a, cy - b * cx - a * cy + ty, 0.0, 0.0, 1.0)
}

/// Moves the picture by `h`: `out(h p) = picture(p)`. Returns `None` if `h` has no inverse.
fn warp(picture: &Plane<u16>, h: &Matrix3<f64>) -> Option<Plane<u16>> {
    let back = h.try_inverse()?;
    let (width, height) = (picture.width(), picture.height());
    let clamp = |index: i64, size: usize| index.clamp(0, size as i64 - 1) as usize;
    Some(Plane::from_fn(width, height, |x, y| {
        let Some(p) = transfer(&back, Vector2::new(x as f64, y as f64)) else { return 0 };
        let (wx, wy) = (cubic(p.x - p.x.floor()), cubic(p.y - p.y.floor()));
        let (left, top) = (p.x.floor() as i64 - 1, p.y.floor() as i64 - 1);
        let mut sum = 0.0;
        for (j, wy) in wy.iter().enumerate() {
            let row = picture.row(clamp(top + j as i64, height));
            let along: f64 =
                wx.iter().enumerate().map(|(i, wx)| wx * f64::from(row[clamp(left + i as i64, width)])).sum();
            sum += wy * along;
        }
        // `as` clips the overshoot of the interpolation to the range of `u16`.
        sum.round() as u16
    }))
}

/// Weights of the four samples around a position; `t` in `[0, 1)` is its distance from the second of them.
fn cubic(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0, -1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * t3 - 0.5 * t2]
}

/// Checks median and maximum of the displacement errors against the bounds, over the motions that are estimated from
/// `streaming`. There are no checks if there is none.
pub fn check(displacements: &[Displacement], bounds: &Bounds) -> Vec<Check> {
    let judged: Vec<&Displacement> = displacements.iter().filter(|d| d.reference.is_some()).collect();
    if judged.is_empty() {
        return Vec::new();
    }
    let (median, max) = median_and_max(&judged);
    let estimated = judged.iter().filter(|d| d.test.is_some()).count();
    let location = format!("{estimated} of {} known motions", displacements.len());
    let limits = &bounds.displacement;
    let check = |name, limit, measured| Check::new(name, "px", Sense::AtMost, limit, measured, location.clone());
    vec![
        check("displacement, median difference", limits.median_px, median),
        check("displacement, largest difference", limits.max_px, max),
    ]
}

/// Returns median and maximum of the differences; NaN if there is none.
fn median_and_max(displacements: &[&Displacement]) -> (f64, f64) {
    let mut differences: Vec<f64> = displacements.iter().map(|d| d.difference_px).collect();
    differences.sort_unstable_by(f64::total_cmp);
    let middle = differences.len() / 2;
    let median = match differences.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => differences[middle],
        _ => (differences[middle - 1] + differences[middle]) / 2.0,
    };
    (median, differences.last().copied().unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warping_reproduces_a_linear_plane() {
        // Cubic convolution reproduces a linear function; away from the border the warped
        // sample is the sample at the position before the motion.
        let picture = Plane::from_fn(80, 60, |x, y| (2000 + 400 * x + 300 * y) as u16);
        let h = similarity(&mut ChaCha8Rng::seed_from_u64(9), &Plane::filled(80, 60, 0));
        let warped = warp(&picture, &h).unwrap();
        let back = h.try_inverse().unwrap();
        let mut compared = 0;
        for y in 0..60 {
            for x in 0..80 {
                let p = transfer(&back, Vector2::new(x as f64, y as f64)).unwrap();
                if p.x >= 1.0 && p.y >= 1.0 && p.x < 77.0 && p.y < 57.0 {
                    let expected = 2000.0 + 400.0 * p.x + 300.0 * p.y;
                    assert!((f64::from(warped[(x, y)]) - expected).abs() <= 0.5 + 1e-6, "{x} {y}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 1000, "{compared}");
    }

    #[test]
    fn median_and_maximum_of_the_differences() {
        let with = |differences: &[f64]| -> Vec<Displacement> {
            let one =
                |&difference_px: &f64| Displacement { known: [0.0; 2], reference: None, test: None, difference_px };
            differences.iter().map(one).collect()
        };
        let of = |differences: &[f64]| median_and_max(&with(differences).iter().collect::<Vec<_>>());
        assert_eq!(of(&[3.0, 1.0, 2.0]), (2.0, 3.0));
        assert_eq!(of(&[4.0, 1.0, 2.0, f64::INFINITY]), (3.0, f64::INFINITY));
    }

    #[test]
    fn a_motion_that_streaming_does_not_find_judges_no_design() {
        let found = || Some(Found { displacement: [0.0; 2], error_px: 0.0, matches: 9, inliers: 9 });
        let motion = |reference, test, difference_px| Displacement { known: [0.0; 2], reference, test, difference_px };
        let bounds = Bounds::acceptance();
        let unseen = [motion(None, found(), f64::INFINITY), motion(None, None, f64::INFINITY)];
        assert!(check(&unseen, bounds).is_empty());
        let seen = [motion(None, None, f64::INFINITY), motion(found(), found(), 0.01)];
        assert!(check(&seen, bounds).iter().all(|check| check.pass));
        let lost = [motion(found(), None, f64::INFINITY), motion(found(), found(), 0.01)];
        assert!(check(&lost, bounds).iter().any(|check| !check.pass));
    }
}
