//! The estimator: one filter for all frames, with keyframes that are matched where it predicts them.
//!
//! A frame is processed in this order:
//!
//! 1. The filter predicts over the samples of the IMU since the frame before, or over any motion if there are none.
//! 2. Attitude reading and laser range update it.
//! 3. Landmarks of the first keyframe, and of the most similar other one if the first is far, are matched within the
//!    gate of the prediction, and the filter is fitted to them ([`crate::keyframe`], [`crate::filter`]).
//! 4. If no keyframe was found so, because the prediction is uncertain or after a loss, RANSAC acquires: it matches
//!    without the prediction, and the filter accepts its pairs only if the change is possible for the vehicle.
//!
//! A frame without a keyframe has no estimate; the filter coasts and its covariance grows. A frame becomes a keyframe
//! if the nearest keyframe overlaps by less than [`MIN_OVERLAP`] or differs in scale by more than
//! [`MAX_SCALE_CHANGE`], and only if it shows enough of the landmarks that it should; or if no keyframe is in view and
//! the filter still knows its place. That one is not confirmed until it is found again at an age at which the captured
//! frame would be ([`CONFIRMATION_AGE_S`]), and with it those that come from it. With samples of the IMU, a frame that
//! does not show an unconfirmed keyframe replaces it: a blind camera shows noise, or white.
//!
//! **Confirmation.** Waves look like ground until they have moved on. So no estimate is published until the captured
//! frame has been found again [`CONFIRMATION_AGE_S`] after its capture. Until then the laser ranges are collected. If
//! their median contradicts the range at the capture, the height is corrected. Without samples of the IMU that may be
//! later too, as long as no range has agreed with the first.
//!
//! **Contradicting readings.** The filter ignores a reading that contradicts its state. Without samples of the IMU
//! nothing says which of the two is wrong, so the standard error includes the displacement under the other
//! ([`Contradiction`]).
//!
//! **Covariance and protection level.** The filter counts a 16th of the information of sightings, because some errors
//! persist. Of its covariance `P` and the inconsistency ([`Inconsistency`]), that of the frame or that with which its
//! keyframe was made, whichever is larger, with `k` on the mean and `b` as the bound,
//!
//! ```text
//! covariance         min(k, 10)^2 P / 16
//! protection level   max(0.05 m, 4.8 b s + 0.02 |d|)
//! ```
//!
//! The covariance is what errors are on the mean; that of the velocity has the same factors. The protection level is
//! the radius that one error of 100 000 exceeds if they are normal: `s` is the standard error by `P` along the worse
//! direction, `d` the displacement, whose scale has the error of the focal length. Without samples of the IMU the
//! covariance is `min(k, 10)^2 P`. Where `P` is that of patches alone, the protection level has twice the standard
//! errors.

use crate::calibration::Calibration;
use crate::filter::{Filter, INFORMATION_SHARE, Inconsistency, MAX_KEYFRAMES, Step};
use crate::keyframe::{
    CONFIRMATION_AGE_S, Keyframe, MAX_PATCHES, MAX_REFINED, MIN_REFINED, MatchMemory, REFINED_WORK, confirms, evenly,
    match_predicted,
};
use crate::line::{Estimate, MIN_FEATURES, Reason, Velocity};
use crate::message::{InertialSample, Telemetry};
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::estimator::{Estimator, Workspace};
use hoverlock_reference::motion::mark::{Part, mark};
use hoverlock_reference::motion::model::{Model, Pair, transfer};
use hoverlock_reference::motion::observation::Observation;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View};
use hoverlock_reference::motion::ransac::RansacError;
use hoverlock_reference::motion::sensor_pattern;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Samples of the IMU that are kept: five seconds at 200 a second.
const MAX_SAMPLES: usize = 1024;
/// Longest interval that two samples, or the last one, may span, us.
const MAX_SAMPLE_INTERVAL_US: u64 = 50_000;
/// Time between two frames that the samples need not cover, us: two samples at 200 a second.
const MAX_UNCOVERED_US: u64 = 10_000;
/// Time by which a sample may be later than a frame, us: with more its clock is another.
const MAX_AHEAD_US: u64 = 5_000_000;
/// Largest jumps from one sample to the next that need no other to confirm them, rad/s and m/s^2.
const MAX_JUMPS: [f64; 2] = [5.0, 50.0];
/// Longest time over which a prediction without samples grows, s.
const MAX_FREE_S: f64 = 10.0;

/// Time for which samples of the IMU must be complete before a velocity is published, us.
const VELOCITY_US: u64 = 500_000;

/// Smallest overlap with a keyframe, as a fraction of its picture, from which on the frame becomes a keyframe.
const MIN_OVERLAP: f64 = 0.6;
/// Logarithm of the change of scale from which on a frame becomes a keyframe.
const MAX_SCALE_CHANGE: f64 = 0.10;
/// Smallest number of inliers of a frame that becomes a keyframe, as a share of the best of the keyframe in view.
const MIN_INLIER_SHARE: f64 = 0.4;
/// Overlap down to which a keyframe is tried.
const USABLE_OVERLAP: f64 = 0.15;
/// Logarithm of the change of scale up to which a keyframe is tried.
const USABLE_SCALE_CHANGE: f64 = 0.16;
/// Lost overlap, and four times the logarithm of the change of scale, up to which the first keyframe suffices.
const MAX_FIRST_DISTANCE: f64 = 0.4;
/// Factor of the change of scale in the distance of a keyframe.
const SCALE_DISTANCE: f64 = 4.0;
/// Columns and rows of the points by which the overlap is counted.
const OVERLAP_GRID: (u32, u32) = (16, 12);

/// A keyframe is tracked beside another if the budget pays for its work of the last time and one in this more.
const SPARE_SHARE: u64 = 8;
/// Inliers that a keyframe needs at least.
const MIN_INLIERS: usize = MIN_FEATURES;
/// Sightings whose fit the matching must leave work for.
const RESERVED_SIGHTINGS: usize = 256;
/// The same of the search, which needs the work more: what it finds in addition is thinned.
const RESERVED_FOUND: usize = 192;
/// Patches of a search whose refinement and fit it must leave work for.
const RESERVED_PATCHES: usize = 64;
/// Distance from the map of all matches up to which they count in that by which patches are looked for, px.
const MAX_MAPPED_PX: f64 = 1.5;
/// Steps of a prediction at most: with more samples between two frames, neighbours are merged. 0.6 s at 200 a second.
pub const MAX_STEPS: usize = 128;
/// Work units of a step.
pub const STEP_WORK: usize = 2_600;
/// Work units of a sample of the IMU: its message, and its place among the others.
pub const SAMPLE_WORK: usize = 130;
/// Work units of predicting and of adding a keyframe, without steps and states.
pub const KEYFRAMES_WORK: usize = 35_000;
/// Work units of a landmark after a fit: its history.
pub const LEARNED_WORK: usize = 28;
/// Work units of a pair in the map by which patches are looked for.
pub const MAPPED_WORK: usize = 80;
/// Work units of a pair that the search has found: its sighting, and the check for the pattern of the sensor.
pub const ACQUIRED_WORK: usize = 80;

