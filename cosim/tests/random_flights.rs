//! The beginnings of random flights: no estimate may be misleading.

use hoverlock_cosim::FeatureSource;
use hoverlock_cosim::campaign::random::{RandomFlight, fly_random};

const SEED: u64 = 1;
/// Long enough for the capture, its confirmation and the first faults.
const SECONDS: f64 = 5.0;

/// Flies flights of the seed. A misleading estimate is named with its flight, which `hoverlock sweep` repeats.
fn fly(numbers: [u32; 3]) {
    for number in numbers {
        let flight = RandomFlight::draw(SEED, number, SECONDS);
        let flown = fly_random(&flight, FeatureSource::Fixed, &()).unwrap();
        let what = format!("flight {number} of seed {SEED}: {flown:?}");
        assert!(flown.frames == 76 && flown.answered > 30, "{what}");
        assert!(flown.misleading == 0, "{what}");
    }
}

#[test]
#[ignore = "three flights of 5 s"]
fn the_first_flights_of_the_seed_do_not_mislead() {
    fly([1, 2, 3]);
}

#[test]
#[ignore = "three flights of 5 s"]
fn the_next_flights_of_the_seed_do_not_mislead() {
    fly([4, 5, 6]);
}
