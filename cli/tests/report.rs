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

/// Blocks of three sizes: features everywhere.
fn blocks(width: u32, height: u32) -> GrayImage {
    let hash = |x: u32, y: u32| {
        let mixed = u64::from(x).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(y).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 56
    };
    ImageBuffer::from_fn(width, height, |x, y| {
        Luma([((hash(x / 5, y / 5) + hash(x / 11, y / 11 + 1000) + hash(x / 23, y / 23 + 2000)) / 3) as u8])
    })
}

/// Returns the command with no program in reach, so that `rtl` is not run.
fn without_tools(program: &str) -> Command {
    let mut command = Command::new(program);
    command.env("PATH", Path::new(env!("CARGO_BIN_EXE_hoverlock")).parent().expect("the command is in a folder"));
    command
}

fn parsed(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
        .expect("a report is JSON")
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
        (&[&good, &small, "--out", &out], "small.png: unfit"),
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
fn a_picture_with_too_few_features_is_unfit_and_does_not_fail_the_design() {
    let folder = tempfile::tempdir().unwrap();
    let tiny = saved(folder.path(), "tiny.png", &texture(79, 79));
    let flat = saved(folder.path(), "flat.png", &GrayImage::from_pixel(90, 90, Luma([7])));
    let good = saved(folder.path(), "good.png", &blocks(440, 400));
    let out = folder.path().join("out");
    let run = |pictures: &[&str]| {
        let mut command = without_tools(env!("CARGO_BIN_EXE_hoverlock"));
        let output = command.arg("report").args(pictures).args(["--json", "--out", out.to_str().unwrap()]).output();
        let output = output.expect("the command runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), output.stdout)
    };
    // Alone it gives no verdict, and nothing is written.
    let (status, said, stdout) = run(&[&tiny]);
    assert!(status == Some(2) && said.contains("no picture can judge the design: tiny, nominal"), "{said}");
    assert!(said.trim_end().lines().count() == 1 && stdout.is_empty() && !out.exists(), "{said}");
    let (status, said, stdout) = run(&[&flat, &tiny, &good]);
    assert_eq!(status, Some(0), "{said}");
    for reason in ["flat.png: unfit", "tiny, nominal: unfit", "rtl not run: verilator was not found"] {
        assert!(said.contains(reason), "{said}");
    }
    let junit = fs::read_to_string(out.join("junit.xml")).unwrap();
    assert!(junit.contains("every pixel") && junit.contains("tiny, nominal"), "{junit}");
    let printed: serde_json::Value = serde_json::from_slice(&stdout).expect("one JSON object and nothing else");
    assert_eq!(printed["pass"], true);
    assert_eq!(level(&printed, "rtl")["hardware"]["simulation"]["status"], "not run");
    let rows = printed["bounds"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["name"] != "RTL mismatches" && row["picture"] != "tiny"));
    assert!(rows.iter().any(|row| row["picture"] == "good"));
    assert_eq!(printed, parsed(&out.join("report.json")));
    assert_eq!(printed["pictures_given"], 3);
    let mut command = without_tools(env!("CARGO_BIN_EXE_hoverlock"));
    let text = command.args(["report", &tiny, &good, "--out", out.to_str().unwrap()]).output().unwrap().stdout;
    let text = String::from_utf8_lossy(&text);
    assert!(text.contains("PASS") && text.contains(" checks pass on 1 of 2 picture(s)"), "{text}");
    assert!(out.join("index.html").exists() && out.join("junit.xml").exists());
}

/// Each row of the alternatives is a command that anyone can paste: it is run, and must give the row's verdict.
#[test]
#[ignore = "two dozen reports: a minute"]
fn every_alternative_is_a_command_that_gives_its_verdict() {
    let folder = tempfile::tempdir().unwrap();
    saved(folder.path(), "blocks.png", &blocks(330, 330));
    let in_shell = |line: &str| {
        let output = without_tools("/bin/sh").args(["-c", line]).current_dir(folder.path()).output();
        output.expect("a shell runs").status.code()
    };
    assert_eq!(in_shell("hoverlock report blocks.png --out base --config threshold_target=400"), Some(0));
    let base = parsed(&folder.path().join("base/report.json"));
    let rows = base["alternatives"].as_array().unwrap();
    let others: Vec<_> = rows.iter().filter(|row| row["chosen"] == false).collect();
    let of = |word: &str, pass: bool| others.iter().any(|row| row["word"] == word && row["pass"] == pass);
    // Both verdicts of each word; a shorter look-ahead always fails.
    assert!(["state", "coefficients", "DoG", "pixel"].iter().all(|word| of(word, true) && of(word, false)));
    assert!(of("look-ahead", false) && others.len() > 20, "{others:?}");
    for row in others {
        let line = row["command"].as_str().unwrap();
        let pass = row["pass"].as_bool().unwrap();
        assert_eq!(in_shell(line), Some(if pass { 0 } else { 1 }), "{line}\n{row}");
        let (_, out) = line.split_once(" --out ").expect("a folder is named");
        let report = parsed(&folder.path().join(out).join("report.json"));
        let checks = report["bounds"].as_array().unwrap().iter();
        // The motions of a design that fails are not estimated for the row.
        let judged = checks.filter(|check| pass || !check["name"].as_str().unwrap().starts_with("displacement"));
        let used = |check: &serde_json::Value| check["used"].as_f64().unwrap_or(f64::INFINITY).min(1e6);
        let worst = judged.max_by(|a, b| used(a).total_cmp(&used(b))).expect("there are checks");
        assert_eq!(row["worst"]["check"], worst["name"], "{line}");
        assert_eq!(row["worst"]["measured"], worst["measured"], "{line}");
    }
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
    // A design that is changed by keys is simulated like any other.
    if hardware["simulation"]["status"] == "run" {
        let changed = parsed(&folder.path().join("report.json"));
        let simulation = &level(&changed, "rtl")["hardware"]["simulation"];
        assert!(simulation["status"] == "run" && simulation["result"][0]["mismatches"] == 0, "{simulation}");
    }
}

#[test]
fn the_furthest_failures_are_listed_and_the_others_counted() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let pictures = [(440, 400), (400, 440)].map(|(w, h)| saved(folder.path(), &format!("{w}.png"), &blocks(w, h)));
    let mut command = without_tools(env!("CARGO_BIN_EXE_hoverlock"));
    let output = command.arg("report").args(&pictures).args(["--config", "dog_bits=8", "--out", &at("out")]).output();
    let output = output.expect("the command runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let failed = parsed(Path::new(&at("out/report.json")))["bounds"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| row["pass"] == false)
        .count();
    assert!(failed > 12, "{failed} checks fail");
    assert_eq!(said.matches("bound fails: ").count(), 10, "{said}");
    assert!(said.contains(&format!("{} more bounds fail; {} lists all", failed - 10, at("out/checks.csv"))), "{said}");
    // A bound without a unit leaves no space in its place.
    assert!(!said.contains(" ,") && !said.contains("  "), "{said}");
}

/// The level of this name in a report.
fn level<'a>(report: &'a serde_json::Value, name: &str) -> &'a serde_json::Value {
    let levels = report["levels"].as_array().expect("levels is a list");
    levels.iter().find(|level| level["name"] == name).expect("every level is in the report")
}

