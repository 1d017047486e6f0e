//! Reusable memory of a matching, with the features sorted by scale and polarity.

use crate::features::feature::Feature;
use crate::motion::budget::Budget;
use crate::motion::mark::{Part, mark};
use crate::motion::matching::block::{BLOCK, Block};
use crate::motion::matching::candidate::Candidate;
use crate::motion::matching::{BLOCK_WORK, WIDE_BLOCK_WORK};
use nalgebra::Vector2;
use std::ops::Range;

/// Work units of preparing a feature, once for all matchings of a frame, from instruction counts on the ARM.
const FILL_WORK: usize = 24;

/// The features of two frames and reusable memory of their matching: a matching of no more features than before
/// allocates nothing.
#[derive(Default)]
pub(crate) struct MatchBuffers {
    /// As in [`Matching`](crate::motion::matching::Matching).
    pub(crate) strict: bool,
    pub(super) groups: Vec<Group>,
    pub(super) from: Vec<Candidate>,
    pub(super) to: Vec<Candidate>,
    pub(super) blocks: Vec<Block>,
    /// Work units of a block, at most.
    block_work: usize,
    pub(super) best_from: Vec<Best>,
    pub(super) best_to: Vec<Best>,
}

impl MatchBuffers {
    /// Allocates memory for lists of `features` features each.
    pub fn with_capacity(features: usize) -> Self {
        Self {
            strict: false,
            groups: Vec::with_capacity(features),
            from: Vec::with_capacity(features),
            to: Vec::with_capacity(features),
            // Each group may have one incomplete block.
            blocks: Vec::with_capacity(features),
            block_work: BLOCK_WORK,
            best_from: Vec::with_capacity(features),
            best_to: Vec::with_capacity(features),
        }
    }

    /// Returns the work units of comparing a feature with all of its scale and polarity, at most.
    pub(in crate::motion) fn max_query_work(&self) -> usize {
        self.groups.iter().map(|group| group.blocks.len() * self.block_work).max().unwrap_or_default()
    }

    /// Calls `found` with the number of the query and the position (px) for every feature of CUR whose descriptor is
    /// similar to that of the query. A query is an index in REF and the largest Hamming distance; only features of its
    /// scale and polarity are compared. `reference` is the list that the buffers were filled with, and `found_work` the
    /// work units of a call of `found`. Returns `false` if `budget` is exhausted.
    pub(in crate::motion) fn for_each_similar(
        &mut self,
        reference: &[Feature],
        queries: impl Iterator<Item = (usize, u8)> + Clone,
        found_work: usize,
        budget: &mut Budget,
        mut found: impl FnMut(usize, Vector2<f64>),
    ) -> bool {
        // Only the limit of the query counts.
        self.blocks.iter_mut().for_each(|block| block.limits = [0; BLOCK]);
        for Group { kind, to, blocks, .. } in &self.groups {
            let to = &self.to[to.clone()];
            let queries = queries.clone().enumerate().filter(|(_, (i, _))| kind_of(&reference[*i]) == *kind);
            for (query, (i, limit)) in queries {
                let words = Candidate::of(i, &reference[i], self.strict).words;
                for (near, features) in self.blocks[blocks.clone()].iter().zip(to.chunks(BLOCK)) {
                    let (mut closer, _) = near.closer(&words, limit);
                    if !budget.spend(near.work(&words) + found_work * closer.count_ones() as usize) {
                        return false;
                    }
                    while closer != 0 {
                        found(query, features[closer.trailing_zeros() as usize].position);
                        closer &= closer - 1;
                    }
                }
            }
        }
        true
    }

    /// Replaces the content by the features of two frames with at least the given responses, sorted by scale and
    /// polarity. `strict` is as in [`Matching`](crate::motion::matching::Matching). Returns `false` if `budget` is
    /// exhausted.
    pub fn fill(
        &mut self,
        [reference, current]: [&[Feature]; 2],
        min_responses: [f64; 2],
        strict: bool,
        budget: &mut Budget,
    ) -> bool {
        if !budget.spend(FILL_WORK * (reference.len() + current.len())) {
            return false;
        }
        mark(Part::Matching);
        self.strict = strict;
        let Self { groups, from, to, blocks, .. } = self;
        groups.clear();
        from.clear();
        to.clear();
        blocks.clear();
        for feature in reference {
            let kind = kind_of(feature);
            if groups.iter().all(|group| group.kind != kind) {
                let first = (from.len(), to.len(), blocks.len());
                let is_member = |f: &Feature, min: f64| kind_of(f) == kind && f.response >= min;
                let [min_from, min_to] = min_responses;
                let from_members = reference.iter().enumerate().filter(|(_, f)| is_member(f, min_from));
                let to_members = current.iter().enumerate().filter(|(_, f)| is_member(f, min_to));
                let candidate = |(i, f): (usize, &Feature)| Candidate::of(i, f, strict);
                from.extend(from_members.map(candidate));
                to.extend(to_members.map(candidate));
                blocks.extend(to[first.1..].chunks(BLOCK).map(Block::of));
                groups.push(Group {
                    kind,
                    from: first.0..from.len(),
                    to: first.1..to.len(),
                    blocks: first.2..blocks.len(),
                    in_row_order: to[first.1..].is_sorted_by_key(|candidate| candidate.row),
                });
            }
        }
        let is_wide = from.iter().chain(&*to).any(|candidate| candidate.words.third.iter().any(|byte| *byte != 0));
        self.block_work = if is_wide { WIDE_BLOCK_WORK } else { BLOCK_WORK };
        mark(Part::Search);
        true
    }
}

/// Returns scale and polarity, which must be equal for two features to be compared.
fn kind_of(feature: &Feature) -> (u8, bool) {
    (feature.scale, feature.bright)
}

/// The features of one scale and polarity, as ranges of [`MatchBuffers`].
#[derive(Clone)]
pub(super) struct Group {
    kind: (u8, bool),
    pub(super) from: Range<usize>,
    pub(super) to: Range<usize>,
    pub(super) blocks: Range<usize>,
    /// `true` if the features of CUR are sorted by row.
    pub(super) in_row_order: bool,
}

/// The best partner so far, and the distance of the second best.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) distance: f64,
    pub(super) difference: f64,
    pub(super) partner: usize,
    pub(super) second: f64,
}

impl Best {
    pub(super) const NONE: Self =
        Self { distance: f64::INFINITY, difference: f64::INFINITY, partner: usize::MAX, second: f64::INFINITY };

    /// Updates the best partner. Partners are offered in the order of their index, so that the strict comparison leaves
    /// ties to the smaller index.
    pub(super) fn offer(&mut self, distance: f64, difference: f64, partner: usize) {
        if distance < self.distance || (distance == self.distance && difference < self.difference) {
            *self = Self { distance, difference, partner, second: self.distance };
        } else if distance < self.second {
            self.second = distance;
        }
    }
}
