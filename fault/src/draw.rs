//! Faults, and how they are drawn from a seed.

use std::ops::Range;

use hoverlock_harness::ModelError;
use hoverlock_harness::model::{Model, SignalId};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::state::{Bit, State};

/// What happens to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A single-event upset: the bit is inverted once, and keeps the wrong value until it is written.
    Seu,
    /// The bit is 0 from the cycle on.
    Stuck0,
    /// The bit is 1 from the cycle on.
    Stuck1,
}

/// A fault in one bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Fault {
    /// The bit.
    pub bit: Bit,
    /// The clock cycle in whose first half it happens, or begins: before the rising edge that ends it.
    pub cycle: u64,
    /// What happens.
    pub kind: Kind,
}

/// Draws `count` faults from a seed: each bit of the state and each cycle of the range is equally likely, and the same
/// bit may be drawn again. Returns none for a state without bits or an empty range.
pub fn draw(state: &State, cycles: Range<u64>, kind: Kind, count: usize, seed: u64) -> Vec<Fault> {
    if cycles.is_empty() || state.bits() == 0 {
        return Vec::new();
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || {
        let bit = state.bit(random.random_range(0..state.bits()))?;
        Some(Fault { bit, cycle: random.random_range(cycles.clone()), kind })
    };
    (0..count).filter_map(|_| draw()).collect()
}

/// A fault in a model that runs: what to write in each cycle.
#[derive(Debug, Clone, Copy)]
pub struct Injection {
    fault: Fault,
    register: SignalId,
}

impl Injection {
    /// Prepares a fault in a model with this state.
    ///
    /// # Errors
    /// If the model has no such register.
    pub fn new(model: &Model, state: &State, fault: &Fault) -> Result<Self, ModelError> {
        Ok(Self { fault: *fault, register: model.find(&state.register(fault.bit).name)? })
    }

    /// Writes the bit if the fault acts in this clock cycle; to be called while the clock is low.
    ///
    /// # Errors
    /// If the register has no such bit.
    pub fn apply(&self, model: &mut Model, cycle: u64) -> Result<(), ModelError> {
        let Fault { bit: Bit { word, bit, .. }, cycle: begins, kind } = self.fault;
        let value = match kind {
            Kind::Seu if cycle == begins => !model.bit(self.register, word, bit)?,
            Kind::Stuck0 | Kind::Stuck1 if cycle >= begins => kind == Kind::Stuck1,
            _ => return Ok(()),
        };
        model.set_bit(self.register, word, bit, value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Register;

    fn state() -> State {
        let register = |name: &str, words, width| Register { name: name.into(), module: "t".into(), words, width };
        State::new([register("flag", 1, 1), register("memory", 31, 9), register("count", 1, 8)])
    }

    #[test]
    fn a_seed_gives_the_same_faults() {
        let faults = |count, seed| draw(&state(), 10..20, Kind::Seu, count, seed);
        assert_eq!(faults(100, 7), faults(100, 7));
        assert_eq!(faults(100, 7)[..50], faults(50, 7), "fewer are the first of more");
        assert_ne!(faults(100, 7), faults(100, 8));
    }

    #[test]
    fn bits_and_cycles_are_equally_likely() {
        let faults = draw(&state(), 10..20, Kind::Seu, 28_800, 1);
        let of = |register: usize| faults.iter().filter(|fault| fault.bit.register == register).count() as f64;
        // 1, 279 and 8 of 288 bits: 100, 27 900 and 800 expected, standard deviations 10, 30 and 28.
        assert!((of(0) - 100.0).abs() < 50.0 && (of(1) - 27_900.0).abs() < 150.0 && (of(2) - 800.0).abs() < 140.0);
        for cycle in 10..20 {
            let count = faults.iter().filter(|fault| fault.cycle == cycle).count() as f64;
            assert!((count - 2880.0).abs() < 255.0, "cycle {cycle}: {count}");
        }
    }

    #[test]
    fn nothing_is_drawn_from_nothing() {
        assert!(draw(&State::default(), 0..9, Kind::Seu, 5, 1).is_empty());
        assert!(draw(&state(), 9..9, Kind::Seu, 5, 1).is_empty());
    }
}
