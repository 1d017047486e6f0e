use super::*;
use crate::motion::orthophoto::{Attitude, Camera};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const SENSORS: SensorErrors = SensorErrors { tilt: 0.2 * DEGREE, heading: 0.5 * DEGREE, range: 0.2 };

/// Two frames of a simulated flight: the readings of both poses, the pairs, and the true motion.
pub(super) struct Flight {
    pub(super) views: [View; 2],
    pairs: Vec<Pair>,
    displacement: Vector2<f64>,
    descent: f64,
    attitude: Attitude,
}

/// Returns a deviate of variance 1, the sum of twelve uniform numbers.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// Distance of a hill from the next hollow over `pi`, m: two of them fit into 93 m, the width of a frame of 50 degrees
/// at 100 m.
const RELIEF_SCALE_M: f64 = 15.0;

/// The parameters of simulated flights.
pub(super) struct Conditions {
    /// Degrees over 1024 columns.
    field_of_view: f64,
    /// Height of the hills and depth of the hollows between them, m.
    relief: f64,
    /// Rise of the ground along `X_e`.
    slope: f64,
    /// Height of houses, m; every fifth pair and the laser of CUR hit one.
    houses: f64,
    /// Noise of positions, px per axis.
    pixel: f64,
    /// Noise of the sensors, in units of their standard errors.
    sensors: f64,
}

/// Simulates two frames from 100 m with up to 5 degrees of tilt and 2 m of descent. Between the frames the camera tilts
/// by up to a twentieth of the field of view and drifts by as much again, so that they overlap. The geometry is by
/// rays, without a homography.
pub(super) fn flight(seed: u64, conditions: &Conditions) -> Flight {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut within = |most: f64| most * (2.0 * rng.random::<f64>() - 1.0);
    let field_of_view = conditions.field_of_view * DEGREE;
    let camera = Camera::with_field_of_view(1024, 768, field_of_view).unwrap();
    let first = Attitude { roll: within(5.0 * DEGREE), pitch: within(5.0 * DEGREE), yaw: within(0.1) };
    let apart = field_of_view / 20.0;
    let second =
        Attitude { roll: first.roll + within(apart), pitch: first.pitch + within(apart), yaw: first.yaw + within(0.1) };
    let attitudes = [first, second];
    let displacement = Vector2::new(within(100.0 * apart), within(100.0 * apart));
    let descent = within(2.0);
    let heights = [100.0, 100.0 - descent];
    let positions = [Vector2::zeros(), displacement];
    let crest = Vector2::new(within(3.0), within(3.0));
    let mut pairs = Vec::new();
    let rotation = attitudes.map(|attitude| attitude.rotation());
    while pairs.len() < 300 {
        let pixel = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
        let ray = rotation[0] * (camera.inverse() * pixel.push(1.0));
        let flat = ray.xy() * (heights[0] / ray.z) / RELIEF_SCALE_M + crest;
        let house = if pairs.len() % 5 == 0 { conditions.houses } else { 0.0 };
        let level = heights[0] + conditions.relief * flat.x.sin() * flat.y.sin() - house;
        let depth = level / (1.0 + conditions.slope * ray.x / ray.z);
        let point = ray.xy() * (depth / ray.z);
        let seen = rotation[1].transpose() * (point - positions[1]).push(depth - descent);
        let image = (camera.matrix() * seen / seen.z).xy();
        if (0.0..1024.0).contains(&image.x) && (0.0..768.0).contains(&image.y) {
            let mut noisy = |p: Vector2<f64>| p + conditions.pixel * Vector2::new(normal(&mut rng), normal(&mut rng));
            pairs.push(Pair { reference: noisy(pixel), current: noisy(image) });
        }
    }
    let views = [0, 1].map(|i| {
        let mut error = |sigma: f64| conditions.sensors * sigma * normal(&mut rng);
        let reading = Attitude {
            roll: attitudes[i].roll + error(SENSORS.tilt),
            pitch: attitudes[i].pitch + error(SENSORS.tilt),
            yaw: attitudes[i].yaw + error(SENSORS.heading),
        };
        let axis = rotation[i].column(2);
        let house = conditions.houses * i as f64;
        let met = (heights[i] - conditions.slope * positions[i].x - house) / (axis.z + conditions.slope * axis.x);
        let range = met + error(SENSORS.range);
        View::new(camera, reading, range).unwrap()
    });
    Flight { views, pairs, displacement, descent, attitude: attitudes[1] }
}

fn fitted(flight: &Flight) -> Result<Pose, PoseError> {
    fit(&flight.views[0], &flight.views[1], &SENSORS, &flight.pairs, 255)
}

