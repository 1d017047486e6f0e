//! The outcome of a campaign as CSV and Markdown.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use crate::class::{Class, Counts, wilson};
use crate::draw::{Fault, Kind};
use crate::state::State;

/// A run with a fault: a row of the CSV.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// The module that declares the register.
    pub module: String,
    /// The register's name below the top module.
    pub register: String,
    /// The word of a memory, from its lowest index; 0 for a register.
    pub word: usize,
    /// The bit of the word.
    pub bit: u32,
    /// The clock cycle of the fault.
    pub cycle: u64,
    /// The kind of fault.
    pub kind: Kind,
    /// What came of it.
    pub class: Class,
}

/// Returns the rows of a campaign.
pub fn rows(state: &State, faults: &[Fault], classes: &[Class]) -> Vec<Row> {
    let row = |(fault, class): (&Fault, &Class)| {
        let register = state.register(fault.bit);
        Row {
            module: register.module.clone(),
            register: register.name.clone(),
            word: fault.bit.word,
            bit: fault.bit.bit,
            cycle: fault.cycle,
            kind: fault.kind,
            class: *class,
        }
    };
    faults.iter().zip(classes).map(row).collect()
}

/// Returns the rows as CSV, with a header.
///
/// # Errors
/// None that a vector gives; the type is that of the writer.
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// What the faults of one module, or of one register, came to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Group {
    /// The module or the register.
    pub name: String,
    /// Bits of its registers and memories, all instances together.
    pub bits: u64,
    /// The runs by class.
    #[serde(flatten)]
    pub counts: Counts,
}

/// How rows are put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// By the module that declares the register.
    Module,
    /// By the register's name below the top module.
    Register,
}

/// Returns the groups of a campaign, those with the most bits first: every module or register in which faults may
/// be, also those that no fault hit.
pub fn groups(state: &State, rows: &[Row], by: By) -> Vec<Group> {
    let mut groups: BTreeMap<&str, (u64, Counts)> = BTreeMap::new();
    for register in state.chosen() {
        let name = if by == By::Module { &register.module } else { &register.name };
        groups.entry(name).or_default().0 += register.bits();
    }
    for row in rows {
        let name = if by == By::Module { &row.module } else { &row.register };
        groups.entry(name).or_default().1.add(row.class);
    }
    let group = |(name, (bits, counts)): (&str, (u64, Counts))| Group { name: name.to_owned(), bits, counts };
    let mut groups: Vec<Group> = groups.into_iter().map(group).collect();
    groups.sort_by_key(|group| std::cmp::Reverse(group.bits));
    groups
}

/// Returns all rows as one group.
pub fn all(state: &State, rows: &[Row]) -> Group {
    let counts = rows.iter().map(|row| row.class).collect();
    Group { name: "all".into(), bits: state.bits(), counts }
}

/// Returns a table in Markdown: a line for each group that a fault hit, then for all. `visible` is the share of faults
/// that were not masked, with its 95 % confidence interval.
pub fn markdown(heading: &str, groups: &[Group], all: &Group) -> String {
    let classes = Class::ALL.map(Class::name).join(" | ");
    let mut text =
        format!("| {heading} | bits | faults | {classes} | visible, 95 % |\n|---|---|---|---|---|---|---|---|---|\n");
    let total = Group { name: "**all**".into(), ..all.clone() };
    for group in groups.iter().filter(|group| group.counts.total() > 0).chain([&total]) {
        let counts = &group.counts;
        let numbers = Class::ALL.map(|class| counts.of(class).to_string()).join(" | ");
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {numbers} | {} |",
            group.name,
            group.bits,
            counts.total(),
            interval(counts.visible(), counts.total())
        );
    }
    text
}

/// Returns a share with its 95 % confidence interval, in per cent: `3.1 % (2.4 to 4.0)`.
pub fn interval(hits: u64, of: u64) -> String {
    let (low, high) = wilson(hits, of);
    let share = if of == 0 { 0.0 } else { hits as f64 / of as f64 };
    format!("{:.1} % ({:.1} to {:.1})", 100.0 * share, 100.0 * low, 100.0 * high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{Bit, Register};

    fn outcome() -> (State, Vec<Row>) {
        let register = |name: &str, module: &str, words, width| Register {
            name: name.into(),
            module: module.into(),
            words,
            width,
        };
        let state = State::new([
            register("a.q", "flag", 1, 1),
            register("b.q", "flag", 1, 1),
            register("m", "ram", 8, 4),
            register("x", "idle", 1, 2),
        ]);
        let fault = |register, word, bit| Fault { bit: Bit { register, word, bit }, cycle: 9, kind: Kind::Seu };
        let faults = [fault(0, 0, 0), fault(1, 0, 0), fault(2, 7, 3), fault(2, 1, 0)];
        let rows = rows(&state, &faults, &[Class::Silent, Class::Masked, Class::Detected, Class::Masked]);
        (state, rows)
    }

    #[test]
    fn a_row_has_its_place_and_class() {
        let text = String::from_utf8(csv(&outcome().1).unwrap()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "module,register,word,bit,cycle,kind,class");
        assert_eq!((lines[1], lines[3]), ("flag,a.q,0,0,9,seu,silent", "ram,m,7,3,9,seu,detected"));
        assert_eq!(lines.len(), 5);
    }

    #[test]
    fn groups_have_all_bits_and_all_faults() {
        let (state, rows) = outcome();
        let modules = groups(&state, &rows, By::Module);
        let short: Vec<_> =
            modules.iter().map(|g| (g.name.as_str(), g.bits, g.counts.total(), g.counts.masked)).collect();
        assert_eq!(short, [("ram", 32, 2, 1), ("flag", 2, 2, 1), ("idle", 2, 0, 0)]);
        assert_eq!(groups(&state, &rows, By::Register).len(), 4);
        let text = markdown("module", &modules, &all(&state, &rows));
        let expected = "| module | bits | faults | masked | detected | recovered | silent | hang | visible, 95 % |\n\
                        |---|---|---|---|---|---|---|---|---|\n\
                        | ram | 32 | 2 | 1 | 1 | 0 | 0 | 0 | 50.0 % (9.5 to 90.5) |\n\
                        | flag | 2 | 2 | 1 | 0 | 0 | 1 | 0 | 50.0 % (9.5 to 90.5) |\n\
                        | **all** | 36 | 4 | 2 | 1 | 0 | 1 | 0 | 50.0 % (15.0 to 85.0) |\n";
        assert_eq!(text, expected);
    }
}
