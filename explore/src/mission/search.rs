//! The search: successive halving over the rounds of the plan.

use std::time::Instant;

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_reports::study::Unfit;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::space::{self, Change};
use super::{
    Binding, Features, Flight, FlightResult, Flown, Known, Measured, Mission, MissionPoint, MissionProgress,
    MissionTask, Plan, Stage, Verdicts,
};
use crate::measure::{Bench, Part, PartOutcome};
use crate::space::Candidate;

/// Number of flights at a time.
const BATCH: usize = 4;
/// Number of designs that are flown on each round before the cheapest survivors go on to the next.
const WIDTHS: [usize; 4] = [8, 4, 2, 1];
/// Number of combinations that are flown.
const TOGETHER: usize = 24;
/// A value that flies no further from the target than this multiple of the budget, and fails nothing else, is combined
/// with others all the same: the distance does not rise steadily with shorter words.
const NEAR: f64 = 1.25;

/// A function that keeps a new result under its key.
type Keep<'a, E> = &'a mut dyn FnMut(&str, Measured<'_>) -> Result<(), E>;

/// Searches for the cheapest design that keeps the budget. `known` has the results of earlier searches. `keep` receives
/// the key and each new result, `report` the progress.
///
/// # Errors
/// The base design has no valid coefficients, a flight cannot be flown, or `keep` fails.
pub fn run<E: From<CoefficientError> + Send>(
    task: &MissionTask<E>,
    known: &Known,
    keep: Keep<E>,
    report: &dyn Fn(&MissionProgress),
) -> Result<Mission, E> {
    Levels::new(task.base)?;
    let first = task.scenes.first().map_or("", |scene| &scene.name);
    let mut search = Search {
        task,
        known,
        keep,
        report,
        flights: Vec::new(),
        plan: Plan::new(task.scenes, first, task.seed, task.seeds, task.seconds),
        designs: vec![Design::new(task.base.clone(), task.base, Stage::Base)],
        best: None,
        flown: 0,
        restored: 0,
        combinations: 0,
        decided: false,
    };
    search.flights = search.plan.flights();
    search.designs[0].results = vec![None; search.flights.len()];
    search.search()?;
    search.result()
}

/// A design of the search.
struct Design {
    candidate: Candidate,
    stage: Stage,
    cost: [u64; 3],
    /// The result of each flight; `None` if it was not flown.
    results: Vec<Option<FlightResult>>,
}

impl Design {
    fn new(design: DesignPoint, base: &DesignPoint, stage: Stage) -> Self {
        Self { cost: space::cost(&design), candidate: Candidate::new(design, base), stage, results: Vec::new() }
    }
}

/// A search in progress.
struct Search<'a, E> {
    task: &'a MissionTask<'a, E>,
    known: &'a Known,
    keep: Keep<'a, E>,
    report: &'a dyn Fn(&MissionProgress),
    plan: Plan,
    /// The flights of the plan with their rounds.
    flights: Vec<(usize, Flight)>,
    /// The designs, the base first.
    designs: Vec<Design>,
    best: Option<usize>,
    flown: usize,
    restored: usize,
    combinations: usize,
    decided: bool,
}

