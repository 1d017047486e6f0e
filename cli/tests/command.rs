//! What people expect of a command: names of every kind, files whole or not at all, signals, a full disk, broken tools,
//! and messages that say what to do.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::Write as _;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use hoverlock_reference::image::plane::Plane;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma};
use serde_json::Value;

fn command<S: AsRef<OsStr>>(args: &[S]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hoverlock"));
    command.args(args);
    command
}

fn hoverlock<S: AsRef<OsStr>>(args: &[S]) -> Output {
    command(args).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Status 2, and one line on stderr.
#[track_caller]
fn refusal<S: AsRef<OsStr>>(args: &[S]) -> String {
    let output = hoverlock(args);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    said
}

/// Smooth spots, 7 px apart.
fn texture(width: u32, height: u32) -> DynamicImage {
    // Mixed between the products: a linear hash repeats nearly, and ground that repeats is refused.
    let mixed = |v: u32| (v ^ (v >> 15)).wrapping_mul(0x27D4_EB2F);
    let lattice = |i: u32, j: u32| {
        let seed = i.wrapping_mul(0x9E37_79B9).wrapping_add(j.wrapping_mul(0x85EB_CA6B));
        f64::from(mixed(mixed(seed)) >> 24)
    };
    DynamicImage::ImageLuma8(ImageBuffer::from_fn(width, height, |x, y| {
        let (i, j, u, v) = (x / 7, y / 7, f64::from(x % 7) / 7.0, f64::from(y % 7) / 7.0);
        let along = |j: u32| lattice(i, j) * (1.0 - u) + lattice(i + 1, j) * u;
        Luma([(along(j) * (1.0 - v) + along(j + 1) * v) as u8])
    }))
}

fn saved(folder: &Path, name: impl AsRef<OsStr>, width: u32, height: u32) -> PathBuf {
    let path = folder.join(name.as_ref());
    texture(width, height).save_with_format(&path, ImageFormat::Png).unwrap();
    path
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Creates a program of this name that runs the script.
fn tool(folder: &Path, name: &str, script: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    path
}

#[test]
fn names_that_are_no_utf8_work_in_json() {
    let folder = tempfile::tempdir().unwrap();
    let odd = |name: &[u8]| folder.path().join(OsStr::from_bytes(name));
    let picture = saved(folder.path(), OsStr::from_bytes(b"a\xffb.png"), 440, 400);
    let json = |args: &[&OsStr]| -> Value {
        let output = hoverlock(args);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{args:?}: {error}"))
    };
    let of = OsStr::new;
    let matched = json(&[of("match"), picture.as_os_str(), picture.as_os_str(), of("--json")]);
    assert_eq!(matched["ok"], true);
    let sets = json(&[of("coeffs"), of("--sigma=2"), of("--json"), of("--out"), odd(b"out\xfe").as_os_str()]);
    assert!(sets["files"][0].as_str().unwrap().contains("out\u{fffd}"), "{sets}");
    let emitted = json(&[of("rtl"), of("emit"), of("--json"), of("--out"), odd(b"rtl\xfe").as_os_str()]);
    assert!(emitted["files"].as_array().unwrap().len() > 10);
    let config = odd(b"design\xfe.toml");
    fs::write(&config, "dog_bits = 15\n").unwrap();
    let out = odd(b"report\xfe");
    let [config, out] = [config.as_os_str(), out.as_os_str()];
    let report = json(&[of("report"), picture.as_os_str(), of("--json"), of("--out"), out, of("--config"), config]);
    assert_eq!(report["pictures"][0]["name"], "a\u{fffd}b");
    let simulated = json(&[of("sim"), picture.as_os_str(), of("--json"), of("--frames=1")]);
    assert!(simulated["pictures"][0]["image"].as_str().unwrap().ends_with("/a\u{fffd}b.png"), "{simulated}");
}

#[test]
fn a_name_with_a_newline_makes_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let said = refusal(&[OsStr::new("match"), folder.path().join("a\nb.png").as_os_str(), OsStr::new("c.png")]);
    assert!(said.contains("a\\nb.png"), "{said}");
    let picture = saved(folder.path(), "two\nlines.png", 1100, 80);
    let output =
        hoverlock(&[OsStr::new("match"), picture.as_os_str(), picture.as_os_str(), OsStr::new("--features=fixed")]);
    assert_eq!(stderr(&output).lines().count(), 2, "{}", stderr(&output));
}

#[test]
fn a_large_picture_needs_a_larger_limit() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("large.pgm");
    fs::write(&picture, [&b"P5 1200 1000 255\n"[..], &[7; 1_200_000]].concat()).unwrap();
    let picture = picture.to_str().unwrap();
    let said = refusal(&["match", picture, picture, "--max-megapixels", "1"]);
    assert!(said.contains("1200 x 1000, 1.2 megapixels, and the limit is 1"), "{said}");
    // Within the limit it is decoded, and found to be constant.
    assert!(refusal(&["match", picture, picture]).contains("every pixel"));
}

