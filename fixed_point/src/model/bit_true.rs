//! The bit-true model: the integer arithmetic of the hardware, for any formats and any frame from 1 x 1.
//!
//! A frame of pixels `x` of `P` bits becomes the state `x << f`; the smoothers (the chains of
//! [`crate::model::stages`] with the integer [`lerp`]) give `G_0, G_1 ..`, one more than scale pairs. Then, with `f`
//! the state's fraction bits, `N` the DoG's bits and `s = f + P - 2 - N`:
//!
//! ```text
//! d_k       = G_k - G_{k+1}                               state LSB, signed
//! sign_k    = 1 where d_k >= 0                            before rounding
//! DOG_k     = min((|d_k| + 2^(s-1)) >> s, 2^N - 1)        half up; s <= 0: |d_k| << -s; saturated samples are counted
//! MaxDOG_k  = max of DOG_k over (2 D + 1)^2 pixels        the border sample repeated
//! feature   : DOG_k(p) >= T_k, DOG_k(p) > earlier and >= later samples, in raster order, of its 7x7 window
//! MaxLBP_k  : bit i = DOG_k(p) >= MaxDOG_k(p + o_i),      o_i = round(R_k (cos, sin)(2 pi i / 32)), x right, y down
//! sign word : bit i = sign_k(p + o_i)
//! ```
//!
//! **Eligible pixels.** A centre is eligible where `18 <= x < W - 18` and `18 <= y < H - 18`, for all scales, so no
//! window leaves the frame, and frames of less than 37 rows or columns have no features. The window test uses all 48
//! neighbours, eligible or not. Windows, rings and the tie rule are those of [`hoverlock_reference::features::maxima`]
//! and [`hoverlock_reference::features::maxlbp`], which support integers and floats.
//!
//! **Order.** Raster order of the pixel; at one pixel the finer scale first. Of equal responses in one window the
//! first in raster order is the feature: the comparison is strict against earlier pixels only, so a tie gives exactly
//! one feature.
//!
//! **Dropped records.** The list of the model is complete. The hardware drops records while its feature FIFO is full.
//! It counts them and keeps the order of the others, so emitted + dropped is the length of this list.

use hoverlock_reference::features::dog::Dog;
use hoverlock_reference::features::maxima::maxima;
use hoverlock_reference::features::maxlbp::{Layer, descriptor};
use hoverlock_reference::image::plane::Plane;

use crate::model::coefficients::{CoefficientError, LerpCoefficients};
use crate::model::design::rings;
use crate::model::lerp::lerp;
use crate::model::record::FeatureRecord;
use crate::model::stages::{self, Stage, StageCoefficients};
use crate::model::threshold::Maxima;
use hoverlock_design::DesignPoint;

/// The planes of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Planes {
    /// `G_0, G_1 ..`, state LSB.
    pub smoothed: Vec<Plane<u32>>,
    /// `d_k`, state LSB.
    pub signed_dog: Vec<Plane<i32>>,
    /// `DOG_k` and `MaxDOG_k`, LSB of the DoG, and the sign bits.
    pub layers: Vec<Layer<u16>>,
    /// Samples of `DOG_k` that saturated; the hardware has one sticky bit that is set where this is not 0.
    pub saturated: Vec<u64>,
}

/// The bit-true model of one design point.
#[derive(Debug, Clone, PartialEq)]
pub struct BitTrue {
    design: DesignPoint,
    coefficients: Vec<StageCoefficients<u32>>,
}

impl BitTrue {
    /// Designs the coefficients of a design and makes its model.
    ///
    /// # Errors
    /// A smoother cannot be designed for one of the sigmas or cannot be rounded to the coefficient format.
    pub fn new(design: &DesignPoint) -> Result<Self, CoefficientError> {
        let coefficients = |(sigma, look_ahead): (&f64, &u32)| {
            LerpCoefficients::design(*sigma, *look_ahead, design.coefficient.bits()).map(StageCoefficients::from)
        };
        let coefficients = design.sigmas.iter().zip(&*design.look_ahead).map(coefficients).collect::<Result<_, _>>()?;
        Ok(Self { design: design.clone(), coefficients })
    }

    /// Returns the design of the model.
    pub fn design(&self) -> &DesignPoint {
        &self.design
    }

    /// Returns the raw coefficients of the smoothers.
    pub fn coefficients(&self) -> &[StageCoefficients<u32>] {
        &self.coefficients
    }

    /// Returns the same model with other raw coefficients: `g`, then each `g_j`, smoother by smoother, in the order of
    /// the registers. Coefficients missing at the end of `raw` are unchanged.
    pub fn with_coefficients(&self, raw: &[u32]) -> Self {
        let mut model = self.clone();
        let own = model
            .coefficients
            .iter_mut()
            .flat_map(|coefficients| std::iter::once(&mut coefficients.g).chain(&mut coefficients.g_j));
        for (own, raw) in own.zip(raw) {
            *own = *raw;
        }
        model
    }

