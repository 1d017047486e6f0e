//! Rung 5 against rung 4: frames through the Verilated top, every smoothed sample, DoG, MaxDOG and record compared bit for bit.
//!
//! The bench sees the top as a system does: pixels by Avalon-ST, registers by Avalon-MM, records by Avalon-ST. Beside that it reads
//! a few internal signals, so that a difference is found in the stage it comes from and not only in the records.
//! MaxDOG is compared where its window lies in the frame; nothing else of it is ever used.

use std::{
    collections::VecDeque,
    io::Write,
    path::{Path, PathBuf},
    time::Instant,
};

use hoverlock_fixed_point::{
    bit_true::{BitTrue, FLAG_TRAILER, FeatureRecord, Planes},
    coefficients::CoefficientError,
    design::KT27,
    lerp::lerp,
    stages,
};
use hoverlock_harness::{
    BuildError, ModelError,
    build::{Build, Initial},
    model::{InstanceOptions, Library, Model, RawSignal, SignalId},
};
use hoverlock_reference::plane::Plane;
use sha2::{Digest, Sha256};

use crate::{
    emit::{EmitError, files},
    registers::{COEFFICIENTS_AT, default_coefficients},
};

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// Verilator or the compiler did not make a model.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The model lacks a signal: the bench does not fit the Verilog.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The design point has no coefficients.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// There is no Verilog to simulate.
    #[error(transparent)]
    Emit(#[from] EmitError),
    /// The Verilog cannot be put where Verilator reads it.
    #[error("cannot write the Verilog to {path}: {source}", path = path.display())]
    Write {
        /// Where.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The hardware stands still, or never ends.
    #[error("no end after {0} cycles: the pipeline hangs")]
    Hang(u64),
}

/// Signals below the top that the bench reads.
const INTERNALS: [&str; 10] = [
    "core.sequencer.capture",
    "core.sequencer.advance",
    "core.extractor.smoothers.start_out",
    "core.extractor.smoothers.narrow",
    "core.extractor.smoothers.middle",
    "core.extractor.smoothers.wide",
    "core.extractor.layer_0.response",
    "core.extractor.layer_1.response",
    "core.extractor.layer_0.ring",
    "core.extractor.layer_1.ring",
];

/// The Verilated top, built once and cached by content.
#[derive(Debug, Clone)]
pub struct Simulator {
    library: Library,
}

impl Simulator {
    /// Of the Verilog the sources give now.
    ///
    /// # Errors
    /// Where Verilator or the compiler fails.
    pub fn new() -> Result<Self, SimulationError> {
        let files = files()?;
        let verilog: Vec<_> = files.iter().filter(|file| file.path.ends_with(".v")).collect();
        // One folder for each emission, and files that keep their times: the harness finds the built model again by them.
        let mut digest = Sha256::new();
        verilog.iter().for_each(|file| digest.update(file.text.as_bytes()));
        let name: String = digest.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        let folder = cache().join("verilog").join(name);
        let mut sources = Vec::new();
        for file in verilog {
            let path = folder.join(file.path.trim_start_matches("verilog/"));
            put(&path, &file.text).map_err(|source| SimulationError::Write { path: path.clone(), source })?;
            sources.push(path);
        }
        Self::of(&sources)
    }

    /// Of Verilog files.
    ///
    /// # Errors
    /// Where Verilator or the compiler fails.
    pub fn of(sources: &[PathBuf]) -> Result<Self, SimulationError> {
        let build = Build::new("hoverlock_top").sources(sources).initial(Initial::Random);
        let build = INTERNALS.into_iter().fold(build, Build::internal);
        Ok(Self { library: build.compile()? })
    }

    /// The Verilated top itself, for a bench of one's own.
    pub fn library(&self) -> &Library {
        &self.library
    }
}

/// The user's cache, or where there is none the folder of temporary files.
pub(crate) fn cache() -> PathBuf {
    let set = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let home = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".cache"));
    set.or_else(home).unwrap_or_else(std::env::temp_dir).join("hoverlock")
}

