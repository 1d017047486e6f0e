//! Word-length sweeps: error and resources against the bits of the state, the coefficients or the DoG.
//!
//! One format is varied at a time; the others keep the design point. The same measurements, checked against the bounds,
//! are the alternatives to each word; look-ahead and pixel are among these.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use hoverlock_design::{AutomaticThreshold, DesignPoint, Format};
use hoverlock_fixed_point::analysis::acceptance::{
    Comparison, Reference, ScaleComparison, check_coefficients, threshold_step,
};
use hoverlock_fixed_point::analysis::bounds::{Bounds, Check};
use hoverlock_fixed_point::analysis::displacement::{self, Motions};
use hoverlock_fixed_point::analysis::errors::BitKind;
use hoverlock_fixed_point::analysis::levels::{Level, Levels};
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_pictures::conditions::{CONDITIONS, Condition, NOMINAL};
use rayon::prelude::*;
use serde::Serialize;

use crate::check_outcome::CheckOutcome;
use crate::study::Subject;

/// Fraction bits of the coefficients in the sweep, beside those of the design.
const COEFFICIENT_FRACTION_BITS: [i8; 6] = [8, 10, 12, 14, 16, 18];
/// Bits of the DoG magnitude in the sweep, beside those of the design.
const DOG_BITS: [u32; 7] = [10, 11, 12, 13, 14, 15, 16];
/// Bits of the pixel among the alternatives, if the camera has as many.
const PIXEL_BITS: [i8; 4] = [8, 10, 12, 14];

/// The sweep of one format.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sweep {
    /// The format that is varied: `state`, `coefficients` or `DoG`.
    pub parameter: &'static str,
    /// Bits at the design point.
    pub chosen: f64,
    /// One entry for each word length and each condition under which a picture is fit to judge it.
    pub points: Vec<SweepPoint>,
}

/// One word length under one condition: the worst picture of each measure, of those that are fit to judge it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepPoint {
    /// Word length, bits.
    pub bits: f64,
    /// Name of the condition.
    pub condition: &'static str,
    /// Root mean square of the DoG error, LSB of `kt27`, on the worst picture and scale.
    pub dog_rms_lsb: f64,
    /// MaxLBP bits flipped, percent, on the worst picture.
    pub maxlbp_flips_percent: f64,
    /// Sign bits flipped, percent, on the worst picture.
    pub sign_flips_percent: f64,
    /// Features not at the same pixel, percent, on the worst picture and scale.
    pub moved_percent: f64,
    /// Verilog can be emitted for the design with it.
    pub buildable: bool,
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
    /// Verilog can be emitted for the design with it.
    pub buildable: bool,
    /// True on the Pareto front: it can be built, and no other that can be built is better in error or resources and no
    /// worse in the rest.
    pub front: bool,
    /// Root mean square of the DoG error, LSB of `kt27`, on the worst picture and scale.
    pub dog_rms_lsb: f64,
    /// MaxLBP bits flipped, percent, on the worst picture.
    pub maxlbp_flips_percent: f64,
    /// Features not at the same pixel, percent, on the worst picture and scale.
    pub moved_percent: f64,
    /// Resources by the memory model.
    #[serde(flatten)]
    pub resources: Resources,
}

/// Returns every word length of the sweeps once, with its error under the worst condition, and marks the Pareto front.
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
                    buildable: point.buildable,
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
    let built = || costs.iter().filter(|cost| cost.buildable);
    let front: Vec<bool> =
        costs.iter().map(|cost| cost.buildable && !built().any(|other| dominates(other, cost))).collect();
    costs.iter_mut().zip(front).for_each(|(cost, front)| cost.front = front);
    costs
}

/// Another choice for one word, with every other word as in the design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alternative {
    /// The word: `state`, `coefficients`, `DoG`, `look-ahead` or `pixel`.
    pub word: &'static str,
    /// Its value, as in a design file.
    pub value: String,
    /// It is the value of the design.
    pub chosen: bool,
    /// The changes that make it of the design, `KEY=VALUE` each, in the order in which `--config` takes them.
    pub changes: Vec<String>,
    /// The report of this choice as a command. Empty for the design itself.
    pub command: String,
    /// It passes every check of its report on every picture that is fit to judge it. `rtl` is not checked.
    pub pass: bool,
    /// Why no Verilog can be emitted for it; `None` if it can.
    pub unbuildable: Option<String>,
    /// The check that is closest to its limit, or furthest beyond it.
    pub worst: Option<CheckOutcome>,
    /// Percentage of the allowance that it leaves; negative if it fails.
    pub margin: Option<f64>,
    /// Resources by the memory model.
    #[serde(flatten)]
    pub resources: Resources,
}

