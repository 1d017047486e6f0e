//! The top from its ports: registers, status, interrupt, resets, sizes, gaps, automatic thresholds, a sink that is not
//! ready.

mod port_bench;

use std::sync::LazyLock;

use hoverlock_simulation::Simulator;
use port_bench::{
    of_other_designs,
    scenarios::{self, SCENARIOS, Scenario},
};
use proptest::prelude::*;

static SIMULATOR: LazyLock<Simulator> = LazyLock::new(|| Simulator::new().expect("Verilator builds the top"));

fn passes(name: &str) {
    let (_, scenario) = SCENARIOS.iter().find(|(this, _)| *this == name).unwrap();
    scenario(&SIMULATOR).unwrap_or_else(|failure| panic!("{failure}"));
}

macro_rules! scenarios {
    ($($test:ident: $name:literal;)*) => {$(
        #[test]
        fn $test() {
            passes($name);
        }
    )*};
}

scenarios! {
    every_register_reads_and_writes_as_documented: "registers";
    status_bits_are_sticky_and_the_interrupt_follows_them: "status";
    frames_back_to_back_keep_their_coefficients_and_thresholds: "frames";
    faulty_frames_are_reported_once_and_leave_their_neighbours_exact: "faults";
    error_bits_stay_with_their_frame_at_any_phase: "tags";
    impossible_sizes_are_refused_and_sizes_change_in_all_directions: "sizes";
    frames_begin_at_any_phase_of_the_drain: "gaps";
    a_disabled_core_drains_under_a_stream_that_goes_on: "disabled";
    a_reset_at_any_moment_leaves_nothing_behind: "resets";
    a_reset_forgets_the_last_set_and_its_thresholds: "forgotten";
    thresholds_follow_the_responses: "automatic";
    a_full_fifo_drops_and_counts_then_stops_the_video: "overflow";
}

#[test]
fn the_other_shipped_designs_pass_every_scenario() {
    let passes = |simulator: &Simulator| {
        let failure = |(name, scenario): (_, Scenario)| Some(format!("{name}: {}", scenario(simulator).err()?));
        SCENARIOS.into_iter().filter_map(failure).collect()
    };
    assert_eq!(of_other_designs(passes), [""; 0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_gap_between_frames(cycles in 0u64..7000, pauses in prop_oneof![Just(0.0), 0.0..0.5], seed: u64) {
        if let Err(failure) = scenarios::gap(&SIMULATOR, cycles, pauses, seed) {
            prop_assert!(false, "{}", failure);
        }
    }

    #[test]
    fn a_reset_at_any_cycle(moment in 0u64..12_000, software: bool, seed: u64) {
        if let Err(failure) = scenarios::reset_at(&SIMULATOR, moment, software, seed) {
            prop_assert!(false, "{}", failure);
        }
    }
}
