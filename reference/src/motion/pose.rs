//! Displacement in metres from matched pairs, IMU and laser rangefinder, by weighted least squares:
//!
//! ```text
//! min sum rho(e)  + sum (reading - unknown)^2 / sigma^2,    e = p' - H p,    H = K R_c^T B R_r K^-1
//! B = h I - t n^T,    n = (slope_x, slope_y, 1)
//! ```
//!
//! `R_r K^-1` maps a pixel `p` of REF to a direction in the level frame. `B` maps from the plane below REF, at height
//! `h` (m), to the position of the camera in CUR; `t` is the displacement from REF to CUR (m) along `X_e`, `Y_e` and
//! down. `K R_c^T` maps to a pixel of CUR. Frames, signs and angles are those of [`crate::motion::orthophoto`].
//!
//! The unknowns are `t` and `R_c` of CUR, and `h` and `R_r` of REF. Each reading is a prior: roll, pitch and yaw of
//! both frames, `h` and `h - tz`. Each error therefore enters once, and the covariance of `tx` and `ty` includes all of
//! them. What is known of REF may be more than one reading: the fit also tells what is known of both views after it
//! ([`Pose::reference`], [`Pose::current`]), which can be the prior of a fit with the next frame. The solver is
//! Gauss-Newton with exact derivatives. `rho` is Huber's, in the metric of the noise of the pairs, which is estimated
//! from their own residual ([`crate::motion::robust`]).
//!
//! **Relief.** The ground is first taken for a level plane. Where the pairs show relief ([`crate::motion::relief`]), or
//! readings and pairs disagree, two more are tried, in this order:
//!
//! 1. A plane with things on it. Pairs whose error is not noise lie on houses and trees and are left out; six in ten
//!    must remain. Heights of a town are not normal: a street and a roof 12 m above it pull a normal model to slopes of
//!    ten degrees that are not there. From a place a few centimetres away a roof differs from the ground by less than
//!    noise, and still tilts the plane. Who has seen it from further away says which pairs lie on it
//!    ([`Agreed::things`]): no plane is fitted to them.
//! 2. Hills: a height of its own for each part of the ground.
//!
//! In both the plane may have a slope, and the laser may hit what is not the plane: its standard error is then 3 m.
//! [`Terrain`] says what is known of height and slope; from a single reading a slope of 3 degrees rms.
//!
//! With IMU and laser alone, the error of the displacement is `h` times the error of the relative tilt: 0.2 degrees at
//! 100 m are 0.35 m per axis and frame. The pairs reduce it, because tilt changes the perspective of the picture and
//! displacement does not. `s` (px per axis) is estimated from the residual of the pairs, `s^2 = sum |e|^2 / (2 n - 8)`,
//! 8 being the parameters of `H`. Relief is treated as noise, although the parallax of neighbouring points is
//! correlated. In simulation at 100 m, with 0.2 degrees of tilt error and 300 pairs of 0.3 px, the mean error falls
//! from 0.64 m to 0.05 m with a field of view of 50 degrees over flat ground, and to 0.16 m with 10 degrees; the
//! covariance agrees with both. Over hills of 3 m it falls to 0.24 m, and the computed standard error is a quarter of
//! the true one.
//!
//! Quality 0 ..= 255 is the smaller of that of the match and `255 (1 - sigma / 1 m)`, `sigma` the standard error along
//! the worse direction; 0 is no estimate. The plane-induced homography: Hartley and Zisserman, 2004, section 13.1.

use crate::motion::budget::Budget;
use crate::motion::model::{Pair, transfer};
use crate::motion::orthophoto::{Attitude, View};
use crate::motion::refusal::{self, Refusal};
use crate::motion::relief::{self, Cells, EVIDENCE, Noise, Residual, normal_equations};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Standard errors of one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensors {
    /// Roll and pitch of the IMU, radians.
    pub tilt: f64,
    /// Yaw of the IMU, radians.
    pub heading: f64,
    /// Laser, m.
    pub range: f64,
}

/// Standard errors of attitude and height of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Roll and pitch, radians.
    pub tilt: f64,
    /// Yaw, radians.
    pub heading: f64,
    /// Height over a level plane, m.
    pub level: f64,
    /// Height over the mean of a ground with relief, m.
    pub hills: f64,
}

impl From<Sensors> for Errors {
    /// Of one reading of each: over relief the laser may hit any hill.
    fn from(sensors: Sensors) -> Self {
        let Sensors { tilt, heading, range } = sensors;
        Self { tilt, heading, level: range, hills: range.hypot(HILLS) }
    }
}

/// The ground below REF: `depth + slope . (x, y) = height`, from the camera, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terrain {
    /// Of the camera over the plane, m.
    pub height: f64,
    /// Of the plane along `X_e` and `Y_e`: ground that rises is positive.
    pub slope: Vector2<f64>,
    /// Covariance of height and slope.
    pub covariance: Matrix3<f64>,
    /// Whether the beams of several frames tell of it: a single one knows no slope.
    pub measured: bool,
}

impl Terrain {
    /// What one reading of the laser tells.
    pub fn of(sight: &Sight) -> Self {
        let hills = sight.errors.hills;
        let covariance = Matrix3::from_diagonal(&Vector3::new(hills * hills, SLOPE * SLOPE, SLOPE * SLOPE));
        Self { height: sight.view.height(), slope: Vector2::zeros(), covariance, measured: false }
    }

    /// Whether a level plane could be seen with this slope by chance.
    fn may_be_level(&self) -> bool {
        let covariance = self.covariance.fixed_view::<2, 2>(1, 1).into_owned();
        covariance.try_inverse().is_some_and(|inverse| self.slope.dot(&(inverse * self.slope)) < CHI2_LEVEL)
    }
}

/// A view, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Attitude and height.
    pub view: View,
    /// Their standard errors.
    pub errors: Errors,
}

/// What a fit tells of a view: attitude and height, and their standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Attitude.
    pub attitude: Attitude,
    /// Height over the plane below the camera, m.
    pub height: f64,
    /// Standard error of the worse one of roll and pitch, radians.
    pub tilt: f64,
    /// Standard error of the yaw, radians.
    pub heading: f64,
}

/// Pose of the camera in CUR relative to REF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// From REF to CUR along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// From REF to CUR downwards, m.
    pub descent: f64,
    /// What is known of REF now.
    pub reference: Found,
    /// What is known of CUR now.
    pub current: Found,
    /// Covariance of the displacement, m^2.
    pub covariance: Matrix2<f64>,
    /// Residual of the pairs, px per axis.
    pub residual: f64,
    /// Standard deviation of the ground's height over the plane, m; 0 where the ground is taken for a plane.
    pub relief: f64,
    /// Quality, 0 ..= 255.
    pub quality: u8,
}

