//! `hoverlock formal`: claims about Verilog, proved for all inputs.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use anyhow::{Context, Result, anyhow, bail};
use clap::{ValueEnum, ValueHint};
use hoverlock_design::{DesignPoint, KT27, Protection, smoother_names};
use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::stages::StageCoefficients;
use hoverlock_formal::claim::{Assumption, Claim};
use hoverlock_formal::composition::{Composition, assumption_line};
use hoverlock_formal::engine::Solver;
use hoverlock_formal::prove::{Outcome, Place, Status, Task, run as prove};
use hoverlock_formal::rounding::{self, Subject};
use hoverlock_formal::shape::Shape;
use hoverlock_formal::shipped;
use hoverlock_rtl::emission::{
    parameters::{Variant, modules, variants},
    verilog::verilog,
};
use hoverlock_rtl::registers::registers;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use self::coverage::Drawing;
use crate::Verdict;
use crate::choice::between;
use crate::design::{emitted, verilog_of};
use crate::output::{prepare_target, print, print_json, say, shown, verdict, write_file};
use crate::progress::LogLines;

mod coverage;
mod second;

/// Prove claims about the emitted Verilog, or about any Verilog with properties.
///
/// Each claim has covers, which show that it is not vacuous, and mutants: faults put into the Verilog that its proof
/// must detect. A claim that fails leaves the waveform of the violation, and a test in
/// Rust that replays it, in the folder of --out. Status 0 only if every
/// proof passes, every cover is reached and, with --mutants, every mutant fails.
///
/// With --coverage faults are drawn by chance. Status 0 only if each is harmless, makes
/// the proof fail, or is in a numbered hole of its claim.
///
/// Examples:
///   hoverlock formal
///   hoverlock formal record_fifo --mutants
///   hoverlock formal rounding saturation
///   hoverlock formal --coverage record_fifo --mutations 50 --seed 7
///   hoverlock formal --design three_scales
///   hoverlock formal sequencer csr --solver z3
///   hoverlock formal --source my_fifo.v --properties my_fifo.sv --depth 12
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Claims; all if none is named
    #[arg(value_name = "NAME", conflicts_with = "source")]
    names: Vec<String>,
    /// Put each claim's faults into the Verilog as well: its proof must fail
    #[arg(long, conflicts_with = "source")]
    mutants: bool,
    /// Draw mutations of the modules under these claims and count those that the proof detects; `all` for every claim
    #[arg(long, value_name = "CLAIM", num_args = 1.., conflicts_with_all = ["names", "mutants"])]
    coverage: Vec<String>,
    #[command(flatten)]
    drawing: Drawing,
    /// Verilog files of your own, with --properties
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "properties", value_hint = ValueHint::FilePath)]
    source: Vec<PathBuf>,
    /// A module over them with assert, assume and cover, for Yosys' read_verilog -formal -sv
    #[arg(long, value_name = "FILE", requires = "source", value_hint = ValueHint::FilePath)]
    properties: Option<PathBuf>,
    /// Steps of the induction and of the covers, for --source
    #[arg(
        long,
        value_name = "K",
        default_value = "20",
        requires = "source",
        value_parser = clap::value_parser!(u32).range(1..=1000)
    )]
    depth: u32,
    /// Prove --source for --depth steps from the initial state only, without induction
    #[arg(long, requires = "source")]
    bounded: bool,
    /// The design whose Verilog claims are about: kt27, hd1080, small, three_scales, or a design file with all keys
    #[arg(long, value_name = "NAME|FILE", conflicts_with_all = ["source", "mutants", "table"])]
    design: Option<OsString>,
    /// The folder of the Verilog that claims are about, in place of the emitted one
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath, conflicts_with = "source")]
    rtl: Option<PathBuf>,
    /// Time limit of one solver query, seconds
    #[arg(long, value_name = "T", default_value = "600", value_parser = between(1.0, 86_400.0))]
    limit: f64,
    /// The solver. With --table another one than yices adds its times beside those of yices
    #[arg(long, value_enum, default_value = "yices", conflicts_with = "coverage")]
    solver: SolverName,
    /// The folder for waveforms of violations
    #[arg(long, value_name = "DIR", default_value = "out/formal", value_hint = ValueHint::DirPath)]
    out: PathBuf,
    /// Write claims and results into this file, as Markdown
    #[arg(long, value_name = "FILE", conflicts_with = "source", value_hint = ValueHint::FilePath)]
    table: Option<PathBuf>,
    /// One JSON object on stdout: results[] of name status pass seconds processor_seconds memory_mib detail trace
    /// replay steps, not_stated[], proved failed
    #[arg(long)]
    json: bool,
}

