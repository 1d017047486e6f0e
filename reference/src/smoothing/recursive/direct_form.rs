//! The coefficients of a recursive filter multiplied out, as tables, hardware and other programs want them.
//!
//! ```text
//! cascade:   u[n] = b[0] x[n] + sum_i a[i] u[n-i]            y[n] = b[0] u[n] + sum_i a[i] y[n+i]
//! parallel:  u[n] = sum_i b[i] x[n-i] + sum_i a[i] u[n-i]    v[n] = sum_i b_ahead[i] x[n+i] + sum_i a[i] v[n+i]
//!            y[n] = u[n] + v[n]
//! ```
//!
//! Feedback is *added*: `a[i]` is the `b_i / b_0` of Young and van Vliet, and the pole itself in the first-order
//! filter.

use crate::image::plane::Plane;
use crate::smoothing::separable::{LANES, Lanes, columns_then_rows, single_line};
use crate::smoothing::smoother::Response;
use nalgebra::Complex;

/// What rounding of the step-down recursion leaves in doubt: a pole on the circle itself may come out so far inside.
const MARGIN: f64 = 1e-10;

/// The arrangement of the two passes of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Structure {
    /// The anticausal pass filters the output of the causal pass.
    Cascade,
    /// Both filter the input, and are added.
    Parallel,
}

/// The coefficients of both passes; see the equations of this module.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectForm {
    /// How the passes work together.
    pub structure: Structure,
    /// `a[1 ..= order]`: feedback, the same both ways.
    pub a: Vec<f64>,
    /// `b[0 ..]`: feed-forward, the same both ways in a cascade, of the causal pass in parallel.
    pub b: Vec<f64>,
    /// `b_ahead[1 ..= order]`: feed-forward of the anticausal pass in parallel; empty in a cascade.
    pub b_ahead: Vec<f64>,
}

impl DirectForm {
    /// Returns `H(e^{i omega})` at `omega` radians per pixel. Complex in general: the two passes in parallel are mirror
    /// images only up to rounding.
    pub fn frequency_response(&self, omega: f64) -> Complex<f64> {
        let z = Complex::from_polar(1.0, -omega);
        // Horner, from the highest power of z^-1 down.
        let polynomial =
            |c: &[f64], z: Complex<f64>| c.iter().rev().fold(Complex::new(0.0, 0.0), |sum, &c| sum * z + c);
        let feedback = |z: Complex<f64>| Complex::new(1.0, 0.0) - z * polynomial(&self.a, z);
        let causal = polynomial(&self.b, z) / feedback(z);
        match self.structure {
            Structure::Cascade => causal * causal.conj(),
            Structure::Parallel => causal + z.conj() * polynomial(&self.b_ahead, z.conj()) / feedback(z.conj()),
        }
    }

    /// Smooths a plane down its columns, then along its rows. Each pass repeats its own border sample. The DC gain must
    /// be 1.
    pub fn smooth(&self, plane: &Plane<f64>) -> Plane<f64> {
        columns_then_rows(plane, |tile| self.filter(tile))
    }

    /// Smooths a single line; see [`DirectForm::smooth`].
    pub fn smooth_line(&self, line: &[f64]) -> Vec<f64> {
        single_line(line, |tile| self.filter(tile))
    }

    fn filter(&self, tile: &mut [Lanes]) {
        let Some(&first) = tile.first() else { return };
        // The first sample is added again at the end, so that a constant passes unchanged to the last bit.
        let input: Vec<Lanes> = tile.iter().map(|sample| std::array::from_fn(|l| sample[l] - first[l])).collect();
        let nothing = [0.0; LANES];
        let causal = pass(input.iter(), &self.b, &self.a, nothing, nothing);
        let last = input.len() - 1;
        let both: Vec<Lanes> = match self.structure {
            Structure::Cascade => {
                let held = causal[last];
                pass(causal.iter().rev(), &self.b, &self.a, held, held)
            }
            Structure::Parallel => {
                let (ahead, feedback) = (self.b_ahead.iter().sum::<f64>(), self.a.iter().sum::<f64>());
                let settled = input[last].map(|sample| sample * ahead / (1.0 - feedback));
                let feed: Vec<f64> = std::iter::once(0.0).chain(self.b_ahead.iter().copied()).collect();
                let anticausal = pass(input.iter().rev(), &feed, &self.a, input[last], settled);
                let pairs = anticausal.iter().zip(causal.iter().rev());
                pairs.map(|(ahead, back)| std::array::from_fn(|l| ahead[l] + back[l])).collect()
            }
        };
        for (sample, smoothed) in tile.iter_mut().rev().zip(both) {
            *sample = std::array::from_fn(|l| first[l] + smoothed[l]);
        }
    }