/// Returns the mean length of the error of the displacement (m) with IMU and laser alone and with the fit, and the mean
/// squared error over its covariance, which is 2 if the covariance is correct.
fn errors(conditions: &Conditions) -> [f64; 3] {
    let flights = 200;
    let mut sums = Vector3::zeros();
    for seed in 0..flights {
        let flight = flight(seed, conditions);
        let pose = fitted(&flight).unwrap();
        let rectified = rectified_displacement(&flight.views[0], &flight.views[1], &flight.pairs).unwrap();
        let error = pose.displacement - flight.displacement;
        let normalised = error.dot(&(pose.covariance.try_inverse().unwrap() * error));
        sums += Vector3::new((rectified - flight.displacement).norm(), error.norm(), normalised);
    }
    (sums / flights as f64).into()
}

pub(super) const WIDE: Conditions =
    Conditions { field_of_view: 50.0, relief: 0.0, slope: 0.0, houses: 0.0, pixel: 0.3, sensors: 1.0 };

/// 0.2 degrees at 100 m are 0.35 m per axis and frame, 0.49 m per axis for two frames; the mean length of that is
/// sqrt(pi / 2) 0.49 m = 0.62 m, and the laser adds little. The bounds for the fit to 300 pairs of 0.3 px are measured.
#[test]
fn the_fit_is_more_accurate_than_imu_and_laser_alone() {
    let cases = [
        ("wide, flat", WIDE, 0.06),
        ("10 degrees, flat", Conditions { field_of_view: 10.0, ..WIDE }, 0.20),
        ("wide, hills of 3 m", Conditions { relief: 3.0, ..WIDE }, 0.30),
    ];
    for (name, conditions, max_error) in cases {
        let [alone, fit, normalised] = errors(&conditions);
        let summary = format!("{name}: {alone:.3} m alone, {fit:.3} m with the fit, normalised {normalised:.2}");
        eprintln!("{summary}");
        assert!((0.55..0.72).contains(&alone) && fit < max_error, "{summary}");
        // Chi squared of 2, whose mean over 200 flights is known to 0.14; four times that is allowed.
        assert!(conditions.relief > 0.0 || (1.44..2.56).contains(&normalised), "{summary}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn without_noise_the_pose_is_exact(seed in any::<u64>(), field_of_view in 5.0..60.0f64) {
        let flight = flight(seed, &Conditions { field_of_view, pixel: 0.0, sensors: 0.0, ..WIDE });
        let pose = fitted(&flight).unwrap();
        prop_assert!((pose.displacement - flight.displacement).norm() < 1e-6, "{pose:?}");
        prop_assert!((pose.descent - flight.descent).abs() < 1e-6);
        let turn = pose.current.attitude.rotation() - flight.attitude.rotation();
        prop_assert!(turn.abs().max() < 1e-7, "{turn}");
    }
}

/// Returns the root mean square error (m) with a measured terrain prior, as a flight program has after a few frames,
/// and with the prior of a single reading.
fn with_terrain(conditions: &Conditions) -> [f64; 2] {
    let flights = 100;
    let rms = |known: bool| {
        let errors = (0..flights).map(|seed| {
            let flight = flight(seed, conditions);
            let [reference, mut current] = flight.views.map(|view| Observation { view, errors: SENSORS.into() });
            current.errors.relief_height = current.errors.relief_height.max(conditions.houses / 2.0);
            let covariance = Matrix3::from_diagonal(&Vector3::new(0.04, 1e-4, 1e-4));
            let all = TerrainPrior {
                height: 100.0,
                slope: Vector2::new(conditions.slope, 0.0),
                covariance,
                slope_is_measured: true,
            };
            let terrain = if known { all } else { TerrainPrior::of(&reference) };
            let (mut buffers, mut budget) = (PoseBuffers::with_capacity(300), Budget::UNLIMITED);
            let consensus = ConsensusPairs { pairs: &flight.pairs, off_plane: 0, quality: 255 };
            let pose = fit_in(&mut buffers, &mut budget, &reference, &terrain, &current, consensus);
            (pose.unwrap().displacement - flight.displacement).norm_squared()
        });
        (errors.sum::<f64>() / flights as f64).sqrt()
    };
    [true, false].map(rms)
}

/// Roofs 12 m high, and a laser that hits one, cost little more than the pairs on them.
#[test]
fn houses_do_not_tilt_the_ground() {
    let [flat, _] = with_terrain(&WIDE);
    let [town, _] = with_terrain(&Conditions { houses: 12.0, ..WIDE });
    assert!(town < 1.3 * flat, "{town:.3} m, {flat:.3} m without houses");
}

/// A roof 12 m high in a corner of the frame, seen 8 cm beside the reference: its parallax is two standard deviations
/// of the noise. Treated as ground it tilts the plane. From a metre beside, the fit reports it as off the plane.
#[test]
fn a_known_roof_does_not_tilt_the_ground() {
    let camera = Camera::with_field_of_view(1024, 768, 50.0 * DEGREE).unwrap();
    let observation = |range: f64| {
        let view = View::new(camera, Attitude::default(), range).unwrap();
        Observation { view, errors: SENSORS.into() }
    };
    let terrain = TerrainPrior { slope_is_measured: true, ..TerrainPrior::of(&observation(50.0)) };
    let (mut buffers, mut budget) = (PoseBuffers::with_capacity(330), Budget::UNLIMITED);
    let mut fitted = |beside: f64, off_plane: usize, seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut pair = |x: f64, y: f64, depth: f64| {
            let mut noise = || 0.15 * Vector2::new(normal(&mut rng), normal(&mut rng));
            let moved = Vector2::new(beside * camera.focal() / depth, 0.0);
            Pair { reference: Vector2::new(x, y) + noise(), current: Vector2::new(x, y) - moved + noise() }
        };
        let ground: Vec<Pair> =
            (0..300).map(|i| pair(20.0 * f64::from(i % 25), 60.0 * f64::from(i / 25), 50.0)).collect();
        let roof = (0..30).map(|i| pair(900.0 + 10.0 * f64::from(i % 10), 40.0 * f64::from(i / 10), 38.0));
        let pairs: Vec<Pair> = ground.into_iter().chain(roof).collect();
        let consensus = ConsensusPairs { pairs: &pairs, off_plane, quality: 255 };
        let pose =
            fit_in(&mut buffers, &mut budget, &observation(50.0), &terrain, &observation(50.0), consensus).unwrap();
        (pose.displacement.x - beside, buffers.off_plane().to_vec())
    };
    let mut rms = |off_plane: usize| {
        let errors = (0..40).map(|seed| fitted(0.08, off_plane, seed).0.powi(2));
        (errors.sum::<f64>() / 40.0).sqrt()
    };
    let (unknown, known) = (rms(0), rms(30));
    assert!(known < 0.6 * unknown, "{known:.3} m, {unknown:.3} m if the roof is not known");
    let (_, off) = fitted(1.0, 0, 0);
    let count = |off: &[bool]| off.iter().filter(|off| **off).count();
    assert_eq!((off.len(), count(&off[300..])), (330, 30));
    assert!(count(&off[..300]) <= 3, "{off:?}");
}

