//! The simulation: tasks, triggers, clocks and time around one model.
//!
//! # A time step
//!
//! 1. **Active.** Clocks that are due change their level. Timers that are due wake their tasks, and these run.
//! 2. Buffered writes are put. Tasks that wait for an edge of a **driven input wake before the evaluation**: they read
//!    registers as they were before the edge, and the design sees their writes after it.
//! 3. The model is evaluated. Tasks that wait for a change of an output or an internal signal run.
//! 4. Steps 2 and 3 repeat while there are writes.
//! 5. **ReadWrite.** All values are settled. Tasks that wait for this region run and may write; if they do, step 2
//!    follows.
//! 6. **ReadOnly.** Values do not change any more in this time step; a write is an error.
//! 7. Waves are written. Time advances to the next clock edge or timer.
//!
//! The order is the same in every run: tasks run in the order in which they became ready, which is the order in which
//! they began to wait. Of several writes to one signal in a round, the last counts, bit by bit. A value written is read
//! back only after it was put. [`EdgeOrder::AfterEval`] wakes the tasks of step 2 after the evaluation, for benches
//! that were written for simulators that do so.
//!
//! A write after a [`Timer`](Dut::timer) that ends in the time step of a clock edge is put together with that edge: the
//! registers sample the new value, as in other simulators. The harness logs a warning once for each signal.

mod clock;
mod dut;
mod forcing;
mod future;
mod log;
mod scheduler;
mod signal;
mod simulation;
mod sync;
mod task;
mod trigger;

use std::time::Duration;

pub use self::clock::Clock;
pub use self::dut::Dut;
pub use self::forcing::Forcing;
pub use self::future::{Either, First, Wait, both, race};
pub use self::log::{Level, Line};
pub(crate) use self::scheduler::{Agent, Core, WallClock};
pub use self::signal::{Memory, Real, Signal, Text, Wide, expect_equal};
pub use self::simulation::{Sim, StopFlag};
pub use self::sync::{Event, Lock, LockGuard, Queue};
pub use self::task::{Coroutine, Ending, Join, Step, TaskHandle, TaskId};
pub use self::trigger::{Edge, Outcome, Sync, Trigger};
pub use super::failure::Failure;
pub use super::report::{StuckReport, TaskReport};
use crate::engine::time::Time;

/// A part of a time step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Region {
    /// Tasks run and write.
    Active,
    /// Values are settled and may still be changed.
    ReadWrite,
    /// Values are settled and do not change any more.
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

/// The moment at which tasks wake that wait for an edge of a driven input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EdgeOrder {
    /// Before the evaluation: registers show their values before the edge.
    #[default]
    BeforeEval,
    /// After the evaluation: registers show their values after the edge.
    AfterEval,
}

/// The limits of a run. A run that exceeds one ends with an error that says what each task waits for.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Simulation time.
    pub time: Option<Time>,
    /// Wall-clock time.
    pub wall_clock: Option<Duration>,
    /// Rounds of writes and evaluations within one time step.
    pub rounds: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { time: None, wall_clock: None, rounds: 10_000 }
    }
}
