//! A hover as an animated PNG: the camera's picture, and beside it the position of the helicopter from above.

use std::time::Duration;

use hoverlock_reference::image::plane::Plane;
use nalgebra::Vector2;
use png::{BitDepth, ColorType, Encoder, EncodingError};

use hoverlock_reports::canvas::{Area, Canvas, Pen};
use hoverlock_reports::colour::Rgb;

const PAPER: Rgb = [250, 251, 252];
const INK: Rgb = [40, 50, 62];
const GRID: Rgb = [220, 225, 230];
const TRUE: Rgb = [214, 122, 30];
const ESTIMATE: Rgb = [31, 95, 168];
const INLIER: Rgb = [40, 235, 90];
const WIND: Rgb = [110, 130, 150];

/// Number of grey levels of the picture. Fewer levels make a smaller file.
const GREY_LEVELS: u32 = 24;

/// Height of the text below the map, px.
const TEXT_HEIGHT: usize = 62;

/// Width of the text, px.
const TEXT_WIDTH: usize = 176;

/// A frame of the animation.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The camera's picture, reduced.
    pub picture: Plane<u16>,
    /// Inliers, px of `picture`.
    pub inliers: Vec<Vector2<f64>>,
    /// Time since the start, s.
    pub time: f64,
    /// True position relative to the target along `X_e` and `Y_e`, m.
    pub place: Vector2<f64>,
    /// Estimated position relative to the target along `X_e` and `Y_e`, m.
    pub estimate: Option<Vector2<f64>>,
    /// Wind along `X_e` and `Y_e`, m/s.
    pub wind: Vector2<f64>,
}

/// Encodes the scenes as an animation that repeats without end and shows each scene for `pause`. The map shows `reach`
/// metres around the target.
///
/// # Errors
/// The PNG encoder fails.
pub fn apng(scenes: &[Scene], pause: Duration, reach: f64) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let Some(first) = scenes.first() else { return Ok(file) };
    let levels = greys(&first.picture);
    let drawn: Vec<_> = (0..scenes.len()).map(|i| draw(&scenes[..=i], levels, reach)).collect();
    let mut encoder = Encoder::new(&mut file, drawn[0].width() as u32, drawn[0].height() as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_animated(drawn.len() as u32, 0)?;
    encoder.set_frame_delay(pause.as_millis() as u16, 1000)?;
    let mut writer = encoder.write_header()?;
    for picture in &drawn {
        let bytes: Vec<u8> = picture.as_slice().iter().flatten().copied().collect();
        writer.write_image_data(&bytes)?;
    }
    writer.finish()?;
    Ok(file)
}

/// Returns the 0.5th and the 99.5th percentile.
fn greys(picture: &Plane<u16>) -> (f64, f64) {
    let mut sorted = picture.as_slice().to_vec();
    sorted.sort_unstable();
    let at = |part: f64| f64::from(sorted[((sorted.len() - 1) as f64 * part) as usize]);
    (at(0.005), at(0.995).max(at(0.005) + 1.0))
}

