//! RANSAC with a quality functional that includes the residuals: `Q(H) = sum [e^2 < E] -+ K sum e^2`, both sums over
//! the pairs with `e^2 < E`.
//!
//! `e^2 = |p' - H p|^2` is the squared transfer error of a pair (px^2), `E` the squared radius within which a pair
//! votes ([`Ransac::max_squared_error`], px^2). The second term decides between hypotheses of equal votes, so `K *
//! sum(e^2) <= 1` is required for every possible sum. With `n` pairs the largest sum is `n E`, so `K` is at most
//! `1 / (n E)`, its default. The functionals:
//!
//! | name | second term | remark |
//! |---|---|---|
//! | count | none | Fischler and Bolles, 1981 |
//! | added | `+ K sum e^2` | as usually published; of two hypotheses with equal votes it selects the worse |
//! | subtracted | `- K sum e^2` | the intended functional |
//! | MSAC | `- sum e^2 / E` | each vote counts `1 - e^2 / E`, Torr and Zisserman, 2000 |
//!
//! The sums must not include outliers: their errors are larger by orders of magnitude and independent of the
//! hypothesis.
//!
//! Each new best hypothesis is improved by rounds of least squares on its own inliers (local optimisation, Chum, Matas
//! and Kittler, 2003), after which the result hardly depends on `E`. Samples are drawn best match first (PROSAC, Chum
//! and Matas, 2005). Sampling stops when the confidence is reached: with the fraction `w` of voters of the best
//! hypothesis, the probability that no sample was free of outliers, `(1 - w^m)^samples`, is below one minus the
//! confidence. This formula holds for samples of all pairs, so every other sample is drawn from all of them: the first
//! pairs of a list in raster order are neighbours, and samples of neighbours fail together.
//!
//! The best hypothesis of the search is then refitted by the module `robust`, unless local optimisation is off.
//!
//! **No estimate.** A few pairs always determine a model, and other pairs agree with it by chance. If all `n` matches
//! are wrong, and each position in CUR is therefore a random feature position, one more pair agrees with the model of a
//! sample of `m` with probability `alpha`, and the expected number of samples with `k` or more voters is (Moisan and
//! Stival, 2004, without their search over `E`)
//!
//! `NFA = C(n, m) sum_{j >= k - m} C(n - m, j) alpha^j (1 - alpha)^(n - m - j)`.
//!
//! It counts every sample that could be drawn, so it is a bound for a search of any length. There is an estimate if
//! `NFA` is at most 1e-8. Its quality 0 ..= 255 is `floor(-log10 NFA)`: such agreement occurs by chance less than once
//! in 10^quality pictures. 0 means no estimate. `alpha` is measured from the positions, because features are not
//! uniformly distributed: the fraction of all pairs of positions in CUR that are less than 32 px apart, scaled by area
//! to `E`; within a gate, at least `E / radius^2`.

mod chance;
mod sampler;
mod score;

use crate::motion::budget::{Budget, FIT_WORK, PAIR_WORK};
use crate::motion::model::{Model, Pair, squared_error};
use crate::motion::refusal::Refusal;
use crate::motion::robust::{self, RefitBuffers};
use chance::{MAX_NFA, agreement_probability, by_chance, log10_nfa};
use nalgebra::Matrix3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
pub use sampler::Order;
use sampler::Sampler;
pub use score::Functional;
use score::{Hypothesis, Score};

/// The settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ransac {
    /// Motion model.
    pub model: Model,
    /// Quality functional.
    pub functional: Functional,
    /// Squared radius within which a pair votes, px^2.
    pub max_squared_error: f64,
    /// Rounds of least squares on the inliers of a new best hypothesis; 0 leaves it as drawn, and skips the last fit.
    pub local_optimisation_rounds: usize,
    /// Order of the samples.
    pub order: Order,
    /// Largest number of samples, at least 1.
    pub max_samples: usize,
    /// Probability that at least one sample is free of outliers when the search stops early, in [0, 1).
    pub confidence: f64,
    /// Movement of the picture's corners, px, below which the last fit has converged.
    pub convergence_step: f64,
    /// Seed of the samples.
    pub seed: u64,
}

