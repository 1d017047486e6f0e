//! The committed files are what the sources give, and Verilator has nothing to say about them.

use std::{path::Path, process::Command};

use hoverlock_rtl::emit::{MEND, files};

#[test]
fn committed_files_are_fresh() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = files().unwrap();
    for file in &files {
        let committed = std::fs::read_to_string(root.join(&file.path)).unwrap_or_default();
        assert!(committed == file.text, "{} is stale: run `{MEND}`", file.path);
    }
    for folder in ["verilog", "registers"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let known = name.ends_with(".vlt") || files.iter().any(|file| file.path == format!("{folder}/{name}"));
            assert!(known, "{folder}/{name} is of no use any more: delete it");
        }
    }
}

#[test]
fn every_module_says_what_it_is_for() {
    for file in files().unwrap().iter().filter(|file| file.path.ends_with(".v")) {
        let comments = file.text.lines().take_while(|line| !line.starts_with("module")).filter(|line| line.len() > 3);
        assert!(comments.count() >= 2, "{} has no header", file.path);
    }
}

#[test]
fn lint_is_clean_but_for_the_waivers() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("verilog");
    let output = Command::new("verilator")
        .current_dir(&folder)
        .args(["--lint-only", "-Wall", "--top-module", "hoverlock_top", "waivers.vlt", "-f", "hoverlock.f"])
        .output()
        .expect("verilator is installed: `hoverlock doctor` says how");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
