//! `LBP(p) = sum_i s(I(p + o_i) - I(p)) 2^i`, `s(t) = 1` where `t >= 0`: local binary patterns on intensities, the
//! baseline that MaxLBP is compared with.
//!
//! The rings are those of MaxLBP (32 points, radius 12 and 16 px), so that the comparison is of the rule and not of the
//! positions: 64 bits, in the words `maxlbp` of a descriptor; the sign words stay 0, so the strict distance and the
//! full one are the same. Source: T. Ojala, M. Pietikainen, T. Maenpaa, "Multiresolution gray-scale and rotation
//! invariant texture classification with local binary patterns", 2002, eq. (4).

use std::sync::LazyLock;

use hoverlock_reference::features::feature::{Descriptor, MAX_PAIRS};
use hoverlock_reference::features::maxlbp::Ring;
use hoverlock_reference::image::plane::Plane;

/// The rings, computed once: their sines take longer than the comparisons of a point.
static RINGS: LazyLock<[Ring; MAX_PAIRS]> = LazyLock::new(Ring::defaults);

/// Computes the plain LBP of both rings at a pixel.
///
/// # Panics
/// If a ring point is outside the frame.
pub fn descriptor<T: Copy + PartialOrd>(intensity: &Plane<T>, x: usize, y: usize) -> Descriptor {
    let centre = intensity[(x, y)];
    let word = |k: usize| {
        RINGS[k].0.iter().enumerate().fold(0, |word, (i, &(dx, dy))| {
            let at = (x.wrapping_add_signed(dx as isize), y.wrapping_add_signed(dy as isize));
            word | u32::from(intensity[at] >= centre) << i
        })
    };
    Descriptor::of_two([word(0), word(1)], [0; 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_sets_the_half_ring_it_rises_to() {
        // Intensity grows to the right: points with dx >= 0 are i = 0 ..= 8 and 24 ..= 31.
        let ramp = Plane::from_fn(40, 40, |x, _| x as u16);
        assert_eq!(descriptor(&ramp, 20, 20).maxlbp, [0xFF00_01FF, 0xFF00_01FF, 0]);
        // Intensity grows downwards: dy >= 0 are i = 0 ..= 16.
        let ramp = Plane::from_fn(40, 40, |_, y| y as f64);
        assert_eq!(descriptor(&ramp, 20, 20).maxlbp, [0x0001_FFFF, 0x0001_FFFF, 0]);
    }

    #[test]
    fn gain_and_offset_leave_the_word_alone() {
        let base = Plane::from_fn(40, 40, |x, y| ((x * 37 + y * 91) % 101) as f64);
        let other = base.map(|v| 0.3 * v + 17.0);
        assert_eq!(descriptor(&base, 19, 20), descriptor(&other, 19, 20));
    }
}
