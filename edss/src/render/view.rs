//! Conversion of pixels to rays and back: `d = R (x s, y s, 1)`, with `(x, y) = K^-1 pixel` and `s` the correction of
//! the lens.
//!
//! Brown (1966): a direction with normalised coordinates at the radius `r` appears at `r (1 + k1 r^2 + k2 r^4)`. The
//! inverse has no closed form; a table of it is computed by Newton's iteration.

use hoverlock_reference::motion::orthophoto::Camera;
use nalgebra::{Vector2, Vector3};

/// A camera and the radial distortion of its lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// The camera without distortion.
    pub camera: Camera,
    /// Second-order term of the radial distortion of normalised coordinates; 0 for a pinhole.
    pub k1: f64,
    /// Fourth-order term of the radial distortion.
    pub k2: f64,
}

/// Smallest slope of the distorted radius over the undistorted one with which [`Lens::correction`] iterates; 0 is the
/// fold of the lens.
const MIN_SLOPE: f64 = 0.1;

impl Lens {
    /// Returns the least `k1` of a lens without `k2` for a frame of `width` x `height` px: the slope of the distorted
    /// radius is at least 0.1 up to the corners. A lens whose slope falls to 0 folds there, and the pixels beyond have
    /// no ray.
    ///
    /// At the slope `m = 1 + 3 k1 r^2` the distorted radius is `s = r (2 + m) / 3`, so
    /// `k1 = (m - 1) (2 + m)^2 / (27 s^2)`.
    pub fn min_k1(camera: &Camera, width: usize, height: usize) -> f64 {
        let last = max_squared(camera, width, height) * (TABLE_STEPS + 1) as f64 / TABLE_STEPS as f64;
        (MIN_SLOPE - 1.0) * (2.0 + MIN_SLOPE).powi(2) / (27.0 * last)
    }

    /// Returns the direction of a pixel in the camera frame, with `z = 1`.
    pub fn direction(&self, pixel: Vector2<f64>) -> Vector3<f64> {
        let seen = self.camera.inverse() * pixel.push(1.0);
        let scale = self.correction(seen.xy().norm_squared());
        Vector3::new(seen.x * scale, seen.y * scale, 1.0)
    }

    /// Returns the pixel at which a direction in the camera frame appears; its `z` must be positive.
    pub fn pixel(&self, direction: Vector3<f64>) -> Vector2<f64> {
        let straight = direction.xy() / direction.z;
        let q = straight.norm_squared();
        let seen = straight * (1.0 + q * (self.k1 + q * self.k2));
        (self.camera.matrix() * seen.push(1.0)).xy()
    }

    /// Returns the ratio of undistorted to distorted radius, for the square of the distorted one.
    fn correction(&self, squared: f64) -> f64 {
        if self.k1 == 0.0 && self.k2 == 0.0 {
            return 1.0;
        }
        let seen = squared.sqrt();
        let mut r = seen;
        for _ in 0..12 {
            let q = r * r;
            let error = r * (1.0 + q * (self.k1 + q * self.k2)) - seen;
            // A lens that folds over has no inverse beyond the fold, where the iteration diverges: see `min_k1`.
            let rate = (1.0 + q * (3.0 * self.k1 + 5.0 * q * self.k2)).max(MIN_SLOPE);
            r -= error / rate;
        }
        if seen > 0.0 { r / seen } else { 1.0 }
    }
}

/// A table of corrections by the squared distorted radius, for all pixels of a frame.
pub struct Corrections {
    table: Vec<f32>,
    per_square: f32,
}

/// Steps of the table: the error of linear interpolation is below 1e-7 at a distortion of 10 %.
const TABLE_STEPS: usize = 1024;

impl Corrections {
    /// Computes the table for a frame of `width` x `height` pixels; `None` if the lens has no distortion.
    pub fn new(lens: &Lens, width: usize, height: usize) -> Option<Self> {
        if lens.k1 == 0.0 && lens.k2 == 0.0 {
            return None;
        }
        let most = max_squared(&lens.camera, width, height);
        let table =
            (0..=TABLE_STEPS + 1).map(|i| lens.correction(most * i as f64 / TABLE_STEPS as f64) as f32).collect();
        Some(Self { table, per_square: (TABLE_STEPS as f64 / most) as f32 })
    }

    /// Returns the correction for a squared distorted radius.
    #[inline(always)]
    pub fn at(&self, squared: f32) -> f32 {
        let place = (squared * self.per_square).min(TABLE_STEPS as f32);
        let step = place as usize;
        let (a, b) = (self.table[step], self.table[step + 1]);
        a + (place - step as f32) * (b - a)
    }
}

/// Returns the largest squared distorted radius for which a frame needs a correction, with a margin.
fn max_squared(camera: &Camera, width: usize, height: usize) -> f64 {
    let corner = |x: usize, y: usize| (camera.inverse() * Vector3::new(x as f64, y as f64, 1.0)).xy();
    let corners = [corner(0, 0), corner(width, 0), corner(0, height), corner(width, height)];
    corners.iter().map(|c| c.norm_squared()).fold(1e-9, f64::max) * 1.01
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_corners_of_a_frame_come_back_down_to_the_least_distortion() {
        for degrees in [5.4f64, 50.0, 90.0] {
            let camera = Camera::with_field_of_view(1024, 768, degrees.to_radians()).unwrap();
            let k1 = Lens::min_k1(&camera, 1024, 768);
            let lens = Lens { camera, k1, k2: 0.0 };
            for pixel in [Vector2::new(0.0, 0.0), Vector2::new(1024.0, 768.0)] {
                assert!((lens.pixel(lens.direction(pixel)) - pixel).norm() < 1e-6, "{degrees} degrees: k1 {k1}");
            }
            let table = Corrections::new(&lens, 1024, 768).unwrap().table;
            assert!(table.iter().all(|correction| (1.0..1.5).contains(correction)), "{degrees} degrees: k1 {k1}");
        }
        // At 50 degrees the squared radius of a corner is 0.34; the lens folds there at k1 = -4/27 of its inverse.
        let camera = Camera::with_field_of_view(1024, 768, 50f64.to_radians()).unwrap();
        let k1 = Lens::min_k1(&camera, 1024, 768);
        assert!((-0.436..-0.42).contains(&k1), "{k1}");
    }

    proptest! {
        #[test]
        fn a_pixel_comes_back(
            x in 0.0..1023.0f64, y in 0.0..767.0f64, k1 in -0.15..0.15f64, k2 in -0.05..0.05f64,
        ) {
            let camera = Camera::with_field_of_view(1024, 768, 0.87).unwrap();
            let lens = Lens { camera, k1, k2 };
            let pixel = Vector2::new(x, y);
            let direction = lens.direction(pixel);
            prop_assert!((lens.pixel(direction) - pixel).norm() < 1e-6);
            // The table against Newton: 1e-6 of the radius is less than 0.001 px.
            let seen = (camera.inverse() * pixel.push(1.0)).xy();
            if let Some(table) = Corrections::new(&lens, 1024, 768) {
                let from_table = f64::from(table.at(seen.norm_squared() as f32));
                prop_assert!((from_table * seen.norm() - direction.xy().norm()).abs() < 1e-6);
            }
        }
    }
}