/// Why there is no pose.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// Standard errors must be positive.
    #[error("standard errors of IMU and laser must be positive and finite")]
    Sensors,
    /// Eight parameters of a homography and a residual need five pairs.
    #[error("no estimate: {0} pairs, and a pose needs {FEWEST}")]
    TooFew(usize),
    /// A pair does not lie on the ground, or the iteration found no minimum.
    #[error("no estimate: the pose does not converge")]
    NotConverged,
    /// The work that was allowed ended before the pose settled.
    #[error("no estimate: the work allowed ended before the pose settled")]
    Late,
    /// The pairs contradict the attitude or height of IMU and laser.
    #[error("no estimate: pictures and sensors disagree (chi squared {chi2:.1}, at most {CHI2_LIMIT} by chance)")]
    Disagreement {
        /// Sum of squared deviations over their variances.
        chi2: f64,
    },
    /// No pose near the readings explains the pairs.
    #[error("no estimate: pictures and sensors disagree (the pairs are {residual:.1} px off the pose that fits best)")]
    Unexplained {
        /// Residual of the pairs, px per axis.
        residual: f64,
    },
    /// The pairs do not show the ground.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The standard error is a metre or more.
    #[error("no estimate: the displacement is known to {sigma:.2} m only")]
    Uncertain {
        /// Standard error along the worse direction, m.
        sigma: f64,
    },
}

/// Largest standard error of a displacement, m: the required accuracy of the whole system.
pub const USELESS: f64 = 1.0;

/// Eight readings and the eight freedoms of a homography for ten unknowns leave six degrees of freedom, of which chi
/// squared exceeds this once in a million: `exp(-x/2) (1 + x/2 + x^2/8) = 1e-6`.
pub const CHI2_LIMIT: f64 = 38.3;

/// Chi squared above which the ground is not taken for a level plane: chance brings it once in 1000 flights.
const CHI2_SUSPECT: f64 = 22.5;

/// Chi squared of two slopes above which the ground is known not to be level: chance brings it once in 1000 flights.
const CHI2_LEVEL: f64 = 13.8;

/// Standard deviation of what the laser hits over relief, m.
const HILLS: f64 = 3.0;

/// Standard deviation of the slope of a ground with relief, radians: 3 degrees.
const SLOPE: f64 = 0.052;

/// The same of a level plane: none, within rounding.
const PLANE_SLOPE: f64 = 1e-5;

/// Evidence of relief in a part of the pairs above which the plane is not tried with all: the pose is not settled yet.
const CLEAR_EVIDENCE: f64 = 3.0 * EVIDENCE;

/// Indices of `tz` and `h` among the unknowns; roll, pitch and yaw of CUR and of REF come after them.
const DESCENT: usize = 2;
const HEIGHT: usize = 6;

/// Index of the first slope.
const SLOPES: usize = 10;

/// The residual is not believed to be below this, px an axis: no comparison of frames with noise knows better.
const LEAST_RESIDUAL: f64 = 0.02;

/// Largest residual, px an axis. Pairs of a consensus are within 3 px of a homography, and a pose has all its freedoms:
/// a larger residual is not noise, but what the readings forbid.
const MOST_RESIDUAL: f64 = 3.0;

const ITERATIONS: usize = 50;

/// Iterations that update the noise. Then it is constant, because with few pairs noise and unknowns may oscillate.
const NOISE_ITERATIONS: usize = 7;

/// The pose has settled when a step is shorter than this, in standard errors: its squared length in the metric of the
/// normal equations is that of the unknowns' covariance.
const SETTLED: f64 = 1e-2;

/// The same among a part of the pairs, where the fit starts.
const APPROACHED: f64 = 1.0;

/// Pairs of that part: they bring the pose within some standard errors of all pairs.
const FEW: usize = 128;

/// Part of the candidates that must show the ground between things on it.
const LEAST_GROUND: f64 = 0.6;

/// An error of more than so many standard deviations is not noise: one pair in 500 has it by chance.
const NOT_NOISE: f64 = 3.5;

/// Pairs that a pose needs: eight parameters of a homography and a residual.
const FEWEST: usize = 5;

/// How often pairs are sorted into ground and things; the second time by the plane that the first has left.
const SORTINGS: usize = 2;

/// Work units of an iteration, by instructions on the ARM: homography, derivatives and solution.
const ITERATION_WORK: usize = 3000;

/// Work units of a pair in an iteration.
const RESIDUAL_WORK: usize = 40;

/// The displacement that IMU and laser alone give: mean difference of the rectified positions, m.
pub fn rectified_displacement(reference: &View, current: &View, pairs: &[Pair]) -> Option<Vector2<f64>> {
    let (from, to) = (reference.to_ground(), current.to_ground());
    let mut sum = Vector2::zeros();
    for pair in pairs {
        sum += transfer(&from, pair.reference)? - transfer(&to, pair.current)?;
    }
    (!pairs.is_empty()).then(|| sum / pairs.len() as f64)
}

/// Memory of [`fit_in`], to be used again: after a first fit of as many pairs none is allocated.
#[derive(Debug, Clone)]
pub struct PoseBuffers {
    residuals: Vec<Residual>,
    values: Vec<f64>,
    places: Vec<Vector2<f64>>,
    kept: Vec<Pair>,
    cells: Cells,
    off: Vec<bool>,
}

impl PoseBuffers {
    /// Memory for `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self {
            residuals: Vec::with_capacity(pairs),
            values: Vec::with_capacity(pairs),
            places: Vec::with_capacity(pairs),
            kept: Vec::with_capacity(pairs),
            cells: Cells::new(),
            off: Vec::with_capacity(pairs),
        }
    }

    /// For each pair of the last fit, whether its error is not noise, so that it is not on the ground's plane. Empty
    /// where the ground was taken for hills, and where there was no fit.
    pub fn off(&self) -> &[bool] {
        &self.off
    }
}

/// The pairs of a consensus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreed<'pairs> {
    /// All of them.
    pub pairs: &'pairs [Pair],
    /// The last so many of them are known to lie on things on the ground, and not on its plane.
    pub things: usize,
    /// Quality of the search, 0 ..= 255.
    pub quality: u8,
}

