//! From a design file to the constants and the wiring that depend on it.
//!
//! rust-hdl has widths in its types, so the emitter is compiled for a design: `HOVERLOCK_DESIGN` names the design file,
//! the default design if it is not set. Four files are written for `include!` and `include_str!`:
//!
//! - `design.toml`: the design file itself;
//! - `design.rs`: the numbers of the file as plain constants;
//! - `smoothers.rs`: a smoother type for each look-ahead, and the smoothers with the delays that align them;
//! - `extractor.rs`: which smoothers each scale pair subtracts.
//!
//! A `#[hdl_gen]` body has no choice but that of numbers, and which delays and smoothers there are is more than a
//! number.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};

use hoverlock_design::{DesignPoint, KEYS, KT27, KeyValue, MAX_RING_RADIUS, smoother_names};

/// Longest delay of one cell, as in `cells/delay.rs`.
const LONGEST_DELAY: u64 = 33;

/// Bits of a field of the bank.
const FIELD_BITS: u64 = 16;

fn main() {
    if let Err(error) = run() {
        eprintln!("the design file: {error}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=HOVERLOCK_DESIGN");
    let design = match std::env::var_os("HOVERLOCK_DESIGN").filter(|path| !path.is_empty()) {
        Some(path) => {
            let path = Path::new(&path);
            println!("cargo:rerun-if-changed={}", path.display());
            let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
            DesignPoint::from_file(&text)?
        }
        None => KT27.clone(),
    };
    design.check_buildable()?;
    let wiring = Wiring {
        pixel_bits: u64::from(design.pixel.bits()),
        coefficient_bits: u64::from(design.coefficient.bits()),
        look_ahead: design.look_ahead.iter().copied().map(u64::from).collect(),
        names: smoother_names(design.smoothers()),
    };
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("design.toml"), design.to_toml())?;
    std::fs::write(out.join("design.rs"), constants(&design))?;
    std::fs::write(out.join("smoothers.rs"), wiring.smoothers())?;
    std::fs::write(out.join("extractor.rs"), extractor(&design))?;
    Ok(())
}

/// Returns the constants of a design in Rust: `WIDTH` for the key `width`, `STATE_BITS` and `STATE_FRACTION_BITS` for
/// the format `state`, an array for a list of whole numbers. `KEY_CONSTANTS` lists the numbers with their names.
fn constants(design: &DesignPoint) -> String {
    let mut text = String::new();
    let mut names = Vec::new();
    for key in &KEYS {
        let name = key.name.to_uppercase();
        let mut number = |name: String, meaning: &str, unit: &str, value: u32| {
            text += &format!("/// {meaning} Unit: {unit}.\npub const {name}: usize = {value};\n");
            names.push(name);
        };
        match key.value(design) {
            KeyValue::Whole(value) => number(name, key.meaning, key.unit, value),
            KeyValue::Format(format) => {
                number(format!("{name}_BITS"), key.meaning, "bits", format.bits());
                let fraction_bits = format.fraction_bits().unsigned_abs().into();
                number(format!("{name}_FRACTION_BITS"), key.meaning, "bits after the point", fraction_bits);
            }
            KeyValue::Wholes(values) => {
                let (meaning, unit, length) = (key.meaning, key.unit, values.len());
                text += &format!("/// {meaning} Unit: {unit}.\npub const {name}: [usize; {length}] = {values:?};\n");
            }
            // The hardware has no numbers with a point.
            KeyValue::Reals(_) => {}
        }
    }
    let pairs: Vec<String> = names.iter().map(|name| format!("(\"{name}\", {name})")).collect();
    text + &format!(
        "/// The numbers of the design file with their names.\npub const KEY_CONSTANTS: &[(&str, usize)] = &[{}];\n",
        pairs.join(", ")
    )
}

