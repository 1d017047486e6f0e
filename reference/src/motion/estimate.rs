//! The result of an estimation: the motion between two pictures with its matches.

use crate::motion::matching::Match;
use crate::motion::model::{Model, Pair};
use nalgebra::Matrix3;

/// The motion between two pictures, with its matches and inliers.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The homography from REF pixel to CUR pixel.
    pub homography: Matrix3<f64>,
    /// The model of the motion: the final one, or that of the wide search if no refinement round found a consensus.
    pub model: Model,
    /// The matches of the last round.
    pub matches: Vec<Match>,
    /// The positions of the matches, in the same order.
    pub pairs: Vec<Pair>,
    /// Indices of the inliers, ascending.
    pub inliers: Vec<usize>,
    /// Root mean square error of the inliers, px.
    pub rms: f64,
    /// Quality of the wide search, 0 ..= 255; 0 is no estimate.
    pub quality: u8,
}
