//! The standard error of a motion at a place of REF, for example the centre of the picture:
//!
//! ```text
//! sigma^2 = s^2 (N^-1[0, 0] + N^-1[1, 1])
//! N       = sum over cells of 1/n sum over their n pairs of J_i^T J_i
//! s^2     = sum over cells of 1/n sum over their n pairs of |e_i|^2, over 2 cells - parameters
//! ```
//!
//! with `J_i` the derivative of the position in CUR by the parameters of the model, of which the first two are the
//! position of the place in CUR, `e_i` the error of a pair, and cells of 64 x 64 px of REF, smaller ones where the
//! matches cover less than eight such cells along an axis. Neighbours share ground that is no plane, a moving thing or
//! a patch, so that they are wrong together, and a cell counts as one pair however many it has.
//!
//! Agreement alone knows no geometry: pairs along one border of a picture agree on a homography that is extrapolated to
//! the centre. A wrong match far from them has so much leverage that the homography passes through it, and its error
//! says nothing. So a pair counts only if at least half of the eight matches nearest to it agree too. With no more
//! cells than the model needs nothing is left that could disagree, and there is no standard error: ten pairs on one
//! marker.

use crate::motion::estimate::Estimate;
use crate::motion::model::{Model, Pair, squared_error, transfer};
use nalgebra::{DMatrix, Matrix2xX, Vector2};
use std::collections::HashMap;

/// Largest side of a cell, px.
const MAX_CELL_PX: f64 = 64.0;

/// Smallest number of cells along an axis of the region that the matches cover.
const MIN_CELLS: f64 = 8.0;

/// Number of matches nearest to a pair, itself included, half of which must agree.
const NEAREST: usize = 8;

/// Standard error up to which the quality of an estimate is that of its matches, px.
const FULL_QUALITY_PX: f64 = 1.0;

impl Estimate {
    /// Returns the standard error of the position in CUR of `place` in REF, px, both axes together. `search` is the
    /// estimate that this one refines, or itself: its matches say which pairs count. Infinite if these do not determine
    /// the model with one cell to spare, or if `place` maps behind the camera.
    pub fn standard_error(&self, search: &Self, place: Vector2<f64>) -> f64 {
        let pairs = search.supported(&self.inliers.iter().map(|&i| self.pairs[i]).collect::<Vec<_>>());
        let side = search.cell_side();
        let mut in_cell = HashMap::new();
        let cell = |pair: &Pair| {
            let [x, y] = [pair.reference.x, pair.reference.y].map(|v| (v / side).floor() as i64);
            (x, y)
        };
        pairs.iter().for_each(|pair| *in_cell.entry(cell(pair)).or_insert(0u32) += 1);
        let parameters = 2 * self.model.minimal_pairs();
        let mut normal = DMatrix::zeros(parameters, parameters);
        let mut squares = 0.0;
        for pair in &pairs {
            let Some(j) = self.derivative(pair.reference, place) else { return f64::INFINITY };
            let weight = 1.0 / f64::from(in_cell[&cell(pair)]);
            normal += weight * j.tr_mul(&j);
            squares += weight * squared_error(&self.homography, pair);
        }
        if 2 * in_cell.len() <= parameters {
            return f64::INFINITY;
        }
        let freedom = (2 * in_cell.len() - parameters) as f64;
        let Some(factor) = normal.cholesky() else { return f64::INFINITY };
        let inverse = factor.inverse();
        let variance = squares / freedom * (inverse[(0, 0)] + inverse[(1, 1)]);
        if variance.is_finite() { variance.sqrt() } else { f64::INFINITY }
    }

    /// Returns the quality of a place with this standard error (px): less than that of the matches by the factor by
    /// which the error exceeds one pixel. 0 is no estimate.
    pub fn quality_within(&self, standard_error: f64) -> u8 {
        (f64::from(self.quality) * (FULL_QUALITY_PX / standard_error).min(1.0)) as u8
    }

    /// Returns those of `pairs` that have at least half of the matches nearest to them with them.
    fn supported(&self, pairs: &[Pair]) -> Vec<Pair> {
        let mut agrees = vec![false; self.pairs.len()];
        self.inliers.iter().for_each(|&i| agrees[i] = true);
        let mut near = Vec::with_capacity(self.pairs.len());
        let is_supported = |pair: &&Pair| {
            near.clear();
            let distance = |other: &Pair| (other.reference - pair.reference).norm_squared();
            near.extend(self.pairs.iter().zip(&agrees).map(|(other, &agrees)| (distance(other), agrees)));
            let nearest = NEAREST.min(near.len());
            if nearest > 0 {
                near.select_nth_unstable_by(nearest - 1, |a, b| a.0.total_cmp(&b.0));
            }
            2 * near[..nearest].iter().filter(|(_, agrees)| *agrees).count() >= nearest
        };
        pairs.iter().filter(is_supported).copied().collect()
    }

    /// Returns the side of a cell, px.
    fn cell_side(&self) -> f64 {
        let extent = |axis: usize| {
            let positions = || self.pairs.iter().map(|pair| pair.reference[axis]);
            positions().fold(f64::NEG_INFINITY, f64::max) - positions().fold(f64::INFINITY, f64::min)
        };
        (extent(0).min(extent(1)) / MIN_CELLS).clamp(1.0, MAX_CELL_PX)
    }

    /// Returns the derivative of the position in CUR of `p` by the parameters of the map from `r = (p - place) / 64 px`
    /// to CUR: `q = (t + A r) / (1 + g r)`.
    fn derivative(&self, p: Vector2<f64>, place: Vector2<f64>) -> Option<Matrix2xX<f64>> {
        let q = transfer(&self.homography, p)?;
        let h = &self.homography;
        let depth = |p: Vector2<f64>| h[(2, 0)] * p.x + h[(2, 1)] * p.y + h[(2, 2)];
        let d = depth(p) / depth(place);
        let r = (p - place) / MAX_CELL_PX;
        let columns: &[[f64; 2]] = match self.model {
            Model::Shift => &[[1.0, 0.0], [0.0, 1.0]],
            Model::Similarity => &[[1.0, 0.0], [0.0, 1.0], [r.x, r.y], [-r.y, r.x]],
            Model::Affine | Model::Homography => {
                &[[1.0, 0.0], [0.0, 1.0], [r.x, 0.0], [r.y, 0.0], [0.0, r.x], [0.0, r.y]]
            }
        };
        let mut columns: Vec<Vector2<f64>> = columns.iter().map(|&column| Vector2::from(column) / d).collect();
        if self.model == Model::Homography {
            columns.extend([-q * r.x / d, -q * r.y / d]);
        }
        (d > 0.0).then(|| Matrix2xX::from_columns(&columns))
    }
}

#[cfg(test)]
mod tests;
