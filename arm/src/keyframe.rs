//! Keyframes: the features of earlier frames as landmarks, and matching where the filter predicts them.
//!
//! A landmark is proven once it was seen [`MIN_GOOD_SIGHTINGS`] times at its place, and as long as one of
//! [`MAX_FRAMES_PER_SIGHTING`] frames that should show it does: features of cars are not, though one or another passes
//! by the place. Each has its own covariance of residuals, so that a feature which slides along an edge, or belongs to
//! a crown of leaves, loses weight in that direction alone.
//!
//! The strongest feature of each of 256 squares of a keyframe has a template, if the pixels of the keyframe came with
//! it, and of each of 400 if patches alone will be fitted. Where it is matched in a frame whose pixels came too, the
//! template is refined from the position of the match ([`hoverlock_fixed_point::refinement`]), and the sighting is that
//! of the patch, a few hundredths of a pixel in place of a few tenths. Its residuals have a covariance of their own.

use crate::filter::{Filter, Inconsistency, Prediction, Sighting};
use crate::line::MIN_FEATURES;
use hoverlock_fixed_point::refinement::{Refined, Template};
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::estimate::Estimate as Motion;
use hoverlock_reference::motion::model::{derivative, transfer};
use hoverlock_reference::motion::orthophoto::Camera;
use nalgebra::{Matrix2, Matrix3, Vector2};

/// Ages between which the share of its landmarks that confirms a keyframe falls, s. Waves of a metre or two keep their
/// form for a second.
pub const CONFIRMATION_AGE_S: [f64; 2] = [0.5, 2.0];
/// Product of age and share that confirms, s: the share falls to 0.15, and over waves faster.
const CONFIRMATION_SHARE_S: f64 = 0.3;
/// Good sightings after which a landmark may be proven.
const MIN_GOOD_SIGHTINGS: u32 = 3;
/// Frames that should show a proven landmark, at most, for each good sighting.
const MAX_FRAMES_PER_SIGHTING: u32 = 8;
/// Proven landmarks of a frame from which on the others do not count.
const MIN_PROVEN_LANDMARKS: usize = 8;
/// Inliers that a frame needs at least, if only proven landmarks count and if all do.
const MIN_INLIERS: [usize; 2] = [5, MIN_FEATURES];
/// Comparisons for each further inlier that it needs: one chance match in hundreds of comparisons.
const COMPARISONS_PER_INLIER: usize = 50;
/// Sightings over which the covariance of residuals is averaged.
const AVERAGED_SIGHTINGS: u32 = 16;
/// Factor of the covariance of residuals.
const RESIDUAL_FACTOR: f64 = 3.0;
/// Standard error of a sighting of a landmark without a history, px, refined or not: relief and lens move it.
const NEW_SIGMA_PX: f64 = 0.5;
/// Smallest standard error of a sighting of a landmark with a history, px.
const MIN_SIGMA_PX: f64 = 0.25;
/// Templates of a keyframe at most, and of one to which patches alone are fitted.
const MAX_TEMPLATES: [usize; 2] = [256, 400];
/// Side of the squares of a keyframe that have a template each, px, at least, in the same order.
const MIN_TEMPLATE_SPACING_PX: [usize; 2] = [48, 32];
/// Patches that are refined in a frame at most.
pub const MAX_REFINED: usize = 100;
/// The same where patches alone are fitted.
pub const MAX_PATCHES: usize = 160;
/// Patches that were refined in a frame, from which on landmarks without a template take turns in the next, or from
/// which on patches alone are fitted.
pub const MIN_REFINED: usize = 30;
/// Landmarks without a template that are then matched in a frame, about.
const TRIED_OTHERS: usize = 256;
/// Distance from the border of a frame of the middle of a patch that is looked for, px.
const PATCH_PX: f64 = 16.0;
/// Smallest standard error of a refined sighting, px.
const MIN_REFINED_SIGMA_PX: f64 = 0.05;
/// The same without samples of the IMU, where no error persists: no comparison of noisy frames is more accurate.
const MIN_FREE_SIGMA_PX: f64 = 0.02;
/// Radius of the gate, in standard deviations.
const GATE_SIGMAS: f64 = 3.5;
/// Largest radius of the gate, px, with samples of the IMU (a third of a metre in the narrow view from 20 m), and
/// without, where a search fits patches alone. Frames that are less certain are searched.
const MAX_GATE_PX: [f64; 2] = [96.0, 48.0];
/// Bits that may differ, of 128.
const MAX_HAMMING: u32 = 12;
/// Radius of agreement of the vote, px; it is taken if the gate is larger than this.
const VOTE_RADIUS_PX: f64 = 3.0;
/// Sightings whose shift is a candidate of the vote.
const MAX_VOTE_CANDIDATES: usize = 64;
/// Work units of predicting a landmark, and of a gate.
pub const LANDMARK_WORK: usize = 175;
/// Work units of a feature in the rows of a gate.
pub const SCANNED_WORK: usize = 2;
/// Work units of a feature in a gate.
pub const COMPARISON_WORK: usize = 14;
/// Work units of making a sighting.
pub const SIGHTED_WORK: usize = 20;
/// Work units of a sighting in the vote.
pub const VOTED_WORK: usize = 64;
/// Work units of cutting a template.
pub const TEMPLATE_WORK: usize = 2_100;
/// Work units of refining a patch.
pub const REFINED_WORK: usize = 3_300;

