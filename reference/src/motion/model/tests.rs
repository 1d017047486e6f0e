use super::*;
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

/// Fits to convergence with a weight for each pair.
fn fit_weighted(model: Model, pairs: &[Pair], weights: &[f64]) -> Result<Matrix3<f64>, MotionError> {
    model.fit_by(pairs, |i| weights[i], HOMOGRAPHY_ROUNDS)
}

const MODELS: [Model; 4] = [Model::Shift, Model::Similarity, Model::Affine, Model::Homography];

/// A random motion of the model: up to 15 degrees, 20 % of scale, 300 px, 5 % of shear, and a
/// perspective that changes the scale by up to 5 % over 1000 px.
fn motion(model: Model) -> impl Strategy<Value = Matrix3<f64>> {
    let shear = if model >= Model::Affine { 0.05 } else { 0.0 };
    let bottom = if model == Model::Homography { 5e-5 } else { 0.0 };
    let turn = if model == Model::Shift { 0.0 } else { 1.0 };
    let unit = || -1.0..1.0f64;
    (unit(), unit(), (unit(), unit()), (unit(), unit()), (unit(), unit())).prop_map(
        move |(angle, scale, (tx, ty), (s0, s1), (g, h))| {
            let (sin, cos) = (turn * 0.26 * angle).sin_cos();
            let k = 1.0 + turn * 0.2 * scale;
            let (s0, s1) = (shear * s0, shear * s1);
            Matrix3::new(
                k * cos + s0,
                -k * sin + s1,
                300.0 * tx,
                k * sin + s1,
                k * cos - s0,
                300.0 * ty,
                bottom * g,
                bottom * h,
                1.0,
            )
        },
    )
}

