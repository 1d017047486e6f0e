//! The model levels, from the ideal filter to the RTL. Each level adds one cause of error.
//!
//! | level | what changes against the level above |
//! |---|---|
//! | `ideal` | the sampled Gaussian, f64 |
//! | `recursive` | the two-sided first-order recursion, f64, whole frame, the border sample repeated |
//! | `streaming` | column look-ahead, row look-back and row look-ahead span `2^m - 1` samples only, f64 |
//! | `quantised` | `streaming` with the coefficients rounded |
//! | `bit_true` | `quantised` in integers: the bit-true model |
//! | `rtl` | the emitted Verilog, simulated; it gives the bits of `bit_true` |
//!
//! With another smoother than the first-order one (key `smoother`) `recursive` is that smoother, and `quantised` is
//! `recursive` with rounded coefficients of its direct form. `streaming`, `bit_true` and `rtl` stay first-order.
//!
//! Frames are pictures of 16-bit samples, which every level first takes as the camera does: in its steps, `2^(16-P)` DN
//! for `P` bits. `recursive` smooths the columns upward first, then downward, as the levels below it do: the two orders
//! differ at the upper and the lower border, where each pass repeats its own border sample.
//!
//! All planes are in DN, `0 ..= 65535`, at every level. Those of `bit_true` are exact, because its
//! integers are whole multiples of a power of two. *Approximation* is a level against `ideal`,
//! *quantisation* against `streaming`.

use rayon::prelude::*;
use serde::Serialize;

use hoverlock_reference::features::dog::Dog;
use hoverlock_reference::features::extractor;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::features::maxlbp::{Layer, Ring, max_dog};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::recursive::Recursive;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::recursive::direct_form::DirectForm;
use hoverlock_reference::smoothing::recursive::first_order;
use hoverlock_reference::smoothing::smoother::Smoother;

use crate::analysis::worst_case;
use crate::model::bit_true::{BitTrue, Planes};
use crate::model::coefficients::CoefficientError;
use crate::model::coefficients::direct_form::IntegerDirectForm;
use crate::model::design::{camera_samples, recursive, rings};
use crate::model::record::FeatureRecord;
use crate::model::simd::SimdBitTrue;
use crate::model::stages::{self, Stage, StageCoefficients};
use hoverlock_design::{DesignPoint, SmootherKind};

/// A model level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// The sampled Gaussian, f64.
    Ideal,
    /// The recursive smoother, f64.
    Recursive,
    /// Finite look-ahead and look-back, f64.
    Streaming,
    /// Rounded coefficients, f64 arithmetic.
    Quantised,
    /// Integer arithmetic: the bit-true model.
    BitTrue,
    /// The emitted Verilog. It is simulated, not computed here.
    Rtl,
}

impl Level {
    /// All levels in order.
    pub const ALL: [Level; 6] =
        [Level::Ideal, Level::Recursive, Level::Streaming, Level::Quantised, Level::BitTrue, Level::Rtl];

    /// The levels that [`Levels`] computes: all but `rtl`.
    pub const MODELS: [Level; 5] = [Level::Ideal, Level::Recursive, Level::Streaming, Level::Quantised, Level::BitTrue];

    /// Returns the name, as in the table of this module.
    pub fn name(self) -> &'static str {
        match self {
            Level::Ideal => "ideal",
            Level::Recursive => "recursive",
            Level::Streaming => "streaming",
            Level::Quantised => "quantised",
            Level::BitTrue => "bit_true",
            Level::Rtl => "rtl",
        }
    }
}

impl std::fmt::Display for Level {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// All planes of one level, in DN of the camera sample.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelPlanes {
    /// `G_0, G_1 ..`, one more than scale pairs.
    pub smoothed: Vec<Plane<f64>>,
    /// `d_k = G_k - G_{k+1}`; in `bit_true` before it is rounded to an LSB of the DoG.
    pub signed_dog: Vec<Plane<f64>>,
    /// `DOG_k`, the magnitude of `d_k`.
    pub dog: Vec<Plane<f64>>,
    /// `MaxDOG_k`, the maximum of `DOG_k` over a window.
    pub max_dog: Vec<Plane<f64>>,
    /// The rings of the descriptors.
    pub rings: Vec<Ring>,
}

