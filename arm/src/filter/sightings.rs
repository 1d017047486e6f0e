//! The update by sightings of landmarks, with the letters of the [parent](super).

use super::grid::CELLS;
use super::information::InformationBatch;
use super::linear::{solve, subtract_products, transposed};
use super::projection::{PairState, Projection};
use super::{CORE, Filter, GYRO_BIAS, KEPT_SLOPE, PAIR, SLOPE, STATES, pair_states};
use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::orthophoto::Camera;
use hoverlock_reference::motion::relief::{ReliefSums, clipped};
use nalgebra::{Matrix2, Matrix3, Matrix3x6, Matrix6, SMatrix, SVector, Vector2, Vector3, Vector6};

/// Cells that the sightings of one frame may touch; sightings of further cells are not used.
pub(super) const MAX_TOUCHED_CELLS: usize = 96;
/// Unknowns of the system of an update.
const SYSTEM: usize = 2 * PAIR;
/// Part of the information of a sighting that counts: errors of position persist over frames and neighbours.
pub const INFORMATION_SHARE: f64 = 1.0 / 16.0;
/// The same without samples of the IMU: each frame then has a new pose, and only the keyframe's errors persist.
const FREE_INFORMATION_SHARE: f64 = 1.0 / 4.0;
/// Iterations of an update near the prediction, and without samples of the IMU, where the prediction is far.
const ITERATIONS: [usize; 2] = [4, 8];
/// Iterations of a fit to patches alone: over even ground, and over a rough one if that fails.
const PATCH_ITERATIONS: [usize; 2] = [6, 5];
/// Iterations at the beginning in which all residuals count alike, and of a fit to patches alone: where these start
/// from, they are off by more than the loss lets count.
const LOSSLESS_ITERATIONS: [usize; 2] = [1, 2];
/// Least share of the patches that agree over even ground.
const MIN_EVEN_SHARE: f64 = 0.4;
/// Largest chi squared of a patch in their mean: what is further off is on another thing, however far.
const MAX_EXCESS_CHI2: f64 = 200.0;
/// Sightings at most in an iteration, evenly chosen, and patches alone; the update itself has all.
const ITERATED: [usize; 2] = [128, 64];
/// Work units of a sighting in an iteration: its projection with all derivatives, and its part of the information.
pub const SIGHTING_WORK: usize = 360;
/// Work units of the system of an iteration, and of its solution.
pub const SYSTEM_WORK: usize = 9_000;
/// Work units of a touched cell in the system.
pub const CELL_SYSTEM_WORK: usize = 300;
/// Work units of a state in the solution for all states.
pub const SOLUTION_STATE_WORK: usize = 1_750;
/// Work units of a touched cell and a state in the gain.
pub const CELL_STATE_WORK: usize = 62;
/// Work units of a correlated cell and a state in the update of the correlations.
pub const CORRELATED_STATE_WORK: usize = 8;
/// Products of the update of the covariance in a work unit, at least.
pub const PRODUCTS_PER_UNIT: usize = 4;
/// Touched cells that are expected beyond those of the last update.
const MORE_CELLS: usize = 8;
/// Weight of a frame in the running NIS.
const NIS_WEIGHT: f64 = 0.3;
/// Share of the largest running NIS that remains after a frame: half after 2.3 s.
const NIS_DECAY: f64 = 0.98;
/// Standard deviation of a sight line below which its motion is no innovation, rad.
const MOTION_FLOOR: f64 = 2e-5;
/// Mean square that the residuals of a block of the picture may have in common, px^2. More is relief that the fit has
/// taken for something else.
pub(super) const COMMON_PX2: f64 = 0.0005;
/// Weight of a frame in its running mean.
const COMMON_WEIGHT: f64 = 0.1;
/// Blocks of the picture across and down.
const BLOCKS: [usize; 2] = [4, 3];
/// Sightings that a block needs.
const MIN_BLOCK_SIGHTINGS: f64 = 5.0;
/// Scale of the Geman-McClure loss, in chi squared of two degrees of freedom.
const LOSS_CHI2: f64 = 4.0;
/// Ratio of the scales in successive iterations without samples of the IMU (graduated non-convexity, Blake and
/// Zisserman 1987): far from the prediction the smallest scale keeps the first local minimum.
const LOSS_SCALE_RATIO: f64 = 2.0;
/// Iterations with the smallest scale at the end.
const FINE_ITERATIONS: usize = 2;