/// Largest protection level with which a smaller share confirms at the second age, m: waves leave residuals that a
/// block of the picture has in common, which raise it.
const MAX_CONFIRMATION_LEVEL_M: f64 = 20.0;
/// Limits of the count of frames that could confirm less those that could not, which must be positive: a search finds
/// something once.
const CONFIRMATION_COUNT_LIMITS: [i32; 2] = [-15, 5];
/// Laser ranges that are collected after a capture.
const MAX_FIRST_HEIGHTS: usize = 32;
/// Laser ranges that a median needs.
const MIN_FIRST_HEIGHTS: usize = 3;
/// Deviation of their median from the first height from which on it is corrected, m.
const HEIGHT_DEVIATION_M: f64 = 3.0;
/// The same, as a part of the height.
const HEIGHT_DEVIATION: f64 = 0.1;
/// Largest standard error of a laser reading that is collected, m.
const MAX_RANGE_ERROR_M: f64 = 1.0;

/// Largest standard error of the filter with an estimate, m: the required accuracy of the whole system.
const MAX_STANDARD_ERROR_M: f64 = 1.0;
/// The same far from the origin, as a part of the displacement: the scale is that of the height over unknown ground.
const MAX_RELATIVE_ERROR: f64 = 0.1;
/// Largest inconsistency that raises the covariance: with more an autopilot would no longer follow estimates, most of
/// which err by less.
const MAX_RAISE: f64 = 10.0;
/// Smallest protection level, m.
const MIN_PROTECTION_LEVEL_M: f64 = 0.05;
/// Standard errors in the protection level: a normal error in the plane exceeds them with a probability of 1e-5.
const PROTECTION_SIGMAS: f64 = 4.8;
/// Factor of the protection level of a fit to patches alone, whose errors persist as long as the helicopter hovers.
const PATCH_MARGIN: f64 = 2.0;
/// Part of the displacement in the protection level.
const PROTECTION_SCALE: f64 = 0.02;
/// Protection level at which the quality has fallen to half, m.
const HALF_QUALITY_M: f64 = 0.5;

/// A frame with its readings and camera.
pub struct Seen<'a> {
    /// Its number; `None` if it was not readable.
    pub frame: Option<u32>,
    /// Readings at its exposure.
    pub telemetry: &'a Telemetry,
    /// The camera at its zoom.
    pub camera: Camera,
    /// Its features in raster order.
    pub features: &'a [Feature],
    /// Its pixels, 16 bits; `None` if they did not come with it.
    pub pixels: Option<&'a Plane<u16>>,
}

/// A keyframe that was found in a frame.
#[derive(Debug, Clone, Copy)]
struct Found {
    keyframe: usize,
    inliers: usize,
    matches: usize,
    /// Share of the landmarks that were matched whose sightings agree.
    share: f64,
    /// The least inconsistency of the keyframes that were found with it.
    inconsistency: Inconsistency,
}

/// By how much the readings of a frame contradict the state of the filter, which ignores them.
#[derive(Debug, Clone, Copy, Default)]
struct Contradiction {
    /// Of attitude, rad about each axis.
    turn: Vector3<f64>,
    /// Of range, as a part of the range that was expected.
    scale: f64,
}

impl Contradiction {
    /// Returns how far a displacement of `moved` (m) at a height (m) is off if the readings are right, m.
    fn error(&self, moved: f64, height: f64) -> f64 {
        (height * self.turn.xy().norm()).hypot(moved * self.turn.z).hypot(moved * self.scale)
    }
}

/// The estimator with its memory.
pub struct Tracker {
    filter: Filter,
    keyframes: Vec<Keyframe>,
    /// Memory of keyframes that are not in use.
    spare: Vec<Keyframe>,
    /// The first keyframe came after the other in the last frame.
    is_reversed: bool,
    /// The keyframe that was commanded: it is matched beside the first.
    commanded: Option<usize>,
    captured: u64,
    /// Inconsistency of the last estimate.
    inconsistency: Inconsistency,
    /// Contradiction of the last frame; none with samples of the IMU.
    contradiction: Contradiction,
    time_us: u64,
    /// Time of the last frame that samples of the IMU did not cover.
    uncovered_us: u64,
    confirmed: bool,
    /// A range has agreed with that of the capture.
    is_range_agreed: bool,
    /// Frames that could confirm the captured one less those that could not.
    confirmation_count: i32,
    first_heights: Vec<f64>,
    samples: Vec<InertialSample>,
    /// A sample later than those, too far from the last of them.
    doubtful: Option<InertialSample>,
    /// Samples that came since the last frame.
    taken: usize,
    steps: Vec<Step>,
    memory: MatchMemory,
    workspace: Workspace,
    inliers: Vec<Pair>,
}

impl Tracker {
    /// Allocates memory for `features` features a frame.
    pub fn with_capacity(features: usize) -> Self {
        Self {
            filter: Filter::new(),
            keyframes: Vec::with_capacity(MAX_KEYFRAMES),
            spare: std::iter::repeat_with(|| Keyframe::with_capacity(features)).take(MAX_KEYFRAMES).collect(),
            is_reversed: false,
            commanded: None,
            captured: 0,
            inconsistency: Inconsistency::NONE,
            contradiction: Contradiction::default(),
            time_us: 0,
            uncovered_us: 0,
            confirmed: false,
            is_range_agreed: false,
            confirmation_count: 0,
            first_heights: Vec::with_capacity(MAX_FIRST_HEIGHTS),
            samples: Vec::with_capacity(MAX_SAMPLES),
            doubtful: None,
            taken: 0,
            steps: Vec::with_capacity(MAX_SAMPLES + 1),
            memory: MatchMemory::with_capacity(features),
            workspace: Workspace::with_capacity(features),
            inliers: Vec::with_capacity(features),
        }
    }

