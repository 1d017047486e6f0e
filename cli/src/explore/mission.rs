//! `hoverlock explore --objective hover`: the cheapest design whose flights keep a budget of centimetres.

use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use hoverlock_cosim::hover::{MAX_LOSS_S, MAX_TILT_DEG, load_scene, scene_identity};
use hoverlock_cosim::{HoverSettings, hover};
use hoverlock_design::DesignPoint;
use hoverlock_edss::camera::{FIELD_OF_VIEW_RANGE_DEG, FRAME_SIZE};
use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::Renderer;
use hoverlock_edss::world::still;
use hoverlock_explore::mission::{
    Budget, Flight, FlightResult, Known, Measured, Mission, MissionProgress, MissionTask, Scene, output, run as search,
};
use hoverlock_explore::output::BEST;
use hoverlock_explore::results;
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_reference::motion::orthophoto::Attitude;
use hoverlock_reports::output::PAGE;
use hoverlock_reports::provenance::sha256;
use hoverlock_reports::study::Subject;
use hoverlock_synthesis::smallest_device;
use nalgebra::Vector3;

use super::{Files, RESULTS, build, publish, unbuildable};
use crate::Verdict;
use crate::choice::between;
use crate::output::{Folder, command, quoted, shown, verdict};
use crate::progress::{LogLines, bar};

/// The arguments of a search by flights.
#[derive(clap::Args)]
pub struct MissionArgs {
    /// Largest rms distance from the target of each flight, cm; for --objective hover
    #[arg(long, value_name = "CM", value_parser = between(0.1, 1000.0))]
    budget_cm: Option<f64>,
    /// Scenes of the simulator, or scene files; for --objective hover. By default field,helipad-in-mist,town
    #[arg(long, value_name = "NAME|FILE", value_delimiter = ',')]
    scenes: Vec<String>,
    /// First seed; the rounds of the search use those that follow; for --objective hover. By default 1
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u64).range(..=u64::MAX / 2))]
    seed: Option<u64>,
    /// Seeds of the round before the confirming flights, each over all scenes; for --objective hover. By default 2
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: Option<u64>,
    /// Duration of the longest flights, seconds; for --objective hover. By default 16
    #[arg(long, value_name = "T", value_parser = between(4.0, 3600.0))]
    seconds: Option<f64>,
}

impl MissionArgs {
    /// Refuses these arguments for an objective that flies nothing.
    pub fn refuse(&self) -> Result<()> {
        let given = [
            ("--budget-cm", self.budget_cm.is_some()),
            ("--scenes", !self.scenes.is_empty()),
            ("--seed", self.seed.is_some()),
            ("--seeds", self.seeds.is_some()),
            ("--seconds", self.seconds.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((option, _)) => bail!("{option}: only --objective hover flies, and takes it"),
            None => Ok(()),
        }
    }
}

/// The scenes of a search without `--scenes`.
const SCENES: [&str; 3] = ["field", "helipad-in-mist", "town"];
/// Number of seeds of the round before the confirming flights.
const SEEDS: u64 = 2;
/// Duration of the longest flights, s.
const SECONDS: f64 = 16.0;
/// Time of a search, s.
const BUDGET_S: u64 = 3600;
/// File name of the flights of earlier searches.
const FLIGHTS: &str = "flights.jsonl";

pub fn run(args: &super::Args) -> Result<Verdict> {
    let Some(budget_cm) = args.mission.budget_cm else {
        bail!("--objective hover: --budget-cm is missing, the largest rms distance from the target in centimetres");
    };
    if let Some(picture) = args.images.first() {
        bail!("{}: --objective hover flies over --scenes and takes no picture", shown(picture));
    }
    let design = args.chosen.design()?.of_hardware();
    Levels::new(&design)?;
    design.check_buildable()?;
    let (columns, rows) = FRAME_SIZE;
    if (design.width as usize) < columns || (design.height as usize) < rows {
        bail!(
            "the design takes {} x {} px at most, and the simulated camera's frames have {columns} x {rows}",
            design.width,
            design.height
        );
    }
    let seed = args.mission.seed.unwrap_or(1);
    let (scenes, subjects) = scenes(&args.mission.scenes, seed)?;
    let out = args.out();
    let folder = Folder::of(&out, "explore --objective hover", &[&Files::NAMES[..], &[FLIGHTS, RESULTS]].concat())?;
    let (flights, parts) = (out.join(FLIGHTS), out.join(RESULTS));
    let known = Known { flights: results::read(&flights)?, parts: results::read(&parts)? };
    let started = Instant::now();
    let bar = bar(0, "{spinner} {pos} flights  {elapsed}  {msg}");
    let lines = LogLines::new();
    let report = |progress: &MissionProgress| {
        let best = progress.best.as_ref().map(|(name, m10k)| format!("best {name}, {m10k} M10K; ")).unwrap_or_default();
        bar.set_position(progress.flights as u64);
        bar.set_message(format!("{best}{}", progress.step));
        lines.say(&bar, || format!("{} flights; {best}{}", progress.flights, progress.step));
    };
    let mut keep = |key: &str, measured: Measured<'_>| {
        match measured {
            Measured::Flight(flown) => results::append(&flights, key, flown)?,
            Measured::Part(outcome) => results::append(&parts, key, outcome)?,
        }
        Ok(())
    };
    let task = MissionTask {
        base: &design,
        budget: Budget { rms_m: budget_cm / 100.0, max_loss_s: MAX_LOSS_S, max_tilt_deg: MAX_TILT_DEG },
        scenes: &scenes,
        seed,
        seeds: args.mission.seeds.unwrap_or(SEEDS),
        seconds: args.mission.seconds.unwrap_or(SECONDS),
        subjects: &subjects,
        deadline: started + Duration::from_secs(args.budget.unwrap_or(BUDGET_S)),
        device: smallest_device(),
        unbuildable: &unbuildable,
        build: &build()?,
        fly: &fly,
    };
    let found = search::<anyhow::Error>(&task, &known, &mut keep, &report);
    bar.finish_and_clear();
    let found = found?;
    let command = command();
    let files = Files {
        page: output::html(&found, &command)?,
        json: output::json(&found, &command).context("the search cannot be written as JSON")?,
        csv: output::csv(&found),
        best: output::best(&found, &command),
    };
    let restored =
        format!("{} of {} flights are from {}", found.restored, found.restored + found.flown, shown(&flights));
    publish(args, folder, &files, (found.restored > 0).then_some(restored), || {
        summary(&found, &out, started.elapsed())
    })?;
    Ok(found.pass.into())
}

