//! A feature as the inner loop of the matching sees it.

use crate::features::feature::Feature;
use nalgebra::Vector2;

/// The words of a descriptor that are compared; the others are 0.
#[derive(Clone, Copy)]
pub(super) struct Words {
    /// Words of the first two scale pairs.
    pub(super) bytes: [u8; BYTES],
    /// Words of the third scale pair, 0 if the chain has two.
    pub(super) third: [u8; BYTES / 2],
}

impl Words {
    /// Counts the bits that differ.
    pub(super) fn hamming(&self, other: &Self) -> u32 {
        fn differ(a: &[u8], b: &[u8]) -> u32 {
            let words = a.as_chunks().0.iter().zip(b.as_chunks().0);
            words.map(|(a, b)| (u32::from_le_bytes(*a) ^ u32::from_le_bytes(*b)).count_ones()).sum()
        }
        differ(&self.bytes, &other.bytes) + differ(&self.third, &other.third)
    }
}

/// Bytes of the descriptor of two scale pairs.
pub(super) const BYTES: usize = 16;

/// The properties of a feature that the inner loop needs.
pub(super) struct Candidate {
    pub(super) index: usize,
    pub(super) words: Words,
    pub(super) response: f64,
    pub(super) row: u32,
    pub(super) position: Vector2<f64>,
}

impl Candidate {
    pub(super) fn of(index: usize, feature: &Feature, strict: bool) -> Self {
        let mut descriptor = feature.descriptor;
        if strict {
            descriptor.sign = Default::default();
        }
        let mut all = descriptor.words().into_iter().flat_map(u32::to_le_bytes);
        let mut next = || all.next().unwrap_or_default();
        let (bytes, third) = (std::array::from_fn(|_| next()), std::array::from_fn(|_| next()));
        let (x, y) = feature.subpixel();
        Self {
            index,
            words: Words { bytes, third },
            response: feature.response,
            row: feature.y,
            position: Vector2::new(x, y),
        }
    }
}
