//! Errors of one model level against another, `e = test - reference`: on planes, features and descriptor bits.
//!
//! ```text
//! bias = mean(e)     rms = sqrt(mean(e^2))     SQNR = 20 log10(rms(reference) / rms(e)) dB
//! kept = min(recall, precision) = common / max(features of the one, features of the other)
//! flip rate = bits that differ / bits, at the pixels of the reference's features
//! ```
//!
//! Planes hold DN of the 16-bit camera sample; errors are in LSB of the format of the test plane.
//! The margin of a bit is the distance of the reference from its decision threshold: `|DOG(p) - MaxDOG(o_i)|` for
//! MaxLBP, `|d(o_i)|` for the sign. A flip at a margin of an LSB is caused by rounding; a flip at a large margin
//! indicates a defect.

use std::collections::BTreeSet;

use hoverlock_reference::features::feature::{Descriptor, Feature, RING_POINTS};
use hoverlock_reference::features::maxlbp::{Layer, descriptor};
use hoverlock_reference::image::plane::Plane;
use serde::{Deserialize, Serialize};

/// The part of a frame that is left when columns and rows at its sides are excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Columns excluded at the left.
    pub left: usize,
    /// Rows excluded at the top.
    pub top: usize,
    /// Columns excluded at the right.
    pub right: usize,
    /// Rows excluded at the bottom.
    pub bottom: usize,
}

impl Region {
    /// The whole frame.
    pub const WHOLE: Self = Self { left: 0, top: 0, right: 0, bottom: 0 };
}

/// The error of one plane against another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorStatistics {
    /// Number of samples compared.
    pub samples: u64,
    /// The error of greatest magnitude, with its sign, LSB.
    pub max: f64,
    /// Column and row of that error; the first in raster order.
    pub max_at: (usize, usize),
    /// Mean error, LSB.
    pub bias: f64,
    /// Root mean square error, LSB.
    pub rms: f64,
    /// Root mean square of the reference, LSB.
    pub reference_rms: f64,
    /// `20 log10(reference_rms / rms)`, dB; infinite if there is no error.
    pub sqnr_db: f64,
    /// How often each error occurs.
    pub histogram: UlpHistogram,
}

/// Histogram of errors in LSB, with bins of equal width, symmetric about 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UlpHistogram {
    /// Width of a bin, LSB: 1, or the least power of two for which the largest error is inside the histogram.
    pub bin_lsb: f64,
    /// Counts; the middle one holds `|e| < bin_lsb / 2`.
    pub counts: Vec<u64>,
}

impl UlpHistogram {
    /// Bins on each side of the middle one.
    const REACH: usize = 12;

    fn for_reach_of(max: f64) -> Self {
        let mut bin_lsb = 1.0;
        while max.is_finite() && max > (Self::REACH as f64 + 0.5) * bin_lsb {
            bin_lsb *= 2.0;
        }
        Self { bin_lsb, counts: vec![0; 2 * Self::REACH + 1] }
    }

    fn count(&mut self, error: f64) {
        let reach = Self::REACH as f64;
        // Half away from zero, as `round`, which is a call on processors before SSE 4.1. NaN is in the first bin.
        let bins = (error / self.bin_lsb).clamp(-reach, reach);
        let whole = bins as i64;
        let rest = bins - whole as f64;
        let bin = whole + i64::from(rest >= 0.5) - i64::from(rest <= -0.5) + Self::REACH as i64;
        self.counts[if bins.is_nan() { 0 } else { bin as usize }] += 1;
    }

    /// Returns the error in the middle of each bin, LSB.
    pub fn centres(&self) -> impl Iterator<Item = f64> {
        let (bin_lsb, reach) = (self.bin_lsb, Self::REACH as f64);
        (0..self.counts.len()).map(move |bin| (bin as f64 - reach) * bin_lsb)
    }
}

