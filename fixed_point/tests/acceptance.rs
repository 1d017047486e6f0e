//! The acceptance bounds on real pictures, under three conditions.

use std::path::PathBuf;

use hoverlock_fixed_point::acceptance::{Comparison, judge_coefficients};
use hoverlock_fixed_point::bounds::{Bounds, Judgement};
use hoverlock_fixed_point::design::KT27;
use hoverlock_fixed_point::displacement;
use hoverlock_fixed_point::ladder::Ladder;
use hoverlock_reference::conditions::{CONDITIONS, NOMINAL};
use hoverlock_reference::picture::{Picture, data_dir, newcomer_dir};
use hoverlock_reference::plane::Plane;

fn failures(what: &str, judgements: Vec<Judgement>) -> Vec<String> {
    let failed = judgements.into_iter().filter(|judgement| !judgement.pass);
    failed
        .map(|j| format!("{what}: {} is {} {}, limit {} ({})", j.name, j.measured, j.unit, j.limit, j.place))
        .collect()
}

/// All textures, and the newcomer's aerial photographs (`graf` is a wall).
fn pictures() -> Vec<PathBuf> {
    let textures = data_dir().map(|folder| folder.join("textures"));
    let mut found: Vec<PathBuf> = [textures, newcomer_dir()]
        .into_iter()
        .flatten()
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "png" || e == "jpg"))
        .filter(|path| !path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("graf")))
        .collect();
    found.sort();
    if found.is_empty() {
        eprintln!("SKIPPED: no real pictures; `make demo` fetches some, or name a folder in HOVERLOCK_DATA");
    }
    found
}

#[test]
fn coefficients_hold_their_bounds() {
    let ladder = Ladder::new(&KT27).unwrap();
    assert_eq!(failures("kt27", judge_coefficients(&ladder, Bounds::acceptance())), [""; 0]);
}

#[test]
fn coefficients_of_eight_bits_do_not() {
    let ladder = Ladder::new(&KT27.with_override("coefficient=u0.8").unwrap()).unwrap();
    let failed = failures("8 bits", judge_coefficients(&ladder, Bounds::acceptance()));
    assert!(failed.iter().any(|line| line.contains("sigma_eff")), "{failed:?}");
}

/// Blobs of three sizes, so that there is a feature wherever one looks.
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
fn a_narrowed_format_fails_and_the_full_one_does_not() {
    let bounds = Bounds::acceptance();
    let judge = |change: &str| {
        let ladder = Ladder::new(&KT27.with_override(change).unwrap()).unwrap();
        failures(change, Comparison::of_frame(&ladder, &blobs(), bounds).unwrap().judge(bounds))
    };
    assert_eq!(judge("dog_bits=15"), [""; 0]);
    for change in ["dog_bits=12", "state=u16.0"] {
        let failed = judge(change);
        assert!(failed.iter().any(|line| line.contains("DoG error, rms")), "{change}: {failed:?}");
    }
    let failed = judge("dog_bits=8");
    assert!(failed.iter().any(|line| line.contains("same pixel")), "{failed:?}");
}

#[test]
#[ignore = "a minute over all real pictures"]
fn real_pictures_hold_the_bounds_under_three_conditions() {
    let (bounds, ladder) = (Bounds::acceptance(), Ladder::new(&KT27).unwrap());
    let mut failed = Vec::new();
    for path in pictures() {
        let frame = Picture::open(&path).unwrap().frame().luma;
        for condition in CONDITIONS {
            let degraded = condition.apply(&frame, bounds.seeds.of(&condition));
            let comparison = Comparison::of_frame(&ladder, &degraded, bounds).unwrap();
            failed.extend(failures(&format!("{}, {}", path.display(), condition.name), comparison.judge(bounds)));
        }
        let displacements = displacement::displacements(&ladder, &frame, &NOMINAL, bounds, 3);
        failed.extend(failures(&path.display().to_string(), displacement::judge(&displacements, bounds)));
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
