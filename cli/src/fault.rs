//! `hoverlock fault`: faults in registers and memories while the hardware runs, and what comes of them.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use clap::{ValueEnum, ValueHint};
use hoverlock_cosim::upsets::{self, Cost, HoverFrames};
use hoverlock_design::{DesignPoint, MIN_SIDE};
use hoverlock_fault::campaign::campaign;
use hoverlock_fault::class::{Class, Counts, wilson};
use hoverlock_fault::core::{Core, CoreError, Options, Stimulus};
use hoverlock_fault::draw::{Fault, Kind, draw};
use hoverlock_fault::state::{Part, State};
use hoverlock_fault::table::{By, Group, all, csv, groups, interval, markdown, rows};
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::fastest::FastestModel;
use hoverlock_harness::BuildError;
use hoverlock_harness::build::{Build, Parameter};
use hoverlock_reference::image::plane::Plane;
use hoverlock_simulation::Simulator;
use hoverlock_simulation::upsets::{MIN_FRAMES, Upsets};
use serde::Serialize;

use crate::Verdict;
use crate::design::{Chosen, verilog_of};
use crate::output::{command, prepare_target, print, print_json, say, shown, write_file};
use crate::picture::{Limit, open};
use crate::progress::{LogLines, bar, spinning};

/// Flip bits of registers and memories while the hardware runs, and count what comes of it.
///
/// Each fault is in one bit, drawn with the clock cycle from the seed; every bit is equally likely. A run with the
/// fault is compared with the run without: masked, detected, recovered within a frame, silent, or hang. With a picture
/// the hardware is Hoverlock's top, which takes --frames strips of the picture back to back. With --scene its frames
/// are those of a camera that moves over a scene of the simulator, and the flight program says what each fault costs.
/// With --source it is any Verilog of one clock, its inputs random or from a table. Status 0 if all runs were made.
///
/// Examples:
///   hoverlock fault aerial.png --upsets 2000 --table upsets.md
///   hoverlock fault --scene field --config protection=parity --upsets 1000
///   hoverlock fault --source fifo.v --top fifo --upsets 5000 --detect overflow
///   hoverlock fault --source core.v --top core --stimulus in.csv --valid out_valid --kind stuck1
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// A picture of the ground for Hoverlock's top: its strips are the frames
    #[arg(
        value_name = "IMAGE",
        required_unless_present_any = ["source", "scene"],
        conflicts_with_all = ["source", "scene"]
    )]
    image: Option<PathBuf>,
    /// Number of faults, each a run of its own
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    upsets: u32,
    /// Seed of bits and cycles
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// What happens to the bit
    #[arg(long, value_enum, default_value_t = KindChoice::Seu)]
    kind: KindChoice,
    /// Registers, memories, or both
    #[arg(long, value_enum, default_value_t = PartChoice::All)]
    part: PartChoice,
    /// Only registers of this name below the top, or of this module; * stands for any text
    #[arg(long, value_name = "PATTERN")]
    only: Vec<String>,
    /// A line of the table for each module, or for each register
    #[arg(long, value_enum, default_value_t = ByChoice::Module)]
    by: ByChoice,
    /// Write a line for each fault: module,register,word,bit,cycle,kind,class
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    csv: Option<PathBuf>,
    /// Write the table as Markdown, with the command that made it
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    table: Option<PathBuf>,
    /// One JSON object on stdout: kind seed cycles bits classes[] groups[] cost seconds
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    own: Own,
    #[command(flatten)]
    other: Other,
}

/// The options of Hoverlock's top.
#[derive(clap::Args)]
struct Own {
    /// Frames of a camera that moves over this scene of the simulator, or scene file, in place of a picture's strips
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "source")]
    scene: Option<String>,
    /// Frames of a run: a fault happens while the second enters
    #[arg(
        long,
        value_name = "N",
        default_value_t = MIN_FRAMES as u32,
        value_parser = clap::value_parser!(u32).range(MIN_FRAMES as i64..=100),
        conflicts_with = "source"
    )]
    frames: u32,
    /// Rows of a frame; it is as wide as the picture, up to the width of the design
    #[arg(
        long,
        value_name = "N",
        default_value_t = MIN_SIDE,
        value_parser = clap::value_parser!(u32).range(i64::from(MIN_SIDE)..=2048),
        conflicts_with_all = ["source", "scene"]
    )]
    rows: u32,
    #[command(flatten)]
    chosen: Chosen,
    /// Take the Verilog files of this folder in place of the design's own
    #[arg(long, value_name = "DIR", conflicts_with = "source", value_hint = ValueHint::DirPath)]
    rtl: Option<PathBuf>,
    #[command(flatten)]
    limit: Limit,
}