/// Returns the call of the macro that wires the module `extractor`: the scale pairs with their smoothers, then those
/// whose ring does not reach the newest row, then those whose ring does.
fn extractor(design: &DesignPoint) -> String {
    let pairs = smoother_names(design.smoothers()).windows(2).enumerate();
    let smoothers: Vec<String> =
        pairs.map(|(k, pair)| format!("{k} {} {} THRESHOLD_{k}_AT", pair[0], pair[1])).collect();
    let (wide, narrow): (Vec<usize>, Vec<usize>) =
        (0..smoothers.len()).partition(|k| design.ring_radii[*k] == MAX_RING_RADIUS);
    let wide: Vec<String> = wide.iter().map(|k| format!("{k} ring_lines_{k} ring_rows_{k}")).collect();
    let narrow: Vec<String> = narrow.iter().map(|k| format!("{k} ring_lines_{k}")).collect();
    format!("extractor!([{}] [{}] [{}]);\n", smoothers.join(", "), narrow.join(", "), wide.join(", "))
}

/// The parameters of the module `smoothers`.
struct Wiring {
    pixel_bits: u64,
    coefficient_bits: u64,
    /// Look-ahead of each smoother, stages.
    look_ahead: Vec<u64>,
    names: &'static [&'static str],
}

/// A delay that aligns smoothers of less look-ahead, in lines and steps.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Delay {
    lines: u64,
    steps: u64,
}

impl Wiring {
    /// The delay of a smoother to the longest one; `None` where it is as long.
    fn delay(&self, look_ahead: u64) -> Option<Delay> {
        let longest = self.look_ahead.iter().copied().max().unwrap_or(look_ahead);
        let lines = (1 << longest) - (1 << look_ahead);
        (lines > 0).then_some(Delay { lines, steps: 12 * (longest - look_ahead) + lines })
    }

