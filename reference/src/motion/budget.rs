//! Work units: a deadline that is counted, so that it ends a search at the same place on every machine.
//!
//! One unit is the comparison of two descriptors; other work counts as many as it costs. A clock would end the search
//! elsewhere in each run.

/// Work that may still be done, in units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    given: u64,
    left: u64,
    refused: bool,
}

impl Budget {
    /// No deadline.
    pub const UNLIMITED: Self = Self::new(u64::MAX);

    /// `units` of work.
    pub const fn new(units: u64) -> Self {
        Self { given: units, left: units, refused: false }
    }

    /// Takes `units`, all of them or none: whether there were enough.
    pub fn spend(&mut self, units: usize) -> bool {
        match self.left.checked_sub(units as u64) {
            Some(left) if !self.refused => self.left = left,
            _ => self.refused = true,
        }
        !self.refused
    }

    /// Units taken so far.
    pub fn spent(&self) -> u64 {
        self.given - self.left
    }

    /// Whether work was refused. From then on all is, so that small work cannot go on where large work was refused.
    pub fn is_exhausted(&self) -> bool {
        self.refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_refused_whole_and_for_good() {
        let mut budget = Budget::new(10);
        assert!(budget.spend(6) && !budget.is_exhausted());
        assert!(!budget.spend(5));
        assert!(!budget.spend(1) && budget.is_exhausted());
        assert_eq!(budget.spent(), 6);
    }
}
