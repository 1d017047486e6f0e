//! RANSAC with a quality functional that includes the residuals: `Q(H) = sum [e^2 < dist] -+ K sum e^2`, both sums over
//! the pairs with `e^2 < dist`.
//!
//! `e^2 = |p' - H p|^2` is the squared transfer error of a pair (px^2), `dist` the squared radius within which a pair
//! votes (px^2). The second term decides between hypotheses of equal votes, so `K * sum(e^2) <= 1` is required for
//! every possible sum. With `n` pairs the largest sum is `n dist`, so `K` is at most `1 / (n dist)`, its default. The
//! functionals:
//!
//! | name | second term | remark |
//! |---|---|---|
//! | count | none | Fischler and Bolles, 1981 |
//! | added | `+ K sum e^2` | as usually published; of two hypotheses with equal votes it selects the worse |
//! | subtracted | `- K sum e^2` | the intended functional |
//! | MSAC | `- sum e^2 / dist` | each vote counts `1 - e^2 / dist`, Torr and Zisserman, 2000 |
//!
//! The sums must not include outliers: their errors are larger by orders of magnitude and independent of the
//! hypothesis.
//!
//! Each new best hypothesis is improved by rounds of least squares on its own inliers (local optimisation, Chum, Matas
//! and Kittler, 2003), after which the result hardly depends on `dist`. Samples are drawn best match first (PROSAC,
//! Chum and Matas, 2005). Drawing stops when the confidence is reached: with the part `w` of voters that the best has,
//! the chance that no sample so far was free of outliers, `(1 - w^m)^draws`, is below one minus the confidence. That
//! counts samples of all pairs, so every other sample is one: the first pairs of a list in raster order are neighbours,
//! and samples of neighbours fail together.
//!
//! The best hypothesis of the search then goes through [`robust`], unless local optimisation is off.
//!
//! **No estimate.** A few pairs always determine a model, and other pairs agree with it by chance. When all `n` matches
//! are wrong, so that each position in CUR is anywhere the features are, one more pair agrees with the model of a
//! sample of `m` with probability `alpha`, and the expected number of samples with `k` or more voters is (Moisan and
//! Stival, 2004, without their search over `dist`)
//!
//! `NFA = C(n, m) sum_{j >= k - m} C(n - m, j) alpha^j (1 - alpha)^(n - m - j)`.
//!
//! It counts every sample that could be drawn, so it is a bound for a search of any length. There is an estimate if
//! `NFA` is at most [`CHANCE`]. Its quality 0 ..= 255 is `floor(-log10 NFA)`: such agreement occurs by chance less than
//! once in 10^quality pictures. 0 means no estimate. `alpha` is measured from the positions, because features are not
//! uniformly distributed: the part of all pairs of positions in CUR less than [`CROWD_RADIUS`] apart, scaled by area to
//! `dist`; within a gate, at least `dist / radius^2`.

use crate::motion::budget::Budget;
use crate::motion::model::{Model, Pair, squared_error};
use crate::motion::refusal::Refusal;
use crate::motion::robust::{self, SettleBuffers};
use nalgebra::Matrix3;
use rand::seq::index;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Largest `NFA` of an estimate. At 15 frames a second, one in 1e6 is one in 18 hours of pictures without any true
/// match. Wrong matches of real ground are not quite independent: over the 240 ordered pairs of 16 unrelated textures
/// the least is 10^-4.4, where 10^-2.4 is to be expected; those two decades are added.
pub const CHANCE: f64 = 1e-8;

/// Radius of the neighbourhood in which the crowding of features is measured, px: many times what they keep from each
/// other (4 px), a small part of a picture.
pub const CROWD_RADIUS: f64 = 32.0;

/// Quality functional.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Functional {
    /// Votes alone.
    Count,
    /// Votes and `K` times the sum of the voters' squared errors, as usually printed; `K` (px^-2) given or the largest
    /// allowed.
    Added(Option<f64>),
    /// Votes less `K` times that sum.
    Subtracted(Option<f64>),
    /// Votes less the sum over `dist`.
    #[default]
    Msac,
}

/// Sampling order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// Pairs are given best first, and samples are drawn from a growing number of the best.
    #[default]
    BestFirst,
    /// All samples are equally likely from the start.
    Uniform,
}

/// The settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ransac {
    /// Motion model.
    pub model: Model,
    /// Quality functional.
    pub functional: Functional,
    /// Squared radius within which a pair votes, px^2.
    pub dist: f64,
    /// Rounds of least squares on the inliers of a new best hypothesis; 0 leaves it as drawn.
    pub local_optimisation: usize,
    /// Sampling order.
    pub order: Order,
    /// Largest number of samples.
    pub draws: usize,
    /// Probability with which the search may stop only after a sample without outliers, in [0, 1).
    pub confidence: f64,
    /// The last least squares end when the motion moves by less, px.
    pub settled: f64,
    /// Seed of the samples.
    pub seed: u64,
}