/// A feature of a keyframe with its history.
#[derive(Debug, Clone, Copy, Default)]
struct Landmark {
    /// Good sightings.
    good: u32,
    /// Frames that should show it.
    expected: u32,
    /// Mean square of the residuals of its features.
    residual: Matrix2<f64>,
    /// Good sightings of its template, and the mean square of their residuals.
    refined: u32,
    refined_residual: Matrix2<f64>,
    /// Index of its template.
    template: Option<u16>,
}

/// Returns the covariance of a sighting after `sightings` with a mean square `residual` of their residuals, px^2.
fn covariance_after(sightings: u32, residual: &Matrix2<f64>, min_sigma: f64) -> Matrix2<f64> {
    if sightings < MIN_GOOD_SIGHTINGS {
        return Matrix2::identity() * (NEW_SIGMA_PX * NEW_SIGMA_PX);
    }
    Matrix2::identity() * (min_sigma * min_sigma) + residual * RESIDUAL_FACTOR
}

/// An earlier frame with its features.
pub struct Keyframe {
    /// Frame number; `None` if it was not readable, or the slot is free.
    pub frame: Option<u32>,
    /// The camera at its zoom.
    pub camera: Camera,
    /// Features, at most the capacity.
    pub features: Vec<Feature>,
    /// Largest share, over frames, of the matched landmarks whose sightings agree.
    pub best_share: f64,
    /// Enough patches were refined in the last frame that most landmarks without a template can take turns.
    pub takes_turns: bool,
    /// Frames that it was found in.
    turn: usize,
    /// Work units of the last frame in which it was tracked.
    pub work: u64,
    /// Count of keyframes before this one.
    pub age: u64,
    /// Time of its frame, us; the largest number if its clock is not that of the frames.
    pub time_us: u64,
    /// What it shows is ground: it was found again as late as [`CONFIRMATION_AGE_S`] asks for, or it was made from one
    /// that was.
    pub is_confirmed: bool,
    /// Factors of standard errors with which its pose was estimated.
    pub inconsistency: Inconsistency,
    landmarks: Vec<Landmark>,
    templates: Vec<Template>,
}

impl Keyframe {
    /// Allocates memory for `features` features.
    pub fn with_capacity(features: usize) -> Self {
        Self {
            frame: None,
            camera: Camera::default(),
            features: Vec::with_capacity(features),
            best_share: 0.0,
            takes_turns: false,
            turn: 0,
            work: 0,
            age: 0,
            time_us: 0,
            is_confirmed: false,
            inconsistency: Inconsistency::NONE,
            landmarks: Vec::with_capacity(features),
            templates: Vec::with_capacity(MAX_TEMPLATES[1]),
        }
    }

    /// Takes the features of a frame of the time `time_us`.
    pub fn fill(&mut self, frame: Option<u32>, time_us: u64, camera: Camera, features: &[Feature], age: u64) {
        (self.frame, self.time_us, self.is_confirmed) = (frame, time_us, false);
        self.camera = camera;
        (self.best_share, self.takes_turns, self.turn) = (0.0, false, 0);
        (self.age, self.inconsistency) = (age, Inconsistency::NONE);
        self.features.clear();
        self.features.extend_from_slice(features);
        self.landmarks.clear();
        self.landmarks.resize(features.len(), Landmark::default());
        self.templates.clear();
    }

