//! Features of a synthetic flat ground, and the stream of a camera that moves over it. Displacements are known, and
//! thousands of frames take little time.

use super::Source;
use hoverlock_arm::message::{self, Command, InertialSample, Telemetry};
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_reference::features::feature::Descriptor;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Columns and rows of a frame, pixels.
pub const SIZE: (usize, usize) = (1024, 768);

/// Height of the camera over the ground, m.
const HEIGHT: f64 = 100.0;

/// Field of view across the columns, radians.
pub const FIELD_OF_VIEW: f64 = 0.87;

struct Point {
    x: f64,
    y: f64,
    scale: u8,
    bright: bool,
    response: u16,
    words: [u32; 4],
}

/// Returns a record whose parabolas have their vertex at `(x, y)` to 1/400 px, or `None` outside the frame.
fn record(point: &Point, x: f64, y: f64, rng: &mut impl Rng) -> Option<FeatureRecord> {
    let inside = x >= 18.0 && y >= 18.0 && x < SIZE.0 as f64 - 18.0 && y < SIZE.1 as f64 - 18.0;
    let (column, row) = (x.round(), y.round());
    let slope = |offset: f64| {
        let lift = (200.0 * offset).round() as i32;
        let beside = i32::from(point.response) - 100;
        [(beside - lift) as u16, (beside + lift) as u16]
    };
    let ([left, right], [up, down]) = (slope(x - column), slope(y - row));
    // Every bit flips with probability 1/16.
    let mut flips = || rng.random::<u32>() & rng.random::<u32>() & rng.random::<u32>() & rng.random::<u32>();
    let [a, b, c, d] = point.words.map(|word| word ^ flips());
    inside.then_some(FeatureRecord {
        x: column as u16,
        y: row as u16,
        response: point.response,
        scale: point.scale,
        bright: point.bright,
        neighbours: [left, right, up, down],
        descriptor: Descriptor::of_two([a, b], [c, d]),
    })
}

/// Returns the displacement of the camera from frame 0, m along `X_e` and `Y_e`.
pub fn displacement(frame: u32) -> (f64, f64) {
    let t = f64::from(frame);
    (0.5 * t, -0.3 * t)
}

/// Returns the telemetry of a frame.
pub fn telemetry(frame: u32) -> Telemetry {
    Telemetry {
        frame,
        // A second apart, so that the first frame after the reference confirms it.
        time_us: 1_000_000 * u64::from(frame),
        attitude: Attitude::default(),
        range: HEIGHT,
        field_of_view: FIELD_OF_VIEW,
        sensors: SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 },
    }
}

/// Returns the records of a frame over `points` ground points.
pub fn records(points: usize, frame: u32) -> Vec<FeatureRecord> {
    seen(points, 1.0, displacement(frame), FIELD_OF_VIEW, frame)
}

/// Returns the records at a place (m) with a field of view (radians). The `points` points cover `extent` times the
/// ground of the first frame, to the right and to the top; `noise` is the seed of the flipped bits.
pub fn seen(points: usize, extent: f64, place: (f64, f64), field_of_view: f64, noise: u32) -> Vec<FeatureRecord> {
    let (metre, zoom) = (focal(field_of_view) / HEIGHT, focal(field_of_view) / focal(FIELD_OF_VIEW));
    imaged(points, extent, noise, |point, _| {
        [(point.x, place.0, CENTRE[0]), (point.y, place.1, CENTRE[1])]
            .map(|(first, moved, centre)| centre + zoom * (first - centre) - metre * moved)
    })
}

/// Returns the records at a place (m) of a scene with a roof of height [`ROOF`] in the upper right corner of the first
/// frame and ground in its left half. Positions have errors of up to 0.2 px.
pub fn seen_beside_a_roof(points: usize, place: (f64, f64), noise: u32) -> Vec<FeatureRecord> {
    imaged(points, 1.0, noise, |point, noise| {
        let on_roof = point.x > 900.0 && point.y < 150.0;
        // The area between has no features, like a shadow.
        let beyond = if on_roof || point.x < CENTRE[0] { 0.0 } else { f64::INFINITY };
        let metre = focal(FIELD_OF_VIEW) / (HEIGHT - if on_roof { ROOF } else { 0.0 });
        [(point.x, place.0), (point.y, place.1)]
            .map(|(first, moved)| first - metre * moved + noise.random_range(-0.2..0.2) + beyond)
    })
}

