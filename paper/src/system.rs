//! Figures 1 to 3, 12 and 13: what is connected to what, what flows, and the load that the FPGA takes from the
//! processor.

use hoverlock_design::KT27;
use hoverlock_edss::camera::{FIELD_OF_VIEW_RANGE_DEG, FRAME_RATE, FRAME_SIZE};
use hoverlock_fixed_point::analysis::resources::resources;
use serde_json::Value;

use crate::diagram::{Block, row};
use crate::{Item, PaperError};

/// Rate of the camera's link, MB/s.
const LINK_MB_S: f64 = 25.0;
/// Bytes of a sample, and of a record of two scale pairs.
const SAMPLE_BYTES: f64 = 2.0;
const RECORD_BYTES: f64 = 32.0;
/// Features that the automatic threshold aims at, of each scale pair.
const TARGET: f64 = 512.0;
/// Published factor by which the FPGA relieves the processor.
const PUBLISHED_RELIEF: f64 = 2.0;
/// The measured numbers of the project.
const RESULTS: &str = include_str!("../../docs/results.json");

fn block<'a>(name: &'a str, content: &[&str]) -> Block<'a> {
    Block { name, content: content.iter().map(|line| (*line).to_owned()).collect() }
}

/// Figures 1 to 3.
pub fn first() -> Vec<Item> {
    let rate = FRAME_SIZE.0 as f64 * FRAME_SIZE.1 as f64 * SAMPLE_BYTES * FRAME_RATE / 1e6;
    vec![
        Item {
            number: "figure 1",
            title: "Architecture of the system",
            stated: "A camera, an IMU and a laser rangefinder; a processing module; the control system of the \
                helicopter.",
            found: "The same parts here: camera, IMU and laser are simulated, the processing module is the Verilog \
                and the flight \
                    program, the control system is an autopilot that takes MAVLink."
                .into(),
            holds: None,
            evidence: "ARCHITECTURE.md",
            drawings: vec![row(
                "architecture of the system",
                &[
                    block("sensors", &["camera KT-27", "IMU", "laser rangefinder"]),
                    block("processing module", &["FPGA: features", "ARM: displacement"]),
                    block("control system", &["holds the place", "commands the camera"]),
                ],
                &[["frames, attitude", "range"], ["X_e, Y_e", "protection level"]],
            )],
            ..Item::default()
        },
        Item {
            number: "figure 2, table 1",
            title: "Camera KT-27",
            stated: "1024 x 768 pixels of 16 bits, zoom from 5.4 to 50 degrees, 15 frames a second, a link of 25 MB/s.",
            found: format!(
                "{} x {} pixels of {} bits, {} to {} degrees, {} frames a second: {rate:.1} MB/s, which the link \
                 carries.",
                FRAME_SIZE.0,
                FRAME_SIZE.1,
                KT27.pixel.bits(),
                FIELD_OF_VIEW_RANGE_DEG[0],
                FIELD_OF_VIEW_RANGE_DEG[1],
                FRAME_RATE
            ),
            holds: Some(rate <= LINK_MB_S),
            evidence: "designs/kt27.toml",
            drawings: Vec::new(),
            ..Item::default()
        },
        Item {
            number: "figure 3",
            title: "Processing module",
            stated: "The FPGA takes everything with a large flow of data; matching, RANSAC and decisions are the \
                processor's.",
            found: "The split is the same.".into(),
            holds: None,
            evidence: "arm/INTEGRATION.md",
            drawings: vec![row(
                "processing module",
                &[
                    block("acquisition", &["Avalon-ST, 16 bits", "FPGA"]),
                    block("features", &["smoothers, DoG", "7x7 maxima, MaxLBP", "FPGA"]),
                    block("motion", &["Hamming matching", "RANSAC", "ARM"]),
                    block("decision", &["filter with keyframes", "estimate or refusal", "ARM"]),
                ],
                &[["a pixel", "a clock"], ["records", ""], ["matches", ""]],
            )],
            ..Item::default()
        },
    ]
}

/// Figures 12 and 13.
pub fn second() -> Vec<Item> {
    let frames = FRAME_SIZE.0 as f64 * FRAME_SIZE.1 as f64 * SAMPLE_BYTES * FRAME_RATE / 1e6;
    let records = 2.0 * TARGET * RECORD_BYTES * FRAME_RATE / 1e6;
    let used = resources(&KT27);
    vec![
        Item {
            number: "figure 12",
            title: "Flow of data between camera, FPGA, memory and processor",
            stated: "Frames go through the FPGA; the processor reads features from memory.",
            found: format!(
                "{frames:.1} MB/s of pixels become {records:.2} MB/s of records at the target of {TARGET:.0} \
                 features a scale pair: {:.0} \
                 times less for the processor.",
                frames / records
            ),
            holds: None,
            evidence: "arm/INTEGRATION.md",
            drawings: vec![row(
                "flow of data",
                &[
                    block("camera", &["1024 x 768 x 15/s"]),
                    block("FPGA", &["one pixel a clock"]),
                    block("memory", &["ring of packets"]),
                    block("processor", &["one estimate a frame"]),
                ],
                &[
                    [&format!("{frames:.1} MB/s"), "pixels"],
                    [&format!("{records:.2} MB/s"), "records"],
                    ["packets", "interrupt"],
                ],
            )],
            ..Item::default()
        },
        Item {
            number: "figure 13",
            title: "FPGA and processor on the board",
            stated: "An Arria V and an ARM processor carry the method.",
            found: format!(
                "The default design by the formulas of its word lengths: about {} ALM, {} M10K, {} DSP blocks; the \
                 command below has the numbers of synthesis. On Arria V nothing has been placed and routed, and no \
                 board has been built.",
                used.alm, used.m10k, used.dsp
            ),
            holds: None,
            evidence: "hoverlock rtl estimate",
            drawings: vec![row(
                "board",
                &[
                    block(
                        "extractor",
                        &[&format!("{} ALM", used.alm), &format!("{} M10K", used.m10k), &format!("{} DSP", used.dsp)],
                    ),
                    block("DMA, bridge", &["packets to memory", "registers"]),
                    block("ARM", &["flight program", "MAVLink, ARINC 429"]),
                ],
                &[["Avalon-ST", "256 bits"], ["AXI", "interrupt"]],
            )],
            ..Item::default()
        },
    ]
}

/// The claim that the FPGA relieves the processor, from instructions that were counted on the ARM.
///
/// # Errors
/// `docs/results.json` lacks a count.
pub fn relief_of_the_processor() -> Result<Item, PaperError> {
    let results: Value = serde_json::from_str(RESULTS).unwrap_or_default();
    let count = |entry: &str, value: &str| {
        let found = results.pointer(&format!("/{entry}/{value}")).and_then(Value::as_f64);
        found.ok_or_else(|| PaperError::NoResult(entry.to_owned()))
    };
    let features = count("arm.extraction", "value")?;
    let motion = count("arm.instructions", "values/worst.all")?;
    let ratio = (features + motion) / motion;
    Ok(Item {
        number: "claim 2",
        title: "\u{201c}More than twice\u{201d}",
        stated: "The FPGA relieves the processor by more than twice.",
        found: format!(
            "Instructions of a frame on the ARM, in millions: features {features:.1}, matching and motion at most \
             {motion:.1}. \
             Without the FPGA {ratio:.1} times as much. Counted by the command below, not when this page was made."
        ),
        holds: Some(ratio > PUBLISHED_RELIEF),
        evidence: "make bench-arm",
        drawings: Vec::new(),
        ..Item::default()
    })
}
