//! Faults put into the emitted Verilog must be found: seeded mutants through the gate of the chain.
//!
//! `MUTANTS=200 cargo test -p hoverlock-rtl --release --test mutants -- --ignored --nocapture` makes as many; 20 are the sample.

use std::{collections::BTreeSet, path::Path};

use hoverlock_reference::plane::Plane;
use hoverlock_rtl::{
    emit::files,
    simulation::{Fault, Job, Simulator, Streams, run},
};
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

/// What a fault exchanges for what.
const FAULTS: [(&str, &str); 9] = [
    (" > ", " >= "),
    (" >= ", " > "),
    (" + ", " - "),
    (" - ", " + "),
    (" & ", " | "),
    (" | ", " & "),
    ("'d1;", "'d0;"),
    (" == ", " != "),
    ("~", ""),
];

/// Survivors that have a reason: module, fault, a part of the line, the reason.
const HARMLESS: [(&str, &str, &str, &str); 4] = [
    ("window_maximum", " > ", " ? ", "the larger of two equal words is either"),
    ("column_maximum", " > ", " ? ", "the larger of two equal words is either"),
    ("maximum", " > ", " ? ", "the larger of two equal words is either"),
    (
        "sequencer",
        " - ",
        "settle <=",
        "waits one cycle in place of three: enough in simulation, three give a slow path its time",
    ),
];

fn noise(seed: u64) -> Plane<u16> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Plane::from_fn(66, 64, |x, y| ((x * 311 + y * 173) % 30_000) as u16 + random.random_range(0..30_000u16))
}

#[test]
#[ignore = "long: a Verilated model for each mutant"]
fn mutants_do_not_survive() {
    let count: usize = std::env::var("MUTANTS").ok().and_then(|text| text.parse().ok()).unwrap_or(20);
    let files = files().unwrap();
    let files: Vec<_> = files.iter().filter(|file| file.path.ends_with(".v")).collect();
    let mut jobs: Vec<Job> = (0..5).map(|seed| Job::new(noise(seed), [60, 45]).unwrap()).collect();
    jobs[1].coefficients.iter_mut().enumerate().for_each(|(i, code)| *code = 30_000 + 1234 * i as u32);
    jobs[2].fault = Fault::Short(700);
    jobs[3].fault = Fault::Long(9);
    // Few grey levels: ties, and responses equal to the threshold.
    let mut random = ChaCha8Rng::seed_from_u64(11);
    jobs[4].pixels = Plane::from_fn(66, 64, |_, _| 30_000 + random.random_range(0..60u16));
    jobs[4].thresholds = [4, 3];
    let mut draw = ChaCha8Rng::seed_from_u64(4);
    let mut seen = BTreeSet::new();
    let mut survivors = Vec::new();
    while seen.len() < count {
        let at = draw.random_range(0..files.len());
        let (from, to) = FAULTS.choose(&mut draw).copied().unwrap();
        let text = &files[at].text;
        let body = text.find("\nmodule ").unwrap_or_default();
        let places: Vec<usize> = text[body..].match_indices(from).map(|(i, _)| body + i).collect();
        let unread = |place: &usize| text[..*place].lines().last().is_some_and(|line| line.contains("wire unused"));
        let Some(&place) = places.choose(&mut draw).filter(|place| !unread(place)) else { continue };
        if !seen.insert((at, place, to)) {
            continue;
        }
        let line = text[..place].lines().last().unwrap_or_default().to_owned()
            + text[place..].lines().next().unwrap_or_default();
        let mutant = format!("{}{to}{}", &text[..place], &text[place + from.len()..]);
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutant");
        std::fs::create_dir_all(&folder).unwrap();
        let sources: Vec<_> = files
            .iter()
            .enumerate()
            .map(|(i, file)| {
                let path = folder.join(file.path.trim_start_matches("verilog/"));
                std::fs::write(&path, if i == at { &mutant } else { &file.text }).unwrap();
                path
            })
            .collect();
        let name = files[at].path.trim_start_matches("verilog/");
        let verdict = match Simulator::of(&sources) {
            Err(_) => "does not build".to_owned(),
            Ok(simulator) => {
                let pauses = Streams { source_pause: 0.1, sink_pause: 0.1, ..Streams::default() };
                let faults = run(&simulator, &jobs, pauses);
                let full = run(&simulator, &jobs[..2], Streams { sink_opens: 20_000, ..Streams::default() });
                match (faults, full) {
                    (Ok(a), Ok(b)) if a.pass() && b.pass() && a.status & 0xff == 0x87 => "survives".to_owned(),
                    (Ok(a), Ok(b)) => {
                        let first = a.first_mismatch.or(b.first_mismatch).map(|m| m.stage);
                        format!("found in {}", first.unwrap_or_else(|| "status".into()))
                    }
                    (a, b) => format!("found: {}", a.err().or(b.err()).unwrap()),
                }
            }
        };
        eprintln!("{name}: `{}` with `{to}`: {verdict}", line.trim());
        let reason = HARMLESS
            .iter()
            .find(|(module, fault, part, _)| name.starts_with(module) && from == *fault && line.contains(part));
        if verdict == "survives" {
            match reason {
                Some((.., reason)) => eprintln!("  harmless: {reason}"),
                None => survivors.push(format!("{name}: `{}` with `{to}`", line.trim())),
            }
        }
    }
    assert!(survivors.is_empty(), "unexplained survivors:\n{}", survivors.join("\n"));
}
