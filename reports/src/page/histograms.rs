//! The histograms of the DoG error, one per model level.

use std::collections::BTreeMap;

use super::numbers::grouped;
use crate::plot::{Axis, BLUE, Chart, Mark, ORANGE, PlotError, Series};
use crate::study::{Kind, Measurement, Stage, Study};

/// Plots for each level the DoG error of both scales over all pictures and conditions, as percent of the samples.
pub(super) fn plots(study: &Study) -> Result<Vec<String>, PlotError> {
    let mut plots = Vec::new();
    for level in &study.levels {
        let dogs: Vec<&Measurement> = level.measurements.iter().filter(|m| matches!(m.stage, Stage::Dog(_))).collect();
        let Some(width) = dogs.iter().map(|m| m.error.histogram.bin_lsb).reduce(f64::max) else { continue };
        let mut bins: BTreeMap<i64, u64> = BTreeMap::new();
        for m in &dogs {
            for (centre, count) in m.error.histogram.centres().zip(&m.error.histogram.counts) {
                *bins.entry((centre / width).round() as i64).or_default() += count;
            }
        }
        let total: u64 = bins.values().sum();
        let share = |count: u64| 100.0 * count as f64 / total.max(1) as f64;
        let reach = bins.iter().filter(|(_, count)| **count > 0).map(|(bin, _)| bin.abs()).max().unwrap_or(1).max(3);
        let points = bins.iter().filter(|(_, count)| **count > 0);
        let points = points.map(|(bin, count)| (*bin as f64 * width, share(*count))).collect();
        let kind = dogs.first().map(|m| m.kind);
        let (against, colour) = match kind {
            Some(Kind::Approximation) => ("ideal", ORANGE),
            _ => ("streaming", BLUE),
        };
        let edge = (reach as f64 + 0.6) * width;
        let chart = Chart {
            title: format!("{} against {against}, bin width {} LSB", level.name, grouped(width as u64)),
            size: (460, 250),
            x: Axis::linear("DoG error, LSB", -edge, edge),
            y: Axis::log("samples, %", 1e-6, 100.0),
            series: vec![Series { name: String::new(), colour, mark: Mark::Bars(0.86 * width), points }],
            rules: Vec::new(),
        };
        plots.push(chart.svg()?);
    }
    Ok(plots)
}
