//! `hoverlock cosim`: a folder of frames through extractor and flight program together.

mod sequence;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use hoverlock_reference::motion::model::Pair;
use hoverlock_reports::flight::{Flight, Frame, html};
use hoverlock_reports::output::PAGE;
use nalgebra::Vector2;
use serde::Serialize;
use serde_json::value::RawValue;

use crate::Verdict;
use crate::chain::{Chain, Line, Program, Source, Written, named, suits, told};
use crate::design::Chosen;
use crate::output::{Folder, command, lossy, print, print_json, shown, spinning, verdict, write_file};
use crate::picture::Limit;
use sequence::{ASSUMED_TEXT, Sequence, Truth};

/// Run a folder of frames through extractor and flight program together, and show where the camera was.
///
/// The first frame is the reference. The frames are the pictures of the folder by name, of one size.
/// With --features rtl they enter the pixel port of the Verilated top; the records go through a DMA into a ring of
/// buffers in simulated memory, and a model of the CPU takes them from there at the interrupt. Status 0 only where
/// some frame has an estimate and, with --estimator arm, where the ARM binary writes the host's lines byte for byte.
///
/// Examples:
///   hoverlock cosim flight/
///   hoverlock cosim flight/ --features rtl --estimator arm --out out/cosim
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = HELP)]
pub struct Args {
    /// A folder of frames: 00.png, 01.png, ..; beside them, where known, telemetry.csv and pseudo_gt.csv
    #[arg(value_name = "SEQUENCE_DIR")]
    sequence: PathBuf,
    /// Where features come from
    #[arg(long, value_enum, default_value = "fixed")]
    features: Source,
    /// Where the flight program runs
    #[arg(long, value_enum, default_value = "host")]
    estimator: Program,
    #[command(flatten)]
    chosen: Chosen,
    /// Write a page about the run, index.html, into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    limit: Limit,
    /// One JSON object on stdout: ok sequence features estimator telemetry estimates[] (the flight program's own
    /// lines, one per frame) pseudo_truth[] against_truth cycles seconds reason
    #[arg(long)]
    json: bool,
}

const HELP: &str = concat!(
    "Without telemetry.csv the telemetry is assumed: roll, pitch and yaw 0, range 20 m, field of view 50 degrees, \
     frames 2 s apart so that none predicts the next; standard errors 5 degrees of tilt, 10 of heading, 1 m of range. \
     Metres are then only as true as that.\n\n",
    "pseudo_gt.csv has homographies fitted to the pictures, ref to frame: columns ref, frame, ok, h00 .. h22. They are \
     no ground truth. The displacement told from one is that of the pose fit of a grid that it moves, with the same \
     telemetry: the error told against it is that of features and matches alone.\n\n",
    "The ARM binary is that of `make arm`; HOVERLOCK_NAV names another.\n\n",
    telemetry_help!()
);

#[derive(Serialize)]
struct Report {
    ok: bool,
    #[serde(serialize_with = "lossy")]
    sequence: PathBuf,
    #[serde(serialize_with = "named")]
    features: Source,
    #[serde(serialize_with = "named")]
    estimator: Program,
    telemetry: &'static str,
    /// The lines as the flight program wrote them.
    estimates: Vec<Box<RawValue>>,
    /// From the homographies of the folder, one per frame, or nothing.
    pseudo_truth: Vec<Option<Position>>,
    against_truth: Option<Accuracy>,
    /// Simulated clock cycles, with features of the hardware.
    cycles: Option<u64>,
    seconds: f64,
    /// Why `ok` is false.
    reason: Option<String>,
    #[serde(skip)]
    page: Option<PathBuf>,
    #[serde(skip)]
    rows: Vec<Row>,
}

/// A position beside an estimate, m.
#[derive(Debug, Clone, Copy, Serialize)]
struct Position {
    x_e_m: f64,
    y_e_m: f64,
    /// Through the frames between.
    chained: bool,
}

/// Estimates against the homographies of the folder.
#[derive(Debug, Clone, Copy, Serialize)]
struct Accuracy {
    /// Frames that have both.
    frames: usize,
    rms_m: f64,
    max_m: f64,
}

/// A frame of the result.
struct Row {
    name: String,
    line: Line,
    truth: Option<Truth>,
    inliers: Vec<Pair>,
}

impl Row {
    /// Of an estimate that a homography leads to.
    fn error(&self) -> Option<Vector2<f64>> {
        Some(self.line.displacement()? - self.truth?.displacement)
    }
}

pub fn run(args: &Args) -> Result<Verdict> {
    // A binary that is missing or does not suit is told before anything is computed.
    suits(args.features, &args.chosen.design()?, args.estimator)?;
    args.estimator.find()?;
    let sequence = sequence::read(&args.sequence, &args.limit)?;
    let folder = args.out.as_deref().map(Folder::new).transpose()?;
    let report = spinning("frames through extractor and flight program", || fly(args, &sequence))?;
    if let Some(out) = &args.out {
        write_file(&out.join(PAGE), report.page(&sequence)?.as_bytes())?;
    }
    drop(folder);
    if args.json {
        print_json(&report)?;
    } else {
        print(&report.text())?;
    }
    Ok(report.ok.into())
}

