//! The fast float extractor: the features of [`extractor`](crate::features::extractor) with the first-order smoothers
//! of the level `recursive`, in f32.
//!
//! [`FastExtractor`] is the path for every use of float features; the f64 path is the reference of its tests. Because
//! an f32 has 24 significant bits, the two are not bit-identical. Measured on four real pictures
//! with 1000 features each: all 4000 features are at the same pixel, responses differ by at most
//! 0.015 DN, and 1 of 512 000 descriptor bits differs. A test requires 990 features of each 1000, 0.05 DN and 5 bits in
//! 10 000.
//!
//! `G_a = C^T C` along the rows, then the same down the columns, where `C` is the causal recursion
//! `s += (1 - a)(x - s)`, `s[-1] = x[0]`, and `C^T` its mirror image, which repeats the last sample. The `F` smoothers
//! of a chain run in parallel:
//!
//! 1. Eight rows at a time: eight columns are transposed, so that the recursion along a row has eight rows as its
//!    lanes; the causal half fills a buffer of one block of rows. The anticausal half runs back over it, is transposed
//!    again, and feeds the causal half of the columns, whose lanes are columns. Rows come before columns here, and
//!    after them in the f64 path; the order changes the rounding only.
//! 2. From the last row upwards: the anticausal half of the columns, `d_k`, and the maximum of 7 along the row. After
//!    seven rows the maximum of the 7x7 window is known, and a sample that equals it is a candidate.
//! 3. MaxDOG and sign bits are read for the selected features only.
//!
//! The speed is limited by memory, so the planes are written once, read once and overwritten in place. Loops over
//! arrays of fixed size are vectorised by the compiler; AVX2 is used if the processor has it. There is no fused
//! multiply-add and no reordered sum, so AVX2 and portable code give the same bits.

use multiversion::multiversion;

use crate::features::dog::SIGMAS;
use crate::features::extractor::Selection;
use crate::features::feature::{Descriptor, Feature, MAX_PAIRS};
use crate::features::maxima::{WINDOW_RADIUS, eligible, spread};
use crate::features::maxlbp::{MAX_RADIUS, Ring};
use crate::image::plane::Plane;
use crate::smoothing::design::DesignError;
use crate::smoothing::recursive::first_order;

/// Samples side by side in one vector: eight f32 fill an AVX2 register.
const LANES: usize = 8;

/// One sample of `LANES` neighbouring lines.
type Lanes = [f32; LANES];

/// `LANES` lines of `LANES` samples.
type Tile = [Lanes; LANES];

/// One vector of each of the `F` smoothers.
type Smoothed<const F: usize> = [Lanes; F];

/// Rows of maxima along the row that are kept: the height of the 7x7 window.
const WINDOW: usize = 2 * WINDOW_RADIUS + 1;

/// The fast float extractor of a chain of `F` smoothers. It keeps its buffers from frame to frame.
#[derive(Debug, Clone)]
pub struct FastExtractor<const F: usize = { SIGMAS.len() }> {
    selection: Selection,
    poles: [f32; F],
    /// The ring of each scale pair, and of more.
    rings: [Ring; MAX_PAIRS],
    /// A block of rows after the causal half along the rows: one entry per column, lanes are rows.
    block: Vec<Smoothed<F>>,
    /// State of the recursion down or up the columns: one entry per eight columns, as in `planes`.
    columns: Vec<Smoothed<F>>,
    /// First the `F` smoothed rows of every row, which lack the anticausal half of the columns; then, in all of them
    /// but the last, the signed `d_k` in their place. A row of one is `stride` samples.
    planes: Vec<f32>,
    scratch: Scratch,
    candidates: Vec<Candidate>,
}

/// The work memory of the search for maxima.
#[derive(Debug, Clone, Default)]
struct Scratch {
    /// `DOG_k` of one row.
    magnitude: Vec<f32>,
    /// Maxima of 7 along the row, of the last seven rows.
    row_maxima: Vec<[Vec<f32>; WINDOW]>,
    /// Bit `k` is set if the sample may be a maximum of scale `k`.
    flags: Vec<u8>,
}

#[derive(Debug, Clone, Copy)]
struct Candidate {
    x: u32,
    y: u32,
    scale: u8,
    response: f32,
}

