//! Matching of features by the distance `D(a, b) = sum_k Hamming_k(a, b) + C (DOG(a) - DOG(b))^2`.
//!
//! `Hamming_k` counts the bits that differ in the words of scale pair `k` (MaxLBP and sign bits, 0 ..= 64 a pair;
//! strict: MaxLBP alone, 0 ..= 32), for as many pairs as the chain has; `DOG` is the feature's response at its own
//! scale, in DN of the camera sample. `C` (one over squared DN) is small, so that the second term decides between equal
//! Hamming distances only. The default is therefore a lexicographic order: Hamming distance, then `|DOG(a) - DOG(b)|`,
//! then the smaller index. It gives the same result for fixed point, whose responses are multiples of 0.5 DN with exact
//! differences in f64. The sum with a given `C` is a separate mode.
//!
//! Two features can match if scale and polarity agree and, with a prediction, if the position in CUR is within the
//! radius of the gate about the predicted position. A match is mutual: `b` is the best candidate of `a`, and `a` the
//! best candidate of `b`. Therefore no feature is in two matches, and the result is symmetric in
//! the two pictures.

mod block;
mod buffers;
mod candidate;

use crate::features::feature::Feature;
use crate::motion::budget::Budget;
use crate::motion::mark::{Part, mark};
use crate::motion::model::{Pair, transfer};
use block::BLOCK;
pub(crate) use buffers::MatchBuffers;
use buffers::{Best, Group};
use nalgebra::{Matrix3, Vector2};
use std::cmp::Ordering;

/// Work units of a feature in a matching, without its comparisons, from instruction counts on the ARM.
const FEATURE_WORK: usize = 20;

/// Work units of the rows of a gate.
const GATE_WORK: usize = 36;

/// Work units of sorting a match.
const SORT_WORK: usize = 60;

/// Work units of comparing a descriptor with a block of two scale pairs.
pub(crate) const BLOCK_WORK: usize = 13;

/// The same of three scale pairs, in portable code.
pub(crate) const WIDE_BLOCK_WORK: usize = 128;

/// Work units of a feature in a block that is near enough to be looked at.
const OFFER_WORK: usize = 8;

/// Work units of a feature in the rows of a gate whose positions are compared first.
const SCANNED_WORK: usize = 2;

/// Work units of a feature in such a gate.
const GATED_WORK: usize = 20;

/// Largest radius of a gate whose positions are compared before descriptors, px: it has one in a hundred features.
const MAX_SCANNED_RADIUS_PX: f64 = 48.0;

/// A combination of the two terms of the distance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Distance {
    /// Hamming distance; the difference of the responses decides between equal distances only.
    #[default]
    Lexicographic,
    /// The sum with this `C`, in one over squared DN; finite and not negative.
    Sum(f64),
}

/// The search region in CUR of a feature of REF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// The homography from REF pixel to the predicted CUR pixel.
    pub prediction: Matrix3<f64>,
    /// Largest distance from the predicted position, px.
    pub radius: f64,
}

/// The settings of a matching.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Matching {
    /// Comparison of descriptors and responses.
    pub distance: Distance,
    /// `true` compares the MaxLBP words alone, without the sign words.
    pub strict: bool,
    /// Search region; `None` is the whole picture.
    pub gate: Option<Gate>,
    /// Ratio test: largest ratio of the distance to that of the second best candidate, in both directions. `None` skips
    /// the test.
    pub ratio: Option<f64>,
    /// Largest distance of a match: Hamming distance in bits, or the sum in the mode of that name.
    pub limit: Option<f64>,
}

/// A mutual best match.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Index among the features of REF.
    pub reference: usize,
    /// Index among the features of CUR.
    pub current: usize,
    /// Hamming distance in bits, or the sum in the mode of that name.
    pub distance: f64,
    /// `|DOG(a) - DOG(b)|`, DN.
    pub response_difference: f64,
}

impl Matching {
    /// Returns all matches, the best first: by distance, then difference of responses, then index in REF.
    pub fn matches(&self, reference: &[Feature], current: &[Feature]) -> Vec<Match> {
        let mut found = Vec::new();
        let (mut budget, mut buffers) = (Budget::UNLIMITED, MatchBuffers::default());
        buffers.fill([reference, current], [f64::NEG_INFINITY; 2], self.strict, &mut budget);
        self.matches_into(&mut budget, &mut buffers, &mut found);
        found
    }

    /// Matches the features that `buffers` were filled with, as [`Matching::matches`] does, into `found`, whose content
    /// is replaced. Returns `false` if `budget` is exhausted; then the matches are incomplete and must not be used.
    pub(crate) fn matches_into(&self, budget: &mut Budget, buffers: &mut MatchBuffers, found: &mut Vec<Match>) -> bool {
        found.clear();
        let gate_work = if self.gate.is_some() { GATE_WORK } else { 0 };
        if !budget.spend(FEATURE_WORK * (buffers.from.len() + buffers.to.len()) + gate_work * buffers.from.len()) {
            return false;
        }
        mark(Part::Matching);
        buffers.blocks.iter_mut().for_each(|block| block.limits = [u8::MAX; BLOCK]);
        let mut complete = (0..buffers.groups.len()).all(|group| match self.distance {
            Distance::Lexicographic => self.mutual(budget, buffers, group, found, |hamming, _| f64::from(hamming)),
            Distance::Sum(c) => self.mutual(budget, buffers, group, found, |hamming, difference| {
                f64::from(hamming) + c * difference * difference
            }),
        });
        complete = complete && budget.spend(SORT_WORK * found.len());
        // No two matches have the same index, so the order is that of a stable sort.
        if complete {
            found.sort_unstable_by(Match::best_first);
        }
        mark(Part::Search);
        complete
    }

