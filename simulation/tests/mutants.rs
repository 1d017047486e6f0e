//! Faults put into the emitted Verilog must be found, and the report must point at their stage.
//!
//! `MUTANTS=300 MUTANTS_REPORT=rtl/MUTANTS.md cargo test -p hoverlock-simulation --test mutants
//! mutants_do_not_survive -- --ignored --nocapture` puts in as many and writes the table that is committed; without the
//! variables it is a sample. Further tests do the same to the other shipped designs, in the modules whose text is not
//! that of the default design.

mod corner;
mod harmless;
mod mutation;
mod port_bench;
mod sequence;
mod three_way;

use hoverlock_fixed_point::model::design::camera_samples;
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use corner::CORNERS;
use harmless::{reason, reason_in_another_design};
use hoverlock_design::{DesignPoint, KT27};
use hoverlock_formal::{
    claim::Claim,
    engine::Solver,
    prove::{FaultySource, Place, Status, holds_with},
    shipped,
};
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::emission::{committed, verilog::verilog};
use hoverlock_simulation::{Fault, Job, Simulator, Streams, run};
use mutation::{Kind, Mutant, Source};
use port_bench::{abrupt::targets_within_bins, ground, lattice, most, noise, scenarios::SCENARIOS};
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

/// Few frames, small and nasty: every kind of content, sizes that change, frames with faults, new coefficients.
fn torture(design: &DesignPoint) -> Vec<Job> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut jobs = Vec::new();
    // Thresholds in 0.5 DN.
    let mut add = |pixels: Plane<u16>, [fine, coarse]: [u32; 2]| {
        let code = |half_dn: &u32| (f64::from(*half_dn) * 0.5 / design.dog().lsb()).max(1.0) as u32;
        let codes: Vec<u32> = [fine, coarse, coarse][..design.pairs()].iter().map(code).collect();
        jobs.push(Job::of(design, camera_samples(design, &pixels), codes).unwrap());
        jobs.len() - 1
    };
    add(noise(64, 64, 1), [60, 45]);
    let other = add(noise(64, 64, 2), [20, 20]);
    // White and black spots: the largest responses there are.
    let spots = |w: usize, h: usize| Plane::from_fn(w, h, |x, y| if (x / 9 + y / 7) % 2 == 0 { 0 } else { 0xffff });
    let strong = add(spots(64, 64), [900, 700]);
    let short = add(noise(66, 64, 3), [60, 45]);
    // Few grey levels: ties, and responses equal to the threshold.
    add(Plane::from_fn(66, 64, |_, _| 30_000 + random.random_range(0..60u16)), [4, 3]);
    let long = add(noise(66, 64, 4), [30, 30]);
    let interrupted = add(noise(66, 64, 5), [1, 1]);
    add(noise(80, 70, 6), [1, 1]);
    let impulse = |x: usize, y: usize| if (x * 7 + y * 13).is_multiple_of(101) { 0xffff } else { 0 };
    add(Plane::from_fn(80, 70, impulse), [1, 1]);
    add(Plane::filled(80, 70, 0xffff), [1, 1]);
    add(spots(80, 70), [1, 1]);
    // Discs, white on black and black on white: responses near the largest value in both scale pairs, far above what is
    // around.
    let disc = |x: usize, y: usize, radius: usize| {
        [(24, 24), (56, 24), (40, 46)]
            .iter()
            .any(|(a, b)| x.abs_diff(*a).pow(2) + y.abs_diff(*b).pow(2) <= radius * radius)
    };
    for (radius, inside, outside) in [(6, 0xffff, 0), (7, 0, 0xffff), (3, 0xffff, 0)] {
        add(Plane::from_fn(80, 70, |x, y| if disc(x, y, radius) { inside } else { outside }), [1000, 1000]);
    }
    for grey in [20, 60, 200] {
        add(Plane::from_fn(128, 80, |_, _| 30_000 + random.random_range(0..grey)), [1, 1]);
    }
    // 1, 0.964, 0.928, ..
    let fall = |i: u32| most(design) - (u64::from(most(design)) * 2345 * u64::from(i) / 65_535) as u32;
    jobs[other].coefficients.iter_mut().enumerate().for_each(|(i, raw)| *raw = fall(i as u32));
    jobs[strong].coefficients[..=design.look_ahead[0] as usize].fill(most(design));
    jobs[short].fault = Fault::Short(700);
    jobs[long].fault = Fault::Long(9);
    jobs[interrupted].fault = Fault::Interrupted(3000);
    jobs
}

