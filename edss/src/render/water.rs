//! Open water: travelling waves whose slopes reflect the sky and the sun.
//!
//! Six octaves of waves, each half as long as the one before and each with its own direction near that of the wind, are
//! four trains each, of a fifth of its wave number and 0.4 rad. A train travels at the phase speed of deep water,
//! `c = sqrt(g L / 2 pi)`, and in its own direction. Their slopes add. A slope `s` reflects the sun into
//! the camera if it equals the slope `h` of the plane half way between both; the glint is a bell about `h` whose width
//! is that of the waves shorter than a pixel (Cox and Munk 1954). Other slopes reflect the sky, brighter towards the
//! sun. Trains move relative to each other, so no pattern on the water persists, where a picture shows one octave too.

#![allow(clippy::needless_range_loop)]

use nalgebra::Vector2;
use rayon::prelude::*;

use super::mip::{LocalTexture, Mip, PlacedTexture, REPEATED, Texel};
use super::noise::unit;
use super::row::KNOT_SPACING;
use crate::scene::Water;

/// Texels along a side of a tile of waves.
const TILE_TEXELS: usize = 512;
/// Length of a tile in waves of mean length.
const WAVES_PER_TILE: f64 = 11.0;
/// Number of sine waves that make up a tile.
const SINES_PER_TILE: u32 = 10;
/// Number of trains of an octave.
const TRAINS: u32 = 4;
/// Range of wave numbers of an octave, in waves of mean length.
const NUMBERS: [f32; 2] = [0.65, 1.45];
/// Range of directions of an octave about its own, rad.
const DIRECTIONS: [f32; 2] = [-0.8, 0.8];
/// Full scale of the slopes stored in a tile, in multiples of their rms.
const FULL_SCALE_RMS: f32 = 4.0;
/// Number of octaves.
const OCTAVES: usize = 6;
/// Acceleration of gravity, m/s^2.
const GRAVITY: f64 = 9.81;
/// Variance of the slopes of waves shorter than the last octave.
const UNDRAWN_SLOPE_VARIANCE: f32 = 0.0012;

/// The waves of a water surface, with their textures.
pub struct Waves {
    layers: Vec<Layer>,
    /// Rms slope of each train.
    slope: f32,
}

/// One train of waves.
struct Layer {
    tile: PlacedTexture<u32, 4, REPEATED>,
    length: f64,
    velocity: Vector2<f64>,
    turn: [f32; 2],
}

/// The waves at one time, relative to an anchor.
pub struct LocalWaves<'a> {
    layers: Vec<(LocalTexture<'a, u32, 4, REPEATED>, [f32; 2], f32)>,
    slope: f32,
}

/// The reflection of the sun, at one end of a block of pixels.
#[derive(Debug, Clone, Copy)]
pub struct SunReflection {
    /// Slope that reflects the sun into the camera.
    pub slope: [f32; 2],
}

/// The wave numbers, in waves of mean length, and the directions (rad) of a train within its octave.
struct Train {
    numbers: [f32; 2],
    directions: [f32; 2],
}

impl Train {
    /// Returns train `index` of an octave: neighbouring wave numbers go in distant directions.
    fn of(index: u32) -> Self {
        let part = |[from, to]: [f32; 2], index: u32| {
            let step = (to - from) / TRAINS as f32;
            [from + step * index as f32, from + step * (index + 1) as f32]
        };
        Self { numbers: part(NUMBERS, index), directions: part(DIRECTIONS, [1, 3, 0, 2][index as usize]) }
    }

    /// Returns wave number and direction in the middle.
    fn middle(&self) -> [f32; 2] {
        [self.numbers, self.directions].map(|[from, to]| (from + to) / 2.0)
    }
}

impl Waves {
    /// Generates the waves from a seed.
    pub fn new(water: &Water, seed: u32) -> Self {
        let layers = (0..OCTAVES).flat_map(|k| (0..TRAINS).map(move |train| (k, train))).map(|(k, train)| {
            let length = water.wave_m / 2.0f64.powi(k as i32);
            let texel = length * WAVES_PER_TILE / TILE_TEXELS as f64;
            // Shorter waves spread further from the wind's direction.
            let aside = [0.1, -0.35, 0.6, -0.8, 1.0, -1.2][k];
            let angle = water.wind_to_deg.to_radians() + aside;
            let (sin, cos) = libm::sincos(angle);
            let index = k as u32 * TRAINS + train;
            let train = Train::of(train);
            let [number, direction] = train.middle();
            let (across, along) = libm::sincos(angle + f64::from(direction));
            let speed = (GRAVITY * length / f64::from(number) / std::f64::consts::TAU).sqrt();
            let mip = Mip::new(TILE_TEXELS, TILE_TEXELS, &texels(&train, seed.wrapping_add(index)));
            Layer {
                tile: PlacedTexture::new(mip, texel, angle, Vector2::new(37.0, 91.0) * f64::from(index)),
                length,
                velocity: Vector2::new(along, across) * speed,
                turn: [cos as f32, sin as f32],
            }
        });
        Self { layers: layers.collect(), slope: (water.slope / (OCTAVES as f64 * f64::from(TRAINS)).sqrt()) as f32 }
    }

