//! What the scheduler keeps of each task.

use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Wake, Waker};

use super::wait_table::WaitId;
use crate::bench::failure::Failure;
use crate::bench::sim::task::{Coroutine, Ending, TaskId};
use crate::bench::sim::trigger::Edge;

pub(crate) enum Body {
    Future(Pin<Box<dyn Future<Output = Result<(), Failure>>>>),
    Coroutine(Box<dyn Coroutine>),
    /// The future that `run` was called with, which lives on `run`'s stack.
    Main,
}

/// The wait of a coroutine.
#[derive(Clone, Copy, Default)]
pub(crate) enum TaskWait {
    /// It has not started, or it runs.
    #[default]
    Nothing,
    /// An edge of a signal: that in `Task::edge`.
    Edge,
    /// That edge has come.
    Fired,
    /// Anything else, as listed in the table of waits.
    Other(WaitId),
}

/// An edge of a signal and a number of edges; 0 until a coroutine has waited for one.
#[derive(Clone, Copy)]
pub(crate) struct EdgeWait {
    pub signal: u32,
    pub edge: Edge,
    /// The rising and falling bits of [`Edge::bits`].
    pub rising: u64,
    pub falling: u64,
    pub count: u64,
}

impl EdgeWait {
    #[inline]
    pub fn new(signal: u32, edge: Edge, count: u64) -> EdgeWait {
        let (rising, falling) = edge.bits();
        EdgeWait { signal, edge, rising, falling, count }
    }
}

pub(crate) struct Task {
    pub generation: u32,
    pub name: String,
    /// `None` while the task runs.
    pub body: Option<Body>,
    /// What a coroutine waits for; futures keep their own.
    pub wait: TaskWait,
    /// The edge that a coroutine waits for, or did when it last waited for one.
    pub edge: EdgeWait,
    /// The number of waits for an edge so far: it distinguishes the present wait from cancelled ones. It continues to
    /// count when another task gets the slot.
    pub waits: u32,
    pub joiners: Vec<WaitId>,
    pub ending: Option<Ending>,
    pub queued: bool,
    /// Nothing will ask for its ending: its slot is free once it has ended.
    pub detached: bool,
    pub cancel_requested: bool,
    /// A wait or write that was not allowed: the task fails when its poll returns.
    pub refused: Option<Failure>,
    pub waker: Waker,
}

/// Wakes a task from combinators that bring wakers of their own (`FuturesUnordered` and the like).
pub(crate) struct TaskWaker {
    pub id: TaskId,
    pub woken: Arc<Mutex<Vec<TaskId>>>,
}

impl Wake for TaskWaker {
    fn wake(self: Arc<Self>) {
        self.woken.lock().unwrap_or_else(PoisonError::into_inner).push(self.id);
    }
}
