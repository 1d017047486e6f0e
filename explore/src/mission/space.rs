//! The keys that the search changes, their values, and how values are combined.
//!
//! Keys are the pixel with the state, whose integer bits are those of the pixel, the DoG, the coefficients and the
//! look-ahead. `candidate_queue` and `record_fifo` are no keys: the bit-true model has no queues that could overflow,
//! so a flight would not show what a shorter one loses, and down to 64 entries none saves a block. No resource follows
//! `threshold_target`.

use hoverlock_design::{DesignPoint, Format};
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_reports::sweep::with_dog_bits;

use crate::space::Unbuildable;

/// Fewest bits of the pixel.
const MIN_PIXEL_BITS: u32 = 8;
/// Fewest bits of the DoG magnitude.
const MIN_DOG_BITS: u32 = 6;
/// Fewest fraction bits of the coefficients.
const MIN_COEFFICIENT_BITS: i8 = 6;
/// Shortest look-ahead of a smoother, stages.
const MIN_LOOK_AHEAD: u32 = 2;

/// The quantities by which designs are compared: M10K, DSP blocks, ALM.
pub(super) fn cost(design: &DesignPoint) -> [u64; 3] {
    let Resources { m10k, alm, dsp, .. } = resources(design);
    [m10k, dsp, alm]
}

/// Values of the keys: each is a change of a design.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Change {
    /// Pixel and state.
    Sample(Format, Format),
    /// Bits of the DoG magnitude.
    Dog(u32),
    /// Format of the coefficients.
    Coefficient(Format),
    /// Look-ahead of all smoothers.
    LookAhead(Vec<u32>),
}

impl Change {
    /// Returns a design with this value.
    pub(super) fn apply(&self, design: &DesignPoint) -> DesignPoint {
        match self {
            Self::Sample(pixel, state) => DesignPoint { pixel: *pixel, state: *state, ..design.clone() },
            Self::Dog(bits) => with_dog_bits(design, *bits),
            Self::Coefficient(coefficient) => DesignPoint { coefficient: *coefficient, ..design.clone() },
            Self::LookAhead(look_ahead) => DesignPoint { look_ahead: look_ahead.clone(), ..design.clone() },
        }
    }
}

/// Returns a pixel of some bits, and a state of others.
fn sample(pixel: u32, state: u32) -> Change {
    let integer = pixel as i8;
    Change::Sample(Format::unsigned(integer, 0), Format::unsigned(integer, (state - pixel) as i8))
}

/// Returns the values of each key that are shorter than that of the base: pixel with state, DoG, coefficients,
/// look-ahead.
pub(super) fn values(base: &DesignPoint) -> [Vec<Change>; 4] {
    let (pixel, state) = (base.pixel.bits(), base.state.bits());
    let mut samples = Vec::new();
    for bits in (MIN_PIXEL_BITS.min(pixel)..=pixel).rev().step_by(2) {
        let mut states: Vec<u32> = (bits..=state).step_by(2).collect();
        if bits == pixel {
            states.extend(bits..=state);
        }
        states.push(state);
        states.sort_unstable();
        states.dedup();
        samples.extend(states.into_iter().map(|state| sample(bits, state)));
    }
    samples.retain(|change| change.apply(base) != *base);
    let dogs = (MIN_DOG_BITS..base.dog_bits).map(Change::Dog).collect();
    let fraction = base.coefficient.fraction_bits();
    let coefficients = (MIN_COEFFICIENT_BITS..fraction).rev().skip(1).step_by(2);
    let coefficients = coefficients.map(|bits| Change::Coefficient(Format::unsigned(0, bits))).collect();
    [samples, dogs, coefficients, look_aheads(base).into_iter().map(Change::LookAhead).collect()]
}

