//! One design on one part of the measurement: a picture under a condition, or the known motions of a picture.
//!
//! A part is small enough to stop after it, and its result is worth keeping: it is named by the content of everything
//! it depends on, so that a later search takes it from a file.

use std::collections::HashMap;

use hoverlock_fixed_point::analysis::acceptance::Reference;
use hoverlock_fixed_point::analysis::bounds::{Bounds, Check};
use hoverlock_fixed_point::analysis::displacement::{self, Motions};
use hoverlock_fixed_point::analysis::levels::{Level, Levels};
use hoverlock_fixed_point::model::design::DesignPoint;
use hoverlock_pictures::conditions::{CONDITIONS, NOMINAL};
use hoverlock_reference::image::plane::Plane;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::study::{MOTIONS, Subject};

/// A check with its outcome, as it is kept in a file: numbers that are not finite are missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checked {
    /// Name of the bound.
    pub check: String,
    /// Its unit.
    pub unit: String,
    /// The measurement.
    pub measured: Option<f64>,
    /// The limit.
    pub limit: Option<f64>,
    /// Picture, condition, scale or smoother.
    pub place: String,
    /// Part of the allowance that is used, at most [`Checked::MOST`]; above 1 the check fails.
    pub used: f64,
    /// The check passes.
    pub pass: bool,
}

impl Checked {
    /// What stands for an infinite part of the allowance.
    pub const MOST: f64 = 1e6;

    /// A check on a picture.
    pub fn of(check: &Check, place: Option<&str>) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        // NaN is no measurement, so it fails by as much as can be.
        let used = if check.used.is_nan() { Self::MOST } else { check.used.min(Self::MOST) };
        Self {
            check: check.name.into(),
            unit: check.unit.into(),
            measured: finite(check.measured),
            limit: finite(check.limit),
            place: place.map_or_else(|| check.location.clone(), |place| format!("{place}, {}", check.location)),
            used,
            pass: check.pass,
        }
    }

    /// A design that has no model.
    pub fn impossible(what: &str, reason: String) -> Self {
        Self {
            check: what.into(),
            unit: String::new(),
            measured: None,
            limit: None,
            place: reason,
            used: Self::MOST,
            pass: false,
        }
    }
}

/// What a design is measured on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A picture under a condition: indices into the subjects and [`CONDITIONS`].
    Frame(usize, usize),
    /// The known motions of a picture.
    Motion(usize),
}

/// What came of a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The check that uses most of its allowance.
    pub worst: Checked,
    /// The first check that fails, in the order of the report.
    pub failure: Option<Checked>,
    /// Root mean square of the DoG error of the worse scale, LSB of the design point `kt27`; missing for motions.
    pub dog_rms_lsb: Option<f64>,
}

impl Outcome {
    fn of(checks: &[Check], place: &str, dog_rms_lsb: Option<f64>) -> Self {
        let checks: Vec<Checked> = checks.iter().map(|check| Checked::of(check, Some(place))).collect();
        let failure = checks.iter().find(|check| !check.pass).cloned();
        let worst = checks
            .into_iter()
            .max_by(|a, b| (!a.pass, a.used).partial_cmp(&(!b.pass, b.used)).unwrap_or(std::cmp::Ordering::Equal));
        let nothing = || Checked::impossible("checks", format!("{place}: nothing was measured"));
        let worst = worst.unwrap_or_else(nothing);
        Self { failure: if worst.pass { failure } else { failure.or(Some(worst.clone())) }, worst, dog_rms_lsb }
    }
}

/// The pictures, and what `streaming` gives on them. Designs with the same look-ahead share it.
pub struct Bench<'a> {
    subjects: &'a [Subject],
    hashes: Vec<String>,
    build: String,
    /// The look-ahead and part of the last reference, and the frame.
    last: Option<(Vec<u32>, Part, Plane<u16>, Reference)>,
    motions: HashMap<(Vec<u32>, usize), Motions>,
}

