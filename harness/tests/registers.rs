//! Registers and memories of a model: which they are, and that a changed bit in one is seen.

use hoverlock_harness::build::Build;
use hoverlock_harness::model::Model;
use hoverlock_harness::sim::{Sim, expect_equal};
use hoverlock_harness::{ModelError, Time};

fn design(file: &str) -> String {
    format!("{}/tests/designs/{file}", env!("CARGO_MANIFEST_DIR"))
}

/// The design `state` after four cycles of which the first resets, its clock low.
fn model() -> Model {
    let library = Build::new("state").source(design("state.v")).registers(true).compile().unwrap();
    let mut model = library.instance().unwrap();
    set(&mut model, "rst", 1);
    set(&mut model, "in", 5);
    cycle(&mut model);
    set(&mut model, "rst", 0);
    (0..3).for_each(|_| cycle(&mut model));
    model
}

fn set(model: &mut Model, name: &str, value: u64) {
    model.set(model.find(name).unwrap(), value).unwrap();
}

fn get(model: &Model, name: &str) -> u64 {
    model.get(model.find(name).unwrap())
}

fn cycle(model: &mut Model) {
    for level in [1, 0] {
        set(model, "clk", level);
        model.eval().unwrap();
    }
}

/// Inverts a bit, and evaluates without an edge.
fn flip(model: &mut Model, name: &str, word: usize, bit: u32) {
    let id = model.find(name).unwrap();
    let old = model.bit(id, word, bit).unwrap();
    model.set_bit(id, word, bit, !old).unwrap();
    model.eval().unwrap();
    assert_eq!(model.bit(id, word, bit).unwrap(), !old, "{name} keeps it");
}

#[test]
fn registers_are_what_a_clock_assigns() {
    let model = model();
    let mut found: Vec<_> =
        model.signals().iter().filter(|s| s.register).map(|s| (s.name.as_str(), s.module.as_str(), s.width)).collect();
    found.sort_unstable();
    let expected = [
        ("at", "state", 3),
        ("by_task", "state", 4),
        ("lane[0].kept.kept", "state_bit", 1),
        ("lane[1].kept.kept", "state_bit", 1),
        ("memory", "state", 8),
        ("out", "state", 8),
        ("shift", "state", 100),
        ("total", "state", 8),
    ];
    assert_eq!(found, expected);
}

#[test]
fn a_changed_bit_reaches_logic_without_an_edge() {
    let mut model = model();
    let before = get(&model, "inverted");
    flip(&mut model, "out", 0, 6);
    assert_eq!(get(&model, "inverted"), before ^ 64, "an output of the top that is a register");
    let at = get(&model, "at") as usize;
    let before = get(&model, "word");
    flip(&mut model, "memory", at, 3);
    assert_eq!(get(&model, "word"), before ^ 8, "a word of a memory");
    flip(&mut model, "shift", 0, 97);
    let chain = model.get_words(model.find("chain").unwrap());
    assert_eq!(chain[3], 2, "a wide register");
    flip(&mut model, "lane[1].kept.kept", 0, 0);
    assert_eq!(get(&model, "lanes"), 0b11, "a register below");
}

#[test]
fn a_changed_bit_reaches_the_next_edge() {
    let (mut left, mut right) = (model(), model());
    // Changed and clocked without an evaluation in between.
    let total = left.find("total").unwrap();
    let bit = left.bit(total, 0, 7).unwrap();
    left.set_bit(total, 0, 7, !bit).unwrap();
    cycle(&mut left);
    cycle(&mut right);
    assert_eq!(get(&left, "out") ^ get(&right, "out"), 128);
}

#[test]
fn what_is_no_register_is_refused() {
    let mut model = model();
    let id = |name: &str| model.find(name).unwrap();
    let (inverted, memory, out) = (id("inverted"), id("memory"), id("out"));
    let message = |result: Result<(), ModelError>| result.unwrap_err().to_string();
    assert!(message(model.set_bit(inverted, 0, 0, true)).contains("'inverted' is no register"));
    assert!(message(model.set_bit(out, 0, 8, true)).contains("'out' has no bit 8: it has 8 bits"));
    assert!(message(model.set_bit(memory, 8, 0, true)).contains("memory"));
    assert!(model.set_bit(memory, 7, 7, true).is_ok());
}

#[test]
fn a_bench_flips_a_bit_between_two_edges() {
    let library = Build::new("state").source(design("state.v")).registers(true).compile().unwrap();
    let mut sim = Sim::new(library.instance().unwrap()).unwrap();
    let dut = sim.dut();
    dut.clock("clk", Time::ns(10)).unwrap();
    let total = dut.find("total").unwrap();
    let ended = sim.run(async {
        let (clk, rst, out) = (dut.signal("clk")?, dut.signal("rst")?, dut.signal("out")?);
        rst.set(1)?;
        clk.cycles(2).await;
        rst.set(0)?;
        clk.cycles(3).await;
        clk.falling_edge().await;
        assert!(!dut.bit(total, 0, 7)?);
        dut.set_bit(total, 0, 7, true)?;
        clk.cycles(2).await;
        expect_equal("bit 7 of the output", out.get() >> 7, 1)
    });
    ended.unwrap();
}

#[test]
fn saved_registers_continue_a_run() {
    let (mut left, mut right) = (model(), model());
    (0..5).for_each(|_| cycle(&mut left));
    let mut saved = Vec::new();
    left.save_registers(&mut saved);
    right.load_registers(&saved).unwrap();
    let outputs = |model: &Model| ["out", "inverted", "word", "lanes"].map(|name| get(model, name));
    for _ in 0..20 {
        cycle(&mut left);
        cycle(&mut right);
        assert_eq!(outputs(&left), outputs(&right));
    }
    assert!(right.load_registers(&saved[1..]).unwrap_err().to_string().contains("not those of 'state'"));
}
