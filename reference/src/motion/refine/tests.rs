use super::*;
use crate::motion::matching::Match;
use crate::motion::model::Model;

/// Returns the brightness of an unbounded ground: smooth waves at many scales.
fn ground(p: Vector2<f64>) -> f64 {
    let wave = |x: f64, y: f64| (p.x * x + p.y * y).sin();
    30_000.0 + 4000.0 * (wave(0.21, 0.13) + wave(-0.17, 0.29) + wave(0.05, -0.35) + wave(0.41, 0.02) + wave(0.11, 0.47))
}

fn frame(to_ground: &Matrix3<f64>, gain: f64, offset: f64) -> Plane<u16> {
    Plane::from_fn(200, 150, |x, y| {
        let p = transfer(to_ground, Vector2::new(x as f64, y as f64)).unwrap();
        (gain * ground(p) + offset) as u16
    })
}

/// 3 degrees, 3 % larger, a little oblique.
fn motion() -> Matrix3<f64> {
    Matrix3::new(1.03, -0.054, 5.3, 0.054, 1.03, -4.7, 2e-5, -1e-5, 1.0)
}

fn frames() -> (Plane<u16>, Plane<u16>) {
    (frame(&Matrix3::identity(), 1.0, 0.0), frame(&motion().try_inverse().unwrap(), 0.7, 3000.0))
}

/// Returns a pair whose position in CUR is off by `miss`, px.
fn pair(x: f64, y: f64, miss: Vector2<f64>) -> Pair {
    let reference = Vector2::new(x, y);
    Pair { reference, current: transfer(&motion(), reference).unwrap() + miss }
}

#[test]
fn a_match_half_a_pixel_off_is_corrected_under_another_gain() {
    let (reference, current) = frames();
    let mut refined = 0;
    for (x, y) in [(60.3, 70.4), (99.6, 40.2), (120.0, 90.0), (80.5, 100.4)] {
        let position = Vector2::new(x, y);
        let prediction = Matrix3::new_translation(&Vector2::new(0.6, -0.4)) * motion();
        let Some(after) = refined_pair(&reference, &current, &prediction, position) else { continue };
        let miss = (after.pair.current - transfer(&motion(), after.pair.reference).unwrap()).norm();
        assert!(miss < 0.03 && after.ncc > 0.99, "({x}, {y}): {miss} px, NCC {}", after.ncc);
        assert!((after.pair.reference - position).abs().max() <= 0.5);
        refined += 1;
    }
    assert_eq!(refined, 4);
}

#[test]
fn pairs_that_cannot_be_compared_are_dropped() {
    let (reference, current) = frames();
    let none = |reference: &Plane<u16>, current: &Plane<u16>, h: &Matrix3<f64>, (x, y)| {
        let refined = refined_pair(reference, current, h, Vector2::new(x, y));
        assert_eq!(refined, None, "({x}, {y})");
    };
    let moved = |x, y| Matrix3::new_translation(&Vector2::new(x, y)) * motion();
    assert!(refined_pair(&reference, &current, &motion(), Vector2::new(60.0, 70.0)).is_some());
    // Patches that leave either frame; a motion too far off; a uniform frame; a single edge.
    none(&reference, &current, &motion(), (5.0, 70.0));
    none(&reference, &current, &motion(), (196.0, 70.0));
    none(&reference, &current, &moved(-57.0, 0.0), (60.0, 70.0));
    none(&reference, &current, &moved(3.0, 0.0), (60.0, 70.0));
    none(&Plane::filled(200, 150, 9u16), &current, &motion(), (60.0, 70.0));
    none(&reference, &Plane::filled(200, 150, 9u16), &motion(), (60.0, 70.0));
    let edge = Plane::from_fn(200, 150, |x, _| if x < 60 { 100u16 } else { 900 });
    none(&edge, &edge, &Matrix3::identity(), (60.0, 70.0));
    // Ground that differs between the frames.
    let other = Plane::from_fn(200, 150, |x, y| ((x * 7919 + y * 104_729) % 6007) as u16);
    none(&reference, &other, &motion(), (60.0, 70.0));
}

fn estimate(pairs: Vec<Pair>) -> Estimate {
    let one = Match { reference: 0, current: 0, distance: 0.0, response_difference: 0.0 };
    let homography = Model::Similarity.fit(&pairs).unwrap();
    let (matches, inliers) = (vec![one; pairs.len()], (0..pairs.len()).collect());
    Estimate { homography, model: Model::Homography, matches, pairs, inliers, rms: 0.5, quality: 200 }
}

#[test]
fn the_motion_follows_the_refined_pairs() {
    let (reference, current) = frames();
    // Off by up to half a pixel, with a bias to the right.
    let miss = |i: usize| Vector2::new(0.4 + 0.1 * (i % 3) as f64, 0.2 * (i % 5) as f64 - 0.4);
    let pairs: Vec<Pair> =
        (0..48).map(|i| pair(30.0 + 18.0 * (i % 8) as f64, 30.0 + 17.0 * (i / 8) as f64, miss(i))).collect();
    let before = estimate(pairs);
    let after = refined(before.clone(), &reference, &current, 9.0);
    let centre = Vector2::new(99.5, 74.5);
    let miss = |h: &Matrix3<f64>| (transfer(h, centre).unwrap() - transfer(&motion(), centre).unwrap()).norm();
    let (was, is) = (miss(&before.homography), miss(&after.homography));
    assert!(was > 0.4 && is < 0.02, "{was} px before, {is} px after");
    assert!(after.inliers.len() >= 30 && after.rms < 0.05 && after.matches.len() == after.pairs.len());
    assert_eq!((after.quality, after.model), (200, Model::Homography));
    // Too few refined pairs leave the estimate unchanged.
    let flat = Plane::filled(200, 150, 9u16);
    assert_eq!(refined(before.clone(), &reference, &flat, 9.0), before);
}
