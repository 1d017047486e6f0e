//! `hoverlock fault` from the command line.

#[path = "common/picture.rs"]
mod picture;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use hoverlock_reference::image::plane::Plane;
use picture::save;
use serde_json::Value;

fn fault(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).arg("fault").args(args).output().unwrap()
}

/// As `common::assert_refused`, but a line about a model that is built for the first time may precede.
#[track_caller]
fn assert_refused(output: &Output, named: &str) {
    let text = String::from_utf8_lossy(&output.stderr);
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("hoverlock: building")).collect();
    assert_eq!(output.status.code(), Some(2), "{named}: {text}");
    assert!(lines.len() == 1 && lines[0].contains(named), "{named}: {text}");
    assert!(output.stdout.is_empty());
}

/// A core in which the outcome of an upset in each register is known.
fn tiny() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fault/tests/designs/tiny.v").to_str().unwrap().to_owned()
}

#[test]
fn a_core_of_any_verilog_has_the_outcomes_that_it_must_have() {
    let folder = tempfile::tempdir().unwrap();
    let [csv, table] = ["upsets.csv", "upsets.md"].map(|name| folder.path().join(name));
    let [csv, table] = [&csv, &table].map(|path| path.to_str().unwrap());
    let source = tiny();
    let arguments = ["--source", &source, "--top", "tiny", "--detect", "alarm", "--upsets", "400", "--json"];
    let output = fault(&[&arguments[..], &["--csv", csv, "--table", table, "--by", "register"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("clock clk, reset rst, active at 1"));

    let known = BTreeMap::from([
        ("unread", "masked"),
        ("stage", "recovered"),
        ("guarded", "detected"),
        ("guard", "detected"),
        ("words", "silent"),
        ("at", "silent"),
        ("total", "silent"),
        ("armed", "hang"),
    ]);
    let mut reader = csv::Reader::from_path(csv).unwrap();
    let mut counts: BTreeMap<String, u64> = BTreeMap::new();
    let mut met = BTreeMap::new();
    for row in reader.records().map(Result::unwrap) {
        assert_eq!(known.get(&row[1]).copied(), Some(&row[6]), "{row:?}");
        *counts.entry(row[6].to_owned()).or_default() += 1;
        met.insert(row[1].to_owned(), ());
    }
    assert_eq!((met.len(), counts.values().sum::<u64>()), (known.len(), 400), "every register is hit");

    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["kind"], &report["bits"], &report["cycles"]), (&"seu".into(), &40.into(), &2000.into()));
    for class in report["classes"].as_array().unwrap() {
        assert_eq!(class["faults"].as_u64(), counts.get(class["class"].as_str().unwrap()).copied());
        let [share, low, high] = ["share", "low", "high"].map(|key| class[key].as_f64().unwrap());
        assert!(low <= share && share <= high && high - low < 0.11, "{class}");
    }
    assert_eq!(report["groups"].as_array().unwrap().len(), known.len());
    assert!(report["seconds"].as_f64().unwrap() > 0.0);
    let table = std::fs::read_to_string(table).unwrap();
    assert!(table.starts_with("# What comes of 400 faults\n\nclock clk, "), "{table}");
    assert!(table.contains("\n| register | bits | faults | masked | detected |"), "{table}");
    assert!(table.contains("| **all** | 40 | 400 |"), "{table}");
}

#[test]
fn stuck_bits_and_chosen_registers() {
    let output =
        fault(&["--source", &tiny(), "--top", "tiny", "--kind", "stuck1", "--only", "stage", "--upsets", "20"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0));
    assert!(text.contains("silent 100.0 %") && text.contains("masked 0.0 %"), "{text}");
    let line = text.lines().find(|line| line.starts_with("tiny")).unwrap();
    assert_eq!(line.split_whitespace().take(3).collect::<Vec<_>>(), ["tiny", "4", "20"]);
}

