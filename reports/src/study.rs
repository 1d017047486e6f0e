//! Pictures in, measurements out: everything that the quantisation report says, before any page is made of it.
//!
//! Every picture passes through every condition and every level. Errors are of two kinds that are never added up:
//! *approximation*, `recursive` and `streaming` against `ideal` (the true Gaussian), and *quantisation*, `quantised` and `bit_true` against `streaming`.

use hoverlock_fixed_point::analysis::acceptance::{Comparison, SigmaEff, check_coefficients, response, sigma_eff};
use hoverlock_fixed_point::analysis::bounds::{Bounds, Check, Sense};
use hoverlock_fixed_point::analysis::displacement::{self, Displacement};
use hoverlock_fixed_point::analysis::errors::{BitKind, ErrorStatistics, Flips};
use hoverlock_fixed_point::analysis::levels::{Level, LevelPlanes, Levels};
use hoverlock_fixed_point::analysis::range::Ranges;
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_fixed_point::model::design::{DesignPoint, KT27, SCALES, SMOOTHERS};
use hoverlock_reference::features::repeatability::{self, Curve};
use hoverlock_reference::image::conditions::{CONDITIONS, Condition, NOMINAL};
use hoverlock_reference::image::picture;
use hoverlock_reference::image::plane::Plane;
use rayon::prelude::*;
use serde::Serialize;

use crate::figures::{Figures, overlay};
use crate::hardware::Hardware;
use crate::provenance::Provenance;
use crate::ranges::RangeRow;
use crate::sweep::{self, Cost, Sweep};

/// The smallest side of a picture with an interior: 8 and 70 pixels are left out, and one must remain.
pub const LEAST_SIDE: usize = 79;

/// Known motions per picture.
const MOTIONS: usize = 5;

/// A picture to be measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// What it is called, without its folder.
    pub name: String,
    /// What the camera would see, at most the frame of the design point.
    pub frame: Plane<u16>,
    /// The whole picture.
    pub picture: Plane<u16>,
}

/// What is measured of one picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PictureStudy {
    /// What it is called.
    pub name: String,
    /// SHA-256 of the decoded plane.
    pub sha256: String,
    /// Columns and rows of the picture.
    pub whole: (usize, usize),
    /// Columns and rows of what was measured.
    pub frame: (usize, usize),
    /// Under each condition.
    pub conditions: Vec<ConditionStudy>,
    /// Known motions, nominal condition.
    pub displacements: Vec<Displacement>,
    /// Pictures for the page.
    #[serde(skip)]
    pub figures: Figures,
}

/// What is measured of one picture under one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionStudy {
    /// The condition.
    pub condition: Condition,
    /// The seed of its noise and gain.
    pub seed: u64,
    /// The gain that the seed gave.
    pub gain: f64,
    /// SHA-256 of the degraded frame.
    pub sha256: String,
    /// `bit_true` against `streaming`.
    pub comparison: Comparison,
}

/// Which of the two columns an error belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Against `ideal`.
    Approximation,
    /// Against `streaming`.
    Quantisation,
}

/// One stage of one level on one picture under one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measurement {
    /// Name of the picture.
    pub picture: String,
    /// Name of the condition.
    pub condition: &'static str,
    /// What was compared.
    pub stage: Stage,
    /// Against what.
    pub kind: Kind,
    /// The step that errors are told in, DN of the camera sample.
    pub lsb_dn: f64,
    /// The error on the interior, LSB.
    #[serde(flatten)]
    pub error: ErrorStatistics,
}

/// A plane that every level has.
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
    /// All of them, in the order of the data.
    pub const ALL: [Self; SMOOTHERS + 2 * SCALES] = [
        Self::Smoothed(0),
        Self::Smoothed(1),
        Self::Smoothed(2),
        Self::Dog(0),
        Self::Dog(1),
        Self::MaxDog(0),
        Self::MaxDog(1),
    ];

    /// How people call it, with the sigmas of the design.
    pub fn name(self, design: &DesignPoint) -> String {
        let sigma = |smoother: usize| design.sigmas[smoother];
        match self {
            Self::Smoothed(smoother) => format!("smoothed, σ {}", sigma(smoother)),
            Self::Dog(k) => format!("DoG {k}, σ {} − {}", sigma(k), sigma(k + 1)),
            Self::MaxDog(k) => format!("MaxDOG {k}"),
        }
    }

    /// The step of the design point's word, codes.
    pub fn lsb(self) -> f64 {
        match self {
            Self::Smoothed(_) => KT27.state.lsb(),
            Self::Dog(_) | Self::MaxDog(_) => KT27.dog().lsb(),
        }
    }

    fn plane(self, planes: &LevelPlanes) -> Plane<f64> {
        match self {
            Self::Smoothed(smoother) => planes.smoothed[smoother].clone(),
            Self::Dog(k) => response(planes, k),
            Self::MaxDog(k) => planes.max_dog[k].clone(),
        }
    }
}

