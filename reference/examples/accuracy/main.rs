//! Accuracy of the whole estimator over simulated flights above pictures of ground, beside other methods whose results
//! are read from files.
//!
//! ```text
//! accuracy simulate FOLDER EVERY FLIGHTS PICTURE..  frames of every flight, 16-bit PGM, their telemetry, and its name
//!                                                   on stdout
//! accuracy score FOLDER EVERY FLIGHTS PICTURE..     scores of this project's estimates and of the results in
//!                                                   FOLDER, written to FOLDER/scores.csv
//! ```
//!
//! Only every EVERY-th case of a picture is used. FLIGHTS is the number of flights of each picture and case.
//!
//! A method writes `NAME.METHOD.txt` for the flight `NAME`: `detect_ms match_ms features`, then nine numbers of the
//! homography or `none`, then a line `x y x' y' inlier` for each first match, the best first. `benches/accuracy.py`
//! does so with OpenCV, and calls both parts. Each result is scored as it is and refined on the frames, all by the same
//! refinement.
//!
//! The flight program and the metres of `match` have no matches. `NAME.flight_program.txt` and `NAME.match.txt`, and
//! `NAME.uncalibrated.txt` and `NAME.match_uncalibrated.txt` without a calibration of the camera, have the milliseconds
//! of the run, then `none`, or displacement (m) and covariance (m^2, row by row).

mod conditions;
mod scene;

use conditions::{CASES, Case, TUNING_PICTURES};
use hoverlock_pictures::Picture;
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::estimate::Estimate;
use hoverlock_reference::motion::estimator::Estimator;
use hoverlock_reference::motion::matching::{Match, matched_pairs};
use hoverlock_reference::motion::model::{Model, Pair, transfer};
use hoverlock_reference::motion::orthophoto::Attitude;
use hoverlock_reference::motion::{pose, refine};
use nalgebra::{Matrix2, Matrix3, Vector2};
use rayon::prelude::*;
use scene::{Flight, HEIGHT, SENSORS, WIDTH, render};
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// The other methods, by the end of the names of their result files.
const OTHER_METHODS: [&str; 5] = ["orb", "akaze", "brisk", "sift", "klt"];

/// Smallest picture of ground, px.
const MIN_GROUND: (usize, usize) = (640, 480);
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
    let [verb, folder, every, flights, pictures @ ..] = arguments else {
        return Err("usage: accuracy simulate|score FOLDER EVERY FLIGHTS PICTURE..".into());
    };
    let (every, flights) = (every.parse::<usize>()?.max(1), flights.parse::<usize>()?.max(1));
    let runs = runs(pictures, every, flights);
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

/// One flight over a picture under one case.
struct Run {
    picture: PathBuf,
    tuning: bool,
    case: Case,
    /// Picture, case and seed.
    name: String,
    seed: u64,
}

fn runs(pictures: &[String], every: usize, flights: usize) -> Vec<Run> {
    let mut runs = Vec::new();
    for (t, picture) in pictures.iter().map(PathBuf::from).enumerate() {
        let stem = picture.file_stem().unwrap_or_default().to_string_lossy();
        for (c, case) in CASES.into_iter().enumerate() {
            // Neighbours have the same cases.
            if (c + t / 2) % every != 0 {
                continue;
            }
            for number in 0..flights {
                let seed = ((number * pictures.len() + t) * CASES.len() + c) as u64;
                let name = format!("{stem}.{}.{seed}", case.name.replace(' ', "_"));
                let tuning = TUNING_PICTURES.contains(&&*stem);
                runs.push(Run { picture: picture.clone(), tuning, case, name, seed });
            }
        }
    }
    runs
}

impl Run {
    fn flight(&self) -> Flight {
        Flight::draw(&self.case.ranges, self.seed)
    }

    /// Renders REF and CUR.
    fn frames(&self) -> Outcome<[Plane<u16>; 2]> {
        let texture = Picture::open(&self.picture)?.luma;
        let (width, height) = (texture.width(), texture.height());
        if width < MIN_GROUND.0 || height < MIN_GROUND.1 {
            let (path, (columns, rows)) = (self.picture.display(), MIN_GROUND);
            return Err(
                format!("{path}: is {width} x {height}; name ground of at least {columns} x {rows} pixels").into()
            );
        }
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
        self.write_telemetry(folder)?;
        let paths = self.paths(folder);
        if paths.iter().all(|path| path.exists()) {
            return Ok(());
        }
        for (frame, path) in self.frames()?.iter().zip(&paths) {
            let bytes: Vec<u8> = frame.as_slice().iter().flat_map(|v| v.to_be_bytes()).collect();
            let header = format!("P5\n{WIDTH} {HEIGHT}\n65535\n");
            replace(path, &[header.as_bytes(), &bytes].concat())?;
        }
        Ok(())
    }

