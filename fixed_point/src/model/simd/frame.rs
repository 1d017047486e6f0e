//! The loops over a frame: from pixels to planes and to the candidates of features.

use hoverlock_design::DesignPoint;
use hoverlock_reference::features::maxima::eligible;
use hoverlock_reference::features::maxlbp::MAX_RADIUS;
use hoverlock_reference::image::plane::Plane;
use multiversion::multiversion;

use super::cell::{Gain, with_cell};
use crate::model::bit_true::Planes;
use crate::model::coefficients::MAX_LOOK_AHEAD;

/// Columns of a strip: four cache lines of states.
const LANES: usize = 64;

/// Rows of a strip that a stage processes before the next stage runs, so that their rows stay in the cache.
const BLOCK: usize = 16;

/// The states of one row of a strip.
type Lanes = [i32; LANES];

/// Rows of the MaxDOG window.
const MAX_ROWS: usize = 2 * MAX_RADIUS + 1;

/// The coefficients of one smoother.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Gains {
    pub g: Gain,
    pub g_j: Vec<Gain>,
}

/// The quantities of the formats that the loops use.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words {
    /// Fraction bits of the state.
    fraction_bits: u32,
    /// `s`, where it is positive: the state has the smaller LSB.
    right: u32,
    /// `-s`, where that is positive.
    left: u32,
    /// Half an LSB of the DoG, in LSB of the state.
    half: u32,
    /// Largest response, LSB of the DoG.
    max: u32,
}

impl Words {
    pub fn new(design: &DesignPoint) -> Self {
        let right = design.dog_shift().max(0) as u32;
        Self {
            fraction_bits: design.state.fraction_bits() as u32,
            right,
            left: (-design.dog_shift()).max(0) as u32,
            half: (1 << right) >> 1,
            max: design.max_dog(),
        }
    }

    /// Computes `(|d| + 2^(s-1)) >> s`, without saturation.
    #[inline(always)]
    fn rounded(self, d: i32) -> u32 {
        ((d.unsigned_abs() + self.half) >> self.right) << self.left
    }
}

/// The work memory of the loops, reused from frame to frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    /// One strip of columns.
    strip: Vec<Lanes>,
    /// A row of states before and after a stage, with space for repeated border samples at both ends.
    lines: [Vec<i32>; 2],
    /// A row of responses, with space for the MaxDOG window at both ends.
    responses: Vec<u16>,
    /// Horizontal maxima of the last rows, one ring buffer per scale pair.
    row_maxima: Vec<[Vec<u16>; MAX_ROWS]>,
    /// Pixels of at least the threshold that equal their MaxDOG: `(y, x, k)`.
    pub candidates: Vec<(usize, usize, usize)>,
}

/// A function that computes the planes of a frame and the candidates of its features.
pub(super) type Chain = fn(&Plane<u16>, &[Gains], Words, &[u16], &mut Planes, &mut Scratch);

#[multiversion(targets("x86_64+avx2"))]
pub(super) fn chain(
    pixels: &Plane<u16>,
    gains: &[Gains],
    words: Words,
    thresholds: &[u16],
    planes: &mut Planes,
    scratch: &mut Scratch,
) {
    whole_chain(pixels, gains, words, thresholds, planes, scratch);
}

pub(super) fn chain_portable(
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

/// Applies the vertical pass of one smoother to the strip of columns that begins at `left`. `strip` has an entry for
/// every row.
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
    // Number of rows that are converted, then of those that each look-ahead stage has output, the longest first.
    let mut given = [0; MAX_LOOK_AHEAD as usize + 1];
    let stages = gains.g_j.len();
    let mut state = [0; LANES];
    let mut written = 0;
    while written < height {
        let rows = given[0]..(given[0] + BLOCK).min(height);
        given[0] = rows.end;
        for r in rows {
            strip[r] = states(pixels.row(r));
        }
        for (stage, (j, gain)) in gains.g_j.iter().enumerate().rev().enumerate() {
            let reach = 1 << j;
            let ready =
                if given[stage] == height { height } else { given[stage].saturating_sub(reach).max(given[stage + 1]) };
            let rows = given[stage + 1]..ready;
            given[stage + 1] = ready;
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
        if written == 0 {
            state = strip[0];
        }
        with_cell!(gains.g, cell => {
            for here in &mut strip[written..given[stages]] {
                for l in 0..LANES {
                    state[l] = cell(state[l], here[l]);
                }
                *here = state;
            }
        });
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

/// Applies the horizontal pass of one smoother to one row, in place.
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

/// Computes one row of `d_k`, its sign bits and `DOG_k`, and returns the number of saturated samples.
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

/// Computes the maxima of windows along a row. `responses` extends beyond both ends by the radius of the window.
#[inline(always)]
fn maxima_along_row(responses: &[u16], maxima: &mut [u16]) {
    let width = maxima.len();
    let [a, b, c, d, e] = std::array::from_fn::<_, MAX_ROWS, _>(|shift| &responses[shift..shift + width]);
    for (i, max) in maxima.iter_mut().enumerate() {
        *max = a[i].max(b[i]).max(c[i]).max(d[i].max(e[i]));
    }
}

/// Computes the maxima of each column over several rows.
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
