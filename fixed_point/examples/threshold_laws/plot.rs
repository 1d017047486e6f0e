//! Features against frames: one panel a sequence, both laws in each.

use std::fmt::Write;

/// A sequence: the frames in which the picture changes, and the features of each frame by both laws, the count first.
pub struct Panel {
    pub title: &'static str,
    pub changes: Vec<usize>,
    pub laws: [Vec<usize>; 2],
}

/// Lines that are the same in each panel.
pub struct Marks {
    /// Features of both scale pairs that are wanted.
    pub target: f64,
    /// Share of the target by which the features may differ from it.
    pub tolerance: f64,
    /// Features that a frame sends at most.
    pub limit: f64,
}

const LAWS: [(&str, &str, f64); 2] =
    [("law of the count", "#d98032", 1.2), ("law of the distribution", "#1f5fa8", 1.8)];
/// Panels beside each other.
const COLUMNS: usize = 2;
/// Size of a panel's axes, px.
const AXES: (f64, f64) = (400.0, 130.0);
/// Space left of the axes, above them and below them, px.
const SPACE: (f64, f64, f64) = (62.0, 30.0, 26.0);
/// Space above the panels, for the legend, px.
const HEAD: f64 = 34.0;
/// Features at the lower and the upper end of the logarithmic axis; a frame without any is at the lower end.
const RANGE: (f64, f64) = (10.0, 20_000.0);

/// Draws the panels as SVG.
pub fn svg(panels: &[Panel], marks: &Marks) -> String {
    let (width, height) = (SPACE.0 + AXES.0 + 12.0, SPACE.1 + AXES.1 + SPACE.2);
    let rows = panels.len().div_ceil(COLUMNS);
    let (whole, high) = (width * COLUMNS as f64, HEAD + height * rows as f64);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {whole} {high}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"{whole}\" height=\"{high}\" fill=\"white\"/>\n"
    );
    let entries = LAWS.iter().map(|(name, colour, width)| (*name, *colour, *width, ""));
    let entries = entries.chain([("record limit", "#666", 1.0, " stroke-dasharray=\"5 3\"")]);
    let mut x = SPACE.0;
    for (name, colour, width, dash) in entries {
        let _ = writeln!(
            text,
            "<path d=\"M{x} 16h26\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>\
             <text x=\"{}\" y=\"20\">{name}</text>",
            x + 32.0
        );
        x += 170.0;
    }
    let share = 100.0 * marks.tolerance;
    let _ = writeln!(
        text,
        "<rect x=\"{x}\" y=\"9\" width=\"26\" height=\"13\" fill=\"#bfe3c3\"/>\
         <text x=\"{}\" y=\"20\">target \u{b1} {share} %</text>",
        x + 32.0
    );
    let _ =
        writeln!(text, "<text x=\"{:.0}\" y=\"20\" text-anchor=\"end\">features against frame</text>", whole - 12.0);
    for (at, panel) in panels.iter().enumerate() {
        let (x, y) = (width * (at % COLUMNS) as f64 + SPACE.0, HEAD + height * (at / COLUMNS) as f64 + SPACE.1);
        let _ = writeln!(text, "<g transform=\"translate({x} {y})\">\n{}</g>", axes(panel, marks));
    }
    text + "</svg>\n"
}

/// Returns the height of a number of features.
fn at(features: f64) -> f64 {
    let part = (features.clamp(RANGE.0, RANGE.1) / RANGE.0).ln() / (RANGE.1 / RANGE.0).ln();
    AXES.1 * (1.0 - part)
}

fn axes(panel: &Panel, marks: &Marks) -> String {
    let (width, height) = AXES;
    let frames = panel.laws[0].len();
    let across = |frame: usize| width * frame as f64 / frames as f64;
    let [upper, lower] = [1.0, -1.0].map(|side| at(marks.target * (1.0 + side * marks.tolerance)));
    let mut text = format!(
        "<text y=\"-8\" font-weight=\"bold\">{}</text>\n\
         <rect y=\"{upper:.1}\" width=\"{width}\" height=\"{:.1}\" fill=\"#bfe3c3\"/>\n\
         <path d=\"M0 {limit:.1}h{width}\" stroke=\"#666\" stroke-dasharray=\"5 3\"/>\n",
        panel.title,
        lower - upper,
        limit = at(marks.limit)
    );
    for features in [10, 100, 1000, 10_000] {
        let y = at(f64::from(features));
        let _ = writeln!(
            text,
            "<path d=\"M-4 {y:.1}h4\" stroke=\"#333\"/>\
             <text x=\"-8\" y=\"{:.1}\" text-anchor=\"end\">{features}</text>",
            y + 4.0
        );
    }
    for &change in &panel.changes {
        let x = across(change);
        let _ = writeln!(
            text,
            "<path d=\"M{x:.1} 0v{height}\" stroke=\"#aaa\"/>\
             <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{change}</text>",
            height + 15.0
        );
    }
    for (counts, (_, colour, width)) in panel.laws.iter().zip(LAWS) {
        let points: String = counts
            .iter()
            .enumerate()
            .map(|(frame, count)| format!(" {:.1},{:.1}", across(frame), at(*count as f64)))
            .collect();
        let _ = writeln!(
            text,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>",
            points.trim()
        );
    }
    let _ = writeln!(text, "<rect width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#333\"/>");
    text
}
