//! The module `smoothers` in rust-hdl: the smoothers, the line memories and markers of their column stages, and the
//! delays that align their outputs.
//!
//! All smoothers end their column stages in the same step, the longest after `2^M - 1` lines. A smoother of
//! look-ahead `m` filters row `r` when it is `2^M - q` lines old, `q = 2^(m-2)`, and also uses the rows `q`, `2 q` and
//! `3 q` below.

use std::collections::BTreeSet;

use hoverlock_design::pipeline::{BORDER_STEPS, CELL_STEPS, CURSOR_STEPS, TREE_STEPS, row_steps};
use hoverlock_design::{DesignPoint, Protection, smoother_names};

/// The module with placeholders in capitals for the parts that depend on the design.
const TEMPLATE: &str = include_str!("smoothers.template");

/// Longest delay of one cell, steps, as in `cells/delay.rs`.
const LONGEST_DELAY: u64 = 33;

/// Bits of a field of the register bank.
const FIELD_BITS: u64 = 16;

/// Rows of the first two column stages that may lie outside the frame.
const OUTER_ROWS: u64 = 3;

/// Returns the source of the module: a smoother type for each look-ahead, then the module itself.
pub fn module(design: &DesignPoint) -> String {
    let mut module = Module::new(design);
    module.cell("counter", "AddressCounter", "AddressCounter::default()");
    module.memory();
    module.last_row();
    module.markers();
    module.first_rows();
    module.smoothers();
    if design.protection == Protection::Parity {
        module.upsets();
    }
    module.text()
}

