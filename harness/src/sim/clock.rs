//! Clocks driven by the scheduler.

use super::scheduler::ClockState;
use super::signal::Signal;
use crate::error::Error;
use crate::time::Time;

/// A clock of the harness: no task, no cost but its evaluations.
#[derive(Clone)]
pub struct Clock {
    pub(super) signal: Signal,
    pub(super) high: Time,
    pub(super) low: Time,
}

impl Clock {
    /// The signal it drives.
    pub fn signal(&self) -> &Signal {
        &self.signal
    }

    /// High and low together.
    pub fn period(&self) -> Time {
        self.high + self.low
    }

    pub(crate) fn high(&self) -> Time {
        self.high
    }

    pub(crate) fn low(&self) -> Time {
        self.low
    }

    /// Begins again with a rising edge after `phase`; until then the clock is low.
    ///
    /// # Errors
    /// If the signal is written in `ReadOnly`.
    pub fn start(&self, phase: Time) -> Result<(), Error> {
        let core = &self.signal.core;
        self.stop();
        let level = phase == Time::ZERO;
        self.signal.set(u64::from(level))?;
        let next = core.now() + if level { self.high } else { phase };
        let signal = self.signal.id().index() as u32;
        let mut clocks = core.clocks.borrow_mut();
        clocks.retain(|c| c.signal != signal);
        clocks.push(ClockState { signal, high: self.high, low: self.low, next, level: !level, running: true });
        Ok(())
    }

    /// Leaves it at its level.
    pub fn stop(&self) {
        let signal = self.signal.id().index() as u32;
        for clock in self.signal.core.clocks.borrow_mut().iter_mut().filter(|c| c.signal == signal) {
            clock.running = false;
        }
    }
}
