//! Rare cases of the control logic from the ports; and each fault that only they or one scenario find, put into the
//! Verilog, is found by its own case.

mod corner;
mod port_bench;

use std::{fs, path::Path, sync::LazyLock};

use corner::CORNERS;
use hoverlock_design::KT27;
use hoverlock_rtl::emission::files;
use hoverlock_simulation::Simulator;
use port_bench::scenarios::SCENARIOS;

static SIMULATOR: LazyLock<Simulator> = LazyLock::new(|| Simulator::new().expect("Verilator builds the top"));

#[test]
fn rare_cases_are_exact() {
    let wrong: Vec<String> = CORNERS
        .iter()
        .filter_map(|(name, corner)| {
            let begin = std::time::Instant::now();
            let failure = corner(&SIMULATOR).err();
            eprintln!("{name}: {:.1} s", begin.elapsed().as_secs_f64());
            Some(format!("{name}: {}", failure?))
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// File, what stands there with the expression or the statements at fault in guillemets, what is put in its place, the
/// case that finds it.
const FAULTS: &[(&str, &str, &str, &str)] = &[
    ("sequencer", "skid_back <= «{end_of_packet, start_of_packet, data}»;", "{1'b0, start_of_packet, data}", "skid"),
    ("sequencer", "skid_front <= skid_count == 2'd2 ? «skid_back»", "{skid_back[17], 1'b0, skid_back[15:0]}", "skid"),
    (
        "sequencer",
        "wire stray   = «idle & not_empty & ~is_start»;",
        "idle & not_empty & ~is_start & ~drained",
        "strays",
    ),
    (
        "sequencer",
        "errors  <= {«((stray & ~ignoring) | refuse) & enable»",
        "(stray & ~ignoring) | (refuse & enable)",
        "strays",
    ),
    ("sequencer", "ignoring <= «~is_end»;", "1'b1", "strays"),
    ("sequencer", "wire steady  = «committed == committed_delayed»;", "1'b1", "commit"),
    ("hoverlock_core", ".load(«sequencer_capture & committed»)", "sequencer_capture", "commit"),
    ("csr", "wire disturbs = «write»", "1'b0", "commit"),
    ("csr", "width  = «commit_pending»", "1'b1", "commit"),
    ("csr", "height = «commit_pending»", "1'b1", "commit"),
    ("csr", "writedata[1] ^ «control_automatic»", "writedata[1]", "commit"),
    (
        "extractor",
        ".follow(«smoothers_window_bank[32'h160]»),\n  .manual(smoothers_window_bank[(32'h130)",
        "frame_bank[32'h160]",
        "banks",
    ),
    (
        "extractor",
        ".target(«smoothers_window_bank[(32'h150)+:(16)]»),\n  .threshold(controller_0",
        "frame_bank[(32'h150)+:(16)]",
        "banks",
    ),
    ("extractor", ".manual(«smoothers_window_bank[(32'h140)+:(15)]»)", "frame_bank[(32'h140)+:(15)]", "banks"),
    ("threshold", "less   <= «four_counts < three_targets»;", "four_counts <= three_targets", "met target"),
    ("threshold", "more   <= «four_counts > five_targets»;", "four_counts >= five_targets", "met target"),
    ("threshold", "count <= «count + 20'd1»;", "(count == 20'd1023 ? count : count + 20'd1)", "many features"),
    ("threshold", "wire [21:0] four_counts = «{count, 2'b00}»;", "{8'd0, count[11:0], 2'b00}", "many features"),
    ("threshold", "threshold <= «raised[15]» ?", "1'b0", "threshold limits"),
    ("threshold", "| «(lowered == 16'd0)»;", "1'b0", "threshold limits"),
    ("csr", "done & «(dropped != 20'd0)»", "(dropped[19:1] != 19'd0)", "one drop"),
    ("record_fifo", "room        <= «after < 10'd496»;", "after < 10'd495", "one drop"),
    ("record_fifo", "stall        <= «after >= 10'd509»;", "after >= 10'd508", "stop"),
    (
        "extractor",
        "assign saturated = («scale_pair_0_saturated | scale_pair_1_saturated»)",
        "scale_pair_0_saturated",
        "coarse",
    ),
    ("sequencer", "settle <= «2'd3»;", "2'd2", "latency"),
    ("sequencer", "settle <= «settle - 2'd1»;", "2'd0", "latency"),
    (
        "record_writer",
        "trailer <= «frame_end | (trailer & ~end_now)»;",
        "(frame_end & (frames != 32'd0)) | (trailer & ~end_now)",
        "latency",
    ),
    (
        "csr",
        "status_begun <= «(status_begun & ~(write & (address == 6'd4) & writedata[7])) \
         | (~clear_now & begun)»;",
        "(status_begun | (~clear_now & begun)) & ~(write & (address == 6'd4) & writedata[7])",
        "cleared",
    ),
    (
        "csr",
        "status_saturated <= «(status_saturated & ~(write & (address == 6'd4) & writedata[6])) \
         | (~clear_now & saturated)»;",
        "(status_saturated | (~clear_now & saturated)) & ~(write & (address == 6'd4) & writedata[6])",
        "cleared",
    ),
    (
        "csr",
        "status_refused <= «(status_refused & ~(write & (address == 6'd4) & writedata[4])) \
         | (~clear_now & errors[3])»;",
        "(status_refused | (~clear_now & errors[3])) & ~(write & (address == 6'd4) & writedata[4])",
        "cleared",
    ),
    (
        "csr",
        "status_interrupted <= «(status_interrupted & ~(write & (address == 6'd4) & writedata[3])) \
         | (~clear_now & errors[2])»;",
        "(status_interrupted | (~clear_now & errors[2])) & ~(write & (address == 6'd4) & writedata[3])",
        "cleared",
    ),
    (
        "csr",
        "status_long_frame <= «(status_long_frame & ~(write & (address == 6'd4) & writedata[2])) \
         | (~clear_now & errors[1])»;",
        "(status_long_frame | (~clear_now & errors[1])) & ~(write & (address == 6'd4) & writedata[2])",
        "cleared",
    ),
    (
        "csr",
        "status_short_frame <= «(status_short_frame & ~(write & (address == 6'd4) & writedata[1])) \
         | (~clear_now & errors[0])»;",
        "(status_short_frame | (~clear_now & errors[0])) & ~(write & (address == 6'd4) & writedata[1])",
        "cleared",
    ),
    (
        "csr",
        "status_frame <= «(status_frame & ~(write & (address == 6'd4) & writedata[0])) \
         | (~clear_now & done)»;",
        "(status_frame | (~clear_now & done)) & ~(write & (address == 6'd4) & writedata[0])",
        "cleared",
    ),
    (
        "csr",
        "writedata[5])) | («~clear_now & done»",
        "~clear_now & done & ~(write & (address == 6'd4) & writedata[5])",
        "cleared",
    ),
    ("address_counter", "if («{1'b0, address} > last»)", "1'b0", "narrower"),
    ("sequencer", "capture      = «begins & ~reset»;", "(begins | start) & ~reset", "standing start"),
    ("sequencer", "frames_left = frames - {2'd0, «kept_out»};", "kept_out & ~keep", "tags"),
    ("sequencer", "kept   <= («kept_out» ?", "kept_out & ~keep", "tags"),
    ("sequencer", "own_now} << («frames_left == 3'd1» ?", "frames == 3'd1", "tags"),
    ("sequencer", "wire short_frame = («begins & is_end»)", "1'b0", "faults"),
    ("csr", "(write & (address == 6'd12) & «writedata[0]»);", "1'b1", "registers"),
    ("csr", "dropped_count <= «dropped»;", "count", "one drop"),
    ("csr", "15'd0, «control_automatic», target_count", "1'b0", "automatic"),
    ("csr", "    «taken_width <= 11'd0;\n    taken_height <= 12'd0;»", "", "forgotten"),
    ("threshold", "follows   <= «1'b0»;", "follows", "forgotten"),
];

/// The emitted Verilog with all faults in it, each asleep until its `+FAULTn`.
fn faulty() -> Simulator {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("corners");
    fs::create_dir_all(&folder).unwrap();
    let mut sources = Vec::new();
    for emitted in files().unwrap() {
        let Some(name) = emitted.module() else { continue };
        let mut text = emitted.text.clone();
        for (at, (_, place, fault, _)) in FAULTS.iter().enumerate().filter(|(_, f)| format!("{}.v", f.0) == name) {
            let (before, rest) = place.split_once('«').unwrap();
            let (expression, after) = rest.split_once('»').unwrap();
            // A statement may carry several faults: each goes round the expression with the others in it.
            let whole = format!("{before}{expression}{after}");
            assert_eq!(text.matches(&whole).count(), 1, "{name}: `{whole}`");
            let either = if expression.ends_with(';') {
                format!("if (fault == 32'd{}) begin {fault} end else begin {expression} end", at + 1)
            } else {
                format!("(fault == 32'd{} ? {fault} : {expression})", at + 1)
            };
            text = text.replace(&whole, &format!("{before}{either}{after}"));
        }
        let body = text.find(");\n").unwrap() + 3;
        text.insert_str(body, "integer fault;\ninitial if ($value$plusargs(\"FAULT=%d\", fault) == 0) fault = 0;\n");
        let path = folder.join(name);
        if !fs::read_to_string(&path).is_ok_and(|there| there == text) {
            fs::write(&path, text).unwrap();
        }
        sources.push(path);
    }
    Simulator::of(&KT27, &sources).unwrap()
}

#[test]
fn each_fault_is_found_by_its_case() {
    let simulator = faulty();
    let mut wrong = Vec::new();
    for (at, (file, place, fault, name)) in FAULTS.iter().enumerate() {
        let (_, corner) = CORNERS.iter().chain(&SCENARIOS).find(|(this, _)| this == name).unwrap();
        let found = corner(&simulator.clone().with_plusargs(vec![format!("+FAULT={}", at + 1)])).err();
        eprintln!("{file}: `{place}` becomes `{fault}`: {name}: {found:?}");
        if found.as_ref().is_none_or(|failure| failure.stage == "bench") {
            wrong.push(format!("{file}: `{place}` as `{fault}`: {name}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
