//! The acceptance bounds on real pictures, under three conditions.

use std::io::Write as _;
use std::path::PathBuf;

use hoverlock_design::{DesignPoint, KT27};
use hoverlock_fixed_point::analysis::acceptance::{
    Comparison, Reference, check_coefficients, dog_lsb, rounding_beyond_bound, threshold_step,
};
use hoverlock_fixed_point::analysis::bounds::{Bounds, Check};
use hoverlock_fixed_point::analysis::displacement::{self, Motions};
use hoverlock_fixed_point::analysis::levels::{Level, Levels, raw_thresholds};
use hoverlock_pictures::conditions::{CONDITIONS, NOMINAL};
use hoverlock_pictures::{Picture, data_dir, demo_dir};
use hoverlock_reference::image::plane::Plane;

fn failures(what: &str, checks: Vec<Check>) -> Vec<String> {
    let failed = checks.into_iter().filter(|check| !check.pass);
    failed
        .map(|check| {
            let Check { name, measured, unit, limit, location, .. } = check;
            format!("{what}: {name} is {measured} {unit}, limit {limit} ({location})")
        })
        .collect()
}

/// The nadir pictures of the picture folder, and the aerial photographs that `make demo` installs.
fn pictures(test: &str) -> Vec<PathBuf> {
    let in_folder = |folder: Option<PathBuf>, start: &str| -> Vec<PathBuf> {
        let entries = folder.and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten().flatten();
        let named = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(start));
        named
            .map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|e| e == "png" || e == "jpg"))
            .collect()
    };
    let mut found = in_folder(data_dir().map(|folder| folder.join("textures")), "");
    found.extend(in_folder(demo_dir(), "aero"));
    found.sort();
    if found.is_empty() {
        writeln!(
            std::io::stderr(),
            "SKIPPED: {test}: run `make demo` for the photographs, or set HOVERLOCK_DATA to the picture folder"
        )
        .expect("stderr is open");
    }
    found
}

#[test]
fn the_coefficients_of_the_design_point_pass() {
    let levels = Levels::new(&KT27).unwrap();
    assert_eq!(failures("kt27", check_coefficients(&levels, Bounds::acceptance())), [""; 0]);
}

#[test]
fn coefficients_of_eight_bits_fail() {
    let levels = Levels::new(&KT27.with_override("coefficient=u0.8").unwrap()).unwrap();
    let failed = failures("8 bits", check_coefficients(&levels, Bounds::acceptance()));
    assert!(failed.iter().any(|line| line.contains("sigma_eff")), "{failed:?}");
}

/// A picture of blocks of three sizes, with features in every part of it.
fn blobs() -> Plane<u16> {
    let hash = |x: usize, y: usize| {
        let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 48
    };
    Plane::from_fn(480, 400, |x, y| {
        ((hash(x / 5, y / 5) + hash(x / 11, y / 11 + 1000) + hash(x / 23, y / 23 + 2000)) / 3) as u16
    })
}

#[test]
fn a_format_with_too_few_bits_fails_and_the_design_point_passes() {
    let bounds = Bounds::acceptance();
    let check = |change: &str| {
        let levels = Levels::new(&KT27.with_override(change).unwrap()).unwrap();
        failures(change, Comparison::of_frame(&levels, &blobs(), bounds).unwrap().check(bounds))
    };
    assert_eq!(check("dog_bits=15"), [""; 0]);
    for change in ["dog_bits=12", "state=u16.0"] {
        let failed = check(change);
        assert!(failed.iter().any(|line| line.contains("DoG error, rms")), "{change}: {failed:?}");
    }
    let failed = check("dog_bits=8");
    assert!(failed.iter().any(|line| line.contains("same pixel")), "{failed:?}");
}

#[test]
fn the_threshold_gives_both_levels_the_same_number_of_features() {
    // The level under test is `streaming` rounded to an LSB. It has the features of `streaming`, except for ties by
    // rounding.
    let (bounds, levels) = (Bounds::acceptance(), Levels::new(&KT27).unwrap());
    let faint = blobs().map(|&dn| 30_000 + dn / 40);
    let reference = levels.planes(Level::Streaming, &faint);
    let mut test = reference.clone();
    for plane in test.dog.iter_mut().chain(&mut test.max_dog) {
        *plane = plane.map(|dn| (dn / dog_lsb()).round() * dog_lsb());
    }
    let comparison = Reference::of(reference, bounds).compare(&test, &KT27, bounds).unwrap();
    for scale in &comparison.scales {
        assert!(scale.interior.reference_rms < 200.0, "the contrast must be low: {}", scale.interior.reference_rms);
        assert!(scale.interior.max.abs() <= 0.5 + 1e-9);
        assert!(scale.kept.reference.abs_diff(scale.kept.test) <= 1, "{} {}", scale.kept.reference, scale.kept.test);
    }
}

