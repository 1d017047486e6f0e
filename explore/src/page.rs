//! The page of a search.

use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_reports::page::{PageError, SCRIPT, STYLE, environment, value};
use hoverlock_reports::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, RED, Rule, Series};
use hoverlock_reports::provenance::COMMIT;
use minijinja::context;
use serde::Serialize;

use crate::{Exploration, Objective, Point, Status, output};

const TEMPLATE: &str = include_str!("../templates/explore.html");

/// Renders the page as one HTML file, with style and plots inside it.
///
/// # Errors
/// A plot or the template fails. Either is a defect of this program, not of the input.
pub fn html(exploration: &Exploration, command: &str) -> Result<String, PageError> {
    let mut environment = environment();
    environment.add_template("explore.html", TEMPLATE)?;
    let count = |status: Status| exploration.points.iter().filter(|point| point.status == status).count();
    let mut measured: Vec<&Point> = exploration.points.iter().filter(|point| point.frames > 0).collect();
    measured.sort_by_key(|point| (point.resources.m10k, point.resources.alm));
    let unmeasured: Vec<&Point> = exploration.points.iter().filter(|point| point.frames == 0).collect();
    Ok(environment.get_template("explore.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        commit => COMMIT,
        command => command,
        exploration => value(exploration),
        objective => in_words(exploration.objective),
        best => value(exploration.best()),
        base => value(exploration.base()),
        passing => count(Status::Passes),
        failing => count(Status::Fails),
        open => count(Status::Open),
        refused => unmeasured.iter().filter(|point| point.status == Status::Fails).count(),
        measured => value(measured),
        unmeasured => value(unmeasured),
        words => value(words(exploration)),
        front => front(exploration)?,
        margins => margins(exploration)?,
        numbers => output::NUMBERS,
        table => output::TABLE,
        design => output::BEST,
    })?)
}

fn in_words(objective: Objective) -> &'static str {
    match objective {
        Objective::M10k => "the fewest M10K",
        Objective::Alm => "the fewest ALM",
        Objective::Dsp => "the fewest DSP blocks",
        Objective::Error => "the smallest DoG error that fits the device",
    }
}

/// A word of the design: its value in the base and in the best design.
#[derive(Serialize)]
struct Word {
    name: &'static str,
    base: String,
    best: String,
}

fn words(exploration: &Exploration) -> Vec<Word> {
    let (Some(base), Some(best)) = (exploration.base(), exploration.best()) else { return Vec::new() };
    let (base, best) = (&base.design, &best.design);
    let word = |name, base: String, best: String| Word { name, base, best };
    vec![
        word("state", base.state.to_string(), best.state.to_string()),
        word("coefficient", base.coefficient.to_string(), best.coefficient.to_string()),
        word("dog_bits", base.dog_bits.to_string(), best.dog_bits.to_string()),
        word("look_ahead", format!("{:?}", base.look_ahead), format!("{:?}", best.look_ahead)),
    ]
}

type Pick<'a> = &'a dyn Fn(&Point) -> bool;

/// Plots the DoG error against memory.
fn front(exploration: &Exploration) -> Result<String, PlotError> {
    chart(exploration, "DoG error, LSB rms, against memory", &|point| point.dog_rms_lsb, true)
}

/// Plots the fraction of the allowance that the closest check uses against memory.
fn margins(exploration: &Exploration) -> Result<String, PlotError> {
    let used = |point: &Point| point.worst.as_ref().filter(|_| point.frames > 0).map(|worst| 100.0 * worst.used);
    chart(exploration, "Allowance of the closest check used, %, against memory", &used, false)
}

fn chart(
    exploration: &Exploration,
    title: &str,
    of: &dyn Fn(&Point) -> Option<f64>,
    error: bool,
) -> Result<String, PlotError> {
    let points = |pick: Pick| -> Vec<(f64, f64)> {
        let picked = exploration.points.iter().filter(|point| pick(point));
        let mut points: Vec<(f64, f64)> =
            picked.filter_map(|point| Some((point.resources.m10k as f64, of(point)?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        points
    };
    let line = |name: &str, colour, mark, points| Series { name: name.into(), colour, mark, points };
    let same = |one: Option<&Point>, point: &Point| one.is_some_and(|one| one.name == point.name);
    let all = points(&|_| true);
    let extent = |of: fn(&(f64, f64)) -> f64| {
        all.iter().map(of).fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(value), high.max(value)))
    };
    let ((least, most), (low, high)) = (extent(|point| point.0), extent(|point| point.1));
    let room = (0.05 * (most - least)).max(2.0);
    let limit = if error { Bounds::acceptance().dog.rms_lsb } else { 100.0 };
    let mut series = Vec::new();
    if error {
        series.push(line("front", GREY, Mark::Line, points(&|point| point.front)));
    }
    series.extend([
        line("fails", ORANGE, Mark::Crosses(4), points(&|point| point.status == Status::Fails)),
        line("passes", BLUE, Mark::Dots(4), points(&|point| point.pass)),
        line("base", GREEN, Mark::Ring(8), points(&|point| same(exploration.base(), point))),
        line("best", RED, Mark::Ring(11), points(&|point| same(exploration.best(), point))),
    ]);
    let (low, high) = ((0.8 * low.min(limit)).max(1e-3), (1.25 * high.max(limit)).min(2e3));
    Chart {
        title: title.into(),
        size: (540, 360),
        x: Axis::linear("M10K blocks, by the memory model", least - room, most + room),
        y: Axis::log("", low, high),
        series,
        rules: vec![Rule::Limit(limit, format!("limit {limit}"))],
    }
    .svg()
}