impl LevelPlanes {
    /// Computes the planes of a float level from its smoothed planes, one more than rings.
    pub fn of(smoothed: Vec<Plane<f64>>, rings: Vec<Ring>) -> Self {
        let signed_dog: Vec<_> =
            smoothed.windows(2).map(|pair| pair[0].zip_map(&pair[1], |narrow, wide| narrow - wide)).collect();
        let dog: Vec<_> = signed_dog.iter().map(|plane| plane.map(|d: &f64| d.abs())).collect();
        let max_dog = dog.iter().map(max_dog).collect();
        Self { smoothed, signed_dog, dog, max_dog, rings }
    }

    /// Returns DoG, sign and MaxDOG of all scale pairs, from which features and descriptors are computed.
    pub fn layers(&self) -> Vec<Layer<f64>> {
        let layer = |(k, ring): (usize, &Ring)| Layer {
            dog: Dog { magnitude: self.dog[k].clone(), positive: self.signed_dog[k].map(|d| *d >= 0.0) },
            max_dog: self.max_dog[k].clone(),
            ring: *ring,
        };
        self.rings.iter().enumerate().map(layer).collect()
    }

    /// Converts the planes into those of [`LevelPlanes::layers`] and the signed responses `sign_k * DOG_k`, without
    /// copying them.
    pub(crate) fn into_layers(self) -> (Vec<Layer<f64>>, Vec<Plane<f64>>) {
        let (mut layers, mut responses) = (Vec::new(), Vec::new());
        let scales = self.signed_dog.into_iter().zip(self.dog).zip(self.max_dog).zip(self.rings);
        for (((mut signed, magnitude), max_dog), ring) in scales {
            let positive = signed.map(|d| *d >= 0.0);
            let samples = signed.as_mut_slice().iter_mut().zip(magnitude.as_slice());
            samples.for_each(|(d, magnitude)| *d = magnitude.copysign(*d));
            layers.push(Layer { dog: Dog { magnitude, positive }, max_dog, ring });
            responses.push(signed);
        }
        (layers, responses)
    }
}

/// A frame after the two passes of one smoother, in DN of the camera sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// After the vertical pass: recursion and look-ahead down the columns.
    pub columns: Plane<f64>,
    /// After the horizontal pass.
    pub rows: Plane<f64>,
}

/// The levels of one design point.
#[derive(Debug, Clone)]
pub struct Levels {
    design: DesignPoint,
    ideal: Vec<Smoother>,
    recursive: Vec<Smoother>,
    streaming: Vec<StageCoefficients<f64>>,
    /// The rounded coefficients of the first-order filters.
    rounded: Vec<StageCoefficients<f64>>,
    /// The rounded filters of another family; empty for first order.
    rounded_forms: Vec<DirectForm>,
    bit_true: BitTrue,
}

impl Levels {
    /// Designs all levels.
    ///
    /// # Errors
    /// A filter cannot be designed for one of the sigmas or cannot be rounded to the coefficient format.
    pub fn new(design: &DesignPoint) -> Result<Self, CoefficientError> {
        let bit_true = BitTrue::new(design)?;
        let streaming = |(sigma, look_ahead): (&f64, &u32)| {
            first_order::pole(*sigma).map(|a| StageCoefficients::of_pole(a, *look_ahead))
        };
        let sigmas = || design.sigmas.iter();
        let rounded = |coefficients: &StageCoefficients<u32>| coefficients.values(design.coefficient);
        let filters = sigmas().map(|sigma| recursive(design, *sigma)).collect::<Result<Vec<_>, _>>()?;
        let form = |filter: &Recursive| {
            IntegerDirectForm::round(&filter.direct_form(), filter.sigma(), design.coefficient.bits())
                .map(|integers| integers.real())
        };
        let forms = filters.iter().filter(|_| design.smoother != SmootherKind::FirstOrder).map(form);
        Ok(Self {
            design: design.clone(),
            ideal: sigmas().map(|sigma| Smoother::gaussian(*sigma)).collect::<Result<_, _>>()?,
            rounded_forms: forms.collect::<Result<_, _>>()?,
            recursive: filters.into_iter().map(Smoother::Recursive).collect(),
            streaming: sigmas().zip(&*design.look_ahead).map(streaming).collect::<Result<_, _>>()?,
            rounded: bit_true.coefficients().iter().map(rounded).collect(),
            bit_true,
        })
    }

