//! `hoverlock sim`: the emitted Verilog under Verilator, compared with the bit-true model on pictures.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use hoverlock_design::{DesignPoint, MIN_SIDE};
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::fastest::FastestModel;
use hoverlock_pictures::folder::expand;
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::{
    FrameOutcome, Job, Mismatch, Outcome, Simulator, Streams, Trace, Window, format_of, record, run_with_progress, view,
};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde::Serialize;

use crate::Verdict;
use crate::design::{Chosen, verilog_of};
use crate::output::{
    Aside, Batch, Folder, lossy, lossy_option, prepare_target, print, print_json, quoted, shown, verdict,
};
use crate::picture::{Limit, open};
use crate::progress::spinning;

/// Run the RTL on pictures under Verilator and compare every plane and every feature with the bit-true model.
///
/// All pictures go through back to back, each as often as --frames says. Status 0 only if nothing differs and
/// features of every picture were compared.
///
/// Example: hoverlock sim aerial.png --stall 0.4 --seed 2 --wave aerial.fst
#[derive(clap::Args)]
pub struct Args {
    /// Pictures of the ground, at least 64x64, or folders of them; - reads one from standard input; the centre of
    /// larger ones, of the size of the design
    #[arg(value_name = "IMAGE", required = true)]
    images: Vec<PathBuf>,
    /// Frames of each picture; three or more of one size measure the cycles a pixel takes
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Chance, in each cycle and on each side, that no pixel is offered and no feature is taken: 0 to 0.95
    #[arg(long, value_name = "P", default_value_t = 0.0)]
    stall: f64,
    /// Take no feature before this clock cycle: the record FIFO fills, and what then finds no room must be counted as
    /// dropped
    #[arg(
        long,
        value_name = "CYCLE",
        default_value_t = 0,
        value_parser = clap::value_parser!(u64).range(..=1_000_000_000)
    )]
    sink_opens: u64,
    /// Seed of the stalls and of what memories hold at first
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Waves of a second, equal run into FILE.fst or FILE.vcd, and beside it FILE.gtkw, the pipeline in groups for
    /// GTKWave: a window of --wave-cycles, most of it before the first mismatch, or before the first feature where
    /// nothing differs
    #[arg(long, value_name = "FILE")]
    wave: Option<PathBuf>,
    /// Clock cycles the waves hold, of all signals: 3.5 MB of FST for a thousand of a full frame
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4096,
        value_parser = clap::value_parser!(u64).range(1..),
        requires = "wave"
    )]
    wave_cycles: u64,
    /// First clock cycle of the waves, in place of the window's own choice; 0 shows the reset and the register writes
    #[arg(long, value_name = "CYCLE", requires = "wave")]
    wave_from: Option<u64>,
    #[command(flatten)]
    chosen: Chosen,
    /// Simulate the Verilog files of this folder, against the model of the design, in place of the design's own
    #[arg(long, value_name = "DIR")]
    rtl: Option<PathBuf>,
    #[command(flatten)]
    limit: Limit,
    /// One JSON object on stdout: pixels cycles cycles_per_pixel features dropped model_features mismatches
    /// first_mismatch cycles_per_second latency_lines verilog pictures[] pass
    #[arg(long)]
    json: bool,
}

/// The hardware that was simulated.
#[derive(Serialize)]
struct Verilog {
    /// Name of the design whose model gave the expected values.
    design: String,
    #[serde(serialize_with = "lossy")]
    folder: PathBuf,
    /// The hash of the emission, as the simulated register `emission` shows it.
    emission: String,
}

