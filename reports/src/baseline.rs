//! Compares a report with an earlier one, check by check.
//!
//! The earlier report is a `report.json` of any commit and design. Two checks are the same check if their name, picture
//! and condition are equal. Pictures go by their names, so a picture or bounds of another content are stated.

use std::collections::HashMap;

use minijinja::context;
use serde::{Deserialize, Serialize};

use crate::page::{PageError, SCRIPT, STYLE, environment, value};
use crate::study::Study;

const TEMPLATE: &str = include_str!("../templates/baseline.html");

/// File name of the page.
pub const PAGE: &str = "baseline.html";

/// The part of an earlier report that is compared.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Baseline {
    provenance: Source,
    bounds: Vec<Row>,
    pictures: Vec<Picture>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Source {
    commit: String,
    command: String,
    configuration: String,
    bounds_sha256: String,
}

/// A picture of the earlier report.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Picture {
    name: String,
    sha256: String,
}

/// A check of either report. Numbers that are not finite are missing in JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Row {
    name: String,
    unit: String,
    limit: Option<f64>,
    measured: Option<f64>,
    used: Option<f64>,
    pass: bool,
    picture: Option<String>,
    condition: Option<String>,
}

/// The way in which a check changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The check passed and fails now.
    Broken,
    /// The earlier report has the check, this one has not.
    Gone,
    /// The check failed and passes now.
    Mended,
    /// This report has the check, the earlier one has not.
    New,
    /// The check uses more of its allowance than before.
    Closer,
    /// The check uses less of its allowance than before.
    Further,
}

/// A check that changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// The way in which it changed.
    pub kind: Kind,
    /// Name of the bound.
    pub name: String,
    /// Unit of `measured` and `limit`.
    pub unit: String,
    /// The picture; `None` for a check of the coefficients.
    pub picture: Option<String>,
    /// The condition; `None` if none was applied.
    pub condition: Option<String>,
    /// Measured value before and now.
    pub measured: [Option<f64>; 2],
    /// Limit before and now.
    pub limit: [Option<f64>; 2],
    /// Fraction of the allowance used before and now.
    pub used: [Option<f64>; 2],
}

/// The differences between an earlier report and this one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// No check that passed fails now, and none is gone.
    pub pass: bool,
    /// Number of checks that are as before.
    pub same: usize,
    /// The checks that changed, the worst kind first.
    pub changes: Vec<Change>,
    /// What both reports name alike and has another content, each with its hashes: the bounds, and pictures.
    pub other_inputs: Vec<String>,
    /// Commit, command and design of the earlier report.
    before: Source,
    /// Commit, command and design of this report.
    now: Source,
}

impl Baseline {
    /// Reads a `report.json`.
    ///
    /// # Errors
    /// The text is not the JSON of a report.
    pub fn parse(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }

    /// Compares a study with this earlier report.
    pub fn compare(&self, study: &Study) -> Comparison {
        let now: Vec<Row> = study.bounds.iter().map(row).collect();
        let mut before: HashMap<_, &Row> = self.bounds.iter().map(|row| (key(row), row)).collect();
        let mut changes = Vec::new();
        let mut same = 0;
        for row in &now {
            let earlier = before.remove(&key(row));
            match kind(earlier, row) {
                Some(kind) => changes.push(change(kind, earlier, Some(row))),
                None => same += 1,
            }
        }
        let gone = self.bounds.iter().filter(|row| before.contains_key(&key(row)));
        changes.extend(gone.map(|row| change(Kind::Gone, Some(row), None)));
        let size = |change: &Change| change.used[1].unwrap_or(f64::MAX) - change.used[0].unwrap_or(0.0);
        changes.sort_by(|a, b| a.kind.cmp(&b.kind).then(size(b).abs().total_cmp(&size(a).abs())));
        let provenance = &study.provenance;
        Comparison {
            pass: !changes.iter().any(|change| matches!(change.kind, Kind::Broken | Kind::Gone)),
            same,
            changes,
            other_inputs: self.other_inputs(study),
            before: self.provenance.clone(),
            now: Source {
                commit: provenance.commit.into(),
                command: provenance.command.clone(),
                configuration: provenance.configuration.clone(),
                bounds_sha256: provenance.bounds_sha256.clone(),
            },
        }
    }

    fn other_inputs(&self, study: &Study) -> Vec<String> {
        let now = |name: &str| study.pictures.iter().find(|picture| picture.name == name);
        let bounds = ("bounds.toml", self.provenance.bounds_sha256.as_str(), study.provenance.bounds_sha256.as_str());
        let pictures = self.pictures.iter().filter_map(|before| {
            let now = now(&before.name)?;
            Some((before.name.as_str(), before.sha256.as_str(), now.sha256.as_str()))
        });
        let differing = std::iter::once(bounds).chain(pictures).filter(|(_, before, now)| before != now);
        differing
            .map(|(name, before, now)| format!("{name}: sha256 {} before, {} now", short(before), short(now)))
            .collect()
    }
}

/// Returns the beginning of a hash, which tells two contents apart.
fn short(sha256: &str) -> String {
    sha256.chars().take(12).collect()
}

