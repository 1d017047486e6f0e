//! The plot of the ranges observed in each format.

use crate::plot::{Axis, BLUE, Chart, Mark, ORANGE, PlotError, RED, Series};
use crate::study::Study;

/// Plots one band for each node. Bar height is the share of the samples in that power of two; the colour is that of in
/// range, overflow or underflow.
pub(super) fn plot(study: &Study) -> Result<String, PlotError> {
    let rows = &study.format_groups;
    let exponents = || rows.iter().flat_map(|row| row.histogram.iter().map(|bin| bin.0));
    let (least, most) = (exponents().min().unwrap_or(-2).max(-12), exponents().max().unwrap_or(16));
    let fits = [("in range", BLUE), ("overflow", RED), ("underflow", ORANGE)];
    let band = |index: usize| (rows.len() - 1 - index) as f64;
    let series = fits.map(|(name, colour)| {
        let points = rows.iter().enumerate().flat_map(|(index, row)| {
            let top = row.histogram.iter().map(|bin| bin.1).max().unwrap_or(1) as f64;
            let bins = row.histogram.iter().filter(move |bin| bin.2 == name);
            // The square root keeps small shares visible.
            bins.map(move |bin| (f64::from(bin.0.max(least)), band(index), 0.82 * (bin.1 as f64 / top).sqrt()))
        });
        (Series { name: name.into(), colour, mark: Mark::Dots(0), points: Vec::new() }, points.collect::<Vec<_>>())
    });
    let y_ticks =
        rows.iter().enumerate().map(|(index, row)| (band(index) + 0.3, format!("{}  {}", row.node, row.format)));
    let x_ticks = (least..=most).filter(|e| e % 2 == 0).map(|e| (f64::from(e), superscript(e))).collect();
    let mut bars: Vec<Series> = Vec::new();
    for (named, points) in series {
        bars.push(named.clone());
        let columns = points.into_iter().map(|(x, from, height)| Series {
            name: String::new(),
            colour: named.colour,
            mark: Mark::Columns { from, width: 0.9 },
            points: vec![(x + 0.5, from + height)],
        });
        bars.extend(columns);
    }
    Chart {
        title: String::new(),
        size: (1040, 70 + 34 * rows.len() as u32),
        x: Axis::ticked("magnitude, DN", f64::from(least), f64::from(most) + 1.0, x_ticks),
        y: Axis::ticked("", -0.1, rows.len() as f64, y_ticks.collect()),
        series: bars,
        rules: Vec::new(),
    }
    .svg()
}

/// Formats `2^exponent` with superscript digits.
fn superscript(exponent: i32) -> String {
    let text = exponent.to_string();
    let digits = text.chars().map(|c| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    });
    std::iter::once('2').chain(digits).collect()
}
