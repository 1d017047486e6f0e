//! `hoverlock rtl`: the Verilog written, proved fresh, and sized for an Arria V.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use hoverlock_rtl::{
    emit::{MEND, files},
    estimate::{Estimate, estimate},
};
use serde::Serialize;

use crate::Verdict;
use crate::output::{print, print_json, write_file};

/// Write the Verilog, prove it fresh, or estimate what it takes of an Arria V.
///
/// Example: hoverlock rtl estimate --json
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Write Verilog, file list, C header, Rust constants and register table
    ///
    /// Example: hoverlock rtl emit
    Emit(Common),
    /// Regenerate everything and compare it with what is there
    ///
    /// Example: hoverlock rtl check
    Check(Common),
    /// Yosys estimate of the top for the Arria V family: ALM, M10K, DSP blocks, registers (some minutes)
    ///
    /// Example: hoverlock rtl estimate --json
    Estimate(Common),
}

#[derive(clap::Args)]
struct Common {
    /// The folder with verilog/ and registers/
    #[arg(long, value_name = "DIR", default_value = "rtl")]
    out: PathBuf,
    /// One JSON object on stdout: emit: files[]; check: fresh stale[]; estimate: alm m10k dsp mul18 registers device fits
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Checked {
    fresh: bool,
    stale: Vec<String>,
}

#[derive(Serialize)]
struct Emitted {
    files: Vec<String>,
}

pub fn run(args: &Args) -> Result<Verdict> {
    match &args.action {
        Action::Emit(common) => emit(common),
        Action::Check(common) => check(common),
        Action::Estimate(common) => sized(common),
    }
}

fn emit(common: &Common) -> Result<Verdict> {
    let files = files()?;
    for file in &files {
        let path = common.out.join(&file.path);
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
        // A file that has not changed keeps its time: no tool works again for nothing.
        if std::fs::read_to_string(&path).ok().as_ref() != Some(&file.text) {
            write_file(&path, file.text.as_bytes())?;
        }
    }
    let emitted = Emitted { files: files.into_iter().map(|file| file.path).collect() };
    if common.json {
        print_json(&emitted)?;
    } else {
        print(&format!("{} files in {}\n", emitted.files.len(), common.out.display()))?;
    }
    Ok(Verdict::Pass)
}

fn check(common: &Common) -> Result<Verdict> {
    if !common.out.is_dir() {
        bail!("{}: no such folder; run this in the project, or give --out", common.out.display());
    }
    let same = |path: &str, text: &str| std::fs::read_to_string(common.out.join(path)).is_ok_and(|there| there == text);
    let stale: Vec<String> =
        files()?.into_iter().filter(|file| !same(&file.path, &file.text)).map(|file| file.path).collect();
    let checked = Checked { fresh: stale.is_empty(), stale };
    if !checked.fresh {
        eprintln!("hoverlock: {} files are stale, {} first; run `{MEND}`", checked.stale.len(), checked.stale[0]);
    }
    if common.json {
        print_json(&checked)?;
    } else if checked.fresh {
        print("every file is fresh\n")?;
    }
    Ok(checked.fresh.into())
}

fn sized(common: &Common) -> Result<Verdict> {
    let estimate = estimate()?;
    if common.json {
        print_json(&estimate)?;
    } else {
        print(&table(&estimate))?;
    }
    Ok(estimate.fits.into())
}

fn table(estimate: &Estimate) -> String {
    let share = |used: u64, of: u64| 100.0 * used as f64 / of as f64;
    let mut text = format!(
        "Yosys estimate of hoverlock_top for Arria V\n  ALM {}\n  M10K {}\n  DSP blocks {} ({} multipliers 18x18)\n  registers {}\n\n",
        estimate.alm, estimate.m10k, estimate.dsp, estimate.mul18, estimate.registers
    );
    for device in &estimate.devices {
        text += &format!(
            "{:10} ALM {:5.1} %  M10K {:5.1} %  DSP {:5.1} %  {}\n",
            device.name,
            share(estimate.alm, device.alm),
            share(estimate.m10k, device.m10k),
            share(estimate.dsp, device.dsp),
            if device.fits { "fits with a third free" } else { "does not fit with a third free" }
        );
    }
    text
}
