//! Gauss-Newton over the twelve unknowns, for each of the three models of the ground.

use crate::motion::budget::Budget;
use crate::motion::model::Pair;
use crate::motion::observation::{FittedView, ViewErrors};
use crate::motion::orthophoto::Attitude;
use crate::motion::pose::homography::{Cameras, linearise};
use crate::motion::pose::{MAX_STANDARD_ERROR_M, Pose, PoseBuffers, PoseError};
use crate::motion::relief::{self, MIN_EVIDENCE, Noise, Residual, normal_equations};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Chi squared of the readings above which a plane is rejected; exceeded by chance once in 1000 flights.
const MAX_PLANE_CHI2: f64 = 22.5;

/// Prior standard deviation of the slope of a level plane: 0 within rounding.
const LEVEL_SLOPE_SIGMA: f64 = 1e-5;

/// Evidence of relief in a subset of the pairs above which a level plane is not tried with all pairs. Larger than
/// [`MIN_EVIDENCE`], because the pose of the subset has not fully converged.
const MIN_SUBSET_EVIDENCE: f64 = 3.0 * MIN_EVIDENCE;

/// Smallest residual assumed, px per axis: no comparison of noisy frames is more accurate.
const MIN_RESIDUAL_PX: f64 = 0.02;

/// Largest residual, px per axis. The pairs of a consensus are within 3 px of a homography, and a pose has all its
/// degrees of freedom: a larger residual is not noise, but a contradiction with the readings.
const MAX_RESIDUAL_PX: f64 = 3.0;

const MAX_ITERATIONS: usize = 50;

/// Iterations that update the noise. After them it is constant, because with few pairs noise and unknowns may
/// oscillate.
const NOISE_ITERATIONS: usize = 7;

/// Length of a step, in standard errors, below which the pose has converged. The squared length is taken in the metric
/// of the normal equations, the inverse covariance of the unknowns.
const CONVERGENCE_STEP_SIGMAS: f64 = 1e-2;

/// The same for the fit to a subset of the pairs, which gives the starting point.
const SUBSET_CONVERGENCE_STEP_SIGMAS: f64 = 1.0;

/// Smallest size of that subset. It brings the pose within a few standard errors of the fit to all pairs.
const MIN_SUBSET_PAIRS: usize = 128;

/// Smallest fraction of the candidates that must be on a trimmed plane.
const MIN_ON_PLANE_FRACTION: f64 = 0.6;

/// Error, in standard deviations, from which a pair is off the plane; noise reaches it in one pair of 500.
const OFF_PLANE_SIGMAS: f64 = 3.5;

/// Rounds of trimming; the second uses the plane that the first round left.
const TRIMMING_ROUNDS: usize = 2;

/// Work units of an iteration (homography, derivatives, solution), from instruction counts on the ARM.
const ITERATION_WORK: usize = 3000;

/// Work units of a pair in an iteration, from instruction counts on the ARM.
const RESIDUAL_WORK: usize = 40;

/// Fraction of a step that the next one takes back, above which the steps oscillate.
const OSCILLATION_FRACTION: f64 = 0.25;

/// Smallest factor by which a step is shortened.
const MIN_RELAXATION: f64 = 0.2;

/// Parameters of the plane-induced homography.
const HOMOGRAPHY_PARAMETERS: usize = 8;

pub(super) const UNKNOWNS: usize = 12;

/// Index of `tz` among the unknowns; roll, pitch and yaw of CUR follow it.
pub(super) const DESCENT: usize = 2;
/// Index of `h` among the unknowns; roll, pitch and yaw of REF follow it.
pub(super) const HEIGHT: usize = 6;
/// Index of the slope along `X_e` among the unknowns.
pub(super) const SLOPE_X: usize = 10;
/// Index of the slope along `Y_e` among the unknowns.
pub(super) const SLOPE_Y: usize = 11;

/// The unknowns: `tx, ty, tz` (m) and roll, pitch, yaw (radians) of CUR; `h` (m) and roll, pitch, yaw of REF; slope of
/// the ground along `X_e` and `Y_e` (m/m).
pub(super) type Unknowns = SVector<f64, UNKNOWNS>;