/// Writes a file whole, unless it is there already.
fn put(path: &Path, text: &str) -> std::io::Result<()> {
    if std::fs::read(path).is_ok_and(|there| there == text.as_bytes()) {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.persist(path)?;
    Ok(())
}

/// A frame to be sent, with what the registers hold as it begins.
#[derive(Debug, Clone)]
pub struct Job {
    /// The pixels.
    pub pixels: Plane<u16>,
    /// The 19 coefficients.
    pub coefficients: Vec<u32>,
    /// `T_k`.
    pub thresholds: [u32; 2],
    /// What is wrong with it.
    pub fault: Fault,
}

/// What can be wrong with a frame at the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fault {
    /// Nothing.
    #[default]
    None,
    /// Only so many pixels, the last with end of packet.
    Short(usize),
    /// So many pixels too many, the last of them with end of packet.
    Long(usize),
    /// Only so many pixels and no end: the next frame begins.
    Interrupted(usize),
}

/// One beat of the video stream: pixel, start of packet, end of packet.
type Beat = (u16, bool, bool);

impl Job {
    /// A frame with the coefficients of the design point.
    ///
    /// # Errors
    /// Where the design point has none.
    pub fn new(pixels: Plane<u16>, thresholds: [u32; 2]) -> Result<Self, CoefficientError> {
        Ok(Self { pixels, coefficients: default_coefficients()?, thresholds, fault: Fault::None })
    }

    /// The frame as the bench sends it.
    fn beats(&self) -> Vec<Beat> {
        let pixels = self.pixels.as_slice();
        let last = pixels.last().copied().unwrap_or_default();
        let (count, ends) = match self.fault {
            Fault::None => (pixels.len(), true),
            Fault::Short(count) => (count, true),
            Fault::Long(more) => (pixels.len() + more, true),
            Fault::Interrupted(count) => (count, false),
        };
        let pixel = |i: usize| pixels.get(i).copied().unwrap_or(last ^ i as u16);
        (0..count).map(|i| (pixel(i), i == 0, ends && i + 1 == count)).collect()
    }

    /// The frame as the hardware completes it: a short one with its last pixel.
    fn completed(&self) -> Plane<u16> {
        let sent = match self.fault {
            Fault::Short(count) | Fault::Interrupted(count) => count,
            _ => self.pixels.as_slice().len(),
        };
        let w = self.pixels.width();
        let pixels = self.pixels.as_slice();
        Plane::from_fn(w, self.pixels.height(), |x, y| pixels[(y * w + x).min(sent - 1)])
    }

    /// The error bits of its trailer.
    fn errors(&self) -> u32 {
        match self.fault {
            Fault::None => 0,
            Fault::Short(_) => 1,
            Fault::Long(_) => 2,
            Fault::Interrupted(_) => 4,
        }
    }
}

/// How the bench treats the streams.
#[derive(Debug, Clone, Copy)]
pub struct Streams {
    /// Chance that no pixel is offered in a cycle.
    pub source_pause: f64,
    /// Chance that no record is taken in a cycle.
    pub sink_pause: f64,
    /// No record is taken before this cycle.
    pub sink_opens: u64,
    /// Seed of the pauses and of the registers' first content.
    pub seed: u64,
}

impl Default for Streams {
    fn default() -> Self {
        Self { source_pause: 0.0, sink_pause: 0.0, sink_opens: 0, seed: 1 }
    }
}

/// The first difference.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Mismatch {
    /// Stage.
    pub stage: String,
    /// Frame, from 0.
    pub frame: usize,
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Clock cycle since reset.
    pub cycle: u64,
    /// What rung 4 says, in hex and in real units.
    pub expected: String,
    /// What the hardware says.
    pub actual: String,
}

