//! Textures filtered in advance for every distance (mip maps, Williams 1983).
//!
//! A camera pixel of `p` texels averages the ground over its own width and the blur of the lens: together a bell of
//! `sigma` about 0.43 pixels. Level 0 is the texture itself, for `p <= 1`. Level 1 has the same texels, smoothed to
//! `sigma` 0.87 texel, for `p = 2`. Each further level is smoothed and halved, so that level `k` serves `p = 2^k` and
//! always has two texels a pixel. Such a level is smooth enough for bilinear interpolation, and has nothing above the
//! Nyquist frequency of the frame. Between two levels the result is interpolated in `log2 p`.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use std::sync::Arc;

use nalgebra::Vector2;
use rayon::prelude::*;

/// Value of `MIRROR` for a texture that is mirrored at its edges.
pub const MIRRORED: bool = true;
/// Value of `MIRROR` for a texture that repeats; its sides must be powers of two.
pub const REPEATED: bool = false;

/// A texel format that stores `N` channels.
pub trait Texel<const N: usize>: Copy + Default + Send + Sync {
    /// Stored value of 1.
    const FULL_SCALE: f32;
    /// Returns the channels as stored, `0 ..= FULL_SCALE`.
    fn unpack(self) -> [f32; N];
    /// Stores channels of `0 ..= FULL_SCALE`, rounded; values outside are clipped.
    fn pack(channels: [f32; N]) -> Self;
}

/// One channel of 16 bits: a picture.
impl Texel<1> for u16 {
    const FULL_SCALE: f32 = 65535.0;

    #[inline(always)]
    fn unpack(self) -> [f32; 1] {
        [f32::from(self)]
    }

    fn pack([value]: [f32; 1]) -> Self {
        (value + 0.5) as u16
    }
}

/// Four channels of 8 bits. Written so that it becomes one shift, one mask and one conversion of four lanes.
impl Texel<4> for u32 {
    const FULL_SCALE: f32 = 255.0;

    #[inline(always)]
    fn unpack(self) -> [f32; 4] {
        let bytes = [self & 255, (self >> 8) & 255, (self >> 16) & 255, (self >> 24) & 255];
        [bytes[0] as i32 as f32, bytes[1] as i32 as f32, bytes[2] as i32 as f32, bytes[3] as i32 as f32]
    }

    fn pack(channels: [f32; 4]) -> Self {
        u32::from_le_bytes(channels.map(|value| (value + 0.5) as u8))
    }
}

/// A texture of `N` channels with all its levels.
pub struct Mip<T, const N: usize, const MIRROR: bool> {
    levels: Vec<Level<T, N, MIRROR>>,
    side: [f32; 2],
}

/// One level, stored in blocks of 4 x 4 texels: a block of four bytes a texel is one cache line, whatever the direction
/// of a row of the frame across it.
struct Level<T, const N: usize, const MIRROR: bool> {
    width: usize,
    height: usize,
    /// Texels of this level per texel of level 0.
    scale: f32,
    /// Number of texels in a row of blocks.
    stride: usize,
    texels: Vec<T>,
}

/// Weights by which a level is smoothed before it is halved: variance 2.25, which together with the level's own 0.75,
/// divided by 4, is 0.75 again.
const HALVING_WEIGHTS: [f32; 10] = [1.0, 9.0, 36.0, 84.0, 126.0, 126.0, 84.0, 36.0, 9.0, 1.0];

impl<T: Texel<N>, const N: usize, const MIRROR: bool> Mip<T, N, MIRROR> {
    /// Computes all levels of a texture of `width` x `height` texels, given row by row.
    ///
    /// # Panics
    /// If the sides of a repeated texture are not powers of two.
    pub fn new(width: usize, height: usize, texels: &[T]) -> Self {
        assert!(MIRROR || width.is_power_of_two() && height.is_power_of_two(), "{width} x {height}");
        let first = Level::new(width, height, 1.0, texels);
        let smooth = first.filtered(&[1.0, 4.0, 6.0, 4.0, 1.0], 1);
        let mut levels = vec![first, smooth];
        while let Some(last) = levels.last().filter(|last| last.width > 4 && last.height > 4) {
            let next = last.filtered(&HALVING_WEIGHTS, 2);
            levels.push(next);
        }
        Self { levels, side: [width as f32, height as f32] }
    }

    /// Returns width and height of level 0, texels.
    pub fn side(&self) -> Vector2<f64> {
        Vector2::new(self.side[0].into(), self.side[1].into())
    }