/// A threshold between two responses of a coarse DoG would be rounded up for its integers alone.
#[test]
fn the_threshold_is_a_response_of_the_coarser_dog() {
    let bounds = Bounds::acceptance();
    let streaming = Levels::new(&KT27).unwrap().planes(Level::Streaming, &blobs());
    let reference = Reference::of(streaming, bounds);
    for (bits, step) in [(16, 0.5), (15, 0.5), (12, 4.0), (9, 32.0)] {
        let design = KT27.with_override(&format!("dog_bits={bits}")).unwrap();
        assert_eq!(threshold_step(&design), step);
        let compared = reference.compare_bit_true(&Levels::new(&design).unwrap(), &blobs(), bounds).unwrap();
        let thresholds: Vec<f64> = compared.scales.iter().map(|scale| scale.threshold_lsb * dog_lsb()).collect();
        for (threshold, raw) in thresholds.iter().zip(raw_thresholds(&design, &thresholds)) {
            assert_eq!(threshold % step, 0.0, "{bits} bits: {threshold} DN");
            assert_eq!(f64::from(raw) * design.dog().lsb(), *threshold, "{bits} bits");
        }
        // `streaming` is cut half a step below.
        let selected = reference.selected(&design);
        let cut = |scale: u8| thresholds[usize::from(scale)] - step / 2.0;
        assert!(selected.features.iter().all(|feature| feature.response >= cut(feature.scale)), "{bits} bits");
        assert!(selected.features.len() > 200, "{bits} bits: {}", selected.features.len());
    }
}

#[test]
fn a_dog_whose_rounding_is_beyond_the_bound_is_named() {
    for (bits, beyond) in [(15, false), (13, false), (12, true), (9, true)] {
        let design = KT27.with_override(&format!("dog_bits={bits}")).unwrap();
        let reason = rounding_beyond_bound(&design, Bounds::acceptance());
        assert_eq!(reason.is_some(), beyond, "{reason:?}");
    }
}

#[test]
fn the_comparison_of_integers_is_that_of_their_planes() {
    let bounds = Bounds::acceptance();
    for change in ["dog_bits=9", "dog_bits=16", "state=u16.4", "coefficient=u0.18", "threshold_target=9"] {
        let levels = Levels::new(&KT27.with_override(change).unwrap()).unwrap();
        let reference = Reference::of(levels.planes(Level::Streaming, &blobs()), bounds);
        let of_planes = reference.compare(&levels.planes(Level::BitTrue, &blobs()), levels.design(), bounds).unwrap();
        assert!(of_planes.scales.iter().all(|scale| scale.kept.test > 50), "{of_planes:?}");
        assert_eq!(reference.compare_bit_true(&levels, &blobs(), bounds), Some(of_planes), "{change}");
    }
}

#[test]
#[ignore = "a minute over all real pictures"]
fn real_pictures_pass_the_bounds_under_three_conditions() {
    let (bounds, levels) = (Bounds::acceptance(), Levels::new(&KT27).unwrap());
    let mut failed = Vec::new();
    for path in pictures("real_pictures_pass_the_bounds_under_three_conditions") {
        let frame = Picture::open(&path).unwrap().crop(KT27.width as usize, KT27.height as usize).luma;
        for condition in CONDITIONS {
            let degraded = condition.apply(&frame, bounds.seeds.of(&condition));
            let comparison = Comparison::of_frame(&levels, &degraded, bounds).unwrap();
            let place = format!("{}, {}", path.display(), condition.name);
            failed.extend(comparison.unfit(bounds).map(|reason| format!("{place}: {reason}")));
            failed.extend(failures(&place, comparison.check(bounds)));
        }
        let motions = Motions::new(&levels, &frame, &NOMINAL, bounds, 3);
        failed.extend(motions.unfit(bounds).map(|reason| format!("{}: {reason}", path.display())));
        let checks = displacement::check(&motions.displacements(&levels), bounds);
        failed.extend(failures(&path.display().to_string(), checks));
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn a_camera_of_few_bits_passes_constant_pictures() {
    for name in ["hd1080", "small"] {
        let design = DesignPoint::shipped(name).unwrap();
        let checks = check_coefficients(&Levels::new(&design).unwrap(), Bounds::acceptance());
        let constant = checks.iter().find(|check| check.name.starts_with("constant picture")).unwrap();
        assert!(constant.pass, "{name}: {constant:?}");
    }
}
