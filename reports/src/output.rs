//! The three files of a report: the page for people, the same numbers for programs, the bounds as test cases.
//!
//! All three are complete before any of them appears: each is written under a temporary name in the folder, then renamed.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use tempfile::NamedTempFile;

use crate::hardware::{MISMATCHES, Made};
use crate::page::{self, PageError};
use crate::study::{BoundRow, Study};

/// The page.
pub const PAGE: &str = "index.html";
/// The numbers.
pub const NUMBERS: &str = "report.json";
/// The test cases.
pub const TESTS: &str = "junit.xml";

/// Why a report was not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The page.
    #[error(transparent)]
    Page(#[from] PageError),
    /// JSON.
    #[error("the numbers cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// JUnit.
    #[error("the bounds cannot be written as JUnit: {0}")]
    Junit(#[from] quick_junit::SerializeError),
    /// The folder.
    #[error("{path}: cannot be written: {source}; name another folder with --out")]
    Write {
        /// The folder or file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// Makes sure that `folder` exists and can be written into, before hours of work are lost.
///
/// # Errors
/// Where it cannot.
pub fn prepare(folder: &Path) -> Result<(), OutputError> {
    let refused = |source| OutputError::Write { path: folder.to_path_buf(), source };
    fs::create_dir_all(folder).map_err(refused)?;
    NamedTempFile::new_in(folder).map_err(refused)?;
    Ok(())
}

/// Writes all three files into `folder`.
///
/// # Errors
/// Where one of them cannot be made or written; then none of them has changed, unless renaming itself failed.
pub fn write(study: &Study, folder: &Path) -> Result<(), OutputError> {
    let contents = [(PAGE, page::html(study)?), (NUMBERS, json(study)?), (TESTS, junit(study)?)];
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

/// A temporary file is for its owner alone; a report is for all.
#[cfg(unix)]
fn readable(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(path, fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable(_path: &Path) -> io::Result<()> {
    Ok(())
}

/// The numbers.
///
/// # Errors
/// Where they cannot be written as JSON.
pub fn json(study: &Study) -> Result<String, OutputError> {
    Ok(serde_json::to_string_pretty(study)? + "\n")
}

/// One suite for each picture and condition, one case for each bound.
///
/// # Errors
/// Where XML cannot hold a name.
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
    if let Some(Made::NotRun { reason }) = study.hardware().map(|hardware| &hardware.simulation) {
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
    let says =
        format!("measured {} {unit}, limit {} {unit}, {}", check.measured, check.limit, check.place, unit = check.unit);
    let mut status =
        if check.pass { TestCaseStatus::success() } else { TestCaseStatus::non_success(NonSuccessKind::Failure) };
    if !check.pass {
        status.set_message(says.clone()).set_type("bound");
    }
    let mut case = TestCase::new(check.name, status);
    case.set_classname(suite).set_system_out(says);
    case
}
