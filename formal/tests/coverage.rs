//! A claim that states less leaves survivors, and holes list them.

use std::path::Path;
use std::time::Duration;

use hoverlock_formal::claim::{Claim, Hole};
use hoverlock_formal::coverage::{Campaign, Class, Mutation};
use hoverlock_formal::engine::{Solver, find_program};
use hoverlock_formal::prove::Place;
use hoverlock_formal::shipped;

/// Returns the mutations that survive a claim about the committed Verilog.
fn survivors(claim: &Claim) -> Vec<Mutation> {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog");
    let out = tempfile::tempdir().unwrap();
    let place =
        Place { sources: &sources, out: out.path(), limit: Duration::from_secs(100), solver: Solver::default() };
    let campaign = Campaign::new(claim, &place, 40, 1).unwrap();
    assert_eq!(campaign.mutations().len(), 40);
    let survives = |mutation: &&Mutation| campaign.classify(mutation).unwrap().0 == Class::Survivor;
    campaign.mutations().iter().filter(survives).cloned().collect()
}

#[test]
fn a_weakened_claim_leaves_survivors_that_a_hole_lists() {
    if !["yosys", "yices-smt2"].iter().all(|program| find_program(program).is_some()) {
        eprintln!("SKIPPED: no yosys or no yices-smt2; `make test` installs them");
        return;
    }
    let claim = shipped::claims().unwrap().into_iter().find(|claim| claim.name == "cursor").unwrap();
    assert_eq!(survivors(&claim), []);

    // Without the border flags nothing is said of them.
    let flags = "first_column == (inside && column == 11'd0)";
    assert_eq!(claim.properties.matches(flags).count(), 1);
    let weak = Claim { properties: claim.properties.replace(flags, "(1'b1"), ..claim };
    let start = weak.properties.find("(1'b1").unwrap();
    let end = start + weak.properties[start..].find(");").unwrap();
    let properties = format!("{}1'b1{}", &weak.properties[..start], &weak.properties[end..]);
    let left = survivors(&Claim { properties, ..weak });
    assert!(left.len() > 3 && left.iter().all(|of| of.file == "cursor.v" && of.line > 0), "{left:?}");

    let hole =
        |text: &str| Hole { number: 1, file: "cursor.v".into(), lines: vec![text.into()], reason: String::new() };
    assert!(left.iter().any(|mutation| hole("first_column =").matches(mutation)), "{left:?}");
    assert!(!left.iter().any(|mutation| hole("active <= 1'b1").matches(mutation)), "{left:?}");
}
