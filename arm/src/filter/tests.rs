//! Tests of the filter.

use super::linear::solve;
use super::rotation::logarithm;
use super::*;
use hoverlock_reference::motion::budget::Budget;
use hoverlock_reference::motion::orthophoto::Camera;
use nalgebra::{DMatrix, DVector, Matrix2, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SENSORS: SensorErrors = SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 };

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

fn camera() -> Camera {
    Camera::with_field_of_view(1024, 768, 0.87).unwrap()
}

fn unlimited() -> Budget {
    Budget::UNLIMITED
}

fn started() -> Filter {
    let mut filter = Filter::new();
    filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
    filter.clone_pose(0);
    filter
}

fn hovering(seconds: f64) -> impl Iterator<Item = Step> {
    let count = (seconds * 200.0).round() as usize;
    std::iter::repeat_n(
        Step { rates: Vector3::zeros(), force: Vector3::new(0.0, 0.0, -GRAVITY), seconds: 0.005 },
        count,
    )
}

/// Returns the state of a level camera `moved` m beside the level keyframe.
fn level_pair(filter: &Filter, moved: Vector3<f64>) -> PairState {
    let mut state = filter.pair_state(0).unwrap();
    state.then.pose.rotation = Matrix3::identity();
    state.now.pose.position = state.then.pose.position + moved;
    state.now.pose.rotation = Matrix3::identity();
    state
}

/// Returns sightings of points on flat ground from a place `moved` m beside the keyframe, with noise of 0.3 px.
fn sightings(filter: &Filter, moved: Vector3<f64>, errors: CameraErrors, rng: &mut ChaCha8Rng) -> Vec<Sighting> {
    seen(&PairState { errors, ..level_pair(filter, moved) }, rng)
}

/// Returns sightings of points on flat ground from a place, with noise of 0.3 px.
fn seen(state: &PairState, rng: &mut ChaCha8Rng) -> Vec<Sighting> {
    let camera = camera();
    (0..200)
        .map(|landmark| {
            let reference = Vector2::new(1023.0 * rng.random::<f64>(), 767.0 * rng.random::<f64>());
            let image = state.project([&camera, &camera], &reference).unwrap().image;
            Sighting {
                landmark,
                reference,
                current: image + 0.3 * Vector2::new(normal(rng), normal(rng)),
                covariance: Matrix2::identity() * 0.09,
                counts: true,
                is_refined: false,
                chi2: 0.0,
                residual: Vector2::zeros(),
            }
        })
        .collect()
}

#[test]
fn a_system_is_solved_with_pivots() {
    let mut a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 1.0];
    let mut b = [7.0, 3.0, 6.0];
    solve(&mut a, &mut b, 3, 1, 1).unwrap();
    assert!(b.iter().zip([1.0, 2.0, 3.0]).all(|(found, expected)| (found - expected).abs() < 1e-12), "{b:?}");
    assert_eq!(solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 2.0], 2, 1, 1), None);
}

/// The equations of the module without the elimination of heights, on dense matrices, after updates that correlate
/// the state with heights.
#[test]
fn eliminated_heights_give_the_dense_update() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut filter = started();
    let camera = camera();
    for step in 0..4 {
        filter.predict(hovering(0.1), &SENSORS);
        let moved = Vector3::new(0.1 * f64::from(step), -0.2, 0.3);
        let mut seen = sightings(&filter, moved, CameraErrors::default(), &mut rng);
        filter
            .update_sightings(0, [&camera, &camera], &mut seen, 8, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
            .unwrap();
    }
    filter.predict(hovering(0.1), &SENSORS);
    let mut seen = sightings(&filter, Vector3::new(1.0, 0.5, -0.5), CameraErrors::default(), &mut rng);
    let (prior, states) = (filter.pair_state(0).unwrap(), pair_states(0));
    filter.linearise(&prior, [&camera, &camera], &mut seen, 1, &[0.0; PAIR], None).unwrap();

    let Scratch { cells, poses, coupling, heights, pose_vector, height_vector, .. } = &filter.scratch;
    let size = PAIR + cells.len();
    assert!(cells.len() > 20);
    let information = DMatrix::from_fn(size, size, |i, j| match (i.min(j), i.max(j)) {
        (i, j) if j < PAIR => poses[i][j],
        (i, j) if i < PAIR => coupling[j - PAIR][i],
        (i, j) => f64::from(u8::from(i == j)) * heights[i - PAIR],
    });
    let vector = DVector::from_fn(size, |i, _| if i < PAIR { pose_vector[i] } else { height_vector[i - PAIR] });
    let with_y = DMatrix::from_fn(STATES, size, |x, j| match j {
        j if j < PAIR => filter.at(x, states[j]),
        j => filter.cross[x * CELLS + cells[j - PAIR]],
    });
    let of_y = DMatrix::from_fn(size, size, |i, j| match (i.min(j), i.max(j)) {
        (i, j) if i < PAIR => with_y[(states[i], j)],
        (i, j) => f64::from(u8::from(i == j)) * filter.height_variance(),
    });
    let inverse = (DMatrix::identity(size, size) + &information * of_y).try_inverse().unwrap();
    let gain = &with_y * inverse;
    let covariance = DMatrix::from_fn(STATES, STATES, |i, j| filter.at(i, j));
    let with_heights = DMatrix::from_row_slice(STATES, CELLS, &filter.cross);
    let of_heights = DMatrix::from_fn(size, CELLS, |i, cell| match i {
        i if i < PAIR => filter.cross[states[i] * CELLS + cell],
        i => f64::from(u8::from(cells[i - PAIR] == cell)) * filter.height_variance(),
    });
    let kept = |state: usize| if (SLOPE..CORE).contains(&state) { KEPT_SLOPE } else { 0.0 };
    let parts = DMatrix::from_fn(STATES, STATES, |i, j| 1.0 - kept(i) * kept(j));
    let expected = covariance - parts.component_mul(&(&gain * &information * with_y.transpose()));
    let parts = DMatrix::from_fn(STATES, CELLS, |i, _| 1.0 - kept(i));
    let expected_heights = with_heights - parts.component_mul(&(&gain * &information * of_heights));
    let moved = &gain * vector;

    filter.fill_system(&states);
    let change = filter.solve_change().unwrap();
    let (before, slope) = (filter.pose.position, filter.slope);
    filter.apply(&states).unwrap();
    let near = |found: f64, expected: f64, scale: f64| (found - expected).abs() <= 1e-7 * scale;
    for axis in 0..3 {
        assert!(near(change[axis], moved[axis], moved.amax()), "{change:?} {moved}");
        assert!(near(filter.pose.position[axis] - before[axis], moved[axis], moved.amax()));
    }
    for axis in 0..2 {
        let change = filter.slope[axis] - slope[axis];
        assert!(near(change, (1.0 - KEPT_SLOPE) * moved[SLOPE + axis], moved.amax()), "{change} {moved}");
    }
    let (largest, largest_height) = (expected.amax(), expected_heights.amax());
    for i in 0..STATES {
        (0..STATES).for_each(|j| assert!(near(filter.at(i, j), expected[(i, j)], largest), "{i} {j}"));
        for cell in 0..CELLS {
            assert!(near(filter.cross[i * CELLS + cell], expected_heights[(i, cell)], largest_height), "{i} {cell}");
        }
    }
}

