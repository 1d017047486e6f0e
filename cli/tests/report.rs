//! `hoverlock report` as a user runs it: status, streams and one clear line for bad input.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use hoverlock_pictures::{data_dir, demo_dir};
use image::{GrayImage, ImageBuffer, Luma};

fn report(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).arg("report").args(arguments).output().expect("the command runs")
}

fn saved(folder: &Path, name: &str, picture: &GrayImage) -> String {
    let path = folder.join(name);
    picture.save(&path).unwrap();
    path.to_str().unwrap().to_owned()
}

fn texture(width: u32, height: u32) -> GrayImage {
    ImageBuffer::from_fn(width, height, |x, y| Luma([(x * x / 7 + y * y / 5 + x * y / 3) as u8]))
}

#[test]
fn bad_input_is_one_line_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let out = at("out");
    fs::write(at("text.png"), "no picture").unwrap();
    fs::write(at("empty.png"), "").unwrap();
    fs::write(at("file"), "").unwrap();
    fs::create_dir(at("none")).unwrap();
    let good = saved(folder.path(), "good.png", &texture(90, 80));
    let small = saved(folder.path(), "small.png", &texture(90, 78));
    let flat = saved(folder.path(), "flat.png", &GrayImage::from_pixel(90, 90, Luma([7])));
    let line = saved(folder.path(), "line.png", &texture(2000, 20));
    let under_file = at("file/out");
    let cases: [(&[&str], &str); 12] = [
        (&[&at("none.png"), "--out", &out], "none.png"),
        (&[&at("none"), "--out", &out], "holds no picture"),
        (&[&at("text.png"), "--out", &out], "not a picture"),
        (&[&at("empty.png"), "--out", &out], "is empty"),
        (&[&small, "--out", &out], "79 x 79"),
        (&[&line, "--out", &out], "79 x 79"),
        (&[&flat, "--out", &out], "every pixel"),
        (&[&good, &small, "--out", &out], "small.png"),
        (&[&good, "--out", &out, "--config", "dog_bits=200"], "dog_bits"),
        (&[&good, "--out", &out, "--config", "sigmas=[nan, 3, 5]"], "sigmas"),
        (&[&good, "--out", &out, "--config", "missing.toml"], "missing.toml"),
        (&[&good, "--out", &under_file], "file"),
    ];
    for (arguments, reason) in cases {
        let output = report(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        assert!(said.contains(reason), "{arguments:?}: {said}");
        assert!(output.stdout.is_empty());
        assert!(!Path::new(&out).exists(), "nothing is written");
    }
}

