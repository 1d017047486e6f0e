//! A bench that uses only the ports of the top: two streams, registers, interrupt, reset.
//!
//! The comparison in `simulation` reads internal signals. This bench checks the behaviour at the interfaces: packets,
//! trailers, status bits, the interrupt, the state after a reset. Each scenario ends with the first difference it
//! finds.

#![allow(dead_code, reason = "each test binary uses its part")]

pub mod scenarios;

use std::{collections::VecDeque, fmt};

use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::model::bit_true::{BitTrue, Planes};
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::record::{FLAG_TRAILER, FeatureRecord};
use hoverlock_harness::model::{InstanceOptions, Model};
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::emission::files_of;
use hoverlock_rtl::registers::{COEFFICIENTS_AT, default_coefficients};
use hoverlock_simulation::{Ports, Simulator};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The constants as the program on the ARM gets them.
#[path = "../../../rtl/registers/hoverlock_registers.rs"]
mod map;

pub use map::{
    COMMIT, CONTROL, CONTROL_AUTOMATIC as AUTOMATIC, CONTROL_ENABLE as ENABLE,
    CONTROL_INTERRUPT_ERROR as INTERRUPT_ERROR, CONTROL_INTERRUPT_FRAME as INTERRUPT_FRAME, CONTROL_RESET as RESET,
    DROPPED, FEATURES, FRAMES, SIZE, STATUS, STATUS_BEGUN as BEGUN, STATUS_BUSY as BUSY, STATUS_DROPPED as DROPS,
    STATUS_FRAME as FRAME, STATUS_INTERRUPTED as INTERRUPTED, STATUS_LONG_FRAME as LONG, STATUS_REFUSED as REFUSED,
    STATUS_SATURATED as SATURATED, STATUS_SHORT_FRAME as SHORT, TARGET, THRESHOLD, THRESHOLD_NOW,
};

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
    pub thresholds: [u32; 2],
    pub planes: Planes,
}

impl Frame {
    /// With the coefficients of the design. Samples are those of its camera.
    pub fn new(design: &DesignPoint, pixels: Plane<u16>, thresholds: [u32; 2]) -> Self {
        Self::with(design, pixels, thresholds, default_coefficients(design).unwrap())
    }

    pub fn with(design: &DesignPoint, pixels: Plane<u16>, thresholds: [u32; 2], coefficients: Vec<u32>) -> Self {
        let planes = BitTrue::new(design).unwrap().with_coefficients(&coefficients).planes(&pixels);
        Self { pixels, coefficients, thresholds, planes }
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

    /// The records of its features, packed: the eight words of two scale pairs.
    pub fn records(&self, thresholds: [u32; 2]) -> Vec<[u32; 8]> {
        let pack = |feature: &FeatureRecord| std::array::from_fn(|i| feature.pack()[i]);
        self.planes.features(&thresholds).iter().map(pack).collect()
    }

    /// Its beats, all of them: pixel, start, end.
    pub fn beats(&self) -> Vec<Beat> {
        let last = self.pixels.as_slice().len() - 1;
        self.pixels.as_slice().iter().enumerate().map(|(i, pixel)| (*pixel, i == 0, i == last)).collect()
    }
}

/// One beat of the video stream: pixel, start of packet, end of packet.
pub type Beat = (u16, bool, bool);

/// A packet of features with its trailer.
#[derive(Debug, Clone)]
pub struct Packet {
    pub records: Vec<[u32; 8]>,
    pub trailer: [u32; 8],
}

/// A register access of one cycle.
#[derive(Clone, Copy)]
pub enum Access {
    Read(u32),
    Write(u32, u32),
}

pub struct Bench {
    /// The design of two scale pairs that is simulated.
    pub design: DesignPoint,
    model: Model,
    ports: Ports,
    random: ChaCha8Rng,
    /// Chance that no beat is offered in a cycle.
    pub source_pause: f64,
    /// Chance that no record is taken in a cycle; 1 closes the sink.
    pub sink_pause: f64,
    /// What the source still sends.
    pub beats: VecDeque<Beat>,
    /// Cycles in which no beat is offered, once the queue has shrunk to this length: a gap between frames.
    pub gap: Option<(usize, u64)>,
    /// Complete packets that were not checked yet.
    pub packets: VecDeque<Packet>,
    /// Records of the packet in progress.
    partial: Vec<[u32; 8]>,
    offered: bool,
    /// A record that the sink has not accepted: it must stay unchanged.
    standing: Option<([u32; 8], u8, u8)>,
    /// The sink is being reset.
    deaf: bool,
    /// Cycles since the first reset.
    pub cycle: u64,
    /// A broken rule of the feature stream.
    broken: Option<String>,
}

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
    /// Out of reset, with a first content of registers and memories that the seed decides.
    pub fn new(simulator: &Simulator, seed: u64) -> Self {
        let options = InstanceOptions { seed, plusargs: simulator.plusargs().to_vec() };
        let model = simulator.library().instance_with(&options).unwrap();
        let mut bench = Self {
            design: simulator.design().clone(),
            ports: Ports::find(&model).unwrap(),
            model,
            random: ChaCha8Rng::seed_from_u64(seed),
            source_pause: 0.0,
            sink_pause: 0.0,
            beats: VecDeque::new(),
            gap: None,
            packets: VecDeque::new(),
            partial: Vec::new(),
            offered: false,
            standing: None,
            deaf: false,
            cycle: 0,
            broken: None,
        };
        bench.reset(4);
        bench
    }

