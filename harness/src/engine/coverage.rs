//! Coverage counted by Verilator: read, merged over runs, written as LCOV.
//!
//! A point is a position in the Verilog with what is counted there: a line or branch, a bit that went up or down, a
//! `cover` statement. [`Coverage::read`] reads the files of [`Dut::write_coverage`](crate::sim::Dut::write_coverage),
//! [`Coverage::merge`] adds runs, [`Coverage::to_lcov`] writes what `genhtml` and editors read. A line's count is that
//! of its least counted point.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

use crate::engine::error::RecordingError;

/// A position in the Verilog where something is counted.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Point {
    /// The Verilog file.
    pub file: String,
    /// The line in it.
    pub line: u32,
    /// `line`, `branch`, `toggle` or `user`.
    pub kind: String,
    /// What is counted there: a signal and bit, a branch.
    pub what: String,
    /// The instance.
    pub scope: String,
}

/// The counts of all points of one or several runs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Coverage {
    /// How often each point was hit.
    pub counts: BTreeMap<Point, u64>,
}

impl Coverage {
    /// Reads a file in Verilator's format.
    ///
    /// # Errors
    /// If the file cannot be read, or is not one that Verilator wrote.
    pub fn read(path: &Path) -> Result<Coverage, RecordingError> {
        let failed = |source| RecordingError::File { path: path.to_owned(), source };
        Coverage::parse(&std::fs::read(path).map_err(failed)?)
            .ok_or_else(|| failed(io::Error::new(io::ErrorKind::InvalidData, "not a coverage file of Verilator")))
    }

    /// Parses lines of the form `C '\x01f\x02file\x01l\x02line...' count` after a first line that names the format.
    fn parse(bytes: &[u8]) -> Option<Coverage> {
        let text = String::from_utf8_lossy(bytes);
        let mut lines = text.lines();
        if !lines.next()?.starts_with("# SystemC::Coverage") {
            return None;
        }
        let mut coverage = Coverage::default();
        for line in lines.filter(|l| l.starts_with("C '")) {
            let (keys, count) = line[3..].rsplit_once("' ")?;
            let mut fields: BTreeMap<&str, &str> = BTreeMap::new();
            for field in keys.split('\u{1}').skip(1) {
                let (key, value) = field.split_once('\u{2}')?;
                fields.insert(key, value);
            }
            let get = |key: &str| fields.get(key).copied().unwrap_or("");
            let page = get("page").split('/').next().unwrap_or("").trim_start_matches("v_");
            let point = Point {
                file: get("f").to_owned(),
                line: get("l").parse().ok()?,
                kind: page.to_owned(),
                what: format!("{}{}", get("o"), if get("n").is_empty() { "" } else { get("n") }),
                scope: get("h").to_owned(),
            };
            *coverage.counts.entry(point).or_insert(0) += count.trim().parse::<u64>().ok()?;
        }
        Some(coverage)
    }

    /// Adds the counts of another run.
    pub fn merge(&mut self, other: &Coverage) {
        for (point, count) in &other.counts {
            *self.counts.entry(point.clone()).or_insert(0) += count;
        }
    }

    /// Returns the number of points that were hit and the number of all points, of one kind, or of all kinds if `kind`
    /// is empty.
    pub fn ratio(&self, kind: &str) -> (usize, usize) {
        let of_kind = || self.counts.iter().filter(|(p, _)| kind.is_empty() || p.kind == kind);
        (of_kind().filter(|(_, count)| **count > 0).count(), of_kind().count())
    }

    /// Returns the points that were never hit.
    pub fn missed(&self) -> impl Iterator<Item = &Point> {
        self.counts.iter().filter(|(_, count)| **count == 0).map(|(point, _)| point)
    }

    /// Returns the counts as an LCOV tracefile.
    pub fn to_lcov(&self) -> String {
        let mut files: BTreeMap<&str, BTreeMap<u32, u64>> = BTreeMap::new();
        for (point, count) in &self.counts {
            let line = files.entry(&point.file).or_default().entry(point.line).or_insert(u64::MAX);
            *line = (*line).min(*count);
        }
        let mut text = String::new();
        for (file, lines) in files {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "TN:verilator\nSF:{file}");
            for (line, count) in &lines {
                let _ = writeln!(text, "DA:{line},{count}");
            }
            let hit = lines.values().filter(|count| **count > 0).count();
            let _ = writeln!(text, "LF:{}\nLH:{hit}\nend_of_record", lines.len());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "# SystemC::Coverage-3\n\
        C '\u{1}f\u{2}a.v\u{1}l\u{2}4\u{1}n\u{2}3\u{1}page\u{2}v_line/a\u{1}o\u{2}block\u{1}h\u{2}TOP.a' 5\n\
        C '\u{1}f\u{2}a.v\u{1}l\u{2}4\u{1}page\u{2}v_toggle/a\u{1}o\u{2}x[0]\u{1}h\u{2}TOP.a' 0\n\
        C '\u{1}f\u{2}a.v\u{1}l\u{2}7\u{1}page\u{2}v_line/a\u{1}o\u{2}else\u{1}h\u{2}TOP.a' 2\n";

    #[test]
    fn runs_add_up_and_a_line_counts_as_its_least_point() {
        let one = Coverage::parse(FILE.as_bytes()).unwrap();
        assert_eq!(one.ratio("line"), (2, 2));
        assert_eq!(one.ratio(""), (2, 3));
        assert_eq!(one.missed().next().unwrap().what, "x[0]");
        let mut two = one.clone();
        two.merge(&one);
        let lcov = two.to_lcov();
        assert!(lcov.contains("DA:4,0\nDA:7,4\nLF:2\nLH:1\n"), "{lcov}");
        assert!(Coverage::parse(b"something else").is_none());
    }
}
