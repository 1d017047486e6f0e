//! `hoverlock sweep`: a campaign of hovers, seeds x scenes x heights x views x gusts x designs.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use hoverlock_cosim::campaign::random::RandomSettings;
use hoverlock_cosim::campaign::{Campaign, CampaignProgress, CampaignSettings, Cluster, DesignStatistics, Place};
use hoverlock_cosim::{BoxError, CampaignOutcome};
use hoverlock_reports::output::PAGE;
use hoverlock_reports::provenance::COMMIT;

use crate::Verdict;
use crate::choice::{Features, View, between};
use crate::output::{Folder, command, print, print_json, say, shown, verdict, write_file};
use crate::progress::{LogLines, Reporter, bar};
use crate::random_sweep;

/// Fly a campaign over seeds, scenes, heights, views, gusts and word lengths, or over flights that are drawn at random.
///
/// Writes results.csv, one row a point, and index.html: the distance from the target against word lengths, and which
/// designs no other beats in both error and memory. A stopped campaign is continued. Status 0 only if every
/// point of kt27 and of each --design passes its checks; points of a --config are for comparison.
///
/// With --random ground, weather, errors of the camera and faults of each flight are drawn from --seed. It writes
/// flights.csv, one row a flight, a scenario file for each, and index.html: errors against protection levels. Status 0
/// only if no error exceeds the protection level of its estimate.
///
/// Examples:
///   hoverlock sweep --seeds 20 --scene field,town,helipad-in-mist --seconds 60
///   hoverlock sweep --config dog_bits=10 --config state=u16.0,coefficient=u0.8
///   hoverlock sweep --dask tcp://cluster:8786
///   hoverlock sweep --random 300 --seed 7
///   hoverlock sweep --random 300 --seed 7 --shrink 42
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = include_str!("../help/sweep.txt"))]
pub struct Args {
    /// Scenes of the simulator, or scene files
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',', default_value = "field,town,helipad-in-mist")]
    scene: Vec<String>,
    /// Seeds, from 1 on
    #[arg(long, value_name = "N", default_value = "2", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    seeds: u64,
    /// Gusts, m/s rms
    #[arg(long, value_name = "V", value_delimiter = ',', default_value = "3", value_parser = between(0.0, 5.0))]
    gusts: Vec<f64>,
    /// Heights over the mean ground, m: 10 to 300
    #[arg(long, value_name = "M", value_delimiter = ',', default_value = "50", value_parser = between(10.0, 300.0))]
    height: Vec<f64>,
    /// Fields of view of the camera
    #[arg(long, value_name = "VIEW", value_enum, value_delimiter = ',', default_value = "wide")]
    view: Vec<View>,
    /// Further designs beside kt27, which must pass too: their names or design files
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    design: Vec<String>,
    /// A further design for comparison, as changes of kt27: dog_bits=12 or state=u16.0,coefficient=u0.8
    #[arg(long, value_name = "CHANGES")]
    config: Vec<String>,
    /// Fly this number of random flights
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000),
          conflicts_with_all = ["scene", "seeds", "gusts", "height", "view", "design", "config", "dask"])]
    random: Option<u32>,
    /// Seed of the random flights
    #[arg(long, value_name = "S", default_value = "1", requires = "random")]
    seed: u64,
    /// Remove ingredients of this random flight as long as it fails, and write the scenario file of what remains
    #[arg(long, value_name = "NUMBER", requires = "random", conflicts_with = "table",
          value_parser = clap::value_parser!(u32).range(1..))]
    shrink: Option<u32>,
    /// The table of random flights, which the campaign continues, if not flights.csv in the folder of --out
    #[arg(long, value_name = "FILE", requires = "random")]
    table: Option<PathBuf>,
    /// Duration of each hover, seconds; by default 10, and 20 for random flights
    #[arg(long, value_name = "T", value_parser = between(1.0, 3600.0))]
    seconds: Option<f64>,
    /// Where features come from
    #[arg(long, value_enum, default_value = "fixed")]
    features: Features,
    /// The scheduler of a Dask cluster; without it this machine flies them
    #[arg(long, value_name = "ADDRESS")]
    dask: Option<String>,
    /// The folder for index.html and results.csv
    #[arg(long, value_name = "DIR", default_value = "out/sweep")]
    out: PathBuf,
    /// One JSON object on stdout: pass checked[] points[] pareto[]; of random flights pass totals flights[]; with
    /// --shrink the row of the flight that remains
    #[arg(long)]
    json: bool,
}

/// Duration of a hover, s.
const SECONDS: f64 = 10.0;
/// Duration of a random flight, s.
const RANDOM_SECONDS: f64 = 20.0;
/// File name of the table.
const TABLE: &str = "results.csv";
/// Environment variable that names the Python interpreter.
const PYTHON: &str = "HOVERLOCK_PYTHON";

