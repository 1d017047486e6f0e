//! `hoverlock explore`: the cheapest design that passes every check of the report on given pictures.

mod mission;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use hoverlock_design::DesignPoint;
use hoverlock_explore::{Exploration, Objective, PartOutcome, Progress, Task, output, results};
use hoverlock_fixed_point::analysis::acceptance::rounding_beyond_bound;
use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_pictures::folder::expand;
use hoverlock_reports::output::PAGE;
use hoverlock_reports::provenance::sha256;
use hoverlock_reports::study::Unjudged;
use hoverlock_synthesis::smallest_device;
use indicatif::{ProgressBar, ProgressStyle};

use crate::Verdict;
use crate::design::Chosen;
use crate::output::{Batch, Folder, command, print, quoted, remove_earlier, say, shown, verdict};
use crate::picture::Limit;
use crate::progress::LogLines;
use crate::report::subjects;

/// Find the cheapest design that passes every check of the report, or that holds a helicopter within centimetres.
///
/// Changes state, coefficients, DoG and look-ahead of a design together; frame, pixel and sigmas stay. Writes
/// index.html with the Pareto front of error against memory, explore.json, points.csv, and the best design as
/// best.toml, which --design of the other verbs takes. A stopped search is continued. Status 0 only if a
/// design passes every check on every picture.
///
/// With --objective hover designs are judged by simulated flights over --scenes, as by hoverlock hover, and the pixel
/// is changed too. The cheapest design is sought (M10K, then DSP blocks, then ALM) that stays within --budget-cm on
/// every flight, without an estimate beyond its protection level and without a loss of vision. At least twenty of
/// these flights have seeds that chose no design. The page shows centimetres against memory, and which bound binds:
/// that of the flights, or the checks of the report. Status 0 only if a design keeps the budget.
///
/// Examples:
///   hoverlock explore aerial.png --budget 300
///   hoverlock explore --objective hover --budget-cm 10 --scenes field,helipad-in-mist,town --seed 2
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Pictures of the ground, or folders of them; - reads one from standard input. As for the report. None for hover
    #[arg(value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// The quantity that the best design has least of
    #[arg(long, value_enum, default_value = "m10k")]
    objective: Choice,
    /// Stop after this time, seconds; what was measured stays for the next search. By default 600, and 3600 for hover
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    budget: Option<u64>,
    #[command(flatten)]
    mission: mission::MissionArgs,
    /// The folder to write into. By default out/explore, and out/explore-hover for hover
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    chosen: Chosen,
    #[command(flatten)]
    limit: Limit,
    /// One JSON object on stdout, the same as explore.json: pass decided best base pareto[] points[] of name design
    /// m10k alm dsp fits status pass margin
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Choice {
    /// Block memories
    M10k,
    /// Adaptive logic modules, by a fit to Yosys estimates
    Alm,
    /// DSP blocks
    Dsp,
    /// The DoG error, among the designs that fit the smallest device
    Error,
    /// Block memories, among the designs whose flights keep --budget-cm
    Hover,
}

impl Choice {
    /// Returns what a search on pictures minimises; `None` for flights.
    fn objective(self) -> Option<Objective> {
        match self {
            Self::M10k => Some(Objective::M10k),
            Self::Alm => Some(Objective::Alm),
            Self::Dsp => Some(Objective::Dsp),
            Self::Error => Some(Objective::Error),
            Self::Hover => None,
        }
    }
}

impl Args {
    /// Returns the folder of this search. A search by flights and one on pictures have different files.
    fn out(&self) -> PathBuf {
        let default = || if self.objective.objective().is_some() { "out/explore" } else { "out/explore-hover" };
        self.out.clone().unwrap_or_else(|| default().into())
    }
}

/// Time of a search on pictures, s.
const BUDGET_S: u64 = 600;

/// File name of the results of earlier searches.
const RESULTS: &str = "results.jsonl";

