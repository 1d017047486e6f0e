//! Renders a scene from a pose to a PNG: `look SCENE HEIGHT_M FIELD_OF_VIEW_DEG OUT.png [X Y TILT_DEG YAW_DEG TIME_S]`.

use std::path::Path;

use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::{Lens, Renderer, Shot};
use hoverlock_edss::scene::Scene;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
use image::{ImageBuffer, Luma};
use nalgebra::Vector3;

/// Number of frames that are timed.
const FRAMES: u32 = 100;

/// Returns the processor time of all threads so far, s, in steps of 0.01 s (proc(5)). Unlike wall time it hardly
/// depends on other programs.
fn cpu_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    fields.get(11..13).map_or(0.0, |ticks| ticks.iter().filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() / 100.0)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, height, field_of_view, out, rest @ ..] = arguments.as_slice() else {
        return Err("usage: look SCENE HEIGHT_M FIELD_OF_VIEW_DEG OUT.png [X Y TILT_DEG YAW_DEG TIME_S]".into());
    };
    let rest = rest.iter().map(|value| value.parse()).collect::<Result<Vec<f64>, _>>()?;
    let optional = |i: usize| rest.get(i).copied().unwrap_or(0.0);
    let (text, folder) = match Scene::named(scene) {
        Some(text) => (text.to_owned(), Path::new("")),
        None => (std::fs::read_to_string(scene)?, Path::new(scene).parent().unwrap_or(Path::new(""))),
    };
    let parsed = Scene::parse(&text, folder).map_err(|error| format!("scene {scene} {error}"))?;
    let start = cpu_time();
    let renderer = Renderer::new(&parsed, 1)?;
    eprintln!("prepared in {:.2} s of processor time", cpu_time() - start);
    let camera = Camera::with_field_of_view(1024, 768, field_of_view.parse::<f64>()?.to_radians())?;
    let attitude = Attitude { roll: optional(2).to_radians(), pitch: 0.0, yaw: optional(3).to_radians() };
    let pose = Pose { position: Vector3::new(optional(0), optional(1), -height.parse::<f64>()?), attitude };
    let shot = Shot { lens: Lens { camera, k1: 0.0, k2: 0.0 }, first: pose, last: pose, time: optional(4) };
    let mut frame = Plane::filled(1024, 768, 0f32);
    let start = cpu_time();
    renderer.render(&shot, &mut frame);
    eprintln!("{:.0} ms of processor time for the first frame, which composes the ground", 1e3 * (cpu_time() - start));
    let start = cpu_time();
    for _ in 0..FRAMES {
        renderer.render(&shot, &mut frame);
    }
    eprintln!("{:.1} ms of processor time for each of the next", 1e3 * (cpu_time() - start) / f64::from(FRAMES));
    let bytes = frame.as_slice().iter().map(|&v| (255.0 * v).clamp(0.0, 255.0) as u8).collect();
    let picture: ImageBuffer<Luma<u8>, Vec<u8>> = ImageBuffer::from_raw(1024, 768, bytes).ok_or("frame")?;
    picture.save(out)?;
    Ok(())
}
