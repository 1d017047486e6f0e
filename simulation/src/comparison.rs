//! The comparison with `bit_true`: sends the frames, and compares in each clock cycle what passes the stages of the
//! pipeline and what comes out.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use hoverlock_design::{DesignPoint, smoother_names};
use hoverlock_harness::Error;
use hoverlock_harness::bus::Pause;
use hoverlock_harness::bus::avalon_mm::Master;
use hoverlock_harness::bus::stream::{Frame, Rules, Source};
use hoverlock_harness::sim::{Dut, Edge, Queue, Signal, Sim, Wide};

use crate::{
    Progress, SimulationError, Simulator, Streams,
    expect::Oracle,
    job::{Fault, Job, Map},
    outcome::{FrameOutcome, Outcome, Position},
    planes::{Passing, Shown, Units},
    records::{Records, Taken, halves},
    stalls::Stalls,
    top::{HALF_CYCLE, RESET_CYCLES, Top, simulation},
    waves::Recorder,
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

/// Cycles between progress reports: a power of two.
const PROGRESS_INTERVAL: u64 = 1 << 14;

/// Word index of a register, and the value to write.
type RegisterWrite = (u64, u64);

/// The signals that are compared.
struct Probes {
    video_valid: Signal,
    video_ready: Signal,
    feature_valid: Signal,
    feature_ready: Signal,
    feature_first: Signal,
    feature_last: Signal,
    feature_data: Wide,
    capture: Signal,
    advance: Signal,
    start: Signal,
    smoothed: Vec<Signal>,
    response: Vec<Signal>,
    ring: Vec<Signal>,
    write: Signal,
    record: Wide,
}

impl Probes {
    fn find(dut: &Dut, design: &DesignPoint) -> Result<Self, Error> {
        let find = |names: &[String]| -> Result<Vec<Signal>, Error> {
            Ok(names.iter().map(|name| dut.signal(name)).collect::<Result<_, _>>()?)
        };
        let [smoothed, response, ring] = samples(design);
        Ok(Self {
            video_valid: dut.signal("video_valid")?,
            video_ready: dut.signal("video_ready")?,
            feature_valid: dut.signal("feature_valid")?,
            feature_ready: dut.signal("feature_ready")?,
            feature_first: dut.signal("feature_startofpacket")?,
            feature_last: dut.signal("feature_endofpacket")?,
            feature_data: dut.wide("feature_data")?,
            capture: dut.signal("core.sequencer.capture")?,
            advance: dut.signal("core.sequencer.advance")?,
            start: dut.signal("core.extractor.smoothers.start_out")?,
            smoothed: find(&smoothed)?,
            response: find(&response)?,
            ring: find(&ring)?,
            write: dut.signal("core.extractor.write")?,
            record: dut.wide("core.extractor.record")?,
        })
    }

    #[inline]
    fn shown(&self) -> Shown {
        let value = |signals: &[Signal], i: usize| signals.get(i).map_or(0, |signal| signal.get() as u32);
        Shown {
            smoothed: std::array::from_fn(|i| value(&self.smoothed, i)),
            response: std::array::from_fn(|k| value(&self.response, k)),
            ring: std::array::from_fn(|k| value(&self.ring, k)),
        }
    }
}

/// Writes the registers of each frame, one in a cycle, and sends the frame in the cycle after the last of them.
async fn send_frames(
    registers: Master,
    video: Source,
    frames: Queue<(Vec<RegisterWrite>, Frame)>,
) -> Result<(), Error> {
    loop {
        let (writes, frame) = frames.get().await;
        for (i, (word, value)) in writes.iter().enumerate() {
            if i + 1 == writes.len() {
                video.send(&frame)?;
            }
            registers.write(*word, *value).await?;
        }
    }
}

/// Timeouts of a run in clock cycles, far above what working hardware takes.
struct Timeouts {
    /// Without a record.
    quiet: u64,
    total: u64,
}

impl Timeouts {
    fn new(jobs: &[Job], streams: Streams) -> Self {
        let pixels = |job: &Job| job.pixels.as_slice().len() as u64;
        let longest = jobs.iter().map(pixels).max().unwrap_or_default();
        let sent: u64 = jobs.iter().map(|job| job.beats() as u64 + pixels(job)).sum();
        let share = (1.0 - streams.source_pause.max(streams.sink_pause)).max(0.01);
        let cycles = |pixels: u64| (4.0 * pixels as f64 / share) as u64 + streams.sink_opens;
        Self { quiet: cycles(longest + 100_000), total: cycles(sent + 200_000 * jobs.len() as u64) }
    }
}

/// A simulation with a run of frames in it.
pub(crate) struct Comparison<'a> {
    sim: Sim,
    run: Run<'a>,
}