/// Chi squared (two degrees of freedom) up to which a sighting is an inlier; noise exceeds it once in 90.
const MAX_INLIER_CHI2: f64 = 9.0;
/// Chi squared (six degrees of freedom) up to which a change of the relative pose is possible for the vehicle: noise
/// exceeds it once in ten million.
const MAX_INNOVATION_CHI2: f64 = 43.0;

/// A ground point of a keyframe in the present frame.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    /// Index of the landmark in its keyframe.
    pub landmark: usize,
    /// Position in the keyframe, px.
    pub reference: Vector2<f64>,
    /// Position in the present frame, px.
    pub current: Vector2<f64>,
    /// Covariance of the difference of both positions, px^2.
    pub covariance: Matrix2<f64>,
    /// The sighting counts in the update; others are only judged by it.
    pub counts: bool,
    /// The positions are those of a patch that was refined on the frames, not of features.
    pub is_refined: bool,
    /// Chi squared of the residual after the update, two degrees of freedom; heights are considered.
    pub chi2: f64,
    /// Residual after the update, px.
    pub residual: Vector2<f64>,
}

impl Sighting {
    /// Writes residual and chi squared at a state. Returns the projection; `None` if the landmark is not seen.
    fn judge(&mut self, state: &PairState, cameras: [&Camera; 2], height_variance: f64) -> Option<Projection> {
        self.chi2 = f64::INFINITY;
        let seen = state.project(cameras, &self.reference)?;
        let g = seen.by_height;
        self.residual = self.current - seen.image;
        let spread = self.covariance + g * g.transpose() * height_variance;
        if let Some(inverse) = spread.try_inverse() {
            self.chi2 = self.residual.dot(&(inverse * self.residual));
        }
        Some(seen)
    }

    /// Returns `true` if the sighting counts and agrees with the fitted poses.
    pub fn is_inlier(&self) -> bool {
        self.counts && self.is_consistent()
    }

    /// Returns `true` if the sighting agrees with the fitted poses.
    pub fn is_consistent(&self) -> bool {
        self.chi2 <= MAX_INLIER_CHI2
    }
}

/// The result of an update by sightings.
#[derive(Debug, Clone, Copy)]
pub struct Fitted {
    /// Chi squared of the change of the relative pose over its predicted covariance; six degrees of freedom.
    pub innovation: f64,
    /// Sightings that agree.
    pub inliers: usize,
    /// The state was changed.
    pub is_applied: bool,
}

/// A row for each touched cell, with an element for each state of a pair.
pub(super) type CellRows = Vec<[f64; PAIR]>;
/// An element for each state.
pub(super) type StateRow = [f64; STATES];

/// Memory of an update, with the letters of the [module](self).
pub(super) struct Scratch {
    pub(super) cells: Vec<usize>,
    /// Number of them in the last update.
    last_cells: usize,
    /// Number that the present update may touch.
    max_cells: usize,
    /// Place of a cell in `cells`, or `usize::MAX`.
    pub(super) place: Vec<usize>,
    /// `A`, upper triangle.
    pub(super) poses: [[f64; PAIR]; PAIR],
    /// `B^T`.
    pub(super) coupling: CellRows,
    /// `D`.
    pub(super) heights: Vec<f64>,
    /// `n_1`.
    pub(super) pose_vector: [f64; PAIR],
    /// `n_2`.
    pub(super) height_vector: Vec<f64>,
    /// `C^T`.
    pub(super) correlation: CellRows,
    /// `K`, row-major.
    pub(super) system: Vec<f64>,
    /// Right-hand sides and solutions, a column for each state: `-t` above `w`.
    pub(super) gain: Vec<f64>,
    /// `v`, a row for each touched cell.
    pub(super) height_gain: Vec<StateRow>,
    /// `P_yx`, a row for each element of `y`.
    pub(super) columns: Vec<StateRow>,
    /// `(M L)^T`, a row for each element of `y`.
    pub(super) product: Vec<StateRow>,
}

