//! Waves of a run: a window of clock cycles as FST or VCD, and GTKWave's view of it.
//!
//! All cycles of a real frame would be gigabytes, so a window is recorded: by default around the first mismatch, or
//! else the first feature at the output. A run is repeatable bit for bit under one seed, so it runs twice: once to find
//! that cycle and again up to the end of the window. The view file groups the signals along the pipeline, with samples
//! in DN and the fields of the record by name. Its marker is at that cycle.

use std::{fmt::Write as _, path::Path};

use hoverlock_design::{DesignPoint, smoother_names};
use hoverlock_harness::{Time, build::Trace, wave::Recording};
use hoverlock_registers::record::record_words;

use crate::{Job, Outcome, SimulationError, Simulator, Streams, record_window, top::RESET_CYCLES};
use hoverlock_rtl::design::{HEIGHT_BITS, ROW_BITS};

/// Nanoseconds of a clock cycle: 100 MHz.
pub(super) const PERIOD: u64 = 10;

/// Cycles before the window's middle, as a share of four.
const BEFORE: u64 = 3;

/// The cycles that are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// The first cycle.
    pub from: u64,
    /// Number of cycles.
    pub cycles: u64,
    /// The cycle that the view is centred on.
    pub focus: u64,
}

impl Window {
    /// Returns a window of `cycles` cycles, three quarters of them before the first mismatch of a run, or else before
    /// its first feature.
    pub fn around(outcome: &Outcome, cycles: u64) -> Self {
        let mismatch = outcome.first_mismatch.as_ref().map(|mismatch| mismatch.cycle);
        let focus = mismatch.or(outcome.first_feature).unwrap_or_default();
        Self { from: focus.saturating_sub(cycles / 4 * BEFORE), cycles, focus }
    }
}

/// Runs frames again, as far as the window goes, and writes its waves; the simulator must have been built with tracing.
///
/// # Errors
/// If the file cannot be written, or the simulator was built without waves.
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
    /// Returns the recording of the window, without the view of the harness: [`view`] groups the signals.
    pub fn recording(&self) -> Recording {
        let from = if self.window.from == 0 { 0 } else { self.window.from + RESET_CYCLES };
        let last = self.end().saturating_sub(1);
        Recording::everything(self.path).without_view().window(time(from, false), time(last, true))
    }

    fn end(&self) -> u64 {
        (self.window.from + RESET_CYCLES).saturating_add(self.window.cycles)
    }

    /// Returns `true` if the window is complete after `cycle` cycles, counted from the first of the reset.
    pub fn is_past(&self, cycle: u64) -> bool {
        cycle >= self.end()
    }
}

/// Returns the time of a clock edge: a cycle begins with the falling edge, and half a period later comes the rising
/// one.
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
type Shown = (String, u32, String, Form);

/// A group of the view: its name, whether it is open at first, its signals.
type Group = (String, bool, Vec<Shown>);

/// A field of a record: lowest bit, bits, name, form.
type FieldOfRecord = (u32, u32, String, Form);

