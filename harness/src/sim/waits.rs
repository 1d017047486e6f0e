//! Waits: begun, over, given up; events and locks.

use std::cell::RefCell;
use std::cmp::Reverse;
use std::task::Context;

use super::Region;
use super::core::{Core, TimerEntry};
use super::node::{NodeRef, State, Target, Waiting};
use super::task::Ending;
use super::trigger::{Outcome, Sync, Trigger};
use crate::error::SimError;
use crate::time::Time;

impl Core {
    #[inline]
    pub(super) fn new_node(&self, target: Target, waiting: Waiting) -> NodeRef {
        self.nodes.borrow_mut().add(target, waiting)
    }

    #[inline]
    pub(super) fn is_armed(&self, node: NodeRef) -> bool {
        self.nodes.borrow().is_armed(node)
    }

    /// Begins a wait for the running task, woken by its own waker or by a combinator's.
    #[inline]
    pub fn arm_for_future(&self, trigger: &Trigger, context: &Context<'_>) -> Result<NodeRef, SimError> {
        let own = self.current.get().filter(|_| self.current_waker.get() == context.waker().data());
        let target = own.map_or_else(|| Target::Waker(Box::new(context.waker().clone())), Target::Task);
        self.arm(trigger, target)
    }

    #[inline]
    pub(super) fn arm(&self, trigger: &Trigger, target: Target) -> Result<NodeRef, SimError> {
        match trigger {
            Trigger::Edge(signal, edge) => self.arm_edge(*signal, *edge, 1, target),
            Trigger::Edges(signal, edge, count) => self.arm_edge(*signal, *edge, *count, target),
            _ => self.arm_other(trigger, target),
        }
    }

