//! A bench that uses only the ports of the top: two streams, registers, interrupt, reset.
//!
//! The comparison in `simulation` reads internal signals. This bench checks the behaviour at the interfaces: packets,
//! trailers, status bits, the interrupt, the state after a reset. Each scenario ends with the first difference it
//! finds.

#![allow(dead_code, reason = "each test binary uses its part")]

pub mod abrupt;
pub mod scenarios;

use std::{cell::RefCell, collections::VecDeque, fmt, rc::Rc, time::Instant};

use hoverlock_design::{DesignPoint, SHIPPED, pipeline};
use hoverlock_fixed_point::model::bit_true::{BitTrue, Planes};
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_fixed_point::model::record_limit::RecordLimit;
use hoverlock_harness::Error;
use hoverlock_harness::bus::stream::{Frame as StreamFrame, Rules};
use hoverlock_harness::bus::{Pause, Switch};
use hoverlock_harness::sim::{Edge, Signal, Sim};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::{FLAG_TEN_WORDS, FLAG_TRAILER, RECORD_WORDS, default_limit, record_words};
use hoverlock_rtl::emission::files_of;
use hoverlock_rtl::registers::default_coefficients;
use hoverlock_simulation::{Simulator, Top, Trace, simulation};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use hoverlock_registers::COEFFICIENTS_OFFSET;
pub use hoverlock_registers::kt27::{
    COMMIT, CONTROL, CONTROL_AUTOMATIC as AUTOMATIC, CONTROL_ENABLE as ENABLE,
    CONTROL_INTERRUPT_ERROR as INTERRUPT_ERROR, CONTROL_INTERRUPT_FRAME as INTERRUPT_FRAME, CONTROL_RESET as RESET,
    DROPPED, FEATURES, FRAMES, RECORD_LIMIT, SIZE, STATUS, STATUS_BEGUN as BEGUN, STATUS_BUSY as BUSY,
    STATUS_DROPPED as DROPS, STATUS_FRAME as FRAME, STATUS_INTERRUPTED as INTERRUPTED, STATUS_LONG_FRAME as LONG,
    STATUS_REFUSED as REFUSED, STATUS_SATURATED as SATURATED, STATUS_SHORT_FRAME as SHORT, TARGET, THRESHOLD,
    THRESHOLD_NOW,
};

/// Byte addresses of the registers that designs of three scale pairs have in addition.
pub const THRESHOLD_2: u32 = 0x34;
pub const THRESHOLD_NOW_2: u32 = 0x38;

/// The failure of a scenario: the stage and the difference.
#[derive(Debug, Clone)]
pub struct Failure {
    pub stage: &'static str,
    pub what: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.stage, self.what)
    }
}

pub type Outcome<T = ()> = Result<T, Failure>;

pub fn fail<T>(stage: &'static str, what: impl Into<String>) -> Outcome<T> {
    Err(Failure { stage, what: what.into() })
}

pub fn equal<T: PartialEq + fmt::LowerHex>(stage: &'static str, what: &str, expected: T, actual: T) -> Outcome {
    if expected == actual {
        Ok(())
    } else {
        fail(stage, format!("{what}: expected 0x{expected:x}, actual 0x{actual:x}"))
    }
}

/// A frame with its register values and the planes of `bit_true`.
#[derive(Debug, Clone)]
pub struct Frame {
    pub pixels: Plane<u16>,
    pub coefficients: Vec<u32>,
    /// `T_k` of each scale pair.
    pub thresholds: Vec<u32>,
    pub planes: Planes,
    /// Most features that it sends.
    pub record_limit: u32,
    /// The largest response, LSB of the DoG.
    pub max: u32,
}

impl Frame {
    /// With the coefficients and the record limit of the design. Samples are those of its camera.
    pub fn new(design: &DesignPoint, pixels: Plane<u16>, thresholds: &[u32]) -> Self {
        Self::with(design, pixels, thresholds, default_coefficients(design).unwrap())
    }