/// Returns the look-aheads that are shorter by as many stages for all smoothers, and those of equal smoothers.
fn look_aheads(base: &DesignPoint) -> Vec<Vec<u32>> {
    let longest = base.look_ahead.iter().copied().max().unwrap_or(MIN_LOOK_AHEAD);
    let shorter = |less: u32| base.look_ahead.iter().map(|m| m.saturating_sub(less).max(MIN_LOOK_AHEAD)).collect();
    let equal = |stages: u32| base.look_ahead.iter().map(|m| stages.min(*m)).collect();
    let mut all: Vec<Vec<u32>> = (1..longest)
        .map(shorter)
        .chain((MIN_LOOK_AHEAD..longest).map(equal))
        .filter(|m| *m != base.look_ahead)
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Returns the design with one value changed. The DoG is shortened as far as it must be; `None` if that does not help.
pub(super) fn alone(base: &DesignPoint, change: &Change, unbuildable: Unbuildable) -> Option<DesignPoint> {
    let design = change.apply(base);
    let with = |bits: u32| if bits == design.dog_bits { design.clone() } else { with_dog_bits(&design, bits) };
    (MIN_DOG_BITS..=design.dog_bits).rev().map(with).find(|design| unbuildable(design).is_none())
}

/// A combination of values, with the distance that is predicted for it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Combination {
    pub design: DesignPoint,
    pub predicted_cm: f64,
}

/// Combines values of all keys. Each list has the values of a key with the distance (cm) flown with this value alone;
/// the value of the base is added. The increases of the squared distance over that of the base (`base_cm`) add up.
pub(super) fn combinations(
    base: &DesignPoint,
    base_cm: f64,
    flown: &[Vec<(Change, f64)>],
    unbuildable: Unbuildable,
) -> Vec<Combination> {
    let mut all = vec![(base.clone(), base_cm * base_cm)];
    for values in flown {
        let with = |(design, square): &(DesignPoint, f64)| {
            let of =
                |(change, cm): &(Change, f64)| (change.apply(design), square + (cm * cm - base_cm * base_cm).max(0.0));
            values.iter().map(of).collect::<Vec<_>>()
        };
        let more: Vec<(DesignPoint, f64)> = all.iter().flat_map(with).collect();
        all.extend(more);
    }
    let buildable = all.into_iter().filter(|(design, _)| design != base && unbuildable(design).is_none());
    buildable.map(|(design, square)| Combination { design, predicted_cm: square.sqrt() }).collect()
}

/// Returns at most `count` of the combinations than which no other is both cheaper and predicted closer, the cheapest
/// first. They are spread evenly.
pub(super) fn front(mut all: Vec<Combination>, count: usize) -> Vec<Combination> {
    // The bits of numbers that are not negative have their order.
    all.sort_by_cached_key(|one| (cost(&one.design), one.predicted_cm.to_bits()));
    let mut closest = f64::INFINITY;
    all.retain(|one| {
        let better = one.predicted_cm < closest;
        closest = closest.min(one.predicted_cm);
        better
    });
    let last = all.len().saturating_sub(1);
    let mut picked: Vec<usize> = (0..count).map(|i| i * last / count.saturating_sub(1).max(1)).collect();
    picked.dedup();
    picked.into_iter().filter_map(|index| all.get(index).cloned()).collect()
}

