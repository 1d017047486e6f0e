//! A mask of the reference features that are not on the ground plane: on roofs, in trees, on moving cars.
//!
//! ```text
//! masked:  off the plane in at least MIN_OFF_PLANE_FRAMES frames, and in more than OFF_PLANE_FRACTION of all frames
//! ```
//!
//! A pose fit rejects pairs whose residual is too large for noise. From a few centimetres beside the reference a roof
//! moves almost as the ground does, so the fit accepts its pairs as ground. Ten pairs of a roof in a corner of the
//! frame, half a pixel off the ground, tilt the plane by a tenth of a degree: 9 cm of displacement from 50 m, which the
//! covariance does not include. Frames taken from further away have rejected the same features. So the mask counts, for
//! each feature of the reference, the frames in which the fit rejected it.
//!
//! If the estimate of the ground plane itself turns out to be wrong, all counts are cleared.

use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::model::Pair;
use std::cmp::Ordering;

/// Frames off the plane before a feature can be masked: a single one may be image noise.
const MIN_OFF_PLANE_FRAMES: u32 = 3;

/// Numerator and denominator of the share of frames off the plane above which a feature is masked: more than one frame
/// in eight. Image noise alone causes one in 500.
const OFF_PLANE_FRACTION: (u32, u32) = (1, 8);

/// Numerator and denominator of the largest share of a frame's pairs that is masked, those most often off the plane
/// first: two in five. The fit needs the others.
const MAX_MASKED_FRACTION: (usize, usize) = (2, 5);

/// Both counts of a feature are halved when it has been seen in this many frames, so that a shadow that has moved on
/// is unmasked after half a minute.
const HALVE_COUNTS_AFTER_FRAMES: u32 = 512;

/// Work units to look up, sort and copy one pair.
const PAIR_WORK: usize = 20;

/// The frames in which one feature of the reference was matched.
#[derive(Debug, Clone, Copy, Default)]
struct FrameCounts {
    matched: u32,
    /// Frames whose fit rejected the feature.
    off_plane: u32,
}

impl FrameCounts {
    fn is_off_plane(self) -> bool {
        let (numerator, denominator) = OFF_PLANE_FRACTION;
        self.off_plane >= MIN_OFF_PLANE_FRAMES && self.off_plane * denominator > self.matched * numerator
    }

    fn add_frame(&mut self, off_plane: bool) {
        if self.matched == HALVE_COUNTS_AFTER_FRAMES {
            (self.matched, self.off_plane) = (self.matched / 2, self.off_plane / 2);
        }
        self.matched += 1;
        self.off_plane += u32::from(off_plane);
    }

    /// Compares the share of frames off the plane, in integers.
    fn cmp_off_plane_rate(self, other: Self) -> Ordering {
        (self.off_plane * other.matched).cmp(&(other.off_plane * self.matched))
    }
}

/// The frame counts of every feature of the reference, and the pairs of the last frame sorted by them.
pub struct OffPlaneMask {
    /// By the index of the feature in the reference.
    counts: Vec<FrameCounts>,
    /// Feature of each pair, in the order of the last call to [`OffPlaneMask::sort`].
    sorted_features: Vec<usize>,
    /// Scratch memory of [`OffPlaneMask::sort`].
    masked: Vec<(usize, Pair)>,
}

impl OffPlaneMask {
    /// Allocates an empty mask for references of up to `features` features.
    pub fn with_capacity(features: usize) -> Self {
        Self {
            counts: vec![FrameCounts::default(); features],
            sorted_features: Vec::with_capacity(features),
            masked: Vec::with_capacity(features),
        }
    }

    /// Clears all counts. Call it when the reference or the ground plane has been replaced.
    pub fn clear(&mut self) {
        self.counts.fill(FrameCounts::default());
    }

    /// Writes the pairs of a frame, each given with the index of its feature in the reference, into `sorted`, masked
    /// pairs last. Returns how many at the end of `sorted` are masked: at most two in five. Without enough work left
    /// in `budget` no pair is masked.
    pub fn sort(
        &mut self,
        pairs: impl ExactSizeIterator<Item = (usize, Pair)>,
        budget: &mut Budget,
        sorted: &mut Vec<Pair>,
    ) -> usize {
        let Self { counts, sorted_features, masked } = self;
        sorted.clear();
        sorted_features.clear();
        masked.clear();
        let max_masked = pairs.len() * MAX_MASKED_FRACTION.0 / MAX_MASKED_FRACTION.1;
        let affordable = budget.spend(PAIR_WORK * pairs.len());
        for (feature, pair) in pairs {
            if affordable && counts[feature].is_off_plane() {
                masked.push((feature, pair));
            } else {
                sorted_features.push(feature);
                sorted.push(pair);
            }
        }
        // Features with equal rates stay in their order, so that the result is the same on every machine.
        masked.sort_unstable_by(|(a, _), (b, _)| counts[*a].cmp_off_plane_rate(counts[*b]).then(a.cmp(b)));
        sorted_features.extend(masked.iter().map(|(feature, _)| *feature));
        sorted.extend(masked.iter().map(|(_, pair)| *pair));
        masked.len().min(max_masked)
    }

