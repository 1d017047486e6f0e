//! The checks of the leaf cells, each three ways: bit-true model == rust-hdl's simulator == Verilator on the emitted
//! file.
//!
//! All cells are instances of one generated Verilog bench, so Verilator runs once. Inputs are random values mixed with
//! the corners of their range; clock enable and reset are random too. Every output is compared after every clock edge.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    fmt::Write,
    path::{Path, PathBuf},
    sync::{LazyLock, OnceLock},
};

use hoverlock_harness::{
    build::Build,
    model::{InstanceOptions, Library, Model},
};
use hoverlock_rtl::emission::{
    committed,
    parameters::{Variant, ports, variants},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rust_hdl::prelude::*;

/// The value of a signal as 32-bit words.
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

/// A check by its name.
pub type Check = (&'static str, fn());

/// All checks of leaf cells.
pub const CHECKS: [Check; 16] = [
    ("every_leaf_has_a_check", every_leaf_has_a_check),
    ("lerp_is_the_bit_true_lerp", arithmetic::lerp_is_the_bit_true_lerp),
    (
        "difference_rounds_half_up_keeps_the_sign_and_saturates",
        arithmetic::difference_rounds_half_up_keeps_the_sign_and_saturates,
    ),
    ("window_maxima_are_those_of_the_definition", arithmetic::window_maxima_are_those_of_the_definition),
    ("maxima_and_comparisons", arithmetic::maxima_and_comparisons),
    ("every_threshold_moves_as_the_model_says", arithmetic::every_threshold_moves_as_the_model_says),
    ("the_record_limit_is_the_law_of_the_model", control::the_record_limit_is_the_law_of_the_model),
    ("delays", delays::delays),
    ("lines_of_every_depth", delays::lines_of_every_depth),
    ("column_rows", delays::column_rows),
    ("lines_and_addresses", delays::lines_and_addresses),
    ("borders_and_positions", borders::borders_and_positions),
    ("samples_side_by_side", control::samples_side_by_side),
    ("queues_and_records", control::queues_and_records),
    ("sequencer_under_any_stream", control::sequencer_under_any_stream),
    ("registers_read_back_and_clear", control::registers_read_back_and_clear),
];

/// Runs the check of this name.
#[allow(dead_code, reason = "for the tests of the cells")]
pub fn run(name: &str) {
    let check = CHECKS.iter().chain(&structure::CHECKS).find(|(known, _)| *known == name);
    check.unwrap_or_else(|| panic!("no check {name}")).1();
}

/// Verilog files in place of the committed ones, and where the bench is to be written.
static OTHERS: OnceLock<(Vec<PathBuf>, PathBuf)> = OnceLock::new();

thread_local! {
    /// The only module to be driven, and the arguments its Verilog sees.
    static CHOICE: RefCell<(Option<String>, Vec<String>)> = const { RefCell::new((None, Vec::new())) };
}

/// Drives other files than the committed ones. Must be called before any check.
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

/// Whether a module is a leaf cell. Wiring is checked in `structure.rs` and by the chain.
fn is_leaf(text: &str) -> bool {
    !text.contains("\n  .clock(clock)")
}

/// Each module of the design with each set of its numbers, by its label.
static VARIANTS: LazyLock<BTreeMap<String, Variant>> = LazyLock::new(|| {
    let texts = FILES.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    variants(&texts, "hoverlock_top").into_iter().map(|variant| (variant.label(), variant)).collect()
});

/// The labels of a module's variants, with their numbers: `delay(18, 16)` and 18, 16.
fn family(module: &str) -> Vec<(String, Vec<usize>)> {
    let numbers = |variant: &Variant| variant.parameters.iter().map(|(_, number)| *number as usize).collect();
    let of_module = VARIANTS.iter().filter(|(_, variant)| variant.module == module);
    let members: Vec<_> = of_module.map(|(label, variant)| (label.clone(), numbers(variant))).collect();
    assert!(!members.is_empty(), "no module {module}");
    members
}

/// The port of the bench that is a port of a module.
fn bench_port(label: &str, port: &str) -> String {
    format!("{}__{port}", label.replace(|c: char| !c.is_ascii_alphanumeric(), "_"))
}

pub fn every_leaf_has_a_check() {
    // The text of these files holds the name of each module that they drive, as it is or where they ask for its family.
    let checks = [
        include_str!("arithmetic.rs"),
        include_str!("borders.rs"),
        include_str!("control.rs"),
        include_str!("delays.rs"),
        include_str!("structure.rs"),
    ]
    .concat();
    // The mutation test adds a package of its own, which is no cell.
    let leaves = FILES.iter().filter(|(name, text)| *name != "mutation" && is_leaf(text));
    for (name, _) in leaves {
        assert!(checks.contains(&format!("\"{name}\"")), "{name} has no check of its own");
    }
}

/// One instance of each cell, its ports named `cell__port`, one clock for all.
static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    let folder = OTHERS.get().map_or(Path::new(env!("CARGO_TARGET_TMPDIR")), |(_, folder)| folder.as_path());
    let (mut of_bench, mut instances) = (vec!["input wire clock".to_owned()], String::new());
    if FILES.contains_key("mutation") {
        instances += "mutation_choice mutation_choice ();\n";
    }
    for (label, variant) in VARIANTS.iter() {
        let text = &FILES[&variant.module];
        // Wiring modules are checked by the chain.
        if !is_leaf(text) && !structure::MODULES.contains(&label.as_str()) {
            continue;
        }
        let scope = variant.scope(text);
        let mut connections = Vec::new();
        for port in ports(text) {
            if port.name == "clock" {
                connections.push(".clock(clock)".to_owned());
                continue;
            }
            let direction = if port.is_output { "output" } else { "input" };
            let top = port.width(&scope).expect("a width is a number") - 1;
            let name = bench_port(label, &port.name);
            of_bench.push(format!("{direction} wire [{top}:0] {name}"));
            connections.push(format!(".{}({name})", port.name));
        }
        let numbers: Vec<String> = variant.parameters.iter().map(|(name, value)| format!(".{name}({value})")).collect();
        let (module, name) = (&variant.module, bench_port(label, "i"));
        writeln!(instances, "{module} #({}) {name} ({});", numbers.join(", "), connections.join(", ")).unwrap();
    }
    let bench = folder.join("bench.v");
    let text = format!("module bench ({});\n{instances}endmodule\n", of_bench.join(", "));
    // A file that has not changed keeps its time, so that the built model is found again.
    if std::fs::read_to_string(&bench).ok().as_ref() != Some(&text) {
        std::fs::write(&bench, text).unwrap();
    }
    Build::new("bench").sources(sources()).source(bench).compile().unwrap()
});

