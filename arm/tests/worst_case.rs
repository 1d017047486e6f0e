//! The work of a frame is bounded, whatever arrives: counted in work units here, in instructions of the ARM under qemu.

mod support;

use hoverlock_arm::line::{Line, Status};
use hoverlock_arm::message::Command as Order;
use hoverlock_arm::navigator::{MAX_FRAME_INSTRUCTIONS, Navigator, WORK_UNITS};
use hoverlock_reference::motion::budget::UNIT_INSTRUCTIONS;
use hoverlock_reference::motion::mark::Part;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::adversarial::{self, Samples, Shape, Taken};
use support::{Source, flown};

/// Instructions of a frame that is refused at once, which no unit counts: its message is still checked byte for byte.
const UNCOUNTED_INSTRUCTIONS: u64 = 100_000;

fn lines(source: &Source, work: u64) -> Vec<Line> {
    flown(&source.messages.concat(), Navigator::with_work(work))
}

fn shape() -> impl Strategy<Value = Shape> {
    (0..Shape::ALL.len()).prop_map(|i| Shape::ALL[i])
}

fn taken() -> impl Strategy<Value = Taken> {
    let samples = prop_oneof![Just(Samples::None), Just(Samples::Even), Just(Samples::Flood)];
    let command = prop_oneof![4 => Just(None), 2 => Just(Some(Order::Renew)), 1 => Just(Some(Order::Capture))];
    let after_us = prop_oneof![Just(66_667u64), Just(500_000), 1..8_000_000u64];
    (shape(), samples, after_us, command).prop_map(|(shape, samples, after_us, command)| Taken {
        shape,
        samples,
        after_us,
        command,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever shapes follow each other, every frame keeps its limit, and has an estimate or a reason.
    #[test]
    fn no_frame_spends_more_than_its_work(
        first in shape(),
        frames in proptest::collection::vec(taken(), 1..6),
        work in prop_oneof![Just(WORK_UNITS), 0..WORK_UNITS],
        is_refined: bool,
        is_calibrated: bool,
    ) {
        let texture = is_refined.then(adversarial::texture);
        let stream = if is_calibrated { adversarial::calibrated } else { adversarial::stream };
        let found = lines(&stream(first, &frames, texture.as_ref()), work);
        prop_assert_eq!(found.len(), frames.len() + 1);
        for line in found {
            prop_assert!(line.work <= work, "{:?}", line);
            prop_assert_eq!(line.reason.is_some(), line.status == Status::None);
            prop_assert_eq!(line.estimate.is_some(), matches!(line.status, Status::Estimate | Status::Late));
        }
    }
}

/// Returns the programs of `make arm` and the plugin that counts, or `None` if one of them or qemu is missing.
fn counting() -> Option<[PathBuf; 2]> {
    let target = Path::new(env!("CARGO_BIN_EXE_hoverlock-nav")).ancestors().nth(2)?;
    let nav = target.join("arm/armv7-unknown-linux-gnueabihf/release/hoverlock-nav");
    let plugin = ["release", "debug"].map(|profile| target.join(profile).join("libhoverlock_icount.so"));
    let plugin = plugin.into_iter().find(|path| path.is_file())?;
    let qemu = Command::new("qemu-arm").arg("--version").output().is_ok();
    (qemu && nav.is_file()).then_some([nav, plugin])
}

/// Counts the instructions of each frame of a stream on the ARM. The transfer of pixels, which lie in memory on a
/// board, is left out, and with it that of all messages of a stream that has them.
fn counted([nav, plugin]: &[PathBuf; 2], name: &str, source: &Source) -> Vec<u64> {
    let stream = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name).with_extension("hln");
    std::fs::write(&stream, source.messages.concat()).unwrap();
    let mut qemu = Command::new("qemu-arm");
    let output = qemu.args(["-cpu", "cortex-a9", "-plugin"]).arg(plugin).arg(nav).arg(&stream).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{name}: {text}");
    let counts = text.lines().filter_map(|line| line.strip_prefix("icount "));
    let parts = if support::has_pixels(source) { Part::Transfer as usize - 1 } else { Part::End as usize };
    counts.map(|line| line.split(' ').take(parts).map(|count| count.parse::<u64>().unwrap()).sum()).collect()
}

/// The shapes that were found to be expensive, and one stream drawn anew in each run.
#[test]
fn a_unit_is_no_more_instructions_than_it_says() {
    let Some(tools) = counting() else {
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED: a_unit_is_no_more_instructions_than_it_says: no ARM binary, plugin or qemu; run `make bench-arm`"
        );
        return;
    };
    let seed: u64 = rand::random();
    let mut streams = adversarial::worst();
    streams.push(("drawn", adversarial::drawn(seed)));
    let searched = adversarial::repeated(Shape::Ground, Samples::None, 8);
    streams.push(("calibrated", adversarial::calibrated(Shape::Ground, &searched, Some(&adversarial::texture()))));
    // Twelve thousand samples take most of a frame.
    let flood = Taken { shape: Shape::Empty, samples: Samples::Flood, after_us: 12_000_000, command: None };
    streams.push(("calibrated, flooded", adversarial::calibrated(Shape::Full, &[flood; 3], None)));
    for (name, source) in streams {
        let counts = counted(&tools, name, &source);
        let lines = lines(&source, WORK_UNITS);
        assert_eq!(counts.len(), lines.len(), "{name}: run `make arm` if the sources have changed since");
        for (count, line) in counts.into_iter().zip(lines) {
            let allowed = UNIT_INSTRUCTIONS * line.work + UNCOUNTED_INSTRUCTIONS;
            assert!(
                count <= allowed.min(MAX_FRAME_INSTRUCTIONS),
                "{name}, seed {seed}: {count} of {allowed}: {line:?}"
            );
        }
    }
}

/// Returns all constants of work units in a folder of sources, with their values.
fn work_constants(folder: &Path, found: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // The pose of two frames is fitted by `hoverlock match`, not in flight.
        if ["pose", "relief.rs"].iter().any(|name| path.ends_with(name)) {
            continue;
        }
        if path.is_dir() {
            work_constants(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            for line in std::fs::read_to_string(&path).unwrap().lines() {
                let Some((name, rest)) = line.split_once("const ").and_then(|(_, rest)| rest.split_once(": ")) else {
                    continue;
                };
                if let Some(value) = rest.split_once(" = ").and_then(|(_, value)| value.strip_suffix(';'))
                    && (name.ends_with("_WORK") || name.ends_with("_PER_UNIT"))
                {
                    let module = path.file_stem().unwrap().to_string_lossy();
                    let module = if module == "mod" {
                        path.parent().unwrap().file_name().unwrap().to_string_lossy()
                    } else {
                        module
                    };
                    found.insert(format!("{module}::{name}"), value.replace('_', ""));
                }
            }
        }
    }
}

/// The table of loops names every constant with its value, and no other.
#[test]
fn the_table_of_loops_has_the_constants_of_the_code() {
    let arm = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut constants = BTreeMap::new();
    for folder in ["src", "../reference/src/motion"] {
        work_constants(&arm.join(folder), &mut constants);
    }
    let text = std::fs::read_to_string(arm.join("WORST_CASE.md")).unwrap();
    let mut table = BTreeMap::new();
    for row in text.lines().filter(|line| line.starts_with('|')) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        if let [_, .., constant, value, _] = cells[..]
            && let Some(name) = constant.strip_prefix('`').and_then(|name| name.strip_suffix('`'))
            && name.contains("::")
        {
            table.insert(name.to_owned(), value.replace(' ', ""));
        }
    }
    assert_eq!(table, constants);
}