    /// Returns the inliers of the last estimate.
    pub fn inliers(&self) -> &[Pair] {
        &self.inliers
    }

    /// Returns the frame number of the first keyframe; `None` without one, or if it was not readable.
    pub fn origin(&self) -> Option<u32> {
        self.keyframes.first().and_then(|keyframe| keyframe.frame)
    }

    /// Forgets all frames.
    pub fn clear(&mut self) {
        self.spare.append(&mut self.keyframes);
        self.commanded = None;
    }

    /// Gives camera and IMU a calibration, and forgets all frames.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        self.clear();
        self.confirmed = false;
        self.filter.calibrate(calibration);
    }

    /// Forgets the samples of the IMU and the times of frames.
    pub fn restart_clock(&mut self) {
        self.samples.clear();
        self.doubtful = None;
        self.time_us = 0;
        self.keyframes.iter_mut().for_each(|keyframe| keyframe.time_us = u64::MAX);
    }

    /// Takes a sample of the IMU. One that is not later than the one before is ignored, and one that jumps is kept if
    /// the next confirms it.
    pub fn take_sample(&mut self, sample: InertialSample) {
        self.taken = self.taken.saturating_add(1);
        let newest = self.doubtful.as_ref().or(self.samples.last());
        if newest.is_some_and(|newest| newest.time_us >= sample.time_us) {
            return;
        }
        if let Some(doubtful) = self.doubtful.take_if(|doubtful| !jumps(doubtful, &sample)) {
            self.keep_sample(doubtful);
        }
        self.doubtful = None;
        if self.samples.last().is_some_and(|last| jumps(last, &sample)) {
            self.doubtful = Some(sample);
        } else {
            self.keep_sample(sample);
        }
    }

    fn keep_sample(&mut self, sample: InertialSample) {
        if self.samples.len() == MAX_SAMPLES {
            self.samples.drain(..MAX_SAMPLES / 8);
        }
        self.samples.push(sample);
    }

    /// Makes a frame the origin and the only keyframe.
    ///
    /// # Errors
    /// If its readings are no view of the ground, or if it has too few features.
    pub fn capture(&mut self, present: &Seen<'_>, budget: &mut Budget) -> Result<(), Reason> {
        let Seen { telemetry, camera, features, .. } = *present;
        let view = View::new(camera, telemetry.attitude, telemetry.range)?;
        if features.len() < MIN_FEATURES {
            return Err(Reason::Features(features.len()));
        }
        let width = picture_width(&camera, view.height());
        let is_known = self.predict(telemetry, budget);
        let (height, attitude, sensors) = (view.height(), &telemetry.attitude, &telemetry.sensors);
        self.filter.restart(height, attitude, sensors, width, is_known && self.confirmed);
        self.clear();
        (self.confirmed, self.confirmation_count) = (false, 0);
        self.is_range_agreed = false;
        self.first_heights.clear();
        self.inconsistency = Inconsistency::NONE;
        self.add_keyframe(present, budget);
        Ok(())
    }

    /// Estimates the pose of a frame relative to the origin. `renew` asks for a keyframe.
    ///
    /// # Errors
    /// The reason why there is no estimate.
    pub fn estimate(&mut self, present: &Seen<'_>, renew: &mut bool, budget: &mut Budget) -> Result<Estimate, Reason> {
        let Seen { telemetry, camera, features, .. } = *present;
        let view = View::new(camera, telemetry.attitude, telemetry.range)?;
        if self.keyframes.is_empty() {
            return Err(Reason::Reference);
        }
        self.predict(telemetry, budget);
        let filter = &mut self.filter;
        let turn = filter.update_attitude(&telemetry.attitude, &telemetry.sensors);
        let scale = filter.update_range(telemetry.range, telemetry.sensors.range);
        let is_free = filter.is_free();
        self.contradiction = if is_free { Contradiction { turn, scale } } else { Contradiction::default() };
        self.is_range_agreed |= scale == 0.0;
        if !(self.confirmed && self.is_range_agreed)
            && telemetry.sensors.range <= MAX_RANGE_ERROR_M
            && self.first_heights.len() < MAX_FIRST_HEIGHTS
        {
            self.first_heights.push(view.height());
        }
        if is_free && !self.is_range_agreed {
            self.correct_height();
        }
        if features.len() < MIN_FEATURES {
            return Err(Reason::Features(features.len()));
        }
        let found = self.find(present, budget);
        if !self.filter.is_sound() {
            self.clear();
            return Err(Reason::Reference);
        }
        if !self.confirmed {
            self.confirm(present, &found)?;
        }
        let (found, compared) = found?;
        self.inconsistency = self.filter.inconsistency().max(found.inconsistency);
        let estimate = self.result(present, found);
        if let Some(compared) = compared {
            self.renew(present, compared, renew, budget);
        }
        estimate
    }

    /// Confirms the captured frame by one that has found it, or returns the reason why it does not.
    fn confirm(&mut self, present: &Seen<'_>, found: &Result<(Found, Option<Found>), Reason>) -> Result<(), Reason> {
        let [_, most] = CONFIRMATION_AGE_S;
        let age = self.keyframes[0].age_s(present.telemetry.time_us);
        let known = found.clone().and_then(|(found, _)| {
            let level = self.result(present, found)?.protection_level_m;
            if level > MAX_CONFIRMATION_LEVEL_M && !confirms(most, found.share) {
                return Err(Reason::Uncertain(level / PROTECTION_SIGMAS));
            }
            Ok(age >= most || confirms(age, found.share))
        });
        let change = if known.is_ok() { 1 } else { -1 };
        let [fewest, largest] = CONFIRMATION_COUNT_LIMITS;
        self.confirmation_count = (self.confirmation_count + change).clamp(fewest, largest);
        if !known? || self.confirmation_count <= 0 {
            return Err(Reason::Unconfirmed);
        }
        self.confirmed = true;
        self.keyframes[0].is_confirmed = true;
        self.correct_height();
        Ok(())
    }

    /// Predicts the filter to the time of a frame; returns `false` if samples of the IMU are missing.
    fn predict(&mut self, telemetry: &Telemetry, budget: &mut Budget) -> bool {
        let (from, to) = (self.time_us, telemetry.time_us);
        self.time_us = to;
        let is_near = |sample: &InertialSample| sample.time_us <= to.saturating_add(MAX_AHEAD_US);
        self.samples.truncate(self.samples.partition_point(is_near));
        self.doubtful = self.doubtful.take().filter(is_near);
        let filter = &mut self.filter;
        let elapsed = to.checked_sub(from);
        let steps = &mut self.steps;
        steps.clear();
        let mut covered = 0;
        let mut push = |begin: u64, end: u64, one: &InertialSample, other: &InertialSample| {
            let (begin, end) = (begin.max(from), end.min(to));
            if end > begin && steps.len() <= MAX_SAMPLES {
                let mean = |a: &[f64; 3], b: &[f64; 3]| (Vector3::from(*a) + Vector3::from(*b)) / 2.0;
                let (rates, force) = (mean(&one.rates, &other.rates), mean(&one.force, &other.force));
                covered += end - begin;
                steps.push(Step { rates, force, seconds: (end - begin) as f64 / 1e6 });
            }
        };
        for pair in self.samples.windows(2) {
            if pair[1].time_us - pair[0].time_us <= MAX_SAMPLE_INTERVAL_US {
                push(pair[0].time_us, pair[1].time_us, &pair[0], &pair[1]);
            }
        }
        if let Some(last) = self.samples.last() {
            push(last.time_us, last.time_us.saturating_add(MAX_SAMPLE_INTERVAL_US), last, last);
        }
        // The sample before the frame begins the next interval.
        let kept = self.samples.iter().rposition(|sample| sample.time_us <= to).unwrap_or(0);
        self.samples.drain(..kept);
        let is_covered = match elapsed {
            // A frame that comes again.
            Some(0) => !self.samples.is_empty(),
            Some(elapsed) => covered > 0 && covered + MAX_UNCOVERED_US >= elapsed,
            None => false,
        };
        let group = self.steps.len().div_ceil(MAX_STEPS).max(1);
        let steps = self.steps.chunks(group).map(Step::merged);
        // A frame has the units for this, which are less than half of its budget, unless a flood of samples came.
        let samples = SAMPLE_WORK.saturating_mul(std::mem::take(&mut self.taken));
        budget.spend(samples.saturating_add(KEYFRAMES_WORK + STEP_WORK * steps.len() + filter.prediction_work()));
        if is_covered {
            filter.predict(steps, &telemetry.sensors);
        } else {
            self.uncovered_us = to;
            filter.predict_free(elapsed.map_or(MAX_FREE_S, |elapsed| elapsed as f64 / 1e6).min(MAX_FREE_S));
        }
        is_covered
    }

    /// Finds keyframes in a frame, and fits the filter to them. Returns the last that was found, and the one that
    /// decides whether the frame becomes a keyframe: the nearest, or the other if that was not found, or none if the
    /// budget did not pay for it.
    fn find(&mut self, present: &Seen<'_>, budget: &mut Budget) -> Result<(Found, Option<Found>), Reason> {
        let mut usable: [Option<(usize, f64)>; 2] = [None; 2];
        for k in 0..self.keyframes.len() {
            let Some((overlap, scale)) = self.overlap_and_scale(k, &present.camera) else { continue };
            if overlap < USABLE_OVERLAP || scale.abs() > USABLE_SCALE_CHANGE {
                continue;
            }
            let distance = 1.0 - overlap + SCALE_DISTANCE * scale.abs();
            if k == 0 {
                usable[0] = Some((k, distance));
            } else if usable[1].is_none_or(|(_, least)| distance < least) {
                usable[1] = Some((k, distance));
            }
        }
        if self.commanded.is_none() && usable[0].is_some_and(|(_, distance)| distance < MAX_FIRST_DISTANCE) {
            usable[1] = None;
        }
        self.inliers.clear();
        let Some((nearest, _)) = usable[1].or(usable[0]) else {
            // Zoom or flight have gone too far between two frames with a keyframe.
            self.keep_coasted(None, present, budget);
            return Err(Reason::OutOfView);
        };
        // Where the budget pays for one of them only, they take turns.
        self.is_reversed = !self.is_reversed;
        if self.is_reversed {
            usable.reverse();
        }
        let patches = MAX_REFINED / usable.iter().flatten().count().max(1);
        let mut found: Option<Found> = None;
        let mut compared: Option<Found> = None;
        let (mut is_skipped, mut is_excluded) = (false, false);
        for (k, _) in usable.into_iter().flatten() {
            if found.is_some() && budget.left() < self.keyframes[k].work + self.keyframes[k].work / SPARE_SHARE {
                is_skipped |= k == nearest;
                continue;
            }
            let before = budget.spent();
            let tracked = if found.is_none() {
                self.track(k, patches, present, budget)
            } else {
                // The estimate stands without it.
                budget.optional(|rest| self.track(k, patches, present, rest))
            };
            is_excluded |= matches!(tracked, Err(Reason::Implausible(_)));
            if let Ok(mut tracked) = tracked {
                if let Some(other) = found {
                    tracked.inconsistency = tracked.inconsistency.min(other.inconsistency);
                }
                found = Some(tracked);
                compared = if k == nearest { found } else { compared };
                self.keyframes[k].work = budget.spent() - before;
            }
        }
        match found {
            Some(found) => Ok((found, if is_skipped { None } else { compared.or(Some(found)) })),
            None => {
                let acquired = self.acquire(nearest, present, budget);
                let is_unlike = !is_excluded && acquired.as_ref().is_err_and(shows_another_picture);
                if is_unlike && !self.filter.is_free() && !self.keyframes[nearest].is_confirmed {
                    self.keep_coasted(Some(nearest), present, budget);
                }
                acquired.map(|found| (found, Some(found)))
            }
        }
    }

    /// Returns the work units that the fit to keyframe `k` needs, and that what comes before it leaves.
    fn kept_for_fit(&self, k: usize) -> usize {
        let learning = LEARNED_WORK * self.keyframes[k].features.len();
        learning + self.filter.work(RESERVED_SIGHTINGS, self.filter.expected_cells(), false)
    }

    /// Matches keyframe `k` where it is predicted, refines some patches, and fits the filter.
    fn track(&mut self, k: usize, patches: usize, present: &Seen<'_>, budget: &mut Budget) -> Result<Found, Reason> {
        mark(Part::Matching);
        let mut matching = budget.split(self.kept_for_fit(k));
        let filter = &self.filter;
        let keyframe = &self.keyframes[k];
        let memory = &mut self.memory;
        let matched = match_predicted(filter, k, keyframe, &present.camera, present.features, memory, &mut matching);
        budget.absorb(matching);
        let matched = matched.ok_or(Reason::Sightings(0))?;
        self.refine(k, patches, present, budget);
        mark(Part::Pose);
        self.fit(k, present, matched, budget)
    }

    /// Refines sightings of keyframe `k` on the frames, at most `patches` and as many as the fit leaves units for.
    fn refine(&mut self, k: usize, patches: usize, present: &Seen<'_>, budget: &mut Budget) {
        let views = self.views(k, &present.camera);
        let homography = views.and_then(|views| self.homography(k, &views));
        let Some((pixels, homography)) = present.pixels.zip(homography) else {
            self.keyframes[k].takes_turns = false;
            return;
        };
        mark(Part::Refinement);
        let paid = budget.left().saturating_sub(self.kept_for_fit(k) as u64) / REFINED_WORK as u64;
        let most = paid.min(patches as u64) as usize;
        let tried = self.keyframes[k].refine(&mut self.memory.sightings, pixels, &homography, most);
        budget.spend(REFINED_WORK * tried);
    }

    /// Fits the filter to the sightings of keyframe `k`.
    fn fit(&mut self, k: usize, present: &Seen<'_>, min_inliers: usize, budget: &mut Budget) -> Result<Found, Reason> {
        let filter = &mut self.filter;
        let keyframe = &mut self.keyframes[k];
        let sightings = &mut self.memory.sightings;
        if sightings.len() < min_inliers {
            return Err(Reason::Sightings(sightings.len()));
        }
        if !budget.spend(LEARNED_WORK * keyframe.features.len()) {
            return Err(Reason::Work);
        }
        let by_patches = filter.fits_patches(sightings);
        let count = sightings.len();
        let (most, max_cells) = filter.thinning(count, budget.left(), by_patches);
        let mut chosen = evenly(most, count);
        sightings.retain(|_| chosen.next().unwrap_or(false));
        if sightings.len() < min_inliers {
            return Err(Reason::Work);
        }
        let fitted =
            filter.update_sightings(k, [&keyframe.camera, &present.camera], sightings, min_inliers, max_cells, budget);
        let fitted = fitted
            .ok_or_else(|| if budget.is_exhausted() { Reason::Work } else { Reason::Singular(sightings.len()) })?;
        if !fitted.is_applied {
            let few = fitted.inliers < min_inliers;
            return Err(if few { Reason::Sightings(fitted.inliers) } else { Reason::Implausible(fitted.innovation) });
        }
        let consistent = sightings.iter().filter(|sighting| sighting.is_consistent()).count();
        let tried = self.memory.tried * sightings.len() / count.max(1);
        let share = consistent as f64 / tried.max(1) as f64;
        keyframe.learn(sightings, share, &self.memory.predicted);
        let age = keyframe.age_s(present.telemetry.time_us);
        keyframe.is_confirmed |= confirms(age, share);
        self.inliers.clear();
        let inliers = sightings.iter().filter(|sighting| sighting.is_inlier());
        self.inliers.extend(inliers.map(|found| Pair { reference: found.reference, current: found.current }));
        let inconsistency = keyframe.inconsistency;
        Ok(Found { keyframe: k, inliers: fitted.inliers, matches: sightings.len(), share, inconsistency })
    }

    /// Searches keyframe `k` by RANSAC, and fits the filter to the consensus.
    fn acquire(&mut self, k: usize, present: &Seen<'_>, budget: &mut Budget) -> Result<Found, Reason> {
        let filter = &self.filter;
        let keyframe = &self.keyframes[k];
        let views = self.views(k, &present.camera).ok_or(Reason::OutOfView)?;
        mark(Part::Search);
        let pairs = ACQUIRED_WORK * keyframe.features.len().min(present.features.len());
        let learning = LEARNED_WORK * keyframe.features.len();
        let pixels = present.pixels.filter(|_| filter.is_free() && filter.is_calibrated());
        let of_patches = |count: usize| REFINED_WORK * count + filter.work(count, count, true);
        let fit = match pixels {
            Some(_) => of_patches(RESERVED_PATCHES),
            None => filter.work(RESERVED_FOUND, filter.expected_cells(), false),
        };
        let mut search = budget.split(pairs + learning + fit);
        let (workspace, known) = (&mut self.workspace, &keyframe.features);
        // Without a gate: it takes more work than it saves, and waves agree with a prediction (decision 058).
        let motion = Estimator::default().estimate_in(workspace, &mut search, known, present.features);
        budget.absorb(search);
        mark(Part::Pose);
        let motion = motion?;
        if !budget.spend(ACQUIRED_WORK * motion.inliers.len()) {
            return Err(Reason::Work);
        }
        self.inliers.clear();
        self.inliers.extend(motion.inliers.iter().map(|&i| motion.pairs[i]));
        let readings = present.telemetry;
        let current = View::new(present.camera, readings.attitude, readings.range)?;
        let observation = |view| Observation { view, errors: readings.sensors.into() };
        sensor_pattern::check(&self.inliers, &observation(views[0]), &observation(current))?;
        self.memory.predicted.clear();
        self.memory.tried = keyframe.features.len();
        self.memory.sightings.clear();
        // Patches alone: the errors of features persist.
        if let Some(pixels) = pixels {
            // The map of the search is near enough for its matches only.
            budget.spend(MAPPED_WORK * self.inliers.len());
            let homography = mapped(&mut self.inliers).unwrap_or(motion.homography);
            let left = budget.left().saturating_sub(learning as u64);
            let is_paid = |count: &usize| of_patches(*count) as u64 <= left;
            let most = (MIN_REFINED..=MAX_PATCHES).rev().find(is_paid).unwrap_or(0);
            mark(Part::Refinement);
            budget.spend(REFINED_WORK * keyframe.refine_all(motion, &homography, pixels, most, &mut self.memory));
            mark(Part::Pose);
        }
        let MatchMemory { sightings, tried, .. } = &mut self.memory;
        if sightings.len() < MIN_REFINED {
            sightings.clear();
            let left = budget.left().saturating_sub(learning as u64);
            let count = motion.inliers.len();
            let (most, _) = filter.thinning(count, left, false);
            *tried = (*tried * most).div_ceil(count.max(1));
            let found = motion.inliers.iter().zip(evenly(most, count)).filter(|(_, is_chosen)| *is_chosen);
            sightings
                .extend(found.map(|(&i, _)| keyframe.sighting(motion.matches[i].reference, motion.pairs[i].current)));
        } else {
            // The share of the consensus, less the patches that disagree.
            *tried = (*tried * sightings.len()).div_ceil(motion.inliers.len());
        }
        let min_inliers = MIN_INLIERS.max(sightings.len() / 3);
        self.fit(k, present, min_inliers, budget)
    }

    /// Returns the predicted views of keyframe `k` and of the present frame; `None` if either is above the horizon or
    /// below the ground.
    fn views(&self, k: usize, camera: &Camera) -> Option<[View; 2]> {
        let filter = &self.filter;
        let (then, now) = (filter.keyframe(k)?, filter.exposed());
        let view =
            |camera, rotation: &Matrix3<f64>, z: f64| View::at_height(camera, Attitude::of_rotation(rotation), -z).ok();
        Some([
            view(self.keyframes[k].camera, &then.rotation, then.position.z)?,
            view(*camera, &now.rotation, now.position.z)?,
        ])
    }

    /// Returns the predicted homography from keyframe `k` to the present frame over level ground, between their views.
    fn homography(&self, k: usize, views: &[View; 2]) -> Option<Matrix3<f64>> {
        let (moved, _) = self.filter.displacement(k)?;
        Some(ground_homography(&views[0], &views[1], moved.xy()))
    }

    /// Returns the predicted overlap with keyframe `k`, as a fraction, and the logarithm of the change of scale.
    fn overlap_and_scale(&self, k: usize, camera: &Camera) -> Option<(f64, f64)> {
        let views = self.views(k, camera)?;
        let homography = self.homography(k, &views)?;
        let scale = |view: &View| view.camera().focal() / view.height();
        Some((overlap(&homography, camera), libm::log(scale(&views[1]) / scale(&views[0]))))
    }

    /// Corrects the height if the laser ranges since the capture contradict the first.
    fn correct_height(&mut self) {
        let heights = &mut self.first_heights;
        let filter = &mut self.filter;
        if heights.len() < MIN_FIRST_HEIGHTS {
            return;
        }
        heights.sort_unstable_by(f64::total_cmp);
        let median = heights[heights.len() / 2];
        let present = -filter.pose.position.z;
        if (median - present).abs() > HEIGHT_DEVIATION_M.max(HEIGHT_DEVIATION * present.abs()) {
            filter.scale_height(median);
        }
    }

    /// Returns the displacement (m) with its covariance (m^2) and the standard error along the worse direction (m), all
    /// of the filter and of readings that contradict it.
    ///
    /// # Errors
    /// The standard error is larger than that of an estimate may be.
    fn place(&self, telemetry: &Telemetry) -> Result<(Vector3<f64>, Matrix2<f64>, f64), Reason> {
        let (moved, covariance) = self.filter.displacement(0).ok_or(Reason::Reference)?;
        let of_readings = self.contradiction.error(moved.xy().norm(), -self.filter.pose.position.z);
        let covariance = covariance + Matrix3::identity() * (of_readings * of_readings);
        let [xx, xy, yy] = [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]];
        let largest = (xx + yy) / 2.0 + ((xx - yy) * (xx - yy) / 4.0 + xy * xy).sqrt();
        let sigma = largest.sqrt();
        let heading = telemetry.sensors.heading;
        if sigma.is_nan() || sigma > MAX_STANDARD_ERROR_M.max(MAX_RELATIVE_ERROR.hypot(heading) * moved.xy().norm()) {
            return Err(Reason::Uncertain(sigma));
        }
        Ok((moved, Matrix2::new(xx, xy, xy, yy), sigma))
    }

    /// Returns the estimate of the filter.
    fn result(&self, present: &Seen<'_>, found: Found) -> Result<Estimate, Reason> {
        let (moved, covariance, sigma) = self.place(present.telemetry)?;
        let filter = &self.filter;
        let inconsistency = filter.inconsistency().max(found.inconsistency);
        let margin = if filter.is_by_patches() { PATCH_MARGIN } else { 1.0 };
        let normal = PROTECTION_SIGMAS * sigma * inconsistency.of_bound * margin;
        let protection = (normal + PROTECTION_SCALE * moved.xy().norm()).max(MIN_PROTECTION_LEVEL_M);
        // As if all of the information counted: what the errors of random flights are on the mean (decision 059).
        let share = if filter.is_free() { 1.0 } else { INFORMATION_SHARE };
        let factor = inconsistency.of_mean.min(MAX_RAISE).powi(2) * share;
        let covariance = covariance * factor;
        let attitude = Attitude::of_rotation(&filter.exposed().rotation);
        Ok(Estimate {
            x_e_m: moved.x,
            y_e_m: moved.y,
            z_e_m: moved.z,
            yaw_rad: attitude.yaw,
            covariance_m2: [covariance.m11, covariance.m12, covariance.m21, covariance.m22],
            velocity: self.is_velocity_known(present.telemetry).then(|| velocity(filter, factor)),
            protection_level_m: protection,
            quality: (255.0 / (1.0 + protection / HALF_QUALITY_M)).max(1.0) as u8,
            inliers: found.inliers,
            matches: found.matches,
            keyframe: self.keyframes[found.keyframe].frame,
            attitude,
            sensors: present.telemetry.sensors,
        })
    }

    /// Returns `true` if samples of the IMU have been complete for long enough that pictures have shown the velocity.
    fn is_velocity_known(&self, telemetry: &Telemetry) -> bool {
        telemetry.time_us.saturating_sub(self.uncovered_us) >= VELOCITY_US
    }

    /// Makes the frame a keyframe if the one it was matched with is far, or if `renew` asks for it.
    fn renew(&mut self, present: &Seen<'_>, found: Found, renew: &mut bool, budget: &mut Budget) {
        let Some((overlap, scale)) = self.overlap_and_scale(found.keyframe, &present.camera) else { return };
        let is_far = overlap < MIN_OVERLAP || scale.abs() > MAX_SCALE_CHANGE;
        let possible = overlap * self.keyframes[found.keyframe].best_share;
        if (is_far || *renew) && found.share >= MIN_INLIER_SHARE * possible {
            let is_confirmed = self.keyframes[found.keyframe].is_confirmed;
            let slot = self.add_keyframe(present, budget);
            self.keyframes[slot].is_confirmed = is_confirmed;
            self.commanded = renew.then_some(slot).or(self.commanded);
            *renew = false;
        }
    }

    /// Makes a frame in which no keyframe was found one itself if the filter still knows where it was taken. It fills
    /// the slot of keyframe `replaced`, or a new one.
    fn keep_coasted(&mut self, replaced: Option<usize>, present: &Seen<'_>, budget: &mut Budget) {
        if self.confirmed && self.place(present.telemetry).is_ok() {
            self.inconsistency = self.inconsistency.max(self.filter.inconsistency());
            let slot = replaced.unwrap_or_else(|| self.free_slot());
            self.fill_keyframe(slot, present, budget);
        }
    }

    /// Adds a keyframe and returns its index.
    fn add_keyframe(&mut self, present: &Seen<'_>, budget: &mut Budget) -> usize {
        let slot = self.free_slot();
        self.fill_keyframe(slot, present, budget);
        slot
    }

    /// Returns the index of a free slot, or of the oldest keyframe except the first.
    fn free_slot(&mut self) -> usize {
        match self.spare.pop() {
            Some(keyframe) => {
                self.keyframes.push(keyframe);
                self.keyframes.len() - 1
            }
            None => {
                let rest = self.keyframes.iter().enumerate().skip(1);
                rest.min_by_key(|(_, keyframe)| keyframe.age).map_or(1, |(slot, _)| slot)
            }
        }
    }

    /// Makes a frame the keyframe of this index.
    fn fill_keyframe(&mut self, slot: usize, present: &Seen<'_>, budget: &mut Budget) {
        self.commanded = self.commanded.filter(|commanded| *commanded != slot);
        self.captured += 1;
        let work = self.keyframes.iter().map(|keyframe| keyframe.work).max().unwrap_or_default();
        let keyframe = &mut self.keyframes[slot];
        keyframe.fill(present.frame, present.telemetry.time_us, present.camera, present.features, self.captured);
        (keyframe.work, keyframe.inconsistency) = (work, self.inconsistency.limited(MAX_RAISE));
        if let Some(pixels) = present.pixels {
            mark(Part::Refinement);
            // Templates that the rest does not pay for are not cut.
            let are_alone = self.filter.is_free() && self.filter.is_calibrated();
            budget.optional(|rest| keyframe.cut_templates(pixels, are_alone, &mut self.memory.strongest, rest));
        }
        self.filter.fit_grid(picture_width(&present.camera, -self.filter.pose.position.z));
        self.filter.clone_pose(slot);
    }
}