    pub fn with(design: &DesignPoint, pixels: Plane<u16>, thresholds: &[u32], coefficients: Vec<u32>) -> Self {
        assert_eq!(thresholds.len(), design.pairs());
        let planes = BitTrue::new(design).unwrap().with_coefficients(&coefficients).planes(&pixels);
        let (record_limit, max) = (default_limit(design.pairs()), design.max_dog());
        Self { pixels, coefficients, thresholds: thresholds.to_vec(), planes, record_limit, max }
    }

    pub fn width(&self) -> usize {
        self.pixels.width()
    }

    pub fn height(&self) -> usize {
        self.pixels.height()
    }

    pub fn saturates(&self) -> bool {
        self.planes.saturated.iter().any(|count| *count > 0)
    }

    /// Returns the features that the record limit lets through at `thresholds`, LSB of the DoG, and the number of
    /// those withheld.
    pub fn sent(&self, thresholds: &[u32]) -> (Vec<FeatureRecord>, usize) {
        let features = self.planes.features(thresholds);
        let sent = RecordLimit::sent(self.record_limit, thresholds, self.max, self.height(), &features);
        let withheld = features.len() - sent.len();
        (sent, withheld)
    }

    /// Returns the records of [`Frame::sent`], packed.
    pub fn records(&self, thresholds: &[u32]) -> Vec<Words> {
        self.sent(thresholds).0.iter().map(FeatureRecord::pack).collect()
    }

    /// Its beats, all of them: pixel, start, end.
    pub fn beats(&self) -> Vec<Beat> {
        let last = self.pixels.as_slice().len() - 1;
        self.pixels.as_slice().iter().enumerate().map(|(i, pixel)| (*pixel, i == 0, i == last)).collect()
    }
}

/// One beat of the video stream: pixel, start of packet, end of packet.
pub type Beat = (u16, bool, bool);

/// The words of a record; those that the records of the design do not have are 0.
pub type Words = [u32; RECORD_WORDS];

/// A packet of features with its trailer.
#[derive(Debug, Clone)]
pub struct Packet {
    pub records: Vec<Words>,
    pub trailer: Words,
}

/// A register access of one cycle.
#[derive(Clone, Copy)]
pub enum Access {
    Read(u32),
    Write(u32, u32),
}

/// The chances of pauses, drawn for each cycle.
struct Pauses {
    random: ChaCha8Rng,
    source: f64,
    sink: f64,
    source_switch: Switch,
    sink_switch: Switch,
}

impl Pauses {
    fn draw(&mut self) {
        let mut chance = |p: f64| p > 0.0 && self.random.random_bool(p.min(1.0));
        self.source_switch.set(chance(self.source));
        self.sink_switch.set(chance(self.sink));
    }
}

pub struct Bench {
    /// The design that is simulated.
    pub design: DesignPoint,
    sim: Rc<RefCell<Sim>>,
    top: Top,
    csr: CsrPorts,
    feature_ready: Signal,
    random: ChaCha8Rng,
    pauses: Rc<RefCell<Pauses>>,
    /// Complete packets that were not checked yet.
    pub packets: VecDeque<Packet>,
    /// Cycles since the first reset.
    pub cycle: u64,
}

/// The register port, for one access in a cycle of the test's choice.
struct CsrPorts {
    address: Signal,
    read: Signal,
    readdata: Signal,
    write: Signal,
    writedata: Signal,
}

