//! Accuracy of the whole estimator over simulated flights above real ground, beside other methods whose results are
//! read from files.
//!
//! ```text
//! accuracy simulate TEXTURES FOLDER [EVERY]            frames of every flight, 16-bit PGM, and its name on stdout
//! accuracy score TEXTURES FOLDER [EVERY [FLIGHTS]]     scores of this project's estimates and of the results in
//! FOLDER,
//!                                                      written to FOLDER/scores.csv
//! ```
//!
//! Only every EVERY-th flight is used. FLIGHTS is the number of flights of each texture and condition; frames after the
//! first flight are rendered in memory, and the other methods do not have them.
//!
//! A method writes `NAME.METHOD.txt` for the flight `NAME`: `detect_ms match_ms features`, then nine numbers of the
//! homography or `none`, then a line `x y x' y' inlier` for each first match. `benches/accuracy.py` does so with
//! OpenCV, and calls both parts.

mod conditions;
mod scene;

use conditions::{CASES, Case, is_tuning};
use hoverlock_pictures::Picture;
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::estimator::Estimator;
use hoverlock_reference::motion::matching::matched_pairs;
use hoverlock_reference::motion::model::{Pair, transfer};
use hoverlock_reference::motion::{pose, refine};
use nalgebra::{Matrix3, Vector2};
use rayon::prelude::*;
use scene::{Flight, HEIGHT, SENSORS, WIDTH, render};
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

const METHODS: [&str; 5] = ["orb", "akaze", "brisk", "sift", "phase"];

/// Largest error of a correct match, px.
const MAX_CORRECT_ERROR_PX: f64 = 2.0;

fn main() -> ExitCode {
    match run(&std::env::args().skip(1).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Outcome<()> {
    let [verb, textures, folder, rest @ ..] = arguments else {
        return Err("usage: accuracy simulate|score TEXTURES FOLDER [EVERY [FLIGHTS]]".into());
    };
    let number = |i: usize| rest.get(i).map_or(Ok(1), |n| n.parse::<usize>());
    let (every, flights) = (number(0)?.max(1), number(1)?.max(1));
    let runs = runs(Path::new(textures), every, flights)?;
    let folder = Path::new(folder);
    match verb.as_str() {
        "simulate" => {
            fs::create_dir_all(folder)?;
            runs.iter().try_for_each(|run| {
                run.simulate(folder)?;
                println!("{}", run.name);
                Ok(())
            })
        }
        "score" => score(&runs, folder),
        other => Err(format!("{other}: simulate or score").into()),
    }
}

/// One texture under one condition.
struct Run {
    texture: PathBuf,
    tuning: bool,
    case: &'static Case,
    name: String,
    /// Index among the flights of this texture and condition; other methods have index 0 only.
    number: usize,
    seed: u64,
}

fn runs(textures: &Path, every: usize, flights: usize) -> Outcome<Vec<Run>> {
    let mut files: Vec<PathBuf> = fs::read_dir(textures)
        .map_err(|error| format!("{}: {error}", textures.display()))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "png"))
        .collect();
    files.sort();
    let mut runs = Vec::new();
    for (t, texture) in files.iter().enumerate() {
        let stem = texture.file_stem().unwrap_or_default().to_string_lossy();
        for (c, case) in CASES.iter().enumerate() {
            // Alphabetical neighbours are in different halves and have the same conditions.
            if (c + t / 2) % every != 0 {
                continue;
            }
            for number in 0..flights {
                let seed = ((number * files.len() + t) * CASES.len() + c) as u64;
                let suffix = if number == 0 { String::new() } else { format!(".{number}") };
                let name = format!("{stem}.{}{suffix}", case.name.replace(' ', "_"));
                runs.push(Run { texture: texture.clone(), tuning: is_tuning(t), case, name, number, seed });
            }
        }
    }
    Ok(runs)
}

impl Run {
    fn flight(&self) -> Flight {
        Flight::draw(&self.case.ranges, self.seed)
    }

