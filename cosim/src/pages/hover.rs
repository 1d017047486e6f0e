//! The page of a closed-loop hover: true and estimated track, errors, wind and attitude, and frames with their inliers.

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::Pair;
use minijinja::context;
use serde::Serialize;

use super::estimates::{Estimate, Run, Sample, describe};
use super::still::{Still, still};
use hoverlock_reports::embed;
use hoverlock_reports::page::{PageError, SCRIPT, STYLE, environment, value};
use hoverlock_reports::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, Rule, Series, VIOLET};
use hoverlock_reports::provenance::COMMIT;

const TEMPLATE: &str = include_str!("../../templates/hover.html");

/// The content of the page of a hover.
#[derive(Debug, Clone, Serialize)]
pub struct Hover {
    /// Name of the scene.
    pub scene: String,
    /// The settings: name and value.
    pub setup: Vec<(String, String)>,
    /// The source of the features.
    pub features: String,
    /// The place where the flight program ran.
    pub estimator: String,
    /// Why the hover fails; `None` if it passes.
    pub failure: Option<String>,
    /// The checks in words.
    pub checks: Vec<String>,
    /// Distance from the target: rms and largest, m.
    pub hold: [f64; 2],
    /// Distance of the helicopter with its IMU only: rms and largest, m.
    pub blind: [f64; 2],
    /// Rms of estimate less truth over both axes, m; `None` without an estimate.
    pub error: Option<f64>,
    /// Largest rms distance that passes, m.
    pub bound: Option<f64>,
    /// The frames in order.
    pub frames: Vec<Frame>,
    /// Frames to show with their inliers.
    #[serde(skip)]
    pub stills: Vec<Picture>,
    /// The hover as an animated PNG.
    #[serde(skip)]
    pub animation: Vec<u8>,
}

/// A frame of the page.
#[derive(Debug, Clone, Serialize)]
pub struct Frame {
    /// Time since the start, s.
    pub time: f64,
    /// True position along `X_e`, `Y_e` from the target, and height over the mean ground, m.
    pub truth: [f64; 3],
    /// Status in the line of the flight program.
    pub status: String,
    /// Why there is no estimate.
    pub reason: Option<String>,
    /// The estimate of the displacement.
    pub estimate: Option<Estimate>,
    /// Number of the reference frame.
    pub reference: Option<usize>,
    /// Number of features.
    pub features: usize,
    /// Wind along `X_e`, `Y_e` and down, m/s.
    pub wind: [f64; 3],
    /// Roll and pitch, degrees.
    pub tilt: [f64; 2],
    /// Field of view, degrees.
    pub field_of_view: f64,
    /// Distance of the helicopter without vision from its target, m.
    pub blind: f64,
}

impl Frame {
    /// Returns estimate less truth along `X_e` and `Y_e`, m.
    fn error(&self) -> Option<[f64; 2]> {
        let estimate = self.estimate?;
        Some([0, 1].map(|axis| estimate.displacement[axis] - self.truth[axis]))
    }

    fn distance(&self) -> f64 {
        self.truth[0].hypot(self.truth[1])
    }
}

/// A frame to show with its inliers.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Index of the frame among those of the [`Hover`].
    pub frame: usize,
    /// The pixels, reduced by `step`, DN.
    pub small: Plane<u16>,
    /// Pixels of the frame along one side of a pixel of `small`.
    pub step: usize,
    /// Inliers, px of the frame.
    pub inliers: Vec<Pair>,
}

/// Renders the page as HTML, with style, plots and pictures inside it.
///
/// # Errors
/// A plot or the template fails. Either is a defect of this program, not of the input.
pub fn html(hover: &Hover, command: &str) -> Result<String, PageError> {
    let mut environment = environment();
    environment.add_template("hover.html", TEMPLATE)?;
    let estimates = hover.frames.iter().filter(|frame| frame.estimate.is_some()).count();
    let mut references: Vec<_> = hover.frames.iter().filter_map(|frame| frame.reference).collect();
    references.dedup();
    let mut reasons: Vec<(String, usize)> = Vec::new();
    for reason in hover.frames.iter().filter_map(|frame| frame.reason.as_ref()) {
        // Reasons end with numbers in parentheses; the text before them is the kind of the reason.
        let kind = reason.split(" (").next();
        match reasons.iter_mut().find(|(known, _)| known.split(" (").next() == kind) {
            Some((_, count)) => *count += 1,
            None => reasons.push((reason.clone(), 1)),
        }
    }
    let stills =
        hover.stills.iter().map(|picture| draw_still(hover, picture)).collect::<Result<Vec<_>, PlotError>>()?;
    let run = run(hover);
    Ok(environment.get_template("hover.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        commit => COMMIT,
        command => command,
        hover => value(hover),
        seconds => hover.frames.last().map_or(0.0, |frame| frame.time),
        estimates => estimates,
        references => references.len(),
        reasons => reasons,
        animation => (!hover.animation.is_empty()).then(|| embed::address("image/png", &hover.animation)),
        track => track(hover)?,
        distance => distance(hover)?,
        errors => [run.error(0)?, run.error(1)?],
        others => [wind(hover)?, tilt(hover)?, height(hover)?, view(hover)?],
        quality => [run.quality()?, run.inliers(Some(renewals(hover)))?],
        stills => value(stills),
    })?)
}