impl Scratch {
    /// Allocates the memory.
    pub(super) fn new() -> Self {
        Self {
            cells: Vec::with_capacity(MAX_TOUCHED_CELLS),
            last_cells: MAX_TOUCHED_CELLS / 2,
            max_cells: MAX_TOUCHED_CELLS,
            place: vec![usize::MAX; CELLS],
            poses: [[0.0; PAIR]; PAIR],
            coupling: Vec::with_capacity(MAX_TOUCHED_CELLS),
            heights: Vec::with_capacity(MAX_TOUCHED_CELLS),
            pose_vector: [0.0; PAIR],
            height_vector: Vec::with_capacity(MAX_TOUCHED_CELLS),
            correlation: Vec::with_capacity(MAX_TOUCHED_CELLS),
            system: vec![0.0; SYSTEM * SYSTEM],
            gain: vec![0.0; SYSTEM * STATES],
            height_gain: vec![[0.0; STATES]; MAX_TOUCHED_CELLS],
            columns: vec![[0.0; STATES]; PAIR + MAX_TOUCHED_CELLS],
            product: vec![[0.0; STATES]; PAIR + MAX_TOUCHED_CELLS],
        }
    }

    /// Returns the place of a cell among those that are touched; `None` if no further one may be.
    fn touch(&mut self, cell: usize) -> Option<usize> {
        if self.place[cell] == usize::MAX {
            if self.cells.len() >= self.max_cells {
                return None;
            }
            self.place[cell] = self.cells.len();
            self.cells.push(cell);
            self.coupling.push([0.0; PAIR]);
            self.heights.push(0.0);
            self.height_vector.push(0.0);
        }
        Some(self.place[cell])
    }
}

impl Filter {
    /// Returns the cells that sightings are expected to touch: as many as those of the last update, and some more.
    pub fn expected_cells(&self) -> usize {
        (self.scratch.last_cells + MORE_CELLS).min(MAX_TOUCHED_CELLS)
    }

    /// Returns the work units of [`Filter::update_sightings`] with a number of sightings, or of patches alone, that may
    /// touch a number of cells.
    pub fn work(&self, sightings: usize, cells: usize, by_patches: bool) -> usize {
        let cells = sightings.min(cells).min(MAX_TOUCHED_CELLS);
        let iterated = SIGHTING_WORK * sightings.min(ITERATED[usize::from(by_patches)]);
        let iterations =
            |count: usize, cells: usize| count * (system_work(cells) + iterated) + SIGHTING_WORK * sightings;
        let fit = if by_patches {
            let [even, rough] = PATCH_ITERATIONS;
            iterations(even, 0) + iterations(rough, cells)
        } else {
            iterations(ITERATIONS[usize::from(self.is_free)], cells)
        };
        fit + self.application_work(cells, self.changed(by_patches))
    }

    /// Returns the work units of the update of the first `changed` states with a number of touched cells.
    fn application_work(&self, cells: usize, changed: usize) -> usize {
        let (active, correlated) = (self.active(), (self.grid.correlated() + cells).min(CELLS));
        system_work(cells)
            + changed * (SOLUTION_STATE_WORK + CELL_STATE_WORK * cells + CORRELATED_STATE_WORK * correlated)
            + active * changed * (PAIR + cells) / PRODUCTS_PER_UNIT
    }

    /// Returns the number of the first states that an update changes. A fit to patches alone has no memory.
    fn changed(&self, by_patches: bool) -> usize {
        if by_patches { GYRO_BIAS } else { self.active() }
    }

    /// Returns `true` if a fit to sightings is one to patches alone.
    pub fn fits_patches(&self, sightings: &[Sighting]) -> bool {
        self.is_free && self.is_calibrated() && sightings.iter().all(|sighting| sighting.is_refined)
    }

    /// Returns the largest number of sightings whose update takes at most `units`; 0 if there is none.
    fn affordable_sightings(&self, units: u64, cells: usize) -> usize {
        let most = ITERATED[0];
        match units.checked_sub(self.work(most, cells, false) as u64) {
            Some(rest) => most + (rest / SIGHTING_WORK as u64).min(usize::MAX as u64 / 2) as usize,
            None => (1..most).rev().find(|count| self.work(*count, cells, false) as u64 <= units).unwrap_or(0),
        }
    }

    /// Returns the number of `count` sightings, at least 1, that can be fitted with some work units, and the cells that
    /// they may touch then. Patches alone are as many as were paid for.
    pub fn thinning(&self, count: usize, units: u64, by_patches: bool) -> (usize, usize) {
        if by_patches || self.affordable_sightings(units, MAX_TOUCHED_CELLS) >= count {
            return (count, MAX_TOUCHED_CELLS);
        }
        let cells = self.expected_cells();
        (self.affordable_sightings(units, cells).clamp(1, count), cells)
    }

