//! Rare cases of the control logic from the ports; and each fault that only they or one scenario find, put into the
//! Verilog, is found by its own case.

mod corner;
mod port_bench;

use std::{fs, path::Path, sync::LazyLock};

use corner::CORNERS;
use hoverlock_design::{DesignPoint, KT27};
use hoverlock_rtl::emission::{File, files, files_of};
use hoverlock_simulation::Simulator;
use port_bench::{of_other_designs, scenarios::SCENARIOS};

static SIMULATOR: LazyLock<Simulator> = LazyLock::new(|| Simulator::new().expect("Verilator builds the top"));

/// Returns the cases that fail on a model.
fn failures(simulator: &Simulator) -> Vec<String> {
    CORNERS
        .iter()
        .filter_map(|(name, corner)| {
            let begin = std::time::Instant::now();
            let failure = corner(simulator).err();
            eprintln!("{name}: {:.1} s", begin.elapsed().as_secs_f64());
            Some(format!("{name}: {}", failure?))
        })
        .collect()
}

#[test]
fn rare_cases_are_exact() {
    assert_eq!(failures(&SIMULATOR), [""; 0]);
}

#[test]
fn rare_cases_of_the_other_shipped_designs_are_exact() {
    assert_eq!(of_other_designs(failures), [""; 0]);
}

/// File, what stands there with the expression or the statements at fault in guillemets, what is put in its place, the
/// case that finds it.
type Fault = (&'static str, &'static str, &'static str, &'static str);

