//! Instructions per frame on the Cortex-A9, counted under qemu by the plugin `hoverlock-icount`: `make bench-arm`.
//!
//! Counts `hoverlock-nav`, unchanged, from one line written to the next, and for comparison the extraction in software,
//! `hoverlock-extract`, on a picture. Every count is the same in every run.

#[path = "../tests/support/mod.rs"]
mod support;

use hoverlock_arm::message::{self, Command as Order, InertialSample, Telemetry};
use hoverlock_arm::navigator::MAX_FRAME_INSTRUCTIONS;
use hoverlock_design::KT27;
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_fixed_point::model::threshold::ThresholdController;
use hoverlock_pictures::{Picture, data_dir, demo_dir};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::TWO_PAIR_WORDS;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use support::Source;
use support::adversarial;
use support::scene::{self, records, telemetry};

/// Number of ground points, of which somewhat more than the 1024 features that are used are in view.
const POINTS: usize = 1400;

/// Instructions of the parts of a frame, in the order of `hoverlock_reference::motion::mark::Part`.
#[derive(Clone, Copy, Default)]
struct Parts {
    rest: u64,
    matching: u64,
    search: u64,
    pose: u64,
    extraction: u64,
    refinement: u64,
    /// Of a stream with pixels. Without them it is in the rest.
    transfer: u64,
}

impl Parts {
    /// All but the transfer of pixels, which lie in memory on a board.
    fn total(&self) -> u64 {
        self.rest + self.matching + self.search + self.pose + self.extraction + self.refinement
    }
}

/// Cycles of a line that the second level has. An assumption.
const SECOND_LEVEL_CYCLES: u64 = 25;
/// Cycles of a line from memory, besides. An assumption.
const MEMORY_CYCLES: u64 = 100;

/// Estimated cycles of a frame, with one instruction a cycle if its pipeline is free, and with each waiting for the
/// result of the one before; and the deepest stack, bytes.
#[derive(Clone, Copy)]
struct Cycles {
    least: u64,
    most: u64,
    stack: u64,
}

/// The paths of the plugin, of the programs and of a work folder.
struct Tools {
    plugin: PathBuf,
    programs: PathBuf,
    work: PathBuf,
}

impl Tools {
    /// Finds them relative to this program, `target/release/deps/instructions-...`.
    fn find() -> Result<Self, Box<dyn Error>> {
        let this = std::env::current_exe()?;
        let target = this.ancestors().nth(3).ok_or("not in a target folder")?;
        let tools = Self {
            plugin: target.join("release/libhoverlock_icount.so"),
            programs: target.join("arm/armv7-unknown-linux-gnueabihf/release"),
            work: PathBuf::from(env!("CARGO_TARGET_TMPDIR")),
        };
        for file in
            [tools.plugin.clone(), tools.programs.join("hoverlock-nav"), tools.programs.join("hoverlock-extract")]
        {
            if !file.is_file() {
                return Err(format!("{} is missing; run `make bench-arm`", file.display()).into());
            }
        }
        Ok(tools)
    }

    /// Runs a program and returns its output and the counts of each frame.
    fn counted(&self, program: &str, arguments: &[&str]) -> Result<(Vec<u8>, Vec<Parts>), Box<dyn Error>> {
        let mut command = Command::new("qemu-arm");
        command
            .args(["-cpu", "cortex-a9", "-plugin"])
            .arg(&self.plugin)
            .arg(self.programs.join(program))
            .args(arguments);
        let output = command.output().map_err(|error| format!("qemu-arm: {error}; run `make bench-arm`"))?;
        let text = String::from_utf8(output.stderr)?;
        if !output.status.success() {
            return Err(format!("{program}: {}", text.trim_end()).into());
        }
        let mut frames = Vec::new();
        for line in text.lines().filter_map(|line| line.strip_prefix("icount ")) {
            let counts: Vec<u64> = line.split(' ').map(str::parse).collect::<Result<_, _>>()?;
            let [rest, matching, search, pose, extraction, refinement, transfer, ..] = counts[..] else {
                return Err(line.into());
            };
            frames.push(Parts { rest, matching, search, pose, extraction, refinement, transfer });
        }
        Ok((output.stdout, frames))
    }

