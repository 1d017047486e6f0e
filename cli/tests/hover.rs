//! `hoverlock hover` and `hoverlock sweep`: the closed loop from the command line.

#[path = "common/picture.rs"]
mod picture;
#[path = "common/refusal.rs"]
mod refusal;

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

use hoverlock_reference::image::plane::Plane;
use serde_json::Value;

use picture::save;
use refusal::assert_refused;

fn hoverlock(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(args).output().unwrap()
}

fn hover(out: &Path, args: &[&str]) -> Value {
    let output = hoverlock(&[&["hover", "--json", "--out", out.to_str().unwrap()], args].concat());
    assert!(output.status.code() != Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A table without the columns that are text.
fn column(table: &str, name: &str) -> Vec<Option<f64>> {
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let at = rows.headers().unwrap().iter().position(|header| header == name).unwrap();
    rows.records().map(|row| row.unwrap()[at].parse().ok()).collect()
}

/// A flight of which no frame arrives leaves no results of the one before.
#[test]
fn a_flight_without_a_frame_replaces_the_one_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let scenario = path("lost.toml");
    fs::write(&scenario, "scene = 'field'\nseconds = 1\n[[event]]\nt = 0\nevent = 'dropped'\nseconds = 5\n").unwrap();
    let fly =
        |args: &[&str]| hover(Path::new(&path("out")), &[&["--seconds", "1", "--save", &path("saved")], args].concat());
    let files = |folder: &str| fs::read_dir(path(folder)).unwrap().count();
    assert_eq!((&fly(&[])["lost"], files("out"), files("saved")), (&0.into(), 3, 20));
    assert_eq!(fly(&["--scenario", &scenario])["frames"], 0);
    assert_eq!((files("out"), files("saved")), (2, 4));
}

/// Results that are links stay links, and their targets are replaced.
#[test]
fn a_flight_replaces_the_targets_of_links() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("lost.toml"), "scene = 'field'\nseconds = 1\n[[event]]\nt = 0\nevent = 'dropped'\nseconds = 5\n")
        .unwrap();
    for (out, results) in
        [("out", &["hover.csv", "index.html"][..]), ("saved", &["telemetry.csv", "calibration.toml"][..])]
    {
        fs::create_dir(path(out)).unwrap();
        fs::create_dir(path(&format!("{out} elsewhere"))).unwrap();
        for name in results {
            fs::write(path(&format!("{out} elsewhere/{name}")), "of the flight before").unwrap();
            std::os::unix::fs::symlink(path(&format!("{out} elsewhere/{name}")), path(&format!("{out}/{name}")))
                .unwrap();
        }
    }
    fs::write(path("out/.hoverlock"), "hoverlock hover\n").unwrap();
    fs::write(path("saved/.hoverlock"), "hoverlock hover --save\n").unwrap();
    let [scenario, save] = ["lost.toml", "saved"].map(|name| path(name).display().to_string());
    hover(&path("out"), &["--scenario", &scenario, "--save", &save]);
    for name in ["out/hover.csv", "out/index.html", "saved/telemetry.csv", "saved/calibration.toml"] {
        assert!(path(name).is_symlink(), "{name} is no link any more");
    }
    let text = |name: &str| fs::read_to_string(path(name)).unwrap();
    assert_eq!(text("out elsewhere/hover.csv"), "");
    assert!(text("out elsewhere/index.html").contains("</html>"));
    assert!(text("saved elsewhere/telemetry.csv").starts_with("time_s,"));
    assert!(text("saved elsewhere/calibration.toml").contains("readout_s"));
    // A link to nothing is refused before a result of the flight before is removed.
    fs::remove_file(path("out elsewhere/index.html")).unwrap();
    let output = hoverlock(&["hover", "--out", &path("out").display().to_string(), "--scenario", &scenario]);
    assert_refused(&output, "index.html: is a link to nothing; name another file");
}

