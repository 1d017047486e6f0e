//! The search itself: which design is measured next, and when its measurement ends.

use std::collections::BTreeSet;
use std::time::Instant;

use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_fixed_point::analysis::resources::Resources;
use hoverlock_fixed_point::model::coefficients::CoefficientError;
use hoverlock_reports::check_outcome::CheckOutcome;
use hoverlock_reports::study::{Unfit, Unjudged};
use rayon::prelude::*;

use crate::measure::{Bench, Part, PartOutcome, shared};
use crate::results::KnownResults;
use crate::space::{self, Candidate};
use crate::{Exploration, Objective, Point, Progress, Status, Task};

/// Number of designs that are measured in parallel.
const BATCH: usize = 4;

/// Searches for the best design. `known` has the results of earlier searches. `keep` receives the key and the outcome
/// of each new measurement, `report` the progress before each one.
///
/// # Errors
/// The base design has no valid coefficients, no picture is fit to judge it, or `keep` fails.
pub fn run<E: From<CoefficientError> + From<Unjudged>>(
    task: &Task,
    known: &KnownResults,
    keep: &mut dyn FnMut(&str, &PartOutcome) -> Result<(), E>,
    report: &dyn Fn(&Progress),
) -> Result<Exploration, E> {
    Levels::new(task.base)?;
    let candidates = space::candidates(task.base, task.unbuildable);
    let bench = Bench::new(task.subjects, task.build);
    let parts = bench.parts();
    let outcomes = vec![vec![None; parts.len()]; candidates.len()];
    let mut search = Search { task, candidates, bench, parts, outcomes, known, keep, report, measured: 0, restored: 0 };
    search.measure_all()?;
    Ok(search.result())
}

/// A search in progress.
struct Search<'a, E> {
    task: &'a Task<'a>,
    candidates: Vec<Candidate>,
    bench: Bench<'a>,
    parts: Vec<Part>,
    /// Outcome of each candidate on each part; `None` if not measured.
    outcomes: Vec<Vec<Option<PartOutcome>>>,
    known: &'a KnownResults,
    keep: &'a mut dyn FnMut(&str, &PartOutcome) -> Result<(), E>,
    report: &'a dyn Fn(&Progress),
    measured: usize,
    restored: usize,
}

