//! Waves of a run: a window of clock cycles as FST or VCD, and GTKWave's view of it.
//!
//! All cycles of a real frame would be gigabytes, so a window is recorded: by default around the first mismatch, or
//! else the first feature at the output. A run is repeatable bit for bit under one seed, so it runs twice: once to find
//! that cycle and again up to the end of the window. The view file groups the signals along the pipeline, with samples
//! in DN and the fields of the record by name. Its marker is at that cycle.

use std::{fmt::Write as _, path::Path};

use hoverlock_harness::{Time, build::Trace, model::Model};

use super::{Job, Outcome, SimulationError, Simulator, Streams, bench::RESET_CYCLES, record_window};

/// Nanoseconds of a clock cycle: 100 MHz.
pub(super) const PERIOD: u64 = 10;

/// Cycles before the window's middle, as a share of four.
const BEFORE: u64 = 3;

/// The cycles that are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// The first.
    pub from: u64,
    /// How many.
    pub cycles: u64,
    /// The cycle that the view is centred on.
    pub focus: u64,
}

impl Window {
    /// So many cycles, three quarters of them before the first mismatch of a run, or else before its first feature.
    pub fn around(outcome: &Outcome, cycles: u64) -> Self {
        let mismatch = outcome.first_mismatch.as_ref().map(|mismatch| mismatch.cycle);
        let focus = mismatch.or(outcome.first_feature).unwrap_or_default();
        Self { from: focus.saturating_sub(cycles / 4 * BEFORE), cycles, focus }
    }
}

/// Runs frames again, as far as the window goes, and writes its waves; the simulator must be [`Simulator::traced`].
///
/// # Errors
/// Where the file cannot be written, or waves are not built in.
pub fn record(
    simulator: &Simulator,
    jobs: &[Job],
    streams: Streams,
    window: Window,
    path: &Path,
) -> Result<(), SimulationError> {
    record_window(simulator, jobs, streams, Recorder { window, path })
}

/// Writes the waves while the bench runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Recorder<'a> {
    window: Window,
    path: &'a Path,
}

impl Recorder<'_> {
    pub fn open(&self, model: &mut Model) -> Result<(), SimulationError> {
        Ok(model.trace_open(self.path, 0, "")?)
    }

    /// A cycle, counted from the run's first, resets included, is in the window.
    pub fn wants(&self, cycle: u64) -> bool {
        let from = if self.window.from == 0 { 0 } else { self.window.from + RESET_CYCLES };
        (from..self.end()).contains(&cycle)
    }

    fn end(&self) -> u64 {
        (self.window.from + RESET_CYCLES).saturating_add(self.window.cycles)
    }

    /// The window is complete.
    pub fn is_past(&self, cycle: u64) -> bool {
        cycle >= self.end()
    }
}

/// The time of a clock edge: a cycle begins with the falling one, where inputs change, and half a period later comes
/// the rising one.
pub(super) fn time(cycle: u64, rising: bool) -> Time {
    Time::ns(cycle * PERIOD + if rising { PERIOD / 2 } else { 0 })
}

/// Format of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Bit,
    Hex,
    Decimal,
    /// DN with this many fraction bits.
    Dn(u32),
    /// DN as an analogue curve.
    Curve(u32),
}

/// A signal of the view: path below the top, bits, label, form.
type Shown = (&'static str, u32, &'static str, Form);

use Form::{Bit, Curve, Decimal, Dn, Hex};

