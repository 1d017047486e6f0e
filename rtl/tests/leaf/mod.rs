//! The gates of the leaf cells. Every leaf cell three ways: bit-true reference == rust-hdl's simulator == Verilator on the emitted file.
//!
//! All cells stand side by side in one bench of generated Verilog, so that Verilator runs once. Inputs are random words mixed with
//! the corners of their range; the clock enable and the reset come and go. Every output is compared after every clock edge.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    fmt::Write,
    path::{Path, PathBuf},
    sync::{LazyLock, OnceLock},
};

use hoverlock_fixed_point::model::bit_true::ThresholdController;
use hoverlock_fixed_point::model::design::KT27;
use hoverlock_fixed_point::model::lerp::lerp;
use hoverlock_harness::{
    build::Build,
    model::{InstanceOptions, Library, Model, SignalId},
};
use hoverlock_rtl::{
    cells::{
        address::AddressCounter,
        bank::Bank,
        border::{CoefficientRegister, ColumnBorder, LookAheadBorder, LookBackBorder},
        csr::Csr,
        decision::{Decision, Eligible, Threshold},
        delay::{Cursor, Delay, FlagDelay, FrameDelay, PulseDelay},
        difference::Difference,
        join::{Neighbours, PixelState, RingRows, SignedResponse},
        lerp::Lerp,
        line_delay::LineDelay,
        maximum::{ColumnMaximum, Maximum, WindowMaximum},
        queue::{CandidateQueue, CandidateWord, RecordFifo, RecordWriter},
        ring::{RingComparator, RingTaps, rows},
        sequencer::Sequencer,
        tail::{HeldRow, TailCounter},
    },
    emit::{committed, emission},
    registers::registers,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rust_hdl::prelude::*;

/// A signal's value as 32-bit words.
trait Word: Copy {
    const WIDTH: usize;
    fn from_words(words: &[u32]) -> Self;
    fn words(self) -> Vec<u32>;
}

impl Word for bool {
    const WIDTH: usize = 1;
    fn from_words(words: &[u32]) -> Self {
        words[0] & 1 != 0
    }
    fn words(self) -> Vec<u32> {
        vec![u32::from(self)]
    }
}

impl<const N: usize> Word for Bits<N> {
    const WIDTH: usize = N;
    fn from_words(words: &[u32]) -> Self {
        (0..N).fold(Self::default(), |bits, i| bits.replace_bit(i, words[i / 32] >> (i % 32) & 1 != 0))
    }
    fn words(self) -> Vec<u32> {
        let bit = |i: usize| u32::from(i < N && self.get_bit(i));
        (0..N.div_ceil(32)).map(|word| (0..32).fold(0, |sum, i| sum | bit(32 * word + i) << i)).collect()
    }
}

/// Random words, one in four all zeros or all ones.
fn random<T: Word>(random: &mut ChaCha8Rng) -> T {
    let words: Vec<u32> = match random.random_range(0..8) {
        0 => vec![0; T::WIDTH.div_ceil(32)],
        1 => vec![u32::MAX; T::WIDTH.div_ceil(32)],
        _ => (0..T::WIDTH.div_ceil(32)).map(|_| random.random()).collect(),
    };
    T::from_words(&words)
}

/// All gates.
pub const GATES: [(&str, fn()); 14] = [
    ("every_leaf_has_a_gate", every_leaf_has_a_gate),
    ("lerp_is_the_bit_true_lerp", lerp_is_the_bit_true_lerp),
    ("difference_rounds_half_up_keeps_the_sign_and_saturates", difference_rounds_half_up_keeps_the_sign_and_saturates),
    ("window_maxima_are_those_of_the_definition", window_maxima_are_those_of_the_definition),
    ("maxima_and_comparisons", maxima_and_comparisons),
    ("delays", delays),
    ("lines_of_every_depth", lines_of_every_depth),
    ("lines_and_addresses", lines_and_addresses),
    ("borders_and_places", borders_and_places),
    ("every_threshold_moves_as_the_model_says", every_threshold_moves_as_the_model_says),
    ("words_side_by_side", words_side_by_side),
    ("queues_and_records", queues_and_records),
    ("sequencer_under_any_stream", sequencer_under_any_stream),
    ("registers_read_back_and_clear", registers_read_back_and_clear),
];

/// Verilog files in place of the committed ones, and where the bench is to be written.
static OTHERS: OnceLock<(Vec<PathBuf>, PathBuf)> = OnceLock::new();

thread_local! {
    /// The only module to be driven, and the arguments its Verilog sees.
    static CHOICE: RefCell<(Option<String>, Vec<String>)> = const { RefCell::new((None, Vec::new())) };
}

/// Drives other files than the committed ones; to be said before anything is driven.
#[allow(dead_code, reason = "for the mutants")]
pub fn drive_others(sources: &[PathBuf], folder: &Path) {
    OTHERS.set((sources.to_vec(), folder.to_path_buf())).expect("said once");
}

/// In this thread drives one module only, with arguments for its Verilog.
#[allow(dead_code, reason = "for the mutants")]
pub fn drive_only(module: &str, plusargs: &[String]) {
    CHOICE.set((Some(module.to_owned()), plusargs.to_vec()));
}

fn is_driven(module: &str) -> bool {
    CHOICE.with_borrow(|(only, _)| only.as_ref().is_none_or(|only| only == module))
}

fn instance() -> Model {
    let plusargs = CHOICE.with_borrow(|(_, plusargs)| plusargs.clone());
    LIBRARY.instance_with(&InstanceOptions { plusargs, ..InstanceOptions::default() }).unwrap()
}

fn sources() -> Vec<PathBuf> {
    OTHERS.get().map_or_else(|| committed().expect("the project is there"), |(sources, _)| sources.clone())
}

/// The Verilog by module.
static FILES: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    let module = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
    sources().iter().map(|path| (module(path), std::fs::read_to_string(path).unwrap())).collect()
});

