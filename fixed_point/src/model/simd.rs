//! `bit_true` at the formats of the design point, the same bits as [`crate::model::bit_true`] at tens of megapixels a second.
//!
//! State u16.2, coefficients u0.16, DoG of 15 bits; sigmas, look-ahead and coefficients are free. What makes it quick:
//!
//! - **One signed 32-bit cell.** With `e = q - p` and `m = e >> 31` (-1 where `e < 0`), rounding half away from zero is
//!   `round(c e / 2^16) = (c e + 2^15 + m) >> 16`. For `c > 2^15` the complement `c' = 2^16 - c` is at most `2^15`, and
//!   `p + round(c e / 2^16) = q - ((c' e + 2^15 - 1 - m) >> 16)`, which rounds half toward zero because it is subtracted. Pixels are at
//!   most 65535, so `|e| <= 262140`, and for `c <= 8191` all of it stays below `2^31`. Above that `e = 4 h + l` splits the
//!   product: `(4 c h + c l + bias) >> 16 = (c h + ((c l + bias) >> 2)) >> 14`, both terms below `2^31` again.
//! - **Columns in strips** of [`LANES`] side by side, the vertical stages following one another a few rows apart, in place, so that
//!   they find their rows in the nearest cache; rows one by one through all later stages while they are in it.
//! - **Maxima from MaxDOG**: a feature equals the maximum of its 5x5 window, which is there already; only such pixels are
//!   given the full test.
//!
//! Everything is plain loops over slices. They are compiled for AVX2 and for the baseline of the target, and the better is
//! chosen at run time: one source, so the same bits.

use hoverlock_reference::features::dog::Dog;
use hoverlock_reference::features::maxima::{eligible, is_maximum};
use hoverlock_reference::features::maxlbp::{Layer, MAX_RADIUS};
use hoverlock_reference::image::plane::Plane;
use multiversion::multiversion;

use crate::model::bit_true::{FeatureRecord, Planes};
use crate::model::coefficients::{CoefficientError, LerpCoefficients, MAX_LOOK_AHEAD};
use crate::model::design::{DesignPoint, KT27, SCALES, SMOOTHERS};
use crate::model::format::Format;

/// Columns of a strip: four cache lines of states, next to each other in every row they are written to.
pub const LANES: usize = 64;

/// Rows of a strip that one stage does before the next follows, so that all stages of a smoother work on rows still near.
const BLOCK: usize = 16;

/// The states of one row of a strip.
type Lanes = [i32; LANES];

/// Rows whose maxima along the row make one row of MaxDOG.
const MAX_ROWS: usize = 2 * MAX_RADIUS + 1;

/// Why a design point has no simd model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimdError {
    /// Its formats are not those this model is written for.
    #[error(
        "the simd model knows state u16.2, coefficients u0.16 and a DoG of 15 bits only, not {state}, {coefficient} and {dog_bits} bits"
    )]
    Formats {
        /// State format asked for.
        state: Format,
        /// Coefficient format asked for.
        coefficient: Format,
        /// DoG bits asked for.
        dog_bits: u32,
    },
    /// Its coefficients do not exist.
    #[error(transparent)]
    Coefficient(#[from] CoefficientError),
}

/// A coefficient as the cell wants it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Gain {
    /// `c`, or `2^16 - c` where that is smaller; at most `2^15`.
    code: i32,
    /// Whether it is the complement.
    complement: bool,
}

impl Gain {
    fn new(code: u32) -> Self {
        let complement = code > 1 << 15;
        let code = if complement { (1 << 16) - code } else { code };
        Self { code: code as i32, complement }
    }

    /// Whether the product must be split.
    fn split(self) -> bool {
        self.code > 8191
    }
}

/// `p + round(c (q - p))`. The operators wrap so that builds with overflow checks are vectorised too; none does.
#[inline(always)]
fn cell<const COMPLEMENT: bool, const SPLIT: bool>(p: i32, q: i32, code: i32) -> i32 {
    let e = q.wrapping_sub(p);
    let m = e >> 31;
    let bias = if COMPLEMENT { 0x7fffi32.wrapping_sub(m) } else { 0x8000i32.wrapping_add(m) };
    let t = if SPLIT {
        let low = (code.wrapping_mul(e & 3).wrapping_add(bias)) >> 2;
        code.wrapping_mul(e >> 2).wrapping_add(low) >> 14
    } else {
        code.wrapping_mul(e).wrapping_add(bias) >> 16
    };
    if COMPLEMENT { q.wrapping_sub(t) } else { p.wrapping_add(t) }
}

