//! What a plot of the page shows: its labels, its marks and the data that it carries say the same.

use hoverlock_reports::page;
use serde_json::Value;

use crate::FULL;

/// A plot may be off by this much, px: marks stand on whole pixels.
const NEAR: f64 = 1.6;

/// One plot of the page.
struct Plot {
    svg: String,
    data: Value,
}

impl Plot {
    fn all() -> Vec<Self> {
        let html = page::html(&FULL).unwrap();
        let pieces = html.split("<svg ").skip(1).map(|piece| piece[..piece.find("</svg>").unwrap()].to_owned());
        let plots = pieces.filter_map(|svg| {
            let data = serde_json::from_str(&plain(attribute(&svg, "data-plot")?)).unwrap();
            Some(Self { svg, data })
        });
        plots.collect()
    }

    /// The plot whose description begins like this.
    fn named(start: &str) -> Self {
        let mut found: Vec<Self> = Self::all().into_iter().filter(|plot| plot.name().starts_with(start)).collect();
        assert_eq!(found.len(), 1, "{start}");
        found.remove(0)
    }

    fn name(&self) -> String {
        plain(attribute(&self.svg, "aria-label").unwrap())
    }

    /// Tags of this name, each with the text that follows it.
    fn tags(&self, name: &str) -> Vec<(&str, &str)> {
        let open = format!("<{name} ");
        let tags = self.svg.match_indices(&open).map(|(at, _)| {
            let (tag, rest) = self.svg[at..].split_once('>').unwrap();
            (tag, rest.split('<').next().unwrap().trim())
        });
        tags.collect()
    }

    /// Left, top, right and bottom of the plot inside its axes, px.
    fn area(&self) -> [f64; 4] {
        std::array::from_fn(|i| self.data["area"][i].as_f64().unwrap())
    }

    /// Where a value stands, px.
    fn position(&self, axis: &str, value: f64) -> f64 {
        let (from, to) = (self.data[axis]["from"].as_f64().unwrap(), self.data[axis]["to"].as_f64().unwrap());
        let value = if self.data[axis]["log"] == true { value.max(1e-300).log10() } else { value };
        let part = ((value - from) / (to - from)).clamp(0.0, 1.0);
        let [left, top, right, bottom] = self.area();
        if axis == "x" { left + part * (right - left) } else { bottom - part * (bottom - top) }
    }

    /// The labels drawn along an axis, and where, px.
    fn labels(&self, axis: &str) -> Vec<(String, f64)> {
        let [left, _, _, bottom] = self.area();
        let label = self.data[axis]["label"].as_str().unwrap();
        let along = self.tags("text").into_iter().filter(|(tag, text)| {
            let beside = if axis == "x" { number(tag, "y") > bottom } else { number(tag, "x") < left };
            // The title, the legend and the name of the vertical axis start at their anchor or are turned.
            let anchor = attribute(tag, "text-anchor").unwrap_or_default();
            beside && plain(text) != label && !tag.contains("transform") && matches!(anchor, "middle" | "end")
        });
        along.map(|(tag, text)| (plain(text), number(tag, axis))).collect()
    }

    /// What a label of an axis stands for.
    fn value(&self, axis: &str, label: &str) -> f64 {
        let names = self.data[axis]["names"].as_array().map(Vec::as_slice).unwrap_or_default();
        let named = names.iter().find(|name| name[1] == label).map(|name| name[0].as_f64().unwrap());
        named.unwrap_or_else(|| label.replace('\u{2212}', "-").parse().unwrap_or_else(|_| panic!("label {label:?}")))
    }

    /// Points of each series by its name.
    fn series(&self, name: &str) -> Vec<(f64, f64)> {
        let all = self.data["series"].as_array().unwrap();
        let of: Vec<&Value> = all.iter().filter(|series| series["name"] == name).collect();
        assert!(of.len() == 1, "{}: series {name:?}", self.name());
        let pair = |point: &Value| (point[0].as_f64().unwrap(), point[1].as_f64().unwrap());
        of[0]["points"].as_array().unwrap().iter().map(pair).collect()
    }

    /// Where marks are drawn, px: centres of circles, upper edges of bars, corners of lines.
    fn marks(&self) -> Vec<(f64, f64)> {
        let circles = self.tags("circle").into_iter().map(|(tag, _)| (number(tag, "cx"), number(tag, "cy")));
        let bars = self.tags("rect").into_iter();
        let bars = bars.map(|(tag, _)| (number(tag, "x") + number(tag, "width") / 2.0, number(tag, "y")));
        let lines = self.tags("polyline").into_iter().flat_map(|(tag, _)| {
            let pair = |pair: &str| pair.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()));
            attribute(tag, "points").unwrap().split_whitespace().filter_map(pair).collect::<Vec<_>>()
        });
        circles.chain(bars).chain(lines).collect()
    }
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let open = format!(" {name}=\"");
    let at =
        tag.find(&open).map(|at| at + open.len()).or_else(|| tag.starts_with(&open[1..]).then_some(open.len() - 1))?;
    tag[at..].split('"').next()
}

