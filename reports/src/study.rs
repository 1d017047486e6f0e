//! The measurements of a quantisation report, before a page is rendered from them.
//!
//! Every picture is measured under every condition at every model level. There are two kinds of error, which are never
//! added: *approximation*, `recursive` and `streaming` against `ideal` (the sampled Gaussian), and *quantisation*,
//! `quantised` and `bit_true` against `streaming`.

use std::borrow::Cow;
use std::fmt;

use crate::repeatability::{self, Curve};
use hoverlock_design::{DesignPoint, KT27, SmootherKind};
use hoverlock_fixed_point::analysis::acceptance::{
    Comparison, Reference, SigmaEff, check_coefficients, dog_lsb, response, rounding_beyond_bound, sigma_eff,
};
use hoverlock_fixed_point::analysis::bounds::{Bounds, Check, Sense};
use hoverlock_fixed_point::analysis::displacement::{self, Displacement, Motions};
use hoverlock_fixed_point::analysis::errors::{ErrorStatistics, Flips};
use hoverlock_fixed_point::analysis::levels::{Level, LevelPlanes, Levels};
use hoverlock_fixed_point::analysis::range::Ranges;
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_fixed_point::model::design::{other_smoother, recursive};
use hoverlock_pictures::conditions::{CONDITIONS, Condition, NOMINAL};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::smoother::Smoother;
use rayon::prelude::*;
use serde::Serialize;

use crate::figures::{Figures, overlay};
use crate::hardware::{Hardware, MISMATCHES, StepResult};
use crate::provenance::Provenance;
use crate::ranges::RangeRow;
use crate::smoothers::{self, SmootherRow};
use crate::sweep::{self, Alternative, Cost, Sweep};

/// Smallest width and height of a picture, px. The interior leaves out 8 and 70 pixels, and one pixel must remain.
pub const MIN_SIDE: usize = 79;

/// Number of known motions per picture.
pub const MOTIONS: usize = 5;

/// A picture to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// File name without its folder.
    pub name: String,
    /// The part that is measured, at most the frame size of the design point, DN.
    pub frame: Plane<u16>,
    /// The whole picture, DN.
    pub picture: Plane<u16>,
}

/// The measurements of one picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PictureStudy {
    /// File name without its folder.
    pub name: String,
    /// SHA-256 of the decoded plane.
    pub sha256: String,
    /// Width and height of the whole picture, px.
    pub whole: (usize, usize),
    /// Width and height of the part that was measured, px.
    pub frame: (usize, usize),
    /// The measurements under each condition.
    pub conditions: Vec<ConditionStudy>,
    /// The displacement for each known motion, nominal condition.
    pub displacements: Vec<Displacement>,
    /// Why no design can be judged by the motions; they are not estimated then.
    #[serde(skip)]
    pub unfit_motions: Option<String>,
    /// Error maps and feature map for the page.
    #[serde(skip)]
    pub figures: Figures,
}

/// The measurements of one picture under one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionStudy {
    /// The condition that was applied.
    pub condition: Condition,
    /// The seed of its noise and gain.
    pub seed: u64,
    /// The gain drawn from the seed.
    pub gain: f64,
    /// SHA-256 of the degraded frame.
    pub sha256: String,
    /// `bit_true` against `streaming`.
    pub comparison: Comparison,
}

/// The two kinds of error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A level against `ideal`.
    Approximation,
    /// A level against `streaming`.
    Quantisation,
}

/// The error of one stage of one level on one picture under one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measurement {
    /// Name of the picture.
    pub picture: String,
    /// Name of the condition.
    pub condition: &'static str,
    /// The stage that was compared.
    pub stage: Stage,
    /// The kind of error.
    pub kind: Kind,
    /// The LSB that errors are given in, DN: that of the design's state, or of the DoG of `kt27`.
    pub lsb_dn: f64,
    /// The error on the interior, LSB.
    #[serde(flatten)]
    pub error: ErrorStatistics,
}

/// A signal that every level computes for the whole frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// A smoother's output.
    Smoothed(usize),
    /// The signed response of a scale pair.
    Dog(usize),
    /// The maximum of the response around each pixel.
    MaxDog(usize),
}

impl Stage {
    /// Returns all stages of a design, in the order of the data.
    pub fn all(design: &DesignPoint) -> Vec<Self> {
        let smoothed = (0..design.smoothers()).map(Self::Smoothed);
        let dogs = (0..design.pairs()).map(Self::Dog);
        smoothed.chain(dogs).chain((0..design.pairs()).map(Self::MaxDog)).collect()
    }