    /// The module `smoothers` in rust-hdl.
    fn smoothers(&self) -> String {
        let pixel = self.pixel_bits;
        let delays: Vec<Delay> =
            self.look_ahead.iter().filter_map(|m| self.delay(*m)).collect::<BTreeSet<_>>().into_iter().collect();
        // Only where there are two delays their cells need a number.
        let suffix = |delay: &Delay| match delays.len() {
            1 => String::new(),
            _ => format!("_{}", delays.iter().position(|known| known == delay).unwrap_or_default()),
        };
        let names = self.names;
        let last = names[names.len() - 1];
        let mut types = String::new();
        for m in self.look_ahead.iter().copied().collect::<BTreeSet<_>>() {
            types += &format!("smoother!(Smoother{m}, {m}, \"module: smoother_{m}\");\n");
        }
        let (mut fields, mut made, mut body) = (String::new(), String::new(), String::new());
        let mut cell = |name: &str, cell: &str, new: &str| {
            fields += &format!("    {name}: {cell},\n");
            made += &format!("            {name}: {new},\n");
        };
        let clocked = |name: &str| {
            format!(
                "        self.{name}.clock.next = self.clock.val();\n        self.{name}.reset.next = \
                 self.reset.val();\n        self.{name}.advance.next = self.advance.val();\n"
            )
        };
        cell("counter", "AddressCounter", "AddressCounter::default()");
        if !delays.is_empty() {
            let taps: Vec<u64> = delays.iter().map(|delay| delay.lines).collect();
            let out = pixel * taps.len() as u64;
            cell("pixel_line_delay", &format!("LineDelay<{pixel}, {out}>"), &format!("LineDelay::new(&{taps:?})"));
            let shorter = self.look_ahead.iter().filter(|m| self.delay(**m).is_some()).count();
            let comment = match (delays.as_slice(), shorter) {
                ([Delay { lines, steps }], 2) if self.look_ahead.len() == 3 => format!(
                    "The wide smoother is {lines} lines and {steps} steps longer than the others, so their pixels \
                     are delayed by that."
                ),
                _ => format!("The {last} smoother is the longest, so the pixels of the others are delayed."),
            };
            body += &format!("        comment!(\"{comment}\");\n");
            body += "        self.pixel_line_delay.clock.next = self.clock.val();
        self.pixel_line_delay.advance.next = self.advance.val();
        self.pixel_line_delay.address.next = self.counter.address.val();
        self.pixel_line_delay.write_address.next = self.counter.delayed_1.val();
        self.pixel_line_delay.x.next = self.pixel.val();\n";
            for (tap, delay) in delays.iter().enumerate() {
                let suffix = suffix(delay);
                let mut from = match delays.len() {
                    1 => "self.pixel_line_delay.y.val()".to_owned(),
                    _ => format!("self.pixel_line_delay.y.val().get_bits::<{pixel}>({})", tap as u64 * pixel),
                };
                let cells = delay.steps.div_ceil(LONGEST_DELAY);
                for i in 0..cells {
                    let name = format!("pixel_delay{suffix}_{i}");
                    let steps = delay.steps / cells + u64::from(i < delay.steps % cells);
                    cell(&name, &format!("Delay<{pixel}>"), &format!("Delay::new({steps})"));
                    body += &clocked(&name);
                    body += &format!("        self.{name}.x.next = {from};\n");
                    from = format!("self.{name}.y.val()");
                }
                let name = format!("start_delay{suffix}");
                cell(&name, "FrameDelay", &format!("FrameDelay::new({}, {})", delay.lines, delay.steps));
                body += &clocked(&name);
                body += &format!("        self.{name}.width.next = self.width.val();\n");
                body += &format!("        self.{name}.x.next = self.start.val();\n");
                body += &format!("        self.delayed_state{suffix}.x.next = {from};\n");
            }
            for delay in &delays {
                cell(&format!("delayed_bank{}", suffix(delay)), "Bank", "Bank::default()");
            }
            cell("rows_bank", "Bank", "Bank::default()");
            for delay in &delays {
                cell(&format!("delayed_state{}", suffix(delay)), "PixelState", "PixelState::default()");
            }
        } else {
            cell("rows_bank", "Bank", "Bank::default()");
        }
        cell("state", "PixelState", "PixelState::default()");
        body += "        self.state.x.next = self.pixel.val();\n\n";
        body += &if delays.is_empty() {
            "        comment!(\"Banks: frame_bank for the columns, rows_bank for all rows.\");\n".to_owned()
        } else {
            format!(
                "        comment!(\"Banks: frame_bank for the {last} columns, delayed_bank for the other columns, \
                 rows_bank for all rows.\");\n"
            )
        };
        for delay in &delays {
            let suffix = suffix(delay);
            body += &format!(
                "        self.delayed_bank{suffix}.clock.next = self.clock.val();
        self.delayed_bank{suffix}.load.next = self.start_delay{suffix}.y.val();
        self.delayed_bank{suffix}.d.next = self.frame_bank.val();\n"
            );
        }
        body += &format!(
            "        self.rows_bank.clock.next = self.clock.val();
        self.rows_bank.load.next = self.{last}_smoother.columns_done.val();
        self.rows_bank.d.next = self.frame_bank.val();
        self.window_bank.next = self.rows_bank.q.val();\n"
        );
        let mut field = 0;
        for (name, &m) in names.iter().zip(&self.look_ahead) {
            let smoother = format!("{name}_smoother");
            cell(&smoother, &format!("Smoother{m}"), &format!("Smoother{m}::default()"));
            let (start, x, bank) = match self.delay(m) {
                None => ("start".to_owned(), "state.y".to_owned(), "frame_bank".to_owned()),
                Some(delay) => {
                    let suffix = suffix(&delay);
                    (
                        format!("start_delay{suffix}.y"),
                        format!("delayed_state{suffix}.y"),
                        format!("delayed_bank{suffix}.q"),
                    )
                }
            };
            body += "\n";
            body += &clocked(&smoother);
            for size in ["width", "height"] {
                body += &format!("        self.{smoother}.{size}.next = self.{size}.val();\n");
            }
            body += &format!("        self.{smoother}.address.next = self.counter.address.val();\n");
            for steps in [1, 4, 5, 8, 12, 16, 20] {
                body += &format!(
                    "        self.{smoother}.address_delayed_{steps}.next = self.counter.delayed_{steps}.val();\n"
                );
            }
            body += &format!("        self.{smoother}.start.next = self.{start}.val();\n");
            body += &format!("        self.{smoother}.x.next = self.{x}.val();\n");
            let bits = self.coefficient_bits;
            let slice =
                |bank: &str, field: u64| format!("self.{bank}.val().get_bits::<{bits}>({})", FIELD_BITS * field);
            body += &format!("        self.{smoother}.g.next = {};\n", slice(&bank, field));
            for j in 0..m {
                let at = field + 1 + j;
                body += &format!("        self.{smoother}.column_g[{j}].next = {};\n", slice(&bank, at));
                body += &format!("        self.{smoother}.row_g[{j}].next = {};\n", slice("rows_bank.q", at));
            }
            field += 1 + m;
        }
        let (mut ports, mut signals, mut outputs) = (String::new(), String::new(), String::new());
        for (i, name) in names.iter().enumerate() {
            ports += &format!("    /// `G_{i}`.\n    pub {name}: Signal<Out, State>,\n");
            signals += &format!("            {name}: Signal::default(),\n");
            outputs += &format!("        self.{name}.next = self.{name}_smoother.y.val();\n");
        }
        outputs += &format!("        self.start_out.next = self.{last}_smoother.start_out.val();\n");
        let parts = [
            ("PORTS", ports),
            ("SIGNALS", signals),
            ("OUTPUTS", outputs),
            ("FIELDS", fields),
            ("MADE", made),
            ("BODY", body),
        ];
        types + &parts.iter().fold(TEMPLATE.to_owned(), |text, (name, part)| text.replace(name, part))
    }
}

