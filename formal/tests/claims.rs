//! The claims whose proofs take seconds, proved on the committed Verilog with all their mutants.

use std::path::Path;
use std::time::Duration;

use hoverlock_formal::engine::{Solver, find_program};
use hoverlock_formal::prove::{Place, Task, run};
use hoverlock_formal::shipped;

#[test]
#[ignore = "two minutes of proofs"]
fn bus_record_and_control_claims_are_proved_and_their_mutants_fail() {
    if !["yosys", "yosys-smtbmc", "yices-smt2"].iter().all(|program| find_program(program).is_some()) {
        eprintln!("SKIPPED: no yosys or no yices-smt2; `make test` installs them");
        return;
    }
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog");
    let out = tempfile::tempdir().unwrap();
    let place =
        Place { sources: &sources, out: out.path(), limit: Duration::from_secs(200), solver: Solver::default() };
    let names =
        ["row_look_back", "sequencer", "record_fifo", "csr", "ring_comparator", "record_writer", "top", "wiring"];
    for claim in shipped::claims().unwrap().iter().filter(|claim| names.contains(&claim.name.as_str())) {
        let mutants = (0..claim.mutants.len()).map(Task::Mutant);
        for task in [Task::Proof, Task::Cover].into_iter().chain(mutants) {
            let outcome = run(claim, task, &place).unwrap();
            assert!(outcome.pass, "{}: {:?}: {}", outcome.name, outcome.status, outcome.detail);
            eprintln!("{} {:?} {:.1} s {}", outcome.name, outcome.status, outcome.seconds, outcome.detail);
        }
    }
}