/// Jobs for what the others leave, by name. The widest and the highest frame use the upper bits of positions and
/// counters, which small frames do not. Drawn targets put the automatic threshold between the edges of bins.
fn further(design: &DesignPoint) -> [(&'static str, Vec<Job>); 3] {
    let thresholds = if *design == *KT27 { vec![60, 45] } else { vec![1; design.pairs()] };
    let job = |w: usize, h: usize, seed: u64| Job::of(design, ground(design, w, h, seed), thresholds.clone()).unwrap();
    let widest = design.width as usize;
    let points = Job::of(design, camera_samples(design, &lattice(widest, 64)), vec![1; design.pairs()]).unwrap();
    [
        ("targets", targets_within_bins(design, 12, 23)),
        ("large frames", vec![job(widest - 24, 64, 1), points]),
        ("large frames", vec![job(64, 2048, 3), job(64, 64, 4)]),
    ]
}

/// The stages that reports name, in the order of the pipeline; what is seen from outside only comes last.
fn rank(stage: &str) -> usize {
    const ORDER: [(&str, usize); 6] =
        [("smoother", 1), ("DoG", 2), ("MaxDOG", 3), ("decision", 4), ("record", 5), ("descriptor", 5)];
    ORDER.iter().find(|(name, _)| stage.starts_with(name)).map_or(6, |(_, rank)| *rank)
}

/// The first stage that a module can disturb, by the longest beginning of its name that fits.
fn stage_of(module: &str) -> usize {
    const STAGES: [(&str, usize); 23] = [
        ("", 1),
        ("scale_pair", 2),
        ("difference", 2),
        ("signed_response", 2),
        ("line_delay(16, 6,", 3),
        ("flag_delay(8)", 3),
        ("column_maximum", 3),
        ("window_maximum", 3),
        ("window_maximum(15, 7)", 4),
        ("window_maximum(15, 3)", 4),
        ("maximum", 4),
        ("delay(15,", 4),
        ("eligible", 4),
        ("decision", 4),
        ("threshold", 4),
        ("candidate", 4),
        ("neighbours", 5),
        ("ring", 5),
        ("line_delay(16, 28,", 5),
        ("line_delay(16, 32,", 5),
        ("record_writer", 4),
        ("record_fifo", 4),
        ("record_limit", 4),
    ];
    STAGES
        .iter()
        .filter(|(name, _)| module.starts_with(name))
        .max_by_key(|(name, _)| name.len())
        .map_or(1, |(_, rank)| *rank)
}

/// Runs all checks on a model. Returns the first that failed and the stage it named.
fn checks(simulator: &Simulator, jobs: &[Job], further: &[(&str, Vec<Job>)], module: &str) -> Option<(String, String)> {
    let chain = |check: &str, jobs: &[Job], pause: f64| {
        let streams = Streams { source_pause: pause, sink_pause: pause, ..Streams::default() };
        match run(simulator, jobs, streams) {
            Ok(outcome) if outcome.pass() => None,
            Ok(outcome) => {
                let stage = outcome.first_mismatch.map_or("nothing compared".to_owned(), |first| first.stage);
                Some((check.to_owned(), stage))
            }
            Err(error) => Some((check.to_owned(), format!("{error}"))),
        }
    };
    if let Some(found) = chain("chain", jobs, 0.0).or_else(|| chain("chain, pauses", jobs, 0.25)) {
        return Some(found);
    }
    for (name, scenario) in SCENARIOS.into_iter().chain(CORNERS) {
        if let Err(failure) = scenario(simulator) {
            return Some((name.into(), failure.stage.into()));
        }
    }
    if let Err(failed) = sequence::campaign(simulator, 1, 40) {
        return Some(("sequences".into(), failed.what.stage.into()));
    }
    // The check of the cell itself drives its ports with inputs that no frame produces.
    three_way::drive_only(module, simulator.plusargs());
    // The cells of other designs are not built for this check.
    let is_default = *simulator.design() == *KT27;
    let fails = |check: fn()| is_default && catch_unwind(check).is_err();
    if three_way::CHECKS.iter().chain(&three_way::structure::CHECKS).any(|(_, check)| fails(*check)) {
        return Some(("cell".into(), module.into()));
    }
    further.iter().find_map(|(name, jobs)| chain(name, jobs, 0.0))
}

/// The check that reads the files instead of running them.
const LINTER: &str = "Verilator";

struct Verdict {
    mutant: Mutant,
    found: Option<(String, String)>,
    reason: Option<String>,
}

#[test]
#[ignore = "long: hundreds of faults, a second or more each"]
fn mutants_do_not_survive() {
    let sources = mutation::read(&committed().unwrap());
    let all = mutation::all(&sources);
    survivors(&KT27, "mutants", 20, &sources, &all);
}

macro_rules! mutants_of {
    ($($test:ident: $design:literal;)*) => {$(
        #[test]
        #[ignore = "long: as many faults in another design"]
        fn $test() {
            mutants_of_another_design($design);
        }
    )*};
}

mutants_of! {
    mutants_of_hd1080_do_not_survive: "hd1080";
    mutants_of_small_do_not_survive: "small";
    mutants_of_three_scales_do_not_survive: "three_scales";
}

/// In the modules whose text is not that of the default design: the others are tested with it, and more sharply.
fn mutants_of_another_design(name: &str) {
    let design = DesignPoint::shipped(name).unwrap();
    let sources = mutation::read(&verilog(&design, None).unwrap());
    let default = mutation::read(&committed().unwrap());
    // With other numbers a module is another one.
    let known: BTreeSet<String> = mutation::all(&default).into_iter().map(|mutant| mutant.module).collect();
    let differs = |mutant: &Mutant| {
        let text = |sources: &[Source]| sources.iter().find(|s| s.module == mutant.file).map(|s| s.text.clone());
        !known.contains(&mutant.module) || text(&sources) != text(&default)
    };
    let all: Vec<Mutant> = mutation::all(&sources).into_iter().filter(differs).collect();
    survivors(&design, &format!("mutants-{name}"), 12, &sources, &all);
}

/// Puts as many faults as are asked for, or `sample`, into the Verilog of a design; fails where one is neither found
/// nor explained.
fn survivors(design: &DesignPoint, name: &str, sample: usize, sources: &[Source], all: &[Mutant]) {
    let count: usize = std::env::var("MUTANTS").ok().and_then(|text| text.parse().ok()).unwrap_or(sample);
    let seed: u64 = std::env::var("MUTANTS_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let mutants = mutation::choose(all, count, seed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{count}-{seed}"));
    let faulty = mutation::write(&folder, sources, &mutants);
    if *design == *KT27 {
        three_way::drive_others(&faulty, &folder);
    }
    let model = Simulator::of(design, &faulty).expect("the faults build");
    let (jobs, further) = (torture(design), further(design));
    let choose = |number: usize| model.clone().with_plusargs(vec![format!("+MUTANT={number}")]);
    // The control: with no fault chosen nothing is found.
    assert_eq!(checks(&choose(0), &jobs, &further, "lerp"), None);
    // A failed check panics; every mutant that is found makes one.
    std::panic::set_hook(Box::new(|_| ()));

    let next = AtomicUsize::new(0);
    let verdicts: Mutex<Vec<(usize, Verdict)>> = Mutex::default();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(mutant) = mutants.get(at) else { break };
                    let found =
                        catch_unwind(AssertUnwindSafe(|| checks(&choose(at + 1), &jobs, &further, &mutant.module)))
                            .unwrap_or_else(|_| Some(("bench".into(), "stopped".into())));
                    let why = if *design == *KT27 { reason } else { reason_in_another_design };
                    let reason = found.is_none().then(|| why(sources, mutant)).flatten();
                    let found = found.or_else(|| reason.is_none().then(|| by_lint(sources, mutant)).flatten());
                    let said = match (&found, &reason) {
                        (Some((check, stage)), _) => format!("{check}: {stage}"),
                        (None, Some(reason)) => format!("survives, {reason}"),
                        (None, None) => "SURVIVES".into(),
                    };
                    let Mutant { module, line, kind, original, fault, .. } = mutant;
                    eprintln!("{module}:{line}: {}: `{original}` as `{fault}`: {said}", kind.name());
                    verdicts.lock().unwrap().push((at, Verdict { mutant: mutant.clone(), found, reason }));
                }
            });
        }
    });
    let mut verdicts = verdicts.into_inner().unwrap();
    verdicts.sort_by_key(|(at, _)| *at);
    let verdicts: Vec<Verdict> = verdicts.into_iter().map(|(_, verdict)| verdict).collect();
    drop(std::panic::take_hook());
    if let Some(path) = std::env::var_os("MUTANTS_REPORT") {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        std::fs::write(root.join(path), report(&verdicts, all.len(), seed)).unwrap();
    }
    let describe = |verdict: &&Verdict| {
        let Mutant { module, line, original, fault, .. } = &verdict.mutant;
        format!("{module}:{line}: `{original}` as `{fault}`: {:?}\n", verdict.found)
    };
    let early: String = verdicts.iter().filter(|verdict| !points_right(verdict)).map(|v| describe(&v)).collect();
    assert!(early.is_empty(), "found in a stage before the fault's own:\n{early}");
    let open: String =
        verdicts.iter().filter(|v| v.found.is_none() && v.reason.is_none()).map(|v| describe(&v)).collect();
    assert!(open.is_empty(), "unexplained survivors:\n{open}");
}

