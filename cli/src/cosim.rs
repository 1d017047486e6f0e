//! `hoverlock cosim`: a folder of frames through extractor and flight program together.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use hoverlock_cosim::{Accuracy, CosimOutcome, CosimSettings, cosim};
use hoverlock_reports::output::PAGE;

use crate::Verdict;
use crate::choice::{Estimator, Features};
use crate::design::Chosen;
use crate::output::{Folder, command, print, print_json, shown, verdict, write_file};
use crate::picture::Limit;
use crate::progress::Reporter;

/// Run a folder of frames through extractor and flight program together, and show the track of the camera.
///
/// The first frame is the reference. The frames are the pictures of the folder by name, 2.png before 10.png, of one
/// size.
/// With --features rtl they enter the pixel port of the Verilated top; the records go through a DMA into a ring of
/// buffers in simulated memory, and a model of the CPU takes them from there at the interrupt. Status 0 only if
/// some frame has an estimate and, with --estimator arm, if the ARM binary writes the host's lines byte for byte.
/// The verdict says how many of the frames that features in floating point solve have an estimate.
///
/// Examples:
///   hoverlock cosim flight/
///   hoverlock cosim flight/ --features rtl --estimator arm --out out/cosim
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = HELP)]
pub struct Args {
    /// A folder of frames: 00.png, 01.png, ..; beside them, if known, telemetry.csv, inertial.csv, calibration.toml and
    /// pseudo_gt.csv
    #[arg(value_name = "SEQUENCE_DIR")]
    sequence: PathBuf,
    /// Where features come from
    #[arg(long, value_enum, default_value = "fixed")]
    features: Features,
    /// Where the flight program runs
    #[arg(long, value_enum, default_value = "host")]
    estimator: Estimator,
    #[command(flatten)]
    chosen: Chosen,
    /// Write a page about the run, index.html, into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    limit: Limit,
    /// One JSON object on stdout: ok sequence features estimator telemetry estimates[] (the flight program's own
    /// lines, one per frame) pseudo_truth[] against_truth cycles seconds float (solved estimated) reason
    #[arg(long)]
    json: bool,
}

const HELP: &str = concat!(include_str!("../help/cosim.txt"), include_str!("../help/telemetry.txt"));

pub fn run(args: &Args) -> Result<Verdict> {
    let settings = CosimSettings {
        sequence: args.sequence.clone(),
        design: args.chosen.design()?,
        features: args.features.into(),
        flight_program: args.estimator.into(),
        limits: args.limit.limits(),
    };
    let folder = args.out.as_deref().map(|out| Folder::of(out, "cosim", &[PAGE])).transpose()?;
    let outcome = cosim(&settings, &Reporter)?;
    if let Some(out) = &args.out {
        write_file(&out.join(PAGE), outcome.page(&command())?.as_bytes())?;
    }
    drop(folder);
    if args.json {
        print_json(&outcome)?;
    } else {
        print(&text(&outcome, args.out.as_deref()))?;
    }
    Ok(outcome.ok.into())
}

/// Describes a run: a table of its frames, and the verdict.
fn text(outcome: &CosimOutcome, out: Option<&Path>) -> String {
    let mut text = format!("telemetry {}\n", outcome.telemetry);
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "{:<14} {:<9} {:>9} {:>9} {:>8} {:>7} {:>11} {:>8}",
        "frame", "status", "X_e, m", "Y_e, m", "sigma, m", "quality", "inliers", "error, m"
    );
    for frame in &outcome.frames {
        let line = &frame.line;
        let _ = write!(text, "{:<14} {:<9}", shown(Path::new(&frame.name)), line.status);
        if let (Some(at), Some([xx, _, _, yy])) = (line.displacement(), line.covariance_m2) {
            let count = |count: Option<usize>| count.unwrap_or_default();
            let agree = format!("{} of {}", count(line.inliers), count(line.matches));
            let quality = line.quality.unwrap_or_default();
            let sigma = xx.max(yy).sqrt();
            let error = frame.error().map_or("-".to_owned(), |error| format!("{:.3}", error.norm()));
            let _ = write!(text, " {:>9.3} {:>9.3} {sigma:>8.3} {quality:>7} {agree:>11} {error:>8}", at.x, at.y);
        } else if let Some(reason) = &line.reason {
            let _ = write!(text, " {reason}; {} features", line.features);
        }
        text.push('\n');
    }
    if let Some(Accuracy { frames, rms_m, max_m }) = outcome.against_truth {
        let _ = writeln!(
            text,
            "against the homographies of pseudo_gt.csv, {frames} frames: {rms_m:.3} m rms, {max_m:.3} m at most"
        );
    }
    if let Some(cycles) = outcome.cycles {
        let _ = writeln!(text, "{cycles} clock cycles of the hardware in {:.1} s", outcome.seconds);
    }
    if let Some(out) = out {
        let _ = writeln!(text, "{}", shown(&out.join(PAGE)));
    }
    let reason = outcome.reason.clone().unwrap_or_else(|| outcome.coverage());
    text + &verdict(outcome.ok, &reason) + "\n"
}