/// A value of a word: its bits for the plots, and the design with it.
struct Variant {
    word: &'static str,
    bits: f64,
    value: String,
    chosen: bool,
    design: DesignPoint,
    /// Why no Verilog can be emitted for it; `None` if it can.
    unbuildable: Option<String>,
    /// `None` if the word has too few bits for valid coefficients.
    levels: Option<Levels>,
    /// The checks that need no picture.
    checks: Vec<Check>,
}

impl Variant {
    fn new(word: &'static str, bits: f64, value: String, design: DesignPoint, base: &DesignPoint) -> Self {
        let levels = Levels::new(&design).ok();
        let checks = levels.as_ref().map(|levels| check_coefficients(levels, Bounds::acceptance())).unwrap_or_default();
        let unbuildable = design.check_buildable().err().map(|error| error.to_string());
        Self { word, bits, value, chosen: design == *base, design, unbuildable, levels, checks }
    }

    /// Returns `true` if the value is measured on pictures. One with its own `streaming` is not if a check that needs
    /// no picture fails.
    fn is_measured(&self) -> bool {
        self.levels.is_some() && (!self.has_own_streaming() || self.checks.iter().all(|check| check.pass))
    }

    /// Returns `true` if `streaming` differs from that of the design: another look-ahead is another filter, and a
    /// camera of fewer bits is another picture. Word lengths leave it as it is.
    fn has_own_streaming(&self) -> bool {
        !self.chosen && [LOOK_AHEAD, PIXELS].contains(&self.word)
    }

    /// Returns `true` if the value is drawn as a sweep.
    fn is_swept(&self) -> bool {
        self.levels.is_some() && ![LOOK_AHEAD, PIXELS].contains(&self.word)
    }
}

const LOOK_AHEAD: &str = "look-ahead";
const PIXELS: &str = "pixel";

/// Returns the values of every word. That of the design is among them, once for each word.
fn variants(design: &DesignPoint) -> Vec<Variant> {
    let integer = design.pixel.integer_bits();
    let mut variants = Vec::new();
    let mut add = |word, bits, value: String, changed: DesignPoint| {
        variants.push(Variant::new(word, bits, value, changed, design));
    };
    let own = design.state.fraction_bits();
    for fraction in (own - 2).max(0)..=own + 2 {
        let state = Format::unsigned(integer, fraction);
        add("state", f64::from(state.bits()), state.to_string(), DesignPoint { state, ..design.clone() });
    }
    let coefficients: BTreeSet<i8> =
        COEFFICIENT_FRACTION_BITS.into_iter().chain([design.coefficient.fraction_bits()]).collect();
    for fraction in coefficients {
        let coefficient = Format::unsigned(0, fraction);
        let changed = DesignPoint { coefficient, ..design.clone() };
        add("coefficients", f64::from(fraction), coefficient.to_string(), changed);
    }
    for bits in DOG_BITS.into_iter().chain([design.dog_bits]).collect::<BTreeSet<u32>>() {
        add("DoG", f64::from(bits), bits.to_string(), with_dog_bits(design, bits));
    }
    let look_ahead = |m: Vec<u32>| (format!("{m:?}"), DesignPoint { look_ahead: m, ..design.clone() });
    for smoother in 0..design.smoothers() {
        let mut m = design.look_ahead.to_vec();
        m[smoother] -= 1;
        if m[smoother] > 0 {
            let (value, changed) = look_ahead(m);
            add(LOOK_AHEAD, 0.0, value, changed);
        }
    }
    let (value, changed) = look_ahead(design.look_ahead.to_vec());
    add(LOOK_AHEAD, 0.0, value, changed);
    for bits in PIXEL_BITS.into_iter().filter(|bits| *bits < integer).chain([integer]) {
        let pixel = Format::unsigned(bits, 0);
        // The state keeps its LSB in DN, so that the pixel alone changes.
        let state = Format::unsigned(bits, own + integer - bits);
        add(PIXELS, f64::from(bits), pixel.to_string(), DesignPoint { pixel, state, ..design.clone() });
    }
    variants
}