impl<'a> Comparison<'a> {
    pub fn new(
        simulator: &Simulator,
        jobs: &'a [Job],
        streams: Streams,
        recorder: Option<Recorder<'a>>,
    ) -> Result<Self, SimulationError> {
        let sim = simulation(simulator, streams.seed)?;
        let dut = sim.dut();
        if let Some(recorder) = &recorder {
            dut.start_waves(&recorder.recording())?;
        }
        let run = Run::new(&dut, simulator.design(), jobs, streams, recorder)?;
        Ok(Self { sim, run })
    }

    /// Runs until the trailer of the last frame has left the FIFO, or the window of the waves is complete.
    pub fn run(self, oracle: &mut Oracle, progress: &mut dyn FnMut(Progress)) -> Result<Outcome, SimulationError> {
        let Self { mut sim, mut run } = self;
        let mut finished = sim.run(async { Ok::<_, Error>(run.play(oracle, progress).await) })?;
        if run.recorder.is_some() {
            sim.stop_waves()?;
        } else if finished.is_ok() {
            finished = sim.run(async { Ok::<_, Error>(run.finish(oracle).await) })?;
        }
        finished.map(|()| run.outcome)
    }
}

/// A run of frames.
struct Run<'a> {
    top: Top,
    probes: Probes,
    stalls: Rc<RefCell<Stalls>>,
    recorder: Option<Recorder<'a>>,
    streams: Streams,
    jobs: &'a [Job],
    map: Map,
    /// The largest pixel: beats beyond the end of a frame are arbitrary, but fit the port.
    largest: u64,
    /// The frames that are to be sent, with their registers.
    frames: Queue<(Vec<RegisterWrite>, Frame)>,
    /// The frame whose beats enter, and how many of them have.
    frame: usize,
    beats: usize,
    /// Frames that have captured their registers.
    begun: usize,
    records: Records,
    units: Units,
    passing: VecDeque<Passing>,
    /// The next frame to leave the smoothers.
    arriving: usize,
    smoothed_at: Option<u64>,
    cycle: u64,
    outcome: Outcome,
}

impl<'a> Run<'a> {
    fn new(
        dut: &Dut,
        design: &DesignPoint,
        jobs: &'a [Job],
        streams: Streams,
        recorder: Option<Recorder<'a>>,
    ) -> Result<Self, SimulationError> {
        let stalls = Rc::new(RefCell::new(Stalls::new(streams)));
        let drawn = stalls.clone();
        // Before the source and the sink, which follow the draw.
        dut.on_edge(&dut.signal("clock")?, Edge::Rising, move || {
            drawn.borrow_mut().draw();
            Ok::<_, Error>(())
        });
        let top = Top::new(dut, design, Rules::Recorded)?;
        top.video.set_pause(Pause::while_on(&stalls.borrow().source));
        top.features.set_pause(Pause::while_on(&stalls.borrow().sink));
        let frames = dut.queue("frames to send", jobs.len());
        dut.spawn("frames", send_frames(top.registers.clone(), top.video.clone(), frames.clone()));
        let pixels = jobs.iter().map(|job| job.pixels.as_slice().len() as u64).sum();
        Ok(Self {
            probes: Probes::find(dut, design)?,
            top,
            stalls,
            recorder,
            streams,
            jobs,
            map: Map::new(design)?,
            largest: design.pixel.max_raw() as u64,
            frames,
            frame: 0,
            beats: 0,
            begun: 0,
            records: Records::of(design, streams),
            units: Units::of(design),
            passing: VecDeque::new(),
            arriving: 0,
            smoothed_at: None,
            cycle: 0,
            outcome: Outcome { pixels, frames: vec![FrameOutcome::default(); jobs.len()], ..Outcome::default() },
        })
    }

    /// Sends all frames and compares what comes out.
    async fn play(&mut self, oracle: &mut Oracle, progress: &mut dyn FnMut(Progress)) -> Result<(), SimulationError> {
        let clock = self.top.clock.clone();
        self.start().await?;
        self.prepare()?;
        let timeouts = Timeouts::new(self.jobs, self.streams);
        let mut accepted = 0;
        while self.records.done < self.jobs.len() && !self.is_recorded() {
            clock.rising_edge().await;
            if self.cycle(oracle).await? {
                accepted = self.cycle;
            }
            if self.cycle - accepted > timeouts.quiet || self.cycle > timeouts.total {
                let at = Position { frame: self.records.done, x: 0, y: 0 };
                let texts = || ["trailer".into(), "one record".into(), "none: the pipeline hangs".into()];
                self.outcome.differ("end of frame", at, self.cycle, texts);
                break;
            }
            if self.cycle & (PROGRESS_INTERVAL - 1) == 0 {
                progress(self.progress());
            }
        }
        progress(self.progress());
        Ok(())
    }

