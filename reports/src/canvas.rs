//! Draws anti-aliased lines and discs, and letters, on a picture.

use crate::colour::Rgb;
use font8x8::legacy::BASIC_LEGACY;
use hoverlock_reference::image::plane::Plane;
use nalgebra::Vector2;

/// The colour of letters.
pub const INK: Rgb = [30, 30, 30];

/// A rectangle of pixels: columns `x0 .. x1`, rows `y0 .. y1`.
#[derive(Clone, Copy)]
#[allow(missing_docs, reason = "the description of the type explains its fields")]
pub struct Area {
    pub x0: usize,
    pub y0: usize,
    pub x1: usize,
    pub y1: usize,
}

impl Area {
    /// Creates an area of the size of a picture that begins at column `x0`.
    pub fn of(picture: &Plane<u16>, x0: usize) -> Self {
        Self { x0, y0: 0, x1: x0 + picture.width(), y1: picture.height() }
    }
}

/// The style of a line.
#[derive(Clone, Copy)]
pub struct Pen {
    /// Thickness of the line, px.
    pub thickness: f64,
    /// Colour at full opacity.
    pub colour: Rgb,
    /// Opacity, 0 to 1.
    pub opacity: f64,
}

/// A picture to draw on.
pub struct Canvas {
    /// The pixels of the drawing.
    pub picture: Plane<Rgb>,
    /// The area outside which no line or disc is drawn. Text ignores it.
    pub clip: Area,
}

impl Canvas {
    /// Draws a picture in grey into an area, stretched between the 0.5th and the 99.5th percentile.
    pub fn grey(&mut self, source: &Plane<u16>, area: &Area) {
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

    /// Draws a square of `colour` and a text after it.
    pub fn legend(&mut self, text: &str, colour: Rgb, (x0, y0): (usize, usize), scale: usize) {
        for (row, column) in (0..7).flat_map(|row| (0..7).map(move |column| (row, column))) {
            self.square((x0 + column * scale, y0 + row * scale), scale, colour);
        }
        self.text(text, INK, (x0 + 16 * scale, y0), scale);
    }

    /// Draws a text whose letters are 8 x 8 squares of `scale` pixels. Text beyond the edge of the picture is cut off.
    pub fn text(&mut self, text: &str, colour: Rgb, (x0, y0): (usize, usize), scale: usize) {
        for (place, glyph) in text.bytes().filter_map(|byte| BASIC_LEGACY.get(usize::from(byte))).enumerate() {
            for (row, bits) in glyph.iter().enumerate() {
                for column in (0..8).filter(|column| bits >> column & 1 == 1) {
                    self.square((x0 + (8 * place + column) * scale, y0 + row * scale), scale, colour);
                }
            }
        }
    }

    fn square(&mut self, (x0, y0): (usize, usize), side: usize, colour: Rgb) {
        for (x, y) in (0..side * side).map(|i| (x0 + i % side, y0 + i / side)) {
            if x < self.picture.width() && y < self.picture.height() {
                self.picture[(x, y)] = colour;
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

    /// Returns the pixels of `clip` within `reach` of `a .. b` along one axis.
    fn span(a: f64, b: f64, reach: f64, clip: (usize, usize)) -> std::ops::Range<usize> {
        let from = (a.min(b) - reach).floor().max(clip.0 as f64) as usize;
        // The cast of a negative number is 0, which gives an empty range.
        let to = ((a.max(b) + reach).ceil() + 1.0).min(clip.1 as f64) as usize;
        from..to
    }

    /// Draws a line. A line of zero or infinite length is not drawn.
    pub fn line(&mut self, a: Vector2<f64>, b: Vector2<f64>, pen: Pen) {
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

    /// Draws a disc.
    pub fn dot(&mut self, centre: Vector2<f64>, radius: f64, colour: Rgb, opacity: f64) {
        for y in Self::span(centre.y, centre.y, radius + 1.0, (self.clip.y0, self.clip.y1)) {
            for x in Self::span(centre.x, centre.x, radius + 1.0, (self.clip.x0, self.clip.x1)) {
                let distance = (Vector2::new(x as f64, y as f64) - centre).norm();
                self.cover(x, y, distance, radius, colour, opacity);
            }
        }
    }
}