/// Returns `base` with another number of DoG bits. The initial threshold keeps its value in DN.
pub fn with_dog_bits(base: &DesignPoint, bits: u32) -> DesignPoint {
    let scaled = f64::from(base.threshold.initial) * 2f64.powi(bits as i32 - base.dog_bits as i32);
    let full_scale = f64::from((1u32 << bits) - 1);
    let initial = scaled.round().clamp(1.0, full_scale) as u32;
    DesignPoint { dog_bits: bits, threshold: AutomaticThreshold { initial, ..base.threshold }, ..base.clone() }
}

/// Returns the number of progress steps of [`Bench::run`] for each picture: each value that is measured, on frames and
/// on motions.
pub(crate) fn steps(design: &DesignPoint) -> usize {
    let variants = variants(design);
    2 * (0..variants.len()).filter(|&i| variants[i].is_measured() && measured_as(&variants, i) == i).count()
}

/// Returns the index of the variant that is measured for a variant: the design itself is a value of every word, and is
/// measured once.
fn measured_as(variants: &[Variant], index: usize) -> usize {
    let chosen = variants.iter().position(|variant| variant.chosen);
    chosen.filter(|_| variants[index].chosen).unwrap_or(index)
}

/// The worst picture and scale of each measure, as the checks take them.
#[derive(Debug, Clone, Copy)]
struct Worst {
    dog_rms_lsb: f64,
    maxlbp_flips_percent: f64,
    sign_flips_percent: f64,
    moved_percent: f64,
}

/// One subject under one condition, and the comparison of every variant that is measured on it.
type OnFrame = (Condition, String, Vec<Option<Comparison>>);

/// What the alternatives are measured on and compared with.
pub(crate) struct Bench<'a> {
    /// The design that they are alternatives to.
    pub design: &'a DesignPoint,
    /// The pictures.
    pub subjects: &'a [Subject],
    /// The known motions of each picture, with the `streaming` of the design.
    pub motions: &'a [Motions],
    /// Returns the command of the report with some changes.
    pub command: &'a (dyn Fn(&[String]) -> String + Sync),
    /// Called after each progress step.
    pub step: &'a (dyn Fn(&str) + Sync),
}

