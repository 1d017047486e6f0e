//! Recursive approximations of the Gaussian, one file per family:
//!
//! ```text
//! H(z) = H+(z) H+(z^-1),    H+(z) = prod_j b_j / (1 - a1_j z^-1 - a2_j z^-2),    b_j = 1 - a1_j - a2_j
//! ```
//!
//! A causal pass, then its mirror image, both a cascade of sections of first and second order. Every section has DC gain 1,
//! and is computed as `y[n] = x[n] + a1 (y[n-1] - x[n]) + a2 (y[n-2] - x[n])`, so that a constant passes unchanged to the last bit
//! and does so whatever the rounding of the coefficients. Poles are kept in sections because a product of many poles
//! near 1 loses its digits when it is multiplied out.

pub mod border;
pub mod first_order;

use crate::separable::{LANES, Lanes, single_line};
use crate::smoother::DesignError;
use border::{Border, Extension};
use multiversion::multiversion;

/// Which approximation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// Two-sided first order: one real pole.
    FirstOrder,
}

impl Family {
    /// What people call it.
    pub fn name(self) -> String {
        match self {
            Self::FirstOrder => "first order".to_owned(),
        }
    }
}

/// How the free parameter of a family is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fit {
    /// Least squares against the unit-sum sampled Gaussian.
    LeastSquares,
}

/// `y[n] = b x[n] + a1 y[n-1] + a2 y[n-2]`, `b = 1 - a1 - a2`: all poles, DC gain 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// `a1`, `a2`; the second is 0 in a section of first order.
    pub a: [f64; 2],
}

impl Section {
    /// A real pole.
    pub fn real(pole: f64) -> Self {
        Self { a: [pole, 0.0] }
    }

    /// `b = 1 - a1 - a2`.
    pub fn b(&self) -> f64 {
        1.0 - self.a[0] - self.a[1]
    }

    /// The largest modulus of its poles, the roots of `z^2 - a1 z - a2`.
    pub fn radius(&self) -> f64 {
        let [a1, a2] = self.a;
        let discriminant = a1 * a1 + 4.0 * a2;
        if discriminant < 0.0 { (-a2).sqrt() } else { 0.5 * (a1.abs() + discriminant.sqrt()) }
    }

    /// `|b / (1 - a1 e^{-i omega} - a2 e^{-2 i omega})|^2`.
    fn power(&self, omega: f64) -> f64 {
        let [a1, a2] = self.a;
        let real = 1.0 - a1 * omega.cos() - a2 * (2.0 * omega).cos();
        let imaginary = a1 * omega.sin() + a2 * (2.0 * omega).sin();
        self.b().powi(2) / (real * real + imaginary * imaginary)
    }
}

/// A recursive smoother, designed.
#[derive(Debug, Clone, PartialEq)]
pub struct Recursive {
    family: Family,
    fit: Fit,
    sigma: f64,
    sections: Vec<Section>,
    extension: Extension,
}

impl Recursive {
    /// Finds the coefficients for `sigma` pixels.
    ///
    /// # Errors
    /// Where the family cannot do this `sigma` or this fit.
    pub fn design(family: Family, fit: Fit, sigma: f64) -> Result<Self, DesignError> {
        let sections = match family {
            Family::FirstOrder => vec![Section::real(first_order::pole(sigma)?)],
        };
        let extension = Extension::of(&sections);
        Ok(Self { family, fit, sigma, sections, extension })
    }

    /// The family it belongs to.
    pub fn family(&self) -> Family {
        self.family
    }

    /// How it was fitted.
    pub fn fit(&self) -> Fit {
        self.fit
    }

    /// The `sigma` it was designed for, pixels.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// The sections of each of the two passes.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// `h[0 ..= reach]`; what lies beyond is below `2^-53` of the whole.
    pub fn impulse_response(&self) -> Vec<f64> {
        let radius = self.sections.iter().map(Section::radius).fold(0.0, f64::max);
        // Poles that lie together decay as n^k r^n: 2^-70 leaves room for the factor n^k.
        let reach = (-70.0 * std::f64::consts::LN_2 / radius.ln()).ceil().max(1.0) as usize;
        let mut line = vec![0.0; 2 * reach + 1];
        line[reach] = 1.0;
        single_line(&line, |tile| self.filter(tile, Border::Held)).split_off(reach)
    }

    /// `H(e^{i omega})`, `omega` in radians per pixel.
    pub fn frequency_response(&self, omega: f64) -> f64 {
        self.sections.iter().map(|section| section.power(omega)).product()
    }

    /// Filters a tile in place: the causal pass, then the anticausal.
    pub(crate) fn filter(&self, tile: &mut [Lanes], border: Border) {
        let (Some(&first), Some(&last)) = (tile.first(), tile.last()) else { return };
        let mut tails = Vec::with_capacity(2 * self.sections.len());
        for section in &self.sections {
            pass(tile, section.a, [first; 2], false);
            let end = tile.len() - 1;
            tails.push(tile[end]);
            // Before the line every section has settled on its first sample.
            tails.push(if end > 0 { tile[end - 1] } else { first });
        }
        // Under `Held` all anticausal sections hold the same sample, for each starts on the one it is given.
        let held = tile[tile.len() - 1];
        for rows in self.sections.iter().zip(&self.extension.rows) {
            let (section, rows) = rows;
            let state = match border {
                Border::Held => [held; 2],
                Border::ConstantExtension => [extended(&rows[0], &tails, last), extended(&rows[1], &tails, last)],
            };
            pass(tile, section.a, state, true);
        }
    }
}

/// `x[N-1] + row . w`, `w` the tails less `x[N-1]`.
fn extended(row: &[f64], tails: &[Lanes], last: Lanes) -> Lanes {
    let mut sum = last;
    for (weight, tail) in row.iter().zip(tails) {
        for l in 0..LANES {
            sum[l] += weight * (tail[l] - last[l]);
        }
    }
    sum
}

/// One section along a tile, in place; `state` is what it put out one and two samples before it begins.
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