#[test]
fn a_picture_comes_through_standard_input_once() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "a.png", 120, 100);
    let mut child = command(&["match", "-", picture.to_str().unwrap(), "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(&fs::read(&picture).unwrap()).unwrap();
    let output = child.wait_with_output().unwrap();
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["ok"], true);
    assert!(refusal(&["match", "-", "-"]).contains("can be read once"));
}

#[test]
fn a_fifo_is_refused_and_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = folder.path().join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let fifo = fifo.to_str().unwrap();
    let started = Instant::now();
    for args in [["match", fifo, fifo], ["report", fifo, fifo], ["sim", "/dev/zero", "/dev/zero"]] {
        assert!(refusal(&args).contains("not a regular file"));
    }
    let picture = saved(folder.path(), "a.png", 90, 90);
    assert!(refusal(&["report", picture.to_str().unwrap(), "--config", fifo]).contains("not a regular file"));
    assert!(started.elapsed() < Duration::from_secs(5));
}

#[test]
fn a_folder_stands_for_its_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("pictures");
    fs::create_dir(&inside).unwrap();
    fs::write(inside.join("notes.txt"), "no picture").unwrap();
    let said = refusal(&["sim", inside.to_str().unwrap()]);
    assert!(said.contains("holds no picture"), "{said}");
    saved(&inside, "b.png", 90, 90);
    saved(&inside, "a.PNG", 40, 40);
    let said = refusal(&["report", inside.to_str().unwrap()]);
    assert!(said.contains("a.PNG") && said.contains("79 x 79"), "{said}");
}

#[test]
fn an_overlay_replaces_neither_its_input_nor_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "a.png", 120, 100);
    let before = fs::read(&picture).unwrap();
    let link = folder.path().join("link.png");
    std::os::unix::fs::symlink(&picture, &link).unwrap();
    let null = folder.path().join("null.png");
    std::os::unix::fs::symlink("/dev/null", &null).unwrap();
    let picture = picture.to_str().unwrap();
    let with = |overlay: &Path| refusal(&["match", picture, picture, "--overlay", overlay.to_str().unwrap()]);
    assert!(with(Path::new(picture)).contains("is one of the inputs"));
    assert!(with(&link).contains("is one of the inputs"));
    assert!(with(&null).contains("not a regular file"));
    assert!(with(&folder.path().join("a.jpg")).contains("must end in .png"));
    assert!(with(folder.path()).contains("must end in .png"));
    assert_eq!(fs::read(picture).unwrap(), before);
    assert_eq!(names(folder.path()), ["a.png", "link.png", "null.png"]);
}