/// Loads the scenes, and takes a frame of each from the middle of its ground.
fn scenes(names: &[String], seed: u64) -> Result<(Vec<Scene>, Vec<Subject>)> {
    let given = if names.is_empty() { SCENES.map(str::to_owned).to_vec() } else { names.to_vec() };
    let mut names: Vec<String> = Vec::new();
    for name in given {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let (mut scenes, mut subjects) = (Vec::new(), Vec::new());
    // All scenes are loaded before the first is made, which takes longer.
    let loaded: Vec<_> = names.iter().map(|name| load_scene(name)).collect::<Result<_, _>>()?;
    for (name, scene) in names.into_iter().zip(loaded) {
        let renderer = Renderer::new(&scene, seed).with_context(|| format!("scene {name}"))?;
        let position = Vector3::new(0.0, 0.0, -HoverSettings::default().height_m);
        let pose = Pose { position, attitude: Attitude::default() };
        let frame = still(&renderer, &pose, FIELD_OF_VIEW_RANGE_DEG[1], seed)?;
        subjects.push(Subject { name: name.clone(), frame: frame.clone(), picture: frame });
        let hash = sha256(scene_identity(&scene)?);
        scenes.push(Scene { hash, name });
    }
    Ok((scenes, subjects))
}

/// Flies a design by the bit-true model.
fn fly(design: &DesignPoint, flight: &Flight) -> Result<FlightResult> {
    let settings = HoverSettings {
        scene: flight.scene.clone(),
        design: design.clone(),
        seconds: flight.seconds,
        seed: flight.seed,
        ..HoverSettings::default()
    };
    let flown = hover(&settings, &())?.summary;
    Ok(FlightResult {
        rms_m: flown.rms_m,
        error_rms_m: flown.error_rms_m,
        estimates: flown.estimates,
        misleading: flown.misleading,
        longest_loss_s: flown.longest_loss_s,
        tilt_max_deg: flown.tilt_max_deg,
    })
}

fn summary(found: &Mission, out: &Path, time: Duration) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = match (found.best(), found.base()) {
        (Some(best), Some(base)) => writeln!(
            text,
            "{}: {} M10K, {} DSP blocks, about {} ALM; the base has {}, {} and {}\n  \
             {} flights, at most {:.1} cm rms from the target; the base at most {:.1} cm",
            verdict(true, &best.name),
            best.resources.m10k,
            best.resources.dsp,
            best.resources.alm,
            base.resources.m10k,
            base.resources.dsp,
            base.resources.alm,
            best.flights,
            best.worst_cm.unwrap_or_default(),
            base.worst_cm.unwrap_or_default(),
        ),
        (_, base) => {
            let failure = base.and_then(|base| base.failure.clone()).unwrap_or_default();
            writeln!(text, "{}", verdict(false, &format!("the base design does not keep the budget: {failure}")))
        }
    };
    if let Some(binding) = found.binding_in_words() {
        let _ = writeln!(text, "  {binding}");
    }
    if !found.decided {
        text += "the time was up before the search was decided; the same command goes on\n";
    }
    let flights = found.flown + found.restored;

    let _ = writeln!(text, "{flights} flights in {:.0} s, {} designs", time.as_secs_f64(), found.points.len());
    let _ = writeln!(text, "{}", shown(&out.join(PAGE)));
    if found.best().is_some() {
        let _ = writeln!(text, "next: hoverlock sim --design {} PICTURE..", quoted(&out.join(BEST)));
    }
    text
}