    /// The recorder has its whole window.
    fn is_recorded(&self) -> bool {
        self.recorder.as_ref().is_some_and(|recorder| recorder.is_past(self.cycle + RESET_CYCLES))
    }

    fn progress(&self) -> Progress {
        let before: usize = self.jobs.iter().take(self.frame).map(|job| job.pixels.as_slice().len()).sum();
        Progress { pixels: (before + self.beats) as u64, frames: self.records.done, cycles: self.cycle }
    }

    /// Has the registers of the next frame written and the frame sent, once the one before has captured its own.
    fn prepare(&mut self) -> Result<(), SimulationError> {
        let Some(job) = self.jobs.get(self.begun) else { return Ok(()) };
        let writes = self.map.writes(job)?.into_iter().map(|(address, value)| (u64::from(address / 4), value.into()));
        // The queue has room for all frames.
        let _ = self.frames.try_put((writes.collect(), job.frame(self.largest)));
        Ok(())
    }

    /// Looks at one clock cycle, before its rising edge. Returns whether a record was taken.
    async fn cycle(&mut self, oracle: &mut Oracle) -> Result<bool, SimulationError> {
        if self.probes.capture.is_high() {
            // A frame that a reset cuts off is not followed before that.
            let is_lost = self.jobs.get(self.begun).is_some_and(Job::is_lost);
            self.begun += 1;
            if !is_lost {
                self.prepare()?;
            }
        }
        let mut reset_by = None;
        if self.probes.video_valid.is_high() && self.probes.video_ready.is_high() {
            reset_by = self.beat_entered().filter(|job| job.is_lost());
        }
        let accepted = self.probes.feature_valid.is_high() && self.probes.feature_ready.is_high();
        if accepted {
            self.take();
            oracle.forget(self.records.done.min(self.jobs.len() - 1));
        }
        if self.probes.advance.is_high() {
            self.compare(oracle);
        }
        self.cycle += 1;
        if let Some(job) = reset_by {
            self.lose_frames(job.fault).await?;
        }
        Ok(accepted)
    }

