//! Simulated cycles per second of CPU time, each way of driving against the plain Verilator loop in C++.
//!
//! `cargo bench -p hoverlock-harness` prints medians of several runs and their ratio to the C++ loop of the same run.
//! All ways do the same work: drive one byte and sample one word a cycle; their sums must agree.

use std::path::Path;
use std::process::Command;

use hoverlock_harness::build::Build;
use hoverlock_harness::model::Model;
use hoverlock_harness::sim::Sim;
use hoverlock_harness::{Error, Time};

const RUNS: usize = 7;

/// CPU seconds of this thread.
fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0) * 1e-9
}

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
        model.set(data, i * 7 & 255)?;
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
            data.set(i * 7 & 255)?;
        }
        Ok::<_, Error>(sum)
    })?;
    let seconds = cpu() - start;
    clock.stop();
    Ok((seconds, sum))
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
            data.set(i * 7 & 255)?;
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

/// Builds the C++ loop with the same Verilator and `-O3`, and gives its program.
fn build_limit(folder: &Path) -> std::path::PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let status = Command::new("verilator")
        .args([
            "--cc",
            "--exe",
            "--build",
            "-O3",
            "-CFLAGS",
            "-O3",
            "-MAKEFLAGS",
            "OPT_FAST=-O3",
            "--assert",
            "--x-assign",
            "0",
        ])
        .args(["--x-initial", "0", "--top-module", "stream", "--no-timing", "-Wno-fatal", "--Mdir"])
        .arg(folder)
        .arg(here.join("tests/designs/stream.v"))
        .arg(here.join("benches/limit.cpp"))
        .stdout(std::process::Stdio::null())
        .status();
    assert!(status.is_ok_and(|s| s.success()), "the C++ loop does not build");
    folder.join("Vstream")
}

fn limit(program: &Path, cycles: u64) -> Result<(f64, u64), Error> {
    let output = Command::new(program).arg(cycles.to_string()).output().map_err(|e| Error::bench(e.to_string()))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let mut fields = text.split_whitespace();
    let seconds = fields.next().and_then(|t| t.parse().ok()).ok_or_else(|| Error::bench("no time"))?;
    let sum = fields.next().and_then(|t| t.parse().ok()).ok_or_else(|| Error::bench("no sum"))?;
    Ok((seconds, sum))
}

type Way<'a> = (&'a str, u64, bool, Box<dyn Fn(u64) -> Result<(f64, u64), Error> + 'a>);

fn main() -> Result<(), Error> {
    let folder = tempfile::tempdir().map_err(|e| Error::bench(e.to_string()))?;
    let program = build_limit(folder.path());
    let million = 1_000_000;
    let ways: Vec<Way> = vec![
        ("plain C++ loop", 20 * million, true, Box::new(|n| limit(&program, n))),
        ("Rust direct, unchecked", 20 * million, true, Box::new(raw)),
        ("Rust direct, checked", 20 * million, true, Box::new(checked)),
        ("clock only", 5 * million, false, Box::new(clock_only)),
        ("async, one task", 3 * million, true, Box::new(per_cycle)),
        ("async, driver and monitor", 3 * million, true, Box::new(driver_and_monitor)),
    ];
    let (_, expected) = limit(&program, 3 * million)?;
    println!("{:<28} {:>14} {:>8}", "way", "cycles/s", "of C++");
    let mut rates = vec![Vec::new(); ways.len()];
    // Round robin, so that a disturbance of the machine meets all ways alike.
    for _ in 0..RUNS {
        for (rate, (name, cycles, compared, run)) in rates.iter_mut().zip(&ways) {
            let (seconds, sum) = run(*cycles)?;
            if *compared && *cycles == 3 * million {
                assert_eq!(sum, expected, "{name} did other work");
            }
            rate.push(*cycles as f64 / seconds);
        }
    }
    let median = |rates: &[f64]| {
        let mut sorted = rates.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let limit = median(&rates[0]);
    for (rate, (name, ..)) in rates.iter().zip(&ways) {
        println!("{name:<28} {:>12.2} M {:>8.3}", median(rate) / 1e6, median(rate) / limit);
    }
    Ok(())
}
