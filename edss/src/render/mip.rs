//! A texture filtered beforehand for every distance (mip map, Williams 1983).
//!
//! A camera pixel of `p` texels is the mean of the ground over its own width and the blur of the lens: together a bell
//! of `sigma` about 0.43 pixels. Level 0 is the texture itself, for `p <= 1`. Level 1 has the same texels, smoothed to
//! `sigma` 0.87 texel, for `p = 2`. Each further level is smoothed and halved, so that level `k` serves `p = 2^k` and
//! always has two texels a pixel: bilinear interpolation of so smooth a level is nearly exact, and nothing beyond the
//! Nyquist frequency of the frame is left in it. Between two levels the result is interpolated in `log2 p`.

use nalgebra::Vector2;
use rayon::prelude::*;

/// What lies beyond the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Border {
    /// The texture again; its sides are powers of two.
    Repeated,
    /// The texture mirrored.
    Mirrored,
}

/// `N` channels of 16 bits, `0 ..= 65535` for 0 to 1.
pub struct Mip<const N: usize> {
    levels: Vec<Level<N>>,
    border: Border,
    side: [f32; 2],
}

struct Level<const N: usize> {
    width: usize,
    height: usize,
    /// Texels of this level per texel of level 0.
    scale: f32,
    texels: Vec<[u16; N]>,
}

/// Smoothing before a level is halved: variance 2.25, which with a quarter of the level's own makes 0.75 again.
const HALVE: [f32; 10] = [1.0, 9.0, 36.0, 84.0, 126.0, 126.0, 84.0, 36.0, 9.0, 1.0];

impl<const N: usize> Mip<N> {
    /// All levels of a texture of `width` x `height`.
    ///
    /// # Panics
    /// Where the number of texels is not `width * height`, or a repeated texture has sides that are no powers of two.
    pub fn new(width: usize, height: usize, texels: Vec<[u16; N]>, border: Border) -> Self {
        assert_eq!(texels.len(), width * height, "texels of {width} x {height}");
        assert!(
            border == Border::Mirrored || width.is_power_of_two() && height.is_power_of_two(),
            "{width} x {height}"
        );
        let first = Level { width, height, scale: 1.0, texels };
        let smooth = first.filtered(&[1.0, 4.0, 6.0, 4.0, 1.0], 1, border);
        let mut levels = vec![first, smooth];
        while let Some(last) = levels.last().filter(|last| last.width > 4 && last.height > 4) {
            let next = last.filtered(&HALVE, 2, border);
            levels.push(next);
        }
        Self { levels, border, side: [width as f32, height as f32] }
    }

    /// Texels along rows and columns.
    pub fn side(&self) -> Vector2<f64> {
        Vector2::new(self.side[0].into(), self.side[1].into())
    }

    /// Value in `0 ..= 65535` at a point in texels of level 0 (its first texel spans 0 to 1), seen by a pixel of
    /// `2^lod` texels.
    #[inline(always)]
    pub fn sample(&self, u: f32, v: f32, lod: f32) -> [f32; N] {
        let last = self.levels.len() - 1;
        let lod = lod.clamp(0.0, last as f32);
        let level = (lod as usize).min(last - 1);
        let part = lod - level as f32;
        let (u, v) = match self.border {
            Border::Repeated => (u, v),
            Border::Mirrored => (mirrored(u, self.side[0]), mirrored(v, self.side[1])),
        };
        let fine = self.levels[level].bilinear(u, v, self.border);
        let coarse = self.levels[level + 1].bilinear(u, v, self.border);
        let mut value = [0.0; N];
        for n in 0..N {
            value[n] = fine[n] + part * (coarse[n] - fine[n]);
        }
        value
    }
}

/// The point of the texture that a mirrored one shows at `u`.
#[inline(always)]
fn mirrored(u: f32, side: f32) -> f32 {
    let turn = u - 2.0 * side * (u / (2.0 * side)).floor();
    turn.min(2.0 * side - turn)
}

/// The index of a texel inside, or of what lies beyond the edge.
#[inline(always)]
fn index(i: i32, side: usize, border: Border) -> usize {
    match border {
        Border::Repeated => i as u32 as usize & (side - 1),
        Border::Mirrored => (i.max(0) as usize).min(side - 1),
    }
}

