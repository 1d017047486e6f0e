//! Prints what an edge measure says about features: `cargo run --release -p hoverlock-fixed-point --example
//! edge_measure -- ../shared/data/textures [SEEDS]`
//!
//! Each picture is seen twice: a crop, and a random homography of it with noise, haze or blur of its own. Features of
//! the bit-true model are paired where the homography maps them. The mixed difference of the response, in nine bits as
//! `docs/decisions/044-edge-measure.md` defines it, gives the ratio of the principal curvatures (Lowe 2004, section
//! 4.1) and a position by a paraboloid in place of two parabolas. The second table has the motion of the centre by the
//! estimator of `match`, with features above a limit of the ratio left out, and with that position.

use std::path::{Path, PathBuf};

use hoverlock_design::KT27;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_fixed_point::model::threshold::ThresholdController;
use hoverlock_pictures::Picture;
use hoverlock_pictures::conditions::{COMBINED, Condition, FOG, NOMINAL};
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::image::bicubic::bicubic;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::estimator::Estimator;
use hoverlock_reference::motion::model::transfer;
use nalgebra::{Matrix2, Matrix3, Vector2};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

type Error = Box<dyn std::error::Error>;

/// Columns and rows of a frame; the smallest picture has 1024 x 1024 pixels.
const FRAME: (usize, usize) = (896, 640);
/// Ratios that separate the classes; a class without an upper limit has a determinant that is not positive.
const LIMITS: [f64; 8] = [1.5, 2.0, 3.0, 5.0, 8.0, 10.0, 15.0, f64::MAX];
/// Features handed to the estimator: a name, the largest ratio, and whether the position is that of the paraboloid.
const VARIANTS: [(&str, f64, bool); 7] = [
    ("all", f64::INFINITY, false),
    ("ratio up to 15", 15.0, false),
    ("ratio up to 10", 10.0, false),
    ("ratio up to 8", 8.0, false),
    ("ratio up to 5", 5.0, false),
    ("ratio up to 3", 3.0, false),
    ("all, paraboloid", f64::INFINITY, true),
];
/// Largest distance at which two features are a pair, px.
const GATE_PX: f64 = 8.0;
/// Bits in which the descriptors of a pair may differ, as in the flight program.
const MAX_HAMMING: u32 = 12;
/// Distance within which a feature is found again, px.
const REPEATED_PX: f64 = 1.5;

/// A feature with its measure.
struct Point {
    record: FeatureRecord,
    /// By two parabolas, and by the paraboloid, px.
    positions: [Vector2<f64>; 2],
    ratio: f64,
    /// Unit vector along the edge.
    along: Vector2<f64>,
}

/// A feature of the first frame in the second.
struct Sighting {
    ratio: f64,
    /// Error along and across the edge, by two parabolas and by the paraboloid, px.
    errors: Option<[[f64; 2]; 2]>,
    is_repeated: bool,
}

/// Returns the mixed difference as the nine bits of a record would carry it, LSB of the response.
fn mixed_difference(dog: &Plane<u16>, (x, y): (usize, usize)) -> f64 {
    let [c, ul, lr, ur, ll] =
        [(x, y), (x - 1, y - 1), (x + 1, y + 1), (x + 1, y - 1), (x - 1, y + 1)].map(|at| i32::from(dog[at]));
    let shift = c.max(1).ilog2().saturating_sub(7);
    let sent = ((ul + lr - ur - ll) >> shift).clamp(-256, 255);
    // The middle of the interval that the shift has left.
    f64::from(sent << shift) + f64::from((1 << shift) - 1) / 2.0
}

fn point(record: FeatureRecord, dog: &Plane<u16>) -> Point {
    let c = f64::from(record.response);
    let [l, r, u, d] = record.neighbours.map(f64::from);
    let mixed = mixed_difference(dog, (usize::from(record.x), usize::from(record.y))) / 4.0;
    let (a, b) = (2.0 * c - l - r, 2.0 * c - u - d);
    let curvatures = Matrix2::new(a, -mixed, -mixed, b);
    let eigen = curvatures.symmetric_eigen();
    let (low, high) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    let ratio = if low > 0.0 { high / low } else { f64::INFINITY };
    let along = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
    let (x, y) = Feature::from(&record).subpixel();
    let parabolas = Vector2::new(x, y);
    let vertex = curvatures.try_inverse().map(|inverse| inverse * Vector2::new(r - l, d - u) / 2.0);
    // A vertex outside the pixel is no maximum that the four neighbours confirm.
    let paraboloid = vertex.filter(|vertex| low > 0.0 && vertex.amax() <= 1.0).map_or(parabolas, |vertex| {
        Vector2::new(f64::from(record.x), f64::from(record.y)) + vertex.map(|part| part.clamp(-0.5, 0.5))
    });
    Point { record, positions: [parabolas, paraboloid], ratio, along }
}

