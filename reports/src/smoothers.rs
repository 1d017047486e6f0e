//! The smoothers in floating point side by side: the Gaussian, the first-order recursion of the hardware, and the
//! smoother that the design names. They answer whether first order is enough on the pictures of a report.
//!
//! Features of two smoothers are compared at thresholds of the same rank, because their responses differ in amplitude.

use hoverlock_design::{DesignPoint, SmootherKind};
use hoverlock_fixed_point::analysis::acceptance::{Reference, dog_lsb, response};
use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_fixed_point::analysis::displacement::Motions;
use hoverlock_fixed_point::analysis::errors::{BitKind, ErrorStatistics, Flips, Kept};
use hoverlock_fixed_point::analysis::levels::{Level, LevelPlanes, Levels};
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_fixed_point::model::design::recursive;
use hoverlock_pictures::conditions::CONDITIONS;
use hoverlock_reference::image::plane::Plane;
use rayon::prelude::*;
use serde::Serialize;

use crate::repeatability::{Curve, Sample, Stability, Warp};
use crate::study::Subject;

/// Largest rotation and tilt of the warps that are averaged, degrees.
const MAX_ANGLE_DEG: f64 = 5.0;
/// Largest change of scale of the warps that are averaged.
const MAX_SCALE_CHANGE: f64 = 0.05;

/// A smoother on the pictures of a report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmootherRow {
    /// The Gaussian, or a name as in a design file.
    pub name: String,
    /// Poles of each side; `None` for the Gaussian.
    pub order: Option<usize>,
    /// Difference from the Gaussian; `None` for the Gaussian.
    pub approximation: Option<Approximation>,
    /// Rms of the DoG error by rounded coefficients alone, LSB of `kt27`, on the worst picture, condition and scale.
    pub rounding_rms_lsb: Option<f64>,
    /// Number of known motions found over all pictures.
    pub motions_found: usize,
    /// Median distance of the estimates from the known motions, px; `None` without one.
    pub motion_median_px: Option<f64>,
    /// Largest distance of the estimates from the known motions, px; `None` without one.
    pub motion_max_px: Option<f64>,
    /// Mean share of repeated points over the warps of the first picture within 5 degrees and 5 % of scale, percent.
    pub repeated_percent: Option<f64>,
    /// Mean share of correct matches of those by MaxLBP with signs, percent.
    pub matched_percent: Option<f64>,
}

/// The difference of a smoother from the Gaussian, all in floating point: the worst picture and condition of each
/// measure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Approximation {
    /// Rms of the difference of the responses, LSB of `kt27`, on the worst scale.
    pub dog_rms_lsb: f64,
    /// Features at the same pixel, percent, on the worst scale.
    pub same_pixel_percent: f64,
    /// Features within one pixel, percent, on the worst scale.
    pub within_one_px_percent: f64,
    /// MaxLBP bits that differ, percent.
    pub maxlbp_flips_percent: f64,
    /// Sign bits that differ, percent.
    pub sign_flips_percent: f64,
}

impl Approximation {
    /// The value that any measured one is worse than.
    const BEST: Self = Self {
        dog_rms_lsb: 0.0,
        same_pixel_percent: 100.0,
        within_one_px_percent: 100.0,
        maxlbp_flips_percent: 0.0,
        sign_flips_percent: 0.0,
    };

    fn worse(self, other: Self) -> Self {
        Self {
            dog_rms_lsb: self.dog_rms_lsb.max(other.dog_rms_lsb),
            same_pixel_percent: self.same_pixel_percent.min(other.same_pixel_percent),
            within_one_px_percent: self.within_one_px_percent.min(other.within_one_px_percent),
            maxlbp_flips_percent: self.maxlbp_flips_percent.max(other.maxlbp_flips_percent),
            sign_flips_percent: self.sign_flips_percent.max(other.sign_flips_percent),
        }
    }
}