/// How samples of a design are shown: in DN, or in steps of the camera or LSB where those are larger.
struct Units {
    state: (Form, Form, &'static str),
    dog: (Form, Form, &'static str),
}

impl Units {
    fn of(design: &DesignPoint) -> Self {
        let fraction = design.state.fraction_bits() as u32;
        let state = if design.step_bits() == 0 { "DN" } else { "camera steps" };
        let dog = match design.dog_bits.checked_sub(14) {
            Some(bits) => (Dn(bits), Curve(bits), "DN"),
            None => (Decimal, Curve(0), "LSB"),
        };
        Self { state: (Dn(fraction), Curve(fraction), state), dog }
    }
}

use Form::{Bit, Curve, Decimal, Dn, Hex};

/// The groups of the view, along the pipeline, and which of them are open at first.
fn groups(design: &DesignPoint) -> Vec<Group> {
    let view = View::of(design);
    let names = smoother_names(design.smoothers());
    let smoothers = names.iter().zip(&*design.sigmas).zip(&*design.look_ahead);
    let smoothers = smoothers.map(|((name, sigma), look_ahead)| view.smoother(name, *sigma, *look_ahead));
    let mut groups = vec![View::clock_and_reset(), view.video(), view.registers(), view.sequencer()];
    groups.extend(smoothers);
    groups.extend([view.smoothed(names), view.responses(), view.maxima(), view.descriptor()]);
    groups.extend([View::record(), View::features()]);
    groups
}

/// What the groups of the view depend on.
struct View {
    units: Units,
    /// Scale pairs.
    pairs: usize,
    /// Bits of a pixel, a state, a response, a column and a row.
    pixel: u32,
    state: u32,
    dog: u32,
    column: u32,
    row: u32,
}

impl View {
    fn of(design: &DesignPoint) -> Self {
        Self {
            units: Units::of(design),
            pairs: design.pairs(),
            pixel: design.pixel.bits(),
            state: design.state.bits(),
            dog: design.dog_bits,
            column: design.width.next_power_of_two().trailing_zeros(),
            row: ROW_BITS as u32,
        }
    }

    /// Returns `signals` of every scale pair `k`.
    fn of_pairs(&self, signals: impl Fn(usize) -> Vec<Shown>) -> Vec<Shown> {
        (0..self.pairs).flat_map(signals).collect()
    }

    /// A response of a cell.
    fn response(&self, path: String, label: String) -> Shown {
        let (form, _, unit) = &self.units.dog;
        (format!("core.{path}"), self.dog, format!("{label}, {unit}"), *form)
    }

    fn smoother(&self, name: &str, sigma: f64, look_ahead: u32) -> Group {
        let path = |signal: &str| format!("core.extractor.smoothers.{name}_smoother.{signal}");
        let last = look_ahead - 1;
        let sample = |signal: &str, label: &str| -> Shown {
            (path(signal), self.state, format!("{label}, {}", self.units.state.2), self.units.state.0)
        };
        let signals = vec![
            (path("rows_load"), 1, "the first row of a frame arrives".into(), Bit),
            sample("second_stage_y", "two column stages done"),
            sample("column_0", "column_look_ahead done"),
            (path("first_row"), 1, "recursion, first row".into(), Bit),
            sample("recursion_y", "recursion"),
            (path("first_column"), 1, "row stages, first column".into(), Bit),
            sample(&format!("row_look_back_{last}_y"), "row_look_back done"),
            sample(&format!("row_look_ahead_{last}_y"), "row_look_ahead done"),
        ];
        (format!("smoother {name}, sigma {sigma:?}"), false, signals)
    }

    fn clock_and_reset() -> Group {
        (
            "clock and reset".into(),
            true,
            vec![
                ("clock".into(), 1, "clock".into(), Bit),
                ("reset".into(), 1, "reset".into(), Bit),
                ("irq".into(), 1, "irq".into(), Bit),
            ],
        )
    }

    fn video(&self) -> Group {
        (
            "video in".into(),
            true,
            vec![
                ("video_valid".into(), 1, "valid".into(), Bit),
                ("video_ready".into(), 1, "ready".into(), Bit),
                ("video_startofpacket".into(), 1, "startofpacket".into(), Bit),
                ("video_endofpacket".into(), 1, "endofpacket".into(), Bit),
                ("video_data".into(), self.pixel, "data".into(), Hex),
                ("video_data".into(), self.pixel, format!("data, {}", self.units.state.2), Curve(0)),
            ],
        )
    }

    fn registers(&self) -> Group {
        (
            "registers".into(),
            false,
            [
                vec![
                    ("csr_address".into(), 6, "word address".into(), Hex),
                    ("csr_write".into(), 1, "write".into(), Bit),
                    ("csr_writedata".into(), 32, "writedata".into(), Hex),
                    ("csr_read".into(), 1, "read".into(), Bit),
                    ("csr_readdata".into(), 32, "readdata".into(), Hex),
                    ("registers.control_enable".into(), 1, "control.enable".into(), Bit),
                    ("registers.control_automatic".into(), 1, "control.automatic".into(), Bit),
                    ("registers.size_width".into(), self.column + 1, "size.width".into(), Decimal),
                    ("registers.size_height".into(), HEIGHT_BITS as u32, "size.height".into(), Decimal),
                ],
                self.of_pairs(|k| vec![self.response(format!("threshold_{k}"), format!("T {k} in use"))]),
                vec![
                    ("core.begun".into(), 1, "frame begun".into(), Bit),
                    ("core.done".into(), 1, "frame done".into(), Bit),
                    ("core.errors".into(), 4, "errors now".into(), Hex),
                    ("core.frames".into(), 32, "frames".into(), Decimal),
                ],
            ]
            .concat(),
        )
    }

    fn sequencer(&self) -> Group {
        (
            "sequencer".into(),
            false,
            vec![
                ("core.sequencer.state".into(), 2, "state: idle, frame, pad".into(), Decimal),
                ("core.sequencer.x".into(), self.column, "x".into(), Decimal),
                ("core.sequencer.y".into(), self.row, "y".into(), Decimal),
                ("core.sequencer.capture".into(), 1, "registers captured".into(), Bit),
                ("core.sequencer.advance".into(), 1, "step (advance)".into(), Bit),
                ("core.sequencer.start".into(), 1, "start of frame".into(), Bit),
                ("core.sequencer.pixel".into(), self.pixel, "pixel".into(), Hex),
                ("core.sequencer.drain".into(), self.column + 7, "steps left to drain".into(), Decimal),
                ("core.sequencer.stall".into(), 1, "stall by the FIFO".into(), Bit),
            ],
        )
    }

    fn smoothed(&self, names: &[&str]) -> Group {
        // The narrowest as a curve too.
        let aligned = names.iter().enumerate().flat_map(|(i, name)| -> Vec<Shown> {
            let path = format!("core.extractor.smoothers.{name}");
            let mut shown =
                vec![(path.clone(), self.state, format!("{name}, {}", self.units.state.2), self.units.state.0)];
            shown.extend((i == 0).then(|| (path, self.state, (*name).to_owned(), self.units.state.1)));
            shown
        });
        (
            "smoothed, aligned".into(),
            true,
            std::iter::once(("core.extractor.smoothers.start_out".into(), 1, "start of frame".into(), Bit))
                .chain(aligned)
                .collect(),
        )
    }

    fn responses(&self) -> Group {
        (
            "DoG".into(),
            true,
            [
                vec![
                    ("core.extractor.response_cursor.x".into(), self.column, "x".into(), Decimal),
                    ("core.extractor.response_cursor.y".into(), self.row, "y".into(), Decimal),
                ],
                self.of_pairs(|k| {
                    let path = |signal: &str| format!("extractor.scale_pair_{k}.difference_{signal}");
                    let magnitude = path("magnitude");
                    vec![
                        flag(path("positive"), format!("pair {k} bright")),
                        self.response(magnitude.clone(), format!("pair {k}")),
                        (format!("core.{magnitude}"), self.dog, format!("pair {k}"), self.units.dog.1),
                    ]
                }),
            ]
            .concat(),
        )
    }

    fn maxima(&self) -> Group {
        (
            "maxima".into(),
            true,
            [
                vec![
                    ("core.extractor.window_cursor.x".into(), self.column, "x".into(), Decimal),
                    ("core.extractor.window_cursor.y".into(), self.row, "y".into(), Decimal),
                    ("core.extractor.eligible.eligible".into(), 1, "eligible".into(), Bit),
                ],
                self.of_pairs(|k| {
                    let path = |signal: &str| format!("extractor.decision_{k}.{signal}");
                    vec![
                        self.response(path("p"), format!("pair {k} centre")),
                        self.response(path("strict"), format!("pair {k} earlier maximum")),
                        self.response(path("loose"), format!("pair {k} later maximum")),
                        self.response(path("threshold"), format!("pair {k} T")),
                        flag(path("hit"), format!("pair {k} feature")),
                    ]
                }),
            ]
            .concat(),
        )
    }

    fn descriptor(&self) -> Group {
        (
            "ring and descriptor".into(),
            false,
            [
                self.of_pairs(|k| {
                    vec![self.response(format!("extractor.scale_pair_{k}.max_dog_y"), format!("MaxDOG {k}"))]
                }),
                vec![
                    ("core.extractor.ring_cursor.x".into(), self.column, "x".into(), Decimal),
                    ("core.extractor.ring_cursor.y".into(), self.row, "y".into(), Decimal),
                    ("core.extractor.queue.waiting".into(), 10, "candidates waiting".into(), Decimal),
                    ("core.extractor.queue.found".into(), 1, "ring complete".into(), Bit),
                ],
                self.of_pairs(|k| vec![(format!("core.extractor.ring_{k}.maxlbp"), 32, format!("MaxLBP {k}"), Hex)]),
                self.of_pairs(|k| vec![(format!("core.extractor.ring_{k}.sign"), 32, format!("sign {k}"), Hex)]),
            ]
            .concat(),
        )
    }

    fn record() -> Group {
        (
            "record".into(),
            false,
            vec![
                ("core.extractor.write".into(), 1, "write".into(), Bit),
                ("core.extractor.room".into(), 1, "FIFO has room".into(), Bit),
                ("core.fifo.waiting".into(), 10, "records in the FIFO".into(), Decimal),
                ("core.extractor.count".into(), 20, "features of the frame".into(), Decimal),
                ("core.extractor.dropped".into(), 20, "dropped of the frame".into(), Decimal),
            ],
        )
    }

    fn features() -> Group {
        (
            "feature out".into(),
            true,
            vec![
                ("feature_valid".into(), 1, "valid".into(), Bit),
                ("feature_ready".into(), 1, "ready".into(), Bit),
                ("feature_startofpacket".into(), 1, "startofpacket".into(), Bit),
                ("feature_endofpacket".into(), 1, "endofpacket".into(), Bit),
            ],
        )
    }
}

/// A bit of a cell.
fn flag(path: String, label: String) -> Shown {
    (format!("core.{path}"), 1, label, Bit)
}

/// The fields of a record.
fn fields(design: &DesignPoint) -> Vec<FieldOfRecord> {
    let units = Units::of(design);
    let response =
        |low: u32, name: &str| -> FieldOfRecord { (low, 16, format!("{name}, {}", units.dog.2), units.dog.0) };
    let mut all = vec![
        (0, 16, "x".into(), Decimal),
        (16, 16, "y".into(), Decimal),
        response(32, "response"),
        (48, 1, "scale pair".into(), Bit),
        (49, 1, "bright".into(), Bit),
        (63, 1, "trailer".into(), Bit),
        response(64, "left"),
        response(80, "right"),
        response(96, "upper"),
        response(112, "lower"),
        (128, 64, "MaxLBP 1, 0".into(), Hex),
        (192, 64, "sign 1, 0".into(), Hex),
    ];
    if design.pairs() > 2 {
        all.push((50, 1, "scale pair 2".into(), Bit));
        all.push((256, 32, "MaxLBP 2".into(), Hex));
        all.push((288, 32, "sign 2".into(), Hex));
    }
    all.push((0, record_port(design).1, "record".into(), Hex));
    all
}

/// The port of the records, whose fields are the last group's, and its bits.
fn record_port(design: &DesignPoint) -> (&'static str, u32) {
    ("feature_data", 32 * record_words(design.pairs()) as u32)
}

/// Returns every signal of the view: its path in the wave file, and its width in bits.
pub fn signals(design: &DesignPoint) -> Vec<(String, u32)> {
    let shown = groups(design).into_iter().flat_map(|(_, _, signals)| signals).map(|(path, bits, ..)| (path, bits));
    let (record, bits) = record_port(design);
    let record = (record.to_owned(), bits);
    let mut all: Vec<_> = shown.chain([record]).map(|(path, bits)| (full(&path), bits)).collect();
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
pub fn view(design: &DesignPoint, wave: &Path, window: Window) -> String {
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
    for (group, open, signals) in groups(design) {
        let closed = if open { 0 } else { flag::CLOSED };
        let is_record = group == "feature out";
        let mut line = |text_of: std::fmt::Arguments<'_>| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{text_of}");
        };
        line(format_args!("@{:x}\n-{group}", flag::GROUP_BEGIN | flag::BLANK | closed));
        for (path, bits, alias, form) in signals {
            let range = if bits > 1 { format!("[{}:0]", bits - 1) } else { String::new() };
            shown(&mut line, &format!("+{{{alias}}} {}{range}", full(&path)), form);
        }
        for (low, bits, alias, form) in fields(design).into_iter().filter(|_| is_record) {
            let (path, width) = record_port(design);
            let signal = format!("{}[{}:0]", full(path), width - 1);
            let bit = |bit: u32| format!("({}){signal}", width - 1 - bit);
            let text = match bits {
                1 => format!("+{{{alias}}} {}", bit(low)),
                all if all == width => format!("+{{{alias}}} {signal}"),
                _ => {
                    let bits: Vec<_> = (low..low + bits).rev().map(bit).collect();
                    format!("#{{{alias}}} {}", bits.join(" "))
                }
            };
            shown(&mut line, &text, form);
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