fn positions(count: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<Vector2<f64>>> {
    prop::collection::vec((0.0..1024.0f64, 0.0..768.0f64).prop_map(|(x, y)| Vector2::new(x, y)), count)
}

fn pairs_under(h: &Matrix3<f64>, positions: &[Vector2<f64>]) -> Vec<Pair> {
    positions.iter().map(|&p| Pair { reference: p, current: transfer(h, p).unwrap() }).collect()
}

/// A triangle over the picture whose smallest height is at least 20 px, so that rounding is not magnified beyond
/// the tolerance below.
fn well_spread(positions: &[Vector2<f64>]) -> bool {
    let n = positions.len();
    let far = (0..n).all(|i| (0..i).all(|j| (positions[i] - positions[j]).norm() > 20.0));
    let wide = |i: usize, j: usize, k: usize| {
        let longest = (positions[i] - positions[j]).norm().max((positions[j] - positions[k]).norm());
        (positions[j] - positions[i]).perp(&(positions[k] - positions[i])).abs() > 20.0 * longest
    };
    far && (0..n).all(|i| (0..i).all(|j| (0..j).all(|k| wide(i, j, k))))
}

fn any_model_with_motion() -> impl Strategy<Value = (Model, Matrix3<f64>)> {
    prop::sample::select(MODELS.to_vec()).prop_flat_map(|model| motion(model).prop_map(move |h| (model, h)))
}

proptest! {
    #[test]
    fn minimal_pairs_are_met_exactly((model, h) in any_model_with_motion(), four in positions(4)) {
        let positions = &four[..model.minimal_pairs()];
        prop_assume!(well_spread(positions));
        let pairs = pairs_under(&h, positions);
        let found = model.fit(&pairs).unwrap();
        for pair in &pairs {
            prop_assert!(squared_error(&found, pair) < 1e-12, "{model:?} {found} {h}");
        }
    }

    #[test]
    fn many_exact_pairs_give_the_motion_back(
        (model, h) in any_model_with_motion(), positions in positions(12..40),
    ) {
        let pairs = pairs_under(&h, &positions);
        let found = model.fit(&pairs).unwrap();
        for corner in [(0.0, 0.0), (1023.0, 0.0), (0.0, 767.0), (1023.0, 767.0)] {
            let corner = Vector2::new(corner.0, corner.1);
            let miss = (transfer(&found, corner).unwrap() - transfer(&h, corner).unwrap()).norm();
            prop_assert!(miss < 1e-6, "{model:?} misses a corner by {miss}");
        }
    }

    /// No small change of a parameter lowers the weighted sum: the fit is the minimum, weights included.
    #[test]
    fn least_squares_is_a_minimum(
        (model, h) in any_model_with_motion(),
        positions in positions(12..30),
        noise in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0.1..2.0f64), 30),
    ) {
        let mut pairs = pairs_under(&h, &positions);
        for (pair, n) in pairs.iter_mut().zip(&noise) {
            pair.current += Vector2::new(n.0, n.1);
        }
        let weights: Vec<f64> = noise.iter().take(pairs.len()).map(|n| n.2).collect();
        let cost = |h: &Matrix3<f64>| -> f64 {
            pairs.iter().zip(&weights).map(|(pair, w)| w * squared_error(h, pair)).sum()
        };
        let found = fit_weighted(model, &pairs, &weights).unwrap();
        let least = cost(&found);
        let mut steps = vec![(0, 2, 0.1), (1, 2, 0.1)];
        if model >= Model::Affine {
            steps.extend([(0, 0, 1e-3), (0, 1, 1e-3), (1, 0, 1e-3), (1, 1, 1e-3)]);
        }
        for (row, column, step) in steps {
            for step in [step, -step] {
                let mut near = found;
                near[(row, column)] += step;
                let near = cost(&near);
                prop_assert!(near > least, "{model:?}: {near} at ({row}, {column}) {step} under {least}");
            }
        }
        if model == Model::Similarity {
            for turn in [Matrix3::new(1.001, 0.0, 0.0, 0.0, 1.001, 0.0, 0.0, 0.0, 1.0),
                         Matrix3::new(1.0, -1e-3, 0.0, 1e-3, 1.0, 0.0, 0.0, 0.0, 1.0)] {
                prop_assert!(cost(&(turn * found)) > least);
                prop_assert!(cost(&(turn.try_inverse().unwrap() * found)) > least);
            }
        }
    }

    #[test]
    fn weight_zero_leaves_out(h in motion(Model::Affine), positions in positions(12..20), wild in positions(3)) {
        let mut pairs = pairs_under(&h, &positions);
        let mut weights = vec![1.0; pairs.len()];
        pairs.extend(wild.iter().map(|&p| Pair { reference: p, current: Vector2::new(p.y, -p.x) }));
        weights.resize(pairs.len(), 0.0);
        for model in MODELS {
            let left_out = fit_weighted(model, &pairs, &weights).unwrap();
            let absent = model.fit(&pairs[..positions.len()]).unwrap();
            prop_assert!((left_out - absent).norm() < 1e-9, "{model:?} {left_out} {absent}");
        }
    }
}

/// A strong perspective, in a square of side 2 with noise of 0.01: denominators from 0.4 to 1.6, so that the
/// equations as they are would weigh some pairs 16 times as much as others. The minimum is found here by
/// Gauss-Newton on all eight parameters.
#[test]
fn the_homography_minimises_the_transfer_error() {
    let truth = Matrix3::new(1.1, 0.1, 0.2, -0.1, 0.9, -0.1, 0.35, -0.25, 1.0);
    let spread = |i: u32, step: f64| 2.0 * (f64::from(i) * step).fract() - 1.0;
    let pairs: Vec<Pair> = (0..60)
        .map(|i| {
            let reference = Vector2::new(spread(i, 0.618_034), spread(i, 0.414_214));
            let noise = 0.01 * Vector2::new(spread(i, 0.732_051), spread(i, 0.236_068));
            Pair { reference, current: transfer(&truth, reference).unwrap() + noise }
        })
        .collect();
    let cost = |h: &Matrix3<f64>| pairs.iter().map(|pair| squared_error(h, pair)).sum::<f64>();
    let found = Model::Homography.fit(&pairs).unwrap();
    let mut least = found;
    for _ in 0..10 {
        let (mut normal, mut gradient) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
        for pair in &pairs {
            let position = |h: &Matrix3<f64>| transfer(h, pair.reference).unwrap();
            let slope = SMatrix::<f64, 2, 8>::from_fn(|axis, k| {
                let mut near = least;
                near[(k / 3, k % 3)] += 1e-6;
                (position(&near)[axis] - position(&least)[axis]) / 1e-6
            });
            normal += slope.transpose() * slope;
            gradient += slope.transpose() * (pair.current - position(&least));
        }
        let step = normal.cholesky().unwrap().solve(&gradient);
        for k in 0..8 {
            least[(k / 3, k % 3)] += step[k];
        }
    }
    let (found, least) = (cost(&found), cost(&least));
    assert!(least < 0.01 && found <= 1.001 * least, "{found} over {least}");
}