/// A descent over a slope looks like a motion along it, unless the slope is known.
#[test]
fn a_known_slope_is_not_mistaken_for_motion() {
    let [flat, _] = with_terrain(&WIDE);
    let [known, unknown] = with_terrain(&Conditions { slope: 0.2, ..WIDE });
    assert!(known < 1.3 * flat && unknown > 1.5 * known, "{known:.3} m, {unknown:.3} m unknown, {flat:.3} m flat");
}

#[test]
fn contradicting_or_weak_input_gives_no_estimate() {
    let good = flight(1, &WIDE);
    let [reference, current] = good.views;
    let with = |pairs: &[Pair], sensors: &SensorErrors| fit(&reference, &current, sensors, pairs, 255);
    assert_eq!(with(&good.pairs[..4], &SENSORS), Err(PoseError::TooFewPairs(4)));
    assert_eq!(with(&good.pairs, &SensorErrors { tilt: 0.0, ..SENSORS }), Err(PoseError::InvalidStandardErrors));
    // Pictures that imply 3 degrees more roll than an IMU of 0.2 degrees reads.
    let tilted = Attitude { roll: current.attitude().roll + 3.0 * DEGREE, ..*current.attitude() };
    let wrong = View::new(*current.camera(), tilted, current.height()).unwrap();
    let outcome = fit(&reference, &wrong, &SENSORS, &good.pairs, 255);
    assert!(matches!(outcome, Err(PoseError::Disagreement { .. })), "{outcome:?}");
    // And 30 degrees more yaw, most of which the fit attributes to noise.
    let turned = Attitude { yaw: current.attitude().yaw + 30.0 * DEGREE, ..*current.attitude() };
    let wrong = View::new(*current.camera(), turned, current.height()).unwrap();
    let outcome = fit(&reference, &wrong, &SENSORS, &good.pairs, 255);
    let refused = matches!(outcome, Err(PoseError::Disagreement { .. } | PoseError::Unexplained { .. }));
    assert!(refused, "{outcome:?}");
    // Five pairs in a corner, 0.7 px off to either side, and an IMU of 3 degrees: 100 m tan 3 degrees is 5 m.
    let aside = [0.7, -0.7, 0.7, -0.7, 0.7].map(|x| Vector2::new(x, 0.0));
    let corner: Vec<Pair> = good
        .pairs
        .iter()
        .filter(|pair| pair.reference.x < 300.0 && pair.reference.y < 300.0)
        .zip(aside)
        .map(|(pair, aside)| Pair { current: pair.current + aside, ..*pair })
        .collect();
    let outcome = with(&corner, &SensorErrors { tilt: 3.0 * DEGREE, ..SENSORS });
    assert!(matches!(outcome, Err(PoseError::Uncertain { sigma }) if sigma > 1.0), "{outcome:?}");
    // The quality of the match is never exceeded.
    assert_eq!(fit(&reference, &current, &SENSORS, &good.pairs, 17).unwrap().quality, 17);
    let pose = with(&good.pairs, &SENSORS).unwrap();
    assert!(pose.quality > 230, "{pose:?}");
}

