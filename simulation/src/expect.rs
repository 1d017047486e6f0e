//! The expected values of the frames in order: planes, records, and the thresholds that follow the responses.

use std::{
    collections::VecDeque,
    sync::{Arc, mpsc::Receiver},
};

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::bit_true::{BitTrue, Planes};
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_fixed_point::model::record_limit::RecordLimit;
use hoverlock_fixed_point::model::threshold::{Maxima, ThresholdController};

use crate::job::Job;

/// The expected planes, records and thresholds of a frame.
#[derive(Debug)]
pub(super) struct Expected {
    pub planes: Arc<Planes>,
    /// The features that the record limit lets through.
    pub records: Vec<FeatureRecord>,
    /// The number of those that it does not.
    pub withheld: usize,
    pub thresholds: Vec<u32>,
}

/// An iterator over the expected values of all frames, in their order.
pub(super) struct Expectation<'a> {
    model: BitTrue,
    jobs: &'a [Job],
    next: usize,
    /// The planes of the frame before, which the next one shares if it is the same picture.
    planes: Option<Arc<Planes>>,
    /// Thresholds and maxima of the frame before, if it was in automatic mode.
    follows: Option<(Vec<u32>, Vec<Maxima>)>,
}

impl<'a> Expectation<'a> {
    pub fn new(design: &DesignPoint, jobs: &'a [Job]) -> Result<Self, CoefficientError> {
        Ok(Self { model: BitTrue::new(design)?, jobs, next: 0, planes: None, follows: None })
    }

    fn thresholds(&self, job: &Job) -> Vec<u32> {
        let (Some(target), Some((thresholds, maxima))) = (job.automatic, &self.follows) else {
            return job.thresholds.iter().map(|threshold| (*threshold).max(1)).collect();
        };
        let mut design = self.model.design().clone();
        design.threshold.target = target;
        let mut control = ThresholdController::resumed(&design, thresholds);
        control.finish_frame(maxima);
        control.thresholds().to_vec()
    }

    fn planes(&self, job: &Job) -> Planes {
        self.model.with_coefficients(&job.coefficients).planes(&job.completed())
    }
}

impl Iterator for Expectation<'_> {
    type Item = Expected;

    fn next(&mut self) -> Option<Expected> {
        let job = self.jobs.get(self.next)?;
        let same = |other: &Job| {
            (&other.pixels, &other.coefficients, other.fault) == (&job.pixels, &job.coefficients, job.fault)
        };
        let before = self.next.checked_sub(1).map(|before| &self.jobs[before]);
        let shared = self.planes.take().filter(|_| before.is_some_and(same));
        let planes = shared.unwrap_or_else(|| Arc::new(self.planes(job)));
        let thresholds = self.thresholds(job);
        let features = planes.features(&thresholds);
        let (max, height) = (self.model.design().max_dog(), job.pixels.height());
        let records = RecordLimit::sent(job.record_limit, &thresholds, max, height, &features);
        let withheld = features.len() - records.len();
        let follows = || (thresholds.clone(), planes.maxima());
        self.follows = job.automatic.filter(|_| !job.is_lost()).map(|_| follows());
        self.planes = Some(planes.clone());
        self.next += 1;
        Some(Expected { planes, records, withheld, thresholds })
    }
}

/// The expected values as they come from the thread that computes them. Frames that are done are dropped.
pub(super) struct Oracle {
    coming: Receiver<Expected>,
    known: VecDeque<Arc<Expected>>,
    first: usize,
}

impl Oracle {
    pub fn new(coming: Receiver<Expected>) -> Self {
        Self { coming, known: VecDeque::new(), first: 0 }
    }

    /// Returns the expected values of a frame, waiting for them if need be. `None` if there is no such frame, or it was
    /// dropped.
    pub fn frame(&mut self, frame: usize) -> Option<Arc<Expected>> {
        let at = frame.checked_sub(self.first)?;
        while self.known.len() <= at {
            self.known.push_back(Arc::new(self.coming.recv().ok()?));
        }
        self.known.get(at).cloned()
    }

    /// Drops the frames before this one.
    pub fn forget(&mut self, frame: usize) {
        while self.first < frame && self.known.pop_front().is_some() {
            self.first += 1;
        }
    }
}
