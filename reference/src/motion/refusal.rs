//! Honest refusals: matches that agree and are wrong all the same.
//!
//! The search refuses agreement that chance can bring. Two kinds of agreement are not chance and not the ground's
//! motion either:
//!
//! - **Ground that repeats.** With a lattice vector `v` the motions `H p` and `H p + v` explain the matches equally
//!   well. Every inlier looks at all features of CUR that are as like it as its partner, within [`MARGIN`] bits,
//!   wherever they are; where the differences `q - H p` of [`SECOND`] of the inliers crowd away from 0, there is a
//!   second mode. No gate narrows this look. Waves of one wind repeat nearly, and are refused for the same reason.
//! - **Pattern of the sensor.** It stays on its pixels. Where half of the inliers do, and IMU and laser say that the
//!   picture has moved by more than [`SIGMAS`] of their errors, what is seen is not the ground. A drift that undoes the
//!   turn exactly would be refused too; of the drifts that can be, it is one in thousands.

use crate::features::feature::Feature;
use crate::motion::budget::Budget;
use crate::motion::estimate::Estimate;
use crate::motion::matching::{Match, MatchBuffers};
use crate::motion::model::{Pair, transfer};
use crate::motion::pose::{Errors, Sight};
use nalgebra::Vector2;

/// Bits by which another partner may be worse than the chosen one and still be as like.
pub const MARGIN: u32 = 8;

/// Part of the inliers that make a second mode. Ground has at most 0.16 of them anywhere, lattices 0.34 and more, waves
/// 0.23 and more.
pub const SECOND: f64 = 0.2;

/// Fewer than this are never a mode.
const FEWEST: usize = 8;

/// Inliers that look for other partners, the best first.
const MOST: usize = 200;

/// Differences within this are the first mode, px.
const NEAR: f64 = 8.0;

/// Side of a bin of the differences, px; a mode may lie across four of them.
const BIN: f64 = 4.0;

/// Differences reach this far, px.
const REACH: f64 = 1024.0;

/// Bins along an axis.
const BINS: usize = (2.0 * REACH / BIN) as usize + 2;

/// A match that moves less stays on its pixel, px.
pub const STILL: f64 = 0.75;

/// Standard errors beyond which IMU and laser exclude that the picture stood still.
pub const SIGMAS: f64 = 4.0;

/// Why an estimate is not believed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A second motion explains the matches.
    #[error("no estimate: the ground repeats, {second} of {inliers} matches fit as well ({x:+.0}, {y:+.0}) px away")]
    Repeats {
        /// Inliers with a partner there.
        second: usize,
        /// Inliers that looked.
        inliers: usize,
        /// Where it is from the first, px.
        x: f64,
        /// Where it is from the first, px.
        y: f64,
    },
    /// What is seen stays on the sensor.
    #[error(
        "no estimate: {still} of {inliers} matches stay on their pixel, and IMU and laser say that the picture moved"
    )]
    Sensor {
        /// Inliers that stay.
        still: usize,
        /// All inliers.
        inliers: usize,
    },
}

/// Memory of [`repeats`], to be used again.
#[derive(Debug, Clone)]
pub struct RepeatBuffers {
    /// Differences per bin; all 0 between calls.
    votes: Vec<u16>,
    /// Bins with votes.
    touched: Vec<usize>,
}

impl RepeatBuffers {
    /// Memory for lists of `features` features each.
    pub fn with_capacity(features: usize) -> Self {
        Self { votes: vec![0; BINS * BINS], touched: Vec::with_capacity(MOST * features) }
    }
}

/// Refuses an estimate over ground that repeats. Where `budget` ends, the check is left out, and the estimate is late.
///
/// # Errors
/// [`Refusal::Repeats`].
pub fn repeats(
    estimate: &Estimate,
    reference: &[Feature],
    current: &[Feature],
    budget: &mut Budget,
    matching: &mut MatchBuffers,
    buffers: &mut RepeatBuffers,
) -> Result<(), Refusal> {
    let inliers = &estimate.inliers[..estimate.inliers.len().min(MOST)];
    let strict = matching.strict;
    let queries = inliers.iter().map(|&i| {
        let Match { reference: a, current: b, .. } = estimate.matches[i];
        // At most 192 + 8.
        (a, (reference[a].descriptor.hamming(&current[b].descriptor, strict) + MARGIN) as u8)
    });
    let RepeatBuffers { votes, touched } = buffers;
    let all = matching.alike(reference, queries, budget, |query, position| {
        let away = position - estimate.pairs[inliers[query]].current;
        if away.norm_squared() > NEAR * NEAR && away.amax() < REACH {
            let bin = away.map(|v| ((v + REACH) / BIN) as usize);
            let bin = bin.y * BINS + bin.x;
            if votes[bin] == 0 {
                touched.push(bin);
            }
            votes[bin] += 1;
        }
    });
    // Of four bins about a corner the first voted one is the upper left, or the mode starts beside it.
    let block = |bin: usize| [0, 1, BINS, BINS + 1].map(|step| votes.get(bin + step).copied().map_or(0, usize::from));
    let corners = touched.iter().flat_map(|&bin| [0, 1, BINS, BINS + 1].map(|step| bin.saturating_sub(step)));
    let largest = corners.map(|bin| (block(bin).iter().sum::<usize>(), std::cmp::Reverse(bin))).max().filter(|_| all);
    let inliers = inliers.len();
    for bin in touched.drain(..) {
        votes[bin] = 0;
    }
    match largest {
        Some((second, std::cmp::Reverse(bin))) if second >= FEWEST && second as f64 >= SECOND * inliers as f64 => {
            let at = Vector2::new((bin % BINS) as f64 + 1.0, (bin / BINS) as f64 + 1.0) * BIN;
            Err(Refusal::Repeats { second, inliers, x: at.x - REACH, y: at.y - REACH })
        }
        _ => Ok(()),
    }
}

/// Refuses inlier pairs that rest on the sensor's own pattern.
///
/// # Errors
/// [`Refusal::Sensor`].
pub fn sensor(pairs: &[Pair], reference: &Sight, current: &Sight) -> Result<(), Refusal> {
    let stays = |pair: &&Pair| (pair.current - pair.reference).norm_squared() < STILL * STILL;
    let still = pairs.iter().filter(stays).count();
    if 2 * still < pairs.len() || !has_moved(reference, current) {
        return Ok(());
    }
    Err(Refusal::Sensor { still, inliers: pairs.len() })
}

/// Whether IMU and laser exclude that the picture stood still, had there been no drift.
fn has_moved(reference: &Sight, current: &Sight) -> bool {
    let both = |error: fn(&Errors) -> f64| error(&reference.errors).hypot(error(&current.errors));
    let (tilt, heading, height) = (both(|e| e.tilt), both(|e| e.heading), both(|e| e.level));
    let (reference, current) = (&reference.view, &current.view);
    let undrifted = current.from_ground() * reference.to_ground();
    let moved = |p: Vector2<f64>| transfer(&undrifted, p).map(|q| q - p);
    let matrix = reference.camera().matrix();
    let (centre, corner) = (Vector2::new(matrix[(0, 2)], matrix[(1, 2)]), Vector2::zeros());
    let (Some(shift), Some(turn)) = (moved(centre), moved(corner)) else { return true };
    let half = centre.norm();
    // Tilt shifts the whole picture; yaw turns it and height scales it about the centre.
    let by_tilt = SIGMAS * tilt * current.camera().focal();
    let by_turn = SIGMAS * half * (heading + height / current.height());
    shift.norm() > by_tilt || (turn - shift).norm() > by_turn + half * by_tilt / current.camera().focal()
}