#[test]
fn the_prediction_follows_force_and_rates() {
    let mut filter = started();
    let push = Step { rates: Vector3::z() * 0.5, force: Vector3::new(0.0, 0.0, -GRAVITY - 2.0), seconds: 0.005 };
    filter.predict(std::iter::repeat_n(push, 200), &SENSORS);
    // A second of 2 m/s^2 upwards: 1 m.
    assert!((filter.pose.position - Vector3::new(0.0, 0.0, -51.0)).norm() < 1e-9, "{}", filter.pose.position);
    assert!((filter.pose.rotation - exponential(&(Vector3::z() * 0.5))).norm() < 1e-9);
    assert!((logarithm(&filter.pose.rotation) - Vector3::z() * 0.5).norm() < 1e-9);
}

/// Of half a turn the direction is not known.
#[test]
fn the_logarithm_inverts_the_exponential_up_to_half_a_turn() {
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let around = std::f64::consts::PI;
    let drawn: Vec<f64> = (0..1000).map(|_| around * rng.random::<f64>()).collect();
    for angle in drawn.into_iter().chain([0.0, 1e-7, around / 2.0, around - 1e-9, around]) {
        let axis = Vector3::from_fn(|_, _| normal(&mut rng)).normalize();
        let found = logarithm(&exponential(&(axis * angle)));
        let miss = [1.0, -1.0].map(|sign| (found - axis * (sign * angle)).norm());
        assert!(miss[0] < 1e-6 || angle == around && miss[1] < 1e-6, "{angle} about {axis}: {found}");
    }
}

/// Returns what of a reading contradicts a filter that has hovered at 50 m.
fn contradiction(yaw: f64, range: f64) -> (f64, f64) {
    let mut filter = started();
    filter.predict_free(0.1);
    let turn = filter.update_attitude(&Attitude { yaw, ..Attitude::default() }, &SENSORS);
    assert_eq!(turn.xy(), Vector2::zeros());
    (turn.z, filter.update_range(range, SENSORS.range))
}

#[test]
fn a_reading_that_contradicts_the_state_is_named() {
    assert_eq!(contradiction(0.01, 50.1), (0.0, 0.0));
    let (turn, scale) = contradiction(std::f64::consts::PI, 500.0);
    assert!((turn - std::f64::consts::PI).abs() < 1e-9 && (scale - 9.0).abs() < 1e-9, "{turn}, {scale}");
}

/// The first frame of a flight has no sample before it.
#[test]
fn a_keyframe_takes_its_rates_from_the_samples_before_or_after_it() {
    let turn = |rate: f64| Step { rates: Vector3::x() * rate, force: -Vector3::z() * GRAVITY, seconds: 0.005 };
    let mut filter = Filter::new();
    filter.predict(std::iter::empty(), &SENSORS);
    filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
    filter.clone_pose(0);
    filter.predict([turn(0.1), turn(0.2)].into_iter(), &SENSORS);
    filter.clone_pose(1);
    filter.predict([turn(0.3)].into_iter(), &SENSORS);
    let rates = [0, 1].map(|k| filter.keyframes[k].unwrap().rates.x);
    assert_eq!(rates, [0.1, 0.2]);
    filter.predict_free(0.1);
    filter.clone_pose(1);
    filter.predict_free(0.1);
    filter.predict([turn(0.3)].into_iter(), &SENSORS);
    assert_eq!(filter.keyframes[1].unwrap().rates.x, 0.0);
}

