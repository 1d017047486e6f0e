//! The handle that benches and tasks use: signals by name, triggers, tasks, clocks, waves.

use std::cell::RefCell;
use std::future::Future;
use std::rc::Rc;

use super::Region;
use super::clock::Clock;
use super::forcing::Forcing;
use super::future::{Either, First, Wait, race};
use super::log::Level;
use super::scheduler::{Agent, Body, Core};
use super::signal::{Memory, Real, Signal, Text, Wide};
use super::sync::{Event, Lock, Queue};
use super::task::{Coroutine, Ending, TaskHandle, TaskId};
use super::trigger::{Edge, Trigger};
use crate::bench::error::{Error, SimError};
use crate::bench::failure::Failure;
use crate::engine::error::ModelError;
use crate::engine::model::{SignalId, SignalInfo};
use crate::engine::time::Time;
use crate::engine::wave::{Recording, RecordingId};

/// The handle through which benches and tasks reach the simulation; cheap to clone.
#[derive(Clone)]
pub struct Dut {
    pub(super) core: Rc<Core>,
}

/// A function that is called at an edge.
struct Callback<F>(F);

impl<E: Into<Error>, F: FnMut() -> Result<(), E>> Agent for Callback<F> {
    fn edge(&mut self, _: &Core) -> Result<(), Error> {
        (self.0)().map_err(Into::into)
    }
}

impl Dut {
    pub(crate) fn core(&self) -> &Rc<Core> {
        &self.core
    }

    /// Returns `true` if there is a port or public internal of this name.
    pub fn has_signal(&self, name: &str) -> bool {
        self.core.model.borrow().find_if_any(name).is_some()
    }

