//! One random flight after its hover: a row of the table.

use std::collections::BTreeMap;
use std::path::Path;

use hoverlock_reports::provenance::{COMMIT, sha256};
use serde::{Deserialize, Serialize};

use super::RandomFlight;
use crate::campaign::CampaignError;
use crate::chain::FeatureSource;
use crate::hover::{HoverOutcome, HoverSettings, hover};
use crate::monitor::{BoxError, Monitor};

/// Smallest error and protection level with a cell of its own in the table, m.
const MIN_CELL_M: f64 = 1e-3;
/// Cells of the table for a factor of ten.
const CELLS_PER_DECADE: f64 = 10.0;

/// A random flight that has been flown: a row of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlownFlight {
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the flight.
    pub number: u32,
    /// Duration, s.
    pub seconds: f64,
    /// Hash of the scenario, hexadecimal. A flight that is drawn in another way is another one.
    pub scenario: String,
    /// The source of the features.
    pub features: FeatureSource,
    /// Commit of the program that flew it.
    pub commit: String,
    /// Rms distance from the target, m.
    pub rms_m: f64,
    /// Largest distance from the target, m.
    pub max_m: f64,
    /// Rms of estimate less truth, m; `None` without an estimate.
    pub error_rms_m: Option<f64>,
    /// Largest error of an estimate, m; `None` without an estimate.
    pub error_max_m: Option<f64>,
    /// Number of frames.
    pub frames: usize,
    /// Number of frames that show the ground, from the first with an estimate on.
    pub in_view: usize,
    /// Number of those with an estimate.
    pub answered: usize,
    /// Number of estimates from a search that the work limit ended.
    pub late: usize,
    /// Number of frames whose error exceeds the protection level.
    pub misleading: usize,
    /// Time of the first such frame, s.
    pub misleading_at_s: Option<f64>,
    /// Largest ratio of error and protection level; `None` without an estimate.
    pub worst_ratio: Option<f64>,
    /// Mean normalised squared error, 2 if the covariance is true; `None` without an estimate.
    pub nees: Option<f64>,
    /// Median of the protection level, m; `None` without an estimate.
    pub protection_level_m: Option<f64>,
    /// Number of frames by error and protection level, as `error:level:frames` separated by spaces. Cell `i` begins at
    /// `0.001 * 10^(i / 10)` m.
    pub cells: String,
    /// The ingredients as `kind=value`, separated by spaces.
    pub ingredients: String,
}

/// Returns the hash of a scenario.
pub(super) fn hash(flight: &RandomFlight) -> String {
    let mut digest = sha256(flight.scenario());
    digest.truncate(8);
    digest
}

/// Returns the key of a flight in the table.
pub(super) fn key(seed: u64, number: u32, scenario: &str, features: FeatureSource) -> String {
    format!("{seed}|{number}|{scenario}|{features}")
}

/// Flies a random flight. Equal flights give equal results on every machine.
///
/// # Errors
/// The scenario is invalid, the hover fails, or the monitor stops it.
pub fn fly_random(
    flight: &RandomFlight,
    features: FeatureSource,
    monitor: &dyn Monitor,
) -> Result<FlownFlight, CampaignError> {
    let failed = |source: BoxError| CampaignError::Flight { seed: flight.seed, number: flight.number, source };
    let mut settings = HoverSettings { features, ..HoverSettings::default() };
    let path = format!("{}-{}.toml", flight.seed, flight.number);
    settings.apply_scenario(&flight.scenario(), Path::new(&path)).map_err(|error| failed(error.into()))?;
    let outcome = hover(&settings, monitor).map_err(|error| failed(error.into()))?;
    Ok(FlownFlight::new(flight, features, &outcome))
}

impl FlownFlight {
    fn new(flight: &RandomFlight, features: FeatureSource, outcome: &HoverOutcome) -> Self {
        let rows = &outcome.rows;
        let mut errors = Vec::new();
        let mut levels = Vec::new();
        for row in rows {
            if let Some((error, level)) = row.error().zip(row.line.protection_level_m) {
                errors.push(error.norm());
                levels.push(level);
            }
        }
        let largest = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::max);
        let (answered, in_view) = outcome.answered();
        let mut cells: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for (error, level) in errors.iter().zip(&levels) {
            *cells.entry((cell(*error), cell(*level))).or_default() += 1;
        }
        let cells: Vec<String> = cells.iter().map(|((error, level), n)| format!("{error}:{level}:{n}")).collect();
        let worst_ratio = largest(&mut errors.iter().zip(&levels).map(|(error, level)| error / level));
        levels.sort_by(f64::total_cmp);
        Self {
            seed: flight.seed,
            number: flight.number,
            seconds: flight.seconds,
            scenario: hash(flight),
            features,
            commit: COMMIT.to_owned(),
            rms_m: outcome.summary.rms_m,
            max_m: outcome.summary.max_m,
            error_rms_m: outcome.summary.error_rms_m,
            error_max_m: largest(&mut errors.iter().copied()),
            frames: rows.len(),
            in_view,
            answered,
            late: rows.iter().filter(|row| row.line.status == "late").count(),
            misleading: outcome.summary.misleading,
            misleading_at_s: rows.iter().find(|row| row.is_misleading()).map(|row| row.truth.time),
            worst_ratio,
            nees: outcome.nees(),
            protection_level_m: levels.get(levels.len() / 2).copied(),
            cells: cells.join(" "),
            ingredients: flight.described(),
        }
    }

    /// Returns the share of the frames that show the ground which have an estimate; `None` if no frame shows it.
    pub fn availability(&self) -> Option<f64> {
        share(self.answered, self.in_view)
    }

    /// Returns error (m), protection level (m), each the middle of its cell, and number of frames. Cells that cannot be
    /// read are left out.
    pub fn cells(&self) -> impl Iterator<Item = (f64, f64, usize)> {
        let middle = |index: f64| MIN_CELL_M * 10f64.powf((index + 0.5) / CELLS_PER_DECADE);
        self.cells.split(' ').filter_map(move |cell| {
            let mut parts = cell.split(':').map(|part| part.parse::<usize>().ok());
            let [error, level, frames] = [parts.next()??, parts.next()??, parts.next()??];
            Some((middle(error as f64), middle(level as f64), frames))
        })
    }

    /// Returns the groups to which the flight belongs, one for each ingredient.
    pub fn groups(&self) -> impl Iterator<Item = String> {
        self.ingredients.split(' ').filter_map(|one| one.split_once('=')).map(|(kind, value)| group(kind, value))
    }
}