impl Default for Ransac {
    /// Similarity, MSAC, 3 px, three rounds, best first. Positions of features are known to tenths of a pixel: the
    /// motion settles to 0.01 px.
    fn default() -> Self {
        Self {
            model: Model::Similarity,
            functional: Functional::Msac,
            dist: 9.0,
            local_optimisation: 3,
            order: Order::BestFirst,
            draws: 20_000,
            confidence: 0.9999,
            settled: 0.01,
            seed: 1,
        }
    }
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Consensus {
    /// REF pixel -> CUR pixel.
    pub homography: Matrix3<f64>,
    /// Indices of the pairs that vote, ascending.
    pub inliers: Vec<usize>,
    /// Value of the functional.
    pub functional: f64,
    /// Root mean square error of the inliers, px.
    pub rms: f64,
    /// `log10` of the expected number of such agreements by chance.
    pub log10_nfa: f64,
    /// `floor(-log10 NFA)`, at most 255.
    pub quality: u8,
    /// Samples drawn.
    pub draws: usize,
}

impl Consensus {
    /// None yet, with memory for `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self {
            homography: Matrix3::identity(),
            inliers: Vec::with_capacity(pairs),
            functional: 0.0,
            rms: 0.0,
            log10_nfa: 0.0,
            quality: 0,
            draws: 0,
        }
    }
}

/// Memory of a search, to be used again for the next: after a first search among as many pairs none is allocated.
#[derive(Debug, Clone, Default)]
pub struct SearchBuffers {
    sample: Vec<Pair>,
    inliers: Vec<Pair>,
    settling: SettleBuffers,
}

impl SearchBuffers {
    /// Memory for a search among `pairs` pairs.
    pub fn with_capacity(pairs: usize) -> Self {
        Self {
            sample: Vec::with_capacity(LARGEST_SAMPLE),
            inliers: Vec::with_capacity(pairs),
            settling: SettleBuffers::with_capacity(pairs),
        }
    }
}

/// Pairs of the largest sample, that of a homography.
const LARGEST_SAMPLE: usize = 4;

/// Work units of comparing a pair with a motion, by instructions on the ARM.
pub(crate) const PAIR_WORK: usize = 4;

/// Work units of fitting a sample.
pub(crate) const FIT_WORK: usize = 256;

/// Why there is no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RansacError {
    /// A setting is out of its range.
    #[error("{0}")]
    Setting(String),
    /// `K` times the largest sum of squared errors exceeds 1, so the second term could outvote a pair.
    #[error(
        "K = {k} px^-2 times the largest sum of squared errors, {largest} px^2, is more than 1: at most {}",
        1.0 / largest
    )]
    Constant {
        /// As given.
        k: f64,
        /// Number of pairs times `dist`, px^2.
        largest: f64,
    },
    /// The pairs are too few for the model.
    #[error("no estimate: {given} matches, the model needs {needed}")]
    TooFew {
        /// Pairs the model takes.
        needed: usize,
        /// Pairs given.
        given: usize,
    },
    /// No sample determined a model.
    #[error("no estimate: no sample of the {0} matches determines the model")]
    Degenerate(usize),
    /// The work that was allowed ended before the first hypothesis.
    #[error("no estimate: the work allowed ended before a first hypothesis")]
    Late,
    /// The matches agree on more than one motion.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The agreement may be chance.
    #[error(
        "no estimate: {inliers} of {matches} matches agree, and as many agree by chance {}",
        by_chance(*log10_nfa)
    )]
    Chance {
        /// Pairs that agree.
        inliers: usize,
        /// Pairs given.
        matches: usize,
        /// `log10` of the expected number of such agreements.
        log10_nfa: f64,
    },
}

impl RansacError {
    /// The pictures give no estimate, as against settings that make no sense.
    pub fn is_no_estimate(&self) -> bool {
        !matches!(self, Self::Setting(_) | Self::Constant { .. })
    }
}

/// What the functional makes of one hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Pairs with `e^2 < dist`.
    pub votes: usize,
    /// Their sum of `e^2`, px^2.
    pub squared_errors: f64,
}

impl Score {
    /// Votes and their squared errors under `h`.
    pub fn of(h: &Matrix3<f64>, pairs: &[Pair], dist: f64) -> Self {
        let mut score = Self { votes: 0, squared_errors: 0.0 };
        for pair in pairs {
            let e2 = squared_error(h, pair);
            if e2 < dist {
                score.votes += 1;
                score.squared_errors += e2;
            }
        }
        score
    }
}

impl Functional {
    /// The factor of the sum, sign included, for `pairs` pairs.
    ///
    /// # Errors
    /// Where a given `K` lets the second term exceed one vote.
    pub fn factor(self, pairs: usize, dist: f64) -> Result<f64, RansacError> {
        let largest = pairs as f64 * dist;
        let checked = |k: Option<f64>| match k {
            None => Ok(1.0 / largest),
            // The negated comparison refuses NaN.
            Some(k) if !(k >= 0.0 && k * largest <= 1.0) => Err(RansacError::Constant { k, largest }),
            Some(k) => Ok(k),
        };
        match self {
            Self::Count => Ok(0.0),
            Self::Added(k) => checked(k),
            Self::Subtracted(k) => checked(k).map(|k| -k),
            Self::Msac => Ok(-1.0 / dist),
        }
    }
}