impl FastExtractor {
    /// Returns an extractor of the default chain, for frames of any size.
    ///
    /// # Errors
    /// No pole can be found for the default sigmas, which is a defect of this program.
    pub fn new(selection: Selection) -> Result<Self, DesignError> {
        Self::of_chain(SIGMAS, selection)
    }
}

impl<const F: usize> FastExtractor<F> {
    /// Returns an extractor of a chain of ascending sigmas (px), for frames of any size.
    ///
    /// # Errors
    /// A sigma is out of range.
    pub fn of_chain(sigmas: [f64; F], selection: Selection) -> Result<Self, DesignError> {
        let mut poles = [0.0; F];
        for (pole, sigma) in poles.iter_mut().zip(sigmas) {
            *pole = first_order::pole(sigma)? as f32;
        }
        Ok(Self {
            selection,
            poles,
            rings: Ring::defaults(),
            block: Vec::new(),
            columns: Vec::new(),
            planes: Vec::new(),
            scratch: Scratch::default(),
            candidates: Vec::new(),
        })
    }

    /// Replaces the rings. `radii` has the radius (px) of each scale pair.
    pub fn with_rings(mut self, radii: &[u32]) -> Self {
        self.rings.iter_mut().zip(radii).for_each(|(ring, radius)| *ring = Ring::of_radius(*radius));
        self
    }

    /// Extracts the features of a frame, in raster order, the lower `k` first at a pixel.
    pub fn extract(&mut self, frame: &Plane<u16>) -> Vec<Feature> {
        let (width, height) = (frame.width(), frame.height());
        if eligible(width).is_empty() || eligible(height).is_empty() {
            return Vec::new();
        }
        let stride = width.next_multiple_of(LANES) + 2 * LANES;
        self.block.resize(stride, [Lanes::default(); F]);
        self.columns.resize(stride / LANES, [Lanes::default(); F]);
        self.planes.resize(F * stride * height.next_multiple_of(LANES), 0.0);
        self.scratch.resize(F - 1, stride);

        smooth_rows_and_down(frame.as_slice(), width, self.poles, &mut self.block, &mut self.columns, &mut self.planes);

        let threshold = self.selection.threshold as f32;
        let columns = eligible(width);
        self.candidates.clear();
        for y in (0..height).rev() {
            let rows = &mut self.planes[y * F * stride..][..F * stride];
            if y == height - 1 {
                hold(rows, &mut self.columns);
            }
            smooth_up(rows, self.poles, &mut self.columns);
            for (k, dog) in rows.chunks_exact(stride).take(F - 1).enumerate() {
                let maxima = &mut self.scratch.row_maxima[k][y % WINDOW];
                maxima_along_row(dog, &mut self.scratch.magnitude, maxima);
            }
            let centre = y + WINDOW_RADIUS;
            if eligible(height).contains(&centre) {
                let flags = &mut self.scratch.flags[columns.clone()];
                for (k, row_maxima) in self.scratch.row_maxima.iter().enumerate() {
                    let centres = &self.planes[(F * centre + k) * stride..][columns.clone()];
                    let rows = std::array::from_fn(|i| &row_maxima[(y + i) % WINDOW][columns.clone()]);
                    flag(centres, rows, threshold, k, flags);
                }
                gather::<F>(flags, &self.planes, stride, (columns.start, centre), &mut self.candidates);
            }
        }
        self.candidates.reverse();
        let kept = spread(&self.candidates, self.selection.count, |c| (c.x, c.y, f64::from(c.response)));
        describe::<F>(&kept, &self.rings, &self.planes, stride)
    }
}

impl Scratch {
    fn resize(&mut self, pairs: usize, stride: usize) {
        self.row_maxima.resize_with(pairs, Default::default);
        self.magnitude.resize(stride, 0.0);
        self.row_maxima.iter_mut().flatten().for_each(|row| row.resize(stride, 0.0));
        self.flags.resize(stride, 0);
    }
}

/// Advances a recursion by one sample, `s = a s + (x - a x)`. Only one product and one sum depend on the previous
/// state. A constant passes unchanged to the last bit: `a` is above a half, so `x - a x` is exact (Sterbenz) and the
/// sum gives `x` again.
#[inline(always)]
fn step(x: &Lanes, a: f32, state: &mut Lanes) {
    for l in 0..LANES {
        state[l] = a * state[l] + (x[l] - a * x[l]);
    }
}