    /// Returns the waves at a time (s), for sampling around an anchor (m).
    pub fn local(&self, anchor: Vector2<f64>, time: f64) -> LocalWaves<'_> {
        let layer = |layer: &'_ Layer| {
            let moved = anchor - layer.velocity * time;
            // A wave shorter than two pixels is not drawn.
            (moved, layer.turn, libm::log2(layer.length / 2.0) as f32)
        };
        let layers = self.layers.iter().map(|l| {
            let (moved, turn, shortest) = layer(l);
            (l.tile.local(moved), turn, shortest)
        });
        LocalWaves { layers: layers.collect(), slope: self.slope }
    }
}

impl LocalWaves<'_> {
    /// Computes the radiance, relative to white ground in full sun, at points `(x, y)` m from the anchor for pixels of
    /// `2^footprint` m.
    #[inline(always)]
    pub fn radiance(
        &self,
        x: &[f32; KNOT_SPACING],
        y: &[f32; KNOT_SPACING],
        footprint: f32,
        mirrors: [SunReflection; 2],
    ) -> [f32; KNOT_SPACING] {
        let mut slopes = [[0f32; 2]; KNOT_SPACING];
        let mut variance = UNDRAWN_SLOPE_VARIANCE;
        for (tile, [cos, sin], shortest) in &self.layers {
            // The part of the octave that the pixel does not resolve widens the glint instead.
            let seen = (shortest - footprint).clamp(0.0, 1.0);
            variance += self.slope * self.slope * (1.0 - seen);
            if seen == 0.0 {
                continue;
            }
            let gain = 2.0 * FULL_SCALE_RMS * self.slope * seen;
            let values = tile.sample(x, y, footprint);
            for l in 0..KNOT_SPACING {
                let (a, b) = (gain * (values[l][0] - 0.5), gain * (values[l][1] - 0.5));
                slopes[l][0] += cos * a - sin * b;
                slopes[l][1] += sin * a + cos * b;
            }
        }
        let width = 0.25 / variance;
        let peak = 0.018 / variance;
        let mut radiance = [0f32; KNOT_SPACING];
        for l in 0..KNOT_SPACING {
            let part = l as f32 / KNOT_SPACING as f32;
            let mirror = |n: usize| mirrors[0].slope[n] + part * (mirrors[1].slope[n] - mirrors[0].slope[n]);
            let (h, s) = ([mirror(0), mirror(1)], slopes[l]);
            let away = ((s[0] - h[0]).powi(2) + (s[1] - h[1]).powi(2)) * width;
            // (1 + q/2)^-2 in place of exp(-q): a bell with wider flanks, for glare.
            let bell = 1.0 / ((1.0 + away) * (1.0 + away));
            // The sky brightens towards the sun: to first order in the slope.
            let towards = s[0] * h[0] + s[1] * h[1];
            let steep = s[0] * s[0] + s[1] * s[1];
            let sky = 0.17 + 0.55 * towards + 0.35 * (s[0] + 0.6 * s[1]) + 0.8 * steep;
            radiance[l] = sky.max(0.02) + (peak * bell).min(1.6) * bell;
        }
        radiance
    }
}

/// Generates a tile: slopes of a sum of sine waves about the direction of the rows, of total rms 1.
fn texels(train: &Train, seed: u32) -> Vec<u32> {
    let waves: Vec<[f32; 4]> = (0..SINES_PER_TILE)
        .map(|k| {
            let draw = |n: u32| unit(k, n, seed);
            let within = |[from, to]: [f32; 2], part: f32| from + (to - from) * part;
            let number = WAVES_PER_TILE as f32 * within(train.numbers, draw(1));
            let (sin, cos) = libm::sincosf(within(train.directions, draw(2)));
            // Whole numbers of waves, so that the tile repeats.
            let (along, across) = ((number * cos).round().max(1.0), (number * sin).round());
            let norm = libm::hypotf(along, across);
            [along / TILE_TEXELS as f32, across / TILE_TEXELS as f32, draw(4), norm]
        })
        .collect();
    let amplitude = (2.0 / SINES_PER_TILE as f32).sqrt() / FULL_SCALE_RMS * 0.5;
    let mut texels = vec![0u32; TILE_TEXELS * TILE_TEXELS];
    texels.par_chunks_exact_mut(TILE_TEXELS).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            let mut slope = [0f32; 2];
            for [along, across, phase, norm] in &waves {
                let turns = along * x as f32 + across * y as f32 + phase;
                let cosine = cosine(turns);
                slope[0] += cosine * along * TILE_TEXELS as f32 / norm;
                slope[1] += cosine * across * TILE_TEXELS as f32 / norm;
            }
            let code = |v: f32| ((amplitude * v + 0.5) * 255.0).clamp(0.0, 255.0);
            *texel = u32::pack([code(slope[0]), code(slope[1]), 0.0, 0.0]);
        }
    });
    texels
}

/// Approximates `cos(2 pi t)` to 0.001 by a parabola and its square: faster than a cosine, and accurate enough here.
#[inline(always)]
fn cosine(turns: f32) -> f32 {
    let t = turns + 0.25;
    let t = 2.0 * (t - t.floor()) - 1.0;
    let parabola = 4.0 * t * (1.0 - t.abs());
    -(0.225 * (parabola * parabola.abs() - parabola) + parabola)
}
