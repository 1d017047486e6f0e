//! Matches that agree and are wrong are rejected: repeating ground, the pattern of the sensor, waves. Simulated,
//! seeded.

#[path = "../examples/accuracy/scene.rs"]
#[allow(dead_code, reason = "the benchmark uses all of it")]
mod scene;

use hoverlock_pictures::Picture;
use hoverlock_pictures::conditions::Condition;
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::estimate::Estimate;
use hoverlock_reference::motion::estimator::Estimator;
use hoverlock_reference::motion::matching::{Gate, Matching};
use hoverlock_reference::motion::model::transfer;
use hoverlock_reference::motion::{pose, refine};
use nalgebra::{Matrix3, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use scene::{Flight, FlightRanges, HEIGHT, Relief, SENSORS, WIDTH, normal, render_with};

/// Radius of the gate about a predicted position, px.
const GATE_RADIUS_PX: f64 = 192.0;
const WIDE: FlightRanges =
    FlightRanges { field_of_view: 50.0, tilt: 5.0, tilt_between: 3.0, yaw: 3.0, drift: 4.0, climb: 1.0, relief: 0.0 };
const CLEAR: Condition = Condition { name: "clear", contrast: 1.0, blur: 0.0, gain_spread: 0.1, full_well: 20_000.0 };

fn size() -> Vector2<f64> {
    Vector2::new(WIDTH as f64 - 1.0, HEIGHT as f64 - 1.0)
}

/// Returns the random brightness of the ground at `p` (m), smooth between grid nodes `node` m apart, with a period of
/// `nodes` nodes.
fn ground(p: Vector2<f64>, node: f64, nodes: i64, seed: u64) -> f64 {
    let brightness = |x: i64, y: i64| {
        let (x, y) = (x.rem_euclid(nodes) as u64, y.rem_euclid(nodes) as u64);
        let mut bits = x.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (y + seed * 77_777).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        bits = (bits ^ (bits >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((bits >> 40) & 0xffff) as f64
    };
    let (u, v) = (p.x / node, p.y / node);
    let (i, j) = (u.floor(), v.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(u - i), ease(v - j));
    let (i, j) = (i as i64, j as i64);
    let upper = (1.0 - s) * brightness(i, j) + s * brightness(i + 1, j);
    let lower = (1.0 - s) * brightness(i, j + 1) + s * brightness(i + 1, j + 1);
    10_000.0 + 0.6 * ((1.0 - t) * upper + t * lower)
}

fn features(frame: &Plane<u16>) -> Vec<Feature> {
    FastExtractor::new(Selection::default()).unwrap().extract(frame)
}

/// Estimates the motion of two frames with all checks, from the features alone as the flight program does, or refined
/// on the frames. Returns the reason if there is no estimate.
fn estimate(flight: &Flight, frames: &[Plane<u16>; 2], gated: bool, refined: bool) -> Result<Estimate, String> {
    let [from, to] = [0, 1].map(|i| features(&frames[i]));
    let [reference, current] = &flight.views;
    let prediction = current.from_ground() * reference.to_ground();
    let gate = gated.then_some(Gate { prediction, radius: GATE_RADIUS_PX });
    let estimator = Estimator::default();
    let estimator = Estimator { matching: Matching { gate, ..estimator.matching }, ..estimator };
    let found = estimator.estimate(&from, &to).map_err(|error| error.to_string())?;
    let dist = estimator.ransac.max_squared_error;
    let found = if refined { refine::refined(found, &frames[0], &frames[1], dist) } else { found };
    let pairs: Vec<_> = found.inliers.iter().map(|&i| found.pairs[i]).collect();
    pose::fit(reference, current, &SENSORS, &pairs, found.quality).map_err(|error| error.to_string())?;
    Ok(found)
}

fn centre_error(h: &Matrix3<f64>, flight: &Flight) -> f64 {
    (transfer(h, size() / 2.0).unwrap() - flight.transfer(size() / 2.0)).norm()
}

/// Uses periods of 5.4 m and 18 m, that is 59 and 198 px: several within the gate, and at most one.
fn check_repeating_ground(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let nodes = if seed.is_multiple_of(2) { 18 } else { 60 };
        let flight = Flight::draw(&WIDE, seed);
        let frames = [0, 1].map(|i| {
            let frame = render_with(&flight.poses[i], &flight.relief, |p| ground(p, 0.3, nodes, seed));
            CLEAR.apply(&frame, 2 * seed + i as u64)
        });
        for gated in [false, true] {
            let outcome = estimate(&flight, &frames, gated, false).map(|e| centre_error(&e.homography, &flight));
            eprintln!("{seed} {nodes} {gated}: {outcome:?}");
            assert!(outcome.is_err(), "seed {seed}, {nodes} nodes, gated {gated}");
        }
    }
}

#[test]
fn repeating_ground_is_rejected_with_and_without_a_gate() {
    check_repeating_ground(0..4);
    // The same ground without a period within the frame is accepted.
    let flight = Flight::draw(&WIDE, 9);
    let frames = [0, 1]
        .map(|i| CLEAR.apply(&render_with(&flight.poses[i], &flight.relief, |p| ground(p, 0.3, 5000, 1)), i as u64));
    let found = estimate(&flight, &frames, false, true).unwrap();
    assert!(centre_error(&found.homography, &flight) < 0.1);
}

/// Simulates thick mist and a low-noise sensor whose pixel gains differ by 1 %, the same in both frames, while the
/// camera turns. The pattern agrees with itself better than by chance, so only IMU and laser can reject it.
fn check_sensor_pattern(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let pattern = Plane::from_fn(WIDTH, HEIGHT, |_, _| 1.0 + 0.01 * normal(&mut rng));
        let flight = Flight::draw(&WIDE, 100 + seed);
        let mist = Condition { contrast: 0.01, full_well: 200_000.0, ..CLEAR };
        let frames = [0, 1].map(|i| {
            let frame = render_with(&flight.poses[i], &flight.relief, |p| ground(p, 0.3, 5000, seed));
            let frame = mist.apply(&frame, 2 * seed + i as u64);
            frame.zip_map(&pattern, |&v, p| (f64::from(v) * p) as u16)
        });
        for (gated, refined) in [(false, false), (false, true), (true, false)] {
            let outcome = estimate(&flight, &frames, gated, refined).map(|e| centre_error(&e.homography, &flight));
            eprintln!("{seed} {gated} {refined}: {outcome:?}");
            let reason = outcome.err().unwrap_or_default();
            assert!(
                reason.contains("stay on their pixel") || gated && !reason.is_empty(),
                "seed {seed}, gated {gated}, refined {refined}: {reason}"
            );
        }
    }
}

#[test]
fn the_pattern_of_the_sensor_is_rejected() {
    check_sensor_pattern(0..3);
}

/// A sea: waves of 0.7 to 12 m length about one wind direction, each with its speed in deep water, `omega^2 = g k`.
struct Sea {
    /// Wave vector, phase, steepness.
    waves: Vec<(Vector2<f64>, f64, f64)>,
}

impl Sea {
    fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let wind = std::f64::consts::TAU * rng.random::<f64>();
        let waves = (0..24).map(|_| {
            let length = 0.7 * (12.0f64 / 0.7).powf(rng.random::<f64>());
            let (s, c) = (wind + 0.5 * normal(&mut rng)).sin_cos();
            (Vector2::new(c, s) * (std::f64::consts::TAU / length), std::f64::consts::TAU * rng.random::<f64>(), 1.0)
        });
        Self { waves: waves.collect() }
    }

    fn light(&self, p: Vector2<f64>, seconds: f64) -> f64 {
        let slope: f64 = self
            .waves
            .iter()
            .map(|(k, phase, steepness)| {
                let omega = (9.81 * k.norm()).sqrt();
                steepness * (k.dot(&p) - omega * seconds + phase).cos()
            })
            .sum();
        20_000.0 + 3000.0 * slope
    }
}

