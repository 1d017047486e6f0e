use super::*;
use crate::motion::model::transfer;
use nalgebra::Vector2;
use proptest::prelude::*;
use rand::RngExt;
use rand::seq::index;

const PICTURE: Vector2<f64> = Vector2::new(1024.0, 768.0);

fn position(rng: &mut ChaCha8Rng) -> Vector2<f64> {
    Vector2::new(rng.random::<f64>(), rng.random::<f64>()).component_mul(&PICTURE)
}

/// Sum of twelve uniform numbers: variance 1.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// `inliers` pairs of the motion `h` with noise of `sigma` px a coordinate, then `outliers` anywhere in CUR, 20 px
/// or more from where they belong.
fn scene(rng: &mut ChaCha8Rng, h: &Matrix3<f64>, inliers: usize, outliers: usize, sigma: f64) -> Vec<Pair> {
    let mut pairs = Vec::new();
    while pairs.len() < inliers {
        let reference = position(rng);
        let current = transfer(h, reference).unwrap() + sigma * Vector2::new(normal(rng), normal(rng));
        pairs.push(Pair { reference, current });
    }
    while pairs.len() < inliers + outliers {
        let wrong = Pair { reference: position(rng), current: position(rng) };
        if squared_error(h, &wrong) > 400.0 {
            pairs.push(wrong);
        }
    }
    pairs
}

fn similarity(angle: f64, scale: f64, tx: f64, ty: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    Matrix3::new(scale * c, -scale * s, tx, scale * s, scale * c, ty, 0.0, 0.0, 1.0)
}

fn centre_miss(found: &Matrix3<f64>, truth: &Matrix3<f64>) -> f64 {
    (transfer(found, PICTURE / 2.0).unwrap() - transfer(truth, PICTURE / 2.0).unwrap()).norm()
}

fn shuffled(rng: &mut ChaCha8Rng, pairs: Vec<Pair>) -> Vec<Pair> {
    let order = index::sample(rng, pairs.len(), pairs.len());
    order.into_iter().map(|i| pairs[i]).collect()
}