    /// Converts pixels, `x < 2^P` steps of the camera, to filter states, `x << f`.
    pub fn state(&self, pixels: &Plane<u16>) -> Plane<u32> {
        debug_assert!(pixels.as_slice().iter().all(|pixel| i64::from(*pixel) <= self.design.pixel.max_raw()));
        let fraction_bits = self.design.state.fraction_bits();
        pixels.map(|pixel| u32::from(*pixel) << fraction_bits)
    }

    /// Smooths the states by one smoother; `each` gets the output of every stage.
    pub fn smooth(&self, smoother: usize, state: &Plane<u32>, each: impl FnMut(Stage, &Plane<u32>)) -> Plane<u32> {
        let fraction_bits = self.design.coefficient.bits();
        stages::smooth(state, &self.coefficients[smoother], |p, q, raw| lerp(p, q, raw, fraction_bits), each)
    }

    /// Smooths the states by one smoother, without showing its stages.
    pub fn smoothed(&self, smoother: usize, state: Plane<u32>) -> Plane<u32> {
        let fraction_bits = self.design.coefficient.bits();
        stages::smoothed(state, &self.coefficients[smoother], |p, q, raw| lerp(p, q, raw, fraction_bits))
    }

    /// Subtracts two smoothed planes: `d_k`, LSB of the state.
    pub fn signed_dog(narrow: &Plane<u32>, wide: &Plane<u32>) -> Plane<i32> {
        narrow.zip_map(wide, |narrow, wide| *narrow as i32 - *wide as i32)
    }

    /// Rounds `d_k` to `DOG_k` with its sign bits, LSB of the DoG, and returns the number of saturated samples.
    pub fn dog(&self, signed: &Plane<i32>) -> (Dog<u16>, u64) {
        let (shift, max) = (self.design.dog_shift(), u64::from(self.design.max_dog()));
        let mut saturated = 0;
        let magnitude = signed.map(|d| {
            let magnitude = u64::from(d.unsigned_abs());
            let rounded = if shift > 0 { (magnitude + (1 << (shift - 1))) >> shift } else { magnitude << -shift };
            saturated += u64::from(rounded > max);
            rounded.min(max) as u16
        });
        (Dog { magnitude, positive: signed.map(|d| *d >= 0) }, saturated)
    }

    /// Returns all planes of a frame. `pixels` is in steps of the camera; see
    /// [`camera_samples`](crate::model::design::camera_samples).
    pub fn planes(&self, pixels: &Plane<u16>) -> Planes {
        let state = self.state(pixels);
        let smooth = |smoother| self.smoothed(smoother, state.clone());
        self.planes_of((0..self.design.smoothers()).map(smooth).collect())
    }

    /// Computes all planes of a frame from its smoothed planes.
    pub fn planes_of(&self, smoothed: Vec<Plane<u32>>) -> Planes {
        let signed_dog: Vec<_> = smoothed.windows(2).map(|pair| Self::signed_dog(&pair[0], &pair[1])).collect();
        let dogs = signed_dog.iter().map(|signed| self.dog(signed));
        let layers = dogs.zip(rings(&self.design)).map(|((dog, saturated), ring)| (Layer::new(dog, ring), saturated));
        let (layers, saturated) = layers.unzip();
        Planes { smoothed, signed_dog, layers, saturated }
    }
}

impl Planes {
    /// Returns all features of the frame, in order. `thresholds` are in LSB of the DoG; 0 counts as 1. A scale pair
    /// without a threshold has no features.
    pub fn features(&self, thresholds: &[u32]) -> Vec<FeatureRecord> {
        let mut positions = Vec::new();
        for (k, (layer, threshold)) in self.layers.iter().zip(thresholds).enumerate() {
            // A response has 16 bits, so none reaches a larger threshold.
            if let Ok(threshold) = u16::try_from((*threshold).max(1)) {
                positions.extend(maxima(&layer.dog.magnitude, threshold).into_iter().map(|(x, y)| (y, x, k)));
            }
        }
        positions.sort_unstable();
        positions.into_iter().map(|(y, x, k)| self.record(x, y, k)).collect()
    }

    /// Returns the eligible maxima of each scale pair.
    pub fn maxima(&self) -> Vec<Maxima> {
        let of_layer = |layer: &Layer<u16>| {
            let magnitude = &layer.dog.magnitude;
            Maxima::new(maxima(magnitude, 1).into_iter().map(|at| magnitude[at]).collect())
        };
        self.layers.iter().map(of_layer).collect()
    }

