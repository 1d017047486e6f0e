//! Streams that make a frame expensive: features in all shapes that loops depend on, and long gaps between frames.

use super::Source;
use super::scene::{self, SIZE, telemetry};
use hoverlock_arm::calibration::Calibration;
use hoverlock_arm::message::{self, Command, InertialSample, Telemetry};
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_reference::features::feature::Descriptor;
use hoverlock_reference::image::plane::Plane;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A shape of the features of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// No feature.
    Empty,
    /// The features of the ground, in a number that exceeds what the program uses.
    Ground,
    /// As many records as a message holds.
    Full,
    /// The features of the ground, all of one scale and polarity.
    OneKind,
    /// The same, all with one descriptor.
    Identical,
    /// Different descriptors in a square of 16 px.
    OnePlace,
    /// Different descriptors in four rows.
    OneRow,
    /// The ground's descriptors in clusters of 40 px.
    Clusters,
    /// Random positions and descriptors.
    Random,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 9] = [
        Self::Empty,
        Self::Ground,
        Self::Full,
        Self::OneKind,
        Self::Identical,
        Self::OnePlace,
        Self::OneRow,
        Self::Clusters,
        Self::Random,
    ];

    /// Returns the records of a frame in raster order. Frames of one shape show the same features with other noise.
    pub fn records(self, frame: u32) -> Vec<FeatureRecord> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let points = match self {
            Self::Empty => 0,
            Self::Full => 4400,
            _ => 1400,
        };
        let mut all = scene::seen(points, 1.0, (0.0, 0.0), scene::FIELD_OF_VIEW, frame);
        all.truncate(4095);
        for record in &mut all {
            let (left, top) = (record.x / 256 * 256, record.y / 256 * 256);
            let mut place = |x: std::ops::Range<u16>, y: std::ops::Range<u16>| {
                (record.x, record.y) = (rng.random_range(x), rng.random_range(y));
            };
            match self {
                Self::Empty | Self::Ground | Self::Full => (),
                Self::OneKind => (record.scale, record.bright) = (0, true),
                Self::Identical => {
                    (record.scale, record.bright, record.response) = (0, true, 1000);
                    record.descriptor = Descriptor::of_two([1, 2], [3, 4]);
                }
                Self::OnePlace => {
                    place(500..516, 300..316);
                    (record.scale, record.bright) = (0, true);
                }
                Self::OneRow => {
                    place(20..1004, 300..304);
                    (record.scale, record.bright) = (0, true);
                }
                Self::Clusters => place(left + 20..left + 60, top + 20..top + 60),
                Self::Random => {
                    let mut noise = ChaCha8Rng::seed_from_u64(u64::from(frame) << 32 | u64::from(record.response));
                    (record.x, record.y) = (noise.random_range(20..1004), noise.random_range(20..748));
                    record.descriptor = Descriptor::of_two(noise.random(), noise.random());
                }
            }
        }
        all.sort_by_key(|record| (record.y, record.x, record.scale));
        all
    }
}

/// Samples of the IMU before a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// None: the frame is found by search.
    None,
    /// One every 5 ms.
    Even,
    /// One every millisecond: more than the program keeps, over a second.
    Flood,
}

/// A frame of a stream.
#[derive(Debug, Clone, Copy)]
pub struct Taken {
    pub shape: Shape,
    pub samples: Samples,
    /// Time since the frame before, us.
    pub after_us: u64,
    pub command: Option<Command>,
}

/// Creates a stream of a captured reference and further frames of a vehicle at rest, with the pixels of a picture in
/// each if there is one.
pub fn stream(first: Shape, frames: &[Taken], picture: Option<&Plane<u16>>) -> Source {
    flown(None, first, frames, picture)
}

/// Creates a stream as [`stream`] does, of a camera that is calibrated.
pub fn calibrated(first: Shape, frames: &[Taken], picture: Option<&Plane<u16>>) -> Source {
    let mut calibration = Calibration::default();
    (calibration.k1.sigma, calibration.readout_s.sigma) = (1e-3, 1e-4);
    (calibration.principal_px.value, calibration.boresight_deg.value) = ([2.5, -1.5], [0.3, -0.2, 0.1]);
    flown(Some(&calibration), first, frames, picture)
}

fn flown(calibration: Option<&Calibration>, first: Shape, frames: &[Taken], picture: Option<&Plane<u16>>) -> Source {
    let mut source = Source::default();
    source.send_registers(SIZE.0, SIZE.1).unwrap();
    if let Some(calibration) = calibration {
        source.send(message::CALIBRATION, &calibration.encode()).unwrap();
    }
    source.send(message::COMMAND, &Command::Capture.encode()).unwrap();
    picture.map(|picture| source.send_pixels(0, picture)).transpose().unwrap();
    source.send_frame(&Telemetry { time_us: 0, ..telemetry(0) }, &first.records(0), &[2000; 2]).unwrap();
    let mut time_us = 0;
    for (number, taken) in (1..).zip(frames) {
        let step = match taken.samples {
            Samples::None => 0,
            Samples::Even => 5_000,
            Samples::Flood => 1_000,
        };
        let readings: Vec<InertialSample> = (0..taken.after_us.checked_div(step).unwrap_or(0))
            .map(|i| InertialSample { time_us: time_us + i * step, rates: [0.0; 3], force: [0.0, 0.0, -9.80665] })
            .collect();
        for some in readings.chunks(message::MAX_INERTIAL_SAMPLES) {
            source.send(message::INERTIAL, &message::encode_inertial(some)).unwrap();
        }
        time_us += taken.after_us;
        if let Some(command) = taken.command {
            source.send(message::COMMAND, &command.encode()).unwrap();
        }
        picture.map(|picture| source.send_pixels(number, picture)).transpose().unwrap();
        let records = taken.shape.records(number);
        source.send_frame(&Telemetry { time_us, ..telemetry(number) }, &records, &[2000; 2]).unwrap();
    }
    source
}