/// Returns the records of a hover over a road at a time (s): two thirds of the `points` points are on cars in lanes of
/// 64 px, of which each has its speed, and a frame shows 45 % of the others. Positions have errors of up to 0.2 px.
pub fn seen_on_a_road(points: usize, seconds: f64, noise: u32) -> Vec<FeatureRecord> {
    imaged(points, 1.0, noise, |point, noise| {
        let mut error = || noise.random_range(-0.2..0.2);
        let (x, y) = (point.x + error(), point.y + error());
        if point.y % 96.0 < 64.0 {
            let lane = (point.y / 96.0).floor();
            let speed = (50.0 + 9.0 * lane) * if lane % 2.0 == 0.0 { 1.0 } else { -1.0 };
            return [(x + speed * seconds).rem_euclid(SIZE.0 as f64), y];
        }
        if noise.random::<f64>() < 0.45 { [x, y] } else { [f64::INFINITY; 2] }
    })
}

/// Returns the records of a hover over waves: a share of the `points` points stays, and the others are anywhere.
pub fn seen_over_waves(points: usize, share: f64, noise: u32) -> Vec<FeatureRecord> {
    imaged(points, 1.0, noise, |point, noise| {
        let stays = point.x < share * SIZE.0 as f64;
        let mut anywhere = |side: usize| noise.random_range(0.0..side as f64);
        let elsewhere = [anywhere(SIZE.0), anywhere(SIZE.1)];
        if stays { [point.x, point.y] } else { elsewhere }
    })
}

/// Height of the roof, m.
const ROOF: f64 = 24.0;

/// Centre of the frame, px.
const CENTRE: [f64; 2] = [(SIZE.0 as f64 - 1.0) / 2.0, (SIZE.1 as f64 - 1.0) / 2.0];

fn focal(field_of_view: f64) -> f64 {
    SIZE.0 as f64 / 2.0 / (field_of_view / 2.0).tan()
}

/// Returns the records of points; `image` returns the pixel of a point.
fn imaged(
    points: usize,
    extent: f64,
    noise: u32,
    image: impl Fn(&Point, &mut ChaCha8Rng) -> [f64; 2],
) -> Vec<FeatureRecord> {
    let mut ground = ChaCha8Rng::seed_from_u64(points as u64);
    let mut noise = ChaCha8Rng::seed_from_u64(u64::from(noise) + 1000);
    let mut records: Vec<_> = (0..points)
        .filter_map(|_| {
            let point = Point {
                x: SIZE.0 as f64 * extent * ground.random::<f64>(),
                y: SIZE.1 as f64 * (1.0 - extent * ground.random::<f64>()),
                scale: u8::from(ground.random::<bool>()),
                bright: ground.random(),
                response: 1000 + ground.random_range(0..500u16),
                words: [ground.random(), ground.random(), ground.random(), ground.random()],
            };
            let [x, y] = image(&point, &mut noise);
            record(&point, x, y, &mut noise)
        })
        .collect();
    records.sort_by_key(|record| (record.y, record.x, record.scale));
    records
}

/// Returns the samples of an IMU at rest before the frame at a time.
pub fn samples(time_us: u64) -> Vec<InertialSample> {
    let sample = |i: u64| InertialSample {
        time_us: (time_us + 5_000 * i).saturating_sub(65_000),
        rates: [0.0; 3],
        force: [0.0, 0.0, -9.80665],
    };
    (0..14).map(sample).collect()
}

/// Velocity of the camera in [`steady`] along `X_e` and `Y_e`, m/s.
pub const STEADY_M_S: (f64, f64) = (0.4, -0.25);

/// Creates the same stream as [`stream`] at 15 frames a second and [`STEADY_M_S`], with samples of the IMU.
pub fn steady(points: usize, frames: u32) -> Source {
    let mut source = stream(points, 0);
    for frame in 0..frames {
        let time_us = 66_667 * u64::from(frame);
        source.send(message::INERTIAL, &message::encode_inertial(&samples(time_us))).unwrap();
        let seconds = time_us as f64 / 1e6;
        let place = (STEADY_M_S.0 * seconds, STEADY_M_S.1 * seconds);
        let records = seen(points, 1.0, place, FIELD_OF_VIEW, frame);
        source.send_frame(&Telemetry { time_us, ..telemetry(frame) }, &records, &[2000; 2]).unwrap();
    }
    source
}

/// Creates a stream of registers, the command to capture, and `frames` frames of telemetry and records.
pub fn stream(points: usize, frames: u32) -> Source {
    let mut source = Source::default();
    source.send_registers(SIZE.0, SIZE.1).unwrap();
    source.send(message::COMMAND, &Command::Capture.encode()).unwrap();
    for frame in 0..frames {
        source.send_frame(&telemetry(frame), &records(points, frame), &[2000, 2000]).unwrap();
    }
    source
}
