//! The SIMD bit-true model: the bits of [`crate::model::bit_true`] at tens of megapixels per second, for states of at
//! most 18 bits, coefficients of at most 16 and responses of at most 15, which includes the default design point.
//!
//! A coefficient of `F < 16` bits is computed as one of 16, `c 2^(16-F)`: product and rounding are the same. It is fast
//! because of:
//!
//! - **A lerp in signed 32-bit arithmetic.** With `e = q - p` and `m = e >> 31` (-1 where `e < 0`), rounding half away
//!   from zero is `round(c e / 2^16) = (c e + 2^15 + m) >> 16`. For `c > 2^15` the complement `c' = 2^16 - c` is at
//!   most `2^15`, and `p + round(c e / 2^16) = q - ((c' e + 2^15 - 1 - m) >> 16)`, which rounds half toward zero
//!   because the term is subtracted. A state has at most 18 bits, so `|e| <= 262143`, and for `c <= 8191` the product
//!   stays below `2^31`. For larger `c`, `e = 4 h + l` splits the product: `(4 c h + c l + bias) >> 16 = (c h + ((c l +
//!   bias) >> 2)) >> 14`, both terms below `2^31` again.
//! - **Strips of 64 columns.** The vertical stages run a few rows apart, in place, so that their rows are in the
//!   L1 cache. Each row then passes all later stages while it is in the cache.
//! - **Maxima from MaxDOG.** A feature equals the maximum of its 5x5 window, MaxDOG, which is already computed. Only
//!   such pixels get the full 7x7 test.
//!
//! The loops are compiled twice, for AVX2 and for the baseline of the target, and selected at run time. Both give the
//! same bits.

mod cell;
mod frame;

use hoverlock_design::{DesignPoint, Format};
use hoverlock_reference::features::dog::Dog;
use hoverlock_reference::features::maxima::is_maximum;
use hoverlock_reference::features::maxlbp::{Layer, Ring};
use hoverlock_reference::image::plane::Plane;

use self::cell::Gain;
use self::frame::{Chain, Gains, Scratch, Words, chain, chain_portable};
use crate::model::bit_true::Planes;
use crate::model::coefficients::{CoefficientError, LerpCoefficients};
use crate::model::design::rings;
use crate::model::record::FeatureRecord;
use crate::model::threshold::{Maxima, floor};

/// The reason why a design has no SIMD model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimdError {
    /// The formats are not supported.
    #[error(
        "the simd model supports states of up to 18 bits, coefficients of up to 16 and a DoG of up to 15 only, \
         not {state}, {coefficient} and {dog_bits} bits"
    )]
    Formats {
        /// Format of the state of the design.
        state: Format,
        /// Format of the coefficients of the design.
        coefficient: Format,
        /// Bits of the DoG of the design.
        dog_bits: u32,
    },
    /// The coefficients cannot be designed.
    #[error(transparent)]
    Coefficient(#[from] CoefficientError),
}

/// The SIMD bit-true model. It reuses its planes, so that frames of equal size need no allocation.
#[derive(Debug, Clone)]
pub struct SimdBitTrue {
    gains: Vec<Gains>,
    words: Words,
    /// Lowest automatic threshold, LSB of the DoG.
    floor: u16,
    planes: Planes,
    scratch: Scratch,
    features: Vec<FeatureRecord>,
    maxima: Vec<Maxima>,
}

impl SimdBitTrue {
    /// Designs the coefficients of a design and makes its model.
    ///
    /// # Errors
    /// The formats are not supported, or the coefficients cannot be designed.
    pub fn new(design: &DesignPoint) -> Result<Self, SimdError> {
        let DesignPoint { state, coefficient, dog_bits, .. } = *design;
        if state.bits() > 18 || coefficient.bits() > 16 || dog_bits > 15 {
            return Err(SimdError::Formats { state, coefficient, dog_bits });
        }
        let gains = |(sigma, look_ahead): (&f64, &u32)| {
            let gain = |raw: u32| Gain::new(raw << (16 - coefficient.bits()));
            LerpCoefficients::design(*sigma, *look_ahead, coefficient.bits()).map(|coefficients| Gains {
                g: gain(coefficients.g),
                g_j: coefficients.g_j.into_iter().map(gain).collect(),
            })
        };
        Ok(Self {
            gains: design.sigmas.iter().zip(&*design.look_ahead).map(gains).collect::<Result<_, _>>()?,
            words: Words::new(design),
            floor: floor(design) as u16,
            planes: blank(&rings(design), 1, 1),
            scratch: Scratch::default(),
            features: Vec::new(),
            maxima: Vec::new(),
        })
    }

