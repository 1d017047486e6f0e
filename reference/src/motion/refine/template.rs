//! The patch of REF, and the step of Gauss-Newton that a patch of CUR gives.

use crate::image::plane::Plane;
use crate::motion::refine::spline::{sample, value_and_slope};
use nalgebra::{Matrix2, Vector2};

/// Samples of a patch along an axis. An even number has no sample at the centre: the samples are at odd distances.
pub const SIDE: usize = 12;

/// Distance of neighbouring samples, px.
pub const STRIDE: usize = 2;

/// Distance of the outermost samples from the centre of the patch, px.
pub const REACH_PX: usize = (SIDE - 1) * STRIDE / 2;

/// Samples of a patch.
pub const AREA: usize = SIDE * SIDE;

/// Smallest ratio of the eigenvalues of the normal matrix.
pub const MIN_EIGENVALUE_RATIO: f64 = 0.02;

/// Smallest norm of the samples of a patch about their mean, DN. A uniform patch has that of the rounding only.
const MIN_NORM: f64 = 1.0;

/// A patch of REF, normalised to mean 0 and norm 1, with its gradient and the inverse of the normal matrix.
pub struct Template {
    samples: [f64; AREA],
    slopes: [Vector2<f64>; AREA],
    inverse: Matrix2<f64>,
}

impl Template {
    /// Cuts the patch about the whole pixel `p`. Returns `None` if the patch or its neighbours leave the frame, or if
    /// its gradients have one direction only.
    pub fn of(frame: &Plane<u16>, p: Vector2<f64>) -> Option<Self> {
        let margin = (REACH_PX + 1) as f64;
        let inside = |v: f64, size: usize| v >= margin && v + margin < size as f64;
        if !(inside(p.x, frame.width()) && inside(p.y, frame.height())) {
            return None;
        }
        let (left, top) = (p.x as usize - REACH_PX, p.y as usize - REACH_PX);
        let (mut samples, mut slopes) = ([0.0; AREA], [Vector2::zeros(); AREA]);
        for (i, (value, slope)) in samples.iter_mut().zip(&mut slopes).enumerate() {
            (*value, *slope) = value_and_slope(frame, left + STRIDE * (i % SIDE), top + STRIDE * (i / SIDE));
        }
        let norm = normalise(&mut samples)?;
        let mut normal = Matrix2::zeros();
        let mut along = Vector2::zeros();
        let mut mean = Vector2::zeros();
        for (slope, sample) in slopes.iter_mut().zip(&samples) {
            *slope /= norm;
            mean += *slope / AREA as f64;
            along += *slope * *sample;
        }
        // The part of a displacement that gain and offset explain as well is removed.
        for (slope, sample) in slopes.iter_mut().zip(&samples) {
            *slope -= mean + along * *sample;
            normal += *slope * slope.transpose();
        }
        let eigenvalues = normal.symmetric_eigenvalues();
        let has_two_directions = eigenvalues.min() > MIN_EIGENVALUE_RATIO * eigenvalues.max();
        has_two_directions.then(|| normal.try_inverse()).flatten().map(|inverse| Self { samples, slopes, inverse })
    }

    /// Returns the next step, px of REF, and the NCC for the patch of CUR about `centre`, or `None` if it leaves the
    /// frame or is uniform.
    pub fn step(&self, current: &Plane<u16>, centre: Vector2<f64>, a: &Matrix2<f64>) -> Option<(Vector2<f64>, f64)> {
        let mut patch = [0.0; AREA];
        for (i, value) in patch.iter_mut().enumerate() {
            let place = |i: usize| (STRIDE * i) as f64 - REACH_PX as f64;
            *value = sample(current, centre + a * Vector2::new(place(i % SIDE), place(i / SIDE)))?;
        }
        normalise(&mut patch)?;
        let (mut gradient, mut ncc) = (Vector2::zeros(), 0.0);
        for ((sample, slope), patch) in self.samples.iter().zip(&self.slopes).zip(&patch) {
            gradient += *slope * (sample - patch);
            ncc += sample * patch;
        }
        Some((self.inverse * gradient, ncc))
    }
}

/// Normalises samples to mean 0 and norm 1 and returns the norm they had, or `None` if the patch is uniform.
fn normalise(samples: &mut [f64; AREA]) -> Option<f64> {
    let mean = samples.iter().sum::<f64>() / AREA as f64;
    let mut squares = 0.0;
    for sample in samples.iter_mut() {
        *sample -= mean;
        squares += *sample * *sample;
    }
    let norm = squares.sqrt();
    (norm >= MIN_NORM).then(|| {
        samples.iter_mut().for_each(|sample| *sample /= norm);
        norm
    })
}
