//! Plots as SVG: lines, points and bars with explicit axis ticks.
//!
//! A logarithmic axis is a linear axis of `log10` with labels in the original unit. All plots share one style: thin
//! grey grid lines, no frame, text in the size of the page. A plot carries its own data (`data-plot`): the script of a
//! page shows the values under the pointer, and a test reads the drawn labels against them.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde::Serialize;

use crate::colour::Rgb;

/// Largest power of ten of a value on an axis, of either sign. Labels of larger ones would not fit.
const MAX_EXPONENT: f64 = 30.0;

/// Text and axes.
pub const INK: Rgb = [38, 50, 64];
/// Colour of secondary data.
pub const GREY: Rgb = [139, 150, 161];
/// Colour of the first series.
pub const BLUE: Rgb = [31, 95, 168];
/// Colour of the second series.
pub const ORANGE: Rgb = [214, 122, 30];
/// Third series, and the design point.
pub const GREEN: Rgb = [35, 128, 86];
/// Limits and failures.
pub const RED: Rgb = [184, 38, 32];
/// Colour of the fourth series.
pub const VIOLET: Rgb = [116, 76, 158];

/// A plot could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("a plot cannot be drawn: {0}")]
pub struct PlotError(String);

impl PlotError {
    /// Creates the error of the plot with this title.
    pub fn new(title: &str, error: impl std::fmt::Display) -> Self {
        Self(format!("{title}: {error}"))
    }
}

/// An axis of a plot: label, range and ticks, on a linear or logarithmic scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    label: String,
    from: f64,
    to: f64,
    log: bool,
    /// The ticks are names of values, such as stages; values between them have no name.
    named: bool,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Creates a linear axis with ticks at round numbers. A range with an end that is not finite becomes 0 to 1; one of
    /// no length is widened.
    pub fn linear(label: impl Into<String>, from: f64, to: f64) -> Self {
        let (from, to) = drawable(from, to);
        let step = round_step((to - from) / 5.0);
        let first = (from / step - 1e-9).ceil() as i64;
        let last = (to / step + 1e-9).floor() as i64;
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let ticks =
            (first..=last).map(|i| (i as f64 * step, minus(format!("{:.decimals$}", i as f64 * step)))).collect();
        Self { label: label.into(), from, to, log: false, named: false, ticks }
    }

    /// Creates a linear axis with the given ticks. The range is replaced as in [`Axis::linear`].
    pub fn ticked(label: impl Into<String>, from: f64, to: f64, ticks: Vec<(f64, String)>) -> Self {
        let (from, to) = drawable(from, to);
        Self { label: label.into(), from, to, log: false, named: true, ticks }
    }

    /// Creates a logarithmic axis between two positive numbers, with ticks at the decades, and at 2 and 5 times a
    /// decade on a short axis. Ends that are not positive or not finite become those of 0.1 to 10.
    pub fn log(label: impl Into<String>, from: f64, to: f64) -> Self {
        let exponent = |value: f64, otherwise: f64| {
            let drawn = value > 0.0 && value.is_finite();
            if drawn { value.log10().clamp(-MAX_EXPONENT, MAX_EXPONENT) } else { otherwise }
        };
        let from = exponent(from, -1.0);
        let to = exponent(to, 1.0).max(from + 0.1);
        let steps: &[f64] = if to - from > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let decades = from.floor() as i32..=to.ceil() as i32;
        let ticks = decades
            .flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)))
            .filter(|value| (from - 1e-9..=to + 1e-9).contains(&value.log10()))
            .map(|value| (value.log10(), plain(value)))
            .collect();
        Self { label: label.into(), from, to, log: true, named: false, ticks }
    }

    /// Returns the data with which a page finds the value under the pointer.
    fn data(&self) -> AxisData<'_> {
        AxisData {
            label: &self.label,
            from: self.from,
            to: self.to,
            log: self.log,
            names: if self.named { &self.ticks } else { &[] },
        }
    }

    /// Returns the position of `value`, clamped to the ends of the axis; its `log10` on a logarithmic axis.
    fn position(&self, value: f64) -> f64 {
        if self.log { value.max(1e-300).log10().clamp(self.from, self.to) } else { value.clamp(self.from, self.to) }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        // A bar may reach beyond the ends; one length of the axis is outside of the picture.
        let part = ((value - self.from) / (self.to - self.from)).clamp(-1.0, 2.0);
        limit.0 + (part * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.iter().map(|tick| tick.0).collect()
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let tick = self.ticks.iter().find(|tick| tick.0 == *value);
        tick.map(|tick| tick.1.clone()).unwrap_or_default()
    }
}

