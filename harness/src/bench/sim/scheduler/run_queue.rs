//! Starts, runs and ends tasks and bus models.

use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, PoisonError};
use std::task::{Context, Poll, Waker};

use super::task_state::{Body, EdgeWait, Task, TaskWait, TaskWaker};
use super::wait_table::{Target, WaitId};
use super::waiting::joined;
use super::{Agent, Core, Ready};
use crate::bench::error::{Error, SimError};
use crate::bench::failure::Failure;
use crate::bench::sim::task::{Coroutine, Ending, Step, TaskId};
use crate::bench::sim::trigger::{Edge, Outcome, Trigger};
use crate::engine::model::SignalId;

/// The reason why a coroutine runs.
#[derive(Clone, Copy)]
enum Woken {
    First,
    ByEdge,
    By(WaitId),
}

/// The future that `run` drives, if it drives one.
pub(crate) type MainTask<'a> = Option<Pin<&'a mut dyn Future<Output = ()>>>;

impl Core {
    pub fn spawn(&self, name: &str, body: Body, at_once: bool) -> TaskId {
        let mut tasks = self.tasks.borrow_mut();
        let reused = self.free_tasks.borrow_mut().pop();
        let index = reused.unwrap_or(tasks.len() as u32);
        let generation = reused.map_or(0, |i| tasks[i as usize].generation.wrapping_add(1));
        let id = TaskId { index, generation };
        let waker = Waker::from(Arc::new(TaskWaker { id, woken: self.woken.clone() }));
        let name = if name.is_empty() { format!("task {index}") } else { name.to_owned() };
        let task = Task {
            generation,
            name,
            body: Some(body),
            wait: TaskWait::Nothing,
            edge: EdgeWait::new(0, Edge::Any, 0),
            waits: reused.map_or(0, |i| tasks[i as usize].waits.wrapping_add(1)),
            joiners: Vec::new(),
            ending: None,
            queued: true,
            detached: false,
            cancel_requested: false,
            refused: None,
            waker,
        };
        if reused.is_some() {
            tasks[index as usize] = task;
        } else {
            tasks.push(task);
        }
        let mut ready = self.ready.borrow_mut();
        if at_once {
            ready.push_front(Ready::Task(id));
        } else {
            ready.push_back(Ready::Task(id));
        }
        id
    }

    /// Returns how a task ended, or `None` while it runs; `Done` for a task whose slot was freed.
    pub fn ending(&self, id: TaskId) -> Option<Ending> {
        let tasks = self.tasks.borrow();
        match tasks.get(id.index as usize).filter(|t| t.generation == id.generation) {
            Some(task) => task.ending.clone(),
            None => Some(Ending::Done),
        }
    }

    pub fn task_name(&self, id: TaskId) -> String {
        let tasks = self.tasks.borrow();
        tasks
            .get(id.index as usize)
            .filter(|t| t.generation == id.generation)
            .map_or_else(|| "a finished task".into(), |t| t.name.clone())
    }

    pub fn current_task(&self) -> Option<TaskId> {
        self.current.get()
    }

    /// Makes the running task fail as soon as it returns.
    pub fn refuse_current(&self, failure: Failure) {
        if let Some(id) = self.current.get()
            && let Some(task) = self.tasks.borrow_mut().get_mut(id.index as usize)
        {
            task.refused = Some(failure);
        }
    }

