//! The scheduler: one time step after the other, each with its regions. See the module documentation of `sim`.

use std::cell::{Cell, RefCell};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::future::Future;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use super::log::{Level, Log};
pub(crate) use super::node::NodeRef;
use super::node::{Node, Nodes, State, Target, Waiting};
use super::report::{StuckReport, TaskReport};
use super::task::{Body, Ending, Step, Task, TaskId, TaskWaker};
use super::trigger::{Edge, Failure, Outcome, Sync, Trigger};
use super::{EdgeOrder, Limits, Region};
use crate::error::{Error, ModelError, SimError};
use crate::model::{Direction, Message, Model, SignalId, Storage, load, load_words, store, store_words};
use crate::time::Time;
use crate::wave::Waves;

struct Watcher {
    node: NodeRef,
    edge: Edge,
    /// How many edges still to come, this one included.
    remaining: u64,
}

/// What runs next: a task, or a bus model at an edge.
#[derive(Clone, Copy)]
enum Ready {
    Task(TaskId),
    Agent(u32),
}

/// A bus model that works at the edges of a clock without being a task.
pub(crate) trait Agent {
    /// The edge has come; signals still show what they were before it.
    fn edge(&mut self, core: &Core) -> Result<(), Error>;
}

struct SignalState {
    data: *mut u8,
    storage: Storage,
    /// Whether the design may change it by itself.
    observed: bool,
    last: Cell<u64>,
    last_words: RefCell<Vec<u32>>,
    watchers: RefCell<Vec<Watcher>>,
    agents: RefCell<Vec<(u32, Edge)>>,
    listed: Cell<bool>,
    /// Place of the buffered write of this round, or `NONE`.
    pending: Cell<u32>,
}

const NONE: u32 = u32::MAX;

/// A buffered write of at most 64 bits.
#[derive(Clone, Copy)]
struct Write {
    signal: u32,
    value: u64,
}

/// A buffered write of another kind.
enum LargeWrite {
    Words(u32, Vec<u32>),
    /// An element of a memory, at a byte offset.
    Element(u32, usize, u64),
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct TimerEntry {
    at: Time,
    order: u64,
    node: (u32, u32),
}

pub(crate) struct ClockState {
    pub signal: u32,
    pub high: Time,
    pub low: Time,
    pub next: Time,
    pub level: bool,
    pub running: bool,
}

/// State of one simulation; used through `Rc` by everything that waits or writes.
pub(crate) struct Core {
    pub model: RefCell<Model>,
    signals: Vec<SignalState>,
    now: Cell<Time>,
    region: Cell<Region>,
    writes: RefCell<Vec<Write>>,
    applying: RefCell<Vec<Write>>,
    large_writes: RefCell<Vec<LargeWrite>>,
    observed: RefCell<Vec<u32>>,
    nodes: RefCell<Nodes>,
    tasks: RefCell<Vec<Task>>,
    free_tasks: RefCell<Vec<u32>>,
    ready: RefCell<VecDeque<Ready>>,
    agents: RefCell<Vec<Option<Box<dyn Agent>>>>,
    timers: RefCell<BinaryHeap<Reverse<TimerEntry>>>,
    timer_order: Cell<u64>,
    pub clocks: RefCell<Vec<ClockState>>,
    read_only: RefCell<Vec<NodeRef>>,
    read_write: RefCell<Vec<NodeRef>>,
    next_step: RefCell<Vec<NodeRef>>,
    finish_waiters: RefCell<Vec<NodeRef>>,
    current: Cell<Option<TaskId>>,
    /// The data of the running task's own waker, to know it again.
    current_waker: Cell<*const ()>,
    woken: Arc<Mutex<Vec<TaskId>>>,
    pub log: RefCell<Log>,
    pub limits: RefCell<Limits>,
    pub edge_order: Cell<EdgeOrder>,
    pub interrupt: RefCell<Option<Box<dyn FnMut() -> bool>>>,
    pub stop_flag: Arc<AtomicBool>,
    finished: Cell<Option<(Time, u32)>>,
    finish_file: RefCell<String>,
    error: RefCell<Option<Error>>,
    warned: RefCell<Vec<u32>>,
    pub waves: RefCell<Waves>,
    has_waves: Cell<bool>,
    evaluations: Cell<u64>,
    /// In the step at hand: how many clocks put a level, and whether a timer woke anybody.
    clock_writes: Cell<u32>,
    timed: Cell<bool>,
}

impl Core {
    pub fn new(model: Model) -> Result<Rc<Core>, Error> {
        let signals = model
            .signals()
            .iter()
            .map(|info| SignalState {
                data: info.data,
                storage: info.storage,
                observed: info.direction != Direction::Input,
                last: Cell::new(0),
                last_words: RefCell::default(),
                watchers: RefCell::default(),
                agents: RefCell::default(),
                listed: Cell::new(false),
                pending: Cell::new(NONE),
            })
            .collect();
        let core = Rc::new(Core {
            model: RefCell::new(model),
            signals,
            now: Cell::new(Time::ZERO),
            region: Cell::new(Region::Active),
            writes: RefCell::default(),
            applying: RefCell::default(),
            large_writes: RefCell::default(),
            observed: RefCell::default(),
            nodes: RefCell::default(),
            tasks: RefCell::default(),
            free_tasks: RefCell::default(),
            ready: RefCell::default(),
            agents: RefCell::default(),
            timers: RefCell::default(),
            timer_order: Cell::new(0),
            clocks: RefCell::default(),
            read_only: RefCell::default(),
            read_write: RefCell::default(),
            next_step: RefCell::default(),
            finish_waiters: RefCell::default(),
            current: Cell::new(None),
            current_waker: Cell::new(std::ptr::null()),
            woken: Arc::default(),
            log: RefCell::default(),
            limits: RefCell::default(),
            edge_order: Cell::new(EdgeOrder::default()),
            interrupt: RefCell::default(),
            stop_flag: Arc::default(),
            finished: Cell::new(None),
            finish_file: RefCell::default(),
            error: RefCell::default(),
            warned: RefCell::default(),
            waves: RefCell::default(),
            has_waves: Cell::new(false),
            evaluations: Cell::new(0),
            clock_writes: Cell::new(0),
            timed: Cell::new(false),
        });
        // `initial` blocks run and everything settles, so that the first read is of a value the design has.
        core.evaluate()?;
        Ok(core)
    }