/// Returns a range that an axis can have: two finite numbers with a distance that `f64` resolves. The range of no
/// values has infinite ends, and becomes 0 to 1; that of equal values has no length, and is widened.
fn drawable(from: f64, to: f64) -> (f64, f64) {
    if !from.is_finite() || !to.is_finite() {
        return (0.0, 1.0);
    }
    let most = 10f64.powf(MAX_EXPONENT);
    let (from, to) = (from.clamp(-most, most), to.clamp(-most, most));
    let magnitude = from.abs().max(to.abs());
    if to - from > (1e-9 * magnitude).max(1.0 / most) {
        return (from, to);
    }
    let half = (1e-6 * magnitude).max(0.5);
    (from - half, from + half)
}

/// Returns 1, 2 or 5 times a power of ten, at least `step`.
fn round_step(step: f64) -> f64 {
    let decade = 10f64.powf(step.log10().floor());
    let lead = step / decade;
    decade
        * if lead <= 1.0 {
            1.0
        } else if lead <= 2.0 {
            2.0
        } else if lead <= 5.0 {
            5.0
        } else {
            10.0
        }
}

/// Formats `value` without exponent and trailing zeros.
fn plain(value: f64) -> String {
    let decimals = (-value.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// Rounds `value` to five digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Replaces the ASCII minus sign by U+2212.
fn minus(text: String) -> String {
    text.replace('-', "\u{2212}")
}

/// The way in which a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// A line through all points.
    Line,
    /// A line with a dot at each point.
    LineDots,
    /// A dot of this radius in px at each point.
    Dots(i32),
    /// A cross of this half width in px at each point.
    Crosses(i32),
    /// A ring of this radius in px around each point.
    Ring(i32),
    /// Bars from the axis up, of this width in units of `x`.
    Bars(f64),
    /// Bars from a given `y` up.
    Columns {
        /// Lower end, `y`.
        from: f64,
        /// Width in units of `x`.
        width: f64,
    },
}

/// A data series of a plot: a line or marks with an entry in the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; empty for no entry.
    pub name: String,
    /// Colour of line and marks.
    pub colour: Rgb,
    /// Style of line and marks.
    pub mark: Mark,
    /// Points `(x, y)`.
    pub points: Vec<(f64, f64)>,
}

/// A dashed line across the plot.
#[derive(Debug, Clone, PartialEq)]
pub enum Rule {
    /// A limit at this `y`, with its label.
    Limit(f64, String),
    /// The chosen value at this `x`, with its label.
    Choice(f64, String),
}

impl Rule {
    /// Returns the position of the line on its axis.
    fn value(&self) -> f64 {
        let (Self::Limit(value, _) | Self::Choice(value, _)) = self;
        *value
    }
}

/// A plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title above the plot; may be empty.
    pub title: String,
    /// Width and height, px.
    pub size: (u32, u32),
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Data series; later ones cover earlier ones.
    pub series: Vec<Series>,
    /// Dashed lines across the plot.
    pub rules: Vec<Rule>,
}

/// An axis in the `data-plot` of a plot. On a logarithmic axis `from` and `to` are `log10` of its ends.
#[derive(Debug, Serialize)]
struct AxisData<'a> {
    label: &'a str,
    from: f64,
    to: f64,
    log: bool,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    names: &'a [(f64, String)],
}

