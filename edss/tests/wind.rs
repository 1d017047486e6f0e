//! Gusts compared with the formulas of their spectra.

use hoverlock_edss::wind::{Climate, Wind};
use nalgebra::{Complex, Vector2, Vector3};
use std::f64::consts::{PI, TAU};

const STEP: f64 = 0.02;

fn climate() -> Climate {
    Climate { gust_rms: 3.0, mean: Vector2::zeros(), height: 50.0 }
}

fn gusts(climate: &Climate, seed: u64, steps: usize) -> Vec<Vector3<f64>> {
    let mut wind = Wind::new(climate, seed, STEP);
    std::iter::repeat_with(|| {
        let value = wind.velocity();
        wind.advance();
        value
    })
    .take(steps)
    .collect()
}

/// MIL-F-8785C at 50 m (164.04 ft): 0.177 + 0.000823 h = 0.31201; intensities 3, 3 and 3 * 0.31201^0.4 = 1.883 m/s; V =
/// 18.83 m/s; scales 164.04 / 0.31201^1.2 = 663.7 ft = 202.3 m, and 50 m.
#[test]
fn scales_and_intensities_are_those_of_low_altitude() {
    let [along, across, vertical] = climate().components();
    assert_eq!(along, across);
    assert!((along.rms - 3.0).abs() < 1e-12 && (vertical.rms - 1.883).abs() < 1e-3, "{vertical:?}");
    assert!((along.time - 202.3 / 18.83).abs() < 0.01 && (vertical.time - 50.0 / 18.83).abs() < 0.005, "{along:?}");
    // With a faster mean wind the gusts pass faster.
    let fast = Climate { mean: Vector2::new(0.0, 30.0), ..climate() };
    assert!((fast.components()[2].time - 50.0 / 30.0).abs() < 1e-9);
}

/// The variance over seeds, at the first sample and later: it is stationary from the start. With 4000 seeds its
/// standard error is 2.2 %; four times that is allowed.
#[test]
fn the_variance_is_the_specified_one_from_the_first_sample_on() {
    let seeds = 4000;
    let expected = climate().components().map(|component| component.rms * component.rms);
    for steps in [0, 1, 300] {
        let mut sums = Vector3::zeros();
        for seed in 0..seeds {
            let last = gusts(&climate(), seed, steps + 1)[steps];
            sums += last.component_mul(&last);
        }
        for (axis, expected) in expected.iter().enumerate() {
            let ratio = sums[axis] / seeds as f64 / expected;
            assert!((ratio - 1.0).abs() < 0.09, "axis {axis}, after {steps} steps: {ratio} of the variance");
        }
    }
}

/// Returns Dryden's spectrum, one-sided over angular frequency, along the wind or across it.
fn dryden(rms: f64, time: f64, frequency: f64, across: bool) -> f64 {
    let square = (time * frequency).powi(2);
    let common = rms * rms * time / PI;
    if across { common * (1.0 + 3.0 * square) / (1.0 + square).powi(2) } else { common * 2.0 / (1.0 + square) }
}

/// Computes the mean periodogram of many flights over octaves, with Hann's window.
#[test]
fn the_spectrum_is_drydens_over_octaves() {
    let (steps, seeds) = (8192, 24);
    let duration = steps as f64 * STEP;
    // The lines of the periodogram at which the octaves begin; each octave is sampled at 8 of its lines.
    let octaves: Vec<Vec<usize>> =
        (2..9).map(|k| (0..8).map(|i| (1 << k) + i * (1 << k) / 8).collect()).map(dedup).collect();
    let window: Vec<f64> = (0..steps).map(|i| 0.5 - 0.5 * (TAU * i as f64 / steps as f64).cos()).collect();
    let power = window.iter().map(|w| w * w).sum::<f64>() * STEP;
    let mut measured = vec![Vector3::zeros(); octaves.len()];
    for seed in 0..seeds {
        let gusts = gusts(&climate(), 1000 + seed, steps);
        for (sum, lines) in measured.iter_mut().zip(&octaves) {
            for line in lines {
                let turn = TAU * *line as f64 / steps as f64;
                let mut amplitude = [Complex::new(0.0, 0.0); 3];
                for (i, (gust, window)) in gusts.iter().zip(&window).enumerate() {
                    let (sin, cos) = (turn * i as f64).sin_cos();
                    for (amplitude, gust) in amplitude.iter_mut().zip(gust.iter()) {
                        *amplitude += Complex::new(cos, -sin) * (gust * window * STEP);
                    }
                }
                // One-sided density over angular frequency: |X|^2 / (pi T_w).
                *sum += Vector3::from(amplitude.map(|a| a.norm_sqr())) / (PI * power * lines.len() as f64);
            }
        }
    }
    let components = climate().components();
    for (sum, lines) in measured.iter().zip(&octaves) {
        let first = TAU * lines[0] as f64 / duration;
        for (axis, component) in components.iter().enumerate() {
            let of = |line: &usize| dryden(component.rms, component.time, TAU * *line as f64 / duration, axis > 0);
            let expected = lines.iter().map(of).sum::<f64>() / lines.len() as f64;
            let ratio = sum[axis] / f64::from(seeds as u32) / expected;
            eprintln!("axis {axis}, from {first:.2} rad/s: {ratio:.3} of Dryden's");
            // A line of one flight has an exponential distribution, and neighbours are correlated by the window: 24 * 4
            // independent values give 10 %.
            assert!((0.7..1.35).contains(&ratio), "axis {axis}, from {first:.2} rad/s: {ratio} of Dryden's");
        }
    }
}

fn dedup(mut lines: Vec<usize>) -> Vec<usize> {
    lines.dedup();
    lines
}

#[test]
fn a_seed_is_a_wind() {
    let bits = |seed| gusts(&climate(), seed, 500).iter().flat_map(|g| [g.x.to_bits(), g.z.to_bits()]).collect();
    let first: Vec<u64> = bits(5);
    assert_eq!(first, bits(5));
    assert_ne!(first, bits(6));
    // Without gusts the wind is the mean wind.
    let calm = Climate { gust_rms: 0.0, mean: Vector2::new(4.0, -1.0), height: 50.0 };
    assert!(gusts(&calm, 5, 100).iter().all(|wind| *wind == Vector3::new(4.0, -1.0, 0.0)));
    let still = Climate { mean: Vector2::zeros(), ..calm };
    assert!(gusts(&still, 5, 100).iter().all(|wind| *wind == Vector3::zeros()));
}