impl Default for Ransac {
    /// Returns a search of a similarity with MSAC, a radius of 3 px and three rounds, best pairs first. Positions of
    /// features are known to tenths of a pixel, so the last fit ends at steps of 0.01 px.
    fn default() -> Self {
        Self {
            model: Model::Similarity,
            functional: Functional::Msac,
            max_squared_error: 9.0,
            local_optimisation_rounds: 3,
            order: Order::BestFirst,
            max_samples: 20_000,
            confidence: 0.9999,
            convergence_step: 0.01,
            seed: 1,
        }
    }
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Consensus {
    /// The homography from REF pixel to CUR pixel.
    pub homography: Matrix3<f64>,
    /// Indices of the voters, ascending.
    pub inliers: Vec<usize>,
    /// Value of the quality functional.
    pub functional: f64,
    /// Root mean square error of the inliers, px.
    pub rms: f64,
    /// `log10` of the expected number of such agreements by chance.
    pub log10_nfa: f64,
    /// `floor(-log10 NFA)`, at most 255.
    pub quality: u8,
    /// Number of samples drawn.
    pub samples: usize,
}

impl Consensus {
    /// Returns an empty consensus with memory for `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self {
            homography: Matrix3::identity(),
            inliers: Vec::with_capacity(pairs),
            functional: 0.0,
            rms: 0.0,
            log10_nfa: 0.0,
            quality: 0,
            samples: 0,
        }
    }
}

/// Reusable memory of a search: a search among no more pairs than before allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct SearchBuffers {
    sample: Vec<Pair>,
    inliers: Vec<Pair>,
    positions: Vec<[u16; 2]>,
    refit: RefitBuffers,
}

impl SearchBuffers {
    /// Allocates memory for a search among `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self {
            sample: Vec::with_capacity(MAX_SAMPLE_PAIRS),
            inliers: Vec::with_capacity(pairs),
            positions: Vec::with_capacity(pairs),
            refit: RefitBuffers::with_capacity(pairs),
        }
    }
}

/// Work units of a pair after the search: its errors under the result, twice, and a term of `NFA`.
const JUDGEMENT_WORK: usize = 30;

/// Pairs of the largest sample, that of a homography.
const MAX_SAMPLE_PAIRS: usize = 4;

/// An error of a search: an invalid setting, or no estimate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RansacError {
    /// A setting is out of its range.
    #[error("{0}")]
    InvalidSetting(String),
    /// `K` times the largest sum of squared errors exceeds 1, so the second term could outvote a pair.
    #[error(
        "K = {k} px^-2 times the largest sum of squared errors, {max_sum} px^2, is more than 1: at most {}",
        1.0 / max_sum
    )]
    FactorTooLarge {
        /// The given `K`, px^-2.
        k: f64,
        /// Number of pairs times the largest squared error of a voter, px^2.
        max_sum: f64,
    },
    /// There are fewer pairs than a sample of the model has.
    #[error("no estimate: {given} matches, the model needs {needed}")]
    TooFewMatches {
        /// Pairs of a sample.
        needed: usize,
        /// Pairs given.
        given: usize,
    },
    /// No sample determined a model.
    #[error("no estimate: no sample of the {0} matches determines the model")]
    Degenerate(usize),
    /// The budget was exhausted before the first hypothesis.
    #[error("no estimate: the work allowed ended before a first hypothesis")]
    BudgetExhausted,
    /// The budget was exhausted before the ground was checked for repetition.
    #[error("no estimate: the work allowed ended before the ground was checked for repetition")]
    Unchecked,
    /// The matches agree on more than one motion.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// As much agreement is likely by chance.
    #[error(
        "no estimate: {inliers} of {matches} matches agree, and as many agree by chance {}",
        by_chance(*log10_nfa)
    )]
    AgreementByChance {
        /// Pairs that agree.
        inliers: usize,
        /// Pairs given.
        matches: usize,
        /// `log10` of the expected number of such agreements by chance.
        log10_nfa: f64,
    },
}

