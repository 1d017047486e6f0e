//! Pictures for property tests. A few numbers describe a picture, so that a failure prints and shrinks to a short text.

use hoverlock_reference::image::plane::Plane;
use proptest::prelude::*;

/// The content of a picture.
#[derive(Debug, Clone, Copy)]
pub enum Content {
    /// Independent random pixels within `low ..= high`.
    Noise { low: u16, high: u16 },
    /// Two values either side of a straight line `x dx + y dy = at`.
    Edge { dx: i32, dy: i32, at: i32, values: [u16; 2] },
    /// Full-scale pixels, one in `spacing`, on black or the other way round.
    Impulses { spacing: u32, inverse: bool },
    /// Rising along both axes, wrapping round.
    Ramp { dx: u16, dy: u16 },
    /// All pixels have this value.
    Constant(u16),
}

/// Size, seed and content of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub seed: u64,
    pub content: Content,
}

impl Picture {
    pub fn draw(&self) -> Plane<u16> {
        Plane::from_fn(self.width, self.height, |x, y| match self.content {
            Content::Noise { low, high } => low + (self.hash(x, y) % (u64::from(high - low) + 1)) as u16,
            Content::Edge { dx, dy, at, values } => values[usize::from(x as i32 * dx + y as i32 * dy > at)],
            Content::Impulses { spacing, inverse } => {
                let hit = self.hash(x, y).is_multiple_of(u64::from(spacing));
                if hit != inverse { u16::MAX } else { 0 }
            }
            Content::Ramp { dx, dy } => (x as u16).wrapping_mul(dx).wrapping_add((y as u16).wrapping_mul(dy)),
            Content::Constant(value) => value,
        })
    }

    /// Mixes position and seed to 64 bits (the finaliser of SplitMix64).
    fn hash(&self, x: usize, y: usize) -> u64 {
        let position = (x as u64) << 32 | y as u64;
        let mut z = self.seed ^ position.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
}

fn content() -> impl Strategy<Value = Content> {
    prop_oneof![
        any::<u16>().prop_map(Content::Constant),
        (any::<u16>(), any::<u16>()).prop_map(|(dx, dy)| Content::Ramp { dx, dy }),
        (1u32..2000, any::<bool>()).prop_map(|(spacing, inverse)| Content::Impulses { spacing, inverse }),
        (-3..=3i32, -3..=3i32, -100..200i32, any::<[u16; 2]>()).prop_map(|(dx, dy, at, values)| Content::Edge {
            dx,
            dy,
            at,
            values
        }),
        (any::<u16>(), any::<u16>()).prop_map(|(a, b)| Content::Noise { low: a.min(b), high: a.max(b) }),
        Just(Content::Noise { low: 0, high: u16::MAX }),
    ]
}

/// Draws any content in sizes `1 x 1`, `1 x N`, `N x 1`, narrower than the look-ahead, odd, just too small for
/// features, and up to `most` columns and rows.
pub fn pictures(most: usize) -> impl Strategy<Value = Picture> {
    let side = || prop_oneof![1 => Just(1), 2 => 2..40usize.min(most), 4 => 30.min(most - 1)..=most];
    (side(), side(), any::<u64>(), content()).prop_map(|(width, height, seed, content)| Picture {
        width,
        height,
        seed,
        content,
    })
}
