//! Signals in the scheduler: which tasks wait for which change, buffered writes, detection of changes.

use std::cell::{Cell, RefCell};
use std::iter::repeat;

use super::task_state::{Body, EdgeWait, TaskWait};
use super::wait_table::{Target, WaitId, Waiting};
use super::{Core, LargeWrite, NONE, Ready};
use crate::bench::error::SimError;
use crate::bench::sim::task::{Coroutine, TaskId};
use crate::bench::sim::trigger::Edge;
use crate::engine::model::{Direction, SignalId, SignalInfo, Storage, load, load_words, store, store_words};

/// The task or wait that an edge wakes.
#[derive(Clone, Copy)]
pub(super) enum Waiter {
    /// A coroutine that waits for this edge and nothing else: the task's index, and the number of its wait. It needs no
    /// slot in the table of waits, which is most of the cost of a wait.
    Task(u32, u32),
    Wait(WaitId),
}

pub(super) struct Watcher {
    waiter: Waiter,
    /// The bits whose rise, and those whose fall is waited for: to look for an edge takes no branch.
    rising: u64,
    falling: u64,
    /// The number of edges until it wakes, the next one included.
    remaining: u64,
}

impl Watcher {
    #[inline]
    fn new(waiter: Waiter, edge: &EdgeWait) -> Watcher {
        Watcher { waiter, rising: edge.rising, falling: edge.falling, remaining: edge.count }
    }

    /// Returns `true` if it waits for a change in which the bits of `rose` rose and those of `fell` fell.
    #[inline(always)]
    fn matches(&self, rose: u64, fell: u64) -> bool {
        rose & self.rising | fell & self.falling != 0
    }
}

pub(super) struct SignalState {
    pub data: *mut u8,
    /// The address of writes; another than `data` if the evaluation decides the value.
    pub target: *mut u8,
    pub storage: Storage,
    /// Whether the design may change the signal itself.
    pub observed: bool,
    pub last: Cell<u64>,
    pub last_words: RefCell<Vec<u32>>,
    pub watchers: RefCell<Vec<Watcher>>,
    pub agents: RefCell<Vec<(u32, Edge)>>,
    pub listed: Cell<bool>,
    /// Index of this round's buffered write, or `NONE`.
    pub pending: Cell<u32>,
}

impl SignalState {
    pub fn new(info: &SignalInfo) -> SignalState {
        SignalState {
            data: info.data,
            target: info.target,
            storage: info.storage,
            observed: info.direction != Direction::Input,
            last: Cell::new(0),
            last_words: RefCell::default(),
            watchers: RefCell::default(),
            agents: RefCell::default(),
            listed: Cell::new(false),
            pending: Cell::new(NONE),
        }
    }

    /// Returns `true` if the design may change what a write changes.
    #[inline(always)]
    pub fn is_changed_by_design(&self) -> bool {
        self.observed && self.data == self.target
    }
}

impl Core {
    /// Returns the index of a signal, which must be one of this simulation's model.
    #[inline]
    fn index_of(&self, signal: SignalId) -> Result<u32, SimError> {
        if self.has(signal) { Ok(signal.index() as u32) } else { Err(SimError::OtherSimulation) }
    }

    #[inline]
    pub fn has(&self, signal: SignalId) -> bool {
        signal.model() == self.model_id
    }

    /// Begins a wait for an edge that wakes `target`.
    #[inline]
    pub(super) fn arm_edge(
        &self,
        signal: SignalId,
        edge: Edge,
        count: u64,
        target: Target,
    ) -> Result<WaitId, SimError> {
        let signal = self.begin_watching(signal, edge, count)?;
        let wait_id = self.new_wait(target, Waiting::Edge(signal, edge, count));
        let watcher = Watcher::new(Waiter::Wait(wait_id), &EdgeWait::new(signal, edge, count));
        self.signals[signal as usize].watchers.borrow_mut().push(watcher);
        Ok(wait_id)
    }

    /// Begins the wait of a coroutine for an edge alone.
    #[inline]
    pub(super) fn arm_task(&self, id: TaskId, signal: SignalId, edge: Edge, count: u64) -> Result<(), SimError> {
        let signal = self.begin_watching(signal, edge, count)?;
        self.tasks.borrow_mut()[id.index as usize].edge = EdgeWait::new(signal, edge, count);
        self.arm_task_again(id)
    }

