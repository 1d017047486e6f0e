//! The search for the cheapest design that keeps a simulated helicopter within a budget of centimetres.
//!
//! The bounds of the report are those of features; the mission is to stay where one is. This search judges a design by
//! closed-loop flights alone, and says beside it what the checks of the report say, so that a reader sees which of the
//! two bounds forbids a design.
//!
//! It is a successive halving over flights ([`Plan`]): many designs on one short flight, the cheapest survivors on
//! longer ones over all scenes, the last few on long ones. A design that fails a flight is out. One that has passed is
//! called the best only after at least [`CONFIRMING`] more flights, whose seeds no other round has: the survivors of
//! few flights are those that the gusts of these flights favour. Which designs are flown is chosen in three stages:
//!
//! 1. [`Stage::Alone`]: each value of each key, all others as in the base design.
//! 2. [`Stage::Together`]: combinations of values. Their distances are predicted from those of stage 1, and those
//!    combinations are flown than which no other is both cheaper and predicted closer. A prediction chooses what is
//!    flown; it never decides who passes.
//! 3. [`Stage::Step`]: every design that differs from the best one in one key and is cheaper, until none passes.
//!
//! So the best design is the cheapest of its neighbourhood, and not proved the cheapest of the space.
//!
//! Flights come in through a function, so this crate knows nothing of the simulator.

pub mod output;
mod page;
mod search;
mod space;

use std::collections::HashMap;
use std::time::Instant;

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::analysis::resources::Resources;
use hoverlock_reports::check_outcome::CheckOutcome;
use hoverlock_reports::study::{Subject, Unfit};
use serde::{Deserialize, Serialize};

pub use search::run;

use crate::measure::PartOutcome;
use crate::results::KnownResults;
use crate::space::Unbuildable;

/// A scene to fly over.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Scene {
    /// Name or file.
    pub name: String,
    /// Hash of its content. Results over another content are not reused.
    pub hash: String,
}

/// A flight.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Flight {
    /// Name or file of the scene.
    pub scene: String,
    /// Seed of wind, sensors, camera and scene.
    pub seed: u64,
    /// Duration, s.
    pub seconds: f64,
}

/// What a flight has shown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FlightResult {
    /// Rms distance from the target, m.
    pub rms_m: f64,
    /// Rms of estimate less truth, m; `None` without an estimate.
    pub error_rms_m: Option<f64>,
    /// Number of estimates.
    pub estimates: usize,
    /// Number of estimates whose error exceeds their protection level.
    pub misleading: usize,
    /// Longest time without an estimate, s.
    pub longest_loss_s: f64,
    /// Largest roll or pitch, degrees.
    pub tilt_max_deg: f64,
}

/// The bounds of the mission, which every flight must keep.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Budget {
    /// Largest rms distance from the target, m.
    pub rms_m: f64,
    /// Longest time without an estimate, s.
    pub max_loss_s: f64,
    /// Largest roll or pitch, degrees.
    pub max_tilt_deg: f64,
}

impl Budget {
    /// Returns what a flight does not keep, in words; `None` if it keeps all.
    pub fn failure(&self, flown: &FlightResult) -> Option<String> {
        let FlightResult { rms_m, misleading, longest_loss_s, tilt_max_deg, .. } = *flown;
        let mut failures = Vec::new();
        if flown.estimates == 0 {
            failures.push("no estimate".to_owned());
        }
        // Written so that a distance that is no number fails.
        if !matches!(rms_m.partial_cmp(&self.rms_m), Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal)) {
            failures.push(format!("{:.1} cm rms from the target", 100.0 * rms_m));
        }
        if misleading > 0 {
            failures.push(format!("{misleading} estimates beyond their protection level"));
        }
        if longest_loss_s > self.max_loss_s {
            failures.push(format!("vision lost for {longest_loss_s:.1} s"));
        }
        if tilt_max_deg > self.max_tilt_deg {
            failures.push(format!("{tilt_max_deg:.1} degrees of roll or pitch"));
        }
        (!failures.is_empty()).then(|| failures.join(", "))
    }
}

/// The flights of a search, in rounds. A design is flown on a round only after it has passed those before.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// The rounds: one short flight, longer flights over all scenes, long flights over all scenes and seeds, and those
    /// that confirm the best design.
    pub rounds: Vec<Vec<Flight>>,
}

/// Shortest flight, s.
const MIN_SECONDS: f64 = 1.0;
/// Least number of flights that confirm the best design.
pub const CONFIRMING: u64 = 20;

impl Plan {
    /// Plans flights of at most `seconds` over scenes. No seed occurs in two rounds: `seed` is that of the first, and
    /// the third has `seeds` of them. The first round flies over `first`.
    pub fn new(scenes: &[Scene], first: &str, seed: u64, seeds: u64, seconds: f64) -> Self {
        let over_all = |seed: u64, seconds: f64| {
            let flight = move |scene: &Scene| Flight { scene: scene.name.clone(), seed, seconds };
            scenes.iter().map(flight)
        };
        let part = |parts: f64| (seconds / parts).max(MIN_SECONDS);
        let short = Flight { scene: first.into(), seed, seconds: part(4.0) };
        let long = |seeds: std::ops::Range<u64>| seeds.flat_map(|more| over_all(seed + 2 + more, seconds)).collect();
        let confirming = CONFIRMING.div_ceil(scenes.len().max(1) as u64);
        let rounds = vec![vec![short], over_all(seed + 1, part(2.0)).collect(), long(0..seeds)];
        Self { rounds: rounds.into_iter().chain([long(seeds..seeds + confirming)]).collect() }
    }