pub fn run(args: &Args) -> Result<Verdict> {
    let Some(objective) = args.objective.objective() else { return mission::run(args) };
    args.mission.refuse()?;
    if args.images.is_empty() {
        bail!("explore: a picture is missing; name one, or give --objective hover with --budget-cm");
    }
    let design = args.chosen.design()?.of_hardware();
    Levels::new(&design)?;
    design.check_buildable()?;
    let (subjects, unfit) = subjects(&expand(&args.images)?, &design, &args.limit)?;
    let out = args.out();
    let folder = Folder::of(&out, "explore", &[&Files::NAMES[..], &[RESULTS]].concat())?;
    let path = out.join(RESULTS);
    let known = results::read(&path)?;
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos} of {len} designs  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    let started = Instant::now();
    let lines = LogLines::new();
    let report = |progress: &Progress| {
        let best = progress.best.as_ref().map(|(name, m10k)| format!("best {name}, {m10k} M10K; ")).unwrap_or_default();
        bar.set_length(progress.designs as u64);
        bar.set_position(progress.settled as u64);
        bar.set_message(format!("{best}{}", progress.step));
        lines.say(&bar, || {
            format!("{} of {} designs settled; {best}{}", progress.settled, progress.designs, progress.step)
        });
    };
    let mut keep = |key: &str, outcome: &PartOutcome| Ok(results::append(&path, key, outcome)?);
    let task = Task {
        base: &design,
        subjects: &subjects,
        objective,
        deadline: started + Duration::from_secs(args.budget.unwrap_or(BUDGET_S)),
        device: smallest_device(),
        unbuildable: &unbuildable,
        build: &build()?,
    };
    let found = hoverlock_explore::run::<anyhow::Error>(&task, &known, &mut keep, &report);
    bar.finish_and_clear();
    let mut found = found.map_err(|error| match error.downcast::<Unjudged>() {
        Ok(Unjudged(others)) => {
            // Nothing that was measured is of use, unless an earlier search of other pictures wrote it.
            if known.is_empty() {
                let _ = fs::remove_file(&path);
            }
            Unjudged(unfit.iter().cloned().chain(others).collect()).into()
        }
        Err(error) => error,
    })?;
    found.unfit.extend(unfit);
    found.unfit.iter().for_each(|unfit| say(&unfit.to_string()));
    if !found.pass {
        rounding_beyond_bound(&design, Bounds::acceptance()).iter().for_each(|line| say(line));
    }
    let command = command();
    let files = Files {
        page: output::html(&found, &command)?,
        json: output::json(&found, &command).context("the search cannot be written as JSON")?,
        csv: output::csv(&found),
        best: output::best(&found, &command),
    };
    let restored =
        format!("{} of {} results are from {}", found.restored, found.restored + found.measured, shown(&path));
    publish(args, folder, &files, (found.restored > 0).then_some(restored), || {
        summary(&found, &out, started.elapsed())
    })?;
    Ok(found.pass.into())
}

/// Returns the version of this program, whose results can be reused: the SHA-256 of the executable, whatever its commit
/// says. The link is that of this process, so a program that was replaced meanwhile is not read.
fn build() -> Result<String> {
    const PROGRAM: &str = "/proc/self/exe";
    let bytes = fs::read(PROGRAM).with_context(|| format!("{PROGRAM}: this program cannot be read; mount /proc"))?;
    Ok(sha256(bytes))
}

/// Returns why a design cannot be built; `None` if it can.
fn unbuildable(design: &DesignPoint) -> Option<String> {
    design.check_buildable().err().map(|error| error.to_string())
}

/// The content of the files of a search.
struct Files {
    page: String,
    json: String,
    csv: String,
    /// The best design; `None` if no design passes.
    best: Option<String>,
}

impl Files {
    /// The names of all files of a search but its results.
    const NAMES: [&str; 4] = [PAGE, output::NUMBERS, output::TABLE, output::BEST];

    /// Returns the content of each file, in the order of [`Files::NAMES`]; `None` if it is not to be there.
    fn contents(&self) -> [Option<&str>; 4] {
        [Some(&self.page), Some(&self.json), Some(&self.csv), self.best.as_deref()]
    }
}

/// Writes the files and prints the result. `restored` says how many results are those of an earlier search.
fn publish(
    args: &Args,
    folder: Folder,
    files: &Files,
    restored: Option<String>,
    summary: impl FnOnce() -> String,
) -> Result<()> {
    write(&args.out(), files)?;
    drop(folder);
    restored.iter().for_each(|text| say(text));
    if args.json { print(&files.json) } else { print(&summary()) }
}

/// Writes all files, or none. Then the best design of an earlier search is removed if this one has none.
fn write(out: &Path, files: &Files) -> Result<()> {
    let mut batch = Batch::default();
    let mut gone = Vec::new();
    for (name, content) in Files::NAMES.iter().zip(files.contents()) {
        match content {
            Some(text) => batch.add(&out.join(name), text.as_bytes())?,
            None => gone.push(out.join(name)),
        }
    }
    batch.keep()?;
    gone.iter().try_for_each(|path| remove_earlier(path))
}

fn summary(found: &Exploration, out: &Path, time: Duration) -> String {
    let result = match (found.best(), found.base()) {
        (Some(best), Some(base)) => {
            let worst = best.worst.as_ref().map(|worst| format!("{} ({})", worst.check, worst.place));
            format!(
                "{}: {} M10K, {} DSP blocks, about {} ALM; the base has {}, {} and {}\n  \
                 {:.0} % of the allowance left: {}\n",
                verdict(true, &best.name),
                best.resources.m10k,
                best.resources.dsp,
                best.resources.alm,
                base.resources.m10k,
                base.resources.dsp,
                base.resources.alm,
                best.margin.unwrap_or_default(),
                worst.unwrap_or_default(),
            )
        }
        _ => verdict(false, "no design passes every check") + "\n",
    };
    let open =
        if found.decided { "" } else { "the time was up before the search was decided; the same command goes on\n" };
    let next = match found.best() {
        Some(_) => format!("next: hoverlock sim --design {} PICTURE..\n", quoted(&out.join(output::BEST))),
        None => String::new(),
    };
    format!(
        "{result}{open}{} results in {:.0} s, {} designs\n{}\n{next}",
        found.measured + found.restored,
        time.as_secs_f64(),
        found.points.len(),
        shown(&out.join(PAGE))
    )
}
