//! Bus models in Rust. They run at the edges of a clock, without a task, and read every signal as it was before the
//! edge.
//!
//! | bus | drives the design | answers or listens |
//! |---|---|---|
//! | Avalon-ST | [`stream::Source`] | [`stream::Sink`], [`stream::Monitor`] |
//! | AXI4-Stream | the same, with [`stream::Dialect::Axi`] | the same |
//! | Avalon-MM | [`avalon_mm::Master`] | [`avalon_mm::Memory`] |
//! | AXI4-Lite | [`axi_lite::Master`] | [`axi_lite::Memory`] |
//! | AXI4, with bursts | [`axi4::Master`], which checks the slave | [`axi4::Memory`], [`axi4::Checker`] |
//!
//! Every model that drives takes a [`Pause`]: the cycles in which it inserts idle or stall cycles. Sinks, monitors and
//! memories check the rules of their bus: a broken rule ends the run with a [`Violation`] that names rule and time.
//! [`bulk`] moves whole frames without the scheduler.

pub mod avalon_mm;
pub mod axi4;
pub mod axi_lite;
pub mod bulk;
mod handshake;
pub mod stream;
mod words;

pub use self::words::Contents;
use crate::error::ModelError;
use crate::sim::{Dut, Signal};
use crate::time::Time;

/// A broken rule of a bus.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{bus} at {time}: {rule}")]
pub struct Violation {
    /// The bus, by the prefix of its signals.
    pub bus: String,
    /// What was wrong.
    pub rule: String,
    /// Simulation time.
    pub time: Time,
}

/// A random number generator (SplitMix64; Steele, Lea and Flood, 2014): the same numbers from the same seed everywhere.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// A generator with a seed.
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

/// In which cycles a bus model pauses: a source offers nothing, a sink or memory is not ready.
#[derive(Debug, Clone, Default)]
pub enum Pause {
    /// In none.
    #[default]
    Never,
    /// In each cycle with a probability, in units of 2^-32; see [`Pause::random`].
    Random(u32, Random),
    /// As a repeated pattern says (`true`: pause).
    Pattern(Vec<bool>, usize),
}

impl Pause {
    /// Pauses in each cycle with a probability from 0 to 0.999; a greater one is taken as 0.999, so that the bus does
    /// move.
    pub fn random(probability: f64, seed: u64) -> Pause {
        let part = probability.clamp(0.0, 0.999) * f64::from(u32::MAX);
        Pause::Random(part as u32, Random::new(seed))
    }

    /// Pauses as a repeated pattern says (`true`: pause). A pattern of pauses alone is taken as [`Pause::Never`].
    pub fn pattern(pattern: impl Into<Vec<bool>>) -> Pause {
        let pattern = pattern.into();
        if pattern.iter().all(|pause| *pause) { Pause::Never } else { Pause::Pattern(pattern, 0) }
    }

    /// The same for one of several channels: each has its own position in the pattern, or its own random numbers.
    pub(super) fn of_channel(&self, number: u64) -> Pause {
        match self {
            Pause::Random(part, random) => {
                let seed = random.clone().bits();
                Pause::Random(*part, Random::new(seed.wrapping_add(number)))
            }
            other => other.clone(),
        }
    }

    /// Whether to pause in the next cycle.
    #[inline(always)]
    pub fn next_cycle(&mut self) -> bool {
        match self {
            Pause::Never => false,
            Pause::Random(part, random) => (random.bits() >> 32) < u64::from(*part),
            Pause::Pattern(pattern, at) => {
                let pause = pattern[*at];
                *at = (*at + 1) % pattern.len();
                pause
            }
        }
    }
}

/// The reset of a bus model: while it is active, the model is idle and checks nothing.
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
