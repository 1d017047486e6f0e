//! A causal and an anticausal pass over the same input, added, each a sum of sections of first and second order:
//!
//! ```text
//! H(z) = H+(z) + H+(z^-1) - h[0],    h[0] = sum_j n0_j,
//! H+(z) = sum_j (n0_j + n1_j z^-1) / (1 - a1_j z^-1 - a2_j z^-2)
//! ```
//!
//! Only the causal pass includes the middle sample, so the anticausal section is
//! `(m1 z + m2 z^2) / (1 - a1 z - a2 z^2)` with `m1 = n1 + a1 n0`, `m2 = a2 n0`. DC gain 1 by scaling `n0`, `n1`. Both
//! passes see the original input: constant extension only needs the steady state `x (m1 + m2)/(1 - a1 - a2)` to start
//! from, and both rules of [`Border`](super::border::Border) are the same. The first sample is subtracted from the line
//! and added at the end, so that a constant passes unchanged to the last bit.

use super::direct_form::{DirectForm, Structure, multiply, product};
use crate::smoothing::separable::{LANES, Lanes};
use multiversion::multiversion;
use nalgebra::Complex;

/// A section of first or second order with a zero, `y[n] = n0 x[n] + n1 x[n-1] + a1 y[n-1] + a2 y[n-2]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallelSection {
    /// Feed-forward coefficients `n0`, `n1`.
    pub n: [f64; 2],
    /// Feedback coefficients `a1`, `a2`; the second is 0 in a section of first order.
    pub a: [f64; 2],
}

impl ParallelSection {
    /// Returns `m1`, `m2` of the anticausal section, the factors of `x[n+1]` and `x[n+2]`.
    fn ahead(&self) -> [f64; 2] {
        [self.n[1] + self.a[0] * self.n[0], self.a[1] * self.n[0]]
    }

    /// Returns `1 - a1 - a2`.
    fn b(&self) -> f64 {
        1.0 - self.a[0] - self.a[1]
    }

    /// Returns the gain `sum_n h[n]` of both sides.
    fn dc_gain(&self) -> f64 {
        2.0 * (self.n[0] + self.n[1]) / self.b() - self.n[0]
    }

    /// Returns `sum_n n^2 h[n]` of both sides: twice the second derivative of `N/D` at 0, `N(s) = n0 + n1 e^-s`, `D(s)
    /// = 1 - a1 e^-s - a2 e^-2s`.
    fn second_moment(&self) -> f64 {
        let ([n0, n1], [a1, a2], d) = (self.n, self.a, self.b());
        let (n, slope_n, bend_n) = (n0 + n1, -n1, n1);
        let (slope_d, bend_d) = (a1 + 2.0 * a2, -(a1 + 4.0 * a2));
        2.0 * (bend_n / d - (2.0 * slope_n * slope_d + n * bend_d) / (d * d)
            + 2.0 * n * slope_d * slope_d / (d * d * d))
    }

    fn radius(&self) -> f64 {
        super::cascade::Section { a: self.a }.radius()
    }
}

/// A filter with the same sections in both passes, which are added.
#[derive(Debug, Clone, PartialEq)]
pub struct Parallel {
    sections: Vec<ParallelSection>,
}

impl Parallel {
    /// Makes a filter of sections whose poles are inside the unit circle, scaled to DC gain 1.
    pub fn new(mut sections: Vec<ParallelSection>) -> Self {
        let gain: f64 = sections.iter().map(ParallelSection::dc_gain).sum();
        for n in sections.iter_mut().flat_map(|section| &mut section.n) {
            *n /= gain;
        }
        Self { sections }
    }

    /// Returns the largest modulus of a pole.
    pub fn radius(&self) -> f64 {
        self.sections.iter().map(ParallelSection::radius).fold(0.0, f64::max)
    }

    /// Returns the variance of the impulse response, `sum n^2 h[n]`, square pixels.
    pub fn variance(&self) -> f64 {
        self.sections.iter().map(ParallelSection::second_moment).sum()
    }

    /// Returns `H(e^{i omega}) = sum_j 2 Re(N_j/D_j) - n0_j`.
    pub fn frequency_response(&self, omega: f64) -> f64 {
        let z = Complex::from_polar(1.0, -omega);
        let of = |s: &ParallelSection| 2.0 * ((s.n[0] + s.n[1] * z) / (1.0 - s.a[0] * z - s.a[1] * z * z)).re - s.n[0];
        self.sections.iter().map(of).sum()
    }

    /// Brings the sections to a common denominator.
    pub fn direct_form(&self) -> DirectForm {
        let a = product(self.sections.iter().map(|section| section.a));
        let order = a.len();
        let mut b = vec![0.0; order];
        for (j, section) in self.sections.iter().enumerate() {
            let others = self.sections.iter().enumerate().filter(|&(i, _)| i != j).map(|(_, other)| other.a);
            let denominator: Vec<f64> = std::iter::once(1.0).chain(product(others).iter().map(|a| -a)).collect();
            for (sum, term) in b.iter_mut().zip(multiply(&section.n, &denominator)) {
                *sum += term;
            }
        }
        // N(z^-1) - h[0] D(z^-1): the constant terms cancel.
        let b_ahead = (1..=order).map(|i| b.get(i).copied().unwrap_or(0.0) + a[i - 1] * b[0]).collect();
        DirectForm { structure: Structure::Parallel, a, b, b_ahead }
    }

    /// Filters a tile in place.
    pub(crate) fn filter(&self, tile: &mut [Lanes]) {
        let Some(&first) = tile.first() else { return };
        let input: Vec<Lanes> = tile.iter().map(|sample| std::array::from_fn(|l| sample[l] - first[l])).collect();
        let last = input[input.len() - 1];
        tile.fill(first);
        for section in &self.sections {
            let [m1, m2] = section.ahead();
            pass(&input, tile, [section.n[0], section.n[1], 0.0], section.a, [[0.0; LANES]; 2], false);
            let settled = last.map(|x| x * (m1 + m2) / section.b());
            pass(&input, tile, [0.0, m1, m2], section.a, [last, settled], true);
        }
    }
}

/// Adds one section of one side to `out`. `feed` has the factors of the sample and of the two before it. `start` is the
/// constant input before the line and its steady-state output.
#[multiversion(targets("x86_64+avx2"))]
fn pass(input: &[Lanes], out: &mut [Lanes], feed: [f64; 3], a: [f64; 2], start: [Lanes; 2], backwards: bool) {
    if backwards {
        recurse(input.iter().rev().zip(out.iter_mut().rev()), feed, a, start);
    } else {
        recurse(input.iter().zip(out.iter_mut()), feed, a, start);
    }
}

#[inline(always)]
fn recurse<'a>(
    samples: impl Iterator<Item = (&'a Lanes, &'a mut Lanes)>,
    feed: [f64; 3],
    a: [f64; 2],
    [before, settled]: [Lanes; 2],
) {
    let (mut x_one, mut x_two) = (before, before);
    let (mut y_one, mut y_two) = (settled, settled);
    for (x, sum) in samples {
        let mut y = [0.0; LANES];
        for l in 0..LANES {
            y[l] = feed[0] * x[l] + feed[1] * x_one[l] + feed[2] * x_two[l] + a[0] * y_one[l] + a[1] * y_two[l];
            sum[l] += y[l];
        }
        (x_two, x_one) = (x_one, *x);
        (y_two, y_one) = (y_one, y);
    }
}
