//! The plot of displacement errors.

use hoverlock_fixed_point::analysis::bounds::Bounds;

use super::numbers::clipped;
use crate::plot::{Axis, BLUE, Chart, GREY, Mark, ORANGE, PlotError, Rule, Series};
use crate::study::Study;

/// Plots, for each picture and motion, the difference between `streaming` and `bit_true`, and the error of each.
pub(super) fn plot(study: &Study) -> Result<String, PlotError> {
    let limits = Bounds::acceptance().displacement;
    let mut series =
        [("bit_true − streaming", BLUE), ("streaming − known motion", GREY), ("bit_true − known motion", ORANGE)]
            .map(|(name, colour)| Series { name: name.into(), colour, mark: Mark::Dots(4), points: Vec::new() });
    let mut ticks = Vec::new();
    for (index, picture) in study.pictures.iter().enumerate() {
        ticks.push((index as f64, clipped(&picture.name, 26)));
        for (motion, displacement) in picture.displacements.iter().enumerate() {
            let x = index as f64 + (motion as f64 - 2.0) * 0.09;
            series[0].points.push((x, displacement.difference_px));
            series[1].points.extend(displacement.reference.iter().map(|found| (x - 0.02, found.error_px)));
            series[2].points.extend(displacement.test.iter().map(|found| (x + 0.02, found.error_px)));
        }
    }
    Chart {
        title: String::new(),
        size: (1040, 270),
        x: Axis::ticked("", -0.5, study.pictures.len() as f64 - 0.5, ticks),
        y: Axis::log("px", 1e-4, 1.0),
        series: series.into(),
        rules: vec![
            Rule::Limit(limits.max_px, format!("largest ≤ {} px", limits.max_px)),
            Rule::Limit(limits.median_px, format!("median ≤ {} px", limits.median_px)),
        ],
    }
    .svg()
}
