//! The small design (`tests/designs/stream.v`): each way drives one byte and samples one output in each cycle; the sums
//! of the outputs must agree.

use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

use hoverlock_harness::build::Build;
use hoverlock_harness::bus::Pause;
use hoverlock_harness::bus::bulk::{Bulk, Options};
use hoverlock_harness::bus::stream::{Dialect, Frame, Ports, Rules, Sink, Source};
use hoverlock_harness::model::Model;
use hoverlock_harness::sim::{Clock, Coroutine, Edge, Outcome, Signal, Sim, Step, Trigger};
use hoverlock_harness::{Error, Time};

use crate::measure::{Way, build_limit, compare, cpu, words_of};

/// The model out of reset, clock high.
fn reset(model: &mut Model) -> Result<(), Error> {
    let (clk, rst, ready, valid) =
        (model.find("clk")?, model.find("rst")?, model.find("out_ready")?, model.find("in_valid")?);
    model.set(rst, 1)?;
    model.set(ready, 1)?;
    for _ in 0..4 {
        model.set(clk, 0)?;
        model.eval()?;
        model.set(clk, 1)?;
        model.eval()?;
    }
    model.set(rst, 0)?;
    model.set(valid, 1)?;
    Ok(())
}

fn library() -> Result<hoverlock_harness::model::Library, Error> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/designs/stream.v");
    Ok(Build::new("stream").source(source).compile()?)
}

fn raw(cycles: u64) -> Result<(f64, u64), Error> {
    let mut model = library()?.instance()?;
    reset(&mut model)?;
    let (clk, data, out) = (model.raw::<u8>("clk")?, model.raw::<u8>("in_data")?, model.raw::<u16>("out_data")?);
    let mut sum = 0;
    model.bind();
    let start = cpu();
    for i in 0..cycles {
        // SAFETY: the model is bound, alive and on this thread; a byte fits `in_data`, a bit fits `clk`.
        unsafe {
            data.set((i * 7) as u8);
            clk.set(0);
            model.eval_bound();
            sum += u64::from(out.get());
            clk.set(1);
            model.eval_bound();
        }
    }
    Ok((cpu() - start, sum))
}

fn checked(cycles: u64) -> Result<(f64, u64), Error> {
    let mut model = library()?.instance()?;
    reset(&mut model)?;
    let (clk, data, out) = (model.find("clk")?, model.find("in_data")?, model.find("out_data")?);
    let mut sum = 0;
    let start = cpu();
    for i in 0..cycles {
        model.set(data, (i * 7) & 255)?;
        model.set(clk, 0)?;
        model.eval()?;
        sum += model.get(out);
        model.set(clk, 1)?;
        model.eval()?;
    }
    Ok((cpu() - start, sum))
}

fn clock_only(cycles: u64) -> Result<(f64, u64), Error> {
    let mut sim = Sim::new(library()?.instance()?)?;
    sim.dut().clock("clk", Time::ns(2))?;
    let start = cpu();
    sim.run_for(Time::ns(2 * cycles))?;
    Ok((cpu() - start, 0))
}

fn per_cycle(cycles: u64) -> Result<(f64, u64), Error> {
    let mut model = library()?.instance()?;
    reset(&mut model)?;
    let mut sim = Sim::new(model)?;
    let dut = sim.dut();
    let (clk, data, out) = (dut.signal("clk")?, dut.signal("in_data")?, dut.signal("out_data")?);
    let clock = dut.clock_with("clk", Time::ns(1), Time::ns(1), Time::ns(1))?;
    let start = cpu();
    let sum = sim.run(async {
        data.set(0)?;
        let mut sum = 0;
        for i in 1..=cycles {
            clk.rising_edge().await;
            sum += out.get();
            data.set((i * 7) & 255)?;
        }
        Ok::<_, Error>(sum)
    })?;
    let seconds = cpu() - start;
    clock.stop();
    Ok((seconds, sum))
}

/// A task as another language brings it: resumed through a trait object, each wait a value.
struct PerCycle {
    clk: Signal,
    data: Signal,
    out: Signal,
    cycles: u64,
    at: u64,
    sum: Rc<Cell<u64>>,
}

