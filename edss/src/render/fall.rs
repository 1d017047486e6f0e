//! Rain and snow in front of the camera: drops fixed in a falling cube of air, repeated in all directions.
//!
//! A drop of diameter `d` at the distance `z` covers `f d / z` pixels. During an exposure it draws a streak, fainter in
//! proportion to its length.

use hoverlock_reference::image::plane::Plane;
use nalgebra::{Vector2, Vector3};

use super::Shot;
use super::noise::unit;
use super::row::Viewpoint;
use crate::scene::Fall;

/// Side of the cube of air, m.
const CUBE_SIDE_M: f64 = 8.0;
/// Distance from the camera below which no drop is drawn, m.
const MIN_DISTANCE_M: f64 = 0.5;
/// Exposure time for the streaks, s.
const EXPOSURE_S: f64 = 0.008;
/// Light reflected by a drop, relative to white ground in full sun.
const DROP_LIGHT: f32 = 0.85;

/// The raindrops or snowflakes in the cube of air.
pub struct Drops {
    places: Vec<Vector3<f64>>,
    velocity: Vector3<f64>,
    diameter: f64,
    light: f32,
}

impl Drops {
    /// Creates rain: drops of 3 mm that fall at 7 m/s (Gunn and Kinzer 1949: 8 m/s), slanted by a breeze.
    pub fn rain(fall: &Fall, brightness: f32, seed: u32) -> Self {
        Self::new(fall, Vector3::new(1.5, 0.8, 7.0), 0.003, brightness, seed)
    }

    /// Creates snow: flakes of 8 mm that fall at 1.2 m/s. `brightness` is that of the scene, 1 by default.
    pub fn snow(fall: &Fall, brightness: f32, seed: u32) -> Self {
        Self::new(fall, Vector3::new(1.0, 0.6, 1.2), 0.008, brightness, seed)
    }

    fn new(fall: &Fall, velocity: Vector3<f64>, diameter: f64, brightness: f32, seed: u32) -> Self {
        let count = (fall.per_m3 * CUBE_SIDE_M.powi(3)) as u32;
        let place = |k| Vector3::from_fn(|axis, _| CUBE_SIDE_M * f64::from(unit(k, axis as u32, seed)));
        Self { places: (0..count).map(place).collect(), velocity, diameter, light: DROP_LIGHT * brightness }
    }

    /// Draws the streaks over a frame.
    pub fn draw(&self, shot: &Shot, out: &mut Plane<f32>) {
        let viewpoint = Viewpoint::new(&shot.first);
        for place in &self.places {
            let moved = place + self.velocity * shot.time - viewpoint.origin;
            let from = moved.map(|v| v - CUBE_SIDE_M * (v / CUBE_SIDE_M).round());
            let to_camera = viewpoint.rotation.transpose();
            let ends = [from, from + self.velocity * EXPOSURE_S].map(|point| to_camera * point);
            if ends.iter().any(|end| end.z < MIN_DISTANCE_M) {
                continue;
            }
            let [a, b] = ends.map(|end| shot.lens.pixel(end));
            let size = shot.lens.camera.focal() * self.diameter / ends[0].z;
            // Drops fade towards the faces of the cube, where they would otherwise appear suddenly.
            let fade = (4.0 * (0.5 - from.amax() / CUBE_SIDE_M)).clamp(0.0, 1.0);
            let length = (b - a).norm();
            let width = size.max(1.0);
            let cover = fade * (size / width) * size.max(1.0) / (size.max(1.0) + length);
            streak(out, a, b, width, cover as f32, self.light);
        }
    }
}

/// Draws a line of `width` pixels with round ends and edges one pixel wide.
fn streak(out: &mut Plane<f32>, a: Vector2<f64>, b: Vector2<f64>, width: f64, cover: f32, light: f32) {
    let reach = 0.5 * width + 1.0;
    let (low, high) = (a.inf(&b).add_scalar(-reach), a.sup(&b).add_scalar(reach));
    let (columns, rows) = (out.width() as f64 - 1.0, out.height() as f64 - 1.0);
    if cover < 1e-3 || high.x < 0.0 || high.y < 0.0 || low.x > columns || low.y > rows {
        return;
    }
    let along = b - a;
    let square = along.norm_squared().max(1e-12);
    for y in low.y.clamp(0.0, rows) as usize..=high.y.clamp(0.0, rows) as usize {
        for x in low.x.clamp(0.0, columns) as usize..=high.x.clamp(0.0, columns) as usize {
            let p = Vector2::new(x as f64, y as f64) - a;
            let part = (p.dot(&along) / square).clamp(0.0, 1.0);
            let distance = (p - along * part).norm();
            let inside = (0.5 + 0.5 * width - distance).clamp(0.0, 1.0) as f32;
            let sample = &mut out[(x, y)];
            *sample += cover * inside * (light - *sample);
        }
    }
}