    /// Fits present pose, keyframe `k` and the errors of the camera to sightings: iterated, with Geman-McClure's loss.
    /// Residual and chi squared of each sighting are written into it. The change is applied if at least `min_inliers`
    /// sightings agree and its chi squared is possible. Sightings beyond `max_cells` touched cells are not used.
    /// Returns `None` without sightings that count, if the system is singular, or if the budget is exhausted.
    pub fn update_sightings(
        &mut self,
        k: usize,
        cameras: [&Camera; 2],
        sightings: &mut [Sighting],
        min_inliers: usize,
        max_cells: usize,
        budget: &mut Budget,
    ) -> Option<Fitted> {
        self.scratch.max_cells = max_cells;
        self.by_patches = self.fits_patches(sightings);
        (self.excess, self.is_rough) = (1.0, false);
        let (change, inliers) = if self.by_patches {
            self.fit_patches(k, cameras, sightings, budget)?
        } else {
            self.fit(k, cameras, sightings, ITERATIONS[usize::from(self.is_free)], budget)?
        };
        let innovation = self.innovation(k, &change)?;
        let is_applied = innovation <= MAX_INNOVATION_CHI2 && inliers >= min_inliers;
        if is_applied {
            let before = self.relative_covariance(k);
            self.scratch.last_cells = self.scratch.cells.len();
            spend(budget, self.application_work(self.scratch.last_cells, self.changed(self.by_patches)))?;
            self.apply(&pair_states(k))?;
            self.monitor(k, cameras[1], &change, &before);
            if self.is_rough {
                // The relief is that of the residuals, and with it what they have in common.
                self.common = 0.0;
            } else {
                self.watch_blocks(cameras[1], sightings);
            }
        }
        Some(Fitted { innovation, inliers, is_applied })
    }

    /// Fits to patches alone as [`Filter::fit`] does: over even ground, and over a rough one if too few agree. Over
    /// rough ground much can be explained: between streets and roofs it finds more than one solution.
    fn fit_patches(
        &mut self,
        k: usize,
        cameras: [&Camera; 2],
        sightings: &mut [Sighting],
        budget: &mut Budget,
    ) -> Option<([f64; PAIR], usize)> {
        let [even, rough] = PATCH_ITERATIONS;
        let max_cells = std::mem::take(&mut self.scratch.max_cells);
        self.set_relief(0.0);
        let mut found = self.fit(k, cameras, sightings, even, budget)?;
        let count = sightings.len() as f64;
        if (found.1 as f64) < MIN_EVEN_SHARE * count {
            (self.scratch.max_cells, self.is_rough) = (max_cells, true);
            self.set_relief(f64::INFINITY);
            found = self.fit(k, cameras, sightings, rough, budget)?;
        }
        let squares: f64 = sightings.iter().map(|sighting| sighting.chi2.min(MAX_EXCESS_CHI2)).sum();
        self.excess = (squares / (2.0 * count)).max(1.0);
        Some(found)
    }

    /// Iterates from the prediction to the poses that sightings fit best. Returns the change of the states of the pair,
    /// and the number of inliers; the last linearisation is at the solution. If the ground is rough, the residuals
    /// decide by how much.
    fn fit(
        &mut self,
        k: usize,
        cameras: [&Camera; 2],
        sightings: &mut [Sighting],
        iterations: usize,
        budget: &mut Budget,
    ) -> Option<([f64; PAIR], usize)> {
        let prior = self.pair_state(k)?;
        let mut change = [0.0; PAIR];
        let states = pair_states(k);
        for iteration in 0..iterations {
            let chosen = sightings.len().div_ceil(ITERATED[usize::from(self.by_patches)]).max(1);
            let has_loss = iteration >= LOSSLESS_ITERATIONS[usize::from(self.by_patches)];
            let loss_scale = has_loss.then(|| self.loss_scale(iterations - iteration));
            spend(budget, SIGHTING_WORK * sightings.len().div_ceil(chosen))?;
            self.linearise(&prior.moved(&change), cameras, sightings, chosen, &change, loss_scale)?;
            spend(budget, system_work(self.scratch.cells.len()))?;
            self.fill_system(&states);
            change = self.solve_change()?;
            if self.is_rough {
                self.set_relief(self.relief.variance());
            }
        }
        // The residuals at the solution.
        spend(budget, SIGHTING_WORK * sightings.len())?;
        self.linearise(&prior.moved(&change), cameras, sightings, 1, &change, Some(LOSS_CHI2))?;
        Some((change, sightings.iter().filter(|sighting| sighting.is_inlier()).count()))
    }