fn key(row: &Row) -> (&str, Option<&str>, Option<&str>) {
    (&row.name, row.picture.as_deref(), row.condition.as_deref())
}

fn row(row: &crate::study::BoundRow) -> Row {
    let finite = |value: f64| value.is_finite().then_some(value);
    let check = &row.check;
    Row {
        name: check.name.into(),
        unit: check.unit.into(),
        limit: finite(check.limit),
        measured: finite(check.measured),
        used: finite(check.used),
        pass: check.pass,
        picture: row.picture.clone(),
        condition: row.condition.map(str::to_owned),
    }
}

/// Returns how a check changed; `None` if it did not. JSON text can change the last bit of a number, so numbers are
/// compared with a tolerance.
fn kind(before: Option<&Row>, now: &Row) -> Option<Kind> {
    let Some(before) = before else { return Some(if now.pass { Kind::New } else { Kind::Broken }) };
    match (before.pass, now.pass) {
        (true, false) => return Some(Kind::Broken),
        (false, true) => return Some(Kind::Mended),
        _ => {}
    }
    let close = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= 1e-12 * a.abs().max(b.abs()),
        (a, b) => a.is_none() && b.is_none(),
    };
    if close(before.measured, now.measured) && close(before.limit, now.limit) {
        return None;
    }
    let used = |row: &Row| row.used.unwrap_or(f64::MAX);
    Some(if used(now) > used(before) { Kind::Closer } else { Kind::Further })
}

fn change(kind: Kind, before: Option<&Row>, now: Option<&Row>) -> Change {
    let either = now.or(before);
    let both = |of: fn(&Row) -> Option<f64>| [before.and_then(of), now.and_then(of)];
    Change {
        kind,
        name: either.map(|row| row.name.clone()).unwrap_or_default(),
        unit: either.map(|row| row.unit.clone()).unwrap_or_default(),
        picture: either.and_then(|row| row.picture.clone()),
        condition: either.and_then(|row| row.condition.clone()),
        measured: both(|row| row.measured),
        limit: both(|row| row.limit),
        used: both(|row| row.used),
    }
}

/// A key of the design with its two values.
#[derive(Serialize)]
struct Word<'a> {
    key: &'a str,
    before: &'a str,
    now: &'a str,
}

/// Returns the keys that differ between two configurations.
fn words<'a>(before: &'a str, now: &'a str) -> Vec<Word<'a>> {
    let of = |text: &'a str| text.lines().filter_map(|line| line.split_once(" = ")).collect::<Vec<_>>();
    let earlier: HashMap<&str, &str> = of(before).into_iter().collect();
    let differing = of(now).into_iter().filter_map(|(key, now)| {
        let before = earlier.get(key).copied().unwrap_or("");
        (before != now).then_some(Word { key, before, now })
    });
    differing.collect()
}

/// Renders the page as HTML.
///
/// # Errors
/// The template fails, which is a defect of this program.
pub fn html(comparison: &Comparison) -> Result<String, PageError> {
    let mut environment = environment();
    environment.add_template("baseline.html", TEMPLATE)?;
    let count = |kind: Kind| comparison.changes.iter().filter(|change| change.kind == kind).count();
    let (before, now) = (&comparison.before, &comparison.now);
    Ok(environment.get_template("baseline.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        comparison => value(comparison),
        broken => count(Kind::Broken),
        gone => count(Kind::Gone),
        mended => count(Kind::Mended),
        words => value(words(&before.configuration, &now.configuration)),
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(measured: f64, pass: bool) -> Row {
        Row {
            name: "DoG error, rms".into(),
            unit: "LSB".into(),
            limit: Some(1.25),
            measured: Some(measured),
            used: Some(measured / 1.25),
            pass,
            picture: Some("a".into()),
            condition: Some("fog".into()),
        }
    }

    #[test]
    fn a_change_is_told_by_its_kind() {
        let of = |before: Option<&Row>, now: &Row| kind(before, now);
        assert_eq!(of(Some(&checked(0.5, true)), &checked(0.5, true)), None);
        assert_eq!(of(Some(&checked(0.5, true)), &checked(0.6, true)), Some(Kind::Closer));
        assert_eq!(of(Some(&checked(0.6, true)), &checked(0.5, true)), Some(Kind::Further));
        assert_eq!(of(Some(&checked(0.5, true)), &checked(1.5, false)), Some(Kind::Broken));
        assert_eq!(of(Some(&checked(1.5, false)), &checked(0.5, true)), Some(Kind::Mended));
        assert_eq!(of(None, &checked(0.5, true)), Some(Kind::New));
        assert_eq!(of(None, &checked(1.5, false)), Some(Kind::Broken));
    }

    #[test]
    fn keys_of_the_design_that_differ_are_named() {
        let words = words("dog_bits = 15\nwidth = 1024\n", "dog_bits = 14\nwidth = 1024\n");
        assert_eq!(words.len(), 1);
        assert_eq!((words[0].key, words[0].before, words[0].now), ("dog_bits", "15", "14"));
    }
}