pub fn run(args: &Args) -> Result<Verdict> {
    if let Some(flights) = args.random {
        let seconds = args.seconds.unwrap_or(RANDOM_SECONDS);
        let settings = RandomSettings { seed: args.seed, flights, seconds, features: args.features.into() };
        return match args.shrink {
            Some(number) if number > flights => {
                bail!("--shrink {number}: --random gives {flights} flights; give it at least {number}")
            }
            Some(number) => random_sweep::run_shrink(&settings, number, &args.out, args.json),
            None => random_sweep::run(&settings, args.table.as_deref(), &args.out, args.json),
        };
    }
    let campaign = Campaign::new(&CampaignSettings {
        scenes: args.scene.clone(),
        seeds: args.seeds,
        gusts_m_s: args.gusts.clone(),
        heights_m: args.height.clone(),
        views: args.view.iter().map(|view| (*view).into()).collect(),
        designs: args.design.clone(),
        variants: args.config.clone(),
        seconds: args.seconds.unwrap_or(SECONDS),
        features: args.features.into(),
    })?;
    let folder = Folder::of(&args.out, "sweep", &[PAGE, TABLE])?;
    let table = args.out.join(TABLE);
    let bar = bar(0, "{bar:32} {pos} of {len}  {elapsed}  {msg}");
    let lines = LogLines::new();
    let mut progress = |progress: CampaignProgress<'_>| -> Result<(), BoxError> {
        match progress {
            CampaignProgress::Started { known, points } => {
                if known > 0 {
                    say(&format!("{known} of {points} points are in {}", shown(&table)));
                }
                bar.set_length((points - known) as u64);
            }
            CampaignProgress::Flown(point) => {
                bar.set_message(format!("{} {}: {:.3} m", point.scene, point.design, point.rms_m));
                bar.inc(1);
                lines.count(&bar, "points");
            }
        }
        Ok(())
    };
    let outcome = campaign.run(&table, &place(args), &Reporter, &mut progress)?;
    bar.finish_and_clear();
    write_file(&args.out.join(PAGE), outcome.page(&command())?.as_bytes())?;
    drop(folder);
    remark_on_commits(outcome.of_other_commits(), outcome.points.len(), "--out");
    if args.json {
        print_json(&outcome)?;
    } else {
        print(&text(&outcome, &args.out))?;
    }
    Ok(outcome.pass.into())
}

/// Says how many of the rows that count were flown by another program. `option` names where the rows are.
pub fn remark_on_commits(others: usize, rows: usize, option: &str) {
    if others > 0 {
        say(&format!(
            "{others} of {rows} rows were flown by another commit than that of this program, {COMMIT}; another \
             {option} flies them again"
        ));
    }
}

/// Returns where the points are flown.
fn place(args: &Args) -> Place {
    match &args.dask {
        None => Place::Local,
        Some(scheduler) => Place::Cluster(Cluster {
            scheduler: scheduler.clone(),
            python: std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into()),
        }),
    }
}

/// Describes a campaign: a table of its designs, and the verdict.
fn text(outcome: &CampaignOutcome, out: &Path) -> String {
    let mut text = format!(
        "{:<36} {:>7} {:>9} {:>9} {:>9} {:>6} {:>6}\n",
        "design", "points", "rms, m", "worst, m", "error, m", "M10K", "pass"
    );
    text.extend(outcome.designs.iter().map(row));
    text += &format!("{}\n{}\n", shown(&out.join(PAGE)), shown(&out.join(TABLE)));
    let reason = match outcome.failures().next() {
        Some(first) => format!(
            "{} points of {} fail, the first: {} {} seed {} at {} m: {}",
            outcome.failures().count(),
            outcome.checked.join(", "),
            first.design,
            first.scene,
            first.seed,
            first.height_m,
            first.reason
        ),
        None => {
            let checked = outcome.points.iter().filter(|point| outcome.checked.contains(&point.design)).count();
            format!("{checked} points of {}; {} in all", outcome.checked.join(", "), outcome.points.len())
        }
    };
    text + &verdict(outcome.pass, &reason) + "\n"
}

fn row(design: &DesignStatistics) -> String {
    let error = design.error_rms_m.map_or("-".to_owned(), |error| format!("{error:.3}"));
    format!(
        "{:<36} {:>7} {:>9.3} {:>9.3} {:>9} {:>6} {:>6}{}\n",
        design.name,
        design.points,
        design.rms_m,
        design.worst_m,
        error,
        design.m10k,
        design.passed,
        if design.pareto { "  not beaten" } else { "" }
    )
}
