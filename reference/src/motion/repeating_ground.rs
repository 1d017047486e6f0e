//! Rejects estimates over ground that repeats.
//!
//! With a lattice vector `v` the motions `H p` and `H p + v` explain the matches equally well. Each inlier is compared
//! with all features of CUR whose descriptor is at most [`SIMILARITY_MARGIN_BITS`] worse than that of its partner,
//! wherever they are; no gate narrows this search. If the differences `q - H p` of a fifth of the inliers cluster away
//! from 0, there is a second motion. Waves of one wind nearly repeat, and are rejected for the same reason.

use crate::features::feature::Feature;
use crate::motion::budget::Budget;
use crate::motion::estimate::Estimate;
use crate::motion::matching::{Match, MatchBuffers};
use crate::motion::ransac::RansacError;
use crate::motion::refusal::Refusal;
use nalgebra::Vector2;

/// Bits by which the distance of another partner may exceed that of the matched one.
const SIMILARITY_MARGIN_BITS: u32 = 8;

/// Fraction of the inliers that makes a second motion. Measured: at most 0.16 over ground that does not repeat, 0.34
/// and more over lattices, 0.23 and more over waves.
const MIN_SECOND_MOTION_FRACTION: f64 = 0.2;

/// Smallest number of inliers that makes a second motion.
const MIN_SECOND_MOTION_INLIERS: usize = 8;

/// Number of inliers that are checked, the best first.
const MAX_CHECKED_INLIERS: usize = 200;

/// Length up to which a difference belongs to the first motion, px.
const FIRST_MOTION_RADIUS_PX: f64 = 8.0;

/// Side of a histogram bin, px; a cluster may extend over four bins.
const BIN_SIDE_PX: f64 = 4.0;

/// Largest difference along an axis, px.
const MAX_DIFFERENCE_PX: f64 = 1024.0;

/// Bins along an axis.
const BINS: usize = (2.0 * MAX_DIFFERENCE_PX / BIN_SIDE_PX) as usize + 2;

/// Work units of an inlier's similar feature: its bin, and the four clusters that the bin may belong to.
const SIMILAR_WORK: usize = 14;

/// Work units of similar features that are always kept for the check.
const RESERVED_SIMILAR_WORK: usize = 56_000;

/// Returns the work units that are kept for [`check`] until the motion is known.
pub(super) fn reserved_work(matching: &MatchBuffers) -> usize {
    RESERVED_SIMILAR_WORK + MAX_CHECKED_INLIERS * matching.max_query_work()
}

/// Reusable memory of [`check`].
#[derive(Debug, Clone)]
pub(super) struct HistogramBuffers {
    /// Number of differences in each bin; all 0 between calls.
    votes: Vec<u16>,
    /// Indices of the bins that are not 0.
    occupied: Vec<usize>,
}

impl HistogramBuffers {
    /// Allocates memory for lists of `features` features each.
    pub(super) fn with_capacity(features: usize) -> Self {
        Self { votes: vec![0; BINS * BINS], occupied: Vec::with_capacity(MAX_CHECKED_INLIERS * features) }
    }
}

/// Rejects an estimate over ground that repeats. `matching` was filled with `reference` and `current`.
///
/// # Errors
/// [`Refusal::RepeatingGround`], or [`RansacError::Unchecked`] if `budget` is exhausted: so many features are similar.
pub(super) fn check(
    estimate: &Estimate,
    reference: &[Feature],
    current: &[Feature],
    budget: &mut Budget,
    matching: &mut MatchBuffers,
    buffers: &mut HistogramBuffers,
) -> Result<(), RansacError> {
    let inliers = &estimate.inliers[..estimate.inliers.len().min(MAX_CHECKED_INLIERS)];
    let strict = matching.strict;
    let queries = inliers.iter().map(|&i| {
        let Match { reference: a, current: b, .. } = estimate.matches[i];
        // At most 192 + 8.
        (a, (reference[a].descriptor.hamming(&current[b].descriptor, strict) + SIMILARITY_MARGIN_BITS) as u8)
    });
    let HistogramBuffers { votes, occupied } = buffers;
    let complete = matching.for_each_similar(reference, queries, SIMILAR_WORK, budget, |query, position| {
        let difference = position - estimate.pairs[inliers[query]].current;
        let is_second = difference.norm_squared() > FIRST_MOTION_RADIUS_PX * FIRST_MOTION_RADIUS_PX;
        if is_second && difference.amax() < MAX_DIFFERENCE_PX {
            let bin = difference.map(|v| ((v + MAX_DIFFERENCE_PX) / BIN_SIDE_PX) as usize);
            let bin = bin.y * BINS + bin.x;
            if votes[bin] == 0 {
                occupied.push(bin);
            }
            votes[bin] += 1;
        }
    });
    // A cluster is a block of 2 x 2 bins. Its first occupied bin may be any of the four.
    let block = |bin: usize| [0, 1, BINS, BINS + 1].map(|step| votes.get(bin + step).copied().map_or(0, usize::from));
    // A cluster that counts has a bin with two differences.
    let shared = occupied.iter().filter(|bin| votes[**bin] > 1);
    let corners = shared.flat_map(|&bin| [0, 1, BINS, BINS + 1].map(|step| bin.saturating_sub(step)));
    let largest = corners.map(|bin| (block(bin).iter().sum::<usize>(), std::cmp::Reverse(bin))).max();
    let inliers = inliers.len();
    for bin in occupied.drain(..) {
        votes[bin] = 0;
    }
    if !complete {
        return Err(RansacError::Unchecked);
    }
    match largest {
        Some((second, std::cmp::Reverse(bin)))
            if second >= MIN_SECOND_MOTION_INLIERS && second as f64 >= MIN_SECOND_MOTION_FRACTION * inliers as f64 =>
        {
            let at = Vector2::new((bin % BINS) as f64 + 1.0, (bin / BINS) as f64 + 1.0) * BIN_SIDE_PX;
            let [x, y] = (at - Vector2::repeat(MAX_DIFFERENCE_PX)).into();
            Err(Refusal::RepeatingGround { second, inliers, x, y }.into())
        }
        _ => Ok(()),
    }
}