#[test]
fn a_set_of_files_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/out");
    let write = |sigmas: &[&str]| {
        let mut args = vec!["coeffs", "--out", out.to_str().unwrap(), "--sigma"];
        args.extend(sigmas);
        hoverlock(&args)
    };
    assert!(write(&["2", "3", "4"]).status.success());
    let larger = names(&out);
    let before = fs::read(out.join("coefficients.json")).unwrap();
    // A folder has the name of one of the files.
    fs::remove_file(out.join("coefficients.vh")).unwrap();
    fs::create_dir(out.join("coefficients.vh")).unwrap();
    let output = write(&["5"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("coefficients.vh"), "{}", stderr(&output));
    assert_eq!(fs::read(out.join("coefficients.json")).unwrap(), before, "the others are as they were");
    assert_eq!(names(&out), larger);
    fs::remove_dir(out.join("coefficients.vh")).unwrap();
    let output = write(&["5"]);
    assert!(output.status.success());
    let said = stderr(&output);
    assert!(
        said.contains("files belong to an earlier, larger set, the first is dog0_frequency.svg; remove them"),
        "{said}"
    );
    // Verilog that no module emits is reported by emit and by check.
    let rtl = folder.path().join("my rtl");
    let rtl = rtl.to_str().unwrap();
    assert!(hoverlock(&["rtl", "emit", "--out", rtl]).stderr.is_empty());
    fs::write(format!("{rtl}/verilog/stray.v"), "module stray; endmodule\n").unwrap();
    assert!(stderr(&hoverlock(&["rtl", "emit", "--out", rtl])).contains("stray.v"));
    fs::write(format!("{rtl}/verilog/lerp.v"), "").unwrap();
    let said = stderr(&hoverlock(&["rtl", "check", "--out", rtl]));
    assert!(said.contains(&format!("run `hoverlock rtl emit --out '{rtl}'`")), "{said}");
}

#[test]
fn a_full_stderr_costs_no_results() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "a.png", 400, 300);
    let overlay = folder.path().join("overlay.png");
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    // The remark that the pictures are larger than the frame cannot be written.
    let small = ["--features", "fixed", "--config", "width=320", "--config", "height=240"];
    let mut matching = command(&[OsStr::new("match"), picture.as_os_str(), picture.as_os_str()]);
    let status = matching.args(small).arg("--overlay").arg(&overlay).stderr(full()).stdout(Stdio::null()).status();
    assert_eq!((status.unwrap().code(), overlay.exists()), (Some(0), true));
    assert_eq!(command(&["match", "none.png", "none.png"]).stderr(full()).status().unwrap().code(), Some(2));
}

#[test]
fn a_link_leads_to_its_file_and_a_read_only_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("a.toml"), folder.path().join("current.toml"));
    assert!(hoverlock(&[OsStr::new("design"), OsStr::new("new"), file.as_os_str()]).status.success());
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink("a.toml", &link).unwrap();
    let set = [OsStr::new("design"), OsStr::new("set"), link.as_os_str(), OsStr::new("dog_bits=12")];
    assert!(hoverlock(&set).status.success());
    assert!(link.is_symlink() && fs::read_to_string(&file).unwrap().contains("dog_bits = 12"));
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    fs::set_permissions(&file, fs::Permissions::from_mode(0o400)).unwrap();
    let said = refusal(&[set[0], set[1], set[2], OsStr::new("dog_bits=13")]);
    assert!(said.contains("current.toml: is read-only"), "{said}");
    let lost = folder.path().join("lost.toml");
    std::os::unix::fs::symlink("nowhere.toml", &lost).unwrap();
    let said = refusal(&[OsStr::new("design"), OsStr::new("new"), lost.as_os_str()]);
    assert!(said.contains("lost.toml: is a link to nothing") && lost.is_symlink(), "{said}");
}

/// The build script of the crate that knows the commit, in a small project of its own.
#[test]
fn an_edit_of_a_tracked_file_makes_the_commit_dirty() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("reports/src")).unwrap();
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../reports/build.rs"), at("reports/build.rs")).unwrap();
    let package = "[package]\nname = \"probe\"\nedition = \"2024\"\n\n[workspace]\n";
    fs::write(at("reports/Cargo.toml"), package).unwrap();
    fs::write(at("reports/src/main.rs"), "fn main() { print!(\"{}\", env!(\"HOVERLOCK_COMMIT\")) }\n").unwrap();
    fs::write(at("elsewhere.rs"), "").unwrap();
    fs::write(at(".gitignore"), "target\nCargo.lock\n").unwrap();
    let git = |args: &[&str]| {
        let name = ["-c", "user.name=Somebody", "-c", "user.email=somebody@localhost"];
        assert!(Command::new("git").args(name).args(args).current_dir(folder.path()).status().unwrap().success());
    };
    git(&["init", "-q"]);
    git(&["add", "."]);
    git(&["commit", "-q", "-m", "First"]);
    let commit = || {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["run", "-q", "--offline"]).current_dir(at("reports")).env("CARGO_TARGET_DIR", at("target"));
        let output = cargo.output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let clean = commit();
    assert!(clean.len() == 12 && !clean.ends_with("-dirty"), "{clean}");
    fs::write(at("elsewhere.rs"), "//! Edited.\n").unwrap();
    assert_eq!(commit(), format!("{clean}-dirty"));
}

