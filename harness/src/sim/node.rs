//! Waits: one slot for each, used again and again, told apart by generation.

use std::task::Waker;

use super::task::TaskId;
use super::trigger::{Edge, Outcome, Sync};
use crate::time::Time;

/// A wait: valid as long as the generations agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NodeRef {
    pub index: u32,
    pub generation: u32,
}

/// Whom it wakes.
#[derive(Clone)]
pub(super) enum Target {
    Task(TaskId),
    /// A combinator's own waker.
    Waker(Box<Waker>),
    /// One of the parts of `First` or `Combine`.
    Parent(NodeRef, u32),
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    Free,
    Armed,
    Fired,
}

/// What is waited for, as far as reports and giving up need it.
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
    First(Box<Vec<NodeRef>>),
    Combine(Box<Vec<NodeRef>>, u32),
}

pub(super) struct Node {
    pub generation: u32,
    pub state: State,
    pub target: Target,
    pub waiting: Waiting,
    /// `None` is the usual `Fired`.
    pub outcome: Option<Box<Outcome>>,
}

/// All waits.
#[derive(Default)]
pub(super) struct Nodes {
    slots: Vec<Node>,
    free: Vec<u32>,
}

impl Nodes {
    #[inline]
    pub fn add(&mut self, target: Target, waiting: Waiting) -> NodeRef {
        if let Some(index) = self.free.pop() {
            let node = &mut self.slots[index as usize];
            node.state = State::Armed;
            node.target = target;
            node.waiting = waiting;
            return NodeRef { index, generation: node.generation };
        }
        let index = self.slots.len() as u32;
        self.slots.push(Node { generation: 0, state: State::Armed, target, waiting, outcome: None });
        NodeRef { index, generation: 0 }
    }

    /// The slot, unless it was used for another wait since.
    #[inline]
    pub fn get(&self, node: NodeRef) -> Option<&Node> {
        self.slots.get(node.index as usize).filter(|n| n.generation == node.generation)
    }

    #[inline]
    pub fn get_mut(&mut self, node: NodeRef) -> Option<&mut Node> {
        self.slots.get_mut(node.index as usize).filter(|n| n.generation == node.generation)
    }

    #[inline]
    pub fn is_armed(&self, node: NodeRef) -> bool {
        self.get(node).is_some_and(|n| n.state == State::Armed)
    }

    /// Frees a slot; what still lists it finds another generation. Gives what it was.
    #[inline]
    pub fn remove(&mut self, node: NodeRef) -> Option<(State, Waiting, Option<Box<Outcome>>)> {
        let slot = self.get_mut(node)?;
        let state = std::mem::replace(&mut slot.state, State::Free);
        slot.generation = slot.generation.wrapping_add(1);
        let waiting = std::mem::replace(&mut slot.waiting, Waiting::Named(""));
        let outcome = slot.outcome.take();
        self.free.push(node.index);
        Some((state, waiting, outcome))
    }

    pub fn iter(&self) -> impl Iterator<Item = &Node> {
        self.slots.iter()
    }
}
