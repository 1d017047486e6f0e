//! Metres: `hoverlock match --telemetry` and `hoverlock cosim` on ground that is rendered from known positions, and on
//! real sequences.

mod common;

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hoverlock_pictures::data_dir;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera, View};
use nalgebra::Vector2;
use serde_json::Value;

use common::{assert_refused, ground, save};

const WIDTH: usize = 320;
const HEIGHT: usize = 240;
const FIELD_OF_VIEW: f64 = 50.0;

/// Metres of a sample of the ground: that of a pixel at 50 m.
const SAMPLE: f64 = 0.145;

/// The header of a table of the inertial sensor.
const INERTIAL_COLUMNS: &str =
    "time_s,rate_x_rad_per_s,rate_y_rad_per_s,rate_z_rad_per_s,force_x_m_per_s2,force_y_m_per_s2,force_z_m_per_s2";

/// Where a camera is and how it looks: X_e, Y_e and height, m; roll, pitch and yaw, degrees.
type Place = ([f64; 3], [f64; 3]);

/// A flight with known positions: it climbs, tilts and turns.
const FLIGHT: [Place; 4] = [
    ([0.0, 0.0, 50.0], [0.0, 0.0, 0.0]),
    ([0.8, -0.5, 50.4], [1.5, -1.0, 2.0]),
    ([1.9, -1.4, 51.0], [-2.0, 1.8, 4.0]),
    ([2.4, -2.6, 49.2], [0.7, 2.5, -3.0]),
];

fn view((position, attitude): &Place) -> View {
    let [roll, pitch, yaw] = attitude.map(f64::to_radians);
    let attitude = Attitude { roll, pitch, yaw };
    let camera = Camera::with_field_of_view(WIDTH, HEIGHT, FIELD_OF_VIEW.to_radians()).unwrap();
    // The laser looks along the optical axis.
    View::new(camera, attitude, position[2] / attitude.rotation()[(2, 2)]).unwrap()
}

/// What the camera sees.
fn seen(place: &Place) -> Plane<u16> {
    seen_through(place, |pixel| pixel)
}

/// What the camera sees through a lens that shows at a pixel what belongs at `straight` of it.
fn seen_through(place: &Place, straight: impl Fn(Vector2<f64>) -> Vector2<f64> + Sync) -> Plane<u16> {
    let (to_ground, [x_e, y_e, _]) = (view(place).to_ground(), place.0);
    Plane::from_fn(WIDTH, HEIGHT, |x, y| {
        let p = to_ground * straight(Vector2::new(x as f64, y as f64)).push(1.0);
        ground((p.x / p.z + x_e) / SAMPLE, (p.y / p.z + y_e) / SAMPLE)
    })
}

/// What the sensors read there, without an error.
fn telemetry(places: &[Place]) -> String {
    // A second apart, so that the second confirms the reference.
    let mut text = "# made\ntime_s,roll_deg,pitch_deg,yaw_deg,range_m,fov_deg,tilt_se_deg\n".to_owned();
    for (number, place) in places.iter().enumerate() {
        let [roll, pitch, yaw] = place.1;
        let range = place.0[2] / view(place).attitude().rotation()[(2, 2)];
        let time = number as f64;
        writeln!(text, "{time}, {roll}, {pitch}, {yaw}, {range}, {FIELD_OF_VIEW}, 0.2").unwrap();
    }
    text
}

/// A folder of the flight.
fn flight() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (i, place) in FLIGHT.iter().enumerate() {
        save(folder.path(), &format!("{i:02}.png"), &seen(place));
    }
    fs::write(folder.path().join("telemetry.csv"), telemetry(&FLIGHT)).unwrap();
    folder
}

fn hoverlock(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock")).args(arguments).output().unwrap()
}

/// Runs with `--json`: the object and the object as text.
#[track_caller]
fn json(arguments: &[&str]) -> (Value, String) {
    let output = hoverlock(&[arguments, &["--json"]].concat());
    let (text, said) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8_lossy(&output.stderr));
    assert_ne!(output.status.code(), Some(2), "{arguments:?}: {said}");
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["ok"], output.status.code() == Some(0), "{text}");
    (report, text)
}

