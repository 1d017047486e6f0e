//! The renderer compared with independent results: closed-form projections, laws of light, and laser ranges.

use std::path::Path;
use std::sync::OnceLock;

use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::{Lens, Renderer, Shot};
use hoverlock_edss::scene::Scene;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;

const WIDTH: usize = 1024;
const HEIGHT: usize = 768;

fn renderer(text: &str) -> Renderer {
    let scene = Scene::parse(text, Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
    Renderer::new(&scene, 1).unwrap()
}

fn lens(degrees: f64, k1: f64, k2: f64) -> Lens {
    Lens { camera: Camera::with_field_of_view(WIDTH, HEIGHT, degrees.to_radians()).unwrap(), k1, k2 }
}

fn pose(x: f64, y: f64, height: f64, [roll, pitch, yaw]: [f64; 3]) -> Pose {
    let attitude = Attitude { roll: roll.to_radians(), pitch: pitch.to_radians(), yaw: yaw.to_radians() };
    Pose { position: Vector3::new(x, y, -height), attitude }
}

fn shot(lens: Lens, pose: Pose) -> Shot {
    Shot { lens, first: pose, last: pose, time: 0.0 }
}

fn render(renderer: &Renderer, shot: &Shot) -> Plane<f32> {
    let mut frame = Plane::filled(WIDTH, HEIGHT, 0f32);
    renderer.render(shot, &mut frame);
    frame
}

/// Projects a point by `K R^T (p - position)` with Brown's distortion, independently of the renderer.
fn projected(lens: &Lens, pose: &Pose, point: Vector3<f64>) -> Vector2<f64> {
    let seen = pose.attitude.rotation().transpose() * (point - pose.position);
    let (x, y) = (seen.x / seen.z, seen.y / seen.z);
    let q = x * x + y * y;
    let bend = 1.0 + lens.k1 * q + lens.k2 * q * q;
    let image = lens.camera.matrix() * Vector3::new(x * bend, y * bend, 1.0);
    image.xy()
}

/// Writes a picture of a white square of 1 m on black ground.
fn square_scene(folder: &Path) -> Renderer {
    let side = 400;
    let picture = image::GrayImage::from_fn(side, side, |x, y| {
        let inside = |v: u32| (180..220).contains(&v);
        image::Luma([if inside(x) && inside(y) { 255 } else { 0 }])
    });
    picture.save(folder.join("square.png")).unwrap();
    let text = "[ground.picture]\nfile = \"square.png\"\ntexel_m = 0.05\n";
    Renderer::new(&Scene::parse(text, folder).unwrap(), 1).unwrap()
}

/// Returns the centroid of brightness within `reach` px of a pixel.
fn centroid(frame: &Plane<f32>, near: Vector2<f64>, reach: f64) -> Vector2<f64> {
    let (mut sum, mut weight) = (Vector2::zeros(), 0.0);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let p = Vector2::new(x as f64, y as f64);
            if (p - near).amax() < reach {
                sum += p * f64::from(frame[(x, y)]);
                weight += f64::from(frame[(x, y)]);
            }
        }
    }
    sum / weight
}

/// A square of 2 m, 20 to 90 px wide. Perspective within it moves its centroid from the projected centre, so the mean
/// of the projections of its points is the reference.
#[test]
fn a_marker_lands_where_the_closed_form_says() {
    let folder = tempfile::tempdir().unwrap();
    let renderer = square_scene(folder.path());
    let cases = [
        (50.0, 0.0, 0.0, pose(0.0, 0.0, 50.0, [0.0, 0.0, 0.0])),
        (50.0, 0.0, 0.0, pose(12.3, -7.1, 60.0, [4.0, -3.0, 77.0])),
        (50.0, -0.08, 0.02, pose(-12.0, 6.0, 50.0, [-3.0, 2.0, -140.0])),
        (20.0, 0.05, 0.0, pose(3.0, 4.0, 100.0, [-2.0, 3.0, 30.0])),
        (10.0, 0.0, 0.0, pose(1.0, -2.0, 100.0, [1.0, -1.5, 200.0])),
        (50.0, 0.0, 0.0, pose(-2.0, -1.5, 22.0, [5.0, 3.0, 10.0])),
    ];
    for (degrees, k1, k2, pose) in cases {
        let lens = lens(degrees, k1, k2);
        let frame = render(&renderer, &shot(lens, pose));
        // Brightness per pixel is uniform, so the centroid is the mean over the image of the square.
        let (mut sum, mut weight) = (Vector2::zeros(), 0.0);
        let steps = 41;
        for i in 0..steps {
            for j in 0..steps {
                let at = |k: i32| 2.0 * ((f64::from(k) + 0.5) / f64::from(steps) - 0.5);
                let (x, y) = (at(i), at(j));
                let p = projected(&lens, &pose, Vector3::new(x, y, 0.0));
                let (dx, dy) = (
                    projected(&lens, &pose, Vector3::new(x + 0.01, y, 0.0)) - p,
                    projected(&lens, &pose, Vector3::new(x, y + 0.01, 0.0)) - p,
                );
                let area = (dx.x * dy.y - dx.y * dy.x).abs();
                sum += p * area;
                weight += area;
            }
        }
        let expected = sum / weight;
        let found = centroid(&frame, expected, 1.2 * lens.camera.focal() * 2.0 / pose.height());
        assert!((found - expected).norm() < 0.05, "{degrees} degrees: {found} {expected}");
    }
}

