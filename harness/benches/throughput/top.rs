//! The Hoverlock top: frames of pixels in, feature records of 256 bits out. Every way must give the records of the C++
//! loop, word for word, trailers included.

use std::path::{Path, PathBuf};

use hoverlock_harness::build::Build;
use hoverlock_harness::bus::Pause;
use hoverlock_harness::bus::bulk::{Bulk, Options};
use hoverlock_harness::bus::stream::{Dialect, Frame, Ports, Rules, Sink, Source};
use hoverlock_harness::model::{Library, Model};
use hoverlock_harness::sim::{Clock, Sim, expect_equal};
use hoverlock_harness::{Error, Time};

use crate::measure::{Way, build_limit, compare, cpu, words_of};

const WIDTH: usize = 512;
const HEIGHT: usize = 384;
const FRAMES: usize = 2;
const SIZE: u64 = (HEIGHT << 16 | WIDTH) as u64;
/// Addresses of the registers, in words.
const CONTROL: u64 = 0x0c >> 2;
const SIZE_AT: u64 = 0x14 >> 2;
const COMMIT: u64 = 0x30 >> 2;
/// 32-bit words of a record.
const RECORD: usize = 8;
const AVALON: Dialect = Dialect::Avalon { ready_latency: 0 };

/// Tiles of 8 x 8 pixels with random grey, as in `limit_top.cpp`.
fn frame() -> Vec<u16> {
    let pixel = |x: u32, y: u32| {
        let hash = (x / 8).wrapping_mul(374_761_393).wrapping_add((y / 8).wrapping_mul(668_265_263));
        let hash = (hash ^ hash >> 13).wrapping_mul(1_274_126_177);
        (hash ^ hash >> 16) as u16
    };
    (0..HEIGHT as u32).flat_map(|y| (0..WIDTH as u32).map(move |x| pixel(x, y))).collect()
}

/// The files that `hoverlock.f` lists, and the waivers.
fn sources() -> Result<Vec<PathBuf>, Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog");
    let list = folder.join("hoverlock.f");
    let text = std::fs::read_to_string(&list).map_err(|e| Error::bench(format!("{}: {e}", list.display())))?;
    let names = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
    let mut files = vec![folder.join("waivers.vlt")];
    files.extend(names.map(|name| folder.join(name)));
    Ok(files)
}

fn library() -> Result<Library, Error> {
    Ok(Build::new("hoverlock_top").sources(sources()?).compile()?)
}

/// The model out of reset, its registers written, the clock high.
fn ready(checked: &mut Model) -> Result<(), Error> {
    let clock = checked.find("clock")?;
    let cycle = |model: &mut Model, values: &[(&str, u64)]| -> Result<(), Error> {
        for (name, value) in values {
            let signal = model.find(name)?;
            model.set(signal, *value)?;
        }
        for level in [0, 1] {
            model.set(clock, level)?;
            model.eval()?;
        }
        Ok(())
    };
    for _ in 0..4 {
        cycle(checked, &[("reset", 1)])?;
    }
    cycle(checked, &[("reset", 0)])?;
    cycle(checked, &[("csr_write", 1), ("csr_address", SIZE_AT), ("csr_writedata", SIZE)])?;
    cycle(checked, &[("csr_address", COMMIT), ("csr_writedata", 1)])?;
    cycle(checked, &[("csr_address", CONTROL), ("csr_writedata", 1)])?;
    let last = [("csr_write", 0), ("feature_ready", 1)];
    for (name, value) in last {
        let signal = checked.find(name)?;
        checked.set(signal, value)?;
    }
    Ok(())
}

/// What a way gave, to be compared.
struct Outcome {
    seconds: f64,
    cycles: u64,
    records: Vec<u32>,
}

