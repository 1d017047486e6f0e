//! The plot of the error after each stage of the smoothers.

use crate::plot::{Axis, BLUE, Chart, GREEN, Mark, ORANGE, PlotError, Series, VIOLET};
use crate::study::Chain;

/// Plots one curve for each smoother: the rms error after each stage.
pub(super) fn plot(chains: &[Chain]) -> Result<String, PlotError> {
    chart(chains).svg()
}

/// Curves share the horizontal axis by stage name: smoothers of different look-ahead have different stages, and a curve
/// has no point at a stage that its smoother does not have.
fn chart(chains: &[Chain]) -> Chart {
    let stages = stages(chains);
    let position = |name: &str| stages.iter().position(|stage| *stage == name).map(|index| index as f64 + 1.0);
    let ticks = stages.iter().enumerate().map(|(index, stage)| (index as f64 + 1.0, short(stage))).collect();
    let top = chains.iter().flat_map(|chain| &chain.stages).map(|stage| stage.rms_lsb).fold(0.5, f64::max);
    let series = chains.iter().zip([BLUE, VIOLET, ORANGE, GREEN]).map(|(chain, colour)| Series {
        name: format!("σ {} px", chain.sigma),
        colour,
        mark: Mark::LineDots,
        points: chain.stages.iter().filter_map(|stage| Some((position(&stage.name)?, stage.rms_lsb))).collect(),
    });
    Chart {
        title: String::new(),
        size: (1040, 270),
        x: Axis::ticked(
            "stage: rec = recursion, cla j = column_look_ahead_j, rlb j = row_look_back_j, rla j = row_look_ahead_j",
            0.5,
            stages.len().max(1) as f64 + 0.5,
            ticks,
        ),
        y: Axis::linear("rms error, state LSB", 0.0, 1.1 * top),
        series: series.collect(),
        rules: Vec::new(),
    }
}

/// Returns the names of all stages of all chains, each once, in the order of the data.
fn stages(chains: &[Chain]) -> Vec<&str> {
    let mut all: Vec<&str> = Vec::new();
    for chain in chains {
        let mut next = 0;
        for stage in &chain.stages {
            next = match all.iter().position(|name| *name == stage.name) {
                Some(index) => index + 1,
                None => {
                    all.insert(next, &stage.name);
                    next + 1
                }
            };
        }
    }
    all
}

/// Returns the tick label of a stage name.
fn short(stage: &str) -> String {
    [("recursion", "rec"), ("column_look_ahead_", "cla "), ("row_look_back_", "rlb "), ("row_look_ahead_", "rla ")]
        .into_iter()
        .find_map(|(name, short)| Some(format!("{short}{}", stage.strip_prefix(name)?)))
        .unwrap_or_else(|| stage.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::ChainStage;
    use hoverlock_fixed_point::model::stages::Stage;
    use plotters::coord::ranged1d::ValueFormatter as _;

    /// Returns a different value for each stage name.
    fn rms(stage: Stage) -> f64 {
        match stage {
            Stage::Recursion => 1.0,
            Stage::ColumnLookAhead(j) => 2.0 + f64::from(j) / 16.0,
            Stage::RowLookBack(j) => 3.0 + f64::from(j) / 16.0,
            Stage::RowLookAhead(j) => 4.0 + f64::from(j) / 16.0,
        }
    }

    #[test]
    fn every_point_stands_over_the_label_of_its_stage() {
        let look_aheads = [5, 7, 6, 4];
        let chains = look_aheads.map(|look_ahead| Chain {
            sigma: f64::from(look_ahead),
            stages: Stage::chain(look_ahead)
                .map(|stage| ChainStage { name: stage.to_string(), rms_lsb: rms(stage) })
                .collect(),
        });
        let chart = chart(&chains);
        assert_eq!(chart.series.len(), look_aheads.len());
        for (series, look_ahead) in chart.series.iter().zip(look_aheads) {
            let stages: Vec<Stage> = Stage::chain(look_ahead).collect();
            assert_eq!(series.points.len(), stages.len());
            for (&(x, y), stage) in series.points.iter().zip(stages) {
                assert_eq!((chart.x.format_ext(&x), y), (short(&stage.to_string()), rms(stage)));
            }
        }
        // The axis has the stages of the longest chain, in the order of the data.
        let labels: Vec<String> = (1..=1 + 3 * 7).map(|x| chart.x.format_ext(&f64::from(x))).collect();
        assert_eq!(labels, Stage::chain(7).map(|stage| short(&stage.to_string())).collect::<Vec<_>>());
        assert_eq!([&labels[0], &labels[7], &labels[14], &labels[21]], ["cla 6", "rec", "rlb 6", "rla 6"]);
    }
}
