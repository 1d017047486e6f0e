//! The larger structure of procedural ground: albedo and kinds of grain on a map of 10 cm texels.
//!
//! The map spans 205 m about the origin and is mirrored at its borders. Finer structure comes from [`super::grain`].

pub mod apron;
pub mod field;
pub mod town;

use nalgebra::Vector2;
use rayon::prelude::*;

use super::mip::{MIRRORED, Mip, PlacedTexture, Texel};

/// Side of the map, texels.
const MAP_TEXELS: usize = 2048;
/// Side of a texel, m.
const TEXEL_M: f64 = 0.1;

/// The surface of the ground at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Part of the light that is reflected, without grain.
    pub albedo: f32,
    /// Rms of the grain of vegetation, soil and pavement, relative to `albedo`.
    pub grain: [f32; 3],
}

impl Material {
    /// Mixes the part `part` of `other` with the rest of this material.
    pub fn mix(self, other: Self, part: f32) -> Self {
        let mix = |a: f32, b: f32| a + part * (b - a);
        Self {
            albedo: mix(self.albedo, other.albedo),
            grain: std::array::from_fn(|n| mix(self.grain[n], other.grain[n])),
        }
    }
}

/// Full scale of the channels of the map: albedo, then grain.
const FULL_SCALE: [f32; 4] = [1.0, 0.5, 0.5, 0.5];

/// Renders the map of a ground that is given as a function of the point (m).
pub fn map(ground: impl Fn(Vector2<f32>) -> Material + Sync) -> PlacedTexture<u32, 4, MIRRORED> {
    let mut texels = vec![0u32; MAP_TEXELS * MAP_TEXELS];
    texels.par_chunks_exact_mut(MAP_TEXELS).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            let metres = |i: usize| ((i as f64 + 0.5 - MAP_TEXELS as f64 / 2.0) * TEXEL_M) as f32;
            let Material { albedo, grain } = ground(Vector2::new(metres(x), metres(y)));
            let values = [albedo, grain[0], grain[1], grain[2]];
            *texel = u32::pack(std::array::from_fn(|n| values[n] / FULL_SCALE[n] * 255.0));
        }
    });
    let middle = Vector2::repeat(MAP_TEXELS as f64 / 2.0);
    PlacedTexture::new(Mip::new(MAP_TEXELS, MAP_TEXELS, &texels), TEXEL_M, 0.0, middle)
}

/// Converts a sample of the map into a material.
#[inline(always)]
pub fn material(sample: [f32; 4]) -> Material {
    let value = |n: usize| sample[n] * FULL_SCALE[n];
    Material { albedo: value(0), grain: [value(1), value(2), value(3)] }
}