/// Drives a cell and its Verilog alike for many cycles. `$tame` may change the random inputs before a cycle, `$check`
/// sees them and the outputs after the edge.
macro_rules! alike {
    ($cell:expr, $($rest:tt)*) => { alike_with!(|cell| cell.clock.next = !cell.clock.val(), $cell, $($rest)*) };
}

macro_rules! alike_with {
    (
        |$ticking:ident| $tick:expr, $cell:expr, $module:expr, $cycles:expr,
        [$($input:ident $([$in:tt])?),*], [$($output:ident $([$out:tt])?),*], $tame:expr, $check:expr
    ) => {
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
            $(cell.$input$([$in])?.next = random(&mut draw);)*
            tame(&mut cell, cycle, &mut draw);
            $({
                let name = concat!(stringify!($input) $(, "_", stringify!($in))?);
                let signal = model.find(&bench_port(module, name)).unwrap();
                model.set_words(signal, &Word::words(cell.$input$([$in])?.next)).unwrap();
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
                    let name = concat!(stringify!($output) $(, "_", stringify!($out))?);
                    let signal = model.find(&bench_port(module, name)).unwrap();
                    let (rust, verilog) = (Word::words(cell.$output$([$out])?.val()), model.get_words(signal));
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

/// Checks only that both simulators agree.
macro_rules! agree {
    (
        $type:ty, $cell:expr, $module:expr, $cycles:expr,
        [$($input:ident $([$in:tt])?),*], [$($output:ident $([$out:tt])?),*], $tame:expr
    ) => {
        alike!($cell, $module, $cycles, [$($input $([$in])?),*], [$($output $([$out])?),*], $tame, |_: &$type, _| {})
    };
}

/// The same for a cell without a clock.
macro_rules! agree_now {
    ($type:ty, $cell:expr, $module:expr, [$($input:ident $([$in:tt])?),*], [$($output:ident $([$out:tt])?),*]) => {
        alike_with!(
            |_unclocked| (), $cell, $module, 100, [$($input $([$in])?),*], [$($output $([$out])?),*],
            |_: &mut $type, _, _: &mut ChaCha8Rng| {}, |_: &$type, _| {}
        )
    };
}

// After the macros that they use.
pub mod arithmetic;
pub mod borders;
pub mod control;
pub mod delays;
pub mod structure;
