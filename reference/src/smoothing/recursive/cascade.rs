//! A causal pass, then its mirror image, each a cascade of sections of first and second order without zeros:
//!
//! ```text
//! H(z) = H+(z) H+(z^-1),    H+(z) = prod_j b_j / (1 - a1_j z^-1 - a2_j z^-2),    b_j = 1 - a1_j - a2_j
//! ```
//!
//! Every section has DC gain 1 and is computed as `y[n] = x[n] + a1 (y[n-1] - x[n]) + a2 (y[n-2] - x[n])`, so that a
//! constant passes unchanged to the last bit, whatever the rounding of the coefficients. Poles are kept in sections
//! because a product of many poles near 1 loses its digits when it is multiplied out.

use super::border::{Border, Extension};
use super::direct_form::{DirectForm, Structure, product};
use crate::smoothing::separable::{LANES, Lanes};
use multiversion::multiversion;
use nalgebra::Complex;

/// A section of first or second order, `y[n] = b x[n] + a1 y[n-1] + a2 y[n-2]` with `b = 1 - a1 - a2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// `a1`, `a2`; the second is 0 in a section of first order.
    pub a: [f64; 2],
}

impl Section {
    /// Returns the section with a real pole.
    pub fn real(pole: f64) -> Self {
        Self { a: [pole, 0.0] }
    }

    /// Returns the section with a pole and its conjugate, `(z - p)(z - p*) = z^2 - 2 Re(p) z + |p|^2`.
    pub fn pair(pole: Complex<f64>) -> Self {
        Self { a: [2.0 * pole.re, -pole.norm_sqr()] }
    }

    /// Returns the input factor `b = 1 - a1 - a2`.
    pub fn b(&self) -> f64 {
        1.0 - self.a[0] - self.a[1]
    }

    /// Returns the largest modulus of its poles, the roots of `z^2 - a1 z - a2`.
    pub fn radius(&self) -> f64 {
        let [a1, a2] = self.a;
        let discriminant = a1 * a1 + 4.0 * a2;
        if discriminant < 0.0 { (-a2).sqrt() } else { 0.5 * (a1.abs() + discriminant.sqrt()) }
    }

    /// Returns the contribution of one pass to the variance of the impulse response, square pixels. With `D(s) = 1 - a1
    /// e^-s - a2 e^-2s` it is `-(ln D)''` at 0, `(a1 + 4 a2)/b + ((a1 + 2 a2)/b)^2`.
    fn variance(&self) -> f64 {
        let ([a1, a2], b) = (self.a, self.b());
        (a1 + 4.0 * a2) / b + ((a1 + 2.0 * a2) / b).powi(2)
    }

    /// Returns the squared gain `|b / (1 - a1 e^{-i omega} - a2 e^{-2 i omega})|^2`.
    fn power(&self, omega: f64) -> f64 {
        let [a1, a2] = self.a;
        let real = 1.0 - a1 * omega.cos() - a2 * (2.0 * omega).cos();
        let imaginary = a1 * omega.sin() + a2 * (2.0 * omega).sin();
        self.b().powi(2) / (real * real + imaginary * imaginary)
    }
}

/// A filter with the same sections in both passes, one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Cascade {
    sections: Vec<Section>,
    extension: Extension,
}

impl Cascade {
    /// Makes a filter of sections whose poles are inside the unit circle.
    pub fn new(sections: Vec<Section>) -> Self {
        let extension = Extension::of(&sections);
        Self { sections, extension }
    }

    /// Returns the sections of each of the two passes.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Returns the largest modulus of a pole.
    pub fn radius(&self) -> f64 {
        self.sections.iter().map(Section::radius).fold(0.0, f64::max)
    }

    /// Returns the variance of the impulse response, `sum n^2 h[n]`, square pixels.
    pub fn variance(&self) -> f64 {
        2.0 * self.sections.iter().map(Section::variance).sum::<f64>()
    }

    /// Returns `H(e^{i omega})` at `omega` radians per pixel.
    pub fn frequency_response(&self, omega: f64) -> f64 {
        self.sections.iter().map(|section| section.power(omega)).product()
    }

    /// Multiplies the sections out.
    pub fn direct_form(&self) -> DirectForm {
        let a = product(self.sections.iter().map(|section| section.a));
        let b = self.sections.iter().map(Section::b).product();
        DirectForm { structure: Structure::Cascade, a, b: vec![b], b_ahead: Vec::new() }
    }

    /// Filters a tile in place: the causal pass, then the anticausal.
    pub(crate) fn filter(&self, tile: &mut [Lanes], border: Border) {
        let (Some(&first), Some(&last)) = (tile.first(), tile.last()) else { return };
        let end = tile.len() - 1;
        let mut tails = Vec::with_capacity(2 * self.sections.len());
        for section in &self.sections {
            // Before the line every section is in its steady state for the first sample.
            pass(tile, section.a, [first; 2], false);
            tails.push(tile[end]);
            tails.push(if end > 0 { tile[end - 1] } else { first });
        }
        // Held: each anticausal section starts in its steady state for the last sample, which is the same for all.
        let held = tile[end];
        for (section, [next, next_but_one]) in self.sections.iter().zip(&self.extension.rows) {
            let state = match border {
                Border::Held => [held; 2],
                Border::ConstantExtension => [extended(next, &tails, last), extended(next_but_one, &tails, last)],
            };
            pass(tile, section.a, state, true);
        }
    }
}

/// Returns the output of an anticausal section behind the border, `x[N-1] + row . w`, with `w` the tails (the last two
/// outputs of every causal section) minus `x[N-1]`.
fn extended(row: &[f64], tails: &[Lanes], last: Lanes) -> Lanes {
    let mut sum = last;
    for (weight, tail) in row.iter().zip(tails) {
        for l in 0..LANES {
            sum[l] += weight * (tail[l] - last[l]);
        }
    }
    sum
}

/// Runs one section along a tile, in place. `state` has its outputs one and two samples before the tile.
#[multiversion(targets("x86_64+avx2"))]
fn pass(tile: &mut [Lanes], a: [f64; 2], state: [Lanes; 2], backwards: bool) {
    if backwards {
        recurse(tile.iter_mut().rev(), a, state);
    } else {
        recurse(tile.iter_mut(), a, state);
    }
}

#[inline(always)]
fn recurse<'a>(samples: impl Iterator<Item = &'a mut Lanes>, a: [f64; 2], state: [Lanes; 2]) {
    let [mut one, mut two] = state;
    if a[1] == 0.0 {
        for sample in samples {
            for l in 0..LANES {
                one[l] = sample[l] + a[0] * (one[l] - sample[l]);
            }
            *sample = one;
        }
    } else {
        for sample in samples {
            let mut now = [0.0; LANES];
            for l in 0..LANES {
                now[l] = sample[l] + a[0] * (one[l] - sample[l]) + a[1] * (two[l] - sample[l]);
            }
            *sample = now;
            two = one;
            one = now;
        }
    }
}