/// The lines of the flight program as they stand in the object, byte for byte.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(|line| line.trim().trim_end_matches(',')).filter(|line| line.starts_with("{\"frame\"")).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// Within three standard errors along each axis, and within `most` metres; 11 cm are 0.8 px at 50 m.
#[track_caller]
fn close(found: [f64; 2], covariance: &[f64], place: &Place, most: f64) {
    for axis in 0..2 {
        let (error, sigma) = (found[axis] - place.0[axis], covariance[3 * axis].sqrt());
        assert!(error.abs() < 3.0 * sigma && error.abs() < most, "axis {axis}: {error} m, sigma {sigma} m");
    }
}

#[test]
fn match_gives_metres_if_telemetry_is_given() {
    let folder = flight();
    let picture = |i: usize| folder.path().join(format!("{i:02}.png")).display().to_string();
    let table = folder.path().join("two.csv");
    for (frame, place) in FLIGHT.iter().enumerate().skip(1) {
        fs::write(&table, telemetry(&[FLIGHT[0], *place])).unwrap();
        let (reference, current) = (picture(0), picture(frame));
        let (report, _) = json(&["match", &reference, &current, "--telemetry", table.to_str().unwrap()]);
        let found = numbers(&report["displacement_m"]);
        let covariance = numbers(&report["covariance_m2"]);
        close([found[0], found[1]], &covariance, place, 0.11);
        assert!((covariance[1] - covariance[2]).abs() < 1e-9, "{covariance:?}");
        let (report, _) = json(&["match", &reference, &current]);
        assert_eq!((&report["displacement_m"], &report["covariance_m2"]), (&Value::Null, &Value::Null));
    }
    // Telemetry that the pictures contradict: the motion stays, the metres go, and the status says so.
    let mut turned = FLIGHT[1];
    turned.1[2] += 30.0;
    fs::write(&table, telemetry(&[FLIGHT[0], turned])).unwrap();
    let (report, _) = json(&["match", &picture(0), &picture(1), "--telemetry", table.to_str().unwrap()]);
    assert_eq!((&report["ok"], &report["displacement_m"]), (&false.into(), &Value::Null), "{report}");
    assert!(report["homography"].is_array() && report["reason"].as_str().unwrap().contains("disagree"), "{report}");
}