    #[inline(never)]
    pub(super) fn arm_other(&self, trigger: &Trigger, target: Target) -> Result<NodeRef, SimError> {
        let wrong = |reason| SimError::WrongRegion {
            trigger: trigger.name(),
            region: self.region.get().name(),
            time: self.now(),
            reason,
        };
        Ok(match trigger {
            Trigger::Edge(..) | Trigger::Edges(..) => return self.arm(trigger, target),
            Trigger::Timer(span) => {
                if *span == Time::ZERO {
                    return Err(SimError::BadTime(
                        "a Timer of 0: use ReadWrite, ReadOnly or NextTimeStep to order things within a step".into(),
                    ));
                }
                let at = self.now() + *span;
                let node = self.new_node(target, Waiting::Until(at));
                let order = self.timer_order.get();
                self.timer_order.set(order + 1);
                self.timers.borrow_mut().push(Reverse(TimerEntry { at, order, node: (node.index, node.generation) }));
                node
            }
            Trigger::ReadOnly => {
                if self.region.get() == Region::ReadOnly {
                    return Err(wrong("the task is in ReadOnly already; await something of a later time first"));
                }
                self.listed_node(target, "ReadOnly", &self.read_only)
            }
            Trigger::ReadWrite => {
                if self.region.get() == Region::ReadOnly {
                    return Err(wrong("this time step takes no writes any more; await NextTimeStep first"));
                }
                self.listed_node(target, "ReadWrite", &self.read_write)
            }
            Trigger::NextTimeStep => self.listed_node(target, "NextTimeStep", &self.next_step),
            Trigger::Finish => self.listed_node(target, "$finish", &self.finish_waiters),
            Trigger::Yield => {
                let node = self.new_node(target, Waiting::Named("Yield"));
                self.fire(node, None);
                node
            }
            Trigger::Sync(sync) => {
                let node = self.new_node(target, Waiting::Sync(sync.clone()));
                let free = sync.0.flag.get() != sync.0.exclusive;
                if free {
                    sync.0.flag.set(true);
                    self.fire(node, None);
                } else {
                    sync.0.waiters.borrow_mut().push(node);
                }
                node
            }
            Trigger::Join(id) => {
                let node = self.new_node(target, Waiting::Join(*id));
                let ended = {
                    let mut tasks = self.tasks.borrow_mut();
                    match tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) {
                        None => Some(Ending::Done),
                        Some(task) => {
                            if task.ending.is_none() {
                                task.joiners.push(node);
                            }
                            task.ending.clone()
                        }
                    }
                };
                if let Some(ending) = ended {
                    self.fire(node, joined(ending));
                }
                node
            }
            Trigger::First(parts) | Trigger::Combine(parts) => {
                if parts.is_empty() {
                    return Err(SimError::BadTime(format!("{} of nothing", trigger.name())));
                }
                let first = matches!(trigger, Trigger::First(_));
                let node = self.new_node(target, Waiting::Named(""));
                // A part may fire while it is armed, so the count is known before.
                self.set_waiting(
                    node,
                    if first {
                        Waiting::First(Box::default())
                    } else {
                        Waiting::Combine(Box::default(), parts.len() as u32)
                    },
                );
                for (index, part) in parts.iter().enumerate() {
                    match self.arm(part, Target::Parent(node, index as u32)) {
                        Ok(child) => self.add_part(node, child),
                        Err(error) => {
                            self.disarm(node);
                            return Err(error);
                        }
                    }
                    if first && !self.is_armed(node) {
                        break;
                    }
                }
                node
            }
        })
    }

    pub(super) fn listed_node(&self, target: Target, name: &'static str, list: &RefCell<Vec<NodeRef>>) -> NodeRef {
        let node = self.new_node(target, Waiting::Named(name));
        list.borrow_mut().push(node);
        node
    }

    pub(super) fn set_waiting(&self, node: NodeRef, waiting: Waiting) {
        if let Some(slot) = self.nodes.borrow_mut().get_mut(node) {
            slot.waiting = waiting;
        }
    }

    pub(super) fn add_part(&self, node: NodeRef, child: NodeRef) {
        if let Some(slot) = self.nodes.borrow_mut().get_mut(node)
            && let Waiting::First(parts) | Waiting::Combine(parts, _) = &mut slot.waiting
        {
            parts.push(child);
        }
    }

    /// If the wait is over, how it ended; the node is free then.
    #[inline]
    pub fn take_outcome(&self, node: NodeRef) -> Option<Outcome> {
        let (_, waiting, outcome) = {
            let mut nodes = self.nodes.borrow_mut();
            if nodes.get(node)?.state != State::Fired {
                return None;
            }
            nodes.remove(node)?
        };
        match waiting {
            Waiting::First(parts) => Some(self.first_outcome(*parts, outcome)),
            Waiting::Combine(parts, _) => Some(self.combined_outcome(*parts)),
            _ => Some(outcome.map_or(Outcome::Fired, |o| *o)),
        }
    }

    #[cold]
    pub(super) fn first_outcome(&self, parts: Vec<NodeRef>, outcome: Option<Box<Outcome>>) -> Outcome {
        let index = match outcome.as_deref() {
            Some(Outcome::First(index, _)) => *index,
            _ => 0,
        };
        let inner = parts.get(index).and_then(|p| self.take_outcome(*p)).unwrap_or(Outcome::Fired);
        parts.into_iter().for_each(|p| self.disarm(p));
        match inner {
            Outcome::Failed(_) | Outcome::Cancelled | Outcome::Refused(_) => inner,
            _ => Outcome::First(index, Box::new(inner)),
        }
    }

    #[cold]
    pub(super) fn combined_outcome(&self, parts: Vec<NodeRef>) -> Outcome {
        let mut all = Outcome::Fired;
        for part in parts {
            match self.take_outcome(part) {
                Some(bad @ (Outcome::Failed(_) | Outcome::Cancelled)) if matches!(all, Outcome::Fired) => all = bad,
                Some(_) => {}
                None => self.disarm(part),
            }
        }
        all
    }

    /// Gives up a wait, with all its parts. A lock got but not taken goes to the next.
    pub fn disarm(&self, node: NodeRef) {
        let removed = self.nodes.borrow_mut().remove(node);
        let Some((state, waiting, _)) = removed else { return };
        match waiting {
            Waiting::First(parts) | Waiting::Combine(parts, _) => parts.into_iter().for_each(|p| self.disarm(p)),
            Waiting::Edge(signal, ..) if state == State::Armed => self.compact(signal),
            Waiting::Sync(sync) if state == State::Fired && sync.0.exclusive => self.release(&sync),
            _ => {}
        }
    }

    /// What a node waited for has happened: its task becomes ready.
    #[inline]
    pub(super) fn fire(&self, node: NodeRef, outcome: Option<Box<Outcome>>) {
        let target = {
            let mut nodes = self.nodes.borrow_mut();
            let Some(slot) = nodes.get_mut(node).filter(|n| n.state == State::Armed) else { return };
            slot.state = State::Fired;
            slot.outcome = outcome;
            match &slot.target {
                Target::Task(id) => Target::Task(*id),
                other => other.clone(),
            }
        };
        match target {
            Target::Task(id) => self.make_ready(id),
            Target::Waker(waker) => {
                waker.wake();
                self.collect_woken();
            }
            Target::Parent(parent, index) => self.part_fired(parent, index),
        }
    }

    #[cold]
    pub(super) fn part_fired(&self, parent: NodeRef, index: u32) {
        let over = {
            let mut nodes = self.nodes.borrow_mut();
            let Some(slot) = nodes.get_mut(parent) else { return };
            match &mut slot.waiting {
                Waiting::First(_) => Some(Some(Box::new(Outcome::First(index as usize, Box::new(Outcome::Fired))))),
                Waiting::Combine(_, remaining) => {
                    *remaining -= 1;
                    (*remaining == 0).then_some(None)
                }
                _ => None,
            }
        };
        if let Some(outcome) = over {
            self.fire(parent, outcome);
        }
    }

    pub(super) fn fire_list(&self, list: &RefCell<Vec<NodeRef>>) {
        let waiting = std::mem::take(&mut *list.borrow_mut());
        waiting.into_iter().for_each(|node| self.fire(node, None));
    }

    pub fn set_event(&self, event: &Sync) {
        event.0.flag.set(true);
        let waiters = std::mem::take(&mut *event.0.waiters.borrow_mut());
        waiters.into_iter().for_each(|node| self.fire(node, None));
    }

    /// Gives a lock to the task that has waited longest, or to nobody.
    pub fn release(&self, lock: &Sync) {
        loop {
            let next = {
                let mut waiters = lock.0.waiters.borrow_mut();
                if waiters.is_empty() { None } else { Some(waiters.remove(0)) }
            };
            match next {
                None => return lock.0.flag.set(false),
                Some(node) if self.is_armed(node) => return self.fire(node, None),
                Some(_) => {}
            }
        }
    }
}

pub(super) fn joined(ending: Ending) -> Option<Box<Outcome>> {
    match ending {
        Ending::Done => None,
        Ending::Failed(failure) => Some(Box::new(Outcome::Failed(failure))),
        Ending::Cancelled => Some(Box::new(Outcome::Cancelled)),
    }
}
