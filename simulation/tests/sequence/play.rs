//! A sequence on the ports, and what is expected of it.
//!
//! Three parties share the clock: the source sends what [`Bench`] has queued, the sink takes records, and a driver
//! writes and reads registers. The driver does what software does: it writes the next frame's registers, commits them,
//! lets the frame in, waits until `begun` is set, and clears that bit.

use std::collections::VecDeque;

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::threshold::{Maxima, ThresholdController};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::default_limit;
use hoverlock_rtl::registers::default_coefficients;
use hoverlock_simulation::Simulator;
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

use super::{Before, Fault, Reset, Sequence, Step};
use crate::port_bench::{
    AUTOMATIC, Access, BEGUN, BUSY, Bench, COEFFICIENTS_OFFSET, COMMIT, CONTROL, DROPPED, DROPS, ENABLE, FEATURES,
    FRAME, FRAMES, Frame, INTERRUPTED, LONG, Outcome, Packet, RECORD_LIMIT, REFUSED, SATURATED, SHORT, SIZE, STATUS,
    TARGET, THRESHOLD, THRESHOLD_2, THRESHOLD_NOW, THRESHOLD_NOW_2, equal, fail, most, strongest, threshold_words,
};

/// Cycles after which a frame that does not begin is called a hang.
const MAX_WAIT_CYCLES: u64 = 3_000_000;

/// What was run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tally {
    pub frames: u64,
    pub records: u64,
    pub dropped: u64,
    pub cycles: u64,
}

impl Tally {
    pub fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.records += other.records;
        self.dropped += other.dropped;
        self.cycles += other.cycles;
    }
}

/// What a frame takes with it.
#[derive(Debug, Clone, PartialEq)]
struct Set {
    size: u32,
    thresholds: Vec<u32>,
    target: u32,
    automatic: bool,
    record_limit: u32,
    coefficients: Vec<u32>,
}

impl Set {
    /// The registers after a hardware reset.
    fn reset(design: &DesignPoint) -> Self {
        Self {
            size: (design.height << 16) | design.width,
            thresholds: vec![design.threshold.initial; design.pairs()],
            target: design.threshold.target,
            automatic: false,
            record_limit: default_limit(design.pairs()),
            coefficients: default_coefficients(design).unwrap(),
        }
    }

    fn of(design: &DesignPoint, step: &Step) -> Self {
        let coefficients = match step.coefficients {
            Some(seed) => {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let count = default_coefficients(design).unwrap().len();
                (0..count).map(|_| random.random_range(most(design) / 3..=most(design))).collect()
            }
            None => default_coefficients(design).unwrap(),
        };
        Self {
            size: (step.height << 16 | step.width) as u32,
            thresholds: step.thresholds.clone(),
            target: step.target,
            automatic: step.automatic,
            record_limit: step.record_limit,
            coefficients,
        }
    }

    fn writes(&self) -> Vec<(u32, u32)> {
        let codes = self.coefficients.iter().enumerate().map(|(i, code)| (COEFFICIENTS_OFFSET + 4 * i as u32, *code));
        let control = ENABLE | if self.automatic { AUTOMATIC } else { 0 };
        let others = [(SIZE, self.size), (TARGET, self.target), (RECORD_LIMIT, self.record_limit), (CONTROL, control)];
        codes.chain(others).chain(threshold_words([THRESHOLD, THRESHOLD_2], &self.thresholds)).collect()
    }

    /// The register at the address, where it is one of the set.
    fn register(&mut self, address: u32) -> Option<&mut u32> {
        match address {
            SIZE => Some(&mut self.size),
            TARGET => Some(&mut self.target),
            RECORD_LIMIT => Some(&mut self.record_limit),
            _ => self.coefficients.get_mut(usize::try_from(address.checked_sub(COEFFICIENTS_OFFSET)? / 4).ok()?),
        }
    }
}

/// A frame on its way.
struct Expected {
    /// Beats sent before it.
    start: usize,
    entered: Plane<u16>,
    errors: u32,
    may_drop: bool,
    /// What it may have taken over: a set, or, where there is none, what the frame before took.
    sets: Vec<Option<Set>>,
    begun: bool,
}