fn draw_still(hover: &Hover, picture: &Picture) -> Result<Still, PlotError> {
    let frame = &hover.frames[picture.frame];
    let description = describe(frame.estimate.as_ref(), frame.reason.as_deref(), &frame.status);
    let name = format!("{:.1} s", frame.time);
    let inliers = if frame.estimate.is_some() { &picture.inliers[..] } else { &[] };
    still(&name, &picture.small, picture.step, inliers, format!("{name}: {description}"))
}

fn line(name: &str, colour: hoverlock_reports::colour::Rgb, mark: Mark, points: Vec<(f64, f64)>) -> Series {
    Series { name: name.into(), colour, mark, points }
}

/// Returns one value of each frame that has it, over time.
fn over_time(hover: &Hover, value: impl Fn(&Frame) -> Option<f64>) -> Vec<(f64, f64)> {
    hover.frames.iter().filter_map(|frame| Some((frame.time, value(frame)?))).collect()
}

fn time(hover: &Hover) -> Axis {
    Axis::linear("time, s", 0.0, hover.frames.last().map_or(1.0, |frame| frame.time).max(1.0))
}

fn chart(hover: &Hover, title: &str, y: Axis, series: Vec<Series>, rules: Vec<Rule>) -> Result<String, PlotError> {
    Chart { title: title.into(), size: (540, 270), x: time(hover), y, series, rules }.svg()
}

/// Plots the track from above, the top of the reference picture up.
fn track(hover: &Hover) -> Result<String, PlotError> {
    let above = |place: &[f64]| (place[0], -place[1]);
    let truths: Vec<_> = hover.frames.iter().map(|frame| above(&frame.truth)).collect();
    let estimates: Vec<_> =
        hover.frames.iter().filter_map(|frame| Some(above(&frame.estimate?.displacement))).collect();
    let half = 1.15 * truths.iter().chain(&estimates).map(|(x, y)| x.abs().max(y.abs())).fold(0.05, f64::max);
    Chart {
        title: "Track over the ground".into(),
        size: (540, 560),
        x: Axis::linear("X_e, m", -half, half),
        y: Axis::linear("\u{2212}Y_e, m", -half, half),
        series: vec![
            line("estimate", BLUE, Mark::Dots(1), estimates),
            line("true", ORANGE, Mark::Line, truths),
            line("target", GREEN, Mark::Ring(7), vec![(0.0, 0.0)]),
        ],
        rules: Vec::new(),
    }
    .svg()
}

/// Plots the distance from the target with and without vision on a logarithmic axis.
fn distance(hover: &Hover) -> Result<String, PlotError> {
    let with = over_time(hover, |frame| Some(frame.distance().max(1e-3)));
    let without = over_time(hover, |frame| Some(frame.blind.max(1e-3)));
    let most = with.iter().chain(&without).map(|(_, v)| *v).fold(1.0, f64::max);
    let rules = hover.bound.iter().map(|bound| Rule::Limit(*bound, format!("{bound} m rms"))).collect();
    let series = vec![line("IMU only", GREY, Mark::Line, without), line("with vision", ORANGE, Mark::Line, with)];
    chart(hover, "Distance from the target, m", Axis::log("", 0.003, 1.3 * most), series, rules)
}

fn wind(hover: &Hover) -> Result<String, PlotError> {
    let along = |axis: usize| over_time(hover, |frame| Some(frame.wind[axis]));
    let most = (0..3).flat_map(along).map(|(_, v)| v.abs()).fold(1.0, f64::max);
    let series = vec![
        line("X_e", BLUE, Mark::Line, along(0)),
        line("Y_e", ORANGE, Mark::Line, along(1)),
        line("down", GREY, Mark::Line, along(2)),
    ];
    chart(hover, "Wind, m/s", Axis::linear("", -1.1 * most, 1.1 * most), series, Vec::new())
}

