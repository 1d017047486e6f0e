//! The relief: height of the ground, `Z = -h(X_e, Y_e)`, on a lattice with bilinear interpolation.
//!
//! A ray from height `H` hits it where `F(v) = H - h(p + v s) - v = 0`, `v` the depth and `s` the ray's motion
//! along the ground per metre of depth. Newton's step `v -= F / F'` takes the slope from the same four heights. It
//! converges from any start if slope times `|s|` is below 1, as it is for a down-looking camera.

use hoverlock_reference::image::plane::Plane;
use nalgebra::Vector2;
use rayon::prelude::*;

use super::noise::unit;
use crate::scene::Hills;

/// A lattice of heights.
pub struct Relief {
    side: [usize; 2],
    mirrored: bool,
    /// Side of a cell, m.
    cell: f64,
    /// Lattice point at the origin of the world.
    origin: [f64; 2],
    /// Height, m, and slopes along both axes of each lattice point.
    points: Vec<[f32; 3]>,
    /// Lowest and highest point, m.
    limits: [f64; 2],
    steepest: f64,
}

/// The height and slope of the relief at a point.
#[derive(Debug, Clone, Copy, Default)]
pub struct Height {
    /// Over the mean ground, m.
    pub h: f64,
    /// Slopes `dh/dX` and `dh/dY`, m/m.
    pub slope: [f64; 2],
}

/// Lattice points along a side of generated hills.
const LATTICE_POINTS: usize = 1024;
/// Lattice points per wavelength of the longest hills.
const POINTS_PER_WAVELENGTH: f64 = 64.0;

/// Number of sine waves in an octave.
const WAVES_PER_OCTAVE: u32 = 16;
/// Ratio of the amplitude of an octave to that of the one twice as long.
const OCTAVE_GAIN: f64 = 0.3;

/// Adds `gain cos(a x + b y + phase)`, a product of tables along both sides.
fn add_wave(heights: &mut [f32], numbers: [f64; 2], phase: f64, gain: f64) {
    let table = |number: f64, phase: f64| -> Vec<(f64, f64)> {
        let step = std::f64::consts::TAU * number / LATTICE_POINTS as f64;
        (0..LATTICE_POINTS).map(|i| libm::sincos(step * i as f64 + phase)).collect()
    };
    let (across, down) = (table(numbers[0], phase), table(numbers[1], 0.0));
    heights.par_chunks_exact_mut(LATTICE_POINTS).zip(&down).for_each(|(row, (sin_y, cos_y))| {
        for (height, (sin_x, cos_x)) in row.iter_mut().zip(&across) {
            *height += (gain * (cos_x * cos_y - sin_x * sin_y)) as f32;
        }
    });
}

impl Relief {
    /// Generates hills from a seed as a sum of sine waves. Heights are Gaussian; the rms slope is `2 pi / wavelength`
    /// times the rms height. The hills repeat after 16 wavelengths.
    pub fn hills(hills: &Hills, seed: u32) -> Self {
        let mut heights = vec![0f32; LATTICE_POINTS * LATTICE_POINTS];
        for octave in 0..hills.octaves {
            let gain = libm::pow(OCTAVE_GAIN, octave.into());
            for wave in 0..WAVES_PER_OCTAVE {
                let draw = |n: u32| f64::from(unit(wave, n, seed.wrapping_add(octave)));
                // Evenly spread directions, and lengths within a quarter of the mean.
                let turn = std::f64::consts::PI * (f64::from(wave) + draw(0)) / f64::from(WAVES_PER_OCTAVE);
                let number =
                    LATTICE_POINTS as f64 / POINTS_PER_WAVELENGTH * f64::from(1u32 << octave) * (0.8 + 0.45 * draw(1));
                let (sin, cos) = libm::sincos(turn);
                // Whole numbers of waves, so that the lattice repeats.
                let numbers = [(number * cos).round(), (number * sin).round()];
                add_wave(&mut heights, numbers, std::f64::consts::TAU * draw(2), gain);
            }
        }
        let count = heights.len() as f64;
        let mean = heights.iter().map(|&h| f64::from(h)).sum::<f64>() / count;
        let square = heights.iter().map(|&h| (f64::from(h) - mean).powi(2)).sum::<f64>() / count;
        let gain = hills.rms_m / square.sqrt();
        heights.iter_mut().for_each(|h| *h = ((f64::from(*h) - mean) * gain) as f32);
        Self::new(
            [LATTICE_POINTS, LATTICE_POINTS],
            heights,
            false,
            hills.wavelength_m / POINTS_PER_WAVELENGTH,
            [0.0, 0.0],
        )
    }

