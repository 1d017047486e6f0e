//! `hoverlock report`: the errors of quantisation on given pictures, and the checks of their bounds.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_pictures::PictureError;
use hoverlock_pictures::folder::expand;
use hoverlock_reports::baseline::{self, Baseline, Kind};
use hoverlock_reports::hardware::StepResult;
use hoverlock_reports::output;
use hoverlock_reports::study::{self, BoundRow, Commands, LowContrast, MIN_SIDE, Study, Subject, Unfit, Unjudged};
use indicatif::{ProgressBar, ProgressStyle};

use crate::Verdict;
use crate::design::Chosen;
use crate::interrupt::end_descendants;
use crate::output::{Batch, Folder, command, print, quoted, remove_earlier, say, shown, verdict};
use crate::picture::{Limit, open};
use crate::progress::LogLines;
use crate::rtl_level;

/// Number of failed checks that are listed on stderr.
const MAX_LISTED_FAILURES: usize = 10;

/// Measure the errors of quantisation, stage by stage, and check them.
///
/// Writes index.html, report.json, checks.csv and junit.xml. Status 0 only if every check passes on every picture
/// under every condition. Where Verilator and Yosys are installed, `rtl` is the simulated hardware and what it takes of
/// a device; else the report says that it was not run.
///
/// Example: hoverlock report aerial.png --out out/report
#[derive(clap::Args)]
pub struct Args {
    /// Pictures of the ground: PNG, JPEG, TIFF, BMP, PNM or WebP, at least 79x79, or folders of them; - reads one from
    /// standard input. Of larger ones the centre is taken: 1024x768, or the width and height of the design
    #[arg(value_name = "IMAGE", required = true)]
    images: Vec<PathBuf>,
    /// The folder to write into
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    out: PathBuf,
    #[command(flatten)]
    chosen: Chosen,
    /// The report.json of an earlier report: writes baseline.html, which says what changed check by check. Status 1
    /// if a check that passed fails now or is gone
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    #[command(flatten)]
    limit: Limit,
    /// One JSON object on stdout, the same as report.json: pass provenance bounds[] levels[] pictures[] and more
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let design = args.chosen.design()?;
    // A design without valid coefficients is refused before anything is written.
    Levels::new(&design)?;
    let (subjects, unfit) = subjects(&expand(&args.images)?, &design, &args.limit)?;
    // The baseline is read first, because this report may replace its file.
    let baseline = args.baseline.as_deref().map(earlier).transpose()?;
    let files = [output::PAGE, output::NUMBERS, output::TABLE, output::TESTS, baseline::PAGE];
    let folder = Folder::of(&args.out, "report", &files)?;
    let hardware = rtl_level::prepare(&design.of_hardware());
    // `rtl` adds a step for each picture, and one to wait for its tools.
    let bar = ProgressBar::new(study::steps(subjects.len(), &design) + subjects.len() as u64 + 1);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    let lines = LogLines::new();
    let step = |what: &str| {
        bar.set_message(what.to_owned());
        bar.inc(1);
        lines.say(&bar, || format!("{} of {} steps; {what}", bar.position(), bar.length().unwrap_or_default()));
    };
    let commands = Commands { typed: &command(), changed: &|changes| args.with_changes(changes) };
    let mut study = study::run(&subjects, &design, &commands, &step)?;
    study.add_refused(unfit);
    if study.judges().is_empty() {
        bar.finish_and_clear();
        end_descendants();
        bail!(Unjudged(study.unfit));
    }
    let study = hardware.finish(study, &subjects, &step)?;
    bar.finish_and_clear();
    let compared = baseline.map(|baseline| baseline.compare(&study));
    let page = args.out.join(baseline::PAGE);
    let mut batch = Batch::default();
    for (name, content) in output::files(&study)? {
        batch.add(&args.out.join(name), content.as_bytes())?;
    }
    if let Some(compared) = &compared {
        batch.add(&page, baseline::html(compared)?.as_bytes())?;
    }
    batch.keep()?;
    if compared.is_none() {
        // That of an earlier report is about other numbers.
        remove_earlier(&page)?;
    }
    drop(folder);
    if let Some(hardware) = study.hardware() {
        let simulation = match &hardware.simulation {
            StepResult::NotRun { reason } => Some(reason),
            StepResult::Run { .. } => None,
        };
        if let Some(reason) = simulation {
            say(&format!("rtl not run: {reason}"));
        }
        // A reason that applies to both is reported once.
        match &hardware.estimate {
            StepResult::NotRun { reason } if simulation != Some(reason) => say(&format!("rtl not sized: {reason}")),
            _ => {}
        }
    }
    study.unfit.iter().for_each(|unfit| say(&unfit.to_string()));
    low_contrast(&study.low_contrast).iter().for_each(|line| say(line));
    study.beyond_bound().iter().for_each(|line| say(line));
    failures(&study, &args.out).iter().for_each(|line| say(line));
    if args.json {
        print(&output::json(&study)?)?;
    } else {
        print(&summary(&study, &args.out))?;
    }
    if let Some(compared) = &compared {
        let count = |kinds: &[Kind]| compared.changes.iter().filter(|change| kinds.contains(&change.kind)).count();
        let worse = count(&[Kind::Broken, Kind::Gone]);
        say(&format!(
            "against the baseline {worse} checks fail now or are gone, {} pass now, {} moved within their verdict, \
             {} are as before: {}",
            count(&[Kind::Mended]),
            compared.changes.len() - worse - count(&[Kind::Mended]),
            compared.same,
            shown(&page)
        ));
        if !compared.other_inputs.is_empty() {
            say(&format!(
                "the baseline has inputs of the same name and another content: {}; make it again from these pictures",
                compared.other_inputs.join("; ")
            ));
        }
    }
    Ok((study.pass && compared.is_none_or(|compared| compared.pass)).into())
}

