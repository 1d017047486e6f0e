//! Faults put into the emitted Verilog must be found, and the report must point at their stage.
//!
//! `MUTANTS=300 MUTANTS_REPORT=rtl/MUTANTS.md cargo test -p hoverlock-rtl --test mutants -- --ignored --nocapture` puts
//! in as many and writes the table that is committed; without the variables it is a sample. A second test does the same
//! to the design `small`, in the modules whose text is not that of the default design.

mod corner;
mod mutation;
mod port_bench;
mod sequence;
mod three_way;

use std::{
    collections::BTreeMap,
    fmt::Write,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use corner::{CORNERS, OF_ANY_DESIGN};
use hoverlock_fixed_point::model::design::{DesignPoint, KT27};
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::{
    emission::{committed, verilog::verilog},
    simulation::{Fault, Job, Simulator, Streams, run},
};
use mutation::{Kind, Mutant, Source, is_proved_equivalent};
use port_bench::{ground, lattice, most, noise, scenarios::SCENARIOS};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Few frames, small and nasty: every kind of content, sizes that change, frames with faults, new coefficients.
fn torture(design: &DesignPoint) -> Vec<Job> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut jobs = Vec::new();
    // Thresholds in 0.5 DN.
    let mut add = |pixels: Plane<u16>, thresholds: [u32; 2]| {
        let codes = thresholds.map(|half_dn| (f64::from(half_dn) * 0.5 / design.dog().lsb()).max(1.0) as u32);
        jobs.push(Job::of(design, design.samples(&pixels), codes).unwrap());
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

/// The widest and the highest frame: they use the upper bits of positions and counters, which small frames do not.
fn large(design: &DesignPoint) -> [Vec<Job>; 2] {
    let thresholds = if *design == KT27 { [60, 45] } else { [1, 1] };
    let job = |w: usize, h: usize, seed: u64| Job::of(design, ground(design, w, h, seed), thresholds).unwrap();
    let widest = design.width as usize;
    let points = Job::of(design, design.samples(&lattice(widest, 64)), [1, 1]).unwrap();
    [vec![job(widest - 24, 64, 1), points], vec![job(64, 2048, 3), job(64, 64, 4)]]
}

/// The stages that reports name, in the order of the pipeline; what is seen from outside only comes last.
fn rank(stage: &str) -> usize {
    const ORDER: [(&str, usize); 6] =
        [("smoother", 1), ("DoG", 2), ("MaxDOG", 3), ("decision", 4), ("record", 5), ("descriptor", 5)];
    ORDER.iter().find(|(name, _)| stage.starts_with(name)).map_or(6, |(_, rank)| *rank)
}

/// The first stage that a module can disturb, by the longest beginning of its name that fits.
fn stage_of(module: &str) -> usize {
    const STAGES: [(&str, usize); 22] = [
        ("", 1),
        ("scale_pair", 2),
        ("difference", 2),
        ("signed_response", 2),
        ("line_delay_16x6", 3),
        ("flag_delay_8", 3),
        ("column_maximum", 3),
        ("window_maximum", 3),
        ("window_maximum_7", 4),
        ("window_maximum_3", 4),
        ("maximum", 4),
        ("delay_15x", 4),
        ("eligible", 4),
        ("decision", 4),
        ("threshold", 4),
        ("candidate", 4),
        ("neighbours", 5),
        ("ring", 5),
        ("line_delay_16x28", 5),
        ("line_delay_16x32_taps", 5),
        ("record_writer", 4),
        ("record_fifo", 4),
    ];
    STAGES
        .iter()
        .filter(|(name, _)| module.starts_with(name))
        .max_by_key(|(name, _)| name.len())
        .map_or(1, |(_, rank)| *rank)
}

/// Runs all checks on a model. Returns the first that failed and the stage it named.
fn checks(simulator: &Simulator, jobs: &[Job], large: &[Vec<Job>; 2], module: &str) -> Option<(String, String)> {
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
    // Most rare cases, and those of the cells, are of the default design.
    let is_default = *simulator.design() == KT27;
    let corners = CORNERS.into_iter().filter(|(name, _)| is_default || OF_ANY_DESIGN.contains(name));
    for (name, scenario) in SCENARIOS.into_iter().chain(corners) {
        if let Err(failure) = scenario(simulator) {
            return Some((name.into(), failure.stage.into()));
        }
    }
    if let Err(failed) = sequence::campaign(simulator, 1, 40) {
        return Some(("sequences".into(), failed.what.stage.into()));
    }
    // The check of the cell itself drives its ports with inputs that no frame produces.
    three_way::drive_only(module, simulator.plusargs());
    let fails = |check: fn()| is_default && catch_unwind(check).is_err();
    if three_way::CHECKS.iter().chain(&three_way::structure::CHECKS).any(|(_, check)| fails(*check)) {
        return Some(("cell".into(), module.into()));
    }
    large.iter().find_map(|jobs| chain("large frames", jobs, 0.0))
}

/// Survivors that have a reason: the beginning of the module's name, or of the instance's, kinds, a part of the
/// original text, a part of the fault, the reason.
type Harmless = (&'static str, &'static [Kind], &'static str, &'static str, &'static str);

const RESETS: &[Kind] = &[Kind::Reset, Kind::ResetValue];
const POSITION: &str = "the address of a circular memory may begin anywhere: it wraps within 32 steps, and the first \
                        sample that counts comes 31 lines after a reset";
const ROWS: &str =
    "data in the rows at a reset leave them within 64 steps, and the first sample arrives there after 31 lines";
const MARKER: &str = "a marker that survives a reset is followed by the marker of the next frame: it only loads the \
                      coefficient of that frame early";
const COUNTS: &str = "no frame has 2^19 features: 2^21 pixels, one maximum in 16 at most, two scale pairs";
const HARMLESS: &[Harmless] = &[
    ("delay_*", RESETS, "", "", POSITION),
    ("ring_taps*", RESETS, "", "", POSITION),
    (
        "ring_taps*",
        &[Kind::Memory],
        "_memory[",
        "_position]",
        "the addresses of two memories of one length are equal, both begin at 0",
    ),
    ("ring_taps*", &[Kind::Comparison], "_position == ", "_position >= ", "an address never exceeds the last one"),
    ("row_look_back*", RESETS, "", "", ROWS),
    ("row_look_ahead*", RESETS, "", "", ROWS),
    ("pulse_delay*", RESETS, "", "", ROWS),
    ("flag_delay_4", RESETS, "", "", ROWS),
    ("flag_delay_8", RESETS, "", "", "delays the signs of ring points: data that are not used before those of a frame"),
    ("frame_delay_1x4", RESETS, "", "", MARKER),
    ("frame_delay_2x4", RESETS, "", "", MARKER),
    ("frame_delay_4x4", RESETS, "", "", MARKER),
    ("frame_delay_8x4", RESETS, "", "", MARKER),
    ("frame_delay_16x4", RESETS, "", "", MARKER),
    ("frame_delay_32x4", RESETS, "", "", MARKER),
    ("csr", &[Kind::Width], "{version_number}", ">> 1", "the top bit of the version is 0"),
    ("csr", &[Kind::Width], "{identification_letters}", ">> 1", "the top bit of a letter is 0"),
    ("extractor", &[Kind::Width], "writer_count", "", COUNTS),
    ("extractor", &[Kind::Width], "writer_dropped", "", COUNTS),
    ("hoverlock_core", &[Kind::Width, Kind::Stuck], "extractor_count", "<< 19", COUNTS),
    ("hoverlock_core", &[Kind::Width, Kind::Stuck], "extractor_dropped", "<< 19", COUNTS),
    (
        "sequencer",
        &[Kind::Stuck, Kind::Width],
        "new_width",
        "",
        "wider frames are refused, so none has the highest bit",
    ),
    ("sequencer", RESETS, "1'd0", "", "x and y are set as a frame begins, before they count"),
    ("sequencer", RESETS, "3'd0", "own", "the error bits of a frame are cleared as the next begins"),
    ("tail_counter", RESETS, "10'd0", "x", "x is set as the tail begins, before it counts"),
    (
        "row_look_ahead*",
        &[Kind::Operator],
        "remaining - ",
        "remaining + ",
        "the count begins at half of its range: counting up or down, it is 0 after the same number of steps",
    ),
    ("row_look_back*", &[Kind::Wiring], "reset", "first_delay_y", "the flag comes when the count is 0 already"),
    ("column_look_ahead*", RESETS, "", "", MARKER),
    ("smoother_5", &[Kind::Stuck], "column_start_y", "", "only the columns_done of the wide smoother is used"),
];

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
    survivors(&KT27, "mutants", &sources, &all);
}

#[test]
#[ignore = "long: as many faults in another design"]
fn mutants_of_another_design_do_not_survive() {
    let design = DesignPoint::shipped("small").unwrap().unwrap();
    let sources = mutation::read(&verilog(&design, None).unwrap());
    let default = mutation::read(&committed().unwrap());
    // The others are tested with the default design, and more sharply.
    let differs = |mutant: &Mutant| {
        let text = |sources: &[Source]| sources.iter().find(|s| s.module == mutant.module).map(|s| s.text.clone());
        text(&sources) != text(&default)
    };
    let all: Vec<Mutant> = mutation::all(&sources).into_iter().filter(differs).collect();
    survivors(&design, "mutants-small", &sources, &all);
}

/// Puts as many faults as are asked for into the Verilog of a design; fails where one is neither found nor explained.
fn survivors(design: &DesignPoint, name: &str, sources: &[Source], all: &[Mutant]) {
    let count: usize = std::env::var("MUTANTS").ok().and_then(|text| text.parse().ok()).unwrap_or(20);
    let seed: u64 = std::env::var("MUTANTS_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(1);
    let mutants = mutation::choose(all, count, seed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{count}-{seed}"));
    let faulty = mutation::write(&folder, sources, &mutants);
    if *design == KT27 {
        three_way::drive_others(&faulty, &folder);
    }
    let model = Simulator::of(design, &faulty).expect("the faults build");
    let (jobs, large) = (torture(design), large(design));
    let choose = |number: usize| model.clone().with_plusargs(vec![format!("+MUTANT={number}")]);
    // The control: with no fault chosen nothing is found.
    assert_eq!(checks(&choose(0), &jobs, &large, "lerp"), None);
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
                        catch_unwind(AssertUnwindSafe(|| checks(&choose(at + 1), &jobs, &large, &mutant.module)))
                            .unwrap_or_else(|_| Some(("bench".into(), "stopped".into())));
                    let reason = found.is_none().then(|| reason(sources, mutant)).flatten();
                    let said = match (&found, &reason) {
                        (Some((check, stage)), _) => format!("{check}: {stage}"),
                        (None, Some(reason)) => format!("survives, {reason}"),
                        (None, None) => "SURVIVES".into(),
                    };
                    let Mutant { module, line, kind, original, fault, .. } = mutant;
                    eprintln!("{module}.v:{line}: {}: `{original}` as `{fault}`: {said}", kind.name());
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
        format!("{module}.v:{line}: `{original}` as `{fault}`: {:?}\n", verdict.found)
    };
    let early: String = verdicts.iter().filter(|verdict| !points_right(verdict)).map(|v| describe(&v)).collect();
    assert!(early.is_empty(), "found in a stage before the fault's own:\n{early}");
    let open: String =
        verdicts.iter().filter(|v| v.found.is_none() && v.reason.is_none()).map(|v| describe(&v)).collect();
    assert!(open.is_empty(), "unexplained survivors:\n{open}");
}

/// The stage that was named is the fault's own or a later one.
fn points_right(verdict: &Verdict) -> bool {
    let Some((check, stage)) = &verdict.found else { return true };
    if check == "cell" {
        return *stage == verdict.mutant.module;
    }
    let module = verdict.mutant.at.as_ref().unwrap_or(&verdict.mutant.module);
    rank(stage) >= stage_of(module)
}

fn reason(sources: &[Source], mutant: &Mutant) -> Option<String> {
    let at = mutant.at.as_ref().unwrap_or(&mutant.module);
    let fits = |(module, kinds, original, fault, _): &&Harmless| {
        module.strip_suffix('*').map_or(at == module, |family| at.starts_with(family))
            && kinds.contains(&mutant.kind)
            && mutant.original.contains(original)
            && mutant.fault.contains(fault)
    };
    let known = HARMLESS.iter().find(fits).map(|(.., reason)| (*reason).to_owned());
    known.or_else(|| is_proved_equivalent(sources, mutant).then(|| "Yosys proves both equivalent".to_owned()))
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
         cargo test -p hoverlock-rtl --test mutants -- --ignored --nocapture\n```\n\n",
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
        let Mutant { module, line, original, fault, .. } = &verdict.mutant;
        let reason = verdict.reason.as_deref().unwrap_or("**not known**");
        let cell = |text: &str| text.replace('|', "\\|");
        writeln!(text, "| {module} | {line} | `{}` as `{}` | {reason} |", cell(original), cell(fault)).unwrap();
    }
    text
}
