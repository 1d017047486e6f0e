//! Random pictures that are moved by any part of a pixel exactly: each frequency is turned by its phase.
//!
//! `I(x - s) = sum_w c(w) exp(i w (x - s))`. Amplitudes fall as `1 / w`, as those of natural scenes, times the response
//! of square pixels and of a lens that passes nothing above the Nyquist frequency. What finds a motion can be held to
//! them, as no interpolation has made them.

use crate::image::plane::Plane;
use nalgebra::{Complex, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Standard deviation of the samples, DN of 16 bits.
const RMS_DN: f64 = 5000.0;

/// The frequencies of a square picture, which is periodic.
pub struct Spectrum {
    side: usize,
    /// Amplitudes and phases; the picture is the real part.
    waves: Vec<Complex<f64>>,
}

impl Spectrum {
    /// Draws the phases of a picture of `side` x `side` pixels, at least one.
    pub fn random(side: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
        let wave = |i: usize| {
            let w = Vector2::new(frequency(i % side, side), frequency(i / side, side));
            let phase = Complex::from_polar(1.0, TAU * rng.random::<f64>());
            let lens = (1.0 - w.norm() / PI).max(0.0);
            let amplitude = if i == 0 { 0.0 } else { sinc(w.x / 2.0) * sinc(w.y / 2.0) * lens / w.norm() };
            phase * amplitude
        };
        Self { side, waves: (0..side * side).map(wave).collect() }
    }

    /// Returns the picture moved by `shift`, px, about the middle of 16 bits.
    pub fn picture(&self, shift: Vector2<f64>) -> Plane<u16> {
        let side = self.side;
        let turns: Vec<Complex<f64>> =
            (0..side).map(|i| Complex::from_polar(1.0, TAU * i as f64 / side as f64)).collect();
        // Rows, then columns.
        let mut rows = vec![Complex::default(); side * side];
        for (v, of_row) in self.waves.chunks_exact(side).enumerate() {
            let turned = |(u, wave): (usize, &Complex<f64>)| {
                wave * Complex::from_polar(1.0, -frequency(u, side) * shift.x - frequency(v, side) * shift.y)
            };
            let moved: Vec<Complex<f64>> = of_row.iter().enumerate().map(turned).collect();
            for x in 0..side {
                rows[v * side + x] = moved.iter().enumerate().map(|(u, c)| c * turns[u * x % side]).sum();
            }
        }
        let power: f64 = self.waves.iter().map(Complex::norm_sqr).sum();
        let scale = RMS_DN / (power / 2.0).sqrt();
        Plane::from_fn(side, side, |x, y| {
            let value: f64 = (0..side).map(|v| (rows[v * side + x] * turns[v * y % side]).re).sum();
            (32_768.0 + scale * value).round() as u16
        })
    }
}

/// Returns the frequency `i` of a period, radians per pixel, negative for the upper half.
fn frequency(i: usize, side: usize) -> f64 {
    let i = if i < side / 2 { i as f64 } else { i as f64 - side as f64 };
    TAU * i / side as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_by_whole_pixels_moves_the_samples() {
        let spectrum = Spectrum::random(32, 5);
        let [still, moved] =
            [Vector2::zeros(), Vector2::new(3.0, 31.0)].map(|shift: Vector2<f64>| spectrum.picture(shift));
        let expected = Plane::from_fn(32, 32, |x, y| still.row((y + 1) % 32)[(x + 29) % 32]);
        let differ = expected.as_slice().iter().zip(moved.as_slice()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(differ <= Some(1), "{differ:?}");
    }
}