/// Nothing is made before what cannot work is refused, and nothing of another verb is overwritten.
#[test]
fn folder_and_design_are_checked_before_the_scene_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").display().to_string();
    fs::write(folder.path().join("file"), "").unwrap();
    let file = folder.path().join("file/save").display().to_string();
    let cases: [(&[&str], &str); 3] = [
        (&["--out", &out, "--design", "small"], "frames of 1024 x 768 px: the design takes"),
        (&["--out", &out, "--save", &file], "file/save"),
        (&["--out", &out, "--gusts", "3", "--scene", "moon"], "moon"),
    ];
    for (args, named) in cases {
        let output = hoverlock(&[&["hover"], args].concat());
        assert_refused(&output, named);
        assert!(!String::from_utf8_lossy(&output.stderr).contains("making the scene"));
        assert!(!Path::new(&out).exists(), "{named}: something was left");
    }
    fs::create_dir(&out).unwrap();
    for marker in [None, Some("hoverlock report\n")] {
        marker.iter().for_each(|text| fs::write(Path::new(&out).join(".hoverlock"), text).unwrap());
        fs::write(Path::new(&out).join("index.html"), "mine").unwrap();
        let output = hoverlock(&["hover", "--seconds", "1", "--out", &out]);
        assert_refused(&output, "index.html: is not a file of hoverlock hover; name another folder");
        assert_eq!(fs::read_to_string(Path::new(&out).join("index.html")).unwrap(), "mine");
    }
}

/// Pictures of others are not touched, whatever number they begin with.
#[test]
fn a_flight_is_not_saved_among_the_pictures_of_others() {
    let folder = tempfile::tempdir().unwrap();
    let frame = folder.path().join("00007.png");
    fs::write(&frame, "mine").unwrap();
    let [out, save] = [folder.path().join("out"), folder.path().into()].map(|path| path.display().to_string());
    let output = hoverlock(&["hover", "--seconds", "1", "--out", &out, "--save", &save]);
    assert_refused(&output, "00007.png: is not a file of hoverlock hover --save");
    assert_eq!(fs::read_to_string(&frame).unwrap(), "mine");
}

/// Samples of the IMU go on while frames are lost, and a shorter flight leaves nothing of the longer one before it.
#[test]
fn what_is_saved_is_one_flight() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [out, save, scenario] = ["out", "saved", "flight.toml"].map(path);
    let flown = |seconds: f64, event: &str| {
        fs::write(&scenario, format!("scene = \"helipad-in-mist\"\nseconds = {seconds}\n{event}")).unwrap();
        hover(&out, &["--scenario", scenario.to_str().unwrap(), "--save", save.to_str().unwrap()]);
        let table = fs::read_to_string(path("saved/inertial.csv")).unwrap();
        column(&table, "time_s").into_iter().flatten().collect::<Vec<f64>>()
    };
    let samples = flown(1.5, "[[event]]\nt = 0.5\nevent = \"dropped\"\nseconds = 0.4\n");
    assert!(samples.windows(2).all(|pair| pair[1] - pair[0] < 0.011), "{samples:?}");
    flown(1.0, "");
    let names = fs::read_dir(&save).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(names.filter(|name| name.ends_with(".png")).count(), 16);
}

