//! A core whose every register has a known outcome.

use std::collections::BTreeSet;
use std::path::PathBuf;

use hoverlock_fault::campaign::campaign;
use hoverlock_fault::class::{Class, Counts};
use hoverlock_fault::core::{Core, CoreError, Options, Stimulus};
use hoverlock_fault::draw::{Fault, Kind, draw};
use hoverlock_fault::state::Bit;
use hoverlock_harness::build::Build;

fn options() -> Options {
    Options {
        clock: None,
        reset: None,
        stimulus: Stimulus::Random(1),
        constants: Vec::new(),
        valid: None,
        detect: vec!["alarm".into()],
        cycles: Some(200),
        frame: 8,
    }
}

fn build() -> Build {
    build_of("tiny")
}

fn build_of(name: &str) -> Build {
    let file = format!("{name}.v");
    let source: PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests", "designs", &file].iter().collect();
    Build::new(name).source(source)
}

fn core(options: &Options) -> Core {
    Core::new(&build(), options).unwrap()
}

/// Returns the classes of a fault in each bit of a register, in each of the given cycles.
fn classes(core: &Core, name: &str, kind: Kind, cycles: &[u64]) -> BTreeSet<Class> {
    let at = core.state().registers().iter().position(|register| register.name == name).unwrap();
    let register = &core.state().registers()[at];
    let mut found = BTreeSet::new();
    for cycle in cycles {
        for word in 0..register.words {
            for bit in 0..register.width {
                let bit = Bit { register: at, word, bit };
                found.insert(core.run(&Fault { bit, cycle: *cycle, kind }).unwrap());
            }
        }
    }
    found
}

const CYCLES: [u64; 4] = [0, 1, 57, 183];

#[test]
fn every_upset_has_the_outcome_that_its_register_must_have() {
    let core = core(&options());
    assert_eq!(core.state().bits(), 4 + 4 + 4 + 1 + 16 + 2 + 1 + 8);
    assert_eq!(core.window(), 0..184);
    assert_eq!(core.clock_and_reset(), ("clk", Some(("rst", 1))));
    let expected = [
        ("unread", Class::Masked),
        ("stage", Class::Recovered),
        ("guarded", Class::Detected),
        ("guard", Class::Detected),
        // Each word is read in one cycle of four, until the end.
        ("words", Class::Silent),
        ("at", Class::Silent),
        ("total", Class::Silent),
        ("armed", Class::Hang),
    ];
    for (name, class) in expected {
        assert_eq!(classes(&core, name, Kind::Seu, &CYCLES), BTreeSet::from([class]), "{name}");
    }
}

#[test]
fn without_its_alarm_the_guarded_register_recovers() {
    let core = core(&Options { detect: Vec::new(), ..options() });
    assert_eq!(classes(&core, "guarded", Kind::Seu, &CYCLES), BTreeSet::from([Class::Recovered]));
    // The alarm itself is an output like the others.
    assert_eq!(classes(&core, "guard", Kind::Seu, &CYCLES), BTreeSet::from([Class::Recovered]));
}

#[test]
fn a_stuck_bit_stays() {
    let core = core(&options());
    assert_eq!(classes(&core, "stage", Kind::Stuck0, &CYCLES), BTreeSet::from([Class::Silent]));
    assert_eq!(classes(&core, "stage", Kind::Stuck1, &CYCLES), BTreeSet::from([Class::Silent]));
    assert_eq!(classes(&core, "guarded", Kind::Stuck1, &CYCLES), BTreeSet::from([Class::Detected]));
    // It is 0 in every run that goes on.
    assert_eq!(classes(&core, "armed", Kind::Stuck0, &CYCLES), BTreeSet::from([Class::Masked]));
    assert_eq!(classes(&core, "armed", Kind::Stuck1, &CYCLES), BTreeSet::from([Class::Hang]));
}

#[test]
fn where_outputs_do_not_count_a_wrong_one_is_masked() {
    // The alarm says when the others count: without an upset it never does.
    let never = Options { valid: Some("alarm".into()), detect: Vec::new(), ..options() };
    let message = Core::new(&build(), &never).unwrap_err().to_string();
    assert!(message.contains("never 1"), "{message}");
    // `out` is not 0 in most cycles; its own lowest bits count.
    let core = core(&Options { valid: Some("out".into()), ..options() });
    assert_eq!(classes(&core, "unread", Kind::Seu, &CYCLES), BTreeSet::from([Class::Masked]));
    assert_eq!(classes(&core, "total", Kind::Seu, &CYCLES), BTreeSet::from([Class::Silent]));
}

#[test]
fn every_bit_of_a_wide_output_counts() {
    let options = Options { valid: Some("counts".into()), ..options() };
    let core = Core::new(&build_of("wide"), &options).unwrap();
    for name in ["out", "parity"] {
        assert_eq!(classes(&core, name, Kind::Seu, &CYCLES), BTreeSet::from([Class::Detected]), "{name}");
    }
}

#[test]
fn a_table_drives_the_core() {
    let quiet = Stimulus::Table("in\n0\n".into());
    let core = core(&Options { stimulus: quiet, ..options() });
    // `total` stays 0, and `out` is what the words are.
    assert_eq!(core.active_outputs(), (1, 3));
    assert_eq!(classes(&core, "stage", Kind::Stuck0, &CYCLES), BTreeSet::from([Class::Masked]), "it is 0 anyway");
}

#[test]
fn a_campaign_gives_what_single_runs_give() {
    let core = core(&options());
    let faults = draw(core.state(), core.window(), Kind::Seu, 400, 3);
    let run = |threads| campaign(&faults, threads, |fault| core.run(fault), |_| ()).unwrap();
    let classes = run(2);
    assert_eq!(classes, run(1));
    let counts: Counts = classes.into_iter().collect();
    // Of 40 bits 4 are masked, 4 recover, 5 are detected, 26 silent, 1 hangs.
    let near = |count: u64, bits: u64| (count as f64 - bits as f64 * 10.0).abs() < 4.0 * (bits as f64 * 10.0).sqrt();
    let found = [counts.masked, counts.recovered, counts.detected, counts.silent, counts.hang];
    assert!(found.iter().zip([4, 4, 5, 26, 1]).all(|(count, bits)| near(*count, bits)), "{counts:?}");
}

#[test]
fn what_does_not_fit_the_core_is_refused() {
    let message = |options: Options| Core::new(&build(), &options).unwrap_err().to_string();
    assert_eq!(
        message(Options { clock: Some("clock".into()), ..options() }),
        "the top has no input of one bit 'clock'; did you mean clk?"
    );
    assert!(message(Options { detect: vec!["alarms".into()], ..options() }).contains("no output 'alarms'"));
    let reset = message(Options { reset: Some(("in".into(), true)), ..options() });
    assert!(reset.contains("input of one bit 'in'") && !reset.contains("did you mean in"), "{reset}");
    assert!(message(Options { constants: vec![("in".into(), "16".into())], ..options() }).contains("'16' is no value"));
    assert!(message(Options { cycles: Some(16), ..options() }).contains("no more than two frames"));
    assert!(message(Options { cycles: Some(u64::MAX), ..options() }).contains("run shorter"));
    assert!(matches!(Core::new(&build().source("none.v"), &options()), Err(CoreError::Build(_))));
}
