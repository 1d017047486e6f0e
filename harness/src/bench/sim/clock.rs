//! Clocks driven by the scheduler.

use super::scheduler::ClockState;
use super::signal::Signal;
use crate::bench::error::Error;
use crate::engine::time::Time;

/// A clock driven by the scheduler: it is no task and costs nothing but its evaluations.
#[derive(Clone)]
pub struct Clock {
    pub(super) signal: Signal,
    pub(super) high: Time,
    pub(super) low: Time,
}

impl Clock {
    /// Returns the signal it drives.
    pub fn signal(&self) -> &Signal {
        &self.signal
    }

    /// Returns the sum of its high and low spans.
    pub fn period(&self) -> Time {
        self.high + self.low
    }

    pub(crate) fn high(&self) -> Time {
        self.high
    }

    pub(crate) fn low(&self) -> Time {
        self.low
    }

    /// Starts the clock again: the rising edge comes after `phase`, until then it is low.
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
        core.disturb();
        let mut clocks = core.clocks.borrow_mut();
        clocks.retain(|c| c.signal != signal);
        clocks.push(ClockState { signal, high: self.high, low: self.low, next, level: !level, running: true });
        Ok(())
    }

    /// Stops the clock at its level.
    pub fn stop(&self) {
        let signal = self.signal.id().index() as u32;
        self.signal.core.disturb();
        for clock in self.signal.core.clocks.borrow_mut().iter_mut().filter(|c| c.signal == signal) {
            clock.running = false;
        }
    }
}
