//! Compares `bit_true` with `streaming` on one frame and checks the acceptance bounds.
//!
//! Errors are those of the signed response `sign_k * DOG_k`, in LSB of the DoG at the design point, `FS / 2^17`. A
//! design with a coarser DoG is measured in the same LSB. The threshold `T_k` is the response of a given rank in
//! `streaming`, rounded to a step, and is the same for both levels. The step is an LSB of the design's DoG, or of the
//! default design's if that is coarser: [`threshold_step`]. The integer that is `T` represents responses from half a
//! step below it on, so `streaming` is thresholded there. Otherwise the two levels would have different features
//! because of the threshold alone.

use std::borrow::Cow;

use hoverlock_reference::features::dog::Dog;
use hoverlock_reference::features::extractor;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::features::maxima::maxima;
use hoverlock_reference::features::maxlbp::Layer;
use hoverlock_reference::image::plane::Plane;
use serde::Serialize;

use crate::analysis::bounds::{Bounds, Check, Class, Sense};
use crate::analysis::errors::{BitKind, ErrorStatistics, Flips, Kept, Region, response_of_rank, round_threshold};
use crate::analysis::levels::{Level, LevelPlanes, Levels};
use hoverlock_design::{DesignPoint, KT27};

const SQNR: &str = "DoG SQNR";
const MAXLBP_FLIPS: &str = "MaxLBP bits flipped";
const SIGN_FLIPS: &str = "sign bits flipped";
const SAME_PIXEL: &str = "features at the same pixel";
const WITHIN_ONE_PX: &str = "features within 1 px";

/// One scale pair of one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScaleComparison {
    /// Contrast class for the SQNR; `None` where the contrast is below all classes.
    pub signal_class: Option<Class>,
    /// Contrast class for the feature positions.
    pub features_class: Option<Class>,
    /// Common threshold `T_k` of both levels, LSB.
    pub threshold_lsb: f64,
    /// Error of the response on the interior.
    pub interior: ErrorStatistics,
    /// Error of the response on the whole frame.
    pub whole_frame: ErrorStatistics,
    /// Features kept, moved, lost and new.
    pub kept: Kept,
}

/// `bit_true` against `streaming` on one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// All scale pairs.
    pub scales: Vec<ScaleComparison>,
    /// Flipped descriptor bits at the features of `streaming`.
    pub flips: Flips,
}

/// Returns the LSB of the DoG at the default design, DN. All errors are measured in it.
pub fn dog_lsb() -> f64 {
    KT27.dog().lsb()
}

/// Returns the step that the thresholds of a design are rounded to, DN: the coarser LSB of its DoG and the default one.
pub fn threshold_step(design: &DesignPoint) -> f64 {
    design.dog().lsb().max(dog_lsb())
}

/// Returns why no picture with features can pass the bound of the DoG error, which is in the LSB of the default design
/// for every design: the DoG is so coarse that its rounding alone, `q / sqrt(12)`, is beyond it. `None` if it is not.
pub fn rounding_beyond_bound(design: &DesignPoint, bounds: &Bounds) -> Option<String> {
    let (rounding, limit) = (design.dog().lsb() / dog_lsb() / 12f64.sqrt(), bounds.dog.rms_lsb);
    (rounding > limit).then(|| {
        format!(
            "dog_bits = {}: the bound of the DoG error, {limit} LSB rms of {} DN for every design, is below this \
             format's own rounding, {rounding:.1} LSB rms; give dog_bits more bits, or judge it by the other bounds",
            design.dog_bits,
            dog_lsb()
        )
    })
}

/// Returns the signed response of a scale pair, `sign_k * DOG_k`, DN.
pub fn response(planes: &LevelPlanes, scale: usize) -> Plane<f64> {
    planes.dog[scale].zip_map(&planes.signed_dog[scale], |magnitude, d| magnitude.copysign(*d))
}

/// `streaming` on one frame: what every level and every design is compared with.
#[derive(Debug, Clone)]
pub struct Reference {
    layers: Vec<Layer<f64>>,
    responses: Vec<Plane<f64>>,
    /// Response of the rank of each scale pair, DN.
    of_rank: Vec<f64>,
    selected: Selected,
}

/// The thresholds for one step, and the features of `streaming` that they select.
#[derive(Debug, Clone)]
pub struct Selected {
    /// The step of the thresholds, DN.
    step: f64,
    /// `T_k` of all scale pairs, DN.
    pub thresholds: Vec<f64>,
    /// The features of `streaming` from half a step below `T_k` on, in order.
    pub features: Vec<Feature>,
}

