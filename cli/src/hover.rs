//! `hoverlock hover`: a simulated helicopter in wind holds its position with the camera alone.

use std::any::Any;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context as _, Result};
use hoverlock_arm::calibration::Calibration;
use hoverlock_cosim::hover::{TABLE, table};
use hoverlock_cosim::sequence::{
    CALIBRATION, INERTIAL, TELEMETRY, calibration, frame_name, inertial_header, inertial_rows, is_frame, png,
    telemetry_header, telemetry_row,
};
use hoverlock_cosim::{BoxError, FrameProgress, HoverOutcome, HoverSettings, Monitor, hover};
use hoverlock_reports::output::PAGE;
use indicatif::ProgressBar;

use crate::Verdict;
use crate::choice::{Climb, Estimator, Features, View, between};
use crate::design::Chosen;
use crate::output::{Folder, command, discard, print, print_json, shown, unwritable, verdict, write_file};
use crate::progress::{LogLines, Reporter, bar};

/// Close the loop: a simulated helicopter in gusts holds its position with the camera's estimate alone.
///
/// Each frame is rendered from the position of the helicopter, taken by the camera with its noise, and goes through the
/// extractor and the flight program; the estimate steers the helicopter a tenth of a second later. The same helicopter
/// in the same wind without vision is flown beside it. Status 0 only if the position is held within the scene's bound,
/// vision is never lost for a second, and roll and pitch stay within 5 degrees; over open water, where no frame has an
/// estimate and the helicopter stays level.
///
/// Examples:
///   hoverlock hover
///   hoverlock hover --scene town --height 100 --seconds 60 --seed 7
///   hoverlock hover --scene my.toml --features rtl --estimator arm --seconds 5
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = include_str!("../help/hover.txt"))]
pub struct Args {
    /// A scene of the simulator, or a scene file
    #[arg(long, value_name = "NAME|FILE", default_value = "field")]
    scene: String,
    /// A scenario file: scene, errors of the camera and timed events; its keys replace the options
    #[arg(long, value_name = "FILE", conflicts_with = "scene")]
    scenario: Option<PathBuf>,
    /// Where features come from
    #[arg(long, value_enum, default_value = "fixed")]
    features: Features,
    /// Where the flight program runs
    #[arg(long, value_enum, default_value = "host")]
    estimator: Estimator,
    /// Duration, seconds
    #[arg(long, value_name = "T", default_value = "10", allow_negative_numbers = true,
        value_parser = between(1.0, 3600.0))]
    seconds: f64,
    /// Seed of wind, sensors, camera and scene
    #[arg(long, value_name = "S", default_value = "1", allow_negative_numbers = true)]
    seed: u64,
    /// Height over the mean ground, m: 10 to 300
    #[arg(long, value_name = "M", default_value = "50", allow_negative_numbers = true,
        value_parser = between(10.0, 300.0))]
    height: f64,
    /// Gusts, root mean square of each horizontal component, m/s
    #[arg(long, value_name = "V", default_value = "3", allow_negative_numbers = true, value_parser = between(0.0, 5.0))]
    gusts: f64,
    /// The height over time
    #[arg(long, value_enum, default_value = "hold")]
    altitude: Climb,
    /// The camera's field of view
    #[arg(long, value_enum, default_value = "wide")]
    view: View,
    /// Command the flight program to renew its reference after this time, seconds
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = between(0.0, 3600.0))]
    renew: Option<f64>,
    #[command(flatten)]
    chosen: Chosen,
    /// The folder for the page, index.html, and the table of each frame, hover.csv, which grows as it flies
    #[arg(long, value_name = "DIR", default_value = "out/hover")]
    out: PathBuf,
    /// Save the frames, their telemetry, the samples of the IMU and the calibration into this folder as it flies, for
    /// `hoverlock cosim`
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// One JSON object on stdout: pass rms_m max_m frames lost and more
    #[arg(long)]
    json: bool,
}

/// Shows the progress of a hover, writes its table frame by frame, and saves its frames.
struct Recorder {
    bar: ProgressBar,
    lines: LogLines,
    /// The table of the flight.
    table: PathBuf,
    /// The folder into which the flight is saved.
    save: Option<PathBuf>,
    calibration: Calibration,
    /// Results of an earlier run.
    earlier: Vec<PathBuf>,
    /// `None` before the first frame.
    files: Mutex<Option<Files>>,
}

/// The files that grow as it flies.
struct Files {
    /// `None` before the first row.
    table: Option<Growing>,
    saved: Option<Saved>,
}

/// A flight that is saved. It has a row of telemetry for each picture after each frame, so that one that is stopped is
/// replayed as it was flown.
struct Saved {
    folder: PathBuf,
    inertial: Growing,
    telemetry: Growing,
}

/// A text file that grows.
struct Growing {
    path: PathBuf,
    file: File,
}

impl Growing {
    /// Creates a file with a text.
    fn create(path: PathBuf, text: &str) -> Result<Self> {
        let file = File::create(&path).with_context(|| unwritable(&path))?;
        let mut growing = Self { path, file };
        growing.add(text)?;
        Ok(growing)
    }

    /// Appends a text.
    fn add(&mut self, text: &str) -> Result<()> {
        self.file.write_all(text.as_bytes()).with_context(|| unwritable(&self.path))
    }
}

impl Saved {
    /// Begins a flight: its calibration, and tables without rows.
    fn begin(folder: &Path, calibration: &Calibration) -> Result<Self> {
        write_file(&folder.join(CALIBRATION), calibration::text(calibration)?.as_bytes())?;
        Ok(Self {
            folder: folder.to_owned(),
            inertial: Growing::create(folder.join(INERTIAL), &inertial_header())?,
            telemetry: Growing::create(folder.join(TELEMETRY), &telemetry_header())?,
        })
    }

