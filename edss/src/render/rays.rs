//! Intersections of rays with the ground and the objects on it: single rays for the laser, rows of rays for frames.

use nalgebra::{Vector2, Vector3};

use super::bundle::{Placed, RAYS, Vectors, first_hits};
use super::relief::Relief;
use super::row::{KNOT_SPACING, Knot, MIN_DOWNWARD, Row, Viewpoint, interpolate_points};
use super::{Lens, Renderer};
use crate::pose::Pose;

/// Length at which a ray ends without a hit, m.
const MAX_RANGE_M: f64 = 10_000.0;

/// A height above every hill and roof of a scene, m.
const ABOVE_ALL_M: f64 = 1000.0;

impl Renderer {
    /// Returns the distance, m, from `origin` along a `direction` of length 1 to the nearest terrain or object; `None`
    /// if there is none within 10 km.
    pub fn range(&self, time: f64, origin: Vector3<f64>, direction: Vector3<f64>) -> Option<f64> {
        let ray = direction.map(|v| v as f32);
        let nearest = self.terrain_range(origin, direction);
        let placed = |object| {
            let centre = (self.centre(object, time) - origin).map(|v| v as f32);
            Placed { object, centre }
        };
        let objects: Vec<Placed<'_>> = self.objects.iter().filter(|object| object.is_solid()).map(placed).collect();
        let limit = nearest.map_or(MAX_RANGE_M as f32, |range| range as f32);
        let hits = first_hits(&objects, &Vectors::all(&ray), &[limit; RAYS]);
        hits.surface(0).map(|_| hits.along[0].into()).or(nearest)
    }

    /// Returns the height, m, of the highest terrain or object at a place over the mean ground, m.
    pub fn surface(&self, time: f64, place: Vector2<f64>) -> f64 {
        self.range(time, place.push(-ABOVE_ALL_M), Vector3::z()).map_or(0.0, |range| ABOVE_ALL_M - range)
    }

    /// Returns the point of the scene that a pixel shows at `time`, m; `None` if its ray hits nothing.
    pub fn ground(&self, lens: &Lens, pose: &Pose, pixel: Vector2<f64>, time: f64) -> Option<Vector3<f64>> {
        let direction = (pose.attitude.rotation() * lens.direction(pixel)).normalize();
        let range = self.range(time, pose.position, direction)?;
        Some(pose.position + direction * range)
    }

    /// Returns the distance to the terrain, m.
    fn terrain_range(&self, origin: Vector3<f64>, direction: Vector3<f64>) -> Option<f64> {
        let [low, high] = self.relief.as_ref().map_or([0.0; 2], Relief::limits);
        let top = -origin.z;
        // Not downwards, or below the lowest ground.
        if direction.z <= 1e-9 || top < low {
            return None;
        }
        let range = match &self.relief {
            None => top / direction.z,
            Some(relief) => {
                let motion = direction.xy() / direction.z;
                let depth = if relief.steepest() * motion.norm() < 0.9 {
                    relief.depth(origin.xy(), top, motion, top, 16)
                } else {
                    march(relief, origin.xy(), top, motion, [(top - high).max(0.0), top - low])?
                };
                depth / direction.z
            }
        };
        (0.0..=MAX_RANGE_M).contains(&range).then_some(range)
    }

    /// Intersects the rays of a row with the ground.
    pub(super) fn intersect_row(&self, row: &mut Row, viewpoint: &Viewpoint, pixel: f64) {
        let top = -viewpoint.origin.z;
        let from = viewpoint.origin.xy();
        let mut depth = top;
        for k in 0..row.knots.len() {
            let x = k * KNOT_SPACING;
            let direction = row.direction(x).map(f64::from);
            let down = direction.z.max(MIN_DOWNWARD.into());
            if let Some(relief) = &self.relief {
                let steps = if k == 0 { 12 } else { 2 };
                depth = relief.depth(from, top, direction.xy() / down, depth, steps);
            }
            let range = depth / down * direction.norm();
            row.knots[k] = Knot {
                depth: depth as f32,
                footprint: libm::log2f((depth.max(0.01) / down * pixel) as f32),
                transmission: if self.extinction > 0.0 { libm::expf((-self.extinction * range) as f32) } else { 1.0 },
            };
        }
        interpolate_points(row);
    }
}

/// Finds the first crossing of a ray with a relief between two depths, by steps of half a cell and bisection. Returns
/// its depth below `top`, m.
fn march(relief: &Relief, from: Vector2<f64>, top: f64, motion: Vector2<f64>, depths: [f64; 2]) -> Option<f64> {
    let above = |depth: f64| top - depth - relief.at(from + motion * depth).h;
    let step = 0.5 * relief.cell() / motion.norm();
    let [first, last] = depths;
    let (mut before, end) = (first, last.min(first + MAX_RANGE_M / motion.norm()));
    if above(before) < 0.0 {
        return None;
    }
    loop {
        let after = (before + step).min(end);
        if above(after) <= 0.0 {
            let (mut high, mut low) = (before, after);
            for _ in 0..40 {
                let middle = 0.5 * (high + low);
                if above(middle) > 0.0 { high = middle } else { low = middle }
            }
            return Some(low);
        }
        if after >= end {
            return None;
        }
        before = after;
    }
}
