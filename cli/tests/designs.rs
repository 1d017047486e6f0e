//! `--design` and `--rtl` as a user gives them: what is refused, and by which constraint.

use std::fs;
use std::process::{Command, Output};

#[path = "common/refusal.rs"]
mod refusal;

use refusal::assert_refused;

fn hoverlock(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(args).output().expect("the command runs")
}

#[test]
fn a_design_that_is_not_there_or_cannot_be_built_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let part = path("part.toml", "width = 640\n");
    let wide = path("wide.toml", &include_str!("../../designs/kt27.toml").replace("\"u16.2\"", "\"u16.3\""));
    for (design, named) in [
        ("nosuch", "the names are kt27, hd1080, small"),
        (part.as_str(), "the key `height` is missing"),
        (wide.as_str(), "state = u16.3 cannot be built: the multiplier of a lerp is 18 x 18"),
    ] {
        assert_refused(&hoverlock(&["rtl", "emit", "--design", design]), named);
        assert_refused(&hoverlock(&["rtl", "estimate", "--design", design, "--json"]), named);
    }
    let change = "look_ahead=[5, 5, 7]";
    assert_refused(&hoverlock(&["rtl", "emit", "--config", change]), "a smoother has 2 to 6 stages");
}

#[test]
fn a_folder_without_verilog_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().display().to_string();
    let picture = folder.path().join("ground.png");
    image::GrayImage::from_fn(80, 80, |x, y| image::Luma([(x * y % 251) as u8])).save(&picture).unwrap();
    for rtl in [empty.as_str(), "/nope"] {
        assert_refused(&hoverlock(&["rtl", "estimate", "--rtl", rtl]), "no Verilog file (*.v) in this folder");
        let sim = hoverlock(&["sim", &picture.display().to_string(), "--rtl", rtl]);
        assert_refused(&sim, "no Verilog file (*.v) in this folder");
    }
    assert_eq!(hoverlock(&["rtl", "estimate", "--out", "/nope"]).status.code(), Some(2));
}

#[test]
fn the_folder_of_the_project_is_the_same_named_or_not() {
    let project = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let elsewhere = tempfile::tempdir().unwrap();
    fs::create_dir(elsewhere.path().join("rtl")).unwrap();
    let within = |folder: &std::path::Path, args: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(args).current_dir(folder).output().unwrap()
    };
    for args in [&["rtl", "check"][..], &["rtl", "check", "--out", "rtl"], &["rtl", "check", "--out", "./rtl/"]] {
        let output = within(project.as_ref(), args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {output:?}");
    }
    for verb in ["emit", "check"] {
        let output = within(elsewhere.path(), &["rtl", verb]);
        assert_refused(&output, "run this in the project, or give --out");
    }
    assert!(fs::read_dir(elsewhere.path().join("rtl")).unwrap().next().is_none());
}

#[test]
fn keys_are_changed_together() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("one.toml").display().to_string();
    let one_pair = ["scale_pairs=1", "sigmas=[2,3.2]", "look_ahead=[5,5]", "ring_radii=[12]"];
    let options: Vec<&str> = one_pair.iter().flat_map(|change| ["--config", change]).collect();
    assert!(hoverlock(&[&["design", "show"][..], &options].concat()).status.success());
    assert!(hoverlock(&["design", "new", &file]).status.success());
    assert_refused(&hoverlock(&["design", "set", &file, "scale_pairs=1"]), "needs a list of 2");
    assert!(hoverlock(&[&["design", "set", &file][..], &one_pair].concat()).status.success());
    assert!(hoverlock(&["design", "set", &file, "state=u10.8", "pixel=u10.0"]).status.success());
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.contains("scale_pairs = 1") && text.contains("state = \"u10.8\""), "{text}");
}

#[test]
fn the_coefficients_of_a_design_are_those_of_its_registers() {
    let output = hoverlock(&["coeffs", "--design", "small", "--json"]);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let stages: Vec<_> = answer["sets"].as_array().unwrap().iter().map(|set| set["sigma"].as_f64().unwrap()).collect();
    assert_eq!(stages, [1.2, 1.8, 2.7]);
    assert!(!hoverlock(&["coeffs", "--design", "small", "--sigma", "2"]).status.success());
}

#[test]
fn a_design_file_is_written_changed_and_compared() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("camera.toml");
    let file = file.to_str().unwrap();
    let text = |output: Output| {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    text(hoverlock(&["design", "new", file, "--design", "small", "--config", "dog_bits=14"]));
    assert_refused(&hoverlock(&["design", "new", file]), "the file exists");
    assert_eq!(text(hoverlock(&["design", "diff", "small", file])), "dog_bits: 9 -> 14\n");

    let commented = fs::read_to_string(file).unwrap().replace("width = 640", "width = 640 # of the lens");
    fs::write(file, &commented).unwrap();
    // The state has the integer bits of the pixel, so it follows.
    text(hoverlock(&["design", "set", file, "width=512", "pixel=u10.0"]));
    let changed = fs::read_to_string(file).unwrap();
    assert!(changed.contains("width = 512 # of the lens\n"), "{changed}");
    let before: Vec<&str> = commented.lines().filter(|line| line.starts_with('#')).collect();
    let after: Vec<&str> = changed.lines().filter(|line| line.starts_with('#')).collect();
    assert_eq!(before, after);
    let report: serde_json::Value =
        serde_json::from_str(&text(hoverlock(&["design", "diff", "small", file, "--json"]))).unwrap();
    let keys: Vec<_> = report["differences"].as_array().unwrap().iter().map(|found| &found["key"]).collect();
    assert_eq!(keys, ["width", "pixel", "state", "dog_bits"]);

    assert_refused(&hoverlock(&["design", "set", file, "nosuch=1"]), "nosuch");
    assert_refused(&hoverlock(&["design", "set", "kt27", "width=512"]), "built in");
    assert_eq!(fs::read_to_string(file).unwrap(), changed);
    let show: serde_json::Value =
        serde_json::from_str(&text(hoverlock(&["design", "show", "--design", file, "--json"]))).unwrap();
    assert_eq!(show["design"]["width"], 512);
    assert_eq!(show["keys"][0]["limits"][0], "a whole number from 1 to 4096");
}
