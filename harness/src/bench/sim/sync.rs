//! Synchronisation between tasks: events, locks, queues.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use super::future::Wait;
use super::scheduler::Core;
use super::trigger::{Sync, Trigger};

/// A flag that tasks wait for. It stays set until it is cleared.
#[derive(Clone)]
pub struct Event {
    core: Rc<Core>,
    sync: Sync,
}

impl Event {
    pub(crate) fn new(core: &Rc<Core>, name: &str) -> Event {
        Event { core: core.clone(), sync: Sync::new(name, false) }
    }

    /// Sets it: all tasks that wait for it become ready.
    pub fn set(&self) {
        self.core.set_event(&self.sync);
    }

    /// Clears it.
    pub fn clear(&self) {
        self.sync.0.flag.set(false);
    }

    /// Returns `true` if it is set.
    pub fn is_set(&self) -> bool {
        self.sync.0.flag.get()
    }

    pub(super) fn core(&self) -> &Rc<Core> {
        &self.core
    }

    /// Waits until it is set; does not wait if it is set already.
    pub fn wait(&self) -> Wait {
        Wait::new(&self.core, self.trigger())
    }

    /// Returns the wait as a value.
    pub fn trigger(&self) -> Trigger {
        Trigger::Sync(self.sync.clone())
    }
}

/// A lock that one task has at a time. Tasks get it in the order in which they asked.
#[derive(Clone)]
pub struct Lock {
    core: Rc<Core>,
    sync: Sync,
}

/// A lock that a task has. When the guard is dropped, the next task gets the lock.
pub struct LockGuard<'a>(&'a Lock);

impl Lock {
    pub(crate) fn new(core: &Rc<Core>, name: &str) -> Lock {
        Lock { core: core.clone(), sync: Sync::new(name, true) }
    }

    /// Waits for the lock and keeps it until the guard is dropped.
    pub async fn lock(&self) -> LockGuard<'_> {
        self.acquire().await;
        LockGuard(self)
    }

    /// Waits for the lock; [`Lock::release`] must follow.
    pub fn acquire(&self) -> Wait {
        Wait::new(&self.core, self.trigger())
    }

    /// Returns the wait as a value; when it is over, the task has the lock.
    pub fn trigger(&self) -> Trigger {
        Trigger::Sync(self.sync.clone())
    }

    /// Releases the lock: the task that has waited longest gets it.
    pub fn release(&self) {
        self.core.release(&self.sync);
    }

    pub(super) fn core(&self) -> &Rc<Core> {
        &self.core
    }

    /// Returns `true` if a task holds it.
    pub fn is_locked(&self) -> bool {
        self.sync.0.flag.get()
    }
}

impl Drop for LockGuard<'_> {
    fn drop(&mut self) {
        self.0.release();
    }
}

/// A first-in first-out queue between tasks, of limited length.
pub struct Queue<T> {
    inner: Rc<QueueInner<T>>,
}

struct QueueInner<T> {
    items: RefCell<VecDeque<T>>,
    limit: Cell<usize>,
    not_empty: Event,
    not_full: Event,
}

impl<T> Clone for Queue<T> {
    fn clone(&self) -> Self {
        Queue { inner: self.inner.clone() }
    }
}

impl<T> Queue<T> {
    pub(crate) fn new(core: &Rc<Core>, name: &str, limit: usize) -> Queue<T> {
        let inner = QueueInner {
            items: RefCell::default(),
            limit: Cell::new(limit.max(1)),
            not_empty: Event::new(core, &format!("{name} not empty")),
            not_full: Event::new(core, &format!("{name} not full")),
        };
        inner.not_full.set();
        Queue { inner: Rc::new(inner) }
    }

    /// Puts an item at the end, waiting while the queue is full.
    pub async fn put(&self, item: T) {
        let mut item = Some(item);
        while let Some(rejected) = item.take().and_then(|i| self.try_put(i).err()) {
            item = Some(rejected);
            self.inner.not_full.wait().await;
        }
    }

    /// Puts an item if there is room, or gives it back.
    ///
    /// # Errors
    /// The item itself, if the queue is full.
    pub fn try_put(&self, item: T) -> Result<(), T> {
        let mut items = self.inner.items.borrow_mut();
        if items.len() >= self.inner.limit.get() {
            return Err(item);
        }
        items.push_back(item);
        if items.len() == self.inner.limit.get() {
            self.inner.not_full.clear();
        }
        drop(items);
        self.inner.not_empty.set();
        Ok(())
    }

    /// Takes the first item, waiting while there is none.
    pub async fn get(&self) -> T {
        loop {
            if let Some(item) = self.try_get() {
                return item;
            }
            self.inner.not_empty.wait().await;
        }
    }

    /// Takes the first item, if there is one.
    pub fn try_get(&self) -> Option<T> {
        let mut items = self.inner.items.borrow_mut();
        let item = items.pop_front()?;
        if items.is_empty() {
            self.inner.not_empty.clear();
        }
        drop(items);
        self.inner.not_full.set();
        Some(item)
    }

    /// Returns the number of items.
    pub fn len(&self) -> usize {
        self.inner.items.borrow().len()
    }

    /// Returns `true` if it is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
