//! The report of what every task waits for.

use std::fmt;

use crate::engine::time::Time;

/// The report of what one task waits for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TaskReport {
    /// The task's name.
    pub task: String,
    /// Descriptions of the events that it waits for; several if it waits for the first of several futures.
    pub waits: Vec<String>,
}

/// The report of what all living tasks wait for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StuckReport {
    /// Simulation time.
    pub time: Time,
    /// The tasks, in the order in which they were started.
    pub tasks: Vec<TaskReport>,
    /// `true` if no clock of the harness runs.
    pub no_clock: bool,
}

impl fmt::Display for StuckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for task in self.tasks.iter().take(40) {
            writeln!(f, "  '{}' waits for {}", task.task, task.waits.join(" or "))?;
        }
        if self.tasks.len() > 40 {
            writeln!(f, "  ... and {} more tasks", self.tasks.len() - 40)?;
        }
        if self.no_clock {
            write!(f, "  no clock runs: was one forgotten?")?;
        } else {
            write!(f, "  (clocks run)")?;
        }
        Ok(())
    }
}