    /// Returns the label in tables, with the sigmas of the design.
    pub fn name(self, design: &DesignPoint) -> String {
        let sigma = |smoother: usize| design.sigmas[smoother];
        match self {
            Self::Smoothed(smoother) => format!("smoothed, σ {}", sigma(smoother)),
            Self::Dog(k) => format!("DoG {k}, σ {} − {}", sigma(k), sigma(k + 1)),
            Self::MaxDog(k) => format!("MaxDOG {k}"),
        }
    }

    /// Returns the LSB that errors of the stage are given in, DN: for a smoother that of the design's state, for a
    /// response that of the DoG of `kt27`, in which the bounds are.
    pub fn lsb(self, design: &DesignPoint) -> f64 {
        match self {
            Self::Smoothed(_) => design.state_dn().lsb(),
            Self::Dog(_) | Self::MaxDog(_) => dog_lsb(),
        }
    }

    fn plane(self, planes: &LevelPlanes) -> Cow<'_, Plane<f64>> {
        match self {
            Self::Smoothed(smoother) => Cow::Borrowed(&planes.smoothed[smoother]),
            Self::Dog(k) => Cow::Owned(response(planes, k)),
            Self::MaxDog(k) => Cow::Borrowed(&planes.max_dog[k]),
        }
    }
}

/// One model level and its measurements.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelStudy {
    /// The level that was measured.
    pub name: Level,
    /// The one thing that differs from the level above.
    pub changes: String,
    /// Every stage on every picture under every condition.
    pub measurements: Vec<Measurement>,
    /// Simulation and resource estimate; `rtl` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardware: Option<Hardware>,
}

/// The check of one bound, and on which picture and condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundRow {
    /// The check of the bound.
    #[serde(flatten)]
    pub check: Check,
    /// Distance to the limit, positive where the check passes.
    pub margin: f64,
    /// The picture; `None` for the bounds of the coefficients.
    pub picture: Option<String>,
    /// The condition; `None` if none was applied.
    pub condition: Option<&'static str>,
}

/// A picture that no design can be judged by, because floating point fails on it too.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unfit {
    /// The picture.
    pub picture: String,
    /// The condition under which it is unfit; `None` if none was applied.
    pub condition: Option<&'static str>,
    /// What it lacks.
    pub reason: String,
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let condition = self.condition.map(|name| format!(", {name}")).unwrap_or_default();
        write!(f, "{}{condition}: unfit to judge a design: {}", self.picture, self.reason)
    }
}

/// A picture that is fit to judge a design under a condition, but has too little contrast for some checks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LowContrast {
    /// The picture.
    pub picture: String,
    /// The condition.
    pub condition: &'static str,
    /// Rms of its `streaming` DoG on the scale with the lowest contrast, LSB.
    pub rms_lsb: f64,
    /// The checks that are left out.
    pub checks: Vec<&'static str>,
}

impl fmt::Display for LowContrast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { picture, condition, rms_lsb, checks } = self;
        let checks = checks.join(", ");
        write!(f, "{picture}, {condition}: the contrast, {rms_lsb:.0} LSB rms, is below every class of {checks}")
    }
}

/// No picture is fit to judge a design, so there is no verdict.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub struct Unjudged(pub Vec<Unfit>);

impl fmt::Display for Unjudged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reasons: Vec<String> = self.0.iter().map(Unfit::to_string).collect();
        write!(
            f,
            "no picture can judge the design: {}; give larger ones, or ones with more texture",
            reasons.join("; ")
        )
    }
}

/// Error after every stage of a smoother, `bit_true` against `streaming`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chain {
    /// `sigma` of the smoother, px.
    pub sigma: f64,
    /// The stages in the order of the data.
    pub stages: Vec<ChainStage>,
}

/// Error after one stage of a smoother.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainStage {
    /// Name of the stage: `recursion`, `column_look_ahead_0`, ..
    pub name: String,
    /// Rms of the error after it, LSB of the design's state.
    pub rms_lsb: f64,
}