/// Ring and H of the helipad are symmetric, so their centroid is the projected centre except for perspective.
#[test]
fn a_helipad_lands_where_the_closed_form_says() {
    let text = "[ground.asphalt]\nside_m = 0\n[[helipad]]\nat_m = [3.0, -2.0]\ndiameter_m = 6.0\nheading_deg = 30\n";
    let (with, without) = (renderer(text), renderer("[ground.asphalt]\nside_m = 0\n"));
    let lens = lens(30.0, -0.05, 0.0);
    let pose = pose(1.0, 2.0, 100.0, [0.5, -0.4, 25.0]);
    let (a, b) = (render(&with, &shot(lens, pose)), render(&without, &shot(lens, pose)));
    // The difference that the paint makes; the ground under it is equal in both.
    let changed = a.zip_map(&b, |a, b| if (a - b).abs() > 1e-4 { 1.0 } else { 0.0 });
    let expected = projected(&lens, &pose, Vector3::new(3.0, -2.0, 0.0));
    let found = centroid(&changed, expected, 100.0);
    assert!((found - expected).norm() < 0.1, "{found} {expected}");
}

#[test]
fn contrast_falls_by_koschmieders_law() {
    let scene = |mist: &str| renderer(&format!("[ground.asphalt]\nside_m = 20\n{mist}"));
    let (clear, misty) = (scene(""), scene("[mist]\nextinction_per_m = 0.02\n"));
    let view = shot(lens(50.0, 0.0, 0.0), pose(0.0, 0.0, 80.0, [0.0, 3.0, 0.0]));
    let (a, b) = (render(&clear, &view), render(&misty, &view));
    for (x, y) in [(511, 383), (3, 5), (1000, 700), (40, 760)] {
        let pixel = Vector2::new(x as f64, y as f64);
        let ground = clear.ground(&view.lens, &view.first, pixel, 0.0).unwrap();
        let range = (ground - view.first.position).norm();
        let transmission = (-0.02 * range).exp();
        let expected = 0.55 + transmission * (f64::from(a[(x, y)]) - 0.55);
        // The renderer interpolates the exponential linearly over 8 px, with an error of 1e-6.
        assert!((f64::from(b[(x, y)]) - expected).abs() < 2e-5, "{x} {y}: {} {expected}", b[(x, y)]);
    }
}

#[test]
fn a_shadow_is_as_long_as_height_over_tangent() {
    for elevation in [30.0, 50.0, 65.0] {
        // The sun in the direction -X_e: the shadow falls towards +X_e from the wall at x = 2.
        let scene = |building: &str| {
            renderer(&format!("[ground.grass]\n[sun]\nazimuth_deg = 180\nelevation_deg = {elevation}\n{building}"))
        };
        let building = "[[building]]\nat_m = [0, 0]\nsize_m = [4, 30]\nheight_m = 5\n";
        let (with, without) = (scene(building), scene(""));
        let view = shot(lens(30.0, 0.0, 0.0), pose(2.0, 0.0, 80.0, [0.0; 3]));
        let (a, b) = (render(&with, &view), render(&without, &view));
        let per_metre = view.lens.camera.focal() / 80.0;
        // From the foot of the wall to the last pixel in shadow, in the middle row.
        let (middle, row) = ((WIDTH - 1) as f64 / 2.0, HEIGHT / 2);
        let dark = |x: usize| f64::from(a[(x, row)] / b[(x, row)]);
        let mut length = 0.0;
        for x in middle.ceil() as usize..WIDTH {
            let part = ((1.0 - dark(x)) / 0.7).clamp(0.0, 1.0);
            length += part / per_metre;
        }
        let expected = 5.0 / f64::to_radians(elevation).tan();
        assert!((length - expected).abs() < 0.03, "{elevation}: {length} {expected}");
        assert!((dark(middle as usize + 5) - 0.3).abs() < 1e-4);
    }
}