    /// Cuts the templates from the pixels of the keyframe, as many as `budget` pays for, and more if patches alone will
    /// be fitted. `strongest` is memory.
    pub fn cut_templates(
        &mut self,
        pixels: &Plane<u16>,
        are_alone: bool,
        strongest: &mut Vec<Option<usize>>,
        budget: &mut Budget,
    ) {
        let squares = |side: usize| [pixels.width().div_ceil(side), pixels.height().div_ceil(side)];
        let kind = usize::from(are_alone);
        let mut side = MIN_TEMPLATE_SPACING_PX[kind];
        while squares(side).iter().product::<usize>() > MAX_TEMPLATES[kind] {
            side += 1;
        }
        let [columns, rows] = squares(side);
        strongest.clear();
        strongest.resize(columns * rows, None);
        for (index, feature) in self.features.iter().enumerate() {
            let [x, y] = [feature.x, feature.y].map(|v| v as usize / side);
            let Some(best) = strongest.get_mut(columns * y + x) else { continue };
            if best.is_none_or(|best: usize| self.features[best].response < feature.response) {
                *best = Some(index);
            }
        }
        for landmark in strongest.iter().flatten().copied() {
            if !budget.spend(TEMPLATE_WORK) {
                break;
            }
            let [x, y] = position(&self.features[landmark]).map(|v| v.round() as usize).into();
            if let Some(template) = Template::cut(pixels, x, y) {
                self.landmarks[landmark].template = Some(self.templates.len() as u16);
                self.templates.push(template);
            }
        }
        self.takes_turns = self.templates.len() >= 2 * MIN_REFINED;
    }

    /// Refines sightings that count and have a template, at most `most`, evenly chosen, and returns the number of
    /// patches that were tried. `homography` maps the keyframe to the present frame, near enough for the warp of a
    /// patch.
    pub fn refine(
        &mut self,
        sightings: &mut [Sighting],
        pixels: &Plane<u16>,
        homography: &Matrix3<f64>,
        most: usize,
    ) -> usize {
        let has_template =
            |sighting: &&mut Sighting| sighting.counts && self.landmarks[sighting.landmark].template.is_some();
        let count = sightings.iter_mut().filter(has_template).count();
        let (mut tried, mut found) = (0, 0);
        if most == 0 || count == 0 {
            return 0;
        }
        for sighting in sightings.iter_mut().filter(has_template).step_by(count.div_ceil(most)) {
            tried += 1;
            let Some(refined) = self.refined(sighting, pixels, homography) else { continue };
            let landmark = &self.landmarks[sighting.landmark];
            let persisting = covariance_after(landmark.refined, &landmark.refined_residual, MIN_REFINED_SIGMA_PX);
            *sighting = Sighting { covariance: refined.covariance + persisting, ..refined };
            found += 1;
        }
        self.takes_turns = found >= MIN_REFINED;
        tried
    }

    /// Refines the templates that the present frame shows, at most `most` of them, evenly chosen, and adds what was
    /// found to `memory.sightings`. They are sought where the consensus of a search has their landmark, or where
    /// `homography` has it. Returns the number of patches that were tried.
    pub fn refine_all(
        &self,
        motion: &Motion,
        homography: &Matrix3<f64>,
        pixels: &Plane<u16>,
        most: usize,
        memory: &mut MatchMemory,
    ) -> usize {
        let MatchMemory { starts, sightings, .. } = memory;
        let size = Vector2::new(pixels.width() as f64, pixels.height() as f64);
        let is_inside =
            |p: &Vector2<f64>| p.iter().zip(&size).all(|(at, side)| (PATCH_PX..=side - PATCH_PX).contains(at));
        starts.clear();
        starts.extend(self.features.iter().zip(&self.landmarks).map(|(feature, landmark)| {
            landmark.template.and_then(|_| transfer(homography, position(feature))).filter(is_inside)
        }));
        for &i in &motion.inliers {
            let start = &mut starts[motion.matches[i].reference];
            *start = start.and(Some(motion.pairs[i].current));
        }
        let count = starts.iter().flatten().count();
        let most = most.min(count);
        let found = starts.iter().enumerate().filter_map(|(landmark, start)| start.map(|start| (landmark, start)));
        for ((landmark, start), _) in found.zip(evenly(most, count)).filter(|(_, is_chosen)| *is_chosen) {
            if let Some(refined) = self.refined(&self.sighting(landmark, start), pixels, homography) {
                let floor = Matrix2::identity() * (MIN_FREE_SIGMA_PX * MIN_FREE_SIGMA_PX);
                sightings.push(Sighting { covariance: refined.covariance + floor, ..refined });
            }
        }
        most
    }