/// Names of the solvers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SolverName {
    Yices,
    Z3,
}

impl From<SolverName> for Solver {
    fn from(name: SolverName) -> Self {
        match name {
            SolverName::Yices => Self::Yices,
            SolverName::Z3 => Self::Z3,
        }
    }
}

/// The JSON object of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    results: &'a [Outcome],
    /// Claims that are not stated for this Verilog.
    not_stated: Vec<&'a str>,
    /// Number of proofs that pass.
    proved: usize,
    /// Number of proofs, covers and mutants that do not pass.
    failed: usize,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let target = |file: &PathBuf| {
        earlier(file)?;
        prepare_target("--table", file, &["md"], &[])
    };
    let _folder = args.table.as_ref().map(target).transpose()?;
    if !args.coverage.is_empty() {
        return coverage::run(args);
    }
    let (mut claims, subjects) = claims(args)?;
    let sources = sources(args)?;
    let not_stated = take_not_stated(args, &mut claims, &sources)?;
    if claims.is_empty() && subjects.is_empty() {
        bail!(nothing_left(&not_stated));
    }
    let mut tasks: Vec<(&Claim, Task)> = Vec::new();
    for claim in &claims {
        tasks.push((claim, Task::Proof));
        tasks.push((claim, Task::Cover));
        if args.mutants {
            tasks.extend((0..claim.mutants.len()).map(|at| (claim, Task::Mutant(at))));
        }
    }
    let (limit, solver) = (Duration::from_secs_f64(args.limit), args.solver.into());
    let place = Place { sources: &sources, out: &args.out, limit, solver };
    // Whether there are covers is known once Yosys has read the properties.
    let outcome = |(claim, task): &(&Claim, Task)| match prove(claim, *task, &place) {
        Err(error) if error.is_without_covers() => Ok(None),
        result => Ok(Some(result?)),
    };
    let named = |outcome: &Option<Outcome>| outcome.as_ref().map_or(String::new(), |outcome| outcome.name.clone());
    let outcomes = all(&tasks, outcome, named)?;
    let (mut finished, mut results) = (Vec::new(), Vec::new());
    for ((claim, task), outcome) in tasks.into_iter().zip(outcomes) {
        match outcome {
            Some(outcome) => {
                finished.push((claim, task));
                results.push(outcome);
            }
            None => say(&format!("{}: no covers, so no run of interest may be possible: add a cover", claim.name)),
        }
    }
    let tasks = finished;
    let design = rounding_design(&KT27)?;
    let mut answers = Vec::new();
    for &subject in &subjects {
        let faults = if args.mutants { subject.faults().len() } else { 0 };
        for task in [Task::Proof, Task::Cover].into_iter().chain((0..faults).map(Task::Mutant)) {
            answers.push((subject, task));
            results.push(rounding::run(&design, subject, task, solver, &args.out)?);
        }
    }
    let failed = results.iter().filter(|outcome| !outcome.pass).count();
    let proved = results.iter().filter(|o| matches!(o.status, Status::Proved | Status::Bounded)).count();
    let done = || tasks.iter().map(|(_, task)| task).chain(answers.iter().map(|(_, task)| task));
    let covers = done().filter(|task| matches!(task, Task::Cover)).count();
    let mutants = done().filter(|task| matches!(task, Task::Mutant(_))).count();
    if let (Some(file), true) = (&args.table, solver != Solver::Yices) {
        let again = Place { solver: Solver::Yices, ..place };
        let proofs: Vec<&Claim> = claims.iter().collect();
        let mut proofs = all(&proofs, |claim| Ok(prove(claim, Task::Proof, &again)?), |outcome| outcome.name.clone())?;
        for &subject in &subjects {
            proofs.push(rounding::run(&design, subject, Task::Proof, Solver::Yices, &args.out)?);
        }
        let known = shipped::claims()?;
        let names: Vec<&str> =
            known.iter().map(|claim| claim.name.as_str()).chain(Subject::ALL.map(Subject::name)).collect();
        second::enter(file, &names, &proofs, &results, args.limit)?;
    } else if let Some(file) = &args.table {
        let mut rows: Vec<Row> = claims.iter().map(Row::of_claim).collect();
        rows.extend(subjects.iter().map(|&subject| Row::of_subject(subject)));
        let done = tasks.iter().map(|(claim, task)| (claim.name.as_str(), *task));
        let done: Vec<_> = done.chain(answers.iter().map(|(subject, task)| (subject.name(), *task))).collect();
        let mut text = table(&rows, &done, &results);
        if args.names.is_empty() && args.design.is_none() {
            text += &format!("\n## Composition\n\n{}", Composition::shipped()?.markdown());
        }
        if subjects.contains(&Subject::Rounding) {
            text += &format!("\n## Worst-case errors\n\n{}", rounding_table(&design)?);
        }
        let before = earlier(file)?;
        text += second::section_of(&before);
        text += coverage::section_of(&before);
        write_file(file, text.as_bytes())?;
    }
    if args.json {
        let not_stated = not_stated.iter().map(|left| left.name.as_str()).collect();
        print_json(&Report { results: &results, not_stated, proved, failed })?;
    } else {
        for outcome in &results {
            print(&line(outcome))?;
        }
        for NotStated { name, reason } in &not_stated {
            print(&format!("{name:<28} not stated for this Verilog: {reason}\n"))?;
        }
        let summary = match results.iter().find(|outcome| !outcome.pass) {
            Some(first) => format!("{failed} of {} fail, the first: {}", results.len(), first.name),
            None if args.mutants => {
                format!("{proved} proofs pass, {covers} covers are reached, {mutants} mutants fail")
            }
            None => format!("{proved} proofs pass, {covers} covers are reached"),
        };
        print(&(verdict(failed == 0, &summary) + "\n"))?;
    }
    Ok((failed == 0).into())
}