fn raw(library: &Library, frame: &[u16]) -> Result<Outcome, Error> {
    let mut model = library.instance()?;
    ready(&mut model)?;
    let bit = |name: &str| model.raw::<u8>(name);
    let (clock, valid, input_ready) = (bit("clock")?, bit("video_valid")?, bit("video_ready")?);
    let (first, last) = (bit("video_startofpacket")?, bit("video_endofpacket")?);
    let (given, end) = (bit("feature_valid")?, bit("feature_endofpacket")?);
    let (data, feature) = (model.raw::<u16>("video_data")?, model.raw::<[u32; RECORD]>("feature_data")?);
    let count = FRAMES * frame.len();
    let (mut sent, mut place, mut packets, mut cycles) = (0, 0, 0, 0);
    let mut records = Vec::new();
    model.bind();
    let start = cpu();
    while packets < FRAMES {
        // SAFETY: the model is bound, alive and on this thread; every value fits its signal.
        unsafe {
            valid.set(u8::from(sent < count));
            data.set(frame[place]);
            first.set(u8::from(place == 0));
            last.set(u8::from(place + 1 == frame.len()));
            clock.set(0);
            model.eval_bound();
            if sent < count && input_ready.get() == 1 {
                sent += 1;
                place = if place + 1 == frame.len() { 0 } else { place + 1 };
            }
            if given.get() == 1 {
                records.extend(feature.get());
                packets += usize::from(end.get());
            }
            clock.set(1);
            model.eval_bound();
        }
        cycles += 1;
    }
    Ok(Outcome { seconds: cpu() - start, cycles, records })
}

fn checked(library: &Library, frame: &[u16]) -> Result<Outcome, Error> {
    let mut model = library.instance()?;
    ready(&mut model)?;
    let (clock, valid, input_ready) = (model.find("clock")?, model.find("video_valid")?, model.find("video_ready")?);
    let (data, first, last) =
        (model.find("video_data")?, model.find("video_startofpacket")?, model.find("video_endofpacket")?);
    let (given, end, feature) =
        (model.find("feature_valid")?, model.find("feature_endofpacket")?, model.find("feature_data")?);
    let count = FRAMES * frame.len();
    let (mut sent, mut place, mut packets, mut cycles) = (0, 0, 0, 0);
    let mut records = Vec::new();
    let start = cpu();
    while packets < FRAMES {
        model.set(valid, u64::from(sent < count))?;
        model.set(data, u64::from(frame[place]))?;
        model.set(first, u64::from(place == 0))?;
        model.set(last, u64::from(place + 1 == frame.len()))?;
        model.set(clock, 0)?;
        model.eval()?;
        if sent < count && model.get(input_ready) == 1 {
            sent += 1;
            place = if place + 1 == frame.len() { 0 } else { place + 1 };
        }
        if model.get(given) == 1 {
            records.extend(model.get_words(feature));
            packets += model.get(end) as usize;
        }
        model.set(clock, 1)?;
        model.eval()?;
        cycles += 1;
    }
    Ok(Outcome { seconds: cpu() - start, cycles, records })
}

/// A simulation with its clock, the registers written.
fn running(library: &Library) -> Result<(Sim, Clock), Error> {
    let mut model = library.instance()?;
    ready(&mut model)?;
    let sim = Sim::new(model)?;
    let clock = sim.dut().clock_with("clock", Time::ns(5), Time::ns(5), Time::ns(5))?;
    Ok((sim, clock))
}

fn bulk(library: &Library, frame: &[u16], stall: Pause) -> Result<Outcome, Error> {
    let (mut sim, clock) = running(library)?;
    let mut bulk = Bulk::<u16, u32>::new(&sim.dut(), &clock, "video_", "feature_", AVALON)?;
    let pixels = frame.repeat(FRAMES);
    let options = Options { stall, packet: frame.len(), packets: FRAMES, ..Options::default() };
    let mut records = Vec::new();
    let start = cpu();
    let report = bulk.transfer(&mut sim, &pixels, &mut records, &options)?;
    Ok(Outcome { seconds: cpu() - start, cycles: report.cycles, records })
}

fn source_and_sink(library: &Library, frame: &[u16], stall: Pause) -> Result<Outcome, Error> {
    let (mut sim, clock) = running(library)?;
    let dut = sim.dut();
    let source = Source::new(&dut, clock.signal(), Ports::find(&dut, "video_", AVALON)?.symbols_of(16)?, None)?;
    let output = Ports::find(&dut, "feature_", AVALON)?.symbols_of(32)?;
    let sink = Sink::new(&dut, clock.signal(), output, None, Rules::Strict)?;
    sink.set_pause(stall);
    let begin = dut.now();
    let start = cpu();
    let records = sim.run(async {
        let mut records = Vec::new();
        for _ in 0..FRAMES {
            source.send(&Frame::new(frame))?;
        }
        for _ in 0..FRAMES {
            let packet = sink.recv().await;
            // The first symbol of a beat is in its highest bits.
            records.extend(packet.symbols.chunks(RECORD).flat_map(|r| r.iter().rev().map(|w| *w as u32)));
        }
        Ok::<_, Error>(records)
    })?;
    Ok(Outcome { seconds: cpu() - start, cycles: (dut.now() - begin).as_fs() / 10_000_000, records })
}