impl<'a> Bench<'a> {
    /// The pictures of a search. `build` names the program: results of another one are not taken over.
    pub fn new(subjects: &'a [Subject], build: &str) -> Self {
        let hashes = subjects.iter().map(|subject| hoverlock_pictures::sha256(&subject.frame)).collect();
        Self { subjects, hashes, build: build.into(), last: None, motions: HashMap::new() }
    }

    /// SHA-256 of what is measured of each picture.
    pub fn hashes(&self) -> &[String] {
        &self.hashes
    }

    /// All parts: frames first, motions last, because motions cost most.
    pub fn parts(&self) -> Vec<Part> {
        let pictures = 0..self.subjects.len();
        let frames = pictures.clone().flat_map(|picture| (0..CONDITIONS.len()).map(move |c| Part::Frame(picture, c)));
        frames.chain(pictures.map(Part::Motion)).collect()
    }

    /// The name of a result: a hash of the design, the picture, the condition, the bounds and the program.
    pub fn key(&self, design: &DesignPoint, part: Part) -> String {
        let (picture, what) = match part {
            Part::Frame(picture, condition) => (picture, CONDITIONS[condition].name),
            Part::Motion(picture) => (picture, "motions"),
        };
        let mut digest = Sha256::new();
        for text in [&self.build, Bounds::FILE, &design.to_toml(), &self.hashes[picture], what] {
            digest.update(text.as_bytes());
            digest.update([0]);
        }
        digest.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
    }

    /// The name of a part, for progress.
    pub fn name(&self, part: Part) -> String {
        match part {
            Part::Frame(picture, condition) => {
                format!("{}, {}", self.subjects[picture].name, CONDITIONS[condition].name)
            }
            Part::Motion(picture) => format!("{}, {}", self.subjects[picture].name, NOMINAL.name),
        }
    }

    /// Computes `streaming` for a part, unless it is there.
    pub fn prepare(&mut self, levels: &Levels, part: Part) {
        let look_ahead = levels.design().look_ahead.to_vec();
        let bounds = Bounds::acceptance();
        match part {
            Part::Frame(picture, condition) => {
                if self.last.as_ref().is_some_and(|last| (&last.0, last.1) == (&look_ahead, part)) {
                    return;
                }
                let condition = CONDITIONS[condition];
                let frame = condition.apply(&self.subjects[picture].frame, bounds.seeds.of(&condition));
                let reference = Reference::of(&levels.planes(Level::Streaming, &frame), bounds);
                self.last = Some((look_ahead, part, frame, reference));
            }
            Part::Motion(picture) => {
                let frame = &self.subjects[picture].frame;
                self.motions
                    .entry((look_ahead, picture))
                    .or_insert_with(|| Motions::new(levels, frame, &NOMINAL, bounds, MOTIONS));
            }
        }
    }

    /// Measures a design on a part that was prepared for its look-ahead.
    pub fn measure(&self, levels: &Levels, part: Part) -> Outcome {
        let (bounds, place) = (Bounds::acceptance(), self.name(part));
        match part {
            Part::Frame(..) => {
                let compared = self.last.as_ref().and_then(|(_, _, frame, reference)| {
                    reference.compare(&levels.planes(Level::BitTrue, frame), bounds)
                });
                let checks = compared.as_ref().map(|compared| compared.check(bounds)).unwrap_or_default();
                let rms = compared.map(|compared| compared.scales.iter().map(|s| s.interior.rms).fold(0.0, f64::max));
                Outcome::of(&checks, &place, rms)
            }
            Part::Motion(picture) => {
                let motions = self.motions.get(&(levels.design().look_ahead.to_vec(), picture));
                let displacements = motions.map(|motions| motions.displacements(levels)).unwrap_or_default();
                Outcome::of(&displacement::check(&displacements, bounds), &place, None)
            }
        }
    }
}
