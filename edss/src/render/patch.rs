//! The ground composed once: texels of the light it sends back, in patches kept from frame to frame (a surface cache,
//! Abrash 1997).
//!
//! Level `n` serves pixels of `2^(n/2)` m with two texels a pixel, as in [`super::mip`], and between two levels the
//! result is interpolated in `log2` of the pixel. A patch is 64 x 64 texels of one level. Its content follows from
//! scene and seed alone, so a frame has the same bits whether its patches were there or not. A hovering camera sees
//! the same ground again and again: material, grain, paint, slope and shadows of what stands still cost time only
//! once.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::Vector2;

use super::KNOT;
use super::mip::split;

/// Texels along a side of a patch.
pub const CELLS: usize = 64;
/// With the first of the next patch, so that interpolation needs one patch only.
pub const SIDE: usize = CELLS + 1;
/// First and last level: pixels of 4 mm and of 64 m.
const LEVELS: [i32; 2] = [-16, 12];
/// Patches that are kept at most beyond those of the last frame: 100 MB.
const MOST: usize = 12_000;
/// What stands for 1.
const FULL: f32 = 65535.0;

/// Which patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key {
    /// Twice the `log2` of the pixel that it serves, m.
    pub level: i32,
    /// Its place in a lattice of patches, the origin of the world at the corner of patch (0, 0).
    pub at: [i32; 2],
}

impl Key {
    /// Side of a texel, m.
    pub fn texel(&self) -> f64 {
        side(self.level)
    }

    /// The centre of its first texel, m.
    pub fn first(&self) -> Vector2<f64> {
        Vector2::from(self.at.map(|at| (f64::from(at) * CELLS as f64 + 0.5) * self.texel()))
    }
}

/// Side of a texel of a level, m.
fn side(level: i32) -> f64 {
    let odd = if level & 1 == 0 { 1.0 } else { std::f64::consts::SQRT_2 };
    0.5 * odd * libm::ldexp(1.0, level >> 1)
}

/// Light of each texel; 65535 stands for 1.
pub type Texels = [[u16; SIDE]; SIDE];

/// A texel of a value of 0 to 1; what is outside is clipped.
pub fn pack(value: f32) -> u16 {
    (value * FULL + 0.5) as u16
}

/// The patches of a scene.
#[derive(Default)]
pub struct Patches {
    kept: Mutex<HashMap<Key, Kept>>,
    frames: AtomicU64,
}

struct Kept {
    texels: Arc<OnceLock<Arc<Texels>>>,
    /// The frame that asked for it last.
    last: u64,
}

impl Patches {
    /// Begins a frame; where there are too many patches, those that the last frame has not used are forgotten.
    pub fn begin(&self) {
        let last = self.frames.fetch_add(1, Ordering::Relaxed);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() > MOST {
            kept.retain(|_, patch| patch.last >= last);
        }
    }

    fn get(&self, key: Key, compose: &(dyn Fn(Key) -> Arc<Texels> + Sync)) -> Arc<Texels> {
        let last = self.frames.load(Ordering::Relaxed);
        let texels = {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            let patch = kept.entry(key).or_insert_with(|| Kept { texels: Arc::default(), last });
            patch.last = last;
            Arc::clone(&patch.texels)
        };
        Arc::clone(texels.get_or_init(|| compose(key)))
    }
}

/// Patches at hand by the last bits of their place, for the rows of one band.
pub struct AtHand<'a> {
    patches: &'a Patches,
    compose: &'a (dyn Fn(Key) -> Arc<Texels> + Sync),
    slots: Vec<Option<(Key, Arc<Texels>)>>,
}

/// Bits of a place that number a slot.
const BITS: i32 = 6;

/// The lattice of each level about an anchor.
pub struct Lattice {
    /// Texels a metre.
    density: f32,
    /// The anchor: whole texels, and the rest.
    whole: [i32; 2],
    rest: [f32; 2],
}

/// The lattices of all levels about an anchor, m: what is large is reduced in f64, so that f32 is enough for the rest.
pub fn lattices(anchor: Vector2<f64>) -> Vec<Lattice> {
    let lattice = |level: i32| {
        let at = [anchor.x, anchor.y].map(|v| v / side(level));
        let whole = at.map(f64::floor);
        Lattice {
            density: (1.0 / side(level)) as f32,
            whole: whole.map(|v| v as i32),
            rest: [(at[0] - whole[0]) as f32, (at[1] - whole[1]) as f32],
        }
    };
    (LEVELS[0]..=LEVELS[1]).map(lattice).collect()
}

