//! The program as it is called: arguments, streams, exit status, and what goes to the camera.

mod support;

use hoverlock_arm::arinc429::{Camera, Control, decode};
use hoverlock_arm::message;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::scene::stream;

fn nav(arguments: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hoverlock-nav")).args(arguments).output().unwrap()
}

fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn bad_usage_is_one_clear_line_and_status_2() {
    let missing = Path::new("no/such/stream.hln");
    for (arguments, part) in [
        (vec![missing], "no/such/stream.hln"),
        (vec![Path::new("--fast")], "unknown option --fast"),
        (vec![Path::new("--camera")], "--camera takes a file"),
        (vec![Path::new("a"), Path::new("b")], "one stream at most"),
    ] {
        let output = nav(&arguments);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.lines().count() == 1 && text.contains(part), "{text}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn another_fpga_ends_the_program_with_status_2() {
    let mut source = stream(50, 1);
    let mut other = support::Source::default();
    other.send(message::REGISTERS, &message::encode_registers(&[(0, 1)]));
    source.messages[0] = other.messages.remove(0);
    let output = nav(&[&file("other.hln", &source.messages.concat())]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("identification reads 0x00000001"));
}

#[test]
fn commands_reach_the_camera_and_stop_ends_the_stream() {
    let mut source = stream(300, 2);
    for command in [message::Command::Narrow, message::Command::Wide, message::Command::Stop, message::Command::Wide] {
        source.send(message::COMMAND, &command.encode());
    }
    let (input, camera) = (file("zoom.hln", &source.messages.concat()), file("camera.words", &[]));
    let output = nav(&[Path::new("--camera"), &camera, &input]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 2);
    let words = std::fs::read(camera).unwrap();
    let views: Vec<_> =
        words.chunks(4).map(|word| decode(u32::from_le_bytes(word.try_into().unwrap())).unwrap()).collect();
    // The command after the one to stop is not carried out.
    let [(Camera::All, Control::Zoom(narrow)), (Camera::All, Control::Zoom(wide))] = views[..] else {
        panic!("{views:?}")
    };
    assert!((narrow - 5.4).abs() < 1e-3 && (wide - 50.0).abs() < 1e-3);
}