    /// Begins the wait of a coroutine for the edge that it waited for last.
    #[inline(always)]
    pub(super) fn arm_task_again(&self, id: TaskId) -> Result<(), SimError> {
        let mut tasks = self.tasks.borrow_mut();
        let task = &mut tasks[id.index as usize];
        if task.edge.count == 0 {
            return Err(SimError::BadTime(
                "the task has waited for no edge before: it cannot wait for it again".into(),
            ));
        }
        task.waits = task.waits.wrapping_add(1);
        task.wait = TaskWait::Edge;
        let waiter = Waiter::Task(id.index, task.waits);
        self.signals[task.edge.signal as usize].watchers.borrow_mut().push(Watcher::new(waiter, &task.edge));
        Ok(())
    }

    #[inline(always)]
    fn begin_watching(&self, signal: SignalId, edge: Edge, count: u64) -> Result<u32, SimError> {
        let signal = self.index_of(signal)?;
        if count == 0 {
            return Err(SimError::BadTime("ClockCycles of 0 cycles: nothing to wait for".into()));
        }
        let state = &self.signals[signal as usize];
        if matches!(state.storage, Storage::Wide(_))
            && matches!(edge, Edge::RisingBit(_) | Edge::FallingBit(_) | Edge::AnyBit(_))
        {
            return Err(self.too_wide_for_edges(signal));
        }
        if state.observed && !state.listed.get() {
            self.observe(signal);
        }
        Ok(signal)
    }

    #[cold]
    fn too_wide_for_edges(&self, signal: u32) -> SimError {
        let name = self.signal_name(signal);
        SimError::BadTime(format!("'{name}' is wider than 64 bits: its bits have no edges of their own"))
    }

