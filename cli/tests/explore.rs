//! `hoverlock explore` as a user runs it: the best design, its file, a second run, and bad input.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use hoverlock_design::DesignPoint;
use image::{GrayImage, ImageBuffer, Luma};
use serde_json::Value;

fn explore(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).arg("explore").args(arguments).output().expect("the command runs")
}

fn saved(folder: &Path, name: &str, picture: &GrayImage) -> String {
    let path = folder.join(name);
    picture.save(&path).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Blocks of three sizes: features everywhere.
fn blobs(width: u32, height: u32) -> GrayImage {
    let hash = |x: u32, y: u32| {
        let mixed = u64::from(x).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(y).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 56) as u32
    };
    ImageBuffer::from_fn(width, height, |x, y| {
        Luma([((hash(x / 5, y / 5) + hash(x / 11, y / 11 + 1000) + hash(x / 23, y / 23 + 2000)) / 3) as u8])
    })
}

#[test]
fn the_best_design_is_a_design_file_and_a_second_run_measures_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "blobs.png", &blobs(440, 400));
    let out = folder.path().join("out");
    let run = |more: &[&str]| {
        let output = explore(&[&[&picture, "--out", out.to_str().unwrap(), "--json"], more].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{said}");
        (serde_json::from_slice::<Value>(&output.stdout).unwrap(), said)
    };
    let (first, _) = run(&[]);
    assert_eq!((&first["pass"], &first["decided"], &first["complete"]), (&true.into(), &true.into(), &true.into()));
    let best = DesignPoint::from_file(&fs::read_to_string(out.join("best.toml")).unwrap()).unwrap();
    assert_eq!(serde_json::to_value(&best).unwrap(), first["best"]["design"]);
    // No design that passes costs less, and the front rises in memory and falls in error.
    let points = first["points"].as_array().unwrap();
    let m10k = |point: &Value| point["m10k"].as_u64().unwrap();
    assert!(points.iter().filter(|point| point["pass"] == true).all(|point| m10k(point) >= m10k(&first["best"])));
    let front = first["pareto"].as_array().unwrap();
    let error = |point: &Value| point["dog_rms_lsb"].as_f64().unwrap();
    assert!(front.windows(2).all(|two| m10k(&two[0]) <= m10k(&two[1]) && error(&two[0]) >= error(&two[1])));
    assert_eq!(fs::read_to_string(out.join("points.csv")).unwrap().lines().count(), 1 + points.len());
    assert!(fs::read_to_string(out.join("index.html")).unwrap().contains(">FOUND<"));
    // A search that was cut off in its last line takes over all others; another objective needs the same results.
    let results = fs::read_to_string(out.join("results.jsonl")).unwrap();
    fs::write(out.join("results.jsonl"), &results[..results.len() - 9]).unwrap();
    let (again, said) = run(&["--objective", "m10k"]);
    assert_eq!(again["measured"], 1, "{said}");
    // A number that was read from JSON may differ in its last bit; what is concluded may not.
    let concluded = |search: &Value| -> Vec<Value> {
        let points = search["points"].as_array().unwrap();
        points.iter().map(|p| serde_json::json!([p["name"], p["status"], p["front"], p["frames"]])).collect()
    };
    assert!(concluded(&again) == concluded(&first));
    let (other, _) = run(&["--objective", "error"]);
    assert!(error(&other["best"]) <= error(&first["best"]));
}

#[test]
fn a_picture_without_features_judges_no_design() {
    let folder = tempfile::tempdir().unwrap();
    let plain = ImageBuffer::from_fn(90, 80, |x, y| Luma([(x * x / 7 + y * y / 5 + x * y / 3) as u8]));
    let plain = saved(folder.path(), "plain.png", &plain);
    let flat = saved(folder.path(), "flat.png", &GrayImage::from_pixel(90, 80, Luma([7])));
    let good = saved(folder.path(), "good.png", &blobs(440, 400));
    let out = folder.path().join("out");
    let run = |pictures: &[&str]| {
        let output = explore(&[pictures, &["--out", out.to_str().unwrap(), "--json", "--budget", "1"]].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), output.stdout)
    };
    // Without any that does, there is no search: one line says why, and nothing is left.
    for pictures in [&[&*plain][..], &[&flat, &plain]] {
        let (status, said, stdout) = run(pictures);
        assert_eq!((status, said.trim_end().lines().count()), (Some(2), 1), "{said}");
        assert!(said.contains("no picture can judge the design: ") && said.contains("plain, nominal: unfit"), "{said}");
        assert_eq!(said.contains("flat.png: unfit"), pictures.len() == 2, "{said}");
        assert!(stdout.is_empty() && !out.exists(), "{said}");
    }
    // Beside one that does, it is listed.
    let (status, said, stdout) = run(&[&flat, &plain, &good]);
    assert_eq!(status, Some(0), "{said}");
    let json: Value = serde_json::from_slice(&stdout).unwrap();
    let unfit = json["unfit"].as_array().unwrap();
    let lists = |name: &str| unfit.iter().any(|unfit| unfit["picture"].as_str().unwrap().ends_with(name));
    assert!(lists("plain") && lists("flat.png") && !lists("good"), "{unfit:?}");
    assert!(said.contains("flat.png: unfit") && said.contains("plain, nominal: unfit"), "{said}");
    let best = fs::read_to_string(out.join("best.toml")).unwrap();
    assert!(best.contains("It passes every check of the report on good. "), "{best}");
    assert!(fs::read_to_string(out.join("index.html")).unwrap().contains("<li>plain, nominal: streaming has "));
}

