//! Bus models, native: they work at the edges of a clock without being tasks, and see every signal as it was before
//! the edge.
//!
//! | bus | drives | listens |
//! |---|---|---|
//! | Avalon-ST | [`stream::Source`] | [`stream::Sink`], [`stream::Monitor`] |
//! | AXI4-Stream | the same, with [`stream::Dialect::Axi`] | the same |
//! | Avalon-MM | [`avalon_mm::Master`] | [`avalon_mm::Memory`] |
//! | AXI4-Lite | [`axi_lite::Master`] | [`axi_lite::Memory`] |
//!
//! Every model takes a [`Pause`]: a cycle in which it holds back. A sink, monitor or memory checks the rules of its bus
//! and ends the run with a [`Violation`] that names the rule and the time. [`bulk`] moves whole frames without the
//! scheduler.

pub mod avalon_mm;
pub mod axi_lite;
pub mod bulk;
pub mod stream;

use crate::error::ModelError;
use crate::sim::{Dut, Signal};
use crate::time::Time;

/// A rule of a bus that was not kept.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{bus} at {time}: {rule}")]
pub struct Violation {
    /// The bus, by the prefix of its signals.
    pub bus: String,
    /// The rule, in words.
    pub rule: String,
    /// Simulation time.
    pub time: Time,
}

/// A small generator of random numbers (splitmix64): the same from the same seed, everywhere.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// A generator of its own for every seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// 64 random bits.
    #[inline(always)]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `bound`, which is not 0.
    pub fn below(&mut self, bound: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(bound.max(1))) >> 64) as u64
    }
}

/// In which cycles a bus model holds back.
#[derive(Debug, Clone, Default)]
pub enum Pause {
    /// In none.
    #[default]
    Never,
    /// In each with a probability, in parts of 2^32; see [`Pause::random`].
    Random(u32, Random),
    /// As the pattern says (`true`: hold back), again and again.
    Pattern(Vec<bool>, usize),
}

impl Pause {
    /// Holds back with a probability from 0 to 1, always less than certainly, so that nothing stands still for ever.
    pub fn random(probability: f64, seed: u64) -> Pause {
        let part = probability.clamp(0.0, 0.999) * f64::from(u32::MAX);
        Pause::Random(part as u32, Random::new(seed))
    }

    /// Holds back as a pattern says, again and again; a pattern that never lets go is taken as never holding back.
    pub fn pattern(pattern: impl Into<Vec<bool>>) -> Pause {
        let pattern = pattern.into();
        if pattern.iter().all(|hold| *hold) { Pause::Never } else { Pause::Pattern(pattern, 0) }
    }

    /// The same for one of several channels: each goes through the pattern, or draws its numbers, by itself.
    pub(super) fn of_channel(&self, number: u64) -> Pause {
        match self {
            Pause::Random(part, random) => {
                let seed = random.clone().bits();
                Pause::Random(*part, Random::new(seed.wrapping_add(number)))
            }
            other => other.clone(),
        }
    }

    /// Whether to hold back in the next cycle.
    #[inline(always)]
    pub fn next_cycle(&mut self) -> bool {
        match self {
            Pause::Never => false,
            Pause::Random(part, random) => (random.bits() >> 32) < u64::from(*part),
            Pause::Pattern(pattern, at) => {
                let hold = pattern[*at];
                *at = (*at + 1) % pattern.len();
                hold
            }
        }
    }
}

/// A reset that bus models obey: while it is active they are idle and look at nothing.
#[derive(Clone)]
pub struct Reset {
    signal: Signal,
    active_high: bool,
}

impl Reset {
    /// A reset active at 1.
    pub fn high(signal: &Signal) -> Reset {
        Reset { signal: signal.clone(), active_high: true }
    }

    /// A reset active at 0.
    pub fn low(signal: &Signal) -> Reset {
        Reset { signal: signal.clone(), active_high: false }
    }

    pub(crate) fn is_active(&self) -> bool {
        self.signal.is_high() == self.active_high
    }
}

/// The signal `prefix` + `name`; `None` if there is none.
fn optional(dut: &Dut, prefix: &str, name: &str) -> Result<Option<Signal>, ModelError> {
    match dut.signal(&format!("{prefix}{name}")) {
        Ok(signal) => Ok(Some(signal)),
        Err(ModelError::NoSuchSignal { .. }) => Ok(None),
        Err(other) => Err(other),
    }
}