/// The module while it is written.
struct Module {
    pixel_bits: u64,
    state_bits: u64,
    coefficient_bits: u64,
    /// Look-ahead of each smoother, stages.
    look_ahead: Vec<u64>,
    /// The different look-aheads, the shortest first.
    lengths: Vec<u64>,
    /// Names of the smoothers, the narrowest first.
    names: &'static [&'static str],
    /// Lines after which the memory outputs pixels, rising.
    taps: Vec<u64>,
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
        let lengths: BTreeSet<u64> = look_ahead.iter().copied().collect();
        let mut module = Self {
            pixel_bits: design.pixel.bits().into(),
            state_bits: design.state.bits().into(),
            coefficient_bits: design.coefficient.bits().into(),
            look_ahead,
            lengths: lengths.into_iter().collect(),
            names: smoother_names(design.smoothers()),
            taps: Vec::new(),
            fields: String::new(),
            initial: String::new(),
            body: String::new(),
        };
        let ages: BTreeSet<u64> = module.lengths.iter().flat_map(|m| module.ages(*m)).filter(|age| *age > 0).collect();
        module.taps = ages.into_iter().collect();
        module
    }

    /// Returns the longest look-ahead.
    fn longest(&self) -> u64 {
        self.lengths.last().copied().unwrap_or_default()
    }

    /// Returns the ages of the rows `r`, `r + q`, `r + 2 q`, `r + 3 q` of a smoother of look-ahead `m`, lines.
    fn ages(&self, m: u64) -> [u64; 4] {
        let q = 1 << (m - 2);
        [1, 2, 3, 4].map(|i| (1 << self.longest()) - i * q)
    }

    /// Returns the stages with a line memory: smoother and `j`, in the order of the memory's ports.
    fn stages(&self) -> Vec<(usize, u64)> {
        let of = |(smoother, m): (usize, &u64)| (0..m - 2).map(move |j| (smoother, j));
        self.look_ahead.iter().enumerate().flat_map(of).collect()
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

    /// Connects ports of a cell that have the names of ports of this module.
    fn ports(&mut self, cell: &str, ports: &[&str]) {
        for port in ports {
            self.connect(&format!("{cell}.{port}"), &format!("self.{port}.val()"));
        }
    }

    /// Connects clock, reset and clock enable of a cell.
    fn clock(&mut self, cell: &str) {
        self.ports(cell, &["clock", "reset", "advance"]);
    }

    fn comment(&mut self, text: &str) {
        self.body += &format!("\n        comment!(\"{text}\");\n");
    }

    /// Declares and connects a delay of a flag, and returns its output.
    fn flag_delay(&mut self, name: &str, steps: u64, from: &str) -> String {
        self.cell(name, "FlagDelay", &format!("FlagDelay::new({steps})"));
        self.clock(name);
        self.connect(&format!("{name}.x"), from);
        format!("self.{name}.y.val()")
    }

    /// Declares and connects a delay of a frame's marker, and returns its output.
    fn frame_delay(&mut self, name: &str, lines: u64, steps: u64, from: &str) -> String {
        self.cell(name, "FrameDelay", &format!("FrameDelay::new({lines}, {steps})"));
        self.clock(name);
        self.ports(name, &["width"]);
        self.connect(&format!("{name}.x"), from);
        format!("self.{name}.y.val()")
    }

    /// Declares and connects a delay of samples in as few cells as possible, and returns its output.
    fn delay(&mut self, name: &str, bits: u64, steps: u64, from: &str) -> String {
        let cells = steps.div_ceil(LONGEST_DELAY);
        let mut from = from.to_owned();
        for i in 0..cells {
            let name = if cells == 1 { name.to_owned() } else { format!("{name}_{i}") };
            let steps = steps / cells + u64::from(i < steps % cells);
            self.cell(&name, &format!("Delay<{bits}>"), &format!("Delay::new({steps})"));
            self.clock(&name);
            self.connect(&format!("{name}.x"), &from);
            from = format!("self.{name}.y.val()");
        }
        from
    }

    /// Declares and connects a cursor.
    fn cursor(&mut self, name: &str, start: &str) {
        self.cell(name, "Cursor", "Cursor::default()");
        self.clock(name);
        self.ports(name, &["width", "height"]);
        self.connect(&format!("{name}.start"), start);
    }

    /// Writes the line memory of all column look-ahead stages.
    fn memory(&mut self) {
        let (taps, stages) = (self.taps.clone(), self.stages());
        let lines: Vec<u64> = stages.iter().map(|(_, j)| 1 << j).collect();
        self.cell(
            "line_memory",
            &format!("ColumnMemory<{}, {}>", taps.len(), stages.len()),
            &format!("ColumnMemory::new(&{taps:?}, &{lines:?})"),
        );
        self.comment("Rows of pixels for the first two column stages, rows of states for the others.");
        self.ports("line_memory", &["clock", "advance", "pixel"]);
        self.connect("line_memory.address", "self.counter.address.val()");
        self.connect("line_memory.write_address", "self.counter.write_address.val()");
        for (i, (smoother, j)) in stages.into_iter().enumerate() {
            let smoother = format!("{}_smoother", self.names[smoother]);
            self.connect(&format!("line_memory.x[{i}]"), &format!("self.{smoother}.arriving[{j}].val()"));
            self.connect(&format!("{smoother}.delayed[{j}]"), &format!("self.line_memory.y[{i}].val()"));
        }
    }

    /// Writes the held last row and the flags of the rows outside the frame.
    fn last_row(&mut self) {
        self.comment("The last row of a frame is held for the column stages.");
        self.cursor("cursor", "self.start.val()");
        self.cell("tail", "TailCounter", "TailCounter::default()");
        self.clock("tail");
        self.ports("tail", &["width"]);
        self.connect("tail.start", "self.cursor.last_row.val() & self.cursor.last_column.val()");
        self.cell("held", "HeldRow", "HeldRow::default()");
        self.ports("held", &["clock", "advance"]);
        self.connect("held.write", "self.cursor.last_row.val()");
        self.connect("held.address", "self.counter.address.val()");
        self.connect("held.write_address", "self.counter.write_address.val()");
        self.connect("held.x", "self.pixel.val()");
        let (mut held, mut steps) = ("self.held.y.val()".to_owned(), 0);
        for j in (0..self.longest() - 2).rev() {
            let more = if steps == 0 { TREE_STEPS } else { CELL_STEPS };
            steps += more;
            held = self.delay(&format!("held_delay_{j}"), self.pixel_bits, more, &held);
            let state = format!("held_state_{j}");
            self.cell(&state, "PixelState", "PixelState::default()");
            self.connect(&format!("{state}.x"), &held);
            let bit = OUTER_ROWS * self.lengths.len() as u64 + j;
            let tail = format!("self.tail.outside.val().get_bit({bit})");
            self.flag_delay(&format!("outside_delay_{j}"), steps, &tail);
        }
    }

    /// Writes the bank and the markers that follow a frame through the pipeline.
    fn markers(&mut self) {
        let (longest, first) = (self.longest(), self.ages(self.longest())[0]);
        self.comment(
            "The bank is loaded before the frame reaches its first stage, and serves all parts of the pipeline.",
        );
        let bank = self.frame_delay("bank_load", first, 1, "self.start.val()");
        self.cell("bank", "Bank", "Bank::default()");
        self.ports("bank", &["clock"]);
        self.connect("bank.load", &bank);
        self.connect("bank.d", "self.frame_bank.val()");
        self.connect("window_bank", "self.bank.q.val()");
        self.comment("Markers: each stage loads its coefficient with the first operands of a frame.");
        let rows = self.flag_delay(&format!("rows_load_{longest}"), 1, &bank);
        for m in self.lengths.clone() {
            if m < longest {
                let (lines, steps) = (self.ages(m)[0] - first, CELL_STEPS * (longest - m));
                self.frame_delay(&format!("rows_load_{m}"), lines, steps, &rows);
            }
        }
        let (mut marker, mut steps) = (rows, TREE_STEPS);
        for j in (0..longest - 2).rev() {
            marker = self.frame_delay(&format!("stage_load_{j}"), 1 << j, steps, &marker);
            steps = CELL_STEPS;
        }
        // A marker that loads comes later than one that starts a cursor: the position goes to the border first.
        let to_load = CURSOR_STEPS + BORDER_STEPS;
        let start = self.flag_delay("recursion_start", steps - to_load, &marker);
        self.cursor("recursion_cursor", &start);
        self.flag_delay("recursion_load", to_load, &start);
        let done = self.flag_delay("columns_done", CELL_STEPS, &start);
        self.cursor("row_cursor", &done);
        self.flag_delay("row_load", to_load, &done);
        let last = self.names[self.names.len() - 1];
        self.connect("start_out", &format!("self.{last}_smoother.start_out.val()"));
    }

    /// Writes the rows of the first two column stages, for each look-ahead.
    fn first_rows(&mut self) {
        for (i, m) in self.lengths.clone().into_iter().enumerate() {
            let q = 1u64 << (m - 2);
            self.comment(&format!("Look-ahead {m}: rows r, r + {q}, r + {} and r + {}.", 2 * q, 3 * q));
            let rows = format!("rows_{m}");
            self.cell(&rows, "RepeatedRows", "RepeatedRows::default()");
            self.ports(&rows, &["clock", "advance"]);
            for (row, age) in self.ages(m).into_iter().enumerate() {
                let source = match self.taps.iter().position(|tap| *tap == age) {
                    Some(tap) => format!("self.line_memory.taps[{tap}].val()"),
                    None => "self.pixel.val()".to_owned(),
                };
                self.connect(&format!("{rows}.rows[{row}]"), &source);
            }
            self.connect(&format!("{rows}.held"), "self.held.y.val()");
            let outside = format!("self.tail.outside.val().get_bits::<{OUTER_ROWS}>({})", OUTER_ROWS * i as u64);
            self.connect(&format!("{rows}.outside"), &outside);
            let (bits, steps) = (4 * self.pixel_bits, CELL_STEPS * (self.longest() - m));
            let pixels = self.delay(&format!("rows_delay_{m}"), bits, steps, &format!("self.{rows}.y.val()"));
            for smoother in 0..self.look_ahead.len() {
                if self.look_ahead[smoother] == m {
                    self.connect(&format!("{}_smoother.rows", self.names[smoother]), &pixels);
                }
            }
        }
    }

    /// Declares and connects the smoothers.
    fn smoothers(&mut self) {
        let mut field = 0;
        for (name, m) in self.names.iter().zip(self.look_ahead.clone()) {
            let smoother = format!("{name}_smoother");
            self.cell(&smoother, &format!("Smoother{m}"), &format!("Smoother{m}::default()"));
            self.body += "\n";
            self.clock(&smoother);
            self.connect(&format!("{smoother}.address"), "self.counter.address.val()");
            self.connect(&format!("{smoother}.recursion_write_address"), "self.counter.recursion_write_address.val()");
            self.connect(&format!("{smoother}.rows_load"), &format!("self.rows_load_{m}.y.val()"));
            for j in 0..m - 2 {
                self.connect(&format!("{smoother}.held[{j}]"), &format!("self.held_state_{j}.y.val()"));
                self.connect(&format!("{smoother}.outside[{j}]"), &format!("self.outside_delay_{j}.y.val()"));
                self.connect(&format!("{smoother}.stage_load[{j}]"), &format!("self.stage_load_{j}.y.val()"));
            }
            for (port, source) in [
                ("first_row", "recursion_cursor.first_row"),
                ("recursion_load", "recursion_load.y"),
                ("first_column", "row_cursor.first_column"),
                ("last_column", "row_cursor.last_column"),
                ("row_load", "row_load.y"),
            ] {
                self.connect(&format!("{smoother}.{port}"), &format!("self.{source}.val()"));
            }
            let bits = self.coefficient_bits;
            let coefficient = |field: u64| format!("self.bank.q.val().get_bits::<{bits}>({})", FIELD_BITS * field);
            self.connect(&format!("{smoother}.g"), &coefficient(field));
            for j in 0..m {
                self.connect(&format!("{smoother}.g_j[{j}]"), &coefficient(field + 1 + j));
            }
            field += 1 + m;
            let steps = row_steps(self.longest()) - row_steps(m);
            let y = self.delay(&format!("{name}_delay"), self.state_bits, steps, &format!("self.{smoother}.y.val()"));
            self.connect(name, &y);
        }
    }

    /// Joins the flags of all memories and of the bank.
    fn upsets(&mut self) {
        self.comment("A bit flipped in a memory or in the bank.");
        self.fields += "    recursion_upset: Signal<Local, Bit>,\n";
        self.initial += "            recursion_upset: Signal::default(),\n";
        let recursions: Vec<String> =
            self.names.iter().map(|name| format!("self.{name}_smoother.upset.val()")).collect();
        self.connect("recursion_upset", &recursions.join(" | "));
        let flags = ["line_memory.upset", "held.upset", "bank.upset", "recursion_upset"];
        self.connect("upset", &flags.map(|flag| format!("self.{flag}.val()")).join(" | "));
    }

    /// Returns the smoother types and the template with all parts.
    fn text(self) -> String {
        let mut types = String::new();
        for m in &self.lengths {
            types += &format!("smoother!(Smoother{m}, {m}, {}, \"module: smoother_{m}\");\n", m - 2);
        }
        let (mut ports, mut signals) = (String::new(), String::new());
        for (i, name) in self.names.iter().enumerate() {
            ports += &format!("    /// `G_{i}`.\n    pub {name}: Signal<Out, State>,\n");
            signals += &format!("            {name}: Signal::default(),\n");
        }
        let parts = [
            ("PORTS", ports),
            ("SIGNALS", signals),
            ("FIELDS", self.fields),
            ("INITIAL", self.initial),
            ("BODY", self.body),
        ];
        types + &parts.iter().fold(TEMPLATE.to_owned(), |text, (name, part)| text.replace(name, part))
    }
}