    /// Updates the counts. `off_plane[i]` refers to pair `i` of the last call to [`OffPlaneMask::sort`]. Pass an empty
    /// slice if no plane was fitted.
    pub fn update(&mut self, off_plane: &[bool]) {
        for (&feature, &off_plane) in self.sorted_features.iter().zip(off_plane) {
            self.counts[feature].add_frame(off_plane);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    const FEATURES: usize = 20;

    /// Returns the mask after `frames` frames that match all features; `off_plane` takes frame and feature.
    fn mask_after(frames: u32, off_plane: impl Fn(u32, usize) -> bool) -> OffPlaneMask {
        let mut mask = OffPlaneMask::with_capacity(FEATURES);
        for frame in 0..frames {
            sort(&mut mask);
            let rejected: Vec<bool> = mask.sorted_features.iter().map(|&feature| off_plane(frame, feature)).collect();
            mask.update(&rejected);
        }
        mask
    }

    /// Returns the features in sorted order, and how many are masked.
    fn sort(mask: &mut OffPlaneMask) -> (Vec<usize>, usize) {
        let pair = |feature: usize| Pair { reference: Vector2::new(feature as f64, 0.0), current: Vector2::zeros() };
        let (mut budget, mut pairs) = (Budget::UNLIMITED, Vec::new());
        let masked = mask.sort((0..FEATURES).map(|i| (i, pair(i))), &mut budget, &mut pairs);
        let order: Vec<usize> = pairs.iter().map(|pair| pair.reference.x as usize).collect();
        assert_eq!(order, mask.sorted_features);
        (order, masked)
    }

    #[test]
    fn a_feature_that_is_often_off_the_plane_is_masked() {
        // Feature 4 in each sixth frame, 7 in each ninth, 9 in two frames alone.
        let off_plane = |frame: u32, feature: usize| match feature {
            4 => frame.is_multiple_of(6),
            7 => frame.is_multiple_of(9),
            9 => frame < 2,
            _ => false,
        };
        let (order, masked) = sort(&mut mask_after(90, off_plane));
        assert_eq!((masked, order[FEATURES - 1]), (1, 4));
        assert!(order[..FEATURES - 1].is_sorted());
        assert_eq!(sort(&mut mask_after(2, off_plane)).1, 0);
    }

    #[test]
    fn at_most_two_in_five_are_masked_those_most_often_off_the_plane() {
        // Two features in each frame, two in each second, and so on to each eighth.
        let (order, masked) = sort(&mut mask_after(60, |frame, feature| frame.is_multiple_of(feature as u32 / 2 + 1)));
        assert_eq!(masked, 8);
        assert_eq!(order[FEATURES - 8..], [6, 7, 4, 5, 2, 3, 0, 1]);
    }

    #[test]
    fn a_feature_that_is_on_the_plane_again_is_unmasked() {
        const N: u32 = HALVE_COUNTS_AFTER_FRAMES;
        let shadow = |until: u32| mask_after(until, |frame, feature| feature == 3 && frame < N);
        assert_eq!(sort(&mut shadow(N)).1, 1);
        assert_eq!(sort(&mut shadow(4 * N)).1, 0);
    }

    #[test]
    fn a_cleared_mask_masks_nothing() {
        let mut mask = mask_after(10, |_, feature| feature == 3);
        assert_eq!(sort(&mut mask).1, 1);
        mask.clear();
        assert_eq!(sort(&mut mask).1, 0);
    }

    /// Without work left, pairs keep their order; the fit that follows is refused its work, too.
    #[test]
    fn without_work_nothing_is_sorted() {
        let mut mask = mask_after(10, |_, feature| feature == 3);
        let (mut budget, mut pairs) = (Budget::new(10), Vec::new());
        let pair = Pair { reference: Vector2::zeros(), current: Vector2::zeros() };
        assert_eq!(mask.sort((0..FEATURES).map(|i| (i, pair)), &mut budget, &mut pairs), 0);
        assert!(mask.sorted_features.is_sorted() && budget.is_exhausted());
    }
}
