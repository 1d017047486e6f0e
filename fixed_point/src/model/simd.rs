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
//! - **Strips of [`LANES`] columns.** The vertical stages run a few rows apart, in place, so that their rows are in the
//!   L1 cache. Each row then passes all later stages while it is in the cache.
//! - **Maxima from MaxDOG.** A feature equals the maximum of its 5x5 window, MaxDOG, which is already computed. Only
//!   such pixels get the full 7x7 test.
//!
//! The loops are compiled twice, for AVX2 and for the baseline of the target, and selected at run time. Both give the
//! same bits.

use hoverlock_reference::features::dog::Dog;
use hoverlock_reference::features::maxima::{eligible, is_maximum};
use hoverlock_reference::features::maxlbp::{Layer, MAX_RADIUS, Ring};
use hoverlock_reference::image::plane::Plane;
use multiversion::multiversion;

use crate::model::bit_true::Planes;
use crate::model::coefficients::{CoefficientError, LerpCoefficients, MAX_LOOK_AHEAD};
use crate::model::design::rings;
use crate::model::record::FeatureRecord;
use hoverlock_design::{DesignPoint, Format};

/// Columns of a strip: four cache lines of states.
pub const LANES: usize = 64;

/// Rows of a strip that a stage processes before the next stage runs, so that their rows stay in the cache.
const BLOCK: usize = 16;

/// The states of one row of a strip.
type Lanes = [i32; LANES];

/// Rows of the MaxDOG window.
const MAX_ROWS: usize = 2 * MAX_RADIUS + 1;

/// Why there is no SIMD model of a design point.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimdError {
    /// The formats are not supported.
    #[error(
        "the simd model supports states of up to 18 bits, coefficients of up to 16 and a DoG of up to 15 only, \
         not {state}, {coefficient} and {dog_bits} bits"
    )]
    Formats {
        /// State format.
        state: Format,
        /// Coefficient format.
        coefficient: Format,
        /// DoG bits.
        dog_bits: u32,
    },
    /// The coefficients cannot be designed.
    #[error(transparent)]
    Coefficient(#[from] CoefficientError),
}

/// A coefficient prepared for [`cell`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Gain {
    /// `c`, or `2^16 - c` where that is smaller; at most `2^15`.
    raw: i32,
    /// `raw` is the complement.
    complement: bool,
}

impl Gain {
    fn new(raw: u32) -> Self {
        let complement = raw > 1 << 15;
        let raw = if complement { (1 << 16) - raw } else { raw };
        Self { raw: raw as i32, complement }
    }

    /// The product must be split.
    fn split(self) -> bool {
        self.raw > 8191
    }
}

/// `p + round(c (q - p))`. The arithmetic never overflows. Wrapping operators let builds with overflow checks
/// be vectorised.
#[inline(always)]
fn cell<const COMPLEMENT: bool, const SPLIT: bool>(p: i32, q: i32, raw: i32) -> i32 {
    let e = q.wrapping_sub(p);
    let m = e >> 31;
    let bias = if COMPLEMENT { 0x7fffi32.wrapping_sub(m) } else { 0x8000i32.wrapping_add(m) };
    let t = if SPLIT {
        let low = (raw.wrapping_mul(e & 3).wrapping_add(bias)) >> 2;
        raw.wrapping_mul(e >> 2).wrapping_add(low) >> 14
    } else {
        raw.wrapping_mul(e).wrapping_add(bias) >> 16
    };
    if COMPLEMENT { q.wrapping_sub(t) } else { p.wrapping_add(t) }
}

/// Calls `$body` with the cell for a coefficient, so that the selection is outside the loops.
macro_rules! with_cell {
    ($gain:expr, $cell:ident => $body:expr) => {{
        let gain: Gain = $gain;
        let raw = gain.raw;
        match (gain.complement, gain.split()) {
            (false, false) => {
                let $cell = |p, q| cell::<false, false>(p, q, raw);
                $body
            }
            (false, true) => {
                let $cell = |p, q| cell::<false, true>(p, q, raw);
                $body
            }
            (true, false) => {
                let $cell = |p, q| cell::<true, false>(p, q, raw);
                $body
            }
            (true, true) => {
                let $cell = |p, q| cell::<true, true>(p, q, raw);
                $body
            }
        }
    }};
}