impl<E: From<Unjudged>> Search<'_, E> {
    fn measure_all(&mut self) -> Result<(), E> {
        // The base is measured in full. From then on the parts that use most of its allowance come first.
        self.measure(&[0], true)?;
        let unfit = self.unfit();
        if unfit.len() == self.parts.len() {
            return Err(Unjudged(unfit).into());
        }
        let used = |part: usize| self.outcomes[0][part].as_ref().map_or(0.0, |outcome| outcome.worst.used);
        let motion = |part: usize| matches!(self.parts[part], Part::Motion(_));
        let mut order: Vec<usize> = (0..self.parts.len()).collect();
        order.sort_by(|&a, &b| motion(a).cmp(&motion(b)).then(used(b).total_cmp(&used(a))));
        self.parts = order.iter().map(|&part| self.parts[part]).collect();
        for outcomes in &mut self.outcomes {
            *outcomes = order.iter().map(|&part| outcomes[part].take()).collect();
        }
        let mut order: Vec<usize> = (0..self.candidates.len()).collect();
        order.sort_by_key(|&index| self.cost(index));
        let mut rest = order.into_iter();
        loop {
            let mut batch = Vec::new();
            while batch.len() < BATCH {
                match rest.next() {
                    Some(index) if self.status(index) == Status::Open => batch.push(index),
                    Some(_) => {}
                    None => break,
                }
            }
            if batch.is_empty() || self.is_late() {
                break;
            }
            self.measure(&batch, false)?;
        }
        self.complete_front()
    }

    fn is_late(&self) -> bool {
        Instant::now() >= self.task.deadline
    }

    /// Returns the quantities by which passing designs are compared, the objective first.
    fn cost(&self, index: usize) -> [u64; 4] {
        let Resources { m10k, alm, dsp, mul18 } = self.candidates[index].resources;
        match self.task.objective {
            Objective::M10k | Objective::Error => [m10k, alm, dsp, mul18],
            Objective::Alm => [alm, m10k, dsp, mul18],
            Objective::Dsp => [dsp, m10k, alm, mul18],
        }
    }

    /// Returns the status of a design.
    fn status(&self, index: usize) -> Status {
        if self.failure(index).is_some() {
            Status::Fails
        } else if self.outcomes[index].iter().all(Option::is_some) {
            Status::Passes
        } else {
            Status::Open
        }
    }

    /// Returns the names of the pictures by one of whose parts the base can be judged.
    fn judges(&self) -> Vec<String> {
        let is_judge = |picture: &usize| {
            let mut of_base = self.parts.iter().zip(&self.outcomes[0]);
            of_base.any(|(part, outcome)| {
                part.picture() == *picture && outcome.as_ref().is_some_and(|outcome| outcome.unfit.is_none())
            })
        };
        let subjects = self.task.subjects;
        (0..subjects.len()).filter(is_judge).map(|picture| subjects[picture].name.clone()).collect()
    }

    /// Returns the parts by which the base cannot be judged.
    fn unfit(&self) -> Vec<Unfit> {
        let of_base = self.parts.iter().zip(&self.outcomes[0]);
        of_base.filter_map(|(&part, outcome)| Some(self.bench.unfit(part, outcome.as_ref()?.unfit.as_ref()?))).collect()
    }

    /// Returns the first check that a design fails.
    fn failure(&self, index: usize) -> Option<&CheckOutcome> {
        let measured = || self.outcomes[index].iter().flatten().find_map(|outcome| outcome.failure.as_ref());
        self.candidates[index].failure.as_ref().or_else(measured)
    }

    /// Measures designs on all parts. With `whole` a design is measured beyond its first failure, and the deadline is
    /// ignored.
    fn measure(&mut self, batch: &[usize], whole: bool) -> Result<(), E> {
        let all = (0..self.parts.len()).collect::<Vec<_>>();
        self.measure_parts(batch, &all, whole)
    }

    /// Does the same as [`Search::measure`] on some of the parts.
    fn measure_parts(&mut self, batch: &[usize], parts: &[usize], whole: bool) -> Result<(), E> {
        for &slot in parts {
            let part = self.parts[slot];
            let wanted = |index: &&usize| {
                self.outcomes[**index][slot].is_none()
                    && self.candidates[**index].failure.is_none()
                    && (whole || self.failure(**index).is_none())
            };
            let wanted: Vec<usize> = batch.iter().filter(wanted).copied().collect();
            let mut left = Vec::new();
            for index in wanted {
                match self.known.get(&self.bench.key(&self.candidates[index].design, part)) {
                    Some(outcome) => {
                        self.outcomes[index][slot] = Some(outcome.clone());
                        self.restored += 1;
                    }
                    None => left.push(index),
                }
            }
            if left.is_empty() {
                continue;
            }
            if !whole && self.is_late() {
                return Ok(());
            }
            (self.report)(&self.progress(&left, part));
            let shared = |index: usize| shared(&self.candidates[index].design, part);
            left.sort_by_key(|&index| shared(index));
            for same in left.chunk_by(|&a, &b| shared(a) == shared(b)) {
                // A candidate without levels has a failure and is not in the list, so the filter removes none.
                let levels: Vec<(usize, Levels)> = same
                    .iter()
                    .filter_map(|&index| Some((index, Levels::new(&self.candidates[index].design).ok()?)))
                    .collect();
                let Some((_, first)) = levels.first() else { continue };
                self.bench.prepare(first, part);
                let bench = &self.bench;
                let found: Vec<(usize, PartOutcome)> =
                    levels.par_iter().map(|(index, levels)| (*index, bench.measure(levels, part))).collect();
                for (index, outcome) in found {
                    (self.keep)(&self.bench.key(&self.candidates[index].design, part), &outcome)?;
                    self.outcomes[index][slot] = Some(outcome);
                    self.measured += 1;
                }
            }
        }
        Ok(())
    }

    fn progress(&self, batch: &[usize], part: Part) -> Progress {
        let status: Vec<Status> = (0..self.candidates.len()).map(|index| self.status(index)).collect();
        let passing = (0..status.len()).filter(|&index| status[index] == Status::Passes);
        let best = passing.min_by_key(|&index| self.cost(index)).map(|index| &self.candidates[index]);
        let first = batch.first().map_or("", |&index| &self.candidates[index].name);
        Progress {
            settled: status.iter().filter(|status| **status != Status::Open).count(),
            designs: status.len(),
            step: format!("{first} on {}", self.bench.name(part)),
            best: best.map(|best| (best.name.clone(), best.resources.m10k)),
        }
    }

    /// Returns the M10K of a design and its largest DoG error over the frames measured; `None` without a frame.
    fn price(&self, index: usize) -> Option<(u64, f64)> {
        let errors = self.outcomes[index].iter().flatten().filter_map(|outcome| outcome.dog_rms_lsb);
        let error = errors.fold(None, |most: Option<f64>, error| Some(most.map_or(error, |most| most.max(error))))?;
        Some((self.candidates[index].resources.m10k, error))
    }

    /// Returns the indices of the parts that are frames.
    fn frames(&self) -> Vec<usize> {
        (0..self.parts.len()).filter(|&slot| matches!(self.parts[slot], Part::Frame(..))).collect()
    }

    /// Measures the designs on the front on all frames. A design whose measurement stopped early has an error that is
    /// too small, so the front can change; the method repeats until it does not.
    fn complete_front(&mut self) -> Result<(), E> {
        let frames = self.frames();
        while !self.is_late() {
            let short: Vec<usize> = self
                .front()
                .into_iter()
                .filter(|&index| frames.iter().any(|&slot| self.outcomes[index][slot].is_none()))
                .take(BATCH)
                .collect();
            if short.is_empty() {
                break;
            }
            self.measure_parts(&short, &frames, true)?;
        }
        Ok(())
    }

    /// Returns the indices of the designs on the Pareto front of memory and error.
    fn front(&self) -> Vec<usize> {
        let prices: Vec<Option<(u64, f64)>> = (0..self.candidates.len()).map(|index| self.price(index)).collect();
        front(&prices)
    }

    fn result(self) -> Exploration {
        let front: BTreeSet<usize> = self.front().into_iter().collect();
        let frames = self.frames();
        let limits = self.task.device.1;
        let point = |index: usize| {
            let candidate = &self.candidates[index];
            let status = self.status(index);
            let measured = self.outcomes[index].iter().flatten().map(|outcome| &outcome.worst);
            let worst = measured.max_by(|a, b| a.used.total_cmp(&b.used));
            let worst = worst.map(|worst| closest(worst, candidate.closest.as_ref()));
            let worst = candidate.failure.as_ref().or(worst).cloned();
            let Resources { m10k, alm, dsp, .. } = candidate.resources;
            Point {
                name: candidate.name.clone(),
                design: candidate.design.clone(),
                resources: candidate.resources,
                fits: [alm, m10k, dsp].iter().zip(limits).all(|(used, limit)| *used <= limit),
                pass: status == Status::Passes,
                margin: worst.as_ref().map(|worst| 100.0 * (1.0 - worst.used)),
                worst,
                failure: self.failure(index).cloned(),
                dog_rms_lsb: self.price(index).map(|price| price.1),
                frames: frames.iter().filter(|&&slot| self.outcomes[index][slot].is_some()).count(),
                front: front.contains(&index),
                status,
            }
        };
        let points: Vec<Point> = (0..self.candidates.len()).map(point).collect();
        let passing = || (0..points.len()).filter(|&index| points[index].pass);
        let error = |index: usize| points[index].dog_rms_lsb.unwrap_or(f64::INFINITY);
        let best = match self.task.objective {
            Objective::Error => passing()
                .filter(|&index| points[index].fits)
                .min_by(|&a, &b| error(a).total_cmp(&error(b)).then(self.cost(a).cmp(&self.cost(b)))),
            _ => passing().min_by_key(|&index| self.cost(index)),
        };
        let open = || (0..points.len()).filter(|&index| points[index].status == Status::Open);
        let decided = match (self.task.objective, best) {
            (Objective::Error, _) | (_, None) => open().next().is_none(),
            (_, Some(best)) => open().all(|index| self.cost(index) > self.cost(best)),
        };
        let pictures = self.task.subjects.iter().zip(self.bench.hashes());
        Exploration {
            pass: best.is_some(),
            decided,
            complete: open().next().is_none(),
            objective: self.task.objective,
            device: self.task.device.0.into(),
            frames: frames.len(),
            measured: self.measured,
            restored: self.restored,
            best,
            unfit: self.unfit(),
            judges: self.judges(),
            pictures: pictures.map(|(subject, hash)| (subject.name.clone(), hash.clone())).collect(),
            points,
        }
    }
}

