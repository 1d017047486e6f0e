//! Begins, ends and cancels waits; sets events, releases locks.

use std::cell::RefCell;
use std::cmp::Reverse;
use std::task::Context;

use super::wait_table::{State, Target, WaitId, Waiting};
use super::{Core, TimerEntry};
use crate::bench::error::SimError;
use crate::bench::sim::Region;
use crate::bench::sim::task::{Ending, TaskId};
use crate::bench::sim::trigger::{Outcome, Sync, Trigger};
use crate::engine::time::Time;

impl Core {
    #[inline]
    pub(super) fn new_wait(&self, target: Target, waiting: Waiting) -> WaitId {
        self.wait_table.borrow_mut().add(target, waiting)
    }

    #[inline]
    pub(super) fn is_armed(&self, wait_id: WaitId) -> bool {
        self.wait_table.borrow().is_armed(wait_id)
    }

    /// Begins a wait of the running task. It is woken directly, or by the waker of a combinator it uses.
    #[inline]
    pub fn arm_for_future(&self, trigger: &Trigger, context: &Context<'_>) -> Result<WaitId, SimError> {
        let own = self.current.get().filter(|_| self.current_waker.get() == context.waker().data());
        let target = own.map_or_else(|| Target::Waker(Box::new(context.waker().clone())), Target::Task);
        self.arm(trigger, target)
    }

    #[inline]
    pub(super) fn arm(&self, trigger: &Trigger, target: Target) -> Result<WaitId, SimError> {
        match trigger {
            Trigger::Edge(signal, edge) => self.arm_edge(*signal, *edge, 1, target),
            Trigger::Edges(signal, edge, count) => self.arm_edge(*signal, *edge, *count, target),
            _ => self.arm_other(trigger, target),
        }
    }