/// Central differences agree with the derivatives of a projection.
#[test]
fn derivatives_are_those_of_the_projection() {
    let camera = camera();
    let zoomed = Camera::with_field_of_view(1024, 768, 0.8).unwrap();
    let moving = |position: Vector3<f64>, turned: Vector3<f64>, velocity: Vector3<f64>| MovingCamera {
        pose: CameraPose { position, rotation: exponential(&turned) },
        velocity,
        rates: Vector3::new(0.05, -0.03, 0.04) * velocity.x,
    };
    let state = PairState {
        then: moving(Vector3::new(1.0, 2.0, -50.0), Vector3::new(0.02, 0.03, 0.4), Vector3::new(1.0, 2.0, 0.5)),
        now: moving(Vector3::new(3.0, 1.0, -48.0), Vector3::new(-0.03, 0.01, 0.5), Vector3::new(-2.0, 1.0, 0.3)),
        errors: CameraErrors { distortion: -0.09, readout_s: 0.005, focal: 0.02, delay_s: 0.004 },
        slope: Vector2::new(0.05, -0.1),
    };
    let pixel = Vector2::new(300.0, 600.0);
    let at = |change: &[f64; PAIR]| state.moved(change).project([&camera, &zoomed], &pixel).unwrap();
    let exact = at(&[0.0; PAIR]).by_pair();
    for i in 0..PAIR {
        let [plus, minus] = [1e-5, -1e-5].map(|h| {
            let mut change = [0.0; PAIR];
            change[i] = h;
            at(&change).image
        });
        let numeric = (plus - minus) / 2e-5;
        let found = exact.column(i).into_owned();
        // The row at which the time is taken is not differentiated: 1e-3 here.
        assert!((numeric - found).norm() < 2e-3 * (1.0 + numeric.norm()), "{i}: {numeric} {found}");
    }
}

/// A pixel that the lens has moved comes back, and the sign of `k1` is that of pincushion.
#[test]
fn the_lens_is_inverted() {
    for distortion in [-0.09, 0.05] {
        let errors = CameraErrors { distortion, ..CameraErrors::default() };
        let straight = Vector2::new(0.46, -0.35);
        let seen = errors.distorted(&straight).0;
        assert!((seen.norm() > straight.norm()) == (distortion > 0.0));
        assert!((errors.straight(&seen) - straight).norm() < 1e-6, "{distortion}");
    }
}

/// Where the camera moves, its errors show, and their standard errors include what is left.
#[test]
fn the_errors_of_the_camera_are_estimated() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut filter = started();
    let errors = CameraErrors { distortion: -0.08, ..CameraErrors::default() };
    for frame in 0..120 {
        let place = Vector3::new(0.05 * f64::from(frame), 0.03 * f64::from(frame), 0.0);
        filter.predict(hovering(0.065), &SENSORS);
        filter.update_attitude(&Attitude::default(), &SENSORS);
        let mut seen = sightings(&filter, place, errors, &mut rng);
        filter
            .update_sightings(0, [&camera(), &camera()], &mut seen, 50, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
            .unwrap();
    }
    let sigma = filter.at(CAMERA, CAMERA).sqrt();
    let error = filter.errors.distortion - errors.distortion;
    assert!(sigma < 0.5 * Calibration::default().k1.sigma && error.abs() < 3.0 * sigma, "{error} {sigma}");
    let before = filter.errors.distortion;
    filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
    assert_eq!((filter.errors.distortion, filter.at(CAMERA, CAMERA).sqrt()), (before, sigma));
    filter.errors.distortion = f64::NAN;
    filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, true);
    assert!(filter.is_sound() && filter.at(CAMERA, CAMERA).sqrt() == Calibration::default().k1.sigma);
}

/// A camera that turns shows by how much its time stamps are early. The pose is that of the exposure.
#[test]
fn the_delay_of_the_exposure_is_estimated() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (mut filter, mut truth) = (started(), started());
    let errors = CameraErrors { delay_s: 0.006, ..CameraErrors::default() };
    let (swing, pulse, step) = (0.02, 3.0, 0.005);
    for frame in 0..90 {
        let steps = (0..13).map(|i| {
            let phase = pulse * step * (f64::from(13 * frame + i) + 0.5);
            let [angle, rate] = [swing * libm::sin(phase), swing * pulse * libm::cos(phase)];
            let force = exponential(&(Vector3::x() * -angle)) * Vector3::new(0.0, 0.0, -GRAVITY);
            Step { rates: Vector3::x() * rate, force, seconds: step }
        });
        truth.predict(steps.clone(), &SENSORS);
        filter.predict(steps, &SENSORS);
        filter.update_attitude(&Attitude::of_rotation(&truth.pose.rotation), &SENSORS);
        let mut seen = seen(&PairState { errors, ..truth.pair_state(0).unwrap() }, &mut rng);
        let cells = sightings::MAX_TOUCHED_CELLS;
        filter.update_sightings(0, [&camera(), &camera()], &mut seen, 50, cells, &mut unlimited()).unwrap();
    }
    let (error, sigma) = (filter.errors.delay_s - errors.delay_s, filter.at(SLOPE - 1, SLOPE - 1).sqrt());
    assert!(sigma < 0.2 * DELAY_SIGMA_S && error.abs() < 3.0 * sigma, "{error} {sigma}");
    let turned = filter.exposed().rotation - truth.present().after(errors.delay_s).rotation;
    assert!(turned.norm() < 5e-4 && (filter.exposed().rotation - filter.pose.rotation).norm() > 1e-4, "{turned}");
}

