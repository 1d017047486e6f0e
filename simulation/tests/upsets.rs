//! Faults in the registers and memories of the top: a run that ends early has the class of the whole run, and registers
//! whose outcome is known have it.

use hoverlock_design::KT27;
use hoverlock_fault::campaign::campaign;
use hoverlock_fault::class::{Class, Counts};
use hoverlock_fault::draw::{Fault, Kind, draw};
use hoverlock_fault::state::Bit;
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::emission::committed;
use hoverlock_simulation::Simulator;
use hoverlock_simulation::upsets::{MIN_FRAMES, Upsets};

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