/// Returns the feature whose parabolas have their vertex at a position.
fn feature_at(record: &FeatureRecord, position: Vector2<f64>) -> Feature {
    let mut feature = Feature::from(record);
    let vertex = position - Vector2::new(f64::from(record.x), f64::from(record.y));
    let beside = |part: f64| [feature.response - 1.0 - 2.0 * part, feature.response - 1.0 + 2.0 * part];
    let [[left, right], [upper, lower]] = [vertex.x, vertex.y].map(beside);
    feature.neighbours = [left, right, upper, lower];
    feature
}

/// Returns the features of a frame at the thresholds on which the automatic control settles.
fn points(model: &mut SimdBitTrue, frame: &Plane<u16>) -> Vec<Point> {
    let mut control = ThresholdController::new(&KT27);
    model.frame(&camera_samples(&KT27, frame), control.thresholds());
    let planes = model.planes();
    control.settle(&planes.maxima());
    let records = planes.features(control.thresholds());
    records.into_iter().map(|record| point(record, &planes.layers[usize::from(record.scale)].dog.magnitude)).collect()
}

/// Returns a random number between `-limit` and `limit`.
fn random(rng: &mut ChaCha8Rng, limit: f64) -> f64 {
    limit * (f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0)
}

/// Returns a homography of a hover: shift, turn, scale and tilt about the middle of the frame.
fn homography(rng: &mut ChaCha8Rng) -> Matrix3<f64> {
    let (turn, scale) = (random(rng, 0.05), 1.0 + random(rng, 0.03));
    let (sin, cos) = (turn.sin() * scale, turn.cos() * scale);
    let mut motion = Matrix3::new(cos, -sin, random(rng, 25.0), sin, cos, random(rng, 25.0), 0.0, 0.0, 1.0);
    (motion[(2, 0)], motion[(2, 1)]) = (random(rng, 3e-5), random(rng, 3e-5));
    let middle = Vector2::new(FRAME.0 as f64 - 1.0, FRAME.1 as f64 - 1.0) / 2.0;
    Matrix3::new_translation(&middle) * motion * Matrix3::new_translation(&-middle)
}

/// Samples a picture at the pixels of a frame; `to_picture` maps frame to picture.
fn sampled(picture: &Plane<u16>, to_picture: &Matrix3<f64>) -> Plane<u16> {
    Plane::from_fn(FRAME.0, FRAME.1, |x, y| {
        let at = transfer(to_picture, Vector2::new(x as f64, y as f64)).unwrap_or_default();
        bicubic(picture, at.x, at.y)
    })
}

