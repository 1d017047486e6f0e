//! The ARM binary under qemu writes the same bytes as the host's.

mod support;

use hoverlock_pictures::data_dir;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::adversarial::{self, Samples, Shape};

/// Returns the binary of `make arm`, or `None` if it or qemu is missing.
fn arm_binary() -> Option<PathBuf> {
    let target = Path::new(env!("CARGO_BIN_EXE_hoverlock-nav")).ancestors().nth(2)?;
    let binary = target.join("arm/armv7-unknown-linux-gnueabihf/release/hoverlock-nav");
    let qemu = Command::new("qemu-arm").arg("--version").output().is_ok();
    (qemu && binary.is_file()).then_some(binary)
}

fn run(command: &mut Command, stream: &Path) -> Output {
    let output = command.arg(stream).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Runs both programs on one stream, asserts that their outputs are equal, and returns it.
fn compare(arm: &Path, name: &str, bytes: &[u8]) -> String {
    let stream = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name).with_extension("hln");
    std::fs::write(&stream, bytes).unwrap();
    let host = run(&mut Command::new(env!("CARGO_BIN_EXE_hoverlock-nav")), &stream);
    let flown = run(Command::new("qemu-arm").args(["-cpu", "cortex-a9"]).arg(arm), &stream);
    let text = |output: &Output| String::from_utf8(output.stdout.clone()).unwrap();
    assert_eq!(text(&host), text(&flown), "{name}: run `make arm` if the sources have changed since");
    assert_eq!(host.stderr, flown.stderr, "{name}");
    text(&host)
}

/// Reports a skipped test on stderr itself, past the captured output, so that `make test` lists it.
fn skipped(why: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: host_and_arm_write_the_same_bytes: {why}");
}

#[test]
fn host_and_arm_write_the_same_bytes() {
    let Some(arm) = arm_binary() else {
        return skipped("no ARM binary or no qemu-arm; run `make arm`");
    };
    let lines = compare(&arm, "scene", &support::scene::stream(800, 10).messages.concat());
    assert_eq!(lines.matches("\"status\":\"estimate\"").count(), 9, "{lines}");
    let frames = adversarial::repeated(Shape::Ground, Samples::Even, 12);
    let refined = adversarial::stream(Shape::Ground, &frames, Some(&adversarial::texture()));
    let lines = compare(&arm, "refined", &refined.messages.concat());
    assert!(lines.matches("x_e_m").count() >= 8, "{lines}");
    let frames = adversarial::repeated(Shape::Ground, Samples::None, 12);
    let searched = adversarial::calibrated(Shape::Ground, &frames, Some(&adversarial::texture()));
    let lines = compare(&arm, "calibrated", &searched.messages.concat());
    assert!(lines.matches("x_e_m").count() >= 4, "{lines}");
    let Some(folder) = data_dir() else {
        return skipped("no folder of real pictures, set HOVERLOCK_DATA");
    };
    let (mut estimates, mut references) = (0, 0);
    for name in ["caliterra", "copr_dunes", "drone_park", "forest_flight"] {
        let source = support::sequence(&folder.join("sequences").join(name)).unwrap();
        let lines = compare(&arm, name, &source.messages.concat());
        estimates += lines.matches("x_e_m").count();
        references += lines.matches("\"status\":\"reference\"").count();
    }
    // Every second of 27 frames is a reference. All others but one, whose displacement is known to 1.8 m only, have an
    // estimate, so search and fit are compared, too.
    assert_eq!((references, estimates), (14, 12));
}
