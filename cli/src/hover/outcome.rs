//! What came of a hover: the checks, the table, the page.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result};
use hoverlock_arm::message::Telemetry;
use hoverlock_edss::camera::FRAME_RATE;
use hoverlock_edss::flight::{Row as Truth, Setup};
use hoverlock_edss::scene::Scene;
use hoverlock_edss::world::Exposure;
use hoverlock_reports::animation::{self, apng};
use hoverlock_reports::hover::{Frame, Hover, Picture, html};
use hoverlock_reports::output::PAGE;
use nalgebra::Vector2;
use serde::Serialize;

use super::Course;
use crate::chain::{Chain, Line, Program, Source, Written, named, told};
use crate::output::{command, shown, verdict, write_file};

/// Largest rms distance over flat ground, m.
const FLAT: f64 = 0.1;
/// The same over relief or buildings.
const RELIEF: f64 = 0.3;
/// Vision that is away for longer is lost, s.
const LOST: f64 = 1.0;
/// Roll and pitch at most, degrees.
const TILT: f64 = 5.0;
/// The table.
const TABLE: &str = "hover.csv";

/// A frame of a hover.
pub struct Row {
    truth: Truth,
    line: Line,
    telemetry: Telemetry,
    /// Where the helicopter without vision is.
    blind: Vector2<f64>,
}

impl Row {
    pub fn new(exposure: &Exposure, telemetry: &Telemetry, written: &Written, blind: Vector2<f64>) -> Self {
        Self { truth: exposure.moment.row(), line: written.read.clone(), telemetry: *telemetry, blind }
    }

    fn place(&self) -> Vector2<f64> {
        Vector2::new(self.truth.x, self.truth.y)
    }

    /// A word for the progress.
    pub fn told(&self, outcome: &Outcome) -> String {
        let off = (self.place() - outcome.rows.first().map_or(self.place(), Row::place)).norm();
        let quality = self.line.quality.map_or("no estimate".to_owned(), |quality| format!("quality {quality}"));
        format!("{:.1} s, {:.0} cm from the target, {quality}", self.truth.time, 100.0 * off)
    }
}

/// A row of the table beside the truth: estimate and sensors; SI units and radians.
#[derive(Serialize)]
struct Record<'a> {
    status: &'a str,
    reason: Option<&'a str>,
    reference: Option<usize>,
    estimate_x: Option<f64>,
    estimate_y: Option<f64>,
    estimate_z: Option<f64>,
    sigma_x: Option<f64>,
    sigma_y: Option<f64>,
    quality: Option<u8>,
    inliers: Option<usize>,
    matches: Option<usize>,
    features: usize,
    told_roll: f64,
    told_pitch: f64,
    told_yaw: f64,
    told_range: f64,
    field_of_view: f64,
    blind_x: f64,
    blind_y: f64,
}

/// What `--json` tells.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    pub pass: bool,
    pub scene: String,
    #[serde(serialize_with = "named")]
    pub features: Source,
    #[serde(serialize_with = "named")]
    pub estimator: Program,
    pub seed: u64,
    pub seconds: f64,
    pub height_m: f64,
    pub gusts_m_s: f64,
    /// Distance from the target.
    pub rms_m: f64,
    pub max_m: f64,
    /// What `rms_m` must not exceed; null where nothing can be held.
    pub bound_m: Option<f64>,
    /// The same of the helicopter that has its IMU only.
    pub imu_only_rms_m: f64,
    pub imu_only_max_m: f64,
    /// Estimate less truth.
    pub error_rms_m: Option<f64>,
    pub frames: usize,
    /// Frames with an estimate.
    pub estimates: usize,
    /// Frames without one after the first that has one; over water all but the reference.
    pub lost: usize,
    /// Longest time without vision.
    pub longest_loss_s: f64,
    /// Frames that were reference.
    pub references: usize,
    /// Largest of roll and pitch.
    pub tilt_max_deg: f64,
    /// Clock cycles of the simulated hardware.
    pub cycles: Option<u64>,
    /// Time that it took.
    pub wall_s: f64,
    /// Why it fails.
    pub reason: Option<String>,
}

/// What came of a hover.
pub struct Outcome {
    pub rows: Vec<Row>,
    pub stills: Vec<Picture>,
    pub scenes: Vec<animation::Scene>,
    pub summary: Summary,
    setup: Vec<(String, String)>,
    checks: Vec<String>,
}

