//! The error of the refinement on pictures that are shifted exactly, in the Fourier domain.

use super::refined_pair;
use crate::image::fourier::Spectrum;
use nalgebra::{Matrix3, Vector2};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Side of a picture, which is periodic, px.
const SIDE: usize = 128;

/// Distance of neighbouring patches, px.
const SPACING: usize = 12;

/// Largest bias over the patches of a picture, px.
const MAX_BIAS_PX: f64 = 0.003;

/// Returns the mean and the rms error, px, of the refined positions of a picture whose patches moved by `shift`.
fn error(seed: u64, shift: Vector2<f64>) -> (Vector2<f64>, f64) {
    let spectrum = Spectrum::random(SIDE, seed);
    let [reference, current] = [Vector2::zeros(), shift].map(|shift| spectrum.picture(shift));
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