/// Calls `$body` with the cell that suits a gain: the choice is made outside the loops.
macro_rules! with_cell {
    ($gain:expr, $cell:ident => $body:expr) => {{
        let gain: Gain = $gain;
        let code = gain.code;
        match (gain.complement, gain.split()) {
            (false, false) => {
                let $cell = |p, q| cell::<false, false>(p, q, code);
                $body
            }
            (false, true) => {
                let $cell = |p, q| cell::<false, true>(p, q, code);
                $body
            }
            (true, false) => {
                let $cell = |p, q| cell::<true, false>(p, q, code);
                $body
            }
            (true, true) => {
                let $cell = |p, q| cell::<true, true>(p, q, code);
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

/// `bit_true`, quick. It keeps its planes from frame to frame, so that no memory is asked for while frames keep their size.
#[derive(Debug, Clone)]
pub struct SimdBitTrue {
    gains: [Gains; SMOOTHERS],
    planes: Planes,
    scratch: Scratch,
    features: Vec<FeatureRecord>,
}

/// Memory of the loops.
#[derive(Debug, Clone, Default)]
struct Scratch {
    /// One strip of columns.
    strip: Vec<Lanes>,
    /// A row of states before and after a stage, with room for repeated border samples at either end.
    lines: [Vec<i32>; 2],
    /// A row of responses, with room for the window of MaxDOG at either end.
    responses: Vec<u16>,
    /// The last rows' maxima along the row, one ring per scale pair.
    row_maxima: [[Vec<u16>; MAX_ROWS]; SCALES],
    /// Pixels of at least the threshold that equal their MaxDOG: `(y, x, k)`.
    candidates: Vec<(usize, usize, usize)>,
}

impl SimdBitTrue {
    /// The model of a design point whose formats are those of [`KT27`].
    ///
    /// # Errors
    /// Where the formats are others, or the coefficients do not exist.
    pub fn new(design: &DesignPoint) -> Result<Self, SimdError> {
        let DesignPoint { state, coefficient, dog_bits, .. } = *design;
        if (state, coefficient, dog_bits) != (KT27.state, KT27.coefficient, KT27.dog_bits) {
            return Err(SimdError::Formats { state, coefficient, dog_bits });
        }
        let gains = |smoother: usize| {
            let (sigma, look_ahead) = (design.sigmas[smoother], design.look_ahead[smoother]);
            LerpCoefficients::design(sigma, look_ahead, coefficient.bits()).map(|coefficients| Gains {
                g: Gain::new(coefficients.g),
                g_j: coefficients.g_j.into_iter().map(Gain::new).collect(),
            })
        };
        Ok(Self {
            gains: [gains(0)?, gains(1)?, gains(2)?],
            planes: blank(1, 1),
            scratch: Scratch::default(),
            features: Vec::new(),
        })
    }

    /// Takes a frame: afterwards [`SimdBitTrue::planes`] and the features returned are those of [`crate::model::bit_true`].
    pub fn frame(&mut self, pixels: &Plane<u16>, thresholds: [u32; SCALES]) -> &[FeatureRecord] {
        self.run(pixels, thresholds, chain)
    }

    /// The same without any choice at run time: the code every processor of the target can run.
    pub fn portable_frame(&mut self, pixels: &Plane<u16>, thresholds: [u32; SCALES]) -> &[FeatureRecord] {
        self.run(pixels, thresholds, chain_everywhere)
    }

    /// All planes of the last frame; before the first, one black pixel.
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The features of the last frame.
    pub fn features(&self) -> &[FeatureRecord] {
        &self.features
    }

    fn run(&mut self, pixels: &Plane<u16>, thresholds: [u32; SCALES], chain: Chain) -> &[FeatureRecord] {
        let (width, height) = (pixels.width(), pixels.height());
        let shape = &self.planes.smoothed[0];
        if (width, height) != (shape.width(), shape.height()) {
            self.planes = blank(width, height);
        }
        // No response reaches a threshold beyond 16 bits, nor 2^16 - 1 itself.
        let thresholds = thresholds.map(|threshold| u16::try_from(threshold.max(1)).unwrap_or(u16::MAX));
        chain(pixels, &self.gains, thresholds, &mut self.planes, &mut self.scratch);

        self.features.clear();
        let candidates = &mut self.scratch.candidates;
        candidates.retain(|&(y, x, k)| is_maximum(&self.planes.layers[k].dog.magnitude, x, y));
        candidates.sort_unstable();
        self.features.extend(candidates.iter().map(|&(y, x, k)| self.planes.record(x, y, k)));
        &self.features
    }
}

fn blank(width: usize, height: usize) -> Planes {
    let layer = || Layer {
        dog: Dog { magnitude: Plane::filled(width, height, 0), positive: Plane::filled(width, height, true) },
        max_dog: Plane::filled(width, height, 0),
    };
    Planes {
        smoothed: [(); SMOOTHERS].map(|()| Plane::filled(width, height, 0)),
        signed_dog: [(); SCALES].map(|()| Plane::filled(width, height, 0)),
        layers: [layer(), layer()],
        saturated: [0; SCALES],
    }
}

/// Everything of a frame up to the candidates of its features.
type Chain = fn(&Plane<u16>, &[Gains; SMOOTHERS], [u16; SCALES], &mut Planes, &mut Scratch);

#[multiversion(targets("x86_64+avx2"))]
fn chain(
    pixels: &Plane<u16>,
    gains: &[Gains; SMOOTHERS],
    thresholds: [u16; SCALES],
    planes: &mut Planes,
    scratch: &mut Scratch,
) {
    whole_chain(pixels, gains, thresholds, planes, scratch);
}

fn chain_everywhere(
    pixels: &Plane<u16>,
    gains: &[Gains; SMOOTHERS],
    thresholds: [u16; SCALES],
    planes: &mut Planes,
    scratch: &mut Scratch,
) {
    whole_chain(pixels, gains, thresholds, planes, scratch);
}

// Inlined into both: each is then compiled for its own instructions, this function and all below.
#[inline(always)]
fn whole_chain(
    pixels: &Plane<u16>,
    gains: &[Gains; SMOOTHERS],
    thresholds: [u16; SCALES],
    planes: &mut Planes,
    scratch: &mut Scratch,
) {
    let (width, height) = (pixels.width(), pixels.height());
    scratch.strip.resize(height, [0; LANES]);
    // One strip of pixels serves all smoothers while it is near.
    for left in (0..width).step_by(LANES) {
        for (gains, smoothed) in gains.iter().zip(&mut planes.smoothed) {
            columns(pixels, left, gains, smoothed, &mut scratch.strip);
        }
    }

    let pad = gains.iter().map(|gains| 1 << (gains.g_j.len() - 1)).max().unwrap_or(0);
    scratch.lines.iter_mut().for_each(|line| line.resize(width + 2 * pad, 0));
    scratch.responses.clear();
    scratch.responses.resize(width + 2 * MAX_RADIUS, 0);
    for line in scratch.row_maxima.as_flattened_mut() {
        line.clear();
        line.resize(width, 0);
    }
    scratch.candidates.clear();
    planes.saturated = [0; SCALES];
    for y in 0..height + MAX_RADIUS {
        if y < height {
            for (gains, smoothed) in gains.iter().zip(&mut planes.smoothed) {
                row(gains, smoothed.row_mut(y), &mut scratch.lines, pad);
            }
        }
        for (k, threshold) in thresholds.into_iter().enumerate() {
            let row_maxima = &mut scratch.row_maxima[k];
            let layer = &mut planes.layers[k];
            if y < height {
                let responses = &mut scratch.responses[MAX_RADIUS..MAX_RADIUS + width];
                planes.saturated[k] += difference(
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
                    candidates(responses, max_dog, threshold, |i| {
                        scratch.candidates.push((y, columns.start + i, k));
                    });
                }
            }
        }
    }
}

/// The vertical pass of one smoother over the strip of columns that begins at `left`. `strip` has a place for every row.
#[inline(always)]
fn columns(pixels: &Plane<u16>, left: usize, gains: &Gains, smoothed: &mut Plane<u32>, strip: &mut [Lanes]) {
    let (width, height) = (pixels.width(), pixels.height());
    let used = LANES.min(width - left);
    let states = |row: &[u16]| {
        let mut states = [0; LANES];
        match row[left..left + used].first_chunk::<LANES>() {
            Some(pixels) => (0..LANES).for_each(|l| states[l] = i32::from(pixels[l]) << 2),
            None => states.iter_mut().zip(&row[left..]).for_each(|(state, pixel)| *state = i32::from(*pixel) << 2),
        }
        states
    };
    // How many rows each stage has given; [0] is the recursion.
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
            // In place: the row ahead is one this stage has not come to. The last row is the same before and after every
            // stage, for it is a lerp of itself with itself.
            // The row ahead is copied because the compiler then knows the two apart; borrowed from one slice, the loop takes twice
            // as long.
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
        with_cell!(*gain, cell => lerp_lines(&from[pad - reach..][..width], &from[here.clone()], &mut to[here.clone()], cell));
        std::mem::swap(&mut from, &mut to);
    }
    for (j, gain) in gains.g_j.iter().enumerate() {
        let reach = 1 << j;
        let last = from[pad + width - 1];
        from[pad + width..pad + width + reach].fill(last);
        with_cell!(*gain, cell => lerp_lines(&from[pad + reach..][..width], &from[here.clone()], &mut to[here.clone()], cell));
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
fn difference(narrow: &[u32], wide: &[u32], signed: &mut [i32], positive: &mut [bool], dog: &mut [u16]) -> u64 {
    for ((signed, narrow), wide) in signed.iter_mut().zip(narrow).zip(wide) {
        *signed = (*narrow as i32).wrapping_sub(*wide as i32);
    }
    for (positive, signed) in positive.iter_mut().zip(&*signed) {
        *positive = *signed >= 0;
    }
    let mut largest = 0;
    for (dog, signed) in dog.iter_mut().zip(&*signed) {
        let rounded = (signed.unsigned_abs() + 1) >> 1;
        largest = largest.max(rounded);
        *dog = rounded.min(0x7fff) as u16;
    }
    // Saturation does not happen with sensible filters, so it is not counted before it is known to be there.
    if largest <= 0x7fff { 0 } else { signed.iter().filter(|d| (d.unsigned_abs() + 1) >> 1 > 0x7fff).count() as u64 }
}

/// The maxima of windows along a row; `responses` reaches over both ends by the radius of the window.
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

/// Calls `found` with each place where a response of at least the threshold equals its MaxDOG.
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
    use crate::model::lerp::lerp;
    use crate::pictures::{Content, Picture, pictures};
    use proptest::prelude::*;

    fn by_gain(p: i32, q: i32, gain: Gain) -> i32 {
        with_cell!(gain, cell => cell(p, q))
    }

    /// All differences there are, for one coefficient. The cell depends on `q - p` alone but for the sum at its end.
    fn every_difference(code: u32) {
        const TOP: i32 = 65535 << 2;
        let gain = Gain::new(code);
        for e in 0..=TOP {
            assert_eq!(by_gain(0, e, gain), lerp(0, e as u32, code, 16) as i32, "{code} x {e}");
            assert_eq!(
                by_gain(TOP, TOP - e, gain),
                lerp(TOP as u32, (TOP - e) as u32, code, 16) as i32,
                "{code} x -{e}"
            );
        }
    }

    #[test]
    fn cell_is_the_lerp_for_every_difference_and_design_coefficient() {
        let simd = SimdBitTrue::new(&KT27).unwrap();
        let bit_true = BitTrue::new(&KT27).unwrap();
        for (gains, coefficients) in simd.gains.iter().zip(bit_true.coefficients()) {
            every_difference(coefficients.g);
            assert_eq!(gains.g, Gain::new(coefficients.g));
            coefficients.g_j.iter().for_each(|code| every_difference(*code));
        }
        // Both ends of each way of computing it.
        for code in [1, 8191, 8192, 32767, 32768, 32769, 57344, 57345, 65535] {
            every_difference(code);
        }
    }

    #[test]
    fn cell_is_the_lerp_for_every_coefficient_at_the_extremes() {
        for code in 1..1u32 << 16 {
            let gain = Gain::new(code);
            for e in [1, 2, 3, 4, 5, 131_070, 131_072, 262_135, 262_137, 262_138, 262_139, 262_140] {
                for (p, q) in [(0, e), (e, 0)] {
                    assert_eq!(by_gain(p, q, gain), lerp(p as u32, q as u32, code, 16) as i32, "{code}: {p} {q}");
                }
            }
        }
    }

    #[test]
    fn other_formats_are_refused() {
        for text in ["state=u16.3", "coefficient=u0.15", "dog_bits=12"] {
            let message = SimdBitTrue::new(&KT27.with_override(text).unwrap()).unwrap_err().to_string();
            assert!(message.contains("only, not"), "{message}");
        }
    }

    #[test]
    fn a_whole_frame_is_that_of_the_bit_true_model() {
        let content = Content::Noise { low: 20_000, high: 30_000 };
        let frame = Picture { width: 1024, height: 768, seed: 11, content }.draw();
        let planes = BitTrue::new(&KT27).unwrap().planes(&frame);
        let features = planes.features([300, 200]);
        assert!(features.len() > 800, "{}", features.len());
        let mut simd = SimdBitTrue::new(&KT27).unwrap();
        assert_eq!(simd.frame(&frame, [300, 200]), features);
        assert!(*simd.planes() == planes);
        assert_eq!(simd.portable_frame(&frame, [300, 200]), features);
        assert!(*simd.planes() == planes);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn planes_and_features_are_those_of_the_bit_true_model(frames in prop::collection::vec(pictures(110), 1..3)) {
            let bit_true = BitTrue::new(&KT27).unwrap();
            let mut simd = SimdBitTrue::new(&KT27).unwrap();
            let mut portable = simd.clone();
            for frame in &frames {
                let frame = &frame.draw();
                let planes = bit_true.planes(frame);
                for thresholds in [[1, 1], [40, 700], [0, 70_000]] {
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