/// What the last frame that came out may have been.
#[derive(Debug, Clone, PartialEq)]
struct Last {
    set: Set,
    /// Thresholds, and the features that they found.
    thresholds: Vec<u32>,
    maxima: Vec<Maxima>,
    /// Features that the record limit let through.
    sent: u32,
}

struct Player {
    bench: Bench,
    random: ChaCha8Rng,
    registers: Set,
    /// The registers are a set that frames take over.
    committed: bool,
    control: u32,
    /// Beats queued so far.
    queued: usize,
    /// Writes to be done, each after some cycles.
    writes: VecDeque<(u64, u32, u32)>,
    frames: VecDeque<Expected>,
    /// More than one where several sets give the packet that came out: the next frame may follow any of them.
    last: Vec<Last>,
    /// Frames that came out since the last reset.
    number: u32,
    closed_until: u64,
    sink_pause: f64,
    may_drop: bool,
    /// Status bits that were read, that must be read, and that may be.
    seen: u32,
    must: u32,
    may: u32,
    tally: Tally,
}

pub fn play(sequence: &Sequence, simulator: &Simulator) -> Outcome<Tally> {
    let mut player = Player {
        bench: Bench::new(simulator, sequence.seed),
        random: ChaCha8Rng::seed_from_u64(sequence.seed ^ 0x5e9),
        registers: Set::reset(simulator.design()),
        committed: true,
        control: 0,
        queued: 0,
        writes: VecDeque::new(),
        frames: VecDeque::new(),
        last: Vec::new(),
        number: 0,
        closed_until: 0,
        sink_pause: 0.0,
        may_drop: false,
        seen: 0,
        must: 0,
        may: 0,
        tally: Tally::default(),
    };
    let sequence = sequence.clone().agreed();
    for step in &sequence.frames {
        player.step(step)?;
    }
    player.finish()?;
    player.tally.cycles = player.bench.cycle;
    Ok(player.tally)
}

impl Player {
    /// One clock cycle, with a register read or the next write that is due.
    fn cycle(&mut self, read: Option<u32>) -> Outcome<u32> {
        self.bench.set_sink_pause(if self.bench.cycle < self.closed_until { 1.0 } else { self.sink_pause });
        let write = match self.writes.front_mut() {
            _ if read.is_some() => None,
            Some((0, address, word)) => Some((*address, *word)),
            Some((wait, ..)) => {
                *wait -= 1;
                None
            }
            None => None,
        };
        let visible = self.committed.then(|| self.registers.clone());
        let before = self.taken();
        let access = read.map(Access::Read).or(write.map(|(address, word)| Access::Write(address, word)));
        let value = self.bench.cycle(access);
        let after = self.taken();
        if let Some(frame) = self.frames.back_mut().filter(|frame| !frame.begun) {
            // The third beat finds room only where the first has left the skid buffer: the frame began in a cycle
            // before.
            frame.begun = after >= frame.start + 3;
            if before > frame.start && !frame.begun && frame.sets.last() != Some(&visible) {
                frame.sets.push(visible);
            }
        }
        if let Some((address, word)) = write {
            self.writes.pop_front();
            self.written(address, word);
        }
        while let Some(packet) = self.bench.packets.pop_front() {
            self.packet(&packet)?;
        }
        self.bench.obeyed()?;
        Ok(value)
    }

    /// Beats that were taken since the last reset.
    fn taken(&self) -> usize {
        self.queued - self.bench.pending()
    }

    fn written(&mut self, address: u32, word: u32) {
        if let Some(register) = self.registers.register(address) {
            *register = word;
            self.committed = false;
        } else if let Some(first) = [THRESHOLD, THRESHOLD_2].iter().position(|register| *register == address) {
            let thresholds = self.registers.thresholds.iter_mut().skip(2 * first);
            thresholds.zip([word & 0xffff, word >> 16]).for_each(|(threshold, half)| *threshold = half);
            self.committed = false;
        } else if address == CONTROL {
            let automatic = word & AUTOMATIC != 0;
            self.committed &= automatic == self.registers.automatic;
            self.registers.automatic = automatic;
            self.control = word;
        } else if address == COMMIT {
            self.committed = true;
        }
    }