    /// Asserts reset for some cycles. Transfers in progress on the streams are lost.
    pub fn reset(&mut self, cycles: u32) {
        set!(self.ports.reset, 1);
        self.forget();
        for _ in 0..cycles {
            self.cycle(None);
        }
        set!(self.ports.reset, 0);
        self.forget();
        // The reset of the pipeline is registered: one cycle later.
        self.cycle(None);
        self.forget();
    }

    /// Discards transfers in progress on both streams, as at a reset.
    pub fn forget(&mut self) {
        self.beats.clear();
        self.forget_records();
        self.offered = false;
    }

    /// Discards the records of the packet in progress.
    pub fn forget_records(&mut self) {
        self.packets.clear();
        self.partial.clear();
        self.standing = None;
    }

    fn chance(&mut self, p: f64) -> bool {
        p > 0.0 && self.random.random_bool(p.min(1.0))
    }

    /// One clock cycle.
    pub fn cycle(&mut self, access: Option<Access>) -> u32 {
        set!(self.ports.clock, 0);
        // Address and data are random while neither `read` nor `write` is set.
        let (address, word, read, write) = match access {
            Some(Access::Read(address)) => (address, self.random.random(), 1, 0),
            Some(Access::Write(address, word)) => (address, word, 0, 1),
            None => (self.random.random(), self.random.random(), 0, 0),
        };
        set!(self.ports.csr_address, (address >> 2) as u8 & 63);
        set!(self.ports.csr_writedata, word);
        set!(self.ports.csr_read, read);
        set!(self.ports.csr_write, write);
        let pause = match &mut self.gap {
            Some((left, cycles)) if *left == self.beats.len() && *cycles > 0 => {
                *cycles -= 1;
                true
            }
            _ => false,
        };
        self.offered = !self.beats.is_empty() && (self.offered || (!pause && !self.chance(self.source_pause)));
        let (data, first, last) = match self.beats.front() {
            Some(beat) if self.offered => *beat,
            // The video signals are random while `valid` is low.
            _ => (self.random.random_range(0..=white(&self.design)), self.random.random(), self.random.random()),
        };
        set!(self.ports.valid, u8::from(self.offered));
        set!(self.ports.data, data.into());
        set!(self.ports.first, u8::from(first));
        set!(self.ports.last, u8::from(last));
        let sink = !self.chance(self.sink_pause);
        set!(self.ports.feature_ready, u8::from(sink));
        self.model.eval().unwrap();
        if self.offered && get!(self.ports.ready) == 1 {
            self.beats.pop_front();
            self.offered = false;
        }
        self.watch(sink);
        set!(self.ports.clock, 1);
        self.model.eval().unwrap();
        self.cycle += 1;
        get!(self.ports.csr_readdata)
    }

    /// The protocol of the feature stream: an offered record is stable, packets begin and end correctly.
    fn watch(&mut self, sink: bool) {
        if self.deaf || get!(self.ports.reset) == 1 {
            return;
        }
        if get!(self.ports.feature_valid) == 0 {
            if self.standing.is_some() {
                self.broken.get_or_insert_with(|| "a record that was offered has gone".into());
            }
            return;
        }
        let words = self.model.get_words(self.ports.feature_data);
        let words: [u32; 8] = std::array::from_fn(|i| words[i]);
        let (first, last) = (get!(self.ports.feature_first), get!(self.ports.feature_last));
        if self.standing.is_some_and(|standing| standing != (words, first, last)) {
            self.broken.get_or_insert_with(|| "a record changed while it was offered".into());
        }
        self.standing = (!sink).then_some((words, first, last));
        if !sink {
            return;
        }
        let trailer = words[1] >> 16 & u32::from(FLAG_TRAILER) != 0;
        if (first == 1) != self.partial.is_empty() || (last == 1) != trailer {
            self.broken.get_or_insert_with(|| format!("start {first}, end {last} at {words:08x?}"));
        }
        if trailer {
            self.packets.push_back(Packet { records: std::mem::take(&mut self.partial), trailer: words });
        } else {
            self.partial.push(words);
        }
    }

