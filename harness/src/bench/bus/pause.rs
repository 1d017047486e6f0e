//! The cycles in which a bus model pauses: never, always, at random, by a pattern, or while a switch is on.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A random number generator (SplitMix64; Steele, Lea and Flood, 2014): the same numbers from the same seed everywhere.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// Creates a generator from a seed; every seed is allowed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// Returns 64 random bits.
    #[inline(always)]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number below `bound`; 0 if `bound` is 0.
    pub fn below(&mut self, bound: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(bound.max(1))) >> 64) as u64
    }
}

/// A flag that a bench sets and a bus model follows from the next clock edge on. Clones share it.
///
/// ```
/// use hoverlock_harness::bus::{Pause, Switch};
///
/// let hold = Switch::default();
/// let mut pause = Pause::while_on(&hold); // for `Sink::set_pause`
/// assert!(!pause.next_cycle());
/// hold.set(true);
/// assert!(pause.next_cycle());
/// ```
#[derive(Debug, Clone, Default)]
pub struct Switch(Arc<AtomicBool>);

impl Switch {
    /// Turns it on or off.
    #[inline]
    pub fn set(&self, on: bool) {
        self.0.store(on, Ordering::Relaxed);
    }

    /// Returns `true` if it is on; a new switch is off.
    #[inline(always)]
    pub fn is_on(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The cycles in which a bus model pauses: a source offers no new beat, a sink or memory is not ready.
#[derive(Debug, Clone, Default)]
pub enum Pause {
    /// Never pauses.
    #[default]
    Never,
    /// Always pauses: `ready` stays low until another pause is set.
    Always,
    /// Pauses in each cycle with a probability, in units of 2^-32; see [`Pause::random`].
    Random(u32, Random),
    /// Pauses by a repeated pattern (`true`: pause), from a position in it on; see [`Pause::pattern`].
    Pattern(Vec<bool>, usize),
    /// Pauses while a switch is on.
    Switch(Switch),
}

impl Pause {
    /// Pauses in each cycle with a probability from 0 to 0.999; a greater one is taken as 0.999, so that the bus does
    /// move.
    pub fn random(probability: f64, seed: u64) -> Pause {
        let part = probability.clamp(0.0, 0.999) * f64::from(u32::MAX);
        Pause::Random(part as u32, Random::new(seed))
    }

    /// Pauses by a repeated pattern (`true`: pause). A pattern of pauses alone is taken as [`Pause::Never`], so that
    /// the bus does move.
    pub fn pattern(pattern: impl Into<Vec<bool>>) -> Pause {
        let pattern = pattern.into();
        if pattern.iter().all(|pause| *pause) { Pause::Never } else { Pause::Pattern(pattern, 0) }
    }

    /// Pauses while a switch is on, for benches that decide in each cycle.
    pub fn while_on(switch: &Switch) -> Pause {
        Pause::Switch(switch.clone())
    }

    /// Returns the same pause for one of several channels: each has its own position in the pattern, or its own random
    /// numbers.
    pub(super) fn of_channel(&self, number: u64) -> Pause {
        match self {
            Pause::Random(part, random) => {
                let seed = random.clone().bits();
                Pause::Random(*part, Random::new(seed.wrapping_add(number)))
            }
            other => other.clone(),
        }
    }

    /// Returns `true` if the next cycle is one of a pause, and moves on by one cycle.
    #[inline(always)]
    pub fn next_cycle(&mut self) -> bool {
        match self {
            Pause::Never => false,
            Pause::Always => true,
            Pause::Random(part, random) => (random.bits() >> 32) < u64::from(*part),
            Pause::Pattern(pattern, at) => {
                let pause = pattern[*at];
                *at = (*at + 1) % pattern.len();
                pause
            }
            Pause::Switch(switch) => switch.is_on(),
        }
    }
}
