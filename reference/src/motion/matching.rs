//! Matching of features by the distance `D(a, b) = sum_k Hamming_k(a, b) + C (DOG(a) - DOG(b))^2`.
//!
//! `Hamming_k` counts the bits that differ in the words of scale pair `k` (MaxLBP and sign bits, 0 ..= 64 a pair;
//! strict: MaxLBP alone, 0 ..= 32), for as many pairs as the chain has; `DOG` is the feature's response at its own
//! scale, in DN of the camera sample. `C` (one over squared DN) is small, so that the second term decides between equal
//! Hamming distances only. The default is therefore a lexicographic order: Hamming distance, then `|DOG(a) - DOG(b)|`,
//! then the smaller index. It gives the same result for fixed point, whose responses are multiples of 0.5 DN with exact
//! differences in f64. The sum with a given `C` is a separate mode.
//!
//! Two features can match when scale and polarity agree and, where there is a prediction, when the position in CUR is
//! within the gate's radius of where the prediction takes the position in REF. A match is mutual: `b` is the best
//! candidate of `a`, and `a` the best candidate of `b`. So no feature is in two matches, and the result is symmetric in
//! the two pictures.

use crate::features::feature::Feature;
use crate::motion::budget::Budget;
use crate::motion::mark::{Part, mark};
use crate::motion::model::transfer;
use nalgebra::{Matrix3, Vector2};
use std::cmp::Ordering;
use std::ops::Range;

/// Radius of the gate about a predicted position, px.
pub const GATE_RADIUS: f64 = 192.0;

/// Work units of a feature in a matching beside its comparisons, by instructions on the ARM.
const FEATURE_WORK: usize = 72;

/// Work units of preparing a feature, once for all matchings of a frame.
const FILL_WORK: usize = 24;

/// Work units of a comparison where the place decides too.
const GATED_WORK: usize = 2;

/// How the two terms of the distance are combined.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Distance {
    /// Hamming distance first; the difference of the responses only decides between equals.
    #[default]
    Lexicographic,
    /// The sum with this `C`, one over squared DN; finite and not negative.
    Sum(f64),
}

/// The search region in CUR of a feature of REF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// REF pixel -> CUR pixel.
    pub prediction: Matrix3<f64>,
    /// Largest distance from the predicted position, px.
    pub radius: f64,
}

/// Settings of the matching.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Matching {
    /// How descriptors and responses are compared.
    pub distance: Distance,
    /// MaxLBP words alone, without the sign words.
    pub strict: bool,
    /// Search region; the whole picture where there is no prediction.
    pub gate: Option<Gate>,
    /// Ratio test: largest ratio of the distance to that of the second best candidate, both ways; 1 switches it off.
    pub ratio: Option<f64>,
    /// Largest Hamming distance, or largest sum.
    pub limit: Option<f64>,
}

/// A mutual best match.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Index among the features of REF.
    pub reference: usize,
    /// Index among the features of CUR.
    pub current: usize,
    /// Hamming distance, or the sum in the mode of that name.
    pub distance: f64,
    /// `|DOG(a) - DOG(b)|`, DN.
    pub response_difference: f64,
}

impl Matching {
    /// All matches, the best first: by distance, then difference of responses, then index in REF.
    pub fn matches(&self, reference: &[Feature], current: &[Feature]) -> Vec<Match> {
        let mut found = Vec::new();
        let (mut budget, mut buffers) = (Budget::UNLIMITED, MatchBuffers::default());
        buffers.fill(reference, current, self.strict, &mut budget);
        self.matches_into(&mut budget, &mut buffers, &mut found);
        found
    }

