//! Estimates the motion between two pictures from their features: a wide search with few parameters, then refinement.
//!
//! 1. Match without a gate (or within that of a prediction) and search a similarity, or a shift if that is the model: a
//!    sample of two pairs is more often free of outliers than one of four. This step alone decides whether there is an
//!    estimate, and its quality.
//! 2. Match again within 48 px of where the motion so far maps each feature, which recovers matches that a wrong
//!    candidate had displaced, and search the final model. Then the same within 16 px. A round without consensus leaves
//!    the motion unchanged.
//! 3. Reject ground that repeats (module `repeating_ground`).
//!
//! Real neighbours of a flight (turned up to 7 degrees, scale to 1.13, 300 px apart): a similarity alone misses the
//! centre of the picture by up to 4 px where the ground is seen obliquely, the refined homography by at most 1 px.

use crate::features::feature::{Feature, MAX_PAIRS};
use crate::motion::budget::Budget;
use crate::motion::estimate::Estimate;
use crate::motion::matching::{Gate, MatchBuffers, Matching, matched_pairs};
use crate::motion::model::Model;
use crate::motion::ransac::{Consensus, Ransac, RansacError, SearchBuffers};
use crate::motion::repeating_ground::{self, HistogramBuffers};
use nalgebra::Matrix3;

/// Radii of the gates of the refinement rounds, px. The first allows for the error of a similarity in an oblique view:
/// a scale that changes by 10 % over 1000 px, at 500 px from the centre. The second allows for relief.
const REFINEMENT_GATE_RADII_PX: [f64; 2] = [48.0, 16.0];

/// Largest number of samples of a refinement round. The motion so far is its first hypothesis; samples are needed only
/// if that one is wrong.
const MAX_REFINEMENT_SAMPLES: usize = 64;

/// Convergence step before the last round, px: the motion is only the centre of the next gate.
const COARSE_CONVERGENCE_STEP_PX: f64 = 1.0;

/// Largest ratio of the distance of a match to that of the second best. Removes half of the wrong matches and few of
/// the right ones.
const MAX_DISTANCE_RATIO: f64 = 0.9;

/// Expected work units of a feature in the first round, without comparisons, and in about half of the others; from
/// instruction counts on the ARM.
const FEATURE_WORK: usize = 250;

/// Expected work units of a comparison in the first matching.
const COMPARISON_WORK: f64 = 1.7;

/// The settings of the estimation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimator {
    /// Matching, with the gate of a prediction if there is one.
    pub matching: Matching,
    /// Search of the motion; its model is the final model.
    pub ransac: Ransac,
}

impl Default for Estimator {
    /// Returns the settings of the flight program: a homography, and matches that pass the ratio test with 0.9.
    fn default() -> Self {
        let matching = Matching { ratio: Some(MAX_DISTANCE_RATIO), ..Matching::default() };
        Self { matching, ransac: Ransac { model: Model::Homography, ..Ransac::default() } }
    }
}

impl Estimator {
    /// Estimates the motion that maps the features of REF to those of CUR.
    ///
    /// # Errors
    /// A setting is invalid, or there is no estimate.
    pub fn estimate(&self, reference: &[Feature], current: &[Feature]) -> Result<Estimate, RansacError> {
        let mut workspace = Workspace::with_capacity(reference.len().min(current.len()));
        let mut budget = Budget::UNLIMITED;
        self.estimate_in(&mut workspace, &mut budget, reference, current)?;
        Ok(workspace.best)
    }

