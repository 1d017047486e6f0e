//! Error maps and feature maps.
//!
//! All error maps share one colour scale, `v = sgn(e) log2(1 + |e|) / 12`, `e` in LSB of the DoG: white is an error of
//! 0, the ends are 4095 LSB. Maps of approximation and of quantisation can therefore be compared. Each point of a map
//! shows the error of greatest magnitude in a square of samples.

use std::fmt::Write as _;

use hoverlock_fixed_point::analysis::acceptance::{Comparison, dog_lsb, response};
use hoverlock_fixed_point::analysis::errors::Fate;
use hoverlock_fixed_point::analysis::levels::LevelPlanes;
use hoverlock_fixed_point::model::design::SCALES;
use hoverlock_reference::image::plane::Plane;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageError};

use crate::colour::{Rgb, diverging};
use crate::embed;
use crate::plot::{self, PlotError};

/// Octaves of error from the middle of the colour scale to its end.
const OCTAVES: f64 = 12.0;
/// Colours on each side of white. Few colours keep the PNG of a noise picture small.
const SHADES: f64 = 36.0;
/// Side of a square, samples.
const SQUARE: usize = 2;

/// Error maps and feature map of one picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figures {
    /// Error maps.
    pub maps: Vec<HeatMap>,
    /// Features under the condition with the most changes.
    pub features: FeatureMap,
}

/// One error map.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Scale pair.
    pub scale: usize,
    /// True for approximation, false for quantisation.
    pub approximation: bool,
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
    pub counts: [[usize; 4]; SCALES],
}

impl Figures {
    /// Maps of the DoG: approximation of `streaming` against `ideal`, quantisation of `bit_true` against `streaming`.
    pub(crate) fn heat_maps(&mut self, ideal: &LevelPlanes, streaming: &LevelPlanes, fixed: &LevelPlanes) {
        for scale in 0..SCALES {
            for (approximation, reference, test) in [(true, ideal, streaming), (false, streaming, fixed)] {
                let error = response(test, scale).zip_map(&response(reference, scale), |t, r| (t - r) / dog_lsb());
                let address = embed::colour_png(&pooled(&error).map(|&e| colour(e))).expect("a PNG in memory");
                self.maps.push(HeatMap { scale, approximation, address });
            }
        }
    }
}

/// The sample of greatest magnitude in every square.
fn pooled(error: &Plane<f64>) -> Plane<f64> {
    Plane::from_fn(error.width().div_ceil(SQUARE), error.height().div_ceil(SQUARE), |x, y| {
        let columns = SQUARE * x..(SQUARE * (x + 1)).min(error.width());
        let rows = SQUARE * y..(SQUARE * (y + 1)).min(error.height());
        let samples = rows.flat_map(|row| error.row(row)[columns.clone()].iter().copied());
        samples.fold(0.0, |most: f64, e| if e.abs() > most.abs() || e.is_nan() { e } else { most })
    })
}

/// Position of an error, LSB, on the colour scale, `-1 ..= 1`.
fn on_scale(error: f64) -> f64 {
    (error.abs().ln_1p() / std::f64::consts::LN_2 / OCTAVES).copysign(error)
}

fn colour(error: f64) -> Rgb {
    diverging((on_scale(error) * SHADES).round() / SHADES)
}

/// The colour bar of the maps.
///
/// # Errors
/// Formatting fails, which does not happen for a string.
pub fn colour_bar() -> Result<String, PlotError> {
    let (width, height, left) = (1040.0, 18.0, 40.0);
    let mut svg =
        String::from("<svg viewBox=\"0 0 1120 62\" role=\"img\" aria-label=\"colour bar of the error maps\">");
    let steps = 2 * SHADES as i32 + 1;
    let mut write =
        |text: std::fmt::Arguments<'_>| svg.write_fmt(text).map_err(|error| plot::failed("colour bar", error));
    for step in 0..steps {
        let [r, g, b] = diverging((f64::from(step) - SHADES) / SHADES);
        let x = left + width * f64::from(step) / f64::from(steps);
        let wide = width / f64::from(steps) + 0.5;
        write(format_args!(
            "<rect x=\"{x:.2}\" y=\"2\" width=\"{wide:.2}\" height=\"{height}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>"
        ))?;
    }
    for e in [-4095.0f64, -1023.0, -255.0, -63.0, -15.0, -3.0, -1.0, 0.0, 1.0, 3.0, 15.0, 63.0, 255.0, 1023.0, 4095.0] {
        let x = left + width * (on_scale(e) + 1.0) / 2.0;
        let label = if e < 0.0 { format!("\u{2212}{}", -e) } else { format!("{e}") };
        write(format_args!(
            "<path d=\"M{x:.1} 20v5\" stroke=\"#8b96a1\"/>\
             <text x=\"{x:.1}\" y=\"38\" text-anchor=\"middle\">{label}</text>"
        ))?;
    }
    write(format_args!(
        "<text x=\"560\" y=\"58\" text-anchor=\"middle\">\
         signed DoG error, LSB (1 LSB = full scale / 2¹⁷ = 0.5 DN)</text></svg>"
    ))?;
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
    let mut counts = [[0; 4]; SCALES];
    for fate in [Fate::Kept, Fate::Moved, Fate::New, Fate::Lost] {
        let mut path = String::new();
        for (scale, counts) in counts.iter_mut().enumerate() {
            let r = [5, 9][scale];
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

/// The frame as a JPEG `data:` URL, stretched between its 0.5th and 99.5th percentile and dimmed, so that marks stand
/// out.
fn background(frame: &Plane<u16>) -> Result<String, ImageError> {
    let mut sorted: Vec<u16> = frame.as_slice().iter().step_by(7).copied().collect();
    sorted.sort_unstable();
    let at = |part: f64| f64::from(sorted[((sorted.len() - 1) as f64 * part) as usize]);
    let (low, high) = (at(0.005), at(0.995).max(at(0.005) + 1.0));
    let grey = frame.map(|&dn| (40.0 + 190.0 * ((f64::from(dn) - low) / (high - low)).clamp(0.0, 1.0)) as u8);
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, 72).encode(
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
    fn the_colour_scale_is_symmetric_and_ends_at_4095_lsb() {
        assert_eq!(on_scale(0.0), 0.0);
        assert!((on_scale(4095.0) - 1.0).abs() < 1e-12 && (on_scale(-4095.0) + 1.0).abs() < 1e-12);
        assert!((on_scale(1.0) - 1.0 / 12.0).abs() < 1e-12);
    }

    #[test]
    fn pooling_keeps_the_error_of_greatest_magnitude() {
        let mut error = Plane::filled(5, 3, 0.1);
        error[(4, 2)] = -7.0;
        error[(1, 0)] = 3.0;
        assert_eq!(pooled(&error).as_slice(), [3.0, 0.1, 0.1, 0.1, 0.1, -7.0]);
    }
}