    #[inline(never)]
    pub(super) fn arm_other(&self, trigger: &Trigger, target: Target) -> Result<WaitId, SimError> {
        self.disturb();
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
                let wait_id = self.new_wait(target, Waiting::Until(at));
                let order = self.timer_order.get();
                self.timer_order.set(order + 1);
                self.timers.borrow_mut().push(Reverse(TimerEntry {
                    at,
                    order,
                    wait_id: (wait_id.index, wait_id.generation),
                }));
                wait_id
            }
            Trigger::ReadOnly => {
                if self.region.get() == Region::ReadOnly {
                    return Err(wrong("the task is in ReadOnly already; await something of a later time first"));
                }
                self.listed_wait(target, "ReadOnly", &self.read_only)
            }
            Trigger::ReadWrite => {
                if self.region.get() == Region::ReadOnly {
                    return Err(wrong("this time step takes no writes any more; await NextTimeStep first"));
                }
                self.listed_wait(target, "ReadWrite", &self.read_write)
            }
            Trigger::NextTimeStep => self.listed_wait(target, "NextTimeStep", &self.next_step),
            Trigger::Finish => self.listed_wait(target, "$finish", &self.finish_waiters),
            Trigger::Yield => {
                let wait_id = self.new_wait(target, Waiting::Named("Yield"));
                self.fire(wait_id, None);
                wait_id
            }
            Trigger::Sync(sync) => {
                let wait_id = self.new_wait(target, Waiting::Sync(sync.clone()));
                let free = sync.0.flag.get() != sync.0.exclusive;
                if free {
                    sync.0.flag.set(true);
                    self.fire(wait_id, None);
                } else {
                    sync.0.waiters.borrow_mut().push_back(wait_id);
                }
                wait_id
            }
            Trigger::Join(id) => self.arm_join(*id, target),
            Trigger::First(parts) => self.arm_parts(trigger.name(), parts, Waiting::First(Box::default()), target)?,
            Trigger::Combine(parts) => {
                let waiting = Waiting::Combine(Box::default(), parts.len() as u32);
                self.arm_parts(trigger.name(), parts, waiting, target)?
            }
        })
    }

    fn arm_join(&self, id: TaskId, target: Target) -> WaitId {
        let wait_id = self.new_wait(target, Waiting::Join(id));
        let ended = {
            let mut tasks = self.tasks.borrow_mut();
            match tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) {
                None => Some(Ending::Done),
                Some(task) => {
                    if task.ending.is_none() {
                        task.joiners.push(wait_id);
                    }
                    task.ending.clone()
                }
            }
        };
        if let Some(ending) = ended {
            self.fire(wait_id, joined(ending));
        }
        wait_id
    }

    /// Begins the waits of `First` or `Combine`.
    fn arm_parts(
        &self,
        name: &'static str,
        parts: &[Trigger],
        waiting: Waiting,
        target: Target,
    ) -> Result<WaitId, SimError> {
        if parts.is_empty() {
            return Err(SimError::BadTime(format!("{name} of nothing")));
        }
        // A part may fire while it is armed: `Combine` knows the number of its parts before.
        let wait_id = self.new_wait(target, waiting);
        for (index, part) in parts.iter().enumerate() {
            match self.arm(part, Target::Parent(wait_id, index as u32)) {
                Ok(child) => self.add_part(wait_id, child),
                Err(error) => {
                    self.disarm(wait_id);
                    return Err(error);
                }
            }
            // Over already: `First` by a part that fired, `Combine` by one that failed.
            if !self.is_armed(wait_id) {
                break;
            }
        }
        Ok(wait_id)
    }

    pub(super) fn listed_wait(&self, target: Target, name: &'static str, list: &RefCell<Vec<WaitId>>) -> WaitId {
        let wait_id = self.new_wait(target, Waiting::Named(name));
        list.borrow_mut().push(wait_id);
        wait_id
    }

    pub(super) fn add_part(&self, wait_id: WaitId, child: WaitId) {
        if let Some(slot) = self.wait_table.borrow_mut().get_mut(wait_id)
            && let Waiting::First(parts) | Waiting::Combine(parts, _) = &mut slot.waiting
        {
            parts.push(child);
        }
    }

    /// Returns how a wait ended and frees its slot, or `None` if it is not over.
    #[inline]
    pub fn take_outcome(&self, wait_id: WaitId) -> Option<Outcome> {
        let (_, waiting, outcome) = {
            let mut wait_table = self.wait_table.borrow_mut();
            if wait_table.get(wait_id)?.state != State::Fired {
                return None;
            }
            wait_table.remove(wait_id)?
        };
        match waiting {
            Waiting::First(parts) => Some(self.first_outcome(*parts, outcome)),
            Waiting::Combine(parts, _) => Some(self.combined_outcome(*parts)),
            _ => Some(outcome.map_or(Outcome::Fired, |o| *o)),
        }
    }

    #[cold]
    pub(super) fn first_outcome(&self, parts: Vec<WaitId>, outcome: Option<Box<Outcome>>) -> Outcome {
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
    pub(super) fn combined_outcome(&self, parts: Vec<WaitId>) -> Outcome {
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

    /// Cancels a wait with all its parts. A lock that it got goes to the next task.
    pub fn disarm(&self, wait_id: WaitId) {
        let removed = self.wait_table.borrow_mut().remove(wait_id);
        let Some((state, waiting, _)) = removed else { return };
        match waiting {
            Waiting::First(parts) | Waiting::Combine(parts, _) => parts.into_iter().for_each(|p| self.disarm(p)),
            Waiting::Edge(signal, ..) if state == State::Armed => self.compact(signal),
            Waiting::Until(_) if state == State::Armed => self.abandon_timer(),
            Waiting::Named("$finish") if state == State::Armed => {
                self.finish_waiters.borrow_mut().retain(|w| *w != wait_id);
            }
            Waiting::Join(id) if state == State::Armed => self.abandon_join(id, wait_id),
            Waiting::Sync(sync) if state == State::Armed => self.abandon_sync(&sync),
            Waiting::Sync(sync) if sync.0.exclusive => self.release(&sync),
            _ => {}
        }
    }

    /// Drops the cancelled waits for an event or a lock once they are half of the list, so that the cost of a wait does
    /// not depend on how many were cancelled before.
    #[cold]
    fn abandon_sync(&self, sync: &Sync) {
        let stale = sync.0.stale.get() + 1;
        let mut waiters = sync.0.waiters.borrow_mut();
        if stale > 16 && stale * 2 > waiters.len() {
            waiters.retain(|w| self.is_armed(*w));
            sync.0.stale.set(0);
        } else {
            sync.0.stale.set(stale);
        }
    }

    /// Removes stale timers once they outnumber the others.
    #[cold]
    fn abandon_timer(&self) {
        let stale = self.stale_timers.get() + 1;
        let mut timers = self.timers.borrow_mut();
        if stale > 16 && stale * 2 > timers.len() {
            timers.retain(|Reverse(t)| self.is_armed(WaitId { index: t.wait_id.0, generation: t.wait_id.1 }));
            self.stale_timers.set(0);
        } else {
            self.stale_timers.set(stale);
        }
    }

    #[cold]
    fn abandon_join(&self, id: TaskId, wait_id: WaitId) {
        let mut tasks = self.tasks.borrow_mut();
        if let Some(task) = tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) {
            task.joiners.retain(|w| *w != wait_id);
        }
    }

    /// Ends a wait: its task becomes ready.
    #[inline]
    pub(super) fn fire(&self, wait_id: WaitId, outcome: Option<Box<Outcome>>) {
        let failed = matches!(outcome.as_deref(), Some(Outcome::Failed(_) | Outcome::Cancelled));
        self.fire_as(wait_id, outcome, failed);
    }

    /// Ends a wait with an outcome; `failed` says that a task that was waited for failed or was cancelled.
    #[inline]
    fn fire_as(&self, wait_id: WaitId, outcome: Option<Box<Outcome>>, failed: bool) {
        let target = {
            let mut wait_table = self.wait_table.borrow_mut();
            let Some(slot) = wait_table.get_mut(wait_id).filter(|n| n.state == State::Armed) else { return };
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
            Target::Parent(parent, index) => self.part_fired(parent, index, failed),
        }
    }

    /// Ends a `First` with any of its parts, and a `Combine` with its last part or with one that failed.
    #[cold]
    fn part_fired(&self, parent: WaitId, index: u32, failed: bool) {
        let over = {
            let mut wait_table = self.wait_table.borrow_mut();
            let Some(slot) = wait_table.get_mut(parent) else { return };
            match &mut slot.waiting {
                Waiting::First(_) => Some(Some(Box::new(Outcome::First(index as usize, Box::new(Outcome::Fired))))),
                Waiting::Combine(_, remaining) => {
                    *remaining -= 1;
                    (failed || *remaining == 0).then_some(None)
                }
                _ => None,
            }
        };
        if let Some(outcome) = over {
            self.fire_as(parent, outcome, failed);
        }
    }

    pub(super) fn fire_list(&self, list: &RefCell<Vec<WaitId>>) {
        let waiting = std::mem::take(&mut *list.borrow_mut());
        waiting.into_iter().for_each(|wait_id| self.fire(wait_id, None));
    }

    pub fn set_event(&self, event: &Sync) {
        event.0.flag.set(true);
        let waiters = std::mem::take(&mut *event.0.waiters.borrow_mut());
        event.0.stale.set(0);
        waiters.into_iter().for_each(|wait_id| self.fire(wait_id, None));
    }

    /// Gives a lock to the task that has waited longest, or sets it free.
    pub fn release(&self, lock: &Sync) {
        loop {
            let next = lock.0.waiters.borrow_mut().pop_front();
            match next {
                None => return lock.0.flag.set(false),
                Some(wait_id) if self.is_armed(wait_id) => return self.fire(wait_id, None),
                Some(_) => lock.0.stale.set(lock.0.stale.get().saturating_sub(1)),
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
