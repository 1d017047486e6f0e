//! Bus models.
use crate::time::Time;

/// A rule of a bus that was not kept.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{bus}: {rule} at {time}")]
pub struct Violation {
    /// The bus.
    pub bus: String,
    /// The rule.
    pub rule: String,
    /// Simulation time.
    pub time: Time,
}
