//! `measured <= limit`, or `>=`: the acceptance bounds of the levels, read from one file, and the check on a measurement.
//!
//! Rounding noise is nearly constant in LSB, whatever the picture, so all measures relative to the signal fall with the
//! picture's own contrast. Hence the column of limits is chosen by the contrast that is there, the rms of the `streaming` DoG,
//! and not by the name of the condition that the picture was taken under.

use std::sync::LazyLock;

use hoverlock_reference::image::conditions::{COMBINED, Condition, FOG};
use serde::{Deserialize, Serialize};

use crate::analysis::errors::Region;

/// The content of `bounds.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Where errors are checked.
    pub interior: Region,
    /// How features are chosen for comparison.
    pub features: FeatureRule,
    /// Where each column begins.
    pub class: Classes,
    /// Limits of the DoG error that hold for any picture.
    pub dog: DogLimits,
    /// Relative limits at good contrast.
    pub nominal: Column,
    /// Relative limits at middling contrast.
    pub combined: Column,
    /// Relative limits at poor contrast.
    pub fog: Column,
    /// Limits of the displacement, end to end.
    pub displacement: DisplacementLimits,
    /// Limits that concern the coefficients alone.
    pub coefficients: CoefficientLimits,
    /// Seeds of the degradations and of the motion.
    pub seeds: Seeds,
}

/// Which features are compared: those above `T`, the response of a rank.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureRule {
    /// `T` is the response of this rank at `streaming`, per picture and scale.
    pub rank: usize,
    /// Fewer features than this fail.
    pub minimum: usize,
}

/// Where each column begins, for two kinds of measures.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Classes {
    /// For SQNR and bit flips, which average over ten thousands of samples or bits.
    pub signal: ClassLimits,
    /// For the places of features, of which there are some hundred, most of them the weakest that are let in.
    pub features: ClassLimits,
}

/// Least rms of the `streaming` DoG of each column, LSB.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ClassLimits {
    /// From here on the nominal column holds.
    pub nominal: f64,
    /// From here on the combined column holds.
    pub combined: f64,
    /// From here on the fog column holds; below it only absolute limits do.
    pub fog: f64,
}

/// Limits of the DoG error, LSB.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DogLimits {
    /// Greatest error on the interior.
    pub max_lsb: f64,
    /// Root mean square of the error on the interior.
    pub rms_lsb: f64,
    /// Greatest error anywhere in the frame.
    pub whole_frame_max_lsb: f64,
}

/// Limits that depend on the contrast.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Least ratio of DoG signal to quantisation error on the interior, dB.
    pub sqnr_db: f64,
    /// Most MaxLBP bits flipped at `streaming` features, percent.
    pub maxlbp_flips_percent: f64,
    /// Most sign bits flipped at `streaming` features, percent.
    pub sign_flips_percent: f64,
    /// Least share of features at the same pixel, the smaller of recall and precision, percent.
    pub same_pixel_percent: f64,
    /// Least share of features within one pixel, likewise, percent.
    pub within_one_px_percent: f64,
}

/// Limits of the displacement error, px.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DisplacementLimits {
    /// Median over the motions.
    pub median_px: f64,
    /// Greatest of the motions.
    pub max_px: f64,
}

/// Limits of what rounding and truncation do to the filters themselves.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CoefficientLimits {
    /// Greatest relative change of the effective sigma.
    pub sigma_eff_relative: f64,
    /// Greatest deviation of a constant picture's output from the constant, LSB.
    pub constant_lsb: f64,
}

/// Seeds, so that every measurement can be had again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Seeds {
    /// Of the nominal condition.
    pub nominal: u64,
    /// Of the combined condition.
    pub combined: u64,
    /// Of fog.
    pub fog: u64,
    /// Of the known motions and of the current frame's noise.
    pub motion: u64,
}

impl Seeds {
    /// The seed of one of the three conditions; that of any other is the nominal one's.
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
    /// The column for a `streaming` DoG of this rms in LSB; none where only the absolute limits hold.
    pub fn class(&self, dog_rms_lsb: f64) -> Option<Class> {
        [(self.nominal, Class::Nominal), (self.combined, Class::Combined), (self.fog, Class::Fog)]
            .into_iter()
            .find(|(least, _)| dog_rms_lsb >= *least)
            .map(|(_, class)| class)
    }
}

/// A column of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Good contrast.
    Nominal,
    /// Middling contrast.
    Combined,
    /// Poor contrast.
    Fog,
}

static ACCEPTANCE: LazyLock<Bounds> =
    LazyLock::new(|| toml::from_str(Bounds::FILE).expect("bounds.toml is part of this crate"));

impl Bounds {
    /// The text of `bounds.toml`.
    pub const FILE: &'static str = include_str!("../../bounds.toml");

    /// Every picture, condition and seed that the limits of the columns were read off, as CSV; made by the example `calibrate`.
    pub const CALIBRATION: &'static str = include_str!("../../calibration.csv");

    /// The acceptance bounds of the project.
    pub fn acceptance() -> &'static Self {
        &ACCEPTANCE
    }

    /// The limits of a column.
    pub fn column(&self, class: Class) -> &Column {
        match class {
            Class::Nominal => &self.nominal,
            Class::Combined => &self.combined,
            Class::Fog => &self.fog,
        }
    }
}

/// On which side of its limit a measurement must lie, and so how near to it it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sense {
    /// `measured <= limit`.
    AtMost,
    /// `measured >= limit`, a count.
    AtLeast,
    /// `measured >= limit`, percent: what is missing from 100 counts.
    AtLeastPercent,
    /// `measured >= limit`, decibels.
    AtLeastDecibel,
}

/// A measurement beside its limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What was measured.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// On which side of the limit it must lie.
    pub sense: Sense,
    /// The limit.
    pub limit: f64,
    /// The measurement.
    pub measured: f64,
    /// Where it was found.
    pub place: String,
    /// Part of the allowance that is used up: at most 1 where the bound holds, and comparable between bounds.
    pub used: f64,
    /// Whether the bound holds; what is no number never does.
    pub pass: bool,
}

impl Check {
    /// Holds `measured` against `limit`.
    pub fn new(
        name: &'static str,
        unit: &'static str,
        sense: Sense,
        limit: f64,
        measured: f64,
        place: impl Into<String>,
    ) -> Self {
        let (pass, used) = match sense {
            Sense::AtMost => (measured <= limit, measured / limit),
            Sense::AtLeast => (measured >= limit, limit / measured),
            Sense::AtLeastPercent => (measured >= limit, (100.0 - measured) / (100.0 - limit)),
            Sense::AtLeastDecibel => (measured >= limit, 10f64.powf((limit - measured) / 20.0)),
        };
        // 0 of 0 allowed is nothing used.
        let used = if pass && used.is_nan() { 0.0 } else { used };
        Self { name, unit, sense, limit, measured, place: place.into(), used, pass }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_read_whole_and_its_columns_grow_laxer() {
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
        assert!(toml::from_str::<Bounds>(&misspelt).is_err(), "a misspelt bound must not be passed over");
    }

    #[test]
    fn contrast_chooses_the_column() {
        let limits = ClassLimits { nominal: 400.0, combined: 200.0, fog: 80.0 };
        assert_eq!(limits.class(400.0), Some(Class::Nominal));
        assert_eq!(limits.class(399.9), Some(Class::Combined));
        assert_eq!(limits.class(80.0), Some(Class::Fog));
        assert_eq!(limits.class(79.9), None);
        assert_eq!(limits.class(f64::NAN), None);
    }

    #[test]
    fn checks_fall_on_the_right_side() {
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
