//! The bench of the comparison with `bit_true`: a loop over clock cycles that drives source, sink and registers and
//! compares.

use std::collections::VecDeque;

use hoverlock_design::{DesignPoint, smoother_names};
use hoverlock_harness::model::{InstanceOptions, Model, RawSignal, SignalId};

use crate::{
    Narrow, Ports, Progress, SimulationError, Simulator,
    expect::Oracle,
    job::{Fault, Job, Map, Streams},
    outcome::{FrameOutcome, Outcome, Position},
    planes::{Passing, Shown, Units},
    records::{Records, Taken, Words, halves},
    waves::{Recorder, time},
};

/// Signals below the top that the bench reads: those of every design.
const INTERNALS: [&str; 5] = [
    "core.sequencer.capture",
    "core.sequencer.advance",
    "core.extractor.smoothers.start_out",
    "core.extractor.write",
    "core.extractor.record",
];

/// The samples of a design: smoothed states, responses, ring samples.
fn samples(design: &DesignPoint) -> [Vec<String>; 3] {
    let of_pairs = |port: &str| (0..design.pairs()).map(|k| format!("core.extractor.scale_pair_{k}.{port}")).collect();
    let smoothed = smoother_names(design.smoothers()).iter().map(|name| format!("core.extractor.smoothers.{name}"));
    [smoothed.collect(), of_pairs("response"), of_pairs("ring")]
}

/// All signals below the top that the bench reads.
pub(super) fn internals(design: &DesignPoint) -> Vec<String> {
    INTERNALS.iter().map(|name| (*name).to_owned()).chain(samples(design).into_iter().flatten()).collect()
}

/// Clock cycles of the reset, before cycle 0.
pub(super) const RESET_CYCLES: u64 = 5;

/// Cycles between progress reports: a power of two.
const PROGRESS_EVERY: u64 = 1 << 14;

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

/// The model and its signals.
struct Pins<'a> {
    model: Model,
    recorder: Option<Recorder<'a>>,
    /// Clock cycles, those of the reset included.
    now: u64,
    ports: Ports,
    capture: RawSignal<u8>,
    advance: RawSignal<u8>,
    start: RawSignal<u8>,
    smoothed: Vec<Narrow>,
    response: Vec<Narrow>,
    ring: Vec<Narrow>,
    write: RawSignal<u8>,
    record: SignalId,
    /// Largest pixel.
    largest: u32,
}

/// Reads or writes a raw signal of the bench's own model.
macro_rules! get {
    ($signal:expr) => {
        // SAFETY: the model lives in the same structure and never leaves this thread.
        unsafe { $signal.get() }
    };
}
macro_rules! set {
    ($signal:expr, $value:expr) => {
        // SAFETY: as above, and the value fits the signal.
        unsafe { $signal.set($value) }
    };
}

impl<'a> Pins<'a> {
    fn new(simulator: &Simulator, seed: u64, recorder: Option<Recorder<'a>>) -> Result<Self, SimulationError> {
        // The largest pixel: beats beyond the end of a frame are arbitrary, but fit the port.
        let largest = simulator.design().pixel.max_raw() as u32;
        let options = InstanceOptions { seed, plusargs: simulator.plusargs().to_vec() };
        let mut model = simulator.library().instance_with(&options)?;
        if let Some(recorder) = &recorder {
            recorder.open(&mut model)?;
        }
        let find = |names: &[String]| -> Result<Vec<Narrow>, SimulationError> {
            Ok(names.iter().map(|name| Narrow::find(&model, name)).collect::<Result<_, _>>()?)
        };
        let [smoothed, response, ring] = samples(simulator.design());
        let (smoothed, response, ring) = (find(&smoothed)?, find(&response)?, find(&ring)?);
        Ok(Self {
            ports: Ports::find(&model)?,
            capture: model.raw("core.sequencer.capture")?,
            advance: model.raw("core.sequencer.advance")?,
            start: model.raw("core.extractor.smoothers.start_out")?,
            smoothed,
            response,
            ring,
            largest,
            write: model.raw("core.extractor.write")?,
            record: model.find("core.extractor.record")?,
            model,
            recorder,
            now: 0,
        })
    }

