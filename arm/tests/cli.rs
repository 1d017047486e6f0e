//! The program from the command line: arguments, streams, exit status, and the words for the camera.

mod support;

use hoverlock_arm::arinc429::{Camera, Control, decode};
use hoverlock_arm::hardware::{EMISSION, IDENTIFICATION, VERSION, registers as map};
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

fn paths(arguments: [&str; 2]) -> Vec<&Path> {
    arguments.map(Path::new).into()
}

/// Creates a file with the register block of the emitted hardware from byte 8 on, and returns its path.
fn registers(name: &str) -> PathBuf {
    let mut bytes = vec![0; 8 + 0x100];
    for (address, value) in [(map::IDENTIFICATION, IDENTIFICATION), (map::VERSION, VERSION), (map::EMISSION, EMISSION)]
    {
        bytes[8 + address as usize..][..4].copy_from_slice(&value.to_le_bytes());
    }
    file(name, &bytes)
}

/// Runs the program with the registers at `device`, for frames of 320 x 240.
fn nav_on(device: &str, stream: &Path) -> Output {
    let setup = ["--thresholds", "700,900", "--size", "320x240", "--registers", device].map(Path::new);
    nav(&[&setup[..], &[stream]].concat())
}

#[test]
fn the_registers_are_set_up_before_the_stream_is_read() {
    let device = registers("device.registers");
    let input = file("set_up.hln", &stream(300, 2).messages.concat());
    let output = nav_on(&format!("{}@0x8", device.display()), &input);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 2);
    let block = std::fs::read(device).unwrap();
    let register = |address: u32| u32::from_le_bytes(block[8 + address as usize..][..4].try_into().unwrap());
    assert_eq!((register(map::SIZE), register(map::THRESHOLD)), (240 << 16 | 320, 900 << 16 | 700));
    assert_eq!((register(map::CONTROL), register(map::COMMIT), register(map::TARGET)), (0b101, 1, 512));
    assert_eq!(map::COEFFICIENTS.map(|(address, _)| register(address)), map::COEFFICIENTS.map(|(_, value)| value));
}

#[test]
fn registers_that_cannot_be_used_are_one_line_and_status_2() {
    let device = registers("refused.registers");
    let untouched = std::fs::read(&device).unwrap();
    let short = file("short.registers", &untouched[..0x100]);
    let input = file("not_read.hln", &stream(50, 1).messages.concat());
    for (device, part) in [
        (format!("{}", device.display()), "identification reads 0x00000000, not 0x484c434b: no Hoverlock core"),
        (format!("{}@8", short.display()), "short.registers: 256 bytes, too few for 256 bytes of registers at offset"),
        (format!("{}@6", device.display()), "offset 0x6 of the registers is not a multiple of 4"),
        ("no/such/device".into(), "no/such/device: cannot open the registers"),
        ("/dev/null".into(), "/dev/null: cannot map 256 bytes at offset 0x0"),
    ] {
        let output = nav_on(&device, &input);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.lines().count() == 1 && text.contains(part), "{text}");
        assert!(output.stdout.is_empty());
    }
    assert!(std::fs::read(device).unwrap() == untouched, "nothing is written to another device");
}

#[test]
fn bad_usage_is_one_clear_line_and_status_2() {
    let missing = Path::new("no/such/stream.hln");
    let text = file("text.hln", b"This is no stream.\n");
    for (arguments, part) in [
        (vec![missing], "no/such/stream.hln"),
        (vec![&text], "no message in 19 bytes"),
        (vec![Path::new("--fast")], "unknown option --fast"),
        (vec![Path::new("--camera")], "--camera takes a file"),
        (vec![Path::new("a"), Path::new("b")], "one stream at most"),
        (paths(["--registers", "/dev/uio0"]), "--registers needs --size"),
        (paths(["--size", "64x64"]), "--size and --thresholds need --registers"),
        (paths(["--size", "64*64"]), "--size: `64*64` is not WIDTHxHEIGHT"),
        (paths(["--size", "63x64"]), "--size: a frame of 63 x 64 pixels"),
        (paths(["--thresholds", "0,9"]), "--thresholds: [0, 9] are not both from 1 to 32767"),
        (paths(["--registers", "/dev/mem@base"]), "--registers: `base` after the @ is not a byte offset"),
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
    other.send(message::REGISTERS, &message::encode_registers(&[(0, 1)])).unwrap();
    source.messages[0] = other.messages.remove(0);
    let output = nav(&[&file("other.hln", &source.messages.concat())]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("identification reads 0x00000001"));
}

#[test]
fn commands_reach_the_camera_and_stop_ends_the_stream() {
    let mut source = stream(300, 2);
    for command in [message::Command::Narrow, message::Command::Wide, message::Command::Stop, message::Command::Wide] {
        source.send(message::COMMAND, &command.encode()).unwrap();
    }
    let (input, camera) = (file("zoom.hln", &source.messages.concat()), file("camera.words", &[]));
    let output = nav(&[Path::new("--camera"), &camera, &input]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 2);
    let words = std::fs::read(camera).unwrap();
    let views: Vec<_> =
        words.chunks(4).map(|word| decode(u32::from_le_bytes(word.try_into().unwrap())).unwrap()).collect();
    // The command after the one to stop is not executed.
    let [(Camera::All, Control::Zoom(narrow)), (Camera::All, Control::Zoom(wide))] = views[..] else {
        panic!("{views:?}")
    };
    assert!((narrow - 10.0).abs() < 1e-3 && (wide - 50.0).abs() < 1e-3);
}

/// An output that is the stream would empty it before it is read.
#[test]
fn the_stream_is_not_overwritten() {
    let bytes = stream(300, 2).messages.concat();
    let input = file("own_output.hln", &bytes);
    for option in ["--mavlink", "--camera"] {
        let output = nav(&[Path::new(option), &input, &input]);
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.lines().count() == 1 && said.contains("own_output.hln: is the stream"), "{said}");
    }
    assert_eq!(std::fs::read(&input).unwrap(), bytes);
    let folder = nav(&[Path::new("--mavlink"), &input, input.parent().unwrap()]);
    assert_eq!(folder.status.code(), Some(2));
    assert!(String::from_utf8(folder.stderr).unwrap().contains("is a folder"));
    assert_eq!(std::fs::read(&input).unwrap(), bytes);
}