#[test]
fn a_laser_meets_plane_and_box() {
    let scene = renderer("[ground.grass]\n[[building]]\nat_m = [10, 0]\nsize_m = [6, 8]\nheight_m = 7\n");
    let origin = Vector3::new(0.0, 0.0, -60.0);
    let towards = |x: f64, y: f64, z: f64| (Vector3::new(x, y, z) - origin).normalize();
    let range = |x: f64, y: f64, z: f64| scene.range(0.0, origin, towards(x, y, z)).unwrap();
    // Level ground: height over cosine. The roof: 53 m down. The wall: at x = 7.
    let ground = towards(-20.0, 5.0, 0.0);
    assert!((range(-20.0, 5.0, 0.0) - 60.0 / ground.z).abs() < 1e-4);
    let roof = towards(10.0, 2.0, -7.0);
    assert!((range(10.0, 2.0, -7.0) - 53.0 / roof.z).abs() < 1e-4);
    let wall = towards(7.0, 1.0, -3.0);
    assert!((range(7.0, 1.0, -3.0) - 7.0 / wall.x).abs() < 1e-4);
    assert_eq!(scene.range(0.0, origin, -Vector3::z()), None);
    assert_eq!(scene.range(0.0, origin, Vector3::x()), None);
}

#[test]
fn a_laser_meets_a_car_where_it_is_at_the_time() {
    let scene = renderer("[ground.grass]\n[[car]]\nfrom_m = [-50, 0]\nto_m = [50, 0]\nspeed_m_per_s = 10\n");
    let below = |time: f64| scene.range(time, Vector3::new(0.0, 0.0, -30.0), Vector3::z()).unwrap();
    assert!((below(0.0) - 30.0).abs() < 1e-5 && below(5.0) < 29.2 && (below(6.0) - 30.0).abs() < 1e-5);
    assert!(below(15.0) < 29.2, "it starts again after 100 m");
}

fn hills() -> &'static Renderer {
    static HILLS: OnceLock<Renderer> = OnceLock::new();
    HILLS.get_or_init(|| renderer("[ground.grass]\n[relief.hills]\nrms_m = 3\nwavelength_m = 90\n"))
}

proptest! {
    /// Over hills, the point of a pixel is on its ray and at the height that a vertical laser measures there.
    #[test]
    fn pixels_and_lasers_see_the_same_hills(
        x in 0.0..1023.0f64, y in 0.0..767.0f64, roll in -8.0..8.0f64, yaw in -180.0..180.0f64,
    ) {
        let scene = hills();
        let lens = lens(50.0, -0.05, 0.01);
        let pose = pose(7.0, -3.0, 100.0, [roll, 2.0, yaw]);
        let pixel = Vector2::new(x, y);
        let point = scene.ground(&lens, &pose, pixel, 0.0).unwrap();
        prop_assert!((projected(&lens, &pose, point) - pixel).norm() < 1e-3);
        let above = Vector3::new(point.x, point.y, -200.0);
        let range = scene.range(0.0, above, Vector3::z()).unwrap();
        prop_assert!((200.0 - range + point.z).abs() < 1e-3, "{range} {point}");
    }
}