/// All measurements of a report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Study {
    /// Every check passes, and at least one picture was fit to judge the design.
    pub pass: bool,
    /// Inputs, design point and sources.
    pub provenance: Provenance,
    /// The checks of every bound on every picture and condition.
    pub bounds: Vec<BoundRow>,
    /// Number of pictures given, with those that were refused before they were measured.
    pub pictures_given: usize,
    /// What no design can be judged by, and why.
    pub unfit: Vec<Unfit>,
    /// The checks that are left out for want of contrast.
    pub low_contrast: Vec<LowContrast>,
    /// The six levels, `ideal` to `rtl`.
    pub levels: Vec<LevelStudy>,
    /// The range observed at every node, over all pictures and conditions.
    pub formats: Vec<RangeRow>,
    /// The same, with all stages of a smoother as one row.
    #[serde(skip)]
    pub format_groups: Vec<RangeRow>,
    /// Effective sigma of each smoother and direction.
    pub sigma_eff: Vec<SigmaEff>,
    /// The error after each stage of each smoother: first picture, nominal condition.
    pub chains: Vec<Chain>,
    /// The measurements of each picture.
    pub pictures: Vec<PictureStudy>,
    /// Flipped descriptor bits over all pictures, for each condition.
    pub flips: Vec<(&'static str, Flips)>,
    /// Error against word length, one sweep for each format.
    pub sweeps: Vec<Sweep>,
    /// Error against resources, one entry for each word length of the sweeps.
    pub costs: Vec<Cost>,
    /// Other choices for each word, and whether they pass.
    pub alternatives: Vec<Alternative>,
    /// Stability of the points of `ideal` and `recursive` and of three descriptors under warps of the first picture.
    pub repeatability: Vec<Curve>,
    /// The smoothers in floating point side by side; empty for a first-order design.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub smoothers: Vec<SmootherRow>,
    /// The design point.
    pub design: DesignPoint,
}

/// Returns the number of progress steps of [`run`] for a number of pictures.
pub fn steps(pictures: usize, design: &DesignPoint) -> u64 {
    (pictures * (CONDITIONS.len() + 1 + sweep::steps(design)) + 1) as u64
}

/// The commands that a report shows.
pub struct Commands<'a> {
    /// The command as typed.
    pub typed: &'a str,
    /// Returns the command that makes the same report with some changes of the design, `KEY=VALUE` each.
    pub changed: &'a (dyn Fn(&[String]) -> String + Sync),
}

/// Measures every level except `rtl`, which [`Study::with_hardware`] adds. `step` is called after each progress step.
///
/// # Errors
/// The design point has no valid coefficients.
pub fn run(
    subjects: &[Subject],
    design: &DesignPoint,
    commands: &Commands<'_>,
    step: &(dyn Fn(&str) + Sync),
) -> Result<Study, CoefficientError> {
    let bounds = Bounds::acceptance();
    let levels = Levels::new(design)?;
    // One picture after the other, each in parallel: the planes of all levels are the report's largest memory.
    let measured: Vec<Measured> =
        subjects.iter().map(|subject| measure_picture(&levels, subject, bounds, step)).collect();
    let motions: Vec<Motions> = measured.iter().map(|measured| measured.motions.clone()).collect();
    // The checks are those of the hardware, whatever smoother the design names.
    let hardware = design.of_hardware();
    let bench = sweep::Bench { design: &hardware, subjects, motions: &motions, command: commands.changed, step };
    let (sweeps, alternatives) = bench.run()?;
    let chains = subjects.first().map(|subject| chains(&levels, subject, bounds)).unwrap_or_default();
    let other = |sigma: f64| recursive(design, sigma).map(Smoother::Recursive);
    let other: Option<repeatability::SmootherOf<'_>> = (design.smoother != SmootherKind::FirstOrder).then_some(&other);
    let repeatability = match subjects.first() {
        // A property of the algorithm, so at one frame size whatever the design.
        Some(subject) => repeatability::curves(&subject.picture, (KT27.width as usize, KT27.height as usize), other)?,
        None => Vec::new(),
    };
    let smoothers = smoothers::rows(design, subjects, &motions, &repeatability)?;
    step("repeatability");

    let mut ranges = Ranges::new(design);
    let (mut pictures, mut measurements) = (Vec::new(), Vec::new());
    for measured in measured {
        ranges.merge(&measured.ranges);
        measurements.extend(measured.errors);
        pictures.push(measured.picture);
    }
    let level_studies = Level::MODELS
        .iter()
        .map(|&level| LevelStudy {
            name: level,
            changes: changes(level, design),
            measurements: measurements.iter().filter(|(of, _)| *of == level).map(|(_, m)| m.clone()).collect(),
            hardware: None,
        })
        .collect();
    let flips = CONDITIONS
        .iter()
        .enumerate()
        .map(|(index, condition)| {
            let mut sum = Flips::of_pairs(levels.design().pairs());
            pictures.iter().filter_map(|p| p.conditions.get(index)).for_each(|c| sum.add(&c.comparison.flips));
            (condition.name, sum)
        })
        .collect();
    let rows = check(&levels, &pictures, bounds);
    Ok(Study {
        pass: rows.iter().all(|row| row.check.pass) && rows.iter().any(|row| row.picture.is_some()),
        provenance: Provenance::of(&levels, commands.typed),
        pictures_given: subjects.len(),
        unfit: unfit(&pictures, bounds),
        low_contrast: low_contrast(&pictures, bounds),
        bounds: rows,
        levels: level_studies,
        formats: RangeRow::each(&ranges),
        format_groups: RangeRow::grouped(&ranges, &design.sigmas),
        sigma_eff: sigma_eff(&levels),
        chains,
        pictures,
        flips,
        costs: sweep::costs(&sweeps),
        alternatives,
        sweeps,
        repeatability,
        smoothers,
        design: design.clone(),
    }
    .with_hardware(Hardware::not_run("no simulation was requested")))
}

