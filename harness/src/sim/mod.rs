//! The simulation: tasks, triggers, clocks and time around one model.
//!
//! # A time step
//!
//! 1. **Active.** Clocks that are due put their level, timers that are due wake their tasks, and these run.
//! 2. Buffered writes are put. Tasks that wait for an edge of a **driven input wake before the evaluation**: they see
//!    registers as they were before the edge, and what they write comes after it.
//! 3. The model is evaluated; whoever waits for a change of an output or an internal runs.
//! 4. Again from 2 while there are writes.
//! 5. **ReadWrite.** Everything is settled; tasks that wait for it run and may write, then again from 2.
//! 6. **ReadOnly.** Everything is settled for good; a write is an error.
//! 7. Waves are written, and time goes on to the next clock edge or timer.
//!
//! The order is the same in every run: tasks run in the order in which they became ready, which is the order in which
//! they began to wait. Two writes of a round to one signal: the last counts. A value written is read back only after it
//! was put. [`EdgeOrder::AfterEval`] turns 2 and 3 round for benches written for simulators that do so.
//!
//! A write after a [`Timer`](Dut::timer) in the very step of a clock edge is put together with that edge, so that the
//! registers sample the new value, as in other simulators; the harness warns of it once for each signal.

mod core;
mod edges;
mod future;
mod log;
mod node;
mod report;
mod signal;
mod step;
mod sync;
mod task;
mod tasks;
mod trigger;
mod waits;
mod watch;

use std::cell::RefCell;
use std::future::Future;
use std::marker::PhantomData;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

pub(crate) use self::core::{Agent, Core};
pub use self::future::{Either, First, Wait, both, race};
pub use self::log::{Level, Line};
pub use self::report::{StuckReport, TaskReport};
pub use self::signal::{Memory, Signal, Wide, expect_equal};
pub use self::sync::{Event, Lock, LockGuard, Queue};
use self::task::Body;
pub use self::task::{Coroutine, Ending, Step, TaskId};
pub use self::trigger::{Edge, Failure, Outcome, Sync, Trigger};
use crate::error::{Error, ModelError, SimError};
use crate::model::{Message, Model, SignalInfo};
use crate::time::Time;
use crate::wave::{Recording, RecordingId};

/// Where in a time step the simulation is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Region {
    /// Tasks run and write.
    Active,
    /// Values are settled and may still be changed.
    ReadWrite,
    /// Values are settled for good.
    ReadOnly,
}

impl Region {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Region::Active => "Active",
            Region::ReadWrite => "ReadWrite",
            Region::ReadOnly => "ReadOnly",
        }
    }
}

/// When tasks that wait for an edge of a driven input wake.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EdgeOrder {
    /// Before the evaluation: registers show what they held before the edge.
    #[default]
    BeforeEval,
    /// After it: registers show what they hold since the edge.
    AfterEval,
}

/// When a run is given up.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Simulation time.
    pub time: Option<Time>,
    /// Time on the wall.
    pub wall_clock: Option<Duration>,
    /// Rounds of writes and evaluations within one time step.
    pub rounds: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { time: None, wall_clock: None, rounds: 10_000 }
    }
}

/// A simulation: one model and its tasks. Stays on its thread; dropped, it ends all tasks.
pub struct Sim {
    core: Rc<Core>,
}

/// The handle through which tasks reach the simulation; cheap to clone.
#[derive(Clone)]
pub struct Dut {
    core: Rc<Core>,
}

impl Sim {
    /// A simulation of a fresh model, at time 0, settled.
    pub fn new(model: Model) -> Result<Sim, Error> {
        Ok(Sim { core: Core::new(model)? })
    }

    /// The handle for tasks.
    pub fn dut(&self) -> Dut {
        Dut { core: self.core.clone() }
    }

    /// Sets when runs are given up.
    pub fn set_limits(&self, limits: Limits) {
        *self.core.limits.borrow_mut() = limits;
    }

    /// Sets when tasks wake that wait for an edge of an input.
    pub fn set_edge_order(&self, order: EdgeOrder) {
        self.core.edge_order.set(order);
    }