    /// Samples values in `0 ..= 1` at `L` points, in texels of level 0 (the first texel spans 0 to 1), for pixels of
    /// `2^lod` texels.
    #[inline(always)]
    pub fn sample<const L: usize>(&self, u: &[f32; L], v: &[f32; L], lod: f32) -> [[f32; N]; L] {
        let last = self.levels.len() - 1;
        let lod = lod.clamp(0.0, last as f32);
        let level = (lod as usize).min(last - 1);
        let part = lod - level as f32;
        let (mut u, mut v) = (*u, *v);
        if MIRROR {
            for l in 0..L {
                u[l] = mirrored(u[l], self.side[0]);
                v[l] = mirrored(v[l], self.side[1]);
            }
        }
        let mut value = [[0.0; N]; L];
        self.levels[level].add(&u, &v, 1.0 - part, &mut value);
        if part > 0.0 {
            self.levels[level + 1].add(&u, &v, part, &mut value);
        }
        value
    }
}

/// Folds a coordinate into a mirrored texture.
#[inline(always)]
fn mirrored(u: f32, side: f32) -> f32 {
    let turn = u - 2.0 * side * (u / (2.0 * side)).floor();
    turn.min(2.0 * side - turn)
}

/// Returns the index of the texel for one that may be beyond the edge.
#[inline(always)]
fn index<const MIRROR: bool>(i: i32, side: i32) -> i32 {
    if MIRROR { i.max(0).min(side - 1) } else { i & (side - 1) }
}

/// Returns the texel whose centre is before `u`, and the fraction of the way to the next, `0 ..= 1`.
///
/// A number between `-2^22` and `2^22` added to `1.5 * 2^23` leaves its nearest integer in the mantissa: no rounding
/// instruction, no saturation. If `u` is a centre the fraction may be 1 instead of 0, which is the same point.
#[inline(always)]
pub fn split(u: f32) -> (i32, f32) {
    const SHIFT: f32 = 12_582_912.0;
    let shifted = (u - 1.0) + SHIFT;
    let left = shifted - SHIFT;
    ((shifted.to_bits() as i32).wrapping_sub(SHIFT.to_bits() as i32), (u - 0.5) - left)
}

impl<T: Texel<N>, const N: usize, const MIRROR: bool> Level<T, N, MIRROR> {
    fn new(width: usize, height: usize, scale: f32, rows: &[T]) -> Self {
        let stride = width.div_ceil(4) * 16;
        let mut texels = vec![T::default(); stride * height.div_ceil(4)];
        for (y, row) in rows.chunks_exact(width).enumerate() {
            let start = down(y as i32, stride as i32) as usize;
            for (x, &texel) in row.iter().enumerate() {
                texels[start + across(x as i32) as usize] = texel;
            }
        }
        Self { width, height, scale, stride, texels }
    }

    /// Adds `weight` times the bilinear interpolation at `L` points to `sum`.
    ///
    /// All addresses are computed first, in all lanes at once; then the texels are read.
    #[inline(always)]
    fn add<const L: usize>(&self, u: &[f32; L], v: &[f32; L], weight: f32, sum: &mut [[f32; N]; L]) {
        let (width, height, stride) = (self.width as i32, self.height as i32, self.stride as i32);
        let (mut places, mut ways) = ([[0i32; L]; 4], [[0f32; L]; 2]);
        for l in 0..L {
            let (i, s) = split(u[l] * self.scale);
            let (j, t) = split(v[l] * self.scale);
            places[0][l] = across(index::<MIRROR>(i, width));
            places[1][l] = across(index::<MIRROR>(i + 1, width));
            places[2][l] = down(index::<MIRROR>(j, height), stride);
            places[3][l] = down(index::<MIRROR>(j + 1, height), stride);
            (ways[0][l], ways[1][l]) = (s, t);
        }
        let gain = weight / T::FULL_SCALE;
        for l in 0..L {
            let at = |x: usize, y: usize| self.texels[(places[y][l] + places[x][l]) as usize].unpack();
            let (a, b, c, d) = (at(0, 2), at(1, 2), at(0, 3), at(1, 3));
            let (s, t) = (ways[0][l], ways[1][l]);
            let (upper, lower) = (gain * (1.0 - t), gain * t);
            for n in 0..N {
                let left = upper * a[n] + lower * c[n];
                let right = upper * b[n] + lower * d[n];
                sum[l][n] += left + s * (right - left);
            }
        }
    }