/// One level and all that was measured of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelStudy {
    /// Which level.
    pub name: Level,
    /// The one thing that differs from the level above.
    pub changes: &'static str,
    /// Every stage on every picture under every condition.
    pub measurements: Vec<Measurement>,
    /// What only `rtl` has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardware: Option<Hardware>,
}

/// A bound, and on what it was checked.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundRow {
    /// The check.
    #[serde(flatten)]
    pub check: Check,
    /// Distance to the limit, positive where the bound holds.
    pub margin: f64,
    /// The picture; nothing where the filters alone were checked.
    pub picture: Option<String>,
    /// The condition, where one was applied.
    pub condition: Option<&'static str>,
}

/// Error after every cell of a smoother, `bit_true` against `streaming`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chain {
    /// The `sigma` of the smoother.
    pub sigma: f64,
    /// Name of each cell and the rms of the error after it, state LSB.
    pub cells: Vec<(String, f64)>,
}

/// Everything the report says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Study {
    /// Whether every bound holds.
    pub pass: bool,
    /// What was measured, with what.
    pub provenance: Provenance,
    /// Every bound on every picture and condition.
    pub bounds: Vec<BoundRow>,
    /// The six levels, `ideal` to `rtl`.
    pub levels: Vec<LevelStudy>,
    /// What every word held, all pictures and conditions together.
    pub formats: Vec<RangeRow>,
    /// The same, all stages of a smoother as one.
    #[serde(skip)]
    pub format_groups: Vec<RangeRow>,
    /// Effective sigmas.
    pub sigma_eff: Vec<SigmaEff>,
    /// How the error grows along the cells of each smoother, on the first picture, nominal.
    pub chains: Vec<Chain>,
    /// Each picture.
    pub pictures: Vec<PictureStudy>,
    /// Descriptor bits, all pictures together, per condition.
    pub flips: Vec<(&'static str, Flips)>,
    /// Word lengths either side of the chosen ones.
    pub sweeps: Vec<Sweep>,
    /// The same word lengths, error against resources.
    pub costs: Vec<Cost>,
    /// Stability of `ideal` and `recursive`, and of three descriptors, under warps of the first picture.
    pub repeatability: Vec<Curve>,
    /// The design point.
    pub design: DesignPoint,
}

/// How many times [`run`] reports progress for so many pictures.
pub fn steps(pictures: usize) -> u64 {
    (pictures * (CONDITIONS.len() + 1 + sweep::points()) + 1) as u64
}

/// Measures everything but `rtl`, which [`Study::with_hardware`] brings.
///
/// # Errors
/// Where the design point has no coefficients.
pub fn run(
    subjects: &[Subject],
    design: &DesignPoint,
    command: &str,
    step: &(dyn Fn(&str) + Sync),
) -> Result<Study, CoefficientError> {
    let bounds = Bounds::acceptance();
    let levels = Levels::new(design)?;
    let measured: Vec<Measured> =
        subjects.par_iter().map(|subject| measure_picture(&levels, subject, bounds, step)).collect();
    let sweeps = sweep::run(design, subjects, bounds, step)?;
    let chains = subjects.first().map(|subject| chains(&levels, subject, bounds)).unwrap_or_default();
    let repeatability = match subjects.first() {
        Some(subject) => repeatability::curves(&subject.picture)?,
        None => Vec::new(),
    };
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
            changes: changes(level),
            measurements: measurements.iter().filter(|(of, _)| *of == level).map(|(_, m)| m.clone()).collect(),
            hardware: None,
        })
        .collect();
    let flips = CONDITIONS
        .iter()
        .enumerate()
        .map(|(index, condition)| {
            let mut sum = Flips::default();
            pictures.iter().filter_map(|p| p.conditions.get(index)).for_each(|c| sum.add(&c.comparison.flips));
            (condition.name, sum)
        })
        .collect();
    let rows = check(&levels, &pictures, bounds);
    Ok(Study {
        pass: rows.iter().all(|row| row.check.pass),
        provenance: Provenance::of(&levels, command),
        bounds: rows,
        levels: level_studies,
        formats: RangeRow::each(&ranges),
        format_groups: RangeRow::grouped(&ranges, &design.sigmas),
        sigma_eff: sigma_eff(&levels),
        chains,
        pictures,
        flips,
        costs: sweep::costs(&sweeps),
        sweeps,
        repeatability,
        design: design.clone(),
    }
    .with_hardware(Hardware::not_run("no simulation was asked for")))
}

/// What the camera sees of a picture under each condition, in the order of [`CONDITIONS`].
pub fn frames(subject: &Subject) -> [Plane<u16>; CONDITIONS.len()] {
    CONDITIONS.map(|condition| condition.apply(&subject.frame, Bounds::acceptance().seeds.of(&condition)))
}

pub(crate) fn changes(level: Level) -> &'static str {
    match level {
        Level::Ideal => "sampled Gaussian, f64",
        Level::Recursive => "two-sided first-order recursion instead of the Gaussian",
        Level::Streaming => "look-ahead and look-back of finite reach",
        Level::Quantised => "coefficients rounded, arithmetic still f64",
        Level::BitTrue => "integers: state and DoG rounded",
        Level::Rtl => "the emitted Verilog, simulated",
    }
}

