//! Replay of a counter-example: a module is broken, and the test that the failed proof writes is compiled and run.

use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use hoverlock_formal::engine::{Solver, find_program};
use hoverlock_formal::prove::{Place, Task, run};
use hoverlock_formal::shipped;

/// Compiles the emitted test against the harness that this test was built with, and runs it.
fn run_emitted(test: &Path) -> Output {
    let libraries = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let harness = |name: &str| name.starts_with("libhoverlock_harness-") && name.ends_with(".rlib");
    let found = std::fs::read_dir(&libraries).unwrap().map(|entry| entry.unwrap());
    let mut built: Vec<_> = found.filter(|entry| harness(&entry.file_name().to_string_lossy())).collect();
    // Earlier builds may have left other versions: the newest that compiles is used.
    built.sort_by_key(|entry| std::cmp::Reverse(entry.metadata().unwrap().modified().unwrap()));
    let program = test.with_extension("bin");
    let mut said = String::new();
    for library in built {
        let mut command = Command::new("rustc");
        command.args(["--edition", "2024", "--test", "-o"]).arg(&program).arg(test);
        command.arg("-L").arg(format!("dependency={}", libraries.display()));
        command.arg("--extern").arg(format!("hoverlock_harness={}", library.path().display()));
        let output = command.output().unwrap();
        if output.status.success() {
            return Command::new(&program).output().unwrap();
        }
        said += &String::from_utf8_lossy(&output.stderr);
    }
    panic!("the emitted test does not compile: {said}");
}

#[test]
fn a_refuted_claim_is_listed_by_steps_and_replayed() {
    let all =
        ["yosys", "yosys-smtbmc", "yices-smt2", "verilator"].iter().all(|program| find_program(program).is_some());
    if !all {
        eprintln!("SKIPPED: no yosys, no yices-smt2 or no verilator; `make test` installs them");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let claim = shipped::claims().unwrap().into_iter().find(|claim| claim.name == "difference").unwrap();
    let good = include_str!("../../rtl/verilog/difference.v");
    assert_eq!(good.matches("+ 19'd1").count(), 1);
    std::fs::write(folder.path().join("difference.v"), good.replace("+ 19'd1", "+ 19'd0")).unwrap();
    let out = folder.path().join("out");
    let place = Place { sources: folder.path(), out: &out, limit: Duration::from_secs(120), solver: Solver::default() };
    let outcome = run(&claim, Task::Proof, &place).unwrap();
    assert!(!outcome.pass && outcome.detail.contains("response"), "{}", outcome.detail);

    // Both operands of each step, in hexadecimal and in DN: four LSB are one DN.
    assert!(outcome.steps.len() >= 3, "{:?}", outcome.steps);
    for (at, step) in outcome.steps.iter().enumerate() {
        assert!(step.starts_with(&format!("step {at}:")), "{step}");
        let (_, narrow) = step.split_once("narrow=0x").unwrap();
        let (raw, rest) = narrow.split_once(" (").unwrap();
        let dn: f64 = rest.split_once(" DN)").unwrap().0.parse().unwrap();
        assert_eq!(f64::from(u32::from_str_radix(raw, 16).unwrap()) / 4.0, dn, "{step}");
    }

    let test = outcome.replay.unwrap();
    let run = run_emitted(&test);
    let said = [run.stdout, run.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    assert!(!run.status.success() && said.contains("response"), "{said}");
    // With the module corrected the same run violates nothing.
    std::fs::write(test.with_file_name("difference.v"), good).unwrap();
    let run = run_emitted(&test);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stdout));
}