/// Returns the design that claims are about.
fn design(args: &Args) -> Result<DesignPoint> {
    args.design.as_deref().map_or_else(|| Ok(KT27.clone()), |name| DesignPoint::load(name).context("--design"))
}

/// Returns the numbers of the design that claims refer to.
fn shape(design: &DesignPoint) -> Result<Shape> {
    let registers = registers(design)?;
    let resets = registers.iter().filter(|register| register.reset() != 0);
    let read =
        |path: &PathBuf| std::fs::read_to_string(path).with_context(|| format!("{}: cannot be read", shown(path)));
    emitted(design)?;
    let texts: Vec<String> = verilog(design, None)?.iter().map(read).collect::<Result<_>>()?;
    let texts = texts.iter().flat_map(|text| modules(text)).collect();
    let numbers = |variant: Variant| {
        let numbers =
            variant.parameters.iter().map(|(_, number)| u32::try_from(*number)).collect::<Result<Vec<_>, _>>();
        Ok((variant.module, numbers?))
    };
    let of_parameters = variants(&texts, "hoverlock_top").into_iter().filter(|variant| !variant.parameters.is_empty());
    Ok(Shape {
        width: design.width,
        pixel_bits: design.pixel.bits(),
        state_bits: design.state.bits(),
        coefficient_bits: design.coefficient.bits(),
        dog_shift: u32::try_from(design.dog_shift())?,
        dog_bits: design.dog_bits,
        coefficients: design.look_ahead.iter().map(|stages| stages + 1).sum(),
        smoothers: smoother_names(design.smoothers()).iter().map(|&name| name.to_owned()).collect(),
        look_ahead: design.look_ahead.clone(),
        ring_radii: design.ring_radii.clone(),
        candidate_queue: design.candidate_queue,
        record_fifo: design.record_fifo,
        resets: resets.map(|register| (register.offset / 4, register.reset())).collect(),
        variants: of_parameters.map(numbers).collect::<Result<_>>()?,
    })
}