    /// Adds a frame.
    fn add(&mut self, frame: &FrameProgress<'_>) -> Result<()> {
        write_file(&self.folder.join(frame_name(frame.number)), &png(frame.picture)?)?;
        self.telemetry.add(&telemetry_row(frame.telemetry))?;
        self.inertial.add(&inertial_rows(frame.inertial))
    }
}

impl Files {
    /// Adds a frame to the table, and saves it.
    fn add(&mut self, table_path: &Path, frame: &FrameProgress<'_>) -> Result<()> {
        if let Some(saved) = &mut self.saved {
            saved.add(frame)?;
        }
        if let Some(row) = frame.row {
            let text = table(std::slice::from_ref(row))?;
            match &mut self.table {
                Some(table) => table.add(text.split_once('\n').map_or("", |(_, row)| row))?,
                none => *none = Some(Growing::create(table_path.to_owned(), &text)?),
            }
        }
        Ok(())
    }
}

impl Monitor for Recorder {
    fn long_step(&self, name: &'static str) -> Option<Box<dyn Any>> {
        Reporter.long_step(name)
    }

    fn remark(&self, text: &str) {
        Reporter.remark(text);
    }

    fn frame(&self, frame: &FrameProgress<'_>) -> Result<(), BoxError> {
        self.with_files(|files| files.add(&self.table, frame))?;
        let seconds = frame.telemetry.time_us as f64 / 1e6;
        let distance = 100.0 * frame.distance_m.unwrap_or_default();
        let quality = frame.quality.map_or("no estimate".to_owned(), |quality| format!("quality {quality}"));
        self.bar.set_length(frame.frames as u64);
        self.bar.set_message(format!("{seconds:.1} s, {distance:.0} cm from the target, {quality}"));
        self.bar.inc(1);
        self.lines.count(&self.bar, "frames");
        Ok(())
    }
}

impl Recorder {
    /// Passes the files on. Before the first time it removes the results of an earlier run and begins those of this
    /// one: a run that is stopped leaves no mixture of two flights.
    fn with_files(&self, change: impl FnOnce(&mut Files) -> Result<()>) -> Result<()> {
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        let files = match &mut *files {
            Some(files) => files,
            none => {
                self.earlier.iter().try_for_each(|file| discard(file))?;
                let saved = self.save.as_deref().map(|folder| Saved::begin(folder, &self.calibration)).transpose()?;
                none.insert(Files { table: None, saved })
            }
        };
        change(files)
    }

    /// Ends the progress. The files are begun even if no frame has arrived.
    fn finish(&self) -> Result<()> {
        self.bar.finish_and_clear();
        self.with_files(|_| Ok(()))
    }
}

pub fn run(args: &Args) -> Result<Verdict> {
    let mut settings = HoverSettings {
        scene: args.scene.clone(),
        design: args.chosen.design()?,
        features: args.features.into(),
        flight_program: args.estimator.into(),
        seconds: args.seconds,
        seed: args.seed,
        height_m: args.height,
        gusts_m_s: args.gusts,
        altitude: args.altitude.into(),
        view: args.view.into(),
        renew_after_s: args.renew,
        ..HoverSettings::default()
    };
    if let Some(path) = &args.scenario {
        settings.read_scenario(path)?;
    }
    let mut earlier = Vec::new();
    let folder = folder_of(&args.out, "hover", |name| [PAGE, TABLE].contains(&name), &mut earlier)?;
    let is_saved = |name: &str| [TELEMETRY, INERTIAL, CALIBRATION].contains(&name) || is_frame(name);
    let save = args.save.as_deref().map(|save| folder_of(save, "hover --save", is_saved, &mut earlier)).transpose()?;
    let recorder = Recorder {
        bar: bar(0, "{bar:32} {percent:>3} %  {elapsed}  {msg}"),
        lines: LogLines::new(),
        table: args.out.join(TABLE),
        save: args.save.clone(),
        calibration: settings.scenario.calibration.unwrap_or_default(),
        earlier,
        files: Mutex::default(),
    };
    let outcome = hover(&settings, &recorder)?;
    recorder.finish()?;
    write_file(&args.out.join(PAGE), outcome.page(&command())?.as_bytes())?;
    drop((folder, save));
    if args.json {
        print_json(&outcome)?;
    } else {
        print(&text(&outcome, &args.out))?;
    }
    Ok(outcome.summary.pass.into())
}

/// Makes the folder for the results of a verb, and adds those of an earlier run to `earlier`.
fn folder_of(path: &Path, verb: &str, is_result: impl Fn(&str) -> bool, earlier: &mut Vec<PathBuf>) -> Result<Folder> {
    let entries = fs::read_dir(path).into_iter().flatten().flatten();
    let names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    let results: Vec<&str> = names.iter().map(String::as_str).filter(|name| is_result(name)).collect();
    let folder = Folder::of(path, verb, &results)?;
    earlier.extend(results.into_iter().map(|name| path.join(name)));
    Ok(folder)
}

/// Describes a hover: its statistics, and the verdict.
fn text(outcome: &HoverOutcome, out: &Path) -> String {
    let summary = &outcome.summary;
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "{} for {} s at {} m in gusts of {} m/s, seed {}",
        shown(Path::new(&summary.scene)),
        summary.seconds,
        summary.height_m,
        summary.gusts_m_s,
        summary.seed
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
        "  frames             {} of {} with an estimate, {} lost after the first, longest loss {:.1} s, references: {}",
        summary.estimates, summary.frames, summary.lost, summary.longest_loss_s, summary.references
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
    let reason = summary.reason.clone().unwrap_or_else(|| outcome.checks.join("; "));
    text + &verdict(summary.pass, &reason) + "\n"
}