fn pair(reference: (f64, f64), current: (f64, f64)) -> Pair {
    Pair { reference: Vector2::new(reference.0, reference.1), current: Vector2::new(current.0, current.1) }
}

#[test]
fn degenerate_samples_are_refused() {
    let still = |x: f64, y: f64| pair((x, y), (x, y));
    let one_place = [still(5.0, 5.0); 4];
    let line: Vec<Pair> = (0..6).map(|i| still(10.0 * f64::from(i), 20.0 * f64::from(i))).collect();
    let three_on_a_line = [still(0.0, 0.0), still(100.0, 0.0), still(200.0, 0.0), still(50.0, 90.0)];
    for model in [Model::Similarity, Model::Affine, Model::Homography] {
        assert_eq!(model.fit(&one_place), Err(MotionError::Degenerate), "{model:?}");
    }
    for model in [Model::Affine, Model::Homography] {
        assert_eq!(model.fit(&line), Err(MotionError::Degenerate), "{model:?}");
    }
    assert_eq!(Model::Homography.fit(&three_on_a_line), Err(MotionError::Degenerate));
    for turn in 0..50 {
        // On a line in CUR only, at any angle: rounding alone decides the sign of the determinant.
        let (s, c) = (0.1 * f64::from(turn)).sin_cos();
        let on_line = |t: f64| (100.0 + c * t, 50.0 + s * t);
        let fold = [
            pair((0.0, 0.0), on_line(0.0)),
            pair((100.0, 3.0), on_line(70.0)),
            pair((180.0, 90.0), on_line(130.0)),
            pair((30.0, 90.0), (100.0 - 60.0 * s, 50.0 + 60.0 * c)),
        ];
        assert_eq!(Model::Homography.fit(&fold), Err(MotionError::Degenerate), "{turn}");
    }
    assert_eq!(
        Model::Affine.fit(&line[..2]),
        Err(MotionError::TooFew { needed: 3, given: 2 }),
        "two pairs cannot make an affine map"
    );
}

#[test]
fn a_mirroring_map_is_refused() {
    let mirrored = [
        pair((0.0, 0.0), (0.0, 0.0)),
        pair((100.0, 0.0), (-100.0, 0.0)),
        pair((0.0, 100.0), (0.0, 100.0)),
        pair((90.0, 80.0), (-90.0, 80.0)),
    ];
    assert_eq!(Model::Affine.fit(&mirrored), Err(MotionError::Degenerate));
    assert_eq!(Model::Homography.fit(&mirrored), Err(MotionError::Degenerate));
}

#[test]
fn invalid_weights_and_coordinates_are_refused() {
    let pairs = [pair((0.0, f64::NAN), (1.0, 1.0)), pair((9.0, 1.0), (8.0, 1.0))];
    assert_eq!(Model::Similarity.fit(&pairs), Err(MotionError::NotFinite));
    let pairs = [pair((0.0, 0.0), (1.0, 1.0)), pair((9.0, 1.0), (8.0, 1.0))];
    assert_eq!(Model::Shift.fit_round(&pairs, &[1.0]), Err(MotionError::NotFinite));
    assert_eq!(Model::Shift.fit_round(&pairs, &[1.0, -1.0]), Err(MotionError::NotFinite));
}
