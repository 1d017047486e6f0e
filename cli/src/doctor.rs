//! `hoverlock doctor`: the tools that are installed or missing, and how to get them.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use hoverlock_formal::engine::find_program;
use serde::Serialize;

use crate::Verdict;
use crate::output::{print, print_json};

/// The list from which the bootstrap installs, one tool per line: `package | command | version | needed for`.
const TOOLS: &str = include_str!("../../setup/tools.txt");

/// Programs that only some verbs need: name, need, how to get it.
const PROGRAMS: [(&str, &str, &str); 3] = [
    ("yices-smt2", "formal", "setup/bootstrap.sh"),
    ("qemu-arm", "--estimator arm", "make arm"),
    ("iverilog", "make bench-harness", "apt-get install iverilog"),
];

/// Python modules that only some verbs need: name, need, how to get it.
const MODULES: [(&str, &str, &str); 3] = [
    ("hoverlock", "Python benches", ".venv/bin/pip install ./harness/python"),
    ("hoverlock_models", "models in Python, sweep --dask", ".venv/bin/pip install ./python"),
    ("distributed", "sweep --dask", "setup/bootstrap.sh"),
];

/// List the tools that are installed or missing, and how to get them.
///
/// Example: hoverlock doctor --json
#[derive(clap::Args)]
pub struct Args {
    /// One JSON object on stdout: ok, tools[] of name, found, optional, version, wanted, needed_for, get
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    ok: bool,
    tools: Vec<Tool>,
}

/// A tool or data set that Hoverlock needs.
#[derive(Serialize)]
struct Tool {
    name: String,
    /// It is installed in the required version.
    found: bool,
    /// Only some verbs need it; without it the status is 0.
    optional: bool,
    /// Its version, or its path; `None` if it is missing.
    version: Option<String>,
    /// Required version prefix, or `None` if any version works.
    wanted: Option<String>,
    needed_for: String,
    get: String,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let mut tools = TOOLS
        .lines()
        .filter(|line| !line.trim().is_empty() && !line.starts_with('#'))
        .map(inspect)
        .collect::<Result<Vec<_>>>()?;
    tools.push(pictures());
    tools.extend(PROGRAMS.map(|(name, needed_for, get)| optional(name, find_program(name), needed_for, get)));
    tools.push(optional("hoverlock-nav", hoverlock_cosim::chain::arm_binary().ok(), "--estimator arm", "make arm"));
    tools.extend(MODULES.map(|(name, needed_for, get)| optional(name, python_module(name), needed_for, get)));
    let report = Report { ok: tools.iter().all(|tool| tool.found || tool.optional), tools };
    if args.json {
        print_json(&report)?;
    } else {
        print(&table(&report))?;
    }
    Ok(report.ok.into())
}

/// Looks up one line of the list on this machine.
fn inspect(line: &str) -> Result<Tool> {
    let fields: Vec<&str> = line.split('|').map(str::trim).collect();
    let [package, command, wanted, needed_for] = fields[..] else { bail!("setup/tools.txt: four fields, not: {line}") };
    let wanted = (wanted != "-").then(|| wanted.to_owned());
    let version = version_of(command).with_context(|| format!("{command} --version cannot be run"))?;
    let fits = |version: &str| wanted.as_ref().is_none_or(|wanted| numbers(version).starts_with(wanted.as_str()));
    Ok(Tool {
        name: if command.starts_with('/') { package } else { command }.to_owned(),
        found: version.as_deref().is_some_and(fits),
        optional: false,
        get: match (&version, &wanted) {
            (Some(_), Some(wanted)) => format!("Debian 12's {package} is {wanted}: apt-get install {package}"),
            _ => format!("apt-get install {package}"),
        },
        version,
        wanted,
        needed_for: needed_for.to_owned(),
    })
}

