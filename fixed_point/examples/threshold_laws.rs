//! Prints how two laws of the automatic threshold follow ten abrupt changes of the picture: `cargo run --release -p
//! hoverlock-fixed-point --example threshold_laws -- ../shared/data/textures [COUNTS.csv]`
//!
//! *Count* is [`ThresholdController`], the law of the hardware. *Distribution* is the law of
//! `docs/decisions/032-threshold-from-a-histogram.md`, which the hardware does not have. Both see the same frames of
//! the bit-true model, with noise of their own in each frame. With the second argument the features of each frame are
//! written to that file.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write;
use std::path::Path;

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::threshold::ThresholdController;
use hoverlock_pictures::Picture;
use hoverlock_pictures::conditions::{Condition, FOG, NOMINAL};
use hoverlock_reference::image::plane::Plane;

/// Frames of each part of a sequence, 2 s; the law's steady state is reached before the first.
const FRAMES: usize = 30;

/// Noise seeds of each view: its frames take them in turn.
const SEEDS: usize = 2;

/// Features that a frame sends at most, by default.
const RECORD_LIMIT: usize = 2046;

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

/// Responses of the local maxima of each scale pair, rising.
type Maxima = Vec<Vec<u32>>;

/// Returns the number of maxima that reach a threshold.
fn reaching(maxima: &[u32], threshold: u32) -> u32 {
    (maxima.len() - maxima.partition_point(|response| *response < threshold)) as u32
}

/// The distribution's law, as decision 032 defines it.
struct Distribution {
    target: u32,
    max: u32,
    floor: u32,
}

impl Distribution {
    fn new(design: &DesignPoint) -> Self {
        let floor = ((1u32 << design.dog_bits) >> 10).max(1);
        Self { target: design.threshold.target, max: design.max_dog(), floor }
    }

    /// The lower edge of a bin: eight bins an octave from 8 on, single values below.
    fn edge(bin: u32) -> u32 {
        if bin < 8 { bin } else { (8 + bin % 8) << (bin / 8 - 1) }
    }

    fn next(&self, threshold: u32, maxima: &[u32]) -> u32 {
        let (count, target) = (reaching(maxima, threshold), self.target);
        if 8 * count.abs_diff(target) <= target {
            return threshold;
        }
        let above = |bin: u32| reaching(maxima, Self::edge(bin));
        let total = reaching(maxima, self.floor);
        let wanted =
            match (1..).take_while(|bin| Self::edge(*bin) <= self.max).filter(|bin| above(*bin) >= target).last() {
                Some(bin) if total >= target => {
                    let (surplus, inside) = (above(bin) - target, above(bin) - above(bin + 1));
                    let quarters = (1..4).filter(|part| 4 * surplus >= part * inside).count() as u32;
                    Self::edge(bin) + (((Self::edge(bin + 1) - Self::edge(bin)) * quarters) >> 2)
                }
                _ => self.floor,
            };
        let fall = if 8 * total < target { threshold >> 6 } else { threshold - (threshold >> 3) };
        wanted.clamp(self.floor, self.max).max(threshold - fall)
    }
}

/// A law: thresholds of the next frame from those of this one.
type Law<'a> = &'a dyn Fn(&[u32], &Maxima) -> Vec<u32>;

/// The features of each scale pair, frame by frame, and the frames in which the picture changes.
fn follow(views: &BTreeMap<String, Maxima>, parts: &[Part], law: Law<'_>) -> (Vec<Vec<u32>>, Vec<usize>) {
    let view = |part: &Part, frame: usize| &views[&key(part, frame % SEEDS)];
    let mut thresholds = vec![KT27.threshold.initial; KT27.pairs()];
    (0..200).for_each(|frame| thresholds = law(&thresholds, view(&parts[0], frame)));
    let (mut counts, mut changes) = (Vec::new(), Vec::new());
    for part in parts {
        changes.push(counts.len());
        for frame in 0..part.2 {
            let maxima = view(part, frame);
            counts
                .push(maxima.iter().zip(&thresholds).map(|(maxima, threshold)| reaching(maxima, *threshold)).collect());
            thresholds = law(&thresholds, maxima);
        }
    }
    changes.push(counts.len());
    (counts, changes)
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
            let planes = model.planes(&camera(Path::new(&folder), part, seed)?);
            let mut maxima = vec![Vec::new(); KT27.pairs()];
            for feature in planes.features(&vec![1; KT27.pairs()]) {
                maxima[usize::from(feature.scale)].push(u32::from(feature.response));
            }
            maxima.iter_mut().for_each(|maxima| maxima.sort_unstable());
            view.insert(maxima);
        }
    }
    let count: Law<'_> = &|thresholds, maxima| {
        let mut control = ThresholdController::resumed(&KT27, thresholds);
        let reach = |(maxima, threshold): (&Vec<u32>, &u32)| reaching(maxima, *threshold);
        control.finish_frame(&maxima.iter().zip(thresholds).map(reach).collect::<Vec<_>>());
        control.thresholds().to_vec()
    };
    let distribution = Distribution::new(&KT27);
    let of_distribution: Law<'_> = &|thresholds, maxima| {
        thresholds.iter().zip(maxima).map(|(threshold, maxima)| distribution.next(*threshold, maxima)).collect()
    };
    let mut csv = String::from("sequence,law,frame,features_0,features_1\n");
    println!("sequence | law | to 15 % | to 25 % | starved | overfull | most");
    for (title, parts) in SEQUENCES {
        for (law, name) in [(count, "count"), (of_distribution, "distribution")] {
            let (counts, changes) = follow(&views, &parts, law);
            for (frame, counts) in counts.iter().enumerate() {
                writeln!(csv, "{title},{name},{frame},{},{}", counts[0], counts[1])?;
            }
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
            println!("{title} | {name} | {} | {} | {starved} | {overfull} | {most}", within(0.15), within(0.25));
        }
    }
    if let Some(path) = arguments.next() {
        std::fs::write(path, csv)?;
    }
    Ok(())
}
