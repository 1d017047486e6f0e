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
//! them. The prior of REF may combine several readings: the fit also returns both views with their standard errors
//! ([`Pose::reference`], [`Pose::current`]), which can be the prior of a fit with the next frame. The solver is
//! Gauss-Newton with exact derivatives. `rho` is Huber's, in the metric of the noise of the pairs, which is estimated
//! from their own residual (module `robust`).
//!
//! **Relief.** The ground is first modelled as a level plane. If the pairs show relief (module `relief`), or
//! readings and pairs disagree, two more models are tried, in this order:
//!
//! 1. A sloped plane fitted to the pairs that are on it. Pairs whose error is not noise are on houses and trees and are
//!    left out; six in ten must remain. Heights of a town are not normally distributed: a street and a roof 12 m above
//!    it would pull a normal model to a slope of ten degrees that does not exist. Seen from a few centimetres away, a
//!    roof differs from the ground by less than the noise and still tilts the plane. A caller that has seen the roof
//!    from further away names those pairs ([`ConsensusPairs::off_plane`]), and no plane is fitted to them.
//! 2. Hills: a height of its own for each cell of the picture.
//!
//! In both models the plane may have a slope, and the laser may hit something off the plane: its standard error is then
//! 3 m. [`TerrainPrior`] holds the prior of height and slope; a single reading gives a slope of 3 degrees rms.
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

mod homography;
mod solver;

use crate::motion::budget::Budget;
use crate::motion::model::{Pair, transfer};
use crate::motion::observation::{FittedView, Observation, SensorErrors, TerrainPrior};
use crate::motion::orthophoto::View;
use crate::motion::refusal::Refusal;
use crate::motion::relief::{self, Cells, Residual};
use crate::motion::sensor_pattern;
use homography::Cameras;
use nalgebra::{Matrix2, Vector2};
use solver::{DESCENT, HEIGHT, Problem, SLOPE_X, SLOPE_Y, Unknowns};

/// Largest standard error of a displacement, m: the required accuracy of the whole system.
const MAX_STANDARD_ERROR_M: f64 = 1.0;

/// Largest chi squared of the readings. Eight readings and the eight degrees of freedom of a homography for ten
/// unknowns leave six degrees of freedom, for which chi squared exceeds this once in a million: `exp(-x/2) (1 + x/2 +
/// x^2/8) = 1e-6`.
const MAX_CHI2: f64 = 38.3;

/// Smallest number of pairs: a homography has eight parameters, two a pair, and a residual needs one pair more.
const MIN_PAIRS: usize = 5;

/// The pose of the camera in CUR relative to REF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Displacement from REF to CUR along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// Displacement from REF to CUR downwards, m.
    pub descent: f64,
    /// Fitted attitude and height of the camera in REF.
    pub reference: FittedView,
    /// Fitted attitude and height of the camera in CUR.
    pub current: FittedView,
    /// Covariance of the displacement, m^2.
    pub covariance: Matrix2<f64>,
    /// Residual of the pairs, px per axis.
    pub residual: f64,
    /// Standard deviation of the ground's height over the plane, m; 0 if the ground is modelled as a plane.
    pub relief: f64,
    /// Quality, 0 ..= 255; 0 is no estimate.
    pub quality: u8,
}

/// An error of a pose fit: invalid standard errors, or no estimate.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A standard error is not positive and finite.
    #[error("standard errors of IMU and laser must be positive and finite")]
    InvalidStandardErrors,
    /// Fewer than five pairs may be on the plane.
    #[error("no estimate: {0} pairs, and a pose needs {MIN_PAIRS}")]
    TooFewPairs(usize),
    /// A pair maps behind the camera, or the iteration found no minimum.
    #[error("no estimate: the pose does not converge")]
    NotConverged,
    /// The budget was exhausted before the pose converged.
    #[error("no estimate: the work allowed ended before the pose settled")]
    BudgetExhausted,
    /// The pairs contradict attitude or height of IMU and laser.
    #[error("no estimate: pictures and sensors disagree (chi squared {chi2:.1}, at most {MAX_CHI2} by chance)")]
    Disagreement {
        /// Sum of squared deviations from the readings over their variances.
        chi2: f64,
    },
    /// No pose near the readings explains the pairs.
    #[error("no estimate: pictures and sensors disagree (the pairs are {residual:.1} px off the pose that fits best)")]
    Unexplained {
        /// Residual of the pairs, px per axis.
        residual: f64,
    },
    /// The pairs show the pattern of the sensor instead of the ground.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The standard error is a metre or more.
    #[error("no estimate: the displacement is known to {sigma:.2} m only")]
    Uncertain {
        /// Standard error along the worse direction, m.
        sigma: f64,
    },
}

/// Reusable memory of [`fit_in`]: a fit of no more pairs than before allocates nothing.
#[derive(Debug, Clone)]
pub struct PoseBuffers {
    residuals: Vec<Residual>,
    values: Vec<f64>,
    positions: Vec<Vector2<f64>>,
    on_plane: Vec<Pair>,
    cells: Cells,
    off_plane: Vec<bool>,
}

impl PoseBuffers {
    /// Allocates memory for `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self {
            residuals: Vec::with_capacity(pairs),
            values: Vec::with_capacity(pairs),
            positions: Vec::with_capacity(pairs),
            on_plane: Vec::with_capacity(pairs),
            cells: Cells::new(),
            off_plane: Vec::with_capacity(pairs),
        }
    }

    /// Returns, for each pair of the last fit, `true` if the pair is off the fitted plane (its error is not noise).
    /// Empty if the ground was modelled as hills, or if the fit failed.
    pub fn off_plane(&self) -> &[bool] {
        &self.off_plane
    }
}

