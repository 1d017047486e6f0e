//! `hoverlock sweep`: a campaign of hovers, seeds x scenes x gusts x heights x designs.
//!
//! A point is one hover. The points are flown on all cores of this machine, or by the workers of a Dask cluster, which
//! run this command with `--point`. Either way a point is the same hover with the same seed, so its numbers are the
//! same to the last bit; they travel as lines of CSV, whose numbers are read back as they were. A finished point is
//! appended to the table at once, and not flown again by the next run with the same folder.

use std::collections::HashMap;
use std::ffi::OsString;
use std::io::{BufRead as _, BufReader, ErrorKind, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, anyhow, bail};
use hoverlock_design::DesignPoint;
use hoverlock_edss::camera::FRAME_SIZE;
use hoverlock_edss::render::Renderer;
use hoverlock_edss::scene::Scene;
use hoverlock_fixed_point::analysis::resources::{Resources, resources};
use hoverlock_reports::campaign::{self, Design, Finished, Point};
use hoverlock_reports::output::PAGE;
use hoverlock_reports::provenance::sha256;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::Verdict;
use crate::chain::{Program, Source};
use crate::design::{configured, named};
use crate::hover::{Climb, Course, View, between, fly, scene};
use crate::journal;
use crate::output::{Folder, command, print, print_json, say, shown, verdict, write_file};

/// Fly a campaign: many seeds, scenes, gusts, heights and word lengths, and what each costs in the FPGA.
///
/// Writes results.csv, one row a point, and index.html: the distance from the target against word lengths, and which
/// designs no other beats in both error and memory. A stopped campaign goes on where it was. Status 0 only where every
/// point at the design point kt27 passes its checks.
///
/// Examples:
///   hoverlock sweep --seeds 20 --scene field,town,helipad-in-mist --seconds 60
///   hoverlock sweep --config dog_bits=10 --config state=u16.0,coefficient=u0.8
///   hoverlock sweep --dask tcp://cluster:8786
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = HELP)]
pub struct Args {
    /// Scenes of the simulator, or scene files
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',', default_value = "field,town,helipad-in-mist")]
    scene: Vec<String>,
    /// Seeds, from 1 on
    #[arg(long, value_name = "N", default_value = "2", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    seeds: u64,
    /// Gusts, m/s rms
    #[arg(long, value_name = "V", value_delimiter = ',', default_value = "3", value_parser = between(0.0, 5.0))]
    gusts: Vec<f64>,
    /// Heights over the mean ground, m
    #[arg(long, value_name = "M", value_delimiter = ',', default_value = "50", value_parser = between(20.0, 300.0))]
    height: Vec<f64>,
    /// Further designs beside kt27: their names or design files
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    design: Vec<String>,
    /// A further design, as changes of kt27: dog_bits=12 or state=u16.0,coefficient=u0.8
    #[arg(long, value_name = "CHANGES")]
    config: Vec<String>,
    /// How long each, seconds
    #[arg(long, value_name = "T", default_value = "10", value_parser = between(1.0, 3600.0))]
    seconds: f64,
    /// Where features come from
    #[arg(long, value_enum, default_value = "fixed")]
    features: Source,
    /// The scheduler of a Dask cluster; without it this machine flies them
    #[arg(long, value_name = "ADDRESS")]
    dask: Option<String>,
    /// The folder for index.html and results.csv
    #[arg(long, value_name = "DIR", default_value = "out/sweep")]
    out: PathBuf,
    /// One JSON object on stdout: pass points[] pareto[]
    #[arg(long)]
    json: bool,
    /// Fly one point, given as a row of results.csv without its results; for the workers
    #[arg(long, value_name = "ROW", hide = true, exclusive = true)]
    point: Option<String>,
}

const HELP: &str = "\
With --dask the Python package `hoverlock-models` and the packages of its extra `dask` must be installed for the python3 of \
PATH, or that of HOVERLOCK_PYTHON; the workers need the command `hoverlock` in their PATH, or where HOVERLOCK_COMMAND \
says. A worker that dies costs nothing but time: its points are flown by another.";

