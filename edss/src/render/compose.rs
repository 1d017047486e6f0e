//! The light reflected by a patch of ground: `albedo (sky + sun)`. The albedo comes from material, grain and paint, the
//! sun from slope and shadows. For a picture or water, whose brightness is applied per frame, the albedo is 1.
//!
//! A texel is half a pixel wide. Shadow is tested at the middle of a texel, and at the edge of a shadow by eight rays
//! within the texel. The texels are then smoothed with weights 1 4 6 4 1, of variance 1, to the blur of a pixel.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::bundle::{Placed, RAYS, Shadow, Vectors, shaded};
use super::object::Object;
use super::overlay::SUBPIXEL_RAYS;
use super::patch::{Key, PATCH_TEXELS, SIDE, Texels, pack};
use super::relief::Height;
use super::row::KNOT_SPACING;
use super::shade::{SKY_LIGHT, ground_row};
use super::{Renderer, Surface};

/// Width of the rim around a patch that smoothing and the search for edges need, texels.
const RIM: usize = 3;
/// Texels along a side of a patch with its rim.
const RIMMED_SIDE: usize = SIDE + 2 * RIM;
/// Weights by which shadows are smoothed.
const SMOOTHING_KERNEL: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];
/// Texels from one sample of the relief to the next.
const SAMPLE_SPACING: usize = 8;
/// Samples of the relief along a side, with the rim.
const SAMPLES: usize = PATCH_TEXELS / SAMPLE_SPACING + 3;

impl Renderer {
    /// Computes the texels of a patch.
    pub(super) fn compose(&self, key: Key) -> Arc<Texels> {
        let (first, texel) = (key.first(), key.texel());
        let mut texels = [[0u16; SIDE]; SIDE];
        let heights = self.heights(first, texel);
        let shadows = self.shadows(first, texel, &heights);
        let grain = self.grain.local(first);
        let land = if let Surface::Land(land) = &self.surface { Some(land.local(first)) } else { None };
        let paints = self.paints(first, texel);
        let x: [[f32; KNOT_SPACING]; SIDE.div_ceil(KNOT_SPACING)] =
            std::array::from_fn(|k| std::array::from_fn(|l| ((k * KNOT_SPACING + l) as f64 * texel) as f32));
        for (j, row) in texels.iter_mut().enumerate() {
            let y = (j as f64 * texel) as f32;
            let mut albedo = [[1f32; KNOT_SPACING]; SIDE.div_ceil(KNOT_SPACING)];
            if let Some(land) = &land {
                ground_row(&x, y, 0.5 * key.level as f32, land, &grain, &mut albedo);
                for (object, centre) in &paints {
                    for (x, albedo) in x.as_flattened().iter().zip(albedo.as_flattened_mut()) {
                        let p = Vector2::new(*x, y) - centre;
                        if p.norm_squared() < (object.radius + 2.0 * texel as f32).powi(2) {
                            *albedo = object.albedo_with_paint(p, 2.0 * texel as f32, *albedo);
                        }
                    }
                }
            }
            for (i, (to, albedo)) in row.iter_mut().zip(albedo.as_flattened()).enumerate() {
                let lit = shadows.as_ref().map_or(1.0, |shadows| shadows[j][i]);
                let sun = lit * interpolated(&heights, [i + SAMPLE_SPACING, j + SAMPLE_SPACING], |height| height.sun);
                *to = pack(albedo * (SKY_LIGHT + (1.0 - SKY_LIGHT) * sun) / self.full_scale_light());
            }
        }
        Arc::new(texels)
    }

    /// Returns the paint that reaches a patch, each with its centre relative to the first texel, m.
    fn paints(&self, first: Vector2<f64>, texel: f64) -> Vec<(&Object, Vector2<f32>)> {
        let half = 0.5 * PATCH_TEXELS as f64 * texel;
        let middle = first.add_scalar(half);
        let objects = self.objects.iter().zip(&self.centres);
        let near = |(object, centre): &(&Object, &Vector3<f64>)| {
            let reach = half + f64::from(object.radius) + 2.0 * texel;
            !object.is_solid() && (centre.xy() - middle).amax() < reach
        };
        objects.filter(near).map(|(object, centre)| (object, (centre.xy() - first).map(|v| v as f32))).collect()
    }

    /// Returns height and sunlight at every 8th texel of a patch and its rim, from texel (-8, -8) on.
    fn heights(&self, first: Vector2<f64>, texel: f64) -> [[ReliefSample; SAMPLES]; SAMPLES] {
        let level = ReliefSample { h: 0.0, sun: self.sunlight([0.0; 2]) };
        let Some(relief) = &self.relief else { return [[level; SAMPLES]; SAMPLES] };
        let at = |i: usize| (i as f64 - 1.0) * SAMPLE_SPACING as f64 * texel;
        std::array::from_fn(|j| {
            std::array::from_fn(|i| {
                let Height { h, slope } = relief.at(first + Vector2::new(at(i), at(j)));
                ReliefSample { h: h as f32, sun: self.sunlight(slope) }
            })
        })
    }