    /// Returns a sighting with the positions of its patch, and the covariance that these have by their pixels alone;
    /// `None` without a template, or if the frame does not show the patch.
    fn refined(&self, sighting: &Sighting, pixels: &Plane<u16>, homography: &Matrix3<f64>) -> Option<Sighting> {
        let template = self.templates.get(usize::from(self.landmarks[sighting.landmark].template?))?;
        let centre = template.centre();
        let warp = derivative(homography, centre)?;
        let start = sighting.current + warp * (centre - sighting.reference);
        let Refined { position: current, covariance } = template.refine(pixels, start, &warp)?;
        Some(Sighting { reference: centre, current, covariance, is_refined: true, ..*sighting })
    }

    /// Returns a sighting of a landmark by its feature, at `current` (px) in the present frame.
    pub fn sighting(&self, landmark: usize, current: Vector2<f64>) -> Sighting {
        Sighting {
            landmark,
            reference: position(&self.features[landmark]),
            current,
            covariance: self.sighting_covariance(landmark),
            counts: true,
            is_refined: false,
            chi2: 0.0,
            residual: Vector2::zeros(),
        }
    }

    /// Returns the covariance of a sighting of a landmark by its feature, px^2.
    fn sighting_covariance(&self, landmark: usize) -> Matrix2<f64> {
        let Landmark { good, refined, residual, .. } = &self.landmarks[landmark];
        covariance_after(good - refined, residual, MIN_SIGMA_PX)
    }

    /// Returns the landmarks that are matched in the next frame: all of them, or, if enough patches were refined in the
    /// last one, those that have a template and the others in turn.
    pub fn tried(&self) -> impl Iterator<Item = usize> {
        let others = self.features.len() - self.templates.len();
        let step = if !self.takes_turns { 1 } else { others.div_ceil(TRIED_OTHERS).max(1) };
        let landmarks = self.landmarks.iter().enumerate();
        let tried = landmarks
            .filter(move |(index, landmark)| landmark.template.is_some() || (index + self.turn).is_multiple_of(step));
        tried.map(|(index, _)| index)
    }

    /// Returns `true` if a landmark was seen often enough at its place.
    fn is_proven(&self, landmark: usize) -> bool {
        let Landmark { good, expected, .. } = self.landmarks[landmark];
        good >= MIN_GOOD_SIGHTINGS && good.saturating_mul(MAX_FRAMES_PER_SIGHTING) >= expected
    }

    /// Returns its age in a frame of this time (us), s.
    pub fn age_s(&mut self, time_us: u64) -> f64 {
        // If the frame is stamped before it, the time between them is not known: it begins here.
        self.time_us = self.time_us.min(time_us);
        (time_us - self.time_us) as f64 / 1e6
    }

    /// Updates the landmarks by the sightings of a frame, in which `share` of those that were matched agree, and by
    /// what [`match_predicted`] expected in it, if it was called.
    pub fn learn(&mut self, sightings: &[Sighting], share: f64, expected: &[Option<Prediction>]) {
        self.best_share = self.best_share.max(share);
        self.turn += 1;
        for (landmark, _) in self.landmarks.iter_mut().zip(expected).filter(|(_, prediction)| prediction.is_some()) {
            landmark.expected = landmark.expected.saturating_add(1);
        }
        for sighting in sightings.iter().filter(|sighting| sighting.is_consistent()) {
            let landmark = &mut self.landmarks[sighting.landmark];
            landmark.good += 1;
            let Landmark { good, residual, refined, refined_residual, .. } = landmark;
            let (count, mean) = if sighting.is_refined {
                *refined += 1;
                (*refined, refined_residual)
            } else {
                (*good - *refined, residual)
            };
            let share = 1.0 / f64::from(count.min(AVERAGED_SIGHTINGS));
            let square = sighting.residual * sighting.residual.transpose();
            *mean += (square - *mean) * share;
        }
    }
}

/// Returns `true` if a share of its landmarks confirms a keyframe of an age (s).
pub fn confirms(age: f64, share: f64) -> bool {
    let [least, most] = CONFIRMATION_AGE_S;
    age >= least && share >= CONFIRMATION_SHARE_S / age.min(most)
}