    /// Returns the design of these levels.
    pub fn design(&self) -> &DesignPoint {
        &self.design
    }

    /// Returns the model of the level `bit_true`, in raw integers.
    pub fn bit_true(&self) -> &BitTrue {
        &self.bit_true
    }

    /// Returns the level that `quantised` differs from by its rounded coefficients alone.
    pub fn unrounded(&self) -> Level {
        if self.rounded_forms.is_empty() { Level::Streaming } else { Level::Recursive }
    }

    /// Returns the first-order coefficients of `streaming` (unrounded) or `bit_true` (rounded) as real numbers; `None`
    /// for the other levels.
    pub fn coefficients(&self, level: Level) -> Option<&[StageCoefficients<f64>]> {
        match level {
            Level::Ideal | Level::Recursive | Level::Quantised | Level::Rtl => None,
            Level::Streaming => Some(&self.streaming),
            Level::BitTrue => Some(&self.rounded),
        }
    }

    /// Smooths by one of the smoothers and passes every stage's output, in order, to `each`.
    ///
    /// # Panics
    /// For levels other than `streaming`, `bit_true` and a first-order `quantised`: they have no stages.
    pub fn stages(
        &self,
        level: Level,
        smoother: usize,
        pixels: &Plane<u16>,
        mut each: impl FnMut(Stage, &Plane<f64>),
    ) -> Plane<f64> {
        let float = |coefficients: &StageCoefficients<f64>, each: &mut dyn FnMut(Stage, &Plane<f64>)| {
            stages::smooth(&self.dn(pixels), coefficients, |p, q, c| p + c * (q - p), each)
        };
        match level {
            Level::Ideal | Level::Recursive | Level::Rtl => panic!("the level {level} has no stages"),
            Level::Streaming => float(&self.streaming[smoother], &mut each),
            Level::Quantised if !self.rounded_forms.is_empty() => panic!("another smoother has no stages"),
            Level::Quantised => float(&self.rounded[smoother], &mut each),
            Level::BitTrue => {
                let lsb = self.design.state_dn().lsb();
                let state = self.state(pixels);
                let show = |stage, plane: &Plane<u32>| each(stage, &plane.map(|raw| f64::from(*raw) * lsb));
                self.bit_true.smooth(smoother, &state, show).map(|raw| f64::from(*raw) * lsb)
            }
        }
    }

    /// Smooths a frame by one smoother and keeps the result of both passes.
    ///
    /// # Panics
    /// For `rtl`, which is simulated, not computed.
    pub fn smoothed(&self, level: Level, smoother: usize, pixels: &Plane<u16>) -> Smoothed {
        if let Some(filter) = self.whole_frame(level, smoother) {
            let frame = self.dn(pixels);
            // Both passes over single columns are the vertical pass alone.
            return Smoothed { columns: columns_only(&filter, &frame), rows: upward_first(&filter, &frame) };
        }
        let mut columns = None;
        let rows = self.stages(level, smoother, pixels, |stage, plane| {
            if stage == Stage::Recursion {
                columns = Some(plane.clone());
            }
        });
        Smoothed { columns: columns.expect("every chain has a recursion"), rows }
    }