    /// Processes a frame in steps of the camera and returns its features. They and [`SimdBitTrue::planes`] equal those
    /// of [`crate::model::bit_true`]. A scale pair without a threshold has no features.
    pub fn frame(&mut self, pixels: &Plane<u16>, thresholds: &[u32]) -> &[FeatureRecord] {
        self.run(pixels, thresholds, chain)
    }

    /// Processes a frame as [`SimdBitTrue::frame`], in portable code that any processor of the target executes.
    pub fn portable_frame(&mut self, pixels: &Plane<u16>, thresholds: &[u32]) -> &[FeatureRecord] {
        self.run(pixels, thresholds, chain_portable)
    }

    /// Returns all planes of the last frame; one black pixel before the first frame.
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// Returns all planes of the last frame without copying them.
    pub fn into_planes(self) -> Planes {
        self.planes
    }

    /// Returns the features of the last frame, in order.
    pub fn features(&self) -> &[FeatureRecord] {
        &self.features
    }

    /// Returns the eligible maxima of each scale pair in the last frame: those that reach its threshold or the
    /// [`floor`] of automatic ones.
    pub fn maxima(&self) -> &[Maxima] {
        &self.maxima
    }

    fn run(&mut self, pixels: &Plane<u16>, thresholds: &[u32], chain: Chain) -> &[FeatureRecord] {
        let (width, height) = (pixels.width(), pixels.height());
        let shape = &self.planes.smoothed[0];
        if (width, height) != (shape.width(), shape.height()) {
            let rings: Vec<Ring> = self.planes.layers.iter().map(|layer| layer.ring).collect();
            self.planes = blank(&rings, width, height);
        }
        // A response has 15 bits, so none reaches 2^16 - 1.
        let mut thresholds: Vec<u16> =
            thresholds.iter().map(|threshold| u16::try_from((*threshold).max(1)).unwrap_or(u16::MAX)).collect();
        thresholds.resize(self.gains.len() - 1, u16::MAX);
        let lowest: Vec<u16> = thresholds.iter().map(|threshold| self.floor.min(*threshold)).collect();
        chain(pixels, &self.gains, self.words, &lowest, &mut self.planes, &mut self.scratch);

        let candidates = &mut self.scratch.candidates;
        let magnitude = |k: usize| &self.planes.layers[k].dog.magnitude;
        candidates.retain(|&(y, x, k)| is_maximum(magnitude(k), x, y));
        let mut responses = vec![Vec::new(); thresholds.len()];
        candidates.iter().for_each(|&(y, x, k)| responses[k].push(magnitude(k)[(x, y)]));
        self.maxima = responses.into_iter().map(Maxima::new).collect();
        candidates.retain(|&(y, x, k)| magnitude(k)[(x, y)] >= thresholds[k]);
        candidates.sort_unstable();
        self.features.clear();
        self.features.extend(candidates.iter().map(|&(y, x, k)| self.planes.record(x, y, k)));
        &self.features
    }
}