/// A program that was built again may measure something else, whatever its commit says.
#[test]
fn results_of_another_program_are_not_reused() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "blobs.png", &blobs(440, 400));
    let out = folder.path().join("out");
    let restored = |program: &Path| {
        let mut command = Command::new(program);
        command.args(["explore", &picture, "--json", "--budget", "1", "--out"]).arg(&out);
        let output = command.output().expect("the command runs");
        let found: Value = serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else");
        found["restored"].as_u64().unwrap()
    };
    let program = Path::new(env!("CARGO_BIN_EXE_hoverlock"));
    let other = folder.path().join("hoverlock");
    // Bytes after the last section of a program are not loaded. Written by another process, because a program that is
    // open for writing cannot be run.
    let copy =
        Command::new("sh").args(["-c", "cp \"$0\" \"$1\" && printf other >> \"$1\""]).args([program, &other]).status();
    assert!(copy.unwrap().success());
    assert_eq!(restored(program), 0);
    assert_eq!(restored(&other), 0);
    assert!(restored(program) > 0);
}

#[test]
fn files_of_somebody_else_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "blobs.png", &blobs(440, 400));
    let out = folder.path().join("out");
    let refused = |reason: &str| {
        let output = explore(&[&picture, "--out", out.to_str().unwrap(), "--budget", "1"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(reason), "{said}");
    };
    for name in ["index.html", "explore.json", "points.csv", "best.toml", "results.jsonl"] {
        fs::create_dir(&out).unwrap();
        fs::write(out.join(name), "mine").unwrap();
        refused(&format!("{name}: is not a file of hoverlock explore"));
        assert_eq!(fs::read_to_string(out.join(name)).unwrap(), "mine");
        fs::remove_dir_all(&out).unwrap();
    }
    // A link to nothing would make a file elsewhere.
    fs::create_dir(&out).unwrap();
    fs::write(out.join(".hoverlock"), "hoverlock explore\n").unwrap();
    std::os::unix::fs::symlink("../elsewhere", out.join("results.jsonl")).unwrap();
    refused("results.jsonl: is a link to nothing");
    assert!(!folder.path().join("elsewhere").exists());
}

#[test]
fn bad_input_is_one_line_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let good = saved(folder.path(), "good.png", &blobs(90, 80));
    let broken = folder.path().join("broken");
    fs::create_dir(&broken).unwrap();
    fs::write(broken.join("results.jsonl"), "[1, 2]\n").unwrap();
    // As an explore that was stopped leaves it; in any other folder the file is not read.
    fs::write(broken.join(".hoverlock"), "hoverlock explore\n").unwrap();
    let hover = |more: &[&'static str]| [&["--objective", "hover", "--out", out][..], more].concat();
    let cases: [(&[&str], &str); 14] = [
        (&["none.png", "--out", out], "none.png"),
        (&[&good, "--out", out, "--budget", "0"], "budget"),
        (&[&good, "--out", out, "--objective", "speed"], "m10k"),
        (&[&good, "--out", out, "--config", "state=u16.3"], "cannot be built"),
        (&[&good, "--out", broken.to_str().unwrap()], "line 1 is no result"),
        (&["--out", out], "a picture is missing"),
        (&[&good, "--out", out, "--budget-cm", "10"], "--budget-cm: only --objective hover flies"),
        (&[&good, "--out", out, "--scenes", "field"], "--scenes: only --objective hover flies"),
        (&hover(&[]), "--budget-cm is missing"),
        (&hover(&["--budget-cm", "0"]), "must be 0.1 to 1000"),
        (&hover(&["--budget-cm=-3"]), "must be 0.1 to 1000"),
        (&hover(&["--budget-cm", "10", "--scenes", "field,moon"]), "scene moon: no such scene"),
        (&hover(&["--budget-cm", "10", "--design", "small"]), "the simulated camera's frames have 1024 x 768"),
        (&[&good, "--objective", "hover", "--budget-cm", "10", "--out", out], "takes no picture"),
    ];
    for (arguments, reason) in cases {
        let output = explore(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        assert!(said.contains(reason), "{arguments:?}: {said}");
        assert!(output.stdout.is_empty() && !Path::new(out).exists());
    }
}

/// A search by flights whose base misses the budget: what it says and writes, and that a second run flies nothing.
#[test]
fn a_budget_that_the_base_misses_is_status_1_and_a_second_run_flies_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = || {
        let out = out.to_str().unwrap();
        let flights = ["--scenes", "field", "--seed", "2", "--seeds", "1", "--seconds", "4"];
        let output =
            explore(&[&["--objective", "hover", "--budget-cm", "0.1", "--out", out, "--json"], &flights[..]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let first = run();
    assert_eq!((&first["pass"], &first["flown"], &first["restored"]), (&false.into(), &3.into(), &0.into()));
    assert_eq!((&first["best"], &first["binding"]), (&Value::Null, &Value::Null));
    let base = &first["points"][0];
    assert!(base["failure"].as_str().unwrap().contains("cm rms from the target"), "{base}");
    assert!(fs::read_to_string(out.join("index.html")).unwrap().contains(">NONE<") && !out.join("best.toml").exists());
    let again = run();
    assert_eq!((&again["flown"], &again["restored"]), (&0.into(), &3.into()));
}