impl Coroutine for PerCycle {
    fn resume(&mut self, _: Outcome) -> Step {
        if self.at > 0 {
            self.sum.set(self.sum.get() + self.out.get());
        }
        if let Err(error) = self.data.set((self.at * 7) & 255) {
            return Step::Failed(error.into());
        }
        if self.at == self.cycles {
            return Step::Done;
        }
        self.at += 1;
        Step::Wait(Trigger::Edge(self.clk.id(), Edge::Rising))
    }
}

fn coroutine(cycles: u64) -> Result<(f64, u64), Error> {
    let mut model = library()?.instance()?;
    reset(&mut model)?;
    let mut sim = Sim::new(model)?;
    let dut = sim.dut();
    dut.clock_with("clk", Time::ns(1), Time::ns(1), Time::ns(1))?;
    let sum = Rc::new(Cell::new(0));
    let (clk, data, out) = (dut.signal("clk")?, dut.signal("in_data")?, dut.signal("out_data")?);
    let task = PerCycle { clk, data, out, cycles, at: 0, sum: sum.clone() };
    let start = cpu();
    sim.run_coroutine("bench", Box::new(task))?;
    Ok((cpu() - start, sum.get()))
}

fn driver_and_monitor(cycles: u64) -> Result<(f64, u64), Error> {
    let mut model = library()?.instance()?;
    reset(&mut model)?;
    let mut sim = Sim::new(model)?;
    let dut = sim.dut();
    let (clk, data, out) = (dut.signal("clk")?, dut.signal("in_data")?, dut.signal("out_data")?);
    dut.clock_with("clk", Time::ns(1), Time::ns(1), Time::ns(1))?;
    let start = cpu();
    let driver_clk = clk.clone();
    dut.spawn("driver", async move {
        data.set(0)?;
        for i in 1..=cycles {
            driver_clk.rising_edge().await;
            data.set((i * 7) & 255)?;
        }
        Ok::<(), Error>(())
    });
    let sum = sim.run(async {
        let mut sum = 0;
        for _ in 0..cycles {
            clk.rising_edge().await;
            sum += out.get();
        }
        Ok::<_, Error>(sum)
    })?;
    Ok((cpu() - start, sum))
}

/// A simulation out of reset, with its clock.
fn reset_sim() -> Result<(Sim, Clock), Error> {
    let mut sim = Sim::new(library()?.instance()?)?;
    let dut = sim.dut();
    let clock = dut.clock("clk", Time::ns(2))?;
    dut.signal("rst")?.set(1)?;
    sim.run_for(Time::ns(8))?;
    dut.signal("rst")?.set(0)?;
    sim.run_for(Time::ns(4))?;
    Ok((sim, clock))
}

const PACKET: usize = 100_000;
const AVALON: Dialect = Dialect::Avalon { ready_latency: 0 };

fn bytes(count: u64) -> Vec<u8> {
    (0..count).map(|i| (i * 7) as u8).collect()
}

/// Whole frames through native source and sink inside the scheduler; cycles are counted by the clock.
fn source_and_sink(words: u64, stall: Pause) -> Result<(f64, u64, u64), Error> {
    let (mut sim, clock) = reset_sim()?;
    let dut = sim.dut();
    let source = Source::new(&dut, clock.signal(), Ports::find(&dut, "in_", AVALON)?, None)?;
    let output = Ports::find(&dut, "out_", AVALON)?.symbols_of(16)?;
    let sink = Sink::new(&dut, clock.signal(), output, None, Rules::Strict)?;
    sink.set_pause(stall);
    let data = bytes(words);
    let begin = dut.now();
    let start = cpu();
    let sum = sim.run(async {
        let mut sum = 0;
        for packet in data.chunks(PACKET) {
            source.send(&Frame::new(packet))?;
            sum += sink.recv().await.symbols.iter().sum::<u64>();
        }
        Ok::<_, Error>(sum)
    })?;
    let seconds = cpu() - start;
    Ok((seconds, sum, (dut.now() - begin).as_fs() / 2_000_000))
}