#[derive(Serialize)]
struct Report {
    pixels: u64,
    cycles: u64,
    /// `None` if fewer than three frames of one size follow each other, or if pauses make it meaningless.
    cycles_per_pixel: Option<f64>,
    features: u64,
    dropped: u64,
    /// `features + dropped` if nothing differs.
    model_features: u64,
    samples: u64,
    /// `None` if no feature was compared and nothing else differs.
    mismatches: Option<u64>,
    first_mismatch: Option<First>,
    cycles_per_second: f64,
    /// Latency from a pixel to its smoothed sample.
    latency_lines: Option<f64>,
    /// Latency from the pixel of a feature to its record.
    feature_latency_lines: Option<f64>,
    pictures: Vec<PerPicture>,
    #[serde(serialize_with = "lossy_option")]
    wave: Option<PathBuf>,
    verilog: Verilog,
    pass: bool,
}

/// The first mismatch, and the picture that has it.
#[derive(Serialize)]
struct First {
    #[serde(serialize_with = "lossy")]
    image: PathBuf,
    #[serde(flatten)]
    mismatch: Mismatch,
}

/// The frames of one picture.
#[derive(Serialize)]
struct PerPicture {
    #[serde(serialize_with = "lossy")]
    image: PathBuf,
    frames: usize,
    model_features: u64,
    features: u64,
    dropped: u64,
    mismatches: Option<u64>,
}

pub fn run(args: &Args) -> Result<Verdict> {
    if !(0.0..=0.95).contains(&args.stall) {
        bail!("--stall {} is not a chance from 0 to 0.95; see --help", args.stall);
    }
    let design = args.chosen.design()?.of_hardware();
    design.check_buildable()?;
    let images = expand(&args.images)?;
    let wave = args.wave.as_deref().map(|path| WaveFile::new(path, &images)).transpose()?;
    let pictures = images.iter().map(|path| frame(&design, path, &args.limit)).collect::<Result<Vec<_>>>()?;
    if let Some(wave) = &wave {
        wave.check_space(args.wave_cycles)?;
    }
    let mut model = FastestModel::new(&design)?;
    let mut jobs = Vec::new();
    for plane in &pictures {
        let job = Job::of(&design, plane.clone(), model.settled(plane))?;
        jobs.extend(std::iter::repeat_n(job, args.frames as usize));
    }
    let sources = verilog_of(&design, args.rtl.as_deref())?;
    let simulator = spinning("building the Verilated model (once; later runs find it)", || match &wave {
        Some(wave) => Simulator::of_design(&design, args.rtl.as_deref(), wave.format),
        None => Simulator::of_design(&design, args.rtl.as_deref(), Trace::None),
    })?;
    let streams =
        Streams { source_pause: args.stall, sink_pause: args.stall, sink_opens: args.sink_opens, seed: args.seed };
    let outcome = simulate(&simulator, &jobs, streams)?;
    if let Some(wave) = wave {
        let mut window = Window::around(&outcome, args.wave_cycles);
        if let Some(from) = args.wave_from {
            window = Window { from, focus: window.focus.clamp(from, from.saturating_add(args.wave_cycles)), ..window };
        }
        wave.check_space(args.wave_cycles)?;
        spinning("writing waves", || record(&simulator, &jobs, streams, window, wave.aside.temporary()))?;
        wave.keep(&design, window)?;
    }
    let verilog = Verilog {
        design: args.chosen.described(),
        folder: sources.first().and_then(|file| file.parent()).unwrap_or(Path::new(".")).to_owned(),
        emission: format!("{:08x}", outcome.emission),
    };
    let report = report(args, &images, outcome, verilog);
    if args.json {
        print_json(&report)?;
    } else {
        print(&summary(&report))?;
    }
    Ok(report.pass.into())
}

/// Runs the simulation. After one second a bar counts the pixels.
fn simulate(simulator: &Simulator, jobs: &[Job], streams: Streams) -> Result<Outcome> {
    let pixels = jobs.iter().map(|job| job.pixels.as_slice().len() as u64).sum();
    let rate = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
        let left = HumanDuration(state.eta());
        let _ = write!(text, "{:.2} million pixels a second, {left:#} left", state.per_sec() / 1e6);
    };
    let style = ProgressStyle::with_template("{wide_bar} {percent}% {msg} {rate}")?.with_key("rate", rate);
    let bar = ProgressBar::with_draw_target(Some(pixels), ProgressDrawTarget::hidden()).with_style(style);
    let (started, frames) = (Instant::now(), jobs.len());
    let outcome = run_with_progress(simulator, jobs, streams, &mut |progress| {
        if bar.is_hidden() && started.elapsed() > Duration::from_secs(1) {
            bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        bar.set_message(format!("{} of {frames} frames, {} cycles,", progress.frames, progress.cycles));
        bar.set_position(progress.pixels);
    })?;
    bar.finish_and_clear();
    Ok(outcome)
}

