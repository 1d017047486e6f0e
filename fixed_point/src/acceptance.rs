//! Rung 4 against rung 2 on one frame: everything that a bound speaks of, and the judgement.
//!
//! Errors are those of the signed response `sign_k * DOG_k` in LSB of the design point's DoG, `FS / 2^17`, also where another
//! configuration has a coarser step: a narrowed format is judged by the measure of the full one. `T_k` is the response of a
//! given rank at rung 2, rounded to an LSB, the same for both rungs.

use hoverlock_reference::dog::Dog;
use hoverlock_reference::extractor;
use hoverlock_reference::feature::Feature;
use hoverlock_reference::maxlbp::Layer;
use hoverlock_reference::plane::Plane;
use serde::Serialize;

use crate::bounds::{Bounds, Class, Judgement, Sense};
use crate::design::{KT27, SCALES};
use crate::ladder::{Ladder, Rung, RungPlanes};
use crate::measure::{BitKind, ErrorStatistics, Flips, Kept, Region, threshold_of_rank};

/// One scale pair of one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScaleComparison {
    /// The column that the contrast of this scale puts it in.
    pub class: Option<Class>,
    /// `T_k`, LSB.
    pub threshold_lsb: f64,
    /// Error of the response on the interior.
    pub interior: ErrorStatistics,
    /// Error of the response on the whole frame.
    pub whole_frame: ErrorStatistics,
    /// What became of the features.
    pub kept: Kept,
    /// MaxLBP bits of this scale that flipped, percent.
    pub maxlbp_flips_percent: f64,
    /// Sign bits of this scale that flipped, percent.
    pub sign_flips_percent: f64,
}

/// Two rungs on one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Both scale pairs.
    pub scales: [ScaleComparison; SCALES],
    /// Descriptor bits at the reference's features.
    pub flips: Flips,
}

/// One LSB of the design point's DoG, codes of the camera word.
pub fn dog_lsb() -> f64 {
    KT27.dog().lsb()
}

/// `sign_k * DOG_k`, codes.
pub fn response(planes: &RungPlanes, scale: usize) -> Plane<f64> {
    planes.dog[scale].zip_map(&planes.signed_dog[scale], |magnitude, d| magnitude.copysign(*d))
}

/// DoG, sign and MaxDOG of both scales, for features and descriptors.
pub fn layers(planes: &RungPlanes) -> [Layer<f64>; SCALES] {
    [0, 1].map(|k| Layer {
        dog: Dog { magnitude: planes.dog[k].clone(), positive: planes.signed_dog[k].map(|d| *d >= 0.0) },
        max_dog: planes.max_dog[k].clone(),
    })
}

/// `T_k` of both scales for the planes of rung 2, codes.
pub fn thresholds(reference: &[Layer<f64>; SCALES], bounds: &Bounds) -> [f64; SCALES] {
    let lsb = dog_lsb();
    let all = extractor::features(reference, [lsb; SCALES], 1.0);
    [0, 1].map(|scale| threshold_of_rank(&all, scale, bounds.features.rank, lsb))
}

/// The features of both rungs above the common `T_k`.
#[derive(Debug, Clone, PartialEq)]
pub struct FeaturePair {
    /// Of rung 2.
    pub reference: Vec<Feature>,
    /// Of the rung under test.
    pub test: Vec<Feature>,
}

impl Comparison {
    /// Rung 4 against rung 2 on a frame; nothing where the frame is too small to have an interior.
    pub fn of_frame(ladder: &Ladder, frame: &Plane<u16>, bounds: &Bounds) -> Option<Self> {
        let (reference, test) = (ladder.planes(Rung::Streaming, frame), ladder.planes(Rung::Fixed, frame));
        Self::between(&reference, &test, bounds).map(|(comparison, _)| comparison)
    }

