//! The five results at the head of the page.

use hoverlock_fixed_point::analysis::errors::BitKind;
use hoverlock_fixed_point::analysis::levels::Level;
use hoverlock_reference::image::conditions::CONDITIONS;
use serde::Serialize;

use super::numbers::{grouped, significant};
use crate::hardware::Hardware;
use crate::study::{Stage, Study};

/// One result at the head of the page.
#[derive(Debug, Serialize)]
pub(super) struct Tile {
    value: String,
    unit: &'static str,
    what: &'static str,
}

/// Quantisation, approximation, bit flips, displacement and RTL mismatches.
pub(super) fn tiles(study: &Study) -> Vec<Tile> {
    let rms = |level: Level| {
        let of_level = study.levels.iter().filter(|study| study.name == level).flat_map(|study| &study.measurements);
        let dog = of_level.filter(|m| matches!(m.stage, Stage::Dog(_)));
        dog.map(|m| m.error.rms).fold(f64::NAN, f64::max)
    };
    let worst = |name: &str| {
        let rows = study.bounds.iter().filter(|row| row.check.name == name);
        rows.map(|row| row.check.measured).fold(f64::NAN, f64::max)
    };
    let flips = CONDITIONS.map(|c| study.flips_percent(c.name, BitKind::Maxlbp)).into_iter().fold(f64::NAN, f64::max);
    let hardware = match study.hardware().and_then(Hardware::totals) {
        Some(totals) => Tile {
            value: grouped(totals.mismatches),
            unit: "mismatches",
            what: "rtl (simulated Verilog) against bit_true",
        },
        None => Tile { value: "not run".into(), unit: "", what: "rtl was not simulated; section 9 gives the reason" },
    };
    vec![
        Tile {
            value: significant(rms(Level::BitTrue), 2),
            unit: "LSB rms",
            what: "quantisation error of the DoG: bit_true against streaming",
        },
        Tile {
            value: significant(rms(Level::Streaming), 2),
            unit: "LSB rms",
            what: "approximation error of the DoG: streaming against ideal",
        },
        Tile {
            value: significant(flips, 2),
            unit: "%",
            what: "MaxLBP descriptor bits flipped by quantisation, worst condition",
        },
        Tile {
            value: significant(worst("displacement, largest difference"), 2),
            unit: "px",
            what: "largest change of a measured displacement by quantisation",
        },
        hardware,
    ]
}
