//! Prints how the automatic threshold follows ten abrupt changes of the picture: `cargo run --release -p
//! hoverlock-fixed-point --example threshold_laws -- ../shared/data/textures [COUNTS.svg]`
//!
//! *Distribution* is [`ThresholdController`], the law of model and hardware. *Count* is the law before it, which
//! `docs/decisions/032-threshold-from-a-histogram.md` compares with it and nothing else uses. Both see the same frames
//! of the bit-true model, with noise of their own in each frame. With the second argument the features of each frame
//! are drawn into that file.

mod plot;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use hoverlock_design::KT27;
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::threshold::{Maxima, ThresholdController};
use hoverlock_pictures::Picture;
use hoverlock_pictures::conditions::{Condition, FOG, NOMINAL};
use hoverlock_reference::image::plane::Plane;
use plot::{Marks, Panel};

/// Frames of each part of a sequence, 2 s; the law's steady state is reached before the first.
const FRAMES: usize = 30;

/// Noise seeds of each view: its frames take them in turn.
const SEEDS: usize = 2;

/// Features that a frame sends at most, by default.
const RECORD_LIMIT: usize = 2046;

/// Share of the target by which the features of a frame may differ from it.
const TOLERANCE: f64 = 0.15;

/// What the camera sees: a texture, its exposure, and the number of frames.
#[derive(Clone, Copy)]
struct Part(&'static str, f64, usize);

const BLACK: &str = "black";
const WHITE_OUT: &str = "white-out";

const SEQUENCES: [(&str, [Part; 3]); 10] = [
    ("lens covered for 1 s", [Part("farmstead", 1.0, FRAMES), Part(BLACK, 1.0, 15), Part("farmstead", 1.0, FRAMES)]),
    ("lens covered for 5 s", [Part("farmstead", 1.0, FRAMES), Part(BLACK, 1.0, 75), Part("farmstead", 1.0, FRAMES)]),
    ("white-out for 1 s", [Part("farmstead", 1.0, FRAMES), Part(WHITE_OUT, 1.0, 15), Part("farmstead", 1.0, FRAMES)]),
    (
        "exposure of a forest / 4",
        [Part("forest_canopy", 1.0, FRAMES), Part("forest_canopy", 0.25, FRAMES), Part("forest_canopy", 1.0, FRAMES)],
    ),
    (
        "exposure of a farm / 16",
        [Part("farmstead", 1.0, FRAMES), Part("farmstead", 0.0625, FRAMES), Part("farmstead", 1.0, FRAMES)],
    ),
    (
        "exposure of dunes / 4, 5 frames",
        [Part("dune_scrub", 1.0, FRAMES), Part("dune_scrub", 0.25, 5), Part("dune_scrub", 1.0, FRAMES)],
    ),
    (
        "dunes, town, pasture",
        [
            Part("dune_scrub", 1.0, FRAMES),
            Part("urban_intersection_a", 1.0, FRAMES),
            Part("pasture_low_texture", 1.0, FRAMES),
        ],
    ),
    (
        "sand, forest, lake",
        [Part("sand_ripples", 1.0, FRAMES), Part("forest_canopy", 1.0, FRAMES), Part("lake_shore", 1.0, FRAMES)],
    ),
    (
        "fog over a farm",
        [Part("farmstead", 1.0, FRAMES), Part("fog:farmstead", 1.0, FRAMES), Part("farmstead", 1.0, FRAMES)],
    ),
    (
        "fog over a town, 5 frames",
        [
            Part("urban_intersection_a", 1.0, FRAMES),
            Part("fog:urban_intersection_a", 1.0, 5),
            Part("urban_intersection_a", 1.0, FRAMES),
        ],
    ),
];

/// The law of the count: a step of an eighth up above 5/4 of the target, and down below 3/4.
fn by_count(threshold: u32, maxima: &Maxima) -> u32 {
    let (count, target, step) = (maxima.count(threshold), KT27.threshold.target, (threshold >> 3) + 1);
    match count {
        _ if 4 * count > 5 * target => (threshold + step).min(KT27.max_dog()),
        _ if 4 * count < 3 * target => threshold.saturating_sub(step).max(1),
        _ => threshold,
    }
}

/// A law: thresholds of the next frame from those of this one.
type Law<'a> = &'a dyn Fn(&[u32], &[Maxima]) -> Vec<u32>;

/// The first frame of each part, and the number of frames.
fn changes(parts: &[Part]) -> Vec<usize> {
    (0..=parts.len()).map(|end| parts[..end].iter().map(|part| part.2).sum()).collect()
}

/// The features of each scale pair, frame by frame.
fn follow(views: &BTreeMap<String, Vec<Maxima>>, parts: &[Part], law: Law<'_>) -> Vec<Vec<u32>> {
    let view = |part: &Part, frame: usize| &views[&key(part, frame % SEEDS)];
    let mut thresholds = vec![KT27.threshold.initial; KT27.pairs()];
    (0..200).for_each(|frame| thresholds = law(&thresholds, view(&parts[0], frame)));
    let mut counts = Vec::new();
    for part in parts {
        for frame in 0..part.2 {
            let maxima = view(part, frame);
            counts.push(maxima.iter().zip(&thresholds).map(|(maxima, threshold)| maxima.count(*threshold)).collect());
            thresholds = law(&thresholds, maxima);
        }
    }
    counts
}

fn key(Part(name, exposure, _): &Part, seed: usize) -> String {
    format!("{name} {exposure} {seed}")
}

/// Frames after the first of a part until each scale pair keeps within a part in `tolerance` of the target.
fn until_met(counts: &[Vec<u32>], tolerance: f64) -> String {
    let target = f64::from(KT27.threshold.target);
    let met = |counts: &Vec<u32>| counts.iter().all(|n| (f64::from(*n) - target).abs() <= tolerance * target);
    match counts.iter().rposition(|counts| !met(counts)) {
        None => "0".into(),
        Some(last) if last + 1 < counts.len() => (last + 1).to_string(),
        Some(_) => format!("> {}", counts.len() - 1),
    }
}

fn camera(folder: &Path, part: &Part, seed: usize) -> Result<Plane<u16>, Box<dyn std::error::Error>> {
    let clear = Condition { gain_spread: 0.0, ..NOMINAL };
    let (width, height) = (KT27.width as usize, KT27.height as usize);
    let (name, condition) = match part.0.strip_prefix("fog:") {
        Some(name) => (name, FOG),
        None if part.0 == WHITE_OUT => (WHITE_OUT, FOG),
        None => (part.0, clear),
    };
    let picture = match name {
        BLACK => Plane::filled(width, height, 0),
        WHITE_OUT => Plane::filled(width, height, 36_000),
        name => Picture::open(folder.join(format!("{name}.png")))?.crop(width, height).luma,
    };
    Ok(condition.apply(&picture.map(|dn| (f64::from(*dn) * part.1) as u16), seed as u64 + 1))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let folder = arguments.next().ok_or("name the folder of the textures")?;
    let model = BitTrue::new(&KT27)?;
    let mut views = BTreeMap::new();
    for part in SEQUENCES.iter().flat_map(|(_, parts)| parts) {
        for seed in 0..SEEDS {
            let Entry::Vacant(view) = views.entry(key(part, seed)) else { continue };
            view.insert(model.planes(&camera(Path::new(&folder), part, seed)?).maxima());
        }
    }
    let count: Law<'_> =
        &|thresholds, maxima| thresholds.iter().zip(maxima).map(|(t, maxima)| by_count(*t, maxima)).collect();
    let distribution: Law<'_> = &|thresholds, maxima| {
        let mut control = ThresholdController::resumed(&KT27, thresholds);
        control.finish_frame(maxima);
        control.thresholds().to_vec()
    };
    let mut panels = Vec::new();
    println!("sequence | law | to 15 % | to 25 % | starved | overfull | most");
    for (title, parts) in SEQUENCES {
        let changes = changes(&parts);
        let laws = [(count, "count"), (distribution, "distribution")].map(|(law, name)| {
            let counts = follow(&views, &parts, law);
            // Nothing is seen with the lens covered.
            let seen = (1..parts.len()).filter(|part| parts[*part].0 != BLACK);
            let after = |part: usize| &counts[changes[part]..changes[part + 1]];
            let within = |tolerance: f64| {
                seen.clone().map(|part| until_met(after(part), tolerance)).collect::<Vec<_>>().join(", ")
            };
            let starved = |counts: &&Vec<u32>| counts.iter().any(|count| 2 * count < KT27.threshold.target);
            let starved: usize = seen.clone().map(|part| after(part).iter().filter(starved).count()).sum();
            let sums: Vec<usize> = counts.iter().map(|counts| counts.iter().sum::<u32>() as usize).collect();
            let overfull = sums.iter().filter(|sum| **sum > RECORD_LIMIT).count();
            let most = sums.iter().max().unwrap_or(&0);
            println!("{title} | {name} | {} | {} | {starved} | {overfull} | {most}", within(TOLERANCE), within(0.25));
            sums
        });
        panels.push(Panel { title, changes, laws });
    }
    if let Some(path) = arguments.next() {
        let target = f64::from(KT27.threshold.target) * KT27.pairs() as f64;
        let marks = Marks { target, tolerance: TOLERANCE, limit: RECORD_LIMIT as f64 };
        std::fs::write(path, plot::svg(&panels, &marks))?;
    }
    Ok(())
}
