//! The component for Platform Designer from its ports, between models of Intel's DMA masters: bytes of frames in memory
//! go in, bytes of records in memory come out, as the header and the flight program have them.

use std::{fs, path::Path, path::PathBuf, process::Command};

use hoverlock_design::{DesignPoint, Format, KT27};
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_harness::build::{Build, Initial};
use hoverlock_harness::bus::avalon_mm::Master;
use hoverlock_harness::bus::stream::{Dialect, Frame as StreamFrame, Ports, Rules, Sink, Source};
use hoverlock_harness::bus::{Pause, Random, Reset, Switch};
use hoverlock_harness::model::{InstanceOptions, Library};
use hoverlock_harness::sim::{Dut, Edge, Signal, Sim};
use hoverlock_harness::{Error, Time};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::kt27 as map;
use hoverlock_registers::record::{FLAG_TEN_WORDS, FLAG_TRAILER};
use hoverlock_rtl::emission::{component, verilog::verilog};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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

fn options(seed: u64) -> InstanceOptions {
    InstanceOptions { seed, plusargs: Vec::new() }
}

/// The component between DMA masters: they read bytes of frames and write bytes of records.
struct Bench {
    dut: Dut,
    clock: Signal,
    reset: Signal,
    video: Source,
    features: Sink,
    feature_reset: Switch,
    registers: Master,
    pairs: usize,
}

impl Bench {
    fn new(dut: &Dut, design: &DesignPoint, seed: u64, [source_pause, sink_pause]: [f64; 2]) -> Result<Self, Error> {
        const AVALON: Dialect = Dialect::Avalon { ready_latency: 0 };
        let clock = dut.clock("clock", Time::ns(10))?.signal().clone();
        let feature_reset = Switch::default();
        let video = Source::new(dut, &clock, Ports::find(dut, "video_", AVALON)?, None)?;
        let reset = Some(Reset::while_on(&feature_reset));
        let features = Sink::new(dut, &clock, Ports::find(dut, "feature_", AVALON)?, reset, Rules::Strict)?;
        video.set_pause(Pause::random(source_pause, seed));
        video.randomize_idle(seed);
        features.set_pause(Pause::random(sink_pause, seed + 1));
        let empty = dut.signal("video_empty").ok();
        assert_eq!(empty.is_some(), pixel_bytes(design) > 1, "empty of the video");
        if let Some(empty) = empty {
            fill_lanes(dut, &clock, empty, seed)?;
        }
        let registers = Master::new(dut, &clock, "csr_", 1)?;
        let reset = dut.signal("reset")?;
        Ok(Self { dut: dut.clone(), clock, reset, video, features, feature_reset, registers, pairs: design.pairs() })
    }

    async fn start(&self) -> Result<(), Error> {
        self.feature_reset.set(true);
        self.reset.set(1)?;
        self.clock.cycles(4).await;
        self.reset.set(0)?;
        self.clock.cycles(2).await;
        self.feature_reset.set(false);
        Ok(())
    }

    async fn write(&self, address: u32, value: u32) -> Result<(), Error> {
        self.registers.write(u64::from(address / 4), value.into()).await
    }

    /// Sets size and thresholds for the frames from now on.
    async fn configure(&self, width: usize, height: usize, thresholds: [u32; 3]) -> Result<(), Error> {
        self.write(map::SIZE, (height << 16 | width) as u32).await?;
        let pair = |k: usize| if k < self.pairs { thresholds[k] } else { 0 };
        let (low, third) = (pair(1) << 16 | pair(0), pair(2));
        self.write(map::THRESHOLD, low).await?;
        if third > 0 {
            self.write(THRESHOLD_2, third).await?;
        }
        self.write(map::COMMIT, 1).await?;
        self.write(map::CONTROL, map::CONTROL_ENABLE).await
    }

    /// The next packet as the write master leaves it in memory.
    async fn packet(&self) -> Result<Vec<u8>, Error> {
        let packet = self.dut.with_timeout(Time::ms(10), self.features.recv()).await?;
        Ok(packet.symbols.iter().map(|symbol| *symbol as u8).collect())
    }
}