/// A cell of its own, not the wiring of others: that is for `structure.rs` and the chain.
fn is_leaf(text: &str) -> bool {
    !text.contains("\n  .clock(clock)")
}

/// The numbers in the names of all modules of a family: `delay_18x4` is 4 of `delay_18x`.
fn family(prefix: &str) -> Vec<(String, usize)> {
    let member = |name: &String| Some((name.clone(), name.strip_prefix(prefix)?.parse().ok()?));
    let members: Vec<_> = FILES.keys().filter_map(member).collect();
    assert!(!members.is_empty(), "no module {prefix}N");
    members
}

pub fn every_leaf_has_a_gate() {
    // The text of this file holds the name of each module that it drives, or the name of its family.
    let gates = include_str!("mod.rs");
    for name in FILES.iter().filter(|(_, text)| is_leaf(text)).map(|(name, _)| name) {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let gated = [format!("\"{name}\""), format!("(\"{stem}\")")].iter().any(|gate| gates.contains(gate));
        assert!(gated, "{name} has no gate of its own");
    }
}

/// One instance of each cell, its ports named `cell__port`, one clock for all.
static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    let folder = OTHERS.get().map_or(Path::new(env!("CARGO_TARGET_TMPDIR")), |(_, folder)| folder.as_path());
    let (mut ports, mut instances) = (vec!["input wire clock".to_owned()], String::new());
    for (name, text) in FILES.iter() {
        if name == "mutation" {
            instances += "mutation_choice mutation_choice ();\n";
            continue;
        }
        // What is wiring is covered by the chain.
        if !is_leaf(text) && !structure::MODULES.contains(&name.as_str()) {
            continue;
        }
        let mut connections = Vec::new();
        for line in text.lines().skip_while(|line| !line.starts_with("module")).take_while(|line| *line != ");") {
            let Some((direction, rest)) = line.trim().trim_end_matches(',').split_once(' ') else { continue };
            if direction != "input" && direction != "output" {
                continue;
            }
            let rest = rest.trim().trim_start_matches("wire").trim_start_matches("reg").trim();
            let (range, port) = rest.rsplit_once(' ').unwrap_or(("", rest));
            if port == "clock" {
                connections.push(".clock(clock)".to_owned());
                continue;
            }
            ports.push(format!("{direction} wire {range} {name}__{port}"));
            connections.push(format!(".{port}({name}__{port})"));
        }
        writeln!(instances, "{name} i_{name} ({});", connections.join(", ")).unwrap();
    }
    let bench = folder.join("bench.v");
    let text = format!("module bench ({});\n{instances}endmodule\n", ports.join(", "));
    // A file that has not changed keeps its time, so that the built model is found again.
    if std::fs::read_to_string(&bench).ok().as_ref() != Some(&text) {
        std::fs::write(&bench, text).unwrap();
    }
    Build::new("bench").sources(sources()).source(bench).compile().unwrap()
});

/// Drives a cell and its Verilog alike for many cycles. `$tame` may change the random inputs before a cycle, `$check` sees them
/// and the outputs after the edge.
macro_rules! alike {
    ($cell:expr, $($rest:tt)*) => { alike_with!(|cell| cell.clock.next = !cell.clock.val(), $cell, $($rest)*) };
}

