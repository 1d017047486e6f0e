//! Template refinement in integers: the recipe of `hoverlock_reference::motion::refine` for the flight program.
//!
//! `min over d of sum_u |B I(p + u) - a B J(q + A (u + d)) - b|^2`, `I` of the keyframe and `J` of the present frame:
//! 12 x 12 samples 2 px apart about the whole pixel `p`, compared with those about `q`, warped by `A`. The reference
//! has the derivation; this module has the number formats:
//!
//! | quantity | format | why |
//! |---|---|---|
//! | pixel | 16 bits as the camera sends it, of which the upper 12 count | noise is above the rest |
//! | position of a sample | 1/64 px, rounded, and the centre a multiple of it | under `A = I` all have one phase |
//! | weight of a sample | 9 bits | their mean is the phase, see `spline` |
//! | `B I`, `B J` and their slopes | 1/8 of a step of 12 bits, rounded once | 4095 x 2^18 is below 2^30 |
//! | sums over a patch | exact in 64 bits | their order does not matter, so that loops may be vectorised |
//!
//! What follows the sums, a 2 x 2 system for each patch, is in floating point, in which host and ARM have the same
//! bits.

mod spline;

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::refine::{
    AREA, MAX_MOVEMENT_PX, MIN_EIGENVALUE_RATIO, MIN_NCC, REACH_PX, SIDE, STRIDE,
};
use nalgebra::{Matrix2, Vector2};
use spline::{PHASES, SLOPE, VALUE, Window};

/// Fraction bits of the positions of samples before they are rounded to a phase.
const POSITION_BITS: u32 = 16;
/// Smallest variance of the samples of a patch, in steps of 1/8: below it is rounding.
const MIN_VARIANCE: f64 = 16.0;
/// Steps of a patch.
const STEPS: usize = 2;
/// Degrees of freedom that step, gain and offset take.
const FITTED: usize = 4;

/// Values of a patch.
type Patch = [i16; AREA];

/// Returns the sum of the products of two patches, exact.
fn product(a: &Patch, b: &Patch) -> i64 {
    a.iter().zip(b).map(|(a, b)| i64::from(i32::from(*a) * i32::from(*b))).sum()
}

/// Returns the sum of the products of two patches about their means, whose sums are given.
fn product_about_means(a: &Patch, b: &Patch, [sum_a, sum_b]: [f64; 2]) -> f64 {
    product(a, b) as f64 - sum_a * sum_b / AREA as f64
}

/// Returns the sum of a patch.
fn total(patch: &Patch) -> i64 {
    i64::from(patch.iter().map(|value| i32::from(*value)).sum::<i32>())
}

/// A patch of a keyframe with what its steps need.
#[derive(Debug, Clone)]
pub struct Template {
    /// The whole pixel about which it was cut.
    centre: [u16; 2],
    samples: Patch,
    slopes: [Patch; 2],
    /// Sum of the samples and of the slopes.
    sum: f64,
    slope_sums: Vector2<f64>,
    /// Norm of the samples about their mean.
    norm: f64,
    /// Part of the slopes, over the norm, along the normalised samples.
    along: Vector2<f64>,
    /// Inverse of the normal matrix, px^2.
    inverse: Matrix2<f64>,
}

/// The place of a template in another frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refined {
    /// Position of the template's centre, px.
    pub position: Vector2<f64>,
    /// Covariance of the position from the residuals of the samples, px^2.
    pub covariance: Matrix2<f64>,
}

impl Template {
    /// Cuts the patch about the whole pixel (`x`, `y`) of 16-bit samples. Returns `None` if the patch or its neighbours
    /// leave the frame, if it is uniform, or if its gradients have one direction only.
    pub fn cut(frame: &Plane<u16>, x: usize, y: usize) -> Option<Self> {
        let centre = [u16::try_from(x).ok()?, u16::try_from(y).ok()?];
        let window = Window::about(frame, &Vector2::new(x as f64, y as f64), &Vector2::repeat(REACH_PX as f64))?;
        let [left, top] = [x - window.corner[0] - REACH_PX, y - window.corner[1] - REACH_PX];
        let (mut samples, mut slopes) = ([0; AREA], [[0; AREA]; 2]);
        for i in 0..AREA {
            let at = [left + STRIDE * (i % SIDE), top + STRIDE * (i / SIDE)];
            let values = window.columns(at, &VALUE);
            let differences = window.columns(at, &SLOPE);
            samples[i] = spline::sample(&values, &VALUE);
            slopes[0][i] = spline::sample(&values, &SLOPE);
            slopes[1][i] = spline::sample(&differences, &VALUE);
        }
        let sum = total(&samples) as f64;
        let slope_sums = Vector2::from(slopes.each_ref().map(|slopes| total(slopes) as f64));
        let square = product_about_means(&samples, &samples, [sum, sum]);
        if square < MIN_VARIANCE * AREA as f64 {
            return None;
        }
        let norm = square.sqrt();
        let along =
            Vector2::from_fn(|axis, _| product_about_means(&slopes[axis], &samples, [slope_sums[axis], sum])) / square;
        let [xx, xy, yy] = [[0, 0], [0, 1], [1, 1]]
            .map(|[i, j]| product_about_means(&slopes[i], &slopes[j], [slope_sums[i], slope_sums[j]]));
        // The part of a displacement that gain and offset explain as well is removed.
        let normal = Matrix2::new(xx, xy, xy, yy) / square - along * along.transpose();
        let (mean, half) = (normal.trace() / 2.0, (normal[(0, 0)] - normal[(1, 1)]) / 2.0);
        let spread = (half * half + normal[(0, 1)] * normal[(0, 1)]).sqrt();
        if mean - spread <= MIN_EIGENVALUE_RATIO * (mean + spread) {
            return None;
        }
        let inverse = normal.try_inverse()?;
        Some(Self { centre, samples, slopes, sum, slope_sums, norm, along, inverse })
    }

