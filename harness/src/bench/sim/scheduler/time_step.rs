//! Runs time steps, each with its regions, in the order that the documentation of `sim` gives.

use std::cmp::Reverse;
use std::sync::atomic::Ordering;

use super::Core;
use super::run_queue::MainTask;
use super::wait_table::WaitId;
use super::wall_clock::{WallClock, Watchdog};
use crate::bench::error::{Error, SimError};
use crate::bench::sim::log::Level;
use crate::bench::sim::task::{Coroutine, TaskId};
use crate::bench::sim::trigger::Outcome;
use crate::bench::sim::{EdgeOrder, Region};
use crate::engine::model::Storage;
use crate::engine::time::Time;

impl Core {
    /// Runs until task `id` has ended, then to the end of that time step. `main` is its future, if `run` has it.
    pub fn run(&self, mut main: MainTask<'_>, id: TaskId) -> Result<(), Error> {
        self.main.set(Some(id));
        self.main_ended.set(false);
        self.max_rounds.set(self.limits.borrow().rounds);
        self.stop_flag.store(false, Ordering::Relaxed);
        let mut watch = self.wall_clock();
        let limit = self.limits.borrow().time.unwrap_or(Time::fs(u64::MAX));
        self.time_step(&mut main)?;
        while !self.main_ended.get() {
            self.check_finished()?;
            let Some(next) = self.next_time() else {
                return Err(SimError::Deadlock { report: self.report() }.into());
            };
            if next > limit {
                return Err(SimError::TimeLimit { limit, report: self.report() }.into());
            }
            if watch.is_due() {
                self.check_wall_clock(&mut watch)?;
            }
            if self.is_quiet(limit) {
                self.quiet_steps(&mut watch, &mut main)?;
            } else {
                self.begin_step(next);
                self.time_step(&mut main)?;
            }
        }
        Ok(())
    }

    /// Returns an error if the Verilog called `$finish` and no task waited for it.
    pub fn check_finished(&self) -> Result<(), Error> {
        if self.is_finished.replace(false)
            && let Some((file, line, time)) = self.finish.take()
        {
            return Err(SimError::Finished { file, line, time }.into());
        }
        Ok(())
    }

    pub fn check_wall_clock(&self, watch: &mut WallClock) -> Result<(), Error> {
        if let Some(seconds) = watch.check(self.now()) {
            return Err(SimError::WallClock { seconds, report: self.report() }.into());
        }
        let asked = self.interrupt.borrow_mut().as_mut().is_some_and(|interrupt| interrupt());
        if asked || self.stop_flag.load(Ordering::Relaxed) {
            return Err(SimError::Interrupted { time: self.now() }.into());
        }
        Ok(())
    }

    pub fn wall_clock(&self) -> WallClock {
        let limit = self.limits.borrow().wall_clock;
        let dog = limit.and_then(|limit| Watchdog::start(limit, self.model.borrow().library().top()));
        WallClock::new(limit, dog)
    }

    #[inline]
    fn next_time(&self) -> Option<Time> {
        let clocks = self.clocks.borrow();
        let clock = clocks.iter().filter(|c| c.running).map(|c| c.next).min();
        let mut timers = self.timers.borrow_mut();
        while let Some(Reverse(entry)) = timers.peek() {
            if self.is_armed(WaitId { index: entry.wait_id.0, generation: entry.wait_id.1 }) {
                // A timer that became due while the scheduler did not run.
                let at = entry.at.max(self.now());
                return Some(clock.map_or(at, |c| c.min(at)));
            }
            timers.pop();
            self.stale_timers.set(self.stale_timers.get().saturating_sub(1));
        }
        clock
    }

    /// Advances time: clocks that are due change their level, timers that are due wake their tasks.
    #[inline]
    fn begin_step(&self, time: Time) {
        self.now.set(time);
        self.region.set(Region::Active);
        let mut timed = false;
        let mut clock_writes = 0;
        for clock in self.clocks.borrow_mut().iter_mut().filter(|c| c.running && c.next == time) {
            let span = if clock.level { clock.high } else { clock.low };
            // Cannot fail: writes are allowed in this region.
            let _ = self.write(clock.signal, u64::from(clock.level));
            clock_writes += 1;
            clock.next = time + span;
            clock.level = !clock.level;
        }
        self.clock_writes.set(clock_writes);
        if !self.next_step.borrow().is_empty() {
            self.fire_list(&self.next_step);
        }
        loop {
            let due = {
                let mut timers = self.timers.borrow_mut();
                match timers.peek() {
                    Some(Reverse(entry)) if entry.at <= time => timers.pop(),
                    _ => None,
                }
            };
            let Some(Reverse(entry)) = due else { break };
            timed = true;
            self.fire(WaitId { index: entry.wait_id.0, generation: entry.wait_id.1 }, None);
        }
        self.timed.set(timed);
    }

    #[inline]
    fn time_step(&self, main: &mut MainTask<'_>) -> Result<(), Error> {
        self.region.set(Region::Active);
        self.run_ready(main)?;
        if self.timed.get() && self.clock_writes.get() > 0 {
            self.warn_of_race();
        }
        self.settle(main, 0)
    }

    #[inline(always)]
    fn check_rounds(&self, rounds: u32) -> Result<(), Error> {
        if rounds > self.max_rounds.get() {
            return Err(SimError::NoProgress { rounds, report: self.report() }.into());
        }
        Ok(())
    }