    /// Sets a question asked every few milliseconds: `true` interrupts the run.
    pub fn set_interrupt(&self, asked: impl FnMut() -> bool + 'static) {
        *self.core.interrupt.borrow_mut() = Some(Box::new(asked));
    }

    /// A flag that interrupts the run from another thread or a signal handler.
    pub fn stop_flag(&self) -> StopFlag {
        StopFlag(self.core.stop_flag.clone())
    }

    /// Runs a bench to its end, and its last time step to the end of that. Tasks it started live on and continue in the
    /// next run. The error is that of the bench, of a task nobody waited for, of the Verilog or of the simulation.
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
            // What the bench says comes first: an error of its last time step would hide it.
            Some(Err(error)) => Err(error.into()),
            Some(Ok(value)) => ended.map(|()| value),
            None => ended.and(Err(Error::bench("the bench was cancelled"))),
        };
        self.keep_waves(result.is_err())?;
        result
    }

    /// Brings the waves into their files, and those of a failure too.
    fn keep_waves(&self, failed: bool) -> Result<(), Error> {
        let mut waves = self.core.waves.borrow_mut();
        let mut model = self.core.model.borrow_mut();
        if failed {
            // A model that stopped in the middle has this step's values too.
            waves.sample(&mut model, self.core.now())?;
            waves.failed(&mut model)
        } else {
            waves.flush(&mut model)
        }
    }

    /// Runs a coroutine of another language as the bench.
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

    /// Lets time go on for a span, with whatever clocks and tasks run.
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

    /// What every living task waits for.
    pub fn report(&self) -> StuckReport {
        self.core.report()
    }

    /// The log so far (its last ten thousand lines).
    pub fn log(&self) -> Vec<Line> {
        self.core.log.borrow().lines()
    }

    /// Hands every line of the log to a listener as it comes.
    pub fn set_log_listener(&self, listener: impl FnMut(&Line) + 'static) {
        self.core.log.borrow_mut().set_listener(Box::new(listener));
    }

    /// Lines below this level are not kept.
    pub fn set_log_level(&self, level: Level) {
        self.core.log.borrow_mut().set_threshold(level);
    }

    /// How often the model was evaluated.
    pub fn evaluations(&self) -> u64 {
        self.core.evaluations()
    }

    /// Gives the model back, after its `final` blocks have run; what these print is in its messages.
    pub fn finish(self) -> Vec<Message> {
        self.core.cancel_all();
        let mut model = self.core.model.borrow_mut();
        model.finish();
        model.take_messages()
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        // Tasks hold the core through their signals: without this neither would ever be freed.
        self.core.cancel_all();
        // A file that cannot be written any more was told of by the last run.
        let _ = self.core.waves.borrow_mut().flush(&mut self.core.model.borrow_mut());
    }
}