/// The groups of the view, along the pipeline, and which of them are open at first.
const GROUPS: [(&str, bool, &[Shown]); 13] = [
    ("clock and reset", true, &[("clock", 1, "clock", Bit), ("reset", 1, "reset", Bit), ("irq", 1, "irq", Bit)]),
    (
        "video in",
        true,
        &[
            ("video_valid", 1, "valid", Bit),
            ("video_ready", 1, "ready", Bit),
            ("video_startofpacket", 1, "startofpacket", Bit),
            ("video_endofpacket", 1, "endofpacket", Bit),
            ("video_data", 16, "data", Hex),
            ("video_data", 16, "data, DN", Curve(0)),
        ],
    ),
    (
        "registers",
        false,
        &[
            ("csr_address", 6, "word address", Hex),
            ("csr_write", 1, "write", Bit),
            ("csr_writedata", 32, "writedata", Hex),
            ("csr_read", 1, "read", Bit),
            ("csr_readdata", 32, "readdata", Hex),
            ("registers.control_enable", 1, "control.enable", Bit),
            ("registers.control_automatic", 1, "control.automatic", Bit),
            ("registers.size_width", 11, "size.width", Decimal),
            ("registers.size_height", 12, "size.height", Decimal),
            ("core.threshold_0", 15, "T 0 in use, DN", Dn(1)),
            ("core.threshold_1", 15, "T 1 in use, DN", Dn(1)),
            ("core.begun", 1, "frame begun", Bit),
            ("core.done", 1, "frame done", Bit),
            ("core.errors", 4, "errors now", Hex),
            ("core.frames", 32, "frames", Decimal),
        ],
    ),
    (
        "sequencer",
        false,
        &[
            ("core.sequencer.state", 2, "state: idle, frame, pad", Decimal),
            ("core.sequencer.x", 10, "x", Decimal),
            ("core.sequencer.y", 11, "y", Decimal),
            ("core.sequencer.capture", 1, "registers captured", Bit),
            ("core.sequencer.advance", 1, "step (advance)", Bit),
            ("core.sequencer.start", 1, "start of frame", Bit),
            ("core.sequencer.pixel", 16, "pixel", Hex),
            ("core.sequencer.drain", 17, "steps left to drain", Decimal),
            ("core.sequencer.stall", 1, "stall by the FIFO", Bit),
        ],
    ),
    (
        "smoother narrow, sigma 2.0",
        false,
        &[
            ("core.extractor.smoothers.narrow_smoother.start", 1, "start", Bit),
            ("core.extractor.smoothers.narrow_smoother.x", 18, "in, DN", Dn(2)),
            ("core.extractor.smoothers.narrow_smoother.recursion_y", 18, "recursion, DN", Dn(2)),
            ("core.extractor.smoothers.narrow_smoother.tail_outside", 6, "stages that use the held row", Hex),
            ("core.extractor.smoothers.narrow_smoother.column_look_ahead_4_y", 18, "column_look_ahead done, DN", Dn(2)),
            ("core.extractor.smoothers.narrow_smoother.row_cursor_x", 10, "row stages x", Decimal),
            ("core.extractor.smoothers.narrow_smoother.row_cursor_y", 11, "row stages y", Decimal),
            ("core.extractor.smoothers.narrow_smoother.row_look_back_4_y", 18, "row_look_back done, DN", Dn(2)),
            ("core.extractor.smoothers.narrow_smoother.row_look_ahead_4_y", 18, "row_look_ahead done, DN", Dn(2)),
        ],
    ),
    (
        "smoother middle, sigma 3.2",
        false,
        &[
            ("core.extractor.smoothers.middle_smoother.start", 1, "start", Bit),
            ("core.extractor.smoothers.middle_smoother.x", 18, "in, DN", Dn(2)),
            ("core.extractor.smoothers.middle_smoother.recursion_y", 18, "recursion, DN", Dn(2)),
            ("core.extractor.smoothers.middle_smoother.tail_outside", 6, "stages that use the held row", Hex),
            ("core.extractor.smoothers.middle_smoother.column_look_ahead_4_y", 18, "column_look_ahead done, DN", Dn(2)),
            ("core.extractor.smoothers.middle_smoother.row_cursor_x", 10, "row stages x", Decimal),
            ("core.extractor.smoothers.middle_smoother.row_cursor_y", 11, "row stages y", Decimal),
            ("core.extractor.smoothers.middle_smoother.row_look_back_4_y", 18, "row_look_back done, DN", Dn(2)),
            ("core.extractor.smoothers.middle_smoother.row_look_ahead_4_y", 18, "row_look_ahead done, DN", Dn(2)),
        ],
    ),
    (
        "smoother wide, sigma 5.12",
        false,
        &[
            ("core.extractor.smoothers.wide_smoother.start", 1, "start", Bit),
            ("core.extractor.smoothers.wide_smoother.x", 18, "in, DN", Dn(2)),
            ("core.extractor.smoothers.wide_smoother.recursion_y", 18, "recursion, DN", Dn(2)),
            ("core.extractor.smoothers.wide_smoother.tail_outside", 6, "stages that use the held row", Hex),
            ("core.extractor.smoothers.wide_smoother.column_look_ahead_5_y", 18, "column_look_ahead done, DN", Dn(2)),
            ("core.extractor.smoothers.wide_smoother.row_cursor_x", 10, "row stages x", Decimal),
            ("core.extractor.smoothers.wide_smoother.row_cursor_y", 11, "row stages y", Decimal),
            ("core.extractor.smoothers.wide_smoother.row_look_back_5_y", 18, "row_look_back done, DN", Dn(2)),
            ("core.extractor.smoothers.wide_smoother.row_look_ahead_5_y", 18, "row_look_ahead done, DN", Dn(2)),
        ],
    ),
    (
        "smoothed, aligned",
        true,
        &[
            ("core.extractor.smoothers.start_out", 1, "start of frame", Bit),
            ("core.extractor.smoothers.narrow", 18, "narrow, DN", Dn(2)),
            ("core.extractor.smoothers.narrow", 18, "narrow", Curve(2)),
            ("core.extractor.smoothers.middle", 18, "middle, DN", Dn(2)),
            ("core.extractor.smoothers.wide", 18, "wide, DN", Dn(2)),
        ],
    ),
    (
        "DoG",
        true,
        &[
            ("core.extractor.response_cursor.x", 10, "x", Decimal),
            ("core.extractor.response_cursor.y", 11, "y", Decimal),
            ("core.extractor.scale_pair_0.difference_positive", 1, "pair 0 bright", Bit),
            ("core.extractor.scale_pair_0.difference_magnitude", 15, "pair 0, DN", Dn(1)),
            ("core.extractor.scale_pair_0.difference_magnitude", 15, "pair 0", Curve(1)),
            ("core.extractor.scale_pair_1.difference_positive", 1, "pair 1 bright", Bit),
            ("core.extractor.scale_pair_1.difference_magnitude", 15, "pair 1, DN", Dn(1)),
            ("core.extractor.scale_pair_1.difference_magnitude", 15, "pair 1", Curve(1)),
        ],
    ),
    (
        "maxima",
        true,
        &[
            ("core.extractor.window_cursor.x", 10, "x", Decimal),
            ("core.extractor.window_cursor.y", 11, "y", Decimal),
            ("core.extractor.eligible.eligible", 1, "eligible", Bit),
            ("core.extractor.decision_0.p", 15, "pair 0 centre, DN", Dn(1)),
            ("core.extractor.decision_0.strict", 15, "pair 0 earlier maximum, DN", Dn(1)),
            ("core.extractor.decision_0.loose", 15, "pair 0 later maximum, DN", Dn(1)),
            ("core.extractor.decision_0.threshold", 15, "pair 0 T, DN", Dn(1)),
            ("core.extractor.decision_0.hit", 1, "pair 0 feature", Bit),
            ("core.extractor.decision_1.p", 15, "pair 1 centre, DN", Dn(1)),
            ("core.extractor.decision_1.strict", 15, "pair 1 earlier maximum, DN", Dn(1)),
            ("core.extractor.decision_1.loose", 15, "pair 1 later maximum, DN", Dn(1)),
            ("core.extractor.decision_1.threshold", 15, "pair 1 T, DN", Dn(1)),
            ("core.extractor.decision_1.hit", 1, "pair 1 feature", Bit),
        ],
    ),
    (
        "ring and descriptor",
        false,
        &[
            ("core.extractor.scale_pair_0.max_dog_y", 15, "MaxDOG 0, DN", Dn(1)),
            ("core.extractor.scale_pair_1.max_dog_y", 15, "MaxDOG 1, DN", Dn(1)),
            ("core.extractor.ring_cursor.x", 10, "x", Decimal),
            ("core.extractor.ring_cursor.y", 11, "y", Decimal),
            ("core.extractor.queue.waiting", 10, "candidates waiting", Decimal),
            ("core.extractor.queue.found", 1, "ring complete", Bit),
            ("core.extractor.ring_0.maxlbp", 32, "MaxLBP 0", Hex),
            ("core.extractor.ring_1.maxlbp", 32, "MaxLBP 1", Hex),
            ("core.extractor.ring_0.sign", 32, "sign 0", Hex),
            ("core.extractor.ring_1.sign", 32, "sign 1", Hex),
        ],
    ),
    (
        "record",
        false,
        &[
            ("core.extractor.write", 1, "write", Bit),
            ("core.extractor.room", 1, "FIFO has room", Bit),
            ("core.fifo.waiting", 10, "records in the FIFO", Decimal),
            ("core.extractor.count", 20, "features of the frame", Decimal),
            ("core.extractor.dropped", 20, "dropped of the frame", Decimal),
        ],
    ),
    (
        "feature out",
        true,
        &[
            ("feature_valid", 1, "valid", Bit),
            ("feature_ready", 1, "ready", Bit),
            ("feature_startofpacket", 1, "startofpacket", Bit),
            ("feature_endofpacket", 1, "endofpacket", Bit),
        ],
    ),
];