/// Returns the frame under each condition, in the order of [`CONDITIONS`], DN.
pub fn frames(subject: &Subject) -> [Plane<u16>; CONDITIONS.len()] {
    CONDITIONS.map(|condition| condition.apply(&subject.frame, Bounds::acceptance().seeds.of(&condition)))
}

/// Returns the difference of a level from the level above it, for tables.
pub(crate) fn changes(level: Level, design: &DesignPoint) -> String {
    let smoother = design.smoother;
    let change = match level {
        Level::Recursive if smoother != SmootherKind::FirstOrder => {
            return format!("{smoother} in place of the Gaussian, f64; the levels below but quantised are first-order");
        }
        Level::Quantised if smoother != SmootherKind::FirstOrder => {
            return format!("rounded coefficients of {smoother}, f64 arithmetic");
        }
        Level::Ideal => "sampled Gaussian, f64",
        Level::Recursive => "two-sided first-order recursion in place of the Gaussian, f64",
        Level::Streaming => "look-ahead and look-back over a finite number of samples, f64",
        Level::Quantised => "rounded coefficients, f64 arithmetic",
        Level::BitTrue => "integer arithmetic: state and DoG rounded to their formats",
        Level::Rtl => "the emitted Verilog, simulated",
    };
    change.to_owned()
}

/// The measurements of one picture before they are merged.
struct Measured {
    picture: PictureStudy,
    motions: Motions,
    errors: Vec<(Level, Measurement)>,
    ranges: Ranges,
}

fn measure_picture(levels: &Levels, subject: &Subject, bounds: &Bounds, step: &(dyn Fn(&str) + Sync)) -> Measured {
    let mut ranges = Ranges::new(levels.design());
    let mut figures = Figures::default();
    let mut errors = Vec::new();
    let mut conditions = Vec::new();
    let mut worst_kept = f64::INFINITY;
    for (condition, frame) in CONDITIONS.into_iter().zip(frames(subject)) {
        let seed = bounds.seeds.of(&condition);
        let reference = measure_levels(levels, &frame, (subject, condition), &mut errors, &mut figures);
        let compared = Reference::of(reference, bounds).compare_bit_true(levels, &frame, bounds);
        ranges.see(levels, &frame);
        let Some(comparison) = compared else { continue };
        let kept = comparison.scales.iter().map(|s| s.kept.within_one_px_percent).fold(f64::INFINITY, f64::min);
        if kept < worst_kept {
            worst_kept = kept;
            figures.features = overlay(&frame, &comparison, condition.name);
        }
        let (gain, sha256) = (condition.gain(seed), hoverlock_pictures::sha256(&frame));
        conditions.push(ConditionStudy { condition, seed, gain, sha256, comparison });
        step(&format!("{}, {}", subject.name, condition.name));
    }
    let motions = Motions::new(levels, &subject.frame, &NOMINAL, bounds, MOTIONS);
    let unfit_motions = motions.unfit(bounds);
    let displacements = if unfit_motions.is_none() { motions.displacements(levels) } else { Vec::new() };
    step(&format!("{}, displacement", subject.name));
    let frame = (subject.frame.width(), subject.frame.height());
    let whole = (subject.picture.width(), subject.picture.height());
    let (name, sha256) = (subject.name.clone(), hoverlock_pictures::sha256(&subject.picture));
    Measured {
        picture: PictureStudy { name, sha256, whole, frame, conditions, displacements, unfit_motions, figures },
        motions,
        errors,
        ranges,
    }
}