    /// Returns the record of scale pair `k` at an eligible pixel.
    pub(crate) fn record(&self, x: usize, y: usize, k: usize) -> FeatureRecord {
        let Dog { magnitude, positive } = &self.layers[k].dog;
        FeatureRecord {
            x: x as u16,
            y: y as u16,
            response: magnitude[(x, y)],
            scale: k as u8,
            bright: positive[(x, y)],
            neighbours: [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)].map(|at| magnitude[at]),
            descriptor: descriptor(&self.layers, x, y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::threshold::count_per_scale;
    use crate::pictures::pictures;
    use hoverlock_design::{Format, KT27};
    use proptest::prelude::*;

    /// Returns a design with other word lengths, reach and sigmas.
    fn design(state: i8, coefficient: i8, dog_bits: u32, look_ahead: &[u32]) -> DesignPoint {
        DesignPoint {
            state: Format::unsigned(16, state),
            coefficient: Format::unsigned(0, coefficient),
            dog_bits,
            scale_pairs: look_ahead.len() as u32 - 1,
            sigmas: [2.0, 3.2, 5.12, 8.2][..look_ahead.len()].to_vec(),
            look_ahead: look_ahead.to_vec(),
            ring_radii: [9, 16, 13][..look_ahead.len() - 1].to_vec(),
            ..KT27.clone()
        }
    }

    /// Returns `numerator / 2^bits`, rounded half away from zero, in wide signed integers: another formula than
    /// [`lerp`].
    fn half_away(numerator: i128, bits: u32) -> i128 {
        let half = 1i128 << (bits - 1);
        if numerator >= 0 { (numerator + half) >> bits } else { -((-numerator + half) >> bits) }
    }

    /// Applies one smoother from the equations, sample by sample.
    fn smoothed(x: &[Vec<i128>], coefficients: &StageCoefficients<u32>, bits: u32) -> Vec<Vec<i128>> {
        let (height, width) = (x.len(), x[0].len());
        let lerp = |p: i128, q: i128, raw: u32| p + half_away(i128::from(raw) * (q - p), bits);
        let at = |u: &[Vec<i128>], r: i64, c: i64| {
            u[r.clamp(0, height as i64 - 1) as usize][c.clamp(0, width as i64 - 1) as usize]
        };
        let mut u = x.to_vec();
        for (dr, dc) in [(1, 0), (0, -1), (0, 1)] {
            let mut stages: Vec<_> = coefficients.g_j.iter().enumerate().collect();
            if dr == 1 {
                stages.reverse();
            }
            for (j, raw) in stages {
                let step = 1i64 << j;
                let before = u.clone();
                for r in 0..height {
                    for c in 0..width {
                        let p = at(&before, r as i64 + dr * step, c as i64 + dc * step);
                        u[r][c] = lerp(p, before[r][c], *raw);
                    }
                }
            }
            if dr == 1 {
                for r in 1..height {
                    let above = u[r - 1].clone();
                    u[r].iter_mut().zip(above).for_each(|(s, p)| *s = lerp(p, *s, coefficients.g));
                }
            }
        }
        u
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn planes_and_features_agree_with_the_equations(
            picture in pictures(60),
            (state, coefficient, dog_bits) in (0i8..=12, 6i8..=31, 2u32..=16),
            look_ahead in prop::collection::vec(1u32..=7, 2..=4),
            thresholds in prop::array::uniform3(prop_oneof![0u32..50, 0..5000u32]),
        ) {
            let pixels = picture.draw();
            let (width, height) = (pixels.width(), pixels.height());
            let design = design(state, coefficient, dog_bits, &look_ahead);
            let thresholds = &thresholds[..design.pairs()];
            let model = BitTrue::new(&design).unwrap();
            let planes = model.planes(&pixels);
            let state_row = |row: &[u16]| row.iter().map(|p| i128::from(*p) << state).collect();
            let x: Vec<Vec<i128>> = pixels.rows().map(state_row).collect();
            let g: Vec<_> = model.coefficients().iter().map(|of| smoothed(&x, of, coefficient as u32)).collect();
            for (smoothed, plane) in g.iter().zip(&planes.smoothed) {
                let samples: Vec<i128> = plane.as_slice().iter().map(|s| i128::from(*s)).collect();
                prop_assert!(smoothed.iter().flatten().eq(samples.iter()));
            }
            // 2^14 DN, a quarter of full scale, are 2^N LSB.
            let d = |k: usize, r: usize, c: usize| g[k][r][c] - g[k + 1][r][c];
            let dog =
                |k: usize, r: usize, c: usize| half_away(d(k, r, c).abs() << dog_bits, u32::from(state as u8) + 14);
            let most = (1i128 << dog_bits) - 1;
            for k in 0..design.pairs() {
                let mut saturated = 0;
                for r in 0..height {
                    for c in 0..width {
                        let layer = &planes.layers[k];
                        prop_assert_eq!(i128::from(planes.signed_dog[k][(c, r)]), d(k, r, c));
                        prop_assert_eq!(layer.dog.positive[(c, r)], d(k, r, c) >= 0);
                        prop_assert_eq!(i128::from(layer.dog.magnitude[(c, r)]), dog(k, r, c).min(most));
                        saturated += u64::from(dog(k, r, c) > most);
                        let window = (r.saturating_sub(2)..=(r + 2).min(height - 1))
                            .flat_map(|y| (c.saturating_sub(2)..=(c + 2).min(width - 1)).map(move |x| (x, y)));
                        let max = window.map(|at| layer.dog.magnitude[at]).max();
                        prop_assert_eq!(Some(layer.max_dog[(c, r)]), max);
                    }
                }
                prop_assert_eq!(planes.saturated[k], saturated);
            }

            let mut expected = Vec::new();
            for y in 18..height.saturating_sub(18) {
                for x in 18..width.saturating_sub(18) {
                    for (k, threshold) in thresholds.iter().enumerate() {
                        let dog = &planes.layers[k].dog.magnitude;
                        let centre = dog[(x, y)];
                        let exceeds = |dx: usize, dy: usize| {
                            let other = dog[(x + dx - 3, y + dy - 3)];
                            if dy * 7 + dx < 24 { centre > other } else { centre >= other }
                        };
                        let wins = (0..49).all(|i| exceeds(i % 7, i / 7));
                        if wins && u32::from(centre) >= (*threshold).max(1) {
                            expected.push((x as u16, y as u16, k as u8));
                        }
                    }
                }
            }
            let found = planes.features(thresholds);
            prop_assert_eq!(found.iter().map(|f| (f.x, f.y, f.scale)).collect::<Vec<_>>(), expected);
            for feature in &found {
                let (x, y, k) = (usize::from(feature.x), usize::from(feature.y), usize::from(feature.scale));
                let dog = &planes.layers[k].dog;
                prop_assert_eq!(feature.response, dog.magnitude[(x, y)]);
                prop_assert_eq!(feature.bright, planes.signed_dog[k][(x, y)] >= 0);
                let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                prop_assert_eq!(feature.neighbours, around.map(|at| dog.magnitude[at]));
                for (scale, layer) in planes.layers.iter().enumerate() {
                    for i in 0..32 {
                        let (sin, cos) = (f64::from(i) * 11.25).to_radians().sin_cos();
                        let radius = f64::from(design.ring_radii[scale]);
                        let [dx, dy] = [cos, sin].map(|part| (radius * part).round() as isize);
                        let at = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                        let bits = (feature.descriptor.maxlbp[scale] >> i & 1, feature.descriptor.sign[scale] >> i & 1);
                        let maxlbp = layer.dog.magnitude[(x, y)] >= layer.max_dog[at];
                        prop_assert_eq!(bits, (u32::from(maxlbp), u32::from(planes.signed_dog[scale][at] >= 0)));
                    }
                }
            }
            prop_assert_eq!(count_per_scale(&found).iter().sum::<u32>() as usize, found.len());
        }
    }

    #[test]
    fn coefficients_are_those_of_the_specification() {
        let model = BitTrue::new(&KT27).unwrap();
        let table = [
            (24536, vec![40315, 47101, 56830, 64033, 65500]),
            (17102, vec![37685, 42386, 50478, 60180, 65021]),
            (11450, vec![35905, 38984, 44768, 53931, 62636, 65396]),
        ];
        assert_eq!(*model.coefficients(), table.map(|(g, g_j)| StageCoefficients { g, g_j }));
    }

    #[test]
    fn saturated_samples_are_counted_and_clipped() {
        // Two bits over a quarter of full scale round up to 4 from 7/8 of it on: a white spot of 6 px radius gives 0.22
        // FS or more in the coarse pair, and two bits represent at most 3.
        let spot =
            Plane::from_fn(
                128,
                128,
                |x, y| {
                    if x.abs_diff(64).pow(2) + y.abs_diff(64).pow(2) <= 36 { u16::MAX } else { 0 }
                },
            );
        let planes = BitTrue::new(&design(2, 16, 2, &KT27.look_ahead)).unwrap().planes(&spot);
        assert!(f64::from(planes.signed_dog[1][(64, 64)]) >= 0.22 * 262_140.0);
        assert!(planes.saturated[1] > 0);
        assert_eq!(planes.layers[1].dog.magnitude[(64, 64)], 3);
    }
}