#[test]
fn a_table_is_the_stimulus() {
    let folder = tempfile::tempdir().unwrap();
    let stimulus = folder.path().join("in.csv");
    std::fs::write(&stimulus, "in\n0\n").unwrap();
    let stimulus = stimulus.to_str().unwrap();
    let run = |more: &[&str]| {
        let source = tiny();
        let arguments = ["--source", &source, "--top", "tiny", "--stimulus", stimulus, "--only", "stage"];
        fault(&[&arguments[..], more].concat())
    };
    let output = run(&["--cycles", "300", "--kind", "stuck0", "--upsets", "10"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("masked 100.0 %"), "the stage is 0 anyway");
    assert_refused(&run(&[]), "1 cycles are no more than two frames of 64");
    std::fs::write(stimulus, "in\n1\n16\n").unwrap();
    assert_refused(&run(&[]), "in.csv: line 3: '16' is no value of input 'in' of 4 bits");
}

#[test]
fn the_top_runs_on_strips_of_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let plane = Plane::from_fn(64, 80, |x, y| ((((x / 3) * 73_856_093) ^ ((y / 3) * 19_349_663)) % 60_013) as u16);
    let picture = save(folder.path(), "ground.png", &plane);
    let picture = picture.as_str();
    let output = fault(&[picture, "--only", "sequencer", "--upsets", "30", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let count = |class: usize| report["classes"][class]["faults"].as_u64().unwrap();
    assert_eq!((0..5).map(count).sum::<u64>(), 30);
    assert!(count(0) > 0 && count(0) < 30, "some are masked and some are not: {report}");
    assert_eq!(report["groups"][0]["name"], "sequencer");
    assert_refused(&fault(&[picture, "--rows", "81"]), "has 80 rows, fewer than --rows 81");
    assert_refused(&fault(&[picture, "--frames", "3"]), "--frames");
}

#[test]
fn over_a_scene_the_flight_program_says_what_upsets_cost() {
    let output = fault(&["--scene", "field", "--frames", "5", "--only", "frame_delay", "--upsets", "6", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let cost = &report["cost"];
    // Every frame after the reference has an estimate; a marker that comes too early or too late takes some away.
    assert_eq!(cost["estimates"], 4, "{report}");
    assert!(cost["faults"].as_u64().unwrap() <= 6 && cost["shift_m"].as_f64().is_some(), "{report}");
    assert_refused(&fault(&["--scene", "nowhere"]), "nowhere");
    assert_refused(&fault(&["--scene", "field", "--config", "width=500"]), "frames of 512 columns");
    assert_refused(&fault(&["a.png", "--scene", "field"]), "cannot be used with");
    assert_refused(&fault(&["--scene", "field", "--rows", "70"]), "cannot be used with");
}

#[test]
fn what_makes_no_campaign_is_refused() {
    let source = tiny();
    let core = |more: &[&str]| fault(&[&["--source", &source, "--top", "tiny"][..], more].concat());
    assert_refused(&fault(&[]), "IMAGE");
    assert_refused(&fault(&["a.png", "--source", &source, "--top", "tiny"]), "cannot be used with");
    assert_refused(&core(&["--design", "small"]), "cannot be used with");
    assert_refused(&fault(&["--source", &source]), "--top");
    assert_refused(&fault(&["--source", "none.v", "--top", "tiny"]), "none.v");
    assert_refused(&fault(&["--source", &source, "--top", "tinny"]), "no module 'tinny'");
    assert_refused(&core(&["--clock", "clock"]), "--clock: the top has no input of one bit 'clock'; did you mean clk?");
    assert_refused(&core(&["--detect", "alert"]), "--detect: the top has no output 'alert'");
    assert_refused(&core(&["--set", "in"]), "--set in: is not NAME=VALUE");
    assert_refused(&core(&["--set", "in=99"]), "'99' is no value of input 'in' of 4 bits");
    assert_refused(&core(&["--only", "nothing"]), "no register or memory to put a fault in --only nothing");
    assert_refused(&core(&["--stimulus", "none.csv"]), "--stimulus none.csv: cannot be read");
    assert_refused(&core(&["--csv", "upsets.txt"]), "--csv upsets.txt: the name must end in .csv");
    assert_refused(&core(&["--valid", "alarm"]), "never 1");
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.v");
    std::fs::write(&broken, "module broken(input clk\nendmodule\nmodule\n").unwrap();
    assert_refused(&fault(&["--source", broken.to_str().unwrap(), "--top", "broken"]), "broken.v:2");
}