    /// Falling clock edge: the inputs settle.
    fn settle(&mut self) -> Result<(), SimulationError> {
        set!(self.ports.clock, 0);
        self.model.eval()?;
        self.dump(false)?;
        Ok(())
    }

    fn edge(&mut self) -> Result<(), SimulationError> {
        set!(self.ports.clock, 1);
        self.model.eval()?;
        self.dump(true)?;
        self.now += 1;
        Ok(())
    }

    #[inline]
    fn dump(&mut self, rising: bool) -> Result<(), SimulationError> {
        if self.recorder.as_ref().is_some_and(|recorder| recorder.wants(self.now)) {
            self.model.trace_dump(time(self.now, rising))?;
        }
        Ok(())
    }

    /// The recorder has its whole window.
    fn is_recorded(&self) -> bool {
        self.recorder.as_ref().is_some_and(|recorder| recorder.is_past(self.now))
    }

    fn cycle(&mut self) -> Result<(), SimulationError> {
        self.settle()?;
        self.edge()
    }

    fn write(&mut self, write: Option<(u32, u32)>) {
        set!(self.ports.csr_write, u8::from(write.is_some()));
        if let Some((address, word)) = write {
            set!(self.ports.csr_address, (address >> 2) as u8);
            set!(self.ports.csr_writedata, word);
        }
    }

    fn read(&mut self, address: u32) -> Result<u32, SimulationError> {
        set!(self.ports.valid, 0);
        set!(self.ports.csr_write, 0);
        set!(self.ports.csr_address, (address >> 2) as u8);
        set!(self.ports.csr_read, 1);
        self.cycle()?;
        set!(self.ports.csr_read, 0);
        Ok(get!(self.ports.csr_readdata))
    }

    fn words(&self, signal: SignalId) -> Words {
        let words = self.model.get_words(signal);
        std::array::from_fn(|i| words.get(i).copied().unwrap_or_default())
    }

    fn shown(&self) -> Shown {
        Shown {
            smoothed: std::array::from_fn(|i| self.smoothed.get(i).map_or(0, |signal| get!(signal))),
            response: std::array::from_fn(|k| self.response.get(k).map_or(0, |signal| get!(signal))),
            ring: std::array::from_fn(|k| self.ring.get(k).map_or(0, |signal| get!(signal))),
        }
    }
}

/// The source: sends the frames in order, each after its registers are written.
struct Source<'a> {
    jobs: &'a [Job],
    map: Map,
    writes: VecDeque<(u32, u32)>,
    frame: usize,
    pixel: usize,
    /// Frames that have captured their registers.
    begun: usize,
    offered: bool,
}

impl<'a> Source<'a> {
    fn new(design: &DesignPoint, jobs: &'a [Job]) -> Result<Self, SimulationError> {
        let mut source = Self {
            jobs,
            map: Map::new(design)?,
            writes: VecDeque::new(),
            frame: 0,
            pixel: 0,
            begun: 0,
            offered: false,
        };
        source.prepare()?;
        Ok(source)
    }

    /// Prepares the register writes of the next frame.
    fn prepare(&mut self) -> Result<(), SimulationError> {
        self.writes = match self.jobs.get(self.begun) {
            Some(job) => self.map.writes(job)?.into(),
            None => VecDeque::new(),
        };
        Ok(())
    }

