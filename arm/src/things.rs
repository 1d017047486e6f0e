//! Features of the reference that lie on things on the ground: on roofs, on trees, on cars that drive.
//!
//! ```text
//! on a thing:  off the plane in LEAST frames, and in more than one of OFTEN in which it was seen
//! ```
//!
//! A pose fit leaves out pairs whose error is not noise. From a place a few centimetres from the reference a roof moves
//! hardly otherwise than the ground does, and a fit takes it for ground. Ten pairs of a roof in a corner of the frame,
//! half a pixel off the ground, turn the plane by a tenth of a degree: 9 cm of displacement from 50 m, of which the
//! covariance knows nothing. Other frames were taken from further away, and saw that the same features are off the
//! plane. So frames are counted, for each feature of the reference.
//!
//! What the ground's plane is can turn out to be wrong; then all of it is forgotten.

use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::model::Pair;
use std::cmp::Ordering;

/// Frames off the plane that tell of a thing: one alone may be the noise of its place.
const LEAST: u32 = 3;

/// One in so many frames off the plane tells of a thing; noise brings one in 500.
const OFTEN: u32 = 8;

/// Of the pairs of a frame at most this part, two in five, are taken for things: those that were off the plane most
/// often. The others must show the ground.
const MOST: (usize, usize) = (2, 5);

/// After so many frames half of what they told is forgotten: a shadow that has moved on is known for half a minute.
const MEMORY: u32 = 512;

/// Work units of a pair: looked up, sorted, copied.
const PAIR_WORK: usize = 20;

/// Frames in which a feature was seen, and was off the plane.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    frames: u32,
    off: u32,
}

impl Seen {
    fn is_thing(self) -> bool {
        self.off >= LEAST && self.off * OFTEN > self.frames
    }

    fn learn(&mut self, off: bool) {
        if self.frames == MEMORY {
            (self.frames, self.off) = (self.frames / 2, self.off / 2);
        }
        self.frames += 1;
        self.off += u32::from(off);
    }

    /// By the part of frames off the plane.
    fn compared(self, other: Self) -> Ordering {
        (self.off * other.frames).cmp(&(other.off * self.frames))
    }
}

/// What is known of each feature of the reference.
pub struct Things {
    seen: Vec<Seen>,
    /// Those of the pairs that were sorted last, in their order.
    features: Vec<usize>,
    /// Those of them on things.
    things: Vec<(usize, Pair)>,
}

impl Things {
    /// For references of up to `features` features.
    pub fn with_capacity(features: usize) -> Self {
        Self {
            seen: vec![Seen::default(); features],
            features: Vec::with_capacity(features),
            things: Vec::with_capacity(features),
        }
    }

    /// Nothing is known: it is another reference, or another ground.
    pub fn forget(&mut self) {
        self.seen.fill(Seen::default());
    }

    /// Writes the pairs of a frame, each with the index of its feature in the reference, into `sorted`: at the end
    /// those on things. Tells how many these are.
    pub fn sort(
        &mut self,
        pairs: impl ExactSizeIterator<Item = (usize, Pair)>,
        budget: &mut Budget,
        sorted: &mut Vec<Pair>,
    ) -> usize {
        let Self { seen, features, things } = self;
        sorted.clear();
        features.clear();
        things.clear();
        let most = pairs.len() * MOST.0 / MOST.1;
        let affordable = budget.spend(PAIR_WORK * pairs.len());
        for (feature, pair) in pairs {
            if affordable && seen[feature].is_thing() {
                things.push((feature, pair));
            } else {
                features.push(feature);
                sorted.push(pair);
            }
        }
        // The order of equal ones is that of the features, so that it is the same on every machine.
        things.sort_unstable_by(|(a, _), (b, _)| seen[*a].compared(seen[*b]).then(a.cmp(b)));
        features.extend(things.iter().map(|(feature, _)| *feature));
        sorted.extend(things.iter().map(|(_, pair)| *pair));
        things.len().min(most)
    }

    /// Takes which of the pairs that were sorted last are off the plane; nothing where no plane was found.
    pub fn learn(&mut self, off: &[bool]) {
        for (&feature, &off) in self.features.iter().zip(off) {
            self.seen[feature].learn(off);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    const FEATURES: usize = 20;

    /// Frames that all see all features; `off` says which are off the plane in which frame.
    fn after(frames: u32, off: impl Fn(u32, usize) -> bool) -> Things {
        let mut things = Things::with_capacity(FEATURES);
        for frame in 0..frames {
            sorted(&mut things);
            let told: Vec<bool> = things.features.iter().map(|&feature| off(frame, feature)).collect();
            things.learn(&told);
        }
        things
    }

    /// Features in their order, and how many are on things.
    fn sorted(things: &mut Things) -> (Vec<usize>, usize) {
        let pair = |feature: usize| Pair { reference: Vector2::new(feature as f64, 0.0), current: Vector2::zeros() };
        let (mut budget, mut pairs) = (Budget::UNLIMITED, Vec::new());
        let found = things.sort((0..FEATURES).map(|i| (i, pair(i))), &mut budget, &mut pairs);
        let order: Vec<usize> = pairs.iter().map(|pair| pair.reference.x as usize).collect();
        assert_eq!(order, things.features);
        (order, found)
    }

    #[test]
    fn what_is_often_off_the_plane_is_a_thing() {
        // Feature 4 in each sixth frame, 7 in each ninth, 9 in two frames alone.
        let off = |frame: u32, feature: usize| match feature {
            4 => frame.is_multiple_of(6),
            7 => frame.is_multiple_of(9),
            9 => frame < 2,
            _ => false,
        };
        let (order, found) = sorted(&mut after(90, off));
        assert_eq!((found, order[FEATURES - 1]), (1, 4));
        assert!(order[..FEATURES - 1].is_sorted());
        assert_eq!(sorted(&mut after(2, off)).1, 0);
    }

    #[test]
    fn at_most_two_in_five_are_things_those_that_are_off_most_often() {
        // Two features in each frame, two in each second, and so on to each eighth.
        let (order, found) = sorted(&mut after(60, |frame, feature| frame.is_multiple_of(feature as u32 / 2 + 1)));
        assert_eq!(found, 8);
        assert_eq!(order[FEATURES - 8..], [6, 7, 4, 5, 2, 3, 0, 1]);
    }

    #[test]
    fn what_lies_on_the_ground_again_is_no_thing_any_more() {
        let shadow = |until: u32| after(until, |frame, feature| feature == 3 && frame < MEMORY);
        assert_eq!(sorted(&mut shadow(MEMORY)).1, 1);
        assert_eq!(sorted(&mut shadow(4 * MEMORY)).1, 0);
    }

    #[test]
    fn another_ground_is_learnt_anew() {
        let mut things = after(10, |_, feature| feature == 3);
        assert_eq!(sorted(&mut things).1, 1);
        things.forget();
        assert_eq!(sorted(&mut things).1, 0);
    }

    /// Where work is not left, pairs keep their order, and the fit after it is refused its work too.
    #[test]
    fn without_work_nothing_is_sorted() {
        let mut things = after(10, |_, feature| feature == 3);
        let (mut budget, mut pairs) = (Budget::new(10), Vec::new());
        let pair = Pair { reference: Vector2::zeros(), current: Vector2::zeros() };
        assert_eq!(things.sort((0..FEATURES).map(|i| (i, pair)), &mut budget, &mut pairs), 0);
        assert!(things.features.is_sorted() && budget.is_exhausted());
    }
}
