//! Words that a model has heard and a bench takes.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use crate::sim::{Dut, Event, Wait};

/// Words in the order in which they came; clones share them.
#[derive(Clone)]
pub(super) struct Inbox {
    words: Rc<RefCell<VecDeque<u64>>>,
    count: Rc<Cell<u64>>,
    arrived: Event,
}

impl Inbox {
    /// An empty one; `name` says in a report of waiting tasks what they wait for.
    pub fn new(dut: &Dut, name: &str) -> Inbox {
        Inbox { words: Rc::default(), count: Rc::default(), arrived: dut.event(name) }
    }

    /// Adds a word.
    pub fn push(&self, word: u64) {
        self.words.borrow_mut().push_back(word);
        self.count.set(self.count.get() + 1);
        self.arrived.set();
    }

    /// The next word, once it is there.
    pub async fn recv(&self) -> u64 {
        loop {
            if let Some(word) = self.try_recv() {
                return word;
            }
            self.arrived().await;
        }
    }

    /// The wait for the next word, when none is there.
    pub fn arrived(&self) -> Wait {
        self.arrived.clear();
        self.arrived.wait()
    }

    /// The next word, if it has come.
    pub fn try_recv(&self) -> Option<u64> {
        self.words.borrow_mut().pop_front()
    }

    /// Words that have come so far.
    pub fn count(&self) -> u64 {
        self.count.get()
    }
}
