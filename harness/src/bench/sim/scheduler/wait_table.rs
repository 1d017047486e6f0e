//! The table of waits: one slot for each, reused, distinguished by a generation number.

use std::task::Waker;

use crate::bench::sim::task::TaskId;
use crate::bench::sim::trigger::{Edge, Outcome, Sync};
use crate::engine::time::Time;

/// A wait: valid while the generation is that of its slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct WaitId {
    pub index: u32,
    pub generation: u32,
}

/// The receiver of the end of a wait.
#[derive(Clone)]
pub(super) enum Target {
    Task(TaskId),
    /// A combinator's own waker.
    Waker(Box<Waker>),
    /// One of the parts of `First` or `Combine`.
    Parent(WaitId, u32),
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    Free,
    Armed,
    Fired,
}

/// What is waited for, as far as reports and cancelling need it.
#[expect(
    clippy::box_collection,
    reason = "combined waits are rare, and a wait is written at every edge: it stays small"
)]
pub(super) enum Waiting {
    Edge(u32, Edge, u64),
    Until(Time),
    Named(&'static str),
    Sync(Sync),
    Join(TaskId),
    First(Box<Vec<WaitId>>),
    Combine(Box<Vec<WaitId>>, u32),
}

pub(super) struct WaitSlot {
    pub generation: u32,
    pub state: State,
    pub target: Target,
    pub waiting: Waiting,
    /// `None` is the usual `Fired`.
    pub outcome: Option<Box<Outcome>>,
}

/// The slots of all waits.
#[derive(Default)]
pub(super) struct WaitTable {
    slots: Vec<WaitSlot>,
    free: Vec<u32>,
}

impl WaitTable {
    #[inline]
    pub fn add(&mut self, target: Target, waiting: Waiting) -> WaitId {
        if let Some(index) = self.free.pop() {
            let wait_id = &mut self.slots[index as usize];
            wait_id.state = State::Armed;
            wait_id.target = target;
            wait_id.waiting = waiting;
            return WaitId { index, generation: wait_id.generation };
        }
        let index = self.slots.len() as u32;
        self.slots.push(WaitSlot { generation: 0, state: State::Armed, target, waiting, outcome: None });
        WaitId { index, generation: 0 }
    }

    /// Returns the slot, unless another wait uses it now.
    #[inline]
    pub fn get(&self, wait_id: WaitId) -> Option<&WaitSlot> {
        self.slots.get(wait_id.index as usize).filter(|n| n.generation == wait_id.generation)
    }

    #[inline]
    pub fn get_mut(&mut self, wait_id: WaitId) -> Option<&mut WaitSlot> {
        self.slots.get_mut(wait_id.index as usize).filter(|n| n.generation == wait_id.generation)
    }

    #[inline]
    pub fn is_armed(&self, wait_id: WaitId) -> bool {
        self.get(wait_id).is_some_and(|n| n.state == State::Armed)
    }

    /// Returns `true` if the end of a wait reaches somebody: it is armed, and no `First` that it is a part of has ended
    /// by another part. A `Combine` looks at all of its parts.
    pub fn is_heard(&self, wait_id: WaitId) -> bool {
        let Some(slot) = self.get(wait_id) else { return false };
        if slot.state != State::Armed && !matches!(slot.waiting, Waiting::Combine(..)) {
            return false;
        }
        match slot.target {
            Target::Parent(parent, _) => self.is_heard(parent),
            Target::Task(_) | Target::Waker(_) => true,
        }
    }

    /// Frees a slot and returns its contents; ids that still name it have an old generation.
    #[inline]
    pub fn remove(&mut self, wait_id: WaitId) -> Option<(State, Waiting, Option<Box<Outcome>>)> {
        let slot = self.get_mut(wait_id)?;
        let state = std::mem::replace(&mut slot.state, State::Free);
        slot.generation = slot.generation.wrapping_add(1);
        let waiting = std::mem::replace(&mut slot.waiting, Waiting::Named(""));
        let outcome = slot.outcome.take();
        self.free.push(wait_id.index);
        Some((state, waiting, outcome))
    }

    pub fn iter(&self) -> impl Iterator<Item = &WaitSlot> {
        self.slots.iter()
    }
}