    /// The same of the features that `buffers` were filled with, into `found`, whose content is replaced, and with
    /// bounded work: whether `budget` allowed all of it. Where not, what is found is of no use.
    pub fn matches_into(&self, budget: &mut Budget, buffers: &mut MatchBuffers, found: &mut Vec<Match>) -> bool {
        found.clear();
        if !budget.spend(FEATURE_WORK * (buffers.from.len() + buffers.to.len())) {
            return false;
        }
        mark(Part::Matching);
        buffers.blocks.iter_mut().for_each(|block| block.limits = [u8::MAX; BLOCK]);
        let whole = (0..buffers.groups.len()).all(|group| match self.distance {
            Distance::Lexicographic => self.mutual(budget, buffers, group, found, |hamming, _| f64::from(hamming)),
            Distance::Sum(c) => self.mutual(budget, buffers, group, found, |hamming, difference| {
                f64::from(hamming) + c * difference * difference
            }),
        });
        // The index decides last, so no two are equal and the order is that of a stable sort.
        found.sort_unstable_by(Match::best_first);
        mark(Part::Search);
        whole
    }

    /// Adds the mutual best of one scale and polarity; `sum` puts Hamming distance and difference of responses
    /// together. Whether `budget` allowed all comparisons.
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
        // The second best only matters for the ratio.
        let limit = |best: &Best| if self.ratio.is_some() { best.second } else { best.distance };
        for (i, a) in from.iter().enumerate() {
            // A position that the prediction maps behind the camera has no search region.
            let expected = match self.gate {
                Some(gate) => match transfer(&gate.prediction, a.position) {
                    Some(position) => Some((position, gate.radius * gate.radius)),
                    None => continue,
                },
                None => None,
            };
            let first = match expected {
                Some((position, _)) if in_row_order => {
                    to.partition_point(|b| f64::from(b.row) < position.y - self.reach())
                }
                _ => 0,
            };
            let end = match expected {
                Some((position, _)) if in_row_order => {
                    to.partition_point(|b| f64::from(b.row) <= position.y + self.reach())
                }
                _ => to.len(),
            };
            let looked_at = first / BLOCK..end.div_ceil(BLOCK);
            let each = if expected.is_some() { GATED_WORK } else { 1 };
            if !budget.spend(each * BLOCK * looked_at.len()) {
                return false;
            }
            for (block, near) in blocks.iter_mut().enumerate().take(looked_at.end).skip(looked_at.start) {
                let (mut closer, hamming) = near.closer(&a.words, floor(limit(&best_from[i])));
                while closer != 0 {
                    let lane = closer.trailing_zeros() as usize;
                    closer &= closer - 1;
                    let j = block * BLOCK + lane;
                    let b = &to[j];
                    if let Some((position, radius2)) = expected
                        && (b.position - position).norm_squared() > radius2
                    {
                        continue;
                    }
                    let difference = (a.response - b.response).abs();
                    let distance = sum(u32::from(hamming[lane]), difference);
                    best_from[i].offer(distance, difference, j);
                    best_to[j].offer(distance, difference, i);
                    near.limits[lane] = floor(limit(&best_to[j]));
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
    /// Rows beyond which nothing is in the gate; a position is within half a row of its pixel.
    fn reach(&self) -> f64 {
        self.gate.map_or(f64::INFINITY, |gate| gate.radius + 1.0)
    }
}

impl Match {
    fn best_first(&self, other: &Self) -> Ordering {
        self.distance
            .total_cmp(&other.distance)
            .then(self.response_difference.total_cmp(&other.response_difference))
            .then(self.reference.cmp(&other.reference))
    }
}

/// Features that are compared, and memory of a matching, to be used again for the next: after a first matching of as
/// many features none is allocated.
#[derive(Default)]
pub struct MatchBuffers {
    /// As in [`Matching`].
    pub(crate) strict: bool,
    groups: Vec<Group>,
    from: Vec<Candidate>,
    to: Vec<Candidate>,
    blocks: Vec<Block>,
    best_from: Vec<Best>,
    best_to: Vec<Best>,
}

impl MatchBuffers {
    /// Memory for lists of `features` features each.
    pub fn with_capacity(features: usize) -> Self {
        Self {
            strict: false,
            groups: Vec::with_capacity(features),
            from: Vec::with_capacity(features),
            to: Vec::with_capacity(features),
            // Each group may have a block that is not full.
            blocks: Vec::with_capacity(features),
            best_from: Vec::with_capacity(features),
            best_to: Vec::with_capacity(features),
        }
    }

    /// Hands `found` every feature of CUR whose descriptor is near one of REF: the number of the query and the
    /// position. The buffers were filled with `reference`. A query is an index in REF and the largest Hamming distance;
    /// only features of its scale and polarity are compared. Whether `budget` allowed all of that.
    pub fn alike(
        &mut self,
        reference: &[Feature],
        queries: impl Iterator<Item = (usize, u8)> + Clone,
        budget: &mut Budget,
        mut found: impl FnMut(usize, Vector2<f64>),
    ) -> bool {
        // The query's limit alone decides.
        self.blocks.iter_mut().for_each(|block| block.limits = [0; BLOCK]);
        for Group { kind, to, blocks, .. } in &self.groups {
            let to = &self.to[to.clone()];
            let queries = queries.clone().enumerate().filter(|(_, (i, _))| kind_of(&reference[*i]) == *kind);
            if !budget.spend(queries.clone().count() * to.len()) {
                return false;
            }
            for (query, (i, limit)) in queries {
                let words = Candidate::of(i, &reference[i], self.strict).words;
                for (near, features) in self.blocks[blocks.clone()].iter().zip(to.chunks(BLOCK)) {
                    let (mut closer, _) = near.closer(&words, limit);
                    while closer != 0 {
                        found(query, features[closer.trailing_zeros() as usize].position);
                        closer &= closer - 1;
                    }
                }
            }
        }
        true
    }

    /// Takes the features to be compared, sorted by scale and polarity; `strict` as in [`Matching`]. Whether `budget`
    /// allowed that.
    pub fn fill(&mut self, reference: &[Feature], current: &[Feature], strict: bool, budget: &mut Budget) -> bool {
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
                let member = |(_, f): &(usize, &Feature)| kind_of(f) == kind;
                let candidate = |(i, f): (usize, &Feature)| Candidate::of(i, f, strict);
                from.extend(reference.iter().enumerate().filter(member).map(candidate));
                to.extend(current.iter().enumerate().filter(member).map(candidate));
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
        mark(Part::Search);
        true
    }
}

/// Only features of one scale and polarity are compared.
fn kind_of(feature: &Feature) -> (u8, bool) {
    (feature.scale, feature.bright)
}

/// Where the features of one scale and polarity are among all.
#[derive(Clone)]
struct Group {
    kind: (u8, bool),
    from: Range<usize>,
    to: Range<usize>,
    blocks: Range<usize>,
    /// Those of CUR.
    in_row_order: bool,
}

/// What the inner loop needs of a feature.
struct Candidate {
    index: usize,
    words: Words,
    response: f64,
    row: u32,
    position: Vector2<f64>,
}

/// The words of a descriptor that count; the others are 0.
#[derive(Clone, Copy)]
struct Words {
    /// Of the first two scale pairs.
    bytes: [u8; BYTES],
    /// Of the third, 0 where the chain has none.
    third: [u8; BYTES / 2],
}

/// Bytes of the descriptor of two scale pairs.
const BYTES: usize = 16;

/// Candidates that are compared together: as many bytes as a NEON or SSE register has.
const BLOCK: usize = 16;

/// Descriptors of sixteen candidates, byte `k` of all side by side. So the Hamming distance of sixteen pairs is
/// sixteen times exclusive or, count of bits in bytes and sum of bytes; the largest, 192, fits a byte. For x86-64
/// compilers make vector instructions of that by themselves. For NEON they sum along the wrong axis, a thousand
/// instructions a block where the hundred of [`neon`] suffice.
struct Block {
    bytes: [[u8; BLOCK]; BYTES],
    /// Those of the third scale pair, where one has any.
    third: Option<Box<[[u8; BLOCK]; BYTES / 2]>>,
    /// Hamming distance above which a candidate takes no notice.
    limits: [u8; BLOCK],
    /// A bit for each lane that has a candidate.
    lanes: u16,
}

impl Block {
    fn of(candidates: &[Candidate]) -> Self {
        let lanes = (((1u32 << candidates.len()) - 1) & 0xffff) as u16;
        let mut block = Self { bytes: [[0; BLOCK]; BYTES], third: None, limits: [u8::MAX; BLOCK], lanes };
        for (lane, candidate) in candidates.iter().enumerate() {
            let Words { bytes, third } = candidate.words;
            (0..BYTES).for_each(|k| block.bytes[k][lane] = bytes[k]);
            if third != [0; BYTES / 2] {
                let lanes = block.third.get_or_insert_default();
                (0..BYTES / 2).for_each(|k| lanes[k][lane] = third[k]);
            }
        }
        block
    }

    /// All Hamming distances, and a bit for each lane where it is small enough for either side to take notice.
    #[inline(always)]
    fn closer(&self, words: &Words, limit: u8) -> (u16, [u8; BLOCK]) {
        if self.third.is_some() || words.third != [0; BYTES / 2] {
            let (closer, hamming) = self.portable(words, limit);
            return (closer & self.lanes, hamming);
        }
        #[cfg(all(target_arch = "arm", target_feature = "neon"))]
        let (closer, hamming) = neon::closer(&self.bytes, &self.limits, &words.bytes, limit);
        #[cfg(not(all(target_arch = "arm", target_feature = "neon")))]
        let (closer, hamming) = self.two_pairs(words, limit);
        (closer & self.lanes, hamming)
    }

    /// All three scale pairs.
    fn portable(&self, words: &Words, limit: u8) -> (u16, [u8; BLOCK]) {
        const NONE: &[[u8; BLOCK]; BYTES / 2] = &[[0; BLOCK]; BYTES / 2];
        let mut hamming = [0u8; BLOCK];
        add_distances(&mut hamming, &self.bytes, &words.bytes);
        add_distances(&mut hamming, self.third.as_deref().unwrap_or(NONE), &words.third);
        self.near(hamming, limit)
    }

    #[cfg_attr(all(target_arch = "arm", target_feature = "neon"), expect(dead_code, reason = "for other processors"))]
    fn two_pairs(&self, words: &Words, limit: u8) -> (u16, [u8; BLOCK]) {
        let mut hamming = [0u8; BLOCK];
        add_distances(&mut hamming, &self.bytes, &words.bytes);
        self.near(hamming, limit)
    }

    #[inline(always)]
    fn near(&self, hamming: [u8; BLOCK], limit: u8) -> (u16, [u8; BLOCK]) {
        let mut small = [0u8; BLOCK];
        for ((small, hamming), other) in small.iter_mut().zip(&hamming).zip(&self.limits) {
            *small = u8::from(*hamming <= limit) | u8::from(hamming <= other);
        }
        // Most blocks have none: their bits are not gathered.
        if small == [0; BLOCK] {
            return (0, hamming);
        }
        (small.iter().enumerate().fold(0, |bits, (lane, small)| bits | u16::from(*small) << lane), hamming)
    }
}

#[inline(always)]
fn add_distances<const N: usize>(hamming: &mut [u8; BLOCK], lanes: &[[u8; BLOCK]; N], bytes: &[u8; N]) {
    for (lanes, byte) in lanes.iter().zip(bytes) {
        for (sum, lane) in hamming.iter_mut().zip(lanes) {
            *sum += (lane ^ byte).count_ones() as u8;
        }
    }
}

/// The inner loop for NEON.
#[cfg(all(target_arch = "arm", target_feature = "neon"))]
mod neon {
    use super::{BLOCK, BYTES};
    use std::arch::asm;

    /// The distances in one byte.
    macro_rules! byte {
        () => {
            "vld1.8 {{d18[], d19[]}}, [{bytes}]!
            vld1.8 {{d20, d21}}, [{lanes}]!
            veor q9, q9, q10
            vcnt.8 q9, q9
            vadd.i8 q8, q8, q9
            "
        };
    }

    // Written out and not `.rept`, whose length the compiler does not know when it places constants.
    macro_rules! four_bytes {
        () => {
            concat!(byte!(), byte!(), byte!(), byte!())
        };
    }

    /// As the portable one: for every byte of a descriptor `vld1` of that byte into all lanes, `vld1` of sixteen
    /// candidates' bytes, `veor`, `vcnt`, `vadd`; then the comparisons, and a bit for each lane.
    #[inline(always)]
    pub fn closer(
        lanes: &[[u8; BLOCK]; BYTES],
        limits: &[u8; BLOCK],
        bytes: &[u8; BYTES],
        limit: u8,
    ) -> (u16, [u8; BLOCK]) {
        const WEIGHTS: [u8; BLOCK] = [1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128];
        let mut hamming = [0u8; BLOCK];
        let mut closer: u32;
        // SAFETY: reads `lanes`, `limits`, `bytes` and the weights, writes `hamming`, each over its whole length and
        // not beyond; `vld1.8` and `vst1.8` need no alignment. All registers that change are named, the stack is not
        // used.
        unsafe {
            asm!(
                "vmov.i8 q8, #0",
                four_bytes!(),
                four_bytes!(),
                four_bytes!(),
                four_bytes!(),
                "vdup.8 q9, {closer}",
                "vld1.8 {{d20, d21}}, [{limits}]",
                "vld1.8 {{d22, d23}}, [{weights}]",
                "vmax.u8 q9, q9, q10",
                "vcge.u8 q9, q9, q8",
                "vand q9, q9, q11",
                "vpadd.i8 d18, d18, d19",
                "vpadd.i8 d18, d18, d18",
                "vpadd.i8 d18, d18, d18",
                "vmov.u16 {closer}, d18[0]",
                "vst1.8 {{d16, d17}}, [{hamming}]",
                bytes = inout(reg) bytes.as_ptr() => _,
                lanes = inout(reg) lanes.as_ptr() => _,
                limits = in(reg) limits.as_ptr(),
                weights = in(reg) WEIGHTS.as_ptr(),
                hamming = in(reg) hamming.as_mut_ptr(),
                closer = inout(reg) u32::from(limit) => closer,
                out("q8") _,
                out("q9") _,
                out("q10") _,
                out("q11") _,
                options(nostack, preserves_flags),
            );
        }
        (closer as u16, hamming)
    }
}

/// The largest Hamming distance that is not beyond `limit`; a distance is never below its Hamming part.
fn floor(limit: f64) -> u8 {
    // Saturates, and infinity with it.
    limit as u8
}

impl Candidate {
    fn of(index: usize, feature: &Feature, strict: bool) -> Self {
        let mut descriptor = feature.descriptor;
        if strict {
            descriptor.sign = Default::default();
        }
        let mut all = descriptor.words().into_iter().flat_map(u32::to_le_bytes);
        let mut next = || all.next().unwrap_or_default();
        let (bytes, third) = (std::array::from_fn(|_| next()), std::array::from_fn(|_| next()));
        let (x, y) = feature.subpixel();
        Self {
            index,
            words: Words { bytes, third },
            response: feature.response,
            row: feature.y,
            position: Vector2::new(x, y),
        }
    }
}

/// The best partner so far, and how far the second best is.
#[derive(Clone, Copy)]
struct Best {
    distance: f64,
    difference: f64,
    partner: usize,
    second: f64,
}

impl Best {
    const NONE: Self =
        Self { distance: f64::INFINITY, difference: f64::INFINITY, partner: usize::MAX, second: f64::INFINITY };

    /// Partners come in the order of their index, so a strict comparison leaves ties to the smaller.
    fn offer(&mut self, distance: f64, difference: f64, partner: usize) {
        if distance < self.distance || (distance == self.distance && difference < self.difference) {
            *self = Self { distance, difference, partner, second: self.distance };
        } else if distance < self.second {
            self.second = distance;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::feature::Descriptor;
    use proptest::prelude::*;

    /// The words in the order of the record; those left out are 0.
    fn feature<const N: usize>(position: (u32, u32), group: (u8, bool), response: f64, words: [u32; N]) -> Feature {
        let word = |i: usize| words.get(i).copied().unwrap_or_default();
        Feature {
            x: position.0,
            y: position.1,
            scale: group.0,
            bright: group.1,
            response,
            neighbours: [0.0; 4],
            descriptor: Descriptor { maxlbp: [word(0), word(1), word(4)], sign: [word(2), word(3), word(5)] },
        }
    }

    /// Few bits and few responses, so that ties abound.
    fn features() -> impl Strategy<Value = Vec<Feature>> {
        let one = ((0..1024u32, 0..768u32), (0..3u8, any::<bool>()), 1..6u32, prop::array::uniform6(0..8u32))
            .prop_map(|(position, group, halves, words)| feature(position, group, f64::from(halves) / 2.0, words));
        (prop::collection::vec(one, 0..60), any::<bool>()).prop_map(|(mut features, three_pairs)| {
            if !three_pairs {
                features.iter_mut().for_each(|f| (f.descriptor.maxlbp[2], f.descriptor.sign[2]) = (0, 0));
            }
            features
        })
    }

    fn settings() -> impl Strategy<Value = Matching> {
        let distance = prop_oneof![Just(Distance::Lexicographic), (0.0..2.0f64).prop_map(Distance::Sum)];
        let gate = prop::option::of((-300..300i32, -300..300i32, 1.0..400.0f64));
        (distance, any::<bool>(), gate, prop::option::of(0.3..1.0f64), prop::option::of(0.0..9.0f64)).prop_map(
            |(distance, strict, gate, ratio, limit)| Matching {
                distance,
                strict,
                gate: gate.map(|(x, y, radius)| Gate { prediction: shift(x, y), radius }),
                ratio,
                limit,
            },
        )
    }

    fn shift(x: i32, y: i32) -> Matrix3<f64> {
        Matrix3::new(1.0, 0.0, f64::from(x), 0.0, 1.0, f64::from(y), 0.0, 0.0, 1.0)
    }

    /// The definition, without the optimisations.
    fn by_definition(settings: &Matching, reference: &[Feature], current: &[Feature]) -> Vec<(usize, usize)> {
        let key = |a: &Feature, b: &Feature| -> Option<(f64, f64)> {
            let allowed = a.scale == b.scale
                && a.bright == b.bright
                && settings.gate.is_none_or(|gate| {
                    let (ax, ay) = a.subpixel();
                    let (bx, by) = b.subpixel();
                    let expected = transfer(&gate.prediction, Vector2::new(ax, ay)).unwrap();
                    (Vector2::new(bx, by) - expected).norm_squared() <= gate.radius * gate.radius
                });
            let difference = (a.response - b.response).abs();
            let hamming = f64::from(a.descriptor.hamming(&b.descriptor, settings.strict));
            let distance = match settings.distance {
                Distance::Lexicographic => hamming,
                Distance::Sum(c) => hamming + c * difference.powi(2),
            };
            allowed.then_some((distance, difference))
        };
        // Ordered partners of one feature: (distance, difference, index).
        let ranked = |keys: Vec<Option<(f64, f64)>>| -> Vec<(f64, f64, usize)> {
            let mut ranked: Vec<_> = keys.iter().enumerate().filter_map(|(i, k)| k.map(|(d, r)| (d, r, i))).collect();
            ranked.sort_by(|a, b| a.partial_cmp(b).unwrap());
            ranked
        };
        let mut found = Vec::new();
        for (i, a) in reference.iter().enumerate() {
            let forward = ranked(current.iter().map(|b| key(a, b)).collect());
            let Some(&(distance, _, j)) = forward.first() else { continue };
            let backward = ranked(reference.iter().map(|a| key(a, &current[j])).collect());
            let distinct =
                |list: &[(f64, f64, usize)], ratio: f64| list.get(1).is_none_or(|second| distance <= ratio * second.0);
            if backward[0].2 == i
                && settings.ratio.is_none_or(|ratio| distinct(&forward, ratio) && distinct(&backward, ratio))
                && settings.limit.is_none_or(|limit| distance <= limit)
            {
                found.push((i, j));
            }
        }
        found
    }

    proptest! {
        #[test]
        fn matches_are_those_of_the_definition(a in features(), b in features(), settings in settings()) {
            let matches = settings.matches(&a, &b);
            let mut found: Vec<_> = matches.iter().map(|m| (m.reference, m.current)).collect();
            prop_assert!(matches.is_sorted_by(|a, b| a.best_first(b) == Ordering::Less));
            found.sort_unstable();
            prop_assert_eq!(found, by_definition(&settings, &a, &b));
        }

        #[test]
        fn exchanging_the_pictures_exchanges_the_roles(a in features(), b in features(), settings in settings()) {
            let back = Matching {
                gate: settings.gate.map(|g| Gate { prediction: g.prediction.try_inverse().unwrap(), ..g }),
                ..settings
            };
            let mut forth: Vec<_> = settings.matches(&a, &b).iter().map(|m| (m.reference, m.current)).collect();
            let mut back: Vec<_> = back.matches(&b, &a).iter().map(|m| (m.current, m.reference)).collect();
            forth.sort_unstable();
            back.sort_unstable();
            prop_assert_eq!(forth, back);
        }
    }

    #[test]
    fn responses_decide_only_between_equals() {
        let a = [feature((0, 0), (0, true), 10.0, [0b1, 0, 0, 0])];
        let near_bits = feature((0, 0), (0, true), 1000.0, [0b1, 0, 0, 0]);
        let near_response = feature((0, 0), (0, true), 10.0, [0b11, 0, 0, 0]);
        let b = [near_response, near_bits];
        assert_eq!(Matching::default().matches(&a, &b)[0].current, 1);
        // 0 + C 990^2 against 1 + C 0: the sum turns round at C = 990^-2.
        let turn = 1.0 / 990f64.powi(2);
        let with = |c: f64| Matching { distance: Distance::Sum(c), ..Matching::default() };
        assert_eq!(with(0.99 * turn).matches(&a, &b)[0].current, 1);
        assert_eq!(with(1.01 * turn).matches(&a, &b)[0].current, 0);
    }

    #[test]
    fn scale_and_polarity_must_agree() {
        let a = [feature((0, 0), (0, true), 10.0, [5; 4])];
        for other in [(0, false), (1, true), (1, false)] {
            assert_eq!(Matching::default().matches(&a, &[feature((0, 0), other, 10.0, [5; 4])]), []);
        }
    }

    #[test]
    fn strict_does_not_see_the_signs() {
        let a = [feature((0, 0), (0, true), 10.0, [7, 7, 0, 0])];
        let b = [feature((0, 0), (0, true), 10.0, [7, 6, u32::MAX, u32::MAX])];
        let strict = Matching { strict: true, ..Matching::default() };
        assert_eq!(strict.matches(&a, &b)[0].distance, 1.0);
        assert_eq!(Matching::default().matches(&a, &b)[0].distance, 65.0);
    }
}
