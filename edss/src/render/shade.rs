//! Light: sun, sky and mist, and the loops that shade a row of ground.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use multiversion::multiversion;
use nalgebra::Vector3;

use super::Renderer;
use super::grain::{GREEN, HARD, LocalGrain, SOIL};
use super::land::{self, Material};
use super::mip::{LocalTexture, MIRRORED};
use super::patch::{BandPatches, Lattice};
use super::row::{KNOT_SPACING, Knot, Row};
use super::water::{LocalWaves, SunReflection};

/// Light scattered by mist, relative to white ground in full sun, as in `hoverlock_pictures::conditions`.
pub(super) const AIR_LIGHT: f32 = 0.55;
/// Light from the sky, relative to full sun: the light in a shadow.
pub(super) const SKY_LIGHT: f32 = 0.3;

impl Renderer {
    /// Returns the slope of water that reflects the sun into the camera, at each knot.
    pub(super) fn sun_reflections(&self, row: &Row) -> Vec<SunReflection> {
        let mirror = |k: usize| {
            let to_camera = -row.direction(k * KNOT_SPACING).map(f64::from).normalize();
            let half = to_camera + self.to_sun;
            // A slope s has its normal along (-s, 1) with height upwards.
            SunReflection { slope: [(half.x / half.z) as f32, (half.y / half.z) as f32] }
        };
        (0..row.knots.len()).map(mirror).collect()
    }

    /// Returns the direct sunlight on a slope relative to that on level ground.
    pub(super) fn sunlight(&self, slope: [f64; 2]) -> f32 {
        // The normal is (-dh/dX, -dh/dY, 1) with height upwards, and Z is downwards.
        let normal = Vector3::new(-slope[0], -slope[1], -1.0).normalize();
        (normal.dot(&self.to_sun).max(0.0) / -self.to_sun.z) as f32
    }

    /// Returns the radiance `T L + (1 - T) air`, at the brightness of the scene.
    #[inline(always)]
    pub(super) fn radiance(&self, reflected: f32, transmission: f32) -> f32 {
        self.brightness * (AIR_LIGHT + transmission * (reflected - AIR_LIGHT))
    }
}

/// Applies the mist to the light of the ground along a row.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn apply_mist(ground: &[f32], knots: &[Knot], brightness: f32, out: &mut [f32]) {
    for ((out, ground), pair) in out.chunks_mut(KNOT_SPACING).zip(ground.chunks(KNOT_SPACING)).zip(knots.windows(2)) {
        let (first, slope) =
            (pair[0].transmission, (pair[1].transmission - pair[0].transmission) / KNOT_SPACING as f32);
        for (l, (out, ground)) in out.iter_mut().zip(ground).enumerate() {
            *out = brightness * (AIR_LIGHT + (first + l as f32 * slope) * (ground - AIR_LIGHT));
        }
    }
}

/// Computes the albedo of ground that is a picture, with grain of the given weight.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn shade_picture(
    row: &Row,
    out: &mut [f32],
    picture: &LocalTexture<'_, u16, 1, MIRRORED>,
    weight: f32,
    grain: &LocalGrain<'_>,
) {
    for (k, out) in out.chunks_mut(KNOT_SPACING).enumerate() {
        let (x, y, footprint) = (&row.x[k], &row.y[k], row.knots[k].footprint);
        let mut albedo = picture.sample(x, y, footprint);
        if weight > 0.0 {
            let fine = grain.sample(x, y, footprint);
            for l in 0..KNOT_SPACING {
                albedo[l][0] *= (1.0 + weight * 0.7 * (fine[l][GREEN] + fine[l][HARD])).max(0.0);
            }
        }
        for (out, [albedo]) in out.iter_mut().zip(albedo) {
            *out = albedo;
        }
    }
}

/// Samples the light of composed ground along a row.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn sample_patches(
    row: &Row,
    out: &mut [f32],
    patches: &mut BandPatches<'_>,
    lattices: &[Lattice],
    gain: f32,
) {
    for (k, out) in out.chunks_mut(KNOT_SPACING).enumerate() {
        let light = patches.sample(lattices, &row.x[k], &row.y[k], row.knots[k].footprint);
        for l in 0..out.len() {
            out[l] = gain * light[l];
        }
    }
}

/// Computes the albedo of procedural ground along a line of constant `y`, for pixels of `2^footprint` m.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn ground_row(
    x: &[[f32; KNOT_SPACING]],
    y: f32,
    footprint: f32,
    land: &LocalTexture<'_, u32, 4, MIRRORED>,
    grain: &LocalGrain<'_>,
    out: &mut [[f32; KNOT_SPACING]],
) {
    for (x, out) in x.iter().zip(out) {
        let material = land.sample(x, &[y; KNOT_SPACING], footprint);
        let fine = grain.sample(x, &[y; KNOT_SPACING], footprint);
        for (out, (material, fine)) in out.iter_mut().zip(material.into_iter().zip(fine)) {
            *out = ground_albedo(&land::material(material), fine);
        }
    }
}

/// Computes the radiance of water along a row.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn shade_water(row: &Row, out: &mut [f32], waves: &LocalWaves<'_>, mirrors: &[SunReflection]) {
    for (k, out) in out.chunks_mut(KNOT_SPACING).enumerate() {
        let radiance = waves.radiance(&row.x[k], &row.y[k], row.knots[k].footprint, [mirrors[k], mirrors[k + 1]]);
        for (out, radiance) in out.iter_mut().zip(radiance) {
            *out = radiance;
        }
    }
}

#[inline(always)]
fn ground_albedo(material: &Material, fine: [f32; 4]) -> f32 {
    let [green, soil, hard] = material.grain;
    material.albedo * (1.0 + green * fine[GREEN] + soil * fine[SOIL] + hard * fine[HARD]).max(0.05)
}
