//! A campaign of hovers: the distance from the target against word lengths, and what each design costs in the FPGA.

use minijinja::context;
use serde::{Deserialize, Serialize};

use crate::page::{PageError, SCRIPT, STYLE, environment, value};
use crate::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, Series, VIOLET};
use crate::provenance::COMMIT;

const TEMPLATE: &str = include_str!("../templates/campaign.html");

/// Name of the design point without changes.
pub const DEFAULT: &str = "kt27";

/// A hover to be flown. The fields are the first columns of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Name or file of the scene.
    pub scene: String,
    /// Over the mean ground, m.
    pub height_m: f64,
    /// Root mean square of each horizontal component, m/s.
    pub gusts_m_s: f64,
    /// s.
    pub seconds: f64,
    /// Where features come from.
    pub features: String,
    /// [`DEFAULT`], or its changes.
    pub design: String,
    /// Hash of the numbers of scene and design, hex: a file that was changed since gives another point.
    pub inputs: String,
    /// Of wind, sensors, camera and scene.
    pub seed: u64,
}

/// A hover that has been flown: a row of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// As in [`Point`].
    pub scene: String,
    /// As in [`Point`].
    pub height_m: f64,
    /// As in [`Point`].
    pub gusts_m_s: f64,
    /// As in [`Point`].
    pub seconds: f64,
    /// As in [`Point`].
    pub features: String,
    /// As in [`Point`].
    pub design: String,
    /// As in [`Point`].
    pub inputs: String,
    /// As in [`Point`].
    pub seed: u64,
    /// Block memories of the design, by the memory model.
    pub m10k: u64,
    /// Its multipliers of 18 x 18.
    pub mul18: u64,
    /// Distance from the target, m.
    pub rms_m: f64,
    /// The largest, m.
    pub max_m: f64,
    /// The same of the helicopter that has its IMU only, rms, m.
    pub imu_only_rms_m: f64,
    /// Estimate less truth, rms, m; empty without an estimate.
    pub error_rms_m: Option<f64>,
    /// Frames.
    pub frames: usize,
    /// Frames without an estimate after the first that has one.
    pub lost: usize,
    /// Whether every check passes.
    pub pass: bool,
    /// Why not.
    pub reason: String,
}

impl Point {
    /// What tells it from others.
    pub fn key(&self) -> String {
        let Self { scene, height_m, gusts_m_s, seconds, features, design, inputs, seed } = self;
        format!("{scene}|{height_m}|{gusts_m_s}|{seconds}|{features}|{design}|{inputs}|{seed}")
    }
}

impl Finished {
    /// What was to be flown.
    pub fn point(&self) -> Point {
        Point {
            scene: self.scene.clone(),
            height_m: self.height_m,
            gusts_m_s: self.gusts_m_s,
            seconds: self.seconds,
            features: self.features.clone(),
            design: self.design.clone(),
            inputs: self.inputs.clone(),
            seed: self.seed,
        }
    }
}

/// A design over all its points.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Design {
    /// [`DEFAULT`], or its changes.
    pub name: String,
    /// Hovers flown.
    pub points: usize,
    /// Those that pass.
    pub passed: usize,
    /// Distance from the target over all of them, m.
    pub rms_m: f64,
    /// The largest rms of one, m.
    pub worst_m: f64,
    /// Estimate less truth over all of them, m; nothing without an estimate.
    pub error_rms_m: Option<f64>,
    /// Frames without an estimate.
    pub lost: usize,
    /// Block memories.
    pub m10k: u64,
    /// Multipliers of 18 x 18.
    pub mul18: u64,
    /// No design has less memory and an error that is not larger, or as much and a smaller one.
    pub pareto: bool,
}

/// The designs in the order in which they stand in the table.
pub fn designs(points: &[Finished]) -> Vec<Design> {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.design.as_str()) {
            names.push(&point.design);
        }
    }
    let mut designs: Vec<Design> = names.into_iter().map(|name| design(name, points)).collect();
    let costs: Vec<_> = designs.iter().map(|design| (design.m10k, design.error())).collect();
    for (i, design) in designs.iter_mut().enumerate() {
        let (m10k, error) = costs[i];
        design.pareto = !costs
            .iter()
            .any(|&(less, smaller)| (less <= m10k && smaller < error) || (less < m10k && smaller <= error));
    }
    designs
}

impl Design {
    /// What is compared with memory; a design that sees nothing is the worst.
    fn error(&self) -> f64 {
        self.error_rms_m.unwrap_or(f64::INFINITY)
    }
}

fn design(name: &str, points: &[Finished]) -> Design {
    let own: Vec<&Finished> = points.iter().filter(|point| point.design == name).collect();
    let rms =
        |values: Vec<f64>| (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt();
    let errors: Vec<f64> = own.iter().filter_map(|point| point.error_rms_m).collect();
    Design {
        name: name.to_owned(),
        points: own.len(),
        passed: own.iter().filter(|point| point.pass).count(),
        rms_m: rms(own.iter().map(|point| point.rms_m).collect()),
        worst_m: own.iter().map(|point| point.rms_m).fold(0.0, f64::max),
        error_rms_m: (!errors.is_empty()).then(|| rms(errors)),
        lost: own.iter().map(|point| point.lost).sum(),
        m10k: own.first().map_or(0, |point| point.m10k),
        mul18: own.first().map_or(0, |point| point.mul18),
        pareto: false,
    }
}

/// A row of the table of conditions.
#[derive(Serialize)]
struct Condition<'a> {
    scene: &'a str,
    height_m: f64,
    gusts_m_s: f64,
    points: usize,
    passed: usize,
    rms_m: f64,
    worst_m: f64,
    imu_only_m: f64,
}

