//! The module `smoothers` in rust-hdl: the smoothers with the delays that align their outputs.

use std::collections::BTreeSet;

use hoverlock_design::{DesignPoint, smoother_names};

/// The module with placeholders in capitals for the parts that depend on the design.
const TEMPLATE: &str = include_str!("smoothers.template");

/// Longest delay of one cell, steps, as in `cells/delay.rs`.
const LONGEST_DELAY: u64 = 33;

/// Bits of a field of the register bank.
const FIELD_BITS: u64 = 16;

/// Delays of the line memory address that a smoother uses, steps.
const ADDRESS_DELAYS: [u64; 7] = [1, 4, 5, 8, 12, 16, 20];

/// Returns the source of the module: a smoother type for each look-ahead, then the module itself.
pub fn module(design: &DesignPoint) -> String {
    let mut module = Module::new(design);
    module.cell("counter", "AddressCounter", "AddressCounter::default()");
    if !module.delays.is_empty() {
        module.delay_pixels();
    }
    module.banks();
    module.load_banks();
    module.smoothers();
    module.text()
}

/// A delay that aligns smoothers of less look-ahead, in lines and steps.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Delay {
    lines: u64,
    steps: u64,
}

/// The module while it is written.
struct Module {
    pixel_bits: u64,
    coefficient_bits: u64,
    /// Look-ahead of each smoother, stages.
    look_ahead: Vec<u64>,
    /// Names of the smoothers, the narrowest first.
    names: &'static [&'static str],
    /// The different delays, the shortest first.
    delays: Vec<Delay>,
    /// Declarations of the cells.
    fields: String,
    /// Initial values of the cells.
    initial: String,
    /// Wiring.
    body: String,
}

impl Module {
    fn new(design: &DesignPoint) -> Self {
        let look_ahead: Vec<u64> = design.look_ahead.iter().copied().map(u64::from).collect();
        let delays: BTreeSet<Delay> = look_ahead.iter().filter_map(|m| delay(&look_ahead, *m)).collect();
        Self {
            pixel_bits: design.pixel.bits().into(),
            coefficient_bits: design.coefficient.bits().into(),
            look_ahead,
            names: smoother_names(design.smoothers()),
            delays: delays.into_iter().collect(),
            fields: String::new(),
            initial: String::new(),
            body: String::new(),
        }
    }

    /// Declares a cell of a type with its initial value.
    fn cell(&mut self, name: &str, cell: &str, initial: &str) {
        self.fields += &format!("    {name}: {cell},\n");
        self.initial += &format!("            {name}: {initial},\n");
    }

    /// Connects a port of a cell.
    fn connect(&mut self, port: &str, source: &str) {
        self.body += &format!("        self.{port}.next = {source};\n");
    }

    /// Connects clock, reset and clock enable of a cell.
    fn clock(&mut self, cell: &str) {
        for port in ["clock", "reset", "advance"] {
            self.connect(&format!("{cell}.{port}"), &format!("self.{port}.val()"));
        }
    }

