//! From a design file to the constants and the wiring that depend on it.
//!
//! rust-hdl has widths in its types, so the emitter is compiled for a design: `HOVERLOCK_DESIGN` names the design file,
//! `designs/kt27.toml` where it is not set. Two files are written for `include!`:
//!
//! - `design.rs`: the numbers of the file as plain constants;
//! - `smoothers.rs`: a smoother type for each look-ahead, and the three smoothers with the delays that align them. A
//!   `#[hdl_gen]` body has no choice but that of numbers, and which delays there are is more than a number.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

/// Longest delay of one cell, as in `cells/delay.rs`.
const LONGEST_DELAY: u64 = 33;

/// Bits of a field of the bank.
const FIELD_BITS: u64 = 16;

const NAMES: [&str; 3] = ["narrow", "middle", "wide"];

fn main() {
    if let Err(error) = run() {
        eprintln!("the design file: {error}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=HOVERLOCK_DESIGN");
    let file = match std::env::var_os("HOVERLOCK_DESIGN").filter(|path| !path.is_empty()) {
        Some(path) => PathBuf::from(path),
        None => Path::new(&std::env::var("CARGO_MANIFEST_DIR")?).join("../designs/kt27.toml"),
    };
    println!("cargo:rerun-if-changed={}", file.display());
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let design = Design::of(&text.parse()?)?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("design.rs"), design.constants())?;
    std::fs::write(out.join("smoothers.rs"), design.smoothers())?;
    Ok(())
}

/// The numbers of a design file. What is possible is checked by the models and by `src/design.rs`.
struct Design {
    /// `u8.0` is 8 and 0.
    pixel: [u64; 2],
    state: [u64; 2],
    coefficient: [u64; 2],
    look_ahead: [u64; 3],
    sigmas: [f64; 3],
    /// The other keys.
    numbers: Vec<(&'static str, u64)>,
}

/// A delay that aligns smoothers of less look-ahead, in lines and steps.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Delay {
    lines: u64,
    steps: u64,
}

impl Design {
    fn of(table: &Table) -> Result<Self, String> {
        let value = |key: &str| table.get(key).ok_or(format!("the key {key} is missing"));
        let number = |value: &Value| value.as_integer().and_then(|number| u64::try_from(number).ok());
        let whole = |key: &str| number(value(key)?).ok_or(format!("{key} is not a whole number"));
        let format = |key: &str| {
            let text = value(key)?.as_str().and_then(|text| text.strip_prefix('u')?.split_once('.'));
            let bits = text.and_then(|(integer, fraction)| Some([integer.parse().ok()?, fraction.parse().ok()?]));
            bits.ok_or(format!("{key} is not a format like u16.2"))
        };
        let list = |key: &str| value(key)?.as_array().ok_or(format!("{key} is not a list"));
        let look_ahead: Vec<u64> = list("look_ahead")?.iter().filter_map(number).collect();
        let real = |value: &Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
        let sigmas: Vec<f64> = list("sigmas")?.iter().filter_map(real).collect();
        let keys = [
            ("WIDTH", "width"),
            ("HEIGHT", "height"),
            ("DOG_BITS", "dog_bits"),
            ("THRESHOLD_TARGET", "threshold_target"),
            ("THRESHOLD_INITIAL", "threshold_initial"),
        ];
        Ok(Self {
            pixel: format("pixel")?,
            state: format("state")?,
            coefficient: format("coefficient")?,
            look_ahead: look_ahead.try_into().map_err(|_| "look_ahead is not three whole numbers")?,
            sigmas: sigmas.try_into().map_err(|_| "sigmas are not three numbers")?,
            numbers: keys.iter().map(|(name, key)| Ok((*name, whole(key)?))).collect::<Result<_, String>>()?,
        })
    }

