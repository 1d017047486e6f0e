//! The section of the results that lists the proofs of a second solver.

use std::path::Path;

use anyhow::Result;
use hoverlock_formal::prove::{Outcome, Status};

use super::{earlier, rows_of};
use crate::output::write_file;

/// Head of the section. That about coverage follows.
const SECTION: &str = "\n## A second solver\n";
/// Beginning of any section.
const NEXT: &str = "\n## ";

/// Returns text before, in and after the section of a file of results.
fn parts(text: &str) -> (&str, &str, &str) {
    let Some(start) = text.find(SECTION) else {
        let end = text.find("\n## Coverage").unwrap_or(text.len());
        return (&text[..end], "", &text[end..]);
    };
    let body = start + SECTION.len();
    let end = text[body..].find(NEXT).map_or(text.len(), |at| body + at);
    (&text[..start], &text[start..end], &text[end..])
}

/// Returns the section of results; empty if they have none.
pub fn section_of(results: &str) -> &str {
    parts(results).1
}

/// Enters processor times of both solvers into the section, in place of earlier ones of their claims. `names` are those
/// of all claims, in order.
pub fn enter(file: &Path, names: &[&str], by_yices: &[Outcome], by_other: &[Outcome], limit: f64) -> Result<()> {
    let time = |outcome: &Outcome| match outcome.status {
        Status::Proved | Status::Bounded => format!("{:.1}", outcome.processor_seconds),
        Status::Timeout => format!("**not decided in {limit} s**"),
        _ => "**not proved**".to_owned(),
    };
    let text = earlier(file)?;
    let (before, section, after) = parts(&text);
    let mut rows = rows_of(section);
    for own in by_yices {
        let Some(other) = by_other.iter().find(|other| other.name == own.name) else { continue };
        let row = format!("| `{}` | {} | {} | {:.0} |", own.name, time(own), time(other), other.memory_mib);
        rows.insert(own.name.clone(), row);
    }
    let rows: String = names.iter().filter_map(|&name| rows.get(name)).map(|row| format!("{row}\n")).collect();
    let table = format!(
        "{SECTION}\nWritten by `hoverlock formal CLAIM --solver z3 --table formal/RESULTS.md`: processor time of both \
         solvers for the same questions. A claim without a row was not put to both.\n\n\
         | claim | Yices, s | Z3, s | memory of Z3, MiB |\n|---|---|---|---|\n{rows}"
    );
    write_file(file, format!("{before}{table}{after}").as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_section_is_between_the_others() {
        let without = "# A\n\n## Statements\n\n- x\n\n## Coverage by chance\n\ny\n";
        let (before, own, after) = parts(without);
        assert_eq!((before, own, after), ("# A\n\n## Statements\n\n- x\n", "", "\n## Coverage by chance\n\ny\n"));
        let with = format!("{before}{SECTION}\nz\n{after}");
        assert_eq!(parts(&with), (before, format!("{SECTION}\nz\n").as_str(), after));
        assert_eq!(parts("# A\n"), ("# A\n", "", ""));
    }
}