    /// Returns the name of the longest smoother.
    fn longest(&self) -> &'static str {
        self.names[self.names.len() - 1]
    }

    /// Returns the number that distinguishes the cells of a delay; empty for the only delay.
    fn suffix(&self, delay: &Delay) -> String {
        match self.delays.len() {
            1 => String::new(),
            _ => format!("_{}", self.delays.iter().position(|known| known == delay).unwrap_or_default()),
        }
    }

    /// Writes the line memory and the cells that delay pixel and start marker for the shorter smoothers.
    fn delay_pixels(&mut self) {
        let (pixel, delays) = (self.pixel_bits, self.delays.clone());
        let taps: Vec<u64> = delays.iter().map(|delay| delay.lines).collect();
        let out = pixel * taps.len() as u64;
        self.cell("pixel_line_delay", &format!("LineDelay<{pixel}, {out}>"), &format!("LineDelay::new(&{taps:?})"));
        let shorter = self.look_ahead.iter().filter(|m| delay(&self.look_ahead, **m).is_some()).count();
        let comment = match (delays.as_slice(), shorter) {
            ([Delay { lines, steps }], 2) if self.look_ahead.len() == 3 => format!(
                "The wide smoother is {lines} lines and {steps} steps longer than the others, so their pixels are \
                 delayed by that."
            ),
            _ => format!("The {} smoother is the longest, so the pixels of the others are delayed.", self.longest()),
        };
        self.body += &format!("        comment!(\"{comment}\");\n");
        for (port, source) in [
            ("clock", "clock"),
            ("advance", "advance"),
            ("address", "counter.address"),
            ("write_address", "counter.delayed_1"),
            ("x", "pixel"),
        ] {
            self.connect(&format!("pixel_line_delay.{port}"), &format!("self.{source}.val()"));
        }
        for (tap, delay) in delays.iter().enumerate() {
            let suffix = self.suffix(delay);
            let mut from = match delays.len() {
                1 => "self.pixel_line_delay.y.val()".to_owned(),
                _ => format!("self.pixel_line_delay.y.val().get_bits::<{pixel}>({})", tap as u64 * pixel),
            };
            let cells = delay.steps.div_ceil(LONGEST_DELAY);
            for i in 0..cells {
                let name = format!("pixel_delay{suffix}_{i}");
                let steps = delay.steps / cells + u64::from(i < delay.steps % cells);
                self.cell(&name, &format!("Delay<{pixel}>"), &format!("Delay::new({steps})"));
                self.clock(&name);
                self.connect(&format!("{name}.x"), &from);
                from = format!("self.{name}.y.val()");
            }
            let name = format!("start_delay{suffix}");
            self.cell(&name, "FrameDelay", &format!("FrameDelay::new({}, {})", delay.lines, delay.steps));
            self.clock(&name);
            self.connect(&format!("{name}.width"), "self.width.val()");
            self.connect(&format!("{name}.x"), "self.start.val()");
            self.connect(&format!("delayed_state{suffix}.x"), &from);
        }
    }

    /// Declares the register banks and the conversions of a pixel to a state.
    fn banks(&mut self) {
        for delay in self.delays.clone() {
            self.cell(&format!("delayed_bank{}", self.suffix(&delay)), "Bank", "Bank::default()");
        }
        self.cell("rows_bank", "Bank", "Bank::default()");
        for delay in self.delays.clone() {
            self.cell(&format!("delayed_state{}", self.suffix(&delay)), "PixelState", "PixelState::default()");
        }
        self.cell("state", "PixelState", "PixelState::default()");
        self.connect("state.x", "self.pixel.val()");
        self.body += "\n";
    }

    /// Connects the register banks: each is loaded when the frame reaches the cells that use it.
    fn load_banks(&mut self) {
        let longest = self.longest();
        self.body += &if self.delays.is_empty() {
            "        comment!(\"Banks: frame_bank for the columns, rows_bank for all rows.\");\n".to_owned()
        } else {
            format!(
                "        comment!(\"Banks: frame_bank for the {longest} columns, delayed_bank for the other columns, \
                 rows_bank for all rows.\");\n"
            )
        };
        for delay in self.delays.clone() {
            let suffix = self.suffix(&delay);
            self.load_bank(&format!("delayed_bank{suffix}"), &format!("start_delay{suffix}.y"));
        }
        self.load_bank("rows_bank", &format!("{longest}_smoother.columns_done"));
        self.connect("window_bank", "self.rows_bank.q.val()");
    }

    fn load_bank(&mut self, bank: &str, load: &str) {
        self.connect(&format!("{bank}.clock"), "self.clock.val()");
        self.connect(&format!("{bank}.load"), &format!("self.{load}.val()"));
        self.connect(&format!("{bank}.d"), "self.frame_bank.val()");
    }

    /// Declares and connects the smoothers.
    fn smoothers(&mut self) {
        let mut field = 0;
        for (name, m) in self.names.iter().zip(self.look_ahead.clone()) {
            let smoother = format!("{name}_smoother");
            self.cell(&smoother, &format!("Smoother{m}"), &format!("Smoother{m}::default()"));
            let (start, x, bank) = match delay(&self.look_ahead, m) {
                None => ("start".to_owned(), "state.y".to_owned(), "frame_bank".to_owned()),
                Some(delay) => {
                    let suffix = self.suffix(&delay);
                    (
                        format!("start_delay{suffix}.y"),
                        format!("delayed_state{suffix}.y"),
                        format!("delayed_bank{suffix}.q"),
                    )
                }
            };
            self.body += "\n";
            self.clock(&smoother);
            for size in ["width", "height"] {
                self.connect(&format!("{smoother}.{size}"), &format!("self.{size}.val()"));
            }
            self.connect(&format!("{smoother}.address"), "self.counter.address.val()");
            for steps in ADDRESS_DELAYS {
                let delayed = format!("self.counter.delayed_{steps}.val()");
                self.connect(&format!("{smoother}.address_delayed_{steps}"), &delayed);
            }
            self.connect(&format!("{smoother}.start"), &format!("self.{start}.val()"));
            self.connect(&format!("{smoother}.x"), &format!("self.{x}.val()"));
            let bits = self.coefficient_bits;
            let coefficient =
                |bank: &str, field: u64| format!("self.{bank}.val().get_bits::<{bits}>({})", FIELD_BITS * field);
            self.connect(&format!("{smoother}.g"), &coefficient(&bank, field));
            for j in 0..m {
                let at = field + 1 + j;
                self.connect(&format!("{smoother}.column_g[{j}]"), &coefficient(&bank, at));
                self.connect(&format!("{smoother}.row_g[{j}]"), &coefficient("rows_bank.q", at));
            }
            field += 1 + m;
        }
    }

    /// Returns the smoother types and the template with all parts.
    fn text(self) -> String {
        let mut types = String::new();
        for m in self.look_ahead.iter().copied().collect::<BTreeSet<_>>() {
            types += &format!("smoother!(Smoother{m}, {m}, \"module: smoother_{m}\");\n");
        }
        let (mut ports, mut signals, mut outputs) = (String::new(), String::new(), String::new());
        for (i, name) in self.names.iter().enumerate() {
            ports += &format!("    /// `G_{i}`.\n    pub {name}: Signal<Out, State>,\n");
            signals += &format!("            {name}: Signal::default(),\n");
            outputs += &format!("        self.{name}.next = self.{name}_smoother.y.val();\n");
        }
        outputs += &format!("        self.start_out.next = self.{}_smoother.start_out.val();\n", self.longest());
        let parts = [
            ("PORTS", ports),
            ("SIGNALS", signals),
            ("OUTPUTS", outputs),
            ("FIELDS", self.fields),
            ("INITIAL", self.initial),
            ("BODY", self.body),
        ];
        types + &parts.iter().fold(TEMPLATE.to_owned(), |text, (name, part)| text.replace(name, part))
    }
}

/// Returns the delay of a smoother to the longest one, or `None` if it is as long.
fn delay(look_ahead: &[u64], m: u64) -> Option<Delay> {
    let longest = look_ahead.iter().copied().max().unwrap_or(m);
    let lines = (1 << longest) - (1 << m);
    (lines > 0).then_some(Delay { lines, steps: 12 * (longest - m) + lines })
}