/// Returns `true` if a frame does not show what a keyframe shows, for a reason that says so: neither the work allowed
/// nor a motion that the prediction excludes.
fn shows_another_picture(reason: &Reason) -> bool {
    use RansacError::{AgreementByChance, Degenerate, TooFewMatches};
    let unlike = |error: &RansacError| matches!(error, AgreementByChance { .. } | Degenerate(_) | TooFewMatches { .. });
    match reason {
        Reason::Sightings(_) => true,
        Reason::Motion(error) => unlike(error),
        _ => false,
    }
}

/// Returns the homography from pixels of the keyframe to pixels of the current view, for a camera that has moved by
/// `displacement` (m) over level ground.
fn ground_homography(reference: &View, current: &View, displacement: Vector2<f64>) -> Matrix3<f64> {
    current.from_ground() * Matrix3::new_translation(&-displacement) * reference.to_ground()
}

/// Returns the velocity of a filter, whose covariance has `factor` times that of the filter.
fn velocity(filter: &Filter, factor: f64) -> Velocity {
    let (velocity, covariance) = filter.velocity();
    let row_by_row = std::array::from_fn(|i| covariance[(i / 3, i % 3)] * factor);
    Velocity { velocity_m_s: velocity.into(), velocity_covariance_m2_s2: row_by_row }
}

