//! Draws the matches between two pictures: REF on the left, CUR on the right, dots for all matches, lines for a sample.
//!
//! Inliers are yellow, outliers faint blue. In CUR a red stick begins where the homography maps each inlier and shows
//! its residual, enlarged. The green outline in CUR is the frame of REF mapped by the homography; the green arrow is
//! the displacement of the picture centre. Grey values are stretched between the 0.5th and the 99.5th percentile of
//! each picture, so that pictures of low contrast stay visible. A legend below names the colours.

use crate::canvas::{Area, Canvas, Pen};
use crate::colour::Rgb;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::{Pair, transfer};
use image::{ExtendedColorType, ImageEncoder as _, ImageError, codecs::png::PngEncoder};
use nalgebra::{Matrix3, Vector2};

const INLIER: Rgb = [255, 205, 40];
const OUTLIER: Rgb = [90, 150, 255];
const OUTLINE: Rgb = [40, 235, 90];
const RESIDUAL: Rgb = [255, 70, 60];
const PAPER: Rgb = [255, 255, 255];

/// Gap between the two pictures, px.
const GAP: usize = 12;

/// Largest number of lines of one kind: of more matches, one in so many has a line. More lines hide the pictures.
const MAX_LINES: usize = 60;

/// Factor by which residuals are enlarged: they are fractions of a pixel.
const RESIDUAL_SCALE: f64 = 20.0;

/// The two pictures, their matches and the estimated homography.
#[derive(Debug, Clone, Copy)]
pub struct Overlay<'a> {
    /// The picture REF, DN.
    pub reference: &'a Plane<u16>,
    /// The picture CUR, DN.
    pub current: &'a Plane<u16>,
    /// Positions of the matches, px.
    pub pairs: &'a [Pair],
    /// Indices of the inliers in `pairs`.
    pub inliers: &'a [usize],
    /// Maps a REF pixel to a CUR pixel; `None` without an estimate.
    pub homography: Option<Matrix3<f64>>,
}

impl Overlay<'_> {
    /// Returns the drawing as a PNG file.
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

    /// Draws both pictures and the matches.
    pub fn draw(&self) -> Plane<Rgb> {
        let left = Area::of(self.reference, 0);
        let right = Area::of(self.current, self.reference.width() + GAP);
        let legend = self.legend();
        // Letters of 8 x 8 pixels, larger on large pictures, so that they stay readable when the drawing is scaled
        // down.
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
        let [inliers, outliers] = self.counts();
        let styles = [(false, OUTLIER, 0.7 * pen, 0.3, outliers), (true, INLIER, pen, 0.9, inliers)];
        for (wanted, colour, thickness, opacity, count) in styles {
            let of_kind = || self.pairs.iter().zip(&agrees).filter(move |(_, agrees)| **agrees == wanted);
            canvas.clip = whole;
            for (pair, _) in of_kind().step_by(one_in(count)) {
                canvas.line(pair.reference, pair.current + to_right, Pen { thickness, colour, opacity });
            }
            // Matches without a line are dots only.
            for (pair, _) in of_kind() {
                for end in [pair.reference, pair.current + to_right] {
                    canvas.dot(end, 1.6 * thickness, colour, if wanted { 1.0 } else { 0.5 });
                }
            }
        }
        if let Some(h) = self.homography {
            canvas.clip = right;
            for &i in self.inliers {
                let Pair { reference, current } = self.pairs[i];
                let Some(mapped) = transfer(&h, reference) else { continue };
                let end = mapped + RESIDUAL_SCALE * (current - mapped);
                canvas.line(mapped + to_right, end + to_right, Pen { thickness: pen, colour: RESIDUAL, opacity: 1.0 });
            }
            self.outline(&mut canvas, &h, to_right, pen);
        }
        for (index, (colour, text)) in legend.iter().enumerate() {
            canvas.legend(text, *colour, (letter, foot + line / 2 + index * line), letter / 8);
        }
        canvas.picture
    }

    /// Returns the numbers of inliers and outliers.
    fn counts(&self) -> [usize; 2] {
        [self.inliers.len(), self.pairs.len() - self.inliers.len()]
    }

    /// Returns the meaning of each colour.
    fn legend(&self) -> Vec<(Rgb, String)> {
        let [inliers, outliers] = self.counts();
        let lines_of = |count: usize| match one_in(count) {
            1 => String::new(),
            several => format!(", a line for one in {several}"),
        };
        let mut lines = vec![
            (INLIER, format!("{inliers} matches that agree with the motion{}", lines_of(inliers))),
            (OUTLIER, format!("{outliers} matches that do not{}", lines_of(outliers))),
        ];
        if self.homography.is_some() {
            lines.push((RESIDUAL, format!("their residuals, {RESIDUAL_SCALE} times as long")));
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

/// Returns of how many matches of a kind one has a line.
fn one_in(count: usize) -> usize {
    count.div_ceil(MAX_LINES).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::INK;

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

    /// Two residuals of half a pixel to the right are drawn as 10 px; of many matches only some have a line.
    #[test]
    fn residuals_are_enlarged_and_lines_are_a_sample() {
        let pair = |y: f64| Pair { reference: Vector2::new(20.0, y), current: Vector2::new(50.5, y) };
        let picture = drawn(&[pair(30.0)], &[0], Some(shift(30.0, 0.0)));
        let right = SIDE + GAP;
        let reds = |x: usize| picture[(right + x, 30)] == RESIDUAL;
        assert!(reds(54) && reds(58) && !reds(62), "{:?}", picture[(right + 55, 30)]);

        let many: Vec<Pair> = (0..90).map(|i| pair(5.0 + f64::from(i) * 0.9)).collect();
        let picture = drawn(&many, &(0..90).collect::<Vec<_>>(), None);
        let gap = SIDE + GAP / 2;
        let crossed = (0..SIDE - 10).filter(|&y| picture[(gap, y)] != PAPER).count();
        let whole = drawn(&many[..45], &(0..45).collect::<Vec<_>>(), None);
        let crossed_whole = (0..SIDE - 10).filter(|&y| whole[(gap, y)] != PAPER).count();
        assert!(crossed < 2 * crossed_whole, "{crossed} {crossed_whole}");
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