/// The inlier pairs of a consensus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConsensusPairs<'pairs> {
    /// All inliers, those known to be off the plane of the ground last.
    pub pairs: &'pairs [Pair],
    /// Number of pairs at the end of `pairs` that are known to be off the plane, on roofs or trees for example.
    pub off_plane: usize,
    /// Quality of the search, 0 ..= 255.
    pub quality: u8,
}

/// Fits the pose of CUR to pairs without outliers; `match_quality` is the quality of the consensus that they are from.
///
/// # Errors
/// A standard error is not positive and finite, or there is no estimate.
pub fn fit(
    reference: &View,
    current: &View,
    sensors: &SensorErrors,
    pairs: &[Pair],
    match_quality: u8,
) -> Result<Pose, PoseError> {
    let (mut buffers, mut budget) = (PoseBuffers::with_capacity(pairs.len()), Budget::UNLIMITED);
    let observation = |view: &View| Observation { view: *view, errors: (*sensors).into() };
    let (reference, current) = (observation(reference), observation(current));
    let terrain = TerrainPrior::of(&reference);
    let consensus = ConsensusPairs { pairs, off_plane: 0, quality: match_quality };
    fit_in(&mut buffers, &mut budget, &reference, &terrain, &current, consensus)
}

/// Fits the pose of CUR as [`fit`] does, with reusable memory, bounded work, and priors of both views and the ground.
///
/// # Errors
/// As [`fit`], and if `budget` is exhausted before the pose has converged: before that, a pose has no covariance.
pub fn fit_in(
    buffers: &mut PoseBuffers,
    budget: &mut Budget,
    reference: &Observation,
    terrain: &TerrainPrior,
    current: &Observation,
    ConsensusPairs { pairs, off_plane, quality }: ConsensusPairs<'_>,
) -> Result<Pose, PoseError> {
    buffers.off_plane.clear();
    let errors = [reference.errors, current.errors];
    let all = errors.iter().flat_map(|errors| [errors.tilt, errors.heading, errors.plane_height, errors.relief_height]);
    if all.into_iter().any(|sigma| !(sigma > 0.0 && sigma.is_finite())) {
        return Err(PoseError::InvalidStandardErrors);
    }
    let candidates = &pairs[..pairs.len().saturating_sub(off_plane)];
    if candidates.len() < MIN_PAIRS {
        return Err(PoseError::TooFewPairs(candidates.len()));
    }
    sensor_pattern::check(pairs, reference, current)?;
    let (reference, current) = (&reference.view, &current.view);
    let start = rectified_displacement(reference, current, pairs).ok_or(PoseError::NotConverged)?;
    let (from, to) = (reference.attitude(), current.attitude());
    let (h, descent) = (reference.height(), reference.height() - current.height());
    let level_readings = Unknowns::from([
        start.x, start.y, descent, to.roll, to.pitch, to.yaw, h, from.roll, from.pitch, from.yaw, 0.0, 0.0,
    ]);
    // The laser meets the slope beside the camera.
    let laser_offset = to.rotation().column(2).xy() * (current.height() / to.rotation()[(2, 2)]);
    let mut sloped_readings = level_readings;
    sloped_readings[DESCENT] = terrain.height - current.height() - terrain.slope.dot(&laser_offset);
    sloped_readings[HEIGHT] = terrain.height;
    sloped_readings[SLOPE_X] = terrain.slope.x;
    sloped_readings[SLOPE_Y] = terrain.slope.y;
    let (may_be_level, slope_is_measured) = (terrain.may_be_level(), terrain.slope_is_measured);
    let terrain_information = terrain.covariance.try_inverse().ok_or(PoseError::InvalidStandardErrors)?;
    let cameras = Cameras { from: reference.camera().inverse(), to: current.camera().matrix() };
    let overlap = relief::overlap(pairs, &mut buffers.positions, budget).ok_or(PoseError::BudgetExhausted)?;
    let mut problem = Problem {
        cameras,
        level_readings,
        sloped_readings,
        errors,
        terrain_information,
        slope_is_measured,
        pairs,
        candidates,
        buffers,
        budget,
        overlap,
    };
    let level = if may_be_level { problem.fit_level_plane() } else { Err(problem.sloped_readings) };
    match level.or_else(|start| problem.fit_trimmed_plane(start).ok_or(start)) {
        Ok(solution) => {
            problem.mark_off_plane(&solution);
            solution.pose(quality)
        }
        Err(start) => match problem.fit_relief(start) {
            Ok(solution) if solution.chi2 > MAX_CHI2 => Err(PoseError::Disagreement { chi2: solution.chi2 }),
            Ok(solution) => solution.pose(quality),
            Err(error) => Err(error),
        },
    }
}

/// Returns the displacement, m, that IMU and laser alone give: the mean difference of the rectified positions. `None`
/// without pairs, or if a pair maps behind the camera.
fn rectified_displacement(reference: &View, current: &View, pairs: &[Pair]) -> Option<Vector2<f64>> {
    let (from, to) = (reference.to_ground(), current.to_ground());
    let mut sum = Vector2::zeros();
    for pair in pairs {
        sum += transfer(&from, pair.reference)? - transfer(&to, pair.current)?;
    }
    (!pairs.is_empty()).then(|| sum / pairs.len() as f64)
}

#[cfg(test)]
mod tests;