fn number(tag: &str, name: &str) -> f64 {
    attribute(tag, name).unwrap_or_else(|| panic!("{name} of {tag}")).parse().unwrap()
}

/// Text without the escapes of HTML.
fn plain(text: &str) -> String {
    [("&quot;", "\""), ("&#34;", "\""), ("&#x27;", "'"), ("&#x2f;", "/"), ("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")]
        .into_iter()
        .fold(text.to_owned(), |text, (escape, letter)| text.replace(escape, letter))
}

#[test]
fn every_label_stands_at_its_value() {
    let plots = Plot::all();
    assert!(plots.len() >= 25, "{} plots", plots.len());
    for plot in plots {
        for axis in ["x", "y"] {
            let labels = plot.labels(axis);
            assert!(!labels.is_empty(), "{}: no labels along {axis}", plot.name());
            for (label, at) in labels {
                let expected = plot.position(axis, plot.value(axis, &label));
                assert!((at - expected).abs() < NEAR, "{}: {axis} {label}: {at} px, not {expected}", plot.name());
            }
        }
    }
}

#[test]
fn every_point_is_drawn_where_the_labels_say() {
    for plot in Plot::all() {
        let marks = plot.marks();
        for series in plot.data["series"].as_array().unwrap() {
            for (x, y) in plot.series(series["name"].as_str().unwrap()) {
                let (across, down) = (plot.position("x", x), plot.position("y", y));
                let near = marks.iter().any(|(a, b)| (a - across).abs() < NEAR && (b - down).abs() < NEAR);
                assert!(near, "{}: {series} has no mark at {across}, {down}", plot.name());
            }
        }
    }
}

/// Equal to the five digits that a plot carries.
fn same(drawn: f64, measured: f64) -> bool {
    (drawn - measured).abs() <= 1e-4 * measured.abs()
}

#[test]
fn plots_show_the_numbers_of_the_report() {
    for sweep in &FULL.sweeps {
        let plot = Plot::named(&format!("{}: DoG error", sweep.parameter));
        for point in &sweep.points {
            let drawn = plot.series(point.condition);
            assert!(drawn.iter().any(|(x, y)| *x == point.bits && same(*y, point.dog_rms_lsb)), "{point:?}: {drawn:?}");
            let label = point.bits.to_string();
            assert!(plot.labels("x").iter().any(|(text, _)| *text == label), "{label} is not a label");
        }
    }
    let plot = Plot::named("px; bit_true");
    let picture = &FULL.pictures[0];
    assert_eq!(plot.labels("x")[0].0, picture.name);
    let drawn = plot.series("bit_true − streaming");
    assert!(picture.displacements.iter().zip(&drawn).all(|(found, point)| same(point.1, found.difference_px)));
    assert_eq!(drawn.len(), picture.displacements.len());
    for curve in &FULL.repeatability {
        let warp = format!("{:?}", curve.warp).to_lowercase();
        let start = if warp == "tilt" { "projective tilt" } else { &warp };
        let both: Vec<Plot> = Plot::all().into_iter().filter(|plot| plot.name().starts_with(start)).collect();
        assert_eq!(both.len(), 2, "{start}");
        let drawn = both[0].series("first order");
        let samples = curve.samples.iter().zip(&drawn);
        let equal = |sample: f64, drawn: f64| same(drawn, 100.0 * sample);
        assert!(samples.into_iter().all(|(sample, point)| equal(sample.recursive.repeatability, point.1)));
    }
    // Bits are counted over all scales: a point for each frame, at the contrast that selects its class.
    let flips = Plot::named("MaxLBP bits flipped, all scales").series("this report");
    let frames: Vec<_> = FULL.pictures[0].conditions.iter().map(|of| &of.comparison).collect();
    assert_eq!(flips.len(), frames.len());
    assert!(flips.iter().zip(&frames).all(|(point, frame)| same(point.0, frame.lowest_rms_lsb())), "{flips:?}");
    let chains = Plot::named("rms error, state LSB");
    for chain in &FULL.chains {
        let drawn = chains.series(&format!("σ {} px", chain.sigma));
        assert_eq!(drawn.len(), chain.stages.len());
        assert!(drawn.iter().zip(&chain.stages).all(|(point, stage)| same(point.1, stage.rms_lsb)));
    }
}
