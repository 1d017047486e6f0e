//! The page of a campaign of random flights: the Stanford diagram of integrity, availability and NEES by ingredient.

use std::collections::BTreeMap;

use hoverlock_reports::page::{PageError, SCRIPT, STYLE, environment, value};
use hoverlock_reports::plot::{Axis, BLUE, Chart, GREEN, GREY, INK, Mark, ORANGE, PlotError, RED, Series};
use hoverlock_reports::provenance::COMMIT;
use minijinja::context;
use serde::Serialize;

use super::flown_by;
use crate::campaign::random::{FlownFlight, RandomOutcome, Totals, by_group};

const TEMPLATE: &str = include_str!("../../templates/random.html");

/// Ends of both axes of the Stanford diagram, m.
const RANGE_M: [f64; 2] = [1e-3, 30.0];

/// A row of the table of ingredients.
#[derive(Serialize)]
struct Group {
    name: String,
    totals: Totals,
}

impl RandomOutcome {
    /// Renders the campaign as one HTML page. `command` is shown as its origin.
    ///
    /// # Errors
    /// A plot or the template fails. Either is a defect of this program, not of the input.
    pub fn page(&self, command: &str) -> Result<String, PageError> {
        let groups: Vec<Group> =
            by_group(&self.flights).into_iter().map(|(name, totals)| Group { name, totals }).collect();
        let failed: Vec<&FlownFlight> = self.flights.iter().filter(|flight| flight.misleading > 0).collect();
        let mut environment = environment();
        environment.add_template("random.html", TEMPLATE)?;
        Ok(environment.get_template("random.html")?.render(context! {
            style => STYLE,
            script => SCRIPT,
            commit => COMMIT,
            command => command,
            commits => flown_by(self.flights.iter().map(|flight| flight.commit.as_str())),
            totals => value(self.totals),
            seed => self.flights.first().map(|flight| flight.seed),
            failed => value(failed),
            stanford => stanford(&self.flights)?,
            by_flight => availability(&self.flights)?,
            nees => nees(&groups)?,
            groups => value(&groups),
            flights => value(&self.flights),
        })?)
    }
}

/// Plots the protection level of all estimates against their errors; what is below the diagonal is misleading.
fn stanford(flights: &[FlownFlight]) -> Result<String, PlotError> {
    let mut cells: BTreeMap<(u64, u64), (f64, f64, usize)> = BTreeMap::new();
    for (error, level, frames) in flights.iter().flat_map(FlownFlight::cells) {
        cells.entry((error.to_bits(), level.to_bits())).or_insert((error, level, 0)).2 += frames;
    }
    let of = |min: usize, max: usize| -> Vec<(f64, f64)> {
        let own = cells.values().filter(|cell| (min..max).contains(&cell.2));
        own.map(|&(error, level, _)| (error, level)).collect()
    };
    // A cell on the diagonal has estimates of both kinds; the flights' own counts say which.
    let below: Vec<(f64, f64)> =
        cells.values().filter(|cell| cell.0 > cell.1).map(|&(error, level, _)| (error, level)).collect();
    let [min, max] = RANGE_M;
    let dots = |name: &str, colour, mark, points| Series { name: name.into(), colour, mark, points };
    Chart {
        title: "Protection level, m, against error of the estimate".into(),
        size: (540, 460),
        x: Axis::log("error, m", min, max),
        y: Axis::log("", min, max),
        series: vec![
            dots("1 to 9", GREY, Mark::Dots(2), of(1, 10)),
            dots("10 to 99", ORANGE, Mark::Dots(3), of(10, 100)),
            dots("100 estimates and more", BLUE, Mark::Dots(4), of(100, usize::MAX)),
            dots("misleading", RED, Mark::Ring(6), below),
            dots("error = level", INK, Mark::Line, vec![(min, min), (max, max)]),
        ],
        rules: Vec::new(),
    }
    .svg()
}

/// Plots the availability of each flight.
fn availability(flights: &[FlownFlight]) -> Result<String, PlotError> {
    let last = flights.iter().map(|flight| flight.number).max().unwrap_or(1);
    let of = |is_misleading: bool| -> Vec<(f64, f64)> {
        let own = flights.iter().filter(|flight| (flight.misleading > 0) == is_misleading);
        own.filter_map(|flight| Some((f64::from(flight.number), 100.0 * flight.availability()?))).collect()
    };
    let dots = |name: &str, colour, points| Series { name: name.into(), colour, mark: Mark::Dots(3), points };
    Chart {
        title: "Frames with an estimate, %, of each flight".into(),
        size: (540, 460),
        x: Axis::linear("flight", 0.0, f64::from(last) + 1.0),
        y: Axis::linear("", 0.0, 105.0),
        series: vec![dots("no misleading frame", GREEN, of(false)), dots("misleading", RED, of(true))],
        rules: Vec::new(),
    }
    .svg()
}

/// Plots the mean NEES of each group of ingredients.
fn nees(groups: &[Group]) -> Result<String, PlotError> {
    let points: Vec<(f64, f64)> =
        groups.iter().enumerate().map(|(i, group)| (i as f64 + 1.0, group.totals.nees)).collect();
    let most = points.iter().map(|point| point.1).fold(5.0, f64::max);
    let line = |name: &str, at: f64| Series {
        name: name.into(),
        colour: GREEN,
        mark: Mark::Line,
        points: vec![(0.0, at), (groups.len() as f64 + 1.0, at)],
    };
    Chart {
        title: "Mean NEES of each ingredient, in the order of the table; 2 is expected".into(),
        size: (1100, 300),
        x: Axis::linear("row of the table", 0.0, groups.len() as f64 + 1.0),
        y: Axis::log("", 0.05, 1.5 * most),
        series: vec![
            line("1 and 4", 1.0),
            line("", 4.0),
            Series { name: "mean NEES".into(), colour: BLUE, mark: Mark::Dots(4), points },
        ],
        rules: Vec::new(),
    }
    .svg()
}