impl Selected {
    fn new(layers: &[Layer<f64>], of_rank: &[f64], step: f64) -> Self {
        let thresholds: Vec<_> = of_rank.iter().map(|response| round_threshold(*response, step)).collect();
        let just_below: Vec<_> = thresholds.iter().map(|t| t - step / 2.0).collect();
        Self { step, features: extractor::features(layers, &just_below, 1.0), thresholds }
    }
}

impl Reference {
    /// Determines the responses of the rank, and the features of the default step, from the planes of `streaming`.
    pub fn of(planes: LevelPlanes, bounds: &Bounds) -> Self {
        let (layers, responses) = planes.into_layers();
        let of_rank = |layer: &Layer<f64>| {
            let magnitude = &layer.dog.magnitude;
            let all = maxima(magnitude, dog_lsb()).into_iter().map(|at| magnitude[at]).collect();
            response_of_rank(all, bounds.features.rank)
        };
        let of_rank: Vec<_> = layers.iter().map(of_rank).collect();
        let selected = Selected::new(&layers, &of_rank, dog_lsb());
        Self { layers, responses, of_rank, selected }
    }

    /// Returns the features of `streaming` for thresholds in the LSB of the default design, in order.
    pub fn features(&self) -> &[Feature] {
        &self.selected.features
    }

    /// Returns thresholds and features for a design: see [`threshold_step`].
    pub fn selected(&self, design: &DesignPoint) -> Cow<'_, Selected> {
        let step = threshold_step(design);
        if step == self.selected.step {
            Cow::Borrowed(&self.selected)
        } else {
            Cow::Owned(Selected::new(&self.layers, &self.of_rank, step))
        }
    }

    /// Compares the planes of another level with the thresholds of a design; `None` where the frame is too small to
    /// have an interior.
    pub fn compare(&self, test: &LevelPlanes, design: &DesignPoint, bounds: &Bounds) -> Option<Comparison> {
        let (layers, selected) = (test.layers(), self.selected(design));
        let features = extractor::features(&layers, &selected.thresholds, 1.0);
        self.compare_layers(&layers, &features, &selected, |k| response(test, k), bounds)
    }

    /// Compares `bit_true` of a design on the same frame: what [`Reference::compare`] returns for its planes, computed
    /// from the integers, of which only the responses are converted to DN.
    pub fn compare_bit_true(&self, levels: &Levels, frame: &Plane<u16>, bounds: &Bounds) -> Option<Comparison> {
        let selected = self.selected(levels.design());
        let (planes, features) = levels.bit_true_frame(frame, &selected.thresholds);
        let lsb = levels.design().dog().lsb();
        let response = |k: usize| {
            let Dog { magnitude, positive } = &planes.layers[k].dog;
            magnitude.zip_map(positive, |raw, positive| {
                let dn = f64::from(*raw) * lsb;
                if *positive { dn } else { -dn }
            })
        };
        self.compare_layers(&planes.layers, &features, &selected, response, bounds)
    }

    /// Compares another level by its layers in any unit, its features, and its responses, DN.
    fn compare_layers<T: Copy + PartialOrd>(
        &self,
        layers: &[Layer<T>],
        features: &[Feature],
        selected: &Selected,
        response: impl Fn(usize) -> Plane<f64>,
        bounds: &Bounds,
    ) -> Option<Comparison> {
        let lsb = dog_lsb();
        let flips = Flips::between(&self.layers, layers, &selected.features, lsb);
        let scale = |k: usize| {
            let (wanted, measured) = (&self.responses[k], &response(k));
            let interior = ErrorStatistics::between(wanted, measured, lsb, bounds.interior)?;
            Some(ScaleComparison {
                signal_class: bounds.class.signal.class(interior.reference_rms),
                features_class: bounds.class.features.class(interior.reference_rms),
                threshold_lsb: selected.thresholds[k] / lsb,
                interior,
                whole_frame: ErrorStatistics::between(wanted, measured, lsb, Region::WHOLE)?,
                kept: Kept::between(&selected.features, features, k as u8),
            })
        };
        Some(Comparison { scales: (0..self.layers.len()).map(scale).collect::<Option<_>>()?, flips })
    }
}