    fn constants(&self) -> String {
        let mut text = String::new();
        let mut constant = |what: &str, name: &str, value: u64| {
            text += &format!("/// {what}\npub const {name}: usize = {value};\n");
        };
        constant("Bits of a pixel.", "PIXEL_BITS", self.pixel[0]);
        constant("Fraction bits of the state.", "FRACTION_BITS", self.state[1]);
        constant("Bits of a coefficient.", "COEFFICIENT_BITS", self.coefficient[1]);
        for (name, value) in &self.numbers {
            constant("As in the design file.", name, *value);
        }
        text + &format!(
            "/// Look-ahead of each smoother.\npub const LOOK_AHEAD: [usize; 3] = {:?};\n\
             /// Sigma of each smoother, px.\npub const SIGMAS: [f64; 3] = {:?};\n",
            self.look_ahead, self.sigmas
        )
    }

    /// The delay of a smoother to the longest one; `None` where it is as long.
    fn delay(&self, look_ahead: u64) -> Option<Delay> {
        let longest = self.look_ahead.into_iter().max().unwrap_or(look_ahead);
        let lines = (1 << longest) - (1 << look_ahead);
        (lines > 0).then_some(Delay { lines, steps: 12 * (longest - look_ahead) + lines })
    }

    /// The module `smoothers` in rust-hdl.
    fn smoothers(&self) -> String {
        let pixel = self.pixel[0];
        let delays: Vec<Delay> =
            self.look_ahead.iter().filter_map(|m| self.delay(*m)).collect::<BTreeSet<_>>().into_iter().collect();
        // Only where there are two delays their cells need a number.
        let suffix = |delay: &Delay| match delays.len() {
            1 => String::new(),
            _ => format!("_{}", delays.iter().position(|known| known == delay).unwrap_or_default()),
        };
        let mut types = String::new();
        for m in self.look_ahead.into_iter().collect::<BTreeSet<_>>() {
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
                ([Delay { lines, steps }], 2) => format!(
                    "The wide smoother is {lines} lines and {steps} steps longer than the others, so their pixels \
                     are delayed by that."
                ),
                _ => "The wide smoother is the longest, so the pixels of the others are delayed.".into(),
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
        body += if delays.is_empty() {
            "        comment!(\"Banks: frame_bank for the columns, rows_bank for all rows.\");\n"
        } else {
            "        comment!(\"Banks: frame_bank for the wide columns, delayed_bank for the other columns, rows_bank \
             for all rows.\");\n"
        };
        for delay in &delays {
            let suffix = suffix(delay);
            body += &format!(
                "        self.delayed_bank{suffix}.clock.next = self.clock.val();
        self.delayed_bank{suffix}.load.next = self.start_delay{suffix}.y.val();
        self.delayed_bank{suffix}.d.next = self.frame_bank.val();\n"
            );
        }
        body += "        self.rows_bank.clock.next = self.clock.val();
        self.rows_bank.load.next = self.wide_smoother.columns_done.val();
        self.rows_bank.d.next = self.frame_bank.val();
        self.window_bank.next = self.rows_bank.q.val();\n";
        let mut field = 0;
        for (name, m) in NAMES.into_iter().zip(self.look_ahead) {
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
            let bits = self.coefficient[1];
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
        types + &TEMPLATE.replace("FIELDS", &fields).replace("MADE", &made).replace("BODY", &body)
    }
}

/// The module without what depends on the look-ahead.
const TEMPLATE: &str = r#"
/// The three smoothers with aligned outputs.
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
    /// `G_0`.
    pub narrow: Signal<Out, State>,
    /// `G_1`.
    pub middle: Signal<Out, State>,
    /// `G_2`.
    pub wide: Signal<Out, State>,
    /// Marker one step before the first smoothed samples of a frame.
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
            narrow: Signal::default(),
            middle: Signal::default(),
            wide: Signal::default(),
            start_out: Signal::default(),
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
        self.narrow.next = self.narrow_smoother.y.val();
        self.middle.next = self.middle_smoother.y.val();
        self.wide.next = self.wide_smoother.y.val();
        self.start_out.next = self.wide_smoother.start_out.val();
    }
}
"#;