fn blank(rings: &[Ring], width: usize, height: usize) -> Planes {
    let pairs = rings.len();
    let layer = |ring: &Ring| Layer {
        dog: Dog { magnitude: Plane::filled(width, height, 0), positive: Plane::filled(width, height, true) },
        max_dog: Plane::filled(width, height, 0),
        ring: *ring,
    };
    Planes {
        smoothed: vec![Plane::filled(width, height, 0); pairs + 1],
        signed_dog: vec![Plane::filled(width, height, 0); pairs],
        layers: rings.iter().map(layer).collect(),
        saturated: vec![0; pairs],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::bit_true::BitTrue;
    use crate::model::design::camera_samples;
    use crate::pictures::{Content, Picture, pictures};
    use hoverlock_design::{KT27, SHIPPED};
    use proptest::prelude::*;

    #[test]
    fn the_gains_are_those_of_the_bit_true_coefficients() {
        let simd = SimdBitTrue::new(&KT27).unwrap();
        let bit_true = BitTrue::new(&KT27).unwrap();
        for (gains, coefficients) in simd.gains.iter().zip(bit_true.coefficients()) {
            assert_eq!(gains.g, Gain::new(coefficients.g));
            assert!(gains.g_j.iter().copied().eq(coefficients.g_j.iter().copied().map(Gain::new)));
        }
    }

    #[test]
    fn unsupported_formats_are_refused() {
        for text in ["state=u16.3", "coefficient=u0.17", "dog_bits=16"] {
            let message = SimdBitTrue::new(&KT27.with_override(text).unwrap()).unwrap_err().to_string();
            assert!(message.contains("only, not"), "{message}");
        }
    }

    #[test]
    fn a_full_frame_equals_the_bit_true_model() {
        let content = Content::Noise { low: 20_000, high: 30_000 };
        let frame = Picture { width: 1024, height: 768, seed: 11, content }.draw();
        let planes = BitTrue::new(&KT27).unwrap().planes(&frame);
        let features = planes.features(&[300, 200]);
        assert!(features.len() > 800, "{}", features.len());
        let mut simd = SimdBitTrue::new(&KT27).unwrap();
        assert_eq!(simd.frame(&frame, &[300, 200]), features);
        assert!(*simd.planes() == planes);
        assert_eq!(simd.portable_frame(&frame, &[300, 200]), features);
        assert!(*simd.planes() == planes);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn every_format_it_takes_equals_the_bit_true_model(
            picture in pictures(80),
            words in (8..=16i8, 0..=10i8, 6..=16i8, 4..=15u32),
            shipped in prop::option::of(0..SHIPPED.len()),
            pairs in 1..=3u32,
            radii in prop::array::uniform3(4..=16u32),
        ) {
            let (pixel, fraction, coefficient, dog_bits) = words;
            let design = match shipped {
                Some(i) => DesignPoint::from_file(SHIPPED[i].1).unwrap(),
                None => DesignPoint {
                    pixel: Format::unsigned(pixel, 0),
                    state: Format::unsigned(pixel, fraction.min(18 - pixel)),
                    coefficient: Format::unsigned(0, coefficient),
                    dog_bits,
                    scale_pairs: pairs,
                    sigmas: [2.0, 3.2, 5.12, 8.2][..=pairs as usize].to_vec(),
                    look_ahead: [2, 3, 3, 2][..=pairs as usize].to_vec(),
                    ring_radii: radii[..pairs as usize].to_vec(),
                    ..KT27.clone()
                },
            };
            let Ok(bit_true) = BitTrue::new(&design) else { return Ok(()) };
            let frame = camera_samples(&design, &picture.draw());
            let planes = bit_true.planes(&frame);
            let mut simd = SimdBitTrue::new(&design).unwrap();
            prop_assert_eq!(simd.frame(&frame, &[2, 3, 5]), planes.features(&[2, 3, 5]));
            prop_assert!(simd.planes() == &planes, "planes differ: {}", design.to_toml());
            prop_assert_eq!(simd.portable_frame(&frame, &[2, 3, 5]), planes.features(&[2, 3, 5]));
        }

        #[test]
        fn planes_and_features_equal_the_bit_true_model(frames in prop::collection::vec(pictures(110), 1..3)) {
            let bit_true = BitTrue::new(&KT27).unwrap();
            let mut simd = SimdBitTrue::new(&KT27).unwrap();
            let mut portable = simd.clone();
            for frame in &frames {
                let frame = &frame.draw();
                let planes = bit_true.planes(frame);
                for thresholds in [&[1, 1], &[40, 700], &[0, 70_000]] {
                    let features = planes.features(thresholds);
                    prop_assert_eq!(simd.frame(frame, thresholds), &features[..]);
                    prop_assert_eq!(portable.portable_frame(frame, thresholds), &features[..]);
                    prop_assert!(simd.planes() == &planes, "planes differ");
                    prop_assert!(portable.planes() == &planes, "planes of the portable path differ");
                }
            }
        }
    }
}
