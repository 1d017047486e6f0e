//! The error of the refinement on pictures that are shifted exactly, in the Fourier domain.

use super::refined_pair;
use crate::image::plane::Plane;
use nalgebra::{Complex, Matrix3, Vector2};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Side of a picture, which is periodic, px.
const SIDE: usize = 128;

/// Distance of neighbouring patches, px.
const SPACING: usize = 12;

/// Largest bias over the patches of a picture, px.
const MAX_BIAS_PX: f64 = 0.003;

/// Returns the frequency `i` of a period, radians per pixel, negative for the upper half.
fn frequency(i: usize) -> f64 {
    let i = if i < SIDE / 2 { i as f64 } else { i as f64 - SIDE as f64 };
    TAU * i / SIDE as f64
}

/// Returns a random spectrum, real part of a picture: amplitude `1 / w` as of natural scenes, times the response of
/// square pixels and of a lens that passes nothing above the Nyquist frequency.
fn spectrum(seed: u64) -> Vec<Complex<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
    (0..SIDE * SIDE)
        .map(|i| {
            let w = Vector2::new(frequency(i % SIDE), frequency(i / SIDE));
            let phase = Complex::from_polar(1.0, TAU * rng.random::<f64>());
            let lens = (1.0 - w.norm() / PI).max(0.0);
            let amplitude = if i == 0 { 0.0 } else { sinc(w.x / 2.0) * sinc(w.y / 2.0) * lens / w.norm() };
            phase * amplitude
        })
        .collect()
}

/// Returns the picture of a spectrum, moved by `shift` px, with 5000 DN rms about the middle of the range.
fn picture(spectrum: &[Complex<f64>], shift: Vector2<f64>) -> Plane<u16> {
    let turns: Vec<Complex<f64>> = (0..SIDE).map(|i| Complex::from_polar(1.0, TAU * i as f64 / SIDE as f64)).collect();
    // Rows, then columns.
    let mut rows = vec![Complex::default(); SIDE * SIDE];
    for (v, of_row) in spectrum.chunks_exact(SIDE).enumerate() {
        let moved: Vec<Complex<f64>> = of_row
            .iter()
            .enumerate()
            .map(|(u, c)| c * Complex::from_polar(1.0, -frequency(u) * shift.x - frequency(v) * shift.y))
            .collect();
        for x in 0..SIDE {
            rows[v * SIDE + x] = moved.iter().enumerate().map(|(u, c)| c * turns[u * x % SIDE]).sum();
        }
    }
    let power: f64 = spectrum.iter().map(Complex::norm_sqr).sum();
    let scale = 5000.0 / (power / 2.0).sqrt();
    Plane::from_fn(SIDE, SIDE, |x, y| {
        let value: f64 = (0..SIDE).map(|v| (rows[v * SIDE + x] * turns[v * y % SIDE]).re).sum();
        (32_768.0 + scale * value).round() as u16
    })
}

/// Returns the mean and the rms error, px, of the refined positions of a picture whose patches moved by `shift`.
fn error(seed: u64, shift: Vector2<f64>) -> (Vector2<f64>, f64) {
    let spectrum = spectrum(seed);
    let [reference, current] = [Vector2::zeros(), shift].map(|shift| picture(&spectrum, shift));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let places = || (24..SIDE - 24).step_by(SPACING).map(|v| v as f64);
    let mut errors = Vec::new();
    for (x, y) in places().flat_map(|y| places().map(move |x| (x, y))) {
        let p = Vector2::new(x, y);
        let miss = Vector2::from_fn(|_, _| rng.random::<f64>() - 0.5);
        let prediction = Matrix3::new_translation(&(shift + miss));
        let refined = refined_pair(&reference, &current, &prediction, p).expect("the patch has texture");
        errors.push(refined.pair.current - p - shift);
    }
    let n = errors.len() as f64;
    (errors.iter().sum::<Vector2<f64>>() / n, (errors.iter().map(|e| e.norm_squared()).sum::<f64>() / n).sqrt())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_shift_is_found_without_bias(seed in any::<u64>(), x in -1.0..1.0f64, y in -1.0..1.0f64) {
        let (bias, rms) = error(seed, Vector2::new(x, y));
        prop_assert!(bias.amax() < MAX_BIAS_PX, "bias {bias:?} px");
        prop_assert!(rms < 0.01, "rms {rms} px");
    }
}

/// At a quarter of a pixel the bias of an interpolation is largest.
#[test]
fn a_quarter_of_a_pixel_has_no_more_bias() {
    for quarter in [0.25, 0.75] {
        let biases: Vec<Vector2<f64>> = (0..6).map(|seed| error(seed, Vector2::new(quarter, 0.0)).0).collect();
        let mean = biases.iter().sum::<Vector2<f64>>() / biases.len() as f64;
        eprintln!("{quarter}: bias {} {}", mean.x, mean.y);
        assert!(mean.amax() < MAX_BIAS_PX, "{quarter}: {mean}");
    }
}