/// The table.
const TABLE: &str = "results.csv";
/// Names the interpreter.
const PYTHON: &str = "HOVERLOCK_PYTHON";
/// What the workers run.
const COMMAND: &str = "HOVERLOCK_COMMAND";

/// What `--json` tells.
#[derive(Serialize)]
struct Report<'a> {
    pass: bool,
    points: &'a [Finished],
    /// Designs that no other beats in both error and memory.
    pareto: Vec<&'a str>,
}

pub fn run(args: &Args) -> Result<Verdict> {
    if let Some(row) = &args.point {
        let point = parsed(row).context("--point")?;
        print(&written(&flown(&point)?)?)?;
        return Ok(Verdict::Pass);
    }
    let points = points(args)?;
    let folder = Folder::new(&args.out)?;
    let table = args.out.join(TABLE);
    let mut known = read(&table)?;
    let left: Vec<Point> = points.iter().filter(|point| !known.contains_key(&point.key())).cloned().collect();
    if left.len() < points.len() {
        say(&format!("{} of {} points are in {}", points.len() - left.len(), points.len(), shown(&table)));
    }
    let bar = ProgressBar::new(left.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {pos} of {len}  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    let mut keep = |finished: Finished| -> Result<()> {
        bar.set_message(format!("{} {}: {:.3} m", finished.scene, finished.design, finished.rms_m));
        bar.inc(1);
        append(&table, &finished)?;
        known.insert(finished.point().key(), finished);
        Ok(())
    };
    match &args.dask {
        Some(address) => on_cluster(address, &left, &mut keep)?,
        None => on_this_machine(&left, &mut keep)?,
    }
    bar.finish_and_clear();
    let finished: Vec<Finished> = points.iter().filter_map(|point| known.get(&point.key()).cloned()).collect();
    if finished.len() < points.len() {
        bail!("{} of {} points came back", finished.len(), points.len());
    }
    let designs = campaign::designs(&finished);
    write_file(&args.out.join(PAGE), campaign::html(&finished, &designs, &command())?.as_bytes())?;
    drop(folder);
    let failed: Vec<&Finished> =
        finished.iter().filter(|point| point.design == campaign::DEFAULT && !point.pass).collect();
    let pass = failed.is_empty();
    if args.json {
        let pareto = designs.iter().filter(|design| design.pareto).map(|design| design.name.as_str()).collect();
        print_json(&Report { pass, points: &finished, pareto })?;
    } else {
        print(&text(&designs, &args.out))?;
        let told = match failed.first() {
            Some(first) => format!(
                "{} points of kt27 fail, the first: {} seed {} at {} m: {}",
                failed.len(),
                first.scene,
                first.seed,
                first.height_m,
                first.reason
            ),
            None => format!("{} points", finished.len()),
        };
        print(&(verdict(pass, &told) + "\n"))?;
    }
    Ok(pass.into())
}

/// All points, scene by scene.
fn points(args: &Args) -> Result<Vec<Point>> {
    let mut designs = vec![campaign::DEFAULT.to_owned()];
    for name in args.design.iter().chain(&args.config) {
        if !designs.contains(name) {
            designs.push(name.clone());
        }
    }
    if args.features == Source::Float && designs.len() > 1 {
        bail!("--design, --config: float features have no word lengths; leave --features out");
    }
    for name in &designs {
        let design = design(name)?;
        let DesignPoint { width, height, .. } = design;
        if (width as usize) < FRAME_SIZE.0 || (height as usize) < FRAME_SIZE.1 {
            bail!(
                "the design {name} takes {width} x {height} px at most, and the camera's frames have {} x {}: copy its \
                 file and change width and height",
                FRAME_SIZE.0,
                FRAME_SIZE.1
            );
        }
    }
    let mut points = Vec::new();
    for name in &args.scene {
        let subject = scene(name)?;
        for &height_m in &args.height {
            for &gusts_m_s in &args.gusts {
                for name_of_design in &designs {
                    let inputs = inputs(&subject, &design(name_of_design)?);
                    points.extend((1..=args.seeds).map(|seed| Point {
                        scene: name.clone(),
                        height_m,
                        gusts_m_s,
                        seconds: args.seconds,
                        features: crate::chain::name(&args.features),
                        design: name_of_design.clone(),
                        inputs: inputs.clone(),
                        seed,
                    }));
                }
            }
        }
    }
    Ok(points)
}

/// The design of a name or a file, or of changes of kt27.
fn design(name: &str) -> Result<DesignPoint> {
    if !name.contains('=') {
        return named(name.as_ref());
    }
    let changes: Vec<OsString> = name.split(',').map(OsString::from).collect();
    configured(&changes).context("--config")
}

/// Hash of the numbers of scene and design; of a picture that a scene names, its path only.
fn inputs(scene: &Scene, design: &DesignPoint) -> String {
    let mut digest = sha256(&format!("{scene:?} {}", design.to_toml()));
    digest.truncate(8);
    digest
}

/// Flies a point.
fn flown(point: &Point) -> Result<Finished> {
    let subject: Scene = scene(&point.scene)?;
    let design = design(&point.design)?;
    if inputs(&subject, &design) != point.inputs {
        bail!(
            "scene {} or design {} has other numbers here than where the campaign began: copy the files of there",
            point.scene,
            point.design
        );
    }
    let features = <Source as clap::ValueEnum>::from_str(&point.features, false).map_err(|error| anyhow!(error))?;
    let course = Course {
        scene: point.scene.clone(),
        features,
        estimator: Program::Host,
        seconds: point.seconds,
        seed: point.seed,
        height: point.height_m,
        gusts: point.gusts_m_s,
        altitude: Climb::Hold,
        view: View::Wide,
        renew: None,
    };
    let renderer = Renderer::new(&subject, point.seed).with_context(|| format!("scene {}", point.scene))?;
    let summary = fly(&course, &design, &subject, renderer, None, &mut |_| ())?.summary;
    let Resources { m10k, mul18, .. } = resources(&design);
    Ok(Finished {
        scene: point.scene.clone(),
        height_m: point.height_m,
        gusts_m_s: point.gusts_m_s,
        seconds: point.seconds,
        features: point.features.clone(),
        design: point.design.clone(),
        inputs: point.inputs.clone(),
        seed: point.seed,
        m10k,
        mul18,
        rms_m: summary.rms_m,
        max_m: summary.max_m,
        imu_only_rms_m: summary.imu_only_rms_m,
        error_rms_m: summary.error_rms_m,
        frames: summary.frames,
        lost: summary.lost,
        pass: summary.pass,
        reason: summary.reason.unwrap_or_default(),
    })
}

/// As many at a time as there are cores.
fn on_this_machine(points: &[Point], keep: &mut (dyn FnMut(Finished) -> Result<()> + Send)) -> Result<()> {
    let next = AtomicUsize::new(0);
    let keep = Mutex::new(keep);
    let work = || -> Result<()> {
        while let Some(point) = points.get(next.fetch_add(1, Ordering::Relaxed)) {
            let finished = flown(point)?;
            let mut keep = keep.lock().map_err(|_| anyhow!("another point has panicked"))?;
            (*keep)(finished)?;
        }
        Ok(())
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores.min(points.len())).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| anyhow!("a point has panicked"))?)
    })
}