    /// Ends a task: it is not resumed again. A task that cancels itself runs to its next wait.
    pub fn cancel(&self, id: TaskId) {
        let body = {
            let mut tasks = self.tasks.borrow_mut();
            let Some(task) = tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) else { return };
            if task.ending.is_some() {
                return;
            }
            match task.body.take() {
                Some(body) => body,
                None => {
                    task.cancel_requested = true;
                    return;
                }
            }
        };
        self.end_task(id, Ending::Cancelled);
        // Dropped only now: destructors may use the core.
        if let Body::Coroutine(mut coroutine) = body {
            coroutine.cancel();
        }
    }

    pub(super) fn end_task(&self, id: TaskId, ending: Ending) {
        let (joiners, wait, signal, name, detached) = {
            let mut tasks = self.tasks.borrow_mut();
            let task = &mut tasks[id.index as usize];
            task.ending = Some(ending.clone());
            let (joiners, wait) = (std::mem::take(&mut task.joiners), std::mem::take(&mut task.wait));
            (joiners, wait, task.edge.signal, task.name.clone(), task.detached)
        };
        match wait {
            TaskWait::Other(wait_id) => self.disarm(wait_id),
            TaskWait::Edge => self.compact(signal),
            TaskWait::Nothing | TaskWait::Fired => {}
        }
        if self.main.get() == Some(id) {
            self.main_ended.set(true);
            self.disturb();
        }
        let mut heard = false;
        for wait_id in joiners {
            heard |= self.wait_table.borrow().is_heard(wait_id);
            self.fire(wait_id, joined(ending.clone()));
        }
        if let Ending::Failed(failure) = ending
            && !heard
        {
            let error = SimError::TaskFailed { task: name, time: self.now(), failure };
            self.fail(error.into());
        }
        if detached {
            self.forget(id);
        }
    }

    /// Frees the task's slot as soon as it has ended.
    pub fn detach(&self, id: TaskId) {
        {
            let mut tasks = self.tasks.borrow_mut();
            let Some(task) = tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) else { return };
            task.detached = true;
        }
        self.forget(id);
    }

    /// Frees the slot of an ended task.
    pub fn forget(&self, id: TaskId) {
        let mut tasks = self.tasks.borrow_mut();
        if let Some(task) = tasks.get_mut(id.index as usize)
            && task.generation == id.generation
            && task.ending.is_some()
        {
            task.generation = task.generation.wrapping_add(1);
            task.name = String::new();
            self.free_tasks.borrow_mut().push(id.index);
        }
    }

    /// Cancels all tasks and removes all bus models.
    pub fn cancel_all(&self) {
        let running: Vec<TaskId> = {
            let tasks = self.tasks.borrow();
            let alive = tasks.iter().enumerate().filter(|(_, t)| t.ending.is_none());
            alive.map(|(i, t)| TaskId { index: i as u32, generation: t.generation }).collect()
        };
        running.into_iter().for_each(|id| self.cancel(id));
        self.agents.borrow_mut().clear();
    }

    pub fn add_agent(&self, agent: Box<dyn Agent>, clock: SignalId, edge: Edge) -> u32 {
        let mut agents = self.agents.borrow_mut();
        let index = agents.len() as u32;
        agents.push(Some(agent));
        let signal = clock.index() as u32;
        let state = &self.signals[signal as usize];
        if state.observed && !state.listed.get() {
            self.observe(signal);
        }
        state.agents.borrow_mut().push((index, edge));
        index
    }

    #[inline]
    pub(super) fn make_ready(&self, id: TaskId) {
        let mut tasks = self.tasks.borrow_mut();
        if let Some(task) = tasks.get_mut(id.index as usize)
            && task.generation == id.generation
            && task.ending.is_none()
            && !task.queued
        {
            task.queued = true;
            self.ready.borrow_mut().push_back(Ready::Task(id));
        }
    }

    pub(super) fn collect_woken(&self) {
        let woken = std::mem::take(&mut *self.woken.lock().unwrap_or_else(PoisonError::into_inner));
        woken.into_iter().for_each(|id| self.make_ready(id));
    }

    /// Runs what is ready, in the order in which it became ready.
    #[inline(always)]
    pub(super) fn run_ready(&self, main: &mut MainTask<'_>) -> Result<(), Error> {
        if self.ready.borrow().is_empty() { Ok(()) } else { self.run_queue(main) }
    }

    fn run_queue(&self, main: &mut MainTask<'_>) -> Result<(), Error> {
        loop {
            let next = self.ready.borrow_mut().pop_front();
            match next {
                None => return Ok(()),
                Some(Ready::Task(id)) => self.run_task(id, main),
                Some(Ready::Agent(index)) => self.run_agent(index),
            }
            self.check_failed()?;
        }
    }

    /// Returns the error by which a task or a bus model ends the run, if there is one.
    #[inline(always)]
    pub(super) fn check_failed(&self) -> Result<(), Error> {
        if self.failed.get() { self.take_error() } else { Ok(()) }
    }

    #[cold]
    fn take_error(&self) -> Result<(), Error> {
        self.failed.set(false);
        self.error.borrow_mut().take().map_or(Ok(()), Err)
    }

    /// Ends the run with this error, unless there is an earlier one.
    #[cold]
    pub(super) fn fail(&self, error: Error) {
        self.failed.set(true);
        self.error.borrow_mut().get_or_insert(error);
    }

    pub(super) fn run_agent(&self, index: u32) {
        let agent = self.agents.borrow_mut().get_mut(index as usize).and_then(Option::take);
        if let Some(mut agent) = agent {
            if let Err(error) = agent.edge(self) {
                self.fail(error);
            }
            if let Some(slot) = self.agents.borrow_mut().get_mut(index as usize) {
                *slot = Some(agent);
            }
        }
    }

    fn run_task(&self, id: TaskId, main: &mut MainTask<'_>) {
        let (body, woken) = {
            let mut tasks = self.tasks.borrow_mut();
            let Some(task) = tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) else { return };
            task.queued = false;
            let woken = match task.wait {
                // A trigger that it no longer waits for may have made it ready.
                TaskWait::Edge => return,
                TaskWait::Other(wait_id) if self.is_armed(wait_id) => return,
                TaskWait::Other(wait_id) => Woken::By(wait_id),
                TaskWait::Fired => Woken::ByEdge,
                TaskWait::Nothing => Woken::First,
            };
            let Some(body) = task.body.take() else { return };
            task.wait = TaskWait::Nothing;
            (body, woken)
        };
        match body {
            Body::Coroutine(coroutine) => {
                let outcome = match woken {
                    Woken::First => Outcome::Start,
                    Woken::ByEdge => Outcome::Fired,
                    Woken::By(wait_id) => self.take_outcome(wait_id).unwrap_or(Outcome::Fired),
                };
                self.run_coroutine(id, coroutine, outcome);
            }
            Body::Future(mut future) => {
                let ending = match self.with_waker(id, |context| future.as_mut().poll(context)) {
                    Poll::Pending => None,
                    Poll::Ready(Ok(())) => Some(Ending::Done),
                    Poll::Ready(Err(failure)) => Some(Ending::Failed(failure)),
                };
                self.put_back(id, Body::Future(future), ending);
            }
            Body::Main => {
                let polled = main.as_mut().map(|main| self.with_waker(id, |context| main.as_mut().poll(context)));
                let ending = matches!(polled, Some(Poll::Ready(()))).then_some(Ending::Done);
                self.put_back(id, Body::Main, ending);
            }
        }
    }

    /// Runs a coroutine, taken out of its task, to its next wait.
    #[inline(always)]
    pub(super) fn run_coroutine(&self, id: TaskId, mut coroutine: Box<dyn Coroutine>, outcome: Outcome) {
        let outer = (self.current.replace(Some(id)), self.current_waker.replace(std::ptr::null()));
        let ending = self.resume(id, &mut *coroutine, outcome);
        self.current.set(outer.0);
        self.current_waker.set(outer.1);
        self.put_back(id, Body::Coroutine(coroutine), ending);
    }

    /// Polls a task's future with the task's own waker.
    #[inline]
    fn with_waker<T>(&self, id: TaskId, poll: impl FnOnce(&mut Context<'_>) -> T) -> T {
        // SAFETY: the copy is never dropped; the original stays in the task's slot, which no other task gets before
        // this one has ended.
        let waker =
            std::mem::ManuallyDrop::new(unsafe { std::ptr::read(&self.tasks.borrow()[id.index as usize].waker) });
        let outer = (self.current.replace(Some(id)), self.current_waker.replace(waker.data()));
        let polled = poll(&mut Context::from_waker(&waker));
        self.current.set(outer.0);
        self.current_waker.set(outer.1);
        polled
    }

    /// Keeps a task that waits, or ends it.
    #[inline(always)]
    fn put_back(&self, id: TaskId, body: Body, ending: Option<Ending>) {
        {
            let mut tasks = self.tasks.borrow_mut();
            let task = &mut tasks[id.index as usize];
            if ending.is_none() && task.refused.is_none() && !task.cancel_requested {
                task.body = Some(body);
                return;
            }
        }
        self.end_run_task(id, body, ending);
    }

    /// Ends a task that has run: by its own ending, by what it was refused, or by a cancelling.
    #[inline(never)]
    fn end_run_task(&self, id: TaskId, body: Body, ending: Option<Ending>) {
        let ending = {
            let mut tasks = self.tasks.borrow_mut();
            let task = &mut tasks[id.index as usize];
            let refused = task.refused.take().map(Ending::Failed);
            task.cancel_requested = false;
            ending.or(refused).unwrap_or(Ending::Cancelled)
        };
        let is_cancelled = matches!(ending, Ending::Cancelled);
        self.end_task(id, ending);
        if let (Body::Coroutine(mut coroutine), true) = (body, is_cancelled) {
            coroutine.cancel();
        }
        // A waker of `FuturesUnordered` may have been called inside the poll.
        self.collect_woken();
    }

    #[inline(always)]
    fn resume(&self, id: TaskId, coroutine: &mut dyn Coroutine, mut outcome: Outcome) -> Option<Ending> {
        loop {
            let armed = match coroutine.resume(outcome) {
                Step::Again => self.arm_task_again(id),
                Step::Wait(Trigger::Edge(signal, edge)) => self.arm_task(id, signal, edge, 1),
                Step::Wait(Trigger::Edges(signal, edge, count)) => self.arm_task(id, signal, edge, count),
                Step::Wait(trigger) => self.arm(&trigger, Target::Task(id)).map(|wait_id| {
                    self.tasks.borrow_mut()[id.index as usize].wait = TaskWait::Other(wait_id);
                }),
                Step::Done => return Some(Ending::Done),
                Step::Failed(failure) => return Some(Ending::Failed(failure)),
            };
            match armed {
                Ok(()) => return None,
                Err(error) => outcome = Outcome::Refused(error.into()),
            }
        }
    }
}