/// Interrupts a run from outside.
#[derive(Clone)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// The run ends with [`SimError::Interrupted`] within milliseconds.
    pub fn stop(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Dut {
    pub(crate) fn core(&self) -> &Rc<Core> {
        &self.core
    }

    /// A signal of at most 64 bits.
    pub fn signal(&self, name: &str) -> Result<Signal, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Signal::new(&self.core, id)
    }

    /// A signal of any width.
    pub fn wide(&self, name: &str) -> Result<Wide, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Wide::new(&self.core, id)
    }

    /// A memory made public by [`Build::internal`](crate::build::Build::internal), or a port that is an array.
    pub fn memory(&self, name: &str) -> Result<Memory, ModelError> {
        let id = self.core.model.borrow().find(name)?;
        Memory::new(&self.core, id)
    }

    /// All ports and public internals.
    pub fn signals(&self) -> Vec<SignalInfo> {
        self.core.model.borrow().signals().to_vec()
    }

    /// The top module's name.
    pub fn top(&self) -> String {
        self.core.model.borrow().library().top().to_owned()
    }

    /// Simulation time.
    pub fn now(&self) -> Time {
        self.core.now()
    }

    /// Where in the time step the simulation is.
    pub fn region(&self) -> Region {
        self.core.region()
    }

    /// A span of simulation time.
    pub fn timer(&self, span: Time) -> Wait {
        Wait::new(&self.core, Trigger::Timer(span))
    }

    /// The end of this time step's changes; nothing may be written then.
    pub fn read_only(&self) -> Wait {
        Wait::new(&self.core, Trigger::ReadOnly)
    }

    /// All values settled, writes still allowed.
    pub fn read_write(&self) -> Wait {
        Wait::new(&self.core, Trigger::ReadWrite)
    }

    /// The beginning of the next time step.
    pub fn next_time_step(&self) -> Wait {
        Wait::new(&self.core, Trigger::NextTimeStep)
    }

    /// The other ready tasks first.
    pub fn yield_now(&self) -> Wait {
        Wait::new(&self.core, Trigger::Yield)
    }

    /// `$finish` in the Verilog, which is no error while a task waits for it.
    pub fn verilog_finish(&self) -> Wait {
        Wait::new(&self.core, Trigger::Finish)
    }

    /// Any trigger as a future.
    pub fn wait(&self, trigger: Trigger) -> Wait {
        Wait::new(&self.core, trigger)
    }

    /// The first of several triggers, by its place in the list; the others are given up.
    pub fn first(&self, of: impl IntoIterator<Item = Wait>) -> First {
        First(Wait::new(&self.core, Trigger::first(of.into_iter().map(|w| w.trigger()))))
    }

    /// All of several triggers.
    pub fn combine(&self, of: impl IntoIterator<Item = Wait>) -> Wait {
        Wait::new(&self.core, Trigger::combine(of.into_iter().map(|w| w.trigger())))
    }

    /// A future that must end within a span of simulation time.
    pub async fn with_timeout<F: Future>(&self, limit: Time, future: F) -> Result<F::Output, SimError> {
        match race(future, self.timer(limit)).await {
            Either::Left(value) => Ok(value),
            Either::Right(()) => Err(SimError::Timeout { limit, time: self.now() }),
        }
    }

    /// Starts a task; it begins to run when those ready before it have (`start_soon`). If it fails and nobody waits for
    /// it, the run fails.
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

    /// Starts a task and lets it run to its first wait before this one goes on.
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

    /// Gives up a task's id: the task runs on, and its place is used again once it has ended.
    pub fn detach(&self, task: TaskId) {
        self.core.detach(task);
    }

    /// How a task ended, if it has; of one that was detached, `Done`.
    pub fn ending(&self, task: TaskId) -> Option<Ending> {
        self.core.ending(task)
    }

    /// Ends a task.
    pub fn cancel(&self, task: TaskId) {
        self.core.cancel(task);
    }

    /// Forgets how an ended task ended, for those who keep that themselves: its place serves another.
    pub fn forget(&self, task: TaskId) {
        self.core.forget(task);
    }

    /// The task that runs at the moment.
    pub fn current_task(&self) -> Option<TaskId> {
        self.core.current_task()
    }

    /// A task's name.
    pub fn task_name(&self, task: TaskId) -> String {
        self.core.task_name(task)
    }

    /// An event, not set.
    pub fn event(&self, name: &str) -> Event {
        Event::new(&self.core, name)
    }

    /// A lock, free.
    pub fn lock(&self, name: &str) -> Lock {
        Lock::new(&self.core, name)
    }

    /// A queue of at most `limit` items.
    pub fn queue<T>(&self, name: &str, limit: usize) -> Queue<T> {
        Queue::new(&self.core, name, limit)
    }

    /// A clock on an input, half of the period high; it runs from now on, beginning with its rising edge.
    pub fn clock(&self, name: &str, period: Time) -> Result<Clock, Error> {
        let half = Time::fs(period.as_fs() / 2);
        self.clock_with(name, half, period - half, Time::ZERO)
    }

    /// A clock with its spans of high and low and the time from now to its first rising edge.
    pub fn clock_with(&self, name: &str, high: Time, low: Time, phase: Time) -> Result<Clock, Error> {
        if high == Time::ZERO || low == Time::ZERO {
            return Err(SimError::BadTime(format!("clock '{name}': each half must last 1 fs at least")).into());
        }
        let signal = self.signal(name)?;
        let clock = Clock { signal, high, low };
        clock.start(phase)?;
        Ok(clock)
    }

    /// Begins to record waves.
    pub fn start_waves(&self, recording: &Recording) -> Result<RecordingId, Error> {
        let id = self.core.waves.borrow_mut().start(&mut self.core.model.borrow_mut(), recording)?;
        self.core.set_waves(true);
        Ok(id)
    }

    /// Ends a recording; its file is whole then. Recordings that are not stopped end with the simulation.
    pub fn stop_waves(&self, id: RecordingId) -> Result<(), Error> {
        let mut waves = self.core.waves.borrow_mut();
        waves.stop(&mut self.core.model.borrow_mut(), id)?;
        self.core.set_waves(!waves.is_empty());
        Ok(())
    }

    /// Writes the coverage counted so far, in Verilator's form; see [`coverage`](crate::coverage).
    pub fn write_coverage(&self, path: impl AsRef<std::path::Path>) -> Result<(), Error> {
        self.core.model.borrow_mut().write_coverage(path.as_ref())
    }

    /// Puts a line into the log.
    pub fn log(&self, level: Level, source: &str, text: &str) {
        self.core.log.borrow_mut().put(self.now(), level, source, text);
    }

    /// Keeps what the Verilog said at the end of a bulk path.
    pub(crate) fn handle_messages(&self) -> Result<(), Error> {
        let messages = self.core.model.borrow_mut().take_messages();
        self.core.handle_messages(messages)
    }
}