    fn run(&mut self, cycles: u64) -> Outcome {
        (0..cycles).try_for_each(|_| self.cycle(None).map(|_| ()))
    }

    fn until(&mut self, what: &str, mut holds: impl FnMut(&Self) -> bool) -> Outcome {
        for _ in 0..MAX_WAIT_CYCLES {
            if holds(self) {
                return Ok(());
            }
            self.cycle(None)?;
        }
        fail("hang", format!("{what} not after {MAX_WAIT_CYCLES} cycles"))
    }

    /// Writes in some order, some cycles apart, and the commit behind them.
    fn write_later(&mut self, mut writes: Vec<(u32, u32)>, commit: bool) {
        writes.shuffle(&mut self.random);
        writes.extend(commit.then_some((COMMIT, 1)));
        let spread = [1, 4, 20][self.random.random_range(0..3)];
        for (address, word) in writes {
            let wait = self.random.random_range(0..spread);
            self.writes.push_back((wait, address, word));
        }
    }

    fn write_now(&mut self, writes: Vec<(u32, u32)>, commit: bool) -> Outcome {
        self.write_later(writes, commit);
        self.until("the registers are written", |player| player.writes.is_empty())
    }

    fn send(&mut self, beats: impl IntoIterator<Item = crate::port_bench::Beat>) {
        let before = self.bench.pending();
        self.bench.send(beats);
        self.queued += self.bench.pending() - before;
    }

    /// Reads the status as a driver does, and clears what it saw, or `begun` alone. Gives the bits.
    fn status(&mut self) -> Outcome<u32> {
        let status = self.cycle(Some(STATUS))?;
        self.seen |= status & 0xff;
        if status & BEGUN != 0
            && let Some(frame) = self.frames.back_mut()
        {
            frame.begun = true;
        }
        let clear = if self.random.random() { status & 0xff } else { status & BEGUN };
        if clear != 0 {
            // Not behind the writes of a set that wait their cycles.
            self.writes.push_front((0, STATUS, clear));
            self.cycle(None)?;
        }
        Ok(status)
    }

    fn step(&mut self, step: &Step) -> Outcome {
        let set = Set::of(&self.bench.design, step);
        let beats = step.beats(&self.bench.design);
        self.before(step)?;
        if step.racing.is_none() {
            self.write_now(set.writes(), true)?;
        }
        if step.gap > 0 {
            self.until("the frame before is in", |player| player.bench.is_sent())?;
            self.run(step.gap)?;
        }
        self.bench.set_source_pause(f64::from(step.pauses[0]) / 100.0);
        self.sink_pause = f64::from(step.pauses[1]) / 100.0;
        // A FIFO that is not emptied may be full: by a pause, or by more features than it holds.
        self.may_drop |= step.closed > 0 || step.pauses[1] > 0;
        self.frames.push_back(Expected {
            start: self.queued,
            entered: step.entered(&self.bench.design),
            errors: step.errors(),
            may_drop: self.may_drop,
            sets: Vec::new(),
            begun: false,
        });
        let start = self.queued;
        self.send(beats);
        if let Some(lead) = step.racing {
            self.until("the frame before is in", |player| player.taken() + lead >= start)?;
            self.write_later(set.writes(), true);
        }
        if step.closed > 0 {
            self.until("the frame is taken", |player| player.taken() > start)?;
            self.closed_until = self.bench.cycle + step.closed;
        }
        let limit = self.bench.cycle + MAX_WAIT_CYCLES;
        while self.status()? & BEGUN == 0 {
            if self.bench.cycle > limit {
                return fail("hang", "the frame does not begin");
            }
            let wait = self.random.random_range(0..40);
            self.run(wait)?;
        }
        self.must |= BEGUN;
        self.until("the registers are written", |player| player.writes.is_empty())?;
        if step.scribbles {
            let count = self.registers.coefficients.len() as u32;
            let words = (0..self.random.random_range(1..8)).map(|_| {
                (
                    COEFFICIENTS_OFFSET + 4 * self.random.random_range(0..count),
                    self.random.random_range(0..=most(&self.bench.design)),
                )
            });
            let words: Vec<_> = words.collect();
            self.write_now(words, false)?;
        }
        step.reset.map_or(Ok(()), |reset| self.reset(step, reset, start))
    }