fn wait_until(what: impl Fn() -> bool) {
    let started = Instant::now();
    while !what() {
        assert!(started.elapsed() < Duration::from_secs(60), "it never came");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn terminated(mut child: Child, signal: &str) -> Option<i32> {
    // Waiting closes standard input, and its end would be an answer: it stays open until the command is gone.
    let _open = child.stdin.take();
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    child.wait().unwrap().signal()
}

#[test]
fn a_signal_removes_what_is_half_written() {
    let folder = tempfile::tempdir().unwrap();
    let wave = folder.path().join("run.fst");
    for (signal, number) in [("-TERM", 15), ("-INT", 2)] {
        // It waits for its picture with the waves already asked for.
        let child = command(&["sim", "-", "--wave", wave.to_str().unwrap()]).stdin(Stdio::piped()).spawn().unwrap();
        wait_until(|| !names(folder.path()).is_empty());
        assert_eq!(terminated(child, signal), Some(number));
        assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));
    }
    let picture = saved(folder.path(), "a.png", 400, 300);
    let out = folder.path().join("some/report");
    let args = ["report", picture.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let child = command(&args).env("PATH", "").stderr(Stdio::null()).spawn().unwrap();
    wait_until(|| out.is_dir());
    assert_eq!(terminated(child, "-TERM"), Some(15));
    assert_eq!(names(folder.path()), ["a.png"]);
}

/// A file system of `size`.
struct Small(tempfile::TempDir);

impl Small {
    fn new(size: &str) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={size}"), "none"])
            .arg(folder.path())
            .stderr(Stdio::null())
            .status();
        if mounted.is_ok_and(|status| status.success()) {
            return Some(Self(folder));
        }
        writeln!(std::io::stderr(), "SKIPPED: a full disk: run as root, so that a small file system can be mounted")
            .expect("stderr is open");
        None
    }
}

impl Drop for Small {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

#[test]
fn a_full_disk_is_one_line() {
    let Some(small) = Small::new("64k") else { return };
    let out = small.0.path().join("coefficients");
    let said = refusal(&["coeffs", "--sigma", "2", "3", "4", "--out", out.to_str().unwrap()]);
    assert!(said.contains("No space left") && said.matches("No space left").count() == 1, "{said}");
    assert!(names(small.0.path()).is_empty(), "{:?}", names(small.0.path()));
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "a.png", 90, 90);
    let wave = small.0.path().join("run.fst");
    let said = refusal(&["sim", picture.to_str().unwrap(), "--wave", wave.to_str().unwrap()]);
    assert!(said.contains("no space left on the disk"), "{said}");
    assert!(names(small.0.path()).is_empty());
}

#[test]
#[ignore = "long: a Verilated model with waves built in"]
fn a_disk_that_fills_while_waves_are_written_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "a.png", 300, 200);
    let Some(small) = Small::new("40m") else { return };
    let sim = |wave: &Path| {
        let args = ["sim", picture.to_str().unwrap(), "--wave", wave.to_str().unwrap(), "--wave-cycles", "8000"];
        command(&args).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    // The model is built first, and the waves are those of a disk with room.
    assert!(sim(&folder.path().join("run.fst")).wait().unwrap().success());
    // Another program fills the disk while the waves are written.
    let wave = small.0.path().join("run.fst");
    let child = sim(&wave);
    wait_until(|| fs::read_dir(small.0.path()).unwrap().any(|entry| entry.unwrap().metadata().unwrap().len() > 0));
    let mut filler = fs::File::create(small.0.path().join("filler")).unwrap();
    while filler.write_all(&[1; 4096]).is_ok() {}
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("no space left on the disk"), "{}", stderr(&output));
    assert_eq!(names(small.0.path()), ["filler"]);
}

