//! The automatic threshold: the thresholds of a frame from the responses in the frame before.
//!
//! For each scale pair alone, `T` is the threshold of the frame before, `N` the target, `B` the bits of a response and
//! `n` the number of features, the eligible maxima of at least `T`. All numbers are integers, divisions are shifts.
//!
//! ```text
//! F    = max(1, 2^B >> 10)                                           the lowest threshold that the law chooses
//! E(b) = b for b < 8, else (8 + b mod 8) << (b / 8 - 1)              edges of bins, eight an octave
//! c(b) = min(65535, eligible maxima with E(b) <= DOG < E(b + 1))     whether they reach T or not
//!
//! if 8 |n - N| <= N: T' = T, else
//!   add c(b) to C = 0, from the bin of 2^B - 1 down to that of F, until C >= N
//!   reached in bin b: i = c(b), s = C - N, q the number of j in 1, 2, 3 with 4 s >= j i
//!                     W = E(b) + ((E(b + 1) - E(b)) q >> 2)
//!   never reached:    W = F
//!   D  = T - (T >> 6) if 8 C < N, else T >> 3
//!   T' = max(W, D)
//! ```
//!
//! `W` would have met the target. `D` limits the step down: a frame with less than an eighth of the target shows that
//! the lens is covered, and not how strong the responses of the ground are.

use hoverlock_design::DesignPoint;
use hoverlock_reference::features::feature::MAX_PAIRS;

use crate::model::record::FeatureRecord;

/// Returns the lowest threshold that the law chooses, LSB of the DoG: 16 DN, above the read noise of a camera.
pub fn floor(design: &DesignPoint) -> u32 {
    ((1 << design.dog_bits) >> 10).max(1)
}

/// Most maxima that a bin counts.
const MAX_COUNT: u32 = 0xffff;

/// Returns the smallest response of a bin.
fn edge(bin: u32) -> u32 {
    if bin < 8 { bin } else { (8 + bin % 8) << (bin / 8 - 1) }
}

/// Returns the bin of a response of at least 1.
fn bin(response: u32) -> u32 {
    let octave = response.ilog2().saturating_sub(2);
    if octave == 0 { response } else { 8 * octave + ((response >> (octave - 1)) & 7) }
}

/// The responses of the eligible maxima of one scale pair in one frame, LSB of the DoG, rising.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Maxima(Vec<u16>);

impl Maxima {
    /// Collects responses of any order.
    pub fn new(mut responses: Vec<u16>) -> Self {
        responses.sort_unstable();
        Self(responses)
    }

    /// Returns the number of maxima of at least `response`.
    pub fn count(&self, response: u32) -> u32 {
        (self.0.len() - self.0.partition_point(|of| u32::from(*of) < response)) as u32
    }
}

/// The automatic thresholds `T_k`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ThresholdController {
    target: u32,
    max: u32,
    floor: u32,
    thresholds: Vec<u32>,
}

impl ThresholdController {
    /// Makes the controller of a design before its first frame.
    pub fn new(design: &DesignPoint) -> Self {
        Self {
            target: design.threshold.target,
            max: design.max_dog(),
            floor: floor(design),
            thresholds: vec![design.threshold.initial; design.pairs()],
        }
    }

    /// Makes the controller of a design after a frame with the thresholds `T_k`.
    pub fn resumed(design: &DesignPoint, thresholds: &[u32]) -> Self {
        Self { thresholds: thresholds.to_vec(), ..Self::new(design) }
    }

    /// Returns `T_k` of the frame about to start, LSB of the DoG.
    pub fn thresholds(&self) -> &[u32] {
        &self.thresholds
    }

    /// Makes the thresholds of the next frame. Call it once per frame: `maxima[k]` has the maxima of scale pair `k` in
    /// the frame just finished, at least those that reach [`floor`] or `T_k`.
    pub fn finish_frame(&mut self, maxima: &[Maxima]) {
        let next = |(threshold, maxima): (&u32, &Maxima)| self.next(*threshold, maxima);
        self.thresholds = self.thresholds.iter().zip(maxima).map(next).collect();
    }

