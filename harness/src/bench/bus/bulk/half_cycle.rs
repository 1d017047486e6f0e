//! Half a clock cycle: the clock's level, one evaluation, and what follows every evaluation.

use std::cell::RefMut;

use crate::bench::error::Error;
use crate::bench::sim::{Core, Dut, Signal, WallClock};
use crate::engine::model::{Model, store};
use crate::engine::time::Time;

/// Puts a value into a port at once, without the regions of a time step.
///
/// # Safety
/// The model must be alive, nobody may be reading the port, and the value must fit it.
#[inline(always)]
pub(super) unsafe fn put_now(signal: &Signal, value: u64) {
    // SAFETY: as the caller promises.
    unsafe { store(signal.data(), signal.storage(), value) };
}

/// A driver of one clock, by half cycles.
pub(super) struct HalfCycles<'a> {
    dut: &'a Dut,
    core: &'a Core,
    clk: Signal,
    now: Time,
    is_recording: bool,
    wall_clock: WallClock,
}

impl<'a> HalfCycles<'a> {
    /// Begins with the writes that are buffered: no time step would put them before the first edge.
    pub fn new(dut: &'a Dut, clk: &Signal) -> HalfCycles<'a> {
        let core = &**dut.core();
        core.apply_writes();
        HalfCycles {
            dut,
            core,
            clk: clk.clone(),
            now: core.now(),
            is_recording: core.has_waves(),
            wall_clock: core.wall_clock(),
        }
    }

    /// Returns the simulation time.
    pub fn now(&self) -> Time {
        self.now
    }

    /// Puts the clock low, evaluates, and gives the model, bound to this thread.
    pub fn begin(&mut self) -> Result<RefMut<'a, Model>, Error> {
        let mut model = self.core.model.borrow_mut();
        // SAFETY: the model is alive and borrowed alone; a clock is one bit of an input.
        unsafe { put_now(&self.clk, 0) };
        model.set_time(self.now);
        model.eval()?;
        model.bind();
        Ok(model)
    }

    /// Makes the falling edge and advances time by `span`, until the rising one. `$time` stays that of the last rising
    /// edge.
    ///
    /// # Safety
    /// The model must be the one that [`HalfCycles::begin`] gave, and still be bound to this thread.
    #[inline(always)]
    pub unsafe fn falling(&mut self, model: RefMut<'a, Model>, span: Time) -> Result<RefMut<'a, Model>, Error> {
        // SAFETY: as the caller promises.
        unsafe { self.half_cycle(model, 0, span) }
    }

    /// Makes the rising edge and advances time by `span`, until the falling one.
    ///
    /// # Safety
    /// As [`HalfCycles::falling`].
    #[inline(always)]
    pub unsafe fn rising(&mut self, mut model: RefMut<'a, Model>, span: Time) -> Result<RefMut<'a, Model>, Error> {
        model.set_time(self.now);
        // SAFETY: as the caller promises.
        unsafe { self.half_cycle(model, 1, span) }
    }

    #[inline(always)]
    unsafe fn half_cycle(
        &mut self,
        mut model: RefMut<'a, Model>,
        level: u64,
        span: Time,
    ) -> Result<RefMut<'a, Model>, Error> {
        // SAFETY: as the callers' callers promise.
        unsafe {
            put_now(&self.clk, level);
            model.eval_bound();
        }
        if model.has_messages() {
            model = self.handle_messages(model)?;
        }
        if self.is_recording {
            self.core.waves.borrow_mut().sample(&mut model, self.now)?;
        }
        self.now += span;
        Ok(model)
    }

    /// Logs the text that the Verilog printed; its errors and `$finish` end the run.
    #[cold]
    fn handle_messages(&self, model: RefMut<'a, Model>) -> Result<RefMut<'a, Model>, Error> {
        self.core.set_now(self.now);
        // Listeners of the log may look into the model.
        drop(model);
        self.dut.handle_messages()?;
        self.core.check_finished()?;
        Ok(self.borrow_again())
    }

    /// Ends the run if its time on the wall is over or it was interrupted.
    #[inline(always)]
    pub fn check_wall_clock(&mut self, model: RefMut<'a, Model>) -> Result<RefMut<'a, Model>, Error> {
        if self.wall_clock.is_due() { self.look_at_wall_clock(model) } else { Ok(model) }
    }

    #[cold]
    fn look_at_wall_clock(&mut self, model: RefMut<'a, Model>) -> Result<RefMut<'a, Model>, Error> {
        self.core.set_now(self.now);
        // The report of an error looks into the model.
        drop(model);
        self.core.check_wall_clock(&mut self.wall_clock)?;
        Ok(self.borrow_again())
    }

    fn borrow_again(&self) -> RefMut<'a, Model> {
        let mut model = self.core.model.borrow_mut();
        model.bind();
        model
    }

    /// Ends the transfer with the clock low and the model evaluated, at the time reached.
    pub fn end(&mut self) -> Result<(), Error> {
        let mut model = self.core.model.borrow_mut();
        // SAFETY: as in `begin`.
        unsafe { put_now(&self.clk, 0) };
        model.set_time(self.now);
        let ended = model.eval();
        drop(model);
        self.core.set_now(self.now);
        Ok(ended?)
    }
}