/// Returns the group of an ingredient: its kind, with the range of the value for those that every flight has.
fn group(kind: &str, value: &str) -> String {
    let number: f64 = value.parse().unwrap_or_default();
    let range = |limits: [f64; 2], unit: &str| {
        let [low, high] = limits;
        match number {
            _ if number < low => format!("{kind} below {low} {unit}"),
            _ if number < high => format!("{kind} {low} to {high} {unit}"),
            _ => format!("{kind} from {high} {unit}"),
        }
    };
    match kind {
        "ground" | "climb" => format!("{kind} {value}"),
        "height" => range([30.0, 90.0], "m"),
        "sun" => range([15.0, 40.0], "degrees"),
        "gusts" => range([1.5, 3.5], "m/s"),
        _ => kind.to_owned(),
    }
}

/// Returns the share of the frames that show the ground which have an estimate; `None` if no frame shows it.
pub(super) fn share(answered: usize, in_view: usize) -> Option<f64> {
    (in_view > 0).then(|| answered as f64 / in_view as f64)
}

/// Returns the cell of an error or a protection level (m).
fn cell(value: f64) -> usize {
    (CELLS_PER_DECADE * (value.max(MIN_CELL_M) / MIN_CELL_M).log10()) as usize
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::campaign::random::{RandomOutcome, Totals, by_group};
    use crate::campaign::table::{from_row, to_row};

    /// Returns a flight of 10 frames in view with 9 estimates, `misleading` of which are beyond the protection level.
    pub(crate) fn flown(number: u32, misleading: usize) -> FlownFlight {
        FlownFlight {
            seed: 1,
            number,
            seconds: 20.0,
            scenario: "0123abcd".into(),
            features: FeatureSource::Fixed,
            commit: "0123456789ab".into(),
            rms_m: 0.1,
            max_m: 0.2,
            error_rms_m: Some(0.03),
            error_max_m: Some(0.04),
            frames: 12,
            in_view: 10,
            answered: 9,
            late: 0,
            misleading,
            misleading_at_s: (misleading > 0).then_some(3.0),
            worst_ratio: Some(0.5),
            nees: Some(1.5),
            protection_level_m: Some(0.08),
            cells: "14:19:5 15:19:4".into(),
            ingredients: "height=18 ground=town sun=8 black=0.30".into(),
        }
    }

    #[test]
    fn a_row_is_read_back_as_it_was_written() {
        for row in [flown(1, 0), FlownFlight { worst_ratio: None, cells: String::new(), ..flown(2, 1) }] {
            assert_eq!(from_row::<FlownFlight>(&to_row(&row).unwrap()).unwrap(), row);
        }
    }

    #[test]
    fn cells_and_groups_are_those_of_the_values() {
        let row = flown(1, 0);
        let [first, _] = row.cells().collect::<Vec<_>>()[..] else { panic!() };
        assert!((0.025..0.032).contains(&first.0) && (0.079..0.1).contains(&first.1) && first.2 == 5);
        assert_eq!((cell(0.0), cell(0.00101), cell(0.03)), (0, 0, 14));
        let groups: Vec<String> = row.groups().collect();
        assert_eq!(groups, ["height below 30 m", "ground town", "sun below 15 degrees", "black"]);
    }

    #[test]
    fn totals_count_flights_and_the_page_names_the_misleading_ones() {
        let flights = vec![flown(1, 0), flown(2, 3)];
        let totals = Totals::new(flights.iter());
        assert_eq!((totals.flights, totals.misleading_flights, totals.misleading, totals.estimates), (2, 1, 3, 18));
        assert!(totals.availability == Some(0.9) && (totals.error_rms_m - 0.03).abs() < 1e-12);
        assert_eq!(by_group(&flights).iter().map(|(_, totals)| totals.flights).collect::<Vec<_>>(), [2; 4]);
        let outcome = RandomOutcome { pass: false, totals, flights };
        let page = outcome.page("hoverlock <sweep>").unwrap();
        assert!(page.contains("1 of 2 flights") && page.contains("hoverlock &lt;sweep&gt;") && page.contains("FAIL"));
    }

    #[test]
    fn a_flight_over_water_has_no_availability() {
        let water = FlownFlight { in_view: 0, answered: 0, ingredients: "ground=water".into(), ..flown(1, 0) };
        assert_eq!(water.availability(), None);
        assert_eq!(Totals::new([&water, &flown(2, 0)].into_iter()).availability, Some(0.9));
        let totals = Totals::new([&water].into_iter());
        assert_eq!(totals.availability, None);
        let page = RandomOutcome { pass: true, totals, flights: vec![water] }.page("hoverlock sweep").unwrap();
        assert!(page.contains("<b>-</b>") && page.contains("<td class=\"n\">-</td>"), "{page}");
    }
}