impl ErrorStatistics {
    /// Compares `test` with `reference` inside `region`; `lsb` is the LSB of the test plane in the unit of the planes,
    /// a power of two. `None` where the region has no sample.
    ///
    /// # Panics
    /// The planes differ in shape.
    pub fn between(reference: &Plane<f64>, test: &Plane<f64>, lsb: f64, region: Region) -> Option<Self> {
        let (width, height) = (reference.width(), reference.height());
        assert_eq!((width, height), (test.width(), test.height()), "planes of different shape");
        let columns = region.left..width.checked_sub(region.right)?;
        let rows = region.top..height.checked_sub(region.bottom)?;
        if columns.is_empty() || rows.is_empty() {
            return None;
        }
        let pairs = |y: usize| {
            let reference = &reference.row(y)[columns.clone()];
            reference.iter().zip(&test.row(y)[columns.clone()])
        };
        // Exact, and cheaper than a division for each sample.
        let per_lsb = lsb.recip();
        let (mut max, mut max_at) = (0.0f64, (columns.start, rows.start));
        let (mut sum, mut squares, mut reference_squares) = (0.0, 0.0, 0.0);
        for y in rows.clone() {
            for (x, (&reference, &test)) in columns.clone().zip(pairs(y)) {
                let error = (test - reference) * per_lsb;
                if error.abs() > max.abs() || error.is_nan() {
                    (max, max_at) = (error, (x, y));
                }
                sum += error;
                squares += error * error;
                reference_squares += (reference * per_lsb).powi(2);
            }
        }
        let samples = (columns.len() * rows.len()) as u64;
        let count = samples as f64;
        let (rms, reference_rms) = ((squares / count).sqrt(), (reference_squares / count).sqrt());
        let mut histogram = UlpHistogram::for_reach_of(max.abs());
        for y in rows {
            pairs(y).for_each(|(&reference, &test)| histogram.count((test - reference) * per_lsb));
        }
        let sqnr_db = if rms == 0.0 { f64::INFINITY } else { 20.0 * (reference_rms / rms).log10() };
        Some(Self { samples, max, max_at, bias: sum / count, rms, reference_rms, sqnr_db, histogram })
    }
}

/// Returns the response of the given rank among those of the features of one scale; 0 with fewer features than `rank`.
pub fn response_of_rank(mut responses: Vec<f64>, rank: usize) -> f64 {
    responses.sort_unstable_by(|a, b| b.total_cmp(a));
    rank.checked_sub(1).and_then(|position| responses.get(position)).copied().unwrap_or(0.0)
}

/// Returns a response rounded to a whole number of steps, at least one: the threshold `T` of a scale.
pub fn round_threshold(response: f64, step: f64) -> f64 {
    step * (response / step).round().max(1.0)
}

/// How a feature differs between two levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Fate {
    /// At the same pixel in both.
    Kept,
    /// One pixel away, along a row, a column or both.
    Moved,
    /// In the reference only.
    Lost,
    /// In the test only.
    New,
}

/// The features of one scale at two levels, compared.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Kept {
    /// Features of the reference.
    pub reference: usize,
    /// Features of the test.
    pub test: usize,
    /// At the same pixel in both.
    pub same: usize,
    /// Within one pixel, those at the same pixel among them.
    pub near: usize,
    /// The smaller of recall and precision at the same pixel, percent.
    pub same_pixel_percent: f64,
    /// The smaller of recall and precision within one pixel, percent.
    pub within_one_px_percent: f64,
    /// The fate of each feature: those of the reference first, then the new ones.
    #[serde(skip)]
    pub fates: Vec<(u32, u32, Fate)>,
}

impl Kept {
    /// Compares the features of `scale`. Maxima of one plane are at least four pixels apart, so at most one feature of
    /// the test is within one pixel of a feature of the reference, and vice versa.
    pub fn between(reference: &[Feature], test: &[Feature], scale: u8) -> Self {
        let positions = |features: &[Feature]| -> BTreeSet<(u32, u32)> {
            features.iter().filter(|f| f.scale == scale).map(|f| (f.x, f.y)).collect()
        };
        let (before, after) = (positions(reference), positions(test));
        let neighbour = |&(x, y): &(u32, u32), others: &BTreeSet<(u32, u32)>| {
            let around = (x.saturating_sub(1)..=x + 1).flat_map(|i| (y.saturating_sub(1)..=y + 1).map(move |j| (i, j)));
            around.into_iter().any(|position| others.contains(&position))
        };
        let fate = |position: &(u32, u32)| match (after.contains(position), neighbour(position, &after)) {
            (true, _) => Fate::Kept,
            (false, true) => Fate::Moved,
            (false, false) => Fate::Lost,
        };
        let mut fates: Vec<(u32, u32, Fate)> =
            before.iter().map(|position| (position.0, position.1, fate(position))).collect();
        let count = |wanted: Fate| fates.iter().filter(|(_, _, fate)| *fate == wanted).count();
        let same = count(Fate::Kept);
        let near = same + count(Fate::Moved);
        fates.extend(
            after
                .iter()
                .filter(|position| !neighbour(position, &before))
                .map(|position| (position.0, position.1, Fate::New)),
        );
        let percent = |common: usize| 100.0 * common as f64 / before.len().max(after.len()).max(1) as f64;
        Self {
            reference: before.len(),
            test: after.len(),
            same,
            near,
            same_pixel_percent: percent(same),
            within_one_px_percent: percent(near),
            fates,
        }
    }
}

