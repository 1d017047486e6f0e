//! `hoverlock design`: design files: written, explained, compared, changed.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Subcommand;
use hoverlock_design::{DesignPoint, KEYS};
use serde::{Serialize, Serializer};

use crate::Verdict;
use crate::design::Chosen;
use crate::output::{prepare_target, print, print_json, quoted, say, shown, write_file};

/// Write, explain, compare and change design files.
///
/// A design file is what --design takes and what --config changes: every key of the hardware, with unit and limits.
///
/// Example: hoverlock design new camera.toml --config width=640 --config height=512
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    /// Write the file of a design with its changes, every key with its meaning, unit and limits
    New(New),
    /// Print every key of a design with its value, unit and limits
    Show(Show),
    /// Print the keys in which two designs differ
    Diff(Diff),
    /// Change keys of a design file; comments and other keys stay as they are
    Set(Set),
}

#[derive(clap::Args)]
struct New {
    /// The file to write, which must not exist yet
    file: PathBuf,
    #[command(flatten)]
    chosen: Chosen,
    /// One JSON object on stdout: design, an object of all keys
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct Show {
    #[command(flatten)]
    chosen: Chosen,
    /// One JSON object on stdout: design, an object of all keys; keys[] of name value unit meaning limits
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct Diff {
    /// A design: kt27, hd1080, small, three_scales, or a design file
    a: OsString,
    /// The design to compare it with
    b: OsString,
    /// One JSON object on stdout: differences[] of key a b
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct Set {
    /// The design file to change
    file: PathBuf,
    /// The keys and their new values
    #[arg(value_name = "KEY=VALUE", required = true)]
    changes: Vec<String>,
    /// One JSON object on stdout: design, an object of all keys; differences[] of key a b
    #[arg(long)]
    json: bool,
}

/// A key in which two designs differ, with its values as in `--config`.
#[derive(Debug, PartialEq, Serialize)]
struct Difference {
    key: &'static str,
    a: String,
    b: String,
}

/// All keys of a design with their values, as one object.
struct Keys(DesignPoint);

impl Serialize for Keys {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(KEYS.iter().map(|key| (key.name, key.value(&self.0))))
    }
}

/// A key of a design, explained.
#[derive(Serialize)]
struct Explained {
    name: &'static str,
    value: String,
    unit: &'static str,
    meaning: &'static str,
    /// The values that a design file may have, and then those that the hardware requires.
    limits: Vec<String>,
}

#[derive(Serialize)]
struct Report {
    #[serde(skip_serializing_if = "Option::is_none")]
    design: Option<Keys>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    keys: Vec<Explained>,
    #[serde(skip_serializing_if = "Option::is_none")]
    differences: Option<Vec<Difference>>,
}

pub fn run(args: &Args) -> Result<Verdict> {
    match &args.action {
        Action::New(args) => new(args),
        Action::Show(args) => show(args),
        Action::Diff(args) => diff(args),
        Action::Set(args) => set(args),
    }
    .map(|()| Verdict::Pass)
}

fn new(args: &New) -> Result<()> {
    let design = args.chosen.design()?;
    let _folder = prepare_target("FILE", &args.file, &["toml"], &[])?;
    if args.file.exists() {
        bail!("{}: the file exists; change it with `hoverlock design set`, or name another", args.file.display());
    }
    let heading = format!("Written by `hoverlock design new{}`.", args.chosen.options());
    write_file(&args.file, design.to_file(&[heading]).as_bytes())?;
    say_unbuildable(&args.file, &design);
    if args.json {
        return print_json(&Report { design: Some(Keys(design.clone())), keys: Vec::new(), differences: None });
    }
    print(&format!("{}: a design for --design {}\n", shown(&args.file), quoted(&args.file)))
}

fn show(args: &Show) -> Result<()> {
    let design = args.chosen.design()?;
    let keys: Vec<Explained> = KEYS
        .iter()
        .map(|key| Explained {
            name: key.name,
            value: key.value(&design).to_string(),
            unit: key.unit,
            meaning: key.meaning,
            limits: std::iter::once(key.limits(&design)).chain(key.hardware_limits().map(str::to_owned)).collect(),
        })
        .collect();
    if args.json {
        return print_json(&Report { design: Some(Keys(design.clone())), keys, differences: None });
    }
    let widest = |of: fn(&Explained) -> &str| keys.iter().map(|key| of(key).chars().count()).max().unwrap_or_default();
    let (names, values, units) = (widest(|key| key.name), widest(|key| &key.value), widest(|key| key.unit));
    let line = |Explained { name, value, unit, meaning, limits }: &Explained| {
        let limits = limits.join("; ");
        format!("{name:names$}  {value:values$}  {unit:units$}  {meaning}\n{:1$}{limits}\n", "", names + 2)
    };
    print(&keys.iter().map(line).collect::<String>())
}

fn diff(args: &Diff) -> Result<()> {
    let differences = differences(&DesignPoint::load(&args.a)?, &DesignPoint::load(&args.b)?);
    if args.json {
        return print_json(&Report { design: None, keys: Vec::new(), differences: Some(differences) });
    }
    if differences.is_empty() { print("the designs are equal\n") } else { print(&lines(&differences)) }
}

fn set(args: &Set) -> Result<()> {
    let path = &args.file;
    if DesignPoint::shipped(&path.to_string_lossy()).is_some() && !path.exists() {
        bail!("{}: a design that is built in; copy it with `hoverlock design new FILE --design {0}`", path.display());
    }
    let _folder = prepare_target("FILE", path, &["toml"], &[])?;
    let before = DesignPoint::load(path.as_os_str())?;
    let changes = args.changes.iter().map(String::as_str);
    let after = before.with_overrides(changes).with_context(|| path.display().to_string())?;
    let text = std::fs::read_to_string(path).with_context(|| format!("{}: cannot be read", path.display()))?;
    let differences = differences(&before, &after);
    let changed = differences.iter().fold(text, |text, difference| with_value(&text, difference.key, &after));
    if DesignPoint::from_file(&changed).ok().as_ref() != Some(&after) {
        bail!("{}: a key is in quotes, or a value spans several lines; write each as `key = value`", path.display());
    }
    write_file(path, changed.as_bytes())?;
    say_unbuildable(path, &after);
    if args.json {
        return print_json(&Report {
            design: Some(Keys(after.clone())),
            keys: Vec::new(),
            differences: Some(differences),
        });
    }
    if differences.is_empty() { print("the values are there already\n") } else { print(&lines(&differences)) }
}

/// Says which constraint of the hardware a design breaks. It still has models, which a report measures.
fn say_unbuildable(file: &Path, design: &DesignPoint) {
    if let Err(error) = design.of_hardware().check_buildable() {
        say(&format!("{}: models, but no Verilog: {error}", shown(file)));
    }
}

/// Returns the text of a design file with the value of one key from `design`; a comment behind the value stays.
fn with_value(text: &str, key: &str, design: &DesignPoint) -> String {
    let written = design.to_toml();
    let is_of_key = |line: &str| line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
    let Some(value) = written.lines().find(|line| is_of_key(line)) else { return text.to_owned() };
    let replaced = |line: &str| {
        let end = if line.ends_with("\r\n") { "\r\n" } else { "\n" };
        match line.trim_end().split_once('#') {
            _ if !is_of_key(line) => line.to_owned(),
            Some((_, comment)) => format!("{value} #{comment}{end}"),
            None => format!("{value}{end}"),
        }
    };
    text.split_inclusive('\n').map(replaced).collect()
}

fn differences(a: &DesignPoint, b: &DesignPoint) -> Vec<Difference> {
    let values = KEYS.iter().map(|key| (key.name, key.value(a), key.value(b)));
    values
        .filter(|(_, a, b)| a != b)
        .map(|(key, a, b)| Difference { key, a: a.to_string(), b: b.to_string() })
        .collect()
}

fn lines(differences: &[Difference]) -> String {
    differences.iter().map(|Difference { key, a, b }| format!("{key}: {a} -> {b}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_changed_in_place() {
        let design = hoverlock_design::KT27.with_override("dog_bits=14").unwrap();
        let text = "# first\r\nwidth = 1024\ndog_bits  = 15 # of the response\r\n";
        assert_eq!(
            with_value(text, "dog_bits", &design),
            "# first\r\nwidth = 1024\ndog_bits = 14 # of the response\r\n"
        );
    }
}