    /// Appends the mutual best matches of one scale and polarity. `sum` combines Hamming distance and difference of
    /// responses. Returns `false` if `budget` is exhausted.
    fn mutual(
        &self,
        budget: &mut Budget,
        buffers: &mut MatchBuffers,
        group: usize,
        found: &mut Vec<Match>,
        sum: impl Fn(u32, f64) -> f64,
    ) -> bool {
        let MatchBuffers { groups, from, to, blocks, best_from, best_to, .. } = buffers;
        let Group { from: from_range, to: to_range, blocks: block_range, in_row_order, .. } = groups[group].clone();
        let (from, to, blocks) = (&from[from_range], &to[to_range], &mut blocks[block_range]);
        for (best, candidates) in [(&mut *best_from, from), (&mut *best_to, to)] {
            best.clear();
            best.resize(candidates.len(), Best::NONE);
        }
        // Only the ratio test needs the second best.
        let limit = |best: &Best| if self.ratio.is_some() { best.second } else { best.distance };
        for (i, a) in from.iter().enumerate() {
            // A position that the prediction maps behind the camera has no gate and no match.
            let expected = match self.gate {
                Some(gate) => match transfer(&gate.prediction, a.position) {
                    Some(position) => Some((position, gate.radius * gate.radius)),
                    None => continue,
                },
                None => None,
            };
            let first = match expected {
                Some((position, _)) if in_row_order => {
                    to.partition_point(|b| f64::from(b.row) < position.y - self.row_reach())
                }
                _ => 0,
            };
            let end = match expected {
                Some((position, _)) if in_row_order => {
                    to.partition_point(|b| f64::from(b.row) <= position.y + self.row_reach())
                }
                _ => to.len(),
            };
            let looked_at = first / BLOCK..end.div_ceil(BLOCK);
            let mut offer = |j: usize, hamming: u32, best_from: &mut Best, limit_to: &mut u8| {
                let b = &to[j];
                let difference = (a.response - b.response).abs();
                let distance = sum(hamming, difference);
                best_from.offer(distance, difference, j);
                best_to[j].offer(distance, difference, i);
                *limit_to = floor(limit(&best_to[j]));
            };
            if let Some((position, radius2)) = expected
                && radius2 <= MAX_SCANNED_RADIUS_PX * MAX_SCANNED_RADIUS_PX
            {
                // Few are in the gate, so positions are compared first.
                if !budget.spend(SCANNED_WORK * (end - first)) {
                    return false;
                }
                for (j, b) in to.iter().enumerate().take(end).skip(first) {
                    let miss = b.position - position;
                    if miss.x * miss.x + miss.y * miss.y <= radius2 {
                        if !budget.spend(GATED_WORK) {
                            return false;
                        }
                        let hamming = a.words.hamming(&b.words);
                        offer(j, hamming, &mut best_from[i], &mut blocks[j / BLOCK].limits[j % BLOCK]);
                    }
                }
                continue;
            }
            for (block, near) in blocks.iter_mut().enumerate().take(looked_at.end).skip(looked_at.start) {
                let (mut closer, hamming) = near.closer(&a.words, floor(limit(&best_from[i])));
                if !budget.spend(near.work(&a.words) + OFFER_WORK * closer.count_ones() as usize) {
                    return false;
                }
                while closer != 0 {
                    let lane = closer.trailing_zeros() as usize;
                    closer &= closer - 1;
                    let j = block * BLOCK + lane;
                    if let Some((position, radius2)) = expected
                        && (to[j].position - position).norm_squared() > radius2
                    {
                        continue;
                    }
                    offer(j, u32::from(hamming[lane]), &mut best_from[i], &mut near.limits[lane]);
                }
            }
        }
        for (i, best) in best_from.iter().enumerate() {
            let Some(back) = best_to.get(best.partner).filter(|back| back.partner == i) else { continue };
            let distinct = |ratio: f64| [best, back].iter().all(|b| b.distance <= ratio * b.second);
            if self.ratio.is_none_or(distinct) && self.limit.is_none_or(|limit| best.distance <= limit) {
                found.push(Match {
                    reference: from[i].index,
                    current: to[best.partner].index,
                    distance: best.distance,
                    response_difference: best.difference,
                });
            }
        }
        true
    }
}

impl Matching {
    /// Returns the largest difference of rows within the gate; a position is within half a row of its pixel.
    fn row_reach(&self) -> f64 {
        self.gate.map_or(f64::INFINITY, |gate| gate.radius + 1.0)
    }
}

impl Match {
    /// Compares two matches; the better one is less.
    fn best_first(&self, other: &Self) -> Ordering {
        // Both are not negative, so their bits have their order.
        let key = |m: &Self| (m.distance.to_bits(), m.response_difference.to_bits(), m.reference);
        key(self).cmp(&key(other))
    }
}

/// Returns the largest Hamming distance of at most `limit`; a distance is never below its Hamming part.
fn floor(limit: f64) -> u8 {
    // The conversion saturates, also for infinity.
    limit as u8
}

/// Returns the positions of matched features, to a fraction of a pixel, in the order of the matches.
pub fn matched_pairs(matches: &[Match], reference: &[Feature], current: &[Feature]) -> impl Iterator<Item = Pair> {
    let position = |feature: &Feature| {
        let (x, y) = feature.subpixel();
        Vector2::new(x, y)
    };
    matches
        .iter()
        .map(move |m| Pair { reference: position(&reference[m.reference]), current: position(&current[m.current]) })
}

#[cfg(test)]
mod tests;