impl RansacError {
    /// Returns `true` if the pictures give no estimate, `false` if a setting is invalid.
    pub fn is_no_estimate(&self) -> bool {
        !matches!(self, Self::InvalidSetting(_) | Self::FactorTooLarge { .. })
    }
}

impl Ransac {
    /// Searches the motion with the most votes. `pairs` are sorted, best first; `gate_radius` (px) is the radius of the
    /// gate that they were matched in, if any.
    ///
    /// # Errors
    /// A setting is out of range, or there is no estimate.
    pub fn run(&self, pairs: &[Pair], gate_radius: Option<f64>) -> Result<Consensus, RansacError> {
        let mut found = Consensus::with_capacity(pairs.len());
        let (mut budget, mut buffers) = (Budget::UNLIMITED, SearchBuffers::default());
        self.run_into(pairs, gate_radius, None, &mut budget, &mut buffers, &mut found)?;
        Ok(found)
    }

    /// Searches as [`Ransac::run`] does and writes the result into `found`, with reusable memory and bounded work: if
    /// `budget` ends the search, the result is the best hypothesis so far. `start` is the first hypothesis. On an error
    /// `found` is unchanged.
    ///
    /// # Errors
    /// As [`Ransac::run`], and if the budget is exhausted before the first hypothesis.
    pub fn run_into(
        &self,
        pairs: &[Pair],
        gate_radius: Option<f64>,
        start: Option<&Matrix3<f64>>,
        budget: &mut Budget,
        buffers: &mut SearchBuffers,
        found: &mut Consensus,
    ) -> Result<(), RansacError> {
        self.check()?;
        let (n, m) = (pairs.len(), self.model.minimal_pairs());
        if n < m {
            return Err(RansacError::TooFewMatches { needed: m, given: n });
        }
        let factor = self.functional.factor(n, self.max_squared_error)?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut sampler = Sampler::new(self.order, n, m, self.max_samples);
        let mut uniform = Sampler::new(Order::Uniform, n, m, self.max_samples);
        let SearchBuffers { sample, inliers, positions, refit } = buffers;
        let mut samples = 0;
        let mut needed = self.max_samples;
        // Only every other sample is drawn from all pairs.
        let needed_for = |best: &Hypothesis| self.needed_samples(best.score.votes, n).saturating_mul(2);
        // The search cannot spend what the judgement of its result needs.
        let judgement = n * JUDGEMENT_WORK + chance::crowding_work(n, gate_radius);
        let mut search = budget.split(judgement);
        let mut best: Option<Hypothesis> = None;
        if let Some(h) = start.filter(|_| search.spend(PAIR_WORK * n)) {
            let hypothesis = Hypothesis::of(*h, pairs, self.max_squared_error, factor);
            let optimised = self.optimise(hypothesis, pairs, factor, &mut search, inliers, &mut refit.weights);
            needed = needed.min(needed_for(&optimised));
            best = Some(optimised);
        }
        while samples < needed && search.spend(FIT_WORK + PAIR_WORK * n) {
            samples += 1;
            let sampler = if samples % 2 == 0 { &mut uniform } else { &mut sampler };
            sampler.draw(&mut rng, pairs, sample);
            let Ok(h) = self.model.fit(sample) else { continue };
            let hypothesis = Hypothesis::of(h, pairs, self.max_squared_error, factor);
            if best.as_ref().is_none_or(|best| hypothesis.functional > best.functional) {
                let optimised = self.optimise(hypothesis, pairs, factor, &mut search, inliers, &mut refit.weights);
                needed = needed.min(needed_for(&optimised));
                best = Some(optimised);
            }
        }
        let best = best.map(|best| self.refitted(best, pairs, factor, &mut search, refit));
        let is_exhausted = search.is_exhausted();
        budget.absorb(search);
        let Some(best) = best else {
            return Err(if is_exhausted { RansacError::BudgetExhausted } else { RansacError::Degenerate(n) });
        };
        if budget.left() < judgement as u64 || !budget.spend(n * JUDGEMENT_WORK) {
            return Err(RansacError::BudgetExhausted);
        }
        let alpha = agreement_probability(pairs, self.max_squared_error, gate_radius, positions, budget);
        let votes = best.score.votes;
        let log10_nfa = log10_nfa(n, votes, m, alpha);
        if log10_nfa > libm::log10(MAX_NFA) {
            return Err(RansacError::AgreementByChance { inliers: votes, matches: n, log10_nfa });
        }
        found.inliers.clear();
        found.inliers.extend((0..n).filter(|&i| squared_error(&best.h, &pairs[i]) < self.max_squared_error));
        found.homography = best.h;
        found.functional = best.functional;
        found.rms = (best.score.squared_errors / votes as f64).sqrt();
        found.log10_nfa = log10_nfa;
        // The conversion saturates at 255; the comparison above ensures that the value is not negative.
        found.quality = (-log10_nfa).floor() as u8;
        found.samples = samples;
        Ok(())
    }

