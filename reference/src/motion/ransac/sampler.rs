//! Random samples of pairs, from the best first (PROSAC) or from all pairs alike.

use crate::motion::model::Pair;
use rand::Rng;
use rand::seq::index;
use rand_chacha::ChaCha8Rng;

/// The order in which samples are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// From a growing number of the best pairs; the pairs are given best first.
    #[default]
    BestFirst,
    /// All samples are equally likely from the start.
    Uniform,
}

/// A source of samples of `m` pairs out of a pool of the best ones. The pool grows with the number of samples.
pub(super) struct Sampler {
    /// Size of the pool, `m ..= n`.
    pub(super) pool: usize,
    n: usize,
    m: usize,
    drawn: usize,
    /// Expected number of samples within the pool, of `max_samples` samples out of all `n` pairs.
    expected: f64,
    /// Sample after which the pool grows.
    share_ends: usize,
}

impl Sampler {
    /// Prepares samples of `m` out of `n` pairs, at most `max_samples`.
    pub(super) fn new(order: Order, n: usize, m: usize, max_samples: usize) -> Self {
        let (pool, share_ends) = match order {
            Order::BestFirst => (m, 1),
            Order::Uniform => (n, 0),
        };
        let expected = (0..m).fold(max_samples as f64, |expected, i| expected * (pool - i) as f64 / (n - i) as f64);
        Self { pool, n, m, drawn: 0, expected, share_ends }
    }

    /// Draws the next sample into `sample`, whose content is replaced.
    pub(super) fn draw(&mut self, rng: &mut ChaCha8Rng, pairs: &[Pair], sample: &mut Vec<Pair>) {
        self.drawn += 1;
        if self.drawn > self.share_ends && self.pool < self.n {
            let before = self.expected;
            self.pool += 1;
            self.expected *= self.pool as f64 / (self.pool - self.m) as f64;
            self.share_ends += (self.expected - before).ceil() as usize;
        }
        // After the pool has grown, every sample contains its newest member: samples without it were drawn before.
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

/// Returns `N` different indices below `end`, or none if `end < N`. Draws the same numbers as [`index::sample`], which
/// allocates.
fn distinct<const N: usize>(rng: &mut impl Rng, end: usize) -> impl Iterator<Item = usize> {
    index::sample_array::<_, N>(rng, end).into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use proptest::prelude::*;
    use rand::SeedableRng;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The pool grows from the sample size to all pairs within the samples, and no sample repeats a pair.
        #[test]
        fn the_pool_of_samples_grows_to_all(n in 4..200usize, m in 1..5usize, max_samples in 1000..20_000usize) {
            let pair = |i: usize| Pair { reference: Vector2::new(i as f64, 0.0), current: Vector2::zeros() };
            let pairs: Vec<Pair> = (0..n).map(pair).collect();
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let mut sampler = Sampler::new(Order::BestFirst, n, m, max_samples);
            let mut sample = Vec::new();
            let mut pool = 0;
            // Each growth is rounded up, so the pool may need up to n samples more.
            for drawn in 0..max_samples + n {
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
}