/// The pose of CUR from pairs without outliers, `match_quality` that of the consensus they come from.
///
/// # Errors
/// A standard error is not positive and finite, or there is no estimate.
pub fn fit(
    reference: &View,
    current: &View,
    sensors: &Sensors,
    pairs: &[Pair],
    match_quality: u8,
) -> Result<Pose, PoseError> {
    let (mut buffers, mut budget) = (PoseBuffers::with_capacity(pairs.len()), Budget::UNLIMITED);
    let sight = |view: &View| Sight { view: *view, errors: (*sensors).into() };
    let (reference, current) = (sight(reference), sight(current));
    let terrain = Terrain::of(&reference);
    let agreed = Agreed { pairs, things: 0, quality: match_quality };
    fit_in(&mut buffers, &mut budget, &reference, &terrain, &current, agreed)
}

/// The same with memory that is used again, with bounded work, and with what is known of each view.
///
/// # Errors
/// As [`fit`], and where `budget` ends before the pose has settled: a pose on its way has no covariance.
pub fn fit_in(
    buffers: &mut PoseBuffers,
    budget: &mut Budget,
    reference: &Sight,
    terrain: &Terrain,
    current: &Sight,
    Agreed { pairs, things, quality }: Agreed<'_>,
) -> Result<Pose, PoseError> {
    buffers.off.clear();
    let errors = [reference.errors, current.errors];
    let all = errors.iter().flat_map(|errors| [errors.tilt, errors.heading, errors.level, errors.hills]);
    if all.into_iter().any(|sigma| !(sigma > 0.0 && sigma.is_finite())) {
        return Err(PoseError::Sensors);
    }
    let candidates = &pairs[..pairs.len().saturating_sub(things)];
    if candidates.len() < FEWEST {
        return Err(PoseError::TooFew(candidates.len()));
    }
    refusal::sensor(pairs, reference, current)?;
    let (reference, current) = (&reference.view, &current.view);
    let start = rectified_displacement(reference, current, pairs).ok_or(PoseError::NotConverged)?;
    let (from, to) = (reference.attitude(), current.attitude());
    let (h, descent) = (reference.height(), reference.height() - current.height());
    let readings = Unknowns::from([
        start.x, start.y, descent, to.roll, to.pitch, to.yaw, h, from.roll, from.pitch, from.yaw, 0.0, 0.0,
    ]);
    // The laser meets the slope beside the camera.
    let beside = to.rotation().column(2).xy() * (current.height() / to.rotation()[(2, 2)]);
    let mut sloped = readings;
    sloped[DESCENT] = terrain.height - current.height() - terrain.slope.dot(&beside);
    sloped[HEIGHT] = terrain.height;
    sloped[SLOPES] = terrain.slope.x;
    sloped[SLOPES + 1] = terrain.slope.y;
    let (may_be_level, measured) = (terrain.may_be_level(), terrain.measured);
    let terrain = terrain.covariance.try_inverse().ok_or(PoseError::Sensors)?;
    let scene = Scene { from: reference.camera().inverse(), to: current.camera().matrix() };
    let overlap = relief::overlap(pairs, &mut buffers.places, budget).ok_or(PoseError::Late)?;
    let level = readings;
    let mut problem =
        Problem { scene, level, sloped, errors, terrain, measured, pairs, candidates, buffers, budget, overlap };
    let level = if may_be_level { problem.plane() } else { Err(problem.sloped) };
    match level.or_else(|start| problem.things(start).ok_or(start)) {
        Ok(solution) => {
            problem.sort(&solution);
            solution.pose(quality)
        }
        Err(start) => match problem.solve(Ground::Relief, start) {
            Ok(solution) if solution.chi2 > CHI2_LIMIT => Err(PoseError::Disagreement { chi2: solution.chi2 }),
            Ok(solution) => solution.pose(quality),
            Err(error) => Err(error),
        },
    }
}

/// What the ground is taken for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ground {
    /// Level, and where the laser says.
    Plane,
    /// A plane, with things on it that the laser may hit. Most pairs show the ground between them.
    Things,
    /// Hills on a slope; the laser may hit any of them.
    Relief,
}

/// The fit, with its memory.
struct Problem<'pairs> {
    scene: Scene,
    /// The readings over a level plane.
    level: Unknowns,
    /// The same over other ground.
    sloped: Unknowns,
    /// Of height and slope of other ground, inverse of the covariance.
    terrain: Matrix3<f64>,
    measured: bool,
    /// Of the readings of REF and of CUR.
    errors: [Errors; 2],
    pairs: &'pairs [Pair],
    /// Those that may lie on the plane.
    candidates: &'pairs [Pair],
    buffers: &'pairs mut PoseBuffers,
    budget: &'pairs mut Budget,
    /// Of the pairs' supports ([`relief::overlap`]).
    overlap: f64,
}

/// A minimum.
struct Solution {
    unknowns: Unknowns,
    covariance: Information,
    noise: Noise,
    /// Sum of squared deviations from the readings over their variances.
    chi2: f64,
}