/// Exchanges rows and columns.
#[inline(always)]
fn transposed(tile: &Tile) -> Tile {
    let mut out = Tile::default();
    for (r, row) in tile.iter().enumerate() {
        for (c, &sample) in row.iter().enumerate() {
            out[c][r] = sample;
        }
    }
    out
}

/// Runs step 1: both halves along the rows and the causal half down the columns.
#[multiversion(targets("x86_64+avx2"))]
fn smooth_rows_and_down<const F: usize>(
    frame: &[u16],
    width: usize,
    poles: [f32; F],
    block: &mut [Smoothed<F>],
    columns: &mut [Smoothed<F>],
    planes: &mut [f32],
) {
    let (height, vectors) = (frame.len() / width, columns.len());
    for (b, planes) in planes.as_chunks_mut::<LANES>().0.chunks_exact_mut(F * vectors * LANES).enumerate() {
        // Below the frame the last row is repeated. Those lanes go to rows of `planes` that are not read.
        let rows: [&[u16]; LANES] = std::array::from_fn(|r| &frame[(b * LANES + r).min(height - 1) * width..][..width]);

        let mut state = [std::array::from_fn(|r| f32::from(rows[r][0])); F];
        for (v, out) in block.chunks_exact_mut(LANES).enumerate() {
            let x = v * LANES;
            let tile: Tile = if x + LANES <= width {
                std::array::from_fn(|r| {
                    let dn: [u16; LANES] = std::array::from_fn(|c| rows[r][x..x + LANES][c]);
                    dn.map(f32::from)
                })
            } else {
                std::array::from_fn(|r| std::array::from_fn(|c| f32::from(rows[r][(x + c).min(width - 1)])))
            };
            for (column, out) in transposed(&tile).iter().zip(out) {
                for f in 0..F {
                    step(column, poles[f], &mut state[f]);
                }
                *out = state;
            }
        }
        // The anticausal half repeats the last sample, so it can start on copies of it right of the frame.
        let mut state = block[width - 1];
        block[width..].fill(state);
        for column in block.iter_mut().rev() {
            for f in 0..F {
                step(&column[f], poles[f], &mut state[f]);
            }
            *column = state;
        }

        for (v, (tile, columns)) in block.chunks_exact(LANES).zip(columns.iter_mut()).enumerate() {
            for f in 0..F {
                let tile = transposed(&std::array::from_fn(|c| tile[c][f]));
                let mut down = if b == 0 { tile[0] } else { columns[f] };
                for (r, row) in tile.iter().enumerate() {
                    step(row, poles[f], &mut down);
                    planes[(F * r + f) * vectors + v] = down;
                }
                columns[f] = down;
            }
        }
    }
}

/// Initialises the anticausal half of the columns with the last row.
fn hold<const F: usize>(rows: &[f32], columns: &mut [Smoothed<F>]) {
    for (f, row) in rows.chunks_exact(columns.len() * LANES).enumerate() {
        for (vector, state) in row.as_chunks::<LANES>().0.iter().zip(columns.iter_mut()) {
            state[f] = *vector;
        }
    }
}

/// Runs step 2 for one row: the anticausal half up the columns. `d_k` replaces all smoothed rows but the last.
#[multiversion(targets("x86_64+avx2"))]
fn smooth_up<const F: usize>(rows: &mut [f32], poles: [f32; F], columns: &mut [Smoothed<F>]) {
    let vectors = columns.len();
    let mut rows = rows.as_chunks_mut::<LANES>().0.chunks_exact_mut(vectors);
    let rows: [&mut [Lanes]; F] = std::array::from_fn(|_| rows.next().unwrap_or_default());
    for (v, state) in columns.iter_mut().enumerate() {
        for f in 0..F {
            step(&rows[f][v], poles[f], &mut state[f]);
        }
        for k in 0..F - 1 {
            for l in 0..LANES {
                rows[k][v][l] = state[k][l] - state[k + 1][l];
            }
        }
    }
}