/// Returns a picture in which every patch is found.
pub fn texture() -> Plane<u16> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    Plane::from_fn(SIZE.0, SIZE.1, |_, _| rng.random())
}

/// Frames of one shape, four a second, with a new keyframe from each second one.
pub fn repeated(shape: Shape, samples: Samples, count: usize) -> Vec<Taken> {
    let command = |i: usize| (i % 2 == 1).then_some(Command::Renew);
    (0..count).map(|i| Taken { shape, samples, after_us: 250_000, command: command(i) }).collect()
}

/// A camera that is blind in a zoom, with pixels: after two seconds of ground each frame shows other noise at another
/// scale. It is tracked and searched in vain, and becomes a keyframe with templates.
fn blind_in_zoom(picture: &Plane<u16>) -> Source {
    let ground = Taken { shape: Shape::Ground, samples: Samples::Even, after_us: 66_667, command: None };
    let mut source = stream(Shape::Ground, &[ground; 35], Some(picture));
    for number in 36..44 {
        let time_us = 66_667 * u64::from(number);
        let field_of_view = 0.8 * scene::FIELD_OF_VIEW;
        source.send(message::INERTIAL, &message::encode_inertial(&scene::samples(time_us))).unwrap();
        source.send_pixels(number, picture).unwrap();
        let records = scene::seen_over_waves(1400, 0.0, number);
        source.send_frame(&Telemetry { time_us, field_of_view, ..telemetry(number) }, &records, &[2000; 2]).unwrap();
    }
    source
}

/// Returns the streams that were found to be the most expensive, with names.
pub fn worst() -> Vec<(&'static str, Source)> {
    let mut flood = repeated(Shape::Full, Samples::Even, 9);
    flood.push(Taken { shape: Shape::Full, samples: Samples::Flood, after_us: 1_500_000, command: None });
    flood.push(Taken { shape: Shape::Full, samples: Samples::Even, after_us: 5_000_000, command: None });
    let texture = texture();
    let refined = |shape, samples| stream(shape, &repeated(shape, samples, 8), Some(&texture));
    vec![
        ("refined, tracked", refined(Shape::Ground, Samples::Even)),
        ("refined, many records, tracked", refined(Shape::Full, Samples::Even)),
        ("refined, searched", refined(Shape::Ground, Samples::None)),
        ("refined, one row, tracked", refined(Shape::OneRow, Samples::Even)),
        ("refined, one kind, searched", refined(Shape::OneKind, Samples::None)),
        ("blind in a zoom", blind_in_zoom(&texture)),
        ("many records, many samples", stream(Shape::Full, &flood, None)),
        ("one kind, tracked", stream(Shape::OneKind, &repeated(Shape::OneKind, Samples::Even, 8), None)),
        ("one kind, searched", stream(Shape::OneKind, &repeated(Shape::OneKind, Samples::None, 5), None)),
        ("many records, searched", stream(Shape::Full, &repeated(Shape::Full, Samples::None, 5), None)),
        ("one row, tracked", stream(Shape::OneRow, &repeated(Shape::OneRow, Samples::Even, 6), None)),
        ("one row, searched", stream(Shape::OneRow, &repeated(Shape::OneRow, Samples::None, 4), None)),
        ("one place, tracked", stream(Shape::OnePlace, &repeated(Shape::OnePlace, Samples::Even, 4), None)),
        ("one place, searched", stream(Shape::OnePlace, &repeated(Shape::OnePlace, Samples::None, 4), None)),
        ("identical, tracked", stream(Shape::Identical, &repeated(Shape::Identical, Samples::Even, 4), None)),
        ("identical, searched", stream(Shape::Identical, &repeated(Shape::Identical, Samples::None, 4), None)),
        ("clusters, searched", stream(Shape::Clusters, &repeated(Shape::Clusters, Samples::None, 4), None)),
        ("random, searched", stream(Shape::Random, &repeated(Shape::Random, Samples::None, 4), None)),
    ]
}

/// Returns a stream of six frames drawn at random.
pub fn drawn(seed: u64) -> Source {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut shape = || Shape::ALL[rng.random_range(1..Shape::ALL.len())];
    let shapes: [Shape; 7] = std::array::from_fn(|_| shape());
    let mut samples = || [Samples::None, Samples::Even, Samples::Flood][rng.random_range(0..3)];
    let samples: [Samples; 7] = std::array::from_fn(|_| samples());
    let frames: Vec<Taken> = shapes[1..]
        .iter()
        .zip(samples)
        .map(|(shape, samples)| Taken {
            shape: *shape,
            samples,
            after_us: rng.random_range(1..2_000_000),
            command: rng.random::<bool>().then_some(Command::Renew),
        })
        .collect();
    stream(shapes[0], &frames, rng.random::<bool>().then(texture).as_ref())
}
