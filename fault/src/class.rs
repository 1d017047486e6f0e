//! What comes of a fault, counts of it, and their confidence intervals.

use serde::{Deserialize, Serialize};

/// What comes of a fault. Every run with a fault has exactly one class: the first of this list that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The run does not end as it should: something that must come does not come.
    Hang,
    /// Everything that comes out is as without the fault.
    Masked,
    /// Something is wrong, and what comes out says so.
    Detected,
    /// Something is wrong without a word, for no longer than a frame after the fault; then everything is right again.
    Recovered,
    /// Something is wrong without a word, and still is more than a frame after the fault.
    Silent,
}

impl Class {
    /// All classes, in the order of tables.
    pub const ALL: [Class; 5] = [Class::Masked, Class::Detected, Class::Recovered, Class::Silent, Class::Hang];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Class::Hang => "hang",
            Class::Masked => "masked",
            Class::Detected => "detected",
            Class::Recovered => "recovered",
            Class::Silent => "silent",
        }
    }
}

/// How many runs have each class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "one count for each class")]
pub struct Counts {
    pub masked: u64,
    pub detected: u64,
    pub recovered: u64,
    pub silent: u64,
    pub hang: u64,
}

impl Counts {
    /// Counts a run.
    pub fn add(&mut self, class: Class) {
        *match class {
            Class::Hang => &mut self.hang,
            Class::Masked => &mut self.masked,
            Class::Detected => &mut self.detected,
            Class::Recovered => &mut self.recovered,
            Class::Silent => &mut self.silent,
        } += 1;
    }

    /// Returns the runs of a class.
    pub fn of(&self, class: Class) -> u64 {
        match class {
            Class::Hang => self.hang,
            Class::Masked => self.masked,
            Class::Detected => self.detected,
            Class::Recovered => self.recovered,
            Class::Silent => self.silent,
        }
    }

    /// Returns the number of runs.
    pub fn total(&self) -> u64 {
        Class::ALL.iter().map(|class| self.of(*class)).sum()
    }

    /// Returns the runs in which anything comes out wrong.
    pub fn visible(&self) -> u64 {
        self.total() - self.masked
    }
}

impl FromIterator<Class> for Counts {
    fn from_iter<I: IntoIterator<Item = Class>>(classes: I) -> Self {
        let mut counts = Self::default();
        classes.into_iter().for_each(|class| counts.add(class));
        counts
    }
}

/// The 97.5th percentile of the normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// Returns the bounds of the 95 % confidence interval of a share of which `hits` of `of` were seen, by Wilson's score;
/// 0 to 1 for `of` 0.
pub fn wilson(hits: u64, of: u64) -> (f64, f64) {
    if of == 0 {
        return (0.0, 1.0);
    }
    let (n, p, z2) = (of as f64, hits as f64 / of as f64, Z_95 * Z_95);
    let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    // At the ends the two terms are equal but for rounding.
    let low = if hits == 0 { 0.0 } else { middle - half };
    let high = if hits == of { 1.0 } else { middle + half };
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn intervals_are_those_of_the_literature() {
        // Newcombe, Two-sided confidence intervals for the single proportion, 1998, table I, method 3.
        let expected =
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)];
        for (hits, of, low, high) in expected {
            let found = wilson(hits, of);
            assert!((found.0 - low).abs() < 5e-5 && (found.1 - high).abs() < 5e-5, "{hits} of {of}: {found:?}");
        }
        assert_eq!(wilson(0, 0), (0.0, 1.0));
        assert_eq!((wilson(0, 5).0, wilson(5, 5).1), (0.0, 1.0));
    }

    /// Returns the chance of `hits` of `of` for a share.
    fn binomial(hits: u64, of: u64, share: f64) -> f64 {
        let choose: f64 = (0..hits).map(|i| (of - i) as f64 / (i + 1) as f64).product();
        choose * share.powi(hits as i32) * (1.0 - share).powi((of - hits) as i32)
    }

    #[test]
    fn nineteen_intervals_of_twenty_have_the_share_in_them() {
        for share in [0.1, 0.3, 0.5] {
            let of = 60;
            let inside = |hits: &u64| (wilson(*hits, of).0..=wilson(*hits, of).1).contains(&share);
            let covered: f64 = (0..=of).filter(inside).map(|hits| binomial(hits, of, share)).sum();
            assert!((0.92..0.98).contains(&covered), "share {share}: {covered}");
        }
    }

    proptest! {
        #[test]
        fn an_interval_holds_what_was_seen(of in 1u64..5000, share in 0.0..=1.0f64) {
            let hits = (of as f64 * share) as u64;
            let (low, high) = wilson(hits, of);
            let seen = hits as f64 / of as f64;
            prop_assert!(0.0 <= low && low <= seen && seen <= high && high <= 1.0);
            let (wider_low, wider_high) = wilson(hits / 2, of / 2 + 1);
            prop_assert!(wider_high - wider_low > 0.7 * (high - low));
        }
    }

    #[test]
    fn counts_add_up() {
        let counts: Counts = Class::ALL.into_iter().chain([Class::Masked, Class::Silent]).collect();
        assert_eq!((counts.masked, counts.silent, counts.hang, counts.total(), counts.visible()), (2, 2, 1, 7, 5));
        assert!(Class::ALL.iter().all(|class| counts.of(*class) >= 1));
    }
}
