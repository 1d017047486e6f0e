//! Draws the matches between two pictures: REF on the left, CUR on the right, a line for each match.
//!
//! Inliers are yellow, outliers faint blue. The green outline in CUR is the frame of REF mapped by the homography; the
//! green arrow is the displacement of the picture centre. Grey values are stretched between the 0.5th and the 99.5th
//! percentile of each picture, so that pictures of low contrast stay visible. A legend below names the colours.

use crate::colour::Rgb;
use font8x8::legacy::BASIC_LEGACY;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::{Pair, transfer};
use image::{ExtendedColorType, ImageEncoder as _, ImageError, codecs::png::PngEncoder};
use nalgebra::{Matrix3, Vector2};

const INLIER: Rgb = [255, 205, 40];
const OUTLIER: Rgb = [90, 150, 255];
const OUTLINE: Rgb = [40, 235, 90];
const PAPER: Rgb = [255, 255, 255];
const INK: Rgb = [30, 30, 30];

/// Gap between the two pictures, px.
const GAP: usize = 12;

/// Number of lines drawn at full opacity. With more lines the opacity falls in proportion.
const CLEAR_LINES: f64 = 60.0;

/// The two pictures, their matches and the estimated homography.
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    /// REF, DN.
    pub reference: &'a Plane<u16>,
    /// CUR, DN.
    pub current: &'a Plane<u16>,
    /// Matched positions.
    pub pairs: &'a [Pair],
    /// Indices of the inliers in `pairs`.
    pub inliers: &'a [usize],
    /// Maps a REF pixel to a CUR pixel; `None` where there is no estimate.
    pub homography: Option<Matrix3<f64>>,
}

