//! Plots of successive estimates: errors within their standard errors, quality and matches.

use serde::Serialize;

use hoverlock_reports::plot::{Axis, BLUE, Chart, GREEN, GREY, Mark, ORANGE, PlotError, RED, Series};

/// An estimate of the flight program, as pages show it.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Estimate {
    /// Displacement along `X_e` and `Y_e`, m.
    pub displacement: [f64; 2],
    /// Standard errors along `X_e` and `Y_e`, m.
    pub sigma: [f64; 2],
    /// Quality, 0 to 255.
    pub quality: u8,
    /// Number of inliers.
    pub inliers: usize,
    /// Number of matches.
    pub matches: usize,
}

/// A frame with the values that these plots show.
pub(crate) struct Sample<'a> {
    /// Position on the horizontal axis.
    pub at: f64,
    pub status: &'a str,
    pub estimate: Option<Estimate>,
    /// Estimate less truth along `X_e` and `Y_e`, m.
    pub error: Option<[f64; 2]>,
    pub features: usize,
}

/// The frames of a run, and the style of their plots.
pub(crate) struct Run<'a> {
    pub x: Axis,
    pub mark: Mark,
    /// Radius of the dot of a frame without an estimate, px.
    pub dot: i32,
    pub samples: Vec<Sample<'a>>,
}

impl Run<'_> {
    /// Returns one value of each frame that has it.
    fn points(&self, value: impl Fn(&Sample<'_>) -> Option<f64>) -> Vec<(f64, f64)> {
        self.samples.iter().filter_map(|sample| Some((sample.at, value(sample)?))).collect()
    }

    fn line(&self, name: &str, colour: hoverlock_reports::colour::Rgb, points: Vec<(f64, f64)>) -> Series {
        Series { name: name.into(), colour, mark: self.mark, points }
    }

    fn chart(&self, title: String, y: Axis, series: Vec<Series>) -> Result<String, PlotError> {
        Chart { title, size: (540, 270), x: self.x.clone(), y, series, rules: Vec::new() }.svg()
    }

    /// Plots estimate less truth along an axis, within three standard errors.
    pub fn error(&self, axis: usize) -> Result<String, PlotError> {
        let sigma = |sign: f64| self.points(|sample| Some(3.0 * sign * sample.estimate?.sigma[axis]));
        let errors = self.points(|sample| Some(sample.error?[axis]));
        let most = sigma(1.0).iter().chain(&errors).map(|(_, v)| v.abs()).fold(0.01, f64::max);
        let series = vec![
            self.line("\u{b1}3 standard errors", GREY, sigma(1.0)),
            self.line("", GREY, sigma(-1.0)),
            self.line("error", BLUE, errors),
        ];
        let name = ["X_e", "Y_e"][axis];
        self.chart(format!("Error along {name}, m"), Axis::linear("", -1.1 * most, 1.1 * most), series)
    }

    /// Plots the quality of each frame; 0 without an estimate.
    pub fn quality(&self) -> Result<String, PlotError> {
        let estimated = self.points(|sample| Some(f64::from(sample.estimate?.quality)));
        let none = self.points(|sample| (sample.status == "none").then_some(0.0));
        let ticks = [0, 64, 128, 192, 255].map(|v| (f64::from(v), v.to_string())).to_vec();
        let mark = Mark::Dots(self.dot);
        let series = vec![
            self.line("estimate", BLUE, estimated),
            Series { name: "no estimate".into(), colour: RED, mark, points: none },
        ];
        self.chart("Quality, 0 to 255".into(), Axis::ticked("", 0.0, 262.0, ticks), series)
    }

    /// Plots features, matches and inliers, and one more series.
    pub fn inliers(&self, further: Option<Series>) -> Result<String, PlotError> {
        let count = |of: fn(&Estimate) -> usize| self.points(move |sample| Some(of(sample.estimate.as_ref()?) as f64));
        let features = self.points(|sample| Some(sample.features as f64));
        let most = features.iter().map(|(_, count)| *count).fold(1.0, f64::max);
        let mut series = vec![
            self.line("features", GREY, features),
            self.line("matches", ORANGE, count(|e| e.matches)),
            self.line("inliers", GREEN, count(|e| e.inliers)),
        ];
        series.extend(further);
        self.chart("Features, matches, and those that agree".into(), Axis::linear("", 0.0, 1.1 * most), series)
    }
}

/// Describes a frame in words: the number of inliers, or the reason why there is no estimate.
pub(crate) fn describe(estimate: Option<&Estimate>, reason: Option<&str>, status: &str) -> String {
    match (estimate, reason) {
        (Some(estimate), _) => format!("{} of {} matches agree", estimate.inliers, estimate.matches),
        (None, reason) => reason.unwrap_or(status).to_owned(),
    }
}
