//! The failure of a task.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// The reason why a task failed: a text, and a payload of the task's language, such as an exception.
#[derive(Clone)]
pub struct Failure(Arc<FailureInner>);

struct FailureInner {
    message: String,
    payload: Option<Box<dyn Any + Send + Sync>>,
}

impl Failure {
    /// Creates a failure with a text and no payload.
    pub fn new(message: impl Into<String>) -> Failure {
        Failure(Arc::new(FailureInner { message: message.into(), payload: None }))
    }

    /// Creates a failure with a text and a payload.
    pub fn with_payload(message: impl Into<String>, payload: impl Any + Send + Sync) -> Failure {
        Failure(Arc::new(FailureInner { message: message.into(), payload: Some(Box::new(payload)) }))
    }

    /// Returns the text.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// Returns the payload if it is a `T`.
    pub fn payload<T: 'static>(&self) -> Option<&T> {
        self.0.payload.as_ref()?.downcast_ref()
    }
}

impl<E: std::error::Error + Send + Sync + 'static> From<E> for Failure {
    fn from(error: E) -> Failure {
        Failure::with_payload(error.to_string(), error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Failure({:?})", self.0.message)
    }
}
