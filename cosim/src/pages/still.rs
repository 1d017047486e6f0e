//! A frame with its inliers: a line from the position of each in the reference to its position in the frame.

use std::fmt::Write as _;

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::Pair;
use serde::Serialize;

use hoverlock_reports::figures::background;
use hoverlock_reports::plot::PlotError;

/// A drawing and its caption.
#[derive(Debug, Serialize)]
pub(crate) struct Still {
    pub caption: String,
    pub svg: String,
}

/// Reduces a picture to at most `columns` columns by averaging squares of pixels. Returns the side of a square, px, and
/// the reduced picture.
pub fn reduced(picture: &Plane<u16>, columns: usize) -> (usize, Plane<u16>) {
    let side = picture.width().div_ceil(columns).max(1);
    let mean = |x: usize, y: usize| {
        let sum: u32 = (0..side * side).map(|i| u32::from(picture[(x * side + i % side, y * side + i / side)])).sum();
        (sum / (side * side) as u32) as u16
    };
    (side, Plane::from_fn(picture.width() / side, picture.height() / side, mean))
}

/// Draws inliers, in pixels of the whole picture, on a picture that was reduced by `step`.
pub(crate) fn still(
    name: &str,
    small: &Plane<u16>,
    step: usize,
    inliers: &[Pair],
    caption: String,
) -> Result<Still, PlotError> {
    let (width, height) = (small.width() * step, small.height() * step);
    let image = background(small).map_err(|error| PlotError::new(name, error))?;
    let mut path = String::new();
    let mut ends = String::new();
    for Pair { reference, current } in inliers {
        // Writing to a String cannot fail.
        let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", reference.x, reference.y, current.x, current.y);
        let _ = write!(ends, "M{:.1} {:.1}h.01", current.x, current.y);
    }
    let pen = width as f64 / 400.0;
    let svg = format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name}\">\
         <image width=\"{width}\" height=\"{height}\" href=\"{image}\"/>\
         <path d=\"{path}\" fill=\"none\" stroke=\"#ffcd28\" stroke-width=\"{pen:.2}\" stroke-opacity=\"0.55\"/>\
         <path d=\"{ends}\" fill=\"none\" stroke=\"#28eb5a\" stroke-width=\"{dot:.2}\" stroke-linecap=\"round\"/>\
         </svg>",
        name = minijinja::HtmlEscape(name),
        dot = 2.5 * pen,
    );
    Ok(Still { caption, svg })
}
