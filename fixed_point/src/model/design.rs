//! A design in the types of [`hoverlock_reference`]: its camera samples and its rings.

use hoverlock_design::{DesignPoint, MAX_RING_RADIUS, MAX_SCALE_PAIRS};
use hoverlock_reference::features::feature::MAX_PAIRS;
use hoverlock_reference::features::maxlbp::{self, Ring};
use hoverlock_reference::image::plane::Plane;

// The limits of a design file are those of the algorithm.
const _: () = assert!(MAX_SCALE_PAIRS as usize == MAX_PAIRS && MAX_RING_RADIUS == maxlbp::MAX_RING_RADIUS);

/// Returns a picture of 16-bit samples as the camera of `design` samples it, in steps of the camera: the upper bits of
/// each sample.
pub fn camera_samples(design: &DesignPoint, picture: &Plane<u16>) -> Plane<u16> {
    let shift = design.step_bits();
    picture.map(|sample| sample >> shift)
}

/// Returns the ring of each scale pair.
pub fn rings(design: &DesignPoint) -> Vec<Ring> {
    design.ring_radii.iter().map(|radius| Ring::of_radius(*radius)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    #[test]
    fn a_camera_of_eight_bits_keeps_the_upper_byte() {
        let picture = Plane::from_vec(2, 1, vec![0x12ff, 0xffff]).unwrap();
        let design = KT27.with_override("pixel=u8.0").unwrap();
        assert_eq!(camera_samples(&design, &picture).as_slice(), [0x12, 0xff]);
        assert_eq!(camera_samples(&KT27, &picture), picture);
    }
}