/// What a run gave.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct Outcome {
    /// Pixels sent.
    pub pixels: u64,
    /// Clock cycles.
    pub cycles: u64,
    /// Cycles between the starts of consecutive frames of one size, over their pixels, the worst; 0 for fewer than three.
    pub cycles_per_pixel: f64,
    /// Records compared.
    pub features: u64,
    /// Features the hardware says it dropped.
    pub dropped: u64,
    /// Samples of all planes compared.
    pub samples: u64,
    /// Samples and records that differ.
    pub mismatches: u64,
    /// The first of them.
    pub first_mismatch: Option<Mismatch>,
    /// Simulated clock cycles a second.
    pub cycles_per_second: f64,
    /// The status register at the end, see `registers/REGISTERS.md`.
    pub status: u32,
    /// Lines from a frame's first pixel to its first smoothed sample, with the rest in pixels as a fraction.
    pub latency_lines: f64,
}

impl Outcome {
    /// Everything was compared and nothing differs.
    pub fn pass(&self) -> bool {
        self.mismatches == 0 && self.features > 0 && self.samples > 0
    }
}

struct Expected {
    planes: Planes,
    records: Vec<FeatureRecord>,
}

/// xorshift64*: enough for pauses.
struct Random(u64);

impl Random {
    fn chance(&mut self, p: f64) -> bool {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let draw = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
        p > 0.0 && (draw as f64) < p * (1u64 << 53) as f64
    }
}

/// Rung 4 of a frame with its coefficients.
fn expect(model: &BitTrue, job: &Job) -> Expected {
    let state = model.state(&job.completed());
    let mut codes = job.coefficients.iter().copied();
    let smoothed = model.cells().clone().map(|mut cells| {
        for code in std::iter::once(&mut cells.g).chain(&mut cells.reach) {
            *code = codes.next().unwrap_or(*code);
        }
        stages::smooth(&state, &cells, |p, q, code| lerp(p, q, code, KT27.coefficient.bits()), |_, _| ())
    });
    let planes = model.planes_of(smoothed);
    let records = planes.features(job.thresholds);
    Expected { planes, records }
}

/// A frame whose samples are passing the stages.
struct Passing {
    frame: usize,
    /// Steps since its first smoothed sample.
    step: usize,
}

/// Steps from the smoothed sample to its response, and from the response to the ring word of the same line.
const RESPONSE_STEPS: usize = 2;
const RING_STEPS: usize = 6;

/// Runs frames through the hardware, back to back as far as the pauses let them, and compares everything.
///
/// # Errors
/// Where the bench does not fit the model, or the hardware hangs.
pub fn run(simulator: &Simulator, jobs: &[Job], streams: Streams) -> Result<Outcome, SimulationError> {
    let model = BitTrue::new(&KT27)?;
    let expected: Vec<Expected> = jobs.iter().map(|job| expect(&model, job)).collect();
    let mut bench = Bench::new(simulator, streams)?;
    bench.reset()?;
    let started = Instant::now();
    let mut outcome = bench.frames(jobs, &expected)?;
    outcome.cycles_per_second = outcome.cycles as f64 / started.elapsed().as_secs_f64();
    Ok(outcome)
}

struct Bench {
    model: Model,
    random: Random,
    streams: Streams,
    clock: RawSignal<u8>,
    reset: RawSignal<u8>,
    valid: RawSignal<u8>,
    data: RawSignal<u16>,
    first: RawSignal<u8>,
    last: RawSignal<u8>,
    ready: RawSignal<u8>,
    feature_ready: RawSignal<u8>,
    feature_valid: RawSignal<u8>,
    feature_data: SignalId,
    csr_address: RawSignal<u8>,
    csr_write: RawSignal<u8>,
    csr_read: RawSignal<u8>,
    csr_readdata: RawSignal<u32>,
    csr_data: RawSignal<u32>,
    capture: RawSignal<u8>,
    advance: RawSignal<u8>,
    start: RawSignal<u8>,
    smoothed: [RawSignal<u32>; 3],
    response: [RawSignal<u16>; 2],
    ring: [RawSignal<u16>; 2],
}

/// Reads or writes a raw signal of the bench's own model.
macro_rules! get {
    ($signal:expr) => {
        // SAFETY: the model lives in the same bench and never leaves this thread.
        unsafe { $signal.get() }
    };
}
macro_rules! set {
    ($signal:expr, $value:expr) => {
        // SAFETY: as above, and the value fits the signal.
        unsafe { $signal.set($value) }
    };
}

