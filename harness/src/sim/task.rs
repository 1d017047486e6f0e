//! Tasks: a Rust future, or a coroutine of another language that is resumed with the outcome of its last wait.

use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Wake, Waker};

use super::node::NodeRef;
use super::trigger::{Edge, Failure, Outcome, Trigger};

/// A task, as long as it is remembered; never reused for another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TaskId {
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

/// What a coroutine does when resumed.
pub enum Step {
    /// It waits.
    Wait(Trigger),
    /// It has come to its end; a result, if any, it keeps itself.
    Done,
    /// It ended in an error.
    Failed(Failure),
}

/// A task of another language.
pub trait Coroutine {
    /// Runs it to its next wait.
    fn resume(&mut self, outcome: Outcome) -> Step;

    /// It was cancelled: it is not resumed again.
    fn cancel(&mut self) {}
}

/// How a task ended.
#[derive(Debug, Clone)]
pub enum Ending {
    /// Well.
    Done,
    /// In an error.
    Failed(Failure),
    /// By `cancel`.
    Cancelled,
}

pub(crate) enum Body {
    Future(Pin<Box<dyn Future<Output = Result<(), Failure>>>>),
    Coroutine(Box<dyn Coroutine>),
    /// The future that `run` was called with, which lives on `run`'s stack.
    Main,
}

/// What a coroutine waits for.
#[derive(Clone, Copy, Default)]
pub(crate) enum TaskWait {
    /// It has not begun, or it runs.
    #[default]
    Nothing,
    /// An edge of a signal, so many times.
    Edge(u32, Edge, u64),
    /// That edge has come.
    Fired,
    Node(NodeRef),
}

pub(crate) struct Task {
    pub generation: u32,
    pub name: String,
    /// Away while the task runs.
    pub body: Option<Body>,
    /// What a coroutine waits for; futures keep their own.
    pub wait: TaskWait,
    /// Waits for an edge so far: tells the one at hand from those given up. Goes on where the slot serves another task.
    pub waits: u32,
    pub joiners: Vec<NodeRef>,
    pub ending: Option<Ending>,
    pub queued: bool,
    /// Nobody will ask for its ending: its place is free once it has ended.
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