/// An information matrix (inverse covariance) of the unknowns, or a covariance.
type Information = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// The model of the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
enum GroundModel {
    /// A level plane, at the height that the laser measures.
    LevelPlane,
    /// A sloped plane fitted to the pairs that are on it; the laser may hit something above it.
    TrimmedPlane,
    /// Hills on a slope; the laser may hit any of them.
    Relief,
}

/// A pose fit with its data and memory.
pub(super) struct Problem<'pairs> {
    pub(super) cameras: Cameras,
    /// The readings over a level plane.
    pub(super) level_readings: Unknowns,
    /// The readings with height and slope of the terrain prior.
    pub(super) sloped_readings: Unknowns,
    /// Standard errors of REF and of CUR.
    pub(super) errors: [ViewErrors; 2],
    /// Inverse covariance of height and slope of the terrain prior.
    pub(super) terrain_information: Matrix3<f64>,
    pub(super) slope_is_measured: bool,
    pub(super) pairs: &'pairs [Pair],
    /// The pairs that may be on the plane.
    pub(super) candidates: &'pairs [Pair],
    pub(super) buffers: &'pairs mut PoseBuffers,
    pub(super) budget: &'pairs mut Budget,
    /// Variance inflation by overlapping supports ([`relief::overlap`]).
    pub(super) overlap: f64,
}

/// A minimum of the weighted sum of squares.
pub(super) struct Solution {
    unknowns: Unknowns,
    covariance: Information,
    noise: Noise,
    /// Sum of squared deviations from the readings over their variances.
    pub(super) chi2: f64,
}