    pub fn run(&mut self, cycles: u64) {
        for _ in 0..cycles {
            self.cycle(None);
        }
    }

    pub fn write(&mut self, address: u32, word: u32) {
        self.cycle(Some(Access::Write(address, word)));
    }

    /// Reads a register. Other inputs are random; read data comes one cycle later and is stable.
    pub fn read(&mut self, address: u32) -> u32 {
        self.cycle(Some(Access::Read(address)))
    }

    pub fn interrupt(&mut self) -> bool {
        get!(self.ports.irq) == 1
    }

    /// No protocol error on the feature stream so far.
    pub fn obeyed(&self) -> Outcome {
        match &self.broken {
            None => Ok(()),
            Some(what) => fail("feature stream", what.clone()),
        }
    }

    /// Runs until a condition is true; a failure after `limit` cycles.
    pub fn until(&mut self, what: &str, limit: u64, mut condition: impl FnMut(&Self) -> bool) -> Outcome {
        for _ in 0..limit {
            if condition(self) {
                return self.obeyed();
            }
            self.cycle(None);
        }
        self.obeyed()?;
        fail("hang", format!("{what} not after {limit} cycles"))
    }

    /// Writes what a frame needs, and commits it.
    pub fn configure(&mut self, frame: &Frame) {
        self.write(SIZE, (frame.height() << 16 | frame.width()) as u32);
        self.write(THRESHOLD, frame.thresholds[1] << 16 | frame.thresholds[0]);
        for (i, raw) in frame.coefficients.iter().enumerate() {
            self.write(COEFFICIENTS_AT + 4 * i as u32, *raw);
        }
        self.write(COMMIT, 1);
    }

    /// Sends a frame as a driver does: configures, sends, waits until `begun` is set, and clears it.
    pub fn begin(&mut self, frame: &Frame, beats: impl IntoIterator<Item = Beat>) -> Outcome {
        self.configure(frame);
        self.beats.extend(beats);
        // The frame before may have to end first, and the pipeline to drain.
        for _ in 0..2_000_000 {
            if self.read(STATUS) & BEGUN != 0 {
                self.write(STATUS, BEGUN);
                return self.obeyed();
            }
        }
        fail("hang", "the frame does not begin")
    }

    /// The next packet.
    pub fn packet(&mut self) -> Outcome<Packet> {
        self.until("a packet", 400_000, |bench| !bench.packets.is_empty())?;
        Ok(self.packets.pop_front().unwrap())
    }

    /// The next packet is this frame's, whole.
    pub fn exactly(&mut self, frame: &Frame, number: u32, thresholds: [u32; 2], errors: u32) -> Outcome {
        let packet = self.packet()?;
        let dropped = packet.check(frame, number, thresholds, errors)?;
        equal("record", "dropped features", 0, dropped)
    }

    /// Resets by software and discards the records in progress, as their sink must do.
    pub fn clear(&mut self, control: u32) {
        self.write(CONTROL, control | RESET);
        self.deaf = true;
        self.run(2);
        self.deaf = false;
        self.forget_records();
    }

    /// All records are out and the pipeline is empty.
    pub fn idle(&mut self) -> Outcome {
        for _ in 0..2_000_000 {
            if self.read(STATUS) & BUSY == 0 && self.beats.is_empty() {
                // The last beats may still be in the skid buffer, and their errors on the way to the status.
                self.run(6);
                return self.obeyed();
            }
        }
        fail("hang", "the pipeline does not drain")
    }
}

impl Packet {
    /// Compares with `bit_true`: all records or an ordered part of them, and the whole trailer. Returns the number of
    /// dropped features.
    pub fn check(&self, frame: &Frame, number: u32, thresholds: [u32; 2], errors: u32) -> Outcome<u32> {
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
        let now = thresholds[1] << 16 | thresholds[0];
        let trailer = [number, 0x8000_0000 | errors, self.records.len() as u32, dropped, now, 0, 0, 0];
        if self.trailer != trailer {
            return fail("trailer", format!("frame {number}: expected {trailer:08x?}, actual {:08x?}", self.trailer));
        }
        Ok(dropped)
    }
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

/// [`noise`] as the design's camera takes it.
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