    /// Returns the level smoothed along both sides by the weights, with every `step`-th texel kept.
    fn filtered(&self, weights: &[f32], step: usize) -> Self {
        let sum: f32 = weights.iter().sum();
        let weights: Vec<f32> = weights.iter().map(|weight| weight / sum).collect();
        // An even number of weights is centred between two texels, as the texels of the halved level are.
        let before = (weights.len() as i32 - 1) / 2;
        let (width, height) = (self.width.div_ceil(step), self.height.div_ceil(step));
        // The mirror is at the edge of the texel.
        let tap = |i: i32, side: usize| {
            let turn = i.rem_euclid(if MIRROR { 2 } else { 1 } * side as i32) as usize;
            turn.min(2 * side - 1 - turn)
        };
        let taps = |i: usize, side: usize| -> Vec<usize> {
            (0..weights.len()).map(|k| tap((i * step) as i32 + k as i32 - before, side)).collect()
        };
        let columns: Vec<Vec<usize>> = (0..width).map(|x| taps(x, self.width)).collect();
        let mut along = vec![[0f32; N]; width * self.height];
        along.par_chunks_exact_mut(width).enumerate().for_each_init(
            || vec![[0f32; N]; self.width],
            |row, (y, to)| {
                let start = down(y as i32, self.stride as i32) as usize;
                for (x, value) in row.iter_mut().enumerate() {
                    *value = self.texels[start + across(x as i32) as usize].unpack();
                }
                for (to, columns) in to.iter_mut().zip(&columns) {
                    for (weight, &column) in weights.iter().zip(columns) {
                        let from = &row[column];
                        for n in 0..N {
                            to[n] += weight * from[n];
                        }
                    }
                }
            },
        );
        let mut texels = vec![T::default(); width * height];
        texels.par_chunks_exact_mut(width).enumerate().for_each_init(
            || vec![[0f32; N]; width],
            |sums, (y, to)| {
                sums.fill([0.0; N]);
                for (weight, row) in weights.iter().zip(taps(y, self.height)) {
                    for (sum, from) in sums.iter_mut().zip(&along[row * width..(row + 1) * width]) {
                        for n in 0..N {
                            sum[n] += weight * from[n];
                        }
                    }
                }
                for (to, sum) in to.iter_mut().zip(sums.iter()) {
                    *to = T::pack(*sum);
                }
            },
        );
        Self::new(width, height, self.scale / step as f32, &texels)
    }
}

/// Returns the offset of a column within a row of texels.
#[inline(always)]
fn across(x: i32) -> i32 {
    ((x >> 2) << 4) | (x & 3)
}

/// Returns the offset of the first texel of a row.
#[inline(always)]
fn down(y: i32, stride: i32) -> i32 {
    (y >> 2) * stride + ((y & 3) << 2)
}

/// A texture placed on the ground: rotated, scaled, and with one of its points at the origin of the world.
pub struct PlacedTexture<T, const N: usize, const MIRROR: bool> {
    mip: Arc<Mip<T, N, MIRROR>>,
    /// Side of a texel, m.
    texel: f64,
    turn: [f64; 2],
    /// Point of the texture at the origin of the world, texels.
    origin: Vector2<f64>,
}

impl<T: Texel<N>, const N: usize, const MIRROR: bool> PlacedTexture<T, N, MIRROR> {
    /// Places a texture with texels of `texel` m, rotated by `angle` (rad) from `X_e` to `Y_e`, so that its point
    /// `origin` (texels) is at the origin of the world.
    pub fn new(mip: impl Into<Arc<Mip<T, N, MIRROR>>>, texel: f64, angle: f64, origin: Vector2<f64>) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { mip: mip.into(), texel, turn: [cos, sin], origin }
    }

    /// Returns the texture for sampling around `anchor` (m). Large numbers are reduced in f64 here, so that f32 is
    /// precise enough for the samples.
    pub fn local(&self, anchor: Vector2<f64>) -> LocalTexture<'_, T, N, MIRROR> {
        let [cos, sin] = self.turn.map(|v| v / self.texel);
        let at = Vector2::new(cos * anchor.x + sin * anchor.y, cos * anchor.y - sin * anchor.x) + self.origin;
        let side = self.mip.side() * if MIRROR { 2.0 } else { 1.0 };
        let fold = |v: f64, side: f64| (v - side * (v / side).floor()) as f32;
        LocalTexture {
            mip: &self.mip,
            base: [fold(at.x, side.x), fold(at.y, side.y)],
            turn: [cos as f32, sin as f32],
            lod: -libm::log2(self.texel) as f32,
        }
    }
}

/// A placed texture for sampling around an anchor.
pub struct LocalTexture<'a, T, const N: usize, const MIRROR: bool> {
    mip: &'a Mip<T, N, MIRROR>,
    base: [f32; 2],
    turn: [f32; 2],
    lod: f32,
}

impl<T: Texel<N>, const N: usize, const MIRROR: bool> LocalTexture<'_, T, N, MIRROR> {
    /// Samples values in `0 ..= 1` at points `(x, y)` m from the anchor, for pixels of `2^footprint` m.
    #[inline(always)]
    pub fn sample<const L: usize>(&self, x: &[f32; L], y: &[f32; L], footprint: f32) -> [[f32; N]; L] {
        let [cos, sin] = self.turn;
        let (mut u, mut v) = ([0.0; L], [0.0; L]);
        for l in 0..L {
            u[l] = self.base[0] + cos * x[l] + sin * y[l];
            v[l] = self.base[1] + cos * y[l] - sin * x[l];
        }
        self.mip.sample(&u, &v, footprint + self.lod)
    }
}