impl Bench {
    /// Out of reset, with a first content of registers and memories that the seed decides.
    pub fn new(simulator: &Simulator, seed: u64) -> Self {
        let sim = simulation(simulator, seed).unwrap();
        let dut = sim.dut();
        let pauses = Rc::new(RefCell::new(Pauses {
            random: ChaCha8Rng::seed_from_u64(seed ^ 0x5a5a),
            source: 0.0,
            sink: 0.0,
            source_switch: Switch::default(),
            sink_switch: Switch::default(),
        }));
        let drawn = pauses.clone();
        dut.on_edge(&dut.signal("clock").unwrap(), Edge::Rising, move || {
            drawn.borrow_mut().draw();
            Ok::<_, Error>(())
        });
        let top = Top::new(&dut, simulator.design(), Rules::Recorded).unwrap();
        top.video.set_pause(Pause::while_on(&pauses.borrow().source_switch));
        top.features.set_pause(Pause::while_on(&pauses.borrow().sink_switch));
        top.video.randomize_idle(seed);
        let signal = |name: &str| dut.signal(name).unwrap();
        let csr = CsrPorts {
            address: signal("csr_address"),
            read: signal("csr_read"),
            readdata: signal("csr_readdata"),
            write: signal("csr_write"),
            writedata: signal("csr_writedata"),
        };
        let mut bench = Self {
            design: simulator.design().clone(),
            feature_ready: signal("feature_ready"),
            sim: Rc::new(RefCell::new(sim)),
            top,
            csr,
            random: ChaCha8Rng::seed_from_u64(seed),
            pauses,
            packets: VecDeque::new(),
            cycle: 0,
        };
        bench.reset(4);
        bench
    }

    /// Runs a part of the test in the simulation.
    fn play<T>(&mut self, part: impl AsyncFnOnce(&mut Self) -> Result<T, Error>) -> T {
        let sim = self.sim.clone();
        let result = sim.borrow_mut().run(part(self));
        result.expect("the simulation runs")
    }

    /// Sets the chance that no beat is offered in a cycle.
    pub fn set_source_pause(&mut self, chance: f64) {
        self.pauses.borrow_mut().source = chance;
    }

    /// Sets the chance that no record is taken in a cycle, from the next one on; 1 closes the sink.
    pub fn set_sink_pause(&mut self, chance: f64) {
        let mut pauses = self.pauses.borrow_mut();
        if pauses.sink != chance {
            pauses.sink = chance;
            pauses.draw();
            self.feature_ready.set(u64::from(!pauses.sink_switch.is_on())).unwrap();
        }
    }

    /// Queues beats; the first is offered in the cycle after the next edge.
    pub fn send(&mut self, beats: impl IntoIterator<Item = Beat>) {
        self.send_after(0, beats);
    }

    /// Queues beats behind a gap of at least `gap` cycles.
    pub fn send_after(&mut self, gap: u64, beats: impl IntoIterator<Item = Beat>) {
        // A packet begins at each start and after each end.
        let mut packets: Vec<Vec<Beat>> = Vec::new();
        for beat in beats {
            match packets.last_mut() {
                Some(packet) if !beat.1 && packet.last().is_some_and(|before| !before.2) => packet.push(beat),
                _ => packets.push(vec![beat]),
            }
        }
        for (i, packet) in packets.iter().enumerate() {
            let mut frame = StreamFrame::new(&packet.iter().map(|beat| beat.0).collect::<Vec<u16>>());
            if !packet[0].1 {
                frame = frame.without_start();
            }
            if !packet[packet.len() - 1].2 {
                frame = frame.without_end();
            }
            self.top.video.send(&frame.after_gap(if i == 0 { gap } else { 0 })).unwrap();
        }
    }

    /// Beats that the top has not taken yet.
    pub fn pending(&self) -> usize {
        self.top.video.pending()
    }

    /// All beats were taken.
    pub fn is_sent(&self) -> bool {
        self.pending() == 0
    }

    /// Asserts reset for some cycles. Transfers in progress on the streams are lost.
    pub fn reset(&mut self, cycles: u32) {
        self.top.feature_reset.set(true);
        self.top.reset.set(1).unwrap();
        self.forget();
        self.run(cycles.into());
        self.top.reset.set(0).unwrap();
        // The reset of the pipeline is registered: one cycle later.
        self.run(1);
        self.top.feature_reset.set(false);
        self.forget();
    }

    /// Discards transfers in progress on both streams, as at a reset.
    pub fn forget(&mut self) {
        self.top.video.clear();
        self.forget_records();
    }

