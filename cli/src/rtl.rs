//! `hoverlock rtl`: writes the Verilog, checks that it is up to date, and estimates its resources on an Arria V.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use hoverlock_design::{DesignPoint, KT27};
use hoverlock_rtl::emission::{File, MEND, project_path};
use hoverlock_synthesis::{Estimate, ModuleEstimate, estimate};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::Verdict;
use crate::design::{Chosen, emitted, verilog_of};
use crate::output::{Batch, Folder, print, print_json, quoted, say, shown};

/// Write the Verilog, check that it is up to date, or estimate its resources on an Arria V.
///
/// Example: hoverlock rtl estimate --json
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Write Verilog, file list, C header, Rust constants, register table and the component for Platform Designer
    ///
    /// Example: hoverlock rtl emit
    Emit(Common),
    /// Regenerate everything and compare it with the files that exist
    ///
    /// Example: hoverlock rtl check
    Check(Common),
    /// Yosys estimate for the Arria V family: ALM, M10K, DSP blocks, registers and logic depth, in all and of each
    /// module
    ///
    /// A minute or two the first time; the netlist is kept in the user's cache folder for as long as the Verilog stays
    /// the same. The files are read in the order of their names, whatever folder they come from, because Yosys counts
    /// other ALMs in another order.
    /// Status 0 only if the smallest device keeps a third of everything free.
    ///
    /// Example: hoverlock rtl estimate --json
    Estimate(Sized),
}

#[derive(clap::Args)]
struct Common {
    #[command(flatten)]
    chosen: Chosen,
    /// The folder with verilog/, registers/ and quartus/ [default: rtl for kt27, out/rtl/NAME for other designs]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on stdout: emit: files[]; check: fresh stale[] strays[]
    #[arg(long)]
    json: bool,
}

impl Common {
    /// Returns the design and its folder. The default design has the folder of the project, which no other design may
    /// overwrite.
    ///
    /// # Errors
    /// There is no such design, or the folder of the project is meant and is not here.
    fn target(&self) -> Result<Target> {
        let design = self.chosen.design()?.of_hardware();
        let is_default = design == *KT27;
        let own = || if is_default { "rtl".into() } else { Path::new("out/rtl").join(self.chosen.name()) };
        let out = self.out.clone().unwrap_or_else(own);
        let is_here = Path::new("registers/Cargo.toml").is_file() && Path::new("rtl").is_dir();
        if is_default && self.out.is_none() && !is_here {
            bail!("{}: no such folder of the project here; run this in the project, or give --out", shown(&out));
        }
        let is_project = is_default && is_here && out.canonicalize().ok() == Path::new("rtl").canonicalize().ok();
        Ok(Target { design, out, is_project })
    }

    /// Returns the options that mean this design in this folder.
    fn options(&self) -> String {
        let out = self.out.as_ref().map_or_else(String::new, |out| format!(" --out {}", quoted(out)));
        self.chosen.options() + &out
    }
}

/// A design and the folder of its emitted files.
struct Target {
    design: DesignPoint,
    out: PathBuf,
    /// The folder is that of the project, where some files are in other folders.
    is_project: bool,
}

impl Target {
    /// Returns the path of an emitted file.
    fn path(&self, file: &File) -> PathBuf {
        if self.is_project { project_path(&file.path) } else { self.out.join(&file.path) }
    }
}

