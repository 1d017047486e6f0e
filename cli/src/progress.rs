//! Progress on stderr.

use std::any::Any;
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hoverlock_cosim::Monitor;
use indicatif::{ProgressBar, ProgressStyle};

use crate::output::say;

/// Time after which a long step is announced.
const ANNOUNCE_AFTER: Duration = Duration::from_secs(1);

/// Time between two lines of progress without a terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(30);

/// Lines of progress from time to time, for a reader of a log: a bar shows nothing without a terminal.
pub struct LogLines {
    last: Mutex<Instant>,
}

impl LogLines {
    /// Starts the time; the first line comes after [`LINE_INTERVAL`].
    pub fn new() -> Self {
        Self { last: Mutex::new(Instant::now()) }
    }

    /// Says a text if the bar is hidden and the last line was long ago.
    pub fn say(&self, bar: &ProgressBar, text: impl FnOnce() -> String) {
        if bar.is_hidden() && self.is_due(Instant::now()) {
            say(&text());
        }
    }

    /// Says how many units the bar has counted, under the same conditions.
    pub fn count(&self, bar: &ProgressBar, unit: &str) {
        self.say(bar, || format!("{} of {} {unit}", bar.position(), bar.length().unwrap_or_default()));
    }

    /// Returns `true` once in each interval.
    fn is_due(&self, now: Instant) -> bool {
        let Ok(mut last) = self.last.lock() else { return false };
        let due = now.saturating_duration_since(*last) >= LINE_INTERVAL;
        if due {
            *last = now;
        }
        due
    }
}

/// Creates a bar with a template of indicatif.
pub fn bar(length: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Does something, and announces it on stderr once it has taken a second.
pub fn spinning<T>(name: &'static str, work: impl FnOnce() -> T) -> T {
    let _spinner = Spinner::start(name);
    work()
}

/// A guard that announces a step on stderr once it has taken a second: by a spinner on a terminal, otherwise by
/// one line. Drop it at the end of the step.
pub struct Spinner {
    done: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Spinner {
    /// Starts the time of the step `name`.
    pub fn start(name: &'static str) -> Self {
        let (done, ended) = channel::<()>();
        let wait = move || {
            if ended.recv_timeout(ANNOUNCE_AFTER) == Err(RecvTimeoutError::Timeout) {
                let bar = ProgressBar::new_spinner().with_message(name);
                bar.enable_steady_tick(Duration::from_millis(200));
                if bar.is_hidden() {
                    // Without a terminal one line, for a reader of a log.
                    say(name);
                }
                // Returns when the sender is dropped.
                let _ = ended.recv();
                bar.finish_and_clear();
            }
        };
        // Without the thread the step is not announced, and nothing else is lost.
        let thread = std::thread::Builder::new().name("spinner".into()).spawn(wait).ok();
        Self { done: Some(done), thread }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        drop(self.done.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Shows remarks and long steps on stderr.
pub struct Reporter;

impl Monitor for Reporter {
    fn remark(&self, text: &str) {
        say(text);
    }

    fn long_step(&self, name: &'static str) -> Option<Box<dyn Any>> {
        Some(Box::new(Spinner::start(name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_has_one_line_in_each_interval() {
        let lines = LogLines::new();
        let start = *lines.last.lock().unwrap();
        let due = |seconds: u64| lines.is_due(start + Duration::from_secs(seconds));
        assert_eq!([0, 29, 30, 31, 59, 60, 200, 201].map(due), [false, false, true, false, false, true, true, false]);
    }
}
