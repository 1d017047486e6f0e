use super::*;
use nalgebra::Matrix3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const CENTRE: Vector2<f64> = Vector2::new(511.5, 383.5);

/// A view that turns, grows and tilts.
fn truth(model: Model) -> Matrix3<f64> {
    match model {
        Model::Shift => Matrix3::new(1.0, 0.0, 40.0, 0.0, 1.0, -25.0, 0.0, 0.0, 1.0),
        Model::Similarity => Matrix3::new(1.04, -0.08, 40.0, 0.08, 1.04, -25.0, 0.0, 0.0, 1.0),
        Model::Affine => Matrix3::new(1.04, -0.08, 40.0, 0.05, 0.97, -25.0, 0.0, 0.0, 1.0),
        Model::Homography => Matrix3::new(1.04, -0.08, 40.0, 0.05, 0.97, -25.0, 3e-5, -6e-5, 1.0),
    }
}

/// Fits the model to one pair in each of the cells of the region of 1024 x 768 px that ends at `right`, px, with an
/// error of 0.5 px in each axis.
fn fitted(model: Model, right: f64, rng: &mut ChaCha8Rng) -> Estimate {
    let mut noise = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let mut pairs = Vec::new();
    for cell in 0..16 * 12 {
        let reference = MAX_CELL_PX * Vector2::new(f64::from(cell % 16) + 0.5, f64::from(cell / 16) + 0.5);
        if reference.x < right {
            let current = transfer(&truth(model), reference).unwrap() + 0.5 * Vector2::new(noise(), noise());
            pairs.push(Pair { reference, current });
        }
    }
    let inliers = (0..pairs.len()).collect();
    Estimate {
        homography: model.fit(&pairs).unwrap(),
        model,
        matches: Vec::new(),
        pairs,
        inliers,
        rms: 0.7,
        quality: 200,
    }
}

/// The error over the standard error has a mean square of one, at the centre of the pairs and far outside them.
#[test]
fn the_standard_error_is_that_of_fits_to_noise() {
    for model in [Model::Shift, Model::Similarity, Model::Affine, Model::Homography] {
        for right in [1024.0, 200.0] {
            let mut rng = ChaCha8Rng::seed_from_u64(11);
            let expected = transfer(&truth(model), CENTRE).unwrap();
            let ratio = |found: Estimate| {
                let miss = transfer(&found.homography, CENTRE).unwrap() - expected;
                (miss.norm() / found.standard_error(&found, CENTRE)).powi(2)
            };
            let mean = (0..400).map(|_| ratio(fitted(model, right, &mut rng))).sum::<f64>() / 400.0;
            assert!((0.8..1.25).contains(&mean), "{model:?} {right}: {mean}");
        }
    }
}

#[test]
fn pairs_along_a_border_say_little_of_the_centre() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (whole, border) = (fitted(Model::Homography, 1024.0, &mut rng), fitted(Model::Homography, 140.0, &mut rng));
    assert!(whole.standard_error(&whole, CENTRE) < 0.2, "{}", whole.standard_error(&whole, CENTRE));
    assert_eq!(whole.quality_within(whole.standard_error(&whole, CENTRE)), 200);
    let sigma = border.standard_error(&border, CENTRE);
    assert!(sigma > 2.0, "{sigma}");
    assert_eq!(border.quality_within(sigma), (200.0 / sigma) as u8);
}

/// Wrong matches at the other border, among others that do not agree: the fit passes through them.
#[test]
fn a_pair_among_matches_that_disagree_does_not_count() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut found = fitted(Model::Homography, 140.0, &mut rng);
    let before = found.standard_error(&found, CENTRE);
    let good = found.pairs.len();
    for i in 0..8 {
        let reference = Vector2::new(900.0 + 10.0 * f64::from(i), 100.0 + 500.0 * f64::from(i % 2));
        let current = transfer(&truth(Model::Homography), reference).unwrap() + Vector2::new(15.0, 0.0);
        found.pairs.push(Pair { reference, current });
    }
    found.inliers.extend([good, good + 1]);
    let pairs: Vec<Pair> = found.inliers.iter().map(|&i| found.pairs[i]).collect();
    found.homography = Model::Homography.fit(&pairs).unwrap();
    let miss = transfer(&found.homography, CENTRE).unwrap() - transfer(&truth(Model::Homography), CENTRE).unwrap();
    let alone = Estimate { pairs, inliers: (0..good + 2).collect(), ..found.clone() };
    assert!(miss.norm() > 5.0 && alone.standard_error(&alone, CENTRE) < 1.0, "{}", miss.norm());
    let sigma = found.standard_error(&found, CENTRE);
    assert!(sigma > 0.8 * before && miss.norm() < 5.0 * sigma, "{before} {sigma} {}", miss.norm());
}

/// Two pictures of different ground with one marker in each, and a wrong match that the fit passes through.
#[test]
fn a_single_marker_determines_no_motion() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut found = fitted(Model::Homography, 1024.0, &mut rng);
    let wrong = found.pairs.len();
    found.pairs.iter_mut().for_each(|pair| pair.current.x += 40.0);
    for i in 0..10 {
        let reference = Vector2::new(806.0 + 7.0 * f64::from(i % 4), 631.0 + 9.0 * f64::from(i / 4));
        let current =
            transfer(&truth(Model::Homography), reference).unwrap() + Vector2::new(rng.random(), rng.random());
        found.pairs.push(Pair { reference, current });
    }
    found.inliers = (wrong..wrong + 10).chain([20]).collect();
    let pairs: Vec<Pair> = found.inliers.iter().map(|&i| found.pairs[i]).collect();
    found.homography = Model::Homography.fit(&pairs).unwrap();
    assert_eq!(found.standard_error(&found, CENTRE), f64::INFINITY);
}

#[test]
fn neighbours_count_once() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let found = fitted(Model::Homography, 1024.0, &mut rng);
    let mut twice = found.clone();
    twice.pairs.extend(found.pairs.clone());
    twice.inliers = (0..twice.pairs.len()).collect();
    assert!((found.standard_error(&found, CENTRE) - twice.standard_error(&twice, CENTRE)).abs() < 1e-9);
}

#[test]
fn what_is_not_determined_has_no_quality() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut line = fitted(Model::Homography, 1024.0, &mut rng);
    line.inliers.retain(|&i| line.pairs[i].reference.y < MAX_CELL_PX);
    assert!(line.standard_error(&line, CENTRE) > 1e3, "{}", line.standard_error(&line, CENTRE));
    assert_eq!(line.quality_within(line.standard_error(&line, CENTRE)), 0);
    line.inliers.clear();
    assert_eq!(line.standard_error(&line, CENTRE), f64::INFINITY);
    let behind = Vector2::new(1e6, 0.0);
    let mut tilted = fitted(Model::Homography, 1024.0, &mut rng);
    tilted.homography[(2, 0)] = -1e-4;
    assert_eq!(tilted.standard_error(&tilted, behind), f64::INFINITY);
}