/// Returns the larger number; unlike `f32::max` it compiles to one instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Writes `out[x] = max |dog[x - 3 ..= x + 3]|`. The outermost three are not written, because no eligible window has
/// them as its centre.
#[multiversion(targets("x86_64+avx2"))]
fn maxima_along_row(dog: &[f32], magnitude: &mut [f32], out: &mut [f32]) {
    for (m, d) in magnitude.iter_mut().zip(dog) {
        *m = d.abs();
    }
    let count = dog.len() - (WINDOW - 1);
    let shifted: [&[f32]; WINDOW] = std::array::from_fn(|i| &magnitude[i..i + count]);
    let out = &mut out[WINDOW_RADIUS..][..count];
    for x in 0..count {
        out[x] = shifted[1..].iter().fold(shifted[0][x], |m, row| larger(row[x], m));
    }
}

/// Sets bit `scale` of a flag if the centre reaches the threshold, exceeds the maxima of the three earlier rows and is
/// not below those of its own and the three later rows; clears it otherwise. `rows` are the maxima along the rows,
/// topmost first.
#[multiversion(targets("x86_64+avx2"))]
fn flag(centres: &[f32], rows: [&[f32]; WINDOW], threshold: f32, scale: usize, flags: &mut [u8]) {
    let count = centres.len();
    let rows: [&[f32]; WINDOW] = std::array::from_fn(|i| &rows[i][..count]);
    let (earlier, later) = rows.split_at(WINDOW_RADIUS);
    let flags = &mut flags[..count];
    for x in 0..count {
        let centre = centres[x].abs();
        let before = earlier[1..].iter().fold(earlier[0][x], |m, row| larger(row[x], m));
        let after = later.iter().fold(threshold, |m, row| larger(row[x], m));
        flags[x] = flags[x] & !(1 << scale) | u8::from((centre > before) & (centre >= after)) << scale;
    }
}

/// Appends the flagged samples that none of the three to their left equals, from the last to the first. `start` is
/// column and row of the first flag.
fn gather<const F: usize>(
    flags: &[u8],
    planes: &[f32],
    stride: usize,
    start: (usize, usize),
    candidates: &mut Vec<Candidate>,
) {
    let mut examine = |i: usize, k: usize| {
        let (x, y) = (start.0 + i, start.1);
        let at = (F * y + k) * stride + x;
        let response = planes[at].abs();
        if planes[at - WINDOW_RADIUS..at].iter().all(|d| d.abs() < response) {
            candidates.push(Candidate { x: x as u32, y: y as u32, scale: k as u8, response });
        }
    };
    for (word, flags) in flags.chunks(8).enumerate().rev() {
        let mut bytes = [0; 8];
        bytes[..flags.len()].copy_from_slice(flags);
        // Bit `8 i + k` is sample `i`, scale `k`.
        let mut left = u64::from_le_bytes(bytes);
        while left != 0 {
            let bit = 63 - left.leading_zeros() as usize;
            examine(8 * word + bit / 8, bit % 8);
            left &= !(1 << bit);
        }
    }
}

/// Runs step 3: neighbours and descriptors of the selected features.
#[multiversion(targets("x86_64+avx2"))]
fn describe<const F: usize>(
    kept: &[Candidate],
    rings: &[Ring; MAX_PAIRS],
    planes: &[f32],
    stride: usize,
) -> Vec<Feature> {
    let pitch = F * stride;
    let mut features = Vec::with_capacity(kept.len());
    for c in kept {
        let at = |k: usize| c.y as usize * pitch + k * stride + c.x as usize;
        let mut descriptor = Descriptor::default();
        for k in 0..F - 1 {
            let response = planes[at(k)].abs();
            for (i, &(dx, dy)) in rings[k].0.iter().enumerate() {
                let point = at(k).wrapping_add_signed(dy as isize * pitch as isize + dx as isize);
                descriptor.sign[k] |= u32::from(planes[point] >= 0.0) << i;
                descriptor.maxlbp[k] |= u32::from(response >= max_dog(planes, pitch, point)) << i;
            }
        }
        let at = at(usize::from(c.scale));
        let dn = |at: usize| f64::from(planes[at].abs());
        features.push(Feature {
            x: c.x,
            y: c.y,
            scale: c.scale,
            bright: planes[at] >= 0.0,
            response: dn(at),
            neighbours: [dn(at - 1), dn(at + 1), dn(at - pitch), dn(at + pitch)],
            descriptor,
        });
    }
    features
}

