//! A deadline in counted work units, so that a search ends at the same place on every machine.
//!
//! One unit is the comparison of two descriptors; other work counts in proportion to its instructions. A clock would
//! end the search at a different place in each run.

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
}

impl Budget {
    /// A budget that is never exhausted.
    pub const UNLIMITED: Self = Self::new(u64::MAX);

    /// Returns a budget of `units`.
    pub const fn new(units: u64) -> Self {
        Self { given: units, left: units, refused: false }
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
}
