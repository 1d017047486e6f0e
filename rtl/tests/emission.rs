//! The committed files equal the emission, have a header, and pass Verilator's lint.

use std::{path::Path, process::Command};

use hoverlock_rtl::emission::{MEND, files, project_path};

/// Licence and origin, above the header of a module.
const BANNER_LINES: usize = 2;

#[test]
fn every_file_names_its_licence() {
    for file in files().unwrap() {
        let first = file.text.lines().next().unwrap_or_default();
        assert!(first.contains("SPDX-License-Identifier: MIT OR Apache-2.0"), "{}: {first}", file.path);
    }
}

#[test]
fn committed_files_are_fresh() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = files().unwrap();
    for file in &files {
        let committed = std::fs::read_to_string(root.join("..").join(project_path(&file.path))).unwrap_or_default();
        assert!(committed == file.text, "{} is stale: run `{MEND}`", file.path);
    }
    for folder in ["verilog", "registers"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let known = name.ends_with(".vlt") || files.iter().any(|file| file.path == format!("{folder}/{name}"));
            assert!(known, "{folder}/{name} is not emitted any more: delete it");
        }
    }
}

#[test]
fn the_list_has_a_module_after_those_it_is_made_of() {
    let files = files().unwrap();
    let list = files.iter().find(|file| file.path == "verilog/hoverlock.f").unwrap();
    let listed: Vec<&str> = list.text.lines().filter_map(|line| line.strip_suffix(".v")).collect();
    assert!(listed.len() <= 50 && listed.last() == Some(&"hoverlock_top"), "{listed:?}");
    for (at, name) in listed.iter().enumerate() {
        let text = &files.iter().find(|file| file.path == format!("verilog/{name}.v")).unwrap().text;
        for later in &listed[at + 1..] {
            let instance = format!("{later} ");
            assert!(!text.lines().any(|line| line.starts_with(&instance)), "{name} has an instance of {later}");
        }
    }
}

#[test]
fn every_module_states_its_purpose_and_latency() {
    for file in files().unwrap().iter().filter(|file| file.path.ends_with(".v")) {
        let header: Vec<&str> = file
            .text
            .lines()
            .skip(BANNER_LINES)
            .take_while(|line| !line.starts_with("module"))
            .filter(|line| line.starts_with("//") && line.len() > 3)
            .collect();
        let (purpose, latency) = header.split_at(header.len().saturating_sub(1));
        assert!(!purpose.is_empty(), "{} has no purpose in its header", file.path);
        assert!(latency[0].starts_with("// Latency: "), "{} has no latency in its header", file.path);
        // A cell built of registers shows its pipeline or is one step; what is built of cells shows its parts.
        let steps = header.concat();
        let parts = header.iter().any(|line| line.starts_with("//   "));
        let instances = file.text.matches("\n  .clock(clock)").count();
        assert!(instances < 3 || parts, "{} has {instances} parts and no table of them", file.path);
        assert!(
            !steps.contains(['{', '}']) || steps.contains("= {"),
            "{} has a number that is not filled in",
            file.path
        );
        assert!(file.text.lines().all(|line| line.len() <= 120), "{} is too wide", file.path);
    }
}

#[test]
fn lint_is_clean_but_for_the_waivers() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("verilog");
    let component = ["../quartus/hoverlock_component.v"];
    for (top, more) in [("hoverlock_top", &[][..]), ("hoverlock_component", &component)] {
        let output = Command::new("verilator")
            .current_dir(&folder)
            .args(["--lint-only", "-Wall", "--top-module", top, "waivers.vlt", "-f", "hoverlock.f"])
            .args(more)
            .output()
            .expect("verilator is installed: `hoverlock doctor` says how");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}