/// The linter as the check that finds a fault, where no simulation does and nothing shows that it is harmless.
fn by_lint(sources: &[Source], mutant: &Mutant) -> Option<(String, String)> {
    mutation::is_refused_by_lint(sources, mutant).then(|| (LINTER.into(), "lint".into()))
}

/// The stage that was named is the fault's own or a later one.
fn points_right(verdict: &Verdict) -> bool {
    let Some((check, stage)) = &verdict.found else { return true };
    if check == LINTER {
        return true;
    }
    if check == "cell" {
        return *stage == verdict.mutant.module;
    }
    let module = verdict.mutant.at.as_ref().unwrap_or(&verdict.mutant.module);
    rank(stage) >= stage_of(module)
}

/// The document: what was put in, what found it, what survived and why.
fn report(verdicts: &[Verdict], all: usize, seed: u64) -> String {
    let mut modules: BTreeMap<&str, (usize, usize, BTreeMap<&str, usize>)> = BTreeMap::new();
    let mut kinds: BTreeMap<Kind, (usize, usize)> = BTreeMap::new();
    for verdict in verdicts {
        let (faults, killed, by) = modules.entry(&verdict.mutant.module).or_default();
        let kind = kinds.entry(verdict.mutant.kind).or_default();
        *faults += 1;
        kind.0 += 1;
        if let Some((_, stage)) = &verdict.found {
            *killed += 1;
            kind.1 += 1;
            *by.entry(stage).or_default() += 1;
        }
    }
    let killed = verdicts.iter().filter(|verdict| verdict.found.is_some()).count();
    let mut text = format!(
        "# Mutation test of the Verilog\n\n{} faults of {all} possible ones, seed {seed}, at least one in every \
         module: {killed} found, {} harmless. No report named a stage before the fault's own.\n\nMade by\n\n```\n\
         MUTANTS={} MUTANTS_SEED={seed} MUTANTS_REPORT=rtl/MUTANTS.md \
         cargo test -p hoverlock-simulation --test mutants mutants_do_not_survive -- --ignored --nocapture\n```\n\n",
        verdicts.len(),
        verdicts.len() - killed,
        verdicts.len()
    );
    text += "| kind | faults | found |\n|---|---|---|\n";
    for (kind, (faults, killed)) in &kinds {
        writeln!(text, "| {} | {faults} | {killed} |", kind.name()).unwrap();
    }
    text += "\n| module | faults | found | where the report pointed |\n|---|---|---|---|\n";
    for (module, (faults, killed, by)) in &modules {
        let by: Vec<_> = by.iter().map(|(stage, n)| format!("{stage} {n}")).collect();
        writeln!(text, "| {module} | {faults} | {killed} | {} |", by.join(", ")).unwrap();
    }
    text += "\n## Survivors\n\n| module | line | fault | why it is harmless |\n|---|---|---|---|\n";
    for verdict in verdicts.iter().filter(|verdict| verdict.found.is_none()) {
        let reason = verdict.reason.as_deref().unwrap_or("**not known**");
        writeln!(text, "{}{reason} |", survivor(&verdict.mutant)).unwrap();
    }
    text
}

