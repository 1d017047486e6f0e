//! A fault put by hand into the emitted Verilog is named by its stage: one for each stage that a mismatch can name.

use std::{fs, path::Path};

use hoverlock_design::KT27;
use hoverlock_reference::image::plane::Plane;
use hoverlock_rtl::emission::files;
use hoverlock_simulation::{Job, Simulator, Streams, run};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A source that withdraws a record: `valid` falls while the sink is not ready, and nothing is lost.
const WITHDRAWN: &str = "core_feature_valid & (feature_ready | video_data[0])";

/// File, what stands there with the expression at fault in guillemets, what is put in its place, stage and field to be
/// named.
const FAULTS: [(&str, &str, &str, &str, &str); 13] = [
    ("column_memory", "column[1399:1274], «x_9»", "x_8", "smoother wide", "sample"),
    ("difference", "distance} + «19'd1»;", "19'd0", "DoG", "sign and response"),
    (
        "window_maximum",
        "larger <= «newest > oldest» ?",
        "SAMPLES == 5 ? newest < oldest : newest > oldest",
        "MaxDOG",
        "sign and maximum",
    ),
    ("decision", "(«p >= loose»)", "p <= loose", "decision", "feature"),
    ("record_writer", "1'b0, «neighbours[29:15]», 1'b0", "neighbours[44:30]", "record", "right neighbour"),
    (
        "ring_comparator",
        "«points[16 * i + 15]»;",
        "~points[16 * i + 15]",
        "descriptor",
        "sign 0, every ring point; sign 1, every ring point",
    ),
    ("record_writer", "12'd0, «dropped»,", "count", "trailer", "dropped"),
    ("record_fifo", "data <= «next»;", "{next[255:32], 32'd0}", "feature FIFO", "x; y"),
    ("csr", "features_count <= «count»;", "dropped", "registers", "features"),
    ("record_fifo", " valid <= «next_valid»;", "1'b0", "end of frame", "trailer"),
    ("record_fifo", "room        <= «after < 10'd496»;", "write_address[0]", "trailer", "dropped"),
    ("csr", "(~clear_now & «done & (dropped != 20'd0)»)", "done", "registers", "status"),
    ("hoverlock_top", "feature_valid = «core_feature_valid»;", WITHDRAWN, "feature stream", "rule"),
];

/// The emitted Verilog with all faults in it, each asleep until its `+FAULTnn`: an argument wakes every name that it
/// begins with.
fn simulator() -> Simulator {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("faults");
    fs::create_dir_all(&folder).unwrap();
    let mut sources = Vec::new();
    for emitted in files().unwrap() {
        let Some(name) = emitted.module() else { continue };
        let mut text = emitted.text.clone();
        for (at, (_, text_at, fault, ..)) in FAULTS.iter().enumerate().filter(|(_, f)| format!("{}.v", f.0) == name) {
            let (before, rest) = text_at.split_once('«').unwrap();
            let (expression, after) = rest.split_once('»').unwrap();
            let whole = format!("{before}{expression}{after}");
            assert_eq!(text.matches(&whole).count(), 1, "{name}: `{whole}`");
            let either = format!("($test$plusargs(\"FAULT{at:02}\") != 0 ? ({fault}) : {expression})");
            text = text.replace(&whole, &format!("{before}{either}{after}"));
        }
        let path = folder.join(name);
        if !fs::read_to_string(&path).is_ok_and(|there| there == text) {
            fs::write(&path, text).unwrap();
        }
        sources.push(path);
    }
    Simulator::of(&KT27, &sources).unwrap()
}

#[test]
fn each_fault_is_named_by_its_stage() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let pixels = Plane::from_fn(72, 66, |x, y| ((x * 311 + y * 173) % 30_000) as u16 + random.random_range(0..30_000));
    let jobs = vec![Job::new(pixels, [60, 45]).unwrap(); 2];
    let simulator = simulator();
    let first = |plusargs: Vec<String>, streams: Streams| {
        run(&simulator.clone().with_plusargs(plusargs), &jobs, streams).unwrap().first_mismatch
    };
    let flowing = Streams::default();
    // A beat waits only for a sink that pauses.
    let pausing = Streams { sink_pause: 0.8, ..flowing };
    assert_eq!([flowing, pausing].map(|streams| first(Vec::new(), streams)), [None, None]);
    let mut wrong = Vec::new();
    for (at, (file, text_at, fault, stage, field)) in FAULTS.into_iter().enumerate() {
        let streams = if stage == "feature stream" { pausing } else { flowing };
        let found = first(vec![format!("+FAULT{at:02}")], streams);
        eprintln!("{file}: `{text_at}` becomes `{fault}`: {found:#?}");
        if !found.as_ref().is_some_and(|found| found.stage.starts_with(stage) && found.field.starts_with(field)) {
            wrong.push(format!("{file}: {stage}, {field}, but {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