/// After a zoom nothing is known of the heights of smaller cells, and what is known of the state stays. A cell far away
/// has no correlation of the cell whose place it takes.
#[test]
fn cells_follow_the_picture() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut filter = started();
    let update = |filter: &mut Filter, rng: &mut ChaCha8Rng| {
        filter.predict(hovering(0.065), &SENSORS);
        let mut seen = sightings(filter, Vector3::new(0.02, 0.01, 0.0), CameraErrors::default(), rng);
        let cells = sightings::MAX_TOUCHED_CELLS;
        filter.update_sightings(0, [&camera(), &camera()], &mut seen, 50, cells, &mut unlimited()).unwrap();
    };
    update(&mut filter, &mut rng);
    let correlated = |filter: &Filter, cell: usize| (0..STATES).any(|i| filter.cross[i * CELLS + cell] != 0.0);
    let below = Vector3::new(0.1, 0.1, 0.0);
    let cell = filter.cell(&below);
    assert!(correlated(&filter, cell));
    let far = below + Vector3::x() * 3.0 * 46.0;
    assert_eq!((filter.cell(&far), correlated(&filter, cell)), (cell, false));
    update(&mut filter, &mut rng);
    let (work, covariance) = (filter.prediction_work(), filter.covariance.clone());
    filter.fit_grid(46.0 / 1.2);
    assert_eq!(filter.prediction_work(), work);
    filter.fit_grid(46.0 / 1.3);
    assert_eq!(filter.prediction_work(), PREDICTION_WORK);
    assert!(filter.cross.iter().all(|value| *value == 0.0) && filter.covariance == covariance);
}

/// Up to the limit the variance grows with the cube of the NIS, beyond it in proportion.
#[test]
fn innovations_raise_the_standard_errors() {
    let mut filter = started();
    let mut raised = |nis: f64| {
        filter.nis[1] = nis;
        let Inconsistency { of_bound, of_mean } = filter.inconsistency();
        assert_eq!(of_bound, of_mean);
        of_mean.powi(2)
    };
    for (nis, variance) in [(0.2, 1.0), (0.3, 1.0), (0.45, 3.375), (0.6, 8.0), (1.2, 16.0), (6.0, 80.0)] {
        assert!((raised(nis) - variance).abs() < 1e-9, "{nis}");
    }
}

/// A climb over a slope looks like a motion across it.
#[test]
fn a_climb_over_a_slope_does_not_mislead() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut filter = started();
    let (slope, mut place) = (Vector2::new(0.2, -0.1), Vector3::zeros());
    for _ in 0..60 {
        place.z -= 0.05;
        filter.predict(hovering(0.065), &SENSORS);
        filter.update_attitude(&Attitude::default(), &SENSORS);
        let believed = std::mem::replace(&mut filter.slope, slope);
        let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
        filter.slope = believed;
        filter
            .update_sightings(0, [&camera(), &camera()], &mut seen, 50, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
            .unwrap();
    }
    let (moved, covariance) = filter.displacement(0).unwrap();
    for axis in 0..2 {
        let (error, sigma) = (moved[axis], covariance[(axis, axis)].sqrt());
        assert!(error.abs() < 3.0 * sigma && error.abs() < 0.1, "{error} {sigma}");
        let (error, sigma) = (filter.slope[axis] - slope[axis], filter.at(SLOPE + axis, SLOPE + axis).sqrt());
        assert!(error.abs() < 3.0 * sigma && sigma < 0.9 * SLOPE_SIGMA, "{error} {sigma}");
    }
}

/// Without samples of the IMU camera and ground are taken as better known, until samples come again.
#[test]
fn without_samples_the_camera_is_calibrated_and_the_ground_is_flat() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut filter = started();
    let place = Vector3::new(4.0, 0.0, 0.0);
    filter.predict_free(0.066);
    assert!((filter.at(CAMERA, CAMERA).sqrt() - FREE_DISTORTION_SIGMA).abs() < 1e-12);
    assert_eq!(filter.height_sigma, 50.0 * FREE_HEIGHT_SIGMA);
    let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
    assert!(
        filter
            .update_sightings(0, [&camera(), &camera()], &mut seen, 50, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
            .unwrap()
            .is_applied
    );
    let (known, moved) = (filter.at(CAMERA, CAMERA), filter.displacement(0).unwrap().1[(0, 0)]);
    let correlation = filter.cross.iter().map(|value| value.abs()).fold(0.0, f64::max);
    filter.predict(hovering(0.005), &SENSORS);
    let withheld = Calibration::default().k1.sigma.powi(2) - FREE_DISTORTION_SIGMA.powi(2);
    assert!((filter.at(CAMERA, CAMERA) - known - withheld).abs() < 1e-12);
    assert_eq!(filter.height_sigma, MAX_HEIGHT_SIGMA_M);
    filter.predict_free(1e-6);
    let reduced = filter.cross.iter().map(|value| value.abs()).fold(0.0, f64::max);
    assert!((reduced / correlation - FREE_HEIGHT_SIGMA / HEIGHT_SIGMA).abs() < 1e-3, "{reduced} {correlation}");
    assert!(filter.at(CAMERA, CAMERA).sqrt() < FREE_DISTORTION_SIGMA + 1e-12 && filter.is_sound());
    assert!(filter.displacement(0).unwrap().1[(0, 0)] >= moved);
}

