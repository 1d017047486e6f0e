//! The smoother of the extractor, `G_sigma`: the sampled Gaussian (`ideal`) or a recursive approximation (`recursive`).
//!
//! A smoother is designed from `sigma` (pixels), has DC gain 1 and a symmetric impulse response, and is applied down
//! the columns, then along the rows. [`Residuals`] is its error against the Gaussian.

use crate::image::plane::Plane;
use crate::smoothing::design::DesignError;
use crate::smoothing::gaussian::{Gaussian, unit_sum_half};
use crate::smoothing::recursive::border::Border;
use crate::smoothing::recursive::{Family, Fit, Recursive};
use crate::smoothing::separable;

/// A smoothing filter of given `sigma`.
#[derive(Debug, Clone, PartialEq)]
pub enum Smoother {
    /// Direct convolution with the unit-sum sampled Gaussian.
    Gaussian(Gaussian),
    /// A recursive approximation.
    Recursive(Recursive),
}

impl Smoother {
    /// Designs the sampled Gaussian of the level `ideal`.
    ///
    /// # Errors
    /// `sigma` is out of range.
    pub fn gaussian(sigma: f64) -> Result<Self, DesignError> {
        Ok(Self::Gaussian(Gaussian::design(sigma)?))
    }

    /// Designs the two-sided first-order filter with the least-squares pole, of the level `recursive`.
    ///
    /// # Errors
    /// `sigma` is out of range.
    pub fn first_order(sigma: f64) -> Result<Self, DesignError> {
        Ok(Self::Recursive(Recursive::design(Family::FirstOrder, Fit::LeastSquares, sigma)?))
    }

    /// Returns the `sigma` of the design, pixels.
    pub fn sigma(&self) -> f64 {
        match self {
            Self::Gaussian(gaussian) => gaussian.sigma(),
            Self::Recursive(recursive) => recursive.sigma(),
        }
    }

    /// Returns the name for messages and reports.
    pub fn name(&self) -> String {
        match self {
            Self::Gaussian(_) => "sampled Gaussian".to_owned(),
            Self::Recursive(recursive) => recursive.family().name(),
        }
    }

    /// Smooths a plane down its columns, then along its rows.
    pub fn smooth(&self, plane: &Plane<f64>, border: Border) -> Plane<f64> {
        match self {
            Self::Gaussian(gaussian) => separable::columns_then_rows(plane, |tile| gaussian.filter(tile)),
            Self::Recursive(recursive) => separable::columns_then_rows(plane, |tile| recursive.filter(tile, border)),
        }
    }

    /// Smooths a single line.
    pub fn smooth_line(&self, line: &[f64], border: Border) -> Vec<f64> {
        match self {
            Self::Gaussian(gaussian) => separable::single_line(line, |tile| gaussian.filter(tile)),
            Self::Recursive(recursive) => separable::single_line(line, |tile| recursive.filter(tile, border)),
        }
    }

    /// Returns the impulse response `h[n]` for `n = 0 ..= reach`. It is symmetric; the sum beyond the reach is below
    /// `2^-53` of the whole.
    pub fn impulse_response(&self) -> Vec<f64> {
        match self {
            Self::Gaussian(gaussian) => gaussian.weights().to_vec(),
            Self::Recursive(recursive) => recursive.impulse_response(),
        }
    }

    /// Returns `H(e^{i omega})` at `omega` radians per pixel. It is real, because the impulse response is symmetric.
    pub fn frequency_response(&self, omega: f64) -> f64 {
        match self {
            Self::Gaussian(gaussian) => gaussian.frequency_response(omega),
            Self::Recursive(recursive) => recursive.frequency_response(omega),
        }
    }

    /// Computes the error against the Gaussian of the same `sigma`.
    pub fn residuals(&self) -> Residuals {
        Residuals::from_gaussian(&self.impulse_response(), self.sigma())
    }
}

/// An impulse response `h[n]`, `n = -centre ..`; 0 elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    samples: Vec<f64>,
    centre: usize,
}

impl Response {
    /// Makes a response from samples of which `samples[centre]` is `h[0]`.
    pub fn new(samples: Vec<f64>, centre: usize) -> Self {
        Self { samples, centre }
    }

    /// Makes a symmetric response from its half `h[0 ..]`.
    pub fn symmetric(half: &[f64]) -> Self {
        let samples = half.iter().skip(1).rev().chain(half).copied().collect();
        Self { samples, centre: half.len().saturating_sub(1) }
    }

    /// Returns `h[n]`, 0 outside the samples.
    pub fn at(&self, n: isize) -> f64 {
        self.centre.checked_add_signed(n).and_then(|i| self.samples.get(i)).copied().unwrap_or(0.0)
    }

    /// Returns the largest `|n|` that has a sample.
    pub fn reach(&self) -> isize {
        self.centre.max(self.samples.len().saturating_sub(self.centre + 1)) as isize
    }
}

/// The error of an impulse response `h` against a reference `w`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residuals {
    /// Relative root of the summed squared error, `sqrt(sum (h - w)^2 / sum w^2)`.
    pub l2: f64,
    /// Relative largest error, `max |h - w| / max |w|`.
    pub linf: f64,
    /// Standard deviation of `h` alone, `sqrt(sum n^2 h[n] / sum h[n])`, pixels.
    pub sigma_eff: f64,
    /// Gain of a constant, `sum h[n]`.
    pub dc_gain: f64,
    /// Shift of the picture, `sum n h[n] / sum h[n]`, pixels; 0 for a symmetric response.
    pub shift: f64,
}

impl Residuals {
    /// Computes the error of the symmetric response with the half `h[0 ..]` against the unit-sum sampled Gaussian of
    /// `sigma` pixels.
    pub fn from_gaussian(half: &[f64], sigma: f64) -> Self {
        let len = half.len().max((20.0 * sigma).ceil() as usize + 1);
        Self::between(&Response::symmetric(half), &Response::symmetric(&unit_sum_half(sigma, len)))
    }

    /// Computes the error of `h` against `w`.
    pub fn between(h: &Response, w: &Response) -> Self {
        let (mut difference, mut norm) = (0.0, 0.0);
        let (mut largest, mut peak) = (0.0f64, 0.0f64);
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        // From the tails inwards: small terms are added first.
        for n in (0..=h.reach().max(w.reach())).rev() {
            // The middle sample counts once.
            for n in [n, -n].into_iter().take(if n == 0 { 1 } else { 2 }) {
                let (h, w, n) = (h.at(n), w.at(n), n as f64);
                difference += (h - w) * (h - w);
                norm += w * w;
                largest = largest.max((h - w).abs());
                peak = peak.max(w.abs());
                sum += h;
                first += n * h;
                second += n * n * h;
            }
        }
        Self {
            l2: (difference / norm).sqrt(),
            linf: largest / peak,
            sigma_eff: (second / sum).sqrt(),
            dc_gain: sum,
            shift: first / sum,
        }
    }
}