#[test]
fn a_picture_with_too_few_features_fails_with_status_1_and_names_the_bound() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "tiny.png", &texture(79, 79));
    let out = folder.path().join("out");
    // Without tools: `rtl` is said to be not run, and is no bound.
    let output = Command::new(env!("CARGO_BIN_EXE_hoverlock"))
        .args(["report", &picture, "--out", out.to_str().unwrap(), "--json"])
        .env("PATH", "")
        .output()
        .expect("the command runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("bound fails: features of streaming") && said.contains("tiny, nominal"), "{said}");
    assert!(said.contains("rtl not run: verilator was not found"), "{said}");
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else");
    assert_eq!(printed["pass"], false);
    assert_eq!(level(&printed, "rtl")["hardware"]["simulation"]["status"], "not run");
    assert!(printed["bounds"].as_array().unwrap().iter().all(|row| row["name"] != "RTL mismatches"));
    let written: serde_json::Value = serde_json::from_slice(&fs::read(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(printed, written);
    assert!(out.join("index.html").exists() && out.join("junit.xml").exists());
}

#[test]
#[ignore = "a minute on real pictures"]
fn real_pictures_pass_and_a_dog_of_twelve_bits_does_not() {
    let textures = data_dir().map(|folder| folder.join("textures"));
    let wanted = ["pasture_low_texture.png", "urban_intersection_a.png", "aero1.jpg"];
    let folders: Vec<_> = [textures, demo_dir()].into_iter().flatten().collect();
    let found: Vec<String> = folders
        .iter()
        .flat_map(|folder| wanted.map(|name| folder.join(name)))
        .filter(|path| path.exists())
        .map(|path| path.to_str().unwrap().to_owned())
        .collect();
    let Some(first) = found.first() else {
        let test = "real_pictures_pass_and_a_dog_of_twelve_bits_does_not";
        writeln!(std::io::stderr(), "SKIPPED: {test}: run `make demo` for the photographs, or set HOVERLOCK_DATA")
            .expect("stderr is open");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let mut arguments: Vec<&str> = found.iter().map(String::as_str).collect();
    arguments.extend(["--out", out]);
    let output = report(&arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let text = fs::read(folder.path().join("report.json")).unwrap();
    let written: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let hardware = &level(&written, "rtl")["hardware"];
    if hardware["simulation"]["status"] == "run" {
        let runs = hardware["simulation"]["result"].as_array().unwrap();
        assert_eq!(runs.len(), found.len());
        for run in runs {
            assert!(run["mismatches"] == 0 && run["features"].as_u64() > Some(600), "{run}");
            // Three frames back to back, a pixel a cycle; a hundredth is what may be lost at most.
            assert!(run["cycles_per_pixel"].as_f64().unwrap() <= 1.01, "{run}");
        }
    } else {
        writeln!(std::io::stderr(), "SKIPPED: rtl within real_pictures_pass_and_a_dog_of_twelve_bits_does_not: {said}")
            .expect("stderr is open");
    }
    let narrow = report(&[first, "--out", out, "--config", "dog_bits=12"]);
    let said = String::from_utf8_lossy(&narrow.stderr);
    assert_eq!(narrow.status.code(), Some(1), "{said}");
    assert!(said.contains("bound fails: DoG error, rms"), "{said}");
    assert!(said.contains("rtl not run: the Verilog is emitted for a whole design"), "{said}");
}

/// The level of this name in a report.
fn level<'a>(report: &'a serde_json::Value, name: &str) -> &'a serde_json::Value {
    let levels = report["levels"].as_array().expect("levels is a list");
    levels.iter().find(|level| level["name"] == name).expect("every level is in the report")
}

#[test]
fn a_baseline_shows_what_changed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let picture = saved(folder.path(), "picture.png", &texture(120, 100));
    let run = |more: &[&str]| {
        let output = report(&[&[&picture, "--config", "threshold_target=500"], more].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    run(&["--out", &at("first")]);
    let earlier = at("first/report.json");
    // The same again: nothing is worse off. So few features fail all the same.
    let (status, said) = run(&["--out", &at("same"), "--baseline", &earlier]);
    assert!(
        status == Some(1) && said.contains("against the baseline 0 checks fail now or are gone, 0 pass now"),
        "{said}"
    );
    let page = fs::read_to_string(at("same/baseline.html")).unwrap();
    assert!(page.contains(">PASS<") && page.contains("The design is the same."));
    // Fewer bits: the page names the check and the key.
    let (status, said) = run(&["--out", &at("worse"), "--baseline", &earlier, "--config", "dog_bits=9"]);
    assert!(status == Some(1) && !said.contains("baseline 0 checks"), "{said}");
    let page = fs::read_to_string(at("worse/baseline.html")).unwrap();
    assert!(page.contains(">FAIL<") && page.contains("fails now") && page.contains("<code>dog_bits</code>"));
    // No report.
    fs::write(at("other.json"), "{}").unwrap();
    for (file, reason) in [(at("other.json"), "not the report.json"), (at("none.json"), "cannot be read")] {
        let (status, said) = run(&["--out", &at("none"), "--baseline", &file]);
        assert!(status == Some(2) && said.contains(reason) && said.trim_end().lines().count() == 1, "{said}");
        assert!(!Path::new(&at("none")).exists());
    }
}