/// Measures every stage of every level on a frame, adds the errors, draws the maps of the nominal condition, and
/// returns the planes of `streaming`.
///
/// The planes of a level are the report's largest memory, so at most three levels are there at a time.
fn measure_levels(
    levels: &Levels,
    frame: &Plane<u16>,
    (subject, condition): (&Subject, Condition),
    errors: &mut Vec<(Level, Measurement)>,
    figures: &mut Figures,
) -> LevelPlanes {
    let planes = |level: Level| levels.planes(level, frame);
    let mut measure = |level: Level, kind: Kind, tested: &LevelPlanes, reference: &LevelPlanes| {
        let of_stage = |stage: Stage| {
            let (reference, tested) = (stage.plane(reference), stage.plane(tested));
            let lsb_dn = stage.lsb(levels.design());
            let error = ErrorStatistics::between(&reference, &tested, lsb_dn, Bounds::acceptance().interior)?;
            let (picture, condition) = (subject.name.clone(), condition.name);
            Some((level, Measurement { picture, condition, stage, kind, lsb_dn, error }))
        };
        errors.par_extend(Stage::all(levels.design()).into_par_iter().filter_map(of_stage));
    };
    let (ideal, recursive) = rayon::join(|| planes(Level::Ideal), || planes(Level::Recursive));
    measure(Level::Recursive, Kind::Approximation, &recursive, &ideal);
    if levels.unrounded() == Level::Recursive {
        measure(Level::Quantised, Kind::Quantisation, &planes(Level::Quantised), &recursive);
    }
    drop(recursive);
    let streaming = planes(Level::Streaming);
    measure(Level::Streaming, Kind::Approximation, &streaming, &ideal);
    if levels.unrounded() == Level::Streaming {
        measure(Level::Quantised, Kind::Quantisation, &planes(Level::Quantised), &streaming);
    }
    let bit_true = planes(Level::BitTrue);
    measure(Level::BitTrue, Kind::Quantisation, &bit_true, &streaming);
    if condition == NOMINAL {
        figures.heat_maps(&ideal, &streaming, &bit_true);
    }
    streaming
}

fn check(levels: &Levels, pictures: &[PictureStudy], bounds: &Bounds) -> Vec<BoundRow> {
    let row = |check: Check, picture: Option<&PictureStudy>, condition: Option<&'static str>| {
        let distance = check.limit - check.measured;
        let margin = if check.sense == Sense::AtMost { distance } else { -distance };
        BoundRow { check, margin, picture: picture.map(|picture| picture.name.clone()), condition }
    };
    let mut rows: Vec<BoundRow> =
        check_coefficients(levels, bounds).into_iter().map(|check| row(check, None, None)).collect();
    for picture in pictures {
        for study in fit(picture, bounds) {
            let checks = study.comparison.check(bounds).into_iter();
            rows.extend(checks.map(|check| row(check, Some(picture), Some(study.condition.name))));
        }
        let checks = displacement::check(&picture.displacements, bounds).into_iter();
        rows.extend(checks.map(|check| row(check, Some(picture), Some(NOMINAL.name))));
    }
    rows
}

/// Returns the conditions under which a picture is fit to judge a design.
fn fit<'a>(picture: &'a PictureStudy, bounds: &'a Bounds) -> impl Iterator<Item = &'a ConditionStudy> {
    picture.conditions.iter().filter(move |study| study.comparison.unfit(bounds).is_none())
}

/// Returns the checks that are left out for want of contrast.
fn low_contrast(pictures: &[PictureStudy], bounds: &Bounds) -> Vec<LowContrast> {
    let of_frame = |picture: &PictureStudy, of: &ConditionStudy| LowContrast {
        picture: picture.name.clone(),
        condition: of.condition.name,
        rms_lsb: of.comparison.lowest_rms_lsb(),
        checks: of.comparison.below_every_class(),
    };
    let frames = pictures.iter().flat_map(|picture| fit(picture, bounds).map(move |of| of_frame(picture, of)));
    frames.filter(|of| !of.checks.is_empty()).collect()
}