#[derive(clap::Args)]
struct Sized {
    #[command(flatten)]
    chosen: Chosen,
    /// Size the Verilog files of this folder, in place of the design's own
    #[arg(long, value_name = "DIR")]
    rtl: Option<PathBuf>,
    /// One JSON object on stdout: alm m10k dsp mul18 registers logic_levels device fits modules[] devices[]
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Checked {
    fresh: bool,
    stale: Vec<String>,
    strays: Vec<String>,
}

#[derive(Serialize)]
struct Emitted {
    files: Vec<String>,
}

pub fn run(args: &Args) -> Result<Verdict> {
    match &args.action {
        Action::Emit(common) => emit(common),
        Action::Check(common) => check(common),
        Action::Estimate(args) => sized(args),
    }
}

fn emit(common: &Common) -> Result<Verdict> {
    let target = common.target()?;
    let files = emitted(&target.design)?;
    let mut folders = Vec::new();
    let mut batch = Batch::default();
    for file in &files {
        let path = target.path(file);
        folders.push(Folder::holding(&path)?);
        // A file that has not changed keeps its time, so that no tool processes it again.
        if std::fs::read_to_string(&path).ok().as_ref() != Some(&file.text) {
            batch.add(&path, file.text.as_bytes())?;
        }
    }
    batch.keep()?;
    drop(folders);
    say_strays(&strays(&target.out.join("verilog"), &files)?);
    let emitted = Emitted { files: files.into_iter().map(|file| file.path).collect() };
    if common.json {
        print_json(&emitted)?;
    } else {
        print(&format!("{} files in {}\n", emitted.files.len(), shown(&target.out)))?;
    }
    Ok(Verdict::Pass)
}

fn check(common: &Common) -> Result<Verdict> {
    let target = common.target()?;
    if !target.out.is_dir() {
        bail!("{}: no such folder; write it with `{MEND}{}`, or give --out", shown(&target.out), common.options());
    }
    let files = emitted(&target.design)?;
    let is_fresh = |file: &&File| std::fs::read_to_string(target.path(file)).is_ok_and(|text| text == file.text);
    let stale: Vec<String> = files.iter().filter(|file| !is_fresh(file)).map(|file| file.path.clone()).collect();
    let strays = strays(&target.out.join("verilog"), &files)?;
    let checked = Checked { fresh: stale.is_empty() && strays.is_empty(), stale, strays };
    if let Some(first) = checked.stale.first() {
        let mend = format!("{MEND}{}", common.options());
        let (stale, more) = (first, checked.stale.len() - 1);
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        say(&format!("{stale} is stale{more}; run `{mend}`"));
    }
    say_strays(&checked.strays);
    if common.json {
        print_json(&checked)?;
    } else if checked.fresh {
        print("every file is fresh\n")?;
    }
    Ok(checked.fresh.into())
}

fn say_strays(strays: &[String]) {
    if let Some(first) = strays.first() {
        say(&format!("{} files are of no module, {first} first; remove them", strays.len()));
    }
}

/// Returns Verilog files that the sources do not emit. Simulator and Yosys would read them nevertheless.
fn strays(folder: &Path, files: &[File]) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("{}: cannot be read", folder.display()))?;
    let names = entries.filter_map(|entry| Some(format!("verilog/{}", entry.ok()?.file_name().to_str()?)));
    let mut strays: Vec<_> =
        names.filter(|name| name.ends_with(".v") && files.iter().all(|file| file.path != *name)).collect();
    strays.sort();
    Ok(strays)
}

fn sized(args: &Sized) -> Result<Verdict> {
    let design = args.chosen.design()?.of_hardware();
    design.check_buildable()?;
    verilog_of(&design, args.rtl.as_deref())?;
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} Yosys, a minute or two: {elapsed}  {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    let estimate = estimate(&design, args.rtl.as_deref(), &mut |pass| bar.set_message(pass.to_owned()))?;
    bar.finish_and_clear();
    if !estimate.fits {
        say(&format!("{} is too small: {}", estimate.device, estimate.fits_rule));
    }
    if args.json {
        print_json(&estimate)?;
    } else {
        print(&table(&estimate))?;
    }
    Ok(estimate.fits.into())
}

