//! Faults in the registers and memories of the top: a run that ends early has the class of the whole run, and registers
//! whose outcome is known have it.

use hoverlock_design::KT27;
use hoverlock_fault::campaign::campaign;
use hoverlock_fault::class::{Class, Counts};
use hoverlock_fault::draw::{Fault, Kind, draw};
use hoverlock_fault::state::Bit;
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::emission::committed;
use hoverlock_rtl::emission::verilog::verilog;
use hoverlock_simulation::Simulator;
use hoverlock_simulation::upsets::{MIN_FRAMES, Upsets};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Frames of 64 x 64 with a texture of their own each.
fn frames(count: usize) -> Vec<Plane<u16>> {
    let node = |x: usize, y: usize| (((x * 73_856_093) ^ (y * 19_349_663)) % 60_013) as u16;
    (0..count).map(|i| Plane::from_fn(64, 64, |x, y| node((x + 17 * i) / 3, y / 3))).collect()
}

fn simulator() -> Simulator {
    Simulator::with_registers(&KT27, &committed().unwrap()).unwrap()
}

fn upsets() -> Upsets {
    Upsets::new(simulator(), &frames(MIN_FRAMES), &[100, 100]).unwrap()
}

/// Returns a fault in a bit of a register.
fn fault(upsets: &Upsets, name: &str, bit: u32, cycle: u64, kind: Kind) -> Fault {
    let register = upsets.state().registers().iter().position(|register| register.name == name);
    let bit = Bit { register: register.unwrap_or_else(|| panic!("no {name}")), word: 0, bit };
    Fault { bit, cycle, kind }
}

#[test]
fn a_run_that_ends_early_has_the_class_of_the_whole_run() {
    let upsets = upsets();
    assert!(upsets.features() > 40 && upsets.window().end - upsets.window().start >= 64 * 64);
    let faults = draw(upsets.state(), upsets.window(), Kind::Seu, 24, 5);
    // Small frames use few words of the line memories: faults in the registers besides.
    let registers = upsets.state().registers().iter().enumerate().filter(|(_, register)| register.words == 1);
    let in_registers = registers.step_by(19).enumerate().map(|(i, (at, register))| Fault {
        bit: Bit { register: at, word: 0, bit: i as u32 % register.width },
        cycle: upsets.window().start + 31 * i as u64 % 4096,
        kind: Kind::Seu,
    });
    let faults: Vec<Fault> = faults.into_iter().chain(in_registers).collect();
    let early = campaign(&faults, 2, |fault| upsets.run(fault), |_| ()).unwrap();
    let whole = campaign(&faults, 2, |fault| upsets.run_whole(fault), |_| ()).unwrap();
    for ((fault, early), whole) in faults.iter().zip(&early).zip(&whole) {
        assert_eq!(early, whole, "{:?} of {}", fault, upsets.state().register(fault.bit).name);
    }
    let counts: Counts = early.into_iter().collect();
    assert!(counts.masked > 20 && counts.recovered > 5, "both kinds of runs are compared: {counts:?}");
}

#[test]
fn registers_with_a_known_outcome_have_it() {
    let upsets = upsets();
    let begin = upsets.window().start;
    let class =
        |name: &str, bit: u32, cycle: u64, kind: Kind| upsets.run(&fault(&upsets, name, bit, cycle, kind)).unwrap();
    // Pixels are taken for those of another row: the frame ends early or late, and its trailer says so.
    assert_eq!(class("core.sequencer.y", 4, begin + 2000, Kind::Seu), Class::Detected);
    // The buffer in front never seems empty, or always full: no frame ends.
    assert_eq!(class("core.sequencer.skid_count", 1, begin + 100, Kind::Stuck1), Class::Hang);
    // A count that only the register port shows, which no one reads.
    assert_eq!(class("registers.features_count", 0, begin + 2000, Kind::Seu), Class::Masked);
    // No frame takes a coefficient that is not committed.
    assert_eq!(class("registers.narrow_g_value", 14, begin + 2000, Kind::Seu), Class::Masked);
    // Smoothed samples are wrong in all frames, and nothing says so.
    let smoothed = upsets.state().registers().iter().find(|r| r.module == "lerp" && r.name.ends_with(".y")).unwrap();
    assert_eq!(class(&smoothed.name, 15, begin, Kind::Stuck1), Class::Silent, "{}", smoothed.name);
}

/// Bits of a bank that are coefficients: 19 of 16 bits.
const COEFFICIENT_FIELDS: u32 = 19 * 16;

/// Draws upsets in the memories and banks of a protected design: in words that a frame of 64 columns uses, because most
/// of the others do nothing, and in the coefficients of a bank. A threshold of one frame changes those of later ones,
/// whose records are right for them.
fn protected_faults(upsets: &Upsets, count: usize, seed: u64) -> Vec<Fault> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let is_protected = |(_, register): &(usize, &hoverlock_fault::state::Register)| {
        let blocks = ["column_memory", "line_delay", "held_row", "candidate_queue", "record_fifo"];
        register.name.ends_with(".memory") && blocks.contains(&register.module.as_str())
            || register.name.ends_with("bank.q")
    };
    let registers: Vec<_> = upsets.state().registers().iter().enumerate().filter(is_protected).collect();
    assert_eq!(registers.len(), 1 + 3 + 2 + 2 + 1 + 2 + 2, "{registers:?}");
    (0..count)
        .map(|i| {
            let (at, register) = registers[i % registers.len()];
            let word = random.random_range(0..register.words.min(64));
            let width = if register.name.ends_with("bank.q") { COEFFICIENT_FIELDS } else { register.width };
            let bit = Bit { register: at, word, bit: random.random_range(0..width) };
            Fault { bit, cycle: random.random_range(upsets.window()), kind: Kind::Seu }
        })
        .collect()
}

/// `HOVERLOCK_SEED=S` draws others.
#[test]
fn an_upset_in_a_protected_memory_is_masked_or_detected() {
    let seed = std::env::var("HOVERLOCK_SEED").map_or(1, |text| text.parse().expect("HOVERLOCK_SEED is a number"));
    let design = KT27.with_override("protection=parity").unwrap();
    let simulator = Simulator::with_registers(&design, &verilog(&design, None).unwrap()).unwrap();
    let upsets = Upsets::new(simulator, &frames(MIN_FRAMES), &[100, 100]).unwrap();
    let faults = protected_faults(&upsets, 260, seed);
    let classes = campaign(&faults, 2, |fault| upsets.run(fault), |_| ()).unwrap();
    for (fault, class) in faults.iter().zip(&classes) {
        let register = upsets.state().register(fault.bit);
        assert!(
            matches!(class, Class::Masked | Class::Detected),
            "seed {seed}: {class:?} of {}, {fault:?}",
            register.name
        );
    }
    let counts: Counts = classes.into_iter().collect();
    assert!(counts.detected > 40, "seed {seed}: {counts:?}");
}

#[test]
fn frames_without_a_place_for_a_fault_are_refused() {
    let refused = |frames: &[Plane<u16>]| match Upsets::new(simulator(), frames, &[200, 200]) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("accepted"),
    };
    assert!(refused(&frames(MIN_FRAMES - 1)).contains("too few frames"));
    let mut other = frames(MIN_FRAMES);
    other[2] = Plane::filled(66, 64, 0);
    assert!(refused(&other).contains("differ in size"));
    other[2] = Plane::filled(64, 64, 0);
    assert!(refused(&other).contains("no features"));
    assert!(refused(&[]).contains("too few frames"));
}