impl Problem<'_> {
    /// Fits a level plane. If it does not explain the pairs, returns the unknowns so far, a starting point for the next
    /// model. A subset of the pairs often shows the relief already.
    pub(super) fn fit_level_plane(&mut self) -> Result<Solution, Unknowns> {
        let mut start = self.level_readings;
        if self.stride() > 1 {
            let stride = self.stride();
            if let Ok(solution) = self.iterate(GroundModel::LevelPlane, start, stride, SUBSET_CONVERGENCE_STEP_SIGMAS) {
                start = solution.unknowns;
            }
            if self.evidence() > MIN_SUBSET_EVIDENCE {
                return Err(start);
            }
        }
        let solution = self.iterate(GroundModel::LevelPlane, start, 1, CONVERGENCE_STEP_SIGMAS).map_err(|_| start)?;
        let is_plane = solution.chi2 < MAX_PLANE_CHI2 && self.evidence() < MIN_EVIDENCE;
        if is_plane { Ok(solution) } else { Err(solution.unknowns) }
    }

    /// Returns the step through the pairs that gives a subset of about [`MIN_SUBSET_PAIRS`].
    fn stride(&self) -> usize {
        (self.pairs.len() / MIN_SUBSET_PAIRS).max(1)
    }

    /// Fits a plane to the pairs that are on it. Returns `None` if too many are off it, if the readings contradict the
    /// rest, or if the rest may be a hill: its slope was never measured, and it shows relief.
    pub(super) fn fit_trimmed_plane(&mut self, start: Unknowns) -> Option<Solution> {
        self.buffers.on_plane.clear();
        self.buffers.on_plane.extend_from_slice(self.candidates);
        let (model, stride) = (GroundModel::TrimmedPlane, self.stride());
        let mut found = self.iterate(model, start, stride, SUBSET_CONVERGENCE_STEP_SIGMAS).ok()?;
        for _ in 0..TRIMMING_ROUNDS {
            if self.trim(&found.unknowns)? < MIN_ON_PLANE_FRACTION {
                return None;
            }
            found = self.iterate(model, found.unknowns, 1, CONVERGENCE_STEP_SIGMAS).ok()?;
        }
        let is_plane = self.slope_is_measured || self.evidence() < MIN_EVIDENCE;
        (is_plane && found.chi2 < MAX_PLANE_CHI2).then_some(found)
    }

    /// Fits hills: a height of its own for each cell of the picture.
    pub(super) fn fit_relief(&mut self, start: Unknowns) -> Result<Solution, PoseError> {
        let near = match self.stride() {
            1 => start,
            stride => self
                .iterate(GroundModel::Relief, start, stride, SUBSET_CONVERGENCE_STEP_SIGMAS)
                .map_or(start, |near| near.unknowns),
        };
        self.iterate(GroundModel::Relief, near, 1, CONVERGENCE_STEP_SIGMAS)
    }

    /// Keeps the candidates that are on the plane of `unknowns`. Returns their fraction of all candidates, or `None` if
    /// the budget is exhausted or a pair maps behind the camera.
    fn trim(&mut self, unknowns: &Unknowns) -> Option<f64> {
        self.linearise(unknowns, self.candidates)?;
        let PoseBuffers { residuals, values, on_plane, .. } = &mut *self.buffers;
        let noise =
            Noise { relief: 0.0, ..Noise::of_relief(residuals, MIN_RESIDUAL_PX, HOMOGRAPHY_PARAMETERS, values) };
        on_plane.clear();
        let kept = residuals.iter().map(|residual| !is_off_plane(&noise, residual));
        on_plane.extend(self.candidates.iter().zip(kept).filter(|(_, kept)| *kept).map(|(pair, _)| *pair));
        Some(on_plane.len() as f64 / self.candidates.len() as f64)
    }

    /// Records which of all pairs are off the plane of a solution, for [`PoseBuffers::off_plane`].
    pub(super) fn mark_off_plane(&mut self, solution: &Solution) {
        if self.linearise(&solution.unknowns, self.pairs).is_some() {
            let PoseBuffers { residuals, off_plane, .. } = &mut *self.buffers;
            off_plane.extend(residuals.iter().map(|residual| is_off_plane(&solution.noise, residual)));
        }
    }

    /// Computes the residuals of `pairs` under `unknowns`. Returns `None` if the budget is exhausted or a pair maps
    /// behind the camera.
    fn linearise(&mut self, unknowns: &Unknowns, pairs: &[Pair]) -> Option<()> {
        let (homography, derivatives) = self.cameras.homography(unknowns);
        let affordable = self.budget.spend(RESIDUAL_WORK * pairs.len());
        affordable.then(|| linearise(&homography, &derivatives[HEIGHT], pairs.iter(), &mut self.buffers.residuals))?
    }

    /// Iterates with every `stride`-th pair until a step is shorter than `convergence_step` standard errors.
    fn iterate(
        &mut self,
        ground: GroundModel,
        start: Unknowns,
        stride: usize,
        convergence_step: f64,
    ) -> Result<Solution, PoseError> {
        let PoseBuffers { residuals, values, cells, on_plane, .. } = &mut *self.buffers;
        let pairs = match ground {
            GroundModel::LevelPlane => self.candidates,
            GroundModel::TrimmedPlane => on_plane,
            GroundModel::Relief => self.pairs,
        };
        let prior = information(&self.errors, ground, &self.terrain_information);
        let readings = if ground == GroundModel::LevelPlane { self.level_readings } else { self.sloped_readings };
        let mut unknowns = start;
        let mut noise = Noise { position: MIN_RESIDUAL_PX, relief: 0.0 };
        let (mut relaxation, mut previous) = (1.0, None);
        for iteration in 0..MAX_ITERATIONS {
            if !self.budget.spend(ITERATION_WORK + RESIDUAL_WORK * pairs.len().div_ceil(stride)) {
                return Err(PoseError::BudgetExhausted);
            }
            let (homography, derivatives) = self.cameras.homography(&unknowns);
            let height_derivative = &derivatives[HEIGHT];
            let pairs = pairs.iter().step_by(stride);
            linearise(&homography, height_derivative, pairs, residuals).ok_or(PoseError::NotConverged)?;
            if iteration < NOISE_ITERATIONS {
                noise = match ground {
                    GroundModel::LevelPlane | GroundModel::TrimmedPlane => {
                        Noise::of_plane(residuals, MIN_RESIDUAL_PX, HOMOGRAPHY_PARAMETERS, values)
                    }
                    GroundModel::Relief => Noise::of_relief(residuals, MIN_RESIDUAL_PX, HOMOGRAPHY_PARAMETERS, values),
                };
            }
            let (normal, gradient) = normal_equations(residuals, &derivatives, &noise, cells);
            let factor = (normal + prior).cholesky().ok_or(PoseError::NotConverged)?;
            let gradient = gradient + prior * (readings - unknowns);
            let step = factor.solve(&gradient);
            let squared_length = step.dot(&gradient);
            relaxation =
                previous.map_or(1.0, |(last, last_squared)| relaxed(relaxation, gradient.dot(&last) / last_squared));
            previous = Some((step, squared_length));
            unknowns += step * relaxation;
            if squared_length < convergence_step * convergence_step {
                let deviation = unknowns - readings;
                let spread = normal / (relief::excess(residuals, &noise) * self.overlap) + prior;
                let factor = spread.cholesky().ok_or(PoseError::NotConverged)?;
                return Ok(Solution {
                    unknowns,
                    covariance: factor.inverse(),
                    noise,
                    chi2: deviation.dot(&(prior * deviation)),
                });
            }
        }
        Err(PoseError::NotConverged)
    }

    /// Returns the evidence of relief in the residuals of the last iteration.
    fn evidence(&mut self) -> f64 {
        let PoseBuffers { residuals, values, .. } = &mut *self.buffers;
        Noise::of_relief(residuals, MIN_RESIDUAL_PX, HOMOGRAPHY_PARAMETERS, values).evidence(residuals)
    }
}