/// A wave file that is written under a temporary name in its final folder.
struct WaveFile {
    path: PathBuf,
    format: Trace,
    aside: Aside,
    _folder: Folder,
}

/// Largest size of one clock cycle of all signals, bytes, as FST and as VCD. Measured with `hoverlock sim --wave`: 3.5
/// kB and 19 kB.
const BYTES_PER_CYCLE: [u64; 2] = [4_000, 24_000];

impl WaveFile {
    /// Creates the temporary file before anything is simulated.
    fn new(path: &Path, images: &[PathBuf]) -> Result<Self> {
        let inputs: Vec<&Path> = images.iter().map(PathBuf::as_path).collect();
        let folder = prepare_target("--wave", path, &["fst", "vcd"], &inputs)?;
        let Some(format) = format_of(path) else {
            bail!("--wave {}: the name must end in .fst or .vcd", path.display())
        };
        Ok(Self { path: path.into(), format, aside: Aside::new(path)?, _folder: folder })
    }

    /// Checks that the disk has space for the waves, because the writers do not report a failed write.
    fn check_space(&self, cycles: u64) -> Result<()> {
        let per_cycle = BYTES_PER_CYCLE[usize::from(self.path.extension().is_some_and(|ending| ending == "vcd"))];
        let needed = cycles.saturating_mul(per_cycle) + 1_000_000;
        let free = self.free()?;
        if free < needed {
            let [needed, free] = [needed, free].map(|bytes| bytes as f64 / 1e6);
            bail!(
                "--wave {}: no space left on the disk: {cycles} cycles take up to {needed:.1} MB, and {free:.1} MB are \
                 free; \
                 free some, or lower --wave-cycles",
                self.path.display()
            );
        }
        Ok(())
    }

    /// Returns the free space in the folder of the waves, bytes.
    fn free(&self) -> Result<u64> {
        let about = rustix::fs::statvfs(self.aside.temporary())?;
        Ok(about.f_bavail.saturating_mul(about.f_frsize))
    }

    /// Gives the waves and the GTKWave view beside them their final names.
    fn keep(self, design: &DesignPoint, window: Window) -> Result<()> {
        if self.free()? == 0 {
            bail!(
                "--wave {}: no space left on the disk, so the waves may be cut short; free some",
                self.path.display()
            );
        }
        let mut view_beside = Batch::default();
        view_beside.add(&self.path.with_extension("gtkw"), view(design, &self.path, window).as_bytes())?;
        self.aside.keep()?;
        view_beside.keep()
    }
}

/// Reads a picture and converts it to samples of the design's camera.
fn frame(design: &DesignPoint, path: &Path, limit: &Limit) -> Result<Plane<u16>> {
    let (width, height) = (design.width as usize, design.height as usize);
    let picture = open(path, limit, MIN_SIDE as usize, Some((width, height)))?;
    Ok(camera_samples(design, &picture.crop(width, height).luma))
}