    /// Returns the filter of a level that smooths whole frames, without stages; `None` for the other levels.
    fn whole_frame(&self, level: Level, smoother: usize) -> Option<WholeFrame<'_>> {
        match level {
            Level::Ideal => Some(WholeFrame::Filter(&self.ideal[smoother])),
            Level::Recursive => Some(WholeFrame::Filter(&self.recursive[smoother])),
            Level::Quantised => self.rounded_forms.get(smoother).map(WholeFrame::Form),
            Level::Streaming | Level::BitTrue | Level::Rtl => None,
        }
    }

    /// Computes all planes of a level.
    ///
    /// # Panics
    /// For `rtl`, which is simulated, not computed.
    pub fn planes(&self, level: Level, pixels: &Plane<u16>) -> LevelPlanes {
        if level == Level::BitTrue {
            return self.in_dn(&self.bit_true_planes(pixels));
        }
        let smooth = |smoother: usize| match self.whole_frame(level, smoother) {
            Some(filter) => upward_first(&filter, &self.dn(pixels)),
            // `bit_true` is computed in integers above.
            None => {
                let coefficients = if level == Level::Streaming { &self.streaming } else { &self.rounded };
                stages::smoothed(self.dn(pixels), &coefficients[smoother], |p, q, c| p + c * (q - p))
            }
        };
        LevelPlanes::of(self.per_smoother(smooth), rings(&self.design))
    }

    /// Computes all planes of `bit_true` in raw integers, in the fastest code that the formats allow.
    pub fn bit_true_planes(&self, pixels: &Plane<u16>) -> Planes {
        // The planes alone are wanted: without thresholds there are no features.
        self.bit_true_frame(pixels, &[]).0
    }

    /// Computes all planes of `bit_true`, and the features of at least `thresholds`, DN. A scale pair without a
    /// threshold has no features.
    pub fn bit_true_frame(&self, pixels: &Plane<u16>, thresholds: &[f64]) -> (Planes, Vec<Feature>) {
        let lsb = self.design.dog().lsb();
        let thresholds = raw_thresholds(&self.design, thresholds);
        let in_dn = |records: &[FeatureRecord]| records.iter().map(|record| record.feature(lsb)).collect();
        if let Ok(mut simd) = SimdBitTrue::new(&self.design) {
            let features = in_dn(simd.frame(&camera_samples(&self.design, pixels), &thresholds));
            return (simd.into_planes(), features);
        }
        let state = self.state(pixels);
        let planes =
            self.bit_true.planes_of(self.per_smoother(|smoother| self.bit_true.smoothed(smoother, state.clone())));
        let features = in_dn(&planes.features(&thresholds));
        (planes, features)
    }

    /// Returns the filter states of a picture of 16-bit samples.
    fn state(&self, picture: &Plane<u16>) -> Plane<u32> {
        self.bit_true.state(&camera_samples(&self.design, picture))
    }

    /// Returns a picture of 16-bit samples as the camera samples it, DN: the lower bits are 0.
    pub fn dn(&self, picture: &Plane<u16>) -> Plane<f64> {
        let shift = self.design.step_bits();
        picture.map(|sample| f64::from(sample >> shift << shift))
    }

    /// Converts integer planes of this design to DN.
    pub fn in_dn(&self, planes: &Planes) -> LevelPlanes {
        let (state, dog) = (self.design.state_dn().lsb(), self.design.dog().lsb());
        LevelPlanes {
            smoothed: planes.smoothed.iter().map(|plane| plane.map(|raw| f64::from(*raw) * state)).collect(),
            signed_dog: planes.signed_dog.iter().map(|plane| plane.map(|raw| f64::from(*raw) * state)).collect(),
            dog: planes.layers.iter().map(|layer| layer.dog.magnitude.map(|raw| f64::from(*raw) * dog)).collect(),
            max_dog: planes.layers.iter().map(|layer| layer.max_dog.map(|raw| f64::from(*raw) * dog)).collect(),
            rings: planes.layers.iter().map(|layer| layer.ring).collect(),
        }
    }

    /// Returns the largest difference of a smoother of this level from the level above, DN. `range` is the largest
    /// pixel minus the smallest, DN. It is `None` for `ideal`, which has no level above, and for `quantised` with
    /// another smoother, and 0 for `rtl`. For `recursive` it is valid away from the borders.
    pub fn worst_case(&self, level: Level, smoother: usize, range: f64) -> Option<f64> {
        let (streaming, rounded) = (&self.streaming[smoother], &self.rounded[smoother]);
        let response = |filters: &[Smoother]| filters[smoother].impulse_response();
        match level {
            Level::Ideal => None,
            Level::Quantised if !self.rounded_forms.is_empty() => None,
            Level::Recursive => {
                Some(worst_case::response_difference(&response(&self.recursive), &response(&self.ideal)) * range)
            }
            Level::Streaming => Some(worst_case::reach(streaming) * range),
            Level::Quantised => Some(worst_case::coefficient(streaming, rounded) * range),
            Level::BitTrue => Some(worst_case::rounding(rounded) * self.design.state_dn().lsb()),
            Level::Rtl => Some(0.0),
        }
    }

    /// Returns all features of a level in raster order, the finer scale first at one pixel. `thresholds` are in DN of
    /// the camera sample.
    pub fn features(&self, planes: &LevelPlanes, thresholds: &[f64]) -> Vec<Feature> {
        extractor::features(&planes.layers(), thresholds, 1.0)
    }

    fn per_smoother<T: Send>(&self, make: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
        (0..self.design.smoothers()).into_par_iter().map(make).collect()
    }
}

