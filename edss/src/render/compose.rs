//! The light that a patch of ground sends back: `albedo (sky + sun)`, with material, grain and paint for its albedo,
//! slope and shadows for the sun. Over a picture or water, whose own brightness comes later, albedo stands for 1.
//!
//! A texel is half a pixel wide. A shadow is there or not at the middle of a texel; at its edge, the mean of eight rays
//! within the texel. Then the texels are smoothed with weights 1 4 6 4 1, of variance 1, to the half pixel that the
//! blur of a pixel is.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::overlay::RAYS;
use super::patch::{CELLS, Key, SIDE, Texels, pack};
use super::relief::Height;
use super::thing::Thing;
use super::{KNOT, Renderer, SKY, Surface, ground_row};

/// Texels that smoothing and the search for edges need around a patch.
const RIM: usize = 3;
/// Texels of a patch and its rim.
const WIDE: usize = SIDE + 2 * RIM;
/// Smoothing of shadows.
const SMOOTH: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];
/// Texels from one height to the next.
const STEP: usize = 8;
/// Heights along a side: over the rim too.
const HEIGHTS: usize = CELLS / STEP + 3;

impl Renderer {
    /// Composes a patch.
    pub(super) fn compose(&self, key: Key) -> Arc<Texels> {
        let (first, texel) = (key.first(), key.texel());
        let mut texels = [[0u16; SIDE]; SIDE];
        let heights = self.heights(first, texel);
        let shadows = self.shadows(first, texel, &heights);
        let grain = self.grain.near(first);
        let land = if let Surface::Land(land) = &self.surface { Some(land.near(first)) } else { None };
        let paints = self.paints(first, texel);
        let x: [[f32; KNOT]; SIDE.div_ceil(KNOT)] =
            std::array::from_fn(|k| std::array::from_fn(|l| ((k * KNOT + l) as f64 * texel) as f32));
        for (j, row) in texels.iter_mut().enumerate() {
            let y = (j as f64 * texel) as f32;
            let mut albedo = [[1f32; KNOT]; SIDE.div_ceil(KNOT)];
            if let Some(land) = &land {
                ground_row(&x, y, 0.5 * key.level as f32, land, &grain, &mut albedo);
                for (thing, centre) in &paints {
                    for (x, albedo) in x.as_flattened().iter().zip(albedo.as_flattened_mut()) {
                        let p = Vector2::new(*x, y) - centre;
                        if p.norm_squared() < (thing.radius + 2.0 * texel as f32).powi(2) {
                            *albedo = thing.painted(p, 2.0 * texel as f32, *albedo);
                        }
                    }
                }
            }
            for (i, (to, albedo)) in row.iter_mut().zip(albedo.as_flattened()).enumerate() {
                let lit = shadows.as_ref().map_or(1.0, |shadows| shadows[j][i]);
                let sun = lit * interpolated(&heights, [i + STEP, j + STEP], |height| height.sun);
                *to = pack(albedo * (SKY + (1.0 - SKY) * sun) / self.brightest());
            }
        }
        Arc::new(texels)
    }

    /// Paint that reaches a patch, and where it is from its first texel.
    fn paints(&self, first: Vector2<f64>, texel: f64) -> Vec<(&Thing, Vector2<f32>)> {
        let half = 0.5 * CELLS as f64 * texel;
        let middle = first.add_scalar(half);
        let things = self.things.iter().zip(&self.centres);
        let near = |(thing, centre): &(&Thing, &Vector3<f64>)| {
            let reach = half + f64::from(thing.radius) + 2.0 * texel;
            !thing.is_solid() && (centre.xy() - middle).amax() < reach
        };
        things.filter(near).map(|(thing, centre)| (thing, (centre.xy() - first).map(|v| v as f32))).collect()
    }

    /// Height and slope at every 8th texel of a patch and its rim, the first at the texel (-8, -8).
    fn heights(&self, first: Vector2<f64>, texel: f64) -> [[Knot; HEIGHTS]; HEIGHTS] {
        let level = Knot { h: 0.0, sun: self.sunlight([0.0; 2]) };
        let Some(relief) = &self.relief else { return [[level; HEIGHTS]; HEIGHTS] };
        let at = |i: usize| (i as f64 - 1.0) * STEP as f64 * texel;
        std::array::from_fn(|j| {
            std::array::from_fn(|i| {
                let Height { h, slope } = relief.at(first + Vector2::new(at(i), at(j)));
                Knot { h: h as f32, sun: self.sunlight(slope) }
            })
        })
    }