/// Returns the first line of `command --version`; `None` if there is no such command. A package without a command is
/// represented by one of its files, whose path is returned.
fn version_of(command: &str) -> Result<Option<String>> {
    if command.starts_with('/') {
        return Ok(Path::new(command).exists().then(|| command.to_owned()));
    }
    match Command::new(command).arg("--version").output() {
        Ok(output) => Ok(Some(String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or_default().to_owned())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// Returns the first word that begins with a digit: `0.23` of `Yosys 0.23 (git sha1 7ce5011c24b)`.
fn numbers(version: &str) -> &str {
    version.split_whitespace().find(|word| word.starts_with(|c: char| c.is_ascii_digit())).unwrap_or_default()
}

/// Looks up the pictures of `make demo`, which the bootstrap fetches.
fn pictures() -> Tool {
    let folder = hoverlock_pictures::demo_dir().filter(|folder| folder.join("aero1.jpg").is_file());
    Tool {
        name: "opencv-doc pictures".to_owned(),
        found: folder.is_some(),
        optional: false,
        version: folder.map(|folder| folder.display().to_string()),
        wanted: None,
        needed_for: "make demo".to_owned(),
        get: "setup/bootstrap.sh".to_owned(),
    }
}

/// Describes what only some verbs need.
fn optional(name: &str, path: Option<PathBuf>, needed_for: &str, get: &str) -> Tool {
    Tool {
        name: name.to_owned(),
        found: path.is_some(),
        optional: true,
        version: path.map(|path| path.display().to_string()),
        wanted: None,
        needed_for: needed_for.to_owned(),
        get: get.to_owned(),
    }
}

/// Returns the file of a Python module in the project's environment, or in that of the PATH.
fn python_module(name: &str) -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin/python");
    let python = if own.is_file() { own } else { find_program("python3")? };
    let output = Command::new(python).args(["-c", &format!("import {name}; print({name}.__file__)")]).output().ok()?;
    let file = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    (output.status.success() && !file.is_empty()).then(|| file.into())
}

fn table(report: &Report) -> String {
    let mut text = String::new();
    for tool in &report.tools {
        let state = match (&tool.version, tool.found) {
            (Some(version), true) => format!("ok       {version}"),
            (Some(version), false) => format!("version  {version}; for {}: {}", tool.needed_for, tool.get),
            (None, _) if tool.optional => format!("optional needed for {}: {}", tool.needed_for, tool.get),
            (None, _) => format!("missing  needed for {}: {}", tool.needed_for, tool.get),
        };
        text += &format!("{:<20} {state}\n", tool.name);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_read_from_the_output_of_tools() {
        assert_eq!(numbers("Verilator 5.006 2023-01-22 rev (Debian 5.006-3)"), "5.006");
        assert_eq!(numbers("Z3 version 4.8.12 - 64 bit"), "4.8.12");
        assert_eq!(numbers("no version here"), "");
    }

    #[test]
    fn a_missing_tool_and_a_wrong_version_are_reported() {
        let missing = inspect("nothing | no-such-command-anywhere | - | tests").unwrap();
        assert!(!missing.found && missing.version.is_none());
        let wrong = inspect("coreutils | ls | 0.0.1 | tests").unwrap();
        assert!(!wrong.found && wrong.version.is_some());
        assert!(inspect("coreutils | ls | - | tests").unwrap().found);
        assert!(inspect("two | fields").is_err());
    }

    #[test]
    fn what_some_verbs_need_is_optional() {
        let missing = optional("no-such-program", find_program("no-such-program"), "tests", "nowhere");
        assert!(missing.optional && !missing.found);
        let text = table(&Report { ok: true, tools: vec![missing] });
        assert!(text.contains("optional needed for tests: nowhere"), "{text}");
        assert!(python_module("no_such_module_anywhere").is_none());
    }

    #[test]
    fn every_line_of_the_list_has_four_fields() {
        let lines = TOOLS.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
        assert!(lines.clone().count() >= 6);
        for line in lines {
            assert_eq!(line.split('|').count(), 4, "{line}");
        }
    }
}