    /// Returns all flights with the number of their round.
    pub(crate) fn flights(&self) -> Vec<(usize, Flight)> {
        let rounds = self.rounds.iter().enumerate();
        rounds.flat_map(|(round, flights)| flights.iter().map(move |flight| (round, flight.clone()))).collect()
    }
}

/// A function that flies a design.
pub type Fly<'a, E> = &'a (dyn Fn(&DesignPoint, &Flight) -> Result<FlightResult, E> + Sync);

/// The inputs of a search.
pub struct MissionTask<'a, E> {
    /// The design whose keys are changed.
    pub base: &'a DesignPoint,
    /// What every flight must keep.
    pub budget: Budget,
    /// The scenes.
    pub scenes: &'a [Scene],
    /// Seed of the first round; the others use those that follow.
    pub seed: u64,
    /// Number of seeds in the third round.
    pub seeds: u64,
    /// Duration of a flight of the third and the last round, s.
    pub seconds: f64,
    /// A frame of each scene, on which the checks of the report are measured.
    pub subjects: &'a [Subject],
    /// Time at which the search stops.
    pub deadline: Instant,
    /// Name of the device, and the ALM, M10K and DSP blocks that a design may use.
    pub device: (&'a str, [u64; 3]),
    /// Returns the reason why a design cannot be built.
    pub unbuildable: Unbuildable<'a>,
    /// Version of the program. Results of another version are not reused.
    pub build: &'a str,
    /// Flies a design.
    pub fly: Fly<'a, E>,
}

/// The results of earlier searches, by the hash of everything they depend on.
#[derive(Debug, Default, Clone)]
pub struct Known {
    /// Results of flights.
    pub flights: HashMap<String, FlightResult>,
    /// Checks of the report.
    pub parts: KnownResults,
}

/// A new result, to be kept for later searches.
#[derive(Debug)]
pub enum Measured<'a> {
    /// A flight.
    Flight(&'a FlightResult),
    /// Checks of the report.
    Part(&'a PartOutcome),
}

/// The stage in which a design was chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// The design whose keys are changed.
    Base,
    /// One key is changed, and the DoG is shortened if the design cannot be built otherwise.
    Alone,
    /// A combination of values.
    Together,
    /// One key of the best design is changed.
    Step,
}

/// What flights have shown of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Flown {
    /// Every flight of the plan keeps the budget.
    Keeps,
    /// A flight does not.
    Fails,
    /// Every flight so far keeps the budget, and others have not been flown.
    Open,
}

/// The checks of the report on a design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Features {
    /// Every check passes.
    pub pass: bool,
    /// The first check that fails; the one closest to its limit if all pass.
    pub check: CheckOutcome,
}

/// A design after the search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissionPoint {
    /// Differences from the base design in the syntax of `--config`; `base` for the base.
    pub name: String,
    /// The design itself.
    pub design: DesignPoint,
    /// Resources by the memory model.
    #[serde(flatten)]
    pub resources: Resources,
    /// The design fits the device.
    pub fits: bool,
    /// The stage in which it was chosen.
    pub stage: Stage,
    /// What the flights have shown.
    pub status: Flown,
    /// Number of flights.
    pub flights: usize,
    /// Rms distance from the target on the short flight of the first round, cm.
    pub short_cm: Option<f64>,
    /// Largest rms distance from the target of a flight, cm.
    pub worst_cm: Option<f64>,
    /// Largest rms of estimate less truth of a flight, cm.
    pub error_cm: Option<f64>,
    /// The flight that fails, and what it does not keep.
    pub failure: Option<String>,
    /// The checks of the report; `None` if they were not measured, or if no frame is fit to judge the design.
    pub features: Option<Features>,
}

/// The bound that forbids designs which the other one allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Binding {
    /// The best design of the mission fails a check of the report.
    Features,
    /// It passes these checks; what is cheaper fails a flight.
    Mission,
}