impl Overlay<'_> {
    /// The drawing as a PNG file.
    ///
    /// # Errors
    /// The PNG encoder fails.
    pub fn png(&self) -> Result<Vec<u8>, ImageError> {
        let picture = self.draw();
        let bytes: Vec<u8> = picture.as_slice().iter().flatten().copied().collect();
        let mut png = Vec::new();
        PngEncoder::new(&mut png).write_image(
            &bytes,
            picture.width() as u32,
            picture.height() as u32,
            ExtendedColorType::Rgb8,
        )?;
        Ok(png)
    }

    /// The drawing.
    pub fn draw(&self) -> Plane<Rgb> {
        let left = Area::of(self.reference, 0);
        let right = Area::of(self.current, self.reference.width() + GAP);
        let legend = self.legend();
        // Letters of 8 x 8 pixels, larger on large pictures, so that they are readable where the whole is scaled down.
        let letter = 8 * (right.x1 / 900).max(1);
        let line = letter + letter / 2;
        let foot = left.y1.max(right.y1);
        let (width, height) = (right.x1, foot + line * legend.len() + line / 2);
        let mut canvas = Canvas { picture: Plane::filled(width, height, PAPER), clip: left };
        canvas.grey(self.reference, &left);
        canvas.grey(self.current, &right);

        let whole = Area { x0: 0, y0: 0, x1: width, y1: foot };
        let pen = (self.reference.width().max(self.current.width()) as f64 / 700.0).max(1.0);
        let to_right = Vector2::new(right.x0 as f64, 0.0);
        let mut agrees = vec![false; self.pairs.len()];
        for &i in self.inliers {
            agrees[i] = true;
        }
        let opacity =
            |count: usize, least: f64, most: f64| (most * CLEAR_LINES / count.max(1) as f64).clamp(least, most);
        let styles = [
            (false, OUTLIER, 0.7 * pen, opacity(self.pairs.len() - self.inliers.len(), 0.08, 0.3)),
            (true, INLIER, pen, opacity(self.inliers.len(), 0.14, 0.9)),
        ];
        for (wanted, colour, thickness, opacity) in styles {
            let of_kind = || self.pairs.iter().zip(&agrees).filter(move |(_, agrees)| **agrees == wanted);
            canvas.clip = whole;
            for (pair, _) in of_kind() {
                canvas.line(pair.reference, pair.current + to_right, Pen { thickness, colour, opacity });
            }
            // Dots keep the ends of crowded lines visible.
            for (pair, _) in of_kind() {
                for end in [pair.reference, pair.current + to_right] {
                    canvas.dot(end, 1.6 * thickness, colour, if wanted { 1.0 } else { 0.5 });
                }
            }
        }
        if let Some(h) = self.homography {
            canvas.clip = right;
            self.outline(&mut canvas, &h, to_right, pen);
        }
        for (index, (colour, text)) in legend.iter().enumerate() {
            canvas.text(text, *colour, (letter, foot + line / 2 + index * line), letter / 8);
        }
        canvas.picture
    }

    /// What each colour means.
    fn legend(&self) -> Vec<(Rgb, String)> {
        let others = self.pairs.len() - self.inliers.len();
        let mut lines = vec![
            (INLIER, format!("{} matches that agree with the motion", self.inliers.len())),
            (OUTLIER, format!("{others} matches that do not")),
        ];
        if self.homography.is_some() {
            lines.push((OUTLINE, "frame of REF in CUR, and the motion of its centre".to_owned()));
        }
        lines
    }

    fn outline(&self, canvas: &mut Canvas, h: &Matrix3<f64>, to_right: Vector2<f64>, pen: f64) {
        let (x, y) = (self.reference.width() as f64 - 1.0, self.reference.height() as f64 - 1.0);
        let corners = [(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)].map(|(x, y)| transfer(h, Vector2::new(x, y)));
        let green = |thickness: f64| Pen { thickness, colour: OUTLINE, opacity: 1.0 };
        for i in 0..4 {
            if let (Some(a), Some(b)) = (corners[i], corners[(i + 1) % 4]) {
                canvas.line(a + to_right, b + to_right, green(3.0 * pen));
            }
        }
        let centre = Vector2::new(x / 2.0, y / 2.0);
        let Some(moved) = transfer(h, centre) else { return };
        canvas.line(centre + to_right, moved + to_right, green(3.0 * pen));
        let length = (moved - centre).norm();
        if length > 0.0 {
            let back = (centre - moved) / length * (10.0 * pen).min(length);
            let side = 0.5 * Vector2::new(-back.y, back.x);
            for barb in [back + side, back - side] {
                canvas.line(moved + to_right, moved + barb + to_right, green(3.0 * pen));
            }
        }
        canvas.dot(centre + to_right, 3.0 * pen, OUTLINE, 1.0);
    }
}

/// Columns `x0 .. x1`, rows `y0 .. y1`.
#[derive(Clone, Copy)]
struct Area {
    x0: usize,
    y0: usize,
    x1: usize,
    y1: usize,
}

impl Area {
    fn of(picture: &Plane<u16>, x0: usize) -> Self {
        Self { x0, y0: 0, x1: x0 + picture.width(), y1: picture.height() }
    }
}

#[derive(Clone, Copy)]
struct Pen {
    thickness: f64,
    colour: Rgb,
    opacity: f64,
}

struct Canvas {
    picture: Plane<Rgb>,
    clip: Area,
}

impl Canvas {
    fn grey(&mut self, source: &Plane<u16>, area: &Area) {
        let mut sorted = source.as_slice().to_vec();
        let mut percentile = |part: f64| {
            let at = (part * (sorted.len() - 1) as f64) as usize;
            f64::from(*sorted.select_nth_unstable(at).1)
        };
        let (dark, light) = (percentile(0.005), percentile(0.995));
        for y in 0..source.height() {
            for x in 0..source.width() {
                let part = (f64::from(source[(x, y)]) - dark) / (light - dark).max(1.0);
                // The brightest grey stays below white, so that lines remain visible.
                let grey = (225.0 * part.clamp(0.0, 1.0)) as u8;
                self.picture[(area.x0 + x, area.y0 + y)] = [grey; 3];
            }
        }
    }