/// The first sightings of a hover have independent errors, of which a sixteenth counts: the squared error is well
/// below its covariance. Readings have their stated errors.
#[test]
fn the_covariance_includes_the_error() {
    let (mut sum, runs) = (0.0, 40);
    for seed in 0..runs {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut filter = started();
        let mut tilt = || SENSORS.tilt * normal(&mut rng);
        let reading = Attitude { roll: tilt(), pitch: tilt(), yaw: 0.0 };
        filter.restart(50.0, &reading, &SENSORS, 46.0, false);
        filter.clone_pose(0);
        let place = Vector3::new(0.3, -0.2, 0.1);
        for _ in 0..10 {
            filter.predict_free(0.066);
            filter.update_attitude(&reading, &SENSORS);
            let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
            assert!(
                filter
                    .update_sightings(
                        0,
                        [&camera(), &camera()],
                        &mut seen,
                        50,
                        sightings::MAX_TOUCHED_CELLS,
                        &mut unlimited()
                    )
                    .unwrap()
                    .is_applied
            );
        }
        let (found, covariance) = filter.displacement(0).unwrap();
        let error = (found - place).xy();
        let covariance = covariance.fixed_view::<2, 2>(0, 0).into_owned();
        sum += error.dot(&(covariance.try_inverse().unwrap() * error));
        assert!(error.norm() < 0.15, "{error}");
    }
    let nees = sum / runs as f64;
    assert!((0.01..4.0).contains(&nees), "{nees}");
}

/// What a helicopter cannot do in a fifteenth of a second is not accepted, and coasting widens what is.
#[test]
fn an_impossible_jump_is_refused_and_coasting_grows_the_covariance() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut filter = started();
    for _ in 0..15 {
        filter.predict(hovering(0.065), &SENSORS);
        let mut seen = sightings(&filter, Vector3::zeros(), CameraErrors::default(), &mut rng);
        assert!(
            filter
                .update_sightings(
                    0,
                    [&camera(), &camera()],
                    &mut seen,
                    50,
                    sightings::MAX_TOUCHED_CELLS,
                    &mut unlimited()
                )
                .unwrap()
                .is_applied
        );
    }
    let sigma = |filter: &Filter| filter.displacement(0).unwrap().1[(0, 0)].sqrt();
    let before = (filter.pose, sigma(&filter));
    let mut seen = sightings(&filter, Vector3::new(1.0, 0.0, 0.0), CameraErrors::default(), &mut rng);
    let jump = filter
        .update_sightings(0, [&camera(), &camera()], &mut seen, 8, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
        .unwrap();
    assert!(!jump.is_applied && filter.pose == before.0, "{jump:?}");
    filter.predict(hovering(2.0), &SENSORS);
    assert!(sigma(&filter) > 2.0 * before.1, "{} {}", sigma(&filter), before.1);
}

/// With considered heights, frames from one place 2 m aside never bring the error below that of the heights.
#[test]
fn heights_do_not_average_out() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut filter = started();
    let place = Vector3::new(2.0, 0.0, 0.0);
    let mut sigmas = Vec::new();
    for _ in 0..60 {
        filter.predict_free(0.066);
        filter.update_attitude(&Attitude::default(), &SENSORS);
        let mut seen = sightings(&filter, place, CameraErrors::default(), &mut rng);
        filter
            .update_sightings(0, [&camera(), &camera()], &mut seen, 8, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
            .unwrap();
        sigmas.push(filter.displacement(0).unwrap().1[(0, 0)].sqrt());
    }
    // 10 m in each of about 48 cells, at 2 m from 50 m.
    let of_heights = 2.0 / 50.0 * MAX_HEIGHT_SIGMA_M / 48f64.sqrt();
    assert!(sigmas[59] > 0.5 * of_heights && filter.is_sound(), "{} {of_heights}", sigmas[59]);
}

