//! Flies on all cores of this machine.

use std::any::Any;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::CampaignError;
use crate::monitor::Monitor;

/// A monitor that forwards long steps, but not the frames of the many hovers.
pub(super) struct LongStepsOnly<'a>(pub(super) &'a dyn Monitor);

impl Monitor for LongStepsOnly<'_> {
    fn long_step(&self, name: &'static str) -> Option<Box<dyn Any>> {
        self.0.long_step(name)
    }
}

/// Flies points with `fly`, one per core at a time, and passes each result to `keep`. After an error no further point
/// is begun.
pub(super) fn fly_all<P: Sync, F>(
    points: &[P],
    fly: impl Fn(&P) -> Result<F, CampaignError> + Sync,
    keep: &mut (dyn FnMut(F) -> Result<(), CampaignError> + Send),
) -> Result<(), CampaignError> {
    let next = AtomicUsize::new(0);
    let has_failed = AtomicBool::new(false);
    let keep = Mutex::new(keep);
    let fly_next = || -> Result<(), CampaignError> {
        while let Some(point) = points.get(next.fetch_add(1, Ordering::Relaxed)) {
            if has_failed.load(Ordering::Relaxed) {
                break;
            }
            let flown = fly(point)?;
            let mut keep = keep.lock().map_err(|_| CampaignError::Panic)?;
            (*keep)(flown)?;
        }
        Ok(())
    };
    let work = || fly_next().inspect_err(|_| has_failed.store(true, Ordering::Relaxed));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores.min(points.len())).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| CampaignError::Panic)?)
    })
}
