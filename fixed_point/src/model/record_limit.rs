//! The ceiling on the records of a frame: which features of a frame with too many are sent.
//!
//! The eligible rows `18 <= y < H - 18` are cut into bands of `ceil((H - 36) / 64)` rows, so there are at most 64.
//! With `L` the register `record_limit`, `T_k` the thresholds of the frame and `P` the largest response:
//!
//! ```text
//! first band    left = L - 63 (L >> 6), gate_k = T_k
//! a feature of pair k with response p, in order:
//!   p < gate_k                 withheld
//!   p >= gate_k, left > 0      sent, left -= 1
//!   p >= gate_k, left = 0      withheld; after its pixel all gate_j = min(gate_j + (gate_j >> 2) + 1, P)
//! next band     left += L >> 6, gate_k = max(gate_k - (gate_k >> 2) - 1, T_k)
//! ```
//!
//! All features of a pixel are compared with the gates before that pixel. At most `L` features are sent. What a band
//! does not use is left to the bands below it, so a frame whose features are spread like those of most pictures is sent
//! whole up to nearly `L`. In a frame with far too many the gates rise within its first rows to the strength that the
//! allowance permits: what is sent comes from all rows, and is among the strongest around.

use hoverlock_reference::features::feature::MAX_PAIRS;

use crate::model::record::FeatureRecord;

/// Number of bands of the eligible rows.
const BANDS: u32 = 64;

/// Rows above the first eligible one, and below the last.
const MARGIN: usize = 18;

/// The allowance and the gates at one place of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordLimit {
    /// Features that may still be sent in this band.
    left: u32,
    /// Features that each further band adds.
    quota: u32,
    /// `T_k`, LSB of the DoG; 0 for pairs that the design does not have.
    thresholds: [u32; MAX_PAIRS],
    /// `gate_k`, LSB of the DoG.
    gates: [u32; MAX_PAIRS],
    /// The largest response, LSB of the DoG.
    max: u32,
}

impl RecordLimit {
    /// Creates the state before the first eligible row of a frame with the thresholds `T_k`. `limit` is the register
    /// `record_limit`, `max` the largest response, LSB of the DoG.
    pub fn new(limit: u32, thresholds: &[u32], max: u32) -> Self {
        let quota = limit / BANDS;
        let thresholds = std::array::from_fn(|k| thresholds.get(k).map_or(0, |threshold| (*threshold).max(1)));
        Self { left: limit - (BANDS - 1) * quota, quota, thresholds, gates: thresholds, max }
    }

    /// Decides about the features of one pixel. `responses[k]` is that of scale pair `k` if it has a feature there;
    /// the result says which of them are sent.
    pub fn pixel(&mut self, responses: [Option<u32>; MAX_PAIRS]) -> [bool; MAX_PAIRS] {
        let mut sent = [false; MAX_PAIRS];
        let mut raised = false;
        for k in 0..MAX_PAIRS {
            if responses[k].is_some_and(|response| response >= self.gates[k]) {
                sent[k] = self.left > 0;
                raised |= !sent[k];
                self.left -= u32::from(sent[k]);
            }
        }
        if raised {
            self.gates = self.gates.map(|gate| (gate + (gate >> 2) + 1).min(self.max));
        }
        sent
    }

    /// Begins the next band.
    pub fn finish_band(&mut self) {
        self.left += self.quota;
        for (gate, threshold) in self.gates.iter_mut().zip(self.thresholds) {
            *gate = (*gate - (*gate >> 2)).saturating_sub(1).max(threshold);
        }
    }