/// A flight that is killed leaves the rows flown so far, and what was saved can be replayed.
#[test]
fn the_table_grows_as_it_flies() {
    let folder = tempfile::tempdir().unwrap();
    let saved = folder.path().join("saved");
    let args = ["hover", "--scene", "helipad-in-mist", "--seconds", "600", "--out", folder.path().to_str().unwrap()];
    let args = [&args[..], &["--save", saved.to_str().unwrap()]].concat();
    let mut flight = Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(args).spawn().unwrap();
    let table = folder.path().join("hover.csv");
    let rows = || fs::read_to_string(&table).map_or(0, |text| text.lines().count());
    let started = std::time::Instant::now();
    while rows() < 4 && started.elapsed().as_secs() < 300 {
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    flight.kill().unwrap();
    flight.wait().unwrap();
    assert!(rows() >= 4 && !folder.path().join("index.html").exists(), "{} rows", rows());
    let times = column(&fs::read_to_string(&table).unwrap(), "time");
    assert!(times[..3].windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
    let lines = |name: &str| fs::read_to_string(saved.join(name)).unwrap().lines().count();
    let pictures = fs::read_dir(&saved).unwrap().filter_map(|entry| entry.unwrap().file_name().into_string().ok());
    let pictures = pictures.filter(|name| !name.starts_with('.') && name.ends_with(".png")).count();
    // The picture of the frame at which it was killed may have no row yet.
    assert!((pictures..=pictures + 1).contains(&lines("telemetry.csv")), "{pictures} pictures");
    assert!(lines("inertial.csv") > pictures && saved.join("calibration.toml").exists());
}

/// Level asphalt with its helipad: the place is held to centimetres; the same seed gives the same bytes, another seed
/// other ones; and what was saved is replayed to the same estimates.
#[test]
fn a_hover_holds_its_place_repeats_itself_and_is_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let [first, again, other, frames] = ["1", "2", "3", "frames"].map(|name| folder.path().join(name));
    let scene = ["--scene", "helipad-in-mist", "--seconds", "2"];
    let saved = hover(&first, &[&scene[..], &["--save", frames.to_str().unwrap()]].concat());
    assert_eq!((&saved["pass"], &saved["frames"]), (&true.into(), &31.into()), "{saved}");
    let page = fs::read_to_string(first.join("index.html")).unwrap();
    assert!(page.contains("helipad-in-mist") && page.contains("data:image/png;base64,"));

    hover(&again, &scene);
    hover(&other, &[&scene[..], &["--seed", "2"]].concat());
    let table = |folder: &Path| fs::read_to_string(folder.join("hover.csv")).unwrap();
    assert_eq!(table(&first), table(&again));
    assert_ne!(table(&first), table(&other));

    // A replay has the samples of the IMU of the last 10 ms, which in flight come too late for their frame.
    let output = hoverlock(&["cosim", "--json", frames.to_str().unwrap()]);
    let replayed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let estimates = replayed["estimates"].as_array().unwrap();
    let flown = column(&table(&first), "estimate_x");
    assert_eq!(estimates.len(), flown.len());
    for (line, flown) in estimates.iter().zip(flown) {
        match (line["x_e_m"].as_f64(), flown) {
            (Some(replayed), Some(flown)) => assert!((replayed - flown).abs() < 1e-2, "{replayed} {flown}"),
            (replayed, flown) => assert_eq!(replayed, flown),
        }
    }
}

/// The reference of the narrow view is another than that of the wide one, and the estimate does not jump: at no frame
/// by more than five of its standard errors and what a helicopter flies in a fifteenth of a second.
#[test]
fn the_view_narrows_without_a_jump() {
    let folder = tempfile::tempdir().unwrap();
    let summary = hover(folder.path(), &["--scene", "helipad-in-mist", "--seconds", "4", "--view", "narrow"]);
    assert!(summary["references"].as_u64().unwrap() > 1, "{summary}");
    let table = fs::read_to_string(folder.path().join("hover.csv")).unwrap();
    let view = column(&table, "field_of_view");
    assert!(view[60].unwrap() < 0.8 * view[0].unwrap());
    let [x, sigma] = ["estimate_x", "sigma_x"].map(|name| column(&table, name));
    for (pair, sigma) in x.windows(2).zip(&sigma[1..]) {
        if let ([Some(before), Some(after)], Some(sigma)) = (pair, sigma) {
            assert!((after - before).abs() < 0.05 + 5.0 * sigma, "{before} {after} {sigma}");
        }
    }
}

/// A frame that does not arrive has no row in the table, and the page shows pictures of those that do.
#[test]
fn a_hover_with_frames_that_do_not_arrive_has_its_page() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = folder.path().join("dropped.toml");
    let event = "[[event]]\nt = 0.3\nevent = 'dropped'\nseconds = 0.5\n";
    fs::write(&scenario, format!("scene = 'field'\nseconds = 1.2\n{event}")).unwrap();
    let out = folder.path().join("out");
    let summary = hover(&out, &["--scenario", scenario.to_str().unwrap()]);
    let rows = column(&fs::read_to_string(out.join("hover.csv")).unwrap(), "time").len();
    assert_eq!(summary["frames"], rows, "{summary}");
    assert!(rows < 13, "{summary}");
    let page = fs::read_to_string(out.join("index.html")).unwrap();
    for still in ["0.2 s: ", "0.8 s: ", "1.2 s: "] {
        assert!(page.contains(still), "{still}");
    }
}