    /// Estimates the cycles of the frame of a stream with most of them.
    fn cycles(&self, name: &str) -> Result<Cycles, Box<dyn Error>> {
        let mut plugin = self.plugin.clone().into_os_string();
        plugin.push(",cycles=on");
        let mut command = Command::new("qemu-arm");
        command.args(["-cpu", "cortex-a9", "-plugin"]).arg(plugin).arg(self.programs.join("hoverlock-nav"));
        let output = command.arg(self.work.join(name).with_extension("hln")).output()?;
        let mut worst: Option<Cycles> = None;
        for line in String::from_utf8(output.stderr)?.lines().filter_map(|line| line.strip_prefix("icycles ")) {
            let counts: Vec<u64> = line.split(' ').map(str::parse).collect::<Result<_, _>>()?;
            let [issue, latency, first, second, stack] = counts[..] else { return Err(line.into()) };
            let missed = first * SECOND_LEVEL_CYCLES + second * MEMORY_CYCLES;
            let cycles = Cycles { least: issue + missed, most: latency + missed, stack };
            let stack = worst.map_or(stack, |worst| worst.stack.max(stack));
            let frame = worst.filter(|worst| worst.least >= cycles.least).unwrap_or(cycles);
            worst = Some(Cycles { stack, ..frame });
        }
        worst.ok_or_else(|| format!("{name}: no frame").into())
    }

    /// Returns the counts of the frame with most instructions, and the number of frames with an estimate.
    fn worst(&self, name: &str, source: &Source) -> Result<(Parts, usize), Box<dyn Error>> {
        let stream = self.work.join(name).with_extension("hln");
        std::fs::write(&stream, source.messages.concat())?;
        let (lines, mut frames) = self.counted("hoverlock-nav", &[&stream.to_string_lossy()])?;
        if !support::has_pixels(source) {
            frames.iter_mut().for_each(|frame| frame.rest += std::mem::take(&mut frame.transfer));
        }
        let estimates = String::from_utf8(lines)?.matches("x_e_m").count();
        let worst = frames.into_iter().max_by_key(Parts::total).ok_or_else(|| format!("{name}: no frame"))?;
        Ok((worst, estimates))
    }
}

/// Creates a stream of a reference and `frames` further frames, too far apart to be predicted; `records` returns the
/// features of a frame.
fn flight(frames: u32, records: impl Fn(u32) -> Vec<FeatureRecord>) -> Source {
    let mut source = Source::default();
    source.send_registers(scene::SIZE.0, scene::SIZE.1).unwrap();
    source.send(message::COMMAND, &Order::Capture.encode()).unwrap();
    for frame in 0..=frames {
        let telemetry = telemetry(frame);
        let time_us = UNPREDICTED_FRAMES * telemetry.time_us;
        source.send_frame(&Telemetry { time_us, ..telemetry }, &records(frame), &[2000; 2]).unwrap();
    }
    source
}

/// Returns features of which the fraction `part` is from the ground; the others have random positions and descriptors.
fn diluted(frame: u32, part: f64) -> Vec<FeatureRecord> {
    let mut rng = ChaCha8Rng::seed_from_u64(u64::from(frame));
    let mut all = records(POINTS, frame);
    for record in &mut all {
        if rng.random::<f64>() >= part {
            record.x = rng.random_range(20..1004);
            record.y = rng.random_range(20..748);
            let words = &mut record.descriptor;
            words.maxlbp[..2].iter_mut().chain(&mut words.sign[..2]).for_each(|word| *word = rng.random());
        }
    }
    all.sort_by_key(|record| (record.y, record.x, record.scale));
    all
}

/// Returns features of one scale and polarity, so that every pair is compared.
fn one_kind(frame: u32) -> Vec<FeatureRecord> {
    let mut all = records(POINTS, frame);
    all.iter_mut().for_each(|record| (record.scale, record.bright) = (0, true));
    all
}

/// Time between frames, us.
const FRAME_INTERVAL_US: u64 = 66_667;
/// Time between samples of the IMU, us.
const SAMPLE_INTERVAL_US: u64 = 5_000;

/// Frame periods between frames that make the last displacement too old to predict the next.
const UNPREDICTED_FRAMES: u64 = 30;

