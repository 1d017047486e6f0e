//! What a task can wait for, as plain values: made once, awaited any number of times, from any language.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use super::scheduler::WaitId;
use super::task::TaskId;
use crate::bench::failure::Failure;
use crate::engine::model::SignalId;
use crate::engine::time::Time;

/// A kind of change of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// From 0 to 1, of a one-bit signal.
    Rising,
    /// From 1 to 0, of a one-bit signal.
    Falling,
    /// Any change of value, of any signal (`Edge` and `ValueChange` of cocotb).
    Any,
    /// From 0 to 1, of one bit of a signal of at most 64 bits.
    RisingBit(u8),
    /// From 1 to 0, of one bit of a signal of at most 64 bits.
    FallingBit(u8),
    /// Any change of one bit of a signal of at most 64 bits.
    AnyBit(u8),
}

impl Edge {
    /// Returns `true` if a change from `old` to `new` is such an edge.
    #[inline(always)]
    pub(crate) fn is(self, old: u64, new: u64) -> bool {
        let (rising, falling) = self.bits();
        !old & new & rising | old & !new & falling != 0
    }

    /// Returns the bits whose rise counts and the bits whose fall counts.
    #[inline(always)]
    pub(crate) fn bits(self) -> (u64, u64) {
        match self {
            Edge::Rising => (1, 0),
            Edge::Falling => (0, 1),
            Edge::Any => (u64::MAX, u64::MAX),
            Edge::RisingBit(at) => (bit(at), 0),
            Edge::FallingBit(at) => (0, bit(at)),
            Edge::AnyBit(at) => (bit(at), bit(at)),
        }
    }
}

/// Returns a mask of one bit; 0 for a position above 63.
#[inline(always)]
fn bit(at: u8) -> u64 {
    1u64.checked_shl(u32::from(at)).unwrap_or(0)
}

/// Something a task can wait for.
#[derive(Clone)]
#[non_exhaustive]
pub enum Trigger {
    /// A change of a signal.
    Edge(SignalId, Edge),
    /// The n-th change of a signal from now; the task does not run at the ones before.
    Edges(SignalId, Edge, u64),
    /// A span of simulation time, more than 0.
    Timer(Time),
    /// The end of this time step: all values are settled and nothing may be written.
    ReadOnly,
    /// All values are settled, and may still be changed in this time step.
    ReadWrite,
    /// The beginning of the next time step, whenever that is.
    NextTimeStep,
    /// Lets the other ready tasks run first, in the same region.
    Yield,
    /// An event that is set, or a lock that becomes free for the task.
    Sync(Sync),
    /// The end of a task.
    Join(TaskId),
    /// `$finish` in the Verilog; while a task waits for it, it is no error.
    Finish,
    /// The first of several triggers; the other waits are cancelled.
    First(Rc<[Trigger]>),
    /// All of several.
    Combine(Rc<[Trigger]>),
}

impl Trigger {
    /// Returns a trigger that fires with the first of several.
    pub fn first(of: impl IntoIterator<Item = Trigger>) -> Trigger {
        Trigger::First(of.into_iter().collect())
    }

    /// Returns a trigger that fires when all of several have fired.
    pub fn combine(of: impl IntoIterator<Item = Trigger>) -> Trigger {
        Trigger::Combine(of.into_iter().collect())
    }

    pub(crate) fn name(&self) -> &'static str {
        match self {
            Trigger::Edge(_, Edge::Rising | Edge::RisingBit(_)) => "RisingEdge",
            Trigger::Edge(_, Edge::Falling | Edge::FallingBit(_)) => "FallingEdge",
            Trigger::Edge(_, Edge::Any | Edge::AnyBit(_)) => "ValueChange",
            Trigger::Edges(..) => "ClockCycles",
            Trigger::Timer(_) => "Timer",
            Trigger::ReadOnly => "ReadOnly",
            Trigger::ReadWrite => "ReadWrite",
            Trigger::NextTimeStep => "NextTimeStep",
            Trigger::Yield => "Yield",
            Trigger::Sync(sync) if sync.0.exclusive => "Lock",
            Trigger::Sync(_) => "Event",
            Trigger::Join(_) => "Join",
            Trigger::Finish => "Finish",
            Trigger::First(_) => "First",
            Trigger::Combine(_) => "Combine",
        }
    }
}

/// The end of a wait.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Outcome {
    /// The task begins; it has not waited yet.
    Start,
    /// The trigger fired.
    Fired,
    /// Of `First`: the index of the trigger that fired, and how its wait ended.
    First(usize, Box<Outcome>),
    /// The task waited for failed.
    Failed(Failure),
    /// The task waited for was cancelled.
    Cancelled,
    /// The wait was not allowed; the text says why.
    Refused(Failure),
}

/// An event or a lock: state that tasks wait for. Cheap to clone; clones are the same event.
#[derive(Clone)]
pub struct Sync(pub(crate) Rc<SyncState>);

pub(crate) struct SyncState {
    pub name: String,
    /// An event: it is set. A lock: a task has it.
    pub flag: Cell<bool>,
    pub exclusive: bool,
    pub waiters: RefCell<VecDeque<WaitId>>,
    /// The number of waiters whose wait was cancelled.
    pub stale: Cell<usize>,
}

impl Sync {
    pub(crate) fn new(name: &str, exclusive: bool) -> Sync {
        Sync(Rc::new(SyncState {
            name: name.to_owned(),
            flag: Cell::new(false),
            exclusive,
            waiters: RefCell::default(),
            stale: Cell::new(0),
        }))
    }
}
