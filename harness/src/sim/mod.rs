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

mod clock;
mod dut;
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
pub use self::future::{Either, First, Wait, both, race};
pub use self::log::{Level, Line};
pub(crate) use self::scheduler::{Agent, Core, WallClock};
pub use self::scheduler::{StuckReport, TaskReport};
pub use self::signal::{Memory, Signal, Wide, expect_equal};
pub use self::simulation::{Sim, StopFlag};
pub use self::sync::{Event, Lock, LockGuard, Queue};
pub use self::task::{Coroutine, Ending, Join, Step, TaskHandle, TaskId};
pub use self::trigger::{Edge, Failure, Outcome, Sync, Trigger};
use crate::time::Time;

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
