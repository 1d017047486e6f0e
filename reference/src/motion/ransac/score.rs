//! Score of a hypothesis: its voters, their squared errors, and the quality functional.

use crate::motion::model::{Pair, squared_error};
use crate::motion::ransac::RansacError;
use nalgebra::Matrix3;

/// A quality functional; see the [module](crate::motion::ransac) for the formulas.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Functional {
    /// Votes alone.
    Count,
    /// Votes plus `K` times the sum of the voters' squared errors, as usually printed. `K` in px^-2; `None` is the
    /// largest `K` allowed.
    Added(Option<f64>),
    /// Votes minus `K` times that sum.
    Subtracted(Option<f64>),
    /// Votes minus the sum over the largest squared error of a voter (MSAC).
    #[default]
    Msac,
}

impl Functional {
    /// Returns the factor of the sum of squared errors, with its sign, for `pairs` pairs and voters with `e^2 <
    /// max_squared_error` (px^2).
    ///
    /// # Errors
    /// A given `K` lets the second term exceed one vote.
    pub(super) fn factor(self, pairs: usize, max_squared_error: f64) -> Result<f64, RansacError> {
        let max_sum = pairs as f64 * max_squared_error;
        let checked = |k: Option<f64>| match k {
            None => Ok(1.0 / max_sum),
            // The negated comparison rejects NaN.
            Some(k) if !(k >= 0.0 && k * max_sum <= 1.0) => Err(RansacError::FactorTooLarge { k, max_sum }),
            Some(k) => Ok(k),
        };
        match self {
            Self::Count => Ok(0.0),
            Self::Added(k) => checked(k),
            Self::Subtracted(k) => checked(k).map(|k| -k),
            Self::Msac => Ok(-1.0 / max_squared_error),
        }
    }
}

/// The number of voters of a hypothesis and their squared errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Score {
    /// Number of pairs with `e^2 < max_squared_error`.
    pub(super) votes: usize,
    /// Sum of their `e^2`, px^2.
    pub(super) squared_errors: f64,
}

impl Score {
    /// Counts the voters under `h` and sums their squared errors.
    pub(super) fn of(h: &Matrix3<f64>, pairs: &[Pair], max_squared_error: f64) -> Self {
        let mut score = Self { votes: 0, squared_errors: 0.0 };
        for pair in pairs {
            let e2 = squared_error(h, pair);
            if e2 < max_squared_error {
                score.votes += 1;
                score.squared_errors += e2;
            }
        }
        score
    }
}

/// A motion with its score and the value of the functional.
pub(super) struct Hypothesis {
    pub(super) h: Matrix3<f64>,
    pub(super) score: Score,
    pub(super) functional: f64,
}

impl Hypothesis {
    /// Scores the motion `h`; `factor` is that of [`Functional::factor`].
    pub(super) fn of(h: Matrix3<f64>, pairs: &[Pair], max_squared_error: f64, factor: f64) -> Self {
        let score = Score::of(&h, pairs, max_squared_error);
        Self { h, score, functional: score.votes as f64 + factor * score.squared_errors }
    }
}