    fn drive(&mut self, pins: &mut Pins<'_>, pause: bool) {
        let write = self.writes.pop_front();
        pins.write(write);
        let may_begin = self.pixel > 0 || (self.begun == self.frame && write.is_none());
        // A beat once offered stays valid until it is accepted.
        self.offered = self.frame < self.jobs.len() && (self.offered || (may_begin && !pause));
        set!(pins.ports.valid, u8::from(self.offered));
        if self.offered {
            let beat = self.jobs[self.frame].beat(self.pixel);
            set!(pins.ports.data, u32::from(beat.data) & pins.largest);
            set!(pins.ports.first, u8::from(beat.first));
            set!(pins.ports.last, u8::from(beat.last));
        }
    }

    /// The beat was accepted. Returns the frame if this was its last beat.
    fn advance(&mut self) -> Option<&'a Job> {
        self.offered = false;
        self.pixel += 1;
        let job = &self.jobs[self.frame];
        if self.pixel < job.beats() {
            return None;
        }
        (self.frame, self.pixel) = (self.frame + 1, 0);
        Some(job)
    }
}

/// Timeouts of a run, far above what working hardware takes.
struct Patience {
    quiet: u64,
    total: u64,
}

impl Patience {
    fn new(jobs: &[Job], streams: Streams) -> Self {
        let pixels = |job: &Job| job.pixels.as_slice().len() as u64;
        let longest = jobs.iter().map(pixels).max().unwrap_or_default();
        let sent: u64 = jobs.iter().map(|job| job.beats() as u64 + pixels(job)).sum();
        let share = (1.0 - streams.source_pause.max(streams.sink_pause)).max(0.01);
        let cycles = |pixels: u64| (4.0 * pixels as f64 / share) as u64 + streams.sink_opens;
        Self { quiet: cycles(longest + 100_000), total: cycles(sent + 200_000 * jobs.len() as u64) }
    }
}

/// A run of frames.
pub(super) struct Bench<'a> {
    pins: Pins<'a>,
    random: Random,
    streams: Streams,
    jobs: &'a [Job],
    source: Source<'a>,
    records: Records,
    units: Units,
    passing: VecDeque<Passing>,
    /// The next frame to leave the smoothers.
    arriving: usize,
    smoothed_at: Option<u64>,
    cycle: u64,
    outcome: Outcome,
}

impl<'a> Bench<'a> {
    pub fn new(
        simulator: &Simulator,
        jobs: &'a [Job],
        streams: Streams,
        recorder: Option<Recorder<'a>>,
    ) -> Result<Self, SimulationError> {
        let mut pins = Pins::new(simulator, streams.seed, recorder)?;
        set!(pins.ports.reset, 1);
        (1..RESET_CYCLES).try_for_each(|_| pins.cycle())?;
        set!(pins.ports.reset, 0);
        pins.cycle()?;
        let pixels = jobs.iter().map(|job| job.pixels.as_slice().len() as u64).sum();
        Ok(Self {
            pins,
            random: Random(streams.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1),
            streams,
            jobs,
            source: Source::new(simulator.design(), jobs)?,
            records: Records::of(simulator.design()),
            units: Units::of(simulator.design()),
            passing: VecDeque::new(),
            arriving: 0,
            smoothed_at: None,
            cycle: 0,
            outcome: Outcome { pixels, frames: vec![FrameOutcome::default(); jobs.len()], ..Outcome::default() },
        })
    }

    /// Runs until the trailer of the last frame has left the FIFO.
    pub fn run(mut self, oracle: &mut Oracle, progress: &mut dyn FnMut(Progress)) -> Result<Outcome, SimulationError> {
        let patience = Patience::new(self.jobs, self.streams);
        let mut accepted = 0;
        while self.records.done < self.jobs.len() && !self.pins.is_recorded() {
            if self.step(oracle)? {
                accepted = self.cycle;
            }
            if self.cycle - accepted > patience.quiet || self.cycle > patience.total {
                let at = Position { frame: self.records.done, x: 0, y: 0 };
                let texts = || ["trailer".into(), "one record".into(), "none: the pipeline hangs".into()];
                self.outcome.differ("end of frame", at, self.cycle, texts);
                break;
            }
            if self.cycle & (PROGRESS_EVERY - 1) == 0 {
                progress(self.progress());
            }
        }
        progress(self.progress());
        if self.pins.recorder.is_some() {
            self.pins.model.trace_close()?;
            return Ok(self.outcome);
        }
        self.finish(oracle)
    }