    /// Returns the scale of the loss in an iteration, with the number of those that are left.
    fn loss_scale(&self, left: usize) -> f64 {
        let coarse = left.saturating_sub(FINE_ITERATIONS);
        if self.is_free { LOSS_CHI2 * LOSS_SCALE_RATIO.powi(coarse as i32) } else { LOSS_CHI2 }
    }

    /// Returns the covariance of the relative pose.
    fn relative_covariance(&self, k: usize) -> Matrix6<f64> {
        let pair = self.pair_covariance(k);
        Matrix6::from_fn(|i, j| pair[(i, j)] - pair[(i, 6 + j)] - pair[(6 + i, j)] + pair[(6 + i, 6 + j)])
    }

    /// Updates the running NIS: of a change of the relative pose over the covariance that the update removed, and of
    /// the motion of the picture that the change makes.
    fn monitor(&mut self, k: usize, camera: &Camera, change: &[f64; PAIR], before: &Matrix6<f64>) {
        if self.is_free {
            return;
        }
        let relative = Vector6::from_fn(|i, _| change[i] - change[6 + i]);
        let removed = before - self.relative_covariance(k);
        let height = -self.pose.position.z;
        let motion = picture_motion(height, camera);
        // A millimetre, and a tenth of a milliradian.
        let (place, turn) = (1e-6, 1e-8);
        let sight = (MOTION_FLOOR * height).powi(2);
        let floor = Matrix6::from_diagonal(&Vector6::new(place, place, place, turn, turn, turn));
        let motion_floor = Matrix3::from_diagonal(&Vector3::new(sight, sight, turn));
        let nis = normalised(&relative, removed + floor);
        let motion_nis = normalised(&(motion * relative), motion * removed * motion.transpose() + motion_floor);
        let Some((nis, motion_nis)) = nis.zip(motion_nis) else { return };
        let [running, largest] = &mut self.nis;
        *running += (nis.max(0.0) - *running) * NIS_WEIGHT;
        *largest = (*largest * NIS_DECAY).max(*running);
        self.motion_nis += (motion_nis.max(0.0) - self.motion_nis) * NIS_WEIGHT;
    }

    /// Updates the mean square of what the residuals of a block of the picture have in common.
    fn watch_blocks(&mut self, camera: &Camera, sightings: &[Sighting]) {
        let last = camera.last_pixel();
        let block =
            |value: f64, side: f64, count: usize| ((value / (side + 1.0) * count as f64) as usize).min(count - 1);
        let mut blocks = [(Vector2::zeros(), 0.0); BLOCKS[0] * BLOCKS[1]];
        let (mut squares, mut inliers) = (0.0, 0.0);
        for sighting in sightings.iter().filter(|sighting| sighting.is_inlier()) {
            let at = &sighting.current;
            let index = block(at.y, last.y, BLOCKS[1]) * BLOCKS[0] + block(at.x, last.x, BLOCKS[0]);
            blocks[index].0 += sighting.residual;
            blocks[index].1 += 1.0;
            squares += sighting.residual.norm_squared() / 2.0;
            inliers += 1.0;
        }
        let (mut sum, mut filled) = (0.0, 0.0);
        for (total, count) in blocks.iter().filter(|(_, count)| *count >= MIN_BLOCK_SIGHTINGS) {
            // Less what independent residuals have.
            sum += (total / *count).norm_squared() / 2.0 - squares / inliers / count;
            filled += 1.0;
        }
        if filled > 0.0 {
            self.common += ((sum / filled).max(0.0) - self.common) * COMMON_WEIGHT;
        }
    }

    /// Returns chi squared of a change of the relative pose.
    fn innovation(&self, k: usize, change: &[f64; PAIR]) -> Option<f64> {
        let relative = Vector6::from_fn(|i, _| change[i] - change[6 + i]);
        let mut covariance = self.relative_covariance(k);
        for i in 0..6 {
            // A centimetre, and a tenth of a milliradian: the errors of pictures that no prediction knows.
            covariance[(i, i)] += if i < 3 { 1e-4 } else { 1e-8 };
        }
        normalised(&relative, covariance)
    }