    // ---- what tasks and bus models ask

    #[inline]
    pub fn now(&self) -> Time {
        self.now.get()
    }

    pub fn region(&self) -> Region {
        self.region.get()
    }

    pub fn evaluations(&self) -> u64 {
        self.evaluations.get()
    }

    pub fn signal_name(&self, signal: u32) -> String {
        self.model.borrow().signals()[signal as usize].name.clone()
    }

    /// Buffers a write of a value known to fit.
    #[inline]
    pub fn write(&self, signal: u32, value: u64) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        let state = &self.signals[signal as usize];
        let mut writes = self.writes.borrow_mut();
        let at = state.pending.get();
        if at != NONE {
            writes[at as usize].value = value;
        } else {
            state.pending.set(writes.len() as u32);
            writes.push(Write { signal, value });
        }
        Ok(())
    }

    pub fn write_words(&self, signal: u32, words: Vec<u32>) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        self.large_writes.borrow_mut().push(LargeWrite::Words(signal, words));
        Ok(())
    }

    /// The value a buffered write will put, if there is one.
    pub fn pending(&self, signal: u32) -> Option<u64> {
        let at = self.signals[signal as usize].pending.get();
        (at != NONE).then(|| self.writes.borrow()[at as usize].value)
    }

    /// The words a buffered write will put, if there is one.
    pub fn pending_words(&self, signal: u32) -> Option<Vec<u32>> {
        self.large_writes.borrow().iter().rev().find_map(|write| match write {
            LargeWrite::Words(of, words) if *of == signal => Some(words.clone()),
            _ => None,
        })
    }

    pub fn write_element(&self, signal: u32, offset: usize, value: u64) -> Result<(), ModelError> {
        if self.region.get() == Region::ReadOnly {
            return Err(self.write_in_read_only(signal));
        }
        self.large_writes.borrow_mut().push(LargeWrite::Element(signal, offset, value));
        Ok(())
    }

    #[cold]
    fn write_in_read_only(&self, signal: u32) -> ModelError {
        ModelError::WriteInReadOnly { signal: self.signal_name(signal), time: self.now() }
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

    // ---- waits

    #[inline]
    fn new_node(&self, target: Target, waiting: Waiting) -> NodeRef {
        self.nodes.borrow_mut().add(target, waiting)
    }

    #[inline]
    fn is_armed(&self, node: NodeRef) -> bool {
        self.nodes.borrow().is_armed(node)
    }

    /// Gives up a wait, with all its parts. A lock got but not taken goes to the next.
    pub fn disarm(&self, node: NodeRef) {
        let removed = self.nodes.borrow_mut().remove(node);
        let Some((state, waiting, _)) = removed else { return };
        match waiting {
            Waiting::First(parts) | Waiting::Combine(parts, _) => parts.into_iter().for_each(|p| self.disarm(p)),
            Waiting::Edge(signal, ..) if state == State::Armed => self.compact(&self.signals[signal as usize].watchers),
            Waiting::Sync(sync) if state == State::Fired && sync.0.exclusive => self.release(&sync),
            _ => {}
        }
    }

    /// Drops watchers that were given up, once they are many.
    fn compact(&self, watchers: &RefCell<Vec<Watcher>>) {
        if let Ok(mut list) = watchers.try_borrow_mut()
            && list.len() > 16
        {
            let before = list.len();
            let stale = list.iter().filter(|w| !self.is_armed(w.node)).count();
            if stale * 2 > before {
                list.retain(|w| self.is_armed(w.node));
            }
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
    fn first_outcome(&self, parts: Vec<NodeRef>, outcome: Option<Box<Outcome>>) -> Outcome {
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
    fn combined_outcome(&self, parts: Vec<NodeRef>) -> Outcome {
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

    /// Begins a wait for the running task, woken by its own waker or by a combinator's.
    #[inline]
    pub fn arm_for_future(&self, trigger: &Trigger, context: &Context<'_>) -> Result<NodeRef, SimError> {
        let own = self.current.get().filter(|_| self.current_waker.get() == context.waker().data());
        let target = own.map_or_else(|| Target::Waker(Box::new(context.waker().clone())), Target::Task);
        self.arm(trigger, target)
    }

    #[inline]
    fn arm(&self, trigger: &Trigger, target: Target) -> Result<NodeRef, SimError> {
        match trigger {
            Trigger::Edge(signal, edge) => self.arm_edge(signal.index() as u32, *edge, 1, target),
            Trigger::Edges(signal, edge, count) => self.arm_edge(signal.index() as u32, *edge, *count, target),
            _ => self.arm_other(trigger, target),
        }
    }

    #[inline]
    fn arm_edge(&self, signal: u32, edge: Edge, count: u64, target: Target) -> Result<NodeRef, SimError> {
        let state = &self.signals[signal as usize];
        if count == 0 {
            return Err(SimError::BadTime("ClockCycles of 0 cycles: nothing to wait for".into()));
        }
        if state.observed && !state.listed.get() {
            self.observe(signal);
        }
        let node = self.new_node(target, Waiting::Edge(signal, edge, count));
        state.watchers.borrow_mut().push(Watcher { node, edge, remaining: count });
        Ok(node)
    }

    #[cold]
    fn observe(&self, signal: u32) {
        let state = &self.signals[signal as usize];
        state.listed.set(true);
        self.remember(state);
        self.observed.borrow_mut().push(signal);
    }

    fn remember(&self, state: &SignalState) {
        // SAFETY: the model lives as long as the core.
        unsafe {
            state.last.set(load(state.data, state.storage));
            if let Storage::Wide(_) = state.storage {
                *state.last_words.borrow_mut() = load_words(state.data, state.storage);
            }
        }
    }

    #[inline(never)]
    fn arm_other(&self, trigger: &Trigger, target: Target) -> Result<NodeRef, SimError> {
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

    fn listed_node(&self, target: Target, name: &'static str, list: &RefCell<Vec<NodeRef>>) -> NodeRef {
        let node = self.new_node(target, Waiting::Named(name));
        list.borrow_mut().push(node);
        node
    }

    fn set_waiting(&self, node: NodeRef, waiting: Waiting) {
        if let Some(slot) = self.nodes.borrow_mut().get_mut(node) {
            slot.waiting = waiting;
        }
    }

    fn add_part(&self, node: NodeRef, child: NodeRef) {
        if let Some(slot) = self.nodes.borrow_mut().get_mut(node)
            && let Waiting::First(parts) | Waiting::Combine(parts, _) = &mut slot.waiting
        {
            parts.push(child);
        }
    }

    /// What a node waited for has happened: its task becomes ready.
    #[inline]
    fn fire(&self, node: NodeRef, outcome: Option<Box<Outcome>>) {
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
    fn part_fired(&self, parent: NodeRef, index: u32) {
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

    #[inline]
    fn make_ready(&self, id: TaskId) {
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

    fn collect_woken(&self) {
        let woken = std::mem::take(&mut *self.woken.lock().unwrap_or_else(PoisonError::into_inner));
        woken.into_iter().for_each(|id| self.make_ready(id));
    }

    // ---- events and locks

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

    // ---- tasks

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
            wait: None,
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

    /// The ending of a task, if it has ended; of one long forgotten, `Done`.
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

    /// Ends a task; it is not resumed again. A task that cancels itself runs to its next wait.
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

    fn end_task(&self, id: TaskId, ending: Ending) {
        let (joiners, wait, name, detached) = {
            let mut tasks = self.tasks.borrow_mut();
            let task = &mut tasks[id.index as usize];
            task.ending = Some(ending.clone());
            (std::mem::take(&mut task.joiners), task.wait.take(), task.name.clone(), task.detached)
        };
        if let Some((node, _)) = wait {
            self.disarm(node);
        }
        let mut heard = false;
        for node in joiners {
            heard |= self.is_armed(node);
            self.fire(node, joined(ending.clone()));
        }
        if let Ending::Failed(failure) = ending
            && !heard
        {
            let error = SimError::TaskFailed { task: name, time: self.now(), failure };
            self.error.borrow_mut().get_or_insert(error.into());
        }
        if detached {
            self.forget(id);
        }
    }

    /// Forgets a task as soon as it has ended.
    pub fn detach(&self, id: TaskId) {
        {
            let mut tasks = self.tasks.borrow_mut();
            let Some(task) = tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) else { return };
            task.detached = true;
        }
        self.forget(id);
    }

    /// Forgets an ended task, so that its place can be used again.
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

    /// Cancels everything that still runs.
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

    /// Runs what is ready, in the order in which it became ready. True when the main task has ended.
    fn run_ready(&self, main: &mut MainTask<'_>) -> Result<(), Error> {
        loop {
            let next = self.ready.borrow_mut().pop_front();
            match next {
                None => return Ok(()),
                Some(Ready::Task(id)) => self.run_task(id, main),
                Some(Ready::Agent(index)) => self.run_agent(index),
            }
            if self.error.borrow().is_some() {
                return self.take_error();
            }
        }
    }

    fn take_error(&self) -> Result<(), Error> {
        self.error.borrow_mut().take().map_or(Ok(()), Err)
    }

    fn run_agent(&self, index: u32) {
        let agent = self.agents.borrow_mut().get_mut(index as usize).and_then(Option::take);
        if let Some(mut agent) = agent {
            if let Err(error) = agent.edge(self) {
                self.error.borrow_mut().get_or_insert(error);
            }
            if let Some(slot) = self.agents.borrow_mut().get_mut(index as usize) {
                *slot = Some(agent);
            }
        }
    }

    fn run_task(&self, id: TaskId, main: &mut MainTask<'_>) {
        let (body, wait, waker) = {
            let mut tasks = self.tasks.borrow_mut();
            let Some(task) = tasks.get_mut(id.index as usize).filter(|t| t.generation == id.generation) else { return };
            task.queued = false;
            if let Some((node, _)) = &task.wait
                && self.is_armed(*node)
            {
                // Woken by something it no longer waits for.
                return;
            }
            let Some(body) = task.body.take() else { return };
            // SAFETY: a copy that is never dropped; the original stays in the task's slot, which is not given to another
            // task before this one has ended.
            let waker = std::mem::ManuallyDrop::new(unsafe { std::ptr::read(&task.waker) });
            (body, task.wait.take(), waker)
        };
        let outer = (self.current.replace(Some(id)), self.current_waker.replace(waker.data()));
        let (body, ending) = match body {
            Body::Coroutine(mut coroutine) => {
                let ending = self.resume(id, &mut *coroutine, wait);
                (Body::Coroutine(coroutine), ending)
            }
            Body::Future(mut future) => {
                let ending = match future.as_mut().poll(&mut Context::from_waker(&waker)) {
                    Poll::Pending => None,
                    Poll::Ready(Ok(())) => Some(Ending::Done),
                    Poll::Ready(Err(failure)) => Some(Ending::Failed(failure)),
                };
                (Body::Future(future), ending)
            }
            Body::Main => {
                let ending = match main.as_mut().map(|m| m.as_mut().poll(&mut Context::from_waker(&waker))) {
                    Some(Poll::Ready(())) => Some(Ending::Done),
                    _ => None,
                };
                (Body::Main, ending)
            }
        };
        self.current.set(outer.0);
        self.current_waker.set(outer.1);
        let ending = {
            let mut tasks = self.tasks.borrow_mut();
            let task = &mut tasks[id.index as usize];
            let refused = task.refused.take().map(Ending::Failed);
            let cancelled = std::mem::take(&mut task.cancel_requested).then_some(Ending::Cancelled);
            match ending.or(refused).or(cancelled) {
                None => {
                    task.body = Some(body);
                    return;
                }
                Some(ending) => ending,
            }
        };
        self.end_task(id, ending);
        drop(body);
        // A waker of `FuturesUnordered` may have been called inside the poll.
        self.collect_woken();
    }

    fn resume(
        &self,
        id: TaskId,
        coroutine: &mut dyn super::task::Coroutine,
        wait: Option<(NodeRef, Trigger)>,
    ) -> Option<Ending> {
        let mut outcome = match wait {
            None => Outcome::Start,
            Some((node, _)) => self.take_outcome(node).unwrap_or(Outcome::Fired),
        };
        loop {
            match coroutine.resume(outcome) {
                Step::Done => return Some(Ending::Done),
                Step::Failed(failure) => return Some(Ending::Failed(failure)),
                Step::Wait(trigger) => match self.arm(&trigger, Target::Task(id)) {
                    Ok(node) => {
                        if let Some(task) = self.tasks.borrow_mut().get_mut(id.index as usize) {
                            task.wait = Some((node, trigger));
                        }
                        return None;
                    }
                    Err(error) => outcome = Outcome::Refused(error.into()),
                },
            }
        }
    }

    // ---- the time step

    /// Runs until the main task has ended, then to the end of that time step.
    pub fn run(&self, main: MainTask<'_>, done: &dyn Fn() -> bool) -> Result<(), Error> {
        let mut main = main;
        self.stop_flag.store(false, Ordering::Relaxed);
        let mut watch = WallWatch::new(self.limits.borrow().wall_clock);
        let limit = self.limits.borrow().time.unwrap_or(Time::fs(u64::MAX));
        loop {
            self.time_step(&mut main)?;
            if done() {
                return Ok(());
            }
            self.check_finished()?;
            let next = self.next_time();
            let Some(next) = next else {
                return Err(SimError::Deadlock { report: self.report() }.into());
            };
            if next > limit {
                return Err(SimError::TimeLimit { limit, report: self.report() }.into());
            }
            if watch.is_due() {
                self.check_wall_clock(&mut watch)?;
            }
            self.begin_step(next);
        }
    }

    /// An error if the Verilog called `$finish` and nobody waited for it.
    pub fn check_finished(&self) -> Result<(), Error> {
        match self.finished.take() {
            None => Ok(()),
            Some((time, line)) => {
                let file = self.finish_file.borrow().clone();
                Err(SimError::Finished { file, line, time }.into())
            }
        }
    }

    pub fn check_wall_clock(&self, watch: &mut WallWatch) -> Result<(), Error> {
        if let Some(seconds) = watch.check() {
            return Err(SimError::WallClock { seconds, report: self.report() }.into());
        }
        let asked = self.interrupt.borrow_mut().as_mut().is_some_and(|interrupt| interrupt());
        if asked || self.stop_flag.load(Ordering::Relaxed) {
            return Err(SimError::Interrupted { time: self.now() }.into());
        }
        Ok(())
    }

    pub fn wall_watch(&self) -> WallWatch {
        WallWatch::new(self.limits.borrow().wall_clock)
    }

    #[inline]
    fn next_time(&self) -> Option<Time> {
        let clocks = self.clocks.borrow();
        let clock = clocks.iter().filter(|c| c.running).map(|c| c.next).min();
        let mut timers = self.timers.borrow_mut();
        while let Some(Reverse(entry)) = timers.peek() {
            if self.is_armed(NodeRef { index: entry.node.0, generation: entry.node.1 }) {
                return Some(clock.map_or(entry.at, |c| c.min(entry.at)));
            }
            timers.pop();
        }
        clock
    }

    /// Time goes on: clocks due put their level, timers due wake their tasks.
    #[inline]
    fn begin_step(&self, time: Time) {
        self.now.set(time);
        self.region.set(Region::Active);
        let mut timed = false;
        let mut clock_writes = 0;
        for clock in self.clocks.borrow_mut().iter_mut().filter(|c| c.running && c.next == time) {
            let span = if clock.level { clock.high } else { clock.low };
            // Cannot fail: the region takes writes.
            let _ = self.write(clock.signal, u64::from(clock.level));
            clock_writes += 1;
            clock.next = time + span;
            clock.level = !clock.level;
        }
        self.clock_writes.set(clock_writes);
        if !self.next_step.borrow().is_empty() {
            self.fire_list(&self.next_step);
        }
        loop {
            let due = {
                let mut timers = self.timers.borrow_mut();
                match timers.peek() {
                    Some(Reverse(entry)) if entry.at <= time => timers.pop(),
                    _ => None,
                }
            };
            let Some(Reverse(entry)) = due else { break };
            timed = true;
            self.fire(NodeRef { index: entry.node.0, generation: entry.node.1 }, None);
        }
        self.timed.set(timed);
    }

    fn fire_list(&self, list: &RefCell<Vec<NodeRef>>) {
        let waiting = std::mem::take(&mut *list.borrow_mut());
        waiting.into_iter().for_each(|node| self.fire(node, None));
    }

    #[inline]
    fn time_step(&self, main: &mut MainTask<'_>) -> Result<(), Error> {
        self.region.set(Region::Active);
        self.run_ready(main)?;
        if self.timed.get() && self.clock_writes.get() > 0 {
            self.warn_of_race();
        }
        let mut rounds = 0u32;
        loop {
            while !self.writes.borrow().is_empty() || !self.large_writes.borrow().is_empty() {
                rounds += 1;
                if rounds > self.limits.borrow().rounds {
                    return Err(SimError::NoProgress { rounds, report: self.report() }.into());
                }
                match self.edge_order.get() {
                    EdgeOrder::BeforeEval => {
                        self.apply_writes();
                        self.run_ready(main)?;
                        self.evaluate()?;
                    }
                    EdgeOrder::AfterEval => {
                        self.apply_writes();
                        self.evaluate()?;
                        self.run_ready(main)?;
                    }
                }
                self.fire_observed();
                self.run_ready(main)?;
            }
            if self.read_write.borrow().is_empty() {
                break;
            }
            rounds += 1;
            if rounds > self.limits.borrow().rounds {
                return Err(SimError::NoProgress { rounds, report: self.report() }.into());
            }
            self.region.set(Region::ReadWrite);
            self.fire_list(&self.read_write);
            self.run_ready(main)?;
            self.region.set(Region::Active);
        }
        if !self.read_only.borrow().is_empty() {
            self.region.set(Region::ReadOnly);
            self.fire_list(&self.read_only);
            self.run_ready(main)?;
        }
        if self.has_waves.get() {
            self.waves.borrow_mut().sample(&mut self.model.borrow_mut(), self.now())?;
        }
        Ok(())
    }

    #[cold]
    fn warn_of_race(&self) {
        let writes = self.writes.borrow();
        let clocks = self.clocks.borrow();
        for write in writes.iter().filter(|w| !clocks.iter().any(|c| c.running && c.signal == w.signal)) {
            if !self.warned.borrow().contains(&write.signal) {
                self.warned.borrow_mut().push(write.signal);
                let text = format!(
                    "'{}' was written after a Timer in the very step of a clock edge: the edge samples the new value; \
                     wait for the clock's edge instead",
                    self.signal_name(write.signal)
                );
                self.log.borrow_mut().put(self.now(), Level::Warning, "harness", &text);
            }
        }
    }

    /// Puts the buffered writes; whoever waits for an edge of a written signal becomes ready.
    #[inline]
    fn apply_writes(&self) {
        let mut applying = self.applying.borrow_mut();
        std::mem::swap(&mut *applying, &mut *self.writes.borrow_mut());
        for Write { signal, value } in applying.drain(..) {
            let state = &self.signals[signal as usize];
            state.pending.set(NONE);
            // SAFETY: the model lives as long as the core; nobody holds a reference into it.
            let old = unsafe {
                let old = load(state.data, state.storage);
                store(state.data, state.storage, value);
                old
            };
            state.last.set(value);
            if old != value {
                self.fire_edges(state, old, value);
            }
        }
        if !self.large_writes.borrow().is_empty() {
            self.apply_large_writes();
        }
    }

    #[cold]
    fn apply_large_writes(&self) {
        for write in std::mem::take(&mut *self.large_writes.borrow_mut()) {
            match write {
                LargeWrite::Words(signal, words) => {
                    let state = &self.signals[signal as usize];
                    // SAFETY: as in `apply_writes`; the words fit the signal.
                    let changed = unsafe {
                        let old = load_words(state.data, state.storage);
                        store_words(state.data, state.storage, &words);
                        old != load_words(state.data, state.storage)
                    };
                    self.remember(state);
                    if changed {
                        self.fire_edges(state, 0, 1);
                    }
                }
                LargeWrite::Element(signal, offset, value) => {
                    let state = &self.signals[signal as usize];
                    // SAFETY: the offset was checked when the write was buffered.
                    unsafe { store(state.data.add(offset), state.storage, value) };
                }
            }
        }
    }

    #[inline]
    fn fire_edges(&self, state: &SignalState, old: u64, new: u64) {
        {
            let agents = state.agents.borrow();
            if !agents.is_empty() {
                let mut ready = self.ready.borrow_mut();
                ready.extend(agents.iter().filter(|(_, e)| e.is(old, new)).map(|(index, _)| Ready::Agent(*index)));
            }
        }
        let mut watchers = state.watchers.borrow_mut();
        if watchers.is_empty() {
            return;
        }
        watchers.retain_mut(|watcher| {
            if !watcher.edge.is(old, new) {
                return true;
            }
            watcher.remaining -= 1;
            if watcher.remaining > 0 {
                return true;
            }
            self.fire(watcher.node, None);
            false
        });
    }

    /// Looks for changes of outputs and internals that somebody waits for.
    #[inline]
    fn fire_observed(&self) {
        let observed = self.observed.borrow();
        for &signal in observed.iter() {
            let state = &self.signals[signal as usize];
            // SAFETY: the model lives as long as the core.
            let (old, new) = unsafe {
                if let Storage::Wide(_) = state.storage {
                    let new = load_words(state.data, state.storage);
                    let changed = *state.last_words.borrow() != new;
                    *state.last_words.borrow_mut() = new;
                    (0, u64::from(changed))
                } else {
                    (state.last.get(), load(state.data, state.storage))
                }
            };
            if old != new {
                state.last.set(new);
                self.fire_edges(state, old, new);
            }
        }
    }

    #[inline]
    fn evaluate(&self) -> Result<(), Error> {
        let mut model = self.model.borrow_mut();
        self.evaluations.set(self.evaluations.get() + 1);
        if model.time() != self.now() {
            model.set_time(self.now());
        }
        let result = model.eval();
        if result.is_ok() && !model.has_messages() {
            return Ok(());
        }
        let messages = model.take_messages();
        drop(model);
        self.handle_messages(messages)?;
        Ok(result?)
    }

    /// `$display` goes to the log, `$error` and its kin end the run, `$finish` ends it unless somebody waits for it.
    #[cold]
    pub fn handle_messages(&self, messages: Vec<Message>) -> Result<(), Error> {
        let mut stop = None;
        let mut said = String::new();
        for message in messages {
            match message {
                Message::Text(line) => {
                    let level = if line.contains("%Error") || line.contains("%Fatal") {
                        said.clone_from(&line);
                        Level::Error
                    } else if line.contains("%Warning") {
                        Level::Warning
                    } else {
                        Level::Info
                    };
                    self.log.borrow_mut().put(self.now(), level, "verilog", &line);
                }
                Message::Finish { file, line } => {
                    self.log.borrow_mut().put(self.now(), Level::Info, "verilog", &format!("$finish ({file}:{line})"));
                    if self.finish_waiters.borrow().iter().any(|n| self.is_armed(*n)) {
                        self.fire_list(&self.finish_waiters);
                    } else {
                        self.finished.set(Some((self.now(), line)));
                        *self.finish_file.borrow_mut() = file;
                    }
                }
                Message::Stop { file, line } => {
                    let message = if said.is_empty() { "$stop".to_owned() } else { said.clone() };
                    stop.get_or_insert(SimError::Verilog { message, file, line, time: self.now() });
                }
                Message::Fatal { message, file, line } => {
                    stop.get_or_insert(SimError::Verilog { message, file, line, time: self.now() });
                }
            }
        }
        stop.map_or(Ok(()), |error| Err(error.into()))
    }

    pub fn set_waves(&self, on: bool) {
        self.has_waves.set(on);
    }

    pub fn has_waves(&self) -> bool {
        self.has_waves.get()
    }

    /// Goes to a later time directly: the bulk paths keep clocks and time themselves.
    pub fn set_now(&self, time: Time) {
        self.now.set(time);
    }

    // ---- reports

    /// What every living task waits for.
    pub fn report(&self) -> StuckReport {
        let tasks = self.tasks.borrow();
        let reports = tasks
            .iter()
            .enumerate()
            .filter(|(_, task)| task.ending.is_none())
            .map(|(index, task)| {
                let id = TaskId { index: index as u32, generation: task.generation };
                let mut waits: Vec<String> = {
                    let nodes = self.nodes.borrow();
                    let of_task = |n: &&Node| {
                        n.state == State::Armed
                            && match &n.target {
                                Target::Task(t) => *t == id,
                                Target::Waker(w) => w.will_wake(&task.waker),
                                Target::Parent(..) => false,
                            }
                    };
                    nodes.iter().filter(of_task).map(|n| self.describe(&n.waiting, &nodes, &tasks)).collect()
                };
                if waits.is_empty() {
                    waits.push(if task.queued {
                        "is ready to run".into()
                    } else {
                        "nothing the harness knows of".into()
                    });
                }
                TaskReport { task: task.name.clone(), waits }
            })
            .collect();
        let stopped = self.clocks.borrow().iter().all(|c| !c.running);
        StuckReport { time: self.now(), tasks: reports, no_clock: stopped }
    }

    fn describe(&self, waiting: &Waiting, nodes: &Nodes, tasks: &[Task]) -> String {
        let part = |p: &NodeRef| match nodes.get(*p) {
            Some(node) if node.state == State::Armed => self.describe(&node.waiting, nodes, tasks),
            _ => "done".into(),
        };
        match waiting {
            Waiting::Edge(signal, edge, count) => {
                let name = match edge {
                    Edge::Rising => "RisingEdge",
                    Edge::Falling => "FallingEdge",
                    Edge::Any => "ValueChange",
                };
                let state = &self.signals[*signal as usize];
                // SAFETY: the model lives as long as the core.
                let value = unsafe { load(state.data, state.storage) };
                let times = if *count > 1 { format!(", {count} times") } else { String::new() };
                format!("{name}({}{times}), which is {value:#x}", self.signal_name(*signal))
            }
            Waiting::Until(time) => format!("Timer until {time}"),
            Waiting::Named(name) => (*name).to_owned(),
            Waiting::Sync(sync) => format!("{}({})", if sync.0.exclusive { "Lock" } else { "Event" }, sync.0.name),
            Waiting::Join(id) => format!("the end of task '{}'", tasks.get(id.index as usize).map_or("", |t| &t.name)),
            Waiting::First(parts) => format!("First({})", parts.iter().map(part).collect::<Vec<_>>().join(", ")),
            Waiting::Combine(parts, _) => format!("Combine({})", parts.iter().map(part).collect::<Vec<_>>().join(", ")),
        }
    }
}

fn joined(ending: Ending) -> Option<Box<Outcome>> {
    match ending {
        Ending::Done => None,
        Ending::Failed(failure) => Some(Box::new(Outcome::Failed(failure))),
        Ending::Cancelled => Some(Box::new(Outcome::Cancelled)),
    }
}

/// The future `run` drives, if it drives one.
pub(crate) type MainTask<'a> = Option<Pin<&'a mut dyn Future<Output = ()>>>;

/// Looks at the wall clock about every few milliseconds without asking for it at every step.
pub(crate) struct WallWatch {
    started: Instant,
    limit: Option<Duration>,
    last: Instant,
    countdown: u32,
    interval: u32,
}

impl WallWatch {
    fn new(limit: Option<Duration>) -> WallWatch {
        let now = Instant::now();
        WallWatch { started: now, limit, last: now, countdown: 1, interval: 1 }
    }

    #[inline(always)]
    pub fn is_due(&mut self) -> bool {
        self.countdown -= 1;
        self.countdown == 0
    }

    /// The limit in seconds, if it is over.
    fn check(&mut self) -> Option<f64> {
        let now = Instant::now();
        let since = now - self.last;
        if since < Duration::from_millis(2) {
            self.interval = (self.interval * 2).min(1 << 16);
        } else if since > Duration::from_millis(20) {
            self.interval = (self.interval / 2).max(1);
        }
        self.last = now;
        self.countdown = self.interval;
        self.limit.filter(|limit| now - self.started > *limit).map(|limit| limit.as_secs_f64())
    }
}
