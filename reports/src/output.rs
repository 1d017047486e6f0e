//! The files of a report: HTML page, JSON, the checks as CSV, and JUnit XML with one test case for each check.
//!
//! Each file is written under a temporary name in the folder. All of them are renamed after the last one is complete.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use hoverlock_fixed_point::analysis::bounds::Check;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use tempfile::NamedTempFile;

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

/// Why a report was not written.
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
    /// A file or the folder could not be written.
    #[error("{path}: cannot be written: {source}; name another folder with --out")]
    Write {
        /// The folder or file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// Creates `folder` if needed and checks that files can be written there. Call it before the measurement.
///
/// # Errors
/// The folder cannot be created or written.
pub fn prepare(folder: &Path) -> Result<(), OutputError> {
    let refused = |source| OutputError::Write { path: folder.to_path_buf(), source };
    fs::create_dir_all(folder).map_err(refused)?;
    NamedTempFile::new_in(folder).map_err(refused)?;
    Ok(())
}

/// Writes all files into `folder`.
///
/// # Errors
/// A file cannot be made or written. Then no file has changed, unless a rename failed.
pub fn write(study: &Study, folder: &Path) -> Result<(), OutputError> {
    let contents = [(PAGE, page::html(study)?), (NUMBERS, json(study)?), (TABLE, csv(study)), (TESTS, junit(study)?)];
    let mut written = Vec::new();
    for (name, content) in contents {
        let path = folder.join(name);
        let refused = |source| OutputError::Write { path: path.clone(), source };
        let mut file = NamedTempFile::new_in(folder).map_err(refused)?;
        file.write_all(content.as_bytes()).and_then(|()| file.flush()).map_err(refused)?;
        readable(file.path()).map_err(refused)?;
        written.push((file, path));
    }
    for (file, path) in written {
        file.persist(&path).map_err(|error| OutputError::Write { path, source: error.error })?;
    }
    Ok(())
}

/// Makes the file readable for all: a temporary file is readable for its owner only.
#[cfg(unix)]
fn readable(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(path, fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable(_path: &Path) -> io::Result<()> {
    Ok(())
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

/// Returns the checks as JUnit XML: one suite for each picture and condition, one case for each check.
///
/// # Errors
/// XML cannot represent a name.
pub fn junit(study: &Study) -> Result<String, OutputError> {
    let mut suites: Vec<(String, TestSuite)> = Vec::new();
    for row in &study.bounds {
        let name = suite_name(row);
        let case = test_case(row, &name);
        match suites.iter_mut().find(|(of, _)| *of == name) {
            Some((_, suite)) => {
                suite.add_test_case(case);
            }
            None => {
                let mut suite = TestSuite::new(name.clone());
                suite.add_test_case(case);
                suites.push((name, suite));
            }
        }
    }
    if let Some(StepResult::NotRun { reason }) = study.hardware().map(|hardware| &hardware.simulation) {
        let mut suite = TestSuite::new("hardware");
        for picture in &study.pictures {
            let mut status = TestCaseStatus::skipped();
            status.set_message(format!("not run: {reason}"));
            let mut case = TestCase::new(MISMATCHES, status);
            case.set_classname(&picture.name);
            suite.add_test_case(case);
        }
        suites.push(("hardware".into(), suite));
    }
    let mut report = Report::new("hoverlock report");
    report.add_test_suites(suites.into_iter().map(|(_, suite)| suite));
    Ok(report.to_string()?)
}

fn suite_name(row: &BoundRow) -> String {
    match (&row.picture, row.condition) {
        (Some(picture), Some(condition)) => format!("{picture}, {condition}"),
        (Some(picture), None) => picture.clone(),
        _ => "coefficients".into(),
    }
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
