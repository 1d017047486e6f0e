//! Progress on stderr.

use std::any::Any;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use hoverlock_cosim::Monitor;
use indicatif::{ProgressBar, ProgressStyle};

use crate::output::say;

/// Time after which a long step is announced.
const ANNOUNCE_AFTER: Duration = Duration::from_secs(1);

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
