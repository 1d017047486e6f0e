//! Measures one design on one part: a picture under one condition, or the known motions of a picture.
//!
//! A part is small enough to stop the search after it. Its result is stored under a hash of everything it depends on,
//! so that a later search can reuse it.

use std::collections::HashMap;

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::analysis::acceptance::{Reference, threshold_step};
use hoverlock_fixed_point::analysis::bounds::{Bounds, Check};
use hoverlock_fixed_point::analysis::displacement::{self, Motions};
use hoverlock_fixed_point::analysis::levels::{Level, Levels};
use hoverlock_pictures::conditions::{CONDITIONS, NOMINAL};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reports::check_outcome::CheckOutcome;
use hoverlock_reports::study::{MOTIONS, Subject, Unfit};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A part of the measurement of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// A picture under a condition: indices into the subjects and [`CONDITIONS`].
    Frame(usize, usize),
    /// The known motions of a picture: its index in the subjects.
    Motion(usize),
}

impl Part {
    /// Returns the index of the picture in the subjects.
    pub(crate) fn picture(self) -> usize {
        match self {
            Self::Frame(picture, _) | Self::Motion(picture) => picture,
        }
    }
}

/// The outcome of the checks of one design on one part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartOutcome {
    /// The check that uses most of its allowance.
    pub worst: CheckOutcome,
    /// The first check that fails, in the order of the report.
    pub failure: Option<CheckOutcome>,
    /// Rms of the DoG error on the worse scale, LSB of the design point `kt27`; `None` for motions.
    pub dog_rms_lsb: Option<f64>,
    /// Why no design can be judged by this part; `None` if it can.
    pub unfit: Option<String>,
}

impl PartOutcome {
    fn new(checks: &[Check], place: &str, dog_rms_lsb: Option<f64>) -> Self {
        let checks: Vec<CheckOutcome> = checks.iter().map(|check| CheckOutcome::new(check, Some(place))).collect();
        let failure = checks.iter().find(|check| !check.pass).cloned();
        let worst = checks
            .into_iter()
            .max_by(|a, b| (!a.pass, a.used).partial_cmp(&(!b.pass, b.used)).unwrap_or(std::cmp::Ordering::Equal));
        let unmeasured = || CheckOutcome::unmeasurable("checks", format!("{place}: nothing was measured"));
        let worst = worst.unwrap_or_else(unmeasured);
        let failure = if worst.pass { failure } else { failure.or(Some(worst.clone())) };
        Self { failure, worst, dog_rms_lsb, unfit: None }
    }

    /// Returns the outcome on a part that no design can be judged by.
    fn unfit(place: &str, reason: String) -> Self {
        let none = CheckOutcome::unmeasurable("unfit to judge a design", format!("{place}: {reason}"));
        Self {
            worst: CheckOutcome { used: 0.0, pass: true, ..none },
            failure: None,
            dog_rms_lsb: None,
            unfit: Some(reason),
        }
    }
}

/// What the planes of `streaming` depend on: look-ahead, and the bits of the camera's pixel.
type Filters = (Vec<u32>, u32);

fn filters(design: &DesignPoint) -> Filters {
    (design.look_ahead.clone(), design.pixel.bits())
}

/// What [`Bench::prepare`] computes depends on: the planes of `streaming`, and for motions the step of the thresholds,
/// DN as bits, because their features are computed once.
pub(crate) type Shared = (Filters, Option<u64>);

/// Returns what designs have in common that are measured on a part against the same `streaming`.
pub(crate) fn shared(design: &DesignPoint, part: Part) -> Shared {
    let step = matches!(part, Part::Motion(_)).then(|| threshold_step(design).to_bits());
    (filters(design), step)
}

/// The pictures and the planes of `streaming` on them, which designs with the same look-ahead and pixel share.
pub(crate) struct Bench<'a> {
    subjects: &'a [Subject],
    hashes: Vec<String>,
    build: String,
    /// Filters and part of the last reference, its frame, and the reference.
    last: Option<(Filters, Part, Plane<u16>, Reference)>,
    /// Motions by what they depend on, and picture.
    motions: HashMap<(Shared, usize), Motions>,
}

impl<'a> Bench<'a> {
    /// Creates a bench for a search. `build` is the version of the program.
    pub(crate) fn new(subjects: &'a [Subject], build: &str) -> Self {
        let hashes = subjects.iter().map(|subject| hoverlock_pictures::sha256(&subject.frame)).collect();
        Self { subjects, hashes, build: build.into(), last: None, motions: HashMap::new() }
    }