impl<E: From<CoefficientError> + Send> Search<'_, E> {
    fn search(&mut self) -> Result<(), E> {
        // The base is flown on everything, whatever the deadline. Where it is furthest from its target is where short
        // words show first.
        for round in [1, 2] {
            self.fly(&[0], round, true)?;
        }
        let round = |index: &usize| self.flights[*index].0 == 1;
        let base_m = |index: usize| self.designs[0].results[index].map_or(f64::INFINITY, |flown| flown.rms_m);
        let worst = (0..self.flights.len()).filter(round).max_by(|&a, &b| base_m(a).total_cmp(&base_m(b)));
        let first = worst.map_or(String::new(), |index| self.flights[index].1.scene.clone());
        self.plan = Plan::new(self.task.scenes, &first, self.task.seed, self.task.seeds, self.task.seconds);
        self.flights = self.plan.flights();
        for round in [0, 3] {
            self.fly(&[0], round, true)?;
            // Where the base fails, words cannot be judged: what passes there passes by chance.
            if self.failure(0).is_some() {
                self.decided = true;
                return Ok(());
            }
        }
        self.best = Some(0);
        let alone = self.fly_alone()?;
        if self.is_late() {
            return Ok(());
        }
        self.fly_together(&alone)?;
        self.settle()?;
        while !self.is_late() {
            let best = self.best.unwrap_or(0);
            let steps = space::steps(&self.designs[best].candidate.design, self.task.unbuildable);
            self.add(steps, Stage::Step);
            self.settle()?;
            if self.best.unwrap_or(0) == best {
                self.decided = !self.is_late();
                break;
            }
        }
        Ok(())
    }

    fn is_late(&self) -> bool {
        Instant::now() >= self.task.deadline
    }

    /// Adds designs that are not there yet, and returns the indices of all. Those without valid coefficients are left
    /// out.
    fn add(&mut self, designs: Vec<DesignPoint>, stage: Stage) -> Vec<usize> {
        let mut indices = Vec::new();
        for design in designs.into_iter().filter(|design| Levels::new(design).is_ok()) {
            let known = self.designs.iter().position(|other| other.candidate.design == design);
            indices.push(known.unwrap_or(self.designs.len()));
            if known.is_none() {
                let results = vec![None; self.flights.len()];
                self.designs.push(Design { results, ..Design::new(design, self.task.base, stage) });
            }
        }
        indices
    }

    /// Flies each value alone on the first round. Returns, for each key, the values that can be combined, and their
    /// distances in cm.
    fn fly_alone(&mut self) -> Result<Vec<Vec<(Change, f64)>>, E> {
        let mut keys: Vec<Vec<(Change, usize)>> = Vec::new();
        for values in space::values(self.task.base) {
            let mut of_key = Vec::new();
            for change in values {
                if let Some(design) = space::alone(self.task.base, &change, self.task.unbuildable) {
                    of_key
                        .extend(self.add(vec![design], Stage::Alone).into_iter().map(|index| (change.clone(), index)));
                }
            }
            keys.push(of_key);
        }
        let all: Vec<usize> = keys.iter().flatten().map(|(_, index)| *index).collect();
        self.fly(&all, 0, false)?;
        let near = |index: usize| {
            let flown = self.designs[index].results[0]?;
            let wider = super::Budget { rms_m: NEAR * self.task.budget.rms_m, ..self.task.budget };
            wider.failure(&flown).is_none().then_some(100.0 * flown.rms_m)
        };
        let of_key = |values: Vec<(Change, usize)>| {
            values.into_iter().filter_map(|(change, index)| Some((change, near(index)?))).collect()
        };
        Ok(keys.into_iter().map(of_key).collect())
    }

    /// Flies combinations of values on the first round.
    fn fly_together(&mut self, alone: &[Vec<(Change, f64)>]) -> Result<(), E> {
        let base_cm = self.designs[0].results[0].map_or(0.0, |flown| 100.0 * flown.rms_m);
        let all = space::combinations(self.task.base, base_cm, alone, self.task.unbuildable);
        self.combinations = all.len();
        let chosen = space::front(all, TOGETHER).into_iter().map(|combination| combination.design).collect();
        let chosen = self.add(chosen, Stage::Together);
        self.fly(&chosen, 0, false)
    }

    /// Flies designs that are cheaper than the best one through the rounds, the cheapest survivors first, until none of
    /// them is open.
    fn settle(&mut self) -> Result<(), E> {
        loop {
            let mut has_flown = false;
            for (round, width) in WIDTHS.into_iter().enumerate() {
                let mut waiting: Vec<usize> = (0..self.designs.len())
                    .filter(|&index| self.is_cheaper(index) && self.waits_for(index) == Some(round))
                    .collect();
                waiting.sort_by_key(|&index| self.designs[index].cost);
                waiting.truncate(width);
                if !waiting.is_empty() {
                    self.fly(&waiting, round, false)?;
                    has_flown = true;
                }
                if self.is_late() {
                    return Ok(());
                }
            }
            if !has_flown {
                return Ok(());
            }
        }
    }

    /// Returns `true` if a design is cheaper than the best one.
    fn is_cheaper(&self, index: usize) -> bool {
        self.best.is_none_or(|best| self.designs[index].cost < self.designs[best].cost)
    }

    /// Returns the first round that has not been flown in full; `None` if the design has failed or has flown all.
    fn waits_for(&self, index: usize) -> Option<usize> {
        let results = &self.designs[index].results;
        let open = results.iter().position(Option::is_none);
        open.filter(|_| self.failure(index).is_none()).map(|flight| self.flights[flight].0)
    }

    /// Returns the first flight that does not keep the budget, and what it does not keep.
    fn failure(&self, index: usize) -> Option<(usize, String)> {
        let flown = self.designs[index].results.iter().enumerate();
        flown.filter_map(|(flight, result)| Some((flight, self.task.budget.failure(result.as_ref()?)?))).next()
    }

    /// Flies designs on a round, until they fail. The flights that have failed most designs come first. With `whole` a
    /// design is flown beyond its first failure, and the deadline is ignored.
    fn fly(&mut self, indices: &[usize], round: usize, whole: bool) -> Result<(), E> {
        let failures = |flight: usize| {
            let results = self.designs.iter().filter_map(|design| design.results[flight].as_ref());
            results.filter(|flown| self.task.budget.failure(flown).is_some()).count()
        };
        let mut flights: Vec<usize> =
            (0..self.flights.len()).filter(|&flight| self.flights[flight].0 == round).collect();
        flights.sort_by_key(|&flight| std::cmp::Reverse(failures(flight)));
        let mut jobs: Vec<(usize, usize)> = Vec::new();
        for flight in flights {
            for &index in indices {
                if self.designs[index].results[flight].is_none() && !jobs.contains(&(index, flight)) {
                    jobs.push((index, flight));
                }
            }
        }
        let mut jobs = jobs.into_iter().peekable();
        while jobs.peek().is_some() {
            let mut batch: Vec<(usize, usize, String)> = Vec::new();
            while let Some(&(index, flight)) = jobs.peek().filter(|_| batch.len() < BATCH) {
                jobs.next();
                if !whole && self.failure(index).is_some() {
                    continue;
                }
                let key = self.key(index, flight);
                match self.known.flights.get(&key) {
                    Some(flown) => {
                        self.designs[index].results[flight] = Some(*flown);
                        self.restored += 1;
                    }
                    None => batch.push((index, flight, key)),
                }
            }
            if batch.is_empty() {
                continue;
            }
            if !whole && self.is_late() {
                return Ok(());
            }
            (self.report)(&self.progress(&batch));
            let fly = |(index, flight, _): &(usize, usize, String)| {
                (self.task.fly)(&self.designs[*index].candidate.design, &self.flights[*flight].1)
            };
            let results: Vec<Result<FlightResult, E>> = batch.par_iter().map(fly).collect();
            for ((index, flight, key), result) in batch.into_iter().zip(results) {
                let result = result?;
                (self.keep)(&key, Measured::Flight(&result))?;
                self.designs[index].results[flight] = Some(result);
                self.flown += 1;
            }
        }
        for &index in indices {
            let has_flown_all = self.designs[index].results.iter().all(Option::is_some);
            if has_flown_all && self.failure(index).is_none() && self.is_cheaper(index) {
                self.best = Some(index);
            }
        }
        Ok(())
    }

    /// Returns the key of a flight: a hash of design, flight, scene and program.
    fn key(&self, index: usize, flight: usize) -> String {
        let Flight { scene, seed, seconds } = &self.flights[flight].1;
        let hash = self.task.scenes.iter().find(|known| known.name == *scene).map_or("", |scene| &scene.hash);
        let design = self.designs[index].candidate.design.to_toml();
        let mut digest = Sha256::new();
        for text in [self.task.build, &design, scene, hash, &format!("{seed} {seconds}")] {
            digest.update(text.as_bytes());
            digest.update([0]);
        }
        digest.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
    }

    fn progress(&self, batch: &[(usize, usize, String)]) -> MissionProgress {
        let step = batch.first().map_or_else(String::new, |(index, flight, _)| {
            let Flight { scene, seed, seconds } = &self.flights[*flight].1;
            format!("{} over {scene}, seed {seed}, {seconds} s", self.designs[*index].candidate.name)
        });
        self.progress_of(step)
    }

    fn progress_of(&self, step: String) -> MissionProgress {
        let best = self.best.map(|best| &self.designs[best].candidate);
        let best = best.map(|best| (best.name.clone(), best.resources.m10k));
        MissionProgress { flights: self.flown + self.restored, step, best }
    }

    /// Measures the checks of the report on every design that was flown: base and best first, the others as long as
    /// there is time. A design stops at its first check that fails.
    fn features(&mut self) -> Result<(Vec<Option<Features>>, Vec<Unfit>), E> {
        let mut bench = Bench::new(self.task.subjects, self.task.build);
        let parts = bench.parts();
        let mut found: Vec<Option<Features>> = Vec::new();
        for design in &self.designs {
            let failure = design.candidate.failure.clone();
            found.push(failure.map(|check| Features { pass: false, check }));
        }
        let mut order: Vec<usize> = (0..self.designs.len()).filter(|&index| self.has_flown(index)).collect();
        order.sort_by_key(|&index| {
            let DesignPoint { pixel, look_ahead, .. } = &self.designs[index].candidate.design;
            (index != 0 && Some(index) != self.best, look_ahead.clone(), pixel.bits())
        });
        let mut unfit = Vec::new();
        let is_needed = |index: usize| index == 0 || Some(index) == self.best;
        let (needed, others): (Vec<usize>, Vec<usize>) = order.into_iter().partition(|&index| is_needed(index));
        for (designs, is_needed) in [(needed, true), (others, false)] {
            let mut closest: Vec<Option<PartOutcome>> = vec![None; self.designs.len()];
            let mut complete = true;
            'parts: for &part in &parts {
                for index in &designs {
                    let index = *index;
                    if found[index].is_some() {
                        continue;
                    }
                    if !is_needed && self.is_late() {
                        complete = false;
                        break 'parts;
                    }
                    let outcome = self.measure(&mut bench, index, part)?;
                    if index == 0
                        && let Some(reason) = &outcome.unfit
                    {
                        unfit.push(bench.unfit(part, reason));
                    }
                    if let Some(check) = &outcome.failure {
                        found[index] = Some(Features { pass: false, check: check.clone() });
                    }
                    let is_closer = closest[index].as_ref().is_none_or(|known| outcome.worst.used > known.worst.used);
                    if outcome.unfit.is_none() && is_closer {
                        closest[index] = Some(outcome);
                    }
                }
            }
            for index in designs.into_iter().filter(|_| complete) {
                // Without a part that is fit to judge it, nothing is known beside the coefficients.
                let Some(closest) = closest[index].take().map(|outcome| outcome.worst) else { continue };
                let of_coefficients = self.designs[index].candidate.closest.clone();
                let worst = of_coefficients.into_iter().chain([closest]).max_by(|a, b| a.used.total_cmp(&b.used));
                if found[index].is_none() {
                    found[index] = worst.map(|check| Features { pass: true, check });
                }
            }
        }
        Ok((found, unfit))
    }

    /// Returns the outcome of the report's checks on a part, from an earlier search if it has it.
    fn measure(&mut self, bench: &mut Bench, index: usize, part: Part) -> Result<PartOutcome, E> {
        let candidate = &self.designs[index].candidate;
        let key = bench.key(&candidate.design, part);
        if let Some(outcome) = self.known.parts.get(&key) {
            return Ok(outcome.clone());
        }
        (self.report)(&self.progress_of(format!("checks of the report: {} on {}", candidate.name, bench.name(part))));
        let levels = Levels::new(&candidate.design)?;
        bench.prepare(&levels, part);
        let outcome = bench.measure(&levels, part);
        (self.keep)(&key, Measured::Part(&outcome))?;
        Ok(outcome)
    }

    fn has_flown(&self, index: usize) -> bool {
        self.designs[index].results.iter().any(Option::is_some)
    }

    fn result(mut self) -> Result<Mission, E> {
        let (features, unfit) = self.features()?;
        let shown: Vec<usize> = (0..self.designs.len()).filter(|&index| index == 0 || self.has_flown(index)).collect();
        let points: Vec<MissionPoint> = shown.iter().map(|&index| self.point(index, features[index].clone())).collect();
        let best = shown.iter().position(|&index| Some(index) == self.best);
        let passes = |point: &MissionPoint| point.features.as_ref().map(|features| features.pass);
        let mut verdicts = Verdicts::default();
        for point in &points {
            match (point.status != Flown::Fails, passes(point)) {
                (true, Some(true)) => verdicts.both += 1,
                (true, Some(false)) => verdicts.mission_only += 1,
                (false, Some(true)) => verdicts.features_only += 1,
                (false, Some(false)) => verdicts.neither += 1,
                (_, None) => {}
            }
        }
        let of_both = (0..points.len())
            .filter(|&index| points[index].status != Flown::Fails && passes(&points[index]) == Some(true));
        let best_of_both = of_both.min_by_key(|&index| space::cost(&points[index].design));
        let binding = best.and_then(|best| match passes(&points[best])? {
            false => Some(Binding::Features),
            // Without a decision nothing is known about what is cheaper.
            true => self.decided.then_some(Binding::Mission),
        });
        Ok(Mission {
            pass: best.is_some(),
            decided: self.decided,
            budget: self.task.budget,
            plan: self.plan,
            scenes: self.task.scenes.to_vec(),
            device: self.task.device.0.into(),
            flown: self.flown,
            restored: self.restored,
            combinations: self.combinations,
            best,
            binding,
            best_of_both,
            verdicts,
            unfit,
            points,
        })
    }

    fn point(&self, index: usize, features: Option<Features>) -> MissionPoint {
        let Design { candidate, stage, results, .. } = &self.designs[index];
        let failure = self.failure(index);
        let all_flown = results.iter().all(Option::is_some);
        let status = match (&failure, all_flown) {
            (Some(_), _) => Flown::Fails,
            (None, true) => Flown::Keeps,
            (None, false) => Flown::Open,
        };
        let flown = || results.iter().flatten();
        let largest =
            |of: fn(&FlightResult) -> Option<f64>| flown().filter_map(of).reduce(f64::max).map(|metres| 100.0 * metres);
        let of = resources(&candidate.design);
        let Resources { m10k, alm, dsp, .. } = of;
        let limits = self.task.device.1;
        MissionPoint {
            name: candidate.name.clone(),
            design: candidate.design.clone(),
            resources: of,
            fits: [alm, m10k, dsp].iter().zip(limits).all(|(used, limit)| *used <= limit),
            stage: *stage,
            status,
            flights: flown().count(),
            short_cm: results.first().copied().flatten().map(|flown| 100.0 * flown.rms_m),
            worst_cm: largest(|flown| Some(flown.rms_m)),
            error_cm: largest(|flown| flown.error_rms_m),
            failure: failure.map(|(flight, what)| {
                let Flight { scene, seed, seconds } = &self.flights[flight].1;
                format!("{scene}, seed {seed}, {seconds} s: {what}")
            }),
            features,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Budget, Scene};
    use super::*;
    use hoverlock_design::KT27;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    /// Returns a flight whose distance grows with the bits that a design lacks, and over the mist with each of the DoG.
    fn flown(design: &DesignPoint, flight: &Flight) -> FlightResult {
        let lacking = |base: u32, bits: u32| f64::from(base - bits);
        let is_mist = flight.scene == "mist";
        let dog =
            if is_mist { 0.001 + 0.008 * lacking(15, design.dog_bits) } else { 0.002 * lacking(15, design.dog_bits) };
        let look_ahead: u32 = design.look_ahead.iter().sum();
        let others = lacking(16, design.pixel.bits()) + lacking(16, look_ahead);
        FlightResult {
            rms_m: 0.03 + 1e-5 * flight.seconds + dog + 0.001 * others,
            error_rms_m: Some(0.01),
            estimates: 9,
            misleading: usize::from(design.coefficient.bits() < 9),
            longest_loss_s: 0.0,
            tilt_max_deg: 1.0,
        }
    }

    fn searched(known: &Known, kept: &mut Known, budget_cm: f64, seconds: u64) -> (Mission, usize) {
        let scenes = ["field", "mist"].map(|name| Scene { name: name.into(), hash: "0".into() });
        let count = AtomicUsize::new(0);
        let fly = |design: &DesignPoint, flight: &Flight| {
            count.fetch_add(1, Ordering::Relaxed);
            Ok(flown(design, flight))
        };
        let unbuildable = |design: &DesignPoint| design.check_buildable().err().map(|error| error.to_string());
        let task = MissionTask {
            base: &KT27,
            budget: Budget { rms_m: budget_cm / 100.0, max_loss_s: 1.0, max_tilt_deg: 5.0 },
            scenes: &scenes,
            seed: 1,
            seeds: 2,
            seconds: 8.0,
            subjects: &[],
            deadline: Instant::now() + Duration::from_secs(seconds),
            device: ("any", [u64::MAX; 3]),
            unbuildable: &unbuildable,
            build: "test",
            fly: &fly,
        };
        let mut keep = |key: &str, measured: Measured<'_>| {
            match measured {
                Measured::Flight(flown) => kept.flights.insert(key.into(), *flown).is_none(),
                Measured::Part(outcome) => kept.parts.insert(key.into(), outcome.clone()).is_none(),
            };
            Ok(())
        };
        let found = run::<Box<dyn std::error::Error + Send + Sync>>(&task, known, &mut keep, &|_| ()).unwrap();
        (found, count.into_inner())
    }

    #[test]
    fn the_best_keeps_every_flight_and_all_that_is_cheaper_in_one_key_fails_one() {
        let mut kept = Known::default();
        let (found, flights) = searched(&Known::default(), &mut kept, 10.0, 3600);
        let best = found.best().unwrap();
        assert!(found.pass && found.decided && best.resources.m10k < 200, "{best:?}");
        let keeps = |design: &DesignPoint| {
            found.plan.rounds.iter().flatten().all(|flight| found.budget.failure(&flown(design, flight)).is_none())
        };
        assert!(best.status == Flown::Keeps && best.flights == 27 && keeps(&best.design));
        let unbuildable = |design: &DesignPoint| design.check_buildable().err().map(|error| error.to_string());
        let steps = space::steps(&best.design, &unbuildable);
        assert!(!steps.is_empty() && !steps.iter().any(keeps));
        for point in found.points.iter().filter(|point| point.status == Flown::Keeps) {
            assert!(space::cost(&point.design) >= space::cost(&best.design), "{}", point.name);
        }
        // The base is further from its target over the mist, so the short flight is there.
        assert_eq!(found.plan.rounds[0][0].scene, "mist");
        assert_eq!((found.flown, found.restored), (flights, 0));
        let (again, flights) = searched(&kept, &mut Known::default(), 10.0, 3600);
        assert_eq!((flights, again.restored), (0, found.flown));
        assert_eq!(again.points, found.points);
    }

    /// There is no frame here, so there is none that is fit: coefficients that pass alone are no verdict.
    #[test]
    fn without_a_frame_that_is_fit_no_design_passes_the_checks_of_the_features() {
        let (found, _) = searched(&Known::default(), &mut Known::default(), 10.0, 0);
        let of_base = found.base().unwrap().features.as_ref();
        assert_eq!((of_base, found.binding, found.verdicts.both), (None, None, 0));
        assert!(found.points.iter().all(|point| !point.features.as_ref().is_some_and(|features| features.pass)));
    }

    #[test]
    fn a_stopped_search_has_the_best_so_far_and_does_not_call_it_decided() {
        let (found, flights) = searched(&Known::default(), &mut Known::default(), 10.0, 0);
        assert_eq!((found.best().unwrap().name.as_str(), found.decided, flights), ("base", false, 27));
        // What is cheaper is unknown, so no bound is said to bind.
        assert_eq!(found.binding, None);
    }

    #[test]
    fn a_base_that_misses_the_budget_ends_the_search() {
        let (found, flights) = searched(&Known::default(), &mut Known::default(), 2.0, 3600);
        assert!(!found.pass && found.best().is_none() && flights == 7);
        assert!(found.base().unwrap().failure.as_ref().unwrap().contains("cm rms from the target"));
        let page = crate::mission::output::html(&found, "hoverlock explore").unwrap();
        assert!(page.contains(">NONE<") && page.contains("The base design itself does not keep the budget"));
        assert_eq!(crate::mission::output::best(&found, ""), None);
    }
}