/// Waves have features, but none that stays: no estimate is believed, and the helicopter stays level.
#[test]
fn over_open_water_it_says_that_it_cannot() {
    let folder = tempfile::tempdir().unwrap();
    let summary = hover(folder.path(), &["--scene", "open-water", "--seconds", "2"]);
    assert_eq!((&summary["pass"], &summary["estimates"]), (&true.into(), &0.into()), "{summary}");
    assert!(summary["bound_m"].is_null());
}

#[test]
fn bad_input_is_one_line_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    fs::write(&file, "[ground.field]\nparcel_m = 40.0\nparcels = 3\n").unwrap();
    let out = folder.path().join("out");
    let refused = |args: &[&str], named: &str| {
        assert_refused(&hoverlock(&[&["hover", "--out", out.to_str().unwrap()], args].concat()), named);
        assert!(!out.exists(), "{named}: something was left");
    };
    refused(&["--scene", "moon"], "field, town, helipad-in-mist, open-water, aerial");
    refused(&["--scene", file.to_str().unwrap()], "3");
    refused(&["--scene", file.to_str().unwrap()], "parcels");
    refused(&["--scene", folder.path().to_str().unwrap()], "not a regular file");
    let ground = |name: &str, picture: &Plane<u16>| {
        let file = save(folder.path(), &format!("{name}.png"), picture);
        let scene = folder.path().join(format!("{name}.toml"));
        fs::write(&scene, format!("[ground.picture]\nfile = \"{file}\"\ntexel_m = 0.05\n")).unwrap();
        scene.to_str().unwrap().to_owned()
    };
    for (name, side) in [("constant", 300), ("point", 1)] {
        refused(&["--scene", &ground(name, &Plane::filled(side, side, 7000))], "every pixel has the same value");
    }
    // Nothing to be found on it: no estimate is no pass, however short the hover.
    let mut bare = Plane::filled(300, 300, 7000);
    bare[(0, 0)] = 7001;
    let summary = hover(&out, &["--seconds", "1", "--scene", &ground("bare", &bare)]);
    assert_eq!((&summary["pass"], &summary["estimates"]), (&false.into(), &0.into()), "{summary}");
    assert!(summary["reason"].as_str().unwrap().starts_with("no frame has an estimate"), "{summary}");
    fs::remove_dir_all(&out).unwrap();
    let house = folder.path().join("house.toml");
    let building = "[[building]]\nat_m = [0, 0]\nsize_m = [9, 9]\nheight_m = 60\n";
    fs::write(&house, format!("[ground.grass]\n{building}")).unwrap();
    let output = hoverlock(&["hover", "--scene", house.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let line = String::from_utf8_lossy(&output.stderr).into_owned();
    let named = "begins 50 m over the mean ground, and the surface there is 60.0 m high";
    assert!(output.status.code() == Some(2) && line.contains(named) && !out.exists(), "{line}");
    refused(&["--seconds", "-1"], "must be 1 to 3600");
    refused(&["--gusts", "6"], "must be 0 to 5");
    refused(&["--seconds", "0"], "must be 1 to 3600");
    refused(&["--config", "dog_bits=99"], "dog_bits");
    let arm = ["--features", "rtl", "--estimator", "arm", "--design", "three_scales"];
    refused(&arm, "built for the Verilog of kt27");
    let sweep = |args: &[&str], named: &str| {
        assert_refused(&hoverlock(&[&["sweep", "--out", out.to_str().unwrap()], args].concat()), named);
        assert!(!out.exists(), "{named}: something was left");
    };
    sweep(&["--scene", "moon"], "moon");
    sweep(&["--design", "small"], "640 x 480");
    sweep(&["--config", "dog_bits=99"], "dog_bits");
    sweep(&["--config", "dog_bits=12", "--features", "float"], "no word lengths");
    sweep(&["--random", "0"], "--random");
    sweep(&["--random", "2", "--scene", "field"], "--scene");
    sweep(&["--shrink", "2"], "--random");
    sweep(&["--random", "2", "--shrink", "3"], "--random gives 2 flights");
    sweep(&["--random", "2", "--shrink", "2", "--table", "flights.csv"], "--table");
}

/// Points that are in the table are not flown again, a row that was cut off is.
#[test]
fn a_campaign_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let args = ["sweep", "--json", "--scene", "helipad-in-mist", "--seeds", "2", "--seconds", "1", "--out", out];
    let whole = hoverlock(&args);
    let summary: Value = serde_json::from_slice(&whole.stdout).unwrap();
    assert_eq!((summary["points"].as_array().unwrap().len(), &summary["pareto"]), (2, &serde_json::json!(["kt27"])));
    let table = folder.path().join("results.csv");
    let rows = fs::read_to_string(&table).unwrap();
    assert_eq!(rows.lines().count(), 3);

    // The last row ends within a number.
    fs::write(&table, &rows[..rows.len() - 30]).unwrap();
    let again = hoverlock(&args);
    let summary_again: Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(summary, summary_again);
    let said = String::from_utf8_lossy(&again.stderr);
    assert!(said.contains("1 of 2 points are in") && !said.contains("another commit"), "{said}");

    // Rows of another program count, and it is said.
    let commit = summary["points"][0]["commit"].as_str().unwrap();
    fs::write(&table, rows.replace(commit, OTHER_COMMIT)).unwrap();
    assert_of_other_commit(&hoverlock(&args), folder.path(), "--out");
}

