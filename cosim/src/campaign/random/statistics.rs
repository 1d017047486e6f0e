//! Totals of random flights, of all and by ingredient.

use std::collections::BTreeMap;

use serde::Serialize;

use super::FlownFlight;
use super::flown::share;

/// Totals of some flights.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Totals {
    /// Number of flights.
    pub flights: usize,
    /// Number of flights with a misleading frame.
    pub misleading_flights: usize,
    /// Number of estimates.
    pub estimates: usize,
    /// Number of estimates whose error exceeds their protection level.
    pub misleading: usize,
    /// Number of estimates from a search that the work limit ended.
    pub late: usize,
    /// Share of the frames that show the ground which have an estimate; `None` without such frames.
    pub availability: Option<f64>,
    /// Mean normalised squared error over flights, 2 if the covariance is true; 0 without an estimate.
    pub nees: f64,
    /// Rms of estimate less truth over flights, m; 0 without an estimate.
    pub error_rms_m: f64,
    /// Largest ratio of error and protection level; 0 without an estimate.
    pub worst_ratio: f64,
}

impl Totals {
    /// Adds up flights.
    pub fn new<'a>(flights: impl Iterator<Item = &'a FlownFlight>) -> Self {
        let mut totals = Self::default();
        let (mut answered, mut in_view, mut with_estimate) = (0, 0, 0usize);
        for flight in flights {
            totals.flights += 1;
            totals.misleading_flights += usize::from(flight.misleading > 0);
            totals.misleading += flight.misleading;
            totals.late += flight.late;
            totals.estimates += flight.cells().map(|(_, _, frames)| frames).sum::<usize>();
            answered += flight.answered;
            in_view += flight.in_view;
            if let Some((nees, error)) = flight.nees.zip(flight.error_rms_m) {
                with_estimate += 1;
                totals.nees += nees;
                totals.error_rms_m += error * error;
            }
            totals.worst_ratio = totals.worst_ratio.max(flight.worst_ratio.unwrap_or_default());
        }
        let count = with_estimate.max(1) as f64;
        totals.nees /= count;
        totals.error_rms_m = (totals.error_rms_m / count).sqrt();
        totals.availability = share(answered, in_view);
        totals
    }
}

/// Returns the totals of each group of ingredients, in the order of the names.
pub fn by_group(flights: &[FlownFlight]) -> Vec<(String, Totals)> {
    let mut groups: BTreeMap<String, Vec<&FlownFlight>> = BTreeMap::new();
    for flight in flights {
        for group in flight.groups() {
            groups.entry(group).or_default().push(flight);
        }
    }
    groups.into_iter().map(|(group, flights)| (group, Totals::new(flights.into_iter()))).collect()
}