impl Ransac {
    /// Searches the motion with the most votes. `pairs` come best first; `gate_radius` (px) is that of the gate they
    /// were matched in, if any.
    ///
    /// # Errors
    /// A setting is out of range, or there is no estimate.
    pub fn run(&self, pairs: &[Pair], gate_radius: Option<f64>) -> Result<Consensus, RansacError> {
        let mut found = Consensus::with_capacity(pairs.len());
        let (mut budget, mut buffers) = (Budget::UNLIMITED, SearchBuffers::default());
        self.run_into(pairs, gate_radius, None, &mut budget, &mut buffers, &mut found)?;
        Ok(found)
    }

    /// The same into `found`, with memory that is used again and with bounded work: where `budget` ends the search,
    /// the best so far is what is found. `start` is a motion to improve on, the first hypothesis. Without an estimate
    /// `found` is as it was.
    ///
    /// # Errors
    /// As [`Ransac::run`], and where the work ends before the first hypothesis.
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
            return Err(RansacError::TooFew { needed: m, given: n });
        }
        let factor = self.functional.factor(n, self.dist)?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut sampler = Sampler::new(self.order, n, m, self.draws);
        let mut uniform = Sampler::new(Order::Uniform, n, m, self.draws);
        let SearchBuffers { sample, inliers, settling } = buffers;
        let mut drawn = 0;
        let mut enough = self.draws;
        // Only every other sample is one of all pairs.
        let sufficient = |best: &Hypothesis| self.sufficient(best.score.votes, n).saturating_mul(2);
        let mut best: Option<Hypothesis> = None;
        if let Some(h) = start.filter(|_| budget.spend(PAIR_WORK * n)) {
            let hypothesis = Hypothesis::of(*h, pairs, self.dist, factor);
            let optimised = self.optimise(hypothesis, pairs, factor, budget, inliers, &mut settling.weights);
            enough = enough.min(sufficient(&optimised));
            best = Some(optimised);
        }
        while drawn < enough && budget.spend(FIT_WORK + PAIR_WORK * n) {
            drawn += 1;
            let sampler = if drawn % 2 == 0 { &mut uniform } else { &mut sampler };
            sampler.draw(&mut rng, pairs, sample);
            let Ok(h) = self.model.fit(sample) else { continue };
            let hypothesis = Hypothesis::of(h, pairs, self.dist, factor);
            if best.as_ref().is_none_or(|best| hypothesis.functional > best.functional) {
                let optimised = self.optimise(hypothesis, pairs, factor, budget, inliers, &mut settling.weights);
                enough = enough.min(sufficient(&optimised));
                best = Some(optimised);
            }
        }
        let Some(best) = best else {
            return Err(if budget.is_exhausted() { RansacError::Late } else { RansacError::Degenerate(n) });
        };
        let best = self.settled(best, pairs, factor, budget, settling);
        let alpha = agreement_by_chance(pairs, self.dist, gate_radius);
        let votes = best.score.votes;
        let log10_nfa = log10_nfa(n, votes, m, alpha);
        if log10_nfa > libm::log10(CHANCE) {
            return Err(RansacError::Chance { inliers: votes, matches: n, log10_nfa });
        }
        found.inliers.clear();
        found.inliers.extend((0..n).filter(|&i| squared_error(&best.h, &pairs[i]) < self.dist));
        found.homography = best.h;
        found.functional = best.functional;
        found.rms = (best.score.squared_errors / votes as f64).sqrt();
        found.log10_nfa = log10_nfa;
        // Saturates at 255, and the sign is known from the test above.
        found.quality = (-log10_nfa).floor() as u8;
        found.draws = drawn;
        Ok(())
    }

    fn check(&self) -> Result<(), RansacError> {
        if !(self.dist > 0.0 && self.dist.is_finite()) {
            return Err(RansacError::Setting(format!("dist is a squared distance above 0, not {} px^2", self.dist)));
        }
        if !(0.0..1.0).contains(&self.confidence) {
            return Err(RansacError::Setting(format!("the confidence is in [0, 1), not {}", self.confidence)));
        }
        if self.draws == 0 {
            return Err(RansacError::Setting("at least one sample must be drawn".into()));
        }
        Ok(())
    }

    /// Least squares on the hypothesis' inliers, as long as the result is not worse. It is compared by the
    /// subtracted form for every functional, because least squares lowers the sum, which the added form counts as a
    /// loss.
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
        for _ in 0..self.local_optimisation {
            // Sort out the inliers, fit all of them, and compare anew; the fit of a pair is a few comparisons' worth.
            if !budget.spend(FIT_WORK + 4 * PAIR_WORK * pairs.len()) {
                break;
            }
            inliers.clear();
            inliers.extend(pairs.iter().filter(|pair| squared_error(&best.h, pair) < self.dist));
            weights.clear();
            weights.extend(inliers.iter().map(|pair| robust::by_denominator(&best.h, pair)));
            let Ok(h) = self.model.fit_round(inliers, weights) else { break };
            let refitted = Hypothesis::of(h, pairs, self.dist, factor);
            if value(&refitted.score) < value(&best.score) {
                break;
            }
            best = refitted;
        }
        best
    }

    /// The hypothesis after the last least squares; as it was where that loses more than a vote in twenty, or where the
    /// work ends.
    fn settled(
        &self,
        best: Hypothesis,
        pairs: &[Pair],
        factor: f64,
        budget: &mut Budget,
        buffers: &mut SettleBuffers,
    ) -> Hypothesis {
        if self.local_optimisation == 0 {
            return best;
        }
        let h = robust::settle_in(self.model, best.h, pairs, self.dist, self.settled, budget, buffers);
        let settled = Hypothesis::of(h, pairs, self.dist, factor);
        if 20 * settled.score.votes < 19 * best.score.votes { best } else { settled }
    }

    /// Samples after which one without outliers has been drawn with the wanted confidence, when `votes` of `n` are
    /// inliers. Where all are inliers no sample can have more.
    fn sufficient(&self, votes: usize, n: usize) -> usize {
        let clean: f64 = (0..self.model.minimal_pairs()).map(|_| votes as f64 / n as f64).product();
        if votes == n {
            return 0;
        }
        let needed = libm::log(1.0 - self.confidence) / libm::log1p(-clean);
        // A float beyond the range saturates; without voters it is infinite.
        (needed.ceil() as usize).max(1)
    }
}