    fn next(&self, threshold: u32, maxima: &Maxima) -> u32 {
        let (count, target) = (maxima.count(threshold), self.target);
        if 8 * count.abs_diff(target) <= target {
            return threshold;
        }
        let (mut wanted, mut sum) = (self.floor, 0);
        for bin in (bin(self.floor)..=bin(self.max)).rev() {
            let inside = (maxima.count(edge(bin)) - maxima.count(edge(bin + 1))).min(MAX_COUNT);
            sum += inside;
            if sum >= target {
                let surplus = sum - target;
                let quarters = (1..4).filter(|part| 4 * surplus >= part * inside).count() as u32;
                wanted = edge(bin) + (((edge(bin + 1) - edge(bin)) * quarters) >> 2);
                break;
            }
        }
        let lowest = if 8 * sum < target { threshold - (threshold >> 6) } else { threshold >> 3 };
        wanted.max(lowest)
    }

    /// Updates the thresholds until they no longer change, as for a camera that looks at one picture for a while.
    /// `maxima` are those of the picture that reach [`floor`] or the present thresholds.
    pub fn settle(&mut self, maxima: &[Maxima]) {
        for _ in 0..SETTLING {
            let before = self.thresholds.clone();
            self.finish_frame(maxima);
            if self.thresholds == before {
                break;
            }
        }
    }
}

/// Largest number of frames until thresholds settle: steps of a 64th lead from the largest to one that they no longer
/// change in fewer.
const SETTLING: usize = 1000;