impl<const N: usize> Level<N> {
    // Loops instead of closures: only so is all of it compiled for the instruction set of the caller.
    #[allow(clippy::needless_range_loop)]
    #[inline(always)]
    fn bilinear(&self, u: f32, v: f32, border: Border) -> [f32; N] {
        let (x, y) = (u * self.scale - 0.5, v * self.scale - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (s, t) = (x - left, y - top);
        let (i, j) = (left as i32, top as i32);
        let (x0, x1) = (index(i, self.width, border), index(i + 1, self.width, border));
        let (y0, y1) = (index(j, self.height, border) * self.width, index(j + 1, self.height, border) * self.width);
        let corners = [self.texels[y0 + x0], self.texels[y0 + x1], self.texels[y1 + x0], self.texels[y1 + x1]];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        let mut value = [0.0; N];
        for k in 0..4 {
            for n in 0..N {
                value[n] += weights[k] * corners[k][n] as f32;
            }
        }
        value
    }

    /// Smoothed along both sides by the weights, every `step`-th texel kept.
    fn filtered(&self, weights: &[f32], step: usize, border: Border) -> Self {
        let sum: f32 = weights.iter().sum();
        let weights: Vec<f32> = weights.iter().map(|weight| weight / sum).collect();
        // An even number of weights is centred between two texels, where that of the halved level lies.
        let before = (weights.len() as i32 - 1) / 2;
        let (width, height) = (self.width.div_ceil(step), self.height.div_ceil(step));
        let tap = |i: i32, side: usize| match border {
            Border::Repeated => index(i, side, border),
            // The mirror stands at the edge of the texel.
            Border::Mirrored => {
                let turn = i.rem_euclid(2 * side as i32) as usize;
                turn.min(2 * side - 1 - turn)
            }
        };
        let taps = |i: usize, side: usize| -> Vec<usize> {
            (0..weights.len()).map(|k| tap((i * step) as i32 + k as i32 - before, side)).collect()
        };
        let columns: Vec<Vec<usize>> = (0..width).map(|x| taps(x, self.width)).collect();
        let mut along = vec![[0f32; N]; width * self.height];
        along.par_chunks_exact_mut(width).zip(self.texels.par_chunks_exact(self.width)).for_each(|(to, from)| {
            for (to, columns) in to.iter_mut().zip(&columns) {
                for (weight, &column) in weights.iter().zip(columns) {
                    for n in 0..N {
                        to[n] += weight * f32::from(from[column][n]);
                    }
                }
            }
        });
        let mut texels = vec![[0u16; N]; width * height];
        texels.par_chunks_exact_mut(width).enumerate().for_each(|(y, to)| {
            let mut sums = vec![[0.5f32; N]; width];
            for (weight, row) in weights.iter().zip(taps(y, self.height)) {
                for (sum, from) in sums.iter_mut().zip(&along[row * width..(row + 1) * width]) {
                    for n in 0..N {
                        sum[n] += weight * from[n];
                    }
                }
            }
            for (to, sum) in to.iter_mut().zip(&sums) {
                *to = sum.map(|v| v as u16);
            }
        });
        Self { width, height, scale: self.scale / step as f32, texels }
    }
}

/// A texture laid on the ground: turned, scaled, and with one of its points at the origin.
pub struct Laid<const N: usize> {
    mip: Mip<N>,
    /// Side of a texel, m.
    texel: f64,
    turn: [f64; 2],
    /// The point of the texture at the origin of the world, texels.
    origin: Vector2<f64>,
}

impl<const N: usize> Laid<N> {
    /// `texel` in m, turned by `angle` from `X_e` to `Y_e`.
    pub fn new(mip: Mip<N>, texel: f64, angle: f64, origin: Vector2<f64>) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { mip, texel, turn: [cos, sin], origin }
    }

    /// Made ready for points near `anchor`: what is large is reduced in f64, so that f32 is enough for the rest.
    pub fn near(&self, anchor: Vector2<f64>) -> Near<'_, N> {
        let [cos, sin] = self.turn.map(|v| v / self.texel);
        let at = Vector2::new(cos * anchor.x + sin * anchor.y, cos * anchor.y - sin * anchor.x) + self.origin;
        let side = self.mip.side() * if self.mip.border == Border::Repeated { 1.0 } else { 2.0 };
        let fold = |v: f64, side: f64| (v - side * (v / side).floor()) as f32;
        Near {
            mip: &self.mip,
            base: [fold(at.x, side.x), fold(at.y, side.y)],
            turn: [cos as f32, sin as f32],
            lod: -libm::log2(self.texel) as f32,
        }
    }
}

/// A laid texture as seen from an anchor.
pub struct Near<'a, const N: usize> {
    mip: &'a Mip<N>,
    base: [f32; 2],
    turn: [f32; 2],
    lod: f32,
}

impl<const N: usize> Near<'_, N> {
    /// Value in `0 ..= 65535` at `(x, y)` m from the anchor, seen by a pixel of `2^footprint` m.
    #[inline(always)]
    pub fn sample(&self, x: f32, y: f32, footprint: f32) -> [f32; N] {
        let [cos, sin] = self.turn;
        let u = self.base[0] + cos * x + sin * y;
        let v = self.base[1] + cos * y - sin * x;
        self.mip.sample(u, v, footprint + self.lod)
    }
}