    /// Fills information matrix and vector at a state that differs from the prediction by `change`, from one of
    /// `chosen` sightings with as many times the weight. Without a scale of the loss all residuals count alike.
    pub(super) fn linearise(
        &mut self,
        state: &PairState,
        cameras: [&Camera; 2],
        sightings: &mut [Sighting],
        chosen: usize,
        change: &[f64; PAIR],
        loss_scale: Option<f64>,
    ) -> Option<()> {
        for cell in self.scratch.cells.drain(..) {
            self.scratch.place[cell] = usize::MAX;
        }
        let Scratch { poses, coupling, heights, pose_vector, height_vector, .. } = &mut self.scratch;
        (*poses, *pose_vector) = ([[0.0; PAIR]; PAIR], [0.0; PAIR]);
        coupling.clear();
        heights.clear();
        height_vector.clear();
        let share = match (self.is_free, self.by_patches) {
            (false, _) => INFORMATION_SHARE,
            (true, false) => FREE_INFORMATION_SHARE,
            (true, true) => 1.0,
        };
        let share = chosen as f64 * share;
        let roughness = self.roughness();
        let height_variance = self.height_variance() + roughness;
        self.relief = ReliefSums::default();
        let mut any = false;
        let mut batch = InformationBatch::new();
        for sighting in sightings.iter_mut().step_by(chosen) {
            let Some(seen) = sighting.judge(state, cameras, height_variance) else { continue };
            let (g, residual, chi2) = (seen.by_height, sighting.residual, sighting.chi2);
            let mut covariance = sighting.covariance;
            if self.by_patches && sighting.counts {
                covariance += g * g.transpose() * roughness;
                add_relief(&mut self.relief, sighting, &g, height_variance);
            }
            let Some(inverse) = covariance.try_inverse().filter(|_| sighting.counts && chi2.is_finite()) else {
                continue;
            };
            let loss = loss_scale.map_or(1.0, |scale| scale / (scale + chi2));
            let weight = inverse * (share * loss * loss);
            // Even ground has no cells.
            let has_cell = self.scratch.max_cells > 0;
            let cell = has_cell.then(|| self.cell(&seen.point));
            let height = cell.and_then(|cell| self.scratch.touch(cell));
            if has_cell && height.is_none() {
                continue;
            }
            any = true;
            let Scratch { poses, coupling, heights, pose_vector, height_vector, .. } = &mut self.scratch;
            let by = seen.by_pair();
            let target = residual + by * SMatrix::<f64, PAIR, 1>::from_column_slice(change);
            let weighted_by = weight * by;
            let (weighted_g, weighted_target) = (weight * g, weight * target);
            batch.push(&by, &weighted_by, poses);
            for (pose, [x, y]) in pose_vector.iter_mut().zip(&by.data.0) {
                *pose += x * weighted_target.x + y * weighted_target.y;
            }
            if let Some(height) = height {
                for (coupling, [x, y]) in coupling[height].iter_mut().zip(&by.data.0) {
                    *coupling += x * weighted_g.x + y * weighted_g.y;
                }
                heights[height] += g.dot(&weighted_g);
                height_vector[height] += g.dot(&weighted_target);
            }
        }
        batch.finish(&mut self.scratch.poses);
        any.then_some(())
    }

    /// Fills `system` with `K`, and `correlation`.
    pub(super) fn fill_system(&mut self, states: &[usize; PAIR]) {
        let variance = self.height_variance();
        let Self { covariance, cross, scratch, .. } = self;
        let Scratch { cells, poses, coupling, heights, correlation, system, .. } = scratch;
        correlation.clear();
        correlation.extend(cells.iter().map(|cell| states.map(|state| cross[state * CELLS + cell])));
        for i in 0..PAIR {
            for j in 0..PAIR {
                let unit = f64::from(u8::from(i == j));
                system[i * SYSTEM + j] = unit;
                system[i * SYSTEM + PAIR + j] = poses[i.min(j)][i.max(j)];
                system[(PAIR + i) * SYSTEM + j] = -covariance[states[i] * STATES + states[j]];
            }
        }
        for ((b, c), d) in coupling.iter().zip(&*correlation).zip(&*heights) {
            let inverse = 1.0 / (1.0 + variance * *d);
            let is_correlated = c.iter().any(|value| *value != 0.0);
            // `A'` and `P'` are symmetric: their upper triangles suffice, and `F` stands for its transpose.
            for i in 0..PAIR {
                let [of_b, of_c] = [b[i] * inverse, c[i] * inverse];
                let scaled = variance * of_b;
                let row = &mut system[i * SYSTEM..(i + 1) * SYSTEM];
                row[PAIR + i..].iter_mut().zip(&b[i..]).for_each(|(value, other)| *value -= scaled * other);
                if is_correlated {
                    row[..PAIR].iter_mut().zip(c).for_each(|(value, other)| *value += of_b * other);
                    let scaled = *d * of_c;
                    let row = &mut system[(PAIR + i) * SYSTEM + i..(PAIR + i) * SYSTEM + PAIR];
                    row.iter_mut().zip(&c[i..]).for_each(|(value, other)| *value += scaled * other);
                }
            }
        }
        for i in 0..PAIR {
            for j in 0..PAIR {
                system[(PAIR + i) * SYSTEM + PAIR + j] = system[j * SYSTEM + i];
            }
            for j in 0..i {
                system[i * SYSTEM + PAIR + j] = system[j * SYSTEM + PAIR + i];
                system[(PAIR + i) * SYSTEM + j] = system[(PAIR + j) * SYSTEM + i];
            }
        }
    }

