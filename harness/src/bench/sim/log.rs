//! The log: lines of the bench, the harness and the Verilog, each with its simulation time.

use std::collections::VecDeque;
use std::fmt;

use crate::engine::time::Time;

/// The importance of a line of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Details for debugging.
    Debug,
    /// Information.
    Info,
    /// Something looks wrong.
    Warning,
    /// Something is wrong.
    Error,
}

/// A line of the log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Simulation time.
    pub time: Time,
    /// Importance of the line.
    pub level: Level,
    /// The origin of the line: `verilog`, `harness`, or a name that the bench chose.
    pub source: String,
    /// The text.
    pub text: String,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level = match self.level {
            Level::Debug => "DEBUG",
            Level::Info => "INFO",
            Level::Warning => "WARNING",
            Level::Error => "ERROR",
        };
        write!(f, "{:>16} {level:<8} {:<10} {}", self.time.to_string(), self.source, self.text)
    }
}

/// A function that gets every line of the log.
pub(crate) type Listener = Box<dyn FnMut(&Line)>;

/// The last lines, and a listener that is called with each new line.
pub struct Log {
    lines: VecDeque<Line>,
    kept: usize,
    threshold: Level,
    listener: Option<Listener>,
}

impl Default for Log {
    fn default() -> Self {
        Log { lines: VecDeque::new(), kept: 10_000, threshold: Level::Info, listener: None }
    }
}

impl Log {
    /// Adds a line, unless it is below the threshold.
    pub(crate) fn put(&mut self, time: Time, level: Level, source: &str, text: &str) {
        if level < self.threshold {
            return;
        }
        let line = Line { time, level, source: source.to_owned(), text: text.to_owned() };
        if let Some(listener) = &mut self.listener {
            listener(&line);
        }
        if self.lines.len() == self.kept {
            self.lines.pop_front();
        }
        self.lines.push_back(line);
    }

    pub(crate) fn set_threshold(&mut self, level: Level) {
        self.threshold = level;
    }

    pub(crate) fn set_listener(&mut self, listener: Listener) {
        self.listener = Some(listener);
    }

    pub(crate) fn lines(&self) -> Vec<Line> {
        self.lines.iter().cloned().collect()
    }
}