/// A map of sine hills has the rms of the formula, and displaces the picture as in closed form.
#[test]
fn a_height_map_displaces_by_parallax() {
    let folder = tempfile::tempdir().unwrap();
    // A plateau 6 m over the ground: 200 x 200 texels of 0.5 m, white within 40 m of the middle.
    let plateau = image::GrayImage::from_fn(200, 200, |x, y| {
        let inside = (60..140).contains(&x) && (60..140).contains(&y);
        image::Luma([if inside { 255 } else { 0 }])
    });
    let blurred = image::imageops::blur(&plateau, 8.0);
    blurred.save(folder.path().join("height.png")).unwrap();
    square_scene(folder.path());
    let text = "[ground.picture]\nfile = \"square.png\"\ntexel_m = 0.05\n\
        [relief.map]\nfile = \"height.png\"\ntexel_m = 0.5\nheight_m = 6\n";
    let scene = Scene::parse(text, folder.path()).unwrap();
    let renderer = Renderer::new(&scene, 1).unwrap();
    let luma = blurred.pixels().map(|p| f64::from(p.0[0])).collect::<Vec<_>>();
    let mean = luma.iter().sum::<f64>() / luma.len() as f64;
    let height = 6.0 * (255.0 - mean) / 255.0;
    let view = shot(lens(50.0, 0.0, 0.0), pose(14.0, 9.0, 60.0, [0.0; 3]));
    let frame = render(&renderer, &view);
    let expected = projected(&view.lens, &view.first, Vector3::new(0.0, 0.0, -height));
    let found = centroid(&frame, expected, 40.0);
    assert!((found - expected).norm() < 0.1, "{found} {expected}");
}

/// Stripes of 0.4 px are a uniform grey; stripes of 8 px are resolved.
#[test]
fn stripes_beyond_nyquist_render_to_their_mean() {
    let folder = tempfile::tempdir().unwrap();
    let picture = image::GrayImage::from_fn(1024, 1024, |x, _| image::Luma([if x % 4 < 2 { 230 } else { 20 }]));
    picture.save(folder.path().join("stripes.png")).unwrap();
    let contrast = |period_px: f64| {
        let pixel = 50.0 / lens(30.0, 0.0, 0.0).camera.focal();
        let texel = period_px * pixel / 4.0;
        let text = format!("[ground.picture]\nfile = \"stripes.png\"\ntexel_m = {texel}\n");
        let renderer = Renderer::new(&Scene::parse(&text, folder.path()).unwrap(), 1).unwrap();
        let frame = render(&renderer, &shot(lens(30.0, 0.0, 0.0), pose(0.0, 0.0, 50.0, [0.0, 0.0, 20.0])));
        // Contrast about the mean, over the middle of the frame.
        let part = frame.crop(412, 284, 200, 200).unwrap();
        let mean = part.as_slice().iter().sum::<f32>() / 40_000.0;
        let square = part.as_slice().iter().map(|v| (v - mean).powi(2)).sum::<f32>() / 40_000.0;
        (mean, square.sqrt())
    };
    let expected = 125.0 / 255.0;
    for period in [0.4, 0.7, 1.0] {
        let (mean, rms) = contrast(period);
        assert!((mean - expected).abs() < 2e-3 && rms < 0.02, "{period} px: {mean} {rms}");
    }
    assert!(contrast(8.0).1 > 0.3, "stripes that can be seen are seen");
}

#[test]
fn a_rolling_shutter_sees_each_row_from_its_own_pose() {
    let folder = tempfile::tempdir().unwrap();
    let renderer = square_scene(folder.path());
    let (first, last) = (pose(-2.0, 0.0, 50.0, [0.0; 3]), pose(2.0, 0.0, 50.0, [1.0, 0.0, 0.0]));
    let view = Shot { lens: lens(50.0, 0.0, 0.0), first, last, time: 0.0 };
    let frame = render(&renderer, &view);
    // The row of the square, and the pose at the time of that row.
    let half = (HEIGHT - 1) as f64 / 2.0;
    let middle = first.interpolate(&last, 0.5);
    let expected = projected(&view.lens, &middle, Vector3::zeros());
    let found = centroid(&frame, expected, 60.0);
    assert!((found - expected).norm() < 0.15, "{found} {expected}");
    // The square is sheared: 30 rows later the camera has moved by 0.16 m and 0.04 degrees.
    // The mirrored picture has more squares further out.
    let near = found.x as usize - 50..found.x as usize + 50;
    let mean = |row: usize| {
        let sum: f64 = near.clone().map(|x| f64::from(frame[(x, row)])).sum();
        near.clone().map(|x| x as f64 * f64::from(frame[(x, row)])).sum::<f64>() / sum
    };
    let at = |row: usize| {
        let pose = first.interpolate(&last, row as f64 / (HEIGHT - 1) as f64);
        projected(&view.lens, &pose, Vector3::zeros()).x
    };
    let (a, b) = (half as usize - 15, half as usize + 15);
    assert!((mean(b) - mean(a) - (at(b) - at(a))).abs() < 0.1, "{} {}", mean(b) - mean(a), at(b) - at(a));
    assert!((at(b) - at(a)).abs() > 3.0);
}

