//! Ground that is computed, as pictures in files; and what a refusal looks like.

mod picture;
mod refusal;

pub use picture::save;
pub use refusal::assert_refused;

/// Ground without an end, the same wherever it is looked at: noise of 3 px, smooth between its nodes.
pub fn ground(x: f64, y: f64) -> u16 {
    let node = |x: i64, y: i64| {
        let mut bits = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        bits = (bits ^ (bits >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((bits >> 40) & 0xffff) as f64
    };
    let (u, v) = (x / 3.0, y / 3.0);
    let (i, j) = (u.floor(), v.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(u - i), ease(v - j));
    let (i, j) = (i as i64, j as i64);
    let upper = (1.0 - s) * node(i, j) + s * node(i + 1, j);
    let lower = (1.0 - s) * node(i, j + 1) + s * node(i + 1, j + 1);
    ((1.0 - t) * upper + t * lower) as u16
}