/// Flies a hover in which the force that the accelerometers read steps by `bias` (m/s^2) after 2 s. Returns for each
/// frame the error (m), its standard error along the worse axis, and the factor of the standard error.
fn flown_with_a_bias_step(bias: Vector3<f64>, seconds: f64) -> Vec<[f64; 3]> {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut filter = started();
    let frames = (seconds * 15.0) as usize;
    (0..frames)
        .map(|frame| {
            let wrong = if frame < 30 { Vector3::zeros() } else { bias };
            let steps = hovering(0.065).map(|step| Step { force: step.force + wrong, ..step });
            filter.predict(steps, &SENSORS);
            filter.update_attitude(&Attitude::default(), &SENSORS);
            let mut seen = sightings(&filter, Vector3::zeros(), CameraErrors::default(), &mut rng);
            filter
                .update_sightings(
                    0,
                    [&camera(), &camera()],
                    &mut seen,
                    50,
                    sightings::MAX_TOUCHED_CELLS,
                    &mut unlimited(),
                )
                .unwrap();
            let (moved, covariance) = filter.displacement(0).unwrap();
            let variance = covariance[(0, 0)].max(covariance[(1, 1)]);
            [moved.xy().norm(), variance.sqrt(), filter.inconsistency().of_bound]
        })
        .collect()
}

/// The mean motion of a picture is that of points all over it, which the projection moves.
#[test]
fn a_change_of_the_pose_moves_the_picture() {
    let filter = started();
    let (camera, state) = (camera(), level_pair(&filter, Vector3::zeros()));
    let last = camera.last_pixel();
    let points: Vec<Vector2<f64>> = (0..24 * 18)
        .map(|i| Vector2::new(f64::from(i % 24) + 0.5, f64::from(i / 24) + 0.5))
        .map(|at| Vector2::new(at.x * last.x / 24.0, at.y * last.y / 18.0))
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    for _ in 0..20 {
        let mut draw = |size: f64| Vector3::from_fn(|_, _| size * (2.0 * rng.random::<f64>() - 1.0));
        let (moved, turned) = (draw(0.05), draw(0.001));
        let mut other = level_pair(&filter, moved);
        other.now.pose.rotation = exponential(&turned);
        let image = |state: &PairState, at: &Vector2<f64>| state.project([&camera, &camera], at).unwrap().image;
        // The mean shift, and the turn of the points about the middle.
        let (mut shift, mut turn, mut squares) = (Vector2::zeros(), 0.0, 0.0);
        for at in &points {
            let moved = image(&other, at) - image(&state, at);
            let from_middle = at - last / 2.0;
            shift += moved / points.len() as f64;
            turn += from_middle.perp(&moved);
            squares += from_middle.norm_squared();
        }
        let change = Vector6::new(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z);
        let motion = sightings::picture_motion(50.0, &camera) * change;
        // A picture moves against the camera.
        let found = -Vector3::new(shift.x * 50.0 / camera.focal(), shift.y * 50.0 / camera.focal(), turn / squares);
        assert!((motion - found).abs().max() < 1e-4 + 0.001 * motion.norm(), "{motion} {found}");
    }
}

/// Returns the largest factor of the walk and the largest NIS in a hover. From frame 30 on rates are off by `bias`
/// (rad/s), and the perspective of the pictures is off by that of a tilt of `tilt` (rad) to either side, which does not
/// move them.
fn walked(bias: f64, tilt: f64) -> (f64, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let mut filter = started();
    let mut largest = (0.0f64, 0.0f64);
    for frame in 0..60 {
        let share = if frame < 30 { 0.0 } else { 1.0 };
        let steps = hovering(0.065).map(|step| Step { rates: Vector3::repeat(share * bias), ..step });
        filter.predict(steps, &SENSORS);
        filter.update_attitude(&Attitude::default(), &SENSORS);
        let tilt = share * tilt * if frame / 5 % 2 == 0 { 1.0 } else { -1.0 };
        let lever = -sightings::picture_motion(50.0, &camera())[(1, 3)];
        let mut state = level_pair(&filter, Vector3::new(0.0, lever * tilt, 0.0));
        state.now.pose.rotation = exponential(&Vector3::new(tilt, 0.0, 0.0));
        let mut seen = seen(&PairState { errors: CameraErrors::default(), ..state }, &mut rng);
        let cameras = [&camera(), &camera()];
        filter.update_sightings(0, cameras, &mut seen, 50, sightings::MAX_TOUCHED_CELLS, &mut unlimited()).unwrap();
        largest = (largest.0.max(filter.walk_factor()), largest.1.max(filter.nis[0]));
    }
    largest
}

/// A bias of the gyroscopes moves the picture; a wrong perspective does not, and is no reason to let biases walk.
#[test]
fn biases_walk_if_the_picture_moves_against_the_prediction() {
    let (usual, _) = walked(0.0, 0.0);
    let (after_a_step, _) = walked(1e-3, 0.0);
    let (with_perspective, nis) = walked(0.0, 2e-3);
    assert_eq!(usual, 1.0);
    assert!(after_a_step > 100.0, "{after_a_step}");
    assert!(nis > 1.2 * CONSISTENT_NIS, "{nis}");
    assert_eq!(with_perspective, 1.0);
}