/// The frames in order, each with its telemetry.
fn fly(args: &Args, sequence: &Sequence) -> Result<Report> {
    let started = Instant::now();
    let mut chain = Chain::start(args.features, &args.chosen.design()?, args.estimator, &sequence.frames[0])?;
    let (mut rows, mut estimates) = (Vec::new(), Vec::new());
    for (i, (telemetry, frame)) in sequence.telemetry.iter().zip(&sequence.frames).enumerate() {
        let Written { line, read, inliers } = chain.frame(telemetry, frame)?;
        rows.push(Row { name: sequence.names[i].clone(), line: read, truth: sequence.truths[i], inliers });
        estimates.push(RawValue::from_string(line)?);
    }
    let reason = match chain.differs() {
        Some(frame) => {
            Some(format!("frame {frame}: the ARM binary's line is not the host's; is `make arm` up to date?"))
        }
        None if rows.iter().all(|row| row.line.x_e_m.is_none()) => {
            let first = rows.iter().find_map(|row| row.line.reason.clone()).unwrap_or_default();
            Some(format!("no frame has an estimate: {first}"))
        }
        None => None,
    };
    Ok(Report {
        ok: reason.is_none(),
        sequence: args.sequence.clone(),
        features: args.features,
        estimator: args.estimator,
        telemetry: if sequence.assumed { ASSUMED_TEXT } else { "telemetry.csv" },
        estimates,
        pseudo_truth: rows
            .iter()
            .map(|row| {
                row.truth.map(|t| Position { x_e_m: t.displacement.x, y_e_m: t.displacement.y, chained: t.chained })
            })
            .collect(),
        against_truth: accuracy(&rows),
        cycles: chain.cycles(),
        seconds: started.elapsed().as_secs_f64(),
        reason,
        page: args.out.as_ref().map(|out| out.join(PAGE)),
        rows,
    })
}

/// Over the frames that have an estimate and a homography from frame 0.
fn accuracy(rows: &[Row]) -> Option<Accuracy> {
    let errors: Vec<f64> = rows.iter().filter_map(Row::error).map(|error| error.norm()).collect();
    (!errors.is_empty()).then(|| Accuracy {
        frames: errors.len(),
        rms_m: (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt(),
        max_m: errors.iter().copied().fold(0.0, f64::max),
    })
}

impl Report {
    /// The run as a page.
    fn page(&self, sequence: &Sequence) -> Result<String> {
        let [features, estimator] = told(self.features, self.estimator);
        let frames = self.rows.iter().zip(&sequence.frames).map(|(row, picture)| Frame {
            name: row.name.clone(),
            status: row.line.status.clone(),
            reason: row.line.reason.clone(),
            features: row.line.features,
            estimate: row.line.estimate(),
            truth: row.truth.map(|truth| truth.displacement.into()),
            chained: row.truth.is_some_and(|truth| truth.chained),
            picture,
            inliers: row.inliers.clone(),
        });
        let folder = self.sequence.canonicalize().unwrap_or_else(|_| self.sequence.clone());
        Ok(html(&Flight {
            name: folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned(),
            command: command(),
            features,
            estimator,
            telemetry: self.telemetry.into(),
            failure: self.reason.clone(),
            cycles: self.cycles,
            frames: frames.collect(),
        })?)
    }

    fn text(&self) -> String {
        let mut text = format!("telemetry {}\n", self.telemetry);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{:<14} {:<9} {:>9} {:>9} {:>8} {:>7} {:>11} {:>8}",
            "frame", "status", "X_e, m", "Y_e, m", "sigma, m", "quality", "inliers", "error, m"
        );
        for row in &self.rows {
            let line = &row.line;
            let _ = write!(text, "{:<14} {:<9}", row.name, line.status);
            if let (Some(at), Some([xx, _, _, yy])) = (line.displacement(), line.covariance_m2) {
                let count = |count: Option<usize>| count.unwrap_or_default();
                let agree = format!("{} of {}", count(line.inliers), count(line.matches));
                let quality = line.quality.unwrap_or_default();
                let sigma = xx.max(yy).sqrt();
                let error = row.error().map_or("-".to_owned(), |error| format!("{:.3}", error.norm()));
                let _ = write!(text, " {:>9.3} {:>9.3} {sigma:>8.3} {quality:>7} {agree:>11} {error:>8}", at.x, at.y);
            } else if let Some(reason) = &line.reason {
                let _ = write!(text, " {reason}; {} features", line.features);
            }
            text.push('\n');
        }
        if let Some(Accuracy { frames, rms_m, max_m }) = self.against_truth {
            let _ = writeln!(
                text,
                "against the homographies of pseudo_gt.csv, {frames} frames: {rms_m:.3} m rms, {max_m:.3} m at most"
            );
        }
        if let Some(cycles) = self.cycles {
            let _ = writeln!(text, "{cycles} clock cycles of the hardware in {:.1} s", self.seconds);
        }
        if let Some(page) = &self.page {
            let _ = writeln!(text, "{}", shown(page));
        }
        let estimates = self.rows.iter().filter(|row| row.line.x_e_m.is_some()).count();
        let told = match &self.reason {
            Some(reason) => reason.clone(),
            None => format!("{estimates} estimates in {} frames", self.rows.len()),
        };
        text + &verdict(self.ok, &told) + "\n"
    }
}
