//! The store of composed ground: texels of reflected light, in patches kept between frames (a surface cache, Abrash
//! 1997).
//!
//! Level `n` serves pixels of `2^(n/2)` m with two texels a pixel, as in [`super::mip`], and between two levels the
//! result is interpolated in `log2` of the pixel. A patch is 64 x 64 texels of one level. Its content follows from
//! scene and seed alone, so a frame has the same bits with a cold or a warm store. A hovering camera sees the same
//! ground in every frame: material, grain, paint, slope and static shadows are computed only once.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::Vector2;

use super::mip::split;
use super::row::KNOT_SPACING;

/// Texels along a side of a patch.
pub const PATCH_TEXELS: usize = 64;
/// Texels along a side with the first of the next patch, so that interpolation needs only one patch.
pub const SIDE: usize = PATCH_TEXELS + 1;
/// First and last level, for pixels of 4 mm and of 64 m.
const LEVEL_RANGE: [i32; 2] = [-16, 12];
/// Number of patches above which those not used by the last frame are dropped: 100 MB.
const MAX_STORED_PATCHES: usize = 12_000;
/// Value of a texel of light 1.
const FULL_SCALE: f32 = 65535.0;

/// The identity of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key {
    /// Twice the `log2` of the pixel width that it serves, m.
    pub level: i32,
    /// Column and row in the lattice of patches; the origin of the world is the corner of patch (0, 0).
    pub at: [i32; 2],
}

impl Key {
    /// Returns the side of a texel, m.
    pub fn texel(&self) -> f64 {
        side(self.level)
    }

    /// Returns the centre of the first texel, m.
    pub fn first(&self) -> Vector2<f64> {
        Vector2::from(self.at.map(|at| (f64::from(at) * PATCH_TEXELS as f64 + 0.5) * self.texel()))
    }
}

/// Returns the side of a texel of a level, m.
fn side(level: i32) -> f64 {
    let odd = if level & 1 == 0 { 1.0 } else { std::f64::consts::SQRT_2 };
    0.5 * odd * libm::ldexp(1.0, level >> 1)
}

/// The light of each texel, 65535 for light 1.
pub type Texels = [[u16; SIDE]; SIDE];

/// Encodes a light of 0 to 1 as a texel; values outside are clipped.
pub fn pack(value: f32) -> u16 {
    (value * FULL_SCALE + 0.5) as u16
}

/// The patches of a scene, composed on demand and shared by all threads.
#[derive(Default)]
pub struct PatchStore {
    kept: Mutex<HashMap<Key, StoredPatch>>,
    frames: AtomicU64,
}

struct StoredPatch {
    texels: Arc<OnceLock<Arc<Texels>>>,
    /// Number of the frame that used it last.
    last: u64,
}

impl PatchStore {
    /// Begins a frame. If there are too many patches, drops those that the last frame has not used.
    pub fn begin(&self) {
        let last = self.frames.fetch_add(1, Ordering::Relaxed);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() > MAX_STORED_PATCHES {
            kept.retain(|_, patch| patch.last >= last);
        }
    }

    fn get(&self, key: Key, compose: &(dyn Fn(Key) -> Arc<Texels> + Sync)) -> Arc<Texels> {
        let last = self.frames.load(Ordering::Relaxed);
        let texels = {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            let patch = kept.entry(key).or_insert_with(|| StoredPatch { texels: Arc::default(), last });
            patch.last = last;
            Arc::clone(&patch.texels)
        };
        Arc::clone(texels.get_or_init(|| compose(key)))
    }
}

/// The patches that a band uses, in slots by the low bits of their position: a direct-mapped cache in front of
/// [`PatchStore`].
pub struct BandPatches<'a> {
    patches: &'a PatchStore,
    compose: &'a (dyn Fn(Key) -> Arc<Texels> + Sync),
    slots: Vec<Option<(Key, Arc<Texels>)>>,
}

/// Low bits of column and row that select a slot.
const SLOT_BITS: i32 = 6;

/// The texels of one level relative to an anchor.
pub struct Lattice {
    /// Texels per metre.
    density: f32,
    /// Position of the anchor in texels: integer part and remainder.
    whole: [i32; 2],
    rest: [f32; 2],
}

