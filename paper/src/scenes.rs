//! Pictures of the simulator: figure 14, and the frames that the other figures are made from.

use std::io::Cursor;
use std::path::Path;

use hoverlock_edss::camera::FRAME_SIZE;
use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::{Lens, Renderer};
use hoverlock_edss::scene::Scene;
use hoverlock_edss::world::still;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View};
use hoverlock_reports::figures::background;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use nalgebra::Vector3;

use crate::{Item, PaperError};

/// Field of view of all frames, degrees: the widest of the camera.
const FIELD_OF_VIEW_DEG: f64 = 50.0;
/// Height over the mean ground, m.
pub const HEIGHT_M: f64 = 100.0;

/// A frame with the view that attitude and laser give.
pub struct Photograph {
    /// Samples, DN.
    pub frame: Plane<u16>,
    /// Camera, attitude and range.
    pub view: View,
    /// True pose.
    pub pose: Pose,
}

/// Prepares a scene of the simulator.
pub fn scene(name: &str) -> Result<Renderer, PaperError> {
    let text = Scene::named(name).unwrap_or_default();
    Ok(Renderer::new(&Scene::parse(text, Path::new(""))?, 1)?)
}

/// Returns a pose over the mean ground at [`HEIGHT_M`]; position in m, roll, pitch and yaw in degrees.
pub fn pose(x: f64, y: f64, [roll, pitch, yaw]: [f64; 3]) -> Pose {
    let attitude = Attitude { roll: roll.to_radians(), pitch: pitch.to_radians(), yaw: yaw.to_radians() };
    Pose { position: Vector3::new(x, y, -HEIGHT_M), attitude }
}

/// Takes a frame; `seed` is that of the noise of the sensor.
pub fn photograph(scene: &Renderer, pose: Pose, seed: u64) -> Result<Photograph, PaperError> {
    let camera = Camera::with_field_of_view(FRAME_SIZE.0, FRAME_SIZE.1, FIELD_OF_VIEW_DEG.to_radians())?;
    let lens = Lens { camera, k1: 0.0, k2: 0.0 };
    let laser = scene.ground(&lens, &pose, camera.principal(), 0.0).ok_or(PaperError::NoGround)?;
    let view = View::new(camera, pose.attitude, (laser - pose.position).norm())?;
    Ok(Photograph { frame: still(scene, &pose, FIELD_OF_VIEW_DEG, seed)?, view, pose })
}

/// Encodes a frame as a PNG of 16 bits a sample.
pub fn png(frame: &Plane<u16>) -> Result<Vec<u8>, ImageError> {
    let mut png = Cursor::new(Vec::new());
    // The encoder takes 16-bit samples in native byte order.
    let bytes: Vec<u8> = frame.as_slice().iter().flat_map(|sample| sample.to_ne_bytes()).collect();
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    PngEncoder::new(&mut png).write_image(&bytes, width, height, ExtendedColorType::L16)?;
    Ok(png.into_inner())
}

/// Returns the frames of two views of a scene as files for commands: `field_1.png` and `field_2.png`.
pub fn files(name: &str, views: &[Photograph; 2]) -> Result<Vec<(String, Vec<u8>)>, ImageError> {
    views.iter().zip(1..).map(|(view, i)| Ok((format!("{name}_{i}.png"), png(&view.frame)?))).collect()
}

/// Returns a picture as an SVG element, half as large in each direction.
pub fn picture(title: &str, frame: &Plane<u16>) -> Result<String, PaperError> {
    let half = Plane::from_fn(frame.width() / 2, frame.height() / 2, |x, y| {
        let sum: u32 = (0..4).map(|i| u32::from(frame[(2 * x + i % 2, 2 * y + i / 2)])).sum();
        (sum / 4) as u16
    });
    let (width, height) = (half.width(), half.height());
    Ok(format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\"><image width=\"{width}\" \
         height=\"{height}\" href=\"{}\"/></svg>",
        background(&half)?
    ))
}

/// Figure 14.
pub fn items() -> Result<Vec<Item>, PaperError> {
    let mut drawings = Vec::new();
    for (name, title) in [("helipad-in-mist", "helipad in mist"), ("field", "field")] {
        drawings.push(picture(title, &photograph(&scene(name)?, pose(0.0, 0.0, [0.0; 3]), 1)?.frame)?);
    }
    Ok(vec![Item {
        number: "figure 14",
        title: "Scenes of the simulator: helipad in mist, field",
        stated: "The method is tried over a helipad in mist and over a field.",
        found: format!(
            "Both scenes from {HEIGHT_M:.0} m, as the camera takes them, stretched for display. The command below \
             flies over the first; `--scene field` over the second."
        ),
        holds: None,
        evidence: "hoverlock hover --scene helipad-in-mist",
        drawings,
        ..Item::default()
    }])
}