    /// Looks for changes of the signal after each evaluation from now on.
    #[cold]
    pub(super) fn observe(&self, signal: u32) {
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

    #[inline]
    fn still_waits(&self, waiter: Waiter) -> bool {
        match waiter {
            Waiter::Wait(wait_id) => self.is_armed(wait_id),
            Waiter::Task(index, wait) => {
                let tasks = self.tasks.borrow();
                let task = &tasks[index as usize];
                task.waits == wait && matches!(task.wait, TaskWait::Edge)
            }
        }
    }

    /// Drops watchers of cancelled waits, once they are many.
    pub(super) fn compact(&self, signal: u32) {
        if let Ok(mut list) = self.signals[signal as usize].watchers.try_borrow_mut()
            && list.len() > 16
        {
            let before = list.len();
            let stale = list.iter().filter(|w| !self.still_waits(w.waiter)).count();
            if stale * 2 > before {
                list.retain(|w| self.still_waits(w.waiter));
            }
        }
    }

    /// Puts the buffered writes; tasks that wait for an edge of a written signal become ready.
    #[inline]
    pub fn apply_writes(&self) {
        let mut applying = self.applying.borrow_mut();
        std::mem::swap(&mut *applying, &mut *self.writes.borrow_mut());
        for write in applying.iter() {
            let state = &self.signals[write.signal as usize];
            state.pending.set(NONE);
            // SAFETY: the model lives as long as the core; no reference into it exists.
            let (old, value) = unsafe {
                let old = load(state.data, state.storage);
                let value = match write.mask {
                    u64::MAX => write.value,
                    _ => write.onto(load(state.target, state.storage)),
                };
                store(state.target, state.storage, value);
                (old, value)
            };
            if state.data != state.target {
                continue;
            }
            state.last.set(value);
            if old != value {
                self.fire_edges(state, old, value);
            }
        }
        applying.clear();
        if !self.large_writes.borrow().is_empty() {
            self.apply_large_writes();
        }
    }

    #[cold]
    fn apply_large_writes(&self) {
        for write in std::mem::take(&mut *self.large_writes.borrow_mut()) {
            match write {
                LargeWrite::Words(signal, words) => self.put_words(&self.signals[signal as usize], &words),
                LargeWrite::Bits(signal, mask, mut words) => {
                    let state = &self.signals[signal as usize];
                    // SAFETY: the model lives as long as the core.
                    let old = unsafe { load_words(state.target, state.storage) };
                    words.resize(old.len(), 0);
                    for ((word, mask), old) in words.iter_mut().zip(mask.into_iter().chain(repeat(0))).zip(old) {
                        *word |= old & !mask;
                    }
                    self.put_words(state, &words);
                }
                LargeWrite::Element(signal, offset, value) => {
                    let state = &self.signals[signal as usize];
                    // SAFETY: the offset was checked when the write was buffered.
                    unsafe { store(state.data.add(offset), state.storage, value) };
                }
                LargeWrite::ElementWords(signal, offset, words) => {
                    let state = &self.signals[signal as usize];
                    // SAFETY: offset and words were checked when the write was buffered.
                    unsafe { store_words(state.data.add(offset), state.storage, &words) };
                }
                LargeWrite::Text(index, value) => self.model.borrow_mut().set_text(index, &value),
            }
        }
    }

    fn put_words(&self, state: &SignalState, words: &[u32]) {
        // SAFETY: as in `apply_writes`; the words fit the signal.
        let changed = unsafe {
            let old = load_words(state.data, state.storage);
            store_words(state.target, state.storage, words);
            old != load_words(state.data, state.storage)
        };
        if state.data == state.target {
            self.remember(state);
            if changed {
                self.fire_edges(state, 0, 1);
            }
        }
    }

    /// Wakes what waits for a change: of most signals nothing, and of a clock's falling edges.
    #[inline(always)]
    pub(super) fn fire_edges(&self, state: &SignalState, old: u64, new: u64) {
        let (rose, fell) = (!old & new, old & !new);
        let is_awaited = state.watchers.borrow().iter().any(|watcher| watcher.matches(rose, fell));
        if is_awaited || !state.agents.borrow().is_empty() {
            self.wake(state, old, new);
        }
    }

    /// Wakes what waits for a change at the beginning of a step, when nothing is ready. If only one coroutine waits, as
    /// for most clocks, it is returned and not queued: the caller runs it next.
    #[inline(always)]
    pub(super) fn fire_clock(&self, state: &SignalState, old: u64, new: u64) -> Option<(TaskId, Box<dyn Coroutine>)> {
        {
            let (rose, fell) = (!old & new, old & !new);
            let mut watchers = state.watchers.borrow_mut();
            if let [watcher] = &watchers[..]
                && let Waiter::Task(index, wait) = watcher.waiter
                && watcher.remaining == 1
                && watcher.matches(rose, fell)
                && state.agents.borrow().is_empty()
            {
                watchers.clear();
                let mut tasks = self.tasks.borrow_mut();
                let task = &mut tasks[index as usize];
                if task.waits != wait || !matches!(task.wait, TaskWait::Edge) || task.queued {
                    return None;
                }
                // No other kind of body waits without an entry in the table of waits.
                let Some(Body::Coroutine(coroutine)) = task.body.take() else { return None };
                task.wait = TaskWait::Nothing;
                return Some((TaskId { index, generation: task.generation }, coroutine));
            }
        }
        self.fire_edges(state, old, new);
        None
    }

    fn wake(&self, state: &SignalState, old: u64, new: u64) {
        if !state.agents.borrow().is_empty() {
            let mut ready = self.ready.borrow_mut();
            for (index, edge) in state.agents.borrow().iter() {
                if edge.is(old, new) {
                    ready.push_back(Ready::Agent(*index));
                }
            }
        }
        let (rose, fell) = (!old & new, old & !new);
        // `retain_mut` would do, but calls what it is given.
        let mut watchers = state.watchers.borrow_mut();
        let mut kept = 0;
        for at in 0..watchers.len() {
            let watcher = &mut watchers[at];
            if watcher.matches(rose, fell) {
                watcher.remaining -= 1;
                if watcher.remaining == 0 {
                    match watcher.waiter {
                        Waiter::Task(index, wait) => self.fire_task(index, wait),
                        Waiter::Wait(wait_id) => self.fire(wait_id, None),
                    }
                    continue;
                }
            }
            watchers.swap(kept, at);
            kept += 1;
        }
        watchers.truncate(kept);
    }

    /// Makes a coroutine ready whose edge has come, if it still waits for it.
    #[inline(always)]
    fn fire_task(&self, index: u32, wait: u32) {
        let mut tasks = self.tasks.borrow_mut();
        let task = &mut tasks[index as usize];
        if task.waits == wait && matches!(task.wait, TaskWait::Edge) {
            task.wait = TaskWait::Fired;
            if !task.queued {
                task.queued = true;
                let id = TaskId { index, generation: task.generation };
                self.ready.borrow_mut().push_back(Ready::Task(id));
            }
        }
    }

    /// Looks for changes of the outputs and internals that tasks wait for.
    #[inline(always)]
    pub(super) fn fire_observed(&self) {
        if !self.observed.borrow().is_empty() {
            self.compare_observed();
        }
    }

    fn compare_observed(&self) {
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
}
