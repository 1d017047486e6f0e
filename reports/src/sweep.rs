//! Word-length sweeps: error and resources against the bits of the state, the coefficients or the DoG.
//!
//! One format is varied at a time; the others keep the design point.

use hoverlock_fixed_point::analysis::acceptance::{Comparison, Reference};
use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_fixed_point::analysis::errors::{BitKind, Flips};
use hoverlock_fixed_point::analysis::levels::{Level, Levels};
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_fixed_point::model::design::DesignPoint;
use hoverlock_fixed_point::model::format::Format;
use hoverlock_reference::image::conditions::{CONDITIONS, Condition};
use rayon::prelude::*;
use serde::Serialize;

use crate::study::Subject;

/// Fraction bits of the state in the sweep.
const STATE: [i8; 5] = [0, 1, 2, 3, 4];
/// Fraction bits of the coefficients in the sweep.
const COEFFICIENT: [i8; 6] = [8, 10, 12, 14, 16, 18];
/// Bits of the DoG magnitude in the sweep.
const DOG: [u32; 7] = [10, 11, 12, 13, 14, 15, 16];

/// The sweep of one format.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sweep {
    /// The format that is varied: `state`, `coefficients` or `DoG`.
    pub parameter: &'static str,
    /// Bits at the design point.
    pub chosen: f64,
    /// One entry for each word length and condition.
    pub points: Vec<SweepPoint>,
}

/// One word length under one condition, over all pictures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepPoint {
    /// Word length, bits.
    pub bits: f64,
    /// The condition.
    pub condition: &'static str,
    /// Root mean square of the DoG error, LSB of the design point.
    pub dog_rms_lsb: f64,
    /// MaxLBP bits flipped, percent.
    pub maxlbp_flips_percent: f64,
    /// Sign bits flipped, percent.
    pub sign_flips_percent: f64,
    /// Features not at the same pixel, percent.
    pub moved_percent: f64,
    /// Resources by the memory model.
    #[serde(flatten)]
    pub resources: Resources,
}

/// One word length: its error under the worst condition, and its resources.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cost {
    /// The format that is varied: `state`, `coefficients` or `DoG`.
    pub parameter: &'static str,
    /// Word length, bits.
    pub bits: f64,
    /// True for the design point, which is listed once.
    pub chosen: bool,
    /// True on the Pareto front: no other word length is better in error or resources and no worse in the rest.
    pub front: bool,
    /// Root mean square of the DoG error, LSB of the design point.
    pub dog_rms_lsb: f64,
    /// MaxLBP bits flipped, percent.
    pub maxlbp_flips_percent: f64,
    /// Features not at the same pixel, percent.
    pub moved_percent: f64,
    /// Resources by the memory model.
    #[serde(flatten)]
    pub resources: Resources,
}

/// Every word length of the sweeps once, with its error under the worst condition, and the Pareto front of them.
pub fn costs(sweeps: &[Sweep]) -> Vec<Cost> {
    let mut costs: Vec<Cost> = Vec::new();
    for sweep in sweeps {
        for point in &sweep.points {
            let chosen = point.bits == sweep.chosen;
            // Every sweep contains the design point.
            let same = |cost: &&mut Cost| {
                (chosen && cost.chosen) || (cost.parameter == sweep.parameter && cost.bits == point.bits)
            };
            match costs.iter_mut().find(same) {
                Some(cost) => {
                    cost.dog_rms_lsb = cost.dog_rms_lsb.max(point.dog_rms_lsb);
                    cost.maxlbp_flips_percent = cost.maxlbp_flips_percent.max(point.maxlbp_flips_percent);
                    cost.moved_percent = cost.moved_percent.max(point.moved_percent);
                }
                None => costs.push(Cost {
                    parameter: sweep.parameter,
                    bits: point.bits,
                    chosen,
                    front: false,
                    dog_rms_lsb: point.dog_rms_lsb,
                    maxlbp_flips_percent: point.maxlbp_flips_percent,
                    moved_percent: point.moved_percent,
                    resources: point.resources,
                }),
            }
        }
    }
    let objectives = |cost: &Cost| [cost.resources.m10k as f64, cost.resources.mul18 as f64, cost.dog_rms_lsb];
    let dominates = |a: &Cost, b: &Cost| {
        let pairs = || objectives(a).into_iter().zip(objectives(b));
        pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
    };
    let front: Vec<bool> = costs.iter().map(|cost| !costs.iter().any(|other| dominates(other, cost))).collect();
    costs.iter_mut().zip(front).for_each(|(cost, front)| cost.front = front);
    costs
}