fn report(args: &Args, images: &[PathBuf], outcome: Outcome, verilog: Verilog) -> Report {
    let frames = args.frames as usize;
    let pictures: Vec<_> = images
        .iter()
        .zip(outcome.frames.chunks(frames))
        .map(|(image, frames)| {
            let sum = |part: fn(&FrameOutcome) -> u64| frames.iter().map(part).sum();
            let (features, mismatches): (u64, u64) = (sum(|frame| frame.features), sum(|frame| frame.mismatches));
            PerPicture {
                image: image.clone(),
                frames: frames.len(),
                model_features: sum(|frame| frame.model_features),
                features,
                dropped: sum(|frame| frame.dropped),
                mismatches: (features > 0 || mismatches > 0).then_some(mismatches),
            }
        })
        .collect();
    Report {
        pixels: outcome.pixels,
        cycles: outcome.cycles,
        cycles_per_pixel: outcome.cycles_per_pixel,
        features: outcome.features,
        dropped: outcome.dropped,
        model_features: outcome.model_features,
        samples: outcome.samples,
        mismatches: (outcome.features > 0 || outcome.mismatches > 0).then_some(outcome.mismatches),
        pass: outcome.pass() && pictures.iter().all(|picture| picture.features + picture.dropped > 0),
        cycles_per_second: outcome.cycles_per_second,
        latency_lines: outcome.latency_lines,
        feature_latency_lines: outcome.feature_latency_lines,
        first_mismatch: outcome
            .first_mismatch
            .map(|mismatch| First { image: images[mismatch.frame / frames].clone(), mismatch }),
        pictures,
        wave: args.wave.clone(),
        verilog,
    }
}

fn summary(report: &Report) -> String {
    let count = |mismatches: Option<u64>| mismatches.map_or("-".to_owned(), |count| count.to_string());
    let mut rows = vec![["picture", "frames", "model", "out", "dropped", "mismatches"].map(str::to_owned)];
    rows.extend(report.pictures.iter().map(|picture| {
        [
            shown(&picture.image),
            picture.frames.to_string(),
            picture.model_features.to_string(),
            picture.features.to_string(),
            picture.dropped.to_string(),
            count(picture.mismatches),
        ]
    }));
    let widest = rows.iter().map(|row| row[0].chars().count()).max().unwrap_or_default();
    // Writing to a String cannot fail.
    let mut text = String::new();
    for [picture, numbers @ ..] in rows {
        let _ = write!(text, "{picture:widest$}");
        text.extend(numbers.iter().map(|number| format!(" {number:>10}")));
        text.push('\n');
    }
    let _ = writeln!(
        text,
        "\n{} pixels in {} cycles, {:.2} million cycles a second\n{} samples and {} features compared; \
         {} out + {} dropped, {} of the model",
        report.pixels,
        report.cycles,
        report.cycles_per_second / 1e6,
        report.samples,
        report.features,
        report.features,
        report.dropped,
        report.model_features,
    );
    if let Some(rate) = report.cycles_per_pixel {
        let _ = writeln!(text, "{rate:.3} cycles a pixel");
    }
    if let (Some(smoothed), Some(feature)) = (report.latency_lines, report.feature_latency_lines) {
        let _ =
            writeln!(text, "latency {smoothed:.2} lines to the smoothed sample, {feature:.2} to the feature's record");
    }
    let Verilog { design, folder, emission } = &report.verilog;
    let _ = writeln!(text, "simulated: {}, emission {emission}; model: design {design}", shown(folder));
    if let Some(wave) = &report.wave {
        // The view names the waves without their folder, so that both can be moved together.
        let _ = writeln!(text, "waves: gtkwave {} {}", quoted(wave), quoted(&wave.with_extension("gtkw")));
    }
    text += &match (&report.first_mismatch, report.mismatches) {
        (Some(First { image, mismatch }), _) => format!(
            "{} mismatches, the first in {} of frame {} of {}, x {}, y {}, cycle {}: {}\n  expected {}\n  \
             actual   {}\n",
            count(report.mismatches),
            mismatch.stage,
            mismatch.frame,
            shown(image),
            mismatch.x,
            mismatch.y,
            mismatch.cycle,
            mismatch.field,
            mismatch.expected,
            mismatch.actual
        ),
        (None, None) => "no feature was compared: take a picture with more texture\n".into(),
        (None, Some(mismatches)) => format!("{mismatches} mismatches\n"),
    };
    text + &verdict(report.pass, if report.pass { "pass" } else { "FAIL" }) + "\n"
}
