//! Rung 4: the integers of the hardware, for any format of the design point and any frame from 1 x 1.
//!
//! A frame of 16-bit pixels `x` becomes the state `x << f`; three smoothers (the chains of [`crate::stages`], each cell the
//! integer [`lerp`]) give `G_0 .. G_2`. Then, with `f` the state's fraction bits, `N` the DoG's bits and `s = f + 14 - N`:
//!
//! ```text
//! d_k       = G_k - G_{k+1}                                    state LSB, signed
//! sign_k    = 1 where d_k >= 0                                 before rounding
//! DOG_k     = min((|d_k| + 2^(s-1)) >> s, 2^N - 1)             half up; s <= 0: |d_k| << -s; a saturated sample is counted
//! MaxDOG_k  = max of DOG_k over (2 D + 1)^2 pixels             the border sample repeated
//! feature   : DOG_k(p) >= T_k, DOG_k(p) > what comes earlier in raster order in its 7x7 window, >= what comes later
//! MaxLBP_k  : bit i = DOG_k(p) >= MaxDOG_k(p + o_i),           o_i = round(R_k (cos, sin)(2 pi i / 32)), x right, y down
//! sign word : bit i = sign_k(p + o_i)
//! ```
//!
//! **Which pixels.** A centre is eligible where `18 <= x < W - 18` and `18 <= y < H - 18`, both scales alike, so no window leaves
//! the frame and frames under 37 pixels either way have no features. The window test looks at all 48 neighbours, eligible
//! or not. Windows, rings and the tie rule are those of [`hoverlock_reference::maxima`] and [`hoverlock_reference::maxlbp`],
//! which serve integers and floats alike.
//!
//! **Order.** Raster order of the pixel; at one pixel scale 0 before scale 1. Of equal responses in one window the first in
//! raster order is the feature: the rule is strict against earlier pixels only, so no tie is lost or doubled.
//!
//! **What is dropped.** Nothing: this list is complete. Hardware whose feature FIFO is full leaves records out, never
//! reorders them, and counts them: emitted + dropped is the length of this list, and the emitted are in its order.

use hoverlock_reference::dog::Dog;
use hoverlock_reference::feature::{Descriptor, Feature};
use hoverlock_reference::maxima::maxima;
use hoverlock_reference::maxlbp::{Layer, descriptor};
use hoverlock_reference::plane::Plane;

use crate::coefficients::{CoefficientError, LerpCoefficients};
use crate::design::{DesignPoint, SCALES, SMOOTHERS};
use crate::lerp::lerp;
use crate::stages::{self, Cells, Stage};

/// Everything rung 4 computes of a frame but the features.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Planes {
    /// `G_0 .. G_2`, state LSB.
    pub smoothed: [Plane<u32>; SMOOTHERS],
    /// `d_k`, state LSB.
    pub signed_dog: [Plane<i32>; SCALES],
    /// `DOG_k` and `MaxDOG_k`, LSB of the DoG, and the sign bits.
    pub layers: [Layer<u16>; SCALES],
    /// Samples of `DOG_k` that saturated; the hardware keeps one sticky bit, set where this is not 0.
    pub saturated: [u64; SCALES],
}

/// A feature as the hardware sends it: 256 bits.
///
/// | word | bits 31..16 | bits 15..0 |
/// |---|---|---|
/// | 0 | `y` | `x` |
/// | 1 | flags | response |
/// | 2 | right neighbour | left neighbour |
/// | 3 | lower neighbour | upper neighbour |
/// | 4, 5 | MaxLBP k0, MaxLBP k1 | |
/// | 6, 7 | sign k0, sign k1 | |
///
/// Flags: bit 0 the scale pair, bit 1 the polarity (1 where `d_k >= 0`, a bright spot), bit 15 set in a frame's trailer record
/// and never in a feature; the others are 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FeatureRecord {
    /// Column.
    pub x: u16,
    /// Row.
    pub y: u16,
    /// `DOG_k` at the pixel, LSB of the DoG.
    pub response: u16,
    /// Scale pair, 0 or 1.
    pub scale: u8,
    /// Polarity.
    pub bright: bool,
    /// `DOG_k` at the left, right, upper and lower neighbour.
    pub neighbours: [u16; 4],
    /// Both scales' words.
    pub descriptor: Descriptor,
}

