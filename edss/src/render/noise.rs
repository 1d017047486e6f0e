//! Gradient noise (Perlin, 1985) over an integer lattice, periodic where a tile needs it, with the same bits everywhere.

/// A well mixed 32-bit number for a lattice point (finaliser of MurmurHash3, Appleby 2008).
#[inline(always)]
pub fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let mut h =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77).rotate_left(15) ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// A number in `0 .. 1` for a lattice point.
#[inline(always)]
pub fn unit(x: u32, y: u32, seed: u32) -> f32 {
    (hash(x, y, seed) >> 8) as f32 / 16_777_216.0
}

/// Gradient noise of rms about 0.26 at a point in lattice units; `period` is a power of two, or 0 for none.
#[inline(always)]
pub fn gradient(x: f32, y: f32, period: u32, seed: u32) -> f32 {
    let (fx, fy) = (x.floor(), y.floor());
    let (s, t) = (x - fx, y - fy);
    let (i, j) = (fx as i32 as u32, fy as i32 as u32);
    let mask = period.wrapping_sub(1);
    let corner = |dx: u32, dy: u32| {
        let h = hash(i.wrapping_add(dx) & mask, j.wrapping_add(dy) & mask, seed);
        // Two 16-bit halves as the gradient's components in -1 .. 1.
        let (gx, gy) = ((h & 0xffff) as f32 / 32768.0 - 1.0, (h >> 16) as f32 / 32768.0 - 1.0);
        gx * (s - dx as f32) + gy * (t - dy as f32)
    };
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(s), fade(t));
    let upper = corner(0, 0) + u * (corner(1, 0) - corner(0, 0));
    let lower = corner(0, 1) + u * (corner(1, 1) - corner(0, 1));
    upper + v * (lower - upper)
}

/// `sum_k gain^k noise(2^k p)`, its rms about 0.26 of the root of the sum of squared gains.
#[inline(always)]
pub fn octaves(x: f32, y: f32, period: u32, seed: u32, count: u32, gain: f32) -> f32 {
    let (mut sum, mut weight, mut scale) = (0.0, 1.0, 1.0);
    for k in 0..count {
        // Each octave is shifted, so that the zeros of their lattices do not fall together.
        let shift = 0.37 * k as f32;
        sum += weight * gradient(x * scale + shift, y * scale + shift, period << k, seed.wrapping_add(k));
        weight *= gain;
        scale *= 2.0;
    }
    sum
}
