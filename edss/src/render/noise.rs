//! Gradient noise (Perlin 1985) on an integer lattice, optionally periodic, with the same bits on every machine.

/// Hashes a lattice point to 32 bits (finaliser of MurmurHash3, Appleby 2008).
#[inline(always)]
pub fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let mut h =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77).rotate_left(15) ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Returns a pseudo-random number in `0 .. 1` for a lattice point.
#[inline(always)]
pub fn unit(x: u32, y: u32, seed: u32) -> f32 {
    (hash(x, y, seed) >> 8) as f32 / 16_777_216.0
}

/// Returns the lattice cell of a coordinate and the fraction within it, `0 .. 1`.
#[inline(always)]
fn cell(x: f32) -> (u32, f32) {
    // A negative integer counts as the end of the cell before it, which is the same point.
    let whole = x as i32 - i32::from(x < 0.0);
    (whole as u32, x - whole as f32)
}

/// Returns gradient noise, rms about 0.26, at a point in lattice units; `period` is a power of two, or 0 for none.
#[inline(always)]
pub fn gradient(x: f32, y: f32, period: u32, seed: u32) -> f32 {
    let ((i, s), (j, t)) = (cell(x), cell(y));
    let mask = period.wrapping_sub(1);
    let (i1, j1) = (i.wrapping_add(1) & mask, j.wrapping_add(1) & mask);
    let (i, j) = (i & mask, j & mask);
    let a = slope(hash(i, j, seed), s, t);
    let b = slope(hash(i1, j, seed), s - 1.0, t);
    let c = slope(hash(i, j1, seed), s, t - 1.0);
    let d = slope(hash(i1, j1, seed), s - 1.0, t - 1.0);
    let (u, v) = (fade(s), fade(t));
    let upper = a + u * (b - a);
    let lower = c + u * (d - c);
    upper + v * (lower - upper)
}

/// Evaluates a plane through a lattice point; the two halves of a hash are its gradient, in -1 .. 1.
#[inline(always)]
fn slope(hash: u32, x: f32, y: f32) -> f32 {
    let (gx, gy) = ((hash as i32 >> 16) as f32, ((hash << 16) as i32 >> 16) as f32);
    (gx * x + gy * y) * (1.0 / 32768.0)
}

#[inline(always)]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Returns `sum_k gain^k noise(2^k p)`; its rms is about 0.26 times the root of the sum of squared gains.
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