    /// Returns the features of a frame of `height` rows that are sent. `features` are all features of the frame, in
    /// order; the arguments are otherwise those of [`RecordLimit::new`].
    pub fn sent(
        limit: u32,
        thresholds: &[u32],
        max: u32,
        height: usize,
        features: &[FeatureRecord],
    ) -> Vec<FeatureRecord> {
        let mut law = Self::new(limit, thresholds, max);
        let band_rows = height.saturating_sub(2 * MARGIN).div_ceil(BANDS as usize).max(1);
        let mut sent = Vec::with_capacity(features.len().min(limit as usize));
        let mut band = 0;
        for pixel in features.chunk_by(|a, b| (a.x, a.y) == (b.x, b.y)) {
            let its_band = usize::from(pixel[0].y).saturating_sub(MARGIN) / band_rows;
            (band..its_band).for_each(|_| law.finish_band());
            band = its_band;
            let mut responses = [None; MAX_PAIRS];
            pixel.iter().for_each(|record| responses[usize::from(record.scale)] = Some(record.response.into()));
            let is_sent = law.pixel(responses);
            sent.extend(pixel.iter().filter(|record| is_sent[usize::from(record.scale)]));
        }
        sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::features::feature::Descriptor;
    use proptest::prelude::*;

    const MAX: u32 = 32_767;

    fn feature(x: u16, y: u16, scale: u8, response: u16) -> FeatureRecord {
        let descriptor = Descriptor { maxlbp: [0; 3], sign: [0; 3] };
        FeatureRecord { x, y, response, scale, bright: false, neighbours: [0; 4], descriptor }
    }

    proptest! {
        #[test]
        fn no_more_than_the_limit_is_sent_and_the_order_stays(
            limit in 0u32..300, height in 64usize..400, thresholds in prop::array::uniform2(1u32..200),
            drawn in prop::collection::vec((18u16..382, 18u16..100, 0u8..2, 200u16..32_767), 0..1000),
        ) {
            let mut drawn: Vec<_> =
                drawn.into_iter().filter(|(y, ..)| usize::from(*y) < height - 18).collect();
            drawn.sort_unstable();
            drawn.dedup_by_key(|(y, x, scale, _)| (*y, *x, *scale));
            let features: Vec<_> = drawn.into_iter().map(|(y, x, scale, p)| feature(x, y, scale, p)).collect();
            let sent = RecordLimit::sent(limit, &thresholds, MAX, height, &features);
            prop_assert!(sent.len() <= limit as usize);
            let mut all = features.iter();
            prop_assert!(sent.iter().all(|record| all.any(|other| other == record)), "an ordered part");
            // The allowance of the first band is more than a 64th of the limit.
            prop_assert!(!sent.is_empty() || features.is_empty() || limit == 0);
            let generous = RecordLimit::sent(64 * 1000, &thresholds, MAX, height, &features);
            prop_assert_eq!(generous, features);
        }
    }

    #[test]
    fn the_law_is_that_of_the_specification() {
        // 131 = 63 * 2 + 5.
        let mut law = RecordLimit::new(131, &[100, 4], MAX);
        let none = [None; MAX_PAIRS];
        assert_eq!(law.pixel([Some(100), Some(4), None]), [true, true, false]);
        assert_eq!(law.pixel([Some(100), None, None]), [true, false, false]);
        assert_eq!(law.pixel([None, Some(9), None]), [false, true, false]);
        // One is left for two: the finer pair has it, and the gates rise to 126 and 6.
        assert_eq!(law.pixel([Some(500), Some(500), None]), [true, false, false]);
        law.finish_band();
        // 126 - 31 - 1 = 94 is below the threshold; 6 - 1 - 1 = 4 is the threshold.
        assert_eq!((law.left, law.gates[0], law.gates[1]), (2, 100, 4));
        assert_eq!(law.pixel([Some(100), Some(4), None]), [true, true, false]);
        assert_eq!(law.pixel([Some(100), None, None]), [false; 3]);
        assert_eq!((law.gates[0], law.gates[1]), (126, 6));
        // Below the gate nothing rises.
        assert_eq!(law.pixel([Some(125), None, None]), [false; 3]);
        assert_eq!(law.gates[0], 126);
        (0..100).for_each(|_| _ = law.pixel([Some(MAX), None, None]));
        assert_eq!(law.gates[0], MAX);
        law.finish_band();
        assert_eq!((law.gates[0], law.left), (24_575, 2));
        assert_eq!(law.pixel(none), [false; 3]);
        assert_eq!(law.pixel([Some(24_574), Some(MAX), None]), [false, true, false]);
    }

    #[test]
    fn a_crowd_at_the_top_leaves_room_for_the_rows_below() {
        // 40 a row over 164 rows; the strong ones are 1 in 8.
        let response = |i: usize| if i.is_multiple_of(8) { 3000 } else { 300 };
        let row = |y: u16| (0..40u16).map(move |i| feature(18 + 4 * i, y, 0, response(usize::from(i + y))));
        let features: Vec<_> = (18..182).flat_map(row).collect();
        let sent = RecordLimit::sent(1000, &[200, 200], MAX, 200, &features);
        let strong = sent.iter().filter(|record| record.response == 3000).count();
        assert!(sent.len() > 700 && strong > 500, "{} sent, {strong} strong", sent.len());
        for rows in [18..59, 59..100, 100..141, 141..182u16] {
            let part = sent.iter().filter(|record| rows.contains(&record.y)).count();
            assert!(part > 120, "{part} of {} from rows {rows:?}", sent.len());
        }
    }
}
