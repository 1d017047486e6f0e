//! Waves of a run: the window that was asked for, every signal of the view in the file, and the focus where it should
//! be.

use std::collections::HashMap;

use hoverlock_design::KT27;
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::{Job, Simulator, Streams, Trace, Window, record, run, signals, view};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wellen::simple::{Waveform, read};

/// Nanoseconds of a clock cycle, and cycles of the reset before the first.
const PERIOD: u64 = 10;
const RESET_CYCLES: u64 = 5;

/// The value of a signal of at most 64 bits at a time in picoseconds.
fn value(waves: &mut Waveform, name: &str, time: u64) -> u64 {
    let hierarchy = waves.hierarchy();
    let named = hierarchy.all_vars().find(|var| hierarchy[*var].full_name(hierarchy) == name);
    let signal = hierarchy[named.unwrap()].signal_ref();
    waves.load_signals(&[signal]);
    let at = waves.time_table().iter().rposition(|t| *t <= time).unwrap() as u32;
    let signal = waves.get_signal(signal).unwrap();
    let offset = signal.get_offset(at).unwrap();
    let bits = signal.get_value_at(&offset, 0).to_bit_string().unwrap();
    u64::from_str_radix(&bits, 2).unwrap()
}

#[test]
#[ignore = "long: a Verilated model with waves built in"]
fn every_signal_of_the_view_is_in_the_waves() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let pixels = Plane::from_fn(80, 64, |x, y| ((x * 311 + y * 173) % 30_000) as u16 + random.random_range(0..30_000));
    let jobs = [Job::new(pixels, [60, 45]).unwrap()];
    let simulator = Simulator::of_design(&KT27, None, Trace::Fst).unwrap();
    let outcome = run(&simulator, &jobs, Streams::default()).unwrap();
    assert!(outcome.pass());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.fst");
    let window = Window::around(&outcome, 400);
    assert_eq!(Some(window.focus), outcome.first_feature);
    record(&simulator, &jobs, Streams::default(), window, &path).unwrap();

    let mut waves = read(&path).unwrap();
    let hierarchy = waves.hierarchy();
    let bits: HashMap<_, _> = hierarchy
        .all_vars()
        .map(|var| (hierarchy[var].full_name(hierarchy), hierarchy[var].length(hierarchy)))
        .collect();
    let shown = signals(&KT27);
    assert!(shown.len() > 90);
    for (name, width) in &shown {
        assert_eq!(bits.get(name), Some(&Some(*width)), "{name}");
    }
    // The view names these and no others.
    let text = view(&KT27, &path, window);
    let names = text.split_whitespace().filter_map(|word| word.find("TOP.").map(|at| &word[at..]));
    let mut named = 0;
    for name in names {
        let bare = name.split('[').next().unwrap();
        assert!(shown.iter().any(|(name, _)| name == bare), "{name}");
        named += 1;
    }
    assert!(named > shown.len());

    // Two changes a cycle at most, from the first cycle of the window to its last.
    let edge = |cycle: u64| ((cycle + RESET_CYCLES) * PERIOD + PERIOD / 2) * 1000;
    let table = waves.time_table();
    assert!(table[0] >= edge(window.from) - PERIOD * 1000);
    assert!(*table.last().unwrap() <= edge(window.from + 400));
    assert!(table.len() > 700, "{}", table.len());
    // In the cycle of the focus, before its edge, the first record is handed over; none is in the cycle before.
    let at = |cycle| edge(cycle) - PERIOD / 2 * 1000;
    let top = |name: &str| format!("TOP.hoverlock_top.{name}");
    assert_eq!(value(&mut waves, &top("feature_valid"), at(window.focus)), 1);
    assert_eq!(value(&mut waves, &top("feature_ready"), at(window.focus)), 1);
    assert_eq!(value(&mut waves, &top("feature_valid"), at(window.focus - 1)), 0);
    assert!(text.contains(&format!("*-16.000000 {}", at(window.focus))));
}
