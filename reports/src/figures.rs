//! Error maps and feature maps.
//!
//! Each error map has its own colour scale. The scale is linear from `-full` to `full`, and `full` is the 99.9th
//! percentile of the magnitudes in the map. White is an error of 0, and errors beyond the ends have the colours of the
//! ends. The scale is printed under the map. Each point of a map shows the error of greatest magnitude in a square of
//! samples.

use std::fmt::Write as _;

use hoverlock_fixed_point::analysis::acceptance::{Comparison, dog_lsb, response};
use hoverlock_fixed_point::analysis::errors::Fate;
use hoverlock_fixed_point::analysis::levels::LevelPlanes;
use hoverlock_reference::image::plane::Plane;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageError};

use crate::colour::{Rgb, diverging};
use crate::embed;
use crate::plot::PlotError;

/// Number of colours on each side of white. Few colours keep the PNG of a noise picture small.
const SHADES: f64 = 12.0;
/// Side of a square, samples.
const SQUARE: usize = 4;
/// Fraction of the points of a map that its scale covers.
const COVERED_FRACTION: f64 = 0.999;

/// Error maps and feature map of one picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figures {
    /// Error maps of approximation and quantisation.
    pub maps: Vec<HeatMap>,
    /// Features under the condition with the most changes.
    pub features: FeatureMap,
}

/// One error map.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Index of the scale pair.
    pub scale: usize,
    /// True for approximation, false for quantisation.
    pub approximation: bool,
    /// End of the colour scale, LSB.
    pub full: f64,
    /// Largest magnitude of a finite error, LSB.
    pub max: f64,
    /// The map as a `data:` URL.
    pub address: String,
}

/// Features drawn on the frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FeatureMap {
    /// The condition shown.
    pub condition: &'static str,
    /// The drawing, an `<svg>` element.
    pub svg: String,
    /// Features kept, moved, lost and new, per scale.
    pub counts: Vec<[usize; 4]>,
}

impl Figures {
    /// Draws the maps of the DoG: approximation of `streaming` against `ideal`, quantisation of `bit_true` against
    /// `streaming`.
    pub(crate) fn heat_maps(&mut self, ideal: &LevelPlanes, streaming: &LevelPlanes, fixed: &LevelPlanes) {
        for scale in 0..fixed.dog.len() {
            for (approximation, reference, test) in [(true, ideal, streaming), (false, streaming, fixed)] {
                let error = response(test, scale).zip_map(&response(reference, scale), |t, r| (t - r) / dog_lsb());
                let pooled = pooled(&error);
                let (full, max) = scale_of(&pooled);
                let address = embed::colour_png(&pooled.map(|&e| colour(e, full))).expect("a PNG in memory");
                self.maps.push(HeatMap { scale, approximation, full, max, address });
            }
        }
    }
}

/// Reduces a plane to the sample of greatest magnitude in each square.
fn pooled(error: &Plane<f64>) -> Plane<f64> {
    Plane::from_fn(error.width().div_ceil(SQUARE), error.height().div_ceil(SQUARE), |x, y| {
        let columns = SQUARE * x..(SQUARE * (x + 1)).min(error.width());
        let rows = SQUARE * y..(SQUARE * (y + 1)).min(error.height());
        let samples = rows.flat_map(|row| error.row(row)[columns.clone()].iter().copied());
        samples.fold(0.0, |most: f64, e| if e.abs() > most.abs() || e.is_nan() { e } else { most })
    })
}