#[test]
fn broken_tools_and_an_unusable_cache_cost_the_report_only_what_they_make() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "a.png", 440, 400);
    let tools = folder.path().join("tools");
    fs::create_dir(&tools).unwrap();
    tool(&tools, "verilator", "case $1 in --version) echo 'Verilator 5.006 2023-01-22';; esac");
    tool(&tools, "g++", "exit 1");
    tool(&tools, "yosys", "case $1 in -V) echo 'Yosys 0.23 (git sha1 7ce5011c24b)';; *) exit 1;; esac");
    let no_cache = folder.path().join("file");
    fs::write(&no_cache, "").unwrap();
    let cache = folder.path().join("cache");
    let mut reasons = Vec::new();
    for cache in [&cache, &no_cache] {
        let out = folder.path().join("out");
        let output = command(&["report", picture.to_str().unwrap(), "--json", "--out", out.to_str().unwrap()])
            .env("PATH", format!("{}:/bin:/usr/bin", tools.display()))
            .env("XDG_CACHE_HOME", cache)
            .env("HOVERLOCK_CACHE", cache.join("hoverlock"))
            .output()
            .unwrap();
        let said = stderr(&output);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{said}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(report["bounds"].as_array().unwrap().len() > 10);
        let rtl = report["levels"].as_array().unwrap().iter().find(|level| level["name"] == "rtl").unwrap().clone();
        for part in ["simulation", "estimate"] {
            assert_eq!(rtl["hardware"][part]["status"], "not run", "{rtl}");
        }
        assert!(said.contains("rtl not run: ") && said.contains("rtl not sized: "), "{said}");
        assert!(out.join("index.html").is_file());
        fs::remove_dir_all(&out).unwrap();
        reasons.push(said);
    }
    assert!(reasons[0].contains("this installation is broken") && reasons[0].contains("yosys fails"), "{reasons:?}");
    assert!(!reasons[0].contains("not found:  is"), "{reasons:?}");
    assert_eq!(reasons[1].matches("os error").count(), 2, "a reason each: {}", reasons[1]);
}

#[test]
fn a_yosys_that_prints_anything_but_its_version_is_said_to_be_none() {
    let folder = tempfile::tempdir().unwrap();
    tool(folder.path(), "yosys", "printf 'line one\\nline two\\n\\033[31mred\\n'");
    let output = command(&["rtl", "estimate"]).env("PATH", folder.path()).output().unwrap();
    let said = stderr(&output);
    assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.contains("no working Yosys") && !said.contains("line one"), "{said}");
}

#[test]
fn the_width_of_a_configuration_is_what_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let picture = saved(folder.path(), "a.png", 520, 420);
    let out = folder.path().join("out");
    let args = ["report", picture.to_str().unwrap(), "--json", "--out", out.to_str().unwrap()];
    let sized = [&args[..], &["--config", "width=440", "--config", "height=401"]].concat();
    // Without tools in reach, so that the design is not emitted.
    let output = command(&sized).env("PATH", folder.path()).output().unwrap();
    let said = stderr(&output);
    assert!(said.contains("taking its centre 440x401 at (40, 9)"), "{said}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["pictures"][0]["frame"], serde_json::json!([440, 401]));
    assert_eq!(report["pictures"][0]["whole"], serde_json::json!([520, 420]));
    let said = refusal(&[&args[..], &["--config", "width=78"]].concat());
    assert!(said.contains("at least 79 x 79, not 78 x 768"), "{said}");
}