    /// A square of `colour` and a text after it, its letters 8 x 8 squares of `scale` pixels; what does not fit is cut
    /// off.
    fn text(&mut self, text: &str, colour: Rgb, (x0, y0): (usize, usize), scale: usize) {
        let mut dot = |column: usize, row: usize, colour: Rgb| {
            for (x, y) in (0..scale * scale).map(|i| (x0 + column * scale + i % scale, y0 + row * scale + i / scale)) {
                if x < self.picture.width() && y < self.picture.height() {
                    self.picture[(x, y)] = colour;
                }
            }
        };
        for (row, column) in (0..7).flat_map(|row| (0..7).map(move |column| (row, column))) {
            dot(column, row, colour);
        }
        for (place, glyph) in text.bytes().filter_map(|byte| BASIC_LEGACY.get(usize::from(byte))).enumerate() {
            for (row, bits) in glyph.iter().enumerate() {
                for column in (0..8).filter(|column| bits >> column & 1 == 1) {
                    dot(8 * (place + 2) + column, row, INK);
                }
            }
        }
    }

    /// Blends `colour` into a pixel: `opacity` times the part of the pixel within `radius`, at `distance` from the
    /// centre line.
    fn cover(&mut self, x: usize, y: usize, distance: f64, radius: f64, colour: Rgb, opacity: f64) {
        let part = opacity * (radius + 0.5 - distance).clamp(0.0, 1.0) * (2.0 * radius).min(1.0);
        let pixel = &mut self.picture[(x, y)];
        for channel in 0..3 {
            let (old, new) = (f64::from(pixel[channel]), f64::from(colour[channel]));
            pixel[channel] = (old + part * (new - old)).round() as u8;
        }
    }

    /// The whole pixels of `clip` within `reach` of `a .. b` along one axis.
    fn span(a: f64, b: f64, reach: f64, clip: (usize, usize)) -> std::ops::Range<usize> {
        let from = (a.min(b) - reach).floor().max(clip.0 as f64) as usize;
        // The cast of a negative number is 0, which gives an empty range.
        let to = ((a.max(b) + reach).ceil() + 1.0).min(clip.1 as f64) as usize;
        from..to
    }

    fn line(&mut self, a: Vector2<f64>, b: Vector2<f64>, pen: Pen) {
        let along = b - a;
        let length2 = along.norm_squared();
        if length2 == 0.0 || !length2.is_finite() {
            return;
        }
        let radius = pen.thickness / 2.0;
        let steep = along.y.abs() > along.x.abs();
        let clip = self.clip;
        let (major, minor) = if steep { (1, 0) } else { (0, 1) };
        let (clips, clips_minor) =
            if steep { ((clip.y0, clip.y1), (clip.x0, clip.x1)) } else { ((clip.x0, clip.x1), (clip.y0, clip.y1)) };
        let slope = along[minor] / along[major];
        for m in Self::span(a[major], b[major], radius + 1.0, clips) {
            let middle = a[minor] + slope * (m as f64 - a[major]);
            // A line at 45 degrees extends sqrt(2) times its radius along an axis.
            for n in Self::span(middle, middle, 1.5 * (radius + 1.0), clips_minor) {
                let (x, y) = if steep { (n, m) } else { (m, n) };
                let p = Vector2::new(x as f64, y as f64) - a;
                let t = (p.dot(&along) / length2).clamp(0.0, 1.0);
                self.cover(x, y, (p - t * along).norm(), radius, pen.colour, pen.opacity);
            }
        }
    }

