//! A paved square of slabs, with grass around it.

use nalgebra::Vector2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Material;
use crate::render::noise::{gradient, octaves, unit};

/// Side of a slab, m: long enough that the joints alone give no pattern to match.
const SLAB_M: f32 = 7.5;

/// A paved square in a meadow, or a meadow alone.
pub struct Apron {
    half: f32,
    seed: u32,
}

impl Apron {
    /// Generates a square of `side` m; 0 for a meadow alone.
    pub fn new(side: f32, random: &mut ChaCha8Rng) -> Self {
        Self { half: side / 2.0, seed: random.random() }
    }

    /// Returns the material at a point, m.
    pub fn at(&self, p: Vector2<f32>) -> Material {
        let ragged = gradient(p.x / 0.6, p.y / 0.6, 0, self.seed);
        let inside = self.half - p.x.abs().max(p.y.abs()) + 0.35 * ragged;
        if inside > 0.0 { self.paved(p) } else { self.meadow(p) }
    }

    fn meadow(&self, p: Vector2<f32>) -> Material {
        let patches = octaves(p.x / 25.0, p.y / 25.0, 0, self.seed + 1, 5, 0.75);
        let small = octaves(p.x / 1.6, p.y / 1.6, 0, self.seed + 8, 3, 0.8);
        let worn = ((octaves(p.x / 9.0, p.y / 9.0, 0, self.seed + 12, 3, 0.6) - 0.22) * 6.0).clamp(0.0, 1.0);
        let grass = Material { albedo: 0.34 * (1.0 + 0.55 * patches + 0.45 * small), grain: [0.20, 0.02, 0.0] };
        grass.mix(Material { albedo: 0.50 * (1.0 + 0.4 * small), grain: [0.05, 0.14, 0.02] }, 0.7 * worn)
    }

    fn paved(&self, p: Vector2<f32>) -> Material {
        let slab = p / SLAB_M;
        let (i, j) = (slab.x.floor(), slab.y.floor());
        let joint = [slab.x - i, slab.y - j].map(|t| t.min(1.0 - t) * SLAB_M);
        let tone = unit(i as i32 as u32, j as i32 as u32, self.seed + 20) - 0.5;
        let stains = octaves(p.x / 14.0, p.y / 14.0, 0, self.seed + 21, 6, 0.75);
        let oil = ((octaves(p.x / 3.0, p.y / 3.0, 0, self.seed + 28, 3, 0.6) - 0.28) * 8.0).clamp(0.0, 1.0);
        let mut albedo = 0.40 * (1.0 + 0.14 * tone + 0.38 * stains) * (1.0 - 0.35 * oil);
        let width = 0.05 + 0.06 * gradient(p.x / 1.1, p.y / 1.1, 0, self.seed + 32).abs();
        if joint[0].min(joint[1]) < width {
            albedo *= 0.62;
        }
        Material { albedo, grain: [0.0, 0.02, 0.11] }
    }
}