    /// Renders REF and CUR.
    fn frames(&self) -> Outcome<[Plane<u16>; 2]> {
        let texture = Picture::open(&self.texture)?.luma;
        let flight = self.flight();
        // One texel is one pixel at the nominal height.
        let texel = 100.0 / flight.poses[0].camera.focal();
        let conditions = [self.case.reference, self.case.current];
        Ok(std::array::from_fn(|i| {
            let frame = render(&flight.poses[i], &flight.relief, &texture, texel);
            conditions[i].apply(&frame, 2 * self.seed + i as u64)
        }))
    }

    fn simulate(&self, folder: &Path) -> Outcome<()> {
        let paths = self.paths(folder);
        if paths.iter().all(|path| path.exists()) {
            return Ok(());
        }
        for (frame, path) in self.frames()?.iter().zip(&paths) {
            let bytes: Vec<u8> = frame.as_slice().iter().flat_map(|v| v.to_be_bytes()).collect();
            let header = format!("P5\n{WIDTH} {HEIGHT}\n65535\n");
            let part = path.with_extension("part");
            fs::write(&part, [header.as_bytes(), &bytes].concat())?;
            fs::rename(part, path)?;
        }
        Ok(())
    }

    fn paths(&self, folder: &Path) -> [PathBuf; 2] {
        ["ref", "cur"].map(|which| folder.join(format!("{}.{which}.pgm", self.name)))
    }
}

/// The result of a method for two frames.
struct MethodResult {
    detect_ms: f64,
    match_ms: f64,
    first: Vec<Pair>,
    /// Inlier pairs of the motion.
    last: Vec<Pair>,
    homography: Option<Matrix3<f64>>,
    quality: u8,
}

/// Runs this project with refinement on the frames, and by features alone as the flight program does.
fn hoverlock(reference: &Plane<u16>, current: &Plane<u16>, extractor: &mut FastExtractor) -> [MethodResult; 2] {
    let estimator = Estimator::default();
    let start = Instant::now();
    let from = extractor.extract(reference);
    let detect_ms = 1e3 * start.elapsed().as_secs_f64();
    let to = extractor.extract(current);
    let first = estimator.matching.matches(&from, &to);
    let first: Vec<Pair> = matched_pairs(&first, &from, &to).collect();
    let start = Instant::now();
    let max_squared_error = estimator.ransac.max_squared_error;
    let alone = estimator.estimate(&from, &to).ok();
    let alone_ms = 1e3 * start.elapsed().as_secs_f64();
    let refined = alone.clone().map(|found| refine::refined(found, reference, current, max_squared_error));
    let refined_ms = 1e3 * start.elapsed().as_secs_f64();
    [(refined, refined_ms), (alone, alone_ms)].map(|(estimate, match_ms)| match estimate {
        Some(estimate) => MethodResult {
            detect_ms,
            match_ms,
            first: first.clone(),
            last: estimate.inliers.iter().map(|&i| estimate.pairs[i]).collect(),
            homography: Some(estimate.homography),
            quality: estimate.quality,
        },
        None => {
            MethodResult { detect_ms, match_ms, first: first.clone(), last: Vec::new(), homography: None, quality: 0 }
        }
    })
}

/// Reads the result file of another method.
fn read(path: &Path) -> Outcome<MethodResult> {
    let text = fs::read_to_string(path)?;
    let mut lines = text.lines();
    let numbers = |line: &str| -> Result<Vec<f64>, _> { line.split_whitespace().map(str::parse).collect() };
    let head = numbers(lines.next().ok_or("empty")?)?;
    let homography = match lines.next().ok_or("no homography")? {
        "none" => None,
        line => Some(Matrix3::from_row_slice(&numbers(line)?)),
    };
    let (mut first, mut last) = (Vec::new(), Vec::new());
    for line in lines {
        let [x, y, u, v, inlier] = numbers(line)?[..] else { return Err("a match has five numbers".into()) };
        let pair = Pair { reference: Vector2::new(x, y), current: Vector2::new(u, v) };
        first.push(pair);
        if inlier > 0.0 {
            last.push(pair);
        }
    }
    Ok(MethodResult { detect_ms: head[0], match_ms: head[1], first, last, homography, quality: 255 })
}