/// A claim that is not stated for a Verilog.
struct NotStated {
    name: String,
    reason: String,
}

/// Returns the refusal of a run whose claims are all left out: a verdict would be about nothing.
fn nothing_left(left: &[NotStated]) -> String {
    let left: Vec<String> = left.iter().map(|NotStated { name, reason }| format!("{name}: {reason}")).collect();
    format!("no claim is stated for this Verilog: {}", left.join("; "))
}

/// Takes out the claims that are not stated for this Verilog, and returns them: those for the default design
/// only if the text is another one, those about a module that the design does not have, or has with parity bits, and
/// those about a file beside the folder that is not there.
fn take_not_stated(args: &Args, claims: &mut Vec<Claim>, sources: &Path) -> Result<Vec<NotStated>> {
    let originals = verilog(&KT27, None)?;
    let code = |path: &Path| {
        let text = std::fs::read_to_string(path).ok()?;
        Some(text.lines().filter(|line| !line.trim_start().starts_with("//")).map(str::to_owned).collect::<Vec<_>>())
    };
    let is_same = |file: &String| {
        let original = originals.iter().find(|path| path.ends_with(file));
        original.is_some_and(|original| code(original).is_some() && code(original) == code(&sources.join(file)))
    };
    let may_lack = |file: &String| args.design.is_some() || file.starts_with("../");
    let is_missing = |file: &&String| may_lack(file) && !sources.join(file).is_file();
    let is_protected = design(args)?.protection != Protection::Off;
    let reason = |claim: &Claim| {
        if is_protected && !shipped::is_for_protected_designs(claim) {
            return Some("its modules have parity bits, which the claim does not state".to_owned());
        }
        if let Some(file) = claim.sources.iter().find(is_missing) {
            return Some(format!("there is no {}", shown(&sources.join(file))));
        }
        let is_about_design = args.design.is_none() || shipped::is_for_any_design(claim);
        let is_stated = is_about_design || claim.sources.iter().all(is_same);
        (!is_stated).then(|| "the claim is about the text of kt27".to_owned())
    };
    let mut left = Vec::new();
    claims.retain(|claim| {
        let reason = reason(claim);
        let is_stated = reason.is_none();
        left.extend(reason.map(|reason| NotStated { name: claim.name.clone(), reason }));
        is_stated
    });
    Ok(left)
}

/// Returns the folder of the Verilog that claims are about.
fn sources(args: &Args) -> Result<PathBuf> {
    if let Some(folder) = &args.rtl {
        return Ok(folder.clone());
    }
    if !args.source.is_empty() {
        return Ok(PathBuf::new());
    }
    let files = verilog_of(&design(args)?, None)?;
    Ok(files.first().and_then(|file| file.parent()).map(Path::to_owned).unwrap_or_default())
}

/// Returns the numbers of a design that the claims about rounding refer to.
fn rounding_design(design: &DesignPoint) -> Result<rounding::Design> {
    let smoother = |of: &StageCoefficients<u32>| rounding::Smoother { g: of.g, g_j: of.g_j.clone() };
    Ok(rounding::Design {
        smoothers: BitTrue::new(design)?.coefficients().iter().map(smoother).collect(),
        coefficient_bits: design.coefficient.bits(),
        full_scale: u32::try_from(design.pixel.max_raw())? << design.state.fraction_bits(),
        dog_shift: u32::try_from(design.dog_shift())?,
        dog_bits: design.dog_bits,
    })
}

/// Returns the results that a file of --table has; empty if there is none.
///
/// # Errors
/// If the file cannot be read, or is not text: what it has would be lost.
fn earlier(file: &Path) -> Result<String> {
    match std::fs::read_to_string(file) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(String::new()),
        read => read.with_context(|| format!("--table {}: its results cannot be kept; name another file", shown(file))),
    }
}

