//! A deadline in counted work units, so that a search ends at the same place on every machine.
//!
//! One unit is at most [`UNIT_INSTRUCTIONS`] instructions of the flight program, about a comparison of two descriptors.
//! Every loop whose length depends on the input spends its units before it runs, so a budget bounds the instructions
//! of a frame by construction. A clock would end the search at a different place in each run.

/// Instructions of the Cortex-A9 in a unit, at most: `make bench-arm` counts them for each part of a frame.
pub const UNIT_INSTRUCTIONS: u64 = 12;

/// Work units of comparing a pair with a motion, from instruction counts on the ARM.
pub(crate) const PAIR_WORK: usize = 4;

/// Work units of fitting a sample, from instruction counts on the ARM.
pub(crate) const FIT_WORK: usize = 256;

/// The work units that remain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    given: u64,
    left: u64,
    refused: bool,
    late: bool,
}

impl Budget {
    /// A budget that is never exhausted.
    pub const UNLIMITED: Self = Self::new(u64::MAX);

    /// Returns a budget of `units`.
    pub const fn new(units: u64) -> Self {
        Self { given: units, left: units, refused: false, late: false }
    }

    /// Spends `units`, all of them or none. Returns `false` if they exceed what remains, and from then on always.
    pub fn spend(&mut self, units: usize) -> bool {
        match self.left.checked_sub(units as u64) {
            Some(left) if !self.refused => self.left = left,
            _ => self.refused = true,
        }
        !self.refused
    }

    /// Returns the units spent so far.
    pub fn spent(&self) -> u64 {
        self.given - self.left
    }

    /// Returns the units that remain; 0 once work was refused.
    pub fn left(&self) -> u64 {
        if self.refused { 0 } else { self.left }
    }

    /// Takes all but `reserved` units, or none if less remains, into a budget of their own: what comes first cannot
    /// spend what a later step needs. [`Budget::absorb`] returns them.
    pub fn split(&mut self, reserved: usize) -> Self {
        let part = self.left().saturating_sub(reserved as u64);
        self.left -= part;
        Self::new(part)
    }

    /// Takes back what is left of a budget that was split off. Refused work makes this one late.
    pub fn absorb(&mut self, part: Self) {
        self.left += part.left;
        self.late |= part.is_late();
    }

    /// Does work that may end early with what is left. Work that is refused in it does not make this budget late.
    pub fn optional<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let mut part = Self::new(self.left());
        let done = work(&mut part);
        self.left -= part.spent();
        done
    }

    /// Returns `true` once work was refused, to this budget or to one that it has absorbed.
    pub fn is_late(&self) -> bool {
        self.refused || self.late
    }

    /// Returns `true` once work was refused. All later work is refused too, so that small work does not continue after
    /// large work was refused.
    pub fn is_exhausted(&self) -> bool {
        self.refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refused_work_is_not_spent_and_later_work_is_refused_too() {
        let mut budget = Budget::new(10);
        assert!(budget.spend(6) && !budget.is_exhausted());
        assert!(!budget.spend(5));
        assert!(!budget.spend(1) && budget.is_exhausted());
        assert_eq!(budget.spent(), 6);
    }

    #[test]
    fn a_part_cannot_spend_what_is_reserved() {
        let mut budget = Budget::new(10);
        let mut part = budget.split(4);
        assert!(part.spend(5) && !part.spend(2));
        assert!(!budget.is_late());
        budget.absorb(part);
        assert_eq!((budget.spent(), budget.left()), (5, 5));
        assert!(budget.is_late() && !budget.is_exhausted() && budget.spend(5));
        assert_eq!(budget.split(1).left(), 0);
    }

    #[test]
    fn optional_work_that_is_refused_makes_nothing_late() {
        let mut budget = Budget::new(10);
        assert!(!budget.optional(|rest| rest.spend(4) && rest.spend(7)));
        assert!(!budget.is_late());
        assert_eq!((budget.spent(), budget.left()), (4, 6));
        assert!(budget.spend(6) && !budget.optional(|rest| rest.spend(1)) && !budget.is_late());
    }
}
