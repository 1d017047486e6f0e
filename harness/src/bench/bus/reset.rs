//! The reset of a bus model.

use super::Switch;
use crate::bench::sim::Signal;

/// The reset of a bus model: while it is active, the model is idle and checks nothing.
#[derive(Clone)]
pub struct Reset(Source);

#[derive(Clone)]
enum Source {
    Signal { signal: Signal, active_high: bool },
    Switch(Switch),
}

impl Reset {
    /// Creates a reset that is active while a signal is 1.
    pub fn high(signal: &Signal) -> Reset {
        Reset(Source::Signal { signal: signal.clone(), active_high: true })
    }

    /// Creates a reset that is active while a signal is 0.
    pub fn low(signal: &Signal) -> Reset {
        Reset(Source::Signal { signal: signal.clone(), active_high: false })
    }

    /// Creates a reset that is active while a switch is on, for designs that are reset through a register.
    pub fn while_on(switch: &Switch) -> Reset {
        Reset(Source::Switch(switch.clone()))
    }

    #[inline(always)]
    pub(super) fn is_active(&self) -> bool {
        match &self.0 {
            Source::Signal { signal, active_high } => signal.is_high() == *active_high,
            Source::Switch(switch) => switch.is_on(),
        }
    }
}