/// Faults of the default design.
const FAULTS: &[Fault] = &[
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
    ("sequencer", "state    <= IDLE;\n    ignoring <= «1'b0»;", "ignoring", "strays"),
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
    ("threshold", "«(eight_counts >= {4'd0, least})»", "(eight_counts > {4'd0, least})", "met target"),
    ("threshold", "«(eight_counts <= {3'd0, most})»", "(eight_counts < {3'd0, most})", "met target"),
    ("threshold", "count <= «count + 20'd1»;", "(count == 20'd1023 ? count : count + 20'd1)", "many features"),
    ("threshold", "wire [22:0] eight_counts = «{count, 3'd0}»;", "{8'd0, count[11:0], 3'd0}", "many features"),
    ("threshold", "summing_1 ? «16'd0» :", "word", "threshold limits"),
    ("threshold", "enters ? «7'd79» :", "7'd78", "threshold limits"),
    ("threshold", "(summing & «(bin != 7'd0)»)", "(bin != 7'd1)", "threshold limits"),
    ("threshold", "maximum & «(centre[14:5] != 10'd0)»", "1'b1", "threshold limits"),
    ("threshold", "reached ? from_bins : «15'd32»;", "15'd1", "threshold limits"),
    ("threshold", "«{sum, 3'd0} < {5'd0, target}»", "{sum, 3'd0} <= {5'd0, target}", "threshold limits"),
    ("csr", "done & «(dropped != 20'd0)»", "(dropped[19:1] != 19'd0)", "one drop"),
    ("record_fifo", "room        <= «after < 10'd496»;", "after < 10'd495", "one drop"),
    ("record_fifo", "stall        <= «after >= 10'd509»;", "after >= 10'd508", "stop"),
    (
        "extractor",
        "assign saturated = («scale_pair_0_saturated | scale_pair_1_saturated»)",
        "scale_pair_0_saturated",
        "cut",
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
        "status_begun <= «(status_begun & ~(write & (address == AT_STATUS) & writedata[7]))\n      \
         | (~clear_now & begun)»;",
        "(status_begun | (~clear_now & begun)) & ~(write & (address == AT_STATUS) & writedata[7])",
        "cleared",
    ),
    (
        "csr",
        "status_saturated <= «(status_saturated & ~(write & (address == AT_STATUS) & writedata[6]))\n      \
         | (~clear_now & saturated)»;",
        "(status_saturated | (~clear_now & saturated)) & ~(write & (address == AT_STATUS) & writedata[6])",
        "cleared",
    ),
    (
        "csr",
        "status_refused <= «(status_refused & ~(write & (address == AT_STATUS) & writedata[4]))\n      \
         | (~clear_now & errors[3])»;",
        "(status_refused | (~clear_now & errors[3])) & ~(write & (address == AT_STATUS) & writedata[4])",
        "cleared",
    ),
    (
        "csr",
        "status_interrupted <= «(status_interrupted & ~(write & (address == AT_STATUS) & writedata[3]))\n      \
         | (~clear_now & errors[2])»;",
        "(status_interrupted | (~clear_now & errors[2])) & ~(write & (address == AT_STATUS) & writedata[3])",
        "cleared",
    ),
    (
        "csr",
        "status_long_frame <= «(status_long_frame & ~(write & (address == AT_STATUS) & writedata[2]))\n      \
         | (~clear_now & errors[1])»;",
        "(status_long_frame | (~clear_now & errors[1])) & ~(write & (address == AT_STATUS) & writedata[2])",
        "cleared",
    ),
    (
        "csr",
        "status_short_frame <= «(status_short_frame & ~(write & (address == AT_STATUS) & writedata[1]))\n      \
         | (~clear_now & errors[0])»;",
        "(status_short_frame | (~clear_now & errors[0])) & ~(write & (address == AT_STATUS) & writedata[1])",
        "cleared",
    ),
    (
        "csr",
        "status_frame <= «(status_frame & ~(write & (address == AT_STATUS) & writedata[0]))\n      \
         | (~clear_now & done)»;",
        "(status_frame | (~clear_now & done)) & ~(write & (address == AT_STATUS) & writedata[0])",
        "cleared",
    ),
    (
        "csr",
        "writedata[5]))\n      | («~clear_now & done»",
        "~clear_now & done & ~(write & (address == AT_STATUS) & writedata[5])",
        "cleared",
    ),
    ("address_counter", "if («{1'b0, address} > last»)", "1'b0", "narrower"),
    ("sequencer", "capture      = «begins & ~reset»;", "(begins | start) & ~reset", "standing start"),
    ("sequencer", "frames_left = frames - {2'd0, «kept_out»};", "kept_out & ~keep", "tags"),
    ("sequencer", "kept   <= («kept_out» ?", "kept_out & ~keep", "tags"),
    ("sequencer", "own_now} << («frames_left == 3'd1» ?", "frames == 3'd1", "tags"),
    ("sequencer", "wire short_frame = («begins & is_end»)", "1'b0", "faults"),
    ("csr", "(write & (address == AT_COMMIT) & «writedata[0]»);", "1'b1", "registers"),
    ("csr", "dropped_count <= «dropped»;", "count", "one drop"),
    ("csr", "15'd0, «control_automatic», target_count", "1'b0", "automatic"),
    ("csr", "    «taken_width <= 11'd0;\n    taken_height <= 12'd0;»", "", "forgotten"),
    ("threshold", "follows   <= «1'b0»;", "follows", "forgotten"),
];