/// Returns `MaxDOG` at one sample. Of every row a vector of eight samples is read, of which five count. The others may
/// belong to the next row, which always exists: the widest smoothing follows the last `d_k` of the last row.
#[inline(always)]
fn max_dog(planes: &[f32], pitch: usize, at: usize) -> f32 {
    let mut highest = Lanes::default();
    for r in 0..=2 * MAX_RADIUS {
        let row = &planes[at + r * pitch - MAX_RADIUS * (pitch + 1)..][..LANES];
        for l in 0..LANES {
            highest[l] = larger(row[l].abs(), highest[l]);
        }
    }
    highest[1..=2 * MAX_RADIUS].iter().fold(highest[0], |m, &v| larger(v, m))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::features::extractor::{features, layers};
    use crate::features::maxlbp::MAX_RING_RADIUS;
    use crate::smoothing::recursive::border::Border;
    use crate::smoothing::smoother::Smoother;

    fn clear(plane: &Plane<f64>, sigma: f64) -> Plane<f64> {
        Smoother::first_order(sigma).unwrap().smooth(plane, Border::Held)
    }

    fn key(f: &Feature) -> (u32, u32, u8) {
        (f.y, f.x, f.scale)
    }

    /// Returns a picture of `blobs`: `(x, y, size, dn)` rectangles painted over a ramp, so that edges, flat parts and
    /// steep gradients up to the border all occur.
    fn painted(width: usize, height: usize, blobs: &[(usize, usize, usize, u16)]) -> Plane<u16> {
        let mut frame = Plane::from_fn(width, height, |x, y| ((300 * x + 170 * y) % 65_536) as u16);
        for &(x, y, size, dn) in blobs {
            for y in y % height..(y % height + size).min(height) {
                let x = x % width;
                frame.row_mut(y)[x..(x + size).min(width)].fill(dn);
            }
        }
        frame
    }

    fn pictures() -> impl Strategy<Value = Plane<u16>> {
        let blob = (0usize..200, 0usize..200, 1usize..30, any::<u16>());
        (37usize..90, 37usize..90, prop::collection::vec(blob, 1..60)).prop_map(|(w, h, blobs)| painted(w, h, &blobs))
    }

    /// Largest difference of `d_k` due to f32, DN. A step of a recursion rounds two products and a sum of up to 2^16
    /// DN: three half-ulps of 2^-8, 0.006. The recursion sums those with weights `a^n`, up to 1 / (1 - a) = 5.7 times,
    /// four halves follow each other and two planes are subtracted: 0.27 in the worst case. Rounding errors partly
    /// cancel: 0.015 is measured.
    const TOLERANCE: f64 = 0.05;

    fn extracted<const F: usize>(
        sigmas: [f64; F],
        radii: [u32; MAX_PAIRS],
        selection: Selection,
        frame: &Plane<u16>,
    ) -> Vec<Feature> {
        FastExtractor::of_chain(sigmas, selection).unwrap().with_rings(&radii).extract(frame)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn features_agree_with_the_f64_path(
            frame in pictures(), pairs in 1usize..=3, radii in prop::array::uniform3(4..=MAX_RING_RADIUS),
        ) {
            let sigmas = &[2.0, 3.2, 5.12, 8.2][..=pairs];
            let layers = layers(&frame, sigmas, &radii.map(Ring::of_radius), clear);
            let threshold = 8.0;
            let all = |t: f64| features(&layers, &[t; 3][..pairs], 1.0);
            let selection = Selection { threshold, count: usize::MAX };
            let fast = match *sigmas {
                [a, b] => extracted([a, b], radii, selection, &frame),
                [a, b, c] => extracted([a, b, c], radii, selection, &frame),
                [a, b, c, d] => extracted([a, b, c, d], radii, selection, &frame),
                _ => unreachable!(),
            };
            prop_assert!(fast.windows(2).all(|w| key(&w[0]) < key(&w[1])), "raster order");
            // Every feature exists in the other path, except where two responses of a window differ by less than the
            // rounding.
            let clear_ones = all(threshold);
            for (ours, theirs, what) in [(&fast, &clear_ones, "new"), (&clear_ones, &fast, "lost")] {
                for f in ours {
                    if theirs.binary_search_by_key(&key(f), key).is_err() {
                        let dog = &layers[usize::from(f.scale)].dog.magnitude;
                        let (x, y) = (f.x as usize, f.y as usize);
                        let rival = (y - 3..=y + 3)
                            .flat_map(|r| (x - 3..=x + 3).map(move |c| (c, r)))
                            .filter(|&at| at != (x, y))
                            .map(|at| dog[at])
                            .fold(threshold, f64::max);
                        prop_assert!((dog[(x, y)] - rival).abs() < TOLERANCE, "{what} {f:?}, rival {rival}");
                    }
                }
            }
            for f in &fast {
                let Ok(at) = clear_ones.binary_search_by_key(&key(f), key) else { continue };
                let theirs = &clear_ones[at];
                prop_assert!((f.response - theirs.response).abs() < TOLERANCE);
                for (a, b) in f.neighbours.iter().zip(theirs.neighbours) {
                    prop_assert!((a - b).abs() < TOLERANCE);
                }
                prop_assert!(f.bright == theirs.bright);
                for k in 0..pairs {
                    for (i, &(dx, dy)) in layers[k].ring.0.iter().enumerate() {
                        let at = (f.x as usize, f.y as usize);
                        let ring = (at.0.wrapping_add_signed(dx as isize), at.1.wrapping_add_signed(dy as isize));
                        let margin = (layers[k].dog.magnitude[at] - layers[k].max_dog[ring]).abs();
                        let differs = |a: [u32; 3], b: [u32; 3]| (a[k] ^ b[k]) >> i & 1 == 1;
                        prop_assert!(!differs(f.descriptor.maxlbp, theirs.descriptor.maxlbp) || margin < TOLERANCE);
                        let margin = layers[k].dog.magnitude[ring];
                        prop_assert!(!differs(f.descriptor.sign, theirs.descriptor.sign) || margin < TOLERANCE);
                    }
                }
            }
        }

        #[test]
        fn results_do_not_depend_on_the_frame_before(first in pictures(), second in pictures()) {
            let mut used = FastExtractor::new(Selection::default()).unwrap();
            used.extract(&first);
            let fresh = FastExtractor::new(Selection::default()).unwrap().extract(&second);
            prop_assert_eq!(used.extract(&second), fresh);
        }
    }

    #[test]
    fn constant_and_tiny_frames_have_no_features() {
        let mut extractor = FastExtractor::new(Selection::default()).unwrap();
        for dn in [0, 1, 12_345, u16::MAX] {
            assert_eq!(extractor.extract(&Plane::filled(100, 75, dn)), [], "{dn} DN");
        }
        for (w, h) in [(1, 1), (1, 300), (300, 1), (36, 37), (37, 36)] {
            assert_eq!(
                extractor.extract(&Plane::from_fn(w, h, |x, y| (x * 7919 + y * 31_337) as u16)),
                [],
                "{w} x {h}"
            );
        }
    }

    #[test]
    fn stripes_have_no_maxima() {
        // Along a stripe all responses are equal: every sample has an equal one earlier in raster order.
        let wave = |t: usize| [9_000u16, 13_000, 40_000, 61_000, 52_000, 21_000, 8_000][t % 7];
        let mut extractor = FastExtractor::new(Selection::default()).unwrap();
        assert_eq!(extractor.extract(&Plane::from_fn(150, 110, |x, _| wave(x))), [], "down the columns");
        assert_eq!(extractor.extract(&Plane::from_fn(150, 110, |_, y| wave(y))), [], "along the rows");
    }

    #[test]
    fn the_one_eligible_pixel_of_a_37_px_frame_is_found() {
        let mut frame = Plane::filled(37, 37, 1000u16);
        frame[(18, 18)] = 60_000;
        let found = FastExtractor::new(Selection::default()).unwrap().extract(&frame);
        assert_eq!(found.iter().map(key).collect::<Vec<_>>(), [(18, 18, 0), (18, 18, 1)]);
        assert!(found.iter().all(|f| f.bright));
    }
}