/// A smaller step is followed. Without the factor the error after a larger one exceeds the protection level of 4.8
/// standard errors.
#[test]
fn a_step_of_the_bias_raises_the_protection_level() {
    let small = flown_with_a_bias_step(Vector3::new(0.4, -0.3, 0.2), 5.0);
    let largest = small.iter().map(|[error, ..]| *error).fold(0.0, f64::max);
    assert!(largest < 0.2, "{largest} m");
    for metres in [0.8, 1.5, 3.0] {
        let rows = flown_with_a_bias_step(Vector3::new(metres, -0.75 * metres, 0.5 * metres), 5.0);
        let largest = |raised: bool| {
            let ratios = rows.iter().map(|[error, sigma, factor]| error / sigma / if raised { *factor } else { 1.0 });
            ratios.fold(0.0, f64::max)
        };
        let before = rows[..30].iter().map(|[.., factor]| *factor).fold(0.0, f64::max);
        assert!(before < 2.0, "{before} before the step");
        assert!(largest(false) > 6.0, "{metres} m/s^2: {}", largest(false));
        assert!(largest(true) < 4.0, "{metres} m/s^2: {}", largest(true));
    }
}

/// Sightings of a hover whose pixels within each quarter of the picture's columns are off by `common_px` together, in
/// turn to either side: roofs that all rise above the mean ground leave such residuals.
fn factors_with_common_residuals(common_px: f64) -> Inconsistency {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut filter = started();
    for _ in 0..45 {
        filter.predict(hovering(0.065), &SENSORS);
        filter.update_attitude(&Attitude::default(), &SENSORS);
        let mut seen = sightings(&filter, Vector3::zeros(), CameraErrors::default(), &mut rng);
        for sighting in &mut seen {
            let side = if ((sighting.reference.x / 256.0) as u32).is_multiple_of(2) { 1.0 } else { -1.0 };
            sighting.current.y += side * common_px;
            // What a keyframe has learnt of such landmarks.
            sighting.covariance += Matrix2::identity() * (3.0 * common_px * common_px);
        }
        filter
            .update_sightings(0, [&camera(), &camera()], &mut seen, 50, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
            .unwrap();
    }
    filter.inconsistency()
}

#[test]
fn residuals_that_a_block_has_in_common_raise_the_protection_level() {
    let factors = [0.0, 0.03, 0.3, 1.0].map(factors_with_common_residuals);
    let bounds = factors.map(|factors| factors.of_bound);
    assert!(bounds[0] < 1.1 && bounds[1] < 1.5, "{factors:?}");
    assert!(bounds[2] > 2.0 && bounds[3] > 1.5 * bounds[2], "{factors:?}");
    // The covariance is that of errors on the mean.
    for Inconsistency { of_bound, of_mean } in factors {
        assert!((of_mean * of_mean - of_bound).abs() < 1e-9, "{factors:?}");
    }
}

/// Returns patches of points whose ground has the height `height` (m) of each, with noise of 0.02 px.
fn patches(
    filter: &Filter,
    moved: Vector3<f64>,
    rng: &mut ChaCha8Rng,
    height: impl Fn(usize, &mut ChaCha8Rng) -> f64,
) -> Vec<Sighting> {
    let (camera, state) = (camera(), level_pair(filter, moved));
    let mut found = sightings(filter, moved, CameraErrors::default(), rng);
    found.truncate(80);
    for patch in &mut found {
        let seen = state.project([&camera, &camera], &patch.reference).unwrap();
        let noise = 0.02 * Vector2::new(normal(rng), normal(rng));
        patch.current = seen.image + seen.by_height * height(patch.landmark, rng) + noise;
        (patch.covariance, patch.is_refined) = (Matrix2::identity() * 0.0004, true);
    }
    found
}

/// Returns a filter with a calibrated camera.
fn calibrated() -> Filter {
    let mut filter = started();
    let mut calibration = Calibration::default();
    (calibration.k1.sigma, calibration.readout_s.sigma, calibration.focal.sigma) = (1e-3, 1e-4, 1e-3);
    filter.calibrate(&calibration);
    filter
}

/// Fits a frame without samples of the IMU to patches alone, and returns error and standard error along `X_e`, m.
fn fit_alone(filter: &mut Filter, moved: Vector3<f64>, mut seen: Vec<Sighting>) -> (f64, f64) {
    let fitted = filter
        .update_sightings(0, [&camera(), &camera()], &mut seen, 30, sightings::MAX_TOUCHED_CELLS, &mut unlimited())
        .unwrap();
    assert!(fitted.is_applied, "{fitted:?}");
    let (found, covariance) = filter.displacement(0).unwrap();
    (found.x - moved.x, covariance[(0, 0)].sqrt())
}

/// Frames that are fitted to patches alone leave keyframe and camera as they were, so that a hundred of them are worth
/// no more than one.
#[test]
fn patches_alone_are_fitted_without_memory() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut filter = calibrated();
    let moved = Vector3::new(1.5, -0.7, 0.3);
    let kept = |filter: &Filter| {
        let states = (GYRO_BIAS..WANDER).chain(CAMERA..filter.active());
        states.map(|i| filter.at(i, i)).collect::<Vec<_>>()
    };
    let mut first = None;
    for _ in 0..100 {
        filter.predict_free(0.066);
        filter.update_attitude(&Attitude::default(), &SENSORS);
        let (before, pose) = (kept(&filter), filter.keyframe(0).unwrap());
        let seen = patches(&filter, moved, &mut rng, |_, _| 0.0);
        let (error, sigma) = fit_alone(&mut filter, moved, seen);
        assert!(error.abs() < 0.02 && error.abs() < 4.0 * sigma, "{error} {sigma}");
        assert_eq!((kept(&filter), filter.keyframe(0).unwrap()), (before, pose));
        assert!(sigma > 0.7 * *first.get_or_insert(sigma), "{sigma} {first:?}");
    }
}