    fn before(&mut self, step: &Step) -> Outcome {
        let packet = |beats: usize, start: bool| (0..beats).map(move |i| (i as u16, start && i == 0, i + 1 == beats));
        // A disabled core, as it is after a hardware reset, says nothing.
        let refused = if self.control & ENABLE != 0 { REFUSED } else { 0 };
        match step.before {
            Before::Nothing => return Ok(()),
            Before::Stray(beats) => {
                self.send(packet(beats, false));
                self.must |= refused;
            }
            Before::Refused(width, height) => {
                self.write_now(vec![(SIZE, height << 16 | width)], true)?;
                self.send(packet(6, true));
                self.must |= refused;
            }
            Before::Disabled(beats, start) => {
                self.until("the frame before is in", |player| player.bench.is_sent())?;
                self.run(4)?;
                self.write_now(vec![(CONTROL, self.control & AUTOMATIC)], false)?;
                self.send(packet(beats, start));
            }
        }
        self.until("the packet is swallowed", |player| player.bench.is_sent())?;
        self.run(4)
    }

    fn reset(&mut self, step: &Step, reset: Reset, start: usize) -> Outcome {
        let beats = reset.beats.min(self.queued - start);
        self.until("the beat of the reset", |player| player.taken() >= start + beats)?;
        self.run(reset.cycles)?;
        // What is on its way is lost; what of it the status has seen by now is not known.
        for frame in &self.frames {
            self.may |= FRAME | DROPS | SATURATED | [0, SHORT, LONG, 0, INTERRUPTED][frame.errors as usize];
        }
        self.frames.clear();
        (self.last, self.number, self.may_drop) = (Vec::new(), 0, false);
        self.closed_until = 0;
        if reset.hard {
            let cycles = self.random.random_range(1..4);
            self.bench.reset(cycles);
            (self.registers, self.committed, self.control) = (Set::reset(&self.bench.design), true, 0);
            (self.seen, self.must, self.may) = (0, 0, 0);
            self.queued = 0;
            let status = self.cycle(Some(STATUS))?;
            return equal("reset", "status", 0, status);
        }
        let left = self.bench.pending();
        self.bench.clear(self.control);
        self.queued = self.bench.pending();
        // The source knows nothing of it: the rest of its frame is refused, unless it is swallowed in the reset itself.
        if left > 8 {
            self.must |= REFUSED;
        }
        self.may |= REFUSED;
        if matches!(step.fault, Fault::Long(..)) || left > 0 {
            self.until("the rest is swallowed", |player| player.bench.is_sent())?;
            self.run(4)?;
        }
        // A rest without an end is ended here.
        if !matches!(step.fault, Fault::None | Fault::Short(_) | Fault::Long(_, true)) && left > 0 {
            self.send([(0, false, true)]);
            self.until("the rest is swallowed", |player| player.bench.is_sent())?;
            self.run(4)?;
        }
        Ok(())
    }

    /// Thresholds of a frame that takes this set after another frame.
    fn thresholds(&self, set: &Set, last: Option<&Last>) -> Vec<u32> {
        match last {
            Some(last) if last.set.automatic && set.automatic => {
                let mut design = self.bench.design.clone();
                design.threshold.target = set.target;
                let mut control = ThresholdController::resumed(&design, &last.thresholds);
                control.finish_frame(&last.maxima);
                control.thresholds().to_vec()
            }
            _ => set.thresholds.iter().map(|threshold| (threshold & strongest(&self.bench.design)).max(1)).collect(),
        }
    }

