//! `hoverlock sweep --random`: a campaign of flights that are drawn at random.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use hoverlock_cosim::BoxError;
use hoverlock_cosim::campaign::random::{
    FlownFlight, RandomFlight, RandomOutcome, RandomProgress, RandomSettings, Totals, by_group, draw_all, fly_campaign,
    shrink,
};
use hoverlock_reports::output::PAGE;

use crate::Verdict;
use crate::output::{Folder, command, print, print_json, say, shown, verdict, write_file};
use crate::progress::{LogLines, Reporter, bar};
use crate::sweep::remark_on_commits;

/// File name of the table.
const TABLE: &str = "flights.csv";

/// Draws the flights, writes their scenario files, and flies those that the table does not have.
pub fn run(settings: &RandomSettings, table: Option<&Path>, out: &Path, json: bool) -> Result<Verdict> {
    let option = if table.is_some() { "--table" } else { "--out" };
    let first = scenario_name(&RandomFlight::draw(settings.seed, 1, settings.seconds));
    let folder = Folder::of(out, "sweep --random", &[PAGE, TABLE, &first])?;
    let drawn = draw_all(settings);
    let table = table.map_or_else(|| out.join(TABLE), Path::to_path_buf);
    let bar = bar(0, "{bar:32} {pos} of {len}  {elapsed}  {msg}");
    let lines = LogLines::new();
    let mut progress = |progress: RandomProgress<'_>| -> Result<(), BoxError> {
        match progress {
            RandomProgress::Started { known, flights } => {
                if known > 0 {
                    say(&format!("{known} of {flights} flights are in {}", shown(&table)));
                }
                for flight in &drawn {
                    write_file(&out.join(scenario_name(flight)), flight.scenario().as_bytes())?;
                }
                bar.set_length((flights - known) as u64);
            }
            RandomProgress::Flown(flight) => {
                let error = flight.error_max_m.unwrap_or_default();
                bar.set_message(format!("flight {}: error {error:.3} m at most", flight.number));
                bar.inc(1);
                lines.count(&bar, "flights");
            }
        }
        Ok(())
    };
    let outcome = fly_campaign(settings, &table, &Reporter, &mut progress)?;
    bar.finish_and_clear();
    write_file(&out.join(PAGE), outcome.page(&command())?.as_bytes())?;
    drop(folder);
    remark_on_commits(outcome.of_other_commits(), outcome.flights.len(), option);
    if json {
        print_json(&outcome)?;
    } else {
        print(&text(&outcome, out, &table))?;
    }
    Ok(outcome.pass.into())
}

/// Shrinks flight `number` and writes the scenario file of what remains.
pub fn run_shrink(settings: &RandomSettings, number: u32, out: &Path, json: bool) -> Result<Verdict> {
    let flight = RandomFlight::draw(settings.seed, number, settings.seconds);
    let name = format!("shrunk-{}", scenario_name(&flight));
    let folder = Folder::of(out, "sweep --shrink", &[&name])?;
    let mut progress = |flight: &RandomFlight, fails: bool| {
        let result = if fails { "fails" } else { "passes" };
        say(&format!("{result}, {} s: {}", flight.seconds, flight.described()));
    };
    let shrunk = shrink(&flight, settings.features, &Reporter, &mut progress)?;
    let file = out.join(name);
    write_file(&file, shrunk.flight.scenario().as_bytes())?;
    drop(folder);
    if json {
        print_json(&shrunk.flown)?;
    } else {
        let (all, kept) = (flight.ingredients.len(), shrunk.flight.ingredients.len());
        let mut text = format!("{kept} of {all} ingredients remain after {} flights\n", shrunk.attempts);
        text += &format!("  {}\n  {}\n{}\n", shrunk.flight.described(), result(&shrunk.flown), shown(&file));
        print(&text)?;
    }
    Ok(Verdict::Fail)
}

/// Returns the name of the scenario file of a flight.
fn scenario_name(flight: &RandomFlight) -> String {
    format!("{}-{:04}.toml", flight.seed, flight.number)
}

/// Describes a flight in half a line.
fn result(flight: &FlownFlight) -> String {
    match flight.error_max_m.zip(flight.worst_ratio) {
        Some((error, ratio)) => format!(
            "error {error:.3} m at most, {ratio:.2} of the protection level, {} misleading of {} frames, \
             {} % answered",
            flight.misleading,
            flight.frames,
            percent(flight.availability())
        ),
        None => "no estimate".to_owned(),
    }
}

/// Returns a share in percent, or a dash.
fn percent(share: Option<f64>) -> String {
    share.map_or("-".to_owned(), |share| format!("{:.1}", 100.0 * share))
}

/// Describes a campaign: totals by ingredient, the flights that fail, and the verdict.
fn text(outcome: &RandomOutcome, out: &Path, table: &Path) -> String {
    let mut text = format!(
        "{:<24} {:>7} {:>10} {:>12} {:>6} {:>9} {:>7}\n",
        "ingredient", "flights", "misleading", "available, %", "NEES", "error, m", "ratio"
    );
    let mut row = |name: &str, totals: &Totals| {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{name:<24} {:>7} {:>10} {:>12} {:>6.2} {:>9.3} {:>7.2}",
            totals.flights,
            totals.misleading_flights,
            percent(totals.availability),
            totals.nees,
            totals.error_rms_m,
            totals.worst_ratio
        );
    };
    for (name, totals) in by_group(&outcome.flights) {
        row(&name, &totals);
    }
    row("all", &outcome.totals);
    for flight in outcome.flights.iter().filter(|flight| flight.misleading > 0) {
        let _ = writeln!(text, "flight {}: {}\n  {}", flight.number, result(flight), flight.ingredients);
    }
    let _ = writeln!(text, "{}\n{}", shown(&out.join(PAGE)), shown(table));
    let Totals { flights, misleading_flights, misleading, estimates, .. } = outcome.totals;
    let reason = if outcome.pass {
        format!("{flights} flights, none of {estimates} estimates is misleading")
    } else {
        format!("{misleading_flights} of {flights} flights, {misleading} of {estimates} estimates are misleading")
    };
    text + &verdict(outcome.pass, &reason) + "\n"
}