/// Returns the pictures that judge nothing, under each condition and by their motions.
fn unfit(pictures: &[PictureStudy], bounds: &Bounds) -> Vec<Unfit> {
    let mut all = Vec::new();
    for picture in pictures {
        let mut add = |condition: Option<&'static str>, reason: String| {
            all.push(Unfit { picture: picture.name.clone(), condition, reason });
        };
        for study in &picture.conditions {
            if let Some(reason) = study.comparison.unfit(bounds) {
                add(Some(study.condition.name), reason);
            }
        }
        if picture.conditions.len() < CONDITIONS.len() {
            add(None, "it is too small to have an interior".into());
        }
        if let Some(reason) = &picture.unfit_motions {
            add(None, format!("known motions: {reason}"));
        }
    }
    all
}

fn chains(levels: &Levels, subject: &Subject, bounds: &Bounds) -> Vec<Chain> {
    let frame = NOMINAL.apply(&subject.frame, bounds.seeds.of(&NOMINAL));
    let lsb = levels.design().state_dn().lsb();
    let chain = |smoother: usize| {
        let mut reference = Vec::new();
        levels.stages(Level::Streaming, smoother, &frame, |_, plane| reference.push(plane.clone()));
        let (mut stages, mut reference) = (Vec::new(), reference.into_iter());
        levels.stages(Level::BitTrue, smoother, &frame, |stage, plane| {
            let error =
                reference.next().and_then(|wanted| ErrorStatistics::between(&wanted, plane, lsb, bounds.interior));
            stages.extend(error.map(|error| ChainStage { name: stage.to_string(), rms_lsb: error.rms }));
        });
        Chain { sigma: levels.design().sigmas[smoother], stages }
    };
    (0..levels.design().smoothers()).into_par_iter().map(chain).collect()
}

impl Study {
    /// Returns the checks that fail, the furthest beyond its limit first.
    pub fn failures(&self) -> Vec<&BoundRow> {
        let mut failures: Vec<&BoundRow> = self.bounds.iter().filter(|row| !row.check.pass).collect();
        // NaN means that nothing was measured, which is the worst failure.
        let used = |row: &BoundRow| if row.check.used.is_nan() { f64::INFINITY } else { row.check.used };
        failures.sort_by(|a, b| used(b).total_cmp(&used(a)));
        failures
    }

    /// Adds pictures that were refused before they were measured.
    pub fn add_refused(&mut self, unfit: Vec<Unfit>) {
        self.pictures_given += unfit.len();
        self.unfit.extend(unfit);
    }

    /// Returns the names of the pictures that judge the design: those with a check beside that of the Verilog, which
    /// needs no features.
    pub fn judges(&self) -> Vec<&str> {
        let names = self.pictures.iter().map(|picture| picture.name.as_str());
        let is_judge = |name: &&str| {
            self.bounds.iter().any(|row| row.picture.as_deref() == Some(*name) && row.check.name != MISMATCHES)
        };
        names.filter(is_judge).collect()
    }

    /// Returns `true` if a picture is fit to judge the design under a condition.
    pub fn is_fit(&self, picture: &str, condition: &str) -> bool {
        !self.unfit.iter().any(|unfit| unfit.picture == picture && unfit.condition == Some(condition))
    }

    /// Returns the frames that are fit to judge the design.
    pub fn fit_frames(&self) -> impl Iterator<Item = &Comparison> {
        let frames =
            self.pictures.iter().flat_map(|picture| picture.conditions.iter().map(move |of| (&picture.name, of)));
        frames.filter(move |(name, of)| self.is_fit(name, of.condition.name)).map(|(_, of)| &of.comparison)
    }

    /// Returns the measurements of a level on what is fit to judge the design.
    pub fn fit_measurements(&self, level: Level) -> impl Iterator<Item = &Measurement> {
        let of_level = self.levels.iter().filter(move |study| study.name == level);
        of_level.flat_map(|study| &study.measurements).filter(move |m| self.is_fit(&m.picture, m.condition))
    }

    /// Returns why no picture with features can pass the bound of the DoG error; `None` if one can.
    pub fn beyond_bound(&self) -> Option<String> {
        rounding_beyond_bound(&self.design, Bounds::acceptance())
    }

    /// Returns what no check of this study covers, each with the reason.
    pub fn unchecked(&self) -> Vec<String> {
        let mut unchecked: Vec<String> = other_smoother(&self.design).into_iter().collect();
        unchecked.extend(self.unfit.iter().map(Unfit::to_string));
        if let Some(Hardware { simulation: StepResult::NotRun { reason }, .. }) = self.hardware() {
            unchecked.push(format!("rtl against bit_true: {reason}"));
        }
        unchecked.extend(self.low_contrast.iter().map(LowContrast::to_string));
        unchecked
    }
}