/// Number of designs by the verdicts of both bounds. Designs that were not flown on all flights count by those flown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Verdicts {
    /// Keep the budget and pass the checks of the report.
    pub both: usize,
    /// Keep the budget only.
    pub mission_only: usize,
    /// Pass the checks of the report only.
    pub features_only: usize,
    /// Keep neither bound.
    pub neither: usize,
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mission {
    /// A design keeps the budget on every flight.
    pub pass: bool,
    /// Every cheaper design that differs from the best one in one key was flown and fails.
    pub decided: bool,
    /// The bounds of the mission.
    pub budget: Budget,
    /// The flights.
    pub plan: Plan,
    /// Scenes and their hashes.
    pub scenes: Vec<Scene>,
    /// Name of the device.
    pub device: String,
    /// Number of flights of this search.
    pub flown: usize,
    /// Number of flights that an earlier search had flown.
    pub restored: usize,
    /// Number of designs in the combinations of values of stage 2.
    pub combinations: usize,
    /// Index of the best design in `points`; `None` if no design keeps the budget.
    #[serde(skip)]
    pub best: Option<usize>,
    /// The bound that forbids what the other one allows; `None` without a best design, or if neither is known to.
    pub binding: Option<Binding>,
    /// Index of the cheapest design flown that keeps the budget as far as it was flown and passes the checks of the
    /// report.
    #[serde(skip)]
    pub best_of_both: Option<usize>,
    /// Numbers of designs by both verdicts.
    pub verdicts: Verdicts,
    /// Frames by which the checks of the report cannot be judged. Part of no verdict.
    pub unfit: Vec<Unfit>,
    /// All designs that were flown, the base first.
    pub points: Vec<MissionPoint>,
}

impl Mission {
    /// Returns the best design; `None` if no design keeps the budget.
    pub fn best(&self) -> Option<&MissionPoint> {
        self.points.get(self.best?)
    }

    /// Returns the design whose keys were changed.
    pub fn base(&self) -> Option<&MissionPoint> {
        self.points.first()
    }

    /// Returns the cheapest design that both bounds allow, as far as it was flown.
    pub fn best_of_both(&self) -> Option<&MissionPoint> {
        self.points.get(self.best_of_both?)
    }

    /// Returns which bound is binding, in words without a full stop; `None` if that is not known.
    pub fn binding_in_words(&self) -> Option<String> {
        let best = self.best()?;
        let checks = best.features.as_ref()?;
        let check = |of: &CheckOutcome| match (of.measured, of.limit) {
            (Some(measured), Some(limit)) => {
                let unit = if of.unit.is_empty() { String::new() } else { format!(" {}", of.unit) };
                format!("{} {measured:.3}{unit}, limit {limit}{unit} ({})", of.check, of.place)
            }
            _ => format!("{} ({})", of.check, of.place),
        };
        Some(match self.binding? {
            Binding::Features => {
                let both = self.best_of_both().map_or_else(String::new, |both| {
                    format!(
                        "; the cheapest design flown that passes both has {} M10K ({})",
                        both.resources.m10k, both.name
                    )
                });
                format!(
                    "The bound of the features binds: the best design keeps the budget and fails the report's check \
                     {}{both}",
                    check(&checks.check)
                )
            }
            Binding::Mission => format!(
                "The bound of the mission binds: the best design passes the report's checks too, {} being closest",
                check(&checks.check)
            ),
        })
    }
}

/// The progress of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct MissionProgress {
    /// Number of flights so far.
    pub flights: usize,
    /// What begins.
    pub step: String,
    /// Name and M10K of the best design so far.
    pub best: Option<(String, u64)>,
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUDGET: Budget = Budget { rms_m: 0.1, max_loss_s: 1.0, max_tilt_deg: 5.0 };
    const GOOD: FlightResult = FlightResult {
        rms_m: 0.1,
        error_rms_m: Some(0.02),
        estimates: 100,
        misleading: 0,
        longest_loss_s: 1.0,
        tilt_max_deg: 5.0,
    };

    #[test]
    fn each_bound_of_the_budget_fails_a_flight_alone() {
        assert_eq!(BUDGET.failure(&GOOD), None);
        let cases = [
            (FlightResult { rms_m: 0.1004, ..GOOD }, "10.0 cm rms"),
            (FlightResult { rms_m: f64::NAN, ..GOOD }, "NaN cm rms"),
            (FlightResult { misleading: 1, ..GOOD }, "1 estimates beyond"),
            (FlightResult { longest_loss_s: 1.1, ..GOOD }, "lost for 1.1 s"),
            (FlightResult { tilt_max_deg: 5.1, ..GOOD }, "5.1 degrees"),
            (FlightResult { estimates: 0, ..GOOD }, "no estimate"),
        ];
        for (flown, text) in cases {
            let failure = BUDGET.failure(&flown).unwrap();
            assert!(failure.contains(text) && !failure.contains(", "), "{failure}");
        }
    }

    #[test]
    fn rounds_have_more_and_longer_flights_and_no_seed_twice() {
        let scenes = ["field", "town"].map(|name| Scene { name: name.into(), hash: String::new() });
        let plan = Plan::new(&scenes, "town", 5, 2, 12.0);
        let of =
            |round: usize| plan.rounds[round].iter().map(|f| (f.scene.as_str(), f.seed, f.seconds)).collect::<Vec<_>>();
        assert_eq!(of(0), [("town", 5, 3.0)]);
        assert_eq!(of(1), [("field", 6, 6.0), ("town", 6, 6.0)]);
        assert_eq!(of(2), [("field", 7, 12.0), ("town", 7, 12.0), ("field", 8, 12.0), ("town", 8, 12.0)]);
        let confirming = of(3);
        assert!(confirming.len() == 20 && confirming.iter().all(|(_, seed, s)| (9..19).contains(seed) && *s == 12.0));
    }
}