impl Bench {
    fn new(simulator: &Simulator, streams: Streams) -> Result<Self, SimulationError> {
        let options = InstanceOptions { seed: streams.seed, ..InstanceOptions::default() };
        let model = simulator.library.instance_with(&options)?;
        Ok(Self {
            clock: model.raw("clock")?,
            reset: model.raw("reset")?,
            valid: model.raw("video_valid")?,
            data: model.raw("video_data")?,
            first: model.raw("video_startofpacket")?,
            last: model.raw("video_endofpacket")?,
            ready: model.raw("video_ready")?,
            feature_ready: model.raw("feature_ready")?,
            feature_valid: model.raw("feature_valid")?,
            feature_data: model.find("feature_data")?,
            csr_address: model.raw("csr_address")?,
            csr_write: model.raw("csr_write")?,
            csr_read: model.raw("csr_read")?,
            csr_readdata: model.raw("csr_readdata")?,
            csr_data: model.raw("csr_writedata")?,
            capture: model.raw("core.sequencer.capture")?,
            advance: model.raw("core.sequencer.advance")?,
            start: model.raw("core.extractor.smoothers.start_out")?,
            smoothed: [
                model.raw("core.extractor.smoothers.narrow")?,
                model.raw("core.extractor.smoothers.middle")?,
                model.raw("core.extractor.smoothers.wide")?,
            ],
            response: [model.raw("core.extractor.layer_0.response")?, model.raw("core.extractor.layer_1.response")?],
            ring: [model.raw("core.extractor.layer_0.ring")?, model.raw("core.extractor.layer_1.ring")?],
            model,
            random: Random(streams.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1),
            streams,
        })
    }

    fn reset(&mut self) -> Result<(), SimulationError> {
        set!(self.reset, 1);
        for _ in 0..4 {
            self.settle()?;
            self.edge()?;
        }
        set!(self.reset, 0);
        self.settle()?;
        self.edge()
    }

    fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        set!(self.valid, 0);
        set!(self.csr_write, 0);
        set!(self.csr_address, (address >> 2) as u8);
        set!(self.csr_read, 1);
        self.settle()?;
        self.edge()?;
        set!(self.csr_read, 0);
        Ok(get!(self.csr_readdata))
    }

    fn settle(&mut self) -> Result<(), SimulationError> {
        set!(self.clock, 0);
        Ok(self.model.eval()?)
    }

    fn edge(&mut self) -> Result<(), SimulationError> {
        set!(self.clock, 1);
        Ok(self.model.eval()?)
    }

    fn frames(&mut self, jobs: &[Job], expected: &[Expected]) -> Result<Outcome, SimulationError> {
        let mut outcome =
            Outcome { pixels: jobs.iter().map(|job| job.pixels.as_slice().len() as u64).sum(), ..Outcome::default() };
        let mut writes: VecDeque<(u32, u32)> = jobs.first().map(writes_of).unwrap_or_default().into();
        writes.push_front((0x0c, 1));
        let (mut frame, mut pixel, mut begun, mut done) = (0, 0, 0, 0);
        let mut record = 0;
        let mut skipped = 0;
        let mut passing: VecDeque<Passing> = VecDeque::new();
        let mut arriving = 0;
        let mut starts: Vec<(u64, usize)> = Vec::new();
        let mut offered = false;
        let beats: Vec<Vec<Beat>> = jobs.iter().map(Job::beats).collect();
        let (mut cycle, mut quiet) = (0u64, 0u64);
        let longest = jobs.iter().map(|job| job.pixels.as_slice().len() as u64).max().unwrap_or_default();
        let slowest = 1.0 - self.streams.source_pause.max(self.streams.sink_pause);
        let sent: usize = beats.iter().map(Vec::len).sum();
        let whole = outcome.pixels + sent as u64 + 200_000 * jobs.len() as u64;
        let limit = (4.0 * whole as f64 / slowest.max(0.01)) as u64 + self.streams.sink_opens;
        while done < jobs.len() {
            // A frame's registers are written when the frame before it has begun, and it is offered after that.
            match writes.pop_front() {
                Some((address, word)) => {
                    set!(self.csr_address, (address >> 2) as u8);
                    set!(self.csr_data, word);
                    set!(self.csr_write, 1);
                }
                None => set!(self.csr_write, 0),
            }
            let may_begin = pixel > 0 || (begun == frame && get!(self.csr_write) == 0);
            // An offer once made stands until it is taken.
            offered = frame < jobs.len() && (offered || (may_begin && !self.random.chance(self.streams.source_pause)));
            set!(self.valid, u8::from(offered));
            if offered {
                let (data, first, last) = beats[frame][pixel];
                set!(self.data, data);
                set!(self.first, u8::from(first));
                set!(self.last, u8::from(last));
            }
            let sink = cycle >= self.streams.sink_opens && !self.random.chance(self.streams.sink_pause);
            set!(self.feature_ready, u8::from(sink));
            self.settle()?;

            if get!(self.capture) == 1 {
                begun += 1;
                writes = jobs.get(begun).map(writes_of).unwrap_or_default().into();
            }
            if offered && get!(self.ready) == 1 {
                if pixel == 0 {
                    starts.push((cycle, frame));
                }
                pixel += 1;
                if pixel == beats[frame].len() {
                    (frame, pixel) = (frame + 1, 0);
                }
                offered = false;
            }
            quiet += 1;
            if sink && get!(self.feature_valid) == 1 {
                quiet = 0;
                let words = self.model.get_words(self.feature_data);
                let words: [u32; 8] = std::array::from_fn(|i| words[i]);
                let list = &expected[done].records;
                if words[1] >> 16 & u32::from(FLAG_TRAILER) != 0 {
                    let (count, dropped) = (u64::from(words[2]), u64::from(words[3]));
                    skipped += list.len() - record;
                    let agrees = words[0] as usize == done
                        && words[1] & 0xffff == jobs[done].errors()
                        && count + dropped == list.len() as u64
                        && dropped == skipped as u64;
                    if !agrees {
                        let errors = jobs[done].errors();
                        let want =
                            format!("frame {done}, {} features, {skipped} missing, errors {errors:x}", list.len());
                        outcome.differ("trailer", (done, 0, 0), cycle, want, format!("{words:08x?}"));
                    }
                    outcome.dropped += dropped;
                    (done, record, skipped) = (done + 1, 0, 0);
                } else {
                    outcome.features += 1;
                    match list[record..].iter().position(|feature| feature.pack() == words) {
                        Some(ahead) => {
                            skipped += ahead;
                            record += ahead + 1;
                        }
                        None => {
                            let at = (done, (words[0] & 0xffff) as usize, (words[0] >> 16) as usize);
                            let want = list.get(record).map_or("no record".into(), |f| format!("{:08x?}", f.pack()));
                            outcome.differ("record", at, cycle, want, format!("{words:08x?}"));
                        }
                    }
                }
            }
            if get!(self.advance) == 1 {
                for passes in &mut passing {
                    self.compare(passes, &expected[passes.frame].planes, cycle, &mut outcome);
                    passes.step += 1;
                }
                let gone = |passes: &Passing| {
                    let (w, h) = (jobs[passes.frame].pixels.width(), jobs[passes.frame].pixels.height());
                    passes.step > (h + 2) * w + 16
                };
                if passing.front().is_some_and(gone) {
                    passing.pop_front();
                }
                if get!(self.start) == 1 && arriving < jobs.len() {
                    if arriving == 0
                        && let Some((began, _)) = starts.first()
                    {
                        outcome.latency_lines = (cycle + 1 - began) as f64 / jobs[0].pixels.width() as f64;
                    }
                    passing.push_back(Passing { frame: arriving, step: 0 });
                    arriving += 1;
                }
            }
            self.edge()?;
            cycle += 1;
            // Neither silence nor a flood of records may last.
            if quiet > 4 * longest + 200_000 + self.streams.sink_opens || cycle > limit {
                return Err(SimulationError::Hang(cycle));
            }
        }
        outcome.cycles = cycle;
        outcome.status = self.read(0x10)?;
        let sizes = |frame: usize| (jobs[frame].pixels.width(), jobs[frame].pixels.height());
        // A frame of a new size, as the first is, waits at the input until its size is taken over: not part of the rate.
        let steady = |pair: &&[(u64, usize)]| {
            let frame = pair[0].1;
            frame > 0 && sizes(frame - 1) == sizes(frame) && sizes(frame) == sizes(frame + 1)
        };
        let rates = starts
            .windows(2)
            .filter(steady)
            .map(|pair| (pair[1].0 - pair[0].0) as f64 / jobs[pair[0].1].pixels.as_slice().len() as f64);
        outcome.cycles_per_pixel = rates.fold(0.0, f64::max);
        Ok(outcome)
    }

    /// Compares what a step shows of a frame.
    fn compare(&self, passes: &Passing, planes: &Planes, cycle: u64, outcome: &mut Outcome) {
        let (w, h) = (planes.smoothed[0].width(), planes.smoothed[0].height());
        let samples = w * h;
        let place = |index: usize| (passes.frame, index % w, index / w);
        if passes.step < samples {
            for (i, signal) in self.smoothed.iter().enumerate() {
                let (want, got) = (planes.smoothed[i].as_slice()[passes.step], get!(signal));
                if want != got {
                    let units = |state: u32| format!("0x{state:05x}, {} codes", f64::from(state) / 4.0);
                    outcome.differ(&format!("smoother {i}"), place(passes.step), cycle, units(want), units(got));
                }
            }
            outcome.samples += 3;
        }
        let word = |plane: &Plane<u16>, positive: &Plane<bool>, index: usize| {
            plane.as_slice()[index] | u16::from(positive.as_slice()[index]) << 15
        };
        let units = |word: u16| format!("0x{word:04x}, {} codes", f64::from(word & 0x7fff) / 2.0);
        if let Some(index) = passes.step.checked_sub(RESPONSE_STEPS).filter(|index| *index < samples) {
            for (k, signal) in self.response.iter().enumerate() {
                let dog = &planes.layers[k].dog;
                let (want, got) = (word(&dog.magnitude, &dog.positive, index), get!(signal));
                if want != got {
                    outcome.differ(&format!("DoG {k}"), place(index), cycle, units(want), units(got));
                }
            }
            outcome.samples += 2;
        }
        let late = RESPONSE_STEPS + RING_STEPS + 2 * w + 2;
        if let Some(index) = passes.step.checked_sub(late).filter(|index| *index < samples) {
            let (_, x, y) = place(index);
            if (2..w - 2).contains(&x) && (2..h - 2).contains(&y) {
                for (k, signal) in self.ring.iter().enumerate() {
                    let layer = &planes.layers[k];
                    let (want, got) = (word(&layer.max_dog, &layer.dog.positive, index), get!(signal));
                    if want != got {
                        outcome.differ(&format!("MaxDOG {k}"), place(index), cycle, units(want), units(got));
                    }
                }
                outcome.samples += 2;
            }
        }
    }
}

impl Outcome {
    fn differ(&mut self, stage: &str, at: (usize, usize, usize), cycle: u64, expected: String, actual: String) {
        self.mismatches += 1;
        let (frame, x, y) = at;
        self.first_mismatch.get_or_insert_with(|| Mismatch {
            stage: stage.into(),
            frame,
            x,
            y,
            cycle,
            expected,
            actual,
        });
    }
}

/// The register writes before a frame.
fn writes_of(job: &Job) -> Vec<(u32, u32)> {
    let (w, h) = (job.pixels.width() as u32, job.pixels.height() as u32);
    let codes = job.coefficients.iter().enumerate().map(|(i, code)| (COEFFICIENTS_AT + 4 * i as u32, *code));
    let [fine, coarse] = job.thresholds;
    codes.chain([(0x14, h << 16 | w), (0x18, coarse << 16 | fine)]).collect()
}