    /// Discards the records of the packet in progress.
    pub fn forget_records(&mut self) {
        self.packets.clear();
        self.top.features.clear();
    }

    /// One clock cycle. Gives the data of a read, which come with its edge.
    async fn clocked(&mut self, access: Option<Access>) -> Result<u32, Error> {
        // Address and data are random while neither `read` nor `write` is set.
        let (address, word, read, write) = match access {
            Some(Access::Read(address)) => (address, self.random.random(), 1, 0),
            Some(Access::Write(address, word)) => (address, word, 0, 1),
            None => (self.random.random(), self.random.random(), 0, 0),
        };
        self.csr.address.set(u64::from(address >> 2 & 63))?;
        self.csr.writedata.set(word.into())?;
        self.csr.read.set(read)?;
        self.csr.write.set(write)?;
        self.top.clock.rising_edge().await;
        self.cycle += 1;
        while let Some(packet) = self.top.features.try_recv() {
            self.packets.push_back(Packet::of(&packet.symbols, record_words(self.design.pairs())));
        }
        if read == 0 {
            return Ok(0);
        }
        self.top.dut.read_write().await;
        Ok(self.csr.readdata.get() as u32)
    }

    /// One clock cycle.
    pub fn cycle(&mut self, access: Option<Access>) -> u32 {
        self.play(async |bench| bench.clocked(access).await)
    }

    pub fn run(&mut self, cycles: u64) {
        self.play(async |bench| {
            for _ in 0..cycles {
                bench.clocked(None).await?;
            }
            Ok(())
        });
    }

    pub fn write(&mut self, address: u32, word: u32) {
        self.cycle(Some(Access::Write(address, word)));
    }

    /// Reads a register. Other inputs are random; read data comes one cycle later and is stable.
    pub fn read(&mut self, address: u32) -> u32 {
        self.cycle(Some(Access::Read(address)))
    }

    pub fn interrupt(&mut self) -> bool {
        self.top.irq.is_high()
    }

    /// No protocol error on the feature stream so far.
    pub fn obeyed(&self) -> Outcome {
        match self.top.features.violations().first() {
            None => Ok(()),
            Some(violation) => fail("feature stream", violation.rule.clone()),
        }
    }

    /// Runs until a condition is true; a failure after `limit` cycles.
    pub fn until(&mut self, what: &str, limit: u64, mut condition: impl FnMut(&Self) -> bool) -> Outcome {
        let holds = self.play(async |bench| {
            for _ in 0..limit {
                if condition(bench) {
                    return Ok(true);
                }
                bench.clocked(None).await?;
            }
            Ok(false)
        });
        self.obeyed()?;
        if holds { Ok(()) } else { fail("hang", format!("{what} not after {limit} cycles")) }
    }

    /// Reads the status until a condition holds.
    fn until_status(&mut self, what: &str, condition: impl Fn(&Self, u32) -> bool) -> Outcome {
        let holds = self.play(async |bench| {
            // The frame before may have to end first, and the pipeline to drain.
            for _ in 0..2_000_000 {
                let status = bench.clocked(Some(Access::Read(STATUS))).await?;
                if condition(bench, status) {
                    return Ok(true);
                }
            }
            Ok(false)
        });
        self.obeyed()?;
        if holds { Ok(()) } else { fail("hang", what) }
    }

    /// Writes what a frame needs, and commits it.
    pub fn configure(&mut self, frame: &Frame) {
        self.write(SIZE, (frame.height() << 16 | frame.width()) as u32);
        for (address, word) in threshold_words([THRESHOLD, THRESHOLD_2], &frame.thresholds) {
            self.write(address, word);
        }
        self.write(RECORD_LIMIT, frame.record_limit);
        for (i, raw) in frame.coefficients.iter().enumerate() {
            self.write(COEFFICIENTS_OFFSET + 4 * i as u32, *raw);
        }
        self.write(COMMIT, 1);
    }

