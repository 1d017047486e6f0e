//! The tables of model levels: what each level changes, and the error of each stage.

use hoverlock_design::SmootherKind;
use hoverlock_fixed_point::analysis::levels::Level;
use serde::Serialize;

use super::numbers::{grouped, significant};
use crate::hardware::StepResult;
use crate::study::{Kind, Measurement, Stage, Study};

/// One model level: what it changes and the worst error it shows.
#[derive(Debug, Serialize)]
pub(super) struct LevelRow<'a> {
    name: Level,
    changes: &'a str,
    against: &'static str,
    result: String,
}

/// One stage of one level: the worst values over all pictures and conditions that are fit to judge a design.
#[derive(Debug, Serialize)]
pub(super) struct ErrorRow<'a> {
    level: Level,
    first_of_level: bool,
    stage: String,
    lsb_dn: f64,
    max: &'a Measurement,
    bias: f64,
    rms: f64,
    sqnr_db: f64,
}

/// Returns one row for each model level.
pub(super) fn rows(study: &Study) -> Vec<LevelRow<'_>> {
    let mut rows = Vec::new();
    for level in &study.levels {
        let dogs = || study.fit_measurements(level.name).filter(|m| matches!(m.stage, Stage::Dog(_)));
        let rms = dogs().map(|m| m.error.rms).fold(0.0, f64::max);
        let kind = dogs().next().map(|m| m.kind);
        let result = match &level.hardware {
            None if kind.is_none() => String::new(),
            None => format!("DoG {} LSB rms", significant(rms, 3)),
            Some(hardware) => match (&hardware.simulation, hardware.totals()) {
                (StepResult::Run { .. }, Some(totals)) => format!(
                    "{} mismatches in {} samples and {} features",
                    grouped(totals.mismatches),
                    grouped(totals.samples),
                    grouped(totals.features)
                ),
                (StepResult::NotRun { reason }, _) => format!("not run: {reason}"),
                _ => String::new(),
            },
        };
        let against = match (level.name, kind) {
            (Level::Rtl, _) => "bit_true",
            (_, Some(Kind::Approximation)) => "ideal",
            (Level::Quantised, _) if study.design.smoother != SmootherKind::FirstOrder => "recursive",
            (_, Some(Kind::Quantisation)) => "streaming",
            (_, None) => "",
        };
        rows.push(LevelRow { name: level.name, changes: &level.changes, against, result });
    }
    rows
}

/// Returns the error of every stage at every level that is measured for this kind of error.
pub(super) fn error_rows(study: &Study, kind: Kind) -> Vec<ErrorRow<'_>> {
    let mut rows = Vec::new();
    for level in &study.levels {
        let mut first_of_level = true;
        for stage in Stage::all(&study.design) {
            let of_stage: Vec<&Measurement> =
                study.fit_measurements(level.name).filter(|m| m.stage == stage && m.kind == kind).collect();
            let worst =
                |size: fn(&Measurement) -> f64| of_stage.iter().copied().max_by(|a, b| size(a).total_cmp(&size(b)));
            let (Some(max), Some(bias), Some(rms), Some(noisy)) = (
                worst(|m| m.error.max.abs()),
                worst(|m| m.error.bias.abs()),
                worst(|m| m.error.rms),
                worst(|m| -m.error.sqnr_db),
            ) else {
                continue;
            };
            rows.push(ErrorRow {
                level: level.name,
                first_of_level,
                stage: stage.name(&study.design),
                lsb_dn: stage.lsb(&study.design),
                max,
                bias: bias.error.bias,
                rms: rms.error.rms,
                sqnr_db: noisy.error.sqnr_db,
            });
            first_of_level = false;
        }
    }
    rows
}
