//! Triggers as Rust futures, and functions that combine futures.

use std::future::Future;
use std::pin::Pin;
use std::rc::Rc;
use std::task::{Context, Poll};

use super::scheduler::Core;
use super::scheduler::WaitId;
use super::trigger::{Outcome, Trigger};
use crate::bench::failure::Failure;

/// A trigger as a future: `clk.rising_edge().await`. It can be reused by `clone`, or as a plain [`Trigger`].
///
/// A wait that is not allowed (a second `ReadOnly` in the same time step, a `Timer` of 0) fails its task.
#[must_use = "a trigger does nothing until it is awaited"]
pub struct Wait {
    core: Rc<Core>,
    trigger: Trigger,
    wait_id: Option<WaitId>,
}

impl Clone for Wait {
    fn clone(&self) -> Wait {
        Wait { core: self.core.clone(), trigger: self.trigger.clone(), wait_id: None }
    }
}

impl Wait {
    #[inline]
    pub(crate) fn new(core: &Rc<Core>, trigger: Trigger) -> Wait {
        Wait { core: core.clone(), trigger, wait_id: None }
    }

    /// Returns the trigger as a value.
    pub fn trigger(&self) -> Trigger {
        self.trigger.clone()
    }

    /// Waits and returns how the wait ended, where `await` fails the task.
    pub(crate) fn poll_outcome(&mut self, context: &mut Context<'_>) -> Poll<Outcome> {
        match self.wait_id {
            None => match self.core.arm_for_future(&self.trigger, context) {
                Ok(wait_id) => match self.core.take_outcome(wait_id) {
                    // A wait that is over already does not suspend the task, except `Yield`, whose purpose that is.
                    Some(outcome) if !matches!(self.trigger, Trigger::Yield) => Poll::Ready(outcome),
                    Some(_) | None => {
                        self.wait_id = Some(wait_id);
                        Poll::Pending
                    }
                },
                Err(error) => {
                    self.core.refuse_current(error.into());
                    Poll::Pending
                }
            },
            Some(wait_id) => match self.core.take_outcome(wait_id) {
                Some(outcome) => {
                    self.wait_id = None;
                    Poll::Ready(outcome)
                }
                None if matches!(self.trigger, Trigger::Yield) => {
                    self.wait_id = None;
                    Poll::Ready(Outcome::Fired)
                }
                None => Poll::Pending,
            },
        }
    }
}

impl Future for Wait {
    type Output = ();

    #[inline]
    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        match self.poll_outcome(context) {
            Poll::Pending => Poll::Pending,
            Poll::Ready(Outcome::Failed(failure) | Outcome::Refused(failure)) => {
                self.core.refuse_current(failure);
                Poll::Pending
            }
            Poll::Ready(_) => Poll::Ready(()),
        }
    }
}

impl Drop for Wait {
    fn drop(&mut self) {
        if let Some(wait_id) = self.wait_id.take() {
            self.core.disarm(wait_id);
        }
    }
}

/// A wait for the first of several triggers, which returns its index.
#[must_use = "a trigger does nothing until it is awaited"]
pub struct First(pub(crate) Wait);

impl First {
    /// Returns the trigger as a value.
    pub fn trigger(&self) -> Trigger {
        self.0.trigger()
    }
}

impl Future for First {
    type Output = usize;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<usize> {
        match self.0.poll_outcome(context) {
            Poll::Ready(Outcome::First(index, _)) => Poll::Ready(index),
            Poll::Ready(Outcome::Failed(failure) | Outcome::Refused(failure)) => {
                self.0.core.refuse_current(failure);
                Poll::Pending
            }
            Poll::Ready(_) => {
                self.0.core.refuse_current(Failure::new("a task waited for in First was cancelled"));
                Poll::Pending
            }
            Poll::Pending => Poll::Pending,
        }
    }
}

/// The result of one of two futures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Either<A, B> {
    /// Of the first future.
    Left(A),
    /// Of the second future.
    Right(B),
}

/// Runs two futures until one ends; the other is dropped. If both are ready, the first wins.
pub async fn race<A: Future, B: Future>(a: A, b: B) -> Either<A::Output, B::Output> {
    let (mut a, mut b) = (std::pin::pin!(a), std::pin::pin!(b));
    std::future::poll_fn(move |context| {
        if let Poll::Ready(value) = a.as_mut().poll(context) {
            return Poll::Ready(Either::Left(value));
        }
        b.as_mut().poll(context).map(Either::Right)
    })
    .await
}

/// Runs two futures until both have ended.
pub async fn both<A: Future, B: Future>(a: A, b: B) -> (A::Output, B::Output) {
    let (mut a, mut b) = (std::pin::pin!(a), std::pin::pin!(b));
    let (mut left, mut right) = (None, None);
    std::future::poll_fn(move |context| {
        if left.is_none()
            && let Poll::Ready(value) = a.as_mut().poll(context)
        {
            left = Some(value);
        }
        if right.is_none()
            && let Poll::Ready(value) = b.as_mut().poll(context)
        {
            right = Some(value);
        }
        match (left.take(), right.take()) {
            (Some(l), Some(r)) => Poll::Ready((l, r)),
            (l, r) => {
                (left, right) = (l, r);
                Poll::Pending
            }
        }
    })
    .await
}