/// A fault as the first cells of its row in a table.
fn survivor(mutant: &Mutant) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let Mutant { module, line, original, fault, .. } = mutant;
    format!("| {module} | {line} | `{}` as `{}` | ", cell(original), cell(fault))
}

/// The survivors of the committed table: each is proved harmless again, by the claim that its row names.
/// `MUTANTS_REASONS=1` writes their reasons again.
#[test]
#[ignore = "long: minutes of proofs"]
fn survivors_are_harmless_for_the_reason_given() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/MUTANTS.md");
    let table = std::fs::read_to_string(&path).unwrap();
    let (head, rows) = table.split_once("| why it is harmless |\n|---|---|---|---|\n").expect("the table of survivors");
    let sources = mutation::read(&committed().unwrap());
    let all = mutation::all(&sources);
    let mut rewritten = format!("{head}| why it is harmless |\n|---|---|---|---|\n");
    for row in rows.lines() {
        let mutant = fault_of(&all, row).unwrap_or_else(|| panic!("no such fault in the Verilog: {row}"));
        let reason = reason(&sources, &mutant).unwrap_or_else(|| panic!("not harmless: {row}"));
        eprintln!("{}{reason}", survivor(&mutant));
        writeln!(rewritten, "{}{reason} |", survivor(&mutant)).unwrap();
    }
    if std::env::var_os("MUTANTS_REASONS").is_some() {
        std::fs::write(&path, rewritten).unwrap();
    } else {
        assert_eq!(rewritten, table, "write the reasons again with MUTANTS_REASONS=1");
    }
}