/// The kind of a descriptor bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BitKind {
    /// `DOG_k(p) >= MaxDOG_k(o_i)`.
    Maxlbp,
    /// `d_k(o_i) >= 0`.
    Sign,
}

/// Bits and flips whose margin in the reference is within one octave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct MarginBin {
    /// Bits with a margin in this bin.
    pub bits: u64,
    /// Bits that differ.
    pub flipped: u64,
}

/// Descriptor bits that differ between two levels at the reference's features.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Flips {
    /// Features of all scales.
    pub features: u64,
    /// Flips of each bit: the MaxLBP bits of all scale pairs, then their sign bits.
    pub per_bit: Vec<u64>,
    /// MaxLBP bits by margin: bin 0 below half an LSB, bin `j` from `2^(j-2)` to `2^(j-1)` LSB, the last one open.
    pub maxlbp_margin: Vec<MarginBin>,
    /// Sign bits by margin, likewise.
    pub sign_margin: Vec<MarginBin>,
}

impl Flips {
    /// Number of margin bins.
    pub const MARGIN_BINS: usize = 16;

    /// Makes empty counts for descriptors of `pairs` scale pairs.
    pub fn of_pairs(pairs: usize) -> Self {
        let bins = vec![MarginBin::default(); Self::MARGIN_BINS];
        Self { features: 0, per_bit: vec![0; 2 * pairs * RING_POINTS], maxlbp_margin: bins.clone(), sign_margin: bins }
    }

    /// Compares the descriptors that both levels give at the pixels of the reference's `features`; `lsb` is the step of
    /// the test's DoG in the unit of the reference.
    pub fn between<T: Copy + PartialOrd>(
        reference: &[Layer<f64>],
        test: &[Layer<T>],
        features: &[Feature],
        lsb: f64,
    ) -> Self {
        let mut flips = Self::of_pairs(reference.len());
        for feature in features {
            let (x, y) = (feature.x as usize, feature.y as usize);
            flips.count(&feature.descriptor, &descriptor(test, x, y), &margins(reference, x, y, lsb));
        }
        flips
    }

    /// Counts one feature: its descriptor at both levels, and the margins of the reference's bits in LSB.
    pub fn count(&mut self, reference: &Descriptor, test: &Descriptor, margins: &[f64]) {
        self.features += 1;
        let pairs = self.per_bit.len() / (2 * RING_POINTS);
        for (bit, margin) in margins.iter().enumerate() {
            let (word, point) = (bit / RING_POINTS, bit % RING_POINTS);
            let (bins, differs) = match word.checked_sub(pairs) {
                None => (&mut self.maxlbp_margin, reference.maxlbp[word] ^ test.maxlbp[word]),
                Some(k) => (&mut self.sign_margin, reference.sign[k] ^ test.sign[k]),
            };
            let flipped = u64::from(differs >> point & 1);
            self.per_bit[bit] += flipped;
            let octave = if *margin < 0.5 { 0 } else { (margin.log2().floor() + 2.0) as usize };
            let bin = &mut bins[octave.min(Self::MARGIN_BINS - 1)];
            bin.bits += 1;
            bin.flipped += flipped;
        }
    }

    /// Adds the counts of another picture.
    pub fn add(&mut self, other: &Self) {
        self.features += other.features;
        self.per_bit.iter_mut().zip(&other.per_bit).for_each(|(sum, count)| *sum += count);
        let pairs = [(&mut self.maxlbp_margin, &other.maxlbp_margin), (&mut self.sign_margin, &other.sign_margin)];
        for (sums, counts) in pairs {
            for (sum, count) in sums.iter_mut().zip(counts) {
                sum.bits += count.bits;
                sum.flipped += count.flipped;
            }
        }
    }

    /// Returns the share of flipped bits of one kind over all scales, percent.
    pub fn percent(&self, kind: BitKind) -> f64 {
        let (maxlbp, sign) = self.per_bit.split_at(self.per_bit.len() / 2);
        let of_kind = if kind == BitKind::Sign { sign } else { maxlbp };
        let flipped: u64 = of_kind.iter().sum();
        100.0 * flipped as f64 / (self.features * of_kind.len() as u64).max(1) as f64
    }
}

