//! The files of a report: HTML page, JSON, the checks as CSV, and JUnit XML with one test case for each check.

use hoverlock_fixed_point::analysis::bounds::Check;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use crate::hardware::{MISMATCHES, StepResult};
use crate::page::{self, PageError};
use crate::study::{BoundRow, Study};

/// File name of the HTML page.
pub const PAGE: &str = "index.html";
/// File name of the JSON file.
pub const NUMBERS: &str = "report.json";
/// File name of the checks as a table.
pub const TABLE: &str = "checks.csv";
/// File name of the JUnit XML file.
pub const TESTS: &str = "junit.xml";

/// Why the files of a report were not made.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The page could not be rendered.
    #[error(transparent)]
    Page(#[from] PageError),
    /// The study could not be written as JSON.
    #[error("the report cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The checks could not be written as JUnit XML.
    #[error("the checks cannot be written as JUnit XML: {0}")]
    Junit(#[from] quick_junit::SerializeError),
}

/// Returns all files of a report: name and content of each.
///
/// # Errors
/// A file cannot be made.
pub fn files(study: &Study) -> Result<[(&'static str, String); 4], OutputError> {
    Ok([(PAGE, page::html(study)?), (NUMBERS, json(study)?), (TABLE, csv(study)), (TESTS, junit(study)?)])
}

/// Returns the study as JSON.
///
/// # Errors
/// The study cannot be written as JSON.
pub fn json(study: &Study) -> Result<String, OutputError> {
    Ok(serde_json::to_string_pretty(study)? + "\n")
}

/// Returns the checks as CSV, one row each.
pub fn csv(study: &Study) -> String {
    let mut text = String::from("picture,condition,check,measured,limit,unit,margin,used,pass,location\n");
    for row in &study.bounds {
        let Check { name, unit, limit, measured, location, used, pass, .. } = &row.check;
        let picture = field(row.picture.as_deref().unwrap_or_default());
        let condition = row.condition.unwrap_or_default();
        let (name, location, margin) = (field(name), field(location), row.margin);
        text += &format!("{picture},{condition},{name},{measured},{limit},{unit},{margin},{used},{pass},{location}\n");
    }
    text
}

/// Returns a field of CSV (RFC 4180), quoted if necessary.
pub(crate) fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// Returns the checks as JUnit XML: one suite for each picture and condition, one case for each check. What was not
/// checked is a skipped case with the reason.
///
/// # Errors
/// XML cannot represent a name.
pub fn junit(study: &Study) -> Result<String, OutputError> {
    let mut suites: Vec<TestSuite> = Vec::new();
    let mut add = |name: &str, case: TestCase| {
        let at = suites.iter().position(|suite| suite.name.as_str() == name).unwrap_or_else(|| {
            suites.push(TestSuite::new(name));
            suites.len() - 1
        });
        suites[at].add_test_case(case);
    };
    for row in &study.bounds {
        let name = suite_name(row.picture.as_deref(), row.condition);
        add(&name, test_case(row, &name));
    }
    for unfit in &study.unfit {
        let name = suite_name(Some(&unfit.picture), unfit.condition);
        add(&name, skipped("fit to judge a design", &name, &unfit.reason));
    }
    for of in &study.low_contrast {
        let name = suite_name(Some(&of.picture), Some(of.condition));
        let reason = format!("the contrast, {:.0} LSB rms, is below every class", of.rms_lsb);
        of.checks.iter().for_each(|check| add(&name, skipped(check, &name, &reason)));
    }
    if let Some(StepResult::NotRun { reason }) = study.hardware().map(|hardware| &hardware.simulation) {
        let reason = format!("not run: {reason}");
        study.pictures.iter().for_each(|picture| add("hardware", skipped(MISMATCHES, &picture.name, &reason)));
    }
    let mut report = Report::new("hoverlock report");
    report.add_test_suites(suites);
    Ok(report.to_string()?)
}

fn suite_name(picture: Option<&str>, condition: Option<&str>) -> String {
    match (picture, condition) {
        (Some(picture), Some(condition)) => format!("{picture}, {condition}"),
        (Some(picture), None) => picture.into(),
        _ => "coefficients".into(),
    }
}

/// Returns the case of a check that was not made.
fn skipped(check: &str, class: &str, reason: &str) -> TestCase {
    let mut status = TestCaseStatus::skipped();
    status.set_message(reason);
    let mut case = TestCase::new(check, status);
    case.set_classname(class);
    case
}

fn test_case(row: &BoundRow, suite: &str) -> TestCase {
    let check = &row.check;
    let message = format!(
        "measured {} {unit}, limit {} {unit}, {}",
        check.measured,
        check.limit,
        check.location,
        unit = check.unit
    );
    let mut status =
        if check.pass { TestCaseStatus::success() } else { TestCaseStatus::non_success(NonSuccessKind::Failure) };
    if !check.pass {
        status.set_message(message.clone()).set_type("bound");
    }
    let mut case = TestCase::new(check.name, status);
    case.set_classname(suite).set_system_out(message);
    case
}