struct Hypothesis {
    h: Matrix3<f64>,
    score: Score,
    functional: f64,
}

impl Hypothesis {
    fn of(h: Matrix3<f64>, pairs: &[Pair], dist: f64, factor: f64) -> Self {
        let score = Score::of(&h, pairs, dist);
        Self { h, score, functional: score.votes as f64 + factor * score.squared_errors }
    }
}

/// Draws samples of `m` out of a pool of the best that grows with the number of draws.
struct Sampler {
    /// Size of the pool, `m ..= n`.
    pool: usize,
    n: usize,
    m: usize,
    drawn: usize,
    /// Of `draws` samples out of all `n`, how many would lie within the pool.
    expected: f64,
    /// Draw after which the pool has had its share.
    share_ends: usize,
}

impl Sampler {
    fn new(order: Order, n: usize, m: usize, draws: usize) -> Self {
        let (pool, share_ends) = match order {
            Order::BestFirst => (m, 1),
            Order::Uniform => (n, 0),
        };
        let expected = (0..m).fold(draws as f64, |expected, i| expected * (pool - i) as f64 / (n - i) as f64);
        Self { pool, n, m, drawn: 0, expected, share_ends }
    }

    fn draw(&mut self, rng: &mut ChaCha8Rng, pairs: &[Pair], sample: &mut Vec<Pair>) {
        self.drawn += 1;
        if self.drawn > self.share_ends && self.pool < self.n {
            let before = self.expected;
            self.pool += 1;
            self.expected *= self.pool as f64 / (self.pool - self.m) as f64;
            self.share_ends += (self.expected - before).ceil() as usize;
        }
        // Samples of a pool that grew contain its newest member: those without it were drawn before.
        let newest = self.drawn <= self.share_ends && self.pool > self.m;
        let (others, open) = if newest { (self.pool - 1, self.m - 1) } else { (self.pool, self.m) };
        sample.clear();
        sample.extend(newest.then(|| pairs[self.pool - 1]));
        match open {
            1 => sample.extend(distinct::<1>(rng, others).map(|i| pairs[i])),
            2 => sample.extend(distinct::<2>(rng, others).map(|i| pairs[i])),
            3 => sample.extend(distinct::<3>(rng, others).map(|i| pairs[i])),
            4 => sample.extend(distinct::<4>(rng, others).map(|i| pairs[i])),
            _ => (),
        }
    }
}

/// `N` different indices below `of`, none where there are fewer; the same draws as [`index::sample`], which allocates.
fn distinct<const N: usize>(rng: &mut impl Rng, of: usize) -> impl Iterator<Item = usize> {
    index::sample_array::<_, N>(rng, of).into_iter().flatten()
}

/// Probability that a wrong match agrees with a given motion within `dist`.
fn agreement_by_chance(pairs: &[Pair], dist: f64, gate_radius: Option<f64>) -> f64 {
    let crowd2 = CROWD_RADIUS * CROWD_RADIUS;
    let within_gate = gate_radius.map_or(0.0, |radius| dist / (radius * radius));
    if within_gate >= dist / crowd2 {
        // Not even features that all crowd agree more often.
        return within_gate.min(1.0);
    }
    let close = close_pairs(pairs);
    let all = pairs.len() * pairs.len().saturating_sub(1) / 2;
    // One more than counted: few pairs cannot show that nothing crowds.
    let crowding = (close + 1) as f64 / (all + 1) as f64;
    let anywhere = crowding * dist / crowd2;
    anywhere.max(within_gate).min(1.0)
}