/// Simulates two frames over hills of 3 m rms and 120 m length, which the laser hits, from 50 m: the frame is smaller
/// than a hill. Displacements are up to `reach` m, tilts up to 3 degrees; readings have their errors, pairs a noise of
/// 0.15 px.
fn hover_over_hills(seed: u64, reach: f64) -> Flight {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut within = |most: f64| most * (2.0 * rng.random::<f64>() - 1.0);
    let camera = Camera::with_field_of_view(1024, 768, 50.0 * DEGREE).unwrap();
    let waves: [(f64, f64, f64, f64); 8] = std::array::from_fn(|i| {
        let turn = within(std::f64::consts::PI);
        let k = std::f64::consts::TAU / 120.0 * if i < 4 { 1.0 } else { 2.0 };
        let amplitude = 3.0 * (2.0f64 / 4.0).sqrt() * if i < 4 { 0.9 } else { 0.45 };
        (k * turn.cos(), k * turn.sin(), within(3.0), amplitude)
    });
    let ground = |p: Vector2<f64>| waves.iter().map(|(a, b, c, h)| h * (a * p.x + b * p.y + c).sin()).sum::<f64>();
    let mut tilts = || Attitude { roll: within(3.0 * DEGREE), pitch: within(3.0 * DEGREE), yaw: 0.2 + within(0.02) };
    let attitudes = [tilts(), tilts()];
    let displacement = Vector2::new(within(reach), within(reach));
    let positions = [Vector2::zeros(), displacement];
    let heights = [50.0, 50.0 + within(0.3)];
    let hit = |origin: Vector2<f64>, height: f64, ray: Vector3<f64>| {
        let mut depth = height - ground(origin);
        for _ in 0..60 {
            depth = height - ground(origin + ray.xy() / ray.z * depth);
        }
        (origin + ray.xy() / ray.z * depth, depth)
    };
    let rotation = attitudes.map(|attitude| attitude.rotation());
    let mut pairs = Vec::new();
    while pairs.len() < 500 {
        let pixel = Vector2::new(1024.0 * rng.random::<f64>(), 768.0 * rng.random::<f64>());
        let (point, _) = hit(positions[0], heights[0], rotation[0] * (camera.inverse() * pixel.push(1.0)));
        let seen = rotation[1].transpose() * (point - positions[1]).push(heights[1] - ground(point));
        let image = (camera.matrix() * seen / seen.z).xy();
        if (0.0..1024.0).contains(&image.x) && (0.0..768.0).contains(&image.y) {
            let mut noisy = |p: Vector2<f64>| p + 0.15 * Vector2::new(normal(&mut rng), normal(&mut rng));
            pairs.push(Pair { reference: noisy(pixel), current: noisy(image) });
        }
    }
    let views = [0, 1].map(|i| {
        let mut error = |sigma: f64| sigma * normal(&mut rng);
        let reading = Attitude {
            roll: attitudes[i].roll + error(SENSORS.tilt),
            pitch: attitudes[i].pitch + error(SENSORS.tilt),
            yaw: attitudes[i].yaw + error(SENSORS.heading),
        };
        let axis = rotation[i] * Vector3::z();
        let (_, depth) = hit(positions[i], heights[i], axis);
        View::new(camera, reading, depth / axis.z + error(0.1)).unwrap()
    });
    Flight { views, pairs, displacement, descent: heights[0] - heights[1], attitude: attitudes[1] }
}

/// The height is held to 0.3 m. With 3 m of climb the error is 0.27 m, and the computed standard error is a tenth of
/// it: hills as long as the frame look like perspective.
#[test]
fn a_hover_over_hills_is_known_to_centimetres() {
    for (reach, max_rms) in [(0.1, 0.04), (0.4, 0.08)] {
        let flights = 40;
        let errors = (0..flights).map(|seed| {
            let flight = hover_over_hills(seed, reach);
            let sensors = SensorErrors { range: 0.1, ..SENSORS };
            let pose = fit(&flight.views[0], &flight.views[1], &sensors, &flight.pairs, 255).unwrap();
            (pose.displacement - flight.displacement).norm_squared()
        });
        let rms = (errors.sum::<f64>() / flights as f64).sqrt();
        assert!(rms < max_rms, "within {reach} m: {rms:.3} m");
    }
}
