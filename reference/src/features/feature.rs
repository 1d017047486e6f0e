//! A feature, the output of the extractor: position, response and binary descriptor.

/// Number of ring points, one for each bit of a descriptor word: `n` in `o_i = R (cos(2 pi i / n), sin(2 pi i / n))`,
/// `i = 0 .. n - 1`.
pub const RING_POINTS: usize = 32;

/// Largest number of scale pairs of a chain of smoothers; the default chain has two.
pub const MAX_PAIRS: usize = 3;

/// The descriptor of a feature, 64 bits for each scale pair; bit `i` of each word is ring point `i`. The words of pairs
/// that the chain does not have are 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Descriptor {
    /// `MaxLBP_k`: bit `i` is `DOG_k(p) >= MaxDOG_k(o_i)`, one word per scale pair.
    pub maxlbp: [u32; MAX_PAIRS],
    /// Bit `i` is 1 if the signed DoG at `o_i` is not negative, one word per scale pair.
    pub sign: [u32; MAX_PAIRS],
}

impl Descriptor {
    /// Counts the bits that differ, at most 64 for each scale pair. With `strict` only the MaxLBP words count, 32 bits
    /// for each pair.
    pub fn hamming(&self, other: &Self, strict: bool) -> u32 {
        let differ = |a: &[u32; MAX_PAIRS], b: &[u32; MAX_PAIRS]| -> u32 {
            a.iter().zip(b).map(|(a, b)| (a ^ b).count_ones()).sum()
        };
        differ(&self.maxlbp, &other.maxlbp) + if strict { 0 } else { differ(&self.sign, &other.sign) }
    }

    /// Returns the descriptor of a chain of two scale pairs.
    pub fn of_two(maxlbp: [u32; 2], sign: [u32; 2]) -> Self {
        Self { maxlbp: [maxlbp[0], maxlbp[1], 0], sign: [sign[0], sign[1], 0] }
    }

    /// Returns the words in the order of the feature record: MaxLBP k0, MaxLBP k1, sign k0, sign k1, MaxLBP k2, sign
    /// k2.
    pub fn words(&self) -> [u32; 2 * MAX_PAIRS] {
        let [maxlbp, sign] = [self.maxlbp, self.sign];
        [maxlbp[0], maxlbp[1], sign[0], sign[1], maxlbp[2], sign[2]]
    }
}

/// A feature point: a maximum of `DOG_k` with its neighbours and descriptor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feature {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Scale pair `k`, 0 the finest.
    pub scale: u8,
    /// Polarity: the signed DoG (narrow minus wide) at the pixel is not negative, that is a bright spot.
    pub bright: bool,
    /// `DOG_k` at the pixel, DN of the 16-bit camera sample (0.5 DN is one LSB of the fixed-point DoG).
    pub response: f64,
    /// `DOG_k` at the left, right, upper and lower neighbour, for the parabola.
    pub neighbours: [f64; 4],
    /// The descriptor at the pixel.
    pub descriptor: Descriptor,
}

impl Feature {
    /// Returns the position `(x, y)` to a fraction of a pixel: the vertex of the parabola through three responses along
    /// each axis, `dx = (l - r) / (2 (l - 2 c + r))`. It is within half a pixel, because the centre is a maximum.
    pub fn subpixel(&self) -> (f64, f64) {
        let vertex = |before: f64, after: f64| {
            let curvature = before - 2.0 * self.response + after;
            if curvature < 0.0 { ((before - after) / (2.0 * curvature)).clamp(-0.5, 0.5) } else { 0.0 }
        };
        let [left, right, up, down] = self.neighbours;
        (f64::from(self.x) + vertex(left, right), f64::from(self.y) + vertex(up, down))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabola_finds_its_own_vertex() {
        // f(t) = 10 - 3 (t - 0.2)^2 along x, 10' - 2 (t + 0.4)^2 along y, sampled at -1, 0, 1 around the pixel.
        let along_x = |t: f64| 10.0 - 3.0 * (t - 0.2).powi(2);
        let along_y = |t: f64| along_x(0.0) + 2.0 * 0.16 - 2.0 * (t + 0.4).powi(2);
        let feature = Feature {
            x: 7,
            y: 9,
            scale: 0,
            bright: true,
            response: along_x(0.0),
            neighbours: [along_x(-1.0), along_x(1.0), along_y(-1.0), along_y(1.0)],
            descriptor: Descriptor::default(),
        };
        let (x, y) = feature.subpixel();
        assert!((x - 7.2).abs() < 1e-12 && (y - 8.6).abs() < 1e-12, "{x} {y}");
    }

    #[test]
    fn hamming_counts_each_word_once() {
        let a = Descriptor { maxlbp: [0b1011, 0, 1], sign: [0, 1 << 31, 0] };
        let b = Descriptor { maxlbp: [0b0001, 1, 0], sign: [7, 0, 3] };
        assert_eq!(a.hamming(&b, true), 4);
        assert_eq!(a.hamming(&b, false), 10);
    }
}
