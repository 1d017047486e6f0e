//! A campaign of random flights: flights that nobody prepared, drawn from a seed.
//!
//! A flight is known by seed and number. Its text is a scenario file, so `hoverlock hover --scenario` repeats it.

mod draw;
mod flown;
mod shrink;
mod statistics;

use std::path::Path;

use hoverlock_reports::journal::Lock;
use hoverlock_reports::provenance::COMMIT;
use serde::Serialize;

pub use draw::{Ingredient, RandomFlight};
pub use flown::{FlownFlight, fly_random};
pub use shrink::{Shrunk, shrink};
pub use statistics::{Totals, by_group};

use super::local::{LongStepsOnly, fly_all};
use super::{CampaignError, table};
use crate::chain::FeatureSource;
use crate::monitor::{BoxError, Monitor};

/// The inputs of a campaign of random flights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomSettings {
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of flights; they are numbered from 1.
    pub flights: u32,
    /// Duration of each flight, s.
    pub seconds: f64,
    /// The source of the features.
    pub features: FeatureSource,
}

/// The progress of a campaign of random flights.
#[derive(Debug)]
pub enum RandomProgress<'a> {
    /// The table was read.
    Started {
        /// Number of flights that the table has.
        known: usize,
        /// Number of all flights.
        flights: usize,
    },
    /// A flight was flown and appended to the table.
    Flown(&'a FlownFlight),
}

/// A function that receives the progress. An error stops the campaign.
pub type ReportRandomProgress<'a> = &'a mut (dyn FnMut(RandomProgress<'_>) -> Result<(), BoxError> + Send);

/// The result of a campaign of random flights. Serialised, it is the JSON object of `hoverlock sweep --random`.
#[derive(Debug, Clone, Serialize)]
pub struct RandomOutcome {
    /// No flight has a misleading frame.
    pub pass: bool,
    /// The totals of all flights.
    pub totals: Totals,
    /// The flights in the order of their numbers.
    pub flights: Vec<FlownFlight>,
}

impl RandomOutcome {
    /// Returns the number of flights that were flown by another commit than that of this program.
    pub fn of_other_commits(&self) -> usize {
        self.flights.iter().filter(|flight| flight.commit != COMMIT).count()
    }
}

/// Draws the flights of a campaign.
pub fn draw_all(settings: &RandomSettings) -> Vec<RandomFlight> {
    let RandomSettings { seed, flights, seconds, .. } = *settings;
    (1..=flights).map(|number| RandomFlight::draw(seed, number, seconds)).collect()
}

/// Flies the flights that the table does not have, and appends each to it.
///
/// # Errors
/// The table cannot be read or written, another process is writing it, a flight fails, or `progress` stops the
/// campaign. The table keeps the flights that were finished.
pub fn fly_campaign(
    settings: &RandomSettings,
    table: &Path,
    monitor: &dyn Monitor,
    progress: ReportRandomProgress<'_>,
) -> Result<RandomOutcome, CampaignError> {
    let features = settings.features;
    let drawn: Vec<(String, RandomFlight)> = draw_all(settings)
        .into_iter()
        .map(|flight| (flown::key(flight.seed, flight.number, &flown::hash(&flight), features), flight))
        .collect();
    let key = |row: &FlownFlight| flown::key(row.seed, row.number, &row.scenario, row.features);
    let lock = Lock::new(table)?;
    let mut known = table::read(table, key)?;
    let left: Vec<RandomFlight> =
        drawn.iter().filter(|(key, _)| !known.contains_key(key)).map(|(_, flight)| flight.clone()).collect();
    if !left.is_empty() {
        lock.check_append()?;
    }
    progress(RandomProgress::Started { known: drawn.len() - left.len(), flights: drawn.len() })
        .map_err(CampaignError::Stopped)?;
    let mut keep = |flown: FlownFlight| -> Result<(), CampaignError> {
        table::append(table, &flown)?;
        progress(RandomProgress::Flown(&flown)).map_err(CampaignError::Stopped)?;
        known.insert(key(&flown), flown);
        Ok(())
    };
    fly_all(&left, |flight| fly_random(flight, features, &LongStepsOnly(monitor)), &mut keep)?;
    let flights: Vec<FlownFlight> = drawn.iter().filter_map(|(key, _)| known.remove(key)).collect();
    let totals = Totals::new(flights.iter());
    Ok(RandomOutcome { pass: totals.misleading_flights == 0, totals, flights })
}