/// 3 % at the corner of the picture. Nobody has calibrated it, or somebody has.
#[test]
fn the_metres_of_a_distorted_lens_are_as_uncertain_as_its_calibration() {
    const BARREL: f64 = -0.088;
    let camera = *view(&FLIGHT[0]).camera();
    let straight = |pixel: Vector2<f64>| {
        let seen = (pixel - camera.principal()) / camera.focal();
        // The fixed point of `u = seen / (1 + k1 |u|^2)`.
        let u = (0..20).fold(seen, |u, _| seen / (1.0 + BARREL * u.norm_squared()));
        camera.principal() + u * camera.focal()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    for (number, place) in FLIGHT.iter().enumerate() {
        save(folder.path(), &format!("{number}.png"), &seen_through(place, straight));
    }
    fs::write(path("lens.toml"), format!("k1 = {{ value = {BARREL}, sigma = 0.001 }}\n")).unwrap();
    for (number, place) in FLIGHT.iter().enumerate().skip(1) {
        fs::write(path("two.csv"), telemetry(&[FLIGHT[0], *place])).unwrap();
        let (reference, current, table, lens) =
            (path("0.png"), path(&format!("{number}.png")), path("two.csv"), path("lens.toml"));
        let measured = |calibration: &[&str]| {
            let pictures = ["match", &reference, &current, "--telemetry", &table];
            let (report, _) = json(&[&pictures, calibration].concat());
            let [found, covariance] = ["displacement_m", "covariance_m2"].map(|key| numbers(&report[key]));
            let level = report["protection_level_m"].as_f64().unwrap();
            let error = (found[0] - place.0[0]).hypot(found[1] - place.0[1]);
            let sigma = (covariance[0] + covariance[3]).sqrt();
            assert!(error < 2.0 * sigma && error < level, "{number}: {error} m, sigma {sigma} m, level {level} m");
            error
        };
        let [unknown, known] = [measured(&[]), measured(&["--calibration", &lens])];
        assert!(known < 0.06 && known < unknown, "{number}: {unknown} m, and {known} m with its calibration");
    }
    // With such a lens the corners would be seen twice, within the picture.
    fs::write(path("folded.toml"), "k1 = { value = -1.0, sigma = 0.001 }\n").unwrap();
    fs::write(path("wide.csv"), telemetry(&[FLIGHT[0]; 2]).replace(", 50, ", ", 120, ")).unwrap();
    let pictures = ["match", &path("0.png"), &path("0.png"), "--telemetry", &path("wide.csv")];
    let (report, _) = json(&[&pictures[..], &["--calibration", &path("folded.toml")]].concat());
    assert!(report["reason"].as_str().unwrap().contains("no pose can be fitted"), "{report}");
    let without_telemetry = hoverlock(&["match", &path("0.png"), &path("1.png"), "--calibration", &path("lens.toml")]);
    assert_eq!(without_telemetry.status.code(), Some(2));
}

#[test]
fn a_flight_is_followed_and_the_hardware_gives_the_lines_of_the_model() {
    let folder = flight();
    let sequence = folder.path().to_str().unwrap();
    let out = folder.path().join("page");
    let (fixed, text) = json(&["cosim", sequence, "--out", out.to_str().unwrap()]);
    let estimates = fixed["estimates"].as_array().unwrap();
    assert_eq!((estimates.len(), lines(&text).len()), (4, 4), "{text}");
    assert_eq!((&estimates[0]["status"], &fixed["telemetry"]), (&"reference".into(), &"telemetry.csv".into()));
    for (estimate, place) in estimates.iter().zip(&FLIGHT).skip(1) {
        // With a thousand matches the search may end at its limit of work, which the status reports.
        assert!(estimate["status"] == "estimate" || estimate["status"] == "late", "{text}");
        let found = [estimate["x_e_m"].as_f64().unwrap(), estimate["y_e_m"].as_f64().unwrap()];
        // The budget of the flight program has room for a part of the thousand matches (decision 047).
        close(found, &numbers(&estimate["covariance_m2"]), place, 0.13);
    }
    let page = fs::read_to_string(out.join("index.html")).unwrap();
    assert!(
        page.contains("03.png") && page.contains("4 frames") && page.contains("3 of the 3 that floating point solves")
    );
    assert_eq!(fixed["float"], serde_json::json!({ "solved": 3, "estimated": 3 }), "{text}");

    let (rtl, hardware) = json(&["cosim", sequence, "--features", "rtl"]);
    assert_eq!(lines(&text), lines(&hardware));
    // Four frames of one pixel a clock, at least.
    assert!(rtl["cycles"].as_u64() > Some((4 * WIDTH * HEIGHT) as u64) && fixed["cycles"].is_null());

    let (float, _) = json(&["cosim", sequence, "--features", "float"]);
    assert!(float["float"].is_null());
    for (float, fixed) in float["estimates"].as_array().unwrap().iter().zip(estimates).skip(1) {
        for axis in ["x_e_m", "y_e_m"] {
            let difference = float[axis].as_f64().unwrap() - fixed[axis].as_f64().unwrap();
            // Less than a standard error, 0.12 m at the last frame: of 900 matches each fit takes every second one, and
            // not the same ones.
            assert!(difference.abs() < 0.08, "{axis}: {difference} m");
        }
    }
}

/// Without samples of an IMU each frame is searched, which the work of a frame must pay for.
#[test]
fn frames_without_an_imu_are_found_at_the_frame_rate() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    for (frame, place, attitude) in [("0.png", "0,0,100", "0,0,0"), ("1.png", "2,1.5,100", "1,-1,2")] {
        let rendered = hoverlock(&["scene", "town", "--at", place, "--look", attitude, "--out", &path(frame)]);
        assert!(rendered.status.success(), "{}", String::from_utf8_lossy(&rendered.stderr));
    }
    for frame in ["2.png", "3.png"] {
        fs::copy(path("1.png"), path(frame)).unwrap();
    }
    let readings = "time_s,roll_deg,pitch_deg,yaw_deg,range_m,fov_deg\n0,0,0,0,100,50\n";
    let later = ["2.0", "2.067", "2.133"].map(|time_s| format!("{time_s},1,-1,2,100.03,50\n"));
    fs::write(path("telemetry.csv"), [readings, &later.concat()].concat()).unwrap();
    let (report, text) = json(&["cosim", &folder.path().display().to_string()]);
    for estimate in &report["estimates"].as_array().unwrap()[1..] {
        let found = ["x_e_m", "y_e_m"].map(|axis| estimate[axis].as_f64().unwrap_or_else(|| panic!("{text}")));
        assert!((found[0] - 2.0).hypot(found[1] - 1.5) <= estimate["protection_level_m"].as_f64().unwrap(), "{text}");
    }
}