    /// Returns a signal of at most 64 bits.
    ///
    /// # Errors
    /// If there is no such signal, or it is a memory or wider than 64 bits.
    pub fn signal(&self, name: &str) -> Result<Signal, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Signal::new(&self.core, id)
    }

    /// Returns a signal of any width.
    ///
    /// # Errors
    /// If there is no such signal, or it is a memory.
    pub fn wide(&self, name: &str) -> Result<Wide, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Wide::new(&self.core, id)
    }

    /// Returns the force of an internal signal made forceable by
    /// [`Build::forceable`](crate::engine::build::Build::forceable).
    ///
    /// # Errors
    /// If there is no such signal, or it was not made forceable.
    pub fn forcing(&self, name: &str) -> Result<Forcing, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Forcing::new(&self.core, id)
    }

    /// Returns a memory made public by [`Build::internal`](crate::engine::build::Build::internal), or a port that is an
    /// array.
    ///
    /// # Errors
    /// If there is no such memory, or it is a plain signal.
    pub fn memory(&self, name: &str) -> Result<Memory, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Memory::new(&self.core, id)
    }

    /// Returns a `real`: a port, or an internal one made public.
    ///
    /// # Errors
    /// If there is no such signal, or it is no `real`.
    pub fn real(&self, name: &str) -> Result<Real, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Real::new(&self.core, id)
    }

    /// Returns a `string` made public by [`Build::internal`](crate::engine::build::Build::internal).
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn text(&self, name: &str) -> Result<Text, ModelError> {
        Text::new(&self.core, name)
    }

    /// Returns the names of all public variables of type `string`.
    pub fn texts(&self) -> Vec<String> {
        self.core.model.borrow().texts().iter().map(|(name, _)| name.clone()).collect()
    }

    /// Returns all ports and public internals, except those of type `string`.
    pub fn signals(&self) -> Vec<SignalInfo> {
        self.core.model.borrow().signals().to_vec()
    }

    /// Returns the id of a port or public internal.
    ///
    /// # Errors
    /// If there is no such signal.
    pub fn find(&self, name: &str) -> Result<SignalId, ModelError> {
        self.core.model.borrow().find(name)
    }

    /// Writes a bit of a register or memory at once, as [`Model::set_bit`]: at a falling edge of the clock, nothing has
    /// sampled the old value since the rising edge.
    ///
    /// # Errors
    /// As [`Model::set_bit`].
    ///
    /// [`Model::set_bit`]: crate::engine::model::Model::set_bit
    pub fn set_bit(&self, register: SignalId, word: usize, bit: u32, value: bool) -> Result<(), ModelError> {
        self.core.model.borrow_mut().set_bit(register, word, bit, value)
    }

    /// Returns a bit of a register or memory, as [`Model::bit`](crate::engine::model::Model::bit).
    ///
    /// # Errors
    /// As [`Model::bit`](crate::engine::model::Model::bit).
    pub fn bit(&self, register: SignalId, word: usize, bit: u32) -> Result<bool, ModelError> {
        self.core.model.borrow().bit(register, word, bit)
    }

    /// Returns `true` if a signal is one of this simulation.
    pub fn has(&self, signal: SignalId) -> bool {
        self.core.has(signal)
    }

    /// Returns `true` if both are handles of one simulation.
    pub fn is_same(&self, other: &Dut) -> bool {
        Rc::ptr_eq(&self.core, &other.core)
    }

    /// Returns the top module's name.
    pub fn top(&self) -> String {
        self.core.model.borrow().library().top().to_owned()
    }

    /// Returns the simulation time.
    pub fn now(&self) -> Time {
        self.core.now()
    }

    /// Returns where in the time step the simulation is.
    pub fn region(&self) -> Region {
        self.core.region()
    }

    /// Waits for a span of simulation time.
    pub fn timer(&self, span: Time) -> Wait {
        Wait::new(&self.core, Trigger::Timer(span))
    }

    /// Waits until no value changes any more in this time step; nothing may be written then.
    pub fn read_only(&self) -> Wait {
        Wait::new(&self.core, Trigger::ReadOnly)
    }

    /// Waits until all values of this time step are settled; writes are still allowed.
    pub fn read_write(&self) -> Wait {
        Wait::new(&self.core, Trigger::ReadWrite)
    }

    /// Waits for the beginning of the next time step.
    pub fn next_time_step(&self) -> Wait {
        Wait::new(&self.core, Trigger::NextTimeStep)
    }

    /// Lets the other ready tasks run first.
    pub fn yield_now(&self) -> Wait {
        Wait::new(&self.core, Trigger::Yield)
    }

    /// Waits for `$finish` in the Verilog. While a task waits for it, it is no error.
    pub fn verilog_finish(&self) -> Wait {
        Wait::new(&self.core, Trigger::Finish)
    }

    /// Calls a function at every `edge` of a signal, before the evaluation: it reads values as they were before the
    /// edge, and its writes are buffered as those of a task. It runs before the tasks that wait for the same edge. An
    /// error ends the run.
    ///
    /// This is the way to watch many signals in each cycle, and to write a bus model: it needs no task, and is cheaper
    /// than one that awaits each edge.
    ///
    /// ```
    /// use std::{cell::RefCell, rc::Rc};
    /// # use hoverlock_harness::{Error, Time, build::Build, sim::{Edge, Sim}};
    /// # let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/designs/counter.v");
    /// # let library = Build::new("counter").source(source).parameter("WIDTH", 8).compile()?;
    /// # let mut sim = Sim::new(library.instance()?)?;
    /// let dut = sim.dut();
    /// dut.clock("clk", Time::ns(10))?;
    /// let (clk, count) = (dut.signal("clk")?, dut.signal("count")?);
    /// let seen = Rc::new(RefCell::new(Vec::new()));
    /// let (samples, enable) = (seen.clone(), dut.signal("enable")?);
    /// dut.signal("step")?.set(1)?;
    /// dut.on_edge(&clk, Edge::Rising, move || {
    ///     samples.borrow_mut().push(count.get());
    ///     enable.set(u64::from(count.get() < 3))
    /// });
    /// sim.run(async {
    ///     clk.cycles(6).await;
    ///     Ok::<(), Error>(())
    /// })?;
    /// assert_eq!(*seen.borrow(), [0, 0, 1, 2, 3, 4]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn on_edge<E: Into<Error>>(&self, signal: &Signal, edge: Edge, call: impl FnMut() -> Result<(), E> + 'static) {
        self.core.add_agent(Box::new(Callback(call)), signal.id(), edge);
    }

    /// Returns any trigger as a future.
    pub fn wait(&self, trigger: Trigger) -> Wait {
        Wait::new(&self.core, trigger)
    }

    /// Waits for the first of several triggers and returns its index; the other waits are cancelled.
    pub fn first(&self, of: impl IntoIterator<Item = Wait>) -> First {
        First(Wait::new(&self.core, Trigger::first(of.into_iter().map(|w| w.trigger()))))
    }

    /// Waits for all of several triggers.
    pub fn combine(&self, of: impl IntoIterator<Item = Wait>) -> Wait {
        Wait::new(&self.core, Trigger::combine(of.into_iter().map(|w| w.trigger())))
    }

    /// Awaits a future for at most a span of simulation time.
    ///
    /// # Errors
    /// [`SimError::Timeout`] if the span is over first.
    pub async fn with_timeout<F: Future>(&self, limit: Time, future: F) -> Result<F::Output, SimError> {
        match race(future, self.timer(limit)).await {
            Either::Left(value) => Ok(value),
            Either::Right(()) => Err(SimError::Timeout { limit, time: self.now() }),
        }
    }

    /// Starts a task (`start_soon`). It begins to run after the tasks that are ready already. If it fails and no task
    /// waits for it, the run fails.
    pub fn spawn<T: 'static, E: Into<Failure>>(
        &self,
        name: &str,
        task: impl Future<Output = Result<T, E>> + 'static,
    ) -> TaskHandle<T> {
        let value = Rc::new(RefCell::new(None));
        let slot = value.clone();
        let body = Box::pin(async move {
            let result = task.await.map_err(Into::into)?;
            *slot.borrow_mut() = Some(result);
            Ok(())
        });
        let id = self.core.spawn(name, Body::Future(body), false);
        TaskHandle { core: self.core.clone(), id, value }
    }

    /// Starts a task and lets it run to its first wait before the caller continues.
    pub async fn start<T: 'static, E: Into<Failure>>(
        &self,
        name: &str,
        task: impl Future<Output = Result<T, E>> + 'static,
    ) -> TaskHandle<T> {
        let handle = self.spawn(name, task);
        self.yield_now().await;
        handle
    }

    /// Starts a coroutine of another language.
    pub fn spawn_coroutine(&self, name: &str, coroutine: Box<dyn Coroutine>) -> TaskId {
        self.core.spawn(name, Body::Coroutine(coroutine), false)
    }

    /// Gives up a task's id: the task keeps running, and its slot is reused once it has ended.
    pub fn detach(&self, task: TaskId) {
        self.core.detach(task);
    }

    /// Returns how a task ended: `None` while it runs, `Done` for a task that was detached.
    pub fn ending(&self, task: TaskId) -> Option<Ending> {
        self.core.ending(task)
    }

    /// Ends a task.
    pub fn cancel(&self, task: TaskId) {
        self.core.cancel(task);
    }

    /// Frees the slot of an ended task, for callers that keep its ending themselves.
    pub fn forget(&self, task: TaskId) {
        self.core.forget(task);
    }

    /// Returns the task that is running.
    pub fn current_task(&self) -> Option<TaskId> {
        self.core.current_task()
    }

    /// Returns the name of a task.
    pub fn task_name(&self, task: TaskId) -> String {
        self.core.task_name(task)
    }

    /// Creates an event that is not set.
    pub fn event(&self, name: &str) -> Event {
        Event::new(&self.core, name)
    }

    /// Returns `true` if an event was created by this simulation.
    pub fn has_event(&self, event: &Event) -> bool {
        Rc::ptr_eq(&self.core, event.core())
    }

    /// Creates a free lock.
    pub fn lock(&self, name: &str) -> Lock {
        Lock::new(&self.core, name)
    }

    /// Returns `true` if a lock was created by this simulation.
    pub fn has_lock(&self, lock: &Lock) -> bool {
        Rc::ptr_eq(&self.core, lock.core())
    }

    /// Creates an empty queue of at most `limit` items.
    pub fn queue<T>(&self, name: &str, limit: usize) -> Queue<T> {
        Queue::new(&self.core, name, limit)
    }

    /// Starts a clock on an input, high for half of the period. Its first rising edge is now.
    ///
    /// # Errors
    /// If there is no such signal, it cannot be written, or the period is below 2 fs.
    pub fn clock(&self, name: &str, period: Time) -> Result<Clock, Error> {
        let half = Time::fs(period.as_fs() / 2);
        self.clock_with(name, half, period - half, Time::ZERO)
    }

    /// Starts a clock that is `high` and `low` for those spans; `phase` is the time from now to its first rising edge.
    ///
    /// # Errors
    /// If there is no such signal, it cannot be written, or one of the spans is 0.
    pub fn clock_with(&self, name: &str, high: Time, low: Time, phase: Time) -> Result<Clock, Error> {
        if high == Time::ZERO || low == Time::ZERO {
            return Err(SimError::BadTime(format!("clock '{name}': each half must last 1 fs at least")).into());
        }
        let signal = self.signal(name)?;
        let clock = Clock { signal, high, low };
        clock.start(phase)?;
        Ok(clock)
    }

    /// Starts a recording of waves.
    ///
    /// # Errors
    /// If a signal is not there, the model was built without the waves asked for, or the file cannot be written.
    pub fn start_waves(&self, recording: &Recording) -> Result<RecordingId, Error> {
        let id = self.core.waves.borrow_mut().start(&mut self.core.model.borrow_mut(), recording)?;
        self.core.set_waves(true);
        Ok(id)
    }

    /// Ends a recording and completes its file. Recordings that are not stopped end with the simulation.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn stop_waves(&self, id: RecordingId) -> Result<(), Error> {
        let mut waves = self.core.waves.borrow_mut();
        waves.stop(&mut self.core.model.borrow_mut(), id)?;
        self.core.set_waves(!waves.is_empty());
        Ok(())
    }

    /// Writes the coverage counted so far, in Verilator's format; see [`coverage`](crate::engine::coverage).
    ///
    /// # Errors
    /// If the model was built without coverage, or the file cannot be written.
    pub fn write_coverage(&self, path: impl AsRef<std::path::Path>) -> Result<(), Error> {
        Ok(self.core.model.borrow_mut().write_coverage(path.as_ref())?)
    }

    /// Adds a line to the log.
    pub fn log(&self, level: Level, source: &str, text: &str) {
        self.core.log.borrow_mut().put(self.now(), level, source, text);
    }

    /// Handles the messages of the Verilog after a bulk transfer.
    pub(crate) fn handle_messages(&self) -> Result<(), Error> {
        let messages = self.core.model.borrow_mut().take_messages();
        self.core.handle_messages(messages)
    }
}