/// Faults of a design of three scale pairs, most of them in what the third pair has of its own.
const FAULTS_OF_THREE_SCALES: &[Fault] = &[
    (
        "extractor",
        "assign saturated = («scale_pair_0_saturated | scale_pair_1_saturated | scale_pair_2_saturated»)",
        "scale_pair_0_saturated | scale_pair_1_saturated",
        "cut",
    ),
    (
        "extractor",
        "assign saturated = («scale_pair_0_saturated | scale_pair_1_saturated | scale_pair_2_saturated»)",
        "scale_pair_1_saturated | scale_pair_2_saturated",
        "cut",
    ),
    (
        "extractor",
        ".threshold(«controller_2_threshold»),\n  .maximum(decision_2_maximum)",
        "controller_1_threshold",
        "frames",
    ),
    (
        "extractor",
        ".follow(«smoothers_window_bank[32'h1c0]»),\n  .manual(smoothers_window_bank[(32'h1a0)",
        "frame_bank[32'h1c0]",
        "banks",
    ),
    ("extractor", ".manual(«smoothers_window_bank[(32'h1a0)+:(14)]»)", "frame_bank[(32'h1a0)+:(14)]", "banks"),
    (
        "extractor",
        ".target(«smoothers_window_bank[(32'h1b0)+:(16)]»),\n  .threshold(controller_2",
        "frame_bank[(32'h1b0)+:(16)]",
        "banks",
    ),
    ("extractor", ".threshold_2(«controller_2_threshold»),\n  .hit_0", "controller_1_threshold", "ceiling"),
    ("extractor", ".hit_2(«decision_2_hit»),\n  .p_0", "decision_1_hit", "frames"),
    ("extractor", ".p_2(«scale_pair_2_p[(32'h0)+:(14)]»),\n  .keep_0", "scale_pair_1_p[(32'h0)+:(14)]", "ceiling"),
    ("extractor", ".hit_2(«record_limit_keep_2»)", "decision_2_hit", "ceiling"),
    ("extractor", ".sign_2(«ring_2_sign»),\n  .lost", "ring_1_sign", "frames"),
    ("extractor", ".threshold_2(«controller_2_threshold»),\n  .room", "controller_1_threshold", "frames"),
    ("csr", "threshold_2_coarsest <= «14'd1024»;", "14'd1023", "registers"),
    ("csr", "threshold_2_coarsest <= «writedata[13:0]»;", "{1'b0, writedata[12:0]}", "registers"),
    ("csr", "AT_THRESHOLD_2: readdata <= {18'd0, «threshold_2_coarsest»};", "threshold_coarse", "registers"),
    ("csr", "AT_THRESHOLD_NOW_2: readdata <= {18'd0, «threshold_now_2_coarsest»};", "14'd0", "status"),
    ("csr", "control_automatic, target_count,\n            2'd0, «threshold_2_coarsest»", "threshold_coarse", "frames"),
    ("csr", "| («address == AT_THRESHOLD_2»)\n  | (address == AT_RECORD_LIMIT)", "1'b0", "commit"),
    ("csr", "(address >= AT_NARROW_G) & («address <= AT_WIDEST_G5»)", "address <= AT_WIDEST_G4", "commit"),
    ("csr", "            «widest_g5_value»,\n            widest_g4_value,", "widest_g4_value", "frames"),
    ("csr", "widest_g_value <= «16'd11450»;", "16'd11451", "registers"),
    ("csr", "dropped_count <= «dropped»;", "count", "one drop"),
    (
        "csr",
        "status_refused <= «(status_refused & ~(write & (address == AT_STATUS) & writedata[4]))\n      \
         | (~clear_now & errors[3])»;",
        "(~clear_now & errors[3])",
        "strays",
    ),
    ("sequencer", "errors  <= {«((stray & ~ignoring) | refuse) & enable»", "1'b0", "strays"),
    ("hoverlock_top", ".threshold_2(«core_threshold_2»)\n);\n\nhoverlock_core core (", "core_threshold_1", "status"),
    ("record_fifo", "stall        <= «after >= 10'd509»;", "after >= 10'd508", "stop"),
    ("record_fifo", "stall        <= «after >= 10'd509»;", "after >= 10'd510", "stop"),
    ("record_fifo", "stall        <= «after >= 10'd509»;", "1'b0", "overflow"),
    ("record_fifo", "room        <= «after < 10'd496»;", "after < 10'd497", "one drop"),
    ("candidate_queue", "{1'b0, word[21]} + {1'b0, word[22]} + «{1'b0, word[23]}» : 2'd0;", "2'd0", "full queue"),
    ("candidate_queue", "(word[21] | word[22] | «word[23]»)", "1'b0", "frames"),
    ("record_writer", "2'd0, «thresholds[41:28]», 2'd0", "thresholds[27:14]", "frames"),
    ("record_writer", "response = {13'd0, «third», centre[14]", "1'b0", "frames"),
    ("record_writer", "hits[1] ? {«hits[2]», 2'd0} : 3'd0;", "1'b0", "frames"),
    ("record_writer", "count, «16'h9000», 12'd0", "16'h8000", "frames"),
    ("record_limit", "hits = {1'b0, hit_0} + {1'b0, hit_1} + «{1'b0, hit_2}»;", "2'd0", "ceiling"),
    ("record_limit", "gate_2 <= «higher_2»;", "gate_2", "ceiling"),
    ("record_limit", "was_raised <= «passing != keeping»;", "1'b0", "ceiling"),
    ("record_limit", "reached_higher_2 <= p_2 >= «higher_2»;", "gate_2", "ceiling"),
    ("record_limit", "gate_2 <= «lowered_2 > threshold_2 ? lowered_2 : threshold_2»;", "threshold_2", "ceiling"),
    ("address_counter", "if («{1'b0, address} > last»)", "1'b0", "narrower"),
];