/// The Python module gives the points to the workers; their rows come back in the order they are done.
fn on_cluster(address: &str, points: &[Point], keep: &mut dyn FnMut(Finished) -> Result<()>) -> Result<()> {
    if points.is_empty() {
        return Ok(());
    }
    let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    let worker = std::env::var_os(COMMAND).unwrap_or_else(|| "hoverlock".into());
    // Into a file: nobody reads a pipe while the results come, and a full one would stop the module.
    let mut said = tempfile::tempfile().context("--dask: a temporary file")?;
    let child = Command::new(&python)
        .args(["-m", "hoverlock_models.sweep", "--scheduler", address, "--command"])
        .arg(worker)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(said.try_clone().context("--dask: a temporary file")?)
        .spawn();
    let mut child = match child {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            bail!(
                "--dask: {}: no such program; name a Python with the module hoverlock_models in {PYTHON}",
                python.display()
            )
        }
        child => child.context("--dask: Python cannot be run")?,
    };
    let mut rows = String::new();
    for point in points {
        rows += &written(point)?;
    }
    if let Some(mut stdin) = child.stdin.take() {
        stdin.write_all(rows.as_bytes()).context("--dask: the Python module takes no points")?;
    }
    let stdout = child.stdout.take().ok_or_else(|| anyhow!("--dask: no pipe from the Python module"))?;
    for line in BufReader::new(stdout).lines() {
        keep(parsed(&line.context("--dask: the results cannot be read")?)?)?;
    }
    let status = child.wait().context("--dask: the Python module is lost")?;
    if !status.success() {
        let mut bytes = Vec::new();
        said.rewind().and_then(|()| said.read_to_end(&mut bytes)).context("--dask: what the Python module said")?;
        let said = String::from_utf8_lossy(&bytes);
        let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it says nothing");
        bail!("--dask {address}: the Python module has failed ({status}): {last}");
    }
    Ok(())
}

