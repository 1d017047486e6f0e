//! The page of a co-simulation: the track of the camera over the ground, its error, and frames with their inliers.

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::Pair;
use minijinja::context;
use serde::Serialize;

use super::estimates::{Estimate, Run, Sample, describe};
use super::still::{Still, reduced, still};
use hoverlock_reports::page::{PageError, SCRIPT, STYLE, environment, value};
use hoverlock_reports::plot::{Axis, BLUE, Chart, Mark, ORANGE, PlotError, Series};
use hoverlock_reports::provenance::COMMIT;

const TEMPLATE: &str = include_str!("../../templates/flight.html");

/// Largest number of frames that are shown with their matches. Of more frames every n-th is shown.
const MAX_STILLS: usize = 24;

/// Largest number of columns of a shown frame.
const MAX_STILL_COLUMNS: usize = 480;

/// A run of the flight program.
#[derive(Debug, Clone, Serialize)]
pub struct Flight<'a> {
    /// Name of the sequence.
    pub name: String,
    /// The command as typed.
    pub command: String,
    /// The source of the features.
    pub features: String,
    /// The place where the flight program ran.
    pub estimator: String,
    /// The origin of the telemetry.
    pub telemetry: String,
    /// Why the run fails; `None` if it passes.
    pub failure: Option<String>,
    /// What the run has shown, in a sentence.
    pub coverage: String,
    /// Number of clock cycles simulated; `None` without simulated hardware.
    pub cycles: Option<u64>,
    /// The frames in order.
    pub frames: Vec<Frame<'a>>,
}

/// A frame of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Frame<'a> {
    /// File name of the frame.
    pub name: String,
    /// Status in the line of the flight program.
    pub status: String,
    /// Why there is no estimate.
    pub reason: Option<String>,
    /// Number of features.
    pub features: usize,
    /// The estimate of the displacement.
    pub estimate: Option<Estimate>,
    /// Displacement by the homographies of the folder along `X_e` and `Y_e`, m.
    pub truth: Option<[f64; 2]>,
    /// The homographies of the frames between were multiplied.
    pub chained: bool,
    /// The pixels, DN; `None` if the page does not show them.
    #[serde(skip)]
    pub picture: Option<&'a Plane<u16>>,
    /// Inliers: positions in the reference and in this frame, px.
    #[serde(skip)]
    pub inliers: Vec<Pair>,
}

impl Frame<'_> {
    /// Returns estimate less truth along `X_e` and `Y_e`, m.
    fn error(&self) -> Option<[f64; 2]> {
        let (estimate, truth) = (self.estimate?, self.truth?);
        Some([0, 1].map(|axis| estimate.displacement[axis] - truth[axis]))
    }
}

/// Returns the distance between the frames that are shown, for `frames` in all.
fn step(frames: usize) -> usize {
    frames.div_ceil(MAX_STILLS).max(1)
}

/// Returns `true` if the page of a run of `frames` shows the pixels of frame `number`.
pub fn shows(number: usize, frames: usize) -> bool {
    number.is_multiple_of(step(frames))
}

/// Renders the page as HTML, with style, plots and pictures inside it.
///
/// # Errors
/// A plot or the template fails. Either is a defect of this program, not of the input.
pub fn html(flight: &Flight<'_>) -> Result<String, PageError> {
    let mut environment = environment();
    environment.add_template("flight.html", TEMPLATE)?;
    let errors: Vec<f64> = flight.frames.iter().filter_map(Frame::error).map(|[x, y]| x.hypot(y)).collect();
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64).sqrt();
    let run = run(flight);
    let stills = flight.frames.iter().filter_map(draw_still).collect::<Result<Vec<_>, PlotError>>()?;
    Ok(environment.get_template("flight.html")?.render(context! {
        style => STYLE,
        script => SCRIPT,
        commit => COMMIT,
        flight => value(flight),
        estimates => flight.frames.iter().filter(|frame| frame.estimate.is_some()).count(),
        truths => flight.frames.iter().any(|frame| frame.truth.is_some()),
        chained => flight.frames.iter().any(|frame| frame.chained),
        compared => errors.len(),
        rms => rms,
        largest => errors.iter().copied().fold(0.0, f64::max),
        track => track(flight)?,
        errors => [run.error(0)?, run.error(1)?],
        quality => run.quality()?,
        inliers => run.inliers(None)?,
        step => step(flight.frames.len()),
        stills => value(stills),
    })?)
}