/// Measures the smoothers. `motions` are the known motions of each subject, `curves` the stability under warps. Returns
/// nothing for a first-order design: there is no other smoother to compare with.
///
/// # Errors
/// A smoother cannot be designed.
pub(crate) fn rows(
    design: &DesignPoint,
    subjects: &[Subject],
    motions: &[Motions],
    curves: &[Curve],
) -> Result<Vec<SmootherRow>, CoefficientError> {
    if design.smoother == SmootherKind::FirstOrder {
        return Ok(Vec::new());
    }
    let bounds = Bounds::acceptance();
    let (first_order, other) = (Levels::new(&design.of_hardware())?, Levels::new(design)?);
    let frames: Vec<Plane<u16>> = subjects
        .iter()
        .flat_map(|subject| CONDITIONS.map(|condition| condition.apply(&subject.frame, bounds.seeds.of(&condition))))
        .collect();
    let approximation = |levels: &Levels| {
        let of_frames = frames.par_iter().filter_map(|frame| compare(levels, frame, bounds));
        of_frames.reduce_with(Approximation::worse)
    };
    let rounding = |levels: &Levels| {
        let of_frames = frames.par_iter().filter_map(|frame| {
            dog_rms(&levels.planes(levels.unrounded(), frame), &levels.planes(Level::Quantised, frame), bounds)
        });
        of_frames.reduce_with(f64::max)
    };
    let row = |name: String, levels: &Levels, level: Level, stability: fn(&Sample) -> Option<Stability>| {
        let estimates: Vec<_> =
            motions.iter().flat_map(|motions| motions.estimates(levels, level, bounds)).flatten().collect();
        let mut errors: Vec<f64> = estimates.iter().map(|found| found.error_px).collect();
        errors.sort_unstable_by(f64::total_cmp);
        SmootherRow {
            name,
            order: None,
            approximation: None,
            rounding_rms_lsb: None,
            motions_found: errors.len(),
            motion_median_px: errors.get(errors.len() / 2).copied(),
            motion_max_px: errors.last().copied(),
            repeated_percent: mean(curves, |sample| Some(stability(sample)?.repeatability)),
            matched_percent: mean(curves, |sample| Some(stability(sample)?.signs)),
        }
    };
    let recursive_row = |levels: &Levels, stability| -> Result<SmootherRow, CoefficientError> {
        let order = recursive(levels.design(), design.sigmas[0])?.family().order();
        Ok(SmootherRow {
            order: Some(order),
            approximation: approximation(levels),
            rounding_rms_lsb: rounding(levels),
            ..row(levels.design().smoother.to_string(), levels, Level::Recursive, stability)
        })
    };
    Ok(vec![
        row("Gaussian".into(), &other, Level::Ideal, |sample| Some(sample.ideal)),
        recursive_row(&first_order, |sample| Some(sample.recursive))?,
        recursive_row(&other, |sample| sample.other)?,
    ])
}

/// Compares `recursive` with `ideal` on a frame; `None` where the frame is unfit to judge a smoother.
fn compare(levels: &Levels, frame: &Plane<u16>, bounds: &Bounds) -> Option<Approximation> {
    let (ideal, test) = (levels.planes(Level::Ideal, frame), levels.planes(Level::Recursive, frame));
    let (wanted, found) = (Reference::of(ideal.clone(), bounds), Reference::of(test.clone(), bounds));
    let kept: Vec<Kept> =
        (0..ideal.rings.len()).map(|k| Kept::between(wanted.features(), found.features(), k as u8)).collect();
    if kept.iter().any(|kept| kept.reference < bounds.features.minimum) {
        return None;
    }
    let flips = Flips::between(&ideal.layers(), &test.layers(), wanted.features(), dog_lsb());
    let worst = kept.iter().fold(Approximation::BEST, |worst, kept| {
        worst.worse(Approximation {
            same_pixel_percent: kept.same_pixel_percent,
            within_one_px_percent: kept.within_one_px_percent,
            ..Approximation::BEST
        })
    });
    Some(Approximation {
        dog_rms_lsb: dog_rms(&ideal, &test, bounds)?,
        maxlbp_flips_percent: flips.percent(BitKind::Maxlbp),
        sign_flips_percent: flips.percent(BitKind::Sign),
        ..worst
    })
}

/// Returns the rms of the difference of the responses on the worst scale, LSB; `None` without an interior.
fn dog_rms(reference: &LevelPlanes, test: &LevelPlanes, bounds: &Bounds) -> Option<f64> {
    let of_scale = |k: usize| {
        let (reference, test) = (response(reference, k), response(test, k));
        Some(ErrorStatistics::between(&reference, &test, dog_lsb(), bounds.interior)?.rms)
    };
    (0..reference.rings.len()).try_fold(0.0f64, |worst, k| Some(worst.max(of_scale(k)?)))
}

/// Returns the mean of a share over the warps of a hover, percent; `None` if no warp has points.
fn mean(curves: &[Curve], share: impl Fn(&Sample) -> Option<f64>) -> Option<f64> {
    let is_of_hover = |warp: Warp, value: f64| match warp {
        Warp::Rotation | Warp::Tilt => value <= MAX_ANGLE_DEG,
        Warp::Scale => (value - 1.0).abs() <= MAX_SCALE_CHANGE + 1e-9,
    };
    let samples = curves.iter().flat_map(|curve| curve.samples.iter().filter(|of| is_of_hover(curve.warp, of.value)));
    let shares: Vec<f64> = samples.filter_map(share).collect();
    (!shares.is_empty()).then(|| 100.0 * shares.iter().sum::<f64>() / shares.len() as f64)
}