/// The format that is varied, its bits at the design point, and the design of each word length.
type Variants = (&'static str, f64, Vec<(f64, DesignPoint)>);

/// The word lengths with valid coefficients, and the levels of each.
type LevelsBySetting = Vec<(f64, Levels)>;

/// Number of word lengths of all sweeps.
pub(crate) const fn points() -> usize {
    STATE.len() + COEFFICIENT.len() + DOG.len()
}

/// Sums over pictures.
#[derive(Debug, Clone, Default)]
struct Sum {
    squares: f64,
    planes: f64,
    flips: Flips,
    same: usize,
    features: usize,
}

pub(crate) fn run(
    design: &DesignPoint,
    subjects: &[Subject],
    bounds: &Bounds,
    step: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Sweep>, CoefficientError> {
    let integer = design.pixel.integer_bits();
    let state = |bits: &i8| DesignPoint { state: Format::unsigned(integer, *bits), ..design.clone() };
    let coefficient = |bits: &i8| DesignPoint { coefficient: Format::unsigned(0, *bits), ..design.clone() };
    let dog = |bits: &u32| DesignPoint { dog_bits: *bits, ..design.clone() };
    let variants: [Variants; 3] = [
        (
            "state",
            f64::from(design.state.bits()),
            STATE.iter().map(|bits| (f64::from(integer + *bits), state(bits))).collect(),
        ),
        (
            "coefficients",
            f64::from(design.coefficient.bits()),
            COEFFICIENT.iter().map(|bits| (f64::from(*bits), coefficient(bits))).collect(),
        ),
        ("DoG", f64::from(design.dog_bits), DOG.iter().map(|bits| (f64::from(*bits), dog(bits))).collect()),
    ];
    // With few bits some filters have no valid coefficients. Such a word length is left out.
    let existing = |(bits, design): &(f64, DesignPoint)| Some((*bits, Levels::new(design).ok()?));
    let all_levels: Vec<LevelsBySetting> =
        variants.iter().map(|(_, _, points)| points.iter().filter_map(existing).collect()).collect();
    let exact = Levels::new(design)?;
    // `streaming` is computed once for all word lengths, so pictures and conditions are the outer loop.
    let jobs: Vec<(&Subject, Condition)> =
        subjects.iter().flat_map(|subject| CONDITIONS.map(|condition| (subject, condition))).collect();
    let measured: Vec<(Condition, Vec<Vec<Option<Comparison>>>)> = jobs
        .par_iter()
        .map(|(subject, condition)| {
            let frame = condition.apply(&subject.frame, bounds.seeds.of(condition));
            let reference = Reference::of(&exact.planes(Level::Streaming, &frame), bounds);
            let compare = |levels: &Levels| {
                let test = levels.planes(Level::BitTrue, &frame);
                if *condition == CONDITIONS[0] {
                    step(&format!("{}, word lengths", subject.name));
                }
                reference.compare(&test, bounds)
            };
            (
                *condition,
                all_levels
                    .iter()
                    .map(|all_levels| all_levels.iter().map(|(_, levels)| compare(levels)).collect())
                    .collect(),
            )
        })
        .collect();
    let sweeps = variants.iter().zip(&all_levels).enumerate().map(|(v, ((parameter, chosen, _), all_levels))| {
        let points = all_levels.iter().enumerate().flat_map(|(p, (bits, levels))| {
            let (measured, resources) = (&measured, resources(levels.design()));
            CONDITIONS.into_iter().map(move |condition| {
                let of_condition = measured.iter().filter(|(of, _)| *of == condition);
                let mut sum = Sum::default();
                of_condition.filter_map(|(_, all)| all[v][p].as_ref()).for_each(|comparison| sum.add(comparison));
                sum.point(*bits, condition.name, resources)
            })
        });
        Sweep { parameter, chosen: *chosen, points: points.collect() }
    });
    Ok(sweeps.collect())
}

impl Sum {
    fn add(&mut self, comparison: &Comparison) {
        for scale in &comparison.scales {
            self.squares += scale.interior.rms.powi(2);
            self.planes += 1.0;
            self.same += scale.kept.same;
            self.features += scale.kept.reference.max(scale.kept.test);
        }
        self.flips.add(&comparison.flips);
    }

    fn point(&self, bits: f64, condition: &'static str, resources: Resources) -> SweepPoint {
        SweepPoint {
            bits,
            condition,
            dog_rms_lsb: (self.squares / self.planes).sqrt(),
            maxlbp_flips_percent: self.flips.percent(BitKind::Maxlbp),
            sign_flips_percent: self.flips.percent(BitKind::Sign),
            moved_percent: 100.0 * (1.0 - self.same as f64 / self.features.max(1) as f64),
            resources,
        }
    }
}
