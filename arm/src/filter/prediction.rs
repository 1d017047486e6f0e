//! Where landmarks of a keyframe are expected in the present frame.

use super::Filter;
use super::projection::Projection;
use hoverlock_reference::motion::orthophoto::Camera;
use nalgebra::{Matrix2, Vector2};

/// Blocks of a keyframe, across and down, whose pixels are predicted with one covariance of the poses.
const PREDICTED_BLOCKS: (usize, usize) = (8, 6);

/// The predicted image of a landmark with its covariance.
#[derive(Debug, Clone, Copy)]
pub struct Prediction {
    /// Position, px.
    pub image: Vector2<f64>,
    /// Covariance from poses, errors of the camera and height, px^2.
    pub covariance: Matrix2<f64>,
}

impl Filter {
    /// Predicts the images of pixels of keyframe `k`, given with an index; `out` is called with that of each one seen.
    /// All pixels of a block of the keyframe have the covariance of its middle, to which each adds that of its height.
    pub fn images(
        &self,
        k: usize,
        cameras: [&Camera; 2],
        pixels: impl Iterator<Item = (usize, Vector2<f64>)>,
        mut out: impl FnMut(usize, Prediction),
    ) {
        let Some(state) = self.pair_state(k) else { return };
        let pair = self.pair_covariance(k);
        let of_poses = |seen: &Projection| {
            let by = seen.by_pair();
            by * pair * by.transpose()
        };
        let size = cameras[0].last_pixel().add_scalar(1.0);
        let mut blocks = [None; PREDICTED_BLOCKS.0 * PREDICTED_BLOCKS.1];
        for (index, pixel) in pixels {
            let Some(seen) = state.project(cameras, &pixel) else { continue };
            let place = |value: f64, side: f64, count: usize| ((value / side * count as f64) as usize).min(count - 1);
            let column = place(pixel.x, size.x, PREDICTED_BLOCKS.0);
            let row = place(pixel.y, size.y, PREDICTED_BLOCKS.1);
            let covariance = *blocks[row * PREDICTED_BLOCKS.0 + column].get_or_insert_with(|| {
                let middle = |index: usize, count: usize| (index as f64 + 0.5) / count as f64;
                let middle =
                    Vector2::new(middle(column, PREDICTED_BLOCKS.0) * size.x, middle(row, PREDICTED_BLOCKS.1) * size.y);
                of_poses(state.project(cameras, &middle).as_ref().unwrap_or(&seen))
            });
            let g = seen.by_height * self.height_sigma;
            out(index, Prediction { image: seen.image, covariance: covariance + g * g.transpose() });
        }
    }
}