/// Returns the check that uses more of its allowance.
fn closest<'a>(measured: &'a CheckOutcome, coefficients: Option<&'a CheckOutcome>) -> &'a CheckOutcome {
    coefficients.filter(|check| check.used > measured.used).unwrap_or(measured)
}

/// Returns the indices of the pairs that no other pair dominates: smaller in one number and not larger in the other.
fn front(prices: &[Option<(u64, f64)>]) -> Vec<usize> {
    let beats = |a: (u64, f64), b: (u64, f64)| (a.0 <= b.0 && a.1 < b.1) || (a.0 < b.0 && a.1 <= b.1);
    (0..prices.len())
        .filter(|&index| prices[index].is_some_and(|price| !prices.iter().flatten().any(|&other| beats(other, price))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::{DesignPoint, KT27};
    use hoverlock_reference::image::plane::Plane;
    use hoverlock_reports::study::Subject;
    use std::time::Duration;

    #[test]
    fn the_front_has_the_points_that_no_other_dominates() {
        let prices = [Some((437, 0.5)), Some((410, 0.9)), Some((420, 0.9)), None, Some((410, 0.9)), Some((380, 2.0))];
        assert_eq!(front(&prices), [0, 1, 4, 5]);
    }

    /// Blocks of three sizes: features everywhere.
    fn subject() -> Subject {
        let hash = |x: usize, y: usize| {
            let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
            (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 48
        };
        let frame = Plane::from_fn(440, 400, |x, y| {
            ((hash(x / 5, y / 5) + hash(x / 11, y / 11 + 1000) + hash(x / 23, y / 23 + 2000)) / 3) as u16
        });
        Subject { name: "blobs".into(), frame: frame.clone(), picture: frame }
    }

    fn searched(known: &KnownResults, kept: &mut KnownResults, budget: u64) -> Exploration {
        let subjects = [subject()];
        let unbuildable = |design: &DesignPoint| {
            let odd = design.state.bits() > 18 || design.coefficient.bits() > 16 || design.coefficient.bits() < 14;
            let odd = odd || ![10, 14, 15].contains(&design.dog_bits) || design.dog_shift() < 0;
            odd.then(String::new)
        };
        let task = Task {
            base: &KT27,
            subjects: &subjects,
            objective: Objective::M10k,
            deadline: Instant::now() + Duration::from_secs(budget),
            device: ("any", [u64::MAX; 3]),
            unbuildable: &unbuildable,
            build: "test",
        };
        let mut keep = |key: &str, outcome: &PartOutcome| {
            kept.insert(key.into(), outcome.clone());
            Ok(())
        };
        run::<Box<dyn std::error::Error>>(&task, known, &mut keep, &|_| ()).unwrap()
    }

    #[test]
    fn the_best_is_the_cheapest_that_passes_and_a_second_search_measures_nothing() {
        let mut kept = KnownResults::new();
        let found = searched(&KnownResults::new(), &mut kept, 3600);
        assert!(found.pass && found.decided && found.complete && found.restored == 0);
        let best = found.best().unwrap();
        let (of_best, of_base) = (best.resources, found.points[0].resources);
        assert!(best.pass && of_best.m10k <= of_base.m10k && of_best.alm < of_base.alm, "{best:?}");
        assert!(found.points.iter().any(|point| point.status == Status::Fails));
        for point in &found.points {
            match point.status {
                Status::Passes => assert!(best.resources.m10k <= point.resources.m10k && point.failure.is_none()),
                Status::Fails => assert!(point.failure.is_some() && point.margin.unwrap() < 0.0),
                Status::Open => panic!("{point:?}"),
            }
        }
        let again = searched(&kept, &mut KnownResults::new(), 3600);
        assert_eq!((again.measured, again.restored), (0, found.measured));
        assert_eq!(again.points, found.points);
    }

    #[test]
    fn without_time_only_the_base_is_measured() {
        let found = searched(&KnownResults::new(), &mut KnownResults::new(), 0);
        assert!(!found.complete && !found.decided);
        assert_eq!(found.best().unwrap().name, "base");
    }

    /// Like the report, a search counts the checks of the coefficients, which need no picture.
    #[test]
    fn the_checks_of_the_coefficients_count() {
        let base = Candidate::new(KT27.clone(), &KT27);
        let coefficients = base.closest.unwrap();
        assert!(coefficients.check.starts_with("sigma_eff") && coefficients.used > 0.7, "{coefficients:?}");
        let frame = |used: f64| CheckOutcome { used, ..CheckOutcome::unmeasurable("a frame", String::new()) };
        assert_eq!(closest(&frame(0.5), Some(&coefficients)), &coefficients);
        assert_eq!(closest(&frame(0.9), Some(&coefficients)), &frame(0.9));
    }
}
