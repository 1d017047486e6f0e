//! Impulse and frequency responses of recursive smoothers and of their DoG, against the Gaussian.
//!
//! `h[n]` over pixels; `|H|` over cycles per pixel, up to the Nyquist frequency of 0.5. The response of a smoother is
//! in dB, because an exponential differs from a Gaussian in the tails. The response of a DoG, a band-pass filter, is
//! linear.

use hoverlock_reference::smoothing::design::DesignError;
use hoverlock_reference::smoothing::gaussian::Gaussian;
use hoverlock_reference::smoothing::recursive::Recursive;
use hoverlock_reference::smoothing::smoother::Smoother;

use crate::colour::Rgb;
use crate::plot::{Axis, BLUE, Chart, Mark, ORANGE, PlotError, Series};

/// Why the plots could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// A Gaussian of this sigma cannot be designed.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The plotting crate failed.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// A plot and the stem of its file name.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Stem of the file name: `smoother0_impulse`, `dog0_frequency`, ..
    pub name: String,
    /// The plot itself.
    pub chart: Chart,
}

impl Figure {
    /// Returns the plot as a complete SVG file with white background.
    ///
    /// # Errors
    /// The plotting crate fails.
    pub fn file(&self) -> Result<String, PlotError> {
        let svg = self.chart.svg()?;
        let (width, height) = self.chart.size;
        let head = svg.find('>').map_or(0, |at| at + 1);
        Ok(format!(
            "{} width=\"{width}\" height=\"{height}\" xmlns=\"http://www.w3.org/2000/svg\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>{}",
            &svg[..head.saturating_sub(1)],
            &svg[head..]
        ))
    }
}

const SIZE: (u32, u32) = (640, 380);

/// Lowest magnitude shown, dB.
const FLOOR_DB: f64 = -60.0;

/// Nyquist frequency, cycles per pixel.
const NYQUIST: f64 = 0.5;

/// Plots impulse and frequency response of each smoother, then of the DoG of each pair of neighbours in rising sigma.
///
/// # Errors
/// A Gaussian of one of the sigmas cannot be designed.
pub fn figures(smoothers: &[Recursive]) -> Result<Vec<Figure>, FigureError> {
    let mut pairs = Vec::new();
    for recursive in smoothers {
        pairs.push((Gaussian::design(recursive.sigma())?, recursive.clone()));
    }
    let mut figures = Vec::new();
    for (i, (gaussian, recursive)) in pairs.iter().enumerate() {
        let sigma = recursive.sigma();
        let curves = [
            Curve::of("Gaussian", Smoother::Gaussian(gaussian.clone())),
            Curve::of("recursive", Smoother::Recursive(recursive.clone())),
        ];
        let title = format!("{} and the Gaussian, sigma {sigma} px", capital(&recursive.family().name()));
        figures.push(Figure { name: format!("smoother{i}_impulse"), chart: impulse(&title, &curves, sigma) });
        figures.push(Figure { name: format!("smoother{i}_frequency"), chart: frequency_db(&title, &curves, sigma) });
    }
    pairs.sort_by(|a, b| a.1.sigma().total_cmp(&b.1.sigma()));
    for (k, two) in pairs.windows(2).enumerate() {
        let [narrow, wide] = two else { continue };
        let sigmas = (narrow.1.sigma(), wide.1.sigma());
        let curves = [
            Curve::between(
                "DoG of Gaussians",
                Smoother::Gaussian(narrow.0.clone()),
                Smoother::Gaussian(wide.0.clone()),
            ),
            Curve::between(
                "DoG of recursive filters",
                Smoother::Recursive(narrow.1.clone()),
                Smoother::Recursive(wide.1.clone()),
            ),
        ];
        let title = format!("DoG of sigma {} and {} px, {}", sigmas.0, sigmas.1, narrow.1.family().name());
        figures.push(Figure { name: format!("dog{k}_impulse"), chart: impulse(&title, &curves, sigmas.1) });
        figures.push(Figure { name: format!("dog{k}_frequency"), chart: frequency_linear(&title, &curves, sigmas.0) });
    }
    Ok(figures)
}

/// One smoother, or the difference of two.
struct Curve {
    name: &'static str,
    narrow: Smoother,
    wide: Option<Smoother>,
}

impl Curve {
    fn of(name: &'static str, smoother: Smoother) -> Self {
        Self { name, narrow: smoother, wide: None }
    }

    fn between(name: &'static str, narrow: Smoother, wide: Smoother) -> Self {
        Self { name, narrow, wide: Some(wide) }
    }

    /// Returns `h[n]` for `n = -reach ..= reach`.
    fn impulse(&self, reach: usize) -> Vec<(f64, f64)> {
        let narrow = self.narrow.impulse_response();
        let wide = self.wide.as_ref().map(Smoother::impulse_response).unwrap_or_default();
        let at = |half: &[f64], n: i64| half.get(n.unsigned_abs() as usize).copied().unwrap_or(0.0);
        let reach = reach as i64;
        (-reach..=reach).map(|n| (n as f64, at(&narrow, n) - at(&wide, n))).collect()
    }

    /// Returns `H(f)`, `f` in cycles per pixel.
    fn frequency(&self, f: f64) -> f64 {
        let omega = 2.0 * std::f64::consts::PI * f;
        let wide = self.wide.as_ref().map_or(0.0, |wide| wide.frequency_response(omega));
        self.narrow.frequency_response(omega) - wide
    }