    /// Returns the whole pixel about which the patch was cut.
    pub fn centre(&self) -> Vector2<f64> {
        Vector2::from(self.centre.map(f64::from))
    }

    /// Finds the patch near `start` in another frame of 16-bit samples, warped by `a`, the derivative of the position
    /// there by that in the keyframe. Returns `None` if it comes within 2 px of the border of the frame, moves by more
    /// than 2 px, or has an NCC below 0.5.
    pub fn refine(&self, frame: &Plane<u16>, start: Vector2<f64>, a: &Matrix2<f64>) -> Option<Refined> {
        let extent = a.map(f64::abs) * Vector2::repeat(REACH_PX as f64);
        let window = Window::about(frame, &start, &extent.add_scalar(MAX_MOVEMENT_PX))?;
        let mut position = start;
        let mut moved = Vector2::zeros();
        let mut ncc = 0.0;
        for _ in 0..STEPS {
            let step = self.step(&window, position, a)?;
            moved += step.by;
            // That before the last step, which is a hundredth of a pixel.
            ncc = step.ncc;
            position = step.centre + a * step.by;
            if moved.norm_squared() > MAX_MOVEMENT_PX * MAX_MOVEMENT_PX {
                return None;
            }
        }
        if ncc < MIN_NCC {
            return None;
        }
        let residual = 2.0 * (1.0 - ncc).max(0.0) / (AREA - FITTED) as f64;
        Some(Refined { position, covariance: a * self.inverse * a.transpose() * residual })
    }

    /// Returns the next step from `q`; `None` if the patch there leaves the window or is uniform.
    fn step(&self, window: &Window, q: Vector2<f64>, a: &Matrix2<f64>) -> Option<Step> {
        let phases = q.map(|v| (v * PHASES as f64).round());
        let patch = patch(window, &phases, a)?;
        let sum = total(&patch) as f64;
        let variance = product_about_means(&patch, &patch, [sum, sum]);
        if variance < MIN_VARIANCE * AREA as f64 {
            return None;
        }
        let norms = self.norm * variance.sqrt();
        let ncc = product_about_means(&self.samples, &patch, [self.sum, sum]) / norms;
        let slopes = Vector2::from_fn(|axis, _| {
            product_about_means(&self.slopes[axis], &patch, [self.slope_sums[axis], sum]) / norms
        });
        Some(Step { centre: phases / PHASES as f64, by: self.inverse * (self.along * ncc - slopes), ncc })
    }
}

/// A step of Gauss and Newton.
struct Step {
    /// Where the frame was sampled, px.
    centre: Vector2<f64>,
    /// The step from there, px of the keyframe.
    by: Vector2<f64>,
    /// Normalised cross correlation there.
    ncc: f64,
}

/// Returns the patch whose centre is given in phases, warped by `a`; `None` if it leaves the window.
fn patch(window: &Window, phases: &Vector2<f64>, a: &Matrix2<f64>) -> Option<Patch> {
    const ONE: f64 = (1 << POSITION_BITS) as f64;
    const TO_PHASE: u32 = POSITION_BITS - PHASES.ilog2();
    let rounded = |position: i32| ((position + (1 << (TO_PHASE - 1))) >> TO_PHASE) as usize;
    let centre = phases / PHASES as f64;
    if !window.contains(&centre, &(a.map(f64::abs) * Vector2::repeat(REACH_PX as f64))) {
        return None;
    }
    let a = a.map(|v| (v * ONE).round() as i32);
    let place = |axis: usize| {
        let inside = (phases[axis] as i32 - (PHASES * window.corner[axis]) as i32) << TO_PHASE;
        inside - (a[(axis, 0)] + a[(axis, 1)]) * REACH_PX as i32
    };
    let [left, top] = [place(0), place(1)];
    let across = a.column(0) * STRIDE as i32;
    let down = a.column(1) * STRIDE as i32;
    let mut patch = [0; AREA];
    for (row, values) in patch.chunks_exact_mut(SIDE).enumerate() {
        let (mut x, mut y) = (left + down.x * row as i32, top + down.y * row as i32);
        for value in values {
            let (column, row) = (rounded(x), rounded(y));
            let columns = window.columns([column / PHASES, row / PHASES], &spline::WEIGHTS[row % PHASES]);
            *value = spline::sample(&columns, &spline::WEIGHTS[column % PHASES]);
            x += across.x;
            y += across.y;
        }
    }
    Some(patch)
}

#[cfg(test)]
mod tests;
