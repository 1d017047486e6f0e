//! `hoverlock sim`: the hardware on pictures, under Verilator, against the bit-true model.

use std::path::PathBuf;

use anyhow::{Result, bail};
use hoverlock_fixed_point::{bit_true::ThresholdController, design::KT27, swift::Swift};
use hoverlock_reference::{picture::Picture, plane::Plane};
use hoverlock_rtl::simulation::{Job, Mismatch, Outcome, Simulator, Streams, run as simulate};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::Verdict;
use crate::output::{print, print_json};

/// Run the RTL on pictures under Verilator and compare every plane and every feature with the bit-true model.
///
/// All pictures go through back to back, each as often as --frames says. Status 0 only where nothing differs and features were compared.
///
/// Example: hoverlock sim aerial.png --stall 0.4 --seed 2
#[derive(clap::Args)]
pub struct Args {
    /// Pictures of the ground, at least 64x64; the centre 1024x768 of larger ones
    #[arg(value_name = "IMAGE", required = true)]
    images: Vec<PathBuf>,
    /// Frames of each picture; three or more of one size measure the cycles a pixel takes
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Chance, in each cycle and on each side, that no pixel is offered and no feature is taken: 0 to 0.95
    #[arg(long, value_name = "P", default_value_t = 0.0)]
    stall: f64,
    /// Seed of the stalls and of what memories hold at first
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// One JSON object on stdout: pixels cycles cycles_per_pixel features mismatches first_mismatch cycles_per_second pass
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    pixels: u64,
    cycles: u64,
    /// Nothing where fewer than three frames of one size came after one another, or where stalls make it meaningless.
    cycles_per_pixel: Option<f64>,
    features: u64,
    dropped: u64,
    samples: u64,
    mismatches: u64,
    first_mismatch: Option<Mismatch>,
    cycles_per_second: f64,
    latency_lines: Option<f64>,
    pass: bool,
}

pub fn run(args: &Args) -> Result<Verdict> {
    if !(0.0..=0.95).contains(&args.stall) {
        bail!("--stall {} is not a chance from 0 to 0.95; see --help", args.stall);
    }
    let pictures = args.images.iter().map(frame).collect::<Result<Vec<_>>>()?;
    let bar = ProgressBar::new_spinner();
    bar.set_message("building the Verilated model (once; later runs find it)");
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    let simulator = Simulator::new()?;
    bar.set_message("simulating");
    let mut jobs = Vec::new();
    for plane in &pictures {
        let thresholds = settled(plane)?;
        let job = Job::new(plane.clone(), thresholds)?;
        jobs.extend(std::iter::repeat_n(job, args.frames as usize));
    }
    let streams = Streams { source_pause: args.stall, sink_pause: args.stall, sink_opens: 0, seed: args.seed };
    let outcome = simulate(&simulator, &jobs, streams)?;
    bar.finish_and_clear();
    let pass = outcome.pass();
    let report = report(outcome, pass);
    if args.json {
        print_json(&report)?;
    } else {
        print(&summary(&report))?;
    }
    Ok(pass.into())
}

fn frame(path: &PathBuf) -> Result<Plane<u16>> {
    let picture = Picture::open(path)?.require(64, 64)?;
    let frame = picture.frame();
    if frame.is_cropped_from(&picture) {
        let (w, h) = (frame.luma.width(), frame.luma.height());
        eprintln!("hoverlock: {}: the {w}x{h} at ({}, {}) of it", path.display(), frame.x, frame.y);
    }
    Ok(frame.luma)
}

/// The thresholds at which the automatic control would rest on this picture.
fn settled(plane: &Plane<u16>) -> Result<[u32; 2]> {
    let mut swift = Swift::new(&KT27)?;
    let mut control = ThresholdController::new(&KT27);
    swift.frame(plane, control.thresholds());
    for _ in 0..64 {
        let before = control.thresholds();
        let features = swift.planes().features(before);
        control.finish_frame(hoverlock_fixed_point::bit_true::counts(&features));
        if control.thresholds() == before {
            break;
        }
    }
    Ok(control.thresholds())
}

fn report(outcome: Outcome, pass: bool) -> Report {
    Report {
        pixels: outcome.pixels,
        cycles: outcome.cycles,
        cycles_per_pixel: outcome.cycles_per_pixel,
        features: outcome.features,
        dropped: outcome.dropped,
        samples: outcome.samples,
        mismatches: outcome.mismatches,
        first_mismatch: outcome.first_mismatch,
        cycles_per_second: outcome.cycles_per_second,
        latency_lines: outcome.latency_lines,
        pass,
    }
}

fn summary(report: &Report) -> String {
    let mut text = format!(
        "{} pixels in {} cycles, {:.2} million cycles a second\n{} samples and {} features compared, {} features dropped\n",
        report.pixels,
        report.cycles,
        report.cycles_per_second / 1e6,
        report.samples,
        report.features,
        report.dropped
    );
    if let Some(rate) = report.cycles_per_pixel {
        text += &format!("{rate:.3} cycles a pixel\n");
    }
    match &report.first_mismatch {
        None => text += "0 mismatches\n",
        Some(first) => {
            text += &format!(
                "{} mismatches, the first in {}, frame {}, x {}, y {}, cycle {}:\n  expected {}\n  actual   {}\n",
                report.mismatches,
                first.stage,
                first.frame,
                first.x,
                first.y,
                first.cycle,
                first.expected,
                first.actual
            );
        }
    }
    text + if report.pass { "pass\n" } else { "FAIL\n" }
}