fn bulk(words: u64, stall: Pause) -> Result<(f64, u64, u64), Error> {
    let (mut sim, clock) = reset_sim()?;
    let mut bulk = Bulk::<u8, u16>::new(&sim.dut(), &clock, "in_", "out_", AVALON)?;
    let data = bytes(words);
    let mut received = Vec::with_capacity(data.len());
    let options = Options { stall, packet: PACKET, expect: data.len(), ..Options::default() };
    let start = cpu();
    let report = bulk.transfer(&mut sim, &data, &mut received, &options)?;
    let seconds = cpu() - start;
    Ok((seconds, received.iter().map(|w| u64::from(*w)).sum(), report.cycles))
}

/// The table of this design.
pub fn table(folder: &Path) -> Result<(), Error> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = build_limit(folder, "stream", &[here.join("tests/designs/stream.v")], "limit_small.cpp")?;
    let limit = |cycles: u64| -> Result<(f64, u64, u64), Error> {
        let fields = words_of(&program, &[&cycles.to_string()])?;
        Ok((fields[0], fields[1] as u64, cycles))
    };
    let million = 1_000_000;
    let (many, some) = (20 * million, 3 * million);
    let direct = |name, key, expected, run: fn(u64) -> Result<(f64, u64), Error>, cycles| -> Way<'_> {
        let run = move || run(cycles).map(|(seconds, sum)| (seconds, sum, cycles));
        Way { name, key, expected, run: Box::new(run) }
    };
    let (of_many, of_some) = (Some(limit(many)?.1), Some(limit(some)?.1));
    let packets = Some(bulk(some, Pause::Never)?.1);
    let stall = || Pause::random(0.3, 1);
    compare(
        "small",
        &[
            Way { name: "plain C++ loop", key: "cpp", expected: of_many, run: Box::new(|| limit(many)) },
            direct("Rust direct, unchecked", "rust_unchecked", of_many, raw, many),
            direct("Rust direct, checked", "rust_checked", of_many, checked, many),
            Way { name: "frames in bulk", key: "bulk", expected: packets, run: Box::new(|| bulk(some, Pause::Never)) },
            Way {
                name: "frames in bulk, 30 % stalls",
                key: "bulk_stalls",
                expected: packets,
                run: Box::new(|| bulk(some, stall())),
            },
            Way {
                name: "source and sink",
                key: "source_sink",
                expected: packets,
                run: Box::new(|| source_and_sink(some, Pause::Never)),
            },
            Way {
                name: "source and sink, 30 % stalls",
                key: "source_sink_stalls",
                expected: packets,
                run: Box::new(|| source_and_sink(some, stall())),
            },
            direct("clock only", "clock", None, clock_only, 5 * million),
            direct("async, one task", "task", of_some, per_cycle, some),
            direct("coroutine, one task", "coroutine", of_some, coroutine, some),
            direct("async, driver and monitor", "driver_monitor", of_some, driver_and_monitor, some),
        ],
    )
}

/// How long a test waits for its model: cached, and after an edit of the Verilog.
pub fn start_times(folder: &Path) -> Result<(), Error> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/designs/stream.v"));
    let text = text.map_err(|e| Error::bench(e.to_string()))?;
    let source = folder.join("stream.v");
    let build = Build::new("stream").source(&source);
    let (mut edited, mut cached) = (Vec::new(), Vec::new());
    for number in 0..5 {
        let stamp = std::time::SystemTime::now();
        let edit = format!("{text}// edit {number} at {stamp:?}\n");
        std::fs::write(&source, edit).map_err(|e| Error::bench(e.to_string()))?;
        for times in [&mut edited, &mut cached] {
            let start = std::time::Instant::now();
            Sim::new(build.compile()?.instance()?)?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    for (name, mut times) in [("start after an edit", edited), ("start of a cached model", cached)] {
        times.sort_by(f64::total_cmp);
        println!("{name:<28} {:>11.1} ms (wall, best of 5; median {:.1})", times[0], times[2]);
    }
    Ok(())
}