/// The options of any other Verilog.
#[derive(clap::Args)]
struct Other {
    /// Verilog files of your own, in place of Hoverlock's
    #[arg(
        long,
        value_name = "FILE",
        num_args = 1..,
        requires = "top",
        conflicts_with_all = ["design", "config", "max_megapixels"],
        value_hint = ValueHint::FilePath
    )]
    source: Vec<PathBuf>,
    /// The top module of --source
    #[arg(long, value_name = "NAME", requires = "source")]
    top: Option<String>,
    /// A folder for `include and for modules named like their files
    #[arg(long, value_name = "DIR", requires = "source", value_hint = ValueHint::DirPath)]
    include: Vec<PathBuf>,
    /// A parameter of the top
    #[arg(long, value_name = "NAME=VALUE", requires = "source")]
    parameter: Vec<String>,
    /// The clock [default: the input with a usual name]
    #[arg(long, value_name = "INPUT", requires = "source")]
    clock: Option<String>,
    /// The reset, active at 1 [default: the input with a usual name]
    #[arg(long, value_name = "INPUT", requires = "source")]
    reset: Option<String>,
    /// The reset, active at 0
    #[arg(long, value_name = "INPUT", requires = "source", conflicts_with = "reset")]
    reset_low: Option<String>,
    /// Inputs as a table: names in the first line, then a line for each clock cycle; without it every input is random
    /// in each cycle
    #[arg(long, value_name = "FILE", requires = "source", value_hint = ValueHint::FilePath)]
    stimulus: Option<PathBuf>,
    /// An input that is constant
    #[arg(long, value_name = "INPUT=VALUE", requires = "source")]
    set: Vec<String>,
    /// Compare the other outputs only in cycles in which this one is 1
    #[arg(long, value_name = "OUTPUT", requires = "source")]
    valid: Option<String>,
    /// An output that reports an error: a run in which it rises is detected
    #[arg(long, value_name = "OUTPUT", requires = "source")]
    detect: Vec<String>,
    /// Clock cycles of a run [default: the lines of the table, or 2000]
    #[arg(
        long,
        value_name = "N",
        requires = "source",
        value_parser = clap::value_parser!(u64).range(1..=1_000_000_000)
    )]
    cycles: Option<u64>,
    /// Clock cycles after the fault within which a wrong output counts as recovered
    #[arg(
        long,
        value_name = "N",
        default_value_t = 64,
        requires = "source",
        value_parser = clap::value_parser!(u64).range(1..=100_000_000)
    )]
    frame_cycles: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum KindChoice {
    /// Inverted once
    Seu,
    /// 0 from the cycle on
    Stuck0,
    /// 1 from the cycle on
    Stuck1,
}