#[test]
#[ignore = "half a minute: twenty frames of new ground"]
fn a_frame_has_the_same_bits_for_every_number_of_threads() {
    for name in ["field", "town", "helipad-in-mist", "open-water"] {
        let scene = Scene::parse(Scene::named(name).unwrap(), Path::new("")).unwrap();
        let (first, second) = (Renderer::new(&scene, 5).unwrap(), Renderer::new(&scene, 5).unwrap());
        let view = Shot { time: 3.2, ..shot(lens(50.0, -0.02, 0.0), pose(5.0, 1.0, 60.0, [2.0, 1.0, 40.0])) };
        let with = |threads: usize, renderer: &Renderer| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(renderer, &view))
        };
        let frame = with(1, &first);
        assert!(frame == with(3, &first), "{name}: threads");
        assert!(frame.as_slice().iter().all(|v| v.is_finite() && *v >= 0.0), "{name}");
        // Patches composed for other views, or already for this one, do not change the frame.
        let (near, far) = (pose(4.0, 2.0, 45.0, [0.0, -3.0, 70.0]), pose(-30.0, 9.0, 90.0, [1.0, 0.0, 0.0]));
        for other in [near, far] {
            assert!(frame != render(&second, &shot(view.lens, other)), "{name}: another view");
        }
        assert!(frame == with(2, &second), "{name}: a second renderer after other views");
    }
}

#[test]
fn another_seed_is_another_ground() {
    let scene = Scene::parse(Scene::named("field").unwrap(), Path::new("")).unwrap();
    let view = shot(lens(50.0, 0.0, 0.0), pose(5.0, 1.0, 60.0, [0.0; 3]));
    let [first, second] = [5, 6].map(|seed| render(&Renderer::new(&scene, seed).unwrap(), &view));
    assert!(first != second);
}

/// Above the middle of a crown a climb leaves the picture's centre as it is: the pattern of the leaves stays on it.
#[test]
fn the_leaves_of_a_crown_stay_where_they_are_while_the_camera_climbs() {
    let renderer = renderer("[ground.grass]\n[[tree]]\nat_m = [0, 0]\nradius_m = 4\nheight_m = 6\n");
    let centre = |height: f64| -> Vec<f64> {
        let frame = render(&renderer, &shot(lens(30.0, 0.0, 0.0), pose(0.0, 0.0, height, [0.0; 3])));
        let at = |i: usize| frame[(WIDTH / 2 - 20 + i % 41, HEIGHT / 2 - 20 + i / 41)];
        let values: Vec<f64> = (0..41 * 41).map(|i| f64::from(at(i))).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| value - mean).collect()
    };
    let (low, high) = (centre(30.0), centre(30.3));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let correlation = product(&low, &high) / (product(&low, &low) * product(&high, &high)).sqrt();
    assert!(correlation > 0.9, "{correlation}");
}

/// Frame sizes that are not multiples of blocks and tiles.
#[test]
fn every_size_of_frame_is_rendered() {
    let renderer = renderer("[ground.grass]\n[[tree]]\nat_m = [0, 0]\nradius_m = 3\nheight_m = 7\n");
    for (width, height) in [(1, 1), (7, 3), (33, 17), (100, 49)] {
        let camera = Camera::with_field_of_view(width, height, 0.5).unwrap();
        let view = shot(Lens { camera, k1: 0.0, k2: 0.0 }, pose(0.0, 0.0, 30.0, [0.0; 3]));
        let mut frame = Plane::filled(width, height, -1f32);
        renderer.render(&view, &mut frame);
        assert!(frame.as_slice().iter().all(|v| *v > 0.0), "{width} x {height}");
    }
}