impl Bench<'_> {
    /// Measures the sweeps, and the alternatives to each word.
    pub(crate) fn run(&self) -> Result<(Vec<Sweep>, Vec<Alternative>), CoefficientError> {
        let variants = variants(self.design);
        let frames = self.compare(&variants)?;
        let checks: Vec<Vec<CheckOutcome>> = variants
            .par_iter()
            .enumerate()
            .map(|(index, variant)| {
                if measured_as(&variants, index) != index {
                    return Vec::new();
                }
                self.checks(variant, checks_on_frames(variant, index, &frames))
            })
            .collect();
        let alternative = |(index, variant)| self.alternative(variant, &checks[measured_as(&variants, index)]);
        let mut alternatives: Vec<Alternative> = variants.iter().enumerate().map(alternative).collect();
        // What passes comes first, the cheapest at the top; then what fails, the closest to its limit first.
        alternatives.sort_by(|a, b| {
            let used = |of: &Alternative| of.worst.as_ref().filter(|_| !of.pass).map_or(0.0, |worst| worst.used);
            b.pass.cmp(&a.pass).then(used(a).total_cmp(&used(b))).then(a.price().cmp(&b.price()))
        });
        Ok((sweeps(&variants, &frames), alternatives))
    }

    /// Compares every variant with `streaming`, on every picture under every condition.
    fn compare(&self, variants: &[Variant]) -> Result<Vec<OnFrame>, CoefficientError> {
        let (exact, bounds) = (Levels::new(self.design)?, Bounds::acceptance());
        // `streaming` is computed once for all word lengths, so pictures and conditions are the outer loop. It is
        // sequential, because frames in parallel would multiply the memory.
        let jobs: Vec<(&Subject, Condition)> =
            self.subjects.iter().flat_map(|subject| CONDITIONS.map(|condition| (subject, condition))).collect();
        let on_frame = |(subject, condition): &(&Subject, Condition)| {
            let frame = condition.apply(&subject.frame, bounds.seeds.of(condition));
            let reference = Reference::of(exact.planes(Level::Streaming, &frame), bounds);
            let compare = |(index, variant): (usize, &Variant)| {
                let is_measured = variant.is_measured() && measured_as(variants, index) == index;
                let levels = variant.levels.as_ref().filter(|_| is_measured)?;
                if *condition == CONDITIONS[0] {
                    (self.step)(&format!("{}, word lengths", subject.name));
                }
                let own =
                    variant.has_own_streaming().then(|| Reference::of(levels.planes(Level::Streaming, &frame), bounds));
                let mut compared = own.as_ref().unwrap_or(&reference).compare_bit_true(levels, &frame, bounds)?;
                // No table of the alternatives has single features, and all pictures are kept to the end.
                compared.scales.iter_mut().for_each(|scale| scale.kept.fates = Vec::new());
                Some(compared)
            };
            let place = format!("{}, {}", subject.name, condition.name);
            (*condition, place, variants.par_iter().enumerate().map(compare).collect())
        };
        Ok(jobs.iter().map(on_frame).collect())
    }

    /// Returns the checks of the report of a variant. The known motions take the longest, so they are estimated only if
    /// all other checks pass.
    fn checks(&self, variant: &Variant, mut checks: Vec<CheckOutcome>) -> Vec<CheckOutcome> {
        let bounds = Bounds::acceptance();
        let measured = variant.levels.as_ref().filter(|_| variant.is_measured());
        for (subject, motions) in self.subjects.iter().zip(self.motions) {
            if let Some(levels) = measured.filter(|_| checks.iter().all(|check| check.pass)) {
                let is_own =
                    variant.has_own_streaming() || threshold_step(&variant.design) != threshold_step(self.design);
                let own = is_own.then(|| motions.with_streaming_of(levels, bounds));
                let motions = own.as_ref().unwrap_or(motions);
                if motions.unfit(bounds).is_none() {
                    let place = format!("{}, {}", subject.name, NOMINAL.name);
                    let of_motions = displacement::check(&motions.displacements(levels), bounds);
                    checks.extend(of_motions.iter().map(|check| CheckOutcome::new(check, Some(&place))));
                }
            }
            if measured.is_some() {
                (self.step)(&format!("{}, displacement with other words", subject.name));
            }
        }
        // A variant with its own `streaming` can find too few features where the design finds enough.
        if measured.is_some() && checks.len() == variant.checks.len() {
            checks.push(CheckOutcome::unmeasurable("fit pictures", "no picture is fit to judge it".into()));
        }
        checks
    }

    /// Judges a variant by the checks of its report.
    fn alternative(&self, variant: &Variant, checks: &[CheckOutcome]) -> Alternative {
        let worst =
            checks.iter().max_by(|a, b| (!a.pass, a.used).partial_cmp(&(!b.pass, b.used)).unwrap_or(Ordering::Equal));
        let changes = variant.design.changes_of(self.design);
        Alternative {
            word: variant.word,
            value: variant.value.clone(),
            chosen: variant.chosen,
            command: if variant.chosen { String::new() } else { (self.command)(&changes) },
            changes,
            pass: checks.iter().all(|check| check.pass),
            unbuildable: variant.unbuildable.clone(),
            margin: worst.map(|worst| 100.0 * (1.0 - worst.used)),
            worst: worst.cloned(),
            resources: resources(&variant.design),
        }
    }
}

impl Alternative {
    /// Returns the resources by which alternatives are compared, the scarcest first.
    fn price(&self) -> [u64; 3] {
        let Resources { m10k, alm, dsp, .. } = self.resources;
        [m10k, alm, dsp]
    }
}

/// Returns the cheapest alternative that passes, can be built and costs less than the design. The pixel is not among
/// them: it is the camera's, and what a camera of fewer bits loses is in no check.
pub fn cheapest(alternatives: &[Alternative]) -> Option<&Alternative> {
    let design = alternatives.iter().find(|alternative| alternative.chosen)?;
    let is_choice = |of: &&Alternative| of.word != PIXELS && of.pass && of.unbuildable.is_none();
    let choices = alternatives.iter().filter(is_choice).filter(|of| of.price() < design.price());
    choices.min_by_key(|alternative| alternative.price())
}

