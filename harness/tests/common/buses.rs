//! What the tests of bus models share: a design out of reset, pauses, frames.

use hoverlock_harness::build::Build;
use hoverlock_harness::bus::stream::{Dialect, Frame};
use hoverlock_harness::bus::{Pause, Random, Reset};
use hoverlock_harness::sim::{Dut, Signal, Sim};
use hoverlock_harness::{Error, Time};
use proptest::prelude::*;

use super::sim;

pub const PERIOD: Time = Time::ns(10);
pub const AVALON: Dialect = Dialect::Avalon { ready_latency: 0 };

/// Clock running, reset given for two cycles by a task of its own.
pub fn start(build: Build, reset_name: &str) -> (Sim, Dut, Signal, Reset) {
    let sim = sim(build);
    let dut = sim.dut();
    dut.clock("clk", PERIOD).unwrap();
    let clk = dut.signal("clk").unwrap();
    let reset = dut.signal(reset_name).unwrap();
    let high = reset_name == "rst";
    reset.set(u64::from(high)).unwrap();
    let kept = if high { Reset::high(&reset) } else { Reset::low(&reset) };
    let clock = clk.clone();
    dut.spawn("reset", async move {
        clock.cycles(3).await;
        reset.set(u64::from(!high))?;
        Ok::<(), Error>(())
    });
    (sim, dut, clk, kept)
}

/// Pauses of every kind by name; `seed` decides the random one.
pub fn pauses(seed: u64) -> Vec<(&'static str, Pause)> {
    vec![
        ("never", Pause::Never),
        ("every other", Pause::pattern([true, false])),
        ("bursts", Pause::pattern([false, false, false, true, true, true, true, true])),
        ("random", Pause::random(0.5, seed)),
    ]
}

/// Frames of all short lengths and some long ones, with data of several kinds.
pub fn frames(symbol_bits: u32, lengths: &[usize], seed: u64) -> Vec<Frame> {
    let mut random = Random::new(seed);
    let largest = u64::MAX >> (64 - symbol_bits);
    lengths
        .iter()
        .enumerate()
        .map(|(number, length)| {
            let symbols = (0..*length as u64).map(|at| match number % 4 {
                0 => at & largest,
                1 => largest,
                2 => 0,
                _ => random.bits() & largest,
            });
            Frame { symbols: symbols.collect(), ..Frame::default() }
        })
        .collect()
}

/// Any pause, for property tests.
pub fn any_pause() -> impl Strategy<Value = Pause> {
    prop_oneof![
        Just(Pause::Never),
        (0.05f64..0.95, any::<u64>()).prop_map(|(p, seed)| Pause::random(p, seed)),
        prop::collection::vec(any::<bool>(), 1..12).prop_map(Pause::pattern),
    ]
}