/// A hover with samples of the IMU at the frame rate: frames that the filter tracks, with a second keyframe from frame
/// `renewed` on, without features between frames `blind`, and with the pixels of a picture in each if there is one.
fn hover(frames: u32, renewed: Option<u32>, blind: Range<u32>, picture: Option<&Plane<u16>>) -> Source {
    let mut source = Source::default();
    source.send_registers(scene::SIZE.0, scene::SIZE.1).unwrap();
    source.send(message::COMMAND, &Order::Capture.encode()).unwrap();
    let mut samples = 0;
    for frame in 0..=frames {
        let time_us = u64::from(frame) * FRAME_INTERVAL_US;
        let due = (samples..).map(|sample| sample * SAMPLE_INTERVAL_US).take_while(|sample| *sample <= time_us);
        let reading = |time_us| InertialSample { time_us, rates: [0.0; 3], force: [0.0, 0.0, -9.80665] };
        let readings: Vec<InertialSample> = due.map(reading).collect();
        samples += readings.len() as u64;
        source.send(message::INERTIAL, &message::encode_inertial(&readings)).unwrap();
        if renewed == Some(frame) {
            source.send(message::COMMAND, &Order::Renew.encode()).unwrap();
        }
        if let Some(picture) = picture {
            source.send_pixels(frame, picture).unwrap();
        }
        let seen = if blind.contains(&frame) { Vec::new() } else { at_rest_in(frame) };
        source.send_frame(&Telemetry { time_us, ..telemetry(frame) }, &seen, &[2000; 2]).unwrap();
    }
    source
}

/// Returns features at the place of the first frame, with other flipped bits in each.
fn at_rest_in(frame: u32) -> Vec<FeatureRecord> {
    scene::seen(POINTS, 1.0, (0.0, 0.0), scene::FIELD_OF_VIEW, frame)
}

/// The simulated flights: key in `docs/results.json`, name, stream.
fn flights() -> Vec<(&'static str, &'static str, Source)> {
    let texture = adversarial::texture();
    vec![
        ("all_found", "all features found again", flight(4, |frame| records(POINTS, frame))),
        ("one_in_three", "one in three found again", flight(4, |frame| diluted(frame, 0.577))),
        ("one_in_ten", "one in ten found again", flight(4, |frame| diluted(frame, 0.316))),
        ("none_found", "none found again", flight(4, |frame| diluted(frame, 0.0))),
        ("one_kind", "one scale and polarity", flight(4, one_kind)),
        ("tracked", "tracked with the IMU", hover(14, None, 0..0, None)),
        ("tracked_twice", "the same, two keyframes", hover(24, Some(10), 0..0, None)),
        ("found_again", "found again after 6 s without features", hover(120, None, 12..102, None)),
        ("refined", "tracked with the IMU and the pixels", hover(14, None, 0..0, Some(&texture))),
        ("refined_twice", "the same, two keyframes", hover(24, Some(10), 0..0, Some(&texture))),
    ]
}

/// A real picture and its features as the FPGA extracts them.
struct Sample {
    path: PathBuf,
    pixels: Vec<u8>,
    /// Thresholds at which the automatic control settles.
    thresholds: Vec<u32>,
    features: Vec<FeatureRecord>,
}

fn picture() -> Result<Sample, Box<dyn Error>> {
    let folder = demo_dir().ok_or("no photographs; run `make demo` once, which fetches them")?;
    // The only one of the photographs that is large enough.
    let path = folder.join("aloeL.jpg");
    let frame = Picture::open(&path)?.crop(KT27.width as usize, KT27.height as usize).luma;
    if (frame.width(), frame.height()) != scene::SIZE {
        return Err(format!("{} has {} x {} pixels", path.display(), frame.width(), frame.height()).into());
    }
    let planes = BitTrue::new(&KT27)?.planes(&frame);
    let mut controller = ThresholdController::new(&KT27);
    controller.settle(&planes.maxima());
    let thresholds = controller.thresholds().to_vec();
    let pixels = frame.as_slice().iter().flat_map(|sample| sample.to_le_bytes()).collect();
    let features = planes.features(&thresholds);
    Ok(Sample { path, pixels, thresholds, features })
}

