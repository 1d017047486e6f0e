//! The component for Platform Designer from its ports, between models of Intel's DMA masters: bytes of frames in memory
//! go in, bytes of records in memory come out, as the header and the flight program have them.

use std::{collections::VecDeque, fs, path::Path, path::PathBuf, process::Command};

use hoverlock_design::{DesignPoint, Format, KT27};
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::record::{FLAG_TEN_WORDS, FLAG_TRAILER};
use hoverlock_harness::build::{Build, Initial};
use hoverlock_harness::model::{InstanceOptions, Library, Model, RawSignal};
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::emission::{component, verilog::verilog};
use hoverlock_simulation::Narrow;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[allow(dead_code, reason = "the constants of all registers")]
#[path = "../../rtl/registers/hoverlock_registers.rs"]
mod map;

/// The register of the third threshold, which the default design lacks.
const THRESHOLD_2: u32 = 0x34;

/// Error bits of a trailer.
const SHORT: u32 = 1;
const LONG: u32 = 2;
const INTERRUPTED: u32 = 4;

/// What lies in the lanes of a beat that hold no symbol.
const NOTHING: u8 = 0xa5;

fn shipped(name: &str) -> DesignPoint {
    DesignPoint::shipped(name).unwrap()
}

/// Bytes of a pixel in memory.
fn pixel_bytes(design: &DesignPoint) -> usize {
    design.pixel.bits().div_ceil(8) as usize
}

/// Bytes of a record in memory.
fn record_bytes(design: &DesignPoint) -> usize {
    if design.pairs() > 2 { 40 } else { 32 }
}