    /// Estimates as [`Estimator::estimate`] does, with reusable memory and bounded work: of as many of the
    /// strongest features as `budget` is expected to pay for. If it is late afterwards, the estimate is the best so
    /// far: of a search that ended early, or without refinement.
    ///
    /// # Errors
    /// As [`Estimator::estimate`], and if the budget is exhausted before there is an estimate.
    pub fn estimate_in<'workspace>(
        &self,
        workspace: &'workspace mut Workspace,
        budget: &mut Budget,
        reference: &[Feature],
        current: &[Feature],
    ) -> Result<&'workspace Estimate, RansacError> {
        let convergence_step = COARSE_CONVERGENCE_STEP_PX.max(self.ransac.convergence_step);
        let max_samples = self.ransac.max_samples.min(MAX_REFINEMENT_SAMPLES);
        let search = Ransac { model: self.ransac.model.min(Model::Similarity), convergence_step, ..self.ransac };
        let refinement = Ransac { max_samples, ..self.ransac };
        let min_responses = workspace.min_responses([reference, current], budget);
        if !workspace.matching.fill([reference, current], min_responses, self.matching.strict, budget) {
            return Err(RansacError::BudgetExhausted);
        }
        let whole = budget;
        let mut rest = whole.split(repeating_ground::reserved_work(&workspace.matching));
        let budget = &mut rest;
        let first = workspace.round(&self.matching, &search, None, budget, reference, current);
        if let Err(error) = first {
            whole.absorb(rest);
            return Err(error);
        }
        std::mem::swap(&mut workspace.best, &mut workspace.next);
        let rounds = [Ransac { convergence_step, ..refinement }, refinement];
        let mut round_work = 0;
        for (radius, ransac) in REFINEMENT_GATE_RADII_PX.into_iter().zip(rounds) {
            // The last round gains little; it is left out if it would end early.
            if budget.left() < round_work {
                break;
            }
            let before = budget.left();
            let prediction = workspace.best.homography;
            let matching = Matching { gate: Some(Gate { prediction, radius }), ..self.matching };
            if workspace.round(&matching, &ransac, Some(&prediction), budget, reference, current).is_ok() {
                workspace.next.quality = workspace.best.quality;
                std::mem::swap(&mut workspace.best, &mut workspace.next);
            }
            round_work = before - budget.left();
        }
        whole.absorb(rest);
        let Workspace { best, matching, histogram, .. } = &mut *workspace;
        repeating_ground::check(best, reference, current, whole, matching, histogram)?;
        Ok(&workspace.best)
    }
}

/// Reusable memory of an estimation: an estimation of no more features than before allocates nothing.
pub struct Workspace {
    matching: MatchBuffers,
    search: SearchBuffers,
    consensus: Consensus,
    histogram: HistogramBuffers,
    responses: Vec<f64>,
    best: Estimate,
    next: Estimate,
}

impl Workspace {
    /// Allocates memory for lists of `features` features each.
    pub fn with_capacity(features: usize) -> Self {
        let empty = || Estimate {
            homography: Matrix3::identity(),
            model: Model::Shift,
            matches: Vec::with_capacity(features),
            pairs: Vec::with_capacity(features),
            inliers: Vec::with_capacity(features),
            rms: 0.0,
            quality: 0,
        };
        Self {
            matching: MatchBuffers::with_capacity(features),
            search: SearchBuffers::with_capacity(features),
            consensus: Consensus::with_capacity(features),
            histogram: HistogramBuffers::with_capacity(features),
            responses: Vec::with_capacity(features),
            best: empty(),
            next: empty(),
        }
    }

    /// Returns the smallest responses of two lists with which the features can be matched and searched within a budget.
    fn min_responses(&mut self, lists: [&[Feature]; 2], budget: &mut Budget) -> [f64; 2] {
        // Features of each scale and polarity.
        let mut counts = [[0usize; 2 * MAX_PAIRS]; 2];
        for (counts, list) in counts.iter_mut().zip(lists) {
            list.iter().for_each(|f| counts[2 * (usize::from(f.scale) % MAX_PAIRS) + usize::from(f.bright)] += 1);
        }
        let comparisons: usize = counts[0].iter().zip(counts[1]).map(|(from, to)| from * to).sum();
        let linear = (FEATURE_WORK * (lists[0].len() + lists[1].len())) as f64;
        let square = COMPARISON_WORK * comparisons as f64;
        // The largest share `s` with `linear s + square s^2` within the budget.
        let left = budget.left() as f64;
        if linear + square <= left {
            return [f64::NEG_INFINITY; 2];
        }
        let share = 2.0 * left / (linear + (linear * linear + 4.0 * square * left).sqrt());
        lists.map(|list| {
            let kept = (share * list.len() as f64) as usize;
            self.responses.clear();
            self.responses.extend(list.iter().map(|f| f.response));
            if kept == 0 {
                return f64::INFINITY;
            }
            *self.responses.select_nth_unstable_by(kept - 1, |a, b| b.total_cmp(a)).1
        })
    }