/// Plots the track from above, the top of the reference picture up.
fn track(flight: &Flight<'_>) -> Result<String, PlotError> {
    let above = |[x, y]: [f64; 2]| (x, -y);
    let estimates: Vec<_> = flight
        .frames
        .iter()
        .filter_map(|frame| match frame.status.as_str() {
            "reference" => Some((0.0, 0.0)),
            _ => frame.estimate.map(|estimate| above(estimate.displacement)),
        })
        .collect();
    let truths: Vec<_> = flight.frames.iter().filter_map(|frame| frame.truth.map(above)).collect();
    let all = || estimates.iter().chain(&truths).copied();
    let middle = |of: fn((f64, f64)) -> f64| {
        let (low, high) = all().map(of).fold((0.0, 0.0), |(low, high): (f64, f64), v| (low.min(v), high.max(v)));
        ((low + high) / 2.0, high - low)
    };
    let ((x, width), (y, height)) = (middle(|p| p.0), middle(|p| p.1));
    // Both axes have the same scale.
    let half = 0.6 * width.max(height).max(0.1);
    let mut series = vec![Series { name: "estimate".into(), colour: BLUE, mark: Mark::LineDots, points: estimates }];
    if !truths.is_empty() {
        let colour = ORANGE;
        series.push(Series { name: "homographies of the folder".into(), colour, mark: Mark::Ring(6), points: truths });
    }
    Chart {
        title: "Track over the ground".into(),
        size: (540, 560),
        x: Axis::linear("X_e, m", x - half, x + half),
        y: Axis::linear("\u{2212}Y_e, m", y - half, y + half),
        series,
        rules: Vec::new(),
    }
    .svg()
}

/// Returns the frames for the plots over time.
fn run<'a>(flight: &'a Flight<'_>) -> Run<'a> {
    let last = flight.frames.len().saturating_sub(1).max(1);
    let step = last.div_ceil(12);
    let ticks = (0..=last).step_by(step).map(|frame| (frame as f64, frame.to_string())).collect();
    let sample = |(i, frame): (usize, &'a Frame<'_>)| Sample {
        at: i as f64,
        status: &frame.status,
        estimate: frame.estimate,
        error: frame.error(),
        features: frame.features,
    };
    Run {
        x: Axis::ticked("frame", -0.3, last as f64 + 0.3, ticks),
        mark: Mark::LineDots,
        dot: 4,
        samples: flight.frames.iter().enumerate().map(sample).collect(),
    }
}

/// Draws a frame with its inliers; `None` if its pixels are not shown.
fn draw_still(frame: &Frame<'_>) -> Option<Result<Still, PlotError>> {
    let picture = frame.picture?;
    let inliers = if frame.estimate.is_some() { &frame.inliers[..] } else { &[] };
    let description = describe(frame.estimate.as_ref(), frame.reason.as_deref(), &frame.status);
    let (step, small) = reduced(picture, MAX_STILL_COLUMNS);
    Some(still(&frame.name, &small, step, inliers, format!("{}: {description}", frame.name)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn frame<'a>(picture: &'a Plane<u16>, status: &str, displacement: Option<[f64; 2]>) -> Frame<'a> {
        let estimate = displacement.map(|displacement| Estimate {
            displacement,
            sigma: [0.02, 0.03],
            quality: 200,
            inliers: 1,
            matches: 5,
        });
        Frame {
            name: "00 <a>.png".into(),
            status: status.into(),
            reason: (status == "none").then(|| "no texture".into()),
            features: 50,
            estimate,
            truth: Some([1.0, 2.0]),
            chained: false,
            picture: Some(picture),
            inliers: vec![Pair { reference: Vector2::new(10.0, 11.0), current: Vector2::new(20.5, 21.25) }],
        }
    }

    #[test]
    fn a_long_run_shows_no_more_frames_than_a_short_one() {
        let count = |frames: usize| (0..frames).filter(|&number| shows(number, frames)).count();
        assert_eq!([2, 24, 25, 48, 9000].map(count), [2, 24, 13, 24, 24]);
    }

    #[test]
    fn the_page_is_one_file_and_shows_every_frame() {
        let picture = Plane::from_fn(64, 48, |x, y| (x * y) as u16);
        let flight = Flight {
            name: "hill & dale".into(),
            command: "hoverlock cosim hill".into(),
            features: "fixed".into(),
            estimator: "host".into(),
            telemetry: "telemetry.csv".into(),
            failure: None,
            coverage: "1 estimates in 3 frames; 1 of the 2 that floating point solves".into(),
            cycles: Some(12),
            frames: vec![
                frame(&picture, "reference", None),
                frame(&picture, "estimate", Some([1.3, 2.4])),
                frame(&picture, "none", None),
            ],
        };
        let page = html(&flight).unwrap();
        assert!(page.contains("hill &amp; dale") && page.contains("no texture") && page.contains("00 &lt;a&gt;.png"));
        assert!(!page.contains("00 <a>.png") && page.contains("1 of the 2 that floating point solves"));
        // |(0.3, 0.4)|
        assert!(page.contains("0.500"), "the rms of the one error");
        // The inlier is drawn in the frame that has an estimate, and in no other.
        assert_eq!(page.matches("M10.0 11.0L20.5 21.2").count(), 1);
        let outside = page.split("href=\"").skip(1).filter(|rest| !rest.starts_with("data:") && !rest.starts_with('#'));
        assert_eq!(outside.count(), 0);
        assert!(!page.contains("src=\"http") && !page.contains("@import"));
    }
}