#[test]
fn a_level_computes_what_its_fast_path_computes() {
    let folder = tempfile::tempdir().unwrap();
    let reference = saved(folder.path(), "a.png", 300, 220);
    let current = folder.path().join("b.png");
    texture(300, 220).crop_imm(4, 3, 290, 210).save(&current).unwrap();
    let [reference, current] = [&reference, &current].map(|path| path.to_str().unwrap());
    let answer = |option: &str| -> Value {
        serde_json::from_slice(&hoverlock(&["match", reference, current, "--json", option]).stdout).unwrap()
    };
    // Integers: the same bits. Floating point: the same features, their places within rounding of f32.
    assert_eq!(answer("--features=fixed"), answer("--level=bit_true"));
    let (fast, clear) = (answer("--features=float"), answer("--level=recursive"));
    assert_eq!((&fast["features"], &fast["ok"]), (&clear["features"], &clear["ok"]));
    for axis in 0..2 {
        let of = |answer: &Value| answer["displacement_px"][axis].as_f64().unwrap();
        assert!((of(&fast) - of(&clear)).abs() < 1e-3, "{fast} {clear}");
    }
}

#[test]
fn errors_of_usage_say_what_was_meant() {
    let said = refusal(&["rtl"]);
    assert!(said.contains("a verb is missing") && said.contains("hoverlock rtl"), "{said}");
    assert!(refusal::<&str>(&[]).contains("a verb is missing"));
    let said = refusal(&["doctor", "--jsn"]);
    assert!(said.contains("'--json'"), "{said}");
    let said = refusal(&["mach", "a", "b"]);
    assert!(said.contains("'match'"), "{said}");
    let said = refusal(&["coeffs", "--sigma", "1e308"]);
    assert!(said.contains("1e308 px is outside 0.5 to 256 px") && said.len() < 200, "{said}");
    let said = refusal(&["sim", "a.png", "--sink-opens", "18446744073709551615"]);
    assert!(said.contains("--sink-opens") && said.contains("1000000000"), "{said}");
}

#[test]
fn the_reason_for_no_estimate_uses_plain_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let noise = |seed: u64| {
        Plane::from_fn(200, 160, |x, y| {
            let mut bits = (seed.wrapping_mul(0x2545_F491_4F6C_DD1D).wrapping_add(x as u64))
                .wrapping_mul(0x9E37_79B9_7F4A_7C15)
                ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
            bits = (bits ^ (bits >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            (bits >> 40) as u16
        })
    };
    let paths: Vec<String> = [1, 99]
        .into_iter()
        .map(|seed| {
            let path = folder.path().join(format!("{seed}.png"));
            let samples = noise(seed).as_slice().to_vec();
            ImageBuffer::<Luma<u16>, _>::from_raw(200, 160, samples).unwrap().save(&path).unwrap();
            path.to_str().unwrap().to_owned()
        })
        .collect();
    let output = hoverlock(&["match", &paths[0], &paths[1]]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stdout);
    // The number of inliers and matches, and how often chance gives as many.
    let (_, by_chance) = said.split_once(" matches agree, and as many agree by chance ").expect(&said);
    assert!(["thousands of times in every pair", "about ", "in one of "].iter().any(|how| by_chance.starts_with(how)));
    assert!(by_chance.contains("pair") && !said.contains("10^"), "{said}");
    // The reason alone states how many agree: none of them belongs to an estimate.
    assert!(!said.contains("of which"), "{said}");
}

#[test]
fn version_completions_and_manual_are_there() {
    let version = String::from_utf8(hoverlock(&["--version"]).stdout).unwrap();
    let commit = version.trim().strip_prefix(&format!("hoverlock {} (", env!("CARGO_PKG_VERSION"))).unwrap();
    assert!(commit.len() > 7 && commit.ends_with(')'), "{version}");
    for (shell, sign) in [("bash", "complete -F"), ("zsh", "#compdef hoverlock"), ("fish", "complete -c hoverlock")] {
        let output = hoverlock(&["completions", shell]);
        let script = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && script.contains(sign) && script.contains("max-megapixels"), "{shell}");
    }
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man1");
    assert!(hoverlock(&["man", pages.to_str().unwrap()]).status.success());
    let names = names(&pages);
    for name in ["hoverlock.1", "hoverlock-sim.1", "hoverlock-rtl-emit.1"] {
        assert!(names.iter().any(|there| there == name), "{names:?}");
    }
    let page = fs::read_to_string(pages.join("hoverlock-match.1")).unwrap();
    assert!(page.contains(".TH hoverlock-match 1") && page.contains("overlay"), "{page}");
}