    /// Returns `(f, value)` of a function of the frequency response, up to `end`.
    fn over_frequency(&self, end: f64, value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..=400).map(|i| end * f64::from(i) / 400.0).map(|f| (f, value(self.frequency(f)))).collect()
    }
}

/// Returns the series of both curves, the Gaussian first, so that the filter is drawn over it.
fn series(curves: &[Curve; 2], mark: Mark, points: impl Fn(&Curve) -> Vec<(f64, f64)>) -> Vec<Series> {
    let colours: [Rgb; 2] = [ORANGE, BLUE];
    let one =
        |(curve, colour): (&Curve, Rgb)| Series { name: curve.name.to_owned(), colour, mark, points: points(curve) };
    curves.iter().zip(colours).map(one).collect()
}

/// Returns lowest and highest value of all series, with a margin.
fn extent(series: &[Series]) -> (f64, f64) {
    let values = || series.iter().flat_map(|series| &series.points).map(|point| point.1);
    let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
    let room = 0.08 * (high - low);
    (if low < 0.0 { low - room } else { 0.0 }, high + room)
}

fn impulse(title: &str, curves: &[Curve; 2], sigma: f64) -> Chart {
    let reach = (4.0 * sigma).ceil();
    // Dots mark the samples where there are few.
    let mark = if reach <= 30.0 { Mark::LineDots } else { Mark::Line };
    let series = series(curves, mark, |curve| curve.impulse(reach as usize));
    let (low, high) = extent(&series);
    Chart {
        title: format!("{title}: impulse response"),
        size: SIZE,
        x: Axis::linear("n, px", -reach, reach),
        y: Axis::linear("h[n]", low, high),
        series,
        rules: vec![],
    }
}

fn frequency_db(title: &str, curves: &[Curve; 2], sigma: f64) -> Chart {
    // Twice the frequency at which the Gaussian exp(-(2 pi f sigma)^2 / 2) falls to the floor.
    let end = NYQUIST
        .min(2.0 * (-FLOOR_DB / 20.0 * 2.0 * std::f64::consts::LN_10).sqrt() / (2.0 * std::f64::consts::PI * sigma));
    let decibel = |value: f64| 20.0 * value.abs().log10();
    let shown = |curve: &Curve| -> Vec<(f64, f64)> {
        curve.over_frequency(end, decibel).into_iter().take_while(|point| point.1 >= FLOOR_DB).collect()
    };
    Chart {
        title: format!("{title}: frequency response"),
        size: SIZE,
        x: Axis::linear("frequency, cycles/px", 0.0, end),
        y: Axis::linear("|H|, dB", FLOOR_DB, 6.0),
        series: series(curves, Mark::Line, shown),
        rules: vec![],
    }
}

fn frequency_linear(title: &str, curves: &[Curve; 2], narrow_sigma: f64) -> Chart {
    let end = NYQUIST.min(4.0 / (2.0 * std::f64::consts::PI * narrow_sigma));
    let series = series(curves, Mark::Line, |curve| curve.over_frequency(end, |value| value));
    let (low, high) = extent(&series);
    Chart {
        title: format!("{title}: frequency response"),
        size: SIZE,
        x: Axis::linear("frequency, cycles/px", 0.0, end),
        y: Axis::linear("H", low, high),
        series,
        rules: vec![],
    }
}

/// Returns `text` with its first letter in upper case.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reference::smoothing::recursive::{Family, Fit};

    fn chain() -> Vec<Recursive> {
        [2.0, 3.2, 5.12].map(|sigma| Recursive::design(Family::FirstOrder, Fit::LeastSquares, sigma).unwrap()).to_vec()
    }

    #[test]
    fn three_smoothers_give_six_smoother_plots_and_four_dog_plots() {
        let names: Vec<String> = figures(&chain()).unwrap().into_iter().map(|figure| figure.name).collect();
        let smoothers = (0..3).flat_map(|i| [format!("smoother{i}_impulse"), format!("smoother{i}_frequency")]);
        let dogs = (0..2).flat_map(|k| [format!("dog{k}_impulse"), format!("dog{k}_frequency")]);
        assert_eq!(names, smoothers.chain(dogs).collect::<Vec<_>>());
    }

    #[test]
    fn curves_show_the_known_responses() {
        let figures = figures(&chain()).unwrap();
        let points = |name: &str, series: usize| {
            figures.iter().find(|figure| figure.name == name).unwrap().chart.series[series].points.clone()
        };
        // The peak of the first-order filter is (1 - a)/(1 + a), a = 0.625615; the Gaussian's about 1/(2 sqrt(2 pi)).
        let peak = |series| points("smoother0_impulse", series).into_iter().find(|point| point.0 == 0.0).unwrap().1;
        assert!((peak(1) - 0.374385 / 1.625615).abs() < 1e-6, "{}", peak(1));
        assert!((peak(0) - 0.1994711).abs() < 1e-6, "{}", peak(0));
        // At 0 Hz a smoother has gain 1 and a DoG gain 0.
        assert!(points("smoother1_frequency", 1)[0].1.abs() < 1e-9);
        assert!(points("dog1_frequency", 1)[0].1.abs() < 1e-12);
    }

    #[test]
    fn files_are_complete_svg_documents() {
        for figure in figures(&chain()).unwrap() {
            let file = figure.file().unwrap();
            assert!(file.starts_with("<svg ") && file.contains("xmlns=\"http://www.w3.org/2000/svg\""));
            assert!(file.trim_end().ends_with("</svg>"));
            assert_eq!(file.matches("<svg").count(), 1);
        }
    }
}