/// Reusable memory of the matching.
pub struct MatchMemory {
    /// Prediction of each landmark; `None` if the frame should not show it.
    pub predicted: Vec<Option<Prediction>>,
    /// For each feature of the present frame, the landmark that resembles it most.
    taken: Vec<Option<(u32, usize)>>,
    shifts: Vec<Vector2<f64>>,
    /// Where the template of a landmark is looked for after a search.
    starts: Vec<Option<Vector2<f64>>>,
    /// The strongest feature of each square of a keyframe.
    pub strongest: Vec<Option<usize>>,
    /// Landmarks that were matched.
    pub tried: usize,
    /// The sightings of the last matching.
    pub sightings: Vec<Sighting>,
}

impl MatchMemory {
    /// Allocates memory for `features` features.
    pub fn with_capacity(features: usize) -> Self {
        Self {
            predicted: Vec::with_capacity(features),
            taken: Vec::with_capacity(features),
            shifts: Vec::with_capacity(features),
            starts: Vec::with_capacity(features),
            strongest: Vec::with_capacity(features),
            tried: 0,
            sightings: Vec::with_capacity(features),
        }
    }
}

/// Returns a position of a feature, px.
pub fn position(feature: &Feature) -> Vector2<f64> {
    let (x, y) = feature.subpixel();
    Vector2::new(x, y)
}

/// Matches the landmarks of keyframe `k` with the features of the present frame, in raster order, where the filter
/// predicts them, into `memory.sightings`. Returns the number of inliers that the frame needs; `None` if the prediction
/// is too uncertain for a matching, or if the budget does not pay for the predictions. If it ends later, landmarks that
/// are spread over the picture have been matched, and the others count as not expected. So do those whose own gate is
/// larger than [`MAX_GATE_PX`].
pub fn match_predicted(
    filter: &Filter,
    k: usize,
    keyframe: &Keyframe,
    camera: &Camera,
    current: &[Feature],
    memory: &mut MatchMemory,
    budget: &mut Budget,
) -> Option<usize> {
    let middle = keyframe.camera.last_pixel() / 2.0;
    let max_gate = MAX_GATE_PX[usize::from(filter.is_free())];
    let mut is_uncertain = false;
    filter.images(k, [&keyframe.camera, camera], std::iter::once((0, middle)), |_, prediction| {
        let reach = gate_reach(&prediction.covariance);
        is_uncertain = reach[0].max(reach[1]) > max_gate;
    });
    memory.tried = keyframe.tried().count();
    let fixed = LANDMARK_WORK * memory.tried + SIGHTED_WORK * current.len();
    if is_uncertain || !budget.spend(fixed) {
        return None;
    }
    let MatchMemory { predicted, taken, shifts, sightings, .. } = memory;
    let last = camera.last_pixel();
    predicted.clear();
    predicted.resize(keyframe.features.len(), None);
    let pixels = keyframe.tried().map(|landmark| (landmark, position(&keyframe.features[landmark])));
    filter.images(k, [&keyframe.camera, camera], pixels, |landmark, prediction| {
        if (0.0..=last.x).contains(&prediction.image.x) && (0.0..=last.y).contains(&prediction.image.y) {
            predicted[landmark] = Some(prediction);
        }
    });
    taken.clear();
    taken.resize(current.len(), None);
    // Of landmarks that are not proven, and of proven ones.
    let mut comparisons = [0; 2];
    let mut largest: f64 = 0.0;
    let mut order = spread(predicted.len());
    while let Some(landmark) = order.next() {
        let Some(prediction) = predicted[landmark] else { continue };
        let covariance = prediction.covariance + keyframe.sighting_covariance(landmark);
        let Some(inverse) = covariance.try_inverse() else { continue };
        let reach = gate_reach(&covariance);
        let reached = reach[0].max(reach[1]);
        // Its own residuals are large, or it is far from the middle: the others are matched without it.
        if reached.is_nan() || reached > max_gate {
            predicted[landmark] = None;
            continue;
        }
        largest = largest.max(reached);
        let feature = &keyframe.features[landmark];
        let top = (prediction.image.y - reach[1]).max(0.0) as u32;
        let bottom = prediction.image.y + reach[1] + 1.0;
        let first = current.partition_point(|other| other.y < top);
        let count = current[first..].partition_point(|other| f64::from(other.y) <= bottom);
        let mut is_paid = budget.spend(SCANNED_WORK * count);
        let mut best: Option<(u32, usize)> = None;
        for (index, other) in current.iter().enumerate().skip(first).take(if is_paid { count } else { 0 }) {
            let near = (f64::from(other.x) - prediction.image.x).abs() <= reach[0] + 1.0;
            if !near || other.scale != feature.scale || other.bright != feature.bright {
                continue;
            }
            is_paid = budget.spend(COMPARISON_WORK);
            if !is_paid {
                break;
            }
            let miss = position(other) - prediction.image;
            if miss.dot(&(inverse * miss)) > GATE_SIGMAS * GATE_SIGMAS {
                continue;
            }
            comparisons[usize::from(keyframe.is_proven(landmark))] += 1;
            let differ = feature.descriptor.hamming(&other.descriptor, false);
            if differ <= MAX_HAMMING && best.is_none_or(|(least, _)| differ < least) {
                best = Some((differ, index));
            }
        }
        if !is_paid {
            predicted[landmark] = None;
            order.by_ref().for_each(|landmark| predicted[landmark] = None);
            break;
        }
        // Of equals the first landmark is taken, in whatever order they come.
        if let Some((differ, index)) = best
            && taken[index].is_none_or(|least| (differ, landmark) < least)
        {
            taken[index] = Some((differ, landmark));
        }
    }
    sightings.clear();
    for (index, found) in taken.iter().enumerate() {
        let Some((_, landmark)) = found else { continue };
        let sighting = keyframe.sighting(*landmark, position(&current[index]));
        sightings.push(Sighting { counts: keyframe.is_proven(*landmark), ..sighting });
    }
    let is_startup = sightings.iter().filter(|sighting| sighting.counts).count() < MIN_PROVEN_LANDMARKS;
    if is_startup {
        sightings.iter_mut().for_each(|sighting| sighting.counts = true);
    }
    let counted = if is_startup { comparisons.iter().sum() } else { comparisons[1] };
    if largest > VOTE_RADIUS_PX {
        shifts.clear();
        shifts.extend(sightings.iter().map(|sighting| {
            sighting.current - predicted[sighting.landmark].map_or(sighting.current, |prediction| prediction.image)
        }));
        if !budget.spend(VOTED_WORK * shifts.len()) {
            return None;
        }
        keep_consensus(shifts, sightings);
    }
    Some(MIN_INLIERS[usize::from(is_startup)] + counted / COMPARISONS_PER_INLIER)
}