/// Pairs of positions in CUR less than [`CROWD_RADIUS`] apart, in steps of 1/4 px: 16-bit integers, of which a vector
/// unit compares eight and more at a time.
fn close_pairs(pairs: &[Pair]) -> usize {
    const STEPS: f64 = 4.0;
    const REACH: u16 = (CROWD_RADIUS * STEPS) as u16;
    const BLOCK: usize = 64;
    // Positions may lie outside the picture a little; beyond -4096 and 12 287 px they go to the ends.
    let fixed = |pair: &Pair| (pair.current * STEPS).map(|v| (v + 4096.0 * STEPS) as u16);
    let mut close = 0;
    for (block, others) in pairs.chunks(BLOCK).enumerate() {
        let (mut x, mut y) = ([0; BLOCK], [0; BLOCK]);
        for ((x, y), other) in x.iter_mut().zip(&mut y).zip(others) {
            [*x, *y] = fixed(other).into();
        }
        let mut near = |a: &Pair, x: &[u16], y: &[u16]| {
            let [ax, ay]: [u16; 2] = fixed(a).into();
            let mut count = 0u16;
            for (x, y) in x.iter().zip(y) {
                // Beyond the reach along one axis is beyond it: the squares fit 16 bits.
                let (dx, dy) = (ax.abs_diff(*x).min(REACH), ay.abs_diff(*y).min(REACH));
                count += u16::from(dx * dx + dy * dy < REACH * REACH);
            }
            close += usize::from(count);
        };
        for (i, a) in others.iter().enumerate() {
            near(a, &x[..i], &y[..i]);
        }
        for a in &pairs[block * BLOCK + others.len()..] {
            near(a, &x, &y);
        }
    }
    close
}

/// `log10` of the expected number of samples of `m` out of `n` wrong matches that have `k` voters or more, themselves
/// included.
fn log10_nfa(n: usize, k: usize, m: usize, alpha: f64) -> f64 {
    let ln_ratio = |above: usize, below: usize| libm::log(above as f64 / below as f64);
    let ln_choose = |n: usize, k: usize| -> f64 { (0..k).map(|i| ln_ratio(n - i, k - i)).sum() };
    let (others, agreeing) = (n - m, k.saturating_sub(m));
    let (ln_in, ln_out) = (libm::log(alpha), libm::log1p(-alpha));
    // The tail as a multiple of its largest term so far. C(n, j + 1) = C(n, j) (n - j) / (j + 1) makes each term of
    // the one before.
    let (mut ln_ways, mut largest, mut sum) = (ln_choose(others, agreeing), f64::NEG_INFINITY, 0.0);
    for j in agreeing..=others {
        // alpha = 1 leaves only the term where all others agree, 0 * -inf = NaN otherwise.
        let out = if others == j { 0.0 } else { (others - j) as f64 * ln_out };
        let term = ln_ways + j as f64 * ln_in + out;
        if term > largest {
            sum = sum * libm::exp(largest - term) + 1.0;
            largest = term;
        } else if largest > f64::NEG_INFINITY {
            sum += libm::exp(term - largest);
        }
        ln_ways += if others == j { 0.0 } else { ln_ratio(others - j, j + 1) };
    }
    (ln_choose(n, m) + largest + libm::log(sum)) / std::f64::consts::LN_10
}