    /// Returns the part of the sunlight that reaches each texel, or `None` if no static object can shade the patch.
    fn shadows(
        &self,
        first: Vector2<f64>,
        texel: f64,
        heights: &[[ReliefSample; SAMPLES]; SAMPLES],
    ) -> Option<Box<[[f32; SIDE]; SIDE]>> {
        let limits = heights
            .as_flattened()
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], knot| [low.min(knot.h), high.max(knot.h)]);
        let middle = first.add_scalar(0.5 * PATCH_TEXELS as f64 * texel).push(-0.5 * f64::from(limits[0] + limits[1]));
        let reach = (0.5 * PATCH_TEXELS as f64 + RIM as f64) * texel * std::f64::consts::SQRT_2
            + 0.5 * f64::from(limits[1] - limits[0]);
        let objects: Vec<Placed<'_>> = self
            .objects
            .iter()
            .zip(&self.centres)
            .filter(|(object, centre)| {
                let (to, near) = (*centre - middle, reach + f64::from(object.radius));
                let aside = to.cross(&self.to_sun).norm_squared();
                object.is_solid() && object.is_static() && aside < near * near && to.dot(&self.to_sun) > -near
            })
            .map(|(object, centre)| Placed { object, centre: (centre - first.push(0.0)).map(|v| v as f32) })
            .collect();
        if objects.is_empty() {
            return None;
        }
        let sun = self.to_sun.map(|v| v as f32);
        let texel = texel as f32;
        let point = |i: usize, j: usize, aside: [f32; 2]| {
            let at = |i: usize, aside: f32| (i as f32 - RIM as f32 + aside) * texel;
            // Within a texel the ground is level.
            let h = interpolated(heights, [i + SAMPLE_SPACING - RIM, j + SAMPLE_SPACING - RIM], |height| height.h);
            Vector3::new(at(i, aside[0]), at(j, aside[1]), -h)
        };
        let dark = |point_of: &dyn Fn(usize) -> Vector3<f32>| {
            let mut points = Vectors::all(&Vector3::zeros());
            (0..RAYS).for_each(|lane| points.set(lane, &point_of(lane)));
            shaded(&objects, &points, &sun, Shadow::OfGround, [true; RAYS])
        };
        let mut middles = vec![[0f32; RIMMED_SIDE]; RIMMED_SIDE];
        for (j, row) in middles.iter_mut().enumerate() {
            for (block, lit) in row.chunks_mut(RAYS).enumerate() {
                let dark = dark(&|lane| point((block * RAYS + lane).min(RIMMED_SIDE - 1), j, [0.0; 2]));
                lit.iter_mut().zip(dark).for_each(|(lit, dark)| *lit = f32::from(u8::from(!dark)));
            }
        }
        let mut refined = middles.clone();
        for j in 1..RIMMED_SIDE - 1 {
            for i in 1..RIMMED_SIDE - 1 {
                let sum = middles[j - 1][i] + middles[j + 1][i] + middles[j][i - 1] + middles[j][i + 1];
                if sum != 4.0 * middles[j][i] {
                    let dark = dark(&|lane| point(i, j, SUBPIXEL_RAYS[lane]));
                    refined[j][i] = dark.iter().filter(|dark| !**dark).count() as f32 / RAYS as f32;
                }
            }
        }
        let mut along = vec![[0f32; SIDE]; RIMMED_SIDE];
        for (to, from) in along.iter_mut().zip(&refined) {
            for (i, to) in to.iter_mut().enumerate() {
                *to = (0..5).map(|k| SMOOTHING_KERNEL[k] * from[i + k + RIM - 2]).sum();
            }
        }
        let mut smooth = Box::new([[0f32; SIDE]; SIDE]);
        for (j, row) in smooth.iter_mut().enumerate() {
            for (i, to) in row.iter_mut().enumerate() {
                *to = (0..5).map(|k| SMOOTHING_KERNEL[k] * along[j + k + RIM - 2][i]).sum();
            }
        }
        Some(smooth)
    }

    /// Returns the light of a texel at full scale: that of bright ground on a slope towards the sun.
    pub(super) fn full_scale_light(&self) -> f32 {
        1.5 * (SKY_LIGHT + (1.0 - SKY_LIGHT) / -self.to_sun.z as f32)
    }
}

/// A sample of the relief: height, m, and sunlight relative to that on level ground.
#[derive(Debug, Clone, Copy)]
struct ReliefSample {
    h: f32,
    sun: f32,
}

/// Interpolates a value bilinearly between the samples, at a texel counted from the first sample.
fn interpolated(
    heights: &[[ReliefSample; SAMPLES]; SAMPLES],
    [i, j]: [usize; 2],
    value: impl Fn(&ReliefSample) -> f32,
) -> f32 {
    let (a, b) = (i / SAMPLE_SPACING, j / SAMPLE_SPACING);
    let (s, t) =
        ((i % SAMPLE_SPACING) as f32 / SAMPLE_SPACING as f32, (j % SAMPLE_SPACING) as f32 / SAMPLE_SPACING as f32);
    let upper = value(&heights[b][a]) + s * (value(&heights[b][a + 1]) - value(&heights[b][a]));
    let lower = value(&heights[b + 1][a]) + s * (value(&heights[b + 1][a + 1]) - value(&heights[b + 1][a]));
    upper + t * (lower - upper)
}