#[test]
fn verdicts_are_coloured_where_a_terminal_shows_it() {
    let folder = tempfile::tempdir().unwrap();
    let flat = folder.path().join("a.png");
    // Too little texture for an estimate.
    let spot = |x: u32, y: u32| Luma([if x == 50 && y == 50 { 200u8 } else { 100 }]);
    DynamicImage::ImageLuma8(ImageBuffer::from_fn(100, 100, spot)).save(&flat).unwrap();
    let args: Vec<OsString> = ["match".into(), flat.clone().into(), flat.into()].into();
    let said = |variables: &[(&str, &str)]| {
        let output = command(&args).env_remove("NO_COLOR").envs(variables.iter().copied()).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(!said(&[]).contains('\u{1b}'), "no terminal");
    assert!(said(&[("CLICOLOR_FORCE", "1")]).contains("\u{1b}[31m"));
    assert!(!said(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]).contains('\u{1b}'));
}

#[test]
#[ignore = "48 megapixels, five formats"]
fn forty_eight_megapixels_are_decoded_within_four_hundred_megabytes() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (8000, 6000);
    let rgb = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(width, height, image::Rgb([90, 91, 92])));
    let deep = DynamicImage::ImageLuma16(ImageBuffer::from_pixel(width, height, Luma([30_000])));
    for (name, picture) in [
        ("rgb.png", &rgb),
        ("rgb.jpg", &rgb),
        ("rgb.ppm", &rgb),
        ("rgb.bmp", &rgb),
        ("rgb.tiff", &rgb),
        ("deep.png", &deep),
        ("deep.tiff", &deep),
    ] {
        let path = folder.path().join(name);
        picture.save(&path).unwrap();
        // A constant picture is refused once it is decoded; the limit is of the address space, which no peak exceeds.
        let output = Command::new("/bin/sh")
            .args(["-c", "ulimit -v 400000; exec \"$0\" match \"$1\" \"$1\""])
            .arg(env!("CARGO_BIN_EXE_hoverlock"))
            .arg(&path)
            .output()
            .unwrap();
        assert!(stderr(&output).contains("every pixel is"), "{name}: {}", stderr(&output));
        fs::remove_file(&path).unwrap();
    }
}

#[test]
#[ignore = "builds the command twice over, in a copy of the sources"]
fn an_installed_command_works_with_its_sources_gone() {
    let folder = tempfile::tempdir().unwrap();
    let sources = folder.path().join("sources");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let copied = Command::new("sh")
        .args(["-c", "git ls-files -z | xargs -0 cp --parents -t \"$0\""])
        .arg({
            fs::create_dir(&sources).unwrap();
            &sources
        })
        .current_dir(root)
        .status()
        .unwrap();
    assert!(copied.success());
    let installed = folder.path().join("installed");
    let install = Command::new(env!("CARGO"))
        .args(["install", "--quiet", "--debug", "--locked", "--path", "cli", "--root"])
        .arg(&installed)
        .current_dir(&sources)
        .env("CARGO_TARGET_DIR", folder.path().join("target"))
        .status()
        .unwrap();
    assert!(install.success());
    fs::remove_dir_all(&sources).unwrap();
    let run = |args: &[&str]| {
        Command::new(installed.join("bin/hoverlock")).args(args).current_dir(folder.path()).output().unwrap()
    };
    let picture = saved(folder.path(), "a.png", 120, 100);
    let picture = picture.to_str().unwrap();
    for args in [
        &["match", picture, picture][..],
        &["coeffs", "--sigma", "2", "--out", "coefficients"],
        &["rtl", "emit", "--out", "emitted"],
        &["rtl", "check", "--out", "emitted"],
        &["sim", picture],
        &["doctor", "--json"],
    ] {
        let output = run(args);
        assert!(output.status.success() || args[0] == "doctor", "{args:?}: {}", stderr(&output));
    }
}