    /// The part of the sunlight that reaches each texel; `None` where nothing throws a shadow.
    fn shadows(
        &self,
        first: Vector2<f64>,
        texel: f64,
        heights: &[[Knot; HEIGHTS]; HEIGHTS],
    ) -> Option<Box<[[f32; SIDE]; SIDE]>> {
        let limits = heights
            .as_flattened()
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], knot| [low.min(knot.h), high.max(knot.h)]);
        let middle = first.add_scalar(0.5 * CELLS as f64 * texel).push(-0.5 * f64::from(limits[0] + limits[1]));
        let reach = (0.5 * CELLS as f64 + RIM as f64) * texel * std::f64::consts::SQRT_2
            + 0.5 * f64::from(limits[1] - limits[0]);
        let things: Vec<(&Thing, Vector3<f32>)> = self
            .things
            .iter()
            .zip(&self.centres)
            .filter(|(thing, centre)| {
                let (to, near) = (*centre - middle, reach + f64::from(thing.radius));
                let aside = to.cross(&self.to_sun).norm_squared();
                thing.is_solid() && thing.is_still() && aside < near * near && to.dot(&self.to_sun) > -near
            })
            .map(|(thing, centre)| (thing, (centre - first.push(0.0)).map(|v| v as f32)))
            .collect();
        if things.is_empty() {
            return None;
        }
        let sun = self.to_sun.map(|v| v as f32);
        let texel = texel as f32;
        let lit = |i: usize, j: usize, aside: [f32; 2]| {
            let at = |i: usize, aside: f32| (i as f32 - RIM as f32 + aside) * texel;
            let (x, y) = (at(i, aside[0]), at(j, aside[1]));
            // Within a texel the ground is level.
            let h = interpolated(heights, [i + STEP - RIM, j + STEP - RIM], |height| height.h);
            let point = Vector3::new(x, y, -h);
            !things.iter().any(|(thing, centre)| thing.darkens(&(point - centre), &sun))
        };
        let middles: Vec<[f32; WIDE]> =
            (0..WIDE).map(|j| std::array::from_fn(|i| f32::from(u8::from(lit(i, j, [0.0; 2]))))).collect();
        let mut refined = middles.clone();
        for j in 1..WIDE - 1 {
            for i in 1..WIDE - 1 {
                let sum = middles[j - 1][i] + middles[j + 1][i] + middles[j][i - 1] + middles[j][i + 1];
                if sum != 4.0 * middles[j][i] {
                    let rays = RAYS.iter().filter(|aside| lit(i, j, **aside)).count();
                    refined[j][i] = rays as f32 / RAYS.len() as f32;
                }
            }
        }
        let mut along = vec![[0f32; SIDE]; WIDE];
        for (to, from) in along.iter_mut().zip(&refined) {
            for (i, to) in to.iter_mut().enumerate() {
                *to = (0..5).map(|k| SMOOTH[k] * from[i + k + RIM - 2]).sum();
            }
        }
        let mut smooth = Box::new([[0f32; SIDE]; SIDE]);
        for (j, row) in smooth.iter_mut().enumerate() {
            for (i, to) in row.iter_mut().enumerate() {
                *to = (0..5).map(|k| SMOOTH[k] * along[j + k + RIM - 2][i]).sum();
            }
        }
        Some(smooth)
    }

    /// What full scale of a texel stands for: bright ground on a slope towards the sun.
    pub(super) fn brightest(&self) -> f32 {
        1.5 * (SKY + (1.0 - SKY) / -self.to_sun.z as f32)
    }
}

/// The ground at a point: height, m, and the sunlight on it relative to level ground.
#[derive(Debug, Clone, Copy)]
struct Knot {
    h: f32,
    sun: f32,
}

/// Bilinear between the heights, at a texel counted from the first of them.
fn interpolated(heights: &[[Knot; HEIGHTS]; HEIGHTS], [i, j]: [usize; 2], value: impl Fn(&Knot) -> f32) -> f32 {
    let (a, b) = (i / STEP, j / STEP);
    let (s, t) = ((i % STEP) as f32 / STEP as f32, (j % STEP) as f32 / STEP as f32);
    let upper = value(&heights[b][a]) + s * (value(&heights[b][a + 1]) - value(&heights[b][a]));
    let lower = value(&heights[b + 1][a]) + s * (value(&heights[b + 1][a + 1]) - value(&heights[b + 1][a]));
    upper + t * (lower - upper)
}