impl<'a> AtHand<'a> {
    /// None yet.
    pub fn new(patches: &'a Patches, compose: &'a (dyn Fn(Key) -> Arc<Texels> + Sync)) -> Self {
        let mut slots = Vec::new();
        slots.resize_with(2 << (2 * BITS), || None);
        Self { patches, compose, slots }
    }

    #[inline(always)]
    fn patch(&mut self, key: Key) -> &Texels {
        let mask = (1 << BITS) - 1;
        let slot = ((key.level & 1) << BITS | (key.at[1] & mask)) << BITS | (key.at[0] & mask);
        let slot = slot as usize;
        if !matches!(&self.slots[slot], Some((at, _)) if *at == key) {
            self.slots[slot] = Some((key, self.fetch(key)));
        }
        match &self.slots[slot] {
            Some((_, texels)) => texels,
            None => unreachable!("the slot has just been filled"),
        }
    }

    #[cold]
    fn fetch(&self, key: Key) -> Arc<Texels> {
        self.patches.get(key, self.compose)
    }

    /// Values at points `(x, y)` m from the anchor of the lattices, seen by pixels of `2^footprint` m.
    #[inline(always)]
    pub fn sample(&mut self, lattices: &[Lattice], x: &[f32; KNOT], y: &[f32; KNOT], footprint: f32) -> [f32; KNOT] {
        let last = LEVELS[1] - LEVELS[0];
        let lod = (2.0 * footprint - LEVELS[0] as f32).clamp(0.0, last as f32);
        let level = (lod as usize).min(last as usize - 1);
        let part = lod - level as f32;
        let mut sum = [0.0; KNOT];
        self.add(lattices, level, x, y, 1.0 - part, &mut sum);
        if part > 0.0 {
            self.add(lattices, level + 1, x, y, part, &mut sum);
        }
        sum
    }

    /// Adds `weight` times the bilinear interpolation at a level.
    #[inline(always)]
    fn add(
        &mut self,
        lattices: &[Lattice],
        level: usize,
        x: &[f32; KNOT],
        y: &[f32; KNOT],
        weight: f32,
        sum: &mut [f32; KNOT],
    ) {
        let lattice = &lattices[level];
        let level = level as i32 + LEVELS[0];
        let (mut i, mut j, mut s, mut t) = ([0i32; KNOT], [0i32; KNOT], [0f32; KNOT], [0f32; KNOT]);
        let mut apart = 0;
        for l in 0..KNOT {
            (i[l], s[l]) = split(lattice.rest[0] + x[l] * lattice.density);
            (j[l], t[l]) = split(lattice.rest[1] + y[l] * lattice.density);
            i[l] = i[l].wrapping_add(lattice.whole[0]);
            j[l] = j[l].wrapping_add(lattice.whole[1]);
        }
        for l in 0..KNOT {
            apart |= (i[l] ^ i[0]) | (j[l] ^ j[0]);
        }
        let (shift, mask) = (CELLS.trailing_zeros(), CELLS as i32 - 1);
        let at = |l: usize| Key { level, at: [i[l] >> shift, j[l] >> shift] };
        let mut texels = [[0u16; KNOT]; 4];
        let mut read = |patch: &Texels, l: usize| {
            let (a, b) = ((i[l] & mask) as usize, (j[l] & mask) as usize);
            (texels[0][l], texels[1][l]) = (patch[b][a], patch[b][a + 1]);
            (texels[2][l], texels[3][l]) = (patch[b + 1][a], patch[b + 1][a + 1]);
        };
        if apart >> shift == 0 {
            let patch = self.patch(at(0));
            for l in 0..KNOT {
                read(patch, l);
            }
        } else {
            for l in 0..KNOT {
                read(self.patch(at(l)), l);
            }
        }
        let gain = weight / FULL;
        for l in 0..KNOT {
            let (a, b) = (f32::from(texels[0][l]), f32::from(texels[1][l]));
            let (c, d) = (f32::from(texels[2][l]), f32::from(texels[3][l]));
            let (left, right) = (a + t[l] * (c - a), b + t[l] * (d - b));
            sum[l] += gain * (left + s[l] * (right - left));
        }
    }
}