    /// Returns `u`, the change of the states of the pair; destroys `system`.
    pub(super) fn solve_change(&mut self) -> Option<[f64; PAIR]> {
        let variance = self.height_variance();
        let Scratch { coupling, heights, pose_vector, height_vector, correlation, system, gain, .. } =
            &mut self.scratch;
        let right = &mut gain[..SYSTEM];
        right[..PAIR].copy_from_slice(pose_vector);
        right[PAIR..].fill(0.0);
        for (((b, c), d), n) in coupling.iter().zip(correlation).zip(heights).zip(height_vector) {
            let scaled = *n / (1.0 + variance * *d);
            for i in 0..PAIR {
                right[i] -= variance * b[i] * scaled;
                right[PAIR + i] += c[i] * scaled;
            }
        }
        solve(system, right, SYSTEM, 1, 1)?;
        Some(std::array::from_fn(|i| right[PAIR + i]))
    }

    /// Applies the update of the last linearisation to all states and their covariance.
    pub(super) fn apply(&mut self, states: &[usize; PAIR]) -> Option<()> {
        let (active, changed) = (self.active(), self.changed(self.by_patches));
        self.fill_system(states);
        self.solve_gain(states, changed)?;
        let Self { covariance, cross, scratch, .. } = self;
        let Scratch { cells, place, gain, height_gain, columns, product, pose_vector, height_vector, .. } = scratch;
        let mut by = [0.0; STATES];
        let gains = gain[PAIR * STATES..].as_chunks().0.iter().zip(&*pose_vector);
        for (row, n) in gains.chain(height_gain.iter().zip(&*height_vector)) {
            let row: &StateRow = row;
            by.iter_mut().zip(row).for_each(|(value, gain)| *value += gain * n);
        }
        by[SLOPE..CORE].iter_mut().for_each(|value| *value *= 1.0 - KEPT_SLOPE);
        let size = PAIR + cells.len();
        by[changed..].fill(0.0);
        let slopes = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(row, column)| (SLOPE + row) * STATES + SLOPE + column);
        let before = slopes.map(|at| covariance[at]);
        subtract_products(covariance, &product[..size], &columns[..size], changed, active);
        for (at, before) in slopes.into_iter().zip(before) {
            covariance[at] += KEPT_SLOPE * KEPT_SLOPE * (before - covariance[at]);
        }
        let variance = self.height_sigma * self.height_sigma;
        let of_poses = transposed(&product[..PAIR]);
        for cell in 0..CELLS {
            let touched = place[cell];
            // P_yh of this cell, before the update.
            let before: [f64; PAIR] = std::array::from_fn(|i| cross[states[i] * CELLS + cell]);
            if touched == usize::MAX && before.iter().all(|value| *value == 0.0) {
                continue;
            }
            for (row, of_pose) in of_poses.iter().enumerate().take(changed) {
                let mut less: f64 = of_pose.iter().zip(&before).map(|(product, before)| product * before).sum();
                if touched != usize::MAX {
                    less += product[PAIR + touched][row] * variance;
                }
                let corrected = if (SLOPE..CORE).contains(&row) { 1.0 - KEPT_SLOPE } else { 1.0 };
                cross[row * CELLS + cell] -= corrected * less;
            }
        }
        self.correct(&by);
        for touched in 0..self.scratch.cells.len() {
            self.grid.set_correlated(self.scratch.cells[touched]);
        }
        Some(())
    }

    /// Fills `columns` for all states, and `gain`, `height_gain` and `product` for the first `changed`; destroys
    /// `system`.
    fn solve_gain(&mut self, states: &[usize; PAIR], changed: usize) -> Option<()> {
        let variance = self.height_variance();
        let Self { covariance, cross, scratch, .. } = self;
        let Scratch { cells, coupling, heights, correlation, system, gain, height_gain, columns, product, .. } =
            scratch;
        let (poses, rest) = columns.split_at_mut(PAIR);
        for (row, state) in poses.iter_mut().zip(states) {
            row.copy_from_slice(&covariance[state * STATES..(state + 1) * STATES]);
        }
        let rest = &mut rest[..cells.len()];
        for (row, cell) in rest.iter_mut().zip(&*cells) {
            row.iter_mut().enumerate().for_each(|(state, value)| *value = cross[state * CELLS + cell]);
        }
        let add = |to: &mut StateRow, factor: f64, from: &StateRow| {
            to[..changed].iter_mut().zip(from).for_each(|(value, other)| *value += factor * other);
        };
        let (above, below) = gain.as_chunks_mut::<STATES>().0.split_at_mut(PAIR);
        above.fill([0.0; STATES]);
        below.copy_from_slice(poses);
        for (place, p) in rest.iter().enumerate() {
            let inverse = 1.0 / (1.0 + variance * heights[place]);
            for i in 0..PAIR {
                add(&mut above[i], -inverse * coupling[place][i], p);
                add(&mut below[i], -inverse * heights[place] * correlation[place][i], p);
            }
        }
        solve(system, gain, SYSTEM, STATES, changed)?;
        let (above, below) = gain.as_chunks::<STATES>().0.split_at(PAIR);
        let (of_poses, of_heights) = product.split_at_mut(PAIR);
        for (row, solved) in of_poses.iter_mut().zip(above) {
            row.iter_mut().zip(solved).for_each(|(value, solved)| *value = -solved);
        }
        for (place, p) in rest.iter().enumerate() {
            let (v, seen) = (&mut height_gain[place], &mut of_heights[place]);
            v.copy_from_slice(p);
            seen.fill(0.0);
            for i in 0..PAIR {
                add(v, correlation[place][i], &above[i]);
                add(seen, coupling[place][i], &below[i]);
            }
            let inverse = 1.0 / (1.0 + variance * heights[place]);
            for (v, seen) in v.iter_mut().zip(seen) {
                *v = inverse * (*v - variance * *seen);
                *seen += heights[place] * *v;
            }
        }
        Some(())
    }
}

