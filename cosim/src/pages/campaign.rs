//! The page of a campaign: the distance from the target against word lengths, and the FPGA resources of each design.

use minijinja::context;
use serde::Serialize;

use hoverlock_reports::page::{PageError, SCRIPT, STYLE, environment, value};
use hoverlock_reports::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, Series, VIOLET};
use hoverlock_reports::provenance::COMMIT;

use super::flown_by;
use crate::campaign::{CampaignOutcome, DEFAULT_DESIGN, DesignStatistics, FlownPoint};
use crate::hover::CameraView;

const TEMPLATE: &str = include_str!("../../templates/campaign.html");

/// A row of the table of conditions.
#[derive(Serialize)]
struct Condition<'a> {
    scene: &'a str,
    height_m: f64,
    view: CameraView,
    gusts_m_s: f64,
    points: usize,
    passed: usize,
    rms_m: f64,
    worst_m: f64,
    imu_only_m: f64,
}

impl CampaignOutcome {
    /// Renders the campaign as one HTML page. `command` is shown as its origin.
    ///
    /// # Errors
    /// A plot or the template fails. Either is a defect of this program, not of the input.
    pub fn page(&self, command: &str) -> Result<String, PageError> {
        html(self, command)
    }
}

/// Renders the page as HTML, with style and plots inside it.
fn html(outcome: &CampaignOutcome, command: &str) -> Result<String, PageError> {
    let CampaignOutcome { points, designs, .. } = outcome;
    let mut environment = environment();
    environment.add_template("campaign.html", TEMPLATE)?;
    let kt27: Vec<&FlownPoint> = points.iter().filter(|point| point.design == DEFAULT_DESIGN).collect();
    let is_checked = |point: &&FlownPoint| outcome.checked.contains(&point.design);
    let failed: Vec<&FlownPoint> = outcome.failures().collect();
    Ok(environment.get_template("campaign.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        commit => COMMIT,
        command => command,
        commits => flown_by(points.iter().map(|point| point.commit.as_str())),
        points => points.len(),
        flown => points.iter().map(|point| point.seconds).sum::<f64>() / 60.0,
        checked => points.iter().filter(is_checked).count(),
        checked_designs => outcome.checked.join(", "),
        failed => value(failed),
        designs => value(designs.to_vec()),
        conditions => value(conditions(&kt27)),
        front => front(designs)?,
        spread => spread(&kt27)?,
    })?)
}

/// Returns one row for each scene, height, view and gusts at the default design.
fn conditions<'a>(kt27: &[&'a FlownPoint]) -> Vec<Condition<'a>> {
    let mut conditions: Vec<Condition<'a>> = Vec::new();
    for point in kt27 {
        let same = |c: &&mut Condition<'_>| {
            let views = c.height_m == point.height_m && c.view == point.view;
            c.scene == point.scene && views && c.gusts_m_s == point.gusts_m_s
        };
        let condition = match conditions.iter_mut().find(same) {
            Some(known) => known,
            None => {
                conditions.push(Condition {
                    scene: &point.scene,
                    height_m: point.height_m,
                    view: point.view,
                    gusts_m_s: point.gusts_m_s,
                    points: 0,
                    passed: 0,
                    rms_m: 0.0,
                    worst_m: 0.0,
                    imu_only_m: 0.0,
                });
                let last = conditions.len() - 1;
                &mut conditions[last]
            }
        };
        condition.points += 1;
        condition.passed += usize::from(point.pass);
        // Sums of squares until all points are in.
        condition.rms_m += point.rms_m.powi(2);
        condition.imu_only_m += point.imu_only_rms_m.powi(2);
        condition.worst_m = condition.worst_m.max(point.rms_m);
    }
    for condition in &mut conditions {
        let mean = |sum: f64| (sum / condition.points as f64).sqrt();
        (condition.rms_m, condition.imu_only_m) = (mean(condition.rms_m), mean(condition.imu_only_m));
    }
    conditions
}

/// Plots the error of the estimate against memory, and joins the designs on the Pareto front.
fn front(designs: &[DesignStatistics]) -> Result<String, PlotError> {
    let points = |pareto: bool| -> Vec<(f64, f64)> {
        let of = designs.iter().filter(|design| design.pareto == pareto);
        let mut points: Vec<_> =
            of.filter_map(|design| Some((design.m10k as f64, 100.0 * design.error_rms_m?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let chosen: Vec<_> = designs
        .iter()
        .filter(|design| design.name == DEFAULT_DESIGN)
        .filter_map(|design| Some((design.m10k as f64, 100.0 * design.error_rms_m?)))
        .collect();
    let all = || designs.iter().filter_map(|design| Some((design.m10k as f64, 100.0 * design.error_rms_m?)));
    let most = all().map(|point| point.1).fold(1.0, f64::max);
    let (low, high) =
        all().map(|point| point.0).fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), v| (low.min(v), high.max(v)));
    let line = |name: &str, colour, mark, points| Series { name: name.into(), colour, mark, points };
    Chart {
        title: "Error of the estimate, cm, against memory".into(),
        size: (540, 330),
        x: Axis::linear("M10K, by the memory model", (low - 20.0).max(0.0), high + 20.0),
        y: Axis::linear("", 0.0, 1.15 * most),
        series: vec![
            line("beaten", GREY, Mark::Dots(4), points(false)),
            line("not beaten", BLUE, Mark::LineDots, points(true)),
            line(DEFAULT_DESIGN, GREEN, Mark::Ring(8), chosen),
        ],
        rules: Vec::new(),
    }
    .svg()
}

/// Plots every hover of the default design, scene by scene.
fn spread(kt27: &[&FlownPoint]) -> Result<String, PlotError> {
    let mut scenes: Vec<&str> = Vec::new();
    for point in kt27 {
        if !scenes.contains(&point.scene.as_str()) {
            scenes.push(&point.scene);
        }
    }
    let colours = [BLUE, ORANGE, GREEN, VIOLET, GREY];
    let most = kt27.iter().map(|point| 100.0 * point.rms_m).fold(1.0, f64::max);
    let seeds = kt27.iter().map(|point| point.seed).max().unwrap_or(1);
    let series = scenes.iter().zip(colours.into_iter().cycle()).map(|(scene, colour)| Series {
        name: (*scene).to_owned(),
        colour,
        mark: Mark::Dots(3),
        points: kt27
            .iter()
            .filter(|point| point.scene == **scene)
            .map(|point| (point.seed as f64, 100.0 * point.rms_m))
            .collect(),
    });
    Chart {
        title: "Distance from the target, cm rms, of each hover of kt27".into(),
        size: (540, 330),
        x: Axis::linear("seed", 0.0, seeds as f64 + 1.0),
        y: Axis::linear("", 0.0, 1.15 * most),
        series: series.collect(),
        rules: Vec::new(),
    }
    .svg()
}