/// Returns the checks of a variant that need no motion: of its coefficients, and on each frame that is fit to judge it.
fn checks_on_frames(variant: &Variant, index: usize, frames: &[OnFrame]) -> Vec<CheckOutcome> {
    let bounds = Bounds::acceptance();
    let mut checks: Vec<CheckOutcome> = variant.checks.iter().map(|check| CheckOutcome::new(check, None)).collect();
    for (_, place, all) in frames {
        let of_frame = fit(all, index).map(|comparison| comparison.check(bounds)).unwrap_or_default();
        checks.extend(of_frame.iter().map(|check| CheckOutcome::new(check, Some(place))));
    }
    if variant.levels.is_none() {
        let reason = "a coefficient rounds to 0 or to 1".to_owned();
        checks.push(CheckOutcome::unmeasurable("valid coefficients", reason));
    }
    checks
}

/// Returns the comparison of a variant on a frame; `None` if it was not measured or the frame is unfit to judge it.
fn fit(all: &[Option<Comparison>], index: usize) -> Option<&Comparison> {
    all[index].as_ref().filter(|comparison| comparison.unfit(Bounds::acceptance()).is_none())
}

/// Returns the sweep of each word that is drawn.
fn sweeps(variants: &[Variant], frames: &[OnFrame]) -> Vec<Sweep> {
    let mut sweeps: Vec<Sweep> = Vec::new();
    for (index, variant) in variants.iter().enumerate().filter(|(_, variant)| variant.is_swept()) {
        if sweeps.last().is_none_or(|sweep| sweep.parameter != variant.word) {
            let own = variants.iter().find(|own| own.word == variant.word && own.chosen);
            let chosen = own.map_or(f64::NAN, |own| own.bits);
            sweeps.push(Sweep { parameter: variant.word, chosen, points: Vec::new() });
        }
        let measured = measured_as(variants, index);
        let point = |condition: Condition| {
            let of_condition = frames.iter().filter(|(of, ..)| *of == condition);
            let worst = of_condition.filter_map(|(.., all)| fit(all, measured)).map(Worst::of).reduce(Worst::or)?;
            Some(worst.point(variant, condition.name))
        };
        if let Some(sweep) = sweeps.last_mut() {
            sweep.points.extend(CONDITIONS.into_iter().filter_map(point));
        }
    }
    sweeps
}

impl Worst {
    fn of(comparison: &Comparison) -> Self {
        let of_scales =
            |measure: fn(&ScaleComparison) -> f64| comparison.scales.iter().map(measure).fold(0.0, f64::max);
        Self {
            dog_rms_lsb: of_scales(|scale| scale.interior.rms),
            maxlbp_flips_percent: comparison.flips.percent(BitKind::Maxlbp),
            sign_flips_percent: comparison.flips.percent(BitKind::Sign),
            moved_percent: of_scales(|scale| 100.0 - scale.kept.same_pixel_percent),
        }
    }

    fn or(self, other: Self) -> Self {
        Self {
            dog_rms_lsb: self.dog_rms_lsb.max(other.dog_rms_lsb),
            maxlbp_flips_percent: self.maxlbp_flips_percent.max(other.maxlbp_flips_percent),
            sign_flips_percent: self.sign_flips_percent.max(other.sign_flips_percent),
            moved_percent: self.moved_percent.max(other.moved_percent),
        }
    }

    fn point(self, variant: &Variant, condition: &'static str) -> SweepPoint {
        let Self { dog_rms_lsb, maxlbp_flips_percent, sign_flips_percent, moved_percent } = self;
        SweepPoint {
            bits: variant.bits,
            condition,
            dog_rms_lsb,
            maxlbp_flips_percent,
            sign_flips_percent,
            moved_percent,
            buildable: variant.unbuildable.is_none(),
            resources: resources(&variant.design),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    #[test]
    fn the_initial_threshold_keeps_its_value_in_dn() {
        for bits in [6, 12, 15] {
            let design = with_dog_bits(&KT27, bits);
            assert_eq!(f64::from(design.threshold.initial) * design.dog().lsb(), 1024.0, "{bits}");
        }
    }

    #[test]
    fn the_changes_of_a_variant_make_it_of_the_design() {
        for design in [KT27.clone(), DesignPoint::shipped("three_scales").unwrap()] {
            for variant in variants(&design) {
                let changes = variant.design.changes_of(&design);
                assert_eq!(changes.is_empty(), variant.chosen, "{} {}", variant.word, variant.value);
                let changed = design.with_overrides(changes.iter().map(String::as_str));
                assert_eq!(changed.unwrap(), variant.design, "{changes:?}");
            }
        }
    }
}
