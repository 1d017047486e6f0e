//! The acceptance bounds of `bounds.toml`, and the check `measured <= limit` or `measured >= limit`.
//!
//! Rounding noise is nearly constant in LSB for all pictures. Every measure relative to the signal therefore gets worse
//! as the contrast of the picture falls. The contrast class of a picture, which selects the limits, is determined by
//! the rms of its `streaming` DoG, not by the name of the condition.

use std::sync::LazyLock;

use hoverlock_pictures::conditions::{COMBINED, Condition, FOG};
use serde::{Deserialize, Serialize};

use crate::analysis::errors::Region;

/// The content of `bounds.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// The interior, where errors are checked.
    pub interior: Region,
    /// The features that are compared.
    pub features: FeatureRule,
    /// Least contrast of each class.
    pub class: Classes,
    /// Limits of the DoG error for any contrast.
    pub dog: DogLimits,
    /// Limits of the class nominal: high contrast.
    pub nominal: Column,
    /// Limits of the class combined: medium contrast.
    pub combined: Column,
    /// Limits of the class fog: low contrast.
    pub fog: Column,
    /// Limits of the displacement, end to end.
    pub displacement: DisplacementLimits,
    /// Limits of the filter coefficients.
    pub coefficients: CoefficientLimits,
    /// Seeds of the degradations and of the motion.
    pub seeds: Seeds,
}

/// The features that are compared: those with a response of at least `T`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureRule {
    /// `T` is the response of this rank in `streaming`, for each picture and scale.
    pub rank: usize,
    /// Least number of features of `streaming`; a frame with fewer is unfit to judge a design.
    pub minimum: usize,
}

/// Least contrast of each class, for two kinds of measures.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Classes {
    /// For SQNR and flipped bits, which average over tens of thousands of samples or bits.
    pub signal: ClassLimits,
    /// For feature positions: some hundred features, most of them near the threshold.
    pub features: ClassLimits,
}

/// Least rms of the `streaming` DoG of each class, LSB.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ClassLimits {
    /// Least rms of the class nominal.
    pub nominal: f64,
    /// Least rms of the class combined.
    pub combined: f64,
    /// Least rms of the class fog. Below it only the absolute limits apply.
    pub fog: f64,
}

/// Limits of the DoG error, LSB.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DogLimits {
    /// Largest error on the interior.
    pub max_lsb: f64,
    /// Root mean square of the error on the interior.
    pub rms_lsb: f64,
    /// Largest error in the whole frame.
    pub whole_frame_max_lsb: f64,
}

/// The limits of one contrast class.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Least SQNR of the DoG on the interior, dB.
    pub sqnr_db: f64,
    /// Most MaxLBP bits flipped at the features of `streaming`, percent.
    pub maxlbp_flips_percent: f64,
    /// Most sign bits flipped at the features of `streaming`, percent.
    pub sign_flips_percent: f64,
    /// Least share of features at the same pixel, the smaller of recall and precision, percent.
    pub same_pixel_percent: f64,
    /// Least share of features within one pixel, the smaller of recall and precision, percent.
    pub within_one_px_percent: f64,
}

/// Limits of the displacement error, px.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DisplacementLimits {
    /// Median over the motions.
    pub median_px: f64,
    /// Largest over the motions.
    pub max_px: f64,
}

/// Limits of the effect of rounding and truncation on the filters.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CoefficientLimits {
    /// Largest relative change of the effective sigma.
    pub sigma_eff_relative: f64,
    /// Largest deviation of the output from the constant for a constant picture, LSB.
    pub constant_lsb: f64,
}

/// Seeds of the random numbers, so that every measurement is reproducible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Seeds {
    /// Seed of the nominal condition.
    pub nominal: u64,
    /// Seed of the combined condition.
    pub combined: u64,
    /// Seed of the fog condition.
    pub fog: u64,
    /// Seed of the known motions and of the noise of the second view.
    pub motion: u64,
}

impl Seeds {
    /// Returns the seed of a condition. Conditions other than `combined` and `fog` share that of `nominal`.
    pub fn of(&self, condition: &Condition) -> u64 {
        if *condition == COMBINED {
            self.combined
        } else if *condition == FOG {
            self.fog
        } else {
            self.nominal
        }
    }
}

impl ClassLimits {
    /// Returns the class of a `streaming` DoG with this rms, LSB, or `None` if only the absolute limits apply.
    pub fn class(&self, dog_rms_lsb: f64) -> Option<Class> {
        [(self.nominal, Class::Nominal), (self.combined, Class::Combined), (self.fog, Class::Fog)]
            .into_iter()
            .find(|(least, _)| dog_rms_lsb >= *least)
            .map(|(_, class)| class)
    }
}

/// A contrast class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// High contrast, as in a clear picture.
    Nominal,
    /// Medium contrast, as with several degradations combined.
    Combined,
    /// Low contrast, as in fog.
    Fog,
}

static ACCEPTANCE: LazyLock<Bounds> =
    LazyLock::new(|| toml::from_str(Bounds::FILE).expect("bounds.toml is part of this crate"));

impl Bounds {
    /// The text of `bounds.toml`.
    pub const FILE: &'static str = include_str!("../../bounds.toml");

    /// The measurements from which the limits of the contrast classes were set, as CSV. The example `calibrate` makes
    /// it.
    pub const CALIBRATION: &'static str = include_str!("../../calibration.csv");