macro_rules! alike_with {
    (|$ticking:ident| $tick:expr, $cell:expr, $module:expr, $cycles:expr, [$($input:ident),*], [$($output:ident),*], $tame:expr, $check:expr) => {
        if is_driven($module) {
        let mut cell = $cell;
        cell.connect_all();
        let module: &str = $module;
        let mut model = instance();
        let clock = model.find("clock").unwrap();
        let mut draw = ChaCha8Rng::seed_from_u64(0x5eed);
        #[allow(unused_mut)]
        let (mut tame, mut check) = ($tame, $check);
        for cycle in 0..$cycles {
            $(cell.$input.next = random(&mut draw);)*
            tame(&mut cell, cycle, &mut draw);
            $({
                let signal = model.find(&format!("{module}__{}", stringify!($input))).unwrap();
                model.set_words(signal, &Word::words(cell.$input.next)).unwrap();
            })*
            model.set(clock, 0).unwrap();
            model.eval().unwrap();
            assert!(simulate(&mut cell, 100));
            {
                let $ticking = &mut cell;
                $tick;
            }
            model.set(clock, 1).unwrap();
            model.eval().unwrap();
            assert!(simulate(&mut cell, 100));
            // Without a reset in the first cycles registers may hold anything.
            if cycle >= 2 {
                $({
                    let signal = model.find(&format!("{module}__{}", stringify!($output))).unwrap();
                    let (rust, verilog) = (Word::words(cell.$output.val()), model.get_words(signal));
                    assert_eq!(rust, verilog, "{module}.{} in cycle {cycle}", stringify!($output));
                })*
                check(&cell, cycle);
            }
            {
                let $ticking = &mut cell;
                $tick;
            }
            assert!(simulate(&mut cell, 100));
        }
    }};
}

/// Reset in the first two cycles, and now and then.
macro_rules! resets {
    ($cell:ident, $cycle:ident, $draw:ident) => {
        $cell.reset.next = $cycle < 2 || $draw.random_ratio(1, 200)
    };
}

/// Nothing more to say than that both agree.
macro_rules! agree {
    ($type:ty, $cell:expr, $module:expr, $cycles:expr, [$($input:ident),*], [$($output:ident),*], $tame:expr) => {
        alike!($cell, $module, $cycles, [$($input),*], [$($output),*], $tame, |_: &$type, _| {})
    };
}

// Behind the macros it uses.
pub mod structure;

pub fn lerp_is_the_bit_true_lerp() {
    let mut past: Vec<(u32, u32)> = Vec::new();
    let mut code = Vec::new();
    alike!(
        Lerp::default(),
        "lerp",
        4000,
        [advance, p, q, g],
        [y],
        |_: &mut Lerp, _, _: &mut ChaCha8Rng| {},
        |cell: &Lerp, _| {
            if cell.advance.val() {
                past.push((cell.p.val().to_u32(), cell.q.val().to_u32()));
                code.push(cell.g.val().to_u32());
                if let [.., (p, q), _, _] = past[..] {
                    let g = code[code.len() - 2];
                    assert_eq!(cell.y.val().to_u32(), lerp(p, q, g, 16), "p {p} q {q} g {g}");
                }
            }
        }
    );
}

pub fn difference_rounds_half_up_keeps_the_sign_and_saturates() {
    let mut past: Vec<(i64, i64)> = Vec::new();
    alike!(
        Difference::default(),
        "difference",
        4000,
        [advance, narrow, wide],
        [magnitude, positive, saturated],
        |cell: &mut Difference, _, draw: &mut ChaCha8Rng| {
            // Half of the time close together, as responses are.
            if draw.random() {
                let near = cell.narrow.next.to_u64().saturating_add_signed(draw.random_range(-4..=4)).min(0x3ffff);
                cell.wide.next = near.into();
            }
        },
        |cell: &Difference, _| {
            if cell.advance.val() {
                past.push((cell.narrow.val().to_u64() as i64, cell.wide.val().to_u64() as i64));
                if let [.., (narrow, wide), _] = past[..] {
                    let rounded = ((narrow - wide).unsigned_abs() + 1) >> 1;
                    assert_eq!(cell.magnitude.val().to_u64(), rounded.min(0x7fff));
                    assert_eq!(cell.saturated.val(), rounded > 0x7fff);
                    assert_eq!(cell.positive.val(), narrow >= wide);
                }
            }
        }
    );
}