/// Returns the lattices of all levels relative to an anchor, m. Large numbers are reduced in f64 here, so that f32 is
/// precise enough for the samples.
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
    (LEVEL_RANGE[0]..=LEVEL_RANGE[1]).map(lattice).collect()
}

impl<'a> BandPatches<'a> {
    /// Creates an empty cache.
    pub fn new(patches: &'a PatchStore, compose: &'a (dyn Fn(Key) -> Arc<Texels> + Sync)) -> Self {
        let mut slots = Vec::new();
        slots.resize_with(2 << (2 * SLOT_BITS), || None);
        Self { patches, compose, slots }
    }

    #[inline(always)]
    fn patch(&mut self, key: Key) -> &Texels {
        let mask = (1 << SLOT_BITS) - 1;
        let slot = ((key.level & 1) << SLOT_BITS | (key.at[1] & mask)) << SLOT_BITS | (key.at[0] & mask);
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

    /// Samples the light at points `(x, y)` m from the anchor of the lattices, for pixels of `2^footprint` m.
    #[inline(always)]
    pub fn sample(
        &mut self,
        lattices: &[Lattice],
        x: &[f32; KNOT_SPACING],
        y: &[f32; KNOT_SPACING],
        footprint: f32,
    ) -> [f32; KNOT_SPACING] {
        let last = LEVEL_RANGE[1] - LEVEL_RANGE[0];
        let lod = (2.0 * footprint - LEVEL_RANGE[0] as f32).clamp(0.0, last as f32);
        let level = (lod as usize).min(last as usize - 1);
        let part = lod - level as f32;
        let mut sum = [0.0; KNOT_SPACING];
        self.add(lattices, level, x, y, 1.0 - part, &mut sum);
        if part > 0.0 {
            self.add(lattices, level + 1, x, y, part, &mut sum);
        }
        sum
    }

    /// Adds `weight` times the bilinear interpolation at a level to `sum`.
    #[inline(always)]
    fn add(
        &mut self,
        lattices: &[Lattice],
        level: usize,
        x: &[f32; KNOT_SPACING],
        y: &[f32; KNOT_SPACING],
        weight: f32,
        sum: &mut [f32; KNOT_SPACING],
    ) {
        let lattice = &lattices[level];
        let level = level as i32 + LEVEL_RANGE[0];
        let (mut i, mut j, mut s, mut t) =
            ([0i32; KNOT_SPACING], [0i32; KNOT_SPACING], [0f32; KNOT_SPACING], [0f32; KNOT_SPACING]);
        let mut apart = 0;
        for l in 0..KNOT_SPACING {
            (i[l], s[l]) = split(lattice.rest[0] + x[l] * lattice.density);
            (j[l], t[l]) = split(lattice.rest[1] + y[l] * lattice.density);
            i[l] = i[l].wrapping_add(lattice.whole[0]);
            j[l] = j[l].wrapping_add(lattice.whole[1]);
        }
        for l in 0..KNOT_SPACING {
            apart |= (i[l] ^ i[0]) | (j[l] ^ j[0]);
        }
        let (shift, mask) = (PATCH_TEXELS.trailing_zeros(), PATCH_TEXELS as i32 - 1);
        let at = |l: usize| Key { level, at: [i[l] >> shift, j[l] >> shift] };
        let mut texels = [[0u16; KNOT_SPACING]; 4];
        let mut read = |patch: &Texels, l: usize| {
            let (a, b) = ((i[l] & mask) as usize, (j[l] & mask) as usize);
            (texels[0][l], texels[1][l]) = (patch[b][a], patch[b][a + 1]);
            (texels[2][l], texels[3][l]) = (patch[b + 1][a], patch[b + 1][a + 1]);
        };
        if apart >> shift == 0 {
            let patch = self.patch(at(0));
            for l in 0..KNOT_SPACING {
                read(patch, l);
            }
        } else {
            for l in 0..KNOT_SPACING {
                read(self.patch(at(l)), l);
            }
        }
        let gain = weight / FULL_SCALE;
        for l in 0..KNOT_SPACING {
            let (a, b) = (f32::from(texels[0][l]), f32::from(texels[1][l]));
            let (c, d) = (f32::from(texels[2][l]), f32::from(texels[3][l]));
            let (left, right) = (a + t[l] * (c - a), b + t[l] * (d - b));
            sum[l] += gain * (left + s[l] * (right - left));
        }
    }
}
