//! A picture on level ground compared with `cv2.warpPerspective`, which is given only a homography.

use std::path::{Path, PathBuf};
use std::process::Command;

use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::{Lens, Renderer, Shot};
use hoverlock_edss::scene::Scene;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
use nalgebra::{Matrix3, Vector3};

/// Returns the Python of the project's venv, or `None` if it has no OpenCV.
fn python() -> Option<PathBuf> {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.venv/bin/python");
    let found = Command::new(&python).args(["-c", "import cv2"]).output().is_ok_and(|run| run.status.success());
    found.then_some(python)
}

/// Creates a picture with smooth patches of 16 texels, for which both interpolations have small errors.
fn picture(path: &Path) {
    let value = |x: u32, y: u32| {
        let (x, y) = (f64::from(x), f64::from(y));
        let waves = (x / 5.1).sin() * (y / 7.3).cos() + (x / 11.0 + y / 6.2).sin() + (x / 23.0 - y / 31.0).cos();
        (32_000.0 + 9_000.0 * waves) as u16
    };
    image::ImageBuffer::from_fn(800, 640, |x, y| image::Luma([value(x, y)])).save(path).unwrap();
}

#[test]
#[ignore = "needs the project's venv with OpenCV; run by name"]
fn a_picture_is_seen_as_opencv_warps_it() {
    let Some(python) = python() else {
        eprintln!("skipped: no OpenCV in .venv; `make demo` makes it");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("picture.png");
    picture(&file);
    let texel = 0.1;
    let text = format!("[ground.picture]\nfile = \"picture.png\"\ntexel_m = {texel}\n");
    let renderer = Renderer::new(&Scene::parse(&text, folder.path()).unwrap(), 1).unwrap();
    // Magnified about twice, so that the renderer uses the unfiltered picture.
    for (degrees, height, [roll, pitch, yaw]) in
        [(30.0, 60.0, [0.0, 0.0, 0.0]), (25.0, 80.0, [4.0, -3.0, 33.0]), (10.0, 120.0, [-2.0, 5.0, 160.0])]
    {
        let camera = Camera::with_field_of_view(1024, 768, f64::to_radians(degrees)).unwrap();
        let attitude =
            Attitude { roll: f64::to_radians(roll), pitch: f64::to_radians(pitch), yaw: f64::to_radians(yaw) };
        let pose = Pose { position: Vector3::new(1.3, -2.1, -height), attitude };
        let mut frame = Plane::filled(1024, 768, 0f32);
        let lens = Lens { camera, k1: 0.0, k2: 0.0 };
        renderer.render(&Shot { lens, first: pose, last: pose, time: 0.0 }, &mut frame);
        // Texel centre (u, v) is at ((u + 1/2 - 400) texel, (v + 1/2 - 320) texel).
        let to_ground = Matrix3::new(texel, 0.0, -399.5 * texel, 0.0, texel, -319.5 * texel, 0.0, 0.0, 1.0);
        let rotation = attitude.rotation().transpose();
        let columns = [rotation.column(0).into(), rotation.column(1).into(), -(rotation * pose.position)];
        let homography = camera.matrix() * Matrix3::from_columns(&columns) * to_ground;
        let raw = folder.path().join("frame.raw");
        std::fs::write(&raw, frame.as_slice().iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/render_opencv.py");
        let numbers = (0..9).map(|k| homography[(k / 3, k % 3)].to_string());
        let run = Command::new(&python).arg(script).arg(&file).arg(&raw).args(numbers).output().unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let printed = String::from_utf8(run.stdout).unwrap();
        let [inside, mean, most] =
            printed.split_whitespace().map(|v| v.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap();
        eprintln!("{degrees} degrees, {height} m: inside {inside}, mean difference {mean}, largest {most}");
        // Both interpolate in f32 at the same points: positions of 1000 texels differ by 1e-4, slopes are 0.07 a texel.
        assert!(inside > 0.9 && mean < 5e-6 && most < 5e-5, "{printed}");
    }
}