/// The fields of a record: lowest bit, bits, name, form.
const FIELDS: [(u32, u32, &str, Form); 13] = [
    (0, 16, "x", Decimal),
    (16, 16, "y", Decimal),
    (32, 16, "response, DN", Dn(1)),
    (48, 1, "scale pair", Bit),
    (49, 1, "bright", Bit),
    (63, 1, "trailer", Bit),
    (64, 16, "left, DN", Dn(1)),
    (80, 16, "right, DN", Dn(1)),
    (96, 16, "upper, DN", Dn(1)),
    (112, 16, "lower, DN", Dn(1)),
    (128, 64, "MaxLBP 1, 0", Hex),
    (192, 64, "sign 1, 0", Hex),
    (0, 256, "record", Hex),
];

/// Bits of the record, whose fields are the last group's.
const RECORD: (&str, u32) = ("feature_data", 256);

/// Every signal the view shows, by its path in the wave file, with its bits.
pub fn signals() -> Vec<(String, u32)> {
    let shown = GROUPS.iter().flat_map(|(_, _, signals)| signals.iter().map(|(path, bits, ..)| (*path, *bits)));
    let mut all: Vec<_> = shown.chain([RECORD]).map(|(path, bits)| (full(path), bits)).collect();
    all.sort();
    all.dedup();
    all
}