    fn dot(&mut self, centre: Vector2<f64>, radius: f64, colour: Rgb, opacity: f64) {
        for y in Self::span(centre.y, centre.y, radius + 1.0, (self.clip.y0, self.clip.y1)) {
            for x in Self::span(centre.x, centre.x, radius + 1.0, (self.clip.x0, self.clip.x1)) {
                let distance = (Vector2::new(x as f64, y as f64) - centre).norm();
                self.cover(x, y, distance, radius, colour, opacity);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 100;

    fn drawn(pairs: &[Pair], inliers: &[usize], homography: Option<Matrix3<f64>>) -> Plane<Rgb> {
        let reference = Plane::from_fn(SIDE, SIDE, |x, _| 300 * x as u16);
        let current = Plane::filled(SIDE + 20, SIDE - 10, 7u16);
        let overlay = Overlay { reference: &reference, current: &current, pairs, inliers, homography };
        let decoded = image::load_from_memory(&overlay.png().unwrap()).unwrap().to_rgb8();
        let picture = overlay.draw();
        assert_eq!(decoded.dimensions(), (picture.width() as u32, picture.height() as u32));
        assert!(decoded.pixels().zip(picture.as_slice()).all(|(a, b)| a.0 == *b));
        picture
    }

    fn shift(x: f64, y: f64) -> Matrix3<f64> {
        Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0)
    }

    #[test]
    fn pictures_are_drawn_side_by_side() {
        let picture = drawn(&[], &[], None);
        assert_eq!(picture.width(), SIDE + GAP + SIDE + 20);
        assert!(picture.height() > SIDE + 20, "a legend below");
        assert!(picture[(10, 50)][0] < picture[(80, 50)][0], "the ramp of REF");
        assert_eq!(picture[(SIDE + GAP / 2, 50)], PAPER);
        assert_eq!(picture[(SIDE + GAP + 50, SIDE - 1)], PAPER, "below the shorter picture");
    }

    #[test]
    fn the_homography_maps_the_outline_of_ref_into_cur() {
        let picture = drawn(&[], &[], Some(shift(30.0, 20.0)));
        let right = SIDE + GAP;
        for x in [31, 60, 119] {
            assert_eq!(picture[(right + x, 20)], OUTLINE, "upper edge at {x}");
        }
        assert_eq!(picture[(right + 30, 60)], OUTLINE, "left edge");
        assert_ne!(picture[(right + 60, 40)], OUTLINE);
        // The legend below the pictures shows the colour of the outline too.
        assert!(picture.rows().take(SIDE).all(|row| !row[..right].contains(&OUTLINE)), "the outline stays outside REF");
    }

    #[test]
    fn inliers_are_more_visible_than_outliers() {
        let pair = |y: f64| Pair { reference: Vector2::new(20.0, y), current: Vector2::new(40.0, y) };
        let picture = drawn(&[pair(30.0), pair(60.0)], &[1], None);
        let middle = SIDE + GAP / 2;
        let distance = |pixel: Rgb, colour: Rgb| (0..3).map(|c| pixel[c].abs_diff(colour[c]) as u32).sum::<u32>();
        assert!(distance(picture[(middle, 60)], INLIER) < 60, "{:?}", picture[(middle, 60)]);
        assert!(distance(picture[(middle, 30)], PAPER) < distance(picture[(middle, 30)], OUTLIER), "faint");
        assert_ne!(picture[(middle, 30)], PAPER);
        let below: Vec<_> = picture.rows().skip(SIDE).flatten().collect();
        for colour in [INLIER, OUTLIER, INK] {
            assert!(below.contains(&&colour), "{colour:?} is in the legend");
        }
        assert!(!below.contains(&&OUTLINE), "no frame is drawn, so none is explained");
        assert_eq!(picture[(20, 60)], INLIER, "the end is marked");
    }

    #[test]
    fn degenerate_homographies_and_positions_outside_do_not_panic() {
        let far = Pair { reference: Vector2::new(-1e9, 1e9), current: Vector2::new(1e12, -5.0) };
        let mut singular = shift(1e8, -1e8);
        singular[(2, 0)] = -0.02;
        drawn(&[far], &[0], Some(singular));
        drawn(&[far], &[], Some(Matrix3::from_element(f64::NAN)));
    }
}