    /// Compares planes that exist already, and hands out the features it compared.
    pub fn between(reference: &RungPlanes, test: &RungPlanes, bounds: &Bounds) -> Option<(Self, FeaturePair)> {
        let lsb = dog_lsb();
        let (before, after) = (layers(reference), layers(test));
        let thresholds = thresholds(&before, bounds);
        let reference_features = extractor::features(&before, thresholds.map(|t| t - lsb / 2.0), 1.0);
        let test_features = extractor::features(&after, thresholds, 1.0);
        let flips = Flips::between(&before, &after, &reference_features, lsb);
        let scale = |k: usize| {
            let (wanted, measured) = (response(reference, k), response(test, k));
            let interior = ErrorStatistics::between(&wanted, &measured, lsb, bounds.interior)?;
            Some(ScaleComparison {
                class: bounds.class(interior.reference_rms),
                threshold_lsb: thresholds[k] / lsb,
                interior,
                whole_frame: ErrorStatistics::between(&wanted, &measured, lsb, Region::WHOLE)?,
                kept: Kept::between(&reference_features, &test_features, k as u8),
                maxlbp_flips_percent: flips.percent(BitKind::Maxlbp, k),
                sign_flips_percent: flips.percent(BitKind::Sign, k),
            })
        };
        let scales = [scale(0)?, scale(1)?];
        Some((Self { scales, flips }, FeaturePair { reference: reference_features, test: test_features }))
    }

    /// Every bound that applies, the worse scale of each.
    pub fn judge(&self, bounds: &Bounds) -> Vec<Judgement> {
        let worse = |judge: &dyn Fn(usize, &ScaleComparison) -> Option<Judgement>| {
            let both = self.scales.iter().enumerate().filter_map(|(k, scale)| judge(k, scale));
            // What is no number counts as the worst of all: `total_cmp` puts it last.
            both.max_by(|a, b| (!a.pass, a.used).partial_cmp(&(!b.pass, b.used)).unwrap_or(std::cmp::Ordering::Greater))
        };
        let spot = |k: usize, error: &ErrorStatistics| format!("scale {k} at {}, {}", error.max_at.0, error.max_at.1);
        let at_scale = |k: usize| format!("scale {k}");
        let column = |scale: &ScaleComparison| scale.class.map(|class| bounds.column(class));
        let at_most = |name, unit, limit, measured, place| {
            Some(Judgement::new(name, unit, Sense::AtMost, limit, measured, place))
        };
        [
            worse(&|k, scale| {
                let error = &scale.interior;
                at_most("DoG error, maximum", "LSB", bounds.dog.max_lsb, error.max.abs(), spot(k, error))
            }),
            worse(&|k, scale| at_most("DoG error, rms", "LSB", bounds.dog.rms_lsb, scale.interior.rms, at_scale(k))),
            worse(&|k, scale| {
                let (error, limit) = (&scale.whole_frame, bounds.dog.whole_frame_max_lsb);
                at_most("DoG error, maximum, whole frame", "LSB", limit, error.max.abs(), spot(k, error))
            }),
            worse(&|k, scale| {
                let limit = column(scale)?.sqnr_db;
                let measured = scale.interior.sqnr_db;
                Some(Judgement::new("DoG SQNR", "dB", Sense::AtLeastDecibel, limit, measured, at_scale(k)))
            }),
            worse(&|k, scale| {
                let limit = column(scale)?.maxlbp_flips_percent;
                at_most("MaxLBP bits flipped", "%", limit, scale.maxlbp_flips_percent, at_scale(k))
            }),
            worse(&|k, scale| {
                let limit = column(scale)?.sign_flips_percent;
                at_most("sign bits flipped", "%", limit, scale.sign_flips_percent, at_scale(k))
            }),
            worse(&|k, scale| {
                let (limit, measured) = (column(scale)?.same_pixel_percent, scale.kept.same_pixel_percent);
                let sense = Sense::AtLeastPercent;
                Some(Judgement::new("features at the same pixel", "%", sense, limit, measured, at_scale(k)))
            }),
            worse(&|k, scale| {
                let (limit, measured) = (column(scale)?.within_one_px_percent, scale.kept.within_one_px_percent);
                let sense = Sense::AtLeastPercent;
                Some(Judgement::new("features within 1 px", "%", sense, limit, measured, at_scale(k)))
            }),
            worse(&|k, scale| {
                let (limit, measured) = (bounds.features.minimum as f64, scale.kept.reference as f64);
                Some(Judgement::new("features at rung 2", "", Sense::AtLeast, limit, measured, at_scale(k)))
            }),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}