/// Computes the margin of each bit at `(x, y)`, LSB, in the order of [`Flips::per_bit`].
fn margins(layers: &[Layer<f64>], x: usize, y: usize, lsb: f64) -> Vec<f64> {
    let mut margins = vec![0.0; 2 * layers.len() * RING_POINTS];
    for (k, layer) in layers.iter().enumerate() {
        let centre = layer.dog.magnitude[(x, y)];
        for (i, &(dx, dy)) in layer.ring.0.iter().enumerate() {
            let at = (x.wrapping_add_signed(dx as isize), y.wrapping_add_signed(dy as isize));
            margins[k * RING_POINTS + i] = (centre - layer.max_dog[at]).abs() / lsb;
            margins[(k + layers.len()) * RING_POINTS + i] = layer.dog.magnitude[at] / lsb;
        }
    }
    margins
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::features::dog::Dog;
    use hoverlock_reference::features::maxlbp::Ring;

    fn feature(x: u32, y: u32, scale: u8, response: f64) -> Feature {
        let descriptor = Descriptor::default();
        Feature { x, y, scale, bright: true, response, neighbours: [0.0; 4], descriptor }
    }

    #[test]
    fn error_of_a_hand_made_plane() {
        // Reference 3 everywhere, LSB 0.5. Errors in LSB: 2 at (1, 0), -4 at (2, 1), 0 at the four others.
        let reference = Plane::filled(3, 2, 3.0);
        let mut test = reference.clone();
        test[(1, 0)] = 4.0;
        test[(2, 1)] = 1.0;
        let error = ErrorStatistics::between(&reference, &test, 0.5, Region::WHOLE).unwrap();
        assert_eq!((error.samples, error.max, error.max_at), (6, -4.0, (2, 1)));
        assert!((error.bias + 2.0 / 6.0).abs() < 1e-12);
        assert!((error.rms - (20.0f64 / 6.0).sqrt()).abs() < 1e-12);
        // 20 log10(6 / sqrt(20/6)) = 10 log10(36 * 6 / 20) = 10.334.
        assert!((error.sqnr_db - 10.334).abs() < 1e-3, "{}", error.sqnr_db);
        assert_eq!(error.histogram.counts[8..=14], [1, 0, 0, 0, 4, 0, 1]);
        let region = Region { left: 0, top: 0, right: 1, bottom: 0 };
        let inside = ErrorStatistics::between(&reference, &test, 0.5, region).unwrap();
        assert_eq!((inside.samples, inside.max, inside.max_at), (4, 2.0, (1, 0)));
        assert_eq!(ErrorStatistics::between(&reference, &test, 0.5, Region { right: 3, ..region }), None);
        assert_eq!(ErrorStatistics::between(&reference, &test, 0.5, Region { bottom: 9, ..region }), None);
        let none = ErrorStatistics::between(&reference, &reference, 0.5, Region::WHOLE).unwrap();
        assert_eq!((none.max, none.sqnr_db), (0.0, f64::INFINITY));
    }

    #[test]
    fn histogram_bins_widen_until_the_largest_error_fits() {
        // 12 + 1/2 bins of width 8 reach 100: an error of 100 LSB needs 8, one of 101 needs 16.
        for (error, bin) in [(0.0, 1.0), (12.4, 1.0), (12.6, 2.0), (100.0, 8.0), (101.0, 16.0)] {
            let test = Plane::from_fn(2, 1, |x, _| if x == 0 { error } else { 0.0 });
            let error = ErrorStatistics::between(&Plane::filled(2, 1, 0.0), &test, 1.0, Region::WHOLE).unwrap();
            assert_eq!(error.histogram.bin_lsb, bin);
            assert_eq!(error.histogram.counts.iter().sum::<u64>(), 2);
        }
    }

    #[test]
    fn nan_is_the_largest_error() {
        let test = Plane::from_vec(3, 1, vec![1.0, f64::NAN, 0.0]).unwrap();
        let error = ErrorStatistics::between(&Plane::filled(3, 1, 0.0), &test, 1.0, Region::WHOLE).unwrap();
        assert!(error.max.is_nan() && error.rms.is_nan());
    }

    #[test]
    fn threshold_is_the_response_of_the_rank() {
        let responses: Vec<f64> = (1..=10).map(|i| f64::from(i) + 0.3).collect();
        // Third strongest is 8.3, in halves 8.5; the eleventh is missing, so one step.
        assert_eq!(round_threshold(response_of_rank(responses.clone(), 3), 0.5), 8.5);
        assert_eq!(round_threshold(response_of_rank(responses, 11), 0.5), 0.5);
        assert_eq!(round_threshold(response_of_rank(Vec::new(), 3), 4.0), 4.0);
    }

    #[test]
    fn kept_moved_lost_and_new() {
        let reference = [(10, 10), (20, 20), (30, 30), (40, 40)].map(|(x, y)| feature(x, y, 0, 1.0));
        let test = [(10, 10), (21, 19), (32, 30), (50, 50), (60, 60)].map(|(x, y)| feature(x, y, 0, 1.0));
        let kept = Kept::between(&reference, &test, 0);
        assert_eq!((kept.reference, kept.test, kept.same, kept.near), (4, 5, 1, 2));
        // The smaller of recall 1/4 and precision 1/5.
        assert_eq!((kept.same_pixel_percent, kept.within_one_px_percent), (20.0, 40.0));
        let count = |wanted| kept.fates.iter().filter(|(_, _, fate)| *fate == wanted).count();
        assert_eq!([Fate::Kept, Fate::Moved, Fate::Lost, Fate::New].map(count), [1, 1, 2, 3]);
        assert_eq!(Kept::between(&reference, &test, 1).reference, 0);
        assert_eq!(Kept::between(&reference, &test, 1).same_pixel_percent, 0.0);
    }

    #[test]
    fn flips_are_counted_per_bit_and_by_margin() {
        let mut margins = [100.0; 128];
        margins[3] = 0.2;
        margins[32 + 31] = 0.5;
        margins[96] = 1.5;
        let reference = Descriptor::of_two([0b1000, 1 << 31], [0, 0]);
        let test = Descriptor::of_two([0, 0], [0, 1]);
        let mut flips = Flips::of_pairs(2);
        flips.count(&reference, &test, &margins);
        assert_eq!((flips.per_bit[3], flips.per_bit[63], flips.per_bit[96]), (1, 1, 1));
        assert_eq!(flips.per_bit.iter().sum::<u64>(), 3);
        assert_eq!(flips.maxlbp_margin[0], MarginBin { bits: 1, flipped: 1 });
        assert_eq!(flips.maxlbp_margin[1], MarginBin { bits: 1, flipped: 1 });
        assert_eq!(flips.sign_margin[2], MarginBin { bits: 1, flipped: 1 });
        // 100 LSB lies between 2^6 and 2^7: bin 8.
        assert_eq!(flips.maxlbp_margin[8], MarginBin { bits: 62, flipped: 0 });
        assert_eq!(flips.percent(BitKind::Maxlbp), 200.0 / 64.0);
        assert_eq!(flips.percent(BitKind::Sign), 100.0 / 64.0);
        let mut twice = flips.clone();
        twice.add(&flips);
        assert_eq!((twice.features, twice.per_bit[3], twice.sign_margin[2].bits), (2, 2, 2));
        assert_eq!(twice.percent(BitKind::Maxlbp), 200.0 / 64.0);
    }

    #[test]
    fn moving_a_sample_by_more_than_its_margin_flips_the_bit() {
        // A rough surface; each bit is flipped by moving one sample by its margin and a little more, and not by a
        // little less.
        let narrow = |k: usize| Plane::from_fn(41, 41, |x, y| ((x * 7919 + y * 104_729 + k * 31) % 1009) as f64);
        let wide = Plane::filled(41, 41, 500.25);
        let rings = Ring::defaults();
        let layers = [0, 1, 2].map(|k| Layer::new(Dog::between(&narrow(k), &wide), rings[k]));
        let margins = margins(&layers, 20, 20, 0.5);
        let words = |of: Descriptor| [of.maxlbp, of.sign].concat();
        let before = words(descriptor(&layers, 20, 20));
        for (bit, margin) in margins.iter().enumerate() {
            let (word, point) = (bit / RING_POINTS, bit % RING_POINTS);
            let k = word % 3;
            let (dx, dy) = rings[k].0[point];
            let at = (20usize.wrapping_add_signed(dx as isize), 20usize.wrapping_add_signed(dy as isize));
            let flips_after = |step: f64| {
                let mut moved = layers.clone();
                if word < 3 {
                    let up = before[word] >> point & 1 == 0;
                    moved[k].dog.magnitude[(20, 20)] += if up { step } else { -step };
                } else {
                    let signed = moved[k].dog.signed();
                    let d = signed[at] - step * signed[at].signum();
                    moved[k].dog.positive[at] = d >= 0.0;
                }
                words(descriptor(&moved, 20, 20))[word] >> point & 1 != before[word] >> point & 1
            };
            assert!(flips_after(0.5 * margin + 0.01) && !flips_after(0.5 * margin - 0.01), "bit {bit}");
        }
    }
}
