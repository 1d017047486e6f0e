//! `hoverlock hover`: a simulated helicopter in wind holds its place with the camera alone.

mod fly;
mod outcome;
mod save;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use hoverlock_edss::flight::Altitude;
use hoverlock_edss::render::Renderer;
use hoverlock_edss::scene::Scene;
use indicatif::{ProgressBar, ProgressStyle};

use crate::Verdict;
use crate::chain::{Program, Source, suits};
use crate::design::Chosen;
use crate::output::{Folder, print, print_json, spinning};
pub use fly::fly;
use save::Saved;

/// Close the loop: a simulated helicopter in gusts holds its place with nothing but the camera's estimate.
///
/// Each frame is rendered from where the helicopter is, taken by the camera with its noise, and goes through the
/// extractor and the flight program; the estimate steers the helicopter a tenth of a second later. The same helicopter
/// in the same wind without vision is flown beside it. Status 0 only where the place is held within the scene's bound,
/// vision is never lost for a second, and roll and pitch stay within 5 degrees; over open water, where no frame has an
/// estimate and the helicopter stays level.
///
/// Examples:
///   hoverlock hover
///   hoverlock hover --scene town --height 100 --seconds 60 --seed 7
///   hoverlock hover --scene my.toml --features rtl --estimator arm --seconds 5
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = HELP)]
pub struct Args {
    #[command(flatten)]
    course: Course,
    #[command(flatten)]
    chosen: Chosen,
    /// The folder for the page, index.html, and the table of each frame, hover.csv
    #[arg(long, value_name = "DIR", default_value = "out/hover")]
    out: PathBuf,
    /// Save the frames and their telemetry into this folder, for `hoverlock cosim`
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// One JSON object on stdout: pass rms_m max_m frames lost and more
    #[arg(long)]
    json: bool,
}

/// What is flown.
#[derive(clap::Args, Clone, Debug, PartialEq)]
pub struct Course {
    /// A scene of the simulator, or a scene file
    #[arg(long, value_name = "NAME|FILE", default_value = "field")]
    pub scene: String,
    /// Where features come from
    #[arg(long, value_enum, default_value = "fixed")]
    pub features: Source,
    /// Where the flight program runs
    #[arg(long, value_enum, default_value = "host")]
    pub estimator: Program,
    /// How long, seconds
    #[arg(long, value_name = "T", default_value = "10", value_parser = between(1.0, 3600.0))]
    pub seconds: f64,
    /// Seed of wind, sensors, camera and scene
    #[arg(long, value_name = "S", default_value = "1")]
    pub seed: u64,
    /// Height over the mean ground, m
    #[arg(long, value_name = "M", default_value = "50", value_parser = between(20.0, 300.0))]
    pub height: f64,
    /// Gusts, root mean square of each horizontal component, m/s
    #[arg(long, value_name = "V", default_value = "3", value_parser = between(0.0, 5.0))]
    pub gusts: f64,
    /// Whether the height is held, changes by 5 m up and down as a sine, or in steps
    #[arg(long, value_enum, default_value = "hold")]
    pub altitude: Climb,
    /// The camera's view: wide, or wide to acquire and after two seconds narrow to hold
    #[arg(long, value_enum, default_value = "wide")]
    pub view: View,
    /// Tell the flight program to renew its reference after so many seconds
    #[arg(long, value_name = "T", value_parser = between(0.0, 3600.0))]
    pub renew: Option<f64>,
}

const HELP: &str = "\
Scenes: field (relief of 3 m rms), town, helipad-in-mist (flat), open-water, aerial (a photograph that `make demo` \
fetches). Another scene is a text file; edss/README.md says what can stand in it.

Bounds, root mean square of the distance from the target: 0.1 m over flat ground, 0.3 m over relief or buildings.

hover.csv has a row for each frame: truth, estimate, sensors and wind, SI units and radians.

The ARM binary is that of `make arm`; HOVERLOCK_NAV names another.";

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// 50 degrees
    Wide,
    /// 50 degrees, then 10
    Narrow,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Climb {
    /// It is held
    Hold,
    /// A sine of 5 m in 20 s
    Smooth,
    /// Steps of 5 m every 5 s
    Abrupt,
}

impl From<Climb> for Altitude {
    fn from(climb: Climb) -> Self {
        match climb {
            Climb::Hold => Self::Hold,
            Climb::Smooth => Self::Smooth,
            Climb::Abrupt => Self::Abrupt,
        }
    }
}

/// A number within limits, for the command line.
pub fn between(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        Ok(_) => Err(format!("must be {least} to {most}")),
        Err(_) => Err(format!("is no number; it must be {least} to {most}")),
    }
}

pub fn run(args: &Args) -> Result<Verdict> {
    let course = &args.course;
    let design = args.chosen.design()?;
    suits(course.features, &design, course.estimator)?;
    course.estimator.find()?;
    let scene = scene(&course.scene)?;
    let renderer = spinning("making the scene", || Renderer::new(&scene, course.seed))
        .with_context(|| format!("scene {}", course.scene))?;
    let folder = Folder::new(&args.out)?;
    let save = args.save.as_deref().map(Folder::new).transpose()?;
    let bar = ProgressBar::new(fly::frames(course.seconds) as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    let saved = args.save.as_deref().map(Saved::new);
    let outcome = fly(course, &design, &scene, renderer, saved, &mut |told| {
        bar.set_message(told);
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    outcome.write(&args.out)?;
    drop((folder, save));
    if args.json {
        print_json(&outcome.summary)?;
    } else {
        print(&outcome.text(&args.out))?;
    }
    Ok(outcome.summary.pass.into())
}

/// A scene by its name, or that of a file.
pub fn scene(name: &str) -> Result<Scene> {
    if let Some(text) = Scene::named(name) {
        return Scene::parse(text, ".".as_ref()).with_context(|| format!("scene {name}"));
    }
    let path = PathBuf::from(name);
    if !path.exists() {
        bail!("--scene {name}: no such scene, and no such file; scenes are {}", Scene::NAMES.join(", "));
    }
    if !path.is_file() {
        bail!("--scene {name}: not a regular file");
    }
    let text = std::fs::read_to_string(&path).with_context(|| format!("--scene {name}: cannot be read"))?;
    let folder = path.parent().unwrap_or(&path);
    Scene::parse(&text, folder).with_context(|| format!("scene {name}"))
}