    /// Writes the readings of both frames, in the form that `hoverlock cosim` reads.
    fn write_telemetry(&self, folder: &Path) -> Outcome<()> {
        let field_of_view = self.case.ranges.field_of_view;
        let errors = [SENSORS.tilt, SENSORS.heading].map(f64::to_degrees);
        let mut text =
            String::from("roll_deg,pitch_deg,yaw_deg,range_m,fov_deg,tilt_se_deg,heading_se_deg,range_se_m\n");
        for view in self.flight().views {
            let &Attitude { roll, pitch, yaw } = view.attitude();
            let [roll, pitch, yaw] = [roll, pitch, yaw].map(f64::to_degrees);
            let [tilt, heading] = errors;
            writeln!(text, "{roll},{pitch},{yaw},{},{field_of_view},{tilt},{heading},{}", view.range(), SENSORS.range)?;
        }
        replace(&folder.join(format!("{}.telemetry.csv", self.name)), text.as_bytes())
    }

    fn paths(&self, folder: &Path) -> [PathBuf; 2] {
        ["ref", "cur"].map(|which| folder.join(format!("{}.{which}.pgm", self.name)))
    }
}

/// The result of a method for two frames.
#[derive(Clone)]
struct MethodResult {
    detect_ms: f64,
    match_ms: f64,
    first: Vec<Pair>,
    estimate: Option<Estimate>,
}

impl MethodResult {
    /// Refines the estimate on the frames.
    fn refined(&self, reference: &Plane<u16>, current: &Plane<u16>) -> Self {
        let start = Instant::now();
        let max_squared_error = Estimator::default().ransac.max_squared_error;
        let estimate = self.estimate.clone().map(|found| refine::refined(found, reference, current, max_squared_error));
        let match_ms = self.match_ms + 1e3 * start.elapsed().as_secs_f64();
        Self { detect_ms: self.detect_ms, match_ms, first: self.first.clone(), estimate }
    }
}

/// Runs this project by features alone, as the flight program searches.
fn hoverlock(reference: &Plane<u16>, current: &Plane<u16>) -> Outcome<MethodResult> {
    let mut extractor = FastExtractor::new(Selection::default())?;
    let estimator = Estimator::default();
    let start = Instant::now();
    let from = extractor.extract(reference);
    let detect_ms = 1e3 * start.elapsed().as_secs_f64();
    let to = extractor.extract(current);
    let first = estimator.matching.matches(&from, &to);
    let first = matched_pairs(&first, &from, &to).collect();
    let start = Instant::now();
    let estimate = estimator.estimate(&from, &to).ok();
    Ok(MethodResult { detect_ms, match_ms: 1e3 * start.elapsed().as_secs_f64(), first, estimate })
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
    let (mut pairs, mut inliers) = (Vec::new(), Vec::new());
    for line in lines {
        let [x, y, u, v, inlier] = numbers(line)?[..] else { return Err("a match has five numbers".into()) };
        if inlier > 0.0 {
            inliers.push(pairs.len());
        }
        pairs.push(Pair { reference: Vector2::new(x, y), current: Vector2::new(u, v) });
    }
    let matches =
        (0..pairs.len()).map(|i| Match { reference: i, current: i, distance: 0.0, response_difference: 0.0 }).collect();
    let first = pairs.clone();
    let estimate = homography.map(|homography| Estimate {
        homography,
        model: Model::Homography,
        matches,
        pairs,
        inliers,
        rms: 0.0,
        quality: u8::MAX,
    });
    Ok(MethodResult { detect_ms: head[0], match_ms: head[1], first, estimate })
}

/// Reads the displacement of the flight program and scores it.
fn judge_flight(path: &Path, flight: &Flight) -> Outcome<Score> {
    let text = fs::read_to_string(path)?;
    let (match_ms, found) = text.trim().split_once('\n').ok_or("two lines")?;
    let pose = if found == "none" {
        None
    } else {
        let numbers = found.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let [x, y, xx, xy, yx, yy] = numbers[..] else { return Err("a displacement and its covariance".into()) };
        let error = Vector2::new(x, y) - flight.displacement();
        let inverse = Matrix2::new(xx, xy, yx, yy).try_inverse().ok_or("a singular covariance")?;
        Some((error.norm(), error.dot(&(inverse * error))))
    };
    let match_ms = match_ms.parse()?;
    let none = f64::NAN;
    Ok(Score {
        precision: none,
        correct: none,
        last_precision: none,
        localisation: none,
        centre: None,
        pose,
        detect_ms: none,
        match_ms,
    })
}

