//! A design in the types of [`hoverlock_reference`]: its camera samples and its rings.

use hoverlock_design::{DesignPoint, MAX_RING_RADIUS, MAX_SCALE_PAIRS, SmootherKind};
use hoverlock_reference::features::feature::MAX_PAIRS;
use hoverlock_reference::features::maxlbp::{self, Ring};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_reference::smoothing::recursive::{Family, Recursive, first_order};

use super::coefficients::{look_ahead_error, look_ahead_for};

/// The largest part of a filter's sum that its look-ahead may omit without a remark. Those of the shipped designs omit
/// at most 0.3 % (`small`, which trades them for memory).
const MAX_OMITTED: f64 = 1e-2;

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

/// Designs the recursive filter of the design's family for `sigma` px, with the family's usual fit.
///
/// # Errors
/// The family has no filter of this sigma.
pub fn recursive(design: &DesignPoint, sigma: f64) -> Result<Recursive, DesignError> {
    let family = match design.smoother {
        SmootherKind::FirstOrder => Family::FirstOrder,
        SmootherKind::Deriche => Family::Deriche { order: 4 },
        SmootherKind::Yvv95 => Family::YoungVanVliet,
        SmootherKind::Vyv => Family::VanVlietYoungVerbeek { order: 3 },
    };
    Recursive::design(family, family.fits()[0], sigma)
}

/// Returns a remark about what a smoother other than that of the hardware does not change; `None` without one.
pub fn other_smoother(design: &DesignPoint) -> Option<String> {
    let SmootherKind::FirstOrder = design.smoother else {
        return Some(format!(
            "smoother = {}: the levels recursive and quantised have it; streaming, bit_true and the hardware stay \
             first-order",
            design.smoother
        ));
    };
    None
}

/// Returns a remark for each smoother whose sigma is too large for its look-ahead: its name by sigma, the part of the
/// sum that is omitted, and the look-ahead that would omit at most 1 %.
pub fn short_look_aheads(design: &DesignPoint) -> Vec<String> {
    let smoothers = design.sigmas.iter().zip(&design.look_ahead);
    let remark = |(sigma, stages): (&f64, &u32)| {
        let a = first_order::pole(*sigma).ok()?;
        let omitted = look_ahead_error(a, *stages);
        (omitted > MAX_OMITTED).then(|| {
            let reach = (1u64 << stages) - 1;
            let enough = match look_ahead_for(a, MAX_OMITTED) {
                Ok(enough) => format!("a look-ahead of {enough} reaches far enough"),
                Err(_) => "no look-ahead reaches far enough".into(),
            };
            let percent = 100.0 * omitted;
            format!(
                "sigma {sigma} px is large for a look-ahead of {stages}: {percent:.1} % of the filter's sum lies \
                 beyond its {reach} px; {enough}"
            )
        })
    };
    smoothers.filter_map(remark).collect()
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

    #[test]
    fn a_sigma_that_outgrows_its_look_ahead_is_remarked() {
        for (name, _) in hoverlock_design::SHIPPED {
            let design = DesignPoint::shipped(name).unwrap();
            assert_eq!(short_look_aheads(&design), Vec::<String>::new(), "{name}");
        }
        let large = KT27.with_override("sigmas=[2.0, 3.2, 60.0]").unwrap();
        let remarks = short_look_aheads(&large);
        assert_eq!(remarks.len(), 1);
        let remark = &remarks[0];
        assert!(remark.starts_with("sigma 60 px is large for a look-ahead of 6: 34.6 %"), "{remark}");
        assert!(remark.ends_with("a look-ahead of 9 reaches far enough"), "{remark}");
    }
}
