//! The files of a search: HTML page, JSON, CSV table, and the best design as a design file.

use hoverlock_design::DesignPoint;
use hoverlock_reports::provenance::COMMIT;
use serde::Serialize;

pub use super::page::html;
use super::{Flown, Mission, MissionPoint, Stage};

/// The content of the JSON file.
#[derive(Serialize)]
struct Numbers<'a> {
    commit: &'static str,
    command: &'a str,
    best: Option<&'a MissionPoint>,
    base: Option<&'a MissionPoint>,
    best_of_both: Option<&'a MissionPoint>,
    #[serde(flatten)]
    mission: &'a Mission,
}

/// Returns the search as JSON. `best`, `base` and `best_of_both` are points.
///
/// # Errors
/// The search cannot be written as JSON.
pub fn json(mission: &Mission, command: &str) -> Result<String, serde_json::Error> {
    let (best, base, best_of_both) = (mission.best(), mission.base(), mission.best_of_both());
    Ok(serde_json::to_string_pretty(&Numbers { commit: COMMIT, command, best, base, best_of_both, mission })? + "\n")
}

/// Returns all designs as CSV, the base first.
pub fn csv(mission: &Mission) -> String {
    let mut text = String::from(
        "name,pixel,state,coefficient,look_ahead,dog_bits,m10k,alm,dsp,fits,stage,status,flights,short_cm,worst_cm,\
         error_cm,failure,features,check\n",
    );
    for point in &mission.points {
        let DesignPoint { pixel, state, coefficient, look_ahead, dog_bits, .. } = &point.design;
        let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        let look_ahead = look_ahead.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        let features = point.features.as_ref();
        text += &format!(
            "\"{}\",{pixel},{state},{coefficient},{look_ahead},{dog_bits},{},{},{},{},{},{},{},{},{},\
             {},\"{}\",{},\"{}\"\n",
            point.name,
            point.resources.m10k,
            point.resources.alm,
            point.resources.dsp,
            point.fits,
            stage(point.stage),
            status(point.status),
            point.flights,
            number(point.short_cm),
            number(point.worst_cm),
            number(point.error_cm),
            point.failure.as_deref().unwrap_or_default().replace('"', "'"),
            features.map_or("", |features| if features.pass { "passes" } else { "fails" }),
            features.map_or("", |features| &features.check.check),
        );
    }
    text
}

fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Base => "base",
        Stage::Alone => "alone",
        Stage::Together => "together",
        Stage::Step => "step",
    }
}

fn status(status: Flown) -> &'static str {
    match status {
        Flown::Keeps => "keeps",
        Flown::Fails => "fails",
        Flown::Open => "open",
    }
}

/// Returns the best design as a design file for `--design`; `None` if no design keeps the budget.
pub fn best(mission: &Mission, command: &str) -> Option<String> {
    let best = mission.best()?;
    let scenes: Vec<&str> = mission.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let mut heading = vec![
        format!("Found by: {command}"),
        format!("Changes: {}", best.name),
        format!(
            "It keeps within {:.1} cm rms of its target on {} simulated flights over {}; the furthest has {:.1} cm.",
            100.0 * mission.budget.rms_m,
            best.flights,
            scenes.join(", "),
            best.worst_cm.unwrap_or_default()
        ),
        format!(
            "By the memory model {} M10K, {} DSP blocks and about {} ALM.",
            best.resources.m10k, best.resources.dsp, best.resources.alm
        ),
    ];
    heading.extend(mission.binding_in_words().map(|text| format!("{text}.")));
    Some(best.design.to_file(&heading))
}