/// The module without what depends on the look-ahead and the number of smoothers.
const TEMPLATE: &str = r#"
/// The smoothers with aligned outputs.
#[derive(LogicBlock)]
pub struct Smoothers {
    /// Clock.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`.
    pub width: Signal<In, Width>,
    /// `H`.
    pub height: Signal<In, Height>,
    /// Marker one step before the first pixel of a frame.
    pub start: Signal<In, Bit>,
    /// One pixel per step.
    pub pixel: Signal<In, Pixel>,
    /// Register values of the frame, valid from its start.
    pub frame_bank: Signal<In, Fields>,
    /// The same for the window stage, which the frame reaches later.
    pub window_bank: Signal<Out, Fields>,
    /// Line memory address: the number of steps modulo `W`.
    pub address: Signal<Out, Address>,
    /// The address one step ago.
    pub address_delayed_1: Signal<Out, Address>,
PORTS    /// Marker one step before the first smoothed samples of a frame.
    pub start_out: Signal<Out, Bit>,
FIELDS}

impl Default for Smoothers {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            width: Signal::default(),
            height: Signal::default(),
            start: Signal::default(),
            pixel: Signal::default(),
            frame_bank: Signal::default(),
            window_bank: Signal::default(),
            address: Signal::default(),
            address_delayed_1: Signal::default(),
SIGNALS            start_out: Signal::default(),
MADE        }
    }
}

impl Logic for Smoothers {
    #[hdl_gen]
    fn update(&mut self) {
        comment!("module: smoothers");
        self.counter.clock.next = self.clock.val();
        self.counter.reset.next = self.reset.val();
        self.counter.advance.next = self.advance.val();
        self.counter.width.next = self.width.val();
        self.address.next = self.counter.address.val();
        self.address_delayed_1.next = self.counter.delayed_1.val();

BODY
OUTPUTS    }
}
"#;