impl Outcome {
    /// Of a hover that begins.
    pub fn new(course: &Course, scene: &Scene, setup: &Setup, latency: f64) -> Self {
        let bound = if scene.is_flat() { FLAT } else { RELIEF };
        let degrees = |angle: f64| format!("{:.1} degrees rms", angle.to_degrees());
        let told = [
            ("scene", course.scene.clone()),
            ("height", format!("{} m over the mean ground", course.height)),
            ("gusts", format!("{} m/s rms each horizontal component, Dryden's spectra", course.gusts)),
            (
                "IMU",
                format!("{} of roll and pitch, {} of yaw", degrees(setup.tilt_noise), degrees(setup.heading_noise)),
            ),
            ("laser", format!("{} m rms", setup.laser_noise)),
            ("vision", format!("{FRAME_RATE} frames a second, each known {:.0} ms after its exposure", 1e3 * latency)),
            ("seed", course.seed.to_string()),
        ];
        Self {
            rows: Vec::new(),
            stills: Vec::new(),
            scenes: Vec::new(),
            summary: Summary {
                pass: false,
                scene: course.scene.clone(),
                features: course.features,
                estimator: course.estimator,
                seed: course.seed,
                seconds: course.seconds,
                height_m: course.height,
                gusts_m_s: course.gusts,
                rms_m: 0.0,
                max_m: 0.0,
                bound_m: (!scene.is_water()).then_some(bound),
                imu_only_rms_m: 0.0,
                imu_only_max_m: 0.0,
                error_rms_m: None,
                frames: 0,
                estimates: 0,
                lost: 0,
                longest_loss_s: 0.0,
                references: 0,
                tilt_max_deg: 0.0,
                cycles: None,
                wall_s: 0.0,
                reason: None,
            },
            setup: told.map(|(name, value)| (name.to_owned(), value)).into(),
            checks: Vec::new(),
        }
    }

    /// The place to be held.
    pub fn target(&self) -> Vector2<f64> {
        self.rows.first().map_or(Vector2::zeros(), Row::place)
    }

    /// Checks the whole hover.
    pub fn finish(&mut self, chain: &Chain, scene: &Scene, wall: f64) {
        let target = self.target();
        let blind = self.rows.first().map_or(target, |row| row.blind);
        let statistics = |distances: Vec<f64>| {
            let squares: f64 = distances.iter().map(|d| d * d).sum();
            ((squares / distances.len().max(1) as f64).sqrt(), distances.into_iter().fold(0.0, f64::max))
        };
        let summary = &mut self.summary;
        let rows = &self.rows;
        (summary.rms_m, summary.max_m) = statistics(rows.iter().map(|row| (row.place() - target).norm()).collect());
        (summary.imu_only_rms_m, summary.imu_only_max_m) =
            statistics(rows.iter().map(|row| (row.blind - blind).norm()).collect());
        let errors: Vec<f64> =
            rows.iter().filter_map(|row| Some((row.line.displacement()? - (row.place() - target)).norm())).collect();
        summary.estimates = errors.len();
        summary.error_rms_m = (!errors.is_empty()).then(|| statistics(errors).0);
        summary.frames = rows.len();
        // Until the reference is proved there is nothing to lose.
        let first = rows.iter().position(|row| row.line.x_e_m.is_some()).unwrap_or(1);
        summary.lost = rows.iter().skip(first).filter(|row| row.line.x_e_m.is_none()).count();
        let away = rows.iter().skip(first).scan(0usize, |away, row| {
            *away = if row.line.x_e_m.is_none() { *away + 1 } else { 0 };
            Some(*away)
        });
        summary.longest_loss_s = away.max().unwrap_or(0) as f64 / FRAME_RATE;
        let mut references: Vec<_> = rows.iter().filter_map(|row| row.line.reference).collect();
        references.dedup();
        summary.references = references.len();
        let tilt = rows.iter().flat_map(|row| [row.truth.roll, row.truth.pitch]).map(f64::abs).fold(0.0, f64::max);
        summary.tilt_max_deg = tilt.to_degrees();
        (summary.cycles, summary.wall_s) = (chain.cycles(), wall);

        let mut checks = Vec::new();
        let mut check = |text: String, passes: bool| checks.push((text, passes));
        if let Some(frame) = chain.differs() {
            check(format!("frame {frame}: the ARM binary's line is not the host's; is `make arm` up to date?"), false);
        }
        if scene.is_water() {
            let found = summary.estimates;
            check(format!("{found} estimates over water, where none can be right"), found == 0);
        } else {
            let bound = summary.bound_m.unwrap_or(RELIEF);
            if summary.estimates == 0 {
                let reason = rows.last().and_then(|row| row.line.reason.clone()).unwrap_or_default();
                check(format!("no frame has an estimate: {reason}"), false);
            }
            check(format!("{:.3} m rms from the target, at most {bound}", summary.rms_m), summary.rms_m <= bound);
            let longest = summary.longest_loss_s;
            check(format!("vision away for {longest:.1} s at the longest, at most {LOST}"), longest <= LOST);
        }
        let tilt = summary.tilt_max_deg;
        check(format!("roll and pitch within {tilt:.1} degrees, at most {TILT}"), tilt <= TILT);
        let failed: Vec<&str> = checks.iter().filter(|(_, passes)| !passes).map(|(text, _)| text.as_str()).collect();
        summary.pass = failed.is_empty();
        summary.reason = (!summary.pass).then(|| failed.join("; "));
        self.checks = checks.into_iter().map(|(text, _)| text).collect();
    }

    /// The page and the table.
    pub fn write(&self, out: &Path) -> Result<()> {
        write_file(&out.join(PAGE), self.page()?.as_bytes())?;
        write_file(&out.join(TABLE), self.table()?.as_bytes())
    }