/// The page as HTML, with style and plots inside it.
///
/// # Errors
/// A plot or the template fails. Either is a defect of this program, not of the input.
pub fn html(points: &[Finished], designs: &[Design], command: &str) -> Result<String, PageError> {
    let mut environment = environment();
    environment.add_template("campaign.html", TEMPLATE)?;
    let kt27: Vec<&Finished> = points.iter().filter(|point| point.design == DEFAULT).collect();
    let failed: Vec<&&Finished> = kt27.iter().filter(|point| !point.pass).collect();
    Ok(environment.get_template("campaign.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        commit => COMMIT,
        command => command,
        points => points.len(),
        flown => points.iter().map(|point| point.seconds).sum::<f64>() / 60.0,
        kt27 => kt27.len(),
        failed => value(failed.iter().map(|point| (**point).clone()).collect::<Vec<_>>()),
        designs => value(designs.to_vec()),
        conditions => value(conditions(&kt27)),
        front => front(designs)?,
        spread => spread(&kt27)?,
    })?)
}

/// Scenes, heights and gusts of the design point.
fn conditions<'a>(kt27: &[&'a Finished]) -> Vec<Condition<'a>> {
    let mut conditions: Vec<Condition<'a>> = Vec::new();
    for point in kt27 {
        let same = |c: &&mut Condition<'_>| {
            c.scene == point.scene && c.height_m == point.height_m && c.gusts_m_s == point.gusts_m_s
        };
        let condition = match conditions.iter_mut().find(same) {
            Some(known) => known,
            None => {
                conditions.push(Condition {
                    scene: &point.scene,
                    height_m: point.height_m,
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

/// Error of the estimate against memory; the designs that no other beats are joined.
fn front(designs: &[Design]) -> Result<String, PlotError> {
    let points = |pareto: bool| -> Vec<(f64, f64)> {
        let of = designs.iter().filter(|design| design.pareto == pareto);
        let mut points: Vec<_> =
            of.filter_map(|design| Some((design.m10k as f64, 100.0 * design.error_rms_m?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let chosen: Vec<_> = designs
        .iter()
        .filter(|design| design.name == DEFAULT)
        .filter_map(|design| Some((design.m10k as f64, 100.0 * design.error_rms_m?)))
        .collect();
    let all = || designs.iter().filter_map(|design| Some((design.m10k as f64, 100.0 * design.error_rms_m?)));
    let most = all().map(|point| point.1).fold(1.0, f64::max);
    let (low, high) =
        all().map(|point| point.0).fold((f64::MAX, 0.0), |(low, high): (f64, f64), v| (low.min(v), high.max(v)));
    let line = |name: &str, colour, mark, points| Series { name: name.into(), colour, mark, points };
    Chart {
        title: "Error of the estimate, cm, against memory".into(),
        size: (540, 330),
        x: Axis::linear("M10K, by the memory model", (low - 20.0).max(0.0), high + 20.0),
        y: Axis::linear("", 0.0, 1.15 * most),
        series: vec![
            line("beaten", GREY, Mark::Dots(4), points(false)),
            line("not beaten", BLUE, Mark::LineDots, points(true)),
            line(DEFAULT, GREEN, Mark::Ring(8), chosen),
        ],
        rules: Vec::new(),
    }
    .svg()
}

/// Every hover of the design point, scene by scene.
fn spread(kt27: &[&Finished]) -> Result<String, PlotError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(design: &str, seed: u64, m10k: u64, error: f64, pass: bool) -> Finished {
        Finished {
            scene: "field".into(),
            height_m: 50.0,
            gusts_m_s: 3.0,
            seconds: 10.0,
            features: "fixed".into(),
            design: design.into(),
            inputs: "0123abcd".into(),
            seed,
            m10k,
            mul18: 51,
            rms_m: 2.0 * error,
            max_m: 3.0 * error,
            imu_only_rms_m: 2.0,
            error_rms_m: Some(error),
            frames: 151,
            lost: 0,
            pass,
            reason: if pass { String::new() } else { "too far <away>".into() },
        }
    }

    #[test]
    fn the_front_has_the_designs_that_none_beats() {
        let points = [
            finished("kt27", 1, 437, 0.02, true),
            finished("dog_bits=10", 1, 420, 0.05, true),
            finished("state=u16.4", 1, 460, 0.03, true),
            finished("state=u16.1", 1, 425, 0.02, false),
        ];
        let pareto: Vec<bool> = designs(&points).iter().map(|design| design.pareto).collect();
        assert_eq!(pareto, [false, true, false, true]);
    }

    #[test]
    fn a_design_is_told_over_its_points() {
        let points = [finished("kt27", 1, 437, 0.03, true), finished("kt27", 2, 437, 0.04, false)];
        let [design] = &designs(&points)[..] else { panic!() };
        assert_eq!((design.points, design.passed, design.worst_m), (2, 1, 0.08));
        assert!((design.error_rms_m.unwrap() - (0.00125f64).sqrt()).abs() < 1e-12);
        let page = html(&points, &designs(&points), "hoverlock sweep").unwrap();
        assert!(page.contains("too far &lt;away&gt;") && page.contains("1 of 2"));
    }
}