impl Comparison {
    /// Compares `bit_true` with `streaming` on a frame; `None` where the frame is too small to have an interior.
    pub fn of_frame(levels: &Levels, frame: &Plane<u16>, bounds: &Bounds) -> Option<Self> {
        Reference::of(levels.planes(Level::Streaming, frame), bounds).compare_bit_true(levels, frame, bounds)
    }

    /// Returns the rms of the `streaming` DoG of the scale with the lowest contrast, LSB. Flips are counted over all
    /// scales, so it selects their class.
    pub fn lowest_rms_lsb(&self) -> f64 {
        self.scales.iter().map(|scale| scale.interior.reference_rms).fold(f64::INFINITY, f64::min)
    }

    /// Returns the scales over which flips are counted, in words.
    fn scales_name(&self) -> &'static str {
        match self.scales.len() {
            1 => "scale 0",
            2 => "both scales",
            _ => "all scales",
        }
    }

    /// Returns why no design can be judged by this frame: `streaming` itself has too few features. `None` if it has
    /// enough of them in every scale pair.
    pub fn unfit(&self, bounds: &Bounds) -> Option<String> {
        let minimum = bounds.features.minimum;
        let poor = self.scales.iter().enumerate().find(|(_, scale)| scale.kept.reference < minimum);
        poor.map(|(k, scale)| {
            format!("streaming has {} features at scale {k}, and a verdict needs {minimum}", scale.kept.reference)
        })
    }

    /// Returns the names of the checks that are left out on a scale pair at least, because its contrast is below every
    /// class.
    pub fn below_every_class(&self) -> Vec<&'static str> {
        let mut left_out = Vec::new();
        if self.scales.iter().any(|scale| scale.signal_class.is_none()) {
            left_out.extend([SQNR, MAXLBP_FLIPS, SIGN_FLIPS]);
        }
        if self.scales.iter().any(|scale| scale.features_class.is_none()) {
            left_out.extend([SAME_PIXEL, WITHIN_ONE_PX]);
        }
        left_out
    }

    /// Checks every bound that applies. Each check is that of the worst scale pair.
    pub fn check(&self, bounds: &Bounds) -> Vec<Check> {
        let worse = |check: &dyn Fn(usize, &ScaleComparison) -> Option<Check>| {
            let all = self.scales.iter().enumerate().filter_map(|(k, scale)| check(k, scale));
            // NaN counts as the worst.
            all.max_by(|a, b| (!a.pass, a.used).partial_cmp(&(!b.pass, b.used)).unwrap_or(std::cmp::Ordering::Greater))
        };
        let position =
            |k: usize, error: &ErrorStatistics| format!("scale {k} at {}, {}", error.max_at.0, error.max_at.1);
        let at_scale = |k: usize| format!("scale {k}");
        let column = |class: Option<Class>| class.map(|class| bounds.column(class));
        let bits = column(bounds.class.signal.class(self.lowest_rms_lsb()));
        let at_most = |name, unit, limit, measured, location| {
            Some(Check::new(name, unit, Sense::AtMost, limit, measured, location))
        };
        [
            worse(&|k, scale| {
                let error = &scale.interior;
                at_most("DoG error, maximum", "LSB", bounds.dog.max_lsb, error.max.abs(), position(k, error))
            }),
            worse(&|k, scale| at_most("DoG error, rms", "LSB", bounds.dog.rms_lsb, scale.interior.rms, at_scale(k))),
            worse(&|k, scale| {
                let (error, limit) = (&scale.whole_frame, bounds.dog.whole_frame_max_lsb);
                at_most("DoG error, maximum, whole frame", "LSB", limit, error.max.abs(), position(k, error))
            }),
            worse(&|k, scale| {
                let limit = column(scale.signal_class)?.sqnr_db;
                let measured = scale.interior.sqnr_db;
                Some(Check::new(SQNR, "dB", Sense::AtLeastDecibel, limit, measured, at_scale(k)))
            }),
            bits.and_then(|column| {
                let measured = self.flips.percent(BitKind::Maxlbp);
                at_most(MAXLBP_FLIPS, "%", column.maxlbp_flips_percent, measured, self.scales_name().into())
            }),
            bits.and_then(|column| {
                let measured = self.flips.percent(BitKind::Sign);
                at_most(SIGN_FLIPS, "%", column.sign_flips_percent, measured, self.scales_name().into())
            }),
            worse(&|k, scale| {
                let (limit, measured) =
                    (column(scale.features_class)?.same_pixel_percent, scale.kept.same_pixel_percent);
                let sense = Sense::AtLeastPercent;
                Some(Check::new(SAME_PIXEL, "%", sense, limit, measured, at_scale(k)))
            }),
            worse(&|k, scale| {
                let (limit, measured) =
                    (column(scale.features_class)?.within_one_px_percent, scale.kept.within_one_px_percent);
                let sense = Sense::AtLeastPercent;
                Some(Check::new(WITHIN_ONE_PX, "%", sense, limit, measured, at_scale(k)))
            }),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// Effective sigma of one smoother in one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SigmaEff {
    /// The `sigma` it was designed for, px.
    pub sigma: f64,
    /// True for the horizontal direction, false for the vertical.
    pub along_rows: bool,
    /// `sqrt(2 a) / (1 - a)`: unrounded coefficients, infinite impulse response, px.
    pub unquantised: f64,
    /// Rounded coefficients and finite look-ahead, px.
    pub quantised: f64,
}

impl SigmaEff {
    /// Returns the relative change of sigma by rounding and truncation: 0.01 if the filter is 1 % wider.
    pub fn relative(&self) -> f64 {
        self.quantised / self.unquantised - 1.0
    }
}

/// Computes the effective sigma of all smoothers in both directions. The variances of the stages add: the recursion
/// with coefficient `g` has `(1 - g) / g^2`, and a stage with the weights `g_j` and `1 - g_j`, `2^j` samples apart, has
/// `g_j (1 - g_j) 4^j`.
pub fn sigma_eff(levels: &Levels) -> Vec<SigmaEff> {
    let (Some(exact), Some(rounded)) = (levels.coefficients(Level::Streaming), levels.coefficients(Level::BitTrue))
    else {
        return Vec::new();
    };
    let of_smoother = |smoother: usize| {
        let (exact, rounded) = (&exact[smoother], &rounded[smoother]);
        let recursion = |g: f64| (1.0 - g) / (g * g);
        let ahead: f64 = rounded.g_j.iter().enumerate().map(|(j, g)| g * (1.0 - g) * 4f64.powi(j as i32)).sum();
        [false, true].map(|along_rows| SigmaEff {
            sigma: levels.design().sigmas[smoother],
            along_rows,
            unquantised: (2.0 * recursion(exact.g)).sqrt(),
            quantised: (ahead + if along_rows { ahead } else { recursion(rounded.g) }).sqrt(),
        })
    };
    (0..exact.len()).flat_map(of_smoother).collect()
}

/// Checks the filters alone: effective sigma, and the response to constant pictures.
pub fn check_coefficients(levels: &Levels, bounds: &Bounds) -> Vec<Check> {
    let worst = sigma_eff(levels).into_iter().max_by(|a, b| a.relative().abs().total_cmp(&b.relative().abs()));
    let sigma = worst.map(|worst| {
        let direction = if worst.along_rows { "horizontal" } else { "vertical" };
        let location = format!("sigma {}, {direction}", worst.sigma);
        let (limit, measured) = (bounds.coefficients.sigma_eff_relative, worst.relative().abs());
        Check::new("sigma_eff, relative change", "", Sense::AtMost, limit, measured, location)
    });
    // Both ends of the camera sample, its middle, and a value of mixed bits.
    let deviation = |value: u16| {
        let picture = Plane::filled(96, 80, value);
        let planes = levels.planes(Level::BitTrue, &picture);
        // As the camera takes it: its steps are no error of the filters.
        let taken = levels.dn(&picture)[(0, 0)];
        let from = |plane: &Plane<f64>, wanted: f64| {
            plane.as_slice().iter().map(|sample| (sample - wanted).abs()).fold(0.0, f64::max) / dog_lsb()
        };
        let smoothed = planes.smoothed.iter().map(|plane| from(plane, taken));
        let dog = planes.dog.iter().map(|plane| from(plane, 0.0));
        (smoothed.chain(dog).fold(0.0, f64::max), value)
    };
    let worst = [0, 1, 0x8000, 0xa5c3, u16::MAX].map(deviation).into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let constant = worst.map(|(measured, value)| {
        let limit = bounds.coefficients.constant_lsb;
        Check::new(
            "constant picture, largest deviation",
            "LSB",
            Sense::AtMost,
            limit,
            measured,
            format!("constant of {value} DN"),
        )
    });
    sigma.into_iter().chain(constant).collect()
}
