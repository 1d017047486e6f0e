//! Seeded degradation of a picture by air and camera, in this order, with `v` in DN of the 16-bit camera sample and
//! `FS = 65535`:
//!
//! ```text
//! contrast   v <- L + c (v - L)             L = 0.55 FS, the light that haze scatters into the path (Koschmieder 1924)
//! blur       v <- G_s * v                   sampled Gaussian, border sample held
//! gain       v <- g v                       g uniform in [1 - d, 1 + d], drawn once a frame
//! noise      e = v / FS * Q electrons       shot noise of variance e (Poisson), read noise of 12 e- rms
//! ```
//!
//! `Q` is the full well. The result is rounded and clipped to `0 ..= 65535`. It is a function of the picture, the
//! condition and the seed, with the same bits on every machine: only `+ - * / sqrt` are used, which IEEE 754 defines
//! exactly. Therefore the normal deviate is the sum of twelve uniform numbers minus 6 (variance 1, excess kurtosis
//! -0.1, range +-6), and shot and read noise, both nearly normal and independent, are one draw of variance `e + 12^2`.
//! At a full well of 4 ke- the Poisson distribution is normal up to a skew of `1/sqrt(e)`, 0.02 at mid scale.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use hoverlock_reference::image::plane::Plane;

/// Full scale of the camera sample, DN.
const FULL_SCALE: f64 = 65535.0;
/// Scattered light (air light), relative to full scale.
const AIR_LIGHT: f64 = 0.55;
/// Read noise of the sensor, electrons rms.
const READ_NOISE_ELECTRONS: f64 = 12.0;

/// The parameters of air and camera.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Condition {
    /// Name in reports.
    pub name: &'static str,
    /// Contrast factor `c`, 1 in clear air.
    pub contrast: f64,
    /// Standard deviation of the blur, px; 0 for none.
    pub blur: f64,
    /// Half width `d` of the gain interval.
    pub gain_spread: f64,
    /// Full well `Q`, electrons.
    pub full_well: f64,
}

/// Clear air: full well 20 ke-, gain +-10 %.
pub const NOMINAL: Condition =
    Condition { name: "nominal", contrast: 1.0, blur: 0.0, gain_spread: 0.1, full_well: 20_000.0 };
/// Combined degradations: contrast 0.3, blur 1.5 px, gain +-20 %, 4 ke-.
pub const COMBINED: Condition =
    Condition { name: "combined", contrast: 0.3, blur: 1.5, gain_spread: 0.2, full_well: 4_000.0 };
/// Fog: contrast 0.1, 6 ke-.
pub const FOG: Condition = Condition { name: "fog", contrast: 0.1, blur: 0.0, gain_spread: 0.0, full_well: 6_000.0 };

/// The three conditions of the acceptance tests.
pub const CONDITIONS: [Condition; 3] = [NOMINAL, COMBINED, FOG];

impl Condition {
    /// Returns the gain that `seed` gives.
    pub fn gain(&self, seed: u64) -> f64 {
        let uniform = ChaCha8Rng::seed_from_u64(seed).next_u32() as f64 / f64::from(u32::MAX);
        1.0 + self.gain_spread * (2.0 * uniform - 1.0)
    }

    /// Returns `picture` (DN) under this condition.
    pub fn apply(&self, picture: &Plane<u16>, seed: u64) -> Plane<u16> {
        let air_light = AIR_LIGHT * FULL_SCALE;
        let hazy = picture.map(|&dn| air_light + self.contrast * (f64::from(dn) - air_light));
        let blurred = if self.blur > 0.0 { blur(&hazy, self.blur) } else { hazy };
        let gain = self.gain(seed);
        let electrons = self.full_well / FULL_SCALE;
        let mut noisy = Plane::filled(picture.width(), picture.height(), 0u16);
        let rows = noisy.as_mut_slice().par_chunks_exact_mut(picture.width());
        rows.zip(blurred.as_slice().par_chunks_exact(picture.width())).enumerate().for_each(|(y, (to, from))| {
            // One random stream a row, so that rows can be computed in any order. Stream 0 is for the gain.
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(y as u64 + 1);
            for (to, &value) in to.iter_mut().zip(from) {
                let signal = (gain * value * electrons).max(0.0);
                let noise = (signal + READ_NOISE_ELECTRONS * READ_NOISE_ELECTRONS).sqrt() * normal(&mut random);
                // `as` clips to 0 ..= 65535.
                *to = ((signal + noise) / electrons + 0.5).floor() as u16;
            }
        });
        noisy
    }
}

/// Returns a deviate of mean 0 and variance 1 from twelve 16-bit uniform numbers, each with mean 1/2 and variance 1/12.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let mut sum = 0u64;
    for _ in 0..3 {
        let word = random.next_u64();
        sum += (word & 0xffff) + (word >> 16 & 0xffff) + (word >> 32 & 0xffff) + (word >> 48);
    }
    // Each 16-bit number represents the middle of its interval, which adds twelve halves.
    (sum as f64 + 6.0) / 65536.0 - 6.0
}