fn table(estimate: &Estimate) -> String {
    let mut text = format!(
        "Yosys estimate of hoverlock_top for Arria V ({})\n\n  ALM {}   M10K {}   multipliers 18x18 {}, in {} DSP \
         blocks   \
         registers {}   logic levels {}\n\n",
        estimate.yosys,
        estimate.alm,
        estimate.m10k,
        estimate.mul18,
        estimate.dsp,
        estimate.registers,
        estimate.logic_levels
    );
    text += &format!(
        "{:9}{:>18}{:>18}{:>18}   {:4}  source of the figures\n",
        "device", "ALM", "M10K", "DSP blocks", "fits"
    );
    for device in &estimate.devices {
        text += &format!("{:9}", device.name);
        for (of, percent) in [device.alm, device.m10k, device.dsp].into_iter().zip(device.used_percent) {
            text += &format!("{:>18}", format!("{percent:.1} % of {of}"));
        }
        text += &format!("   {:4}  {}\n", if device.fits { "yes" } else { "NO" }, device.source);
    }
    let [alm, m10k, dsp] = estimate.devices[0].limits;
    text += &format!(
        "fits: {}; in {} at most {alm} ALM, {m10k} M10K, {dsp} DSP blocks\n\n",
        estimate.fits_rule, estimate.device
    );
    let names = estimate.modules.iter().map(|of| of.name.len()).chain([25]);
    let wide = names.max().unwrap_or_default() + 1;
    text += &format!(
        "{:wide$}{:>5}{:>7}{:>7}{:>6}{:>7}{:>6}{:>5}{:>7}{:>7}{:>7}\n",
        "module, its own cells", "times", "ALM", "%", "M10K", "%", "18x18", "DSP", "regs", "levels", "ns"
    );
    let row = |name: &str, of: &ModuleEstimate| {
        format!(
            "{name:wide$}{:>5}{:>7}{:>7.1}{:>6}{:>7.1}{:>6}{:>5}{:>7}{:>7}{:>7.2}\n",
            of.instances,
            of.alm,
            100.0 * of.alm as f64 / estimate.alm as f64,
            of.m10k,
            100.0 * of.m10k as f64 / estimate.m10k as f64,
            of.mul18,
            of.dsp,
            of.registers,
            of.logic_levels,
            f64::from(of.cell_delay_ps) / 1000.0
        )
    };
    // Modules that are neither large nor deep are summed in one line.
    let named = |of: &&ModuleEstimate| {
        of.m10k + of.mul18 > 0 || 100 * of.alm >= estimate.alm || 2 * of.logic_levels > estimate.logic_levels
    };
    let (named, others): (Vec<_>, Vec<_>) = estimate.modules.iter().partition(named);
    for of in named {
        text += &row(&of.name, of);
    }
    let sum = |of: fn(&ModuleEstimate) -> u64| others.iter().map(|module| of(module)).sum::<u64>();
    let most = |of: fn(&ModuleEstimate) -> u32| others.iter().map(|module| of(module)).max().unwrap_or_default();
    if let Some(first) = others.first() {
        let rest = ModuleEstimate {
            instances: sum(|module| module.instances),
            alm: sum(|module| module.alm),
            registers: sum(|module| module.registers),
            mlab: sum(|module| module.mlab),
            logic_levels: most(|module| module.logic_levels),
            cell_delay_ps: most(|module| module.cell_delay_ps),
            ..(*first).clone()
        };
        text += &row(&format!("{} smaller modules", others.len()), &rest);
    }
    if let Some(deepest) = estimate.modules.iter().max_by_key(|module| module.logic_levels) {
        text += &format!(
            "\nMost levels, {}: from {} to {}. Target clock {} MHz.\n",
            deepest.logic_levels, deepest.path_from, deepest.path_to, estimate.target_mhz
        );
    }
    text + &format!(
        "ALM: {}.\nlevels: {}.\nns: the slowest such path from the clock to set-up, in Yosys's delays of \
         Arria V cells; wires not counted.\n",
        estimate.alm_rule, estimate.levels_rule
    )
}