impl From<KindChoice> for Kind {
    fn from(choice: KindChoice) -> Self {
        match choice {
            KindChoice::Seu => Self::Seu,
            KindChoice::Stuck0 => Self::Stuck0,
            KindChoice::Stuck1 => Self::Stuck1,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PartChoice {
    /// Registers and memories
    All,
    /// What is no array
    Registers,
    /// Arrays
    Memories,
}

impl From<PartChoice> for Part {
    fn from(choice: PartChoice) -> Self {
        match choice {
            PartChoice::All => Self::All,
            PartChoice::Registers => Self::Registers,
            PartChoice::Memories => Self::Memories,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ByChoice {
    /// The module that declares it
    Module,
    /// Its name below the top
    Register,
}

/// The JSON object of `--json`.
#[derive(Serialize)]
struct Report {
    kind: Kind,
    seed: u64,
    /// Clock cycles of a run without a fault, after the reset.
    cycles: u64,
    /// Bits that a fault can be in.
    bits: u64,
    classes: Vec<PerClass>,
    groups: Vec<Group>,
    /// With a scene: what the faults cost the flight program.
    #[serde(skip_serializing_if = "Option::is_none")]
    cost: Option<Costs>,
    /// Wall time of the runs.
    seconds: f64,
}

/// What all faults cost the flight program.
#[derive(Serialize)]
struct Costs {
    /// Frames that have an estimate without a fault, in one run.
    estimates: usize,
    /// Faults that change an estimate by more than a centimetre, or withhold one.
    faults: usize,
    /// Frames without an estimate because of a fault, of all runs.
    withheld: usize,
    /// Largest change of an estimate, m.
    shift_m: f64,
    /// Estimates further from the truth than their protection level, of all runs.
    misleading: usize,
}

/// The runs of a class, and their share with its 95 % confidence interval.
#[derive(Serialize)]
struct PerClass {
    class: Class,
    faults: u64,
    share: f64,
    low: f64,
    high: f64,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let inputs: Vec<&Path> =
        args.image.iter().chain(&args.other.source).chain(&args.other.stimulus).map(PathBuf::as_path).collect();
    let target = |option, path: &Option<PathBuf>, ending| {
        path.as_ref().map(|path| prepare_target(option, path, &[ending], &inputs)).transpose()
    };
    let _folders = [target("--csv", &args.csv, "csv")?, target("--table", &args.table, "md")?];
    let of_top = |upsets: &Upsets| {
        format!("{} frames, {} features, {} cycles a run", args.own.frames, upsets.features(), upsets.cycles())
    };
    match (&args.image, &args.own.scene) {
        (Some(image), _) => {
            let design = designed(&args.own)?;
            let upsets = own(&args.own, &design, &strips(&design, &args.own, image)?)?;
            let run = |fault: &Fault| Ok((upsets.run(fault)?, None));
            report(args, &of_top(&upsets), upsets.state(), upsets.window(), upsets.cycles(), 0, run)
        }
        (None, Some(scene)) => {
            let design = designed(&args.own)?;
            let columns = upsets::SIZE.0;
            if (design.width as usize) < columns {
                bail!(
                    "--scene takes frames of {columns} columns; give a design that has them, this one has {}",
                    design.width
                );
            }
            let hover = spinning("rendering the frames", || {
                HoverFrames::new(&design, scene, args.own.frames as usize, args.seed)
            })?;
            let upsets = own(&args.own, &design, hover.frames())?;
            let golden = hover.fixes(upsets.golden());
            let estimates = golden.iter().flatten().count();
            if estimates == 0 {
                bail!(
                    "--scene {scene}: no frame has an estimate even without a fault; take another scene, or a design \
                     with at most two scale pairs"
                );
            }
            let run = |fault: &Fault| {
                let packets = upsets.packets(fault)?;
                let cost = hover.cost(&golden, &hover.fixes(&packets));
                Ok((upsets.class(&packets), Some(cost)))
            };
            report(args, &of_top(&upsets), upsets.state(), upsets.window(), upsets.cycles(), estimates, run)
        }
        (None, None) => {
            let core = other(&args.other, args.seed)?;
            let (clock, reset) = core.clock_and_reset();
            let reset = reset.map_or("no reset".into(), |(name, level)| format!("reset {name}, active at {level}"));
            let ((active, outputs), cycles) = (core.active_outputs(), core.cycles());
            let about = format!("clock {clock}, {reset}; {active} of {outputs} outputs change in {cycles} cycles");
            let run = |fault: &Fault| Ok((core.run(fault)?, None));
            report(args, &about, core.state(), core.window(), cycles, 0, run)
        }
    }
}

/// Returns the design of Hoverlock's top.
fn designed(args: &Own) -> Result<DesignPoint> {
    let design = args.chosen.design()?.of_hardware();
    design.check_buildable()?;
    Ok(design)
}

/// Prepares Hoverlock's top with these frames.
fn own(args: &Own, design: &DesignPoint, frames: &[Plane<u16>]) -> Result<Upsets> {
    let thresholds = FastestModel::new(design)?.settled(&frames[0]);
    let sources = verilog_of(design, args.rtl.as_deref())?;
    let simulator = spinning("building the Verilated model (once; later runs find it)", || {
        Simulator::with_registers(design, &sources)
    })?;
    Ok(Upsets::new(simulator, frames, &thresholds)?)
}

/// Returns the frames: strips from top to bottom of a picture, in steps of the design's camera.
fn strips(design: &DesignPoint, args: &Own, image: &Path) -> Result<Vec<Plane<u16>>> {
    let picture = open(image, &args.limit, MIN_SIDE as usize, None)?;
    let (rows, frames) = (args.rows as usize, args.frames as usize);
    let width = picture.luma.width().min(design.width as usize);
    let left = (picture.luma.width() - width) / 2;
    let Some(spare) = picture.luma.height().checked_sub(rows) else {
        bail!("{}: has {} rows, fewer than --rows {rows}", shown(image), picture.luma.height());
    };
    let strip = |i: usize| {
        let top = i * spare / (frames - 1);
        camera_samples(design, &Plane::from_fn(width, rows, |x, y| picture.luma[(left + x, top + y)]))
    };
    Ok((0..frames).map(strip).collect())
}

/// Builds any other core.
fn other(args: &Other, seed: u64) -> Result<Core> {
    let top = args.top.as_deref().ok_or_else(|| anyhow!("--top is missing"))?;
    let mut build = Build::new(top).sources(&args.source);
    for folder in &args.include {
        build = build.include(folder);
    }
    for text in &args.parameter {
        let (name, value) = pair("--parameter", text)?;
        build = build.parameter(name, Parameter::Verilog(value));
    }
    let stimulus = match &args.stimulus {
        Some(path) => Stimulus::Table(
            std::fs::read_to_string(path).with_context(|| format!("--stimulus {}: cannot be read", shown(path)))?,
        ),
        None => Stimulus::Random(seed),
    };
    let reset = args.reset.clone().map(|name| (name, false)).or(args.reset_low.clone().map(|name| (name, true)));
    let options = Options {
        clock: args.clock.clone(),
        reset,
        stimulus,
        constants: args.set.iter().map(|text| pair("--set", text)).collect::<Result<_>>()?,
        valid: args.valid.clone(),
        detect: args.detect.clone(),
        cycles: args.cycles,
        frame: args.frame_cycles,
    };
    spinning("building the Verilated model (once; later runs find it)", || Core::new(&build, &options))
        .map_err(|error| refusal(error, args))
}

/// Returns an error of a core in one line, with the argument that it is about.
fn refusal(error: CoreError, args: &Other) -> anyhow::Error {
    match (&error, &args.stimulus) {
        (CoreError::Table { .. }, Some(path)) => anyhow!("--stimulus {}: {error}", shown(path)),
        (CoreError::Build(BuildError::Verilog { diagnostics }), _) => match &diagnostics[..] {
            [first] => anyhow!("--source: {first}"),
            [first, rest @ ..] => anyhow!("--source: {first} (and {} more)", rest.len()),
            [] => anyhow!("--source: {error}"),
        },
        (CoreError::NoSuchPort { what, name, .. }, _) => anyhow!("{}: {error}", port_option(what, name, args)),
        _ => anyhow!("--source: {error}"),
    }
}

/// Returns the option that names a port of the core.
fn port_option(what: &str, name: &str, args: &Other) -> String {
    let is = |option: &Option<String>| option.as_deref() == Some(name);
    let named = [
        ("--valid", is(&args.valid)),
        ("--detect", what == "output" && args.detect.iter().any(|output| output == name)),
        ("--clock", is(&args.clock)),
        ("--reset", is(&args.reset)),
        ("--reset-low", is(&args.reset_low)),
        ("--set", args.set.iter().any(|text| text.split_once('=').is_some_and(|(input, _)| input == name))),
    ];
    match (named.iter().find(|(_, is)| *is), &args.stimulus) {
        (Some((option, _)), _) => (*option).to_owned(),
        (None, Some(path)) => format!("--stimulus {}", shown(path)),
        (None, None) => "--source".to_owned(),
    }
}

/// Splits `NAME=VALUE`.
fn pair(option: &str, text: &str) -> Result<(String, String)> {
    let (name, value) = text.split_once('=').ok_or_else(|| anyhow!("{option} {text}: is not NAME=VALUE"))?;
    Ok((name.to_owned(), value.to_owned()))
}

/// Draws the faults, makes the runs, and writes what came of them. `about` describes a run; `estimates` is the number
/// of its frames with an estimate, where runs have a cost.
fn report(
    args: &Args,
    about: &str,
    state: &State,
    window: std::ops::Range<u64>,
    cycles: u64,
    estimates: usize,
    run: impl Fn(&Fault) -> Result<(Class, Option<Cost>)> + Sync,
) -> Result<Verdict> {
    let state = state.clone().only(args.part.into(), &args.only);
    if state.bits() == 0 {
        let only = args.only.iter().map(|pattern| format!(" --only {pattern}")).collect::<String>();
        bail!("no register or memory to put a fault in{only}");
    }
    say(about);
    let kind = Kind::from(args.kind);
    let faults = draw(&state, window, kind, args.upsets as usize, args.seed);
    let progress = bar(faults.len() as u64, "{wide_bar} {pos} of {len} faults, {per_sec}, {eta} left");
    let lines = LogLines::new();
    let started = Instant::now();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let outcomes = campaign(&faults, threads, run, |done| {
        progress.set_position(done as u64);
        lines.count(&progress, "faults");
    })?;
    let seconds = started.elapsed().as_secs_f64();
    progress.finish_and_clear();
    let (classes, costs): (Vec<Class>, Vec<Option<Cost>>) = outcomes.into_iter().unzip();
    let costs: Vec<Cost> = costs.into_iter().flatten().collect();
    let cost = (!costs.is_empty()).then(|| Costs::new(&costs, estimates));
    let said: String = cost.iter().map(|cost| format!("\n{cost}\n")).collect();
    let rows = rows(&state, &faults, &classes);
    let by = match args.by {
        ByChoice::Module => (By::Module, "module"),
        ByChoice::Register => (By::Register, "register"),
    };
    let groups = groups(&state, &rows, by.0);
    let all = all(&state, &rows);
    let table = markdown(by.1, &groups, &all);
    if let Some(path) = &args.csv {
        write_file(path, &csv(&rows)?)?;
    }
    if let Some(path) = &args.table {
        let compared = match args.other.source.is_empty() {
            true => " Packets are compared, neither `irq` nor the register bus.",
            false => "",
        };
        let text = format!(
            "# What comes of {} faults\n\n{about}.{compared} Made by\n\n    {}\n\n{table}{said}",
            faults.len(),
            command()
        );
        write_file(path, text.as_bytes())?;
    }
    if args.json {
        let classes = Class::ALL.into_iter().map(|class| PerClass::new(class, &all.counts)).collect();
        print_json(&Report { kind, seed: args.seed, cycles, bits: all.bits, classes, groups, cost, seconds })?;
    } else {
        print(&aligned(&table))?;
        let share = |class: Class| format!("{} {}", class.name(), interval(all.counts.of(class), all.counts.total()));
        let shares = Class::ALL.map(share).join(", ");
        print(&format!("\n{shares}\n{said}{} faults in {seconds:.1} s\n", faults.len()))?;
    }
    Ok(Verdict::Pass)
}

/// A change of an estimate that counts, m.
const SHIFT_M: f64 = 0.01;

impl Costs {
    fn new(costs: &[Cost], estimates: usize) -> Self {
        Self {
            estimates,
            faults: costs.iter().filter(|cost| cost.withheld > 0 || cost.shift_m > SHIFT_M).count(),
            withheld: costs.iter().map(|cost| cost.withheld).sum(),
            shift_m: costs.iter().map(|cost| cost.shift_m).fold(0.0, f64::max),
            misleading: costs.iter().map(|cost| cost.misleading).sum(),
        }
    }
}

impl fmt::Display for Costs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { estimates, faults, withheld, shift_m, misleading } = self;
        write!(
            f,
            "flight program: {estimates} estimates a run; {faults} faults withhold one or move one by more than {} cm; \
             {withheld} withheld, moved by at most {:.1} cm, {misleading} beyond their protection level",
            100.0 * SHIFT_M,
            100.0 * shift_m
        )
    }
}

impl PerClass {
    fn new(class: Class, counts: &Counts) -> Self {
        let (faults, of) = (counts.of(class), counts.total());
        let (low, high) = wilson(faults, of);
        Self { class, faults, share: faults as f64 / of as f64, low, high }
    }
}

/// Returns the lines of a table with cells of one width in each column, without the line below the heading.
fn aligned(markdown: &str) -> String {
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().replace("**", "")).collect();
    let lines: Vec<Vec<String>> = markdown.lines().filter(|line| !line.starts_with("|---")).map(cells).collect();
    let columns = lines.first().map_or(0, Vec::len);
    let width = |at: usize| lines.iter().map(|line| line[at].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |line: &Vec<String>| {
        let padded = line.iter().zip(&widths).enumerate().map(|(at, (cell, width))| match at {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        padded.collect::<Vec<_>>().join("  ") + "\n"
    };
    lines.iter().map(line).collect()
}