/// Converts thresholds from DN to the raw integers of a design's DoG, within its range: the least response that is not
/// below the threshold.
pub fn raw_thresholds(design: &DesignPoint, thresholds: &[f64]) -> Vec<u32> {
    let lsb = design.dog().lsb();
    thresholds.iter().map(|dn| ((dn / lsb).ceil() as u32).clamp(1, design.max_dog())).collect()
}

/// A filter that smooths whole frames.
enum WholeFrame<'a> {
    /// A filter with unrounded coefficients.
    Filter(&'a Smoother),
    /// A direct form with rounded coefficients.
    Form(&'a DirectForm),
}

impl WholeFrame<'_> {
    fn smooth(&self, frame: &Plane<f64>) -> Plane<f64> {
        match self {
            Self::Filter(filter) => filter.smooth(frame, Border::Held),
            Self::Form(form) => form.smooth(frame),
        }
    }

    fn smooth_line(&self, line: &[f64]) -> Vec<f64> {
        match self {
            Self::Filter(filter) => filter.smooth_line(line, Border::Held),
            Self::Form(form) => form.smooth_line(line),
        }
    }
}

/// Smooths a frame with the upward pass before the downward pass. A filter does it in the other order, so it gets the
/// frame upside down.
fn upward_first(filter: &WholeFrame<'_>, frame: &Plane<f64>) -> Plane<f64> {
    let upside_down =
        |plane: &Plane<f64>| Plane::from_fn(plane.width(), plane.height(), |x, y| plane[(x, plane.height() - 1 - y)]);
    upside_down(&filter.smooth(&upside_down(frame)))
}