/// A row without a header.
fn written(row: &impl Serialize) -> Result<String> {
    let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    table.serialize(row).context("a row")?;
    Ok(String::from_utf8(table.into_inner().context("a row")?)?)
}

fn parsed<T: serde::de::DeserializeOwned>(row: &str) -> Result<T> {
    let mut table = csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
    let row = table.deserialize().next().ok_or_else(|| anyhow!("an empty row"))?;
    row.context("not a row of the table")
}

/// The points of a table.
fn read(table: &Path) -> Result<HashMap<String, Finished>> {
    let text = journal::read(table)?;
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let finished = rows.deserialize().map(|row| {
        let finished: Finished =
            row.with_context(|| format!("{}: not a table of this command; move it away", table.display()))?;
        Ok((finished.point().key(), finished))
    });
    finished.collect()
}

/// A row at the end of the table; a new table begins with its header.
fn append(table: &Path, finished: &Finished) -> Result<()> {
    journal::append(table, |first| {
        let mut rows = csv::WriterBuilder::new().has_headers(first).from_writer(Vec::new());
        rows.serialize(finished).context("a row of the table")?;
        rows.into_inner().context("a row of the table")
    })
}

fn text(designs: &[Design], out: &Path) -> String {
    let mut text = format!(
        "{:<36} {:>7} {:>9} {:>9} {:>9} {:>6} {:>6}\n",
        "design", "points", "rms, m", "worst, m", "error, m", "M10K", "pass"
    );
    for design in designs {
        let error = design.error_rms_m.map_or("-".to_owned(), |error| format!("{error:.3}"));
        text += &format!(
            "{:<36} {:>7} {:>9.3} {:>9.3} {:>9} {:>6} {:>6}{}\n",
            design.name,
            design.points,
            design.rms_m,
            design.worst_m,
            error,
            design.m10k,
            design.passed,
            if design.pareto { "  not beaten" } else { "" }
        );
    }
    text + &format!("{}\n{}\n", shown(&out.join(PAGE)), shown(&out.join(TABLE)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    #[test]
    fn another_number_of_scene_or_design_is_another_point() {
        let of = |scene: &str, change: &str| {
            let scene = Scene::parse(scene, ".".as_ref()).unwrap();
            inputs(&scene, &KT27.with_override(change).unwrap())
        };
        let field = Scene::named("field").unwrap();
        let own = of(field, "dog_bits=15");
        assert!(own.len() == 8 && own == of(&format!("# a comment\n{field}"), "dog_bits=15"));
        assert_ne!(own, of(&field.replace("rms_m = 3.0", "rms_m = 3.1"), "dog_bits=15"));
        assert_ne!(own, of(field, "dog_bits=14"));
    }
}
