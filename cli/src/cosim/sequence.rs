//! A folder of frames with what is known about them: telemetry, and homographies fitted to the pictures.

use std::path::Path;

use anyhow::{Context, Result, bail};
use hoverlock_arm::message::Telemetry;
use hoverlock_design::KT27;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::{Pair, transfer};
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View};
use hoverlock_reference::motion::pose;
use nalgebra::{Matrix3, Vector2};
use serde::Deserialize;

use crate::picture::{Limit, listed, open};
use crate::telemetry;

/// The least side of a frame that the hardware takes.
const LEAST_SIDE: usize = 64;

/// Telemetry of a folder that has none: level, facing one way, at one height. Range and field of view only set what a
/// metre is. A tilt that is known to 5 degrees at 60 m leaves more than the metre at which the flight program refuses;
/// at 20 m the real sequences give estimates.
const ASSUMED: (f64, f64, SensorErrors) =
    (20.0, 50.0, SensorErrors { tilt: 5.0 * DEGREE, heading: 10.0 * DEGREE, range: 1.0 });

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Seconds between frames whose times are not known: more than the age up to which a displacement predicts the next,
/// so that no frame is searched where the one before it was.
const APART: f64 = 2.0;

/// The same in words.
pub const ASSUMED_TEXT: &str = "assumed: roll, pitch and yaw 0, range 20 m, field of view 50 degrees, frames 2 s \
                                apart; standard errors 5 degrees of tilt, 10 of heading, 1 m of range";

/// Columns and rows of the grid whose motion stands for a homography.
const GRID: (usize, usize) = (12, 9);

/// Frames in order.
pub struct Sequence {
    /// Of one size.
    pub frames: Vec<Plane<u16>>,
    /// File names.
    pub names: Vec<String>,
    /// One for each frame.
    pub telemetry: Vec<Telemetry>,
    /// The folder has no telemetry of its own.
    pub assumed: bool,
    /// One for each frame; the first is at rest.
    pub truths: Vec<Option<Truth>>,
}

/// Where a frame was by the folder's own homographies.
#[derive(Debug, Clone, Copy)]
pub struct Truth {
    /// Displacement from frame 0 along `X_e` and `Y_e`, m.
    pub displacement: Vector2<f64>,
    /// Through the frames between, as no homography leads there from frame 0.
    pub chained: bool,
}

/// Opens a folder.
pub fn read(folder: &Path, limit: &Limit) -> Result<Sequence> {
    let name = folder.display();
    if !folder.is_dir() {
        bail!("{name}: is no folder; name a folder of frames");
    }
    let files = listed(&[folder.to_owned()])?;
    if files.len() < 2 {
        bail!("{name}: holds one picture; a sequence has at least two, the first is the reference");
    }
    let (mut frames, mut names) = (Vec::<Plane<u16>>::new(), Vec::new());
    let (mut whole, mut corner) = ((0, 0), (0, 0));
    for path in &files {
        let picture = open(path, limit, LEAST_SIDE, Some((KT27.width as usize, KT27.height as usize)))?;
        let size = (picture.luma.width(), picture.luma.height());
        if !frames.is_empty() && size != whole {
            let ((w, h), (first_w, first_h)) = (size, whole);
            bail!("{}: is {w}x{h}, and the frames before are {first_w}x{first_h}", path.display());
        }
        let frame = picture.crop(KT27.width as usize, KT27.height as usize);
        (whole, corner) = (size, (frame.x, frame.y));
        frames.push(frame.luma);
        names.push(path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned());
    }
    let table = folder.join("telemetry.csv");
    let assumed = !table.exists();
    let mut telemetry = if assumed { assume(frames.len()) } else { telemetry::read(&table, frames.len())? };
    // The telemetry tells the field of view of the whole picture, the frame is its centre.
    for readings in &mut telemetry {
        let part = frames[0].width() as f64 / whole.0 as f64;
        readings.field_of_view = 2.0 * (part * (readings.field_of_view / 2.0).tan()).atan();
    }
    let table = folder.join("pseudo_gt.csv");
    let truths = if table.exists() { truths(&table, &frames, corner, &telemetry)? } else { vec![None; frames.len()] };
    Ok(Sequence { frames, names, telemetry, assumed, truths })
}