pub fn window_maxima_are_those_of_the_definition() {
    for (module, samples) in family("window_maximum_") {
        let mut past = Vec::new();
        alike!(
            WindowMaximum::new(samples),
            &module,
            1500,
            [advance, x],
            [y],
            |_: &mut WindowMaximum, _, _: &mut ChaCha8Rng| {},
            |cell: &WindowMaximum, _| {
                if cell.advance.val() {
                    past.push(cell.x.val().to_u64());
                    let late = WindowMaximum::steps(samples) as usize - 1;
                    if past.len() >= samples + late {
                        let window = &past[past.len() - samples - late..past.len() - late];
                        assert_eq!(Some(cell.y.val().to_u64()), window.iter().copied().max());
                    }
                }
            }
        );
    }
}

pub fn maxima_and_comparisons() {
    alike!(
        Maximum::default(),
        "maximum",
        1000,
        [advance, a, b],
        [y],
        |_: &mut Maximum, _, _: &mut ChaCha8Rng| {},
        |cell: &Maximum, _| {
            if cell.advance.val() {
                assert_eq!(cell.y.val().to_u64(), cell.a.val().to_u64().max(cell.b.val().to_u64()));
            }
        }
    );
    let mut past: Vec<Vec<u64>> = Vec::new();
    alike!(
        ColumnMaximum::default(),
        "column_maximum",
        2000,
        [advance, newest, older],
        [later, middle, earlier, five],
        |_: &mut ColumnMaximum, _, _: &mut ChaCha8Rng| {},
        |cell: &ColumnMaximum, _| {
            if cell.advance.val() {
                let older = cell.older.val();
                let rows = (0..6).map(|row| older.get_bits::<15>(16 * row).to_u64());
                past.push(std::iter::once(cell.newest.val().to_u64()).chain(rows).collect());
                if let [.., v, _, _] = &past[..] {
                    let max = |rows: &[u64]| rows.iter().copied().max();
                    assert_eq!(Some(cell.later.val().to_u64()), max(&v[..3]));
                    assert_eq!(cell.middle.val().to_u64(), v[3]);
                    assert_eq!(Some(cell.earlier.val().to_u64()), max(&v[4..]));
                    assert_eq!(Some(cell.five.val().to_u64()), max(&v[..5]));
                }
            }
        }
    );
    alike!(
        Decision::default(),
        "decision",
        4000,
        [reset, advance, eligible, p, strict, loose, threshold],
        [hit],
        |cell: &mut Decision, cycle, draw: &mut ChaCha8Rng| {
            resets!(cell, cycle, draw);
            let p = cell.p.next.to_u64();
            let mut near = |signal: &mut Bits<15>| {
                if draw.random() {
                    *signal = p.saturating_add_signed(draw.random_range(-1..=1)).min(0x7fff).into();
                }
            };
            near(&mut cell.strict.next);
            near(&mut cell.loose.next);
            near(&mut cell.threshold.next);
        },
        |cell: &Decision, _| {
            if cell.advance.val() && !cell.reset.val() {
                let p = cell.p.val().to_u64();
                let hit = p > cell.strict.val().to_u64()
                    && p >= cell.loose.val().to_u64()
                    && p >= cell.threshold.val().to_u64();
                assert_eq!(cell.hit.val(), hit && cell.eligible.val());
            }
        }
    );
    alike!(
        RingComparator::default(),
        "ring_comparator",
        400,
        [advance, centre, points],
        [maxlbp, sign],
        |_: &mut RingComparator, _, _: &mut ChaCha8Rng| {},
        |cell: &RingComparator, _| {
            if cell.advance.val() {
                for i in 0..32 {
                    let point = cell.points.val().get_bits::<16>(16 * i).to_u64();
                    assert_eq!(cell.maxlbp.val().get_bit(i), cell.centre.val().to_u64() >= point & 0x7fff);
                    assert_eq!(cell.sign.val().get_bit(i), point >> 15 == 1);
                }
            }
        }
    );
}

/// A delay of words of some width and of any length there is.
macro_rules! delay {
    ($bits:literal, $family:expr) => {
        for (module, steps) in $family {
            let mut past = Vec::new();
            alike!(
                Delay::<$bits>::new(steps),
                &module,
                400,
                [reset, advance, x],
                [y],
                |cell: &mut Delay<$bits>, cycle, _: &mut ChaCha8Rng| cell.reset.next = cycle < 2,
                |cell: &Delay<$bits>, _| {
                    if cell.advance.val() {
                        past.push(cell.x.val());
                        if past.len() >= steps {
                            assert_eq!(cell.y.val(), past[past.len() - steps]);
                        }
                    }
                }
            );
        }
    };
}