/// The Verilog of a design with all faults in it, each asleep until its `+FAULTn`.
fn faulty(design: &DesignPoint, emitted: &[File], faults: &[Fault]) -> Simulator {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("corners-{}", design.pairs()));
    fs::create_dir_all(&folder).unwrap();
    let mut sources = Vec::new();
    for emitted in emitted {
        let Some(name) = emitted.module() else { continue };
        let mut text = emitted.text.clone();
        let here = || faults.iter().enumerate().filter(|(_, fault)| format!("{}.v", fault.0) == name);
        for (at, (_, place, fault, _)) in here() {
            let (before, rest) = place.split_once('«').unwrap();
            let (expression, after) = rest.split_once('»').unwrap();
            // A statement may carry several faults: each goes round the expression with the others in it. Those of one
            // expression are put in with the first of them.
            let whole = format!("{before}{expression}{after}");
            let of_place: Vec<_> = here().filter(|(_, other)| other.1 == *place).collect();
            if of_place[0].0 != at {
                continue;
            }
            assert_eq!(text.matches(&whole).count(), 1, "{name}: `{whole}`");
            let either = if expression.ends_with(';') {
                format!("if (fault == 32'd{}) begin {fault} end else begin {expression} end", at + 1)
            } else {
                let asleep = |(at, fault): &(usize, &Fault)| format!("fault == 32'd{} ? {} : ", at + 1, fault.2);
                format!("({}{expression})", of_place.iter().map(asleep).collect::<String>())
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
    Simulator::of(design, &sources).unwrap()
}

/// Fails where a fault is not found by its case.
fn each_is_found(simulator: &Simulator, faults: &[Fault]) {
    let mut wrong = Vec::new();
    for (at, (file, place, fault, name)) in faults.iter().enumerate() {
        let (_, corner) = CORNERS.iter().chain(&SCENARIOS).find(|(this, _)| this == name).unwrap();
        let found = corner(&simulator.clone().with_plusargs(vec![format!("+FAULT={}", at + 1)])).err();
        eprintln!("{file}: `{place}` becomes `{fault}`: {name}: {found:?}");
        if found.as_ref().is_none_or(|failure| failure.stage == "bench") {
            wrong.push(format!("{file}: `{place}` as `{fault}`: {name}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn each_fault_is_found_by_its_case() {
    each_is_found(&faulty(&KT27, &files().unwrap(), FAULTS), FAULTS);
}

#[test]
fn each_fault_of_three_scale_pairs_is_found_by_its_case() {
    let design = DesignPoint::shipped("three_scales").unwrap();
    let emitted = files_of(&design).unwrap();
    each_is_found(&faulty(&design, &emitted, FAULTS_OF_THREE_SCALES), FAULTS_OF_THREE_SCALES);
}