fn full(path: &str) -> String {
    format!("TOP.hoverlock_top.{path}")
}

/// GTKWave's flags.
mod flag {
    pub const HEX: u32 = 0x2;
    pub const DECIMAL: u32 = 0x4;
    pub const BINARY: u32 = 0x8;
    pub const RIGHT: u32 = 0x20;
    pub const BLANK: u32 = 0x200;
    pub const STEPS: u32 = 0x8000;
    pub const STRETCH: u32 = 0x2_0000;
    pub const CLOSED: u32 = 0x40_0000;
    pub const GROUP_BEGIN: u32 = 0x80_0000;
    pub const GROUP_END: u32 = 0x100_0000;
    pub const FIXED_POINT: u32 = 0x4000_0000;
}

/// Additional rows of a curve.
const CURVE_ROWS: usize = 2;

/// GTKWave's view of a wave file: `hoverlock sim` writes it beside the file.
pub fn view(wave: &Path, window: Window) -> String {
    let name = wave.file_name().unwrap_or_default().to_string_lossy();
    // The values before the rising edge are those that count in a cycle.
    let at = |cycle: u64| time(cycle + RESET_CYCLES, false).as_fs() / 1000;
    // Some forty cycles on a screen (2^16 ps for 200 pixels), the focus a third from its left.
    let start = at(window.focus.saturating_sub(13).max(window.from));
    let mut text = format!(
        "[dumpfile] \"{name}\"\n[timestart] {start}\n[size] 1600 1000\n[pos] -1 -1\n\
         *-16.000000 {focus}{unused}\n[sst_expanded] 0\n[signals_width] 330\n",
        focus = at(window.focus),
        unused = " -1".repeat(26),
    );
    for (group, open, signals) in GROUPS {
        let closed = if open { 0 } else { flag::CLOSED };
        let record = group == "feature out";
        let mut line = |text_of: std::fmt::Arguments<'_>| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{text_of}");
        };
        line(format_args!("@{:x}\n-{group}", flag::GROUP_BEGIN | flag::BLANK | closed));
        for (path, bits, alias, form) in signals {
            let range = if *bits > 1 { format!("[{}:0]", bits - 1) } else { String::new() };
            shown(&mut line, &format!("+{{{alias}}} {}{range}", full(path)), *form);
        }
        for (low, bits, alias, form) in FIELDS.iter().filter(|_| record) {
            let (path, width) = RECORD;
            let signal = format!("{}[{}:0]", full(path), width - 1);
            let bit = |bit: u32| format!("({}){signal}", width - 1 - bit);
            let text = match *bits {
                1 => format!("+{{{alias}}} {}", bit(*low)),
                all if all == width => format!("+{{{alias}}} {signal}"),
                _ => {
                    let bits: Vec<_> = (*low..low + bits).rev().map(bit).collect();
                    format!("#{{{alias}}} {}", bits.join(" "))
                }
            };
            shown(&mut line, &text, *form);
        }
        line(format_args!("@{:x}\n-{group}", flag::GROUP_END | flag::BLANK | closed));
    }
    text
}

