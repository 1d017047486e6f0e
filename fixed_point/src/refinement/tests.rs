use super::*;
use hoverlock_reference::image::fourier::Spectrum;
use hoverlock_reference::motion::refine::refined_pair;
use nalgebra::{Matrix3, Rotation2};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Side of the pictures, px.
const PICTURE: usize = 128;
/// Distance of neighbouring patches, px.
const SPACING: usize = 12;
/// Largest bias over the patches of a picture, px: that of the reference.
const MAX_BIAS_PX: f64 = 0.003;
/// Largest deviation of a patch from the reference, px, where the reference keeps its position.
const MAX_DEVIATION_PX: f64 = 0.004;

/// Returns a number from -0.5 to 0.5.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5
}

fn places() -> impl Iterator<Item = [usize; 2]> {
    let axis = || (24..PICTURE - 24).step_by(SPACING);
    axis().flat_map(move |y| axis().map(move |x| [x, y]))
}

/// The errors over the patches of a picture that moved by `shift`, px: of the integers, and against the reference.
fn errors(seed: u64, shift: Vector2<f64>) -> Vec<[Vector2<f64>; 2]> {
    let spectrum = Spectrum::random(PICTURE, seed);
    let [keyframe, present] = [Vector2::zeros(), shift].map(|shift| spectrum.picture(shift));
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut found = Vec::new();
    for [x, y] in places() {
        let p = Vector2::new(x as f64, y as f64);
        let miss = Vector2::from_fn(|_, _| uniform(&mut random));
        let template = Template::cut(&keyframe, x, y).expect("the patch has texture");
        let refined = template.refine(&present, p + shift + miss, &Matrix2::identity()).expect("the patch is there");
        let prediction = Matrix3::new_translation(&(shift + miss));
        let float = refined_pair(&keyframe, &present, &prediction, p).expect("the patch is there");
        found.push([refined.position - p - shift, refined.position - float.pair.current]);
    }
    found
}

fn mean(errors: &[[Vector2<f64>; 2]]) -> Vector2<f64> {
    errors.iter().map(|[error, _]| error).sum::<Vector2<f64>>() / errors.len() as f64
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_shift_is_found_as_by_the_reference(seed in any::<u64>(), x in -1.0..1.0f64, y in -1.0..1.0f64) {
        let errors = errors(seed, Vector2::new(x, y));
        let worst = errors.iter().map(|[_, deviation]| deviation.amax()).fold(0.0, f64::max);
        prop_assert!(mean(&errors).amax() < MAX_BIAS_PX, "bias {:?} px", mean(&errors));
        prop_assert!(worst < MAX_DEVIATION_PX, "{worst} px from the reference");
    }

    /// No content and no position of a patch overflows or panics.
    #[test]
    fn any_picture_and_any_start_are_refined_or_refused(
        seed in any::<u64>(), x in -20.0..70.0f64, y in -20.0..70.0f64, a in prop::array::uniform4(-2.0..2.0f64),
    ) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let two = Plane::from_fn(48, 40, |_, _| if random.next_u32() % 2 == 0 { 0 } else { u16::MAX });
        let template = Template::cut(&two, 24, 20).expect("the patch has texture");
        if let Some(refined) = template.refine(&two, Vector2::new(x, y), &Matrix2::from_row_slice(&a)) {
            prop_assert!(refined.position.iter().chain(&refined.covariance).all(|value| value.is_finite()));
        }
    }
}

/// At a quarter of a pixel the bias of an interpolation is largest.
#[test]
fn a_quarter_of_a_pixel_has_no_more_bias() {
    for quarter in [0.25, 0.75] {
        let means: Vec<_> = (0..6).map(|seed| mean(&errors(seed, Vector2::new(quarter, 0.0)))).collect();
        let mean = means.iter().sum::<Vector2<f64>>() / means.len() as f64;
        assert!(mean.amax() < MAX_BIAS_PX, "{quarter}: {mean}");
    }
}

/// A brightness of smooth waves at many scales.
fn ground(p: Vector2<f64>) -> f64 {
    let wave = |x: f64, y: f64| (p.x * x + p.y * y).sin();
    30_000.0 + 4000.0 * (wave(0.21, 0.13) + wave(-0.17, 0.29) + wave(0.05, -0.35) + wave(0.41, 0.02) + wave(0.11, 0.47))
}

fn frame(gain: f64, offset: f64, to_ground: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Plane<u16> {
    Plane::from_fn(96, 80, |x, y| (gain * ground(to_ground(Vector2::new(x as f64, y as f64))) + offset) as u16)
}

/// Turned, larger and darker: the patch is found where it is, and the covariance is that of its noise.
#[test]
fn a_patch_is_found_under_a_warp_and_another_exposure() {
    let warp = Rotation2::new(0.1).into_inner() * 1.05;
    let moved = Vector2::new(7.3, -2.6);
    let inverse = warp.try_inverse().expect("a rotation has an inverse");
    let keyframe = frame(1.0, 0.0, |p| p);
    let present = frame(0.7, 3000.0, |p| inverse * (p - moved));
    for [x, y] in [[40, 40], [48, 36], [44, 44]] {
        let truth = warp * Vector2::new(x as f64, y as f64) + moved;
        let template = Template::cut(&keyframe, x, y).expect("the patch has texture");
        let start = truth + Vector2::new(0.5, -0.4);
        let refined = template.refine(&present, start, &warp).expect("the patch is there");
        let miss = (refined.position - truth).norm();
        assert!(miss < 0.02, "({x}, {y}): {miss} px");
        assert!(refined.covariance.trace() < 1e-3 && refined.covariance.determinant() > 0.0, "{}", refined.covariance);
        assert_eq!(template.centre(), Vector2::new(x as f64, y as f64));
    }
}

#[test]
fn patches_that_cannot_be_compared_are_refused() {
    let same = Matrix2::identity();
    let keyframe = frame(1.0, 0.0, |p| p);
    let at = Vector2::new(40.0, 40.0);
    let template = Template::cut(&keyframe, 40, 40).expect("the patch has texture");
    assert!(template.refine(&keyframe, at, &same).is_some());
    // A patch that leaves either frame; one direction only; a uniform frame.
    assert!(Template::cut(&keyframe, 12, 40).is_none() && Template::cut(&keyframe, 40, 70).is_none());
    assert!(Template::cut(&Plane::from_fn(96, 80, |x, _| if x < 40 { 100 } else { 900 }), 40, 40).is_none());
    assert!(Template::cut(&Plane::filled(96, 80, 9), 40, 40).is_none());
    for start in [Vector2::new(10.0, 40.0), Vector2::new(40.0, 1e300), Vector2::new(f64::NAN, 40.0)] {
        assert_eq!(template.refine(&keyframe, start, &same), None, "{start}");
    }
    assert_eq!(template.refine(&Plane::filled(96, 80, 9), at, &same), None);
    // Too far, and other ground.
    assert_eq!(template.refine(&keyframe, at + Vector2::new(3.0, 0.0), &same), None);
    let other = Plane::from_fn(96, 80, |x, y| ((x * 7919 + y * 104_729) % 6007) as u16);
    assert_eq!(template.refine(&other, at, &same), None);
}