/// The scores of one method on one run; not a number where a method has no such value.
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
}

/// Scores a result against the truth.
fn judge(found: &MethodResult, flight: &Flight) -> Score {
    let error = |pair: &Pair| (flight.transfer(pair.reference) - pair.current).norm();
    let correct = |pairs: &[Pair]| pairs.iter().filter(|pair| error(pair) < MAX_CORRECT_ERROR_PX).count() as f64;
    let fraction = |pairs: &[Pair]| if pairs.is_empty() { 0.0 } else { correct(pairs) / pairs.len() as f64 };
    let estimate = found.estimate.as_ref();
    let last: Vec<Pair> = estimate.map_or_else(Vec::new, |e| e.inliers.iter().map(|&i| e.pairs[i]).collect());
    let mut errors: Vec<f64> = last.iter().map(error).filter(|e| *e < MAX_CORRECT_ERROR_PX).collect();
    let centre = Vector2::new(WIDTH as f64 - 1.0, HEIGHT as f64 - 1.0) / 2.0;
    let moved = estimate.and_then(|e| transfer(&e.homography, centre));
    let pose = estimate.and_then(|e| {
        let pose = pose::fit(&flight.views[0], &flight.views[1], &SENSORS, &last, e.quality).ok()?;
        let error = pose.displacement - flight.displacement();
        Some((error.norm(), error.dot(&(pose.covariance.try_inverse()? * error))))
    });
    Score {
        precision: fraction(&found.first),
        correct: correct(&found.first),
        last_precision: fraction(&last),
        localisation: median(&mut errors),
        centre: moved.map(|m| (m - flight.transfer(centre)).norm()),
        pose,
        detect_ms: found.detect_ms,
        match_ms: found.match_ms,
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Returns the lines of a flight in the table: each method as it is, and refined.
fn lines(run: &Run, folder: &Path) -> Outcome<String> {
    let flight = run.flight();
    let [from, to] = run.paths(folder);
    let [reference, current] = [Picture::open(from)?.luma, Picture::open(to)?.luma];
    let mut results = vec![("hoverlock", hoverlock(&reference, &current)?)];
    for method in OTHER_METHODS {
        let path = folder.join(format!("{}.{method}.txt", run.name));
        if path.exists() {
            results.push((method, read(&path)?));
        }
    }
    let mut scores = Vec::new();
    for method in ["flight_program", "uncalibrated", "match", "match_uncalibrated"] {
        let flown = folder.join(format!("{}.{method}.txt", run.name));
        if flown.exists() {
            scores.push((method, true, judge_flight(&flown, &flight)?));
        }
    }
    for (method, found) in results {
        scores.push((method, false, judge(&found, &flight)));
        scores.push((method, true, judge(&found.refined(&reference, &current), &flight)));
    }
    let optional = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let mut text = String::new();
    for (method, refined, s) in scores {
        writeln!(
            text,
            "{method},{},{},{},{},{},{},{},{},{},{},{},{}",
            u8::from(refined),
            u8::from(run.tuning),
            run.case.name,
            s.precision,
            s.correct,
            s.last_precision,
            s.localisation,
            optional(s.centre),
            optional(s.pose.map(|p| p.0)),
            optional(s.pose.map(|p| p.1)),
            s.detect_ms,
            s.match_ms,
        )?;
    }
    Ok(text)
}

/// Writes all scores, one line for each method, refined or not, and flight. `benches/accuracy_report.py` reads them.
fn score(runs: &[Run], folder: &Path) -> Outcome<()> {
    let names = "method,refined,tuning,condition,first,correct,last,localisation,centre,pose,nees,detect,match";
    let lines: Vec<String> = runs.par_iter().map(|run| lines(run, folder)).collect::<Outcome<_>>()?;
    replace(&folder.join("scores.csv"), format!("{names}\n{}", lines.concat()).as_bytes())
}

/// Writes a file aside, then renames it.
fn replace(path: &Path, bytes: &[u8]) -> Outcome<()> {
    let part = path.with_extension("part");
    fs::write(&part, bytes)?;
    Ok(fs::rename(part, path)?)
}