/// Returns the rows of a section of the results by the claims that they begin with.
fn rows_of(section: &str) -> BTreeMap<String, String> {
    let claim = |row: &str| row.strip_prefix("| `")?.split_once('`').map(|(name, _)| name.to_owned());
    section.lines().filter_map(|row| Some((claim(row)?, row.to_owned()))).collect()
}

/// Returns a table of the proved bounds beside the largest errors measured.
fn rounding_table(design: &rounding::Design) -> Result<String> {
    #[derive(serde::Deserialize)]
    struct Measured {
        scale: usize,
        whole_frame_max: f64,
    }
    let (mut largest, mut frames) = (vec![0.0f64; design.smoothers.len() - 1], 0);
    for row in csv::Reader::from_reader(Bounds::CALIBRATION.as_bytes()).deserialize() {
        let Measured { scale, whole_frame_max } = row?;
        let of = largest.get_mut(scale).context("calibration.csv: a scale pair that the design has not")?;
        *of = of.max(whole_frame_max.abs());
        frames += usize::from(scale == 0);
    }
    let of = format!(
        "the largest over {frames} frames of `fixed_point/calibration.csv`, whole frames, against the unrounded \
         coefficients; so it includes the error that rounded coefficients make, which the proved bound does not"
    );
    Ok(rounding::table(design, &largest, &of))
}

/// Returns the claim of the user's files, which has the name of the file with the properties.
fn own_claim(args: &Args, properties: &Path) -> Result<Claim> {
    let text = std::fs::read_to_string(properties)
        .with_context(|| format!("--properties {}: cannot be read", shown(properties)))?;
    let mut sources = Vec::new();
    for file in &args.source {
        if file.is_dir() {
            bail!("--source {}: is a folder; name its Verilog files", shown(file));
        }
        if !file.is_file() {
            bail!("--source {}: no such file", shown(file));
        }
        let file = std::path::absolute(file).context("--source")?;
        sources.push(file.to_str().ok_or_else(|| anyhow!("--source {}: not UTF-8", shown(&file)))?.to_owned());
    }
    let name = properties.file_stem().map_or("properties".into(), |stem| stem.to_string_lossy().into_owned());
    let own = Claim {
        name,
        sources,
        properties: text,
        depth: args.depth,
        cover: args.depth,
        bounded: args.bounded,
        ..Claim::default()
    };
    Ok(own)
}

/// Returns the claims that were named, or those of the user's files.
fn claims(args: &Args) -> Result<(Vec<Claim>, Vec<Subject>)> {
    if let Some(properties) = &args.properties {
        return Ok((vec![own_claim(args, properties)?], Vec::new()));
    }
    let mut claims = shipped::claims_of(&shape(&design(args)?)?)?;
    // The claims about the numbers of a design do not concern a folder of Verilog, and are those of the default design.
    let mut subjects = if args.rtl.is_none() && args.design.is_none() { Subject::ALL.to_vec() } else { Vec::new() };
    for name in &args.names {
        let mut known = claims.iter().map(|claim| claim.name.as_str()).chain(subjects.iter().map(|of| of.name()));
        if !known.any(|known| known == name) {
            let subjects = subjects.iter().map(|of| of.name());
            let known: Vec<&str> = claims.iter().map(|claim| claim.name.as_str()).chain(subjects).collect();
            bail!("{name}: no such claim; they are {}", known.join(", "));
        }
    }
    let asked = |name: &str| args.names.is_empty() || args.names.iter().any(|asked| asked == name);
    claims.retain(|claim| asked(&claim.name));
    subjects.retain(|subject| asked(subject.name()));
    Ok((claims, subjects))
}