impl Problem<'_> {
    /// Over a level plane; where that does not explain the pairs, the unknowns so far. A part of the pairs often shows
    /// the relief already.
    fn plane(&mut self) -> Result<Solution, Unknowns> {
        let mut start = self.level;
        if self.stride() > 1 {
            if let Ok(solution) = self.settle(Ground::Plane, start, self.stride(), APPROACHED) {
                start = solution.unknowns;
            }
            if self.evidence() > CLEAR_EVIDENCE {
                return Err(start);
            }
        }
        let solution = self.settle(Ground::Plane, start, 1, SETTLED).map_err(|_| start)?;
        let plane = solution.chi2 < CHI2_SUSPECT && self.evidence() < EVIDENCE;
        if plane { Ok(solution) } else { Err(solution.unknowns) }
    }

    /// One in so many pairs is [`FEW`] of them.
    fn stride(&self) -> usize {
        (self.pairs.len() / FEW).max(1)
    }

    /// Over a plane with things on it: pairs whose error is not noise are left out. `None` where they are many, where
    /// the readings contradict what is left, or where that may be a hill: no beams have told of its slope, and it shows
    /// relief.
    fn things(&mut self, start: Unknowns) -> Option<Solution> {
        self.buffers.kept.clear();
        self.buffers.kept.extend_from_slice(self.candidates);
        let mut found = self.settle(Ground::Things, start, self.stride(), APPROACHED).ok()?;
        for _ in 0..SORTINGS {
            if self.keep(&found.unknowns)? < LEAST_GROUND {
                return None;
            }
            found = self.settle(Ground::Things, found.unknowns, 1, SETTLED).ok()?;
        }
        let ground = self.measured || self.evidence() < EVIDENCE;
        (ground && found.chi2 < CHI2_SUSPECT).then_some(found)
    }

    /// Keeps the candidates that the plane of a solution explains, and tells which part of them they are.
    fn keep(&mut self, unknowns: &Unknowns) -> Option<f64> {
        self.linearise(unknowns, self.candidates)?;
        let PoseBuffers { residuals, values, kept, .. } = &mut *self.buffers;
        let noise = Noise { relief: 0.0, ..Noise::of_relief(residuals, LEAST_RESIDUAL, HOMOGRAPHY_FREEDOMS, values) };
        kept.clear();
        let on_plane = residuals.iter().map(|residual| !is_off(&noise, residual));
        kept.extend(self.candidates.iter().zip(on_plane).filter(|(_, on_plane)| *on_plane).map(|(pair, _)| *pair));
        Some(kept.len() as f64 / self.candidates.len() as f64)
    }

    /// Tells which of all pairs the plane of a solution does not explain.
    fn sort(&mut self, solution: &Solution) {
        if self.linearise(&solution.unknowns, self.pairs).is_some() {
            let PoseBuffers { residuals, off, .. } = &mut *self.buffers;
            off.extend(residuals.iter().map(|residual| is_off(&solution.noise, residual)));
        }
    }

    /// The errors of `pairs` under `unknowns` into the residuals.
    fn linearise(&mut self, unknowns: &Unknowns, pairs: &[Pair]) -> Option<()> {
        let (homography, derivatives) = self.scene.homography(unknowns);
        let affordable = self.budget.spend(RESIDUAL_WORK * pairs.len());
        affordable.then(|| linearised(&homography, &derivatives[HEIGHT], pairs.iter(), &mut self.buffers.residuals))?
    }

    fn solve(&mut self, ground: Ground, start: Unknowns) -> Result<Solution, PoseError> {
        let near = match self.stride() {
            1 => start,
            stride => self.settle(ground, start, stride, APPROACHED).map_or(start, |near| near.unknowns),
        };
        self.settle(ground, near, 1, SETTLED)
    }

    /// Iterates with one in `stride` pairs until a step is shorter than `settled` standard errors.
    fn settle(&mut self, ground: Ground, start: Unknowns, stride: usize, settled: f64) -> Result<Solution, PoseError> {
        let PoseBuffers { residuals, values, cells, kept, .. } = &mut *self.buffers;
        let pairs = match ground {
            Ground::Plane => self.candidates,
            Ground::Things => kept,
            Ground::Relief => self.pairs,
        };
        let prior = information(&self.errors, ground, &self.terrain);
        let readings = if ground == Ground::Plane { self.level } else { self.sloped };
        let mut unknowns = start;
        let mut noise = Noise { places: LEAST_RESIDUAL, relief: 0.0 };
        let (mut relaxation, mut before) = (1.0, None);
        for iteration in 0..ITERATIONS {
            if !self.budget.spend(ITERATION_WORK + RESIDUAL_WORK * pairs.len().div_ceil(stride)) {
                return Err(PoseError::Late);
            }
            let (homography, derivatives) = self.scene.homography(&unknowns);
            let parallax = &derivatives[HEIGHT];
            let pairs = pairs.iter().step_by(stride);
            linearised(&homography, parallax, pairs, residuals).ok_or(PoseError::NotConverged)?;
            if iteration < NOISE_ITERATIONS {
                noise = match ground {
                    Ground::Plane | Ground::Things => {
                        Noise::of_plane(residuals, LEAST_RESIDUAL, HOMOGRAPHY_FREEDOMS, values)
                    }
                    Ground::Relief => Noise::of_relief(residuals, LEAST_RESIDUAL, HOMOGRAPHY_FREEDOMS, values),
                };
            }
            let (normal, gradient) = normal_equations(residuals, &derivatives, &noise, cells);
            let factor = (normal + prior).cholesky().ok_or(PoseError::NotConverged)?;
            let gradient = gradient + prior * (readings - unknowns);
            let step = factor.solve(&gradient);
            let length2 = step.dot(&gradient);
            relaxation = before.map_or(1.0, |(last, last2)| relaxed(relaxation, gradient.dot(&last) / last2));
            before = Some((step, length2));
            unknowns += step * relaxation;
            if length2 < settled * settled {
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

    /// For relief, by the residuals of the last solution.
    fn evidence(&mut self) -> f64 {
        let PoseBuffers { residuals, values, .. } = &mut *self.buffers;
        Noise::of_relief(residuals, LEAST_RESIDUAL, HOMOGRAPHY_FREEDOMS, values).evidence(residuals)
    }
}

/// Whether a pair's error is not noise.
fn is_off(noise: &Noise, residual: &Residual) -> bool {
    noise.length2(residual) >= NOT_NOISE * NOT_NOISE
}

/// The part of the next step that is taken, by the part that was taken of the last one and the part of it that
/// the next one repeats: 0 where the last one arrived, below where it went too far. Where steps go to and fro between
/// two sides of the minimum, as pairs enter and leave Huber's bound, the next one goes to where the two would meet
/// (Aitken 1926, for vectors Irons and Tuck 1969). Where a shortened step is followed by a longer one, the least part.
fn relaxed(last: f64, repeated: f64) -> f64 {
    if repeated > -TO_AND_FRO && last == 1.0 { 1.0 } else { (last / (1.0 - repeated)).clamp(LEAST_RELAXATION, 1.0) }
}

/// Part of a step that the next one takes back, above which steps go to and fro.
const TO_AND_FRO: f64 = 0.25;

/// No step is shortened to less than this part.
const LEAST_RELAXATION: f64 = 0.2;

/// Of the plane-induced homography.
const HOMOGRAPHY_FREEDOMS: usize = 8;

const UNKNOWNS: usize = 12;

/// `tx, ty, tz` and roll, pitch, yaw of CUR; `h` and roll, pitch, yaw of REF; slope of the ground along `X_e` and
/// `Y_e`.
type Unknowns = SVector<f64, UNKNOWNS>;

type Information = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// What is known beforehand: each angle, `h`, and `h - tz`; nothing of `tx` and `ty`. And what is known of the ground.
fn information([reference, current]: &[Errors; 2], ground: Ground, terrain: &Matrix3<f64>) -> Information {
    let of = |sigma: f64| 1.0 / (sigma * sigma);
    let level = Matrix3::from_diagonal(&Vector3::new(of(reference.level), of(PLANE_SLOPE), of(PLANE_SLOPE)));
    let (range, terrain) = match ground {
        Ground::Plane => (of(current.level), &level),
        Ground::Things | Ground::Relief => (of(current.hills), terrain),
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
    const TERRAIN: [usize; 3] = [HEIGHT, SLOPES, SLOPES + 1];
    for (row, i) in TERRAIN.into_iter().enumerate() {
        for (column, j) in TERRAIN.into_iter().enumerate() {
            information[(i, j)] += terrain[(row, column)];
        }
    }
    information[(DESCENT, HEIGHT)] = -range;
    information[(HEIGHT, DESCENT)] = -range;
    information
}

/// The constant parts of the homography.
struct Scene {
    /// `K^-1` of REF.
    from: Matrix3<f64>,
    /// `K` of CUR.
    to: Matrix3<f64>,
}

impl Scene {
    /// `H` and its derivatives by the unknowns.
    fn homography(&self, unknowns: &Unknowns) -> (Matrix3<f64>, [Matrix3<f64>; UNKNOWNS]) {
        let [tx, ty, tz, roll_c, pitch_c, yaw_c, h, roll_r, pitch_r, yaw_r, slope_x, slope_y] = (*unknowns).into();
        let into_current = Attitude { roll: roll_c, pitch: pitch_c, yaw: yaw_c }.factors();
        let from_reference = Attitude { roll: roll_r, pitch: pitch_r, yaw: yaw_r }.factors();
        let left = self.to * rotation(&into_current, None).transpose();
        let right = rotation(&from_reference, None) * self.from;
        let (t, normal) = (Vector3::new(tx, ty, tz), Vector3::new(slope_x, slope_y, 1.0));
        let b = Matrix3::identity() * h - t * normal.transpose();
        let (b_right, left_b) = (b * right, left * b);
        let (seen, moved) = (normal.transpose() * right, left * t);
        let by_place = |row: usize| left.column(row) * -seen;
        let by_slope = |column: usize| -moved * right.row(column);
        let by_current = |k: usize| self.to * rotation(&into_current, Some(k)).transpose() * b_right;
        let by_reference = |k: usize| left_b * rotation(&from_reference, Some(k)) * self.from;
        let derivatives = [
            by_place(0),
            by_place(1),
            by_place(2),
            by_current(0),
            by_current(1),
            by_current(2),
            left * right,
            by_reference(0),
            by_reference(1),
            by_reference(2),
            by_slope(0),
            by_slope(1),
        ];
        (left * b_right, derivatives)
    }
}

/// The errors `p' - H p` of the pairs into `residuals`; `None` where a position is not in view. `by_height` is the
/// derivative of `H` by the height of the camera.
fn linearised<'pairs>(
    h: &Matrix3<f64>,
    by_height: &Matrix3<f64>,
    pairs: impl Iterator<Item = &'pairs Pair>,
    residuals: &mut Vec<Residual>,
) -> Option<()> {
    residuals.clear();
    for pair in pairs {
        let p = pair.reference.push(1.0);
        let image = h * p;
        if image.z.is_nan() || image.z <= 0.0 {
            return None;
        }
        let position = image.xy() / image.z;
        let error = pair.current - position;
        if !(error.x.is_finite() && error.y.is_finite()) {
            return None;
        }
        let change = by_height * p;
        // Ground that is a metre higher moves as if the camera were a metre lower.
        let parallax = (position * change.z - change.xy()) / image.z;
        residuals.push(Residual::new(pair.reference, image, parallax, error));
    }
    Some(())
}

/// `R`, or its derivative by roll (0), pitch (1) or yaw (2): a rotation about an axis changes with its angle by the
/// cross product with the axis times itself.
fn rotation(factors: &[Matrix3<f64>; 3], changed: Option<usize>) -> Matrix3<f64> {
    let about = [Vector3::<f64>::y(), -Vector3::x(), Vector3::z()];
    let mut factors = *factors;
    if let Some(k) = changed {
        factors[k] = about[k].cross_matrix() * factors[k];
    }
    let [roll, pitch, yaw] = factors;
    yaw * pitch * roll
}

/// The larger eigenvalue of a symmetric matrix.
fn worse_direction(covariance: &Matrix2<f64>) -> f64 {
    let (a, b, d) = (covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]);
    let half = (a - d) / 2.0;
    (a + d) / 2.0 + (half * half + b * b).sqrt()
}

impl Solution {
    fn pose(&self, match_quality: u8) -> Result<Pose, PoseError> {
        if self.noise.places > MOST_RESIDUAL {
            return Err(PoseError::Unexplained { residual: self.noise.places });
        }
        let covariance = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let sigma = worse_direction(&covariance).sqrt();
        let precision = 255.0 * (1.0 - sigma / USELESS);
        if precision.is_nan() || precision < 1.0 {
            return Err(PoseError::Uncertain { sigma });
        }
        let variance = |i: usize| self.covariance[(i, i)];
        let found = |first: usize, height: f64| Found {
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
            reference: found(HEIGHT + 1, h),
            current: found(DESCENT + 1, h - descent),
            covariance,
            residual: self.noise.places,
            relief: self.noise.relief,
            quality: (precision as u8).min(match_quality),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::orthophoto::Camera;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const DEGREE: f64 = std::f64::consts::PI / 180.0;
    const SENSORS: Sensors = Sensors { tilt: 0.2 * DEGREE, heading: 0.5 * DEGREE, range: 0.2 };

    /// A flight over the ground: two true poses, what the sensors say of them, and pairs.
    struct Flight {
        views: [View; 2],
        pairs: Vec<Pair>,
        displacement: Vector2<f64>,
        descent: f64,
        attitude: Attitude,
    }

    /// Sum of twelve uniform numbers: variance 1.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    /// Hills and hollows are `pi` times this apart, m: two of them lie side by side in 93 m, the frame of 50 degrees at
    /// 100 m.
    const RELIEF_SCALE: f64 = 15.0;

    struct Conditions {
        /// Degrees over 1024 columns.
        field_of_view: f64,
        /// Height of the hills and depth of the hollows between them, m.
        relief: f64,
        /// Rise of the ground along `X_e`.
        slope: f64,
        /// Height of houses, which every fifth pair and the laser of CUR see, m.
        houses: f64,
        /// Noise of positions, px an axis.
        pixel: f64,
        /// Noise of the sensors, in their standard errors.
        sensors: f64,
    }

    /// 100 m up, up to 5 degrees of tilt, 2 m of descent, and between the frames a tilt of a twentieth of the field of
    /// view and a drift that moves the picture by as much again, so that they overlap; geometry by rays, no homography.
    fn flight(seed: u64, conditions: &Conditions) -> Flight {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |most: f64| most * (2.0 * rng.random::<f64>() - 1.0);
        let field_of_view = conditions.field_of_view * DEGREE;
        let camera = Camera::with_field_of_view(1024, 768, field_of_view).unwrap();
        let first = Attitude { roll: within(5.0 * DEGREE), pitch: within(5.0 * DEGREE), yaw: within(0.1) };
        let apart = field_of_view / 20.0;
        let second = Attitude {
            roll: first.roll + within(apart),
            pitch: first.pitch + within(apart),
            yaw: first.yaw + within(0.1),
        };
        let attitudes = [first, second];
        let displacement = Vector2::new(within(100.0 * apart), within(100.0 * apart));
        let descent = within(2.0);
        let heights = [100.0, 100.0 - descent];
        let positions = [Vector2::zeros(), displacement];
        let crest = Vector2::new(within(3.0), within(3.0));
        let mut pairs = Vec::new();
        let rotation = attitudes.map(|attitude| attitude.rotation());
        while pairs.len() < 300 {
            let pixel = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
            let ray = rotation[0] * (camera.inverse() * pixel.push(1.0));
            let flat = ray.xy() * (heights[0] / ray.z) / RELIEF_SCALE + crest;
            let house = if pairs.len() % 5 == 0 { conditions.houses } else { 0.0 };
            let level = heights[0] + conditions.relief * flat.x.sin() * flat.y.sin() - house;
            let depth = level / (1.0 + conditions.slope * ray.x / ray.z);
            let point = ray.xy() * (depth / ray.z);
            let seen = rotation[1].transpose() * (point - positions[1]).push(depth - descent);
            let image = (camera.matrix() * seen / seen.z).xy();
            if (0.0..1024.0).contains(&image.x) && (0.0..768.0).contains(&image.y) {
                let mut noisy =
                    |p: Vector2<f64>| p + conditions.pixel * Vector2::new(normal(&mut rng), normal(&mut rng));
                pairs.push(Pair { reference: noisy(pixel), current: noisy(image) });
            }
        }
        let views = [0, 1].map(|i| {
            let mut error = |sigma: f64| conditions.sensors * sigma * normal(&mut rng);
            let told = Attitude {
                roll: attitudes[i].roll + error(SENSORS.tilt),
                pitch: attitudes[i].pitch + error(SENSORS.tilt),
                yaw: attitudes[i].yaw + error(SENSORS.heading),
            };
            let axis = rotation[i].column(2);
            let house = conditions.houses * i as f64;
            let met = (heights[i] - conditions.slope * positions[i].x - house) / (axis.z + conditions.slope * axis.x);
            let range = met + error(SENSORS.range);
            View::new(camera, told, range).unwrap()
        });
        Flight { views, pairs, displacement, descent, attitude: attitudes[1] }
    }

    fn fitted(flight: &Flight) -> Result<Pose, PoseError> {
        fit(&flight.views[0], &flight.views[1], &SENSORS, &flight.pairs, 255)
    }

    /// Mean length of the displacement's error (m) with IMU and laser alone, and with the fit; mean of the squared
    /// error over its covariance, 2 where the covariance is true.
    fn errors(conditions: &Conditions) -> [f64; 3] {
        let flights = 200;
        let mut sums = Vector3::zeros();
        for seed in 0..flights {
            let flight = flight(seed, conditions);
            let pose = fitted(&flight).unwrap();
            let rectified = rectified_displacement(&flight.views[0], &flight.views[1], &flight.pairs).unwrap();
            let error = pose.displacement - flight.displacement;
            let normalised = error.dot(&(pose.covariance.try_inverse().unwrap() * error));
            sums += Vector3::new((rectified - flight.displacement).norm(), error.norm(), normalised);
        }
        (sums / flights as f64).into()
    }

    const WIDE: Conditions =
        Conditions { field_of_view: 50.0, relief: 0.0, slope: 0.0, houses: 0.0, pixel: 0.3, sensors: 1.0 };

    /// Steps of an iteration that is on either side of 0 by turns arrive; those of one that converges are not changed.
    #[test]
    fn steps_that_go_to_and_fro_arrive() {
        let steps_until_settled = |error_after_a_step: f64| {
            let (mut at, mut relaxation, mut last) = (100.0f64, 1.0, None);
            (0..50).position(|_| {
                let step = (error_after_a_step - 1.0) * at;
                relaxation = last.map_or(1.0, |last: f64| relaxed(relaxation, step / last));
                last = Some(step);
                at += relaxation * step;
                step.abs() < SETTLED
            })
        };
        for to_and_fro in [-0.98, -0.9, -0.5, -1.3] {
            assert!(steps_until_settled(to_and_fro).is_some_and(|steps| steps <= 5), "{to_and_fro}");
        }
        assert_eq!(relaxed(1.0, -0.1), 1.0);
        assert_eq!(relaxed(1.0, 0.5), 1.0);
        assert_eq!(relaxed(0.5, 0.9), 1.0);
        assert_eq!(relaxed(0.5, 1.5), LEAST_RELAXATION);
    }

    /// 0.2 degrees at 100 m are 0.35 m an axis and a frame, 0.49 m an axis for two frames; the mean length of that is
    /// sqrt(pi / 2) 0.49 m = 0.62 m, and the laser adds little. What the pairs make of it is measured: 300 of them, 0.3
    /// px.
    #[test]
    fn the_fit_is_more_accurate_than_imu_and_laser_alone() {
        let cases = [
            ("wide, flat", WIDE, 0.06),
            ("10 degrees, flat", Conditions { field_of_view: 10.0, ..WIDE }, 0.20),
            ("wide, hills of 3 m", Conditions { relief: 3.0, ..WIDE }, 0.30),
        ];
        for (name, conditions, most) in cases {
            let [alone, fit, normalised] = errors(&conditions);
            let told = format!("{name}: {alone:.3} m alone, {fit:.3} m with the fit, normalised {normalised:.2}");
            eprintln!("{told}");
            assert!((0.55..0.72).contains(&alone) && fit < most, "{told}");
            // Chi squared of 2, whose mean over 200 flights is known to 0.14; four times that is allowed.
            assert!(conditions.relief > 0.0 || (1.44..2.56).contains(&normalised), "{told}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn without_noise_the_pose_is_exact(seed in any::<u64>(), field_of_view in 5.0..60.0f64) {
            let flight = flight(seed, &Conditions { field_of_view, pixel: 0.0, sensors: 0.0, ..WIDE });
            let pose = fitted(&flight).unwrap();
            prop_assert!((pose.displacement - flight.displacement).norm() < 1e-6, "{pose:?}");
            prop_assert!((pose.descent - flight.descent).abs() < 1e-6);
            let turn = pose.current.attitude.rotation() - flight.attitude.rotation();
            prop_assert!(turn.abs().max() < 1e-7, "{turn}");
        }

        /// Against differences of 1e-5 m and radians: what is left of second order is below 1e-6 of a slope of some
        /// hundred px.
        #[test]
        fn derivatives_are_those_of_the_homography(seed in any::<u64>()) {
            let flight = flight(seed, &WIDE);
            let [reference, current] = flight.views;
            let scene = Scene { from: reference.camera().inverse(), to: current.camera().matrix() };
            let at = Unknowns::from([1.0, -2.0, 0.5, 0.03, -0.05, 0.1, 100.0, 0.07, 0.02, -0.2, 0.04, -0.03]);
            let (_, derivatives) = scene.homography(&at);
            for k in 0..UNKNOWNS {
                let mut step = Unknowns::zeros();
                step[k] = 1e-5;
                let difference = (scene.homography(&(at + step)).0 - scene.homography(&(at - step)).0) / 2e-5;
                let (derivative, tolerance) = (derivatives[k], 1e-4 * (1.0 + difference.abs().max()));
                prop_assert!((difference - derivative).abs().max() < tolerance, "{k}: {difference} {derivative}");
            }
        }
    }

    /// Root mean square error (m) where the ground is known as a flight program knows it after some frames, and where
    /// a single reading tells of it.
    fn with_terrain(conditions: &Conditions) -> [f64; 2] {
        let flights = 100;
        let rms = |known: bool| {
            let errors = (0..flights).map(|seed| {
                let flight = flight(seed, conditions);
                let [reference, mut current] = flight.views.map(|view| Sight { view, errors: SENSORS.into() });
                current.errors.hills = current.errors.hills.max(conditions.houses / 2.0);
                let covariance = Matrix3::from_diagonal(&Vector3::new(0.04, 1e-4, 1e-4));
                let all =
                    Terrain { height: 100.0, slope: Vector2::new(conditions.slope, 0.0), covariance, measured: true };
                let terrain = if known { all } else { Terrain::of(&reference) };
                let (mut buffers, mut budget) = (PoseBuffers::with_capacity(300), Budget::UNLIMITED);
                let agreed = Agreed { pairs: &flight.pairs, things: 0, quality: 255 };
                let pose = fit_in(&mut buffers, &mut budget, &reference, &terrain, &current, agreed);
                (pose.unwrap().displacement - flight.displacement).norm_squared()
            });
            (errors.sum::<f64>() / flights as f64).sqrt()
        };
        [true, false].map(rms)
    }

    /// Roofs 12 m high, and a laser that hits one, cost little more than the pairs that they take.
    #[test]
    fn houses_do_not_tilt_the_ground() {
        let [flat, _] = with_terrain(&WIDE);
        let [town, _] = with_terrain(&Conditions { houses: 12.0, ..WIDE });
        assert!(town < 1.3 * flat, "{town:.3} m, {flat:.3} m without houses");
    }

    /// A roof 12 m high in a corner of the frame, 8 cm beside the reference: its parallax is two standard deviations
    /// of the noise. Taken for ground it turns the plane; the fit tells that it is off, from a metre beside.
    #[test]
    fn a_roof_that_is_known_does_not_turn_the_ground() {
        let camera = Camera::with_field_of_view(1024, 768, 50.0 * DEGREE).unwrap();
        let sight = |range: f64| {
            let view = View::new(camera, Attitude::default(), range).unwrap();
            Sight { view, errors: SENSORS.into() }
        };
        let terrain = Terrain { measured: true, ..Terrain::of(&sight(50.0)) };
        let (mut buffers, mut budget) = (PoseBuffers::with_capacity(330), Budget::UNLIMITED);
        let mut fitted = |beside: f64, things: usize, seed: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut pair = |x: f64, y: f64, depth: f64| {
                let mut noise = || 0.15 * Vector2::new(normal(&mut rng), normal(&mut rng));
                let moved = Vector2::new(beside * camera.focal() / depth, 0.0);
                Pair { reference: Vector2::new(x, y) + noise(), current: Vector2::new(x, y) - moved + noise() }
            };
            let ground: Vec<Pair> =
                (0..300).map(|i| pair(20.0 * f64::from(i % 25), 60.0 * f64::from(i / 25), 50.0)).collect();
            let roof = (0..30).map(|i| pair(900.0 + 10.0 * f64::from(i % 10), 40.0 * f64::from(i / 10), 38.0));
            let pairs: Vec<Pair> = ground.into_iter().chain(roof).collect();
            let agreed = Agreed { pairs: &pairs, things, quality: 255 };
            let pose = fit_in(&mut buffers, &mut budget, &sight(50.0), &terrain, &sight(50.0), agreed).unwrap();
            (pose.displacement.x - beside, buffers.off().to_vec())
        };
        let mut rms = |things: usize| {
            let errors = (0..40).map(|seed| fitted(0.08, things, seed).0.powi(2));
            (errors.sum::<f64>() / 40.0).sqrt()
        };
        let (unknown, known) = (rms(0), rms(30));
        assert!(known < 0.6 * unknown, "{known:.3} m, {unknown:.3} m where the roof is not known");
        let (_, off) = fitted(1.0, 0, 0);
        let said = |off: &[bool]| off.iter().filter(|off| **off).count();
        assert_eq!((off.len(), said(&off[300..])), (330, 30));
        assert!(said(&off[..300]) <= 3, "{off:?}");
    }

    /// A descent over a slope looks like a motion along it, unless the slope is known.
    #[test]
    fn a_known_slope_is_not_taken_for_motion() {
        let [flat, _] = with_terrain(&WIDE);
        let [known, unknown] = with_terrain(&Conditions { slope: 0.2, ..WIDE });
        assert!(known < 1.3 * flat && unknown > 1.5 * known, "{known:.3} m, {unknown:.3} m unknown, {flat:.3} m flat");
    }

    #[test]
    fn contradicting_or_weak_input_gives_no_estimate() {
        let good = flight(1, &WIDE);
        let [reference, current] = good.views;
        let with = |pairs: &[Pair], sensors: &Sensors| fit(&reference, &current, sensors, pairs, 255);
        assert_eq!(with(&good.pairs[..4], &SENSORS), Err(PoseError::TooFew(4)));
        assert_eq!(with(&good.pairs, &Sensors { tilt: 0.0, ..SENSORS }), Err(PoseError::Sensors));
        // Pictures that want 3 degrees more roll than an IMU of 0.2 degrees says.
        let tilted = Attitude { roll: current.attitude().roll + 3.0 * DEGREE, ..*current.attitude() };
        let wrong = View::new(*current.camera(), tilted, current.height()).unwrap();
        let outcome = fit(&reference, &wrong, &SENSORS, &good.pairs, 255);
        assert!(matches!(outcome, Err(PoseError::Disagreement { .. })), "{outcome:?}");
        // And 30 degrees more yaw, of which a fit that takes the residual for noise leaves the most as it is.
        let turned = Attitude { yaw: current.attitude().yaw + 30.0 * DEGREE, ..*current.attitude() };
        let wrong = View::new(*current.camera(), turned, current.height()).unwrap();
        let outcome = fit(&reference, &wrong, &SENSORS, &good.pairs, 255);
        let refused = matches!(outcome, Err(PoseError::Disagreement { .. } | PoseError::Unexplained { .. }));
        assert!(refused, "{outcome:?}");
        // Five pairs in a corner, 0.7 px off to either side, and an IMU of 3 degrees: 100 m tan 3 degrees is 5 m.
        let aside = [0.7, -0.7, 0.7, -0.7, 0.7].map(|x| Vector2::new(x, 0.0));
        let corner: Vec<Pair> = good
            .pairs
            .iter()
            .filter(|pair| pair.reference.x < 300.0 && pair.reference.y < 300.0)
            .zip(aside)
            .map(|(pair, aside)| Pair { current: pair.current + aside, ..*pair })
            .collect();
        let outcome = with(&corner, &Sensors { tilt: 3.0 * DEGREE, ..SENSORS });
        assert!(matches!(outcome, Err(PoseError::Uncertain { sigma }) if sigma > 1.0), "{outcome:?}");
        // The quality of the match is never exceeded.
        assert_eq!(fit(&reference, &current, &SENSORS, &good.pairs, 17).unwrap().quality, 17);
        let pose = with(&good.pairs, &SENSORS).unwrap();
        assert!(pose.quality > 230, "{pose:?}");
    }

    /// Hills of 3 m rms and 120 m, which the laser hits, from 50 m: the frame is smaller than a hill. Small
    /// displacements between frames that tilt by up to 3 degrees; readings with their errors; pairs with a noise of
    /// 0.15 px.
    fn hover_over_hills(seed: u64, reach: f64) -> Flight {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |most: f64| most * (2.0 * rng.random::<f64>() - 1.0);
        let camera = Camera::with_field_of_view(1024, 768, 50.0 * DEGREE).unwrap();
        let waves: [(f64, f64, f64, f64); 8] = std::array::from_fn(|i| {
            let turn = within(std::f64::consts::PI);
            let k = std::f64::consts::TAU / 120.0 * if i < 4 { 1.0 } else { 2.0 };
            let amplitude = 3.0 * (2.0f64 / 4.0).sqrt() * if i < 4 { 0.9 } else { 0.45 };
            (k * turn.cos(), k * turn.sin(), within(3.0), amplitude)
        });
        let ground = |p: Vector2<f64>| waves.iter().map(|(a, b, c, h)| h * (a * p.x + b * p.y + c).sin()).sum::<f64>();
        let mut tilts =
            || Attitude { roll: within(3.0 * DEGREE), pitch: within(3.0 * DEGREE), yaw: 0.2 + within(0.02) };
        let attitudes = [tilts(), tilts()];
        let displacement = Vector2::new(within(reach), within(reach));
        let positions = [Vector2::zeros(), displacement];
        let heights = [50.0, 50.0 + within(0.3)];
        let hit = |place: Vector2<f64>, height: f64, ray: Vector3<f64>| {
            let mut depth = height - ground(place);
            for _ in 0..60 {
                depth = height - ground(place + ray.xy() / ray.z * depth);
            }
            (place + ray.xy() / ray.z * depth, depth)
        };
        let rotation = attitudes.map(|attitude| attitude.rotation());
        let mut pairs = Vec::new();
        while pairs.len() < 500 {
            let pixel = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
            let (point, _) = hit(positions[0], heights[0], rotation[0] * (camera.inverse() * pixel.push(1.0)));
            let seen = rotation[1].transpose() * (point - positions[1]).push(heights[1] - ground(point));
            let image = (camera.matrix() * seen / seen.z).xy();
            if (0.0..1024.0).contains(&image.x) && (0.0..768.0).contains(&image.y) {
                let mut noisy = |p: Vector2<f64>| p + 0.15 * Vector2::new(normal(&mut rng), normal(&mut rng));
                pairs.push(Pair { reference: noisy(pixel), current: noisy(image) });
            }
        }
        let views = [0, 1].map(|i| {
            let mut error = |sigma: f64| sigma * normal(&mut rng);
            let told = Attitude {
                roll: attitudes[i].roll + error(SENSORS.tilt),
                pitch: attitudes[i].pitch + error(SENSORS.tilt),
                yaw: attitudes[i].yaw + error(SENSORS.heading),
            };
            let axis = rotation[i] * Vector3::z();
            let (_, depth) = hit(positions[i], heights[i], axis);
            View::new(camera, told, depth / axis.z + error(0.1)).unwrap()
        });
        Flight { views, pairs, displacement, descent: heights[0] - heights[1], attitude: attitudes[1] }
    }

    /// Height held to 0.3 m. With 3 m of climb the error is 0.27 m, and the covariance tells a tenth of it: hills as
    /// long as the frame look like perspective.
    #[test]
    fn a_hover_over_hills_is_known_to_centimetres() {
        for (reach, most) in [(0.1, 0.04), (0.4, 0.08)] {
            let flights = 40;
            let errors = (0..flights).map(|seed| {
                let flight = hover_over_hills(seed, reach);
                let sensors = Sensors { range: 0.1, ..SENSORS };
                let pose = fit(&flight.views[0], &flight.views[1], &sensors, &flight.pairs, 255).unwrap();
                (pose.displacement - flight.displacement).norm_squared()
            });
            let rms = (errors.sum::<f64>() / flights as f64).sqrt();
            assert!(rms < most, "within {reach} m: {rms:.3} m");
        }
    }
}
