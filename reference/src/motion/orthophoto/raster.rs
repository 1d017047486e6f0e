//! The frame as seen straight from above: `out(x, y) = I(P (x, y))`, `P = G^-1 O`, `O` orthophoto pixel to ground, `G`
//! pixel to ground.

use crate::image::plane::Plane;
use crate::motion::model::transfer;
use crate::motion::orthophoto::View;
use nalgebra::{Matrix3, Vector2, Vector3};

/// The raster of an orthophoto on the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raster {
    /// Columns, along `X_e`.
    pub width: usize,
    /// Rows, along `Y_e`.
    pub height: usize,
    /// Side of a pixel, m.
    pub pixel: f64,
    /// Position of the centre of pixel `(0, 0)`, measured from the point below the camera, m.
    pub origin: Vector2<f64>,
}

impl Raster {
    /// Returns a raster of `width` x `height` pixels about the point that the laser hits, each as large as a pixel on
    /// the optical axis.
    pub fn of(view: &View, width: usize, height: usize) -> Self {
        let pixel = view.range / view.camera.focal;
        let axis = view.attitude.rotation() * Vector3::z() * view.range;
        let half = Vector2::new(width as f64 - 1.0, height as f64 - 1.0) / 2.0;
        Self { width, height, pixel, origin: axis.xy() - pixel * half }
    }

    /// Returns the matrix from orthophoto pixel to metres on the plane.
    pub fn to_ground(&self) -> Matrix3<f64> {
        let (s, o) = (self.pixel, self.origin);
        Matrix3::new(s, 0.0, o.x, 0.0, s, o.y, 0.0, 0.0, 1.0)
    }

    /// Renders the frame as seen straight from above: each pixel of the raster is looked up in the frame, bilinear
    /// between four pixels; pixels outside the view are `outside`.
    pub fn warp(&self, frame: &Plane<u16>, view: &View, outside: u16) -> Plane<u16> {
        let to_frame = view.from_ground() * self.to_ground();
        Plane::from_fn(self.width, self.height, |x, y| {
            transfer(&to_frame, Vector2::new(x as f64, y as f64)).and_then(|p| bilinear(frame, p)).unwrap_or(outside)
        })
    }
}

/// Returns the sample at `p`, bilinear between four pixels, or `None` outside the frame.
fn bilinear(frame: &Plane<u16>, p: Vector2<f64>) -> Option<u16> {
    let (right, bottom) = (frame.width() - 1, frame.height() - 1);
    let inside = p.x >= 0.0 && p.y >= 0.0 && p.x <= right as f64 && p.y <= bottom as f64;
    inside.then(|| {
        let (x, y) = (p.x.floor() as usize, p.y.floor() as usize);
        let (s, t) = (p.x - x as f64, p.y - y as f64);
        let at = |x: usize, y: usize| f64::from(frame[(x.min(right), y.min(bottom))]);
        let upper = at(x, y) + s * (at(x + 1, y) - at(x, y));
        let lower = at(x, y + 1) + s * (at(x + 1, y + 1) - at(x, y + 1));
        (upper + t * (lower - upper)).round() as u16
    })
}