/// Runs all tasks on all cores and returns their results in order. `done` describes a result in the progress bar.
fn all<T: Sync, R: Send>(
    tasks: &[T],
    run: impl Fn(&T) -> Result<R> + Sync,
    done: impl Fn(&R) -> String + Sync,
) -> Result<Vec<R>> {
    let bar = ProgressBar::new(tasks.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {pos} of {len}  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    let lines = LogLines::new();
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    let work = || -> Result<()> {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(task) = tasks.get(at) else { return Ok(()) };
            let result = run(task)?;
            bar.set_message(done(&result));
            bar.inc(1);
            lines.count(&bar, "proofs");
            results.lock().map_err(|_| anyhow!("another proof has panicked"))?.push((at, result));
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores.min(tasks.len())).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| anyhow!("a proof has panicked"))?)
    })?;
    bar.finish_and_clear();
    let mut results = results.into_inner().map_err(|_| anyhow!("a proof has panicked"))?;
    results.sort_by_key(|(at, _)| *at);
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

/// What the table says of a claim beside its results.
struct Row<'a> {
    name: &'a str,
    statement: &'a str,
    assumed: Vec<Assumption>,
    /// How it is proved.
    how: String,
}

impl<'a> Row<'a> {
    fn of_claim(claim: &'a Claim) -> Self {
        let how = match claim.bounded {
            false => format!("induction, k = {}", claim.depth),
            true => format!("{} steps from reset", claim.depth),
        };
        Self { name: &claim.name, statement: &claim.statement, assumed: claim.assumed.clone(), how }
    }

    fn of_subject(subject: Subject) -> Self {
        let how = "linear arithmetic".into();
        Self { name: subject.name(), statement: subject.statement(), assumed: subject.assumed(), how }
    }
}

/// Returns claims and results as Markdown.
fn table(rows: &[Row], done: &[(&str, Task)], results: &[Outcome]) -> String {
    let head = "claim | proof | time, s | memory, MiB | covers | mutants that fail";
    let mut text = format!(
        "<!-- Written by `hoverlock formal --mutants --table formal/RESULTS.md`. Do not edit. -->\n\n\
         # What is proved\n\nProved with Yices.\n\n| {head} |\n|{}\n",
        "---|".repeat(6)
    );
    for row in rows {
        let (mut proof, mut cover, mut faults, mut seen) = (String::new(), "", 0, 0);
        for ((_, task), outcome) in done.iter().zip(results).filter(|((of, _), _)| *of == row.name) {
            match task {
                Task::Proof => {
                    let how = match outcome.status {
                        Status::Proved | Status::Bounded => row.how.clone(),
                        status => format!("**{}**", name_of(status)),
                    };
                    proof = format!("{how} | {:.1} | {:.0}", outcome.seconds, outcome.memory_mib);
                }
                Task::Cover => cover = if outcome.pass { "reached" } else { "**not reached**" },
                Task::Mutant(_) => {
                    faults += 1;
                    seen += usize::from(outcome.pass);
                }
            }
        }
        text += &format!("| `{}` | {proof} | {cover} | {seen} of {faults} |\n", row.name);
    }
    text += "\n## Statements\n\n";
    for row in rows {
        text += &format!("- **`{}`** {}\n", row.name, row.statement);
        for assumed in &row.assumed {
            text += &format!("  Assumed: {}.\n", assumption_line(assumed));
        }
    }
    text
}

fn name_of(status: Status) -> String {
    format!("{status:?}").to_lowercase()
}

/// Describes a result in one line, with its steps and traces below.
fn line(outcome: &Outcome) -> String {
    let Outcome { name, status, pass, seconds, memory_mib, detail, trace, replay, steps, .. } = outcome;
    let status = name_of(*status);
    let mark = if *pass { "" } else { "FAIL " };
    let trace = trace.as_ref().map_or(String::new(), |path| format!("  {}", shown(path)));
    let steps: String = steps.iter().map(|step| format!("    {step}\n")).collect();
    let replay = replay.as_ref().map_or(String::new(), |path| format!("    replayed by {}\n", shown(path)));
    format!("{name:<28} {mark}{status:<9} {seconds:6.1} s {memory_mib:5.0} MiB  {detail}{trace}\n{steps}{replay}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_and_registers_of_the_default_design_have_the_numbers_of_its_verilog() {
        let shape = shape(&KT27).unwrap();
        assert_eq!((shape.variants, shape.resets), (Shape::kt27().variants, Shape::kt27().resets));
    }
}