    fn progress(&self) -> Progress {
        let before: usize = self.jobs.iter().take(self.source.frame).map(|job| job.pixels.as_slice().len()).sum();
        Progress { pixels: (before + self.source.pixel) as u64, frames: self.records.done, cycles: self.cycle }
    }

    /// One clock cycle. Returns whether a record was accepted.
    fn step(&mut self, oracle: &mut Oracle) -> Result<bool, SimulationError> {
        let pause = self.random.chance(self.streams.source_pause);
        self.source.drive(&mut self.pins, pause);
        let sink = self.cycle >= self.streams.sink_opens && !self.random.chance(self.streams.sink_pause);
        set!(self.pins.ports.feature_ready, u8::from(sink));
        self.pins.settle()?;
        if get!(self.pins.capture) == 1 {
            self.source.begun += 1;
            self.source.prepare()?;
        }
        let mut reset_by = None;
        if self.source.offered && get!(self.pins.ports.ready) == 1 {
            if self.source.pixel == 0 {
                self.outcome.frames[self.source.frame].began = self.cycle;
            }
            reset_by = self.source.advance().filter(|job| job.is_lost());
        }
        let accepted = sink && get!(self.pins.ports.feature_valid) == 1;
        if accepted {
            self.take();
            oracle.forget(self.records.done.min(self.jobs.len() - 1));
        }
        if get!(self.pins.advance) == 1 {
            self.compare(oracle);
        }
        self.pins.edge()?;
        self.cycle += 1;
        if let Some(job) = reset_by {
            self.apply_reset(job.fault)?;
        }
        Ok(accepted)
    }

    /// The sink accepts a record.
    fn take(&mut self) {
        let beat = Taken {
            words: self.pins.words(self.pins.ports.feature_data),
            first: get!(self.pins.ports.feature_first) == 1,
            last: get!(self.pins.ports.feature_last) == 1,
        };
        self.outcome.first_feature.get_or_insert(self.cycle);
        self.records.taken(&beat, self.cycle, &mut self.outcome);
    }

    /// A step of the pipeline: samples and written records.
    #[inline]
    fn compare(&mut self, oracle: &mut Oracle) {
        let shown = self.pins.shown();
        for passing in &mut self.passing {
            passing.compare(&shown, self.cycle, &mut self.outcome);
        }
        if self.passing.front().is_some_and(Passing::is_through) {
            self.passing.pop_front();
        }
        if get!(self.pins.start) == 1
            && let Some(expected) = oracle.frame(self.arriving)
        {
            if self.jobs[self.arriving].fault == Fault::None {
                self.smoothed_at = Some(self.cycle + 1 - self.outcome.frames[self.arriving].began);
            }
            self.passing.push_back(Passing::new(self.arriving, expected.planes.clone(), self.units));
            self.arriving += 1;
        }
        if get!(self.pins.write) == 1 {
            let words = self.pins.words(self.pins.record);
            let frame = self.records.writing();
            match self.jobs.get(frame).zip(oracle.frame(frame)) {
                Some((job, expected)) => {
                    self.records.written(words, job, &expected, self.cycle, &mut self.outcome);
                    let (x, y) = ((words[0] & 0xffff) as usize, (words[0] >> 16) as usize);
                    if words[1] >> 31 == 0 && job.fault == Fault::None {
                        let (w, _) = job.size();
                        let arrived = self.outcome.frames[frame].began + (y * w + x) as u64;
                        let lines = self.cycle.saturating_sub(arrived) as f64 / w as f64;
                        self.outcome.feature_latency_lines = Some(lines);
                    }
                }
                None => self.outcome.differ("end of frame", Position { frame, x: 0, y: 0 }, self.cycle, || {
                    ["record".into(), "none".into(), format!("{words:08x?}")]
                }),
            }
        }
    }

