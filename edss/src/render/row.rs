//! The rays of a row of pixels and the points where they meet the ground, exact at every 8th pixel and interpolated
//! between.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use multiversion::multiversion;
use nalgebra::{Matrix3, Vector3};

use super::bundle::Vectors;
use super::view::Corrections;
use crate::pose::Pose;

/// Pixels from one exact intersection of a row to the next, and lanes of the vector loops.
pub(super) const KNOT_SPACING: usize = 8;

/// Smallest downward component of a ray's direction; rays nearer the horizon are treated as if they had it.
pub(super) const MIN_DOWNWARD: f32 = 0.02;

/// Position of a camera, and its rotation from camera to world axes.
#[derive(Clone, Copy)]
pub(super) struct Viewpoint {
    pub origin: Vector3<f64>,
    pub rotation: Matrix3<f64>,
}

impl Viewpoint {
    pub fn new(pose: &Pose) -> Self {
        Self { origin: pose.position, rotation: pose.attitude.rotation() }
    }
}

/// The exact intersection at every 8th pixel of a row.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Knot {
    /// Depth of the ground below the camera, m.
    pub depth: f32,
    /// Part of the light that passes the mist.
    pub transmission: f32,
    /// `log2` of the width of a pixel on the ground in m.
    pub footprint: f32,
}

/// The rays of a row of pixels and their intersections with the ground, m, relative to the point below the camera.
pub(super) struct Row {
    /// Direction of each ray in the world, with 1 along the optical axis; as far as the last knot.
    directions: [Vec<f32>; 3],
    pub knots: Vec<Knot>,
    pub x: Vec<[f32; KNOT_SPACING]>,
    pub y: Vec<[f32; KNOT_SPACING]>,
    /// Distance along the ray, in lengths of its direction.
    pub along: Vec<[f32; KNOT_SPACING]>,
}

impl Row {
    pub fn new(width: usize) -> Self {
        let knots = (width - 1) / KNOT_SPACING + 2;
        let rays = (knots - 1) * KNOT_SPACING + 1;
        let zeros = |count: usize| vec![0f32; count];
        Self {
            directions: [zeros(rays), zeros(rays), zeros(rays)],
            knots: vec![Knot::default(); knots],
            x: vec![[0.0; KNOT_SPACING]; knots - 1],
            y: vec![[0.0; KNOT_SPACING]; knots - 1],
            along: vec![[0.0; KNOT_SPACING]; knots - 1],
        }
    }

    /// Sets the rays for row `y`.
    pub fn aim(
        &mut self,
        inverse: &Matrix3<f64>,
        corrections: Option<&Corrections>,
        rotation: &Matrix3<f64>,
        y: usize,
    ) {
        let start = inverse * Vector3::new(0.0, y as f64, 1.0);
        aim(&mut self.directions, [start.x, inverse[(0, 0)], start.y], corrections, &rotation.map(|v| v as f32));
    }

    /// Returns the directions of the rays of the pixels between two knots.
    pub fn directions(&self, block: usize) -> Vectors {
        let of = |axis: &[f32]| std::array::from_fn(|l| axis[block * KNOT_SPACING + l]);
        let [dx, dy, dz] = &self.directions;
        Vectors { x: of(dx), y: of(dy), z: of(dz) }
    }

    /// Returns the direction of the ray of pixel `x` in the world, with 1 along the optical axis.
    pub fn direction(&self, x: usize) -> Vector3<f32> {
        let [dx, dy, dz] = &self.directions;
        Vector3::new(dx[x], dy[x], dz[x])
    }
}

/// Computes the rays of a row with normalised coordinates `(start + step x, v)`.
#[multiversion(targets("x86_64+avx2"))]
fn aim(
    directions: &mut [Vec<f32>; 3],
    [start, step, v]: [f64; 3],
    corrections: Option<&Corrections>,
    rotation: &Matrix3<f32>,
) {
    let [dx, dy, dz] = directions;
    let rotation: [[f32; 3]; 3] = (*rotation).into();
    let [a, b, c] = rotation;
    for (x, ((dx, dy), dz)) in dx.iter_mut().zip(dy).zip(dz).enumerate() {
        // f64 along the row keeps the pixel grid regular to 1e-9.
        let (mut u, mut v) = ((start + step * f64::from(x as i32)) as f32, v as f32);
        if let Some(corrections) = corrections {
            let scale = corrections.at(u * u + v * v);
            (u, v) = (u * scale, v * scale);
        }
        *dx = a[0] * u + b[0] * v + c[0];
        *dy = a[1] * u + b[1] * v + c[1];
        *dz = a[2] * u + b[2] * v + c[2];
    }
}

/// Interpolates the points on the ground between the knots.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn interpolate_points(row: &mut Row) {
    let [dx, dy, dz] = &row.directions;
    let directions =
        dx.chunks_exact(KNOT_SPACING).zip(dy.chunks_exact(KNOT_SPACING)).zip(dz.chunks_exact(KNOT_SPACING));
    let points = row.along.iter_mut().zip(row.x.iter_mut().zip(&mut row.y));
    for ((pair, ((dx, dy), dz)), (along, (x, y))) in row.knots.windows(2).zip(directions).zip(points) {
        let (first, slope) = (pair[0].depth, (pair[1].depth - pair[0].depth) * (1.0 / KNOT_SPACING as f32));
        for l in 0..KNOT_SPACING {
            let depth = (first + l as f32 * slope).max(0.01);
            along[l] = depth / dz[l].max(MIN_DOWNWARD);
            x[l] = dx[l] * along[l];
            y[l] = dy[l] * along[l];
        }
    }
}
