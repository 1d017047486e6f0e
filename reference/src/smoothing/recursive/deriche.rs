//! Deriche's sums of damped waves, orders 2 to 4 (Deriche 1993, "Recursively implementing the Gaussian and its
//! derivatives", INRIA report 1893):
//!
//! ```text
//! h+(t) = sum_j (A_j cos(W_j t) + B_j sin(W_j t)) e^(-L_j t),    t = n / scale >= 0
//! ```
//!
//! fitted to `e^(-t^2/2)` for all `sigma`; `scale` is `sigma` as published. Sampled at whole pixels and brought to DC
//! gain 1. The two sides are added, each sees the original input.

use super::parallel::{Parallel, ParallelSection};

/// Lowest and highest order of the filter: the number of poles of each side.
pub const ORDERS: (usize, usize) = (2, 4);

/// A damped wave with `A`, `B`, `L` and `W`; a wave of frequency 0 is one real pole.
struct Wave {
    cosine: f64,
    sine: f64,
    decay: f64,
    frequency: f64,
}

const fn wave(cosine: f64, sine: f64, decay: f64, frequency: f64) -> Wave {
    Wave { cosine, sine, decay, frequency }
}

const SECOND: &[Wave] = &[wave(0.9629, 1.942, 1.26, 0.8448)];
const THIRD: &[Wave] = &[wave(-0.8929, 1.021, 1.512, 1.475), wave(1.898, 0.0, 1.556, 0.0)];
const FOURTH: &[Wave] = &[wave(1.68, 3.735, 1.783, 0.6318), wave(-0.6803, -0.2598, 1.723, 1.997)];

/// Returns the filter of `order` 2 to 4, with the curve scaled to `scale` pixels.
pub(crate) fn filter(order: usize, scale: f64) -> Parallel {
    let waves = match order {
        2 => SECOND,
        3 => THIRD,
        _ => FOURTH,
    };
    let section = |wave: &Wave| {
        let (decay, angle) = ((-wave.decay / scale).exp(), wave.frequency / scale);
        if wave.frequency == 0.0 {
            ParallelSection { n: [wave.cosine, 0.0], a: [decay, 0.0] }
        } else {
            ParallelSection {
                n: [wave.cosine, decay * (wave.sine * angle.sin() - wave.cosine * angle.cos())],
                a: [2.0 * decay * angle.cos(), -decay * decay],
            }
        }
    };
    Parallel::new(waves.iter().map(section).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the relative l2 error of the curve against `e^(-t^2/2)` on `t >= 0`, by the trapezium rule.
    fn error(waves: &[Wave]) -> f64 {
        let step = 1e-3;
        let (mut difference, mut norm) = (0.0, 0.0);
        for i in 0..12_000 {
            let t = f64::from(i) * step;
            let curve: f64 = waves
                .iter()
                .map(|w| (w.cosine * (w.frequency * t).cos() + w.sine * (w.frequency * t).sin()) * (-w.decay * t).exp())
                .sum();
            let gaussian = (-0.5 * t * t).exp();
            difference += (curve - gaussian).powi(2);
            norm += gaussian * gaussian;
        }
        (difference / norm).sqrt()
    }

    #[test]
    fn the_constants_are_a_best_fit() {
        // A constant that is wrong by more than a percent would be improved by a step of a percent towards the right
        // one.
        for (waves, known) in [(SECOND, 0.0212), (THIRD, 0.00252), (FOURTH, 0.000409)] {
            let published = error(waves);
            assert!((published / known - 1.0).abs() < 0.01, "{published}");
            for i in 0..4 * waves.len() {
                for factor in [0.99, 1.01] {
                    let mut constants: Vec<[f64; 4]> =
                        waves.iter().map(|w| [w.cosine, w.sine, w.decay, w.frequency]).collect();
                    let constant = &mut constants[i / 4][i % 4];
                    *constant *= factor;
                    if *constant != 0.0 {
                        let changed: Vec<Wave> = constants.iter().map(|c| wave(c[0], c[1], c[2], c[3])).collect();
                        assert!(
                            error(&changed) > published,
                            "order with {} waves, constant {i}, {factor}",
                            waves.len()
                        );
                    }
                }
            }
        }
    }
}