fn tilt(hover: &Hover) -> Result<String, PlotError> {
    let of = |axis: usize| over_time(hover, |frame| Some(frame.tilt[axis]));
    let most = (0..2).flat_map(of).map(|(_, v)| v.abs()).fold(5.0, f64::max);
    let series = vec![line("roll", BLUE, Mark::Line, of(0)), line("pitch", ORANGE, Mark::Line, of(1))];
    let rules = vec![Rule::Limit(5.0, "5 degrees".into()), Rule::Limit(-5.0, String::new())];
    chart(hover, "Tilt of the camera, degrees", Axis::linear("", -1.2 * most, 1.2 * most), series, rules)
}

fn height(hover: &Hover) -> Result<String, PlotError> {
    let height = over_time(hover, |frame| Some(frame.truth[2]));
    let (low, high) =
        height.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, v)| (low.min(*v), high.max(*v)));
    let series = vec![line("", ORANGE, Mark::Line, height)];
    chart(hover, "Height over the mean ground, m", Axis::linear("", low - 1.0, high + 1.0), series, Vec::new())
}

fn view(hover: &Hover) -> Result<String, PlotError> {
    let series = vec![line("", VIOLET, Mark::Line, over_time(hover, |frame| Some(frame.field_of_view)))];
    chart(hover, "Field of view, degrees", Axis::linear("", 0.0, 55.0), series, Vec::new())
}

/// Returns the frames for the plots over time.
fn run(hover: &Hover) -> Run<'_> {
    fn sample(frame: &Frame) -> Sample<'_> {
        Sample {
            at: frame.time,
            status: &frame.status,
            estimate: frame.estimate,
            error: frame.error(),
            features: frame.features,
        }
    }
    Run { x: time(hover), mark: Mark::Line, dot: 3, samples: hover.frames.iter().map(sample).collect() }
}

/// Returns the times at which another frame became the reference.
fn renewals(hover: &Hover) -> Series {
    let renewed = hover.frames.windows(2).filter(|pair| pair[0].reference.is_some());
    let renewed = renewed.filter(|pair| pair[1].reference.is_some() && pair[0].reference != pair[1].reference);
    line("reference renewed", VIOLET, Mark::Dots(3), renewed.map(|pair| (pair[0].time, 0.0)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn the_page_is_one_file_and_shows_the_hover() {
        let estimate = Estimate { displacement: [0.3, 0.4], sigma: [0.02, 0.03], quality: 200, inliers: 1, matches: 5 };
        let frame = |i: usize| Frame {
            time: i as f64 / 15.0,
            truth: [0.1 * i as f64, 0.0, 50.0],
            status: ["reference", "estimate", "none"][i].into(),
            reason: (i == 2).then(|| "no texture <here> (0 matches)".into()),
            estimate: (i == 1).then_some(estimate),
            reference: (i == 1).then_some(0),
            features: 100,
            wind: [1.0, 2.0, 0.0],
            tilt: [1.0, -1.0],
            field_of_view: 50.0,
            blind: 3.0,
        };
        let hover = Hover {
            scene: "hill & dale".into(),
            setup: vec![("height".into(), "50 m".into())],
            features: "fixed".into(),
            estimator: "host".into(),
            failure: None,
            checks: vec!["rms 0.050 m, at most 0.1".into()],
            hold: [0.05, 0.1],
            blind: [2.0, 3.0],
            error: Some(0.447),
            bound: Some(0.1),
            frames: (0..3).map(frame).collect(),
            stills: vec![Picture {
                frame: 1,
                small: Plane::from_fn(64, 48, |x, y| (x * y) as u16),
                step: 2,
                inliers: vec![Pair { reference: Vector2::new(10.0, 11.0), current: Vector2::new(20.5, 21.25) }],
            }],
            animation: vec![1, 2, 3],
        };
        let page = html(&hover, "hoverlock hover").unwrap();
        assert!(page.contains("hill &amp; dale") && page.contains("no texture &lt;here&gt;"));
        assert_eq!(page.matches("M10.0 11.0L20.5 21.2").count(), 1);
        assert!(page.contains("viewBox=\"0 0 128 96\""), "the matches are in pixels of the whole frame");
        assert!(page.contains("data:image/png;base64,AQID"));
        let outside = page.split("href=\"").skip(1).filter(|rest| !rest.starts_with("data:") && !rest.starts_with('#'));
        assert_eq!(outside.count(), 0);
        assert!(!page.contains("src=\"http") && !page.contains("@import"));
    }
}