    /// Returns the SHA-256 of the frame of each picture.
    pub(crate) fn hashes(&self) -> &[String] {
        &self.hashes
    }

    /// Returns all parts: frames first, motions last because they take the longest.
    pub(crate) fn parts(&self) -> Vec<Part> {
        let pictures = 0..self.subjects.len();
        let frames = pictures.clone().flat_map(|picture| (0..CONDITIONS.len()).map(move |c| Part::Frame(picture, c)));
        frames.chain(pictures.map(Part::Motion)).collect()
    }

    /// Returns the key of a result: a hash of design, picture, condition, bounds and program.
    pub(crate) fn key(&self, design: &DesignPoint, part: Part) -> String {
        let (picture, condition) = match part {
            Part::Frame(picture, condition) => (picture, CONDITIONS[condition].name),
            Part::Motion(picture) => (picture, "motions"),
        };
        let mut digest = Sha256::new();
        for text in [&self.build, Bounds::FILE, &design.to_toml(), &self.hashes[picture], condition] {
            digest.update(text.as_bytes());
            digest.update([0]);
        }
        digest.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
    }

    /// Returns the name of a part: picture and condition.
    pub(crate) fn name(&self, part: Part) -> String {
        match part {
            Part::Frame(picture, condition) => {
                format!("{}, {}", self.subjects[picture].name, CONDITIONS[condition].name)
            }
            Part::Motion(picture) => format!("{}, {}", self.subjects[picture].name, NOMINAL.name),
        }
    }

    /// Returns a part that no design can be judged by, with the reason.
    pub(crate) fn unfit(&self, part: Part, reason: &str) -> Unfit {
        let (picture, condition, reason) = match part {
            Part::Frame(picture, condition) => (picture, Some(CONDITIONS[condition].name), reason.to_owned()),
            Part::Motion(picture) => (picture, None, format!("known motions: {reason}")),
        };
        Unfit { picture: self.subjects[picture].name.clone(), condition, reason }
    }

    /// Computes `streaming` for a part with what `levels` share, unless it is there.
    pub(crate) fn prepare(&mut self, levels: &Levels, part: Part) {
        let bounds = Bounds::acceptance();
        match part {
            Part::Frame(picture, condition) => {
                let filters = filters(levels.design());
                if self.last.as_ref().is_some_and(|last| (&last.0, last.1) == (&filters, part)) {
                    return;
                }
                let condition = CONDITIONS[condition];
                let frame = condition.apply(&self.subjects[picture].frame, bounds.seeds.of(&condition));
                let reference = Reference::of(levels.planes(Level::Streaming, &frame), bounds);
                self.last = Some((filters, part, frame, reference));
            }
            Part::Motion(picture) => {
                let frame = &self.subjects[picture].frame;
                self.motions
                    .entry((shared(levels.design(), part), picture))
                    .or_insert_with(|| Motions::new(levels, frame, &NOMINAL, bounds, MOTIONS));
            }
        }
    }

    /// Measures a design on a part. Call [`Bench::prepare`] for this part and what it shares first.
    pub(crate) fn measure(&self, levels: &Levels, part: Part) -> PartOutcome {
        let (bounds, place) = (Bounds::acceptance(), self.name(part));
        match part {
            Part::Frame(..) => {
                let compared = self
                    .last
                    .as_ref()
                    .and_then(|(_, _, frame, reference)| reference.compare_bit_true(levels, frame, bounds));
                if let Some(reason) = compared.as_ref().and_then(|compared| compared.unfit(bounds)) {
                    return PartOutcome::unfit(&place, reason);
                }
                let checks = compared.as_ref().map(|compared| compared.check(bounds)).unwrap_or_default();
                let rms = compared.map(|compared| compared.scales.iter().map(|s| s.interior.rms).fold(0.0, f64::max));
                PartOutcome::new(&checks, &place, rms)
            }
            Part::Motion(picture) => {
                let motions = self.motions.get(&(shared(levels.design(), part), picture));
                if let Some(reason) = motions.and_then(|motions| motions.unfit(bounds)) {
                    return PartOutcome::unfit(&place, reason);
                }
                let displacements = motions.map(|motions| motions.displacements(levels)).unwrap_or_default();
                PartOutcome::new(&displacement::check(&displacements, bounds), &place, None)
            }
        }
    }
}