    /// Converts a picture into heights: black and white are `height` m apart, the mean is at 0, the middle at the
    /// origin. The relief is mirrored at the borders of the picture.
    pub fn map(picture: &Plane<u16>, texel: f64, height: f64) -> Self {
        let side = [picture.width(), picture.height()];
        let samples = picture.as_slice();
        let mean = samples.iter().map(|&v| f64::from(v)).sum::<f64>() / samples.len() as f64;
        let heights = samples.iter().map(|&v| ((f64::from(v) - mean) * height / 65535.0) as f32).collect();
        Self::new(side, heights, true, texel, side.map(|side| (side as f64 - 1.0) / 2.0))
    }

    fn new(side: [usize; 2], heights: Vec<f32>, mirrored: bool, cell: f64, origin: [f64; 2]) -> Self {
        let at = |x: i64, y: i64| heights[index(y, side[1], mirrored).0 * side[0] + index(x, side[0], mirrored).0];
        let points: Vec<[f32; 3]> = (0..side[0] * side[1])
            .map(|i| {
                let (x, y) = ((i % side[0]) as i64, (i / side[0]) as i64);
                let slope = |a: f32, b: f32| (b - a) / (2.0 * cell as f32);
                [at(x, y), slope(at(x - 1, y), at(x + 1, y)), slope(at(x, y - 1), at(x, y + 1))]
            })
            .collect();
        let limits = points.iter().fold([0f64; 2], |[low, high], p| [low.min(p[0].into()), high.max(p[0].into())]);
        let steepest = points.iter().map(|p| p[1].hypot(p[2])).fold(0.0, f32::max).into();
        Self { side, mirrored, cell, origin, points, limits, steepest }
    }

    /// Returns the lowest and the highest height, m.
    pub fn limits(&self) -> [f64; 2] {
        self.limits
    }

    /// Returns the largest slope, m/m.
    pub fn steepest(&self) -> f64 {
        self.steepest
    }

    /// Returns the side of a lattice cell, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Returns height and slopes at a point (m). The slopes are interpolated, for smooth light, and not those of the
    /// bilinear surface.
    pub fn at(&self, p: Vector2<f64>) -> Height {
        self.bilinear(p).0
    }

    /// Returns height and smooth slopes, and the slopes of the bilinear surface itself.
    fn bilinear(&self, p: Vector2<f64>) -> (Height, [f64; 2]) {
        let (x, y) = (p.x / self.cell + self.origin[0], p.y / self.cell + self.origin[1]);
        let (left, top) = (floor(x), floor(y));
        let (s, t) = (x - left as f64, y - top as f64);
        let ((x0, fx), (x1, _)) = (self.index(left, 0), self.index(left + 1, 0));
        let ((y0, fy), (y1, _)) = (self.index(top, 1), self.index(top + 1, 1));
        let at = |x: usize, y: usize| self.points[y * self.side[0] + x].map(f64::from);
        let (a, b, c, d) = (at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1));
        let mix = |n: usize| {
            let upper = a[n] + s * (b[n] - a[n]);
            upper + t * (c[n] + s * (d[n] - c[n]) - upper)
        };
        let along = [
            ((b[0] - a[0]) + t * ((d[0] - c[0]) - (b[0] - a[0]))) / self.cell,
            ((c[0] - a[0]) + s * ((d[0] - b[0]) - (c[0] - a[0]))) / self.cell,
        ];
        (Height { h: mix(0), slope: [fx * mix(1), fy * mix(2)] }, along)
    }

    fn index(&self, i: i64, axis: usize) -> (usize, f64) {
        index(i, self.side[axis], self.mirrored)
    }

    /// Intersects a ray by Newton's iteration, and returns the depth of the hit below its start, m. The ray starts at
    /// height `top` over `from` and moves `motion` m along the ground per metre of depth; `guess` starts the iteration.
    #[inline]
    pub fn depth(&self, from: Vector2<f64>, top: f64, motion: Vector2<f64>, guess: f64, steps: usize) -> f64 {
        let mut depth = guess;
        for _ in 0..steps {
            let (here, slope) = self.bilinear(from + motion * depth);
            let rate = (slope[0] * motion.x + slope[1] * motion.y + 1.0).max(0.1);
            depth += (top - here.h - depth) / rate;
        }
        depth
    }
}

/// Returns the integer at or below a number; for a negative integer one less, whose cell ends there.
#[inline(always)]
fn floor(x: f64) -> i64 {
    x as i64 - i64::from(x < 0.0)
}

/// Returns the lattice point for one that may be beyond the edge, and the sign of the slope there.
fn index(i: i64, side: usize, mirrored: bool) -> (usize, f64) {
    if !mirrored {
        // Sides of generated hills are a power of two, because a division would take longer than all the rest.
        return (i as usize & (side - 1), 1.0);
    }
    // The mirror is at the lattice point, or a hill would have a flat top there.
    let turn = i.rem_euclid(2 * (side as i64 - 1).max(1)) as usize;
    if turn < side { (turn, 1.0) } else { (2 * (side - 1) - turn, -1.0) }
}