/// Pairs the features of two frames where the motion maps them.
fn sightings(first: &[Point], second: &[Point], motion: &Matrix3<f64>) -> Vec<Sighting> {
    let (columns, rows) = (25.0..FRAME.0 as f64 - 25.0, 25.0..FRAME.1 as f64 - 25.0);
    let mut found = Vec::new();
    for point in first {
        let images = point.positions.map(|position| transfer(motion, position));
        let [Some(image), Some(by_paraboloid)] = images else { continue };
        if !columns.contains(&image.x) || !rows.contains(&image.y) {
            continue;
        }
        let miss = |other: &Point| (other.positions[0] - image).norm();
        let kind = |point: &Point| (point.record.scale, point.record.bright);
        let hamming = |other: &Point| point.record.descriptor.hamming(&other.record.descriptor, false);
        let near: Vec<_> = second.iter().filter(|other| kind(other) == kind(point) && miss(other) <= GATE_PX).collect();
        let best = near.iter().min_by_key(|other| hamming(other)).filter(|other| hamming(other) <= MAX_HAMMING);
        let errors = best.and_then(|other| {
            let along = (transfer(motion, point.positions[0] + point.along)? - image).normalize();
            let errors = [other.positions[0] - image, other.positions[1] - by_paraboloid];
            Some(errors.map(|error| [error.dot(&along), error.perp(&along)]))
        });
        let is_repeated = near.iter().any(|other| miss(other) <= REPEATED_PX);
        found.push(Sighting { ratio: point.ratio, errors, is_repeated });
    }
    found
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn print_classes(sightings: &[Sighting]) {
    println!("ratio up to | share | found again | paired | along, across, px | 0.8 to 4 px off | median, paraboloid");
    let mut lower = 0.0;
    for upper in LIMITS.into_iter().chain([f64::INFINITY]) {
        let class: Vec<_> = sightings.iter().filter(|one| one.ratio > lower && one.ratio <= upper).collect();
        lower = upper;
        let errors: Vec<_> = class.iter().filter_map(|one| one.errors).collect();
        let size = |error: &[f64; 2]| error[0].hypot(error[1]);
        let near: Vec<_> = errors.iter().map(|error| error[0]).filter(|error| size(error) < 4.0).collect();
        let rms = |i: usize| (near.iter().map(|error| error[i] * error[i]).sum::<f64>() / near.len() as f64).sqrt();
        let medians = [0, 1].map(|by: usize| median(errors.iter().map(|error| size(&error[by])).collect()));
        let part = |count: usize, of: usize| count as f64 / of as f64;
        let off = part(near.iter().filter(|error| size(error) >= 0.8).count(), errors.len());
        let repeated = part(class.iter().filter(|one| one.is_repeated).count(), class.len());
        let (share, paired) = (part(class.len(), sightings.len()), part(errors.len(), class.len()));
        let name = if upper == f64::MAX { "more".into() } else { upper.to_string() };
        println!(
            "{name} | {share:.3} | {repeated:.2} | {paired:.2} | {:.2}, {:.2} | {off:.3} | {:.3}, {:.3}",
            rms(0),
            rms(1),
            medians[0],
            medians[1]
        );
    }
}

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args_os().skip(1);
    let folder = arguments.next().ok_or("name the folder of the textures")?;
    let seeds: u64 = arguments.next().map_or(Ok(5), |seeds| seeds.to_string_lossy().parse())?;
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(Path::new(&folder))?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    files.retain(|file| file.extension().is_some_and(|extension| extension == "png"));
    files.sort();
    let mut model = SimdBitTrue::new(&KT27)?;
    let middle = Vector2::new(FRAME.0 as f64 - 1.0, FRAME.1 as f64 - 1.0) / 2.0;
    for condition in [NOMINAL, COMBINED, FOG] {
        let mut all = Vec::new();
        let mut errors = vec![Vec::new(); VARIANTS.len()];
        let (mut inliers, mut failed) = (vec![0; VARIANTS.len()], vec![0; VARIANTS.len()]);
        for (number, file) in files.iter().enumerate() {
            let picture = Picture::open(file)?.require(1024, 1024)?.luma;
            let corner = [picture.width() - FRAME.0, picture.height() - FRAME.1].map(|rest| (rest / 2) as f64);
            let crop = Matrix3::new_translation(&Vector2::from(corner));
            for seed in 0..seeds {
                let random_seed = 1000 * seed + number as u64;
                let motion = homography(&mut ChaCha8Rng::seed_from_u64(random_seed));
                let back = motion.try_inverse().ok_or("the motion is singular")?;
                let mut view = |to_picture: &Matrix3<f64>, condition: Condition, seed: u64| {
                    points(&mut model, &condition.apply(&sampled(&picture, to_picture), seed))
                };
                let first = view(&crop, NOMINAL, 2 * random_seed);
                let second = view(&(crop * back), condition, 2 * random_seed + 1);
                all.extend(sightings(&first, &second, &motion));
                for (i, (_, limit, by_paraboloid)) in VARIANTS.into_iter().enumerate() {
                    let kept = |points: &[Point]| -> Vec<Feature> {
                        let kept = points.iter().filter(|one| one.ratio <= limit);
                        kept.map(|one| feature_at(&one.record, one.positions[usize::from(by_paraboloid)])).collect()
                    };
                    let estimate = Estimator::default().estimate(&kept(&first), &kept(&second));
                    let Some((by, inside)) = estimate
                        .ok()
                        .and_then(|estimate| Some((transfer(&estimate.homography, middle)?, estimate.inliers.len())))
                    else {
                        failed[i] += 1;
                        continue;
                    };
                    errors[i].push((by - transfer(&motion, middle).ok_or("the middle is not seen")?).norm());
                    inliers[i] += inside;
                }
            }
        }
        println!("\n{}: {} features", condition.name, all.len());
        print_classes(&all);
        println!("features | centre, px: median, rms below 3 px | inliers | no estimate");
        for (i, (name, ..)) in VARIANTS.into_iter().enumerate() {
            let near: Vec<_> = errors[i].iter().filter(|error| **error < 3.0).collect();
            let rms = (near.iter().map(|error| **error * **error).sum::<f64>() / near.len() as f64).sqrt();
            let count = inliers[i] as f64 / errors[i].len() as f64;
            println!("{name} | {:.4}, {rms:.4} | {count:.0} | {}", median(errors[i].clone()), failed[i]);
        }
    }
    Ok(())
}