#[test]
fn homographies_beside_the_frames_give_the_error() {
    let folder = flight();
    let mut table = "ref,frame,ok,h00,h01,h02,h10,h11,h12,h20,h21,h22,matches\n".to_owned();
    // From frame 0 to 1 and from 1 to 2; none leads from 0 to 2, and that to 3 has failed.
    for (from, to) in [(0, 1), (1, 2)] {
        let (a, b) = (FLIGHT[from].0, FLIGHT[to].0);
        let moved = nalgebra::Matrix3::new_translation(&nalgebra::Vector2::new(a[0] - b[0], a[1] - b[1]));
        let h = view(&FLIGHT[to]).from_ground() * moved * view(&FLIGHT[from]).to_ground();
        let h = h / h[(2, 2)];
        let cells: Vec<String> = (0..9).map(|i| h[(i / 3, i % 3)].to_string()).collect();
        writeln!(table, "{from},{to},1,{},100", cells.join(",")).unwrap();
    }
    table += "0,3,0,,,,,,,,,,\n";
    fs::write(folder.path().join("pseudo_gt.csv"), table).unwrap();
    let (report, text) = json(&["cosim", folder.path().to_str().unwrap()]);
    let truths = report["pseudo_truth"].as_array().unwrap();
    let chained: Vec<&Value> = truths.iter().map(|truth| &truth["chained"]).collect();
    assert_eq!(chained, [&Value::Bool(false), &Value::Bool(false), &Value::Bool(true), &Value::Null], "{text}");
    for (truth, place) in truths.iter().zip(&FLIGHT).take(3) {
        for (axis, name) in ["x_e_m", "y_e_m"].iter().enumerate() {
            assert!((truth[*name].as_f64().unwrap() - place.0[axis]).abs() < 1e-6, "{text}");
        }
    }
    let accuracy = &report["against_truth"];
    assert_eq!(accuracy["frames"], 2, "{text}");
    assert!(accuracy["rms_m"].as_f64().unwrap() > 0.0 && accuracy["max_m"].as_f64().unwrap() < 0.1, "{text}");
}

#[test]
fn homographies_of_other_frames_are_remarked() {
    let folder = flight();
    let table = "ref,frame,ok,h00,h01,h02,h10,h11,h12,h20,h21,h22\n100,101,1,1,0,0,0,1,0,0,0,1\n";
    fs::write(folder.path().join("pseudo_gt.csv"), table).unwrap();
    let output = hoverlock(&["cosim", folder.path().to_str().unwrap()]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("pseudo_gt.csv: no homography gives the position of a frame after frame 0"), "{text}");
}

#[track_caller]
fn refused(arguments: &[&str], named: &str) {
    assert_refused(&hoverlock(arguments), named);
}

#[test]
fn bad_telemetry_is_one_line_and_status_2() {
    let folder = flight();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (reference, current, table) = (path("00.png"), path("01.png"), path("bad.csv"));
    let good = telemetry(&FLIGHT[..2]);
    let cases = [
        (good.replace("range_m", "range"), "`range`"),
        ("time_s,roll_deg,pitch_deg,yaw_deg,fov_deg\n0,0,0,0,50\n1,0,0,0,50\n".into(), "missing field `range_m`"),
        (good.replace(", 0.2", ", nine"), "row 1 of the telemetry: tilt_se_deg is no number"),
        (good.replace(", 0.2", ", -0.2"), "tilt_se_deg is -0.2"),
        (good.replace(", 0.2", ", NaN"), "tilt_se_deg is NaN"),
        (good.replace(", 50, ", ", 190, "), "fov_deg is 190"),
        (good.replace(", 50, ", ", "), "6 fields, and the header has 7"),
        (good.lines().take(3).collect::<Vec<_>>().join("\n"), "1 rows of telemetry for 2 pictures"),
        (good.clone() + "1,0,0,0,50,50,1\n", "3 rows of telemetry for 2 pictures"),
        (String::new(), "0 rows"),
        ("\u{0}\u{1}\n".into(), "bad.csv"),
        ("time_s,roll_deg,pitch_deg,yaw_deg,range_m,fov_deg\n1,0,0,0,9,50\n1,0,0,0,9,50\n".into(), "does not grow"),
    ];
    for (text, named) in cases {
        fs::write(&table, text).unwrap();
        refused(&["match", &reference, &current, "--telemetry", &table], named);
    }
    fs::write(&table, [b'r', 0xff, 0xfe]).unwrap();
    refused(&["match", &reference, &current, "--telemetry", &table], "bad.csv");
    refused(&["match", &reference, &current, "--telemetry", &path("missing.csv")], "missing.csv");
    refused(&["match", &reference, &current, "--telemetry", folder.path().to_str().unwrap()], "not a regular file");
    // Opening a FIFO would wait for its writer.
    let fifo = path("fifo.csv");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    refused(&["match", &reference, &current, "--telemetry", &fifo], "fifo.csv: the telemetry is not a regular file");
    let read = good.as_bytes();
    fs::write(&table, read).unwrap();
    for option in ["--telemetry", "--calibration"] {
        let input = path("input.png");
        fs::write(&input, read).unwrap();
        let telemetry = if option == "--telemetry" { vec![] } else { vec!["--telemetry", &table] };
        let given = ["match", &reference, &current, "--overlay", &input, option, &input];
        refused(&[&given[..], &telemetry].concat(), "input.png: is one of the inputs");
        assert_eq!(fs::read(&input).unwrap(), read);
    }
}

