//! The messages to the autopilot, decoded by pymavlink, an independent implementation of MAVLink.

mod support;

use std::io::Write;
use std::path::Path;
use std::process::Command;
use support::{Source, scene};

/// Python program that prints the fields of each message in a file as JSON.
const READER: &str = "
import json, sys
from pymavlink.dialects.v20 import common
link = common.MAVLink(None)
for message in link.parse_buffer(open(sys.argv[1], 'rb').read()):
    fields = message.to_dict()
    fields['sequence'] = message.get_seq()
    print(json.dumps(fields))
";

/// Frames without samples of the IMU, and frames with them.
#[test]
fn an_independent_reader_finds_what_the_lines_say() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let python = root.join(".venv/bin/python");
    let there = Command::new(&python).args(["-c", "import pymavlink"]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        // On stderr itself, past the captured output, so that `make test` lists it.
        let why = "no pymavlink in .venv; run setup/bootstrap.sh";
        let _ = writeln!(std::io::stderr(), "SKIPPED: an_independent_reader_finds_what_the_lines_say: {why}");
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (name, source, has_velocity) in [("free", scene::stream(400, 5), false), ("imu", scene::steady(600, 45), true)]
    {
        compare(&python, &folder.join(name), &source, has_velocity);
    }
}

/// Compares the messages that pymavlink decodes with the lines of a stream.
fn compare(python: &Path, path: &Path, source: &Source, has_velocity: bool) {
    let (stream, messages) = (path.with_extension("hln"), path.with_extension("bin"));
    std::fs::write(&stream, source.messages.concat()).unwrap();
    let program = env!("CARGO_BIN_EXE_hoverlock-nav");
    let output = Command::new(program).arg("--mavlink").args([&messages, &stream]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = Command::new(python).args(["-c", READER]).arg(&messages).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));

    let json = |bytes: &[u8]| -> Vec<serde_json::Value> {
        // Python writes NaN, which is not JSON; here it means unknown.
        let text = String::from_utf8(bytes.to_vec()).unwrap().replace("NaN", "null");
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let lines: Vec<_> = json(&output.stdout).into_iter().filter(|line| line["status"] == "estimate").collect();
    let messages = json(&read.stdout);
    assert!(lines.len() >= 4 && lines.len() == messages.len(), "{} and {}", lines.len(), messages.len());
    for (number, (line, message)) in lines.iter().zip(&messages).enumerate() {
        assert_eq!(message["mavpackettype"], "ODOMETRY");
        assert_eq!(message["sequence"], number);
        assert_eq!(message["time_usec"], line["time_us"]);
        // MAV_FRAME_LOCAL_FRD, MAV_FRAME_BODY_FRD, MAV_ESTIMATOR_TYPE_VISION; the first reference.
        let numbers = ["frame_id", "child_frame_id", "estimator_type", "reset_counter"].map(|name| &message[name]);
        assert_eq!(numbers, [20, 12, 2, 1]);
        let near = |value: &serde_json::Value, expected: f64| {
            let value = value.as_f64().unwrap();
            assert!((value - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{value}, not {expected}");
        };
        let of = |name: &str| line[name].as_f64().unwrap();
        near(&message["x"], -of("y_e_m"));
        near(&message["y"], of("x_e_m"));
        near(&message["z"], of("z_e_m"));
        let (w, z) = (message["q"][0].as_f64().unwrap(), message["q"][3].as_f64().unwrap());
        assert!((2.0 * z.atan2(w) - of("yaw_rad")).abs() < 1e-4);
        let covariance = |index: usize| line["covariance_m2"][index].as_f64().unwrap();
        near(&message["pose_covariance"][0], covariance(3));
        near(&message["pose_covariance"][1], -covariance(1));
        near(&message["pose_covariance"][6], covariance(0));
        near(&message["pose_covariance"][11], 2.0 * 0.1 * 0.1);
        near(&message["pose_covariance"][15], 0.0035 * 0.0035);
        // The camera is level, so that the axes of the body are those of the level frame but for the yaw.
        let [vx, vy, vz] = ["vx", "vy", "vz"].map(|name| &message[name]);
        assert_eq!(has_velocity, !vx.is_null(), "{message}");
        assert_eq!(has_velocity, !message["velocity_covariance"][0].is_null(), "{message}");
        if has_velocity {
            let velocity = |axis: usize| line["velocity_m_s"][axis].as_f64().unwrap();
            for (value, expected) in [(vx, -velocity(1)), (vy, velocity(0)), (vz, velocity(2))] {
                assert!((value.as_f64().unwrap() - expected).abs() < 0.01, "{value}, not {expected}");
            }
            let variance = |axis: usize| line["velocity_covariance_m2_s2"][4 * axis].as_f64().unwrap();
            for (index, axis) in [(0, 1), (6, 0), (11, 2)] {
                let ratio = message["velocity_covariance"][index].as_f64().unwrap() / variance(axis);
                assert!((0.9..1.1).contains(&ratio), "{ratio}");
            }
        }
        assert!(message["rollspeed"].is_null());
        assert_eq!(message["quality"], (of("quality") * 100.0 / 255.0).ceil());
    }
}
