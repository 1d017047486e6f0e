//! One simulation: a model with its tasks and clocks, and the runs of benches on it.

use std::cell::RefCell;
use std::future::Future;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::dut::Dut;
use super::log::{Level, Line};
use super::scheduler::{Body, Core};
use super::task::{Coroutine, Ending};
use super::{EdgeOrder, Limits};
use crate::bench::error::{Error, SimError};
use crate::bench::report::StuckReport;
use crate::engine::model::{Message, Model};
use crate::engine::time::Time;

/// A simulation: one model and its tasks. It stays on its thread. When it is dropped, all its tasks end.
pub struct Sim {
    core: Rc<Core>,
}

impl Sim {
    /// Creates a simulation of a fresh model, at time 0 and settled.
    ///
    /// # Errors
    /// If an `initial` block of the Verilog fails or ends the simulation.
    pub fn new(model: Model) -> Result<Sim, Error> {
        Ok(Sim { core: Core::new(model)? })
    }

    /// Returns the handle for tasks.
    pub fn dut(&self) -> Dut {
        Dut { core: self.core.clone() }
    }

    /// Sets the limits of runs.
    pub fn set_limits(&self, limits: Limits) {
        *self.core.limits.borrow_mut() = limits;
    }

    /// Sets when tasks wake that wait for an edge of an input.
    pub fn set_edge_order(&self, order: EdgeOrder) {
        self.core.edge_order.set(order);
    }

    /// Sets whether writes at a rising edge of the only clock are put together with its falling edge rather than after
    /// the rising one, which saves one of three evaluations in each cycle. Off by default.
    ///
    /// Registers that sample at rising edges see the same values. Outputs that depend on inputs without a register
    /// change half a period later. Steps in which anything but the clock is due (another clock, a timer, waves, a wait
    /// for a region) put writes at once.
    pub fn defer_writes(&self, on: bool) {
        self.core.defers_writes.set(on);
    }

    /// Sets whether a write to an output of the top is a deposit, as in cocotb: the output has the value written until
    /// the design assigns it again, and a warning is logged once for each signal. Off by default: such a write is
    /// [`ModelError::NotWritable`](crate::ModelError::NotWritable).
    pub fn deposit_on_outputs(&self, on: bool) {
        self.core.deposits_on_outputs.set(on);
    }

    /// Sets a function that is called every few milliseconds during a run. If it returns `true`, the run ends with
    /// [`SimError::Interrupted`](crate::SimError::Interrupted).
    pub fn set_interrupt(&self, asked: impl FnMut() -> bool + 'static) {
        *self.core.interrupt.borrow_mut() = Some(Box::new(asked));
    }

    /// Returns a flag that interrupts the run from another thread or a signal handler.
    pub fn stop_flag(&self) -> StopFlag {
        StopFlag(self.core.stop_flag.clone())
    }

    /// Runs a bench until it returns, then finishes that time step. Tasks that the bench started stay alive and
    /// continue in the next run.
    ///
    /// # Errors
    /// The first of: the error of the bench, of a task that nobody waited for, of the Verilog (`$error`, `$finish`),
    /// of a bus rule, of a limit; or that no event can come any more.
    pub fn run<T, E: Into<Error>>(&mut self, bench: impl Future<Output = Result<T, E>>) -> Result<T, Error> {
        let result = RefCell::new(None);
        let ended = {
            let mut main = std::pin::pin!(async {
                let ended = bench.await;
                *result.borrow_mut() = Some(ended);
            });
            let id = self.core.spawn("bench", Body::Main, false);
            let main: Pin<&mut dyn Future<Output = ()>> = main.as_mut();
            let ended = self.core.run(Some(main), id);
            self.core.cancel(id);
            self.core.forget(id);
            ended
        };
        let result = match result.into_inner() {
            // The bench's own error comes first: an error of the same time step would hide it.
            Some(Err(error)) => Err(error.into()),
            Some(Ok(value)) => ended.map(|()| value),
            None => ended.and(Err(Error::bench("the bench was cancelled"))),
        };
        self.keep_waves(result.is_err())?;
        result
    }

