//! The f32 extractor on real pictures against the f64 path.

use std::io::Write as _;

use hoverlock_pictures::{Picture, data_dir, demo_dir};
use hoverlock_reference::features::dog::SIGMAS;
use hoverlock_reference::features::extractor::{Selection, extract};
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::features::feature::Feature;
use hoverlock_reference::features::maxlbp::Ring;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::smoother::Smoother;

/// Largest difference of two responses that f32 rounding causes, DN; derived beside the unit tests of the extractor.
const TOLERANCE: f64 = 0.05;

fn clear(plane: &Plane<f64>, sigma: f64) -> Plane<f64> {
    Smoother::first_order(sigma).unwrap().smooth(plane, Border::Held)
}

fn key(f: &Feature) -> (u32, u32, u8) {
    (f.y, f.x, f.scale)
}

#[test]
fn features_of_real_pictures_agree_with_the_f64_path() {
    let mut paths = Vec::new();
    if let Some(folder) = data_dir().map(|folder| folder.join("textures")) {
        paths.extend(["forest_canopy.png", "pasture_low_texture.png"].map(|name| folder.join(name)));
    }
    if let Some(folder) = demo_dir() {
        paths.extend(["aero1.jpg", "aero3.jpg"].map(|name| folder.join(name)));
    }
    paths.retain(|path| path.is_file());
    if paths.is_empty() {
        writeln!(
            std::io::stderr(),
            "SKIPPED: features_of_real_pictures_agree_with_the_f64_path: run `make demo` for the photographs, \
             or set HOVERLOCK_DATA to the picture folder"
        )
        .expect("stderr is open");
    }
    for path in paths {
        let name = path.display();
        let frame = Picture::open(&path).unwrap().crop(1024, 768).luma;
        let clear = extract(&frame, &SIGMAS, &Ring::defaults(), clear, &Selection::default());
        let fast = FastExtractor::new(Selection::default()).unwrap().extract(&frame);
        let same: Vec<(&Feature, &Feature)> =
            fast.iter().filter_map(|f| Some((f, &clear[clear.binary_search_by_key(&key(f), key).ok()?]))).collect();
        let error = same.iter().map(|(a, b)| (a.response - b.response).abs()).fold(0.0, f64::max);
        let flips: u32 = same.iter().map(|(a, b)| a.descriptor.hamming(&b.descriptor, false)).sum();
        eprintln!("{name}: {} of {} kept, response error {error:.4} DN, {flips} bits flipped", same.len(), clear.len());
        assert!(clear.len() == 1000 && fast.len() == 1000);
        assert!(same.len() >= 990, "{name}: {} of 1000 kept", same.len());
        assert!(error < TOLERANCE, "{name}: {error} DN");
        // 0.05 % of the bits is the acceptance bound of the fixed-point model at nominal contrast.
        assert!(f64::from(flips) <= 0.0005 * 128.0 * same.len() as f64, "{name}: {flips} bits flipped");
    }
}
