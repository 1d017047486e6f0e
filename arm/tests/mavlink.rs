//! The messages to the autopilot, decoded by pymavlink, an independent implementation of MAVLink.

mod support;

use std::io::Write;
use std::path::Path;
use std::process::Command;
use support::scene;

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
    let (stream, messages) = (folder.join("mavlink.hln"), folder.join("mavlink.bin"));
    std::fs::write(&stream, scene::stream(400, 5).messages.concat()).unwrap();
    let program = env!("CARGO_BIN_EXE_hoverlock-nav");
    let output = Command::new(program).arg("--mavlink").args([&messages, &stream]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = Command::new(&python).args(["-c", READER]).arg(&messages).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));

    let json = |bytes: &[u8]| -> Vec<serde_json::Value> {
        // Python writes NaN, which is not JSON; here it means unknown.
        let text = String::from_utf8(bytes.to_vec()).unwrap().replace("NaN", "null");
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let lines: Vec<_> = json(&output.stdout).into_iter().filter(|line| line["status"] == "estimate").collect();
    let messages = json(&read.stdout);
    assert_eq!((lines.len(), messages.len()), (4, 4));
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
        assert!(message["vx"].is_null() && message["velocity_covariance"][0].is_null());
        assert_eq!(message["quality"], (of("quality") * 100.0 / 255.0).ceil());
    }
}