/// A series in the `data-plot` of a plot.
#[derive(Debug, Serialize)]
struct SeriesData<'a> {
    name: &'a str,
    /// Rounded to five digits.
    points: Vec<(f64, f64)>,
}

/// The `data-plot` of a plot.
#[derive(Debug, Serialize)]
struct PlotData<'a> {
    x: AxisData<'a>,
    y: AxisData<'a>,
    /// Left, top, right and bottom of the plot inside its axes, px of the view box.
    area: [i32; 4],
    series: Vec<SeriesData<'a>>,
}

const FONT: &str = "sans-serif";

fn rgb(colour: Rgb) -> RGBColor {
    RGBColor(colour[0], colour[1], colour[2])
}

impl Chart {
    /// Returns the plot as an `<svg>` element that scales to the available width.
    ///
    /// # Errors
    /// The plotting crate fails.
    pub fn svg(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        let area = self.draw(&mut svg).map_err(|error| PlotError::new(&self.title, error))?;
        let data = serde_json::to_string(&self.data(area)).map_err(|error| PlotError::new(&self.title, error))?;
        let tag = format!("<svg data-plot=\"{}\"", minijinja::HtmlEscape(&data));
        Ok(scalable(&svg, &self.described()).replacen("<svg", &tag, 1))
    }

