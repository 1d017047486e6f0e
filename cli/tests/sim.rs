//! `hoverlock sim` as a user runs it: what the JSON object says, what pauses and a closed sink do to it, what waves
//! leave behind.

use std::path::Path;
use std::process::Command;

use image::{DynamicImage, ImageBuffer, Luma};
use serde_json::Value;

/// Runs the verb with `--json`; status 0 and one object, or a panic.
#[track_caller]
fn sim(args: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_hoverlock")).arg("sim").args(args).arg("--json").output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{args:?}\n{stderr}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{args:?}: {error}\n{stderr}"))
}

/// A 160 x 120 picture of hashed blocks, 5 pixels wide, `seed` another one.
fn picture(folder: &Path, name: &str, seed: u32) -> String {
    let block = |x: u32, y: u32| {
        let hash = (x / 5).wrapping_mul(0x9E37_79B9) ^ (y / 5).wrapping_mul(0x85EB_CA6B) ^ seed;
        (hash.wrapping_mul(0x27D4_EB2F) >> 24) as u8
    };
    let path = folder.join(name);
    DynamicImage::ImageLuma8(ImageBuffer::from_fn(160, 120, |x, y| Luma([block(x, y)]))).save(&path).unwrap();
    path.display().to_string()
}

#[test]
fn alone_it_measures_cycles_per_pixel_and_counts_by_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (picture(folder.path(), "one.png", 1), picture(folder.path(), "two.png", 2));
    let answer = sim(&[&one, &two]);
    assert_eq!(answer["pixels"], 6 * 160 * 120);
    assert_eq!(answer["cycles_per_pixel"], 1.0);
    assert_eq!((&answer["mismatches"], &answer["first_mismatch"]), (&0.into(), &Value::Null));
    assert_eq!((&answer["dropped"], &answer["pass"]), (&0.into(), &true.into()));
    // The hash comes from the simulated register, the folder from the command.
    let (design, emission) = (&answer["verilog"]["design"], answer["verilog"]["emission"].as_str().unwrap());
    assert_eq!(
        (design, u32::from_str_radix(emission, 16)),
        (&"kt27".into(), Ok(hoverlock_rtl::emission::emission().unwrap()))
    );
    let pictures = answer["pictures"].as_array().unwrap();
    let features = pictures.iter().map(|picture| picture["features"].as_u64().unwrap());
    assert!(features.clone().all(|count| count > 0 && count % 3 == 0), "{answer}");
    assert_eq!(answer["features"], features.sum::<u64>());
    assert_eq!(answer["features"], answer["model_features"]);
    for (picture, path) in pictures.iter().zip([&one, &two]) {
        assert_eq!((&picture["image"], &picture["frames"]), (&path.as_str().into(), &3.into()));
    }
}

#[test]
fn pauses_and_too_few_frames_leave_no_rate() {
    let folder = tempfile::tempdir().unwrap();
    let one = picture(folder.path(), "one.png", 1);
    for args in [&[&one, "--stall", "0.3", "--seed", "4"][..], &[&one, "--frames", "2"]] {
        let answer = sim(args);
        assert_eq!((&answer["cycles_per_pixel"], &answer["pass"]), (&Value::Null, &true.into()), "{args:?}");
    }
}

#[test]
fn a_sink_that_opens_late_shows_what_was_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let one = picture(folder.path(), "one.png", 1);
    let whole = sim(&[&one, "--frames", "12"]);
    let late = sim(&[&one, "--frames", "12", "--sink-opens", "230000"]);
    let count = |name: &str| late[name].as_u64().unwrap();
    assert!(count("dropped") > 0 && count("features") > 0, "{late}");
    assert_eq!(count("features") + count("dropped"), count("model_features"));
    assert_eq!(late["model_features"], whole["features"]);
    assert_eq!((&late["mismatches"], &late["cycles_per_pixel"]), (&0.into(), &Value::Null));
}

#[test]
#[ignore = "long: a Verilated model with waves built in"]
fn waves_come_with_their_view() {
    let folder = tempfile::tempdir().unwrap();
    let one = picture(folder.path(), "one.png", 1);
    let wave = folder.path().join("run.fst").display().to_string();
    let answer = sim(&[&one, "--wave", &wave, "--wave-cycles", "500"]);
    assert_eq!((&answer["wave"], &answer["pass"]), (&wave.as_str().into(), &true.into()));
    let mut names: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["one.png", "run.fst", "run.gtkw"]);
    let view = std::fs::read_to_string(folder.path().join("run.gtkw")).unwrap();
    assert!(view.starts_with("[dumpfile] \"run.fst\"\n"), "{view}");
}