/// Flag bit of the scale pair.
pub const FLAG_SCALE: u16 = 1;
/// Flag bit of the polarity.
pub const FLAG_BRIGHT: u16 = 1 << 1;
/// Flag bit of the record that ends a frame's packet.
pub const FLAG_TRAILER: u16 = 1 << 15;

impl FeatureRecord {
    /// The 256 bits, least significant word first.
    pub fn pack(&self) -> [u32; 8] {
        let pair = |low: u16, high: u16| u32::from(low) | (u32::from(high) << 16);
        let flags = if self.scale == 1 { FLAG_SCALE } else { 0 } | if self.bright { FLAG_BRIGHT } else { 0 };
        let [left, right, up, down] = self.neighbours;
        let [maxlbp0, maxlbp1, sign0, sign1] = self.descriptor.words();
        [
            pair(self.x, self.y),
            pair(self.response, flags),
            pair(left, right),
            pair(up, down),
            maxlbp0,
            maxlbp1,
            sign0,
            sign1,
        ]
    }

    /// The feature of 256 bits; nothing where a flag is set that no feature has.
    pub fn unpack(words: &[u32; 8]) -> Option<Self> {
        let (low, high) = (|word: u32| word as u16, |word: u32| (word >> 16) as u16);
        let flags = high(words[1]);
        (flags & !(FLAG_SCALE | FLAG_BRIGHT) == 0).then(|| Self {
            x: low(words[0]),
            y: high(words[0]),
            response: low(words[1]),
            scale: u8::from(flags & FLAG_SCALE != 0),
            bright: flags & FLAG_BRIGHT != 0,
            neighbours: [low(words[2]), high(words[2]), low(words[3]), high(words[3])],
            descriptor: Descriptor { maxlbp: [words[4], words[5]], sign: [words[6], words[7]] },
        })
    }

    /// The feature in codes of the camera word: `dog_lsb` is what one LSB of the DoG is worth.
    pub fn feature(&self, dog_lsb: f64) -> Feature {
        Feature {
            x: u32::from(self.x),
            y: u32::from(self.y),
            scale: self.scale,
            bright: self.bright,
            response: f64::from(self.response) * dog_lsb,
            neighbours: self.neighbours.map(|response| f64::from(response) * dog_lsb),
            descriptor: self.descriptor,
        }
    }
}

impl From<&FeatureRecord> for Feature {
    /// At the default design point, where one LSB of the DoG is half a code.
    fn from(record: &FeatureRecord) -> Self {
        record.feature(0.5)
    }
}

/// The thresholds `T_k` from the counts of the last finished frame.
///
/// At frame start, per scale, from the count before drops: above `5 N / 4` `T += (T >> 3) + 1`, below `3 N / 4`
/// `T = max(1, T - (T >> 3) - 1)`. It never passes the largest DoG code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ThresholdController {
    target: u32,
    max: u32,
    thresholds: [u32; SCALES],
}

impl ThresholdController {
    /// The controller of a design point before its first frame.
    pub fn new(design: &DesignPoint) -> Self {
        Self { target: design.threshold.target, max: design.max_dog(), thresholds: [design.threshold.initial; SCALES] }
    }

    /// `T_k` of the frame about to start.
    pub fn thresholds(&self) -> [u32; SCALES] {
        self.thresholds
    }

    /// Takes the number of features of each scale in the frame just finished.
    pub fn finish_frame(&mut self, counts: [u32; SCALES]) {
        for (threshold, count) in self.thresholds.iter_mut().zip(counts) {
            let (count, target) = (u64::from(count), u64::from(self.target));
            let step = (*threshold >> 3) + 1;
            if 4 * count > 5 * target {
                *threshold = (*threshold + step).min(self.max);
            } else if 4 * count < 3 * target {
                *threshold = threshold.saturating_sub(step).max(1);
            }
        }
    }
}