/// All that one picture brings.
struct Measured {
    picture: PictureStudy,
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
        let planes: Vec<LevelPlanes> = Level::MODELS.par_iter().map(|&level| levels.planes(level, &frame)).collect();
        let of = |level: Level| &planes[level as usize];
        let pairs = [
            (Level::Recursive, Level::Ideal, Kind::Approximation),
            (Level::Streaming, Level::Ideal, Kind::Approximation),
            (Level::Quantised, Level::Streaming, Kind::Quantisation),
            (Level::BitTrue, Level::Streaming, Kind::Quantisation),
        ];
        for stage in Stage::ALL {
            let planes: Vec<Plane<f64>> = planes.iter().map(|planes| stage.plane(planes)).collect();
            for (test, reference, kind) in pairs {
                let (reference, tested) = (&planes[reference as usize], &planes[test as usize]);
                let Some(error) = ErrorStatistics::between(reference, tested, stage.lsb(), bounds.interior) else {
                    continue;
                };
                let picture = subject.name.clone();
                let condition = condition.name;
                errors.push((test, Measurement { picture, condition, stage, kind, lsb_dn: stage.lsb(), error }));
            }
        }
        ranges.see(levels, &frame);
        if condition == NOMINAL {
            figures.heat_maps(of(Level::Ideal), of(Level::Streaming), of(Level::BitTrue));
        }
        let Some((comparison, _)) = Comparison::between(of(Level::Streaming), of(Level::BitTrue), bounds) else {
            continue;
        };
        let kept = comparison.scales.iter().map(|s| s.kept.within_one_px_percent).fold(f64::INFINITY, f64::min);
        if kept < worst_kept {
            worst_kept = kept;
            figures.features = overlay(&frame, &comparison, condition.name);
        }
        let (gain, sha256) = (condition.gain(seed), picture::sha256(&frame));
        conditions.push(ConditionStudy { condition, seed, gain, sha256, comparison });
        step(&format!("{}, {}", subject.name, condition.name));
    }
    let displacements = displacement::displacements(levels, &subject.frame, &NOMINAL, bounds, MOTIONS);
    step(&format!("{}, displacement", subject.name));
    let frame = (subject.frame.width(), subject.frame.height());
    let whole = (subject.picture.width(), subject.picture.height());
    let (name, sha256) = (subject.name.clone(), picture::sha256(&subject.picture));
    Measured {
        picture: PictureStudy { name, sha256, whole, frame, conditions, displacements, figures },
        errors,
        ranges,
    }
}

fn check(levels: &Levels, pictures: &[PictureStudy], bounds: &Bounds) -> Vec<BoundRow> {
    let row = |check: Check, picture: Option<&PictureStudy>, condition: Option<&'static str>| {
        let distance = check.limit - check.measured;
        let margin = if check.sense == Sense::AtMost { distance } else { -distance };
        BoundRow { check, margin, picture: picture.map(|picture| picture.name.clone()), condition }
    };
    let mut rows: Vec<BoundRow> = check_coefficients(levels, bounds).into_iter().map(|j| row(j, None, None)).collect();
    for picture in pictures {
        for study in &picture.conditions {
            let checks = study.comparison.check(bounds).into_iter();
            rows.extend(checks.map(|j| row(j, Some(picture), Some(study.condition.name))));
        }
        let checks = displacement::check(&picture.displacements, bounds).into_iter();
        rows.extend(checks.map(|j| row(j, Some(picture), Some(NOMINAL.name))));
    }
    rows
}

fn chains(levels: &Levels, subject: &Subject, bounds: &Bounds) -> Vec<Chain> {
    let frame = NOMINAL.apply(&subject.frame, bounds.seeds.of(&NOMINAL));
    let chain = |smoother: usize| {
        let mut reference = Vec::new();
        levels.stages(Level::Streaming, smoother, &frame, |_, plane| reference.push(plane.clone()));
        let (mut cells, mut reference) = (Vec::new(), reference.into_iter());
        levels.stages(Level::BitTrue, smoother, &frame, |stage, plane| {
            let error = reference
                .next()
                .and_then(|wanted| ErrorStatistics::between(&wanted, plane, KT27.state.lsb(), bounds.interior));
            cells.extend(error.map(|error| (stage.to_string(), error.rms)));
        });
        Chain { sigma: levels.design().sigmas[smoother], cells }
    };
    (0..SMOOTHERS).into_par_iter().map(chain).collect()
}

impl Study {
    /// Share of flipped bits of one kind over all pictures under a condition, percent.
    pub fn flips_percent(&self, condition: &str, kind: BitKind) -> f64 {
        self.flips.iter().find(|(name, _)| *name == condition).map_or(f64::NAN, |(_, flips)| flips.percent(kind))
    }
}