fn assume(frames: usize) -> Vec<Telemetry> {
    let (range, field_of_view, sensors) = ASSUMED;
    let of_frame = |frame: usize| Telemetry {
        frame: frame as u32,
        time_us: (1e6 * APART * frame as f64) as u64,
        attitude: Attitude::default(),
        range,
        field_of_view: field_of_view * DEGREE,
        sensors,
    };
    (0..frames).map(of_frame).collect()
}

#[derive(Deserialize)]
struct Row {
    #[serde(rename = "ref")]
    reference: usize,
    frame: usize,
    ok: u8,
    h00: Option<f64>,
    h01: Option<f64>,
    h02: Option<f64>,
    h10: Option<f64>,
    h11: Option<f64>,
    h12: Option<f64>,
    h20: Option<f64>,
    h21: Option<f64>,
    h22: Option<f64>,
}

impl Row {
    fn homography(&self) -> Option<Matrix3<f64>> {
        let Self { h00, h01, h02, h10, h11, h12, h20, h21, h22, .. } = *self;
        (self.ok == 1).then_some(())?;
        Some(Matrix3::new(h00?, h01?, h02?, h10?, h11?, h12?, h20?, h21?, h22?))
    }
}

/// The displacement that each homography from frame 0 tells: that of the pose fit, with the same telemetry, of a grid
/// of points that it moves. So an estimate differs from it by its features and matches alone.
fn truths(
    table: &Path,
    frames: &[Plane<u16>],
    (x, y): (usize, usize),
    telemetry: &[Telemetry],
) -> Result<Vec<Option<Truth>>> {
    let name = table.display();
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(table)
        .with_context(|| format!("{name}: cannot be read"))?;
    let rows: Vec<Row> = reader.deserialize().collect::<Result<_, _>>().with_context(|| name.to_string())?;
    let corner = Vector2::new(x as f64, y as f64);
    let moved = |reference: usize, frame: usize| {
        let row = rows.iter().find(|row| (row.reference, row.frame) == (reference, frame))?;
        Some(Matrix3::new_translation(&-corner) * row.homography()? * Matrix3::new_translation(&corner))
    };
    let (width, height) = (frames[0].width(), frames[0].height());
    let mut before = Some(Matrix3::identity());
    let mut truths = vec![Some(Truth { displacement: Vector2::zeros(), chained: false })];
    for frame in 1..frames.len() {
        let direct = moved(0, frame);
        let homography = direct.or_else(|| Some(moved(frame - 1, frame)? * before?));
        before = homography;
        truths.push(homography.and_then(|homography| {
            let readings = [telemetry[0], telemetry[frame]];
            let displacement = displacement(&homography, (width, height), readings)?;
            Some(Truth { displacement, chained: direct.is_none() })
        }));
    }
    Ok(truths)
}

/// What the pose fit makes of a homography; nothing where too little of the frame stays in view or where the telemetry
/// contradicts it.
fn displacement(
    homography: &Matrix3<f64>,
    (width, height): (usize, usize),
    readings: [Telemetry; 2],
) -> Option<Vector2<f64>> {
    let (columns, rows) = GRID;
    let (right, bottom) = (width as f64 - 1.0, height as f64 - 1.0);
    let node = |i: usize| {
        let (column, row) = (i % columns, i / columns);
        let part = |k: usize, of: usize| k as f64 / (of - 1) as f64;
        Vector2::new(right * part(column, columns), bottom * part(row, rows))
    };
    let pairs: Vec<Pair> = (0..columns * rows)
        .filter_map(|i| Some(Pair { reference: node(i), current: transfer(homography, node(i))? }))
        .filter(|pair| (0.0..=right).contains(&pair.current.x) && (0.0..=bottom).contains(&pair.current.y))
        .collect();
    let view = |readings: &Telemetry| {
        let camera = Camera::with_field_of_view(width, height, readings.field_of_view).ok()?;
        View::new(camera, readings.attitude, readings.range).ok()
    };
    let fit = pose::fit(&view(&readings[0])?, &view(&readings[1])?, &readings[1].sensors, &pairs, u8::MAX);
    fit.ok().map(|pose| pose.displacement)
}
