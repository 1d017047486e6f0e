//! Models of the motion of the picture: `p' = H p` in homogeneous coordinates, `p` a pixel of REF, `p'` the same ground
//! in CUR.
//!
//! | model | `H` | parameters | minimal pairs |
//! |---|---|---|---|
//! | shift | `[1 0 tx; 0 1 ty; 0 0 1]` | 2 | 1 |
//! | similarity | `[a -b tx; b a ty; 0 0 1]` | 4 | 2 |
//! | affine | `[a b tx; c d ty; 0 0 1]` | 6 | 3 |
//! | homography | `[a b tx; c d ty; g h 1]` | 8 | 4 |
//!
//! Coordinates are pixels, `(0, 0)` the centre of the top-left pixel, `x` right, `y` down. Every fit minimises the
//! weighted transfer error `sum w |p' - H p|^2` (px^2), in coordinates moved to the weighted centroid and scaled to a
//! mean square distance of 2 (Hartley, 1997, "In defense of the eight-point algorithm"), so that the normal equations
//! are well conditioned. The homography's error is not linear in its parameters; its equations, multiplied by the
//! denominator, are, and weights of one over the square of the previous denominator convert them back to pixels. The
//! model is exact at the minimal number of pairs.
//!
//! A camera above the ground never sees it mirrored or from behind. A fit with a negative determinant, or with a
//! denominator that changes its sign between the pairs, is therefore rejected like a degenerate sample.

mod least_squares;

use least_squares::{HOMOGRAPHY_ROUNDS, NormalisedFrame, affine, homography, similarity};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// A model of the motion between two pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Model {
    /// Two parameters: a translation.
    Shift,
    /// Four: translation, rotation, scale.
    Similarity,
    /// Six: a linear map and a translation.
    Affine,
    /// Eight: the motion of a plane between two views.
    Homography,
}

/// The positions of one ground point in two pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Position in REF, px.
    pub reference: Vector2<f64>,
    /// Position in CUR, px.
    pub current: Vector2<f64>,
}

/// An error of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MotionError {
    /// Fewer pairs with a positive weight than the model needs.
    #[error("the model needs {needed} pairs, not {given}")]
    TooFew {
        /// Pairs that determine the model.
        needed: usize,
        /// Pairs with a positive weight.
        given: usize,
    },
    /// The pairs are degenerate (one position or one line), or the map mirrors the picture.
    #[error("the pairs do not determine the model")]
    Degenerate,
    /// A coordinate or weight is not finite, a weight is negative, or the number of weights is not that of the pairs.
    #[error("weights and coordinates must be finite, weights not negative and as many as pairs")]
    NotFinite,
}

impl Model {
    /// Returns the number of pairs that determine the model.
    pub(crate) fn minimal_pairs(self) -> usize {
        match self {
            Self::Shift => 1,
            Self::Similarity => 2,
            Self::Affine => 3,
            Self::Homography => 4,
        }
    }

    /// Fits the model to all pairs with equal weights; exact for the minimal number of pairs.
    ///
    /// # Errors
    /// There are too few pairs, or they do not determine the model.
    pub fn fit(self, pairs: &[Pair]) -> Result<Matrix3<f64>, MotionError> {
        self.fit_by(pairs, |_| 1.0, HOMOGRAPHY_ROUNDS)
    }

    /// Runs a single round of the weighted fit, for a caller that iterates. `weights` include one over the square of
    /// the denominator of each pair under the previous motion; weight 0 leaves a pair out.
    ///
    /// # Errors
    /// As [`Model::fit`], and if a weight is negative or not finite or the number of weights is not that of the pairs.
    pub(crate) fn fit_round(self, pairs: &[Pair], weights: &[f64]) -> Result<Matrix3<f64>, MotionError> {
        if weights.len() != pairs.len() || weights.iter().any(|w| !w.is_finite() || *w < 0.0) {
            return Err(MotionError::NotFinite);
        }
        self.fit_by(pairs, |i| weights[i], 1)
    }

    /// Fits with weights, in `rounds` rounds for a homography.
    fn fit_by(self, pairs: &[Pair], weight: impl Fn(usize) -> f64, rounds: usize) -> Result<Matrix3<f64>, MotionError> {
        let given = (0..pairs.len()).filter(|&i| weight(i) > 0.0).count();
        if given < self.minimal_pairs() {
            return Err(MotionError::TooFew { needed: self.minimal_pairs(), given });
        }
        let from = NormalisedFrame::of(pairs, &weight, |pair| pair.reference)?;
        let to = NormalisedFrame::of(pairs, &weight, |pair| pair.current)?;
        if self == Self::Shift {
            let t = to.centroid - from.centroid;
            return Ok(Matrix3::new(1.0, 0.0, t.x, 0.0, 1.0, t.y, 0.0, 0.0, 1.0));
        }
        if from.scale == 0.0 || to.scale == 0.0 {
            return Err(MotionError::Degenerate);
        }
        let normal = |pair: &Pair| (from.normalise(pair.reference), to.normalise(pair.current));
        let h = match self {
            Self::Shift | Self::Similarity => similarity(pairs, &weight, normal),
            Self::Affine => affine(pairs, &weight, normal)?,
            Self::Homography => homography(pairs, &weight, normal, given, rounds)?,
        };
        let h = to.denormalisation() * h * from.normalisation();
        let h = h / h[(2, 2)];
        let sound = h.iter().all(|v| v.is_finite()) && h.determinant() > 0.0;
        if sound { Ok(h) } else { Err(MotionError::Degenerate) }
    }
}

/// Returns the position `p` (px) mapped by `H`, or `None` if it maps to infinity or behind the camera.
pub fn transfer(h: &Matrix3<f64>, p: Vector2<f64>) -> Option<Vector2<f64>> {
    let q = h * Vector3::new(p.x, p.y, 1.0);
    (q.z > 0.0).then(|| Vector2::new(q.x / q.z, q.y / q.z))
}

/// Returns the derivative of the mapped position by the position `p`, or `None` if `p` maps to infinity or behind the
/// camera.
pub fn derivative(h: &Matrix3<f64>, p: Vector2<f64>) -> Option<Matrix2<f64>> {
    let q = transfer(h, p)?;
    let depth = h[(2, 0)] * p.x + h[(2, 1)] * p.y + h[(2, 2)];
    Some(Matrix2::from_fn(|row, column| (h[(row, column)] - q[row] * h[(2, column)]) / depth))
}

/// Returns the squared transfer error of a pair, px^2; infinite if the position maps behind the camera.
pub(crate) fn squared_error(h: &Matrix3<f64>, pair: &Pair) -> f64 {
    transfer(h, pair.reference).map_or(f64::INFINITY, |q| (pair.current - q).norm_squared())
}

#[cfg(test)]
mod tests;