/// A clock of the harness: no task, no cost but its evaluations.
#[derive(Clone)]
pub struct Clock {
    signal: Signal,
    high: Time,
    low: Time,
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
    pub fn start(&self, phase: Time) -> Result<(), Error> {
        let core = &self.signal.core;
        self.stop();
        let level = phase == Time::ZERO;
        self.signal.set(u64::from(level))?;
        let next = core.now() + if level { self.high } else { phase };
        let signal = self.signal.id().index() as u32;
        let mut clocks = core.clocks.borrow_mut();
        clocks.retain(|c| c.signal != signal);
        clocks.push(self::core::ClockState {
            signal,
            high: self.high,
            low: self.low,
            next,
            level: !level,
            running: true,
        });
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

/// A started task. Awaited, it gives the task's value; dropped, the task runs on.
pub struct TaskHandle<T> {
    core: Rc<Core>,
    id: TaskId,
    value: Rc<RefCell<Option<T>>>,
}

impl<T> TaskHandle<T> {
    /// The task's place in the simulation.
    pub fn id(&self) -> TaskId {
        self.id
    }

    /// Whether it has ended.
    pub fn is_done(&self) -> bool {
        self.core.ending(self.id).is_some()
    }

    /// Ends it.
    pub fn cancel(&self) {
        self.core.cancel(self.id);
    }

    /// Its end as a trigger, without its value.
    pub fn ended(&self) -> Wait {
        Wait::new(&self.core, Trigger::Join(self.id))
    }

    /// Waits for its end; gives its value, or why there is none.
    pub fn join(self) -> Join<T> {
        let wait = self.ended();
        Join { wait, handle: self, _value: PhantomData }
    }
}

impl<T> Drop for TaskHandle<T> {
    fn drop(&mut self) {
        self.core.detach(self.id);
    }
}

impl<T> IntoFuture for TaskHandle<T> {
    type Output = Result<T, SimError>;
    type IntoFuture = Join<T>;

    fn into_future(self) -> Join<T> {
        self.join()
    }
}

/// Waits for the end of a task.
pub struct Join<T> {
    wait: Wait,
    handle: TaskHandle<T>,
    _value: PhantomData<T>,
}

impl<T> Future for Join<T> {
    type Output = Result<T, SimError>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        // SAFETY: no field is pinned structurally: `Wait` and `TaskHandle` may be moved.
        let this = unsafe { self.get_unchecked_mut() };
        let task = || this.handle.core.task_name(this.handle.id);
        match this.wait.poll_outcome(context) {
            Poll::Pending => Poll::Pending,
            Poll::Ready(Outcome::Failed(failure) | Outcome::Refused(failure)) => {
                Poll::Ready(Err(SimError::TaskFailed { task: task(), time: this.handle.core.now(), failure }))
            }
            Poll::Ready(_) => match this.handle.value.borrow_mut().take() {
                Some(value) => Poll::Ready(Ok(value)),
                None => Poll::Ready(Err(SimError::Cancelled { task: task() })),
            },
        }
    }
}