#[test]
fn a_bad_sequence_is_one_line_and_status_2() {
    let good = flight();
    let sequence = good.path().to_str().unwrap();
    let other = tempfile::tempdir().unwrap();
    let folder = other.path().to_str().unwrap();
    let put = |name: &str, bytes: &[u8]| fs::write(other.path().join(name), bytes).unwrap();
    refused(&["cosim", "/missing/folder"], "/missing/folder");
    refused(&["cosim", &format!("{sequence}/00.png")], "is no folder");
    refused(&["cosim", folder], "holds no picture");
    save(other.path(), "00.png", &seen(&FLIGHT[0]));
    refused(&["cosim", folder], "holds one picture");
    save(other.path(), "01.png", &Plane::from_fn(100, 90, |x, y| ground(x as f64, y as f64)));
    refused(&["cosim", folder], "01.png: is 100x90, and the frames before are 320x240");
    put("01.png", b"no picture");
    refused(&["cosim", folder], "01.png");
    save(other.path(), "01.png", &seen(&FLIGHT[1]));
    put("inertial.csv", format!("{INERTIAL_COLUMNS}\n0,0,0,0,0,0,-9.8\n").as_bytes());
    let alone = "inertial.csv: its samples need the times of the frames, and there is no";
    refused(&["cosim", folder], &format!("{folder}/{alone} {folder}/telemetry.csv; add it"));
    fs::remove_file(other.path().join("inertial.csv")).unwrap();
    put("telemetry.csv", telemetry(&FLIGHT).as_bytes());
    refused(&["cosim", folder], "4 rows of telemetry for 2 pictures");
    put("telemetry.csv", telemetry(&FLIGHT[..2]).as_bytes());
    put("pseudo_gt.csv", b"ref,frame,ok,h00,h01,h02,h10,h11,h12,h20,h21,h22\n0,1,1,inf,0,0,0,1,0,0,0,1\n");
    refused(&["cosim", folder], "row 1 of the homographies: a value is not a finite number");
    fs::remove_file(other.path().join("pseudo_gt.csv")).unwrap();
    fs::create_dir(other.path().join("pseudo_gt.csv")).unwrap();
    refused(&["cosim", folder], "pseudo_gt.csv: the table of homographies is not a regular file");
    fs::remove_dir(other.path().join("pseudo_gt.csv")).unwrap();
    put("pseudo_gt.csv", b"ref,frame\n0,1\n");
    refused(&["cosim", folder], "pseudo_gt.csv");
    refused(&["cosim", sequence, "--features", "sift"], "sift");
    let missing = Command::new(env!("CARGO_BIN_EXE_hoverlock"))
        .args(["cosim", sequence, "--estimator", "arm"])
        .env("HOVERLOCK_NAV", "/missing/hoverlock-nav")
        .output()
        .unwrap();
    let line = String::from_utf8_lossy(&missing.stderr);
    assert_eq!((missing.status.code(), line.lines().count()), (Some(2), 1), "{line}");
    assert!(line.contains("/missing/hoverlock-nav") && line.contains("make arm"), "{line}");
    // A page that cannot be written leaves nothing behind.
    refused(&["cosim", sequence, "--out", &format!("{sequence}/00.png")], "00.png");
}