/// Returns `true` if the error of a pair is not noise.
fn is_off_plane(noise: &Noise, residual: &Residual) -> bool {
    noise.length2(residual) >= OFF_PLANE_SIGMAS * OFF_PLANE_SIGMAS
}

/// Returns the factor of the next step. `last` is the factor of the last step, `repeated` the fraction of that step
/// that the next one repeats: 0 if the last step reached the minimum, negative if it overshot. If steps oscillate about
/// the minimum, as pairs enter and leave Huber's bound, the next one goes to where the two would meet (Aitken 1926, for
/// vectors Irons and Tuck 1969). If a shortened step is followed by a longer one, the smallest factor is used.
fn relaxed(last: f64, repeated: f64) -> f64 {
    if repeated > -OSCILLATION_FRACTION && last == 1.0 {
        1.0
    } else {
        (last / (1.0 - repeated)).clamp(MIN_RELAXATION, 1.0)
    }
}

/// Returns the information of the priors: each angle, `h`, `h - tz`, and height and slope of the ground; 0 for `tx` and
/// `ty`.
fn information(
    [reference, current]: &[ViewErrors; 2],
    ground: GroundModel,
    terrain_information: &Matrix3<f64>,
) -> Information {
    let of = |sigma: f64| 1.0 / (sigma * sigma);
    let level =
        Matrix3::from_diagonal(&Vector3::new(of(reference.plane_height), of(LEVEL_SLOPE_SIGMA), of(LEVEL_SLOPE_SIGMA)));
    let (range, terrain) = match ground {
        GroundModel::LevelPlane => (of(current.plane_height), &level),
        GroundModel::TrimmedPlane | GroundModel::Relief => (of(current.relief_height), terrain_information),
    };
    let mut information = Information::from_diagonal(&Unknowns::from([
        0.0,
        0.0,
        range,
        of(current.tilt),
        of(current.tilt),
        of(current.heading),
        range,
        of(reference.tilt),
        of(reference.tilt),
        of(reference.heading),
        0.0,
        0.0,
    ]));
    const TERRAIN: [usize; 3] = [HEIGHT, SLOPE_X, SLOPE_Y];
    for (row, i) in TERRAIN.into_iter().enumerate() {
        for (column, j) in TERRAIN.into_iter().enumerate() {
            information[(i, j)] += terrain[(row, column)];
        }
    }
    information[(DESCENT, HEIGHT)] = -range;
    information[(HEIGHT, DESCENT)] = -range;
    information
}

