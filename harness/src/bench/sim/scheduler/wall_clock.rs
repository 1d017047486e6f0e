//! Wall-clock limits: ends a run that takes too long, and a process that does not return to the scheduler.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::engine::time::Time;

/// A check of the wall clock every few milliseconds, without reading it in every time step.
pub(crate) struct WallClock {
    started: Instant,
    limit: Option<Duration>,
    last: Instant,
    countdown: u32,
    interval: u32,
    dog: Option<Watchdog>,
}

impl WallClock {
    pub fn new(limit: Option<Duration>, dog: Option<Watchdog>) -> WallClock {
        let now = Instant::now();
        WallClock { started: now, limit, last: now, countdown: 1, interval: 1, dog }
    }

    #[inline(always)]
    pub fn is_due(&mut self) -> bool {
        self.countdown -= 1;
        self.countdown == 0
    }

    /// Returns the limit in seconds if it is over. Stores the simulation time for the watchdog's message.
    pub fn check(&mut self, time: Time) -> Option<f64> {
        if let Some(dog) = &self.dog {
            dog.0.time.store(time.as_fs(), Ordering::Relaxed);
        }
        let now = Instant::now();
        let since = now - self.last;
        if since < Duration::from_millis(2) {
            self.interval = (self.interval * 2).min(1 << 16);
        } else if since > Duration::from_millis(20) {
            self.interval = (self.interval / 2).max(1);
        }
        self.last = now;
        self.countdown = self.interval;
        self.limit.filter(|limit| now - self.started > *limit).map(|limit| limit.as_secs_f64())
    }
}

/// Aborts the process when a run is far over its limit and has not returned to the scheduler, which would have ended
/// it: the Verilog loops without end within one evaluation, or a task loops without awaiting. Nothing inside the
/// process can end such a loop.
pub(crate) struct Watchdog(Arc<Watched>);

struct Watched {
    over: Mutex<bool>,
    changed: Condvar,
    /// Simulation time when the scheduler was last seen, in femtoseconds.
    time: AtomicU64,
}

impl Watchdog {
    /// Watches until it is dropped. `None` if no thread can be started.
    pub fn start(limit: Duration, top: &str) -> Option<Watchdog> {
        let watched = Arc::new(Watched { over: Mutex::new(false), changed: Condvar::new(), time: AtomicU64::new(0) });
        let (own, top) = (watched.clone(), top.to_owned());
        let watch = move || {
            // The scheduler and the Python side end the run with a better message: they get time for that.
            let patience = limit + limit / 4 + Duration::from_secs(2);
            let over = own.over.lock().unwrap_or_else(PoisonError::into_inner);
            let (over, _) =
                own.changed.wait_timeout_while(over, patience, |over| !*over).unwrap_or_else(PoisonError::into_inner);
            if !*over {
                eprintln!(
                    "hoverlock: the run of '{top}' exceeded its wall-clock limit of {} s; simulation time was {}: \
                     the Verilog loops without end within one evaluation, or a task loops without awaiting anything. \
                     Such a loop cannot be ended from inside: the process is aborted.",
                    limit.as_secs_f64(),
                    Time::fs(own.time.load(Ordering::Relaxed)),
                );
                std::process::abort();
            }
        };
        std::thread::Builder::new().name("watchdog".into()).stack_size(64 << 10).spawn(watch).ok()?;
        Some(Watchdog(watched))
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        *self.0.over.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.changed.notify_all();
    }
}