/// The coefficients of one smoother.
#[derive(Debug, Clone, PartialEq)]
struct Gains {
    g: Gain,
    g_j: Vec<Gain>,
}

/// The SIMD bit-true model. It reuses its planes, so that frames of equal size need no allocation.
#[derive(Debug, Clone)]
pub struct SimdBitTrue {
    gains: Vec<Gains>,
    words: Words,
    planes: Planes,
    scratch: Scratch,
    features: Vec<FeatureRecord>,
}

/// What the loops need of the formats.
#[derive(Debug, Clone, Copy)]
struct Words {
    /// Fraction bits of the state.
    fraction_bits: u32,
    /// `s`, where it is positive: the state has the smaller LSB.
    right: u32,
    /// `-s`, where that is positive.
    left: u32,
    /// Half an LSB of the DoG, in LSB of the state.
    half: u32,
    /// Largest response.
    max: u32,
}

impl Words {
    fn new(design: &DesignPoint) -> Self {
        let right = design.dog_shift().max(0) as u32;
        Self {
            fraction_bits: design.state.fraction_bits() as u32,
            right,
            left: (-design.dog_shift()).max(0) as u32,
            half: (1 << right) >> 1,
            max: design.max_dog(),
        }
    }

    /// `(|d| + 2^(s-1)) >> s`, before it saturates.
    #[inline(always)]
    fn rounded(self, d: i32) -> u32 {
        ((d.unsigned_abs() + self.half) >> self.right) << self.left
    }
}

/// Work memory.
#[derive(Debug, Clone, Default)]
struct Scratch {
    /// One strip of columns.
    strip: Vec<Lanes>,
    /// A row of states before and after a stage, with space for repeated border samples at both ends.
    lines: [Vec<i32>; 2],
    /// A row of responses, with space for the MaxDOG window at both ends.
    responses: Vec<u16>,
    /// Horizontal maxima of the last rows, one ring buffer per scale pair.
    row_maxima: Vec<[Vec<u16>; MAX_ROWS]>,
    /// Pixels of at least the threshold that equal their MaxDOG: `(y, x, k)`.
    candidates: Vec<(usize, usize, usize)>,
}