    /// Returns the impulse response of both passes together, until it is below `1e-18`; at most 2^20 samples for an
    /// unstable filter.
    pub fn impulse_response(&self) -> Response {
        let order = self.a.len();
        // h+[n], until the last samples, which alone determine the rest, are negligible.
        let mut causal: Vec<f64> = Vec::new();
        while causal.len() < 1 << 20 {
            let n = causal.len();
            let past = |i: usize| n.checked_sub(i).map_or(0.0, |n| causal[n]);
            let feedback: f64 = self.a.iter().zip(1..).map(|(a, i)| a * past(i)).sum();
            causal.push(self.b.get(n).unwrap_or(&0.0) + feedback);
            if n > 2 * order && causal[n - order..].iter().all(|h| h.abs() < 1e-18) {
                break;
            }
        }
        let centre = causal.len() + order;
        let mut samples = vec![0.0; centre];
        samples.extend(&causal);
        samples.extend(vec![0.0; order]);
        // The anticausal pass over the output of the causal one, or over the impulse.
        let input = |n: usize| match self.structure {
            Structure::Cascade => self.b[0] * samples[n],
            Structure::Parallel if n < centre => self.b_ahead.get(centre - n - 1).copied().unwrap_or(0.0),
            Structure::Parallel => 0.0,
        };
        let mut anticausal = vec![0.0; samples.len()];
        for n in (0..samples.len() - order).rev() {
            anticausal[n] = input(n) + self.a.iter().zip(n + 1..).map(|(a, ahead)| a * anticausal[ahead]).sum::<f64>();
        }
        match self.structure {
            Structure::Cascade => Response::new(anticausal, centre),
            Structure::Parallel => Response::new(samples.iter().zip(&anticausal).map(|(u, v)| u + v).collect(), centre),
        }
    }

    /// Returns `true` if all poles are inside the unit circle. By the step-down recursion of Schur and Cohn, whose
    /// reflection coefficients are all below 1 in magnitude if and only if the filter is stable.
    pub fn is_stable(&self) -> bool {
        let mut c: Vec<f64> = self.a.iter().map(|a| -a).collect();
        while let Some(k) = c.pop() {
            if k.is_nan() || k.abs() >= 1.0 - MARGIN {
                return false;
            }
            let scale = 1.0 - k * k;
            c = (0..c.len()).map(|i| (c[i] - k * c[c.len() - 1 - i]) / scale).collect();
        }
        true
    }
}

/// Multiplies sections out: returns `a[1 ..]` of `1 - sum a[i] z^-i = prod_j (1 - a1_j z^-1 - a2_j z^-2)`. A section
/// with `a2 = 0` is of first order.
pub(crate) fn product(sections: impl Iterator<Item = [f64; 2]>) -> Vec<f64> {
    let polynomial = sections.fold(vec![1.0], |polynomial, [a1, a2]| {
        let factor: &[f64] = if a2 == 0.0 { &[1.0, -a1] } else { &[1.0, -a1, -a2] };
        multiply(&polynomial, factor)
    });
    polynomial[1..].iter().map(|c| -c).collect()
}

/// Multiplies two polynomials, lowest power first.
pub(crate) fn multiply(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; p.len() + q.len() - 1];
    for (i, p) in p.iter().enumerate() {
        for (j, q) in q.iter().enumerate() {
            product[i + j] += p * q;
        }
    }
    product
}

/// Computes `y[n] = sum_i feed[i] x[n-i] + sum_i a[i] y[n-1-i]`. Samples before the first are `before` and `settled`.
fn pass<'a>(
    input: impl Iterator<Item = &'a Lanes>,
    feed: &[f64],
    a: &[f64],
    before: Lanes,
    settled: Lanes,
) -> Vec<Lanes> {
    let input: Vec<&Lanes> = input.collect();
    let mut output: Vec<Lanes> = Vec::with_capacity(input.len());
    for n in 0..input.len() {
        let mut now = [0.0; LANES];
        let mut add = |weight: f64, sample: &Lanes| {
            for l in 0..LANES {
                now[l] += weight * sample[l];
            }
        };
        for (i, weight) in feed.iter().enumerate() {
            add(*weight, n.checked_sub(i).map_or(&before, |n| input[n]));
        }
        for (i, weight) in a.iter().enumerate() {
            add(*weight, n.checked_sub(i + 1).map_or(&settled, |n| &output[n]));
        }
        output.push(now);
    }
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_pole(a: &[f64]) -> DirectForm {
        DirectForm { structure: Structure::Cascade, a: a.to_vec(), b: vec![1.0], b_ahead: vec![] }
    }

    #[test]
    fn stability_is_that_of_known_poles() {
        // (1 - p z^-1)(1 - q z^-1)(1 - r z^-1) for poles on either side of the circle.
        for (poles, stable) in [
            ([0.9, 0.99, -0.95], true),
            ([0.9, 1.01, -0.95], false),
            ([0.5, 0.2, -1.001], false),
            ([0.99, 0.99, 0.99], true),
        ] {
            assert_eq!(all_pole(&product(poles.into_iter().map(|p| [p, 0.0]))).is_stable(), stable, "{poles:?}");
        }
        // A pair of modulus sqrt(0.98), then sqrt(1.02).
        assert!(all_pole(&[1.2, -0.98]).is_stable());
        assert!(!all_pole(&[1.2, -1.02]).is_stable());
        assert!(!all_pole(&[1.0]).is_stable());
        assert!(!all_pole(&[f64::NAN, 0.1]).is_stable());
    }
}