/// The scores of one method on one run.
#[derive(Clone, Copy)]
struct Score {
    precision: f64,
    correct: f64,
    last_precision: f64,
    /// Median error of the correct inlier pairs, px.
    localisation: f64,
    centre: Option<f64>,
    /// Error of the pose, m, and normalised squared error; `None` if there is no pose.
    pose: Option<(f64, f64)>,
    detect_ms: f64,
    match_ms: f64,
    quality: u8,
}

/// Scores a result against the truth.
fn judge(found: &MethodResult, flight: &Flight) -> Score {
    let error = |pair: &Pair| (flight.transfer(pair.reference) - pair.current).norm();
    let correct = |pairs: &[Pair]| pairs.iter().filter(|pair| error(pair) < MAX_CORRECT_ERROR_PX).count() as f64;
    let fraction = |pairs: &[Pair]| if pairs.is_empty() { 0.0 } else { correct(pairs) / pairs.len() as f64 };
    let mut errors: Vec<f64> = found.last.iter().map(error).filter(|e| *e < MAX_CORRECT_ERROR_PX).collect();
    let centre = Vector2::new(WIDTH as f64 - 1.0, HEIGHT as f64 - 1.0) / 2.0;
    let moved = found.homography.and_then(|h| transfer(&h, centre));
    let pose = found.homography.and_then(|_| {
        let pose = pose::fit(&flight.views[0], &flight.views[1], &SENSORS, &found.last, found.quality).ok()?;
        let error = pose.displacement - flight.displacement();
        Some((error.norm(), error.dot(&(pose.covariance.try_inverse()? * error))))
    });
    Score {
        precision: fraction(&found.first),
        correct: correct(&found.first),
        last_precision: fraction(&found.last),
        localisation: median(&mut errors),
        centre: moved.map(|m| (m - flight.transfer(centre)).norm()),
        pose,
        detect_ms: found.detect_ms,
        match_ms: found.match_ms,
        quality: found.quality,
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Writes all scores, one line for each method and flight, which `benches/accuracy_report.py` reads.
fn write_table(runs: &[Run], scores: &[Vec<Option<Score>>], path: &Path) -> Outcome<()> {
    let names = "method,tuning,flight,condition,first,correct,last,localisation,centre,pose,nees,detect,match,quality";
    let mut text = format!("{names}\n");
    let optional = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    for (run, scores) in runs.iter().zip(scores) {
        for (method, s) in
            ["hoverlock", "features"].iter().chain(&METHODS).zip(scores).filter_map(|(m, s)| Some((m, (*s)?)))
        {
            let (pose, nees) = (optional(s.pose.map(|p| p.0)), optional(s.pose.map(|p| p.1)));
            writeln!(
                text,
                "{method},{},{},{},{},{},{},{},{},{pose},{nees},{},{},{}",
                u8::from(run.tuning),
                run.number,
                run.case.name,
                s.precision,
                s.correct,
                s.last_precision,
                s.localisation,
                optional(s.centre),
                s.detect_ms,
                s.match_ms,
                s.quality
            )?;
        }
    }
    let part = path.with_extension("part");
    fs::write(&part, text)?;
    Ok(fs::rename(part, path)?)
}

fn score(runs: &[Run], folder: &Path) -> Outcome<()> {
    let scores: Vec<Vec<Option<Score>>> = runs
        .par_iter()
        .map(|run| -> Outcome<Vec<Option<Score>>> {
            let flight = run.flight();
            let [from, to] = run.paths(folder);
            let [reference, current] = if from.exists() && to.exists() {
                [Picture::open(from)?.luma, Picture::open(to)?.luma]
            } else {
                run.frames()?
            };
            let mut extractor = FastExtractor::new(Selection::default())?;
            let hoverlock = hoverlock(&reference, &current, &mut extractor);
            let mut scores: Vec<_> = hoverlock.iter().map(|found| Some(judge(found, &flight))).collect();
            for method in METHODS {
                let path = folder.join(format!("{}.{method}.txt", run.name));
                scores.push(path.exists().then(|| read(&path)).transpose()?.map(|found| judge(&found, &flight)));
            }
            Ok(scores)
        })
        .collect::<Outcome<_>>()?;
    write_table(runs, &scores, &folder.join("scores.csv"))
}