/// Drives what a design must not look at, after the source: the lanes of the last beat that hold no symbol, and `empty`
/// before the last beat.
fn fill_lanes(dut: &Dut, clock: &Signal, empty: Signal, seed: u64) -> Result<(), Error> {
    let (data, last) = (dut.signal("video_data")?, dut.signal("video_endofpacket")?);
    let valid = dut.signal("video_valid")?;
    let mut random = Random::new(seed);
    dut.on_edge(clock, Edge::Rising, move || {
        let is_partial = empty.get_pending() > 0;
        match (valid.get_pending() > 0, last.get_pending() > 0) {
            (true, true) if is_partial => data.set(data.get_pending() & 0xff00 | u64::from(NOTHING)),
            (true, false) => empty.set(random.below(2)),
            _ => Ok(()),
        }
    });
    Ok(())
}

/// A frame in memory: its bytes, the pixels that the hardware makes of them, the errors of its trailer.
struct Frame {
    sent: StreamFrame,
    pixels: Plane<u16>,
    errors: u32,
}

/// A frame with `more` bytes too many, or too few if it is negative. The bits above the pixel are random: they are not
/// looked at.
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
    let sent = StreamFrame::new(&memory);
    Frame { sent: if ends { sent } else { sent.without_end() }, pixels, errors }
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
        let mut frames = vec![(0, true), (0, true), (-5 * bytes, true), (7 * bytes, true), (-100, false), (0, true)];
        if bytes > 1 {
            // Half a pixel at the end: of the last pixel, earlier, after the last.
            frames.extend([(-1, true), (0, true), (-1001, true), (0, true), (1, true), (0, true)]);
        }
        let frames: Vec<Frame> = (0..)
            .zip(frames)
            .map(|(i, (more, ends))| frame(&design, width, height, 100 * seed + i, more, ends))
            .collect();
        let mut sim = Sim::new(library.instance_with(&options(seed)).unwrap()).unwrap();
        let bench = Bench::new(&sim.dut(), &design, seed, pauses).unwrap();
        let played = sim.run(async {
            bench.start().await?;
            bench.configure(width, height, thresholds).await?;
            for (number, frame) in (0..).zip(&frames) {
                bench.video.send(&frame.sent)?;
                // The next frame ends one that has no end.
                if frame.errors == INTERRUPTED {
                    continue;
                }
                let first = number - u32::from(number > 0 && frames[number as usize - 1].errors == INTERRUPTED);
                for number in first..=number {
                    let expected = expected(&design, &frames[number as usize], number, thresholds);
                    assert!(expected.len() > 20 * record_bytes(&design), "{name}: too few features to mean something");
                    same(&format!("{name}, seed {seed}, frame {number}"), &expected, &bench.packet().await?);
                }
            }
            Ok::<_, Error>(())
        });
        played.unwrap();
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
        let mut sim = Sim::new(library.instance_with(&options(beats)).unwrap()).unwrap();
        let bench = Bench::new(&sim.dut(), &KT27, beats, [0.0, 0.0]).unwrap();
        let played = sim.run(async {
            bench.start().await?;
            bench.configure(64, 64, thresholds).await?;
            bench.video.send(&frame(&KT27, 64, 64, 5, 0, true).sent)?;
            bench.clock.cycles_until(1_000_000, || bench.features.beats() >= beats).await?;
            assert!(bench.features.is_empty());
            // No beat more is taken, and the DMAs are reset with the pipeline.
            bench.dut.signal("feature_ready")?.set(0)?;
            bench.feature_reset.set(true);
            bench.write(map::CONTROL, map::CONTROL_ENABLE | map::CONTROL_RESET).await?;
            bench.video.clear();
            bench.features.clear();
            let valid = bench.dut.signal("feature_valid")?;
            bench.clock.cycles_until(1_000, || !valid.is_high()).await?;
            bench.clock.cycles(8).await;
            bench.feature_reset.set(false);
            let second = frame(&KT27, 64, 64, 6, 0, true);
            let expected = expected(&KT27, &second, 0, thresholds);
            bench.video.send(&second.sent)?;
            let packet = bench.packet().await?;
            same(&format!("reset after {beats} beats"), &expected[4..], &packet[4..]);
            assert_eq!(bench.registers.read(0).await?, u64::from(map::IDENTIFICATION_VALUE));
            Ok::<_, Error>(())
        });
        played.unwrap();
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