    /// Returns the data with which the page shows values. A series without a name is added to the one before it; if
    /// there is none before it, it is the only series of the plot.
    fn data(&self, area: [i32; 4]) -> PlotData<'_> {
        let mut series: Vec<SeriesData<'_>> = Vec::new();
        for one in &self.series {
            // The height of a column counts from its lower end, so it is not a value of the axis.
            let points = one.points.iter().filter(|_| !matches!(one.mark, Mark::Columns { .. }));
            let points = points.filter(|(x, y)| x.is_finite() && y.is_finite()).map(|&(x, y)| (rounded(x), rounded(y)));
            match series.last_mut() {
                Some(last) if one.name.is_empty() => last.points.extend(points),
                _ => series.push(SeriesData { name: &one.name, points: points.collect() }),
            }
        }
        series.retain(|one| !one.points.is_empty());
        PlotData { x: self.x.data(), y: self.y.data(), area, series }
    }

    /// Describes the plot in words for screen readers: title, axes and curves.
    fn described(&self) -> String {
        let axes: Vec<&str> =
            [&self.y.label, &self.x.label].into_iter().map(String::as_str).filter(|label| !label.is_empty()).collect();
        let curves: Vec<&str> =
            self.series.iter().map(|series| series.name.as_str()).filter(|name| !name.is_empty()).collect();
        let parts = [self.title.clone(), axes.join(" against "), curves.join(", ")];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
    }

    /// Returns the plot as a separate SVG file on white.
    ///
    /// # Errors
    /// The plotting crate fails.
    pub fn file(&self) -> Result<String, PlotError> {
        let head = r#"<svg xmlns="http://www.w3.org/2000/svg" style="background:white""#;
        Ok(self.svg()?.replacen("<svg", head, 1))
    }

    /// Draws into `svg` and returns left, top, right and bottom of the plot inside its axes, px.
    fn draw(&self, svg: &mut String) -> Result<[i32; 4], Box<dyn std::error::Error>> {
        let root = SVGBackend::with_string(svg, self.size).into_drawing_area();
        let text = |size: i32, colour: Rgb| (FONT, size).into_font().color(&rgb(colour));
        let mut builder = ChartBuilder::on(&root);
        let legend = self.series.iter().any(|series| !series.name.is_empty());
        builder.margin(6).margin_right(14).x_label_area_size(42).y_label_area_size(self.y_label_width());
        // The legend has its own line between the title and the plot.
        let title = if self.title.is_empty() { 0 } else { 24 };
        builder.margin_top(6 + title + if legend { 22 } else { 0 });
        if !self.title.is_empty() {
            let style = text(16, INK).pos(Pos::new(HPos::Left, VPos::Top));
            root.draw(&Text::new(self.title.clone(), (14, 6), style))?;
        }
        let mut chart = builder.build_cartesian_2d(self.x.clone(), self.y.clone())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(rgb([226, 230, 234]))
            .axis_style(rgb([176, 184, 192]))
            .x_labels(self.x.ticks.len().max(1))
            .y_labels(self.y.ticks.len().max(1))
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .label_style(text(14, INK))
            .axis_desc_style(text(14, INK))
            .draw()?;
        for rule in self.rules.iter().filter(|rule| !rule.value().is_nan()) {
            let (line, at, name, colour, pos) = match rule {
                Rule::Limit(y, name) => {
                    let y = self.y.position(*y);
                    let pos = Pos::new(HPos::Right, VPos::Bottom);
                    ([(self.x.from, y), (self.x.to, y)], (self.x.to, y), name, RED, pos)
                }
                Rule::Choice(x, name) => {
                    let x = self.x.position(*x);
                    // On the side with more room.
                    let room = x < (self.x.from + self.x.to) / 2.0;
                    let pos = Pos::new(if room { HPos::Left } else { HPos::Right }, VPos::Top);
                    ([(x, self.y.from), (x, self.y.to)], (x, self.y.to), name, GREEN, pos)
                }
            };
            chart.draw_series(DashedLineSeries::new(line, 5, 4, rgb(colour).stroke_width(1)))?;
            chart.draw_series([Text::new(format!(" {name} "), at, text(13, colour).pos(pos))])?;
        }
        for (series, dash) in self.series.iter().zip(self.dashes()) {
            let colour = rgb(series.colour);
            // NaN means that nothing was measured there, and has no place on an axis.
            let measured = || series.points.iter().filter(|(x, y)| !x.is_nan() && !y.is_nan());
            let points = || measured().map(|&(x, y)| (self.x.position(x), self.y.position(y)));
            match series.mark {
                Mark::Line | Mark::LineDots => {
                    let style = colour.stroke_width(2);
                    match dash {
                        None => {
                            chart.draw_series(LineSeries::new(points(), style))?;
                        }
                        Some((on, off)) => {
                            chart.draw_series(DashedLineSeries::new(points(), on, off, style))?;
                        }
                    }
                    if series.mark == Mark::Line {
                        continue;
                    }
                    chart.draw_series(points().map(|point| Circle::new(point, 3, colour.filled())))?;
                }
                Mark::Dots(radius) => {
                    chart.draw_series(points().map(|point| Circle::new(point, radius, colour.mix(0.75).filled())))?;
                }
                Mark::Crosses(radius) => {
                    chart.draw_series(points().map(|point| Cross::new(point, radius, colour.stroke_width(2))))?;
                }
                Mark::Ring(radius) => {
                    chart.draw_series(points().map(|point| Circle::new(point, radius, colour.stroke_width(2))))?;
                }
                Mark::Bars(_) | Mark::Columns { .. } => {
                    let (from, width) = match series.mark {
                        Mark::Columns { from, width } => (self.y.position(from), width),
                        Mark::Bars(width) => (self.y.from, width),
                        _ => (self.y.from, 0.0),
                    };
                    let bar = |(x, y): (f64, f64)| {
                        let corners = [(x - width / 2.0, from), (x + width / 2.0, y)];
                        Rectangle::new(corners, colour.filled())
                    };
                    chart.draw_series(points().map(bar))?;
                }
            }
        }
        let (across, down) = chart.plotting_area().get_pixel_range();
        self.draw_legend(&root)?;
        root.present()?;
        Ok([across.start, down.start, across.end, down.end])
    }

    /// Returns the length of dash and gap of each series that is a line, px, so that lines differ without colour too.
    /// The first named line is solid. A line without a name has the dashes of the one before it.
    fn dashes(&self) -> Vec<Option<(i32, i32)>> {
        let mut lines = 0;
        let dash = |line: usize| [None, Some((9, 4)), Some((2, 4)), Some((14, 3))][line.saturating_sub(1) % 4];
        self.series
            .iter()
            .map(|series| {
                let is_line = matches!(series.mark, Mark::Line | Mark::LineDots);
                lines += usize::from(is_line && !series.name.is_empty());
                if is_line { dash(lines) } else { None }
            })
            .collect()
    }

    /// Returns the width of the tick labels and the name of the vertical axis, px.
    fn y_label_width(&self) -> u32 {
        let longest = self.y.ticks.iter().map(|tick| tick.1.chars().count()).max().unwrap_or(0) as u32;
        13 + 7 * longest + if self.y.label.is_empty() { 0 } else { 20 }
    }

    /// Draws the legend: the names in one row at the top right.
    fn draw_legend(
        &self,
        root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let named: Vec<(&Series, Option<(i32, i32)>)> =
            self.series.iter().zip(self.dashes()).filter(|(series, _)| !series.name.is_empty()).collect();
        let (gap, line) = (16, |series: &Series| matches!(series.mark, Mark::Line | Mark::LineDots));
        // A piece of a line shows its dashes.
        let key = |series: &Series| if line(series) { 26 } else { 10 };
        let width: i32 = named.iter().map(|(series, _)| key(series) + text_width(&series.name) + gap).sum();
        let mut left = self.size.0 as i32 - 14 + gap - width;
        let top = if self.title.is_empty() { 6 } else { 30 };
        for (series, dash) in named {
            let colour = rgb(series.colour);
            let dot = key(series);
            let style = (FONT, 14).into_font().color(&rgb(INK)).pos(Pos::new(HPos::Left, VPos::Top));
            if line(series) {
                let (mut at, end) = (left, left + dot - 3);
                let (on, off) = dash.unwrap_or((end - at, 0));
                while at < end {
                    let piece = vec![(at, top + 6), ((at + on).min(end), top + 6)];
                    root.draw(&PathElement::new(piece, colour.stroke_width(2)))?;
                    at += on + off;
                }
            } else if let Mark::Crosses(_) = series.mark {
                root.draw(&Cross::new((left + 4, top + 6), 4, colour.stroke_width(2)))?;
            } else if let Mark::Ring(_) = series.mark {
                root.draw(&Circle::new((left + 4, top + 6), 4, colour.stroke_width(2)))?;
            } else {
                root.draw(&Circle::new((left + 4, top + 6), 4, colour.filled()))?;
            }
            // Text starts at its dot. Only the gap to the next entry depends on the estimated text width.
            root.draw(&Text::new(series.name.clone(), (left + dot + 1, top), style))?;
            left += dot + text_width(&series.name) + gap;
        }
        Ok(())
    }
}