    /// Counts a beat of the video. Returns the frame if this was its last beat.
    fn beat_entered(&mut self) -> Option<&'a Job> {
        if self.beats == 0 {
            self.outcome.frames[self.frame].began = self.cycle;
        }
        self.beats += 1;
        let job = &self.jobs[self.frame];
        if self.beats < job.beats() {
            return None;
        }
        (self.frame, self.beats) = (self.frame + 1, 0);
        Some(job)
    }

    /// The sink takes a record.
    fn take(&mut self) {
        let beat = Taken {
            words: self.probes.feature_data.get_array(),
            first: self.probes.feature_first.is_high(),
            last: self.probes.feature_last.is_high(),
        };
        self.outcome.first_feature.get_or_insert(self.cycle);
        self.records.taken(&beat, self.cycle, &mut self.outcome);
        // Packets are compared record by record.
        while self.top.features.try_recv().is_some() {}
    }
    /// A step of the pipeline: samples and written records.
    #[inline]
    fn compare(&mut self, oracle: &mut Oracle) {
        let shown = self.probes.shown();
        for passing in &mut self.passing {
            passing.compare(&shown, self.cycle, &mut self.outcome);
        }
        if self.passing.front().is_some_and(Passing::is_through) {
            self.passing.pop_front();
        }
        if self.probes.start.is_high()
            && let Some(expected) = oracle.frame(self.arriving)
        {
            if self.jobs[self.arriving].fault == Fault::None {
                self.smoothed_at = Some(self.cycle + 1 - self.outcome.frames[self.arriving].began);
            }
            self.passing.push_back(Passing::new(self.arriving, expected.planes.clone(), self.units));
            self.arriving += 1;
        }
        if self.probes.write.is_high() {
            let words = self.probes.record.get_array();
            let frame = self.records.writing();
            match self.jobs.get(frame).zip(oracle.frame(frame)) {
                Some((job, expected)) => {
                    self.records.written(words, job, &expected, self.cycle, &mut self.outcome);
                    let (x, y) = ((words[0] & 0xffff) as usize, (words[0] >> 16) as usize);
                    if words[1] >> 31 == 0 && job.fault == Fault::None {
                        let (w, _) = job.size();
                        let arrived = self.outcome.frames[frame].began + (y * w + x) as u64;
                        let lines = self.cycle.saturating_sub(arrived) as f64 / w as f64;
                        let least = &mut self.outcome.feature_latency_lines;
                        *least = Some(least.map_or(lines, |least| least.min(lines)));
                    }
                }
                None => self.outcome.differ("end of frame", Position { frame, x: 0, y: 0 }, self.cycle, || {
                    ["record".into(), "none".into(), format!("{words:08x?}")]
                }),
            }
        }
    }

    /// The reset before the first cycle.
    async fn start(&mut self) -> Result<(), SimulationError> {
        let Top { clock, reset, feature_reset, .. } = &self.top;
        feature_reset.set(true);
        reset.set(1)?;
        clock.cycles(RESET_CYCLES - 1).await;
        reset.set(0)?;
        self.stalls.borrow_mut().release(0);
        clock.rising_edge().await;
        feature_reset.set(false);
        Ok(())
    }

    /// Resets in the cycles that follow: the top, or by `Fault::Clear` its pipeline alone. All frames inside are lost.
    async fn lose_frames(&mut self, fault: Fault) -> Result<(), SimulationError> {
        let Top { clock, reset, feature_reset, .. } = &self.top;
        self.stalls.borrow_mut().hold();
        feature_reset.set(true);
        if let Fault::Clear(_) = fault {
            let (address, value) = self.map.clear()?;
            self.top.write(address, value).await?;
        } else {
            reset.set(1)?;
            clock.rising_edge().await;
            reset.set(0)?;
        }
        clock.cycles(RESET_CYCLES - 2).await;
        self.cycle += RESET_CYCLES;
        self.stalls.borrow_mut().release(self.cycle);
        clock.rising_edge().await;
        feature_reset.set(false);
        self.top.features.clear();
        let next = self.frame;
        for frame in &mut self.outcome.frames[self.records.done..next] {
            frame.model_features = frame.features;
            self.outcome.model_features += frame.features;
        }
        self.begun = next;
        self.prepare()?;
        self.passing.clear();
        self.arriving = next;
        self.records.restart(next);
        Ok(())
    }

    /// Final checks: rates, latencies and registers.
    async fn finish(&mut self, oracle: &mut Oracle) -> Result<(), SimulationError> {
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
        if let Some(violation) = self.top.features.violations().first() {
            let edge = (violation.time - HALF_CYCLE).as_fs() / (HALF_CYCLE * 2).as_fs();
            let cycle = edge.saturating_sub(RESET_CYCLES);
            let begun = self.outcome.frames.iter().take(self.frame + 1).filter(|frame| frame.began <= cycle).count();
            let at = Position { frame: begun.saturating_sub(1), x: 0, y: 0 };
            let texts = || ["rule".into(), "kept".into(), violation.rule.clone()];
            self.outcome.differ("feature stream", at, cycle, texts);
        }
        let status = self.map.address("status")?;
        self.outcome.status = self.top.read(status).await?;
        self.outcome.emission = self.top.read(self.map.address("emission")?).await?;
        if let (Some(job), Some(frame)) = (self.jobs.last(), self.outcome.frames.last())
            && !job.is_lost()
            && self.records.done == self.jobs.len()
        {
            let expected = oracle.frame(last);
            let thresholds = halves(expected.as_ref().map_or(&[], |expected| &expected.thresholds[..]));
            let mut registers = vec![
                ("frames", self.records.frames() as u32, u32::MAX),
                ("features", frame.features as u32, u32::MAX),
                ("dropped", frame.dropped as u32, u32::MAX),
                ("threshold_now", thresholds[0], u32::MAX),
            ];
            if self.probes.smoothed.len() > 3 {
                registers.push(("threshold_now_2", thresholds[1], u32::MAX));
            }
            // A frame that a reset cuts off may have set a bit or not.
            if !self.jobs.iter().any(Job::is_lost) {
                let [set, unknown] =
                    [self.sticky_bits(), vec!["saturated", "busy"]].map(|bits| self.map.mask("status", &bits));
                registers.push(("status", set?, !unknown?));
            }
            for (name, want, compared) in registers {
                let got = self.top.read(self.map.address(name)?).await? & compared;
                if want != got {
                    let text = |word: u32| format!("0x{word:08x}, {word}");
                    let at = Position { frame: last, x: 0, y: 0 };
                    self.outcome.differ("registers", at, self.cycle, || [name.into(), text(want), text(got)]);
                }
            }
        }
        Ok(())
    }

    /// Returns the status bits that the frames have set, none of which was cut off by a reset.
    fn sticky_bits(&self) -> Vec<&'static str> {
        let errors = self.jobs.iter().fold(0, |errors, job| errors | job.errors());
        let is_dropped = self.outcome.frames.iter().any(|frame| frame.dropped > 0);
        let bits = [
            ("frame", true),
            ("short_frame", errors & 1 != 0),
            ("long_frame", errors & 2 != 0),
            ("interrupted", errors & 4 != 0),
            ("dropped", is_dropped),
            ("begun", true),
        ];
        bits.into_iter().filter(|(_, is_set)| *is_set).map(|(name, _)| name).collect()
    }
}