    /// Resets the pipeline; all frames inside are lost.
    fn apply_reset(&mut self, fault: Fault) -> Result<(), SimulationError> {
        set!(self.pins.ports.valid, 0);
        set!(self.pins.ports.feature_ready, 0);
        match fault {
            Fault::Reset(_) => {
                self.pins.write(None);
                set!(self.pins.ports.reset, 1);
            }
            _ => {
                let write = self.source.map.clear()?;
                self.pins.write(Some(write));
            }
        }
        self.pins.cycle()?;
        set!(self.pins.ports.reset, 0);
        self.pins.write(None);
        (0..4).try_for_each(|_| self.pins.cycle())?;
        self.cycle += 5;
        let next = self.source.frame;
        for frame in &mut self.outcome.frames[self.records.done..next] {
            frame.model_features = frame.features;
            self.outcome.model_features += frame.features;
        }
        self.source.begun = next;
        self.source.prepare()?;
        self.passing.clear();
        self.arriving = next;
        self.records.restart(next);
        Ok(())
    }

    /// Final checks: rates, latencies and registers.
    fn finish(mut self, oracle: &mut Oracle) -> Result<Outcome, SimulationError> {
        self.outcome.cycles = self.cycle;
        let seen = self.arriving - self.passing.len();
        if self.records.done == self.jobs.len() && seen < self.jobs.len() {
            let samples = || ["samples".into(), "all of them".into(), "not all came by".into()];
            self.outcome.differ("end of frame", Position { frame: seen, x: 0, y: 0 }, self.cycle, samples);
        }
        let frames = &self.outcome.frames;
        // A frame of a new size, like the first one, waits at the input until its size is captured. It does not count
        // for the rate.
        let steady = |i: &usize| {
            let around = &self.jobs[i - 1..=i + 1];
            around.iter().all(|job| job.fault == Fault::None && job.size() == around[0].size())
        };
        let rate = |i: usize| {
            let cycles = frames[i + 1].began.saturating_sub(frames[i].began);
            cycles as f64 / self.jobs[i].pixels.as_slice().len() as f64
        };
        let last = self.jobs.len().saturating_sub(1);
        if self.streams.flow() {
            self.outcome.cycles_per_pixel = (1..last).filter(steady).map(rate).reduce(f64::max);
            let width = self.jobs.iter().rfind(|job| job.fault == Fault::None).map(|job| job.size().0);
            self.outcome.latency_lines = self.smoothed_at.zip(width).map(|(cycles, w)| cycles as f64 / w as f64);
        } else {
            self.outcome.feature_latency_lines = None;
        }
        let status = self.source.map.address("status")?;
        self.outcome.status = self.pins.read(status)?;
        if let (Some(job), Some(frame)) = (self.jobs.last(), self.outcome.frames.last())
            && !job.is_lost()
            && self.records.done == self.jobs.len()
        {
            let expected = oracle.frame(last);
            let thresholds = halves(expected.as_ref().map_or(&[], |expected| &expected.thresholds[..]));
            let registers = [
                ("frames", self.records.frames() as u32),
                ("features", frame.features as u32),
                ("dropped", frame.dropped as u32),
                ("threshold_now", thresholds[0]),
                ("threshold_now_2", thresholds[1]),
            ];
            let has_third = self.pins.smoothed.len() > 3;
            for (name, want) in registers.into_iter().take(if has_third { 5 } else { 4 }) {
                let got = self.pins.read(self.source.map.address(name)?)?;
                if want != got {
                    let text = |word: u32| format!("0x{word:08x}, {word}");
                    let at = Position { frame: last, x: 0, y: 0 };
                    self.outcome.differ("registers", at, self.cycle, || [name.into(), text(want), text(got)]);
                }
            }
        }
        Ok(self.outcome)
    }
}