/// The fault of a row. Since the table was written its line may have moved, and a signal wired wrongly at that place
/// may be drawn as another one.
fn fault_of(all: &[Mutant], row: &str) -> Option<Mutant> {
    let line: usize = row.split(" | ").nth(1)?.parse().ok()?;
    let wrong = row.split_once("` as `")?.1.split_once("` | ")?.0;
    let same = |mutant: &Mutant| {
        let mut there = mutant.clone();
        there.line = line;
        row.starts_with(&survivor(&there))
    };
    let rewired = |mutant: &&Mutant| mutant.kind == Kind::Wiring && mutant.line == line;
    let drawn = all.iter().filter(|mutant| same(mutant)).min_by_key(|mutant| mutant.line.abs_diff(line)).cloned();
    drawn.or_else(|| {
        let mut candidates = all.iter().filter(rewired).map(|mutant| {
            let mut other = mutant.clone();
            wrong.clone_into(&mut other.fault);
            other
        });
        candidates.find(same)
    })
}

/// Faults of all kinds, each in another module.
fn thirty(all: &[Mutant]) -> Vec<Mutant> {
    let mut draw = ChaCha8Rng::seed_from_u64(30);
    let mut chosen: Vec<Mutant> = Vec::new();
    for kind in Kind::ALL.into_iter().cycle().take(30) {
        let fresh = |mutant: &&Mutant| mutant.kind == kind && chosen.iter().all(|other| other.file != mutant.file);
        let here: Vec<&Mutant> = all.iter().filter(fresh).collect();
        chosen.push((*here.choose(&mut draw).expect("a module of each kind is left")).clone());
    }
    chosen.sort();
    chosen
}