impl SimdBitTrue {
    /// The model of a design point.
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
            planes: blank(&rings(design), 1, 1),
            scratch: Scratch::default(),
            features: Vec::new(),
        })
    }

    /// Processes a frame. [`SimdBitTrue::planes`] and the features returned equal those of [`crate::model::bit_true`];
    /// a scale pair without a threshold has no features.
    pub fn frame(&mut self, pixels: &Plane<u16>, thresholds: &[u32]) -> &[FeatureRecord] {
        self.run(pixels, thresholds, chain)
    }

    /// As [`SimdBitTrue::frame`], with the portable code: for any processor of the target.
    pub fn portable_frame(&mut self, pixels: &Plane<u16>, thresholds: &[u32]) -> &[FeatureRecord] {
        self.run(pixels, thresholds, chain_everywhere)
    }

    /// All planes of the last frame; one black pixel before the first frame.
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The planes without the model.
    pub fn into_planes(self) -> Planes {
        self.planes
    }

    /// The features of the last frame.
    pub fn features(&self) -> &[FeatureRecord] {
        &self.features
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
        chain(pixels, &self.gains, self.words, &thresholds, &mut self.planes, &mut self.scratch);

        self.features.clear();
        let candidates = &mut self.scratch.candidates;
        candidates.retain(|&(y, x, k)| is_maximum(&self.planes.layers[k].dog.magnitude, x, y));
        candidates.sort_unstable();
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

/// Computes the planes of a frame and the candidates of its features.
type Chain = fn(&Plane<u16>, &[Gains], Words, &[u16], &mut Planes, &mut Scratch);

#[multiversion(targets("x86_64+avx2"))]
fn chain(
    pixels: &Plane<u16>,
    gains: &[Gains],
    words: Words,
    thresholds: &[u16],
    planes: &mut Planes,
    scratch: &mut Scratch,
) {
    whole_chain(pixels, gains, words, thresholds, planes, scratch);
}

fn chain_everywhere(
    pixels: &Plane<u16>,
    gains: &[Gains],
    words: Words,
    thresholds: &[u16],
    planes: &mut Planes,
    scratch: &mut Scratch,
) {
    whole_chain(pixels, gains, words, thresholds, planes, scratch);
}

// Inlined into both callers, so that all functions below are compiled for the instructions of the caller.
#[inline(always)]
fn whole_chain(
    pixels: &Plane<u16>,
    gains: &[Gains],
    words: Words,
    thresholds: &[u16],
    planes: &mut Planes,
    scratch: &mut Scratch,
) {
    let (width, height) = (pixels.width(), pixels.height());
    scratch.strip.resize(height, [0; LANES]);
    // All smoothers use a strip of pixels while it is in the cache.
    for left in (0..width).step_by(LANES) {
        for (gains, smoothed) in gains.iter().zip(&mut planes.smoothed) {
            columns(pixels, left, gains, words.fraction_bits, smoothed, &mut scratch.strip);
        }
    }

    let pad = gains.iter().map(|gains| 1 << (gains.g_j.len() - 1)).max().unwrap_or(0);
    scratch.lines.iter_mut().for_each(|line| line.resize(width + 2 * pad, 0));
    scratch.responses.clear();
    scratch.responses.resize(width + 2 * MAX_RADIUS, 0);
    scratch.row_maxima.resize_with(gains.len() - 1, Default::default);
    for line in scratch.row_maxima.as_flattened_mut() {
        line.clear();
        line.resize(width, 0);
    }
    scratch.candidates.clear();
    planes.saturated.fill(0);
    for y in 0..height + MAX_RADIUS {
        if y < height {
            for (gains, smoothed) in gains.iter().zip(&mut planes.smoothed) {
                row(gains, smoothed.row_mut(y), &mut scratch.lines, pad);
            }
        }
        for (k, threshold) in thresholds.iter().enumerate() {
            let row_maxima = &mut scratch.row_maxima[k];
            let layer = &mut planes.layers[k];
            if y < height {
                let responses = &mut scratch.responses[MAX_RADIUS..MAX_RADIUS + width];
                planes.saturated[k] += difference(
                    words,
                    planes.smoothed[k].row(y),
                    planes.smoothed[k + 1].row(y),
                    planes.signed_dog[k].row_mut(y),
                    layer.dog.positive.row_mut(y),
                    responses,
                );
                layer.dog.magnitude.row_mut(y).copy_from_slice(responses);
                maxima_along_row(&scratch.responses, &mut row_maxima[y % MAX_ROWS]);
            } else {
                row_maxima[y % MAX_ROWS].fill(0);
            }
            if y >= MAX_RADIUS {
                let y = y - MAX_RADIUS;
                let max_dog = layer.max_dog.row_mut(y);
                maxima_of_rows(row_maxima, max_dog);
                let columns = eligible(width);
                if eligible(height).contains(&y) && !columns.is_empty() {
                    let (responses, max_dog) =
                        (&layer.dog.magnitude.row(y)[columns.clone()], &max_dog[columns.clone()]);
                    candidates(responses, max_dog, *threshold, |i| {
                        scratch.candidates.push((y, columns.start + i, k));
                    });
                }
            }
        }
    }
}

/// The vertical pass of one smoother over the strip of columns that begins at `left`. `strip` has a position for every
/// row.
#[inline(always)]
fn columns(
    pixels: &Plane<u16>,
    left: usize,
    gains: &Gains,
    fraction_bits: u32,
    smoothed: &mut Plane<u32>,
    strip: &mut [Lanes],
) {
    let (width, height) = (pixels.width(), pixels.height());
    let used = LANES.min(width - left);
    let states = |row: &[u16]| {
        let mut states = [0; LANES];
        match row[left..left + used].first_chunk::<LANES>() {
            Some(pixels) => (0..LANES).for_each(|l| states[l] = i32::from(pixels[l]) << fraction_bits),
            None => states
                .iter_mut()
                .zip(&row[left..])
                .for_each(|(state, pixel)| *state = i32::from(*pixel) << fraction_bits),
        }
        states
    };
    // Number of rows that each stage has output; [0] is the recursion.
    let mut given = [0; MAX_LOOK_AHEAD as usize + 1];
    let stages = gains.g_j.len();
    let mut state = states(pixels.row(0));
    let mut written = 0;
    while written < height {
        let rows = given[0]..(given[0] + BLOCK).min(height);
        given[0] = rows.end;
        with_cell!(gains.g, cell => {
            for r in rows {
                let x = states(pixels.row(r));
                for l in 0..LANES {
                    state[l] = cell(state[l], x[l]);
                }
                strip[r] = state;
            }
        });
        for (j, gain) in gains.g_j.iter().enumerate() {
            let reach = 1 << j;
            let ready = if given[j] == height { height } else { given[j].saturating_sub(reach).max(given[j + 1]) };
            let rows = given[j + 1]..ready;
            given[j + 1] = ready;
            // In place: this stage has not changed the row ahead yet. The last row is the same before and after every
            // stage, because it is a lerp of itself with itself.
            // The row ahead is copied so that the compiler knows that the two do not overlap. Without the copy the loop
            // takes twice as long.
            with_cell!(*gain, cell => {
                for r in rows {
                    let ahead = strip[(r + reach).min(height - 1)];
                    let here = &mut strip[r];
                    for l in 0..LANES {
                        here[l] = cell(ahead[l], here[l]);
                    }
                }
            });
        }
        for (y, lanes) in (written..given[stages]).zip(&strip[written..]) {
            let row = &mut smoothed.row_mut(y)[left..left + used];
            match row.first_chunk_mut::<LANES>() {
                Some(row) => (0..LANES).for_each(|l| row[l] = lanes[l] as u32),
                None => row.iter_mut().zip(lanes).for_each(|(sample, lane)| *sample = *lane as u32),
            }
        }
        written = given[stages];
    }
}

/// The horizontal pass of one smoother over one row, in place.
#[inline(always)]
fn row(gains: &Gains, samples: &mut [u32], lines: &mut [Vec<i32>; 2], pad: usize) {
    let width = samples.len();
    let here = pad..pad + width;
    let [from, to] = lines;
    let (mut from, mut to) = (from.as_mut_slice(), to.as_mut_slice());
    from[here.clone()].iter_mut().zip(&*samples).for_each(|(line, sample)| *line = *sample as i32);
    for (j, gain) in gains.g_j.iter().enumerate() {
        let reach = 1 << j;
        let first = from[pad];
        from[pad - reach..pad].fill(first);
        let back = &from[pad - reach..][..width];
        with_cell!(*gain, cell => lerp_lines(back, &from[here.clone()], &mut to[here.clone()], cell));
        std::mem::swap(&mut from, &mut to);
    }
    for (j, gain) in gains.g_j.iter().enumerate() {
        let reach = 1 << j;
        let last = from[pad + width - 1];
        from[pad + width..pad + width + reach].fill(last);
        let ahead = &from[pad + reach..][..width];
        with_cell!(*gain, cell => lerp_lines(ahead, &from[here.clone()], &mut to[here.clone()], cell));
        std::mem::swap(&mut from, &mut to);
    }
    samples.iter_mut().zip(&from[here]).for_each(|(sample, line)| *sample = *line as u32);
}

#[inline(always)]
fn lerp_lines(p: &[i32], q: &[i32], y: &mut [i32], cell: impl Fn(i32, i32) -> i32) {
    for ((y, p), q) in y.iter_mut().zip(p).zip(q) {
        *y = cell(*p, *q);
    }
}

/// One row of `d_k`, its sign bits and `DOG_k`; the number of samples that saturated.
#[inline(always)]
fn difference(
    words: Words,
    narrow: &[u32],
    wide: &[u32],
    signed: &mut [i32],
    positive: &mut [bool],
    dog: &mut [u16],
) -> u64 {
    for ((signed, narrow), wide) in signed.iter_mut().zip(narrow).zip(wide) {
        *signed = (*narrow as i32).wrapping_sub(*wide as i32);
    }
    for (positive, signed) in positive.iter_mut().zip(&*signed) {
        *positive = *signed >= 0;
    }
    let mut largest = 0;
    for (dog, signed) in dog.iter_mut().zip(&*signed) {
        let rounded = words.rounded(*signed);
        largest = largest.max(rounded);
        *dog = rounded.min(words.max) as u16;
    }
    // Saturation is rare. Samples are counted only where the row has any.
    if largest <= words.max { 0 } else { signed.iter().filter(|d| words.rounded(**d) > words.max).count() as u64 }
}

/// The maxima of windows along a row; `responses` extends beyond both ends by the radius of the window.
#[inline(always)]
fn maxima_along_row(responses: &[u16], maxima: &mut [u16]) {
    let width = maxima.len();
    let [a, b, c, d, e] = std::array::from_fn::<_, MAX_ROWS, _>(|shift| &responses[shift..shift + width]);
    for (i, max) in maxima.iter_mut().enumerate() {
        *max = a[i].max(b[i]).max(c[i]).max(d[i].max(e[i]));
    }
}

/// The maxima of the same column of several rows.
#[inline(always)]
fn maxima_of_rows(rows: &[Vec<u16>; MAX_ROWS], maxima: &mut [u16]) {
    let width = maxima.len();
    let [a, b, c, d, e] = rows.each_ref().map(|row| &row[..width]);
    for (i, max) in maxima.iter_mut().enumerate() {
        *max = a[i].max(b[i]).max(c[i]).max(d[i].max(e[i]));
    }
}

/// Calls `found` with each position where a response of at least the threshold equals its MaxDOG.
#[inline(always)]
fn candidates(responses: &[u16], max_dog: &[u16], threshold: u16, mut found: impl FnMut(usize)) {
    const BLOCK: usize = 64;
    let is_candidate = |response: u16, max: u16| (response == max) & (response >= threshold);
    for (block, (responses, max_dog)) in responses.chunks(BLOCK).zip(max_dog.chunks(BLOCK)).enumerate() {
        let any = responses.iter().zip(max_dog).fold(false, |any, (r, m)| any | is_candidate(*r, *m));
        if any {
            for (i, (response, max)) in responses.iter().zip(max_dog).enumerate() {
                if is_candidate(*response, *max) {
                    found(block * BLOCK + i);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::bit_true::BitTrue;
    use crate::model::design::camera_samples;
    use crate::model::lerp::lerp;
    use crate::pictures::{Content, Picture, pictures};
    use hoverlock_design::{KT27, SHIPPED};
    use proptest::prelude::*;

    fn by_gain(p: i32, q: i32, gain: Gain) -> i32 {
        with_cell!(gain, cell => cell(p, q))
    }

    /// Checks all differences for one coefficient. Except for the final sum, the result depends on `q - p` only.
    fn every_difference(raw: u32) {
        const TOP: i32 = 65535 << 2;
        let gain = Gain::new(raw);
        for e in 0..=TOP {
            assert_eq!(by_gain(0, e, gain), lerp(0, e as u32, raw, 16) as i32, "{raw} x {e}");
            assert_eq!(by_gain(TOP, TOP - e, gain), lerp(TOP as u32, (TOP - e) as u32, raw, 16) as i32, "{raw} x -{e}");
        }
    }

    #[test]
    fn cell_is_the_lerp_for_every_difference_and_design_coefficient() {
        let simd = SimdBitTrue::new(&KT27).unwrap();
        let bit_true = BitTrue::new(&KT27).unwrap();
        for (gains, coefficients) in simd.gains.iter().zip(bit_true.coefficients()) {
            every_difference(coefficients.g);
            assert_eq!(gains.g, Gain::new(coefficients.g));
            coefficients.g_j.iter().for_each(|raw| every_difference(*raw));
        }
        // Both ends of the range of each formula.
        for raw in [1, 8191, 8192, 32767, 32768, 32769, 57344, 57345, 65535] {
            every_difference(raw);
        }
    }

    #[test]
    fn cell_is_the_lerp_for_every_coefficient_at_the_extremes() {
        for raw in 1..1u32 << 16 {
            let gain = Gain::new(raw);
            for e in [1, 2, 3, 4, 5, 131_070, 131_072, 262_135, 262_137, 262_138, 262_139, 262_140] {
                for (p, q) in [(0, e), (e, 0)] {
                    assert_eq!(by_gain(p, q, gain), lerp(p as u32, q as u32, raw, 16) as i32, "{raw}: {p} {q}");
                }
            }
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
