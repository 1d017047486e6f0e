//! The files of a search: HTML page, JSON, CSV table, and the best design as a design file.

use hoverlock_design::DesignPoint;
use hoverlock_reports::provenance::COMMIT;
use serde::Serialize;

pub use crate::page::html;
use crate::{Exploration, Point, Status};

/// File name of the JSON file.
pub const NUMBERS: &str = "explore.json";
/// File name of the table.
pub const TABLE: &str = "points.csv";
/// File name of the best design.
pub const BEST: &str = "best.toml";

/// The content of the JSON file.
#[derive(Serialize)]
struct Numbers<'a> {
    commit: &'static str,
    command: &'a str,
    best: Option<&'a Point>,
    base: Option<&'a Point>,
    pareto: Vec<&'a Point>,
    #[serde(flatten)]
    exploration: &'a Exploration,
}

/// Returns the search as JSON. `best` and `base` are points; `pareto` is the Pareto front, cheapest first.
///
/// # Errors
/// The search cannot be written as JSON.
pub fn json(exploration: &Exploration, command: &str) -> Result<String, serde_json::Error> {
    let mut pareto: Vec<&Point> = exploration.points.iter().filter(|point| point.front).collect();
    pareto.sort_by_key(|point| point.resources.m10k);
    let (best, base) = (exploration.best(), exploration.base());
    Ok(serde_json::to_string_pretty(&Numbers { commit: COMMIT, command, best, base, pareto, exploration })? + "\n")
}

/// Returns all points as CSV, the base first.
pub fn csv(exploration: &Exploration) -> String {
    let mut text = String::from(
        "name,pixel,state,coefficient,look_ahead,dog_bits,m10k,alm,dsp,mul18,fits,status,margin_percent,check,measured,\
         limit,unit,dog_rms_lsb,frames,front\n",
    );
    for point in &exploration.points {
        let DesignPoint { pixel, state, coefficient, look_ahead, dog_bits, .. } = &point.design;
        let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        let check = point.failure.as_ref().or(point.worst.as_ref());
        let look_ahead = look_ahead.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        text += &format!(
            "\"{}\",{pixel},{state},{coefficient},{look_ahead},{dog_bits},{},{},{},{},{},{},{},\"{}\",{},{},{},{},{},\
             {}\n",
            point.name,
            point.resources.m10k,
            point.resources.alm,
            point.resources.dsp,
            point.resources.mul18,
            point.fits,
            status(point.status),
            number(point.margin),
            check.map(|check| check.check.as_str()).unwrap_or_default(),
            number(check.and_then(|check| check.measured)),
            number(check.and_then(|check| check.limit)),
            check.map(|check| check.unit.as_str()).unwrap_or_default(),
            number(point.dog_rms_lsb),
            point.frames,
            point.front,
        );
    }
    text
}

/// Returns the name of a status.
fn status(status: Status) -> &'static str {
    match status {
        Status::Passes => "passes",
        Status::Fails => "fails",
        Status::Open => "open",
    }
}

/// Returns the best design as a design file for `--design`; `None` if no design passes.
pub fn best(exploration: &Exploration, command: &str) -> Option<String> {
    let best = exploration.best()?;
    let worst = best.worst.as_ref()?;
    let margin = best.margin.unwrap_or_default();
    let heading = [
        format!("Found by: {command}"),
        format!("Changes: {}", best.name),
        format!(
            "It passes every check of the report on {}. Closest to its limit: {} ({}), {margin:.0} % of the allowance \
             left.",
            exploration.judges.join(", "),
            worst.check,
            worst.place
        ),
        format!(
            "By the memory model {} M10K, {} DSP blocks and about {} ALM.",
            best.resources.m10k, best.resources.dsp, best.resources.alm
        ),
    ];
    Some(best.design.to_file(&heading))
}