/// Thirty faults, each through all claims about its module and through the tests. `FAULTS_REPORT=formal/FAULTS.md`
/// writes the table.
#[test]
#[ignore = "long: proofs and simulations of thirty faults"]
fn each_of_thirty_faults_is_found_by_a_proof_or_a_test() {
    let sources = mutation::read(&committed().unwrap());
    let mutants = thirty(&mutation::all(&sources));
    let proofs: Vec<String> = mutants.iter().map(|mutant| by_proof(&sources, mutant)).collect();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("thirty-faults");
    let faulty = mutation::write(&folder, &sources, &mutants);
    three_way::drive_others(&faulty, &folder);
    let model = Simulator::of(&KT27, &faulty).expect("the faults build");
    let (jobs, further) = (torture(&KT27), further(&KT27));
    let choose = |number: usize| model.clone().with_plusargs(vec![format!("+MUTANT={number}")]);
    assert_eq!(checks(&choose(0), &jobs, &further, "lerp"), None);
    std::panic::set_hook(Box::new(|_| ()));
    let mut rows = String::new();
    let (mut by_claims, mut by_tests, mut open) = (0, 0, Vec::new());
    for (at, (mutant, proof)) in mutants.iter().zip(&proofs).enumerate() {
        let found = catch_unwind(AssertUnwindSafe(|| checks(&choose(at + 1), &jobs, &further, &mutant.module)))
            .unwrap_or_else(|_| Some(("bench".into(), "stopped".into())));
        let why = found.is_none().then(|| reason(&sources, mutant)).flatten();
        let found = found.or_else(|| why.is_none().then(|| by_lint(&sources, mutant)).flatten());
        let seen = proof.contains("refuted") || proof.contains("unproved");
        by_claims += usize::from(seen);
        by_tests += usize::from(found.is_some());
        let test = match &found {
            Some((check, stage)) => format!("{check}: {stage}"),
            None => why.map_or_else(|| "none".into(), |reason| format!("harmless: {reason}")),
        };
        if !seen && test == "none" {
            open.push(survivor(mutant));
        }
        let row = format!("{}{} | {proof} | {test} |", survivor(mutant), mutant.kind.name());
        eprintln!("{row}");
        rows += &(row + "\n");
    }
    drop(std::panic::take_hook());
    let text = format!(
        "# Thirty faults, and what finds each\n\n\
         Faults of all twelve kinds, each in another module of the emitted Verilog, drawn with a fixed seed. *Proof*: \
         the first of the claims about the module that fails with the fault, refuted by a run or unproved, and its \
         time; claims that compare a module with its own text are left out. *Test*: the first check of \
         `simulation/tests/mutants.rs` that fails, and the stage that it names. {by_claims} are found by a proof, \
         {by_tests} by a test.\n\nMade by\n\n```\nFAULTS_REPORT=formal/FAULTS.md \
         cargo test -p hoverlock-simulation --test mutants each_of_thirty -- --ignored --nocapture\n```\n\n\
         | module | line | fault | kind | proof | test |\n|---|---|---|---|---|---|\n{rows}"
    );
    if let Some(path) = std::env::var_os("FAULTS_REPORT") {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        std::fs::write(root.join(path), text).unwrap();
    }
    assert!(open.is_empty(), "found by nothing:\n{}", open.join("\n"));
}

/// The first claim that sees a fault, or which ones hold with it.
fn by_proof(sources: &[mutation::Source], mutant: &Mutant) -> String {
    let file = format!("{}.v", mutant.file);
    let source = sources.iter().find(|source| source.module == mutant.file).unwrap();
    let fault = FaultySource { file: file.clone(), text: mutation::by_hand(source, mutant) };
    let out = tempfile::tempdir().unwrap();
    let place = Place {
        sources: harmless::verilog(),
        out: out.path(),
        limit: Duration::from_secs(120),
        solver: Solver::default(),
    };
    let mut hold = Vec::new();
    let about = |claim: &&Claim| {
        // A claim that compares a module with its own text sees any fault, and says nothing.
        claim.golden.is_empty() && claim.sources.contains(&file) && !claim.cut.contains(&mutant.file)
    };
    for claim in shipped::claims().unwrap().iter().filter(about) {
        let outcome = holds_with(claim, &fault, &place).unwrap();
        match outcome.status {
            Status::Refuted => return format!("`{}` refuted, {:.1} s", claim.name, outcome.seconds),
            Status::Unproved => return format!("`{}` unproved, {:.1} s", claim.name, outcome.seconds),
            Status::Timeout => hold.push(format!("`{}` not decided in 120 s", claim.name)),
            _ => hold.push(format!("`{}` holds", claim.name)),
        }
    }
    if hold.is_empty() { "no claim".into() } else { hold.join(", ") }
}
