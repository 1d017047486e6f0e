//! What the tables have in common: CPU time, the C++ loop, turns and medians.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use hoverlock_harness::Error;

const RUNS: usize = 5;

/// A way of driving a design.
pub struct Way<'a> {
    /// What it is called in the table.
    pub name: &'a str,
    /// What it is called in `docs/results.json`, under `harness.rust.DESIGN`.
    pub key: &'a str,
    /// What [`Way::run`] must give as the sum of its outputs, where it is compared.
    pub expected: Option<u64>,
    /// Gives CPU seconds, the sum of the outputs and the cycles that were simulated.
    pub run: Run<'a>,
}

/// One run of a way.
pub type Run<'a> = Box<dyn Fn() -> Result<(f64, u64, u64), Error> + 'a>;

/// CPU seconds of this thread.
pub fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0) * 1e-9
}

/// Builds a C++ loop of this folder with the harness's Verilator and `-O3`, and gives its program.
pub fn build_limit(folder: &Path, top: &str, sources: &[PathBuf], limit: &str) -> Result<PathBuf, Error> {
    let folder = folder.join(top);
    let options = "--cc --exe --build -O3 -CFLAGS -O3 -MAKEFLAGS OPT_FAST=-O3 --assert --x-assign 0 --x-initial 0 \
                   --no-timing -Wno-fatal";
    let status = Command::new("verilator")
        .args(options.split_whitespace())
        .args(["--top-module", top, "-o", "limit", "--Mdir"])
        .arg(&folder)
        .args(sources)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/throughput").join(limit))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    match status {
        Ok(status) if status.success() => Ok(folder.join("limit")),
        _ => Err(Error::bench(format!("the C++ loop {limit} does not build"))),
    }
}

/// The numbers that a C++ loop prints.
pub fn words_of(program: &Path, arguments: &[&str]) -> Result<Vec<f64>, Error> {
    let output = Command::new(program).args(arguments).output().map_err(|e| Error::bench(e.to_string()))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let fields: Option<Vec<f64>> = text.split_whitespace().map(|t| t.parse().ok()).collect();
    fields
        .filter(|fields| output.status.success() && fields.len() == 2)
        .ok_or_else(|| Error::bench(format!("{} printed {text:?}", program.display())))
}

/// Runs the ways by turns and prints medians and their ratio to the first, which is the C++ loop. The lines `result
/// KEY=VALUE` after the table are for `setup/results.py record`.
pub fn compare(design: &str, ways: &[Way<'_>]) -> Result<(), Error> {
    let mut rates = vec![Vec::new(); ways.len()];
    // Round robin, so that a disturbance of the machine meets all ways alike.
    for _ in 0..RUNS {
        for (rate, way) in rates.iter_mut().zip(ways) {
            let (seconds, sum, cycles) = (way.run)()?;
            if let Some(expected) = way.expected {
                assert_eq!(sum, expected, "{} did other work", way.name);
            }
            rate.push(cycles as f64 / seconds);
        }
    }
    let median = |rates: &[f64]| {
        let mut sorted = rates.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let limit = median(&rates[0]);
    println!("| way | cycles/s | of C++ |\n|---|---|---|");
    for (rate, way) in rates.iter().zip(ways) {
        println!("| {} | {:.2} M | {:.2} |", way.name, median(rate) / 1e6, median(rate) / limit);
    }
    for (rate, way) in rates.iter().zip(ways) {
        println!("result harness.rust.{design}.{}={:.0}", way.key, median(rate));
    }
    Ok(())
}