#[test]
fn every_picture_has_a_name_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    for (number, name) in ["1/a.png", "2/a.png", "a (2).png"].into_iter().enumerate() {
        fs::create_dir_all(folder.path().join(name).parent().unwrap()).unwrap();
        saved(folder.path(), name, &blocks(300 + number as u32, 260));
    }
    let out = folder.path().join("out");
    let run = |to: &str, more: &[&str]| {
        let mut command = without_tools(env!("CARGO_BIN_EXE_hoverlock"));
        command.current_dir(folder.path()).args(["report", "1/a.png", "2/a.png", "a (2).png", "--out", to]).args(more);
        command.output().expect("the command runs")
    };
    let first = run("out", &[]);
    assert!(first.status.code() != Some(2), "{first:?}");
    let report: serde_json::Value = serde_json::from_slice(&fs::read(out.join("report.json")).unwrap()).unwrap();
    let names: Vec<&str> =
        report["pictures"].as_array().unwrap().iter().map(|of| of["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["a", "a (2)", "a (2) (2)"]);
    // Nothing has changed against itself; without a baseline its page is gone.
    let said = String::from_utf8(run("out", &["--baseline", "out/report.json"]).stderr).unwrap();
    assert!(said.contains("against the baseline 0 checks fail now or are gone, 0 pass now, 0 moved"), "{said}");
    assert!(out.join("baseline.html").exists());
    run("out", &[]);
    assert!(!out.join("baseline.html").exists());
    // One that no report has written stays.
    let foreign = folder.path().join("site/baseline.html");
    fs::create_dir(folder.path().join("site")).unwrap();
    fs::write(&foreign, "mine").unwrap();
    let refused = run("site", &[]);
    assert_eq!(
        (refused.status.code(), fs::read_to_string(&foreign).unwrap().as_str()),
        (Some(2), "mine"),
        "{refused:?}"
    );
}

#[test]
fn a_baseline_shows_what_changed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let picture = saved(folder.path(), "picture.png", &blocks(440, 400));
    let run = |more: &[&str]| {
        let mut command = without_tools(env!("CARGO_BIN_EXE_hoverlock"));
        let output = command.args(["report", &picture, "--config", "threshold_target=500"]).args(more).output();
        let output = output.expect("the command runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    run(&["--out", &at("first")]);
    let earlier = at("first/report.json");
    // The same again: nothing is worse off.
    let (status, said) = run(&["--out", &at("same"), "--baseline", &earlier]);
    assert!(
        status == Some(0) && said.contains("against the baseline 0 checks fail now or are gone, 0 pass now"),
        "{said}"
    );
    let page = fs::read_to_string(at("same/baseline.html")).unwrap();
    assert!(page.contains(">PASS<") && page.contains("The design is the same."));
    // Fewer bits: the page names the check and the key.
    let (status, said) = run(&["--out", &at("worse"), "--baseline", &earlier, "--config", "dog_bits=9"]);
    assert!(status == Some(1) && !said.contains("baseline 0 checks"), "{said}");
    let page = fs::read_to_string(at("worse/baseline.html")).unwrap();
    assert!(page.contains(">FAIL<") && page.contains("fails now") && page.contains("<code>dog_bits</code>"));
    // Another picture under the same name.
    saved(folder.path(), "picture.png", &blocks(430, 400));
    let (_, said) = run(&["--out", &at("renewed"), "--baseline", &earlier]);
    assert!(said.contains("another content: picture: sha256 ") && !said.contains("bounds.toml"), "{said}");
    assert!(fs::read_to_string(at("renewed/baseline.html")).unwrap().contains("Not the same inputs"));
    // No report.
    fs::write(at("other.json"), "{}").unwrap();
    for (file, reason) in [(at("other.json"), "not the report.json"), (at("none.json"), "cannot be read")] {
        let (status, said) = run(&["--out", &at("none"), "--baseline", &file]);
        assert!(status == Some(2) && said.contains(reason) && said.trim_end().lines().count() == 1, "{said}");
        assert!(!Path::new(&at("none")).exists());
    }
}