/// The top of the component: the committed file of the default design, which is also what is synthesised.
fn top(design: &DesignPoint, name: &str) -> PathBuf {
    if *design == *KT27 {
        return Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/quartus/hoverlock_component.v");
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("component").join(name);
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("hoverlock_component.v");
    let file = component::files(design).into_iter().find(|file| file.path.ends_with("hoverlock_component.v"));
    fs::write(&path, file.unwrap().text).unwrap();
    path
}

fn library(design: &DesignPoint, name: &str) -> Library {
    let mut sources = verilog(design, None).unwrap();
    sources.push(top(design, name));
    Build::new("hoverlock_component").sources(sources).initial(Initial::Random).compile().unwrap()
}

/// The handles of the ports.
struct Ports {
    clock: RawSignal<u8>,
    reset: RawSignal<u8>,
    video_ready: RawSignal<u8>,
    video_valid: RawSignal<u8>,
    video_data: Narrow,
    /// Absent where a beat is one byte.
    video_empty: Option<RawSignal<u8>>,
    video_first: RawSignal<u8>,
    video_last: RawSignal<u8>,
    feature_ready: RawSignal<u8>,
    feature_valid: RawSignal<u8>,
    feature_data: RawSignal<u64>,
    feature_empty: RawSignal<u8>,
    feature_first: RawSignal<u8>,
    feature_last: RawSignal<u8>,
    csr_address: RawSignal<u8>,
    csr_read: RawSignal<u8>,
    csr_readdata: RawSignal<u32>,
    csr_write: RawSignal<u8>,
    csr_writedata: RawSignal<u32>,
}

/// A packet in memory, as a descriptor of the read master names it; without an end where the descriptor generates none.
struct Descriptor {
    bytes: Vec<u8>,
    ends: bool,
}

struct Bench {
    design: DesignPoint,
    model: Model,
    ports: Ports,
    random: ChaCha8Rng,
    source_pause: f64,
    sink_pause: f64,
    /// What the read master still sends; the first packet from `at` on.
    descriptors: VecDeque<Descriptor>,
    at: usize,
    offered: bool,
    /// The memory that the write master fills, packet by packet.
    packets: VecDeque<Vec<u8>>,
    memory: Vec<u8>,
    /// A beat that the write master has not taken: it must stay.
    standing: Option<(u64, u8, u8, u8)>,
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
    fn new(design: &DesignPoint, library: &Library, seed: u64, pauses: [f64; 2]) -> Self {
        let model = library.instance_with(&InstanceOptions { seed, plusargs: Vec::new() }).unwrap();
        let ports = Ports {
            clock: model.raw("clock").unwrap(),
            reset: model.raw("reset").unwrap(),
            video_ready: model.raw("video_ready").unwrap(),
            video_valid: model.raw("video_valid").unwrap(),
            video_data: Narrow::find(&model, "video_data").unwrap(),
            video_empty: model.raw("video_empty").ok(),
            video_first: model.raw("video_startofpacket").unwrap(),
            video_last: model.raw("video_endofpacket").unwrap(),
            feature_ready: model.raw("feature_ready").unwrap(),
            feature_valid: model.raw("feature_valid").unwrap(),
            feature_data: model.raw("feature_data").unwrap(),
            feature_empty: model.raw("feature_empty").unwrap(),
            feature_first: model.raw("feature_startofpacket").unwrap(),
            feature_last: model.raw("feature_endofpacket").unwrap(),
            csr_address: model.raw("csr_address").unwrap(),
            csr_read: model.raw("csr_read").unwrap(),
            csr_readdata: model.raw("csr_readdata").unwrap(),
            csr_write: model.raw("csr_write").unwrap(),
            csr_writedata: model.raw("csr_writedata").unwrap(),
        };
        assert_eq!(ports.video_empty.is_some(), pixel_bytes(design) > 1, "empty of the video");
        let mut bench = Self {
            design: design.clone(),
            model,
            ports,
            random: ChaCha8Rng::seed_from_u64(seed),
            source_pause: pauses[0],
            sink_pause: pauses[1],
            descriptors: VecDeque::new(),
            at: 0,
            offered: false,
            packets: VecDeque::new(),
            memory: Vec::new(),
            standing: None,
        };
        set!(bench.ports.reset, 1);
        (0..4).for_each(|_| bench.cycle(None));
        set!(bench.ports.reset, 0);
        (0..2).for_each(|_| bench.cycle(None));
        bench
    }

    fn pauses(&mut self, probability: f64) -> bool {
        probability > 0.0 && self.random.random_bool(probability)
    }

    /// One clock, with a write to a register or without.
    fn cycle(&mut self, write: Option<(u32, u32)>) {
        set!(self.ports.clock, 0);
        let (address, word) = write.unwrap_or((0, 0));
        set!(self.ports.csr_address, (address >> 2) as u8);
        set!(self.ports.csr_writedata, word);
        set!(self.ports.csr_write, u8::from(write.is_some()));
        self.offered = !self.descriptors.is_empty() && (self.offered || !self.pauses(self.source_pause));
        let taken = self.read_master();
        let ready = !self.pauses(self.sink_pause);
        set!(self.ports.feature_ready, u8::from(ready));
        self.model.eval().unwrap();
        if self.offered && get!(self.ports.video_ready) == 1 {
            self.offered = false;
            self.at += taken;
            if self.at >= self.descriptors[0].bytes.len() {
                self.descriptors.pop_front();
                self.at = 0;
            }
        }
        self.write_master(ready);
        set!(self.ports.clock, 1);
        self.model.eval().unwrap();
    }

    /// Offers a beat: the byte of the lowest address is the first symbol, in the highest bits. Returns its bytes.
    fn read_master(&mut self) -> usize {
        let lanes = pixel_bytes(&self.design);
        set!(self.ports.video_valid, u8::from(self.offered));
        let Some(descriptor) = self.descriptors.front().filter(|_| self.offered) else {
            // Without `valid` the other signals say nothing.
            set!(self.ports.video_data, self.random.random_range(0..1 << (8 * lanes)));
            set!(self.ports.video_first, self.random.random_range(0..2));
            set!(self.ports.video_last, self.random.random_range(0..2));
            if let Some(empty) = self.ports.video_empty {
                set!(empty, self.random.random_range(0..2));
            }
            return 0;
        };
        let rest = &descriptor.bytes[self.at..];
        let symbols = rest.iter().copied().chain(std::iter::repeat(NOTHING)).take(lanes);
        let ends = rest.len() <= lanes;
        set!(self.ports.video_data, symbols.fold(0, |beat, symbol| beat << 8 | u32::from(symbol)));
        set!(self.ports.video_first, u8::from(self.at == 0));
        set!(self.ports.video_last, u8::from(ends && descriptor.ends));
        if let Some(empty) = self.ports.video_empty {
            // It counts only at the end of a packet.
            let free = if ends { lanes.saturating_sub(rest.len()) as u8 } else { self.random.random_range(0..2) };
            set!(empty, free);
        }
        lanes
    }

    /// Takes a beat: the symbol in the highest bits goes to the lowest address.
    fn write_master(&mut self, ready: bool) {
        if get!(self.ports.reset) == 1 {
            return;
        }
        if get!(self.ports.feature_valid) == 0 {
            assert!(self.standing.is_none(), "a beat that was offered has gone");
            return;
        }
        let data = get!(self.ports.feature_data);
        let (first, last) = (get!(self.ports.feature_first), get!(self.ports.feature_last));
        let empty = get!(self.ports.feature_empty);
        let beat = (data, empty, first, last);
        assert!(self.standing.is_none_or(|standing| standing == beat), "a beat changed while it was offered");
        self.standing = (!ready).then_some(beat);
        if !ready {
            return;
        }
        assert_eq!(first == 1, self.memory.is_empty(), "start of packet at byte {}", self.memory.len());
        assert_eq!(empty, 0, "a record fills its beats");
        self.memory.extend(data.to_be_bytes());
        if last == 1 {
            self.packets.push_back(std::mem::take(&mut self.memory));
        }
    }

    /// Reads the register at address 0.
    fn identification(&mut self) -> u32 {
        set!(self.ports.csr_read, 1);
        self.cycle(None);
        set!(self.ports.csr_read, 0);
        get!(self.ports.csr_readdata)
    }

    fn write(&mut self, address: u32, word: u32) {
        self.cycle(Some((address, word)));
    }

    /// Sets size and thresholds for the frames from now on.
    fn configure(&mut self, width: usize, height: usize, thresholds: [u32; 3]) {
        self.write(map::SIZE, (height << 16 | width) as u32);
        let pair = |k: usize| if k < self.design.pairs() { thresholds[k] } else { 0 };
        let (low, third) = (pair(1) << 16 | pair(0), pair(2));
        self.write(map::THRESHOLD, low);
        if third > 0 {
            self.write(THRESHOLD_2, third);
        }
        self.write(map::COMMIT, 1);
        self.write(map::CONTROL, map::CONTROL_ENABLE);
    }

    fn packet(&mut self) -> Vec<u8> {
        for _ in 0..1_000_000 {
            if let Some(packet) = self.packets.pop_front() {
                return packet;
            }
            self.cycle(None);
        }
        panic!("no packet");
    }
}

/// A frame in memory: its bytes, the pixels that the hardware makes of them, the errors of its trailer.
struct Frame {
    descriptor: Descriptor,
    pixels: Plane<u16>,
    errors: u32,
}

/// A frame of so many bytes too few or too many. The bits above the pixel are random: they are not looked at.
fn frame(design: &DesignPoint, width: usize, height: usize, seed: u64, more: isize, ends: bool) -> Frame {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (bytes, bits) = (pixel_bytes(design), design.pixel.bits());
    let mask = ((1u32 << bits) - 1) as u16;
    let mut memory = Vec::new();
    for _ in 0..width * height {
        let pixel = random.random::<u16>() & mask;
        let above = if bytes > 1 { random.random::<u16>() & !mask } else { 0 };
        memory.extend(&(pixel | above).to_le_bytes()[..bytes]);
    }
    let whole = memory.len();
    memory.extend((0..more).map(|_| random.random::<u8>()));
    memory.truncate(whole.saturating_add_signed(more));
    let half = !memory.len().is_multiple_of(bytes);
    let mut samples = memory.clone();
    samples.resize(memory.len().next_multiple_of(bytes), NOTHING);
    let sample = |at: usize| {
        let at = bytes * at.min(samples.len() / bytes - 1);
        let high = if bytes > 1 { samples[at + 1] } else { 0 };
        u16::from_le_bytes([samples[at], high]) & mask
    };
    let pixels = Plane::from_fn(width, height, |x, y| sample(y * width + x));
    let errors = match (samples.len() < whole, ends && !half) {
        (true, true) => SHORT,
        (true, false) => INTERRUPTED,
        (false, true) if samples.len() == whole => 0,
        (false, _) => LONG,
    };
    Frame { descriptor: Descriptor { bytes: memory, ends }, pixels, errors }
}

/// What the write master leaves in memory: the records of the model and the trailer, little endian.
fn expected(design: &DesignPoint, frame: &Frame, number: u32, thresholds: [u32; 3]) -> Vec<u8> {
    let words = record_bytes(design) / 4;
    let thresholds = &thresholds[..design.pairs()];
    let records = BitTrue::new(design).unwrap().planes(&frame.pixels).features(thresholds);
    let flags = FLAG_TRAILER | if words > 8 { FLAG_TEN_WORDS } else { 0 };
    let threshold = |k: usize| thresholds.get(k).copied().unwrap_or_default();
    let mut trailer = vec![0; words];
    trailer[..6].copy_from_slice(&[
        number,
        u32::from(flags) << 16 | frame.errors,
        records.len() as u32,
        0,
        threshold(1) << 16 | threshold(0),
        threshold(2),
    ]);
    let packed = records.iter().flat_map(|record| record.pack()[..words].to_vec());
    packed.chain(trailer).flat_map(u32::to_le_bytes).collect()
}

/// The position of the first byte that differs says more than two lists of bytes.
#[track_caller]
fn same(what: &str, expected: &[u8], actual: &[u8]) {
    let differs = expected.iter().zip(actual).position(|(expected, actual)| expected != actual);
    let at = differs.unwrap_or(expected.len().min(actual.len()));
    let few = |bytes: &[u8]| bytes.get(at..).map(|rest| rest[..rest.len().min(8)].to_vec());
    assert!(
        expected == actual,
        "{what}: {} bytes in place of {}, byte {at}: {:02x?} in place of {:02x?}",
        actual.len(),
        expected.len(),
        few(actual),
        few(expected)
    );
}

fn bytes_are_exact(name: &str) {
    let design = shipped(name);
    let library = library(&design, name);
    let bytes = pixel_bytes(&design) as isize;
    // White noise has features everywhere; these thresholds leave some hundred a frame.
    let strongest = (1u32 << design.dog_bits) - 1;
    let thresholds = [strongest / 16, strongest / 32, strongest / 64];
    let (width, height) = (96, 80);
    for (seed, pauses) in [(1, [0.0, 0.0]), (2, [0.3, 0.3]), (3, [0.1, 0.8])] {
        let mut bench = Bench::new(&design, &library, seed, pauses);
        bench.configure(width, height, thresholds);
        let mut frames = vec![(0, true), (0, true), (-5 * bytes, true), (7 * bytes, true), (-100, false), (0, true)];
        if bytes > 1 {
            // Half a pixel at the end: of the last pixel, earlier, after the last.
            frames.extend([(-1, true), (0, true), (-1001, true), (0, true), (1, true), (0, true)]);
        }
        let frames: Vec<Frame> = (0..)
            .zip(frames)
            .map(|(i, (more, ends))| frame(&design, width, height, 100 * seed + i, more, ends))
            .collect();
        for (number, frame) in (0..).zip(&frames) {
            let Descriptor { bytes, ends } = &frame.descriptor;
            bench.descriptors.push_back(Descriptor { bytes: bytes.clone(), ends: *ends });
            // The next frame ends one that has no end.
            if frame.errors == INTERRUPTED {
                continue;
            }
            let first = number - u32::from(number > 0 && frames[number as usize - 1].errors == INTERRUPTED);
            for number in first..=number {
                let expected = expected(&design, &frames[number as usize], number, thresholds);
                assert!(expected.len() > 20 * record_bytes(&design), "{name}: too few features to mean something");
                same(&format!("{name}, seed {seed}, frame {number}"), &expected, &bench.packet());
            }
        }
        let errors = frames.iter().fold(0, |all, frame| all | frame.errors);
        assert_eq!(errors, SHORT | LONG | INTERRUPTED);
    }
}

#[test]
fn bytes_of_frames_become_bytes_of_records() {
    bytes_are_exact("kt27");
}

/// Pixels of one byte, which have no `empty`.
#[test]
fn bytes_become_records_where_a_pixel_is_a_byte() {
    bytes_are_exact("small");
}

/// Pixels of 12 bits in two bytes, records of 40 bytes in five beats.
#[test]
fn bytes_become_records_of_three_scale_pairs() {
    bytes_are_exact("three_scales");
}

/// `control.reset` withdraws a record at each of its beats; the next packet begins with beat 0 all the same.
#[test]
fn a_reset_in_the_middle_of_a_record_leaves_nothing_behind() {
    let library = library(&KT27, "kt27");
    let thresholds = [500, 500, 0];
    for beats in 1..=8 {
        let mut bench = Bench::new(&KT27, &library, beats as u64, [0.0, 0.0]);
        bench.configure(64, 64, thresholds);
        let first = frame(&KT27, 64, 64, 5, 0, true);
        bench.descriptors.push_back(first.descriptor);
        while bench.memory.len() < 8 * beats {
            bench.cycle(None);
            assert!(bench.packets.is_empty());
        }
        bench.sink_pause = 1.0;
        bench.write(map::CONTROL, map::CONTROL_ENABLE | map::CONTROL_RESET);
        // The DMAs are reset with it.
        bench.descriptors.clear();
        (bench.at, bench.offered) = (0, false);
        bench.standing = None;
        bench.memory.clear();
        while get!(bench.ports.feature_valid) == 1 {
            bench.cycle(None);
            bench.standing = None;
        }
        (0..8).for_each(|_| bench.cycle(None));
        bench.sink_pause = 0.0;
        let second = frame(&KT27, 64, 64, 6, 0, true);
        let expected = expected(&KT27, &second, 0, thresholds);
        bench.descriptors.push_back(second.descriptor);
        let packet = bench.packet();
        same(&format!("reset after {beats} beats"), &expected[4..], &packet[4..]);
        assert_eq!(bench.identification(), map::IDENTIFICATION_VALUE);
    }
}

/// Verilator's lint for every width of a pixel and both records, with a top of the design's ports and nothing in it.
#[test]
fn lint_is_clean_for_every_pixel_and_record() {
    for bits in 8..=16 {
        for pairs in [2, 3] {
            let design = DesignPoint { pixel: Format::unsigned(bits, 0), scale_pairs: pairs, ..KT27.clone() };
            let name = format!("lint_{bits}_{pairs}");
            let path = top(&DesignPoint { width: 1000, ..design.clone() }, &name);
            let stub = path.with_file_name("hoverlock_top.v");
            let (pixel, record) = (bits - 1, 8 * record_bytes(&design) - 1);
            let ports =
                fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog/hoverlock_top.v"))
                    .unwrap();
            let ports = ports[..ports.find(");").unwrap() + 2]
                .replace("[15:0] video_data", &format!("[{pixel}:0] video_data"))
                .replace("[255:0] feature_data", &format!("[{record}:0] feature_data"));
            fs::write(
                &stub,
                format!("// verilator lint_off UNUSED\n// verilator lint_off UNDRIVEN\n{ports}\nendmodule\n"),
            )
            .unwrap();
            let output = Command::new("verilator")
                .args(["--lint-only", "-Wall", "--top-module", "hoverlock_component"])
                .args([&path, &stub])
                .output()
                .expect("verilator is installed: `hoverlock doctor` says how");
            assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        }
    }
}