/// Reads an earlier report.
fn earlier(path: &Path) -> Result<Baseline> {
    let name = path.display();
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--baseline {name}: cannot be read; name the report.json of a report"))?;
    Baseline::parse(&text).with_context(|| format!("--baseline {name}: not the report.json of a report"))
}

impl Args {
    /// Returns the command that makes this report with some changes of the design, in a folder of its own.
    fn with_changes(&self, changes: &[String]) -> String {
        let images: String = self.images.iter().map(|image| format!(" {}", quoted(image))).collect();
        let changed: String = changes.iter().map(|change| format!(" --config {}", quoted(Path::new(change)))).collect();
        let name = changes.join("_").replace(|char: char| !char.is_ascii_alphanumeric(), "_");
        // Without the slash at the end that a shell completes.
        let mut out = self.out.components().collect::<PathBuf>().into_os_string();
        out.push(format!("-{name}"));
        let (options, limit, out) = (self.chosen.options(), self.limit.option(), quoted(Path::new(&out)));
        format!("hoverlock report{images}{options}{changed}{limit} --out {out}")
    }
}

/// Opens all pictures before the measurement begins, crops each to the frame of the design, and gives it a unique name.
/// Of several pictures, those without contrast and those that are too small are returned as unfit; at least one is not.
pub fn subjects(paths: &[PathBuf], design: &DesignPoint, limit: &Limit) -> Result<(Vec<Subject>, Vec<Unfit>)> {
    let (width, height) = (design.width as usize, design.height as usize);
    if width < MIN_SIDE || height < MIN_SIDE {
        bail!(
            "width and height of the configuration: the report needs at least {MIN_SIDE} x {MIN_SIDE}, \
             not {width} x {height}"
        );
    }
    let mut names = BTreeSet::new();
    let (mut subjects, mut unfit) = (Vec::new(), Vec::new());
    for path in paths {
        let picture = match open(path, limit, MIN_SIDE, Some((width, height))) {
            Err(error) if paths.len() > 1 && is_unfit(&error) => {
                unfit.push(Unfit { picture: shown(path), condition: None, reason: reason(&error, path) });
                continue;
            }
            opened => opened?,
        };
        let frame = picture.crop(width, height);
        let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let mut name = stem.clone();
        for number in 2.. {
            if names.insert(name.clone()) {
                break;
            }
            name = format!("{stem} ({number})");
        }
        subjects.push(Subject { name, frame: frame.luma, picture: picture.luma });
    }
    if subjects.is_empty() {
        bail!(Unjudged(unfit));
    }
    Ok((subjects, unfit))
}

/// Returns `true` if the picture is a good file that no design can be judged by.
fn is_unfit(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<PictureError>();
    matches!(kind, Some(PictureError::NoContrast { .. } | PictureError::TooSmall { .. }))
}

/// Returns the message of an error without the path that it begins with.
fn reason(error: &anyhow::Error, path: &Path) -> String {
    let text = error.to_string();
    text.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&text).to_owned()
}

/// Returns which frames have too little contrast for some checks, in one line; `None` if none has.
fn low_contrast(frames: &[LowContrast]) -> Option<String> {
    let checks: usize = frames.iter().map(|of| of.checks.len()).sum();
    let places: Vec<String> =
        frames.iter().map(|of| format!("{}, {}, {:.0} LSB rms", of.picture, of.condition, of.rms_lsb)).collect();
    (checks > 0).then(|| {
        format!(
            "{checks} checks were left out where the contrast is below every class: {}; give pictures with more \
             contrast",
            places.join("; ")
        )
    })
}

/// Returns a line for each check that fails, the furthest beyond its limit first, and how many are left out.
fn failures(study: &Study, folder: &Path) -> Vec<String> {
    let failures = study.failures();
    let mut lines: Vec<String> =
        failures.iter().take(MAX_LISTED_FAILURES).map(|row| format!("bound fails: {}", failure(row))).collect();
    if failures.len() > lines.len() {
        let table = shown(&folder.join(output::TABLE));
        lines.push(format!("{} more bounds fail; {table} lists all", failures.len() - lines.len()));
    }
    lines
}

fn failure(row: &BoundRow) -> String {
    let check = &row.check;
    let picture = row.picture.as_deref().map(|name| format!("{name}, ")).unwrap_or_default();
    let condition = row.condition.map(|name| format!("{name}, ")).unwrap_or_default();
    let unit = if check.unit.is_empty() { String::new() } else { format!(" {}", check.unit) };
    format!(
        "{}: measured {:.4}{unit}, limit {}{unit} ({picture}{condition}{})",
        check.name, check.measured, check.limit, check.location
    )
}

fn summary(study: &Study, folder: &Path) -> String {
    let failed = study.bounds.iter().filter(|row| !row.check.pass).count();
    let verdict = verdict(study.pass, if study.pass { "PASS" } else { "FAIL" });
    let passed = study.bounds.len() - failed;
    let (judges, given) = (study.judges().len(), study.pictures_given);
    let pictures = if judges == given { given.to_string() } else { format!("{judges} of {given}") };
    format!(
        "{verdict}: {passed} of {} checks pass on {pictures} picture(s)\n{}\n",
        study.bounds.len(),
        shown(&folder.join(output::PAGE))
    )
}