/// Prints the row of a flight, and adds its lines for `setup/results.py record` to `results`.
fn row(key: &str, name: &str, parts: &Parts, results: &mut Vec<String>) {
    let million = |count: u64| format!("{:.1}", count as f64 / 1e6);
    let Parts { rest, matching, search, pose, refinement, transfer, .. } = *parts;
    let counts = [matching, search, refinement, pose, rest, parts.total(), transfer].map(million);
    println!("| {name} | {} |", counts.join(" | "));
    for (part, count) in ["matching", "search", "refinement", "pose", "rest", "all", "transfer"].iter().zip(counts) {
        results.push(format!("result arm.instructions.{key}.{part}={count}"));
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let tools = Tools::find()?;
    println!("Million instructions of the worst frame of each flight, 1024 features a side:\n");
    println!(
        "| flight | matching | search | refinement | pose | rest | all | transfer of pixels |\n\
         |---|---|---|---|---|---|---|---|"
    );
    let mut worst: Option<(String, Parts)> = None;
    let mut typical = None;
    let mut results = Vec::new();
    let mut add = |key: &str, name: &str, source: &Source| -> Result<(), Box<dyn Error>> {
        let (parts, estimates) = tools.worst(name, source)?;
        row(key, &format!("{name} ({estimates} estimates)"), &parts, &mut results);
        if worst.as_ref().is_none_or(|(_, worst)| worst.total() < parts.total()) {
            worst = Some((name.to_owned(), parts));
        }
        if key == "tracked" {
            typical = Some(parts);
        }
        Ok(())
    };
    for (key, name, source) in flights() {
        add(key, name, &source)?;
    }
    match data_dir() {
        Some(folder) => {
            for name in ["caliterra", "copr_dunes", "drone_park", "forest_flight"] {
                add(name, name, &support::sequence(&folder.join("sequences").join(name))?)?;
            }
        }
        None => println!("\nWithout the real sequences: set HOVERLOCK_DATA."),
    }
    println!("\nFeatures in shapes that make loops long, and long gaps:\n");
    println!(
        "| shape | matching | search | refinement | pose | rest | all | transfer of pixels |\n\
         |---|---|---|---|---|---|---|---|"
    );
    for (name, source) in adversarial::worst() {
        let (parts, estimates) = tools.worst(name, &source)?;
        row("shapes", &format!("{name} ({estimates} estimates)"), &parts, &mut Vec::new());
        if worst.as_ref().is_none_or(|(_, worst)| worst.total() < parts.total()) {
            worst = Some((name.to_owned(), parts));
        }
    }
    let (typical, (worst_name, worst)) = typical.zip(worst).ok_or("no flight")?;
    println!("\nEstimated million cycles of the worst frame, from one instruction a cycle to none overlapped:\n");
    println!("| stream | least | most |\n|---|---|---|");
    let streams = [
        ("tracked", "tracked with the IMU"),
        ("tracked_twice", "the same, two keyframes"),
        ("searched", "all features found again"),
        ("worst", worst_name.as_str()),
    ];
    let mut stack = 0;
    for (key, name) in streams {
        let cycles = tools.cycles(name)?;
        let [least, most] = [cycles.least, cycles.most].map(|cycles| cycles as f64 / 1e6);
        println!("| {name} | {least:.1} | {most:.1} |");
        results.push(format!("result arm.cycles.{key}.least={least:.1}"));
        results.push(format!("result arm.cycles.{key}.most={most:.1}"));
        stack = stack.max(cycles.stack);
    }
    println!("\nThe stack is at most {:.0} KiB deep.", stack as f64 / 1024.0);
    results.push(format!("result arm.stack.kib={:.0}", stack as f64 / 1024.0));

    let Sample { path, pixels, thresholds, features } = picture()?;
    let file = tools.work.join("frame.raw");
    std::fs::write(&file, pixels)?;
    let [t0, t1] = [0, 1].map(|k| thresholds[k].to_string());
    let (records, frames) = tools.counted("hoverlock-extract", &["1024", "768", &file.to_string_lossy(), &t0, &t1])?;
    let words = features.iter().flat_map(|feature| feature.pack().into_iter().take(TWO_PAIR_WORDS));
    let expected: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
    if records != expected {
        return Err("the features of hoverlock-extract are not those of the bit-true model".into());
    }
    let extraction = frames.first().ok_or("hoverlock-extract: no frame")?.extraction;
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    println!("\nMillion instructions a frame, 1024 x 768 pixels ({name}, {} features):\n", features.len());
    println!("| | pixels to features | features to estimate | all | ratio |\n|---|---|---|---|---|");
    for (name, parts) in [("tracked with the IMU", typical), ("worst case", worst)] {
        let after = parts.total();
        let [software, rest, whole] = [extraction, after, extraction + after].map(|n| n as f64 / 1e6);
        println!("| {name}: all on the ARM | {software:.1} | {rest:.1} | {whole:.1} | |");
        println!("| {name}: with the FPGA | 0 | {rest:.1} | {rest:.1} | {:.1} |", whole / rest);
    }
    let [most, target] = [worst.total(), MAX_FRAME_INSTRUCTIONS].map(|count| count as f64 / 1e6);
    println!("\nThe worst frame takes {most:.1} million instructions; its bound is {target:.0}.");
    if most > target {
        return Err("the bound does not hold".into());
    }
    results.push(format!("result arm.instructions.worst.all={most:.1}"));
    results.push(format!("result arm.worst_case.bound={target:.1}"));
    results.push(format!("result arm.worst_case.measured={most:.1}"));
    results.push(format!("result arm.extraction={:.1}", extraction as f64 / 1e6));
    println!("{}", results.join("\n"));
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bench-arm: {error}");
            ExitCode::from(2)
        }
    }
}
