//! `hoverlock scene`: a picture of a scene of the simulator, from any place.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::ValueHint;
use hoverlock_cosim::hover::load_scene;
use hoverlock_cosim::sequence::png;
use hoverlock_edss::camera::FIELD_OF_VIEW_RANGE_DEG;
use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::Renderer;
use hoverlock_edss::world::still;
use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::Vector3;
use serde::Serialize;

use crate::Verdict;
use crate::choice::between;
use crate::output::{prepare_target, print, print_json, shown, write_file};

/// Largest tilt of the optical axis from the vertical, degrees: beyond it a wide view has the horizon in it, which the
/// simulator does not draw.
const MAX_TILT_DEG: f64 = 60.0;

/// Farthest place from the middle of the scene along an axis, and greatest height, m.
const FARTHEST_M: f64 = 5000.0;

/// Render a scene of the simulator from any place and angle.
///
/// The frame is that of the camera at rest: 1024 x 768 samples of 16 bits, exposed for the scene, with the noise of its
/// sensor.
///
/// Examples:
///   hoverlock scene town
///   hoverlock scene helipad-in-mist --at 20,-10,60 --look 35,0,0 --out oblique.png
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// A scene of the simulator, or a scene file
    #[arg(value_name = "NAME|FILE")]
    scene: String,
    /// Place of the camera, m along X_e and Y_e, and its height over the mean ground
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,50", value_delimiter = ',', allow_hyphen_values = true,
        value_parser = between(-FARTHEST_M, FARTHEST_M))]
    at: Vec<f64>,
    /// Roll, pitch and yaw of the camera, degrees; 0,0,0 looks straight down
    #[arg(long, value_name = "ROLL,PITCH,YAW", default_value = "0,0,0", value_delimiter = ',',
        allow_hyphen_values = true, value_parser = between(-360.0, 360.0))]
    look: Vec<f64>,
    /// Field of view across the columns, degrees
    #[arg(long, value_name = "DEG", default_value = "50",
        value_parser = between(FIELD_OF_VIEW_RANGE_DEG[0], FIELD_OF_VIEW_RANGE_DEG[1]))]
    field_of_view: f64,
    /// Seed of the scene and of the noise
    #[arg(long, value_name = "S", default_value = "1")]
    seed: u64,
    /// The PNG to write
    #[arg(long, value_name = "FILE.png", default_value = "out/scene.png", value_hint = ValueHint::FilePath)]
    out: PathBuf,
    /// One JSON object on stdout: width height out
    #[arg(long)]
    json: bool,
}

/// The JSON object of `--json`.
#[derive(Serialize)]
struct Report {
    width: usize,
    height: usize,
    #[serde(serialize_with = "crate::output::lossy")]
    out: PathBuf,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let pose = args.pose()?;
    let scene = load_scene(&args.scene)?;
    let inputs = [&[Path::new(&args.scene)], &scene.pictures()[..]].concat();
    let _folder = prepare_target("--out", &args.out, &["png"], &inputs)?;
    let renderer = Renderer::new(&scene, args.seed).with_context(|| format!("scene {}", args.scene))?;
    let surface = renderer.surface(0.0, pose.ground());
    if -pose.position.z <= surface {
        bail!("--at: the surface there is {surface:.1} m high; give a greater height");
    }
    let frame = still(&renderer, &pose, args.field_of_view, args.seed)?;
    write_file(&args.out, &png(&frame).context("the frame cannot be encoded")?)?;
    let report = Report { width: frame.width(), height: frame.height(), out: args.out.clone() };
    if args.json {
        print_json(&report)?;
    } else {
        print(&format!("{}\n", shown(&args.out)))?;
    }
    Ok(Verdict::Pass)
}

impl Args {
    /// Returns the pose of the camera.
    fn pose(&self) -> Result<Pose> {
        let (&[x, y, height], &[roll, pitch, yaw]) = (self.at.as_slice(), self.look.as_slice()) else {
            bail!("--at and --look take three numbers each, as in --at 20,-10,60 --look 35,0,0");
        };
        if height <= 0.0 {
            bail!("--at: the height is {height} m; give one above the ground");
        }
        let attitude = Attitude { roll: roll.to_radians(), pitch: pitch.to_radians(), yaw: yaw.to_radians() };
        let tilt = attitude.rotation()[(2, 2)].clamp(-1.0, 1.0).acos().to_degrees();
        if tilt > MAX_TILT_DEG {
            bail!("--look: the optical axis is {tilt:.0} degrees off the vertical; at most {MAX_TILT_DEG} are drawn");
        }
        Ok(Pose { position: Vector3::new(x, y, -height), attitude })
    }
}