/// Returns for each of `count` things in turn whether it is one of `most`, which is at most `count`, evenly chosen.
pub fn evenly(most: usize, count: usize) -> impl Iterator<Item = bool> {
    (0..count).map(move |index| (index + 1) * most / count > index * most / count)
}

/// Returns the numbers below `count`, each once, so that every beginning is spread evenly: steps near the golden ratio.
fn spread(count: usize) -> impl Iterator<Item = usize> {
    let is_coprime = |step: &usize| {
        let (mut a, mut b) = (count, *step);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    let golden = count * 618 / 1000;
    let step = (golden.max(1)..=count.max(1)).find(is_coprime).unwrap_or(1);
    (0..count).map(move |i| i * step % count)
}

/// Returns half the width and half the height of the gate, px.
fn gate_reach(covariance: &Matrix2<f64>) -> [f64; 2] {
    [0, 1].map(|axis| GATE_SIGMAS * covariance[(axis, axis)].sqrt())
}

/// Keeps the sightings whose shift from the prediction is near the one on which most of those that count agree.
fn keep_consensus(shifts: &[Vector2<f64>], sightings: &mut Vec<Sighting>) {
    let radius = VOTE_RADIUS_PX * VOTE_RADIUS_PX;
    let counting = || shifts.iter().zip(&*sightings).filter(|(_, sighting)| sighting.counts).map(|(shift, _)| *shift);
    let votes = |shift: &Vector2<f64>| counting().filter(|other| (other - shift).norm_squared() <= radius).count();
    let step = counting().count().div_ceil(MAX_VOTE_CANDIDATES).max(1);
    // The last of equals is taken, which is the same everywhere.
    let Some(best) = counting().step_by(step).max_by_key(|shift| votes(shift)) else { return };
    let mut index = 0;
    sightings.retain(|_| {
        index += 1;
        (shifts[index - 1] - best).norm_squared() <= 4.0 * radius
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Step;
    use hoverlock_reference::features::feature::Descriptor;
    use hoverlock_reference::motion::observation::SensorErrors;
    use hoverlock_reference::motion::orthophoto::Attitude;
    use nalgebra::Vector3;

    const SENSORS: SensorErrors = SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 };

    fn camera() -> Camera {
        Camera::with_field_of_view(1024, 768, 0.87).unwrap()
    }

    /// Features 60 px apart, each with a descriptor that no other has.
    fn features() -> Vec<Feature> {
        let feature = |i: u32| Feature {
            x: 40 + 60 * (i % 16),
            y: 40 + 60 * (i / 16),
            scale: 0,
            bright: true,
            response: 100.0,
            neighbours: [90.0; 4],
            descriptor: Descriptor::of_two([i.wrapping_mul(0x9e37_79b9), !i], [i << 7, i]),
        };
        (0..192).map(feature).collect()
    }

    /// A filter that begins 50 m above a keyframe with the features.
    fn filter_and_keyframe() -> (Filter, Keyframe) {
        let mut filter = Filter::new();
        filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
        filter.clone_pose(0);
        let mut keyframe = Keyframe::with_capacity(192);
        keyframe.fill(Some(0), 0, camera(), &features(), 1);
        (filter, keyframe)
    }

    #[test]
    fn a_share_confirms_at_its_age() {
        let shares = |age: f64| [1.0, 0.6, 0.4, 0.2, 0.1].map(|share| confirms(age, share));
        assert_eq!(shares(0.4), [false; 5]);
        assert_eq!(shares(0.5), [true, true, false, false, false]);
        assert_eq!(shares(1.0), [true, true, true, false, false]);
        assert_eq!([shares(2.0), shares(3600.0)], [[true, true, true, true, false]; 2]);
    }

    #[test]
    fn a_clock_that_steps_back_begins_the_age_of_a_keyframe() {
        let (_, mut keyframe) = filter_and_keyframe();
        keyframe.time_us = 10_000_000;
        assert_eq!([10_500_000, 4_000_000, 4_600_000].map(|time_us| keyframe.age_s(time_us)), [0.5, 0.0, 0.6]);
    }

    /// Returns the landmarks that are found in a frame with the same features.
    fn matched(filter: &Filter, keyframe: &Keyframe) -> Option<Vec<usize>> {
        let mut memory = MatchMemory::with_capacity(192);
        let mut budget = Budget::UNLIMITED;
        match_predicted(filter, 0, keyframe, &camera(), &features(), &mut memory, &mut budget)?;
        Some(memory.sightings.iter().map(|sighting| sighting.landmark).collect())
    }

    #[test]
    fn frames_are_matched_up_to_96_px_with_the_imu_and_up_to_48_without() {
        let after = |seconds: f64, has_sample: bool| {
            let (mut filter, keyframe) = filter_and_keyframe();
            filter.predict_free(seconds);
            if has_sample {
                let force = Vector3::new(0.0, 0.0, -9.81);
                let step = Step { rates: Vector3::zeros(), force, seconds: 1e-5 };
                filter.predict(std::iter::once(step), &SENSORS);
            }
            let mut reach = [0.0; 2];
            let middle = std::iter::once((0, camera().last_pixel() / 2.0));
            filter.images(0, [&camera(); 2], middle, |_, image| reach = gate_reach(&image.covariance));
            (reach[0].max(reach[1]).round(), matched(&filter, &keyframe).map(|found| found.len()))
        };
        assert_eq!([0.015, 0.020].map(|seconds| after(seconds, false)), [(39.0, Some(192)), (52.0, None)]);
        assert_eq!([0.030, 0.038].map(|seconds| after(seconds, true)), [(78.0, Some(192)), (99.0, None)]);
    }

    /// In the narrow view a landmark on a roof may be tens of pixels from where the filter expects it.
    #[test]
    fn a_landmark_with_large_residuals_does_not_stop_the_others() {
        let (filter, mut keyframe) = filter_and_keyframe();
        assert_eq!(matched(&filter, &keyframe), Some((0..192).collect()));
        let landmark = &mut keyframe.landmarks[100];
        (landmark.good, landmark.residual) = (10, Matrix2::identity() * 400.0);
        assert_eq!(matched(&filter, &keyframe), Some((0..192).filter(|i| *i != 100).collect()));
    }
}