/// Compares the correlation of two frames of the sea, 67 ms apart, with that of two of a field.
#[test]
fn water_does_not_last_and_a_field_does() {
    let correlation = |name: &str, seconds: f64| {
        let scene = Scene::parse(Scene::named(name).unwrap(), Path::new("")).unwrap();
        let renderer = Renderer::new(&scene, 2).unwrap();
        let view = shot(lens(50.0, 0.0, 0.0), pose(0.0, 0.0, 60.0, [0.0; 3]));
        let (a, b) = (render(&renderer, &view), render(&renderer, &Shot { time: seconds, ..view }));
        let centred = |frame: &Plane<f32>| {
            let mean = frame.as_slice().iter().map(|&v| f64::from(v)).sum::<f64>() / frame.as_slice().len() as f64;
            frame.map(|&v| f64::from(v) - mean)
        };
        let (a, b) = (centred(&a), centred(&b));
        let dot =
            |a: &Plane<f64>, b: &Plane<f64>| a.as_slice().iter().zip(b.as_slice()).map(|(a, b)| a * b).sum::<f64>();
        dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt()
    };
    assert_eq!(correlation("field", 0.067), 1.0);
    let (soon, late) = (correlation("open-water", 0.067), correlation("open-water", 2.0));
    eprintln!("sea: correlation {soon:.2} after 67 ms, {late:.2} after 2 s");
    assert!(soon < 0.9 && late.abs() < 0.5, "{soon} {late}");
}

/// Where a picture resolves the waves of one octave alone, they disperse: after 3 s no shift brings a patch back.
#[test]
fn waves_of_one_octave_disperse() {
    const SIDE: usize = 96;
    const REACH: usize = 64;
    let renderer =
        renderer("[ground.water]\nwave_m = 1.5\nslope = 0.06\n[sun]\nazimuth_deg = 90.0\nelevation_deg = 49.0\n");
    let view = shot(lens(50.0, 0.0, 0.0), pose(0.0, 0.0, 124.0, [0.0; 3]));
    let first = render(&renderer, &view);
    let patch = |frame: &Plane<f32>, x: usize, y: usize| -> Vec<f64> {
        let values: Vec<f64> = (0..SIDE * SIDE).map(|i| f64::from(frame.row(y + i / SIDE)[x + i % SIDE])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let centred: Vec<f64> = values.iter().map(|value| value - mean).collect();
        let norm = centred.iter().map(|value| value * value).sum::<f64>().sqrt();
        centred.iter().map(|value| value / norm).collect()
    };
    let corner = [first.width() / 2 - SIDE / 2, first.height() / 2 - SIDE / 2];
    let template = patch(&first, corner[0], corner[1]);
    let likeness = |seconds: f64| {
        let later = render(&renderer, &Shot { time: seconds, ..view });
        let places = (0..=2 * REACH).flat_map(|y| (0..=2 * REACH).map(move |x| (x, y)));
        let found = places.map(|(x, y)| {
            let there = patch(&later, corner[0] + x - REACH, corner[1] + y - REACH);
            there.iter().zip(&template).map(|(a, b)| a * b).sum::<f64>()
        });
        found.fold(-1.0, f64::max)
    };
    let (soon, late) = (likeness(0.067), likeness(3.0));
    assert!(soon > 0.9 && late < 0.5, "{soon} {late}");
}

/// Rain and snow are bright streaks over dark ground, in other places a frame later.
#[test]
fn rain_and_snow_fall() {
    // The seed of the ground is drawn before that of the weather, so all three have the same ground.
    let scene = |fall: &str| renderer(&format!("[ground.asphalt]\nside_m = 200\n{fall}"));
    let clear = scene("");
    let wet = |fall: &str, time: f64| {
        let view = Shot { time, ..shot(lens(50.0, 0.0, 0.0), pose(0.0, 0.0, 50.0, [0.0; 3])) };
        let (a, b) = (render(&scene(fall), &view), render(&clear, &view));
        a.zip_map(&b, |a, b| a - b)
    };
    for fall in ["[rain]\nper_m3 = 40\n", "[snow]\nper_m3 = 40\n"] {
        let (first, second) = (wet(fall, 1.0), wet(fall, 1.067));
        let seen = |frame: &Plane<f32>| frame.as_slice().iter().filter(|v| v.abs() > 0.05).count();
        let both = first.zip_map(&second, |a, b| if a.abs() > 0.05 && b.abs() > 0.05 { 1.0 } else { 0.0f32 });
        let (a, b, lasting) = (seen(&first), seen(&second), seen(&both));
        eprintln!("{fall}: {a} and {b} pixels, {lasting} in both");
        assert!(a > 500 && b > 500 && lasting * 4 < a, "{fall}: {a} {b} {lasting}");
    }
}