/// How many features each scale has.
pub fn counts(features: &[FeatureRecord]) -> [u32; SCALES] {
    let coarse = features.iter().filter(|feature| feature.scale == 1).count() as u32;
    [features.len() as u32 - coarse, coarse]
}

/// Rung 4 of one design point.
#[derive(Debug, Clone, PartialEq)]
pub struct BitTrue {
    design: DesignPoint,
    cells: [Cells<u32>; SMOOTHERS],
}

impl BitTrue {
    /// The model of a design point.
    ///
    /// # Errors
    /// Where a smoother of one of the sigmas, or its rounding to the coefficient format, does not exist.
    pub fn new(design: &DesignPoint) -> Result<Self, CoefficientError> {
        let cells = |smoother: usize| {
            let (sigma, look_ahead) = (design.sigmas[smoother], design.look_ahead[smoother]);
            LerpCoefficients::design(sigma, look_ahead, design.coefficient.bits()).map(Cells::from)
        };
        Ok(Self { design: design.clone(), cells: [cells(0)?, cells(1)?, cells(2)?] })
    }

    /// The design point it was made for.
    pub fn design(&self) -> &DesignPoint {
        &self.design
    }

    /// Integer coefficients of the smoothers.
    pub fn cells(&self) -> &[Cells<u32>; SMOOTHERS] {
        &self.cells
    }

    /// Pixels become states: `x << f`.
    pub fn state(&self, pixels: &Plane<u16>) -> Plane<u32> {
        let fraction_bits = self.design.state.fraction_bits();
        pixels.map(|pixel| u32::from(*pixel) << fraction_bits)
    }

    /// One smoother over the states; `each` sees every stage's output.
    pub fn smooth(&self, smoother: usize, state: &Plane<u32>, each: impl FnMut(Stage, &Plane<u32>)) -> Plane<u32> {
        let fraction_bits = self.design.coefficient.bits();
        stages::smooth(state, &self.cells[smoother], |p, q, code| lerp(p, q, code, fraction_bits), each)
    }

    /// `d_k` of two smoothed planes.
    pub fn signed_dog(narrow: &Plane<u32>, wide: &Plane<u32>) -> Plane<i32> {
        narrow.zip_map(wide, |narrow, wide| *narrow as i32 - *wide as i32)
    }

    /// `DOG_k` with its sign bits, and how many samples saturated.
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

    /// All planes of a frame.
    pub fn planes(&self, pixels: &Plane<u16>) -> Planes {
        let state = self.state(pixels);
        let smoothed = [0, 1, 2].map(|smoother| self.smooth(smoother, &state, |_, _| ()));
        self.planes_of(smoothed)
    }

    /// All planes of a frame whose smoothing is done.
    pub fn planes_of(&self, smoothed: [Plane<u32>; SMOOTHERS]) -> Planes {
        let signed_dog = [0, 1].map(|k| Self::signed_dog(&smoothed[k], &smoothed[k + 1]));
        let [(fine, fine_saturated), (coarse, coarse_saturated)] = [0, 1].map(|k: usize| self.dog(&signed_dog[k]));
        Planes {
            smoothed,
            signed_dog,
            layers: [Layer::new(fine), Layer::new(coarse)],
            saturated: [fine_saturated, coarse_saturated],
        }
    }
}

impl Planes {
    /// All features of the frame, in order. A threshold of 0 counts as 1.
    pub fn features(&self, thresholds: [u32; SCALES]) -> Vec<FeatureRecord> {
        let mut places = Vec::new();
        for (k, layer) in self.layers.iter().enumerate() {
            // No response reaches a threshold beyond 16 bits.
            if let Ok(threshold) = u16::try_from(thresholds[k].max(1)) {
                places.extend(maxima(&layer.dog.magnitude, threshold).into_iter().map(|(x, y)| (y, x, k)));
            }
        }
        places.sort_unstable();
        places.into_iter().map(|(y, x, k)| self.record(x, y, k)).collect()
    }

    /// The record of scale pair `k` at an eligible pixel.
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