/// Returns the number of features of each scale; 0 for scale pairs that the design does not have.
pub fn count_per_scale(features: &[FeatureRecord]) -> [u32; MAX_PAIRS] {
    let mut counts = [0; MAX_PAIRS];
    features.iter().for_each(|feature| counts[usize::from(feature.scale)] += 1);
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;
    use proptest::prelude::*;

    /// Responses of at least `at / 4`: as many reach a threshold as its inverse square, `count` of them reach `at`.
    fn falling(count: u32, at: u32) -> Maxima {
        let response = |i: u32| (f64::from(at) * (f64::from(count) / f64::from(i)).sqrt()) as u16;
        Maxima::new((1..=16 * count).map(response).collect())
    }

    fn controller(bits: u32, target: u32, threshold: u32) -> ThresholdController {
        let mut design = KT27.with_override(&format!("dog_bits={bits}")).unwrap();
        design.threshold.target = target;
        ThresholdController::resumed(&design, &[threshold])
    }

    fn after(mut controller: ThresholdController, maxima: &Maxima) -> u32 {
        controller.finish_frame(std::slice::from_ref(maxima));
        controller.thresholds()[0]
    }

    #[test]
    fn a_bin_starts_at_its_edge_and_ends_below_the_next() {
        for response in 1..=0xffff {
            let bin = bin(response);
            assert!((edge(bin)..edge(bin + 1)).contains(&response), "{response} in bin {bin}");
        }
        assert_eq!([edge(7), edge(8), edge(16), edge(24), edge(103)], [7, 8, 16, 32, 30_720]);
    }

    proptest! {
        #[test]
        fn thresholds_meet_the_target_within_a_quarter_of_a_bin_unless_the_step_is_limited(
            responses in prop::collection::vec(1u16..0x8000, 0..3000),
            threshold in 1u32..0x8000,
            target in 0u32..2500,
            bits in 4u32..=15,
        ) {
            let maxima = Maxima::new(responses.into_iter().map(|response| (response >> (15 - bits)).max(1)).collect());
            let threshold = (threshold >> (15 - bits)).max(1);
            let controller = controller(bits, target, threshold);
            let (floor, max) = (controller.floor, controller.max);
            let next = after(controller, &maxima);
            let count = maxima.count(threshold);
            if 8 * count.abs_diff(target) <= target {
                prop_assert_eq!(next, threshold);
                return Ok(());
            }
            prop_assert!((floor..=max).contains(&next) || next == threshold);
            let sum = maxima.count(floor);
            let lowest = if 8 * sum < target { threshold - (threshold >> 6) } else { threshold >> 3 };
            prop_assert!(next >= lowest);
            if next > lowest.max(floor) {
                // The whole bin has at least the target, and the bins above it have less.
                let bin = bin(next);
                prop_assert!(maxima.count(edge(bin)) >= target, "{} at the lower edge", maxima.count(edge(bin)));
                prop_assert!(target == 0 || maxima.count(edge(bin + 1)) < target, "all above the upper edge");
            }
        }
    }

    #[test]
    fn the_frame_after_a_change_has_the_target() {
        for (count, at) in [(512, 3000), (512, 400), (5000, 400), (90, 2000), (40_000, 33)] {
            let maxima = falling(count, at);
            let next = after(controller(15, 512, 2048), &maxima);
            let met = maxima.count(next).abs_diff(512) <= 512 * 15 / 100;
            assert!(met, "{count} from {at}: {} at {next}", maxima.count(next));
        }
    }

    #[test]
    fn steps_down_are_limited_and_hold_where_little_is_seen() {
        let weak = |count: usize| Maxima::new(vec![40; count]);
        // An eighth of the target is evidence, one less is not.
        assert_eq!(after(controller(15, 512, 2048), &weak(64)), 256);
        assert_eq!(after(controller(15, 512, 2048), &weak(63)), 2048 - 32);
        assert_eq!(after(controller(15, 512, 63), &weak(0)), 63);
        assert_eq!(after(controller(15, 512, 1), &weak(0)), 32, "the floor, from below it");
        // Maxima below the floor are noise: no evidence either.
        assert_eq!(after(controller(15, 512, 2048), &Maxima::new(vec![31; 5000])), 2048 - 32);
        assert_eq!(after(controller(15, 512, 100), &Maxima::new(vec![31; 5000])), 99);
    }

    #[test]
    fn a_count_within_an_eighth_of_the_target_holds_the_threshold() {
        for (count, holds) in [(447, false), (448, true), (576, true), (577, false)] {
            let mut responses = vec![5000; count];
            responses.extend([10_000; 7]);
            let next = after(controller(15, 512, 5000), &Maxima::new(responses.split_off(7)));
            assert_eq!(next == 5000, holds, "{count}: {next}");
        }
    }

    #[test]
    fn a_bin_is_divided_in_quarters() {
        // 100 in the bin from 8 << 7 = 1024 on, which is 128 wide: s = 100 - N.
        for (target, quarters) in [(100, 0), (76, 0), (75, 1), (51, 1), (50, 2), (26, 2), (25, 3), (1, 3)] {
            let next = after(controller(15, target, 1), &Maxima::new(vec![1100; 100]));
            // 1 holds nothing: 100 features are not within an eighth of these targets, except of 100 itself.
            let expected = if target == 100 { 1 } else { 1024 + 32 * quarters };
            assert_eq!(next, expected, "target {target}");
        }
    }

    #[test]
    fn a_bin_counts_to_65535() {
        // 70 000 would be a surplus of 10 000 of 70 000, less than a quarter; 65 535 of one of 5535.
        let next = after(controller(15, 49_000, 1), &Maxima::new(vec![1100; 70_000]));
        assert_eq!(next, 1024 + 32, "65535 - 49000 is more than a quarter of 65535 and less than half");
        let next = after(controller(15, 60_000, 1000), &Maxima::new(vec![1100; 140_000]));
        assert_eq!(next, 1024, "5535 is less than a quarter");
    }

    #[test]
    fn thresholds_settle_where_the_count_is_near_the_target() {
        let mut controller = ThresholdController::new(&KT27);
        let maxima = [falling(512, 300), Maxima::default()];
        controller.settle(&maxima);
        let now = controller.thresholds();
        assert!((448..=576).contains(&maxima[0].count(now[0])) && now[1] == 63, "{now:?}");
    }
}