pub fn delays() {
    delay!(15, family("delay_15x"));
    delay!(16, family("delay_16x"));
    delay!(18, family("delay_18x"));
    for (module, steps) in family("flag_delay_") {
        agree!(
            FlagDelay,
            FlagDelay::new(steps),
            &module,
            1000,
            [reset, advance, x],
            [y],
            |cell: &mut FlagDelay, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
            }
        );
    }
    for (module, steps) in family("pulse_delay_") {
        let mut last = None;
        let mut step = 0;
        alike!(
            PulseDelay::new(steps as u64),
            &module,
            2000,
            [reset, advance, x],
            [y],
            |cell: &mut PulseDelay, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
                cell.x.next = draw.random_ratio(1, 15);
            },
            |cell: &PulseDelay, _| {
                if cell.reset.val() {
                    last = None;
                } else if cell.advance.val() {
                    step += 1;
                    // The pulse is seen with the step before the one it belongs to.
                    assert_eq!(cell.y.val(), last.is_some_and(|last| step + 1 == last + steps), "{module}");
                    if cell.x.val() {
                        last = Some(step);
                    }
                }
            }
        );
    }
    // Lines and steps of each frame marker.
    for (module, lines, steps) in [
        ("frame_delay_1x4", 1, 4),
        ("frame_delay_2x4", 2, 4),
        ("frame_delay_4x4", 4, 4),
        ("frame_delay_8x4", 8, 4),
        ("frame_delay_16x4", 16, 4),
        ("frame_delay_32x4", 32, 4),
        ("frame_delay_32x44", 32, 44),
        ("frame_delay_3x10", 3, 10),
        ("frame_delay_15x13", 15, 13),
    ] {
        let (mut step, mut last) = (0u64, None);
        let width = 66 + lines;
        alike!(
            FrameDelay::new(lines, steps),
            module,
            5000,
            [reset, advance, width, x],
            [y],
            |cell: &mut FrameDelay, cycle, draw: &mut ChaCha8Rng| {
                cell.reset.next = cycle < 2 || cycle == 4000;
                cell.advance.next = draw.random_ratio(9, 10);
                cell.width.next = width.into();
                cell.x.next = [5, 3400, 3950].contains(&cycle);
            },
            |cell: &FrameDelay, _| {
                if cell.reset.val() {
                    last = None;
                } else if cell.advance.val() {
                    step += 1;
                    assert_eq!(
                        cell.y.val(),
                        last.is_some_and(|last| step + 1 == last + lines * width + steps),
                        "{module}"
                    );
                    if cell.x.val() {
                        last = Some(step);
                    }
                }
            }
        );
    }
}

pub fn lines_of_every_depth() {
    /// Lines of words of some width, the taps of them that are read.
    macro_rules! lines {
        ($bits:literal, $out:literal, $module:expr, $taps:expr) => {
            let (mut count, mut past) = (0u64, Vec::new());
            let taps: &[usize] = $taps;
            // As many steps as the oldest tap needs, and a hundred more.
            let cycles = 64 * taps[taps.len() - 1] + 200;
            alike!(
                LineDelay::<$bits, $out>::new(taps),
                $module,
                cycles,
                [advance, address, write_address, x],
                [y],
                |cell: &mut LineDelay<$bits, $out>, cycle, draw: &mut ChaCha8Rng| {
                    cell.advance.next = cycle < 100 || draw.random_ratio(19, 20);
                    cell.address.next = (count % 60).into();
                    cell.write_address.next = ((count + 59) % 60).into();
                    count += u64::from(cell.advance.next);
                },
                |cell: &LineDelay<$bits, $out>, _| {
                    if cell.advance.val() {
                        past.push(cell.x.val());
                        for (i, tap) in taps.iter().enumerate().filter(|(_, tap)| past.len() > 60 * **tap) {
                            assert_eq!(cell.y.val().get_bits::<$bits>($bits * i), past[past.len() - 60 * tap]);
                        }
                    }
                }
            );
        };
    }
    for (module, rows) in family("line_delay_18x") {
        lines!(18, 18, &module, &[rows]);
    }
    lines!(16, 16, "line_delay_16x32", &[32]);
    lines!(16, 96, "line_delay_16x6_all", &[1, 2, 3, 4, 5, 6]);
    let ring =
        |scale: usize| rows(scale).into_iter().map(|(line, _)| line).filter(|line| *line > 0).collect::<Vec<_>>();
    // The fine ring lies deeper inside: it has a newest line of its own to wait for.
    lines!(16, 240, "line_delay_16x28_taps15", &ring(0));
    lines!(16, 224, "line_delay_16x32_taps14", &ring(1));
}