/// The commit of rows that another program has flown.
const OTHER_COMMIT: &str = "0123456789ab";

/// Asserts that a sweep says of its two rows that another program has flown them, as its page does.
#[track_caller]
fn assert_of_other_commit(output: &Output, folder: &Path, option: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    let named = "2 of 2 rows were flown by another commit than that of this program, ";
    assert!(said.contains(named) && said.contains(&format!("; another {option} flies them again")), "{said}");
    let page = fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(page.contains(&format!("<dt>flown by</dt><dd><code>{OTHER_COMMIT}</code></dd>")), "{page}");
}

/// Two sweeps into one table would lose the rows of one of them.
#[test]
fn a_second_sweep_into_the_same_table_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    fs::write(folder.path().join(".hoverlock"), "hoverlock sweep\nhoverlock sweep --random\n").unwrap();
    let [results, flights] = ["results.csv", "flights.csv"].map(|name| folder.path().join(name));
    let random = ["--random", "1", "--table", flights.to_str().unwrap()];
    for (table, further) in [(&results, &[][..]), (&flights, &random[..])] {
        let args = [&["sweep", "--seconds", "1", "--out", out], further].concat();
        let first = fs::File::create(table).unwrap();
        first.lock().unwrap();
        let name = table.file_name().unwrap().to_str().unwrap();
        assert_refused(&hoverlock(&args), &format!("{name}: another run is writing it; wait for its end"));
        drop(first);
        fs::remove_file(table).unwrap();
        std::os::unix::fs::symlink("nothing.csv", table).unwrap();
        assert_refused(&hoverlock(&args), &format!("{name}: is a link to nothing"));
        assert!(table.is_symlink() && !folder.path().join("nothing.csv").exists());
    }
}

/// A Python module that ends before it has read all points is named with its last line.
#[test]
fn a_python_module_that_fails_is_named_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let python = folder.path().join("python");
    fs::write(&python, "#!/bin/sh\necho 'No module named hoverlock_models' >&2\nexit 3\n").unwrap();
    fs::set_permissions(&python, fs::Permissions::from_mode(0o755)).unwrap();
    let out = folder.path().join("out");
    // More rows than a pipe takes.
    let points = ["--scene", "helipad-in-mist", "--seeds", "10000", "--seconds", "1", "--dask", "tcp://nowhere:1"];
    let output = Command::new(env!("CARGO_BIN_EXE_hoverlock"))
        .args([&["sweep", "--out", out.to_str().unwrap()], &points[..]].concat())
        .env("HOVERLOCK_PYTHON", &python)
        .output()
        .unwrap();
    assert_refused(&output, "has failed (exit status: 3): No module named hoverlock_models");
}