/// One task that awaits every edge, does the source's and the sink's work by hand.
fn per_cycle(library: &Library, frame: &[u16]) -> Result<Outcome, Error> {
    let (mut sim, clock) = running(library)?;
    let dut = sim.dut();
    let clk = clock.signal().clone();
    let (valid, input_ready, data) =
        (dut.signal("video_valid")?, dut.signal("video_ready")?, dut.signal("video_data")?);
    let (first, last) = (dut.signal("video_startofpacket")?, dut.signal("video_endofpacket")?);
    let (given, end, feature) =
        (dut.signal("feature_valid")?, dut.signal("feature_endofpacket")?, dut.wide("feature_data")?);
    let count = FRAMES * frame.len();
    let begin = dut.now();
    let start = cpu();
    let records = sim.run(async {
        let (mut sent, mut packets) = (0, 0);
        let mut records = Vec::new();
        let mut offered = false;
        while packets < FRAMES {
            clk.rising_edge().await;
            sent += usize::from(offered && input_ready.is_high());
            if given.is_high() {
                records.extend(feature.get());
                packets += usize::from(end.is_high());
            }
            offered = sent < count;
            let place = sent % frame.len();
            valid.set(u64::from(offered))?;
            data.set(u64::from(frame[place]))?;
            first.set(u64::from(place == 0))?;
            last.set(u64::from(place + 1 == frame.len()))?;
        }
        Ok::<_, Error>(records)
    })?;
    Ok(Outcome { seconds: cpu() - start, cycles: (dut.now() - begin).as_fs() / 10_000_000, records })
}

/// The table of this design.
pub fn table(folder: &Path) -> Result<(), Error> {
    let program = build_limit(folder, "hoverlock_top", &sources()?, "limit_top.cpp")?;
    let file = folder.join("records");
    let limit = || -> Result<Outcome, Error> {
        let fields = words_of(
            &program,
            &[&WIDTH.to_string(), &HEIGHT.to_string(), &FRAMES.to_string(), &file.to_string_lossy()],
        )?;
        let bytes = std::fs::read(&file).map_err(|e| Error::bench(e.to_string()))?;
        let records = bytes.as_chunks::<4>().0.iter().map(|w| u32::from_le_bytes(*w)).collect();
        Ok(Outcome { seconds: fields[0], cycles: fields[1] as u64, records })
    };
    let (library, frame, expected) = (library()?, frame(), limit()?.records);
    println!("{FRAMES} frames of {WIDTH} x {HEIGHT}, {} records a run, trailers included.\n", expected.len() / RECORD);
    let way = |name, key, run: Box<dyn Fn() -> Result<Outcome, Error>>| {
        let expected = expected.clone();
        let run = move || {
            let outcome = run()?;
            expect_equal("the records of a way", &outcome.records, &expected)?;
            Ok((outcome.seconds, 0, outcome.cycles))
        };
        Way { name, key, expected: None, run: Box::new(run) }
    };
    // Each way takes part with the same library and frame.
    macro_rules! with {
        ($run:expr) => {{
            let (library, frame) = (library.clone(), frame.clone());
            Box::new(move || $run(&library, &frame[..]))
        }};
    }
    let stall = || Pause::random(0.3, 1);
    compare(
        "top",
        &[
            Way {
                name: "plain C++ loop",
                key: "cpp",
                expected: None,
                run: Box::new(|| limit().map(|o| (o.seconds, 0, o.cycles))),
            },
            way("Rust direct, unchecked", "rust_unchecked", with!(raw)),
            way("Rust direct, checked", "rust_checked", with!(checked)),
            way("frames in bulk", "bulk", with!(|l: &_, f: &_| bulk(l, f, Pause::Never))),
            way("frames in bulk, 30 % stalls", "bulk_stalls", with!(|l: &_, f: &_| bulk(l, f, stall()))),
            way("source and sink", "source_sink", with!(|l: &_, f: &_| source_and_sink(l, f, Pause::Never))),
            way(
                "source and sink, 30 % stalls",
                "source_sink_stalls",
                with!(|l: &_, f: &_| source_and_sink(l, f, stall())),
            ),
            way("async, one task", "task", with!(per_cycle)),
        ],
    )
}