    fn check(&self) -> Result<(), RansacError> {
        if !(self.max_squared_error > 0.0 && self.max_squared_error.is_finite()) {
            let given = self.max_squared_error;
            return Err(RansacError::InvalidSetting(format!(
                "the largest squared error of a voter must be above 0, not {given} px^2"
            )));
        }
        if !(0.0..1.0).contains(&self.confidence) {
            return Err(RansacError::InvalidSetting(format!("the confidence is in [0, 1), not {}", self.confidence)));
        }
        if self.max_samples == 0 {
            return Err(RansacError::InvalidSetting("at least one sample must be drawn".into()));
        }
        Ok(())
    }

    /// Improves a hypothesis by rounds of least squares on its inliers, as long as the result is not worse. Results are
    /// compared by the subtracted form for every functional, because least squares lowers the sum, which the added form
    /// counts as a loss.
    fn optimise(
        &self,
        drawn: Hypothesis,
        pairs: &[Pair],
        factor: f64,
        budget: &mut Budget,
        inliers: &mut Vec<Pair>,
        weights: &mut Vec<f64>,
    ) -> Hypothesis {
        let value = |score: &Score| score.votes as f64 - factor.abs() * score.squared_errors;
        let mut best = drawn;
        for _ in 0..self.local_optimisation_rounds {
            // Selecting the inliers, fitting them and scoring the result cost about four comparisons a pair.
            if !budget.spend(FIT_WORK + 4 * PAIR_WORK * pairs.len()) {
                break;
            }
            inliers.clear();
            inliers.extend(pairs.iter().filter(|pair| squared_error(&best.h, pair) < self.max_squared_error));
            weights.clear();
            weights.extend(inliers.iter().map(|pair| robust::inverse_squared_denominator(&best.h, pair)));
            let Ok(h) = self.model.fit_round(inliers, weights) else { break };
            let refitted = Hypothesis::of(h, pairs, self.max_squared_error, factor);
            if value(&refitted.score) < value(&best.score) {
                break;
            }
            best = refitted;
        }
        best
    }

    /// Returns the hypothesis after the robust fit, or unchanged if the fit loses more than one vote in twenty.
    fn refitted(
        &self,
        best: Hypothesis,
        pairs: &[Pair],
        factor: f64,
        budget: &mut Budget,
        buffers: &mut RefitBuffers,
    ) -> Hypothesis {
        if self.local_optimisation_rounds == 0 {
            return best;
        }
        let h =
            robust::refit_in(self.model, best.h, pairs, self.max_squared_error, self.convergence_step, budget, buffers);
        let refitted = Hypothesis::of(h, pairs, self.max_squared_error, factor);
        if 20 * refitted.score.votes < 19 * best.score.votes { best } else { refitted }
    }

    /// Returns the number of samples of which at least one is free of outliers with the required confidence, if `votes`
    /// of `n` pairs are inliers. 0 if all are inliers, because no hypothesis can have more votes.
    fn needed_samples(&self, votes: usize, n: usize) -> usize {
        let clean: f64 = (0..self.model.minimal_pairs()).map(|_| votes as f64 / n as f64).product();
        if votes == n {
            return 0;
        }
        let needed = libm::log(1.0 - self.confidence) / libm::log1p(-clean);
        // The conversion saturates; without voters the number is infinite.
        (needed.ceil() as usize).max(1)
    }
}

#[cfg(test)]
mod tests;
