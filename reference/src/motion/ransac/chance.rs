//! Expected number of agreements by chance (NFA, number of false alarms) among wrong matches.

use crate::motion::budget::Budget;
use crate::motion::model::Pair;

/// Largest `NFA` of an estimate. At 15 frames a second, 1e-6 is one frame in 18 hours of pictures without any true
/// match. Wrong matches of real ground are not quite independent: over the 240 ordered pairs of 16 unrelated textures
/// the smallest `NFA` is 10^-4.4, where 10^-2.4 is expected; the limit allows for those two decades.
pub(super) const MAX_NFA: f64 = 1e-8;

/// Radius of the neighbourhood in which the crowding of features is measured, px: several times the smallest distance
/// of two features (4 px), and small against a picture.
const CROWDING_RADIUS_PX: f64 = 32.0;

/// Pairs of positions that are compared in a work unit, at least: 2.2 instructions each.
const PAIRS_PER_UNIT: usize = 5;
/// Work units of sorting a position.
const SORT_WORK: usize = 10;

/// Returns the work units of [`agreement_probability`] with `n` pairs at most, if all are in one place.
pub(super) fn crowding_work(n: usize, gate_radius: Option<f64>) -> usize {
    if is_gate_decisive(gate_radius) { 0 } else { n * n / 2 / PAIRS_PER_UNIT + n * (SORT_WORK + 1) }
}

/// Returns `true` in a gate so small that even fully crowded features do not agree more often by chance.
fn is_gate_decisive(gate_radius: Option<f64>) -> bool {
    gate_radius.is_some_and(|radius| radius <= CROWDING_RADIUS_PX)
}

/// Returns the probability that a wrong match agrees with a given motion, that is has `e^2 < max_squared_error` (px^2).
/// `gate_radius` (px) is the radius of the gate that the matches were found in.
/// `positions` is reusable memory. The budget
/// has at least [`crowding_work`].
pub(super) fn agreement_probability(
    pairs: &[Pair],
    max_squared_error: f64,
    gate_radius: Option<f64>,
    positions: &mut Vec<[u16; 2]>,
    budget: &mut Budget,
) -> f64 {
    let crowding_radius2 = CROWDING_RADIUS_PX * CROWDING_RADIUS_PX;
    let within_gate = gate_radius.map_or(0.0, |radius| max_squared_error / (radius * radius));
    if is_gate_decisive(gate_radius) {
        return within_gate.min(1.0);
    }
    let close = close_pairs(pairs, positions, budget);
    let all = pairs.len() * pairs.len().saturating_sub(1) / 2;
    // One more than counted: a small number of pairs cannot show that no features crowd.
    let crowding = (close + 1) as f64 / (all + 1) as f64;
    let anywhere = crowding * max_squared_error / crowding_radius2;
    anywhere.max(within_gate).min(1.0)
}

/// Counts the pairs of positions in CUR less than 32 px apart. Positions are in steps of 1/4 px: of 16-bit integers a
/// vector unit compares eight or more at a time. Sorted by row, a block of positions is compared with those behind it
/// up to the first that is too far below. `positions` is reusable memory.
fn close_pairs(pairs: &[Pair], positions: &mut Vec<[u16; 2]>, budget: &mut Budget) -> usize {
    const STEPS: f64 = 4.0;
    const RADIUS: u16 = (CROWDING_RADIUS_PX * STEPS) as u16;
    const BLOCK: usize = 64;
    // Positions may be a little outside the picture; beyond -4096 and 12 287 px they saturate.
    let fixed = |pair: &Pair| (pair.current * STEPS).map(|v| (v + 4096.0 * STEPS) as u16);
    budget.spend(SORT_WORK * pairs.len());
    positions.clear();
    positions.extend(pairs.iter().map(|pair| <[u16; 2]>::from(fixed(pair))));
    positions.sort_unstable_by_key(|[x, y]| u32::from(*y) << 16 | u32::from(*x));
    let mut close = 0;
    for (block, others) in positions.chunks(BLOCK).enumerate() {
        let (mut x, mut y) = ([0; BLOCK], [0; BLOCK]);
        for ((x, y), other) in x.iter_mut().zip(&mut y).zip(others) {
            [*x, *y] = *other;
        }
        let mut near = |[ax, ay]: [u16; 2], x: &[u16], y: &[u16]| {
            let mut count = 0u16;
            for (x, y) in x.iter().zip(y) {
                // Clamped to the radius, beyond which the pair does not count anyway, so that the squares fit 16 bits.
                let (dx, dy) = (ax.abs_diff(*x).min(RADIUS), ay.abs_diff(*y).min(RADIUS));
                count += u16::from(dx * dx + dy * dy < RADIUS * RADIUS);
            }
            close += usize::from(count);
        };
        for (i, a) in others.iter().enumerate() {
            near(*a, &x[..i], &y[..i]);
        }
        let lowest = y[others.len() - 1];
        let below = &positions[block * BLOCK + others.len()..];
        let below = &below[..below.partition_point(|[_, y]| y - lowest < RADIUS)];
        budget.spend((others.len() / 2 + below.len()) * others.len() / PAIRS_PER_UNIT);
        below.iter().for_each(|a| near(*a, &x, &y));
    }
    close
}

/// Returns `log10` of the expected number of samples of `m` out of `n` wrong matches that have at least `k` voters,
/// themselves included; `alpha` is the probability that one more match agrees.
pub(super) fn log10_nfa(n: usize, k: usize, m: usize, alpha: f64) -> f64 {
    let ln_ratio = |above: usize, below: usize| libm::log(above as f64 / below as f64);
    let ln_choose = |n: usize, k: usize| -> f64 { (0..k).map(|i| ln_ratio(n - i, k - i)).sum() };
    let (others, agreeing) = (n - m, k.saturating_sub(m));
    let (ln_in, ln_out) = (libm::log(alpha), libm::log1p(-alpha));
    // The tail as a multiple of its largest term so far; C(n, j + 1) = C(n, j) (n - j) / (j + 1).
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

/// Returns the frequency of an agreement by chance in words.
pub(super) fn by_chance(log10_nfa: f64) -> String {
    let times = 10f64.powf(log10_nfa);
    match log10_nfa {
        x if x > 3.0 => "thousands of times in every pair of unrelated pictures".into(),
        _ if times >= 1.5 => format!("about {times:.0} times in every pair of unrelated pictures"),
        x if x >= 0.0 => "about once in every pair of unrelated pictures".into(),
        _ => format!("in one of {:.0} pairs of unrelated pictures", (1.0 / times).max(2.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::{by_chance, log10_nfa};

    #[test]
    fn the_frequency_of_chance_is_said_in_words() {
        let said = |nfa: f64| by_chance(nfa.log10());
        assert_eq!(said(0.25), "in one of 4 pairs of unrelated pictures");
        assert_eq!(said(0.9), "in one of 2 pairs of unrelated pictures");
        assert_eq!(said(1.2), "about once in every pair of unrelated pictures");
        assert_eq!(said(1.6), "about 2 times in every pair of unrelated pictures");
        assert_eq!(said(2000.0), "thousands of times in every pair of unrelated pictures");
    }

    /// By definition: C(6, 2) (1/4)^4 for all six of six; for two voters, the sample itself, the whole tail.
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
}
