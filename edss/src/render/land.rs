//! The larger structure of procedural ground: brightness, and how much of each material, on a map of 10 cm texels.
//!
//! The map spans 205 m about the origin and is mirrored at its borders. What is finer comes from [`super::grain`].

pub mod apron;
pub mod field;
pub mod town;

use nalgebra::Vector2;
use rayon::prelude::*;

use super::mip::{Laid, MIRRORED, Mip, Texel};

/// Side of the map, texels.
pub const SIDE: usize = 2048;
/// Side of a texel, m.
pub const TEXEL: f64 = 0.1;

/// What a point of the ground is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Part of the sunlight that comes back, without grain.
    pub albedo: f32,
    /// Grain of vegetation, soil and pavement: rms, relative to `albedo`.
    pub grain: [f32; 3],
}

impl Material {
    /// `part` of `other` and the rest of this.
    pub fn mix(self, other: Self, part: f32) -> Self {
        let mix = |a: f32, b: f32| a + part * (b - a);
        Self {
            albedo: mix(self.albedo, other.albedo),
            grain: std::array::from_fn(|n| mix(self.grain[n], other.grain[n])),
        }
    }
}

/// Full scale of the map: brightness, then grain.
pub const FULL: [f32; 4] = [1.0, 0.5, 0.5, 0.5];

/// The map of a ground given point by point.
pub fn map(ground: impl Fn(Vector2<f32>) -> Material + Sync) -> Laid<u32, 4, MIRRORED> {
    let mut texels = vec![0u32; SIDE * SIDE];
    texels.par_chunks_exact_mut(SIDE).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            let metres = |i: usize| ((i as f64 + 0.5 - SIDE as f64 / 2.0) * TEXEL) as f32;
            let Material { albedo, grain } = ground(Vector2::new(metres(x), metres(y)));
            let values = [albedo, grain[0], grain[1], grain[2]];
            *texel = u32::pack(std::array::from_fn(|n| values[n] / FULL[n] * 255.0));
        }
    });
    let middle = Vector2::repeat(SIDE as f64 / 2.0);
    Laid::new(Mip::new(SIDE, SIDE, &texels), TEXEL, 0.0, middle)
}

/// What a sample of the map says.
#[inline(always)]
pub fn material(sample: [f32; 4]) -> Material {
    let value = |n: usize| sample[n] * FULL[n];
    Material { albedo: value(0), grain: [value(1), value(2), value(3)] }
}