    /// Truth and estimate side by side.
    fn table(&self) -> Result<String> {
        fn record(row: &Row) -> Record<'_> {
            let Row { line, telemetry, blind, .. } = row;
            let sigma = |i: usize| line.covariance_m2.map(|covariance| covariance[i].sqrt());
            Record {
                status: &line.status,
                reason: line.reason.as_deref(),
                reference: line.reference,
                estimate_x: line.x_e_m,
                estimate_y: line.y_e_m,
                estimate_z: line.z_e_m,
                sigma_x: sigma(0),
                sigma_y: sigma(3),
                quality: line.quality,
                inliers: line.inliers,
                matches: line.matches,
                features: line.features,
                told_roll: telemetry.attitude.roll,
                told_pitch: telemetry.attitude.pitch,
                told_yaw: telemetry.attitude.yaw,
                told_range: telemetry.range,
                field_of_view: telemetry.field_of_view,
                blind_x: blind.x,
                blind_y: blind.y,
            }
        }
        let mut truths = csv::Writer::from_writer(Vec::new());
        let mut records = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            truths.serialize(row.truth).context("a row of the table")?;
            records.serialize(record(row)).context("a row of the table")?;
        }
        let text = |table: csv::Writer<Vec<u8>>| -> Result<String> {
            Ok(String::from_utf8(table.into_inner().context("the table")?)?)
        };
        let (truths, records) = (text(truths)?, text(records)?);
        // No field has a line break.
        Ok(truths.lines().zip(records.lines()).map(|(truth, record)| format!("{truth},{record}\n")).collect())
    }

    fn page(&self) -> Result<String> {
        let (summary, target) = (&self.summary, self.target());
        let blind = self.rows.first().map_or(target, |row| row.blind);
        let frame = |row: &Row| {
            let place = row.place() - target;
            Frame {
                time: row.truth.time,
                truth: [place.x, place.y, -row.truth.z],
                status: row.line.status.clone(),
                reason: row.line.reason.clone(),
                estimate: row.line.estimate(),
                reference: row.line.reference,
                features: row.line.features,
                wind: [row.truth.wind_x, row.truth.wind_y, row.truth.wind_z],
                tilt: [row.truth.roll, row.truth.pitch].map(f64::to_degrees),
                field_of_view: row.telemetry.field_of_view.to_degrees(),
                blind: (row.blind - blind).norm(),
            }
        };
        let apart = self.scenes.get(1).map_or(0.1, |scene| scene.time - self.scenes[0].time);
        // Twice as fast as it was, but no slower than a person waits.
        let pause = Duration::from_secs_f64((apart / 2.0).clamp(0.05, 0.25));
        let reach = (1.2 * summary.max_m).clamp(0.25, 5.0);
        let [features, estimator] = told(summary.features, summary.estimator);
        let hover = Hover {
            scene: summary.scene.clone(),
            setup: self.setup.clone(),
            features,
            estimator,
            failure: summary.reason.clone(),
            checks: self.checks.clone(),
            hold: [summary.rms_m, summary.max_m],
            blind: [summary.imu_only_rms_m, summary.imu_only_max_m],
            error: summary.error_rms_m,
            bound: summary.bound_m,
            frames: self.rows.iter().map(frame).collect(),
            stills: self.stills.clone(),
            animation: apng(&self.scenes, pause, reach).context("the animation")?,
        };
        Ok(html(&hover, &command())?)
    }

    /// What a person reads.
    pub fn text(&self, out: &Path) -> String {
        let summary = &self.summary;
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{} for {} s at {} m in gusts of {} m/s, seed {}",
            summary.scene, summary.seconds, summary.height_m, summary.gusts_m_s, summary.seed
        );
        let _ = writeln!(text, "  from the target    {:.3} m rms, {:.3} m at most", summary.rms_m, summary.max_m);
        let _ = writeln!(
            text,
            "  with the IMU only  {:.3} m rms, {:.3} m at most",
            summary.imu_only_rms_m, summary.imu_only_max_m
        );
        if let Some(error) = summary.error_rms_m {
            let _ = writeln!(text, "  estimate           {error:.3} m rms from the truth");
        }
        let _ = writeln!(
            text,
            "  frames             {} with an estimate, {} without, longest loss {:.1} s, {} references",
            summary.estimates, summary.lost, summary.longest_loss_s, summary.references
        );
        let _ = writeln!(
            text,
            "  time               {:.1} s, {:.0} ms a frame",
            summary.wall_s,
            1e3 * summary.wall_s / summary.frames.max(1) as f64
        );
        if let Some(cycles) = summary.cycles {
            let _ = writeln!(text, "  hardware           {cycles} clock cycles");
        }
        let _ = writeln!(text, "{}", shown(&out.join(PAGE)));
        let told = summary.reason.clone().unwrap_or_else(|| self.checks.join("; "));
        text + &verdict(summary.pass, &told) + "\n"
    }
}