    /// Sends a frame as a driver does: configures, sends, waits until `begun` is set, and clears it.
    pub fn begin(&mut self, frame: &Frame, beats: impl IntoIterator<Item = Beat>) -> Outcome {
        self.configure(frame);
        self.send(beats);
        self.until_status("the frame does not begin", |_, status| status & BEGUN != 0)?;
        self.write(STATUS, BEGUN);
        Ok(())
    }

    /// The next packet.
    pub fn packet(&mut self) -> Outcome<Packet> {
        self.until("a packet", 400_000, |bench| !bench.packets.is_empty())?;
        Ok(self.packets.pop_front().unwrap())
    }

    /// The next packet is this frame's, whole.
    pub fn exactly(&mut self, frame: &Frame, number: u32, thresholds: &[u32], errors: u32) -> Outcome {
        let packet = self.packet()?;
        let dropped = packet.check(frame, number, thresholds, errors)?;
        equal("record", "dropped features", 0, dropped)
    }

    /// The registers of the thresholds in use read these.
    pub fn has_thresholds(&mut self, thresholds: &[u32]) -> Outcome {
        for (address, word) in threshold_words([THRESHOLD_NOW, THRESHOLD_NOW_2], thresholds) {
            equal("registers", "thresholds in use", word, self.read(address))?;
        }
        Ok(())
    }

    /// Resets by software and discards the records in progress, as their sink must do.
    pub fn clear(&mut self, control: u32) {
        self.top.feature_reset.set(true);
        self.write(CONTROL, control | RESET);
        self.run(2);
        self.top.feature_reset.set(false);
        self.forget_records();
    }

    /// All records are out and the pipeline is empty.
    pub fn idle(&mut self) -> Outcome {
        self.until_status("the pipeline does not drain", |bench, status| status & BUSY == 0 && bench.is_sent())?;
        // The last beats may still be in the skid buffer, and their errors on the way to the status.
        self.run(6);
        self.obeyed()
    }
}

impl Packet {
    /// The packet of symbols as the sink received them: the last of the `words` of a record first.
    fn of(symbols: &[u64], words: usize) -> Self {
        let word = |record: &[u64], i: usize| (i < words).then(|| record.get(words - 1 - i)).flatten().copied();
        let mut records: Vec<Words> = symbols
            .chunks(words)
            .map(|record| std::array::from_fn(|i| word(record, i).unwrap_or_default() as u32))
            .collect();
        let trailer = records.pop().unwrap_or_default();
        Self { records, trailer }
    }

    /// No record but the last is a trailer.
    fn is_whole(&self) -> bool {
        let is_trailer = |words: &Words| words[1] >> 16 & u32::from(FLAG_TRAILER) != 0;
        is_trailer(&self.trailer) && !self.records.iter().any(is_trailer)
    }

    /// Compares with `bit_true`: all records or an ordered part of them, and the whole trailer. Returns the number of
    /// dropped features.
    pub fn check(&self, frame: &Frame, number: u32, thresholds: &[u32], errors: u32) -> Outcome<u32> {
        if !self.is_whole() {
            return fail(
                "feature stream",
                format!("frame {number}: a trailer elsewhere than at the end of its packet"),
            );
        }
        let whole = frame.records(thresholds);
        let mut rest = whole.iter();
        for record in &self.records {
            if !rest.any(|expected| expected == record) {
                return fail(
                    "record",
                    format!("frame {number}: {record:08x?} is none of the model's, or out of order"),
                );
            }
        }
        let dropped = (whole.len() - self.records.len()) as u32;
        let [now, now_2] = halves(thresholds);
        let withheld = frame.sent(thresholds).1 as u32;
        let flags = FLAG_TRAILER | if thresholds.len() > 2 { FLAG_TEN_WORDS } else { 0 };
        let (first, sent) = (u32::from(flags) << 16 | errors, self.records.len() as u32);
        let trailer = [number, first, sent, dropped, now, now_2, withheld, 0, 0, 0];
        if self.trailer != trailer {
            return fail("trailer", format!("frame {number}: expected {trailer:08x?}, actual {:08x?}", self.trailer));
        }
        Ok(dropped)
    }