fn any_search() -> impl Strategy<Value = Ransac> {
    let functional = prop_oneof![
        Just(Functional::Count),
        Just(Functional::Added(None)),
        Just(Functional::Subtracted(None)),
        Just(Functional::Msac)
    ];
    let model = prop::sample::select(vec![Model::Shift, Model::Similarity, Model::Affine, Model::Homography]);
    let order = prop::sample::select(vec![Order::BestFirst, Order::Uniform]);
    (model, functional, order, 0..4usize, any::<u64>()).prop_map(|(model, functional, order, rounds, seed)| Ransac {
        model,
        functional,
        order,
        local_optimisation_rounds: rounds,
        seed,
        ..Ransac::default()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Exact matches, as many wrong ones, in any order: every model, functional and order finds all of them.
    #[test]
    fn exact_motion_is_recovered(
        search in any_search(), angle in -0.3..0.3f64, scale in 0.8..1.25f64,
        t in (-300.0..300.0f64, -300.0..300.0f64),
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(search.seed);
        let (angle, scale) = if search.model == Model::Shift { (0.0, 1.0) } else { (angle, scale) };
        let h = similarity(angle, scale, t.0, t.1);
        let pairs = scene(&mut rng, &h, 60, 60, 0.0);
        let pairs = shuffled(&mut rng, pairs);
        let found = search.run(&pairs, None).unwrap();
        let true_pairs = (0..pairs.len()).filter(|&i| squared_error(&h, &pairs[i]) < 1e-12);
        prop_assert!(true_pairs.into_iter().all(|i| found.inliers.contains(&i)), "{} inliers", found.inliers.len());
        // Without residuals in the functional, or with the wrong sign, any hypothesis within the voting radius of all
        // is as good.
        let exact = matches!(search.functional, Functional::Msac | Functional::Subtracted(_));
        let tolerance = if exact { 1e-3 } else { search.max_squared_error.sqrt() };
        prop_assert!(centre_miss(&found.homography, &h) < tolerance, "{}", centre_miss(&found.homography, &h));
    }

    #[test]
    fn one_seed_one_result(search in any_search(), sigma in 0.0..2.0f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(search.seed);
        let pairs = scene(&mut rng, &similarity(0.1, 1.05, 30.0, -50.0), 50, 80, sigma);
        prop_assert_eq!(search.run(&pairs, None), search.run(&pairs, None));
    }
}

/// Two hypotheses, each with all votes; one misses by 0.1 px, the other by 2 px.
#[test]
fn the_added_form_prefers_the_worse_of_two() {
    let pairs = scene(&mut ChaCha8Rng::seed_from_u64(5), &Matrix3::identity(), 40, 0, 0.0);
    let max_squared_error = 9.0;
    let value = |functional: Functional, miss: f64| {
        let factor = functional.factor(pairs.len(), max_squared_error).unwrap();
        Hypothesis::of(similarity(0.0, 1.0, miss, 0.0), &pairs, max_squared_error, factor).functional
    };
    assert!(value(Functional::Added(None), 0.1) < value(Functional::Added(None), 2.0));
    assert!(value(Functional::Subtracted(None), 0.1) > value(Functional::Subtracted(None), 2.0));
    assert!(value(Functional::Msac, 0.1) > value(Functional::Msac, 2.0));
    assert_eq!(value(Functional::Count, 0.1), value(Functional::Count, 2.0));
}

/// In a whole search the added form also finds the worse one.
#[test]
fn the_added_form_is_less_accurate_than_the_subtracted() {
    let truth = similarity(0.05, 1.02, 40.0, -25.0);
    let mut misses = [Vec::new(), Vec::new()];
    for seed in 0..40 {
        let pairs = scene(&mut ChaCha8Rng::seed_from_u64(seed), &truth, 60, 40, 0.5);
        for (functional, misses) in [Functional::Added(None), Functional::Subtracted(None)].into_iter().zip(&mut misses)
        {
            let search = Ransac { functional, seed, local_optimisation_rounds: 0, ..Ransac::default() };
            misses.push(centre_miss(&search.run(&pairs, None).unwrap().homography, &truth));
        }
    }
    let [added, subtracted] = misses.map(median);
    assert!(added > 1.5 * subtracted, "added {added:.3} px, subtracted {subtracted:.3} px");
}

/// Two hypotheses, 0.2 and 1 px off, half of the pairs wrong: over the voters the sum selects the better one
/// every time; over all pairs the wrong ones decide, at random.
#[test]
fn over_all_pairs_outliers_swamp_the_sum() {
    let (mut by_voters, mut by_all) = (0, 0);
    let cases = 200;
    for seed in 0..cases {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let pairs = scene(&mut rng, &Matrix3::identity(), 40, 40, 0.3);
        let direction = std::f64::consts::TAU * rng.random::<f64>();
        let off = |miss: f64| similarity(0.0, 1.0, miss * direction.cos(), miss * direction.sin());
        let over_all = |h: &Matrix3<f64>| pairs.iter().map(|pair| squared_error(h, pair)).sum::<f64>();
        let over_voters = |h: &Matrix3<f64>| Score::of(h, &pairs, 9.0).squared_errors;
        by_voters += usize::from(over_voters(&off(0.2)) < over_voters(&off(1.0)));
        by_all += usize::from(over_all(&off(0.2)) < over_all(&off(1.0)));
    }
    assert_eq!(by_voters, cases as usize);
    assert!((70..=130).contains(&by_all), "{by_all} of {cases}: no better than a coin");
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Median movement of the result, px, when the voting radius changes from 2 px to 6 px; noise 0.5 px.
fn moved_by_radius(local_optimisation_rounds: usize) -> f64 {
    let truth = similarity(0.05, 1.02, 40.0, -25.0);
    let moves = (0..30).map(|seed| {
        let pairs = scene(&mut ChaCha8Rng::seed_from_u64(seed), &truth, 80, 60, 0.5);
        let at = |max_squared_error: f64| {
            let search = Ransac {
                functional: Functional::Count,
                max_squared_error,
                local_optimisation_rounds,
                seed,
                ..Ransac::default()
            };
            transfer(&search.run(&pairs, None).unwrap().homography, PICTURE / 2.0).unwrap()
        };
        (at(4.0) - at(36.0)).norm()
    });
    median(moves.collect())
}

#[test]
fn local_optimisation_makes_the_result_independent_of_the_voting_radius() {
    let (without, with) = (moved_by_radius(0), moved_by_radius(3));
    assert!(with < 0.02 && without > 0.3, "{with:.4} px with, {without:.4} px without");
}

/// `NFA` bounds the expected number of samples with `k` voters or more, so at most a fraction `NFA` of all trials may
/// find one. 400 trials at NFA <= 0.05: 20 expected at most, 40 is 4.5 sigma more.
#[test]
fn random_matches_agree_no_more_often_than_the_bound_says() {
    for (model, crowded) in [(Model::Shift, false), (Model::Similarity, false), (Model::Similarity, true)] {
        let (mut below, mut accepted) = (0, 0);
        let trials = 400;
        for seed in 0..trials {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut pairs = scene(&mut rng, &similarity(0.0, 1.0, 1e6, 0.0), 0, 120, 0.0);
            if crowded {
                // Two thirds of the features in 2 % of the picture: a jetty in open water.
                for pair in pairs.iter_mut().take(80) {
                    pair.reference = pair.reference.component_mul(&Vector2::new(0.1, 0.2));
                    pair.current = pair.current.component_mul(&Vector2::new(0.1, 0.2));
                }
            }
            let pairs = shuffled(&mut rng, pairs);
            let search = Ransac { model, seed, max_samples: 2000, ..Ransac::default() };
            match search.run(&pairs, None) {
                Ok(_) => accepted += 1,
                Err(RansacError::AgreementByChance { log10_nfa, .. }) => {
                    below += usize::from(log10_nfa <= 0.05f64.log10())
                }
                Err(other) => panic!("{other}"),
            }
        }
        assert_eq!(accepted, 0, "{model:?}, crowded {crowded}");
        assert!(below <= 40, "{model:?}, crowded {crowded}: {below} of {trials} at 0.05");
    }
}

/// Twelve true matches among 200 wrong ones are enough for a similarity.
#[test]
fn few_true_matches_among_many_wrong_ones_give_an_estimate() {
    let truth = similarity(0.1, 1.05, 80.0, -60.0);
    for seed in 0..10 {
        let pairs = scene(&mut ChaCha8Rng::seed_from_u64(seed), &truth, 12, 200, 0.5);
        let found = Ransac { seed, ..Ransac::default() }.run(&pairs, None).unwrap();
        assert!(centre_miss(&found.homography, &truth) < 1.5 && found.quality >= 8, "{found:?}");
    }
}

#[test]
fn settings_are_checked() {
    let pairs = scene(&mut ChaCha8Rng::seed_from_u64(1), &Matrix3::identity(), 100, 0, 0.0);
    // 100 pairs at 9 px^2: at most 1/900.
    let with = |functional: Functional| Ransac { functional, ..Ransac::default() }.run(&pairs, None);
    assert!(with(Functional::Subtracted(Some(1.0 / 900.0))).is_ok());
    for k in [1.0 / 899.0, -1e-6, f64::NAN] {
        assert!(matches!(with(Functional::Subtracted(Some(k))), Err(RansacError::FactorTooLarge { .. })), "{k}");
    }
    for search in [
        Ransac { max_squared_error: 0.0, ..Ransac::default() },
        Ransac { max_squared_error: f64::NAN, ..Ransac::default() },
        Ransac { confidence: 1.0, ..Ransac::default() },
        Ransac { max_samples: 0, ..Ransac::default() },
    ] {
        assert!(matches!(search.run(&pairs, None), Err(RansacError::InvalidSetting(_))));
    }
    assert_eq!(Ransac::default().run(&pairs[..1], None), Err(RansacError::TooFewMatches { needed: 2, given: 1 }));
    assert_eq!(Ransac::default().run(&[pairs[0]; 9], None), Err(RansacError::Degenerate(9)));
}

/// Pairs of a homography, all right, noise 0.08 px, in raster order, shuffled, or sorted by error with the worst
/// first: the search starts from other samples and ends in the same motion, as nearly as it settles.
#[test]
fn the_order_of_the_pairs_does_not_matter() {
    let truth = Matrix3::new(1.02, -0.05, 12.0, 0.05, 1.01, -7.0, 4e-5, -3e-5, 1.0);
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut raster = scene(&mut rng, &truth, 300, 0, 0.08);
        raster.sort_by(|a, b| a.reference.y.total_cmp(&b.reference.y));
        let mut worst_first = raster.clone();
        worst_first.sort_by(|a, b| squared_error(&truth, b).total_cmp(&squared_error(&truth, a)));
        let mixed = shuffled(&mut rng, raster.clone());
        let search = Ransac { model: Model::Homography, seed, ..Ransac::default() };
        let misses = [raster, worst_first, mixed].map(|pairs| {
            let found = search.run(&pairs, None).unwrap();
            assert_eq!(found.inliers.len(), 300);
            centre_miss(&found.homography, &truth)
        });
        assert!(
            misses.iter().all(|miss| *miss < 0.03 && (miss - misses[0]).abs() < 0.1 * search.convergence_step),
            "{misses:?}"
        );
    }
}

/// Half of the pairs right: 36 samples of two make 99.99 % sure, not 20 000.
#[test]
fn the_search_stops_at_the_confidence() {
    let pairs = scene(&mut ChaCha8Rng::seed_from_u64(1), &Matrix3::identity(), 100, 100, 0.2);
    let pairs = shuffled(&mut ChaCha8Rng::seed_from_u64(2), pairs);
    // ln(1e-4) / ln(1 - 1/4) = 32.02, and every other sample is one from among all pairs.
    assert_eq!(Ransac::default().needed_samples(100, 200), 33);
    assert_eq!(Ransac::default().run(&pairs, None).unwrap().samples, 66);
    assert_eq!(Ransac::default().needed_samples(200, 200), 0);
    assert_eq!(Ransac::default().needed_samples(0, 200), usize::MAX);
}