    /// Returns the acceptance bounds of the project.
    pub fn acceptance() -> &'static Self {
        &ACCEPTANCE
    }

    /// Returns the limits of a class.
    pub fn column(&self, class: Class) -> &Column {
        match class {
            Class::Nominal => &self.nominal,
            Class::Combined => &self.combined,
            Class::Fog => &self.fog,
        }
    }
}

/// How a measurement is compared with its limit, and how the used part of the allowance is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sense {
    /// `measured <= limit`; used is `measured / limit`.
    AtMost,
    /// `measured >= limit`, a count; used is `limit / measured`.
    AtLeast,
    /// `measured >= limit`, percent; used is `(100 - measured) / (100 - limit)`.
    AtLeastPercent,
    /// `measured >= limit`, dB; used is the ratio of the error amplitudes.
    AtLeastDecibel,
}

/// A measurement and its limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Name of the bound.
    pub name: &'static str,
    /// Unit of limit and measurement; empty for a pure number.
    pub unit: &'static str,
    /// How the measurement is compared with the limit.
    pub sense: Sense,
    /// The limit, in `unit`.
    pub limit: f64,
    /// The measured value, in `unit`.
    pub measured: f64,
    /// Scale, pixel or smoother of the measurement.
    pub location: String,
    /// Part of the allowance that is used: at most 1 where the check passes, comparable between bounds.
    pub used: f64,
    /// The check passes. NaN does not pass.
    pub pass: bool,
}

impl Check {
    /// Compares `measured` with `limit`.
    pub fn new(
        name: &'static str,
        unit: &'static str,
        sense: Sense,
        limit: f64,
        measured: f64,
        location: impl Into<String>,
    ) -> Self {
        let (pass, used) = match sense {
            Sense::AtMost => (measured <= limit, measured / limit),
            Sense::AtLeast => (measured >= limit, limit / measured),
            Sense::AtLeastPercent => (measured >= limit, (100.0 - measured) / (100.0 - limit)),
            Sense::AtLeastDecibel => (measured >= limit, 10f64.powf((limit - measured) / 20.0)),
        };
        // 0 / 0: the limit is 0 and nothing of it is used.
        let used = if pass && used.is_nan() { 0.0 } else { used };
        Self { name, unit, sense, limit, measured, location: location.into(), used, pass }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_looser_at_lower_contrast_and_unknown_keys_are_refused() {
        let bounds = Bounds::acceptance();
        let columns = [&bounds.nominal, &bounds.combined, &bounds.fog];
        for pair in columns.windows(2) {
            assert!(pair[0].sqnr_db > pair[1].sqnr_db);
            assert!(pair[0].maxlbp_flips_percent < pair[1].maxlbp_flips_percent);
            assert!(pair[0].sign_flips_percent < pair[1].sign_flips_percent);
            assert!(pair[0].same_pixel_percent >= pair[1].same_pixel_percent);
            assert!(pair[0].within_one_px_percent > pair[1].within_one_px_percent);
        }
        for class in [bounds.class.signal, bounds.class.features] {
            assert!(class.nominal > class.combined && class.combined > class.fog);
        }
        assert!(bounds.dog.whole_frame_max_lsb >= bounds.dog.max_lsb);
        let misspelt = Bounds::FILE.replace("rms_lsb", "rms_lbs");
        assert!(toml::from_str::<Bounds>(&misspelt).is_err(), "a misspelt bound must be refused");
    }

    #[test]
    fn contrast_selects_the_class() {
        let limits = ClassLimits { nominal: 400.0, combined: 200.0, fog: 80.0 };
        assert_eq!(limits.class(400.0), Some(Class::Nominal));
        assert_eq!(limits.class(399.9), Some(Class::Combined));
        assert_eq!(limits.class(80.0), Some(Class::Fog));
        assert_eq!(limits.class(79.9), None);
        assert_eq!(limits.class(f64::NAN), None);
    }

    #[test]
    fn checks_compare_with_the_limit_and_report_the_allowance_used() {
        let check = |sense, limit, measured| {
            let check = Check::new("n", "u", sense, limit, measured, "");
            (check.pass, check.used)
        };
        assert_eq!(check(Sense::AtMost, 10.0, 5.0), (true, 0.5));
        assert!(!check(Sense::AtMost, 10.0, 10.1).0);
        assert_eq!(check(Sense::AtMost, 0.0, 0.0), (true, 0.0));
        assert_eq!(check(Sense::AtMost, 0.0, 1.0), (false, f64::INFINITY));
        assert!(!check(Sense::AtMost, 10.0, f64::NAN).0);
        assert_eq!(check(Sense::AtLeast, 200.0, 400.0), (true, 0.5));
        assert_eq!(check(Sense::AtLeast, 200.0, 0.0), (false, f64::INFINITY));
        assert_eq!(check(Sense::AtLeastPercent, 95.0, 97.5), (true, 0.5));
        assert!(!check(Sense::AtLeastPercent, 95.0, f64::NAN).0);
        assert_eq!(check(Sense::AtLeastDecibel, 50.0, 70.0), (true, 0.1));
        assert_eq!(check(Sense::AtLeastDecibel, 50.0, f64::INFINITY), (true, 0.0));
    }
}
