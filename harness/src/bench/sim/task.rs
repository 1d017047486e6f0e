//! Tasks as benches see them: a Rust future behind a handle, or a coroutine of another language.

use std::cell::RefCell;
use std::future::Future;
use std::marker::PhantomData;
use std::pin::Pin;
use std::rc::Rc;
use std::task::{Context, Poll};

use super::future::Wait;
use super::scheduler::Core;
use super::trigger::{Outcome, Trigger};
use crate::bench::error::SimError;
use crate::bench::failure::Failure;

/// The id of a task; it is never reused for another task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TaskId {
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

/// The step that a coroutine takes when it is resumed.
pub enum Step {
    /// It waits for a trigger.
    Wait(Trigger),
    /// It waits for the edge that it waited for last, as most coroutines do: the same as `Wait` with that
    /// [`Trigger::Edge`] or [`Trigger::Edges`], in half the time.
    Again,
    /// It has ended. The coroutine keeps its result itself.
    Done,
    /// It ended in an error.
    Failed(Failure),
}

/// A task of another language.
pub trait Coroutine {
    /// Runs it to its next wait.
    fn resume(&mut self, outcome: Outcome) -> Step;

    /// Handles a cancellation: the coroutine is not resumed again.
    fn cancel(&mut self) {}
}

/// The end of a task.
#[derive(Debug, Clone)]
pub enum Ending {
    /// Without an error.
    Done,
    /// With an error.
    Failed(Failure),
    /// By `cancel`.
    Cancelled,
}

/// A started task. Awaiting it gives the task's value. Dropping it leaves the task running.
pub struct TaskHandle<T> {
    pub(super) core: Rc<Core>,
    pub(super) id: TaskId,
    pub(super) value: Rc<RefCell<Option<T>>>,
}

impl<T> TaskHandle<T> {
    /// Returns the task's id.
    pub fn id(&self) -> TaskId {
        self.id
    }

    /// Returns `true` if it has ended.
    pub fn is_done(&self) -> bool {
        self.core.ending(self.id).is_some()
    }

    /// Ends it.
    pub fn cancel(&self) {
        self.core.cancel(self.id);
    }

    /// Returns the end of the task as a trigger, without its value.
    pub fn ended(&self) -> Wait {
        Wait::new(&self.core, Trigger::Join(self.id))
    }

    /// Waits for the end of the task; gives its value, or the reason why there is none.
    pub fn join(self) -> Join<T> {
        let wait = self.ended();
        Join { wait, handle: self, _value: PhantomData }
    }
}

impl<T> Drop for TaskHandle<T> {
    fn drop(&mut self) {
        self.core.detach(self.id);
    }
}

impl<T> IntoFuture for TaskHandle<T> {
    type Output = Result<T, SimError>;
    type IntoFuture = Join<T>;

    fn into_future(self) -> Join<T> {
        self.join()
    }
}

/// A wait for the end of a task.
pub struct Join<T> {
    wait: Wait,
    handle: TaskHandle<T>,
    _value: PhantomData<T>,
}

impl<T> Future for Join<T> {
    type Output = Result<T, SimError>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        // SAFETY: no field is pinned structurally: `Wait` and `TaskHandle` may be moved.
        let this = unsafe { self.get_unchecked_mut() };
        let task = || this.handle.core.task_name(this.handle.id);
        match this.wait.poll_outcome(context) {
            Poll::Pending => Poll::Pending,
            Poll::Ready(Outcome::Failed(failure) | Outcome::Refused(failure)) => {
                Poll::Ready(Err(SimError::TaskFailed { task: task(), time: this.handle.core.now(), failure }))
            }
            Poll::Ready(_) => match this.handle.value.borrow_mut().take() {
                Some(value) => Poll::Ready(Ok(value)),
                None => Poll::Ready(Err(SimError::Cancelled { task: task() })),
            },
        }
    }
}