pub fn lines_and_addresses() {
    agree!(
        AddressCounter,
        AddressCounter::default(),
        "address_counter",
        1500,
        [reset, advance, width],
        [now, before_1, before_4, before_5, before_8, before_12, before_16, before_20],
        |cell: &mut AddressCounter, cycle, draw: &mut ChaCha8Rng| {
            resets!(cell, cycle, draw);
            cell.width.next = if cycle < 700 { 100u64 } else { 64 }.into();
        }
    );
    agree!(
        HeldRow,
        HeldRow::default(),
        "held_row",
        2000,
        [advance, write, write_address, x, select, address_0, address_1, address_2, address_3, address_4, address_5],
        [y],
        |cell: &mut HeldRow, _, draw: &mut ChaCha8Rng| {
            cell.select.next = (1u64 << draw.random_range(0..7) & 63).into();
            let place = |draw: &mut ChaCha8Rng| Bits::<10>::from(draw.random_range(0..16u64));
            cell.write_address.next = place(draw);
            for address in [&mut cell.address_0, &mut cell.address_1, &mut cell.address_2, &mut cell.address_3] {
                address.next = place(draw);
            }
        }
    );
    agree!(
        TailCounter,
        TailCounter::default(),
        "tail_counter",
        9000,
        [reset, advance, width, start],
        [select, outside],
        |cell: &mut TailCounter, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 5000);
            cell.width.next = 64u64.into();
            cell.start.next = cycle == 10 || draw.random_ratio(1, 5000);
        }
    );
    let lines: Vec<usize> = rows(1).into_iter().map(|(line, _)| line).collect();
    assert_eq!((lines[0], lines[14], lines.len()), (0, 32, 15));
    agree!(
        RingTaps<240>,
        RingTaps::<240>::new(0),
        "ring_taps_0",
        200,
        [reset, advance, rows],
        [points],
        |cell: &mut RingTaps<240>, cycle, _: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 1;
            cell.advance.next = cycle > 0;
        }
    );
    agree!(
        RingTaps<240>,
        RingTaps::<240>::new(1),
        "ring_taps_1",
        200,
        [reset, advance, rows],
        [points],
        |cell: &mut RingTaps<240>, cycle, _: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 1;
            cell.advance.next = cycle > 0;
        }
    );
}

pub fn borders_and_places() {
    agree!(
        ColumnBorder,
        ColumnBorder::default(),
        "column_border",
        500,
        [advance, x, neighbour, border, outside],
        [p, q],
        |_: &mut ColumnBorder, _, _: &mut ChaCha8Rng| {}
    );
    for (module, reach) in family("look_back_border_") {
        agree!(
            LookBackBorder,
            LookBackBorder::new(reach as u64),
            &module,
            1500,
            [reset, advance, first, x, past],
            [p, q],
            |cell: &mut LookBackBorder, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
                cell.first.next = draw.random_ratio(1, 40);
            }
        );
    }
    for (module, reach) in family("look_ahead_border_") {
        agree!(
            LookAheadBorder,
            LookAheadBorder::new(reach as u64),
            &module,
            1500,
            [reset, advance, last, x, past],
            [p, q],
            |cell: &mut LookAheadBorder, cycle, draw: &mut ChaCha8Rng| {
                resets!(cell, cycle, draw);
                cell.last.next = draw.random_ratio(1, 40);
            }
        );
    }
    agree!(
        CoefficientRegister,
        CoefficientRegister::default(),
        "coefficient_register",
        300,
        [advance, load, d],
        [g],
        |_: &mut CoefficientRegister, _, _: &mut ChaCha8Rng| {}
    );
    agree!(Bank, Bank::default(), "bank", 100, [load, d], [q], |_: &mut Bank, _, _: &mut ChaCha8Rng| {});
    agree!(
        Cursor,
        Cursor::default(),
        "cursor",
        9000,
        [reset, advance, width, height, start],
        [active, x, y, first_column, last_column, first_row, last_row],
        |cell: &mut Cursor, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 3000);
            cell.width.next = 64u64.into();
            cell.height.next = 64u64.into();
            cell.start.next = cycle == 5 || draw.random_ratio(1, 3000);
        }
    );
    agree!(
        Eligible,
        Eligible::default(),
        "eligible",
        3000,
        [advance, width, height, active, x, y],
        [eligible, place],
        |cell: &mut Eligible, _, draw: &mut ChaCha8Rng| {
            cell.width.next = draw.random_range(64..=1024u64).into();
            cell.height.next = draw.random_range(64..=2048u64).into();
            cell.active.next = true;
            if draw.random() {
                cell.x.next = (cell.width.next.to_u64() - draw.random_range(16..21)).into();
                cell.y.next = draw.random_range(16..21u64).into();
            }
        }
    );
    agree!(
        Threshold,
        Threshold::default(),
        "threshold",
        20_000,
        [reset, advance, start, hit, follow, manual, target],
        [threshold, count],
        |cell: &mut Threshold, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 4000);
            cell.advance.next = true;
            cell.start.next = cycle == 2 || draw.random_ratio(1, 60);
            cell.follow.next = draw.random_ratio(9, 10);
            cell.target.next = draw.random_range(1..60u64).into();
            if draw.random() {
                cell.manual.next = draw.random_range(0..4u64).into();
            }
        }
    );
}

