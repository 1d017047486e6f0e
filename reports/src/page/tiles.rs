//! The five results at the head of the page, over what is fit to judge a design.

use hoverlock_fixed_point::analysis::errors::BitKind;
use hoverlock_fixed_point::analysis::levels::Level;
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

/// Returns quantisation, approximation, bit flips, displacement and RTL mismatches.
pub(super) fn tiles(study: &Study) -> Vec<Tile> {
    let rms = |level: Level| {
        let dog = study.fit_measurements(level).filter(|m| matches!(m.stage, Stage::Dog(_)));
        dog.map(|m| m.error.rms).fold(f64::NAN, f64::max)
    };
    let worst = |name: &str| {
        let rows = study.bounds.iter().filter(|row| row.check.name == name);
        rows.map(|row| row.check.measured).fold(f64::NAN, f64::max)
    };
    let flips = study.fit_frames().map(|frame| frame.flips.percent(BitKind::Maxlbp)).fold(f64::NAN, f64::max);
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
            value: significant(rms(Level::BitTrue), 3),
            unit: "LSB rms",
            what: "quantisation error of the DoG, bit_true against streaming: the worst picture, condition and scale",
        },
        Tile {
            value: significant(rms(Level::Streaming), 3),
            unit: "LSB rms",
            what: "approximation error of the DoG, streaming against ideal: the worst picture, condition and scale",
        },
        Tile {
            value: significant(flips, 3),
            unit: "%",
            what: "MaxLBP descriptor bits flipped by quantisation: the worst picture and condition",
        },
        Tile {
            value: significant(worst("displacement, largest difference"), 3),
            unit: "px",
            what: "largest change of a measured displacement by quantisation",
        },
        hardware,
    ]
}