/// What is beside the frames is read, named, or left out as its name says.
#[test]
fn links_to_nothing_odd_samples_and_hidden_files_are_seen() {
    let folder = flight();
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let sequence = folder.path().to_str().unwrap();
    put("._00.png", "of another system");
    put("telemetry.csv", &telemetry(&FLIGHT));
    let said = |text: &str| {
        put("inertial.csv", &format!("{INERTIAL_COLUMNS}\n{text}\n"));
        String::from_utf8(hoverlock(&["cosim", sequence]).stderr).unwrap()
    };
    let text = said("900,0,0,0,0,0,-9.8");
    assert!(text.contains("inertial.csv: no sample is between the frames: samples are from 900 to 900 s"), "{text}");
    assert!(!text.contains("specific force"), "{text}");
    let text = said("900,0,0,0,0,0,-1");
    assert!(text.contains("inertial.csv: the mean specific force down is -1.00 m/s^2"), "{text}");
    fs::remove_file(folder.path().join("inertial.csv")).unwrap();
    std::os::unix::fs::symlink("/missing/calibration.toml", folder.path().join("calibration.toml")).unwrap();
    refused(&["cosim", sequence], "calibration.toml: cannot be read");
}

/// The clock of a flight may count from 1970.
#[test]
fn times_from_any_epoch_give_the_same_estimates() {
    let folder = flight();
    let sequence = folder.path().to_str().unwrap();
    let positions = || {
        let (report, _) = json(&["cosim", sequence]);
        let estimates = report["estimates"].as_array().unwrap();
        estimates.iter().map(|line| [line["x_e_m"].clone(), line["y_e_m"].clone()]).collect::<Vec<_>>()
    };
    let from_zero = positions();
    let shifted: String = telemetry(&FLIGHT)
        .lines()
        .map(|line| match line.split_once(',') {
            Some((time, rest)) if time.parse::<u32>().is_ok() => format!("179600000{time},{rest}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    fs::write(folder.path().join("telemetry.csv"), shifted).unwrap();
    assert!(from_zero.iter().any(|[x, _]| !x.is_null()) && positions() == from_zero);
}

/// Of many pictures that are cropped, one remark names the first, another counts the others.
#[test]
fn remarks_do_not_repeat_and_names_stay_on_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "b.png", "c\nd.png"] {
        save(folder.path(), name, &Plane::from_fn(1100, 800, |x, y| ground(x as f64, y as f64)));
    }
    let output = hoverlock(&["cosim", folder.path().to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(said.matches("is larger than the frame").count(), 1, "{said}");
    assert!(said.contains("2 more of these pictures are turned or cropped"), "{said}");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("c\\nd.png") && table.lines().count() < 8, "{table}");
    // The frame is that of the design.
    let output = hoverlock(&["cosim", folder.path().to_str().unwrap(), "--design", "hd1080"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() != Some(2) && !said.contains("is larger than the frame"), "{said}");
}

/// Returns a folder of the flight in which some frames are replaced.
fn flight_with(frames: &[(usize, Plane<u16>)]) -> tempfile::TempDir {
    let folder = flight();
    for (i, picture) in frames {
        save(folder.path(), &format!("{i:02}.png"), picture);
    }
    folder
}

/// Pictures without features: black, white, one grey, and fog, whose light falls evenly from the top to the bottom.
fn featureless() -> [Plane<u16>; 4] {
    let fog = Plane::from_fn(WIDTH, HEIGHT, |_, y| 30_000 - 20 * y as u16);
    [Plane::filled(WIDTH, HEIGHT, 0), Plane::filled(WIDTH, HEIGHT, u16::MAX), Plane::filled(WIDTH, HEIGHT, 7), fog]
}

/// Asserts that an estimate is within its protection level and within 15 cm.
#[track_caller]
fn assert_covered(estimate: &Value, place: [f64; 2]) {
    let [x, y, level] = ["x_e_m", "y_e_m", "protection_level_m"].map(|key| estimate[key].as_f64().unwrap());
    let error = (x - place[0]).hypot(y - place[1]);
    assert!(error < level && error < 0.15, "{error} m, protection level {level} m");
}

#[test]
fn a_frame_without_features_has_no_estimate_and_the_others_keep_theirs() {
    let why = "the frame shows 0 features, and 8 are needed";
    for (number, picture) in featureless().into_iter().enumerate() {
        // In the middle or at the end: the frames beside it are estimated.
        for blank in [2, 3] {
            let folder = flight_with(&[(blank, picture.clone())]);
            let sequence = folder.path().to_str().unwrap();
            let (report, text) = json(&["cosim", sequence]);
            let estimates = report["estimates"].as_array().unwrap();
            assert_eq!((&report["ok"], estimates.len()), (&true.into(), 4), "{number}: {text}");
            for (i, (estimate, place)) in estimates.iter().zip(&FLIGHT).enumerate().skip(1) {
                if i == blank {
                    assert_eq!((&estimate["status"], &estimate["reason"]), (&"none".into(), &why.into()), "{text}");
                    assert!(estimate["x_e_m"].is_null() && estimate["protection_level_m"].is_null(), "{text}");
                } else {
                    assert_covered(estimate, [place.0[0], place.0[1]]);
                }
            }
            let table = hoverlock(&["cosim", sequence]);
            let row = format!("{blank:02}.png         none      {why}; 0 features");
            assert!(String::from_utf8_lossy(&table.stdout).contains(&row), "{table:?}");
        }
    }
}

#[test]
fn a_first_frame_without_features_leaves_the_reference_to_the_next() {
    for (number, picture) in featureless().into_iter().enumerate() {
        let folder = flight_with(&[(0, picture)]);
        let out = folder.path().join("page");
        let (report, text) = json(&["cosim", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap()]);
        let estimates = report["estimates"].as_array().unwrap();
        assert_eq!(
            (estimates.len(), &estimates[0]["status"], &estimates[1]["status"]),
            (4, &"none".into(), &"reference".into()),
            "{number}: {text}"
        );
        assert!(estimates[0]["reason"].as_str().unwrap().contains("shows 0 features"), "{text}");
        for (estimate, place) in estimates.iter().zip(&FLIGHT).skip(2) {
            assert_covered(estimate, [0, 1].map(|axis| place.0[axis] - FLIGHT[1].0[axis]));
        }
        let page = fs::read_to_string(out.join("index.html")).unwrap();
        assert!(page.contains("shows 0 features") && page.contains("2 estimates in 4 frames"), "{number}");
    }
}

#[test]
fn a_sequence_without_any_feature_ends_with_its_reason() {
    let blank: Vec<_> = (0..4).zip(featureless()).collect();
    let folder = flight_with(&blank);
    let out = folder.path().join("page");
    let (report, text) = json(&["cosim", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert_eq!((&report["ok"], lines(&text).len()), (&false.into(), 4));
    let reason = report["reason"].as_str().unwrap();
    assert!(reason.starts_with("no frame has an estimate: the frame shows 0 features"), "{text}");
    assert!(fs::read_to_string(out.join("index.html")).unwrap().contains("no frame has an estimate: the frame shows"));
}

/// The thresholds of the hardware adapt through frames without features as those of the model do.
#[test]
fn hardware_and_model_agree_on_frames_without_features() {
    let [black, white, ..] = featureless();
    let folder = flight_with(&[(0, black), (2, white)]);
    let sequence = folder.path().to_str().unwrap();
    let (_, fixed) = json(&["cosim", sequence]);
    let (_, rtl) = json(&["cosim", sequence, "--features", "rtl"]);
    assert_eq!(lines(&fixed), lines(&rtl));
}

#[test]
fn a_flight_over_nothing_known_has_status_1_and_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "00.png", &seen(&FLIGHT[0]));
    save(folder.path(), "01.png", &seen(&([9000.0, 5000.0, 50.0], [0.0; 3])));
    let (report, text) = json(&["cosim", folder.path().to_str().unwrap()]);
    assert_eq!((&report["ok"], lines(&text).len()), (&false.into(), 2));
    assert!(report["reason"].as_str().unwrap().contains("no frame has an estimate"), "{text}");
    assert!(report["reason"].as_str().unwrap().ends_with("so these frames judge no design"), "{text}");
    assert!(report["telemetry"].as_str().unwrap().starts_with("assumed"), "{text}");
}

/// A line that the test's own capture does not hold back.
fn skipped(why: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {why}");
}

/// The ARM binary: what the variable names, or that of `make arm` beside the command under test.
fn arm_binary() -> Option<PathBuf> {
    let named = std::env::var_os("HOVERLOCK_NAV").map(PathBuf::from);
    let target = Path::new(env!("CARGO_BIN_EXE_hoverlock")).ancestors().nth(2)?;
    let binary = named.unwrap_or_else(|| target.join("arm/armv7-unknown-linux-gnueabihf/release/hoverlock-nav"));
    let qemu = Command::new("qemu-arm").arg("--version").output().is_ok();
    (qemu && binary.is_file()).then_some(binary)
}

#[test]
fn the_arm_binary_writes_the_lines_of_the_host() {
    if arm_binary().is_none() {
        return skipped("the_arm_binary_writes_the_lines_of_the_host: no ARM binary or no qemu-arm; run `make arm`");
    }
    let folder = flight();
    let sequence = folder.path().to_str().unwrap();
    let (_, host) = json(&["cosim", sequence]);
    let (report, arm) = json(&["cosim", sequence, "--estimator", "arm"]);
    assert_eq!((lines(&host), &report["ok"]), (lines(&arm), &true.into()));
}

#[test]
#[ignore = "real pictures: 27 frames through the simulated hardware"]
fn real_sequences_give_the_same_lines_from_hardware_and_model() {
    let Some(data) = data_dir() else {
        return skipped("real_sequences_give_the_same_lines: no folder of real pictures, set HOVERLOCK_DATA");
    };
    let estimator = if arm_binary().is_some() { "arm" } else { "host" };
    if estimator == "host" {
        skipped("real_sequences: the ARM binary's half: no ARM binary or no qemu-arm; run `make arm`");
    }
    // Sequences and the estimates in them: all frames but the first, and one of the forest that is known to 1.8 m only.
    for (name, least) in [("drone_park", 7), ("caliterra", 5), ("copr_dunes", 7), ("forest_flight", 3)] {
        let folder = data.join("sequences").join(name);
        let sequence = folder.to_str().unwrap();
        let (fixed, text) = json(&["cosim", sequence]);
        let (_, hardware) = json(&["cosim", sequence, "--features", "rtl", "--estimator", estimator]);
        assert_eq!(lines(&text), lines(&hardware), "{name}");
        let estimates = fixed["estimates"].as_array().unwrap();
        assert_eq!(lines(&text).len(), estimates.len());
        let found = estimates.iter().filter(|estimate| !estimate["x_e_m"].is_null()).count();
        assert!(found >= least, "{name}: {found} estimates\n{text}");
        for (estimate, truth) in estimates.iter().zip(fixed["pseudo_truth"].as_array().unwrap()) {
            let (Some(level), false) = (estimate["protection_level_m"].as_f64(), truth.is_null()) else { continue };
            let apart = ["x_e_m", "y_e_m"].map(|key| estimate[key].as_f64().unwrap() - truth[key].as_f64().unwrap());
            let error = apart[0].hypot(apart[1]);
            assert!(error < level, "{name}: {error} m from the homography, protection level {level} m");
        }
        let error = fixed["against_truth"]["max_m"].as_f64().unwrap();
        assert!(error < 0.5, "{name}: {error} m from the homographies");
    }
}

#[test]
#[ignore = "real pictures: three pairs"]
fn real_neighbours_are_measured_in_metres() {
    let Some(data) = data_dir() else {
        return skipped("real_neighbours_are_measured_in_metres: no folder of real pictures, set HOVERLOCK_DATA");
    };
    // What `cosim` assumes, so that both have the same metres.
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("assumed.csv");
    let header = "roll_deg,pitch_deg,yaw_deg,range_m,fov_deg,tilt_se_deg,heading_se_deg,range_se_m";
    fs::write(&table, format!("{header}\n0,0,0,20,50,5,10,1\n0,0,0,20,50,5,10,1\n")).unwrap();
    for name in ["drone_park", "caliterra", "copr_dunes"] {
        let sequence = data.join("sequences").join(name);
        let (reference, current) = (sequence.join("00.png"), sequence.join("01.png"));
        let pictures = [reference.to_str().unwrap(), current.to_str().unwrap()];
        let (report, _) = json(&["match", pictures[0], pictures[1], "--telemetry", table.to_str().unwrap()]);
        let (cosim, _) = json(&["cosim", sequence.to_str().unwrap()]);
        let found = numbers(&report["displacement_m"]);
        for (axis, key) in ["x_e_m", "y_e_m"].iter().enumerate() {
            let error = found[axis] - cosim["pseudo_truth"][1][*key].as_f64().unwrap();
            assert!(error.abs() < 0.15, "{name}, {key}: {error} m from the homography");
        }
    }
}
