//! The automatic threshold: each frame's thresholds from the number of features in the frame before.

use hoverlock_design::DesignPoint;
use hoverlock_reference::features::feature::MAX_PAIRS;

use crate::model::record::FeatureRecord;

/// The automatic thresholds `T_k`, updated from the feature counts of the last frame.
///
/// At the start of a frame, for each scale, with the count before drops: above `5 N / 4` `T += (T >> 3) + 1`, below `3
/// N / 4` `T = max(1, T - (T >> 3) - 1)`. `T` is at most the largest DoG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ThresholdController {
    target: u32,
    max: u32,
    thresholds: Vec<u32>,
}

impl ThresholdController {
    /// Makes the controller of a design before its first frame.
    pub fn new(design: &DesignPoint) -> Self {
        Self {
            target: design.threshold.target,
            max: design.max_dog(),
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

    /// Moves each threshold by at most one step. Call it once per frame: `counts[k]` is the number of features of scale
    /// pair `k` in the frame just finished, before drops.
    pub fn finish_frame(&mut self, counts: &[u32]) {
        for (threshold, count) in self.thresholds.iter_mut().zip(counts) {
            let (count, target) = (u64::from(*count), u64::from(self.target));
            let step = (*threshold >> 3) + 1;
            if 4 * count > 5 * target {
                *threshold = (*threshold + step).min(self.max);
            } else if 4 * count < 3 * target {
                *threshold = threshold.saturating_sub(step).max(1);
            }
        }
    }

    /// Updates the thresholds until they no longer change, as for a camera that looks at one picture for a while.
    /// `counts` returns the number of features of each scale in that picture at given thresholds.
    pub fn settle(&mut self, mut counts: impl FnMut(&[u32]) -> [u32; MAX_PAIRS]) {
        for _ in 0..SETTLING {
            let before = self.thresholds.clone();
            self.finish_frame(&counts(&before));
            if self.thresholds == before {
                break;
            }
        }
    }
}

/// Largest number of frames until thresholds settle: steps of an eighth lead from one end of their range to the other
/// in fewer.
const SETTLING: usize = 100;

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

    proptest! {
        #[test]
        fn thresholds_stay_in_range_and_rise_with_too_many_features(
            counts in prop::collection::vec(0u32..3000, 1..200),
        ) {
            let mut controller = ThresholdController::new(&KT27);
            for count in counts {
                let before = controller.thresholds()[0];
                controller.finish_frame(&[count, 512]);
                let [after, other] = *controller.thresholds() else { panic!("two scale pairs") };
                prop_assert!((1..=KT27.max_dog()).contains(&after));
                // 640 = 5/4 of 512, 384 = 3/4: neither is beyond its limit.
                match count {
                    641.. => prop_assert!(after > before || before == KT27.max_dog()),
                    ..384 => prop_assert!(after < before || before == 1),
                    _ => prop_assert_eq!(after, before),
                }
                prop_assert_eq!(other, KT27.threshold.initial, "the scales are independent");
            }
        }
    }

    #[test]
    fn thresholds_settle_where_the_count_is_near_the_target() {
        let mut controller = ThresholdController::new(&KT27);
        let mut asked = 0;
        // 512 features at a threshold of 300; none ever at the other scale.
        let counts = |thresholds: &[u32]| [512 * 300 / thresholds[0], 0, 0];
        controller.settle(|thresholds| {
            asked += 1;
            counts(thresholds)
        });
        let now = controller.thresholds();
        assert!((384..=640).contains(&counts(now)[0]) && now[1] == 1, "{now:?}");
        assert!(asked < SETTLING, "{asked} frames");
        controller.settle(|_| [u32::MAX, 512, 0]);
        assert_eq!(controller.thresholds(), [32767, 1]);
    }

    #[test]
    fn threshold_steps_are_those_of_the_specification() {
        let mut controller = ThresholdController::new(&KT27);
        assert_eq!(controller.thresholds(), [2048, 2048]);
        controller.finish_frame(&[641, 383]);
        assert_eq!(controller.thresholds(), [2048 + 257, 2048 - 257]);
        controller.finish_frame(&[640, 384]);
        assert_eq!(controller.thresholds(), [2048 + 257, 2048 - 257]);
        for _ in 0..100 {
            controller.finish_frame(&[u32::MAX, 0]);
        }
        assert_eq!(controller.thresholds(), [32767, 1]);
    }
}