/// Returns every cheaper design that can be built and differs from `design` in one key: pixel, state, both by as many
/// bits, DoG, coefficients, or the look-ahead of one smoother.
pub(super) fn steps(design: &DesignPoint, unbuildable: Unbuildable) -> Vec<DesignPoint> {
    let (pixel, state, fraction) = (design.pixel.bits(), design.state.bits(), design.coefficient.fraction_bits());
    let mut changes: Vec<Change> = Vec::new();
    for bits in MIN_PIXEL_BITS..pixel {
        changes.extend([sample(bits, state), sample(bits, state - (pixel - bits))]);
    }
    changes.extend((pixel..state).map(|state| sample(pixel, state)));
    changes.extend((MIN_DOG_BITS..design.dog_bits).map(Change::Dog));
    changes.extend((MIN_COEFFICIENT_BITS..fraction).map(|bits| Change::Coefficient(Format::unsigned(0, bits))));
    for (smoother, &stages) in design.look_ahead.iter().enumerate() {
        changes.extend((MIN_LOOK_AHEAD..stages).map(|stages| {
            let mut look_ahead = design.look_ahead.clone();
            look_ahead[smoother] = stages;
            Change::LookAhead(look_ahead)
        }));
    }
    let mut found: Vec<DesignPoint> = Vec::new();
    for changed in changes.iter().map(|change| change.apply(design)) {
        if cost(&changed) < cost(design) && unbuildable(&changed).is_none() && !found.contains(&changed) {
            found.push(changed);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    fn unbuildable(design: &DesignPoint) -> Option<String> {
        design.check_buildable().err().map(|error| error.to_string())
    }

    #[test]
    fn every_value_can_be_built_alone_and_differs_from_the_base() {
        let values = values(&KT27);
        assert!(values.iter().all(|values| values.len() > 3), "{values:?}");
        for change in values.iter().flatten() {
            let design = alone(&KT27, change, &unbuildable).unwrap();
            assert!(design != *KT27 && unbuildable(&design).is_none());
            assert!(cost(&design) < cost(&KT27) || matches!(change, Change::Sample(..)), "{design:?}");
        }
        // A state of 16 bits has no finer LSB than a DoG of 14 bits.
        let short = alone(&KT27, &sample(16, 16), &unbuildable).unwrap();
        assert_eq!((short.dog_bits, short.threshold.initial), (14, 1024));
    }

    #[test]
    fn predicted_increases_add_up_and_the_front_rises_in_cost_and_falls_in_distance() {
        let flown = [
            vec![(Change::Dog(8), 5.0), (Change::Dog(6), 8.0)],
            vec![(Change::LookAhead(vec![4, 4, 5]), 2.0), (Change::LookAhead(vec![2, 2, 2]), 6.0)],
        ];
        let all = combinations(&KT27, 3.0, &flown, &unbuildable);
        assert_eq!(all.len(), 8);
        let of = |dog: u32, look_ahead: &[u32]| {
            all.iter().find(|c| c.design.dog_bits == dog && c.design.look_ahead == look_ahead).unwrap().predicted_cm
        };
        // 9 + (25 - 9) + (36 - 9), and a value that flew closer than the base promises nothing.
        assert!((of(8, &[2, 2, 2]) - 52f64.sqrt()).abs() < 1e-12 && (of(8, &[4, 4, 5]) - 5.0).abs() < 1e-12);
        let front = front(all, 100);
        assert!(front.len() > 2);
        assert!(front.windows(2).all(|two| cost(&two[0].design) < cost(&two[1].design)));
        assert!(front.windows(2).all(|two| two[0].predicted_cm > two[1].predicted_cm));
        assert_eq!((front[0].design.dog_bits, &front[0].design.look_ahead[..]), (6, &[2, 2, 2][..]));
        assert_eq!(super::front(front.clone(), 2), [front[0].clone(), front[front.len() - 1].clone()]);
    }

    #[test]
    fn steps_are_cheaper_in_one_key() {
        let steps = steps(&KT27, &unbuildable);
        for step in &steps {
            let sample = (step.pixel, step.state) != (KT27.pixel, KT27.state);
            let differ = [
                sample,
                step.dog_bits != KT27.dog_bits,
                step.coefficient != KT27.coefficient,
                step.look_ahead != KT27.look_ahead,
            ];
            assert_eq!(differ.into_iter().filter(|differs| *differs).count(), 1, "{step:?}");
            assert!(cost(step) < cost(&KT27));
        }
        assert!(steps.iter().any(|step| step.look_ahead == [5, 5, 5]));
    }

    /// Why the queues are no keys: see the text of this module.
    #[test]
    fn shorter_queues_save_no_block() {
        for change in ["candidate_queue=64", "record_fifo=64"] {
            assert_eq!(cost(&KT27.with_override(change).unwrap())[0], cost(&KT27)[0], "{change}");
        }
    }
}