impl Solution {
    /// Converts the solution to a pose, of a quality of at most `match_quality`.
    ///
    /// # Errors
    /// The residual is above 3 px, or the standard error of the displacement is a metre or more.
    pub(super) fn pose(&self, match_quality: u8) -> Result<Pose, PoseError> {
        if self.noise.position > MAX_RESIDUAL_PX {
            return Err(PoseError::Unexplained { residual: self.noise.position });
        }
        let covariance = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let sigma = larger_eigenvalue(&covariance).sqrt();
        let precision = 255.0 * (1.0 - sigma / MAX_STANDARD_ERROR_M);
        if precision.is_nan() || precision < 1.0 {
            return Err(PoseError::Uncertain { sigma });
        }
        let variance = |i: usize| self.covariance[(i, i)];
        let view = |first: usize, height: f64| FittedView {
            attitude: Attitude {
                roll: self.unknowns[first],
                pitch: self.unknowns[first + 1],
                yaw: self.unknowns[first + 2],
            },
            height,
            tilt: variance(first).max(variance(first + 1)).sqrt(),
            heading: variance(first + 2).sqrt(),
        };
        let (descent, h) = (self.unknowns[DESCENT], self.unknowns[HEIGHT]);
        Ok(Pose {
            displacement: Vector2::new(self.unknowns[0], self.unknowns[1]),
            descent,
            reference: view(HEIGHT + 1, h),
            current: view(DESCENT + 1, h - descent),
            covariance,
            residual: self.noise.position,
            relief: self.noise.relief,
            quality: (precision as u8).min(match_quality),
        })
    }
}

/// Returns the larger eigenvalue of a symmetric matrix.
fn larger_eigenvalue(covariance: &Matrix2<f64>) -> f64 {
    let (a, b, d) = (covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]);
    let half = (a - d) / 2.0;
    (a + d) / 2.0 + (half * half + b * b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::pose::tests::{WIDE, flight};
    use proptest::prelude::*;

    #[test]
    fn oscillating_steps_converge_and_converging_steps_are_kept() {
        let steps_until_converged = |error_after_a_step: f64| {
            let (mut at, mut relaxation, mut last) = (100.0f64, 1.0, None);
            (0..50).position(|_| {
                let step = (error_after_a_step - 1.0) * at;
                relaxation = last.map_or(1.0, |last: f64| relaxed(relaxation, step / last));
                last = Some(step);
                at += relaxation * step;
                step.abs() < CONVERGENCE_STEP_SIGMAS
            })
        };
        for oscillating in [-0.98, -0.9, -0.5, -1.3] {
            assert!(steps_until_converged(oscillating).is_some_and(|steps| steps <= 5), "{oscillating}");
        }
        assert_eq!(relaxed(1.0, -0.1), 1.0);
        assert_eq!(relaxed(1.0, 0.5), 1.0);
        assert_eq!(relaxed(0.5, 0.9), 1.0);
        assert_eq!(relaxed(0.5, 1.5), MIN_RELAXATION);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Against differences of 1e-5 m and radians: the second-order error is below 1e-6 of a derivative of a few
        /// hundred px.
        #[test]
        fn derivatives_are_those_of_the_homography(seed in any::<u64>()) {
            let flight = flight(seed, &WIDE);
            let [reference, current] = flight.views;
            let cameras = Cameras { from: reference.camera().inverse(), to: current.camera().matrix() };
            let at = Unknowns::from([1.0, -2.0, 0.5, 0.03, -0.05, 0.1, 100.0, 0.07, 0.02, -0.2, 0.04, -0.03]);
            let (_, derivatives) = cameras.homography(&at);
            for k in 0..UNKNOWNS {
                let mut step = Unknowns::zeros();
                step[k] = 1e-5;
                let difference = (cameras.homography(&(at + step)).0 - cameras.homography(&(at - step)).0) / 2e-5;
                let (derivative, tolerance) = (derivatives[k], 1e-4 * (1.0 + difference.abs().max()));
                prop_assert!((difference - derivative).abs().max() < tolerance, "{k}: {difference} {derivative}");
            }
        }
    }
}