/// Returns `true` if a sample differs from the one before by more than a helicopter does in that time.
fn jumps(before: &InertialSample, sample: &InertialSample) -> bool {
    let [rate, force] = MAX_JUMPS;
    let differ = |a: &[f64; 3], b: &[f64; 3], most: f64| a.iter().zip(b).any(|(a, b)| (a - b).abs() > most);
    differ(&before.rates, &sample.rates, rate) || differ(&before.force, &sample.force, force)
}

/// Returns the homography that fits pairs best, and keeps those that are near it; `None` if they determine none.
fn mapped(pairs: &mut Vec<Pair>) -> Option<Matrix3<f64>> {
    let first = Model::Homography.fit(pairs).ok()?;
    let error = |pair: &Pair| transfer(&first, pair.reference).map_or(f64::INFINITY, |at| (pair.current - at).norm());
    pairs.retain(|pair| error(pair) <= MAX_MAPPED_PX);
    Model::Homography.fit(pairs).ok()
}

/// Returns the ground that a picture spans across its columns from a height (m), m.
fn picture_width(camera: &Camera, height: f64) -> f64 {
    camera.last_pixel().x / camera.focal() * height
}

/// Returns the fraction of a picture that `homography` maps into another of the same size.
fn overlap(homography: &Matrix3<f64>, camera: &Camera) -> f64 {
    let last = camera.last_pixel();
    let place = |i: u32, n: u32, side: f64| side * (f64::from(i) + 0.5) / f64::from(n);
    let inside = |p: Vector2<f64>| (0.0..=last.x).contains(&p.x) && (0.0..=last.y).contains(&p.y);
    let points = (0..OVERLAP_GRID.1).flat_map(|y| (0..OVERLAP_GRID.0).map(move |x| (x, y)));
    let seen = points.filter(|&(x, y)| {
        let point = Vector2::new(place(x, OVERLAP_GRID.0, last.x), place(y, OVERLAP_GRID.1, last.y));
        transfer(homography, point).is_some_and(inside)
    });
    seen.count() as f64 / f64::from(OVERLAP_GRID.0 * OVERLAP_GRID.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::features::feature::Descriptor;
    use hoverlock_reference::motion::observation::SensorErrors;

    const SENSORS: SensorErrors = SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 };
    const READINGS: Telemetry = Telemetry {
        frame: 0,
        time_us: 0,
        attitude: Attitude { roll: 0.0, pitch: 0.0, yaw: 0.0 },
        range: 50.0,
        field_of_view: 0.87,
        sensors: SENSORS,
    };

    fn features() -> Vec<Feature> {
        let feature = Feature {
            x: 0,
            y: 0,
            scale: 0,
            bright: true,
            response: 0.0,
            neighbours: [0.0; 4],
            descriptor: Descriptor::of_two([0, 0], [0, 0]),
        };
        vec![feature; MIN_FEATURES]
    }

    fn seen(features: &[Feature], field_of_view: f64) -> Seen<'_> {
        let camera = Camera::with_field_of_view(1024, 768, field_of_view).unwrap();
        Seen { frame: Some(0), telemetry: &READINGS, camera, features, pixels: None }
    }

    #[test]
    fn a_keyframe_of_a_zoom_has_new_cells() {
        let features = features();
        let mut tracker = Tracker::with_capacity(features.len());
        let mut budget = Budget::UNLIMITED;
        tracker.capture(&seen(&features, 0.87), &mut budget).unwrap();
        tracker.filter.update_range(50.0, SENSORS.range);
        let known = tracker.filter.prediction_work();
        tracker.add_keyframe(&seen(&features, 0.8), &mut budget);
        assert_eq!(tracker.filter.prediction_work(), known);
        tracker.add_keyframe(&seen(&features, 0.6), &mut budget);
        assert!(tracker.filter.prediction_work() < known);
    }

    /// The error of a keyframe's pose stays after what caused it has passed.
    #[test]
    fn a_keyframe_remembers_the_inconsistency_it_was_made_with() {
        let features = features();
        let present = seen(&features, 0.87);
        let mut tracker = Tracker::with_capacity(features.len());
        let mut budget = Budget::UNLIMITED;
        tracker.capture(&present, &mut budget).unwrap();
        assert_eq!(tracker.keyframes[0].inconsistency, Inconsistency::NONE);
        tracker.filter.predict_free(0.01);
        let of = |of_bound: f64, of_mean: f64| Inconsistency { of_bound, of_mean };
        let level = |tracker: &Tracker, inconsistency: Inconsistency| {
            let found = Found { keyframe: 0, inliers: 0, matches: 0, share: 1.0, inconsistency };
            let estimate = tracker.result(&present, found).unwrap();
            [estimate.protection_level_m, estimate.covariance_m2[0].sqrt()]
        };
        for (inconsistency, remembered) in [(of(4.0, 3.0), of(4.0, 3.0)), (of(40.0, 4.0), of(MAX_RAISE, 4.0))] {
            tracker.inconsistency = inconsistency;
            let slot = tracker.add_keyframe(&present, &mut budget);
            assert_eq!(tracker.keyframes[slot].inconsistency, remembered);
            let [one, other] = [of(1.0, 1.0), remembered].map(|inconsistency| level(&tracker, inconsistency));
            assert!((other[0] / one[0] - remembered.of_bound).abs() < 1e-9);
            assert!((other[1] / one[1] - remembered.of_mean).abs() < 1e-9);
        }
        let [limit, beyond] = [MAX_RAISE, 3.0 * MAX_RAISE].map(|factor| level(&tracker, of(factor, factor)));
        assert!((beyond[0] / limit[0] - 3.0).abs() < 1e-9 && beyond[1] == limit[1]);
    }

    /// Returns a sample of a hover with a force upwards, m/s^2.
    fn sample(time_us: u64, force: f64) -> InertialSample {
        InertialSample { time_us, rates: [0.0; 3], force: [0.0, 0.0, -force] }
    }

    #[test]
    fn one_sample_that_jumps_is_left_out_and_two_are_kept() {
        let mut tracker = Tracker::with_capacity(MIN_FEATURES);
        let forces = [9.8, 9.8, 200.0, 9.8, 9.8, 70.0, 71.0, 9.8, 200.0, -200.0, 9.8];
        for (i, force) in forces.into_iter().enumerate() {
            tracker.take_sample(sample(5_000 * i as u64, force));
        }
        // The last but one confirms nothing, and neither does the last.
        tracker.take_sample(sample(60_000, 9.9));
        let kept: Vec<f64> = tracker.samples.iter().map(|sample| -sample.force[2]).collect();
        assert_eq!(kept, [9.8, 9.8, 9.8, 9.8, 70.0, 71.0, 9.8, 9.9]);
    }

    /// A stamp from another clock, an hour ahead, costs the samples up to the next frame.
    #[test]
    fn a_sample_from_another_clock_is_forgotten() {
        let mut tracker = Tracker::with_capacity(MIN_FEATURES);
        let mut budget = Budget::UNLIMITED;
        let mut is_covered = |tracker: &mut Tracker, time_us: u64| {
            (1..=5).for_each(|i| tracker.take_sample(sample(time_us - 50_000 + 10_000 * i, 9.8)));
            tracker.predict(&Telemetry { time_us, ..READINGS }, &mut budget)
        };
        let times = [1_000_000, 1_050_000, 1_100_000];
        assert_eq!(times.map(|time_us| is_covered(&mut tracker, time_us)), [false, true, true]);
        tracker.take_sample(sample(3_600_000_000, 9.8));
        let times = [1_150_000, 1_200_000, 1_250_000];
        assert_eq!(times.map(|time_us| is_covered(&mut tracker, time_us)), [true, true, true]);
    }

    /// However short the time between frames is, without an IMU the camera may have moved.
    #[test]
    fn without_samples_no_frame_is_covered() {
        let mut tracker = Tracker::with_capacity(MIN_FEATURES);
        let mut budget = Budget::UNLIMITED;
        for time_us in [1_000_000, 1_009_000, 1_009_000] {
            assert!(!tracker.predict(&Telemetry { time_us, ..READINGS }, &mut budget), "{time_us} us");
        }
    }

    #[test]
    fn as_many_as_are_paid_for_are_chosen_evenly() {
        for (most, count) in [(0, 4), (1, 1), (3, 9), (2, 3), (5, 7), (7, 7), (128, 300)] {
            let chosen: Vec<_> =
                evenly(most, count).enumerate().filter_map(|(i, is_chosen)| is_chosen.then_some(i)).collect();
            assert_eq!(chosen.len(), most, "{most} of {count}");
            // One of each `most`-th part.
            assert!(chosen.iter().enumerate().all(|(part, index)| index * most / count == part), "{chosen:?}");
        }
    }

    #[test]
    fn the_overlap_is_that_of_the_rectangles() {
        let camera = Camera::with_field_of_view(1024, 768, 0.87).unwrap();
        let moved = |x: f64, y: f64| Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0);
        assert_eq!(overlap(&moved(0.0, 0.0), &camera), 1.0);
        // A quarter of the columns and a half of the rows are lost.
        assert_eq!(overlap(&moved(256.0, -384.0), &camera), 0.375);
        assert_eq!(overlap(&moved(1100.0, 0.0), &camera), 0.0);
    }
}
