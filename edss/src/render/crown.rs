//! The crown of a tree: a dozen balls of leaves, intersected with a ray all at once.
//!
//! A ray `from + t d` is nearest to a centre `c` at `m = (c - from) . d / d . d`. With `a` the distance there, squared,
//! and the chord `h = r^2 - a > 0` it enters the ball at `t = m - sqrt(h / d . d)`.
//!
//! Coordinates are stored as one array per axis, so that the compiler computes several balls in one instruction.

use nalgebra::Vector3;

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

    /// Returns the distance at which a ray first enters a ball, and the index of that ball; `None` if that is not
    /// nearer than `limit`. Distances are in lengths of `direction`.
    pub fn enter(&self, from: &Vector3<f32>, direction: &Vector3<f32>, limit: f32) -> Option<(f32, usize)> {
        let square = direction.norm_squared();
        let mut middle = [0f32; BALLS_PER_CROWN];
        let mut chord = [0f32; BALLS_PER_CROWN];
        for k in 0..BALLS_PER_CROWN {
            let (x, y, z) = (self.x[k] - from.x, self.y[k] - from.y, self.z[k] - from.z);
            let m = (x * direction.x + y * direction.y + z * direction.z) / square;
            // Avoids the difference of two large numbers.
            let (x, y, z) = (x - direction.x * m, y - direction.y * m, z - direction.z * m);
            middle[k] = m;
            chord[k] = self.radius[k] * self.radius[k] - (x * x + y * y + z * z);
        }
        if chord.iter().fold(0f32, |most, chord| most.max(*chord)) <= 0.0 {
            return None;
        }
        // The root of a negative chord is not a number, and no comparison with it holds.
        let along: [f32; BALLS_PER_CROWN] = std::array::from_fn(|k| middle[k] - (chord[k] / square).sqrt());
        let mut first = None;
        let mut nearest = limit;
        for (k, &along) in along.iter().enumerate() {
            if chord[k] > 0.0 && along > 0.0 && along < nearest {
                (first, nearest) = (Some((along, k)), along);
            }
        }
        first
    }

    /// Returns the outward normal at a point of a ball.
    pub fn normal(&self, ball: usize, point: &Vector3<f32>) -> Vector3<f32> {
        (point - Vector3::new(self.x[ball], self.y[ball], self.z[ball])) / self.radius[ball]
    }
}
