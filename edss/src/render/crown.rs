//! The crown of a tree: a dozen balls of leaves, intersected with a bundle of rays.
//!
//! A ray `from + t d` is nearest to a centre `c` at `m = (c - from) . d / d . d`. With `a` the distance there, squared,
//! and the chord `h = r^2 - a > 0` it enters the ball at `t = m - sqrt(h / d . d)`.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use nalgebra::Vector3;

use super::bundle::{Lanes, RAYS, Rays, any_positive};

/// Number of balls of a crown.
pub const BALLS_PER_CROWN: usize = 12;

/// The balls of a crown: centres relative to that of the tree, and radii, m.
pub struct Crown {
    x: [f32; BALLS_PER_CROWN],
    y: [f32; BALLS_PER_CROWN],
    z: [f32; BALLS_PER_CROWN],
    radius: [f32; BALLS_PER_CROWN],
}

impl Crown {
    /// Creates a crown from centre and radius of each ball, m.
    pub fn new(balls: [(Vector3<f32>, f32); BALLS_PER_CROWN]) -> Self {
        Self {
            x: balls.map(|(centre, _)| centre.x),
            y: balls.map(|(centre, _)| centre.y),
            z: balls.map(|(centre, _)| centre.z),
            radius: balls.map(|(_, radius)| radius),
        }
    }

    /// Passes the ball that each ray enters first, before its limit, to `record`: lane, whether there is one, distance
    /// in lengths of the direction, and index. Limits become the distances.
    #[inline(always)]
    pub fn enter(&self, rays: &Rays, limit: &mut Lanes, mut record: impl FnMut(usize, bool, f32, u32)) {
        let (from, direction, square) = (&rays.from, &rays.direction, &rays.square);
        for k in 0..BALLS_PER_CROWN {
            let mut middle = [0f32; RAYS];
            let mut chord = [0f32; RAYS];
            for l in 0..RAYS {
                let (x, y, z) = (self.x[k] - from.x[l], self.y[k] - from.y[l], self.z[k] - from.z[l]);
                let m = (x * direction.x[l] + y * direction.y[l] + z * direction.z[l]) / square[l];
                // Avoids the difference of two large numbers.
                let (x, y, z) = (x - direction.x[l] * m, y - direction.y[l] * m, z - direction.z[l] * m);
                middle[l] = m;
                chord[l] = self.radius[k] * self.radius[k] - (x * x + y * y + z * z);
            }
            if !any_positive(&chord) {
                continue;
            }
            for l in 0..RAYS {
                // The root of a negative chord is not a number, and no comparison with it holds.
                let along = middle[l] - (chord[l] / square[l]).sqrt();
                let hits = chord[l] > 0.0 && along > 0.0 && along < limit[l];
                limit[l] = if hits { along } else { limit[l] };
                record(l, hits, along, k as u32);
            }
        }
    }

    /// Returns the outward normal at a point of a ball.
    pub fn normal(&self, ball: usize, point: &Vector3<f32>) -> Vector3<f32> {
        (point - Vector3::new(self.x[ball], self.y[ball], self.z[ball])) / self.radius[ball]
    }
}