/// Returns the end of the colour scale of a map, and the largest magnitude of a finite error, both in LSB; `(1, 0)` for
/// a map without errors.
fn scale_of(map: &Plane<f64>) -> (f64, f64) {
    let mut sorted: Vec<f64> = map.as_slice().iter().map(|e| e.abs()).filter(|e| e.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let most = sorted.last().copied().unwrap_or(0.0);
    let full = sorted.get((sorted.len() as f64 * COVERED_FRACTION) as usize).copied().unwrap_or(most);
    let full = [full, most].into_iter().find(|end| *end > 0.0).unwrap_or(1.0);
    (full, most)
}

fn colour(error: f64, full: f64) -> Rgb {
    diverging((error / full * SHADES).round() / SHADES)
}

/// Draws the colour bar of the maps, from one end of a scale to the other.
///
/// # Errors
/// Formatting fails, which does not happen for a string.
pub(crate) fn colour_bar() -> Result<String, PlotError> {
    let (width, height, left) = (1040.0, 18.0, 40.0);
    let mut svg = String::from(
        "<svg viewBox=\"0 0 1120 44\" role=\"img\" aria-label=\"colour bar of the error maps: blue below zero, white \
         at zero, red above\">",
    );
    let steps = 2 * SHADES as i32 + 1;
    let mut write =
        |text: std::fmt::Arguments<'_>| svg.write_fmt(text).map_err(|error| PlotError::new("colour bar", error));
    for step in 0..steps {
        let [r, g, b] = diverging((f64::from(step) - SHADES) / SHADES);
        let x = left + width * f64::from(step) / f64::from(steps);
        let wide = width / f64::from(steps) + 0.5;
        write(format_args!(
            "<rect x=\"{x:.2}\" y=\"2\" width=\"{wide:.2}\" height=\"{height}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>"
        ))?;
    }
    for (part, label) in [(0.0, "\u{2212}full"), (0.5, "0"), (1.0, "full")] {
        let x = left + width * part;
        write(format_args!(
            "<path d=\"M{x:.1} 20v5\" stroke=\"#8b96a1\"/>\
             <text x=\"{x:.1}\" y=\"40\" text-anchor=\"middle\">{label}</text>"
        ))?;
    }
    write(format_args!("</svg>"))?;
    Ok(svg)
}

/// Draws kept, moved, lost and new features on the frame; the size of a mark is the scale.
pub(crate) fn overlay(frame: &Plane<u16>, comparison: &Comparison, condition: &'static str) -> FeatureMap {
    let mut svg = format!(
        "<svg viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"features of streaming and bit_true\">\
         <image width=\"{w}\" height=\"{h}\" href=\"{}\"/>",
        background(frame).expect("a JPEG in memory, no larger than the frame"),
        w = frame.width(),
        h = frame.height()
    );
    let mut counts = vec![[0; 4]; comparison.scales.len()];
    for fate in [Fate::Kept, Fate::Moved, Fate::New, Fate::Lost] {
        let mut path = String::new();
        for (scale, counts) in counts.iter_mut().enumerate() {
            let r = [5, 9, 14][scale];
            let of_fate = comparison.scales[scale].kept.fates.iter().filter(|(_, _, of)| *of == fate);
            for (x, y, _) in of_fate {
                counts[fate as usize] += 1;
                // Writing to a string cannot fail.
                let _ = match fate {
                    Fate::Kept => {
                        write!(path, "M{} {y}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0", i64::from(*x) - r, d = 2 * r)
                    }
                    Fate::Moved => write!(path, "M{x} {}l{r} {r}l-{r} {r}l-{r} -{r}z", i64::from(*y) - r),
                    Fate::Lost => {
                        let (left, top, d) = (i64::from(*x) - r, i64::from(*y) - r, 2 * r);
                        write!(path, "M{left} {top}l{d} {d}m-{d} 0l{d} -{d}")
                    }
                    Fate::New => {
                        let (left, top, d) = (i64::from(*x) - r, i64::from(*y) - r, 2 * r);
                        write!(path, "M{x} {top}v{d}M{left} {y}h{d}")
                    }
                };
            }
        }
        let class = match fate {
            Fate::Kept => "kept",
            Fate::Moved => "moved",
            Fate::Lost => "lost",
            Fate::New => "new",
        };
        let _ = write!(svg, "<path class=\"halo {class}\" d=\"{path}\"/><path class=\"{class}\" d=\"{path}\"/>");
    }
    svg.push_str("</svg>");
    FeatureMap { condition, svg, counts }
}

/// Encodes a frame as a JPEG `data:` URL, stretched between its 0.5th and 99.5th percentile and dimmed, so that marks
/// stand out.
pub fn background(frame: &Plane<u16>) -> Result<String, ImageError> {
    let mut sorted: Vec<u16> = frame.as_slice().iter().step_by(7).copied().collect();
    sorted.sort_unstable();
    let at = |part: f64| f64::from(sorted[((sorted.len() - 1) as f64 * part) as usize]);
    let (low, high) = (at(0.005), at(0.995).max(at(0.005) + 1.0));
    let grey = frame.map(|&dn| (40.0 + 190.0 * ((f64::from(dn) - low) / (high - low)).clamp(0.0, 1.0)) as u8);
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, 35).encode(
        grey.as_slice(),
        grey.width() as u32,
        grey.height() as u32,
        ExtendedColorType::L8,
    )?;
    Ok(embed::address("image/jpeg", &jpeg))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_covers_all_but_a_thousandth_of_its_map() {
        let mut map = Plane::from_fn(100, 50, |x, _| if x % 2 == 0 { 3.0 } else { -2.0 });
        map[(7, 7)] = -900.0;
        assert_eq!(scale_of(&map), (3.0, 900.0));
        assert_eq!((colour(3.0, 3.0), colour(900.0, 3.0)), (diverging(1.0), diverging(1.0)));
        assert_eq!((colour(-3.0, 3.0), colour(0.0, 3.0)), (diverging(-1.0), diverging(0.0)));
        // Nearly no errors, and none.
        let mut few = Plane::filled(100, 50, 0.0);
        assert_eq!(scale_of(&few), (1.0, 0.0));
        few[(1, 1)] = 0.5;
        assert_eq!(scale_of(&few), (0.5, 0.5));
    }

    #[test]
    fn pooling_keeps_the_error_of_greatest_magnitude() {
        let mut error = Plane::filled(9, 6, 0.1);
        error[(8, 5)] = -7.0;
        error[(1, 3)] = 3.0;
        assert_eq!(pooled(&error).as_slice(), [3.0, 0.1, 0.1, 0.1, 0.1, -7.0]);
    }
}