    /// A packet came out: it is the oldest frame's, with one of the sets that it may have taken.
    fn packet(&mut self, packet: &Packet) -> Outcome {
        let Some(frame) = self.frames.pop_front() else {
            return fail("trailer", format!("a packet too many: {:08x?}", packet.trailer));
        };
        let mut wrong = None;
        let mut found: Vec<(Last, bool)> = Vec::new();
        let before: Vec<Option<&Last>> =
            if self.last.is_empty() { vec![None] } else { self.last.iter().map(Some).collect() };
        for (set, last) in frame.sets.iter().flat_map(|set| before.iter().map(move |last| (set.as_ref(), *last))) {
            let Some(set) = set.or(last.map(|last| &last.set)) else { continue };
            let thresholds = self.thresholds(set, last);
            let mut model =
                Frame::with(&self.bench.design, frame.entered.clone(), &thresholds, set.coefficients.clone());
            model.record_limit = set.record_limit;
            match packet.check(&model, self.number, &thresholds, frame.errors) {
                Ok(dropped) => {
                    let features = model.planes.features(&thresholds);
                    if dropped > 0 && !frame.may_drop && features.len() <= 400 {
                        return fail("record", format!("frame {}: {dropped} dropped without need", self.number));
                    }
                    let sent = packet.records.len() as u32 + dropped;
                    let this = Last { set: set.clone(), thresholds, maxima: model.planes.maxima(), sent };
                    if found.iter().all(|(other, _)| *other != this) {
                        found.push((this, model.saturates()));
                    }
                }
                Err(failure) => wrong = wrong.or(Some(failure)),
            }
        }
        if let Some((first, _)) = found.first() {
            let records = packet.records.len() as u32;
            let dropped = first.sent - records;
            self.must |= FRAME | [0, SHORT, LONG, 0, INTERRUPTED][frame.errors as usize];
            self.must |= if dropped > 0 { DROPS } else { 0 };
            self.must |= if found.iter().all(|(_, saturates)| *saturates) { SATURATED } else { 0 };
            self.may |= if found.iter().any(|(_, saturates)| *saturates) { SATURATED } else { 0 };
            self.tally.frames += 1;
            self.tally.records += u64::from(records);
            self.tally.dropped += u64::from(dropped);
            self.last = found.into_iter().map(|(last, _)| last).collect();
            self.number += 1;
            return Ok(());
        }
        match wrong {
            Some(failure) => fail(failure.stage, format!("{}; {} sets are possible", failure.what, frame.sets.len())),
            None => fail("registers", format!("frame {} began without a set", self.number)),
        }
    }

    /// Everything comes out; then the status and the counts are what they have to be.
    fn finish(&mut self) -> Outcome {
        self.until("the last frame is in", |player| player.bench.is_sent())?;
        self.until("the last packet", |player| player.frames.is_empty())?;
        for _ in 0..MAX_WAIT_CYCLES {
            let status = self.status()?;
            if status & BUSY == 0 {
                self.run(6)?;
                self.status()?;
                let (wrong, extra) = (self.must & !self.seen, self.seen & !(self.must | self.may));
                equal("status", "bits that were never set", 0, wrong)?;
                equal("status", "bits without a reason", 0, extra)?;
                return self.last_counts();
            }
        }
        fail("hang", "the pipeline does not drain")
    }

    fn last_counts(&mut self) -> Outcome {
        let frames = self.cycle(Some(FRAMES))?;
        equal("registers", "frames", self.number, frames)?;
        if let Some(Last { thresholds, sent, .. }) = self.last.first().cloned() {
            let (features, dropped) = (self.cycle(Some(FEATURES))?, self.cycle(Some(DROPPED))?);
            equal("registers", "features and dropped ones", sent, features + dropped)?;
            for (address, word) in threshold_words([THRESHOLD_NOW, THRESHOLD_NOW_2], &thresholds) {
                let now = self.cycle(Some(address))?;
                equal("registers", "thresholds in use", word, now)?;
            }
        }
        for word in 0..self.registers.coefficients.len() as u32 {
            let address = COEFFICIENTS_OFFSET + 4 * word;
            let code = self.cycle(Some(address))?;
            let expected = *self.registers.register(address).unwrap();
            equal("registers", &format!("address 0x{address:02x}"), expected, code)?;
        }
        Ok(())
    }
}