/// Simulates two frames of a sea, a second apart, with a field of view of 10 degrees.
fn check_waves(seeds: std::ops::Range<u64>) {
    let narrow = FlightRanges { field_of_view: 10.0, tilt_between: 0.3, yaw: 1.0, drift: 0.3, climb: 0.3, ..WIDE };
    for seed in seeds {
        let flight = Flight::draw(&narrow, 200 + seed);
        let sea = Sea::new(seed);
        let flat = Relief { amplitude: 0.0, phase: Vector2::zeros() };
        let frames = [0, 1].map(|i| {
            let frame = render_with(&flight.poses[i], &flat, |p| sea.light(p, i as f64));
            CLEAR.apply(&frame, 2 * seed + i as u64)
        });
        for (gated, refined) in [(false, false), (true, false), (false, true)] {
            let outcome = estimate(&flight, &frames, gated, refined).map(|e| centre_error(&e.homography, &flight));
            eprintln!("{seed} {gated} {refined}: {outcome:?}");
            assert!(outcome.is_err(), "seed {seed}, gated {gated}, refined {refined}");
        }
    }
}

#[test]
fn waves_are_rejected() {
    check_waves(0..2);
}

/// Checks 30 periodic grounds, 12 sensors and 20 seas.
#[test]
#[ignore = "minutes of rendering"]
fn all_seeds_are_rejected() {
    check_repeating_ground(0..30);
    check_sensor_pattern(0..12);
    check_waves(0..20);
}

/// Matches every ordered pair of different aerial textures.
#[test]
#[ignore = "a minute over all real pictures"]
fn unrelated_ground_is_rejected() {
    let Some(folder) = hoverlock_pictures::data_dir() else {
        eprintln!("SKIPPED: unrelated_ground_is_rejected: set HOVERLOCK_DATA to the picture folder");
        return;
    };
    let mut files: Vec<_> = std::fs::read_dir(folder.join("textures")).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "png"));
    files.sort();
    let seen: Vec<_> =
        files.iter().map(|path| features(&Picture::open(path).unwrap().crop(WIDTH, HEIGHT).luma)).collect();
    let mut rejected = 0;
    for (i, from) in seen.iter().enumerate() {
        for (j, to) in seen.iter().enumerate().filter(|(j, _)| *j != i) {
            let outcome = Estimator::default().estimate(from, to);
            assert!(outcome.is_err(), "{} and {}: {:?}", files[i].display(), files[j].display(), outcome);
            rejected += 1;
        }
    }
    eprintln!("{rejected} unrelated pairs rejected");
    assert!(rejected >= 200);
}
