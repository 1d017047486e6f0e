//! The plots of the word-length sweeps: error against bits, and error against resources.

use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_pictures::conditions::CONDITIONS;

use super::CONDITION_COLOURS;
use crate::plot::{Axis, BLUE, Chart, GREEN, Mark, ORANGE, PlotError, RED, Rule, Series, VIOLET};
use crate::study::Study;
use crate::sweep::{Cost, SweepPoint};

/// Plots one row for each word length: DoG error, bit flips, features moved.
pub(super) fn sweep_plots(study: &Study) -> Result<Vec<String>, PlotError> {
    type Measure = (&'static str, fn(&SweepPoint) -> f64, f64, f64);
    let measures: [Measure; 3] = [
        ("DoG error, LSB rms", |point| point.dog_rms_lsb, 0.1, 100.0),
        ("MaxLBP bits flipped, %", |point| point.maxlbp_flips_percent, 1e-3, 10.0),
        ("features not at the same pixel, %", |point| point.moved_percent, 0.1, 100.0),
    ];
    let mut plots = Vec::new();
    // No picture is fit to judge a sweep without points.
    for sweep in study.sweeps.iter().filter(|sweep| !sweep.points.is_empty()) {
        let (least, most) = (
            sweep.points.iter().map(|point| point.bits).fold(f64::INFINITY, f64::min),
            sweep.points.iter().map(|point| point.bits).fold(0.0, f64::max),
        );
        let mut ticks: Vec<(f64, String)> =
            sweep.points.iter().map(|point| (point.bits, point.bits.to_string())).collect();
        ticks.dedup();
        for (row, (label, measure, low, high)) in measures.iter().enumerate() {
            let series = CONDITIONS.iter().zip(CONDITION_COLOURS).map(|(condition, colour)| Series {
                name: condition.name.into(),
                colour,
                mark: Mark::LineDots,
                points: sweep
                    .points
                    .iter()
                    .filter(|point| point.condition == condition.name)
                    .map(|point| (point.bits, measure(point)))
                    .collect(),
            });
            let mut rules = vec![Rule::Choice(sweep.chosen, format!("design point: {}", sweep.chosen))];
            rules.extend(limits(row));
            let chart = Chart {
                title: format!("{}: {label}", sweep.parameter),
                size: (380, 260),
                x: Axis::ticked("bits", least - 0.4, most + 0.4, ticks.clone()),
                y: Axis::log("", *low, *high),
                series: series.collect(),
                rules,
            };
            plots.push(chart.svg()?);
        }
    }
    Ok(plots)
}

/// Returns the limits of a measure (0: DoG error, 1: bit flips, 2: features moved). If the limit depends on the
/// contrast class, these are the strictest and the loosest one.
fn limits(measure: usize) -> Vec<Rule> {
    let bounds = Bounds::acceptance();
    let columns = [&bounds.nominal, &bounds.combined, &bounds.fog];
    let limits: Vec<f64> = match measure {
        0 => vec![bounds.dog.rms_lsb],
        1 => columns.map(|column| column.maxlbp_flips_percent).to_vec(),
        _ => columns.map(|column| 100.0 - column.same_pixel_percent).to_vec(),
    };
    let (least, most) = (limits.iter().copied().fold(f64::MAX, f64::min), limits.iter().copied().fold(0.0, f64::max));
    if least == most {
        return vec![Rule::Limit(least, format!("≤ {least}"))];
    }
    vec![Rule::Limit(least, String::new()), Rule::Limit(most, format!("≤ {least} to {most}, by contrast"))]
}

/// Plots error and bit flips against M10K blocks, and error against multipliers. One dot for each word length; the line
/// is the Pareto front, the ring the design point.
pub(super) fn cost_plots(study: &Study) -> Result<Vec<String>, PlotError> {
    type Measure = fn(&Cost) -> f64;
    let charts: [(&str, &str, Measure, f64, f64, Measure); 3] = [
        ("DoG error, LSB rms", "M10K blocks", |cost| cost.dog_rms_lsb, 0.1, 100.0, |cost| cost.resources.m10k as f64),
        (
            "MaxLBP bits flipped, %",
            "M10K blocks",
            |cost| cost.maxlbp_flips_percent,
            1e-3,
            10.0,
            |cost| cost.resources.m10k as f64,
        ),
        (
            "DoG error, LSB rms",
            "multipliers 18x18",
            |cost| cost.dog_rms_lsb,
            0.1,
            100.0,
            |cost| cost.resources.mul18 as f64,
        ),
    ];
    let mut plots = Vec::new();
    if study.costs.is_empty() {
        return Ok(plots);
    }
    for (measure, (title, label, error, low, high, price)) in [0, 1, 0].into_iter().zip(charts) {
        let points = |keep: &dyn Fn(&Cost) -> bool| {
            let kept = study.costs.iter().filter(|cost| keep(cost));
            let mut points: Vec<(f64, f64)> = kept.map(|cost| (price(cost), error(cost))).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
            points
        };
        // The Pareto front of this plot alone, over what can be built.
        let mut front: Vec<(f64, f64)> = Vec::new();
        for (x, y) in points(&|cost| cost.buildable) {
            if front.last().is_none_or(|last| y < last.1) {
                front.retain(|last| last.0 < x);
                front.push((x, y));
            }
        }
        let parameters = [("state", BLUE), ("coefficients", VIOLET), ("DoG", ORANGE)];
        let mut series = vec![Series { name: "Pareto front".into(), colour: GREEN, mark: Mark::Line, points: front }];
        series.extend(parameters.map(|(name, colour)| Series {
            name: name.into(),
            colour,
            mark: Mark::Dots(4),
            points: points(&|cost| cost.parameter == name && !cost.chosen),
        }));
        let chosen = points(&|cost| cost.chosen);
        series.push(Series { name: "design point".into(), colour: RED, mark: Mark::Ring(6), points: chosen });
        let prices = || study.costs.iter().map(price);
        let (least, most) = (prices().fold(f64::INFINITY, f64::min), prices().fold(0.0, f64::max));
        let room = 0.06 * (most - least).max(1.0);
        let mut kinds: Vec<f64> = prices().collect();
        kinds.sort_by(f64::total_cmp);
        kinds.dedup();
        let x = if kinds.len() > 4 {
            Axis::linear(label, least - room, most + room)
        } else {
            let ticks = kinds.iter().map(|kind| (*kind, kind.to_string())).collect();
            Axis::ticked(label, least - room, most + room, ticks)
        };
        let (y, rules) = (Axis::log("", low, high), limits(measure));
        let chart = Chart { title: title.into(), size: (380, 280), x, y, series, rules };
        plots.push(chart.svg()?);
    }
    Ok(plots)
}