/// Draws the last of the scenes, with the track that led there.
fn draw(scenes: &[Scene], (dark, light): (f64, f64), reach: f64) -> Plane<Rgb> {
    let scene = &scenes[scenes.len() - 1];
    let (width, height) = (scene.picture.width(), scene.picture.height());
    let side = height - TEXT_HEIGHT;
    let whole = Area { x0: 0, y0: 0, x1: width + side.max(TEXT_WIDTH), y1: height };
    let mut canvas = Canvas { picture: Plane::filled(whole.x1, whole.y1, PAPER), clip: whole };
    for y in 0..height {
        for x in 0..width {
            let part = ((f64::from(scene.picture[(x, y)]) - dark) / (light - dark)).clamp(0.0, 1.0);
            let level = (part * f64::from(GREY_LEVELS - 1)).round() as u32;
            canvas.picture[(x, y)] = [(level * 235 / (GREY_LEVELS - 1)) as u8; 3];
        }
    }
    canvas.clip = Area { x1: width, ..whole };
    for &place in &scene.inliers {
        canvas.dot(place, 1.2, INLIER, 1.0);
    }

    canvas.clip = Area { x0: width, y1: side, ..whole };
    let half = side as f64 / 2.0;
    let middle = Vector2::new(width as f64 + half, half);
    let scale = (half - 6.0) / reach;
    let at = |place: Vector2<f64>| middle + scale * place;
    let thin = |colour| Pen { thickness: 1.0, colour, opacity: 1.0 };
    // Grid lines are a tenth of a metre apart, or a metre on a large map.
    let step = if reach <= 0.6 { 0.1 } else { 1.0 };
    for i in -(reach / step) as i32..=(reach / step) as i32 {
        let offset = f64::from(i) * step;
        canvas.line(at(Vector2::new(offset, -reach)), at(Vector2::new(offset, reach)), thin(GRID));
        canvas.line(at(Vector2::new(-reach, offset)), at(Vector2::new(reach, offset)), thin(GRID));
    }
    let mut track = |of: fn(&Scene) -> Option<Vector2<f64>>, colour| {
        let places: Vec<_> = scenes.iter().filter_map(of).collect();
        for pair in places.windows(2) {
            canvas.line(at(pair[0]), at(pair[1]), Pen { thickness: 1.6, colour, opacity: 0.7 });
        }
        if let Some(&last) = places.last() {
            canvas.dot(at(last), 4.0, colour, 1.0);
        }
    };
    track(|scene| Some(scene.place), TRUE);
    track(|scene| scene.estimate, ESTIMATE);
    // An arrow of 5 px stands for 1 m/s.
    let arrow = 5.0 * scene.wind;
    let foot = Vector2::new(width as f64 + 34.0, 34.0);
    canvas.line(foot - arrow / 2.0, foot + arrow / 2.0, Pen { thickness: 2.0, colour: WIND, opacity: 1.0 });
    canvas.dot(foot + arrow / 2.0, 3.0, WIND, 1.0);

    let lines = [
        (INK, format!("t {:5.1} s   grid {step} m", scene.time)),
        (TRUE, format!("is       {:4.0} cm off", 100.0 * scene.place.norm())),
        match scene.estimate {
            Some(estimate) => (ESTIMATE, format!("estimate {:4.0} cm off", 100.0 * estimate.norm())),
            None => (ESTIMATE, "no estimate".to_owned()),
        },
        (WIND, format!("wind     {:4.1} m/s", scene.wind.norm())),
    ];
    for (row, (colour, text)) in lines.iter().enumerate() {
        canvas.text(text, *colour, (width + 10, side + 6 + 14 * row), 1);
    }
    canvas.picture
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(time: f64, place: f64) -> Scene {
        Scene {
            picture: Plane::from_fn(120, 160, |x, y| (300 * x + 10 * y) as u16),
            inliers: vec![Vector2::new(20.0, 30.0)],
            time,
            place: Vector2::new(place, 0.0),
            estimate: (time > 0.0).then(|| Vector2::new(place, 0.1)),
            wind: Vector2::new(3.0, 0.0),
        }
    }

    #[test]
    fn every_scene_is_a_frame_and_the_place_is_where_it_is() {
        let scenes = [scene(0.0, 0.0), scene(0.1, 0.2), scene(0.2, 0.4)];
        let file = apng(&scenes, Duration::from_millis(100), 0.5).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(3));
        let mut last = vec![0; reader.output_buffer_size().unwrap()];
        for _ in 0..3 {
            reader.next_frame(&mut last).unwrap();
        }
        // The map is 98 px wide: 43 px are half a metre.
        let at = |x: usize, y: usize| &last[3 * ((120 + TEXT_WIDTH) * y + x)..][..3];
        assert_eq!(at(120 + 49 + (0.4f64 * 43.0 / 0.5) as usize, 49), TRUE);
        assert_eq!(at(20, 30), INLIER);
    }
}