pub fn every_threshold_moves_as_the_model_says() {
    // One frame takes the manual threshold, the next follows a count: three, against a target that is far less, far more, or met.
    if !is_driven("threshold") {
        return;
    }
    let mut model = instance();
    let ports = ["clock", "threshold__reset", "threshold__advance", "threshold__start", "threshold__hit"];
    let [clock, reset, advance, start, hit] = ports.map(|name| model.find(name).unwrap());
    let ports = ["threshold__follow", "threshold__manual", "threshold__target", "threshold__threshold"];
    let [follow, manual, target, threshold] = ports.map(|name| model.find(name).unwrap());
    let mut cycle = |inputs: &[(SignalId, u64)]| {
        inputs.iter().for_each(|(signal, value)| model.set(*signal, *value).unwrap());
        for level in [0, 1] {
            model.set(clock, level).unwrap();
            model.eval().unwrap();
        }
        model.get(threshold)
    };
    cycle(&[(reset, 1), (advance, 1), (start, 0), (hit, 0)]);
    cycle(&[(reset, 0)]);
    for t in 0..=0x7fffu64 {
        for wanted in [0, 4, 2, 1000] {
            assert_eq!(cycle(&[(start, 1), (hit, 0), (follow, 0), (manual, t)]), t.max(1));
            // The first that follows takes the manual one too.
            cycle(&[(follow, 1)]);
            (0..3).for_each(|_| _ = cycle(&[(start, 0), (hit, 1), (target, wanted)]));
            cycle(&[(hit, 0)]);
            let mut design = KT27.clone();
            (design.threshold.target, design.threshold.initial) = (wanted as u32, t.max(1) as u32);
            let mut control = ThresholdController::new(&design);
            control.finish_frame([3, 3]);
            assert_eq!(cycle(&[(start, 1)]), u64::from(control.thresholds()[0]), "from {t}, 3 features of {wanted}");
        }
    }
}

/// The same for a cell without a clock.
macro_rules! agree_now {
    ($type:ty, $cell:expr, $module:expr, [$($input:ident),*], [$($output:ident),*]) => {
        alike_with!(|_unclocked| (), $cell, $module, 100, [$($input),*], [$($output),*], |_: &mut $type, _, _: &mut ChaCha8Rng| {}, |_: &$type, _| {})
    };
}

pub fn words_side_by_side() {
    agree_now!(PixelState, PixelState::default(), "pixel_state", [x], [y]);
    agree_now!(SignedResponse, SignedResponse::default(), "signed_response", [magnitude, positive], [y]);
    agree_now!(Neighbours, Neighbours::default(), "neighbours", [left, right, up, down], [y]);
    agree_now!(RingRows, RingRows::default(), "ring_rows", [newest, older], [y]);
    agree_now!(
        CandidateWord,
        CandidateWord::default(),
        "candidate_word",
        [place, hit_0, hit_1, centre_0, centre_1, neighbours_0, neighbours_1],
        [word]
    );
}

