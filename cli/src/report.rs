//! `hoverlock report`: what quantisation costs on given pictures, and whether every bound holds.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_fixed_point::model::design::{DesignPoint, KT27};
use hoverlock_reference::image::picture::Picture;
use hoverlock_reports::hardware::Made;
use hoverlock_reports::output;
use hoverlock_reports::study::{self, BoundRow, LEAST_SIDE, Study, Subject};
use indicatif::{ProgressBar, ProgressStyle};

use crate::Verdict;
use crate::output::print;
use crate::picture::cropped;
use crate::rtl_level;

/// Measure what quantisation costs, stage by stage, and check it.
///
/// Writes index.html, report.json and junit.xml. Status 0 only where every bound holds on every picture under every condition. With
/// Verilator and Yosys at hand, `rtl` is the simulated hardware and what it takes of a device; else it is said to be not run.
///
/// Example: hoverlock report aerial.png --out out/report
#[derive(clap::Args)]
pub struct Args {
    /// Pictures of the ground: PNG, JPEG, TIFF, BMP, PNM or WebP, at least 79x79; the centre 1024x768 of larger ones
    #[arg(value_name = "IMAGE", required = true)]
    images: Vec<PathBuf>,
    /// The folder to write into
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    out: PathBuf,
    /// Change the design point: a TOML file, or one key like dog_bits=12 or state=u16.4
    #[arg(long, value_name = "FILE|KEY=VALUE")]
    config: Vec<String>,
    /// One JSON object on stdout, the same as report.json: pass provenance bounds[] levels[] pictures[] and more
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let design = configured(&args.config)?;
    // A design point without coefficients is refused before anything is written.
    Levels::new(&design)?;
    let subjects = subjects(&args.images)?;
    output::prepare(&args.out)?;
    let hardware = rtl_level::prepare(&design);
    // `rtl` adds a step for each picture, and one to wait for its tools.
    let bar = ProgressBar::new(study::steps(subjects.len()) + subjects.len() as u64 + 1);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}") {
        bar.set_style(style);
    }
    let step = |what: &str| {
        bar.set_message(what.to_owned());
        bar.inc(1);
    };
    let study = study::run(&subjects, &design, &command(), &step)?;
    let study = hardware.finish(study, &subjects, &step)?;
    bar.finish_and_clear();
    output::write(&study, &args.out)?;
    if let Some(Made::NotRun { reason }) = study.hardware().map(|hardware| &hardware.simulation) {
        eprintln!("hoverlock: rtl not run: {reason}");
    }
    for row in study.bounds.iter().filter(|row| !row.check.pass) {
        eprintln!("hoverlock: bound fails: {}", failure(row));
    }
    if args.json {
        print(&output::json(&study)?)?;
    } else {
        print(&summary(&study, &args.out))?;
    }
    Ok(study.pass.into())
}

/// The default design point, changed by files and by single keys in the order given.
fn configured(changes: &[String]) -> Result<DesignPoint> {
    let mut design = KT27;
    for change in changes {
        design = if change.contains('=') && !Path::new(change).exists() {
            design.with_override(change)?
        } else {
            let text = std::fs::read_to_string(change)
                .with_context(|| format!("{change}: the configuration cannot be read"))?;
            design.with_toml(&text).with_context(|| change.clone())?
        };
    }
    Ok(design)
}

/// Opens all pictures before any work begins, and gives each a name of its own.
fn subjects(paths: &[PathBuf]) -> Result<Vec<Subject>> {
    let mut names: BTreeMap<String, usize> = BTreeMap::new();
    let mut subjects = Vec::new();
    for path in paths {
        let picture = Picture::open(path)?.require(LEAST_SIDE, LEAST_SIDE)?;
        let frame = cropped(&picture);
        let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let seen = names.entry(stem.clone()).or_default();
        *seen += 1;
        let name = if *seen == 1 { stem } else { format!("{stem} ({seen})") };
        subjects.push(Subject { name, frame: frame.luma, picture: picture.luma });
    }
    Ok(subjects)
}

/// The command as typed, without the folder of the program.
fn command() -> String {
    let quoted = std::env::args().skip(1).map(|word| if word.contains(' ') { format!("'{word}'") } else { word });
    std::iter::once("hoverlock".to_owned()).chain(quoted).collect::<Vec<_>>().join(" ")
}

fn failure(row: &BoundRow) -> String {
    let check = &row.check;
    let picture = row.picture.as_deref().map(|name| format!("{name}, ")).unwrap_or_default();
    let condition = row.condition.map(|name| format!("{name}, ")).unwrap_or_default();
    format!(
        "{}: measured {:.4} {unit}, limit {} {unit} ({picture}{condition}{})",
        check.name,
        check.measured,
        check.limit,
        check.location,
        unit = check.unit
    )
}

fn summary(study: &Study, folder: &Path) -> String {
    let failed = study.bounds.iter().filter(|row| !row.check.pass).count();
    let verdict = if study.pass { "PASS" } else { "FAIL" };
    let held = study.bounds.len() - failed;
    format!(
        "{verdict}: {held} of {} checks hold on {} picture(s)\n{}\n",
        study.bounds.len(),
        study.pictures.len(),
        folder.join(output::PAGE).display()
    )
}
