//! What the memories may return where one address is read and written in one clock. Block memories: anything. The small
//! memories of delays and ring taps: the old word, so their attribute must not leave that open.
//!
//! Reads in the committed Verilog get garbage, chosen by `+GARBAGE=n`.

use std::{fs, path::Path};

use hoverlock_design::KT27;
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::emission::committed;
use hoverlock_simulation::{Fault, Job, Simulator, Streams, run};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Garbage where a block memory reads what it writes.
const COLLISIONS: usize = 1;

/// Block memories: the start of the module's name, and when a read meets a write.
const BLOCKS: [(&str, &str); 5] = [
    ("line_delay", "address == write_address"),
    ("column_memory", "address == write_address"),
    ("held_row", "write & (address == write_address)"),
    ("candidate_queue", "push & (read_address == write_address)"),
    ("record_fifo", "write & (read_address == write_address)"),
];

/// Small memories: every read meets a write.
const SMALL: [&str; 2] = ["delay.v", "ring_taps_"];

/// The number that puts garbage into every read of a kind of module.
fn always(kind: usize) -> usize {
    COLLISIONS + 1 + kind
}

/// Target of a read, `target <= memory[address];`.
fn read(line: &str) -> Option<&str> {
    let (target, word) = line.trim().split_once(" <= ")?;
    let memory = word.split_once('[')?.0;
    (memory.ends_with("memory") && word.ends_with("];")).then_some(target)
}

/// The Verilog with its garbage asleep, and how many reads of each kind have it.
fn simulator() -> (Simulator, Vec<usize>) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("memories");
    fs::create_dir_all(&folder).unwrap();
    let kinds: Vec<(&str, &str)> = BLOCKS.into_iter().chain(SMALL.map(|name| (name, "1'b0"))).collect();
    let mut counts = vec![0; kinds.len()];
    let sources = committed().unwrap().into_iter().map(|source| {
        let name = source.file_name().unwrap().to_str().unwrap();
        let text = fs::read_to_string(&source).unwrap();
        let Some(kind) = kinds.iter().position(|(start, _)| name.starts_with(start)) else {
            assert!(!text.lines().any(|line| read(line).is_some()), "{name} has a memory of no kind");
            return source;
        };
        let mut changed = String::new();
        for line in text.lines() {
            match read(line) {
                Some(target) => {
                    counts[kind] += 1;
                    let word = line.trim().trim_start_matches(target).trim_start_matches(" <= ");
                    let meets = format!("garbage == {COLLISIONS} & ({}) | garbage == {}", kinds[kind].1, always(kind));
                    let bits = format!("$bits({target})");
                    let garbage = format!("{bits}'({{(({bits} + 31) / 32){{$random}}}})");
                    changed += &format!("{target} <= ({meets}) ? {garbage} : {word}\n");
                }
                None => changed += &format!("{line}\n"),
            }
        }
        let body = changed.find(");\n").unwrap() + 3;
        let choice = "integer garbage;\ninitial if ($value$plusargs(\"GARBAGE=%d\", garbage) == 0) garbage = 0;\n";
        changed.insert_str(body, choice);
        let path = folder.join(name);
        if !fs::read_to_string(&path).is_ok_and(|there| there == changed) {
            fs::write(&path, changed).unwrap();
        }
        path
    });
    let sources: Vec<_> = sources.collect();
    (Simulator::of(&KT27, &sources).unwrap(), counts)
}

/// Frames of many sizes, with faults and resets: everything that moves addresses.
fn jobs(seed: u64, frames: usize) -> Vec<Job> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut size = (64, 64);
    let job = |i: usize| {
        // One in three has the size of the frame before.
        if !i.is_multiple_of(3) {
            size = (random.random_range(64..200), random.random_range(64..100));
        }
        if i == 4 {
            size = (1024, 64);
        }
        let (width, height) = size;
        let pixels =
            Plane::from_fn(width, height, |x, y| (311 * x + 173 * y) as u16 / 2 + random.random_range(0..30_000));
        let mut job = Job::new(pixels, [60, 45]).unwrap();
        job.fault = match i % 11 {
            5 => Fault::Short(width * height / 2),
            7 => Fault::Clear(width * height / 3),
            9 => Fault::Interrupted(width * 3),
            _ => Fault::None,
        };
        job
    };
    (0..frames).map(job).collect()
}

#[test]
fn block_memories_may_return_anything_and_small_ones_the_old_word() {
    let (simulator, counts) = simulator();
    // The two rings with 28 and 21 delays of more than three steps.
    assert_eq!(counts, [1, 1, 1, 1, 1, 1, 49]);
    let with = |garbage: usize| simulator.clone().with_plusargs(vec![format!("+GARBAGE={garbage}")]);
    for seed in 1..=3 {
        let frames = jobs(seed, 20);
        for (source_pause, sink_pause) in [(0.0, 0.0), (0.3, 0.3), (0.0, 0.98)] {
            let streams = Streams { source_pause, sink_pause, seed, ..Streams::default() };
            let outcome = run(&with(COLLISIONS), &frames, streams).unwrap();
            assert!(outcome.pass(), "seed {seed}, pauses {source_pause} {sink_pause}: {outcome:#?}");
            assert!(outcome.features > 1000, "{outcome:#?}");
        }
    }
    // Garbage in every read of a kind is seen: so the first part means something, and small memories need old words.
    let frames = jobs(1, 3);
    assert!(run(&with(0), &frames, Streams::default()).unwrap().pass());
    for kind in 0..counts.len() {
        let seen = run(&with(always(kind)), &frames, Streams::default());
        assert!(!seen.is_ok_and(|outcome| outcome.pass()), "garbage in every read of kind {kind} is not seen");
    }
}

/// The small memories have their style, without leave to return anything.
#[test]
fn small_memories_say_where_they_go() {
    for source in committed().unwrap() {
        let name = source.file_name().unwrap().to_str().unwrap().to_owned();
        let small = SMALL.iter().any(|start| name.starts_with(start));
        for line in fs::read_to_string(&source).unwrap().lines().filter(|line| line.contains("memory [0:")) {
            assert_eq!(line.trim().starts_with("(* ramstyle = \"MLAB\" *) reg ["), small, "{name}: {line}");
        }
    }
}