/// A signal with its form.
fn shown(line: &mut impl FnMut(std::fmt::Arguments<'_>), signal: &str, form: Form) {
    let fraction = |bits: u32| if bits > 0 { flag::FIXED_POINT } else { 0 };
    let (flags, shift) = match form {
        Form::Bit => (flag::BINARY | flag::RIGHT, 0),
        Form::Hex => (flag::HEX | flag::RIGHT, 0),
        Form::Decimal => (flag::DECIMAL | flag::RIGHT, 0),
        Form::Dn(bits) => (flag::DECIMAL | flag::RIGHT | fraction(bits), bits),
        Form::Curve(bits) => (flag::DECIMAL | flag::RIGHT | flag::STEPS | fraction(bits), bits),
    };
    line(format_args!("@{flags:x}"));
    if shift > 0 {
        line(format_args!("[fpshift_count] {shift}"));
    }
    line(format_args!("{signal}"));
    if matches!(form, Form::Curve(_)) {
        line(format_args!("@{:x}", flag::STRETCH));
        (0..CURVE_ROWS).for_each(|_| line(format_args!("-")));
    }
}

/// The wave format that a file's name asks for.
pub fn format_of(path: &Path) -> Option<Trace> {
    match path.extension()?.to_str()? {
        "fst" => Some(Trace::Fst),
        "vcd" => Some(Trace::Vcd),
        _ => None,
    }
}