    /// Flushes the wave files; after a failure, writes those that were kept for a failure.
    fn keep_waves(&self, failed: bool) -> Result<(), Error> {
        let mut waves = self.core.waves.borrow_mut();
        let mut model = self.core.model.borrow_mut();
        if failed {
            // A model that stopped in the middle has this step's values too.
            waves.sample(&mut model, self.core.now())?;
            Ok(waves.failed(&mut model)?)
        } else {
            Ok(waves.flush(&mut model)?)
        }
    }

    /// Runs a coroutine of another language as the bench.
    ///
    /// # Errors
    /// As [`Sim::run`].
    pub fn run_coroutine(&mut self, name: &str, coroutine: Box<dyn Coroutine>) -> Result<(), Error> {
        let id = self.core.spawn(name, Body::Coroutine(coroutine), false);
        let ended = self.core.run(None, id);
        let ending = self.core.ending(id);
        self.core.cancel(id);
        self.core.forget(id);
        self.keep_waves(ended.is_err() || matches!(ending, Some(Ending::Failed(_))))?;
        ended?;
        match ending {
            Some(Ending::Failed(failure)) => {
                Err(SimError::TaskFailed { task: name.to_owned(), time: self.core.now(), failure }.into())
            }
            Some(Ending::Cancelled) => Err(SimError::Cancelled { task: name.to_owned() }.into()),
            _ => Ok(()),
        }
    }

    /// Advances time by a span; clocks and tasks run meanwhile.
    ///
    /// # Errors
    /// As [`Sim::run`].
    pub fn run_for(&mut self, span: Time) -> Result<(), Error> {
        let dut = self.dut();
        self.run(async move {
            dut.timer(span).await;
            Ok::<(), Error>(())
        })
    }

    /// Ends all tasks.
    pub fn cancel_all(&mut self) {
        self.core.cancel_all();
    }

    /// Returns what every living task waits for.
    pub fn report(&self) -> StuckReport {
        self.core.report()
    }

    /// Returns the last 10 000 lines of the log.
    pub fn log(&self) -> Vec<Line> {
        self.core.log.borrow().lines()
    }

    /// Calls a function with every line of the log.
    pub fn set_log_listener(&self, listener: impl FnMut(&Line) + 'static) {
        self.core.log.borrow_mut().set_listener(Box::new(listener));
    }

    /// Drops lines of the log below a level; by default those of [`Level::Debug`].
    ///
    /// ```
    /// # use hoverlock_harness::{Error, build::Build, sim::{Level, Sim}};
    /// # let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/designs/dff.v");
    /// # let sim = Sim::new(Build::new("dff").source(source).compile()?.instance()?)?;
    /// sim.set_log_level(Level::Debug);
    /// sim.dut().log(Level::Debug, "driver", "16 words sent");
    /// assert_eq!(sim.log()[0].text, "16 words sent");
    /// # Ok::<(), Error>(())
    /// ```
    pub fn set_log_level(&self, level: Level) {
        self.core.log.borrow_mut().set_threshold(level);
    }

    /// Returns how often the model was evaluated.
    pub fn evaluations(&self) -> u64 {
        self.core.evaluations()
    }

    /// Ends all recordings of waves and completes their files.
    ///
    /// # Errors
    /// If a file cannot be written, such as on a full disk.
    pub fn stop_waves(&mut self) -> Result<(), Error> {
        self.core.waves.borrow_mut().stop_all(&mut self.core.model.borrow_mut())?;
        self.core.set_waves(false);
        Ok(())
    }

    /// Ends all tasks, runs the Verilog's `final` blocks and returns the messages.
    pub fn finish(self) -> Vec<Message> {
        self.core.cancel_all();
        let mut model = self.core.model.borrow_mut();
        model.finish();
        model.take_messages()
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        // Tasks refer to the core through their signals, and the core to the tasks: without this neither is freed.
        self.core.cancel_all();
        self.core.end();
        // The last run reported a file that cannot be written.
        let _ = self.core.waves.borrow_mut().flush(&mut self.core.model.borrow_mut());
    }
}

/// A flag that interrupts a run from another thread.
#[derive(Clone)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Ends the run with [`SimError::Interrupted`] within milliseconds.
    pub fn stop(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