pub fn queues_and_records() {
    // Places in rising order go in; the ring's place passes them all some time later, or the queue runs full.
    let mut next = 0u64;
    agree!(
        CandidateQueue,
        CandidateQueue::default(),
        "candidate_queue",
        6000,
        [reset, advance, word, active, x, y],
        [found, dropped],
        |cell: &mut CandidateQueue, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || cycle == 1500;
            let pushes = cycle > 2 && draw.random_ratio(1, if cycle < 3000 { 9 } else { 2 });
            let mut word = cell.word.next;
            word.set_bits(0, Bits::<21>::from(next));
            word = word.replace_bit(21, pushes).replace_bit(22, pushes && draw.random());
            cell.word.next = word;
            let late = next.saturating_sub(if cycle < 3000 { 300 } else { 4000 });
            cell.active.next = true;
            cell.x.next = (late & 0x3ff).into();
            cell.y.next = (late >> 10).into();
            if cell.advance.next {
                next += 1;
            }
        }
    );
    agree!(
        RecordWriter,
        RecordWriter::default(),
        "record_writer",
        4000,
        [
            reset,
            advance,
            found,
            candidate,
            maxlbp_0,
            maxlbp_1,
            sign_0,
            sign_1,
            lost,
            frame_end,
            errors,
            take,
            threshold_0,
            threshold_1,
            room
        ],
        [write, record, done, count, dropped, frames],
        |cell: &mut RecordWriter, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 1500);
            cell.found.next = draw.random_ratio(1, 5);
            cell.frame_end.next = draw.random_ratio(1, 100);
            cell.room.next = draw.random_ratio(3, 4);
        }
    );
    agree!(
        RecordFifo,
        RecordFifo::default(),
        "record_fifo",
        4000,
        [reset, write, record, ready],
        [room, stop, valid, start_of_packet],
        |cell: &mut RecordFifo, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 1500);
            // Fills for a while, then empties.
            let filling = cycle % 2000 < 1200;
            cell.write.next = !cell.stop.val() && draw.random_ratio(if filling { 9 } else { 1 }, 10);
            cell.ready.next = draw.random_ratio(if filling { 1 } else { 9 }, 10);
        }
    );
}

pub fn sequencer_under_any_stream() {
    agree!(
        Sequencer,
        Sequencer::default(),
        "sequencer",
        60_000,
        [
            reset,
            enable,
            new_width,
            new_height,
            committed,
            stop,
            valid,
            data,
            start_of_packet,
            end_of_packet,
            frame_done
        ],
        [ready, width, height, capture, advance, busy, errors, frame_errors],
        |cell: &mut Sequencer, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 30_000);
            cell.enable.next = cycle % 9000 > 200;
            let size = cycle as u64 / 25_000;
            cell.new_width.next = if cycle % 9000 > 8000 { 63u64 } else { 64 + size }.into();
            cell.new_height.next = 64u64.into();
            cell.committed.next = draw.random_ratio(1, 3);
            cell.stop.next = draw.random_ratio(1, 20);
            cell.valid.next = draw.random_ratio(19, 20);
            cell.start_of_packet.next =
                draw.random_ratio(1, if cycle % 12_000 < 9000 { 6000 } else { 300 }) || cycle % 3000 == 250;
            cell.end_of_packet.next = draw.random_ratio(1, 7000);
            cell.frame_done.next = draw.random_ratio(1, 5000);
        }
    );
}

pub fn registers_read_back_and_clear() {
    agree!(
        Csr,
        Csr::new(emitted_map()),
        "csr",
        8000,
        [
            reset,
            address,
            read,
            write,
            writedata,
            busy,
            errors,
            begun,
            done,
            count,
            dropped,
            frames,
            saturated,
            threshold_0,
            threshold_1
        ],
        [readdata, irq, clear, enable, width, height, bank, committed],
        |cell: &mut Csr, cycle, draw: &mut ChaCha8Rng| {
            cell.reset.next = cycle < 2 || draw.random_ratio(1, 2000);
            // Control, status and the counts of the last frame as often as all others together.
            let often = [3, 4, 10, 11, 12][draw.random_range(0..5)];
            cell.address.next = if draw.random() { often } else { draw.random_range(0..40u64) }.into();
            cell.read.next = cycle == 2 || draw.random();
            // What the pipeline says while it is cleared must not count.
            cell.done.next = draw.random_ratio(1, 20) || (cell.clear.val() && draw.random());
            cell.errors.next = if draw.random_ratio(1, 10) { draw.random_range(0..16u64) } else { 0 }.into();
            cell.saturated.next = draw.random_ratio(1, 50);
        }
    );
}

/// The map with the hash that the emitted Verilog shows.
fn emitted_map() -> Vec<hoverlock_rtl::registers::Register> {
    let hash = emission().unwrap();
    let mut map = registers().unwrap();
    map.iter_mut().filter(|register| register.name == "emission").for_each(|register| register.fields[0].reset = hash);
    map
}