/// Returns the mean motion of a picture by a change of position and rotation over level ground `height` (m) below: its
/// shift, m on the ground, and its turn, rad. A point with the normalised coordinate `x` shifts by `p + h t (1 + x^2)`
/// with the tilt `t`, so a displacement `p = -h t` leaves the perspective alone to tell it from the tilt.
pub(super) fn picture_motion(height: f64, camera: &Camera) -> Matrix3x6<f64> {
    // The mean of `x^2` between the borders.
    let lever = (camera.last_pixel() / 2.0 / camera.focal()).map(|border| height * (1.0 + border * border / 3.0));
    let mut motion = Matrix3x6::zeros();
    (motion[(0, 0)], motion[(0, 4)]) = (1.0, lever.x);
    (motion[(1, 1)], motion[(1, 3)]) = (1.0, -lever.y);
    motion[(2, 5)] = 1.0;
    motion
}

/// Returns the square of a change over its covariance; `None` if that is singular.
fn normalised<const N: usize>(change: &SVector<f64, N>, covariance: SMatrix<f64, N, N>) -> Option<f64> {
    Some(change.dot(&(covariance.try_inverse()? * change)))
}

/// Adds the residual of a sighting to what is known of the relief, whose variance so far is `variance` (m^2); `g` is
/// the derivative of its image by height.
fn add_relief(relief: &mut ReliefSums, sighting: &Sighting, g: &Vector2<f64>, variance: f64) {
    let g2 = g.norm_squared();
    if g2 > 0.0 {
        let along = sighting.residual.dot(g);
        let s2 = g.dot(&(sighting.covariance * g)) / g2;
        relief.push(g2, clipped(along * along / g2, s2 + variance * g2), s2, variance);
    }
}

/// Spends work units; `None` if the budget is exhausted.
fn spend(budget: &mut Budget, units: usize) -> Option<()> {
    budget.spend(units).then_some(())
}

/// Returns the work units of the system of an iteration, and of its solution, with a number of touched cells.
fn system_work(cells: usize) -> usize {
    SYSTEM_WORK + CELL_SYSTEM_WORK * cells
}