/// Applies the vertical pass of a smoother alone, upward first.
///
/// Each column is smoothed as a picture of one column, on which the
/// horizontal pass has no effect.
fn columns_only(filter: &WholeFrame<'_>, frame: &Plane<f64>) -> Plane<f64> {
    let columns: Vec<Vec<f64>> = (0..frame.width())
        .into_par_iter()
        .map(|x| {
            let mut column: Vec<f64> = frame.rows().map(|row| row[x]).collect();
            column.reverse();
            let mut smoothed = filter.smooth_line(&column);
            smoothed.reverse();
            smoothed
        })
        .collect();
    Plane::from_fn(frame.width(), frame.height(), |x, y| columns[x][y])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pictures::{Content, Picture, pictures};
    use hoverlock_design::{Format, KT27};
    use hoverlock_reference::features::maxlbp::descriptor;
    use proptest::prelude::*;

    /// Design points of a sweep: other sigmas, reach and word lengths.
    fn designs() -> impl Strategy<Value = DesignPoint> {
        let sigma = 0.8..3.0f64;
        let fraction = |design: i8, low: i8, high: i8| prop_oneof![1 => Just(design), 2 => low..=high];
        let free = (
            (sigma, prop::collection::vec(1.2..2.5f64, 1..=3)),
            prop::array::uniform4(1..=7u32),
            (fraction(2, 0, 8), fraction(16, 8, 20), fraction(15, 9, 16)),
        )
            .prop_map(|((sigma, ratios), look_ahead, (state, coefficient, dog))| DesignPoint {
                scale_pairs: ratios.len() as u32,
                sigmas: (0..=ratios.len()).map(|i| sigma * ratios[..i].iter().product::<f64>()).collect(),
                look_ahead: look_ahead[..=ratios.len()].to_vec(),
                ring_radii: [12, 16, 16][..ratios.len()].to_vec(),
                state: Format::unsigned(16, state),
                coefficient: Format::unsigned(0, coefficient),
                dog_bits: dog as u32,
                ..KT27.clone()
            });
        prop_oneof![1 => Just(KT27.clone()), 3 => free]
    }

    /// Largest difference of two planes.
    fn distance(a: &Plane<f64>, b: &Plane<f64>) -> f64 {
        a.as_slice().iter().zip(b.as_slice()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    fn range(pixels: &Plane<u16>) -> f64 {
        let samples = pixels.as_slice().iter();
        samples.clone().max().map_or(0.0, |max| f64::from(*max)) - samples.min().map_or(0.0, |min| f64::from(*min))
    }

    /// Returns the samples at least `margin` px from every border.
    fn away_from_borders(plane: &Plane<f64>, margin: usize) -> Plane<f64> {
        let (width, height) = (plane.width() - 2 * margin, plane.height() - 2 * margin);
        plane.crop(margin, margin, width, height).unwrap()
    }

    /// Bound of the f64 rounding error: about 60 stages on values up to 2^16, each with an error of 2^-53, are 5e-10
    /// DN.
    const FLOAT: f64 = 1e-8;

    #[test]
    fn levels_are_named_from_ideal_to_rtl() {
        let names = Level::ALL.map(Level::name);
        assert_eq!(names, ["ideal", "recursive", "streaming", "quantised", "bit_true", "rtl"]);
    }

    #[test]
    fn frames_from_one_pixel_upward_have_all_planes() {
        let levels = Levels::new(&KT27).unwrap();
        for (width, height) in [(1, 1), (1, 50), (50, 1), (2, 3), (37, 37)] {
            let picture = Picture { width, height, seed: 5, content: Content::Noise { low: 0, high: 65535 } }.draw();
            for level in Level::MODELS {
                let planes = levels.planes(level, &picture);
                let shapes = planes.smoothed.iter().chain(&planes.signed_dog).chain(&planes.dog).chain(&planes.max_dog);
                assert!(shapes.clone().all(|plane| (plane.width(), plane.height()) == (width, height)));
                let thresholds = [1.0; 2];
                assert!(width == 37 || levels.features(&planes, &thresholds).is_empty());
            }
        }
    }

    #[test]
    fn another_smoother_changes_recursive_and_quantised_alone() {
        let picture =
            Picture { width: 90, height: 70, seed: 5, content: Content::Noise { low: 0, high: 65535 } }.draw();
        let constant = Plane::filled(60, 50, 40_123);
        let first_order = Levels::new(&KT27).unwrap();
        let smoothed = |levels: &Levels, level| levels.planes(level, &picture).smoothed;
        let largest =
            |a: &[Plane<f64>], b: &[Plane<f64>]| a.iter().zip(b).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
        for smoother in SmootherKind::ALL.iter().copied().skip(1) {
            let with_bits = |bits| DesignPoint { smoother, coefficient: Format::unsigned(0, bits), ..KT27.clone() };
            let levels = Levels::new(&with_bits(16)).unwrap();
            let same = |level| smoothed(&levels, level) == smoothed(&first_order, level);
            assert_eq!(Level::MODELS.map(same), [true, false, true, false, true], "{smoother}");
            // A cascade repeats the last sample of its causal pass beyond the border, the ideal filter the last pixel:
            // with noise they differ there by a multiple of what the approximations of the Gaussian do.
            let inside = |level_of: &Levels, level| -> Vec<Plane<f64>> {
                smoothed(level_of, level).iter().map(|plane| away_from_borders(plane, 28)).collect()
            };
            let ideal = inside(&levels, Level::Ideal);
            let far = |levels: &Levels| largest(&ideal, &inside(levels, Level::Recursive));
            let (near, first_order_far) = (far(&levels), far(&first_order));
            assert!(near < 0.5 * first_order_far, "{smoother}: {near} DN, first-order {first_order_far} DN");
            let rounding = |bits| {
                let levels = Levels::new(&with_bits(bits)).unwrap();
                largest(&smoothed(&levels, Level::Recursive), &smoothed(&levels, Level::Quantised))
            };
            assert!(rounding(22) > 0.0 && 8.0 * rounding(22) < rounding(14), "{smoother}");
            for level in Level::MODELS {
                let planes = levels.planes(level, &constant).smoothed;
                assert!(planes.iter().all(|plane| plane.as_slice().iter().all(|sample| *sample == 40_123.0)));
            }
            let column = levels.smoothed(Level::Quantised, 0, &picture);
            assert!(distance(&column.rows, &smoothed(&levels, Level::Quantised)[0]) == 0.0);
        }
    }

    /// Returns the largest difference of `d_k` of a level from the level above, DN: the sum of those of its two
    /// smoothers. `DOG_k` and `MaxDOG_k` of `bit_true` differ by half an LSB of the DoG more.
    fn worst_dog(levels: &Levels, level: Level, k: usize, range: f64) -> Option<f64> {
        Some(levels.worst_case(level, k, range)? + levels.worst_case(level, k + 1, range)?)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn each_level_stays_within_its_worst_case_of_the_one_above(design in designs(), picture in pictures(90)) {
            let pixels = picture.draw();
            let (width, height) = (pixels.width(), pixels.height());
            let levels = Levels::new(&design).unwrap();
            let range = range(&pixels);
            let planes = Level::MODELS.map(|level| levels.planes(level, &pixels));
            for (pair, level) in planes.windows(2).zip(&Level::MODELS[1..]) {
                let (above, below) = (&pair[0], &pair[1]);
                for smoother in 0..design.smoothers() {
                    let bound = levels.worst_case(*level, smoother, range).unwrap() + FLOAT;
                    let (above, below) = (&above.smoothed[smoother], &below.smoothed[smoother]);
                    if *level == Level::Recursive {
                        // Each pass repeats its own border sample: the weight a^(y + 1) + a^(W - x) is on other
                        // samples.
                        let a = first_order::pole(design.sigmas[smoother]).unwrap();
                        for y in 0..height {
                            for x in 0..width {
                                let border = a.powi(y as i32 + 1) + a.powi((width - x) as i32);
                                let error = (below[(x, y)] - above[(x, y)]).abs();
                                prop_assert!(
                                    error <= bound + border * range,
                                    "{error} at ({x}, {y}), {bound} + {border}"
                                );
                            }
                        }
                    } else {
                        let error = distance(above, below);
                        prop_assert!(error <= bound, "{level:?} smoother {smoother}: {error} DN, bound {bound}");
                    }
                }
                if *level != Level::Recursive {
                    for k in 0..design.pairs() {
                        let bound = worst_dog(&levels, *level, k, range).unwrap() + FLOAT;
                        let error = distance(&above.signed_dog[k], &below.signed_dog[k]);
                        prop_assert!(error <= bound, "{level:?} d_{k}: {error} DN, bound {bound}");
                    }
                }
            }
        }

        #[test]
        fn bits_flip_only_where_the_margin_is_below_the_bound(
            design in designs(), mut picture in pictures(60), larger in 37..60usize,
        ) {
            (picture.width, picture.height) = (picture.width.max(larger), picture.height.max(37));
            let pixels = picture.draw();
            let levels = Levels::new(&design).unwrap();
            let (above, below) = (levels.planes(Level::Quantised, &pixels), levels.planes(Level::BitTrue, &pixels));
            let (half, most) = (design.dog().lsb() / 2.0, design.dog().value(i64::from(design.max_dog())));
            let bound = |k| worst_dog(&levels, Level::BitTrue, k, 0.0).unwrap() + FLOAT;
            let bounds: Vec<f64> = (0..design.pairs()).map(bound).collect();
            for (k, bound) in bounds.iter().enumerate() {
                let clipped = above.dog[k].map(|dog| dog.min(most));
                prop_assert!(distance(&clipped, &below.dog[k]) <= bound + half);
                prop_assert!(distance(&max_dog(&clipped), &below.max_dog[k]) <= bound + half);
            }
            let (float, fixed) = (above.layers(), below.layers());
            for y in hoverlock_reference::features::maxima::eligible(pixels.height()) {
                for x in hoverlock_reference::features::maxima::eligible(pixels.width()) {
                    let (a, b) = (descriptor(&float, x, y), descriptor(&fixed, x, y));
                    for k in 0..design.pairs() {
                        let (maxlbp, sign) = (a.maxlbp[k] ^ b.maxlbp[k], a.sign[k] ^ b.sign[k]);
                        for (i, (dx, dy)) in float[k].ring.0.iter().enumerate() {
                            let at = (x.wrapping_add_signed(*dx as isize), y.wrapping_add_signed(*dy as isize));
                            // Both sides of the comparison may be off, by the DoG's error and its rounding; a flip
                            // where one of them saturates is due to the range, not to rounding.
                            let saturated = above.dog[k][(x, y)].max(above.max_dog[k][at]) >= most;
                            let margin = (above.dog[k][(x, y)] - above.max_dog[k][at]).abs();
                            let allowed = 2.0 * (bounds[k] + half);
                            prop_assert!(maxlbp >> i & 1 == 0 || saturated || margin <= allowed, "{margin}");
                            let margin = above.signed_dog[k][at].abs();
                            prop_assert!(sign >> i & 1 == 0 || margin <= bounds[k], "{margin}");
                        }
                    }
                }
            }
        }

        #[test]
        fn constants_pass_every_level_unchanged(
            design in designs(), width in 1..80usize, height in 1..80usize, value: u16,
        ) {
            let pixels = Plane::filled(width, height, value);
            let levels = Levels::new(&design).unwrap();
            for level in Level::MODELS {
                let planes = levels.planes(level, &pixels);
                for smoothed in &planes.smoothed {
                    prop_assert!(smoothed.as_slice().iter().all(|sample| *sample == f64::from(value)), "{level:?}");
                }
                prop_assert!(planes.dog.iter().all(|dog| dog.as_slice().iter().all(|sample| *sample == 0.0)));
                prop_assert!(levels.features(&planes, &[design.dog().lsb(); 3]).is_empty());
            }
        }

        #[test]
        fn features_of_raw_planes_equal_the_features_of_their_values_in_dn(
            picture in pictures(90), threshold in 1u32..3000,
        ) {
            let levels = Levels::new(&KT27).unwrap();
            let planes = levels.bit_true_planes(&picture.draw());
            let records: Vec<Feature> = planes.features(&[threshold; 2]).iter().map(Feature::from).collect();
            prop_assert_eq!(records, levels.features(&levels.in_dn(&planes), &[f64::from(threshold) / 2.0; 2]));
        }

        #[test]
        fn the_last_stage_gives_the_smoothed_plane(design in designs(), picture in pictures(60)) {
            let pixels = picture.draw();
            let levels = Levels::new(&design).unwrap();
            for level in Level::MODELS {
                let planes = levels.planes(level, &pixels);
                for smoother in 0..design.smoothers() {
                    let passes = levels.smoothed(level, smoother, &pixels);
                    prop_assert_eq!(&passes.rows, &planes.smoothed[smoother]);
                    // Columns alone: a picture whose rows are constant is smoothed by the vertical pass only.
                    let column = Plane::from_fn(1, pixels.height(), |_, y| pixels[(0, y)]);
                    let alone = levels.smoothed(level, smoother, &column);
                    let first = Plane::from_fn(1, pixels.height(), |_, y| passes.columns[(0, y)]);
                    prop_assert_eq!(&alone.rows, &first);
                }
            }
        }
    }
}
