//! Fine structure of the ground: two tiles of soil, vegetation and pavement, turned against each other.
//!
//! The finer tile spans 6.1 m with texels of 6 mm, the coarser 27.7 m with texels of 27 mm. Their sides and angles have
//! no common multiple, and each lies over a ground whose larger structure does not repeat, so the sum does not repeat
//! either.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::mip::{Border, Laid, Mip, Near};
use super::noise::{gradient, octaves, unit};

/// Texels along a side.
const SIDE: u32 = 1024;
/// Full scale of the tiles, in their rms.
pub const FULL: f32 = 5.0;

/// Channels of a tile.
pub const GREEN: usize = 0;
/// Bare soil.
pub const SOIL: usize = 1;
/// Asphalt and stone.
pub const HARD: usize = 2;
/// Leaves of trees.
pub const LEAF: usize = 3;

/// The two tiles.
pub struct Grain {
    tiles: [Laid<4>; 2],
}

impl Grain {
    /// The tiles of a seed.
    pub fn new(seed: u32) -> Self {
        let tile = |k: u32, texel: f64, angle: f64| {
            let mip = Mip::new(SIDE as usize, SIDE as usize, texels(seed.wrapping_add(1000 * k)), Border::Repeated);
            let shift = |n| f64::from(SIDE) * f64::from(unit(k, n, seed));
            Laid::new(mip, texel, angle, Vector2::new(shift(0), shift(1)))
        };
        Self { tiles: [tile(0, 0.0060, 0.41), tile(1, 0.0271, 1.13)] }
    }

    /// Made ready for points near `anchor`.
    pub fn near(&self, anchor: Vector2<f64>) -> NearGrain<'_> {
        NearGrain { tiles: [self.tiles[0].near(anchor), self.tiles[1].near(anchor)] }
    }
}

/// The tiles as seen from an anchor.
pub struct NearGrain<'a> {
    tiles: [Near<'a, 4>; 2],
}

impl NearGrain<'_> {
    /// The four channels, each the sum of both tiles, in units of a tile's rms.
    #[inline(always)]
    pub fn sample(&self, x: f32, y: f32, footprint: f32) -> [f32; 4] {
        let a = self.tiles[0].sample(x, y, footprint);
        let b = self.tiles[1].sample(x, y, footprint);
        let mut value = [0.0; 4];
        for n in 0..4 {
            value[n] = (a[n] + b[n] - 65535.0) * (2.0 * FULL / 65535.0);
        }
        value
    }
}

/// One tile, each channel of mean 0 and rms 1.
fn texels(seed: u32) -> Vec<[u16; 4]> {
    let mut raw = vec![[0f32; 4]; (SIDE * SIDE) as usize];
    raw.par_chunks_exact_mut(SIDE as usize).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            *texel = at(x as u32, y as u32, seed);
        }
    });
    // Rows are summed one by one in order, so that the sum has the same bits for every number of threads.
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
    raw.iter()
        .map(|texel| {
            std::array::from_fn(|n| {
                let (mean, gain) = scaling[n];
                let v = (texel[n] - mean) * gain;
                ((v / FULL * 0.5 + 0.5) * 65535.0 + 0.5) as u16
            })
        })
        .collect()
}

fn at(x: u32, y: u32, seed: u32) -> [f32; 4] {
    // Lattice cells of 128 texels and, by octaves, down to 2.
    let (u, v) = ((x as f32 + 0.5) / 128.0, (y as f32 + 0.5) / 128.0);
    let period = SIDE / 128;
    let smooth = octaves(u, v, period, seed, 7, 0.75);
    let crumbs = octaves(u * 4.0, v * 4.0, period * 4, seed + 20, 5, 0.8);
    // Tufts: bright where two noises agree. Clods: cracks along the zeros of the noise.
    let tufts = gradient(u * 32.0, v * 32.0, period * 32, seed + 40).max(-0.1);
    let green = smooth + 1.2 * tufts + 0.6 * crumbs;
    let clods = gradient(u * 16.0, v * 16.0, period * 16, seed + 41).abs().min(0.3)
        + 0.8 * gradient(u * 8.0, v * 8.0, period * 8, seed + 42).abs().min(0.3);
    let soil = 0.7 * smooth + 2.2 * clods + 0.5 * crumbs;
    // Stones of single texels, a few larger stains, and cracks.
    let stone = unit(x, y, seed + 43) - 0.5;
    let speck = if unit(x / 2, y / 2, seed + 44) > 0.993 { 1.3 } else { 0.0 };
    let crack = gradient(u * 2.0, v * 2.0, period * 2, seed + 45).abs();
    let hard = 0.9 * smooth + 0.5 * stone + speck - if crack < 0.006 { 0.9 } else { 0.0 } + 0.3 * crumbs;
    let holes = gradient(u * 16.0, v * 16.0, period * 16, seed + 46).min(0.15);
    let leaf = 0.5 * smooth + 2.0 * holes + 0.7 * crumbs;
    [green, soil, hard, leaf]
}