    /// The thresholds that its trailer reports, one for each of the scale pairs.
    pub fn thresholds(&self, pairs: usize) -> Vec<u32> {
        let halves = [self.trailer[4] & 0xffff, self.trailer[4] >> 16, self.trailer[5]];
        halves[..pairs].to_vec()
    }
}

/// Thresholds of 16 bits in the words of registers and trailers: the first lowest, two in a word.
pub fn halves(thresholds: &[u32]) -> [u32; 2] {
    let half = |k: usize| thresholds.get(k).copied().unwrap_or_default();
    [half(1) << 16 | half(0), half(2)]
}

/// The registers that hold thresholds, of those at two addresses, and their words.
pub fn threshold_words(addresses: [u32; 2], thresholds: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    addresses.into_iter().zip(halves(thresholds)).take(thresholds.len().div_ceil(2))
}

/// From a frame's last beat to its trailer on the port without a pause: lines, and cycles besides.
pub fn latency(design: &DesignPoint) -> (u64, u64) {
    let longest = u64::from(design.look_ahead.iter().copied().max().unwrap_or_default());
    let steps = pipeline::ring_at(longest) + pipeline::TRAILER_STEPS;
    (pipeline::lines(longest) + pipeline::RING_LINES, pipeline::SEQUENCER_CLOCKS + steps + pipeline::FIFO_CLOCKS)
}

/// Runs a check on each shipped design but the default. Returns what it found, with the name of the design.
pub fn of_other_designs(check: impl Fn(&Simulator) -> Vec<String>) -> Vec<String> {
    let of = |name: &str| {
        let design = DesignPoint::shipped(name).unwrap();
        let begin = Instant::now();
        let found = check(&Simulator::of_design(&design, None, Trace::None).unwrap());
        eprintln!("{name}: {:.1} s", begin.elapsed().as_secs_f64());
        found.into_iter().map(|failure| format!("{name}: {failure}")).collect::<Vec<_>>()
    };
    SHIPPED[1..].iter().flat_map(|(name, _)| of(name)).collect()
}

/// What the `emission` register reads, as the C header of the design says.
pub fn emission(design: &DesignPoint) -> u32 {
    let files = files_of(design).unwrap();
    let header = &files.iter().find(|file| file.path.ends_with(".h")).unwrap().text;
    let digits = &header.split_once("HOVERLOCK_EMISSION_VALUE 0x").unwrap().1[..8];
    u32::from_str_radix(digits, 16).unwrap()
}

/// The largest sample of the camera.
pub fn white(design: &DesignPoint) -> u16 {
    design.pixel.max_raw() as u16
}

/// The largest coefficient.
pub fn most(design: &DesignPoint) -> u32 {
    design.coefficient.max_raw() as u32
}

/// The largest response, which is also the largest threshold.
pub fn strongest(design: &DesignPoint) -> u32 {
    (1 << design.dog_bits) - 1
}

/// Returns [`noise`] as the camera of `design` samples it, in steps of the camera.
pub fn ground(design: &DesignPoint, width: usize, height: usize, seed: u64) -> Plane<u16> {
    camera_samples(design, &noise(width, height, seed))
}

/// Grey noise over a slope: many features, all bits in use.
pub fn noise(width: usize, height: usize, seed: u64) -> Plane<u16> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Plane::from_fn(width, height, |x, y| ((x * 311 + y * 173) % 30_000) as u16 + random.random_range(0..30_000u16))
}

/// Points four apart: as many maxima as there can be, more than wait for their rings.
pub fn lattice(width: usize, height: usize) -> Plane<u16> {
    Plane::from_fn(width, height, |x, y| if x % 4 == 0 && y % 4 == 0 { 0xffff } else { 0 })
}
