//! By how much innovations and residuals contradict the covariance of the filter.

/// Factors of standard errors, each at least 1.
///
/// What the residuals of a block of the picture have in common bounds the error, and most of it is relief whose height
/// the filter has considered: errors grow with its square root on the mean (decision 063).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inconsistency {
    /// Of what no error may exceed: the protection level.
    pub of_bound: f64,
    /// Of what errors are on the mean: the covariance.
    pub of_mean: f64,
}

impl Inconsistency {
    /// No contradiction.
    pub const NONE: Self = Self { of_bound: 1.0, of_mean: 1.0 };

    /// Returns the factors of a variance that innovations demand, and of one that residuals in common do.
    pub(super) fn new(innovations: f64, common: f64) -> Self {
        Self { of_bound: (innovations * common).sqrt(), of_mean: (innovations * common.sqrt()).sqrt() }
    }

    /// Returns the larger of each of two factors.
    pub fn max(self, other: Self) -> Self {
        Self { of_bound: self.of_bound.max(other.of_bound), of_mean: self.of_mean.max(other.of_mean) }
    }

    /// Returns the smaller of each of two factors.
    pub fn min(self, other: Self) -> Self {
        Self { of_bound: self.of_bound.min(other.of_bound), of_mean: self.of_mean.min(other.of_mean) }
    }

    /// Returns the factors, each at most `limit`.
    pub fn limited(self, limit: f64) -> Self {
        self.min(Self { of_bound: limit, of_mean: limit })
    }
}