/// Estimates the width of a legend entry in a sans-serif font, px.
fn text_width(text: &str) -> i32 {
    let tenths = text.chars().map(|c| match c {
        'i' | 'j' | 'l' | 'f' | 't' | 'r' | 'I' | ' ' | '.' | ',' | '\'' => 42,
        'm' | 'w' | 'M' | 'W' => 100,
        _ => 68,
    });
    tenths.sum::<i32>() / 10
}

/// Removes the fixed size of an `<svg>` element, keeps its `viewBox`, and adds `title` as accessible label.
fn scalable(svg: &str, title: &str) -> String {
    let start = svg.find("<svg").unwrap_or(0);
    let end = svg[start..].find('>').map_or(svg.len(), |at| start + at);
    let view_box = svg[start..end].find("viewBox=").map_or("", |at| {
        let rest = &svg[start + at..end];
        rest.match_indices('"').nth(1).map_or("", |(close, _)| &rest[..=close])
    });
    let title = minijinja::HtmlEscape(title);
    format!("<svg {view_box} role=\"img\" aria-label=\"{title}\"{}", &svg[end..])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|tick| tick.1.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_axis() {
        assert_eq!(labels(&Axis::linear("", -1.0, 1.0)), ["\u{2212}1.0", "\u{2212}0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(&Axis::linear("", 8.0, 18.0)), ["8", "10", "12", "14", "16", "18"]);
        assert_eq!(labels(&Axis::log("", 0.01, 100.0)), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(&Axis::log("", 80.0, 1000.0)), ["100", "200", "500", "1000"]);
        assert!(!labels(&Axis::linear("", 3.0, 3.0)).is_empty());
    }

    /// The ends of an axis are computed from what was measured, which may be nothing, one value or any other.
    #[test]
    fn any_range_and_any_point_can_be_drawn() {
        let values = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE,
            5e-324,
            -1.0,
            0.0,
            1.0,
            1.0 + f64::EPSILON,
            1e16,
        ];
        let marks = [
            Mark::Line,
            Mark::LineDots,
            Mark::Dots(3),
            Mark::Crosses(3),
            Mark::Ring(3),
            Mark::Bars(1.0),
            Mark::Columns { from: f64::MIN, width: f64::MAX },
        ];
        let points: Vec<(f64, f64)> = values.iter().flat_map(|&x| values.map(|y| (x, y))).collect();
        let series = |mark| Series { name: "s".into(), colour: BLUE, mark, points: points.clone() };
        let rules = || values.iter().flat_map(|&at| [Rule::Limit(at, "l".into()), Rule::Choice(at, "c".into())]);
        for (from, to) in points.iter().copied() {
            let ticked = Axis::ticked("", from, to, vec![(from, "from".into()), (to, "to".into())]);
            for axis in [Axis::linear("", from, to), Axis::log("", from, to), ticked] {
                assert!(axis.from.is_finite() && axis.to.is_finite() && axis.from < axis.to, "{from} {to}: {axis:?}");
                assert!(axis.ticks.len() < 80 && labels(&axis).iter().all(|label| label.len() < 60), "{axis:?}");
                let (title, size) = (format!("{from} {to}"), (320, 200));
                let (x, y) = (axis.clone(), axis);
                let chart = Chart { title, size, x, y, series: marks.map(series).into(), rules: rules().collect() };
                chart.svg().unwrap();
            }
        }
    }

    #[test]
    fn what_was_not_measured_is_not_drawn() {
        let points = vec![(f64::NAN, 1.0), (1.0, f64::NAN), (1.0, 1.0)];
        let chart = Chart {
            title: String::new(),
            size: (320, 200),
            x: Axis::linear("", 0.0, 2.0),
            y: Axis::log("", 0.1, 10.0),
            series: vec![Series { name: String::new(), colour: BLUE, mark: Mark::Dots(3), points }],
            rules: vec![Rule::Choice(f64::NAN, "unknown".into())],
        };
        let svg = chart.svg().unwrap();
        assert!(svg.matches("<circle").count() == 1 && !svg.contains("unknown"), "{svg}");
    }

    #[test]
    fn a_plot_is_one_scalable_element_without_outside_resources() {
        let chart = Chart {
            title: "a < b".into(),
            size: (320, 200),
            x: Axis::linear("x", 0.0, 4.0),
            y: Axis::log("y", 0.1, 10.0),
            series: vec![Series {
                name: "s".into(),
                colour: BLUE,
                mark: Mark::LineDots,
                points: vec![(0.0, 0.0), (4.0, 20.0)],
            }],
            rules: vec![Rule::Limit(1.0, "limit".into()), Rule::Choice(2.0, "chosen".into())],
        };
        let svg = chart.svg().unwrap();
        assert!(
            svg.starts_with("<svg data-plot=\"{&quot;x&quot;:{&quot;label")
                && svg.contains("viewBox=\"0 0 320 200\" role=\"img\" aria-label=\"a &lt; b; y against x; s\">"),
            "{svg}"
        );
        assert!(svg.trim_end().ends_with("</svg>") && !svg.contains("width=\"320\" height=\"200\" viewBox"));
        assert!(svg.contains("limit") && svg.contains("chosen"));
        assert!(!svg.contains("<image") && !svg.contains("href"));
    }
}