/// An expected number of agreements in words: in one pair of so many, or so many times in each.
fn by_chance(log10_nfa: f64) -> String {
    let times = 10f64.powf(log10_nfa);
    match log10_nfa {
        x if x > 3.0 => "thousands of times in every pair of pictures".into(),
        x if x >= 0.0 => format!("about {times:.0} times in every pair of pictures"),
        _ => format!("in one of {:.0} pairs of unrelated pictures", (1.0 / times).max(2.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::model::transfer;
    use nalgebra::Vector2;
    use proptest::prelude::*;
    use rand::RngExt;

    const PICTURE: Vector2<f64> = Vector2::new(1024.0, 768.0);

    fn position(rng: &mut ChaCha8Rng) -> Vector2<f64> {
        Vector2::new(rng.random::<f64>(), rng.random::<f64>()).component_mul(&PICTURE)
    }

    /// Sum of twelve uniform numbers: variance 1.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    /// `inliers` pairs of the motion `h` with noise of `sigma` px a coordinate, then `outliers` anywhere in CUR, 20 px
    /// or more from where they belong.
    fn scene(rng: &mut ChaCha8Rng, h: &Matrix3<f64>, inliers: usize, outliers: usize, sigma: f64) -> Vec<Pair> {
        let mut pairs = Vec::new();
        while pairs.len() < inliers {
            let reference = position(rng);
            let current = transfer(h, reference).unwrap() + sigma * Vector2::new(normal(rng), normal(rng));
            pairs.push(Pair { reference, current });
        }
        while pairs.len() < inliers + outliers {
            let wrong = Pair { reference: position(rng), current: position(rng) };
            if squared_error(h, &wrong) > 400.0 {
                pairs.push(wrong);
            }
        }
        pairs
    }

    fn similarity(angle: f64, scale: f64, tx: f64, ty: f64) -> Matrix3<f64> {
        let (s, c) = angle.sin_cos();
        Matrix3::new(scale * c, -scale * s, tx, scale * s, scale * c, ty, 0.0, 0.0, 1.0)
    }

    fn centre_miss(found: &Matrix3<f64>, truth: &Matrix3<f64>) -> f64 {
        (transfer(found, PICTURE / 2.0).unwrap() - transfer(truth, PICTURE / 2.0).unwrap()).norm()
    }

    fn shuffled(rng: &mut ChaCha8Rng, pairs: Vec<Pair>) -> Vec<Pair> {
        let order = index::sample(rng, pairs.len(), pairs.len());
        order.into_iter().map(|i| pairs[i]).collect()
    }

    fn any_search() -> impl Strategy<Value = Ransac> {
        let functional = prop_oneof![
            Just(Functional::Count),
            Just(Functional::Added(None)),
            Just(Functional::Subtracted(None)),
            Just(Functional::Msac)
        ];
        let model = prop::sample::select(vec![Model::Shift, Model::Similarity, Model::Affine, Model::Homography]);
        let order = prop::sample::select(vec![Order::BestFirst, Order::Uniform]);
        (model, functional, order, 0..4usize, any::<u64>()).prop_map(|(model, functional, order, rounds, seed)| {
            Ransac { model, functional, order, local_optimisation: rounds, seed, ..Ransac::default() }
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Exact matches, as many wrong ones, in any order: every model, functional and order finds all of them.
        #[test]
        fn exact_motion_is_recovered(
            search in any_search(), angle in -0.3..0.3f64, scale in 0.8..1.25f64,
            t in (-300.0..300.0f64, -300.0..300.0f64),
        ) {
            let mut rng = ChaCha8Rng::seed_from_u64(search.seed);
            let (angle, scale) = if search.model == Model::Shift { (0.0, 1.0) } else { (angle, scale) };
            let h = similarity(angle, scale, t.0, t.1);
            let pairs = scene(&mut rng, &h, 60, 60, 0.0);
            let pairs = shuffled(&mut rng, pairs);
            let found = search.run(&pairs, None).unwrap();
            let true_pairs = (0..pairs.len()).filter(|&i| squared_error(&h, &pairs[i]) < 1e-12);
            prop_assert!(true_pairs.into_iter().all(|i| found.inliers.contains(&i)), "{} inliers", found.inliers.len());
            // Without residuals in the functional, or with the wrong sign, any hypothesis within dist of all is as
            // good.
            let exact = matches!(search.functional, Functional::Msac | Functional::Subtracted(_));
            let tolerance = if exact { 1e-3 } else { search.dist.sqrt() };
            prop_assert!(centre_miss(&found.homography, &h) < tolerance, "{}", centre_miss(&found.homography, &h));
        }

        #[test]
        fn one_seed_one_result(search in any_search(), sigma in 0.0..2.0f64) {
            let mut rng = ChaCha8Rng::seed_from_u64(search.seed);
            let pairs = scene(&mut rng, &similarity(0.1, 1.05, 30.0, -50.0), 50, 80, sigma);
            prop_assert_eq!(search.run(&pairs, None), search.run(&pairs, None));
        }

        /// Best first: the pool grows from the sample size to all pairs within the draws, and samples never repeat a
        /// pair.
        #[test]
        fn the_pool_of_samples_grows_to_all(n in 4..200usize, m in 1..5usize, draws in 1000..20_000usize) {
            let pair = |i: usize| Pair { reference: Vector2::new(i as f64, 0.0), current: Vector2::zeros() };
            let pairs: Vec<Pair> = (0..n).map(pair).collect();
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let mut sampler = Sampler::new(Order::BestFirst, n, m, draws);
            let mut sample = Vec::new();
            let mut pool = 0;
            // Each growth is rounded up, so the pool may need up to n draws more.
            for drawn in 0..draws + n {
                sampler.draw(&mut rng, &pairs, &mut sample);
                let mut members: Vec<usize> = sample.iter().map(|p| p.reference.x as usize).collect();
                members.sort_unstable();
                members.dedup();
                prop_assert_eq!(members.len(), m);
                prop_assert!(*members.last().unwrap() < sampler.pool && sampler.pool >= pool);
                if drawn == 0 {
                    prop_assert_eq!(sampler.pool, m);
                }
                pool = sampler.pool;
            }
            prop_assert_eq!(pool, n);
        }
    }

    /// Two hypotheses, each with all votes; one misses by 0.1 px, the other by 2 px.
    #[test]
    fn the_added_form_prefers_the_worse_of_two() {
        let pairs = scene(&mut ChaCha8Rng::seed_from_u64(5), &Matrix3::identity(), 40, 0, 0.0);
        let dist = 9.0;
        let value = |functional: Functional, miss: f64| {
            let factor = functional.factor(pairs.len(), dist).unwrap();
            Hypothesis::of(similarity(0.0, 1.0, miss, 0.0), &pairs, dist, factor).functional
        };
        assert!(value(Functional::Added(None), 0.1) < value(Functional::Added(None), 2.0));
        assert!(value(Functional::Subtracted(None), 0.1) > value(Functional::Subtracted(None), 2.0));
        assert!(value(Functional::Msac, 0.1) > value(Functional::Msac, 2.0));
        assert_eq!(value(Functional::Count, 0.1), value(Functional::Count, 2.0));
    }

    /// In a whole search it also finds the worse one.
    #[test]
    fn the_added_form_is_less_accurate_than_the_subtracted() {
        let truth = similarity(0.05, 1.02, 40.0, -25.0);
        let mut misses = [Vec::new(), Vec::new()];
        for seed in 0..40 {
            let pairs = scene(&mut ChaCha8Rng::seed_from_u64(seed), &truth, 60, 40, 0.5);
            for (functional, misses) in
                [Functional::Added(None), Functional::Subtracted(None)].into_iter().zip(&mut misses)
            {
                let search = Ransac { functional, seed, local_optimisation: 0, ..Ransac::default() };
                misses.push(centre_miss(&search.run(&pairs, None).unwrap().homography, &truth));
            }
        }
        let [added, subtracted] = misses.map(median);
        assert!(added > 1.5 * subtracted, "added {added:.3} px, subtracted {subtracted:.3} px");
    }

    /// Two hypotheses, 0.2 and 1 px off, half of the pairs wrong: over the voters the sum tells which is better every
    /// time; over all pairs the wrong ones decide, and they do not know.
    #[test]
    fn over_all_pairs_outliers_swamp_the_sum() {
        let (mut by_voters, mut by_all) = (0, 0);
        let cases = 200;
        for seed in 0..cases {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let pairs = scene(&mut rng, &Matrix3::identity(), 40, 40, 0.3);
            let direction = std::f64::consts::TAU * rng.random::<f64>();
            let off = |miss: f64| similarity(0.0, 1.0, miss * direction.cos(), miss * direction.sin());
            let over_all = |h: &Matrix3<f64>| pairs.iter().map(|pair| squared_error(h, pair)).sum::<f64>();
            let over_voters = |h: &Matrix3<f64>| Score::of(h, &pairs, 9.0).squared_errors;
            by_voters += usize::from(over_voters(&off(0.2)) < over_voters(&off(1.0)));
            by_all += usize::from(over_all(&off(0.2)) < over_all(&off(1.0)));
        }
        assert_eq!(by_voters, cases as usize);
        assert!((70..=130).contains(&by_all), "{by_all} of {cases}: no better than a coin");
    }

    fn median(mut values: Vec<f64>) -> f64 {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }

    /// How much the result moves when `dist` goes from 2 px to 6 px, noise 0.5 px.
    fn moved_by_dist(local_optimisation: usize) -> f64 {
        let truth = similarity(0.05, 1.02, 40.0, -25.0);
        let moves = (0..30).map(|seed| {
            let pairs = scene(&mut ChaCha8Rng::seed_from_u64(seed), &truth, 80, 60, 0.5);
            let at = |dist: f64| {
                let search =
                    Ransac { functional: Functional::Count, dist, local_optimisation, seed, ..Ransac::default() };
                transfer(&search.run(&pairs, None).unwrap().homography, PICTURE / 2.0).unwrap()
            };
            (at(4.0) - at(36.0)).norm()
        });
        median(moves.collect())
    }

    #[test]
    fn local_optimisation_makes_the_result_independent_of_dist() {
        let (without, with) = (moved_by_dist(0), moved_by_dist(3));
        assert!(with < 0.02 && without > 0.3, "{with:.4} px with, {without:.4} px without");
    }

    /// `NFA` bounds the expected number of samples with so many voters, so a search that finds such a one in
    /// more than a part `NFA` of all trials refutes it. 400 trials at NFA <= 0.05: 20 expected at most, 40 is 4.5 sigma
    /// more.
    #[test]
    fn random_matches_agree_no_more_often_than_the_bound_says() {
        for (model, crowded) in [(Model::Shift, false), (Model::Similarity, false), (Model::Similarity, true)] {
            let (mut below, mut accepted) = (0, 0);
            let trials = 400;
            for seed in 0..trials {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let mut pairs = scene(&mut rng, &similarity(0.0, 1.0, 1e6, 0.0), 0, 120, 0.0);
                if crowded {
                    // Two thirds of the features in 2 % of the picture: a jetty in open water.
                    for pair in pairs.iter_mut().take(80) {
                        pair.reference = pair.reference.component_mul(&Vector2::new(0.1, 0.2));
                        pair.current = pair.current.component_mul(&Vector2::new(0.1, 0.2));
                    }
                }
                let pairs = shuffled(&mut rng, pairs);
                let search = Ransac { model, seed, draws: 2000, ..Ransac::default() };
                match search.run(&pairs, None) {
                    Ok(_) => accepted += 1,
                    Err(RansacError::Chance { log10_nfa, .. }) => below += usize::from(log10_nfa <= 0.05f64.log10()),
                    Err(other) => panic!("{other}"),
                }
            }
            assert_eq!(accepted, 0, "{model:?}, crowded {crowded}");
            assert!(below <= 40, "{model:?}, crowded {crowded}: {below} of {trials} at 0.05");
        }
    }

    /// How few true matches among 200 wrong ones are still an estimate: 12 with a similarity.
    #[test]
    fn few_true_matches_among_many_wrong_ones_give_an_estimate() {
        let truth = similarity(0.1, 1.05, 80.0, -60.0);
        for seed in 0..10 {
            let pairs = scene(&mut ChaCha8Rng::seed_from_u64(seed), &truth, 12, 200, 0.5);
            let found = Ransac { seed, ..Ransac::default() }.run(&pairs, None).unwrap();
            assert!(centre_miss(&found.homography, &truth) < 1.5 && found.quality >= 8, "{found:?}");
        }
    }

    /// By definition: C(6, 2) (1/4)^4 for all six of six, and all but the sample's own two out of the tail for two.
    #[test]
    fn nfa_agrees_with_its_formula() {
        assert!((log10_nfa(6, 6, 2, 0.25) - (15.0 * 0.25f64.powi(4)).log10()).abs() < 1e-12);
        assert!(
            (log10_nfa(6, 5, 2, 0.25) - (15.0 * (4.0 * 0.25f64.powi(3) * 0.75 + 0.25f64.powi(4))).log10()).abs()
                < 1e-12
        );
        assert!((log10_nfa(6, 2, 2, 0.25) - 15f64.log10()).abs() < 1e-12);
        assert!((log10_nfa(6, 6, 2, 1.0) - 15f64.log10()).abs() < 1e-12);
    }

    #[test]
    fn settings_are_checked() {
        let pairs = scene(&mut ChaCha8Rng::seed_from_u64(1), &Matrix3::identity(), 100, 0, 0.0);
        // 100 pairs at 9 px^2: at most 1/900.
        let with = |functional: Functional| Ransac { functional, ..Ransac::default() }.run(&pairs, None);
        assert!(with(Functional::Subtracted(Some(1.0 / 900.0))).is_ok());
        for k in [1.0 / 899.0, -1e-6, f64::NAN] {
            assert!(matches!(with(Functional::Subtracted(Some(k))), Err(RansacError::Constant { .. })), "{k}");
        }
        for search in [
            Ransac { dist: 0.0, ..Ransac::default() },
            Ransac { dist: f64::NAN, ..Ransac::default() },
            Ransac { confidence: 1.0, ..Ransac::default() },
            Ransac { draws: 0, ..Ransac::default() },
        ] {
            assert!(matches!(search.run(&pairs, None), Err(RansacError::Setting(_))));
        }
        assert_eq!(Ransac::default().run(&pairs[..1], None), Err(RansacError::TooFew { needed: 2, given: 1 }));
        assert_eq!(Ransac::default().run(&[pairs[0]; 9], None), Err(RansacError::Degenerate(9)));
    }

    /// Pairs of a homography, all right, noise 0.08 px, in raster order, shuffled, or sorted by error with the worst
    /// first: the search starts from other samples and ends in the same motion, as nearly as it settles.
    #[test]
    fn the_order_of_the_pairs_does_not_matter() {
        let truth = Matrix3::new(1.02, -0.05, 12.0, 0.05, 1.01, -7.0, 4e-5, -3e-5, 1.0);
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut raster = scene(&mut rng, &truth, 300, 0, 0.08);
            raster.sort_by(|a, b| a.reference.y.total_cmp(&b.reference.y));
            let mut worst_first = raster.clone();
            worst_first.sort_by(|a, b| squared_error(&truth, b).total_cmp(&squared_error(&truth, a)));
            let mixed = shuffled(&mut rng, raster.clone());
            let search = Ransac { model: Model::Homography, seed, ..Ransac::default() };
            let misses = [raster, worst_first, mixed].map(|pairs| {
                let found = search.run(&pairs, None).unwrap();
                assert_eq!(found.inliers.len(), 300);
                centre_miss(&found.homography, &truth)
            });
            assert!(
                misses.iter().all(|miss| *miss < 0.03 && (miss - misses[0]).abs() < 0.1 * search.settled),
                "{misses:?}"
            );
        }
    }

    /// Half of the pairs right: 36 samples of two make 99.99 % sure, not 20 000.
    #[test]
    fn the_search_stops_at_the_confidence() {
        let pairs = scene(&mut ChaCha8Rng::seed_from_u64(1), &Matrix3::identity(), 100, 100, 0.2);
        let pairs = shuffled(&mut ChaCha8Rng::seed_from_u64(2), pairs);
        // ln(1e-4) / ln(1 - 1/4) = 32.02, and every other sample is one from among all pairs.
        assert_eq!(Ransac::default().sufficient(100, 200), 33);
        assert_eq!(Ransac::default().run(&pairs, None).unwrap().draws, 66);
        assert_eq!(Ransac::default().sufficient(200, 200), 0);
        assert_eq!(Ransac::default().sufficient(0, 200), usize::MAX);
    }
}
