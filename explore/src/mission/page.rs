//! The page of a search: centimetres against memory, and the verdicts of both bounds.

use hoverlock_reports::page::{PageError, SCRIPT, STYLE, environment, value};
use hoverlock_reports::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, RED, Rule, Series, VIOLET};
use hoverlock_reports::provenance::COMMIT;
use minijinja::context;
use serde::Serialize;

use super::{Flown, Mission, MissionPoint, Stage};
use crate::output::{BEST, NUMBERS, TABLE};

const TEMPLATE: &str = include_str!("../../templates/mission.html");

/// Renders the page as one HTML file, with style and plots inside it.
///
/// # Errors
/// A plot or the template fails. Either is a defect of this program, not of the input.
pub fn html(mission: &Mission, command: &str) -> Result<String, PageError> {
    let mut environment = environment();
    environment.add_template("mission.html", TEMPLATE)?;
    let mut points: Vec<&MissionPoint> = mission.points.iter().collect();
    points.sort_by_key(|point| (point.resources.m10k, point.resources.dsp, point.resources.alm));
    let alone: Vec<&MissionPoint> =
        mission.points.iter().filter(|point| matches!(point.stage, Stage::Base | Stage::Alone)).collect();
    let count = |status: Flown| mission.points.iter().filter(|point| point.status == status).count();
    Ok(environment.get_template("mission.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        commit => COMMIT,
        command => command,
        mission => value(mission),
        budget_cm => 100.0 * mission.budget.rms_m,
        best => value(mission.best()),
        base => value(mission.base()),
        both => value(mission.best_of_both()),
        binding => mission.binding_in_words(),
        flights => mission.flown + mission.restored,
        plan_flights => mission.plan.rounds.iter().map(Vec::len).sum::<usize>(),
        keeping => count(Flown::Keeps),
        failing => count(Flown::Fails),
        open => count(Flown::Open),
        points => value(points),
        alone => value(alone),
        words => value(words(mission)),
        short => chart(mission, "Short flight: cm rms from the target, against memory", &|point| point.short_cm)?,
        worst => chart(mission, "All flights flown: the furthest, cm rms, against memory", &|point| point.worst_cm)?,
        numbers => NUMBERS,
        table => TABLE,
        design => BEST,
    })?)
}

/// A key of the design: its value in the base, in the best design, and in the best one that both bounds allow.
#[derive(Serialize)]
struct Word {
    name: &'static str,
    values: Vec<String>,
}

fn words(mission: &Mission) -> Vec<Word> {
    let (Some(base), Some(best)) = (mission.base(), mission.best()) else { return Vec::new() };
    let both = mission.best_of_both().unwrap_or(base);
    let word = |name, of: &dyn Fn(&MissionPoint) -> String| Word { name, values: [base, best, both].map(of).into() };
    vec![
        word("pixel", &|point| point.design.pixel.to_string()),
        word("state", &|point| point.design.state.to_string()),
        word("coefficient", &|point| point.design.coefficient.to_string()),
        word("look_ahead", &|point| format!("{:?}", point.design.look_ahead)),
        word("dog_bits", &|point| point.design.dog_bits.to_string()),
        word("M10K", &|point| point.resources.m10k.to_string()),
        word("DSP blocks", &|point| point.resources.dsp.to_string()),
        word("ALM, about", &|point| point.resources.alm.to_string()),
    ]
}

/// Plots a distance in cm against memory. A distance beyond twice the budget is drawn there.
fn chart(mission: &Mission, title: &str, of: &dyn Fn(&MissionPoint) -> Option<f64>) -> Result<String, PlotError> {
    let budget = 100.0 * mission.budget.rms_m;
    let top = 2.0 * budget;
    let points = |pick: &dyn Fn(&MissionPoint) -> bool| -> Vec<(f64, f64)> {
        let picked = mission.points.iter().filter(|point| pick(point));
        let mut points: Vec<(f64, f64)> =
            picked.filter_map(|point| Some((point.resources.m10k as f64, of(point)?.min(top)))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        points
    };
    let all = points(&|_| true);
    let (least, most) = all.iter().fold((f64::INFINITY, 0.0f64), |(low, high), (x, _)| (low.min(*x), high.max(*x)));
    let room = (0.05 * (most - least)).max(2.0);
    let line = |name: &str, colour, mark, points| Series { name: name.into(), colour, mark, points };
    let same = |one: Option<&MissionPoint>, point: &MissionPoint| one.is_some_and(|one| one.name == point.name);
    let passes = |point: &MissionPoint| point.features.as_ref().map(|features| features.pass);
    let keeps = |verdict: Option<bool>| {
        points(&|point: &MissionPoint| point.status != Flown::Fails && passes(point) == verdict)
    };
    let series = vec![
        line("fails a flight", ORANGE, Mark::Crosses(4), points(&|point| point.status == Flown::Fails)),
        line("keeps the budget, features' checks not made", GREY, Mark::Dots(4), keeps(None)),
        line("keeps the budget, fails the features' checks", VIOLET, Mark::Dots(4), keeps(Some(false))),
        line("keeps the budget, passes the features' checks", BLUE, Mark::Dots(4), keeps(Some(true))),
        line("base", GREEN, Mark::Ring(8), points(&|point| same(mission.base(), point))),
        line("best", RED, Mark::Ring(11), points(&|point| same(mission.best(), point))),
    ];
    Chart {
        title: title.into(),
        size: (540, 380),
        x: Axis::linear("M10K blocks, by the memory model", (least - room).max(0.0), most + room),
        y: Axis::linear("", 0.0, 1.05 * top),
        series: series.into_iter().filter(|series| !series.points.is_empty()).collect(),
        rules: vec![Rule::Limit(budget, format!("budget {budget:.0} cm"))],
    }
    .svg()
}