    /// Matches once and searches once, starting from `start`, and writes the result into `next`.
    fn round(
        &mut self,
        matching: &Matching,
        ransac: &Ransac,
        start: Option<&Matrix3<f64>>,
        budget: &mut Budget,
        reference: &[Feature],
        current: &[Feature],
    ) -> Result<(), RansacError> {
        let next = &mut self.next;
        if !matching.matches_into(budget, &mut self.matching, &mut next.matches) {
            return Err(RansacError::BudgetExhausted);
        }
        next.pairs.clear();
        next.pairs.extend(matched_pairs(&next.matches, reference, current));
        let gate_radius = matching.gate.map(|gate| gate.radius);
        ransac.run_into(&next.pairs, gate_radius, start, budget, &mut self.search, &mut self.consensus)?;
        let Consensus { homography, inliers, rms, quality, .. } = &mut self.consensus;
        (next.homography, next.model, next.rms, next.quality) = (*homography, ransac.model, *rms, *quality);
        std::mem::swap(&mut next.inliers, inliers);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::feature::Descriptor;
    use crate::motion::model::transfer;
    use nalgebra::Vector2;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn feature(rng: &mut ChaCha8Rng, position: Vector2<f64>, words: [u32; 4], group: (u8, bool)) -> Option<Feature> {
        let (x, y) = (position.x.round(), position.y.round());
        // A parabola with its vertex at the position: f(t) = 100 - 8 (t - offset)^2, and its neighbours at -1 and 1.
        let f = |offset: f64| [100.0 - 8.0 * (1.0 + offset).powi(2), 100.0 - 8.0 * (1.0 - offset).powi(2)];
        let (dx, dy) = (position.x - x, position.y - y);
        let lift = |v: f64, offset: f64| v + 8.0 * offset * offset;
        let ([l, r], [u, d]) = (f(dx), f(dy));
        // Every bit flips with probability 1/16.
        let mut flips = || rng.random::<u32>() & rng.random::<u32>() & rng.random::<u32>() & rng.random::<u32>();
        let noisy = words.map(|word| word ^ flips());
        (x >= 0.0 && y >= 0.0).then(|| Feature {
            x: x as u32,
            y: y as u32,
            scale: group.0,
            bright: group.1,
            response: 100.0,
            neighbours: [lift(l, dx), lift(r, dx), lift(u, dy), lift(d, dy)],
            descriptor: Descriptor::of_two([noisy[0], noisy[1]], [noisy[2], noisy[3]]),
        })
    }

    /// Returns the features of two pictures: `common` are in both, as many again in each alone.
    fn pictures(h: &Matrix3<f64>, common: usize, seed: u64) -> (Vec<Feature>, Vec<Feature>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut reference, mut current) = (Vec::new(), Vec::new());
        for i in 0..3 * common {
            let position = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
            let words = [rng.random(), rng.random(), rng.random(), rng.random()];
            let group = (u8::from(rng.random::<bool>()), rng.random());
            if i < 2 * common {
                reference.extend(feature(&mut rng, position, words, group));
            }
            if i < common || i >= 2 * common {
                current.extend(feature(&mut rng, transfer(h, position).unwrap(), words, group));
            }
        }
        (reference, current)
    }

    /// 5 degrees, 5 % larger, 200 px, and oblique: the scale changes by 5 % over the picture, so a similarity that fits
    /// the centre is off by more than dist at the border.
    fn oblique() -> Matrix3<f64> {
        let (s, c) = (5f64.to_radians().sin(), 5f64.to_radians().cos());
        Matrix3::new(1.05 * c, -1.05 * s, 200.0, 1.05 * s, 1.05 * c, -90.0, 3e-5, -4e-5, 1.0)
    }

    #[test]
    fn an_oblique_motion_is_found_to_a_fraction_of_a_pixel() {
        for seed in 0..5 {
            let (reference, current) = pictures(&oblique(), 200, seed);
            let found = Estimator::default().estimate(&reference, &current).unwrap();
            let centre = Vector2::new(511.5, 383.5);
            let miss = (transfer(&found.homography, centre).unwrap() - transfer(&oblique(), centre).unwrap()).norm();
            // The positions are exact; a wrong match within 3 px among 150 moves the least squares by a few hundredths.
            assert!(miss < 0.05, "{miss}");
            assert_eq!(found.model, Model::Homography);
            assert!(found.inliers.len() > 150, "{}", found.inliers.len());
        }
    }

    #[test]
    fn unrelated_pictures_give_no_estimate() {
        for seed in 0..20 {
            let reference = pictures(&oblique(), 250, 2 * seed).0;
            let current = pictures(&oblique(), 250, 2 * seed + 1).1;
            let outcome = Estimator::default().estimate(&reference, &current);
            assert!(outcome.as_ref().is_err_and(RansacError::is_no_estimate), "{outcome:?}");
        }
        assert!(Estimator::default().estimate(&[], &[]).is_err_and(|error| error.is_no_estimate()));
    }

    #[test]
    fn the_estimate_has_the_requested_model() {
        let shift = Matrix3::new(1.0, 0.0, 40.0, 0.0, 1.0, 25.0, 0.0, 0.0, 1.0);
        let (reference, current) = pictures(&shift, 100, 3);
        for model in [Model::Shift, Model::Similarity, Model::Affine, Model::Homography] {
            let estimator = Estimator { ransac: Ransac { model, ..Ransac::default() }, ..Estimator::default() };
            let found = estimator.estimate(&reference, &current).unwrap();
            assert_eq!(found.model, model);
            assert!((found.homography - shift).abs().max() < 1e-3, "{model:?} {}", found.homography);
        }
    }
}