/// The residuals decide how rough the ground is, and a row of roofs is left out.
#[test]
fn patches_alone_tell_even_ground_from_rough() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let moved = Vector3::new(2.0, 1.0, 0.2);
    let mut relief_of = |height: &dyn Fn(usize, &mut ChaCha8Rng) -> f64| {
        let mut filter = calibrated();
        filter.predict_free(0.066);
        filter.common = 0.01;
        let seen = patches(&filter, moved, &mut rng, height);
        let (error, sigma) = fit_alone(&mut filter, moved, seen);
        let relief = (filter.height_variance() + filter.roughness()).sqrt();
        // Over rough ground the relief is that of the residuals, with what they have in common.
        assert_eq!(filter.common == 0.0, relief > 0.5, "{relief}");
        (relief, error.abs() / sigma, error.abs(), filter.excess)
    };
    let (relief, ratio, _, excess) = relief_of(&|_, _| 0.0);
    assert!((relief - 50.0 * EVEN_HEIGHT_SIGMA).abs() < 1e-9 && ratio < 4.0 && excess < 2.0, "{relief} {ratio}");
    let (relief, ratio, error, _) = relief_of(&|_, rng| 1.2 * normal(rng));
    assert!((0.8..1.8).contains(&relief) && ratio < 4.0 && error < 0.2, "{relief} {ratio} {error}");
    let (relief, _, error, excess) = relief_of(&|landmark, _| if landmark < 20 { -9.0 } else { 0.0 });
    assert!(relief < 0.1 && error < 0.02 && excess > 5.0, "{relief} {error} {excess}");
}

/// A calibration is the prior of the errors of the camera.
#[test]
fn a_calibration_sets_the_errors_of_the_camera() {
    let mut filter = started();
    let mut calibration = Calibration::default();
    (calibration.k1.value, calibration.k1.sigma) = (-0.03, 0.001);
    assert!(!filter.is_calibrated());
    filter.calibrate(&calibration);
    assert!(!filter.is_calibrated(), "the read-out time is not known");
    calibration.readout_s.sigma = 1e-4;
    filter.calibrate(&calibration);
    assert!(filter.is_calibrated());
    assert_eq!((filter.errors.distortion, filter.at(CAMERA, CAMERA)), (-0.03, 0.001 * 0.001));
    assert!((0..STATES).all(|i| i == CAMERA || filter.at(i, CAMERA) == 0.0 && filter.at(CAMERA, i) == 0.0));
    filter.errors.distortion = f64::NAN;
    filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, true);
    assert_eq!((filter.errors.distortion, filter.at(CAMERA, CAMERA)), (-0.03, 0.001 * 0.001));
}

/// Biases that a calibration knows are taken off the samples of the IMU, whatever the bore-sight.
#[test]
fn a_calibration_sets_the_biases_of_the_inertial_sensor() {
    let mut filter = started();
    let mut calibration = Calibration::default();
    calibration.boresight_deg.value = [3.0, -2.0, 40.0];
    (calibration.gyro_bias_deg_per_s.value, calibration.gyro_bias_deg_per_s.sigma) = ([0.2, -0.1, 0.3], 0.01);
    (calibration.force_bias_m_per_s2.value, calibration.force_bias_m_per_s2.sigma) = ([0.1, 0.2, -0.3], 0.02);
    filter.calibrate(&calibration);
    filter.restart(50.0, &Attitude::default(), &SENSORS, 46.0, false);
    assert!((filter.at(GYRO_BIAS, GYRO_BIAS).sqrt() - 0.01f64.to_radians()).abs() < 1e-12);
    assert!((filter.at(FORCE_BIAS, FORCE_BIAS).sqrt() - 0.02).abs() < 1e-12);
    let boresight = calibration.boresight().unwrap();
    let rates = Vector3::new(0.2, -0.1, 0.3).map(f64::to_radians);
    let force = boresight * Vector3::new(0.0, 0.0, -GRAVITY) + Vector3::new(0.1, 0.2, -0.3);
    filter.predict(std::iter::repeat_n(Step { rates, force, seconds: 0.005 }, 200), &SENSORS);
    let turned = logarithm(&filter.pose.rotation).norm();
    assert!(turned < 1e-9 && filter.velocity.norm() < 1e-9, "{turned} {}", filter.velocity);
}

/// Of more sightings than the work units pay for as many are fitted as they do.
#[test]
fn sightings_beyond_the_work_units_are_thinned() {
    let filter = started();
    let cells = filter.expected_cells();
    let units = filter.work(150, cells, false);
    assert_eq!(filter.thinning(400, units as u64, false), (150, cells));
    assert_eq!(filter.thinning(400, units as u64, true).0, 400);
    assert_eq!(filter.thinning(100, filter.work(400, sightings::MAX_TOUCHED_CELLS, false) as u64, false).0, 100);
    assert_eq!((filter.thinning(400, 0, false).0, filter.thinning(0, 0, false).0), (1, 0));
}
