//! Fine structure of the ground: two tiles of soil, vegetation and pavement, turned against each other.
//!
//! The finer tile spans 6.1 m with texels of 6 mm, the coarser 27.7 m with texels of 27 mm. Their sides and angles have
//! no common multiple, and the larger structure of the ground does not repeat, so no repetition is visible.

#![allow(clippy::needless_range_loop)]

use std::sync::{Arc, LazyLock};

use multiversion::multiversion;
use nalgebra::Vector2;
use rayon::prelude::*;

use super::mip::{LocalTexture, Mip, PlacedTexture, REPEATED, Texel};
use super::noise::{gradient, octaves, unit};

/// Texels along a side of a tile.
const TILE_TEXELS: u32 = 1024;
/// Full scale of the tiles, in multiples of their rms.
pub const FULL_SCALE_RMS: f32 = 5.0;

/// `log2` of the pixel width (m) from which on the finer tile has no structure left: its longest cells are 32 texels,
/// two of which make a wave.
const FINE_TILE_MAX_FOOTPRINT: f32 = -2.7;

/// Channel of vegetation.
pub const GREEN: usize = 0;
/// Channel of bare soil.
pub const SOIL: usize = 1;
/// Channel of asphalt and stone.
pub const HARD: usize = 2;
/// Channel of the leaves of trees.
pub const LEAF: usize = 3;

/// The two tiles, placed on the ground.
pub struct Grain {
    tiles: [PlacedTexture<u32, 4, REPEATED>; 2],
}

/// The textures of the tiles, generated once: scenes differ only in their placement.
static TILES: LazyLock<[Arc<Mip<u32, 4, REPEATED>>; 2]> = LazyLock::new(|| {
    [1, 2].map(|seed| Arc::new(Mip::new(TILE_TEXELS as usize, TILE_TEXELS as usize, &texels(1000 * seed))))
});

impl Grain {
    /// Places the tiles at random offsets by a seed.
    pub fn new(seed: u32) -> Self {
        let tile = |k: u32, texel: f64, angle: f64| {
            let shift = |n| f64::from(TILE_TEXELS) * f64::from(unit(k, n, seed));
            PlacedTexture::new(Arc::clone(&TILES[k as usize]), texel, angle, Vector2::new(shift(0), shift(1)))
        };
        Self { tiles: [tile(0, 0.0060, 0.41), tile(1, 0.0271, 1.13)] }
    }

    /// Returns the tiles for sampling around `anchor` (m).
    pub fn local(&self, anchor: Vector2<f64>) -> LocalGrain<'_> {
        LocalGrain { tiles: [self.tiles[0].local(anchor), self.tiles[1].local(anchor)] }
    }
}

/// The tiles for sampling around an anchor.
pub struct LocalGrain<'a> {
    tiles: [LocalTexture<'a, u32, 4, REPEATED>; 2],
}

impl LocalGrain<'_> {
    /// Samples the four channels, each the sum of both tiles in units of a tile's rms, at points `(x, y)` m from the
    /// anchor, for pixels of `2^footprint` m.
    #[inline(always)]
    pub fn sample<const L: usize>(&self, x: &[f32; L], y: &[f32; L], footprint: f32) -> [[f32; 4]; L] {
        let mut value = self.tiles[1].sample(x, y, footprint);
        let mut mean = 0.5;
        if footprint < FINE_TILE_MAX_FOOTPRINT {
            let fine = self.tiles[0].sample(x, y, footprint);
            mean = 1.0;
            for l in 0..L {
                for n in 0..4 {
                    value[l][n] += fine[l][n];
                }
            }
        }
        for l in 0..L {
            for n in 0..4 {
                value[l][n] = (value[l][n] - mean) * (2.0 * FULL_SCALE_RMS);
            }
        }
        value
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn fill(row: &mut [[f32; 4]], y: u32, seed: u32) {
    for (x, texel) in row.iter_mut().enumerate() {
        *texel = at(x as u32, y, seed);
    }
}

/// Generates a tile whose channels have mean 0 and rms 1.
fn texels(seed: u32) -> Vec<u32> {
    let mut raw = vec![[0f32; 4]; (TILE_TEXELS * TILE_TEXELS) as usize];
    raw.par_chunks_exact_mut(TILE_TEXELS as usize).enumerate().for_each(|(y, row)| {
        fill(row, y as u32, seed);
    });
    // Summed in order, so that the sum has the same bits for every number of threads.
    let mut moments = [[0f64; 2]; 4];
    for texel in &raw {
        for n in 0..4 {
            let v = f64::from(texel[n]);
            moments[n][0] += v;
            moments[n][1] += v * v;
        }
    }
    let count = raw.len() as f64;
    let scaling = moments.map(|[sum, squares]| {
        let mean = sum / count;
        (mean as f32, (1.0 / (squares / count - mean * mean).sqrt()) as f32)
    });
    let code = |value: f32, (mean, gain): (f32, f32)| ((value - mean) * gain / FULL_SCALE_RMS * 0.5 + 0.5) * 255.0;
    raw.iter().map(|texel| u32::pack(std::array::from_fn(|n| code(texel[n], scaling[n])))).collect()
}

#[inline(always)]
fn at(x: u32, y: u32, seed: u32) -> [f32; 4] {
    // Lattice cells of 32 texels and, by octaves, down to 2.
    let (u, v) = ((x as f32 + 0.5) / 32.0, (y as f32 + 0.5) / 32.0);
    let period = TILE_TEXELS / 32;
    let smooth = octaves(u, v, period, seed, 5, 0.8);
    // Tufts: bright where the noise is high. Clods: cracks along its zeros.
    let tufts = gradient(u * 8.0, v * 8.0, period * 8, seed + 40).max(-0.1);
    let green = smooth + 1.2 * tufts;
    let clods = gradient(u * 4.0, v * 4.0, period * 4, seed + 41).abs()
        + 0.8 * gradient(u * 2.0, v * 2.0, period * 2, seed + 42).abs();
    let soil = 0.7 * smooth + 2.2 * clods.min(0.5);
    // Stones of single texels, larger ones, and cracks.
    let stone = unit(x, y, seed + 43) - 0.5;
    let speck = if unit(x / 2, y / 2, seed + 44) > 0.993 { 1.3 } else { 0.0 };
    let crack = gradient(u / 2.0, v / 2.0, period / 2, seed + 45).abs();
    let hard = 0.9 * smooth + 0.5 * stone + speck - if crack < 0.006 { 0.9 } else { 0.0 };
    let holes = gradient(u * 4.0, v * 4.0, period * 4, seed + 46).min(0.15);
    let leaf = 0.5 * smooth + 2.0 * holes;
    [green, soil, hard, leaf]
}