    /// Runs the rest of a time step after `rounds` rounds: puts writes and evaluates until there are none, then runs
    /// the regions that follow.
    fn settle(&self, main: &mut MainTask<'_>, mut rounds: u32) -> Result<(), Error> {
        loop {
            while !self.writes.borrow().is_empty() || !self.large_writes.borrow().is_empty() {
                rounds += 1;
                self.check_rounds(rounds)?;
                self.apply_writes();
                self.evaluate_and_wake(None, main)?;
            }
            if self.read_write.borrow().is_empty() {
                break;
            }
            rounds += 1;
            self.check_rounds(rounds)?;
            self.region.set(Region::ReadWrite);
            self.fire_list(&self.read_write);
            self.run_ready(main)?;
            self.region.set(Region::Active);
        }
        if !self.read_only.borrow().is_empty() {
            self.region.set(Region::ReadOnly);
            self.fire_list(&self.read_only);
            self.run_ready(main)?;
        }
        if self.has_waves.get() {
            self.waves.borrow_mut().sample(&mut self.model.borrow_mut(), self.now())?;
        }
        Ok(())
    }

    /// Evaluates for what was put, and runs the tasks that it woke or wakes, `first` before the others.
    #[inline(always)]
    fn evaluate_and_wake(
        &self,
        first: Option<(TaskId, Box<dyn Coroutine>)>,
        main: &mut MainTask<'_>,
    ) -> Result<(), Error> {
        let order = self.edge_order.get();
        if order == EdgeOrder::AfterEval {
            self.evaluate()?;
        }
        if let Some((id, coroutine)) = first {
            self.run_coroutine(id, coroutine, Outcome::Fired);
            self.check_failed()?;
        }
        self.run_ready(main)?;
        if order == EdgeOrder::BeforeEval {
            self.evaluate()?;
        }
        self.fire_observed();
        self.run_ready(main)
    }

    #[cold]
    fn warn_of_race(&self) {
        let writes = self.writes.borrow();
        let clocks = self.clocks.borrow();
        for write in writes.iter().filter(|w| !clocks.iter().any(|c| c.running && c.signal == w.signal)) {
            if !self.warned.borrow().contains(&write.signal) {
                self.warned.borrow_mut().push(write.signal);
                let text = format!(
                    "'{}' was written after a Timer in the time step of a clock edge: the edge samples the new value; \
                     wait for the clock's edge instead",
                    self.signal_name(write.signal)
                );
                self.log.borrow_mut().put(self.now(), Level::Warning, "harness", &text);
            }
        }
    }

    /// Looks over what may be due: until when nothing can be but the only clock, if there is one. True if that is more
    /// than its next change.
    fn is_quiet(&self, limit: Time) -> bool {
        let clocks = self.clocks.borrow();
        let [clock] = &clocks[..] else { return false };
        let state = &self.signals[clock.signal as usize];
        let is_quiet = clock.running
            && state.storage == Storage::U8
            && state.data == state.target
            && !self.has_waves.get()
            && self.next_step.borrow().is_empty();
        let first_timer = self.timers.borrow().peek().map_or(limit, |Reverse(entry)| entry.at);
        self.quiet_until.set(if is_quiet { first_timer.min(limit) } else { Time::ZERO });
        clock.next < self.quiet_until.get()
    }

    /// Runs the steps in which the only clock changes its level and nothing else is due, as most steps are. They need
    /// no buffered write for the clock and no search for what else is due. They end before the first step in which
    /// something else is due, or within a step after a call of [`Core::disturb`].
    fn quiet_steps(&self, watch: &mut WallClock, main: &mut MainTask<'_>) -> Result<(), Error> {
        self.region.set(Region::Active);
        self.timed.set(false);
        loop {
            if watch.is_due() {
                self.check_wall_clock(watch)?;
            }
            let Some((signal, level)) = self.next_level() else { return Ok(()) };
            let state = &self.signals[signal as usize];
            // SAFETY: the model lives as long as the core; the signal is stored in a byte.
            let (old, new) = (u64::from(unsafe { *state.data }), u64::from(level));
            if old == new {
                continue;
            }
            // Writes that the step before deferred.
            if !self.writes.borrow().is_empty() {
                self.apply_writes();
            }
            // SAFETY: as above; no reference to it exists.
            unsafe { *state.data = u8::from(level) };
            state.last.set(new);
            let mut rounds = 1;
            let mut first = self.fire_clock(state, old, new);
            loop {
                self.evaluate_and_wake(first.take(), main)?;
                if self.quiet_until.get() == Time::ZERO {
                    return self.settle(main, rounds);
                }
                if self.writes.borrow().is_empty() || (level && self.defers_writes.get()) {
                    break;
                }
                rounds += 1;
                self.check_rounds(rounds)?;
                self.apply_writes();
            }
        }
    }

    /// Advances time to the next change of the only clock, and gives its signal and its new level; none if something
    /// else may be due at that time.
    #[inline(always)]
    fn next_level(&self) -> Option<(u32, bool)> {
        let mut clocks = self.clocks.borrow_mut();
        let clock = clocks.first_mut()?;
        let (time, level) = (clock.next, clock.level);
        if time >= self.quiet_until.get() {
            return None;
        }
        self.now.set(time);
        clock.next = time + if level { clock.high } else { clock.low };
        clock.level = !level;
        Some((clock.signal, level))
    }
}