/// Convolves with the sampled Gaussian of `sigma` (px), unit sum, out to 4 sigma, along rows and then columns, with the
/// border sample repeated.
fn blur(plane: &Plane<f64>, sigma: f64) -> Plane<f64> {
    let half = half_kernel(sigma);
    let along_rows = |plane: &Plane<f64>| {
        let last = plane.width() - 1;
        Plane::from_fn(plane.width(), plane.height(), |x, y| {
            let row = plane.row(y);
            let pair = |k: usize| row[x.saturating_sub(k)] + row[(x + k).min(last)];
            half[0] * row[x] + (1..half.len()).map(|k| half[k] * pair(k)).sum::<f64>()
        })
    };
    along_rows(&along_rows(plane).transposed()).transposed()
}

/// Returns the weights `w_k = q^(k^2) / sum`, `q = exp(-1 / (2 sigma^2))`, for `k = 0 ..= 4 sigma`. `q` is computed by
/// the exponential series and its powers by products, because the `exp` of different machines differs in the last bit.
fn half_kernel(sigma: f64) -> Vec<f64> {
    let exponent = 1.0 / (2.0 * sigma * sigma);
    let (mut term, mut series) = (1.0, 1.0);
    for n in 1..40 {
        term *= exponent / f64::from(n);
        series += term;
    }
    let q = 1.0 / series;
    let (mut weight, mut ratio) = (1.0, q);
    let mut half = vec![weight];
    for _ in 0..(4.0 * sigma).ceil() as usize {
        weight *= ratio;
        ratio *= q * q;
        half.push(weight);
    }
    let sum = half[0] + 2.0 * half[1..].iter().sum::<f64>();
    half.iter_mut().for_each(|weight| *weight /= sum);
    half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sha256;

    fn moments(plane: &Plane<u16>) -> (f64, f64) {
        let count = plane.as_slice().len() as f64;
        let mean = plane.as_slice().iter().map(|&v| f64::from(v)).sum::<f64>() / count;
        let variance = plane.as_slice().iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / count;
        (mean, variance)
    }

    #[test]
    fn noise_of_a_flat_picture_has_the_stated_mean_and_variance() {
        // 256 x 256 samples: the standard error of the mean is sd / 256, of the variance sqrt(2) / 256 = 0.55 %; four
        // of each are allowed.
        for condition in CONDITIONS {
            let dn = 20_000.0;
            let (mean, variance) = moments(&condition.apply(&Plane::filled(256, 256, dn as u16), 5));
            let air_light = 0.55 * 65535.0;
            let expected = condition.gain(5) * (air_light + condition.contrast * (dn - air_light));
            let electrons = condition.full_well / 65535.0;
            let spread = (expected * electrons + 144.0) / electrons.powi(2);
            assert!((mean - expected).abs() < 4.0 * spread.sqrt() / 256.0, "{}: {mean} {expected}", condition.name);
            assert!((variance / spread - 1.0).abs() < 0.022, "{}: {variance} {spread}", condition.name);
        }
    }

    #[test]
    fn kernel_is_the_sampled_gaussian() {
        let half = half_kernel(1.5);
        assert_eq!(half.len(), 7);
        let gaussian = |k: usize| (-((k * k) as f64) / 4.5).exp();
        let sum = gaussian(0) + 2.0 * (1..7).map(gaussian).sum::<f64>();
        for (k, weight) in half.iter().enumerate() {
            assert!((weight - gaussian(k) / sum).abs() < 1e-15, "{k}");
        }
    }

    #[test]
    fn blur_spreads_a_point_by_sigma_both_ways() {
        let point = Plane::from_fn(41, 41, |x, y| if (x, y) == (20, 20) { 1.0 } else { 0.0 });
        let blurred = blur(&point, 1.5);
        let moment = |along: fn((usize, usize)) -> usize| {
            let mut sum = 0.0;
            for y in 0..41 {
                for x in 0..41 {
                    sum += blurred[(x, y)] * (along((x, y)) as f64 - 20.0).powi(2);
                }
            }
            sum
        };
        // Truncation at 4 sigma reduces the variance of 2.25 by 0.1 %.
        assert!((moment(|p| p.0) - 2.25).abs() < 0.01 && (moment(|p| p.1) - 2.25).abs() < 0.01);
    }

    #[test]
    fn dark_and_white_are_clipped_not_wrapped() {
        let white = NOMINAL.apply(&Plane::filled(64, 64, u16::MAX), 3);
        let dark = NOMINAL.apply(&Plane::filled(64, 64, 0), 3);
        assert!(white.as_slice().iter().all(|&v| v > 50_000) && dark.as_slice().iter().all(|&v| v < 1_000));
    }

    #[test]
    fn a_seed_gives_the_same_picture_on_every_machine() {
        let ramp = Plane::from_fn(40, 30, |x, y| (1000 * x + 700 * y) as u16);
        assert_eq!(COMBINED.apply(&ramp, 1), COMBINED.apply(&ramp, 1));
        assert_ne!(COMBINED.apply(&ramp, 1), COMBINED.apply(&ramp, 2));
        // Recorded. A different value changes all acceptance measurements.
        assert_eq!(&sha256(&COMBINED.apply(&ramp, 1))[..16], "8b692f04d9da34e7");
    }
}