/// A random flight is a scenario file, and `hover` repeats its numbers; flights in the table are not flown again.
#[test]
fn random_flights_repeat_from_their_scenario_files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let args = ["sweep", "--random", "2", "--seed", "3", "--seconds", "1", "--json", "--out", out];
    let whole = hoverlock(&args);
    assert!(whole.status.code() != Some(2), "{}", String::from_utf8_lossy(&whole.stderr));
    let outcome: Value = serde_json::from_slice(&whole.stdout).unwrap();
    let flights = outcome["flights"].as_array().unwrap();
    assert_eq!((flights.len(), &outcome["totals"]["flights"]), (2, &2.into()));
    let page = fs::read_to_string(folder.path().join("index.html")).unwrap();
    assert!(page.contains("Random flights") && page.contains(flights[0]["ingredients"].as_str().unwrap()));

    let scenario = folder.path().join("3-0002.toml");
    let repeated = hover(&folder.path().join("again"), &["--scenario", scenario.to_str().unwrap()]);
    for key in ["rms_m", "max_m", "error_rms_m", "frames", "misleading"] {
        assert_eq!(repeated[key], flights[1][key], "{key}");
    }

    let again = hoverlock(&args);
    assert_eq!(again.stdout, whole.stdout);
    assert!(String::from_utf8_lossy(&again.stderr).contains("2 of 2 flights are in"));

    let rows = fs::read_to_string(folder.path().join("flights.csv")).unwrap();
    let table = folder.path().join("others.csv");
    fs::write(&table, rows.replace(flights[0]["commit"].as_str().unwrap(), OTHER_COMMIT)).unwrap();
    let others = hoverlock(&[&args[..], &["--table", table.to_str().unwrap()]].concat());
    assert_of_other_commit(&others, folder.path(), "--table");
}

/// A table that cannot be written is refused before a flight is drawn, and without a scenario file.
#[test]
fn a_table_of_random_flights_is_checked_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(path("other.csv"), "a,b\n1,2\n").unwrap();
    for (table, named) in [("missing/flights.csv", "name another file"), ("other.csv", "other.csv")] {
        let out = path("out");
        let output = hoverlock(&["sweep", "--random", "2", "--seconds", "1", "--table", &path(table), "--out", &out]);
        assert_refused(&output, named);
        assert!(!Path::new(&out).exists(), "{named}: something was left");
    }
    fs::create_dir(path("mine")).unwrap();
    fs::write(path("mine/1-0001.toml"), "mine").unwrap();
    let output = hoverlock(&["sweep", "--random", "2", "--seed", "1", "--seconds", "1", "--out", &path("mine")]);
    assert_refused(&output, "1-0001.toml: is not a file of hoverlock sweep --random");
    fs::write(path("mine/shrunk-1-0002.toml"), "mine").unwrap();
    let output = hoverlock(&["sweep", "--random", "2", "--seed", "1", "--shrink", "2", "--out", &path("mine")]);
    assert_refused(&output, "shrunk-1-0002.toml: is not a file of hoverlock sweep --shrink");
}

/// The hardware's features and the ARM binary's estimates steer the same flight as the models in this process.
#[test]
#[ignore = "30 frames through the simulated hardware and the ARM binary"]
fn hardware_and_arm_binary_steer_the_same_flight() {
    if Command::new("qemu-arm").arg("--version").output().is_err() {
        eprintln!("SKIPPED: no qemu-arm; `make arm` installs it");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [models, hardware] = ["models", "hardware"].map(|name| folder.path().join(name));
    let scene = ["--scene", "helipad-in-mist", "--seconds", "1"];
    hover(&models, &scene);
    let summary = hover(&hardware, &[&scene[..], &["--features", "rtl", "--estimator", "arm"]].concat());
    assert!(summary["cycles"].as_u64().unwrap() > 16 * 1024 * 768, "{summary}");
    let table = |folder: &Path| fs::read_to_string(folder.join("hover.csv")).unwrap();
    assert_eq!(table(&models), table(&hardware));
}
