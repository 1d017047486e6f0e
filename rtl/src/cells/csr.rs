//! The registers of [`hoverlock_registers`] behind an Avalon-MM slave: 32 bits, no wait states, data one cycle after
//! `read`.

use hoverlock_registers::{Access, Field, Register};
use rust_hdl::prelude::*;

use super::{Fields, Height, Response, Width, flag::Flag, low, zeros};
use crate::design::{
    COEFFICIENT_BITS, DOG_BITS, HEIGHT_BITS, MODE_AT, PARITY, RECORD_LIMIT_AT, SCALE_PAIRS, TARGET_AT, THRESHOLD_0_AT,
    WIDTH_BITS,
};

/// Bits of a register address, which counts 32-bit registers.
pub const WORD_ADDRESS_BITS: usize = 6;

/// The register bank: status, control, and the values that a frame captures, accessed through an Avalon-MM slave.
#[derive(LogicBlock)]
pub struct Csr {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Address of a 32-bit register.
    pub address: Signal<In, Bits<6>>,
    /// Read request of this cycle.
    pub read: Signal<In, Bit>,
    /// Read data, one cycle after the request.
    pub readdata: Signal<Out, Bits<32>>,
    /// Write request of this cycle.
    pub write: Signal<In, Bit>,
    /// Data of the write request.
    pub writedata: Signal<In, Bits<32>>,
    /// Interrupt request, level-sensitive, active high.
    pub irq: Signal<Out, Bit>,
    /// Reset of the pipeline.
    pub clear: Signal<Out, Bit>,
    /// Frames are accepted.
    pub enable: Signal<Out, Bit>,
    /// `W` of the next frame that begins.
    pub width: Signal<Out, Width>,
    /// `H` of the next frame that begins.
    pub height: Signal<Out, Height>,
    /// Register values that a frame captures.
    pub bank: Signal<Out, Fields>,
    /// `bank` is a complete set for the next frame that begins; otherwise that frame keeps the set of the previous one.
    pub committed: Signal<Out, Bit>,
    /// At least one frame is in the pipeline.
    pub busy: Signal<In, Bit>,
    /// Error bits of this cycle.
    pub errors: Signal<In, Bits<4>>,
    /// A frame begins at the next clock edge and captures the committed set.
    pub begun: Signal<In, Bit>,
    /// Pulse: a frame is complete.
    pub done: Signal<In, Bit>,
    /// Features of that frame.
    pub count: Signal<In, Bits<20>>,
    /// Dropped features of that frame.
    pub dropped: Signal<In, Bits<20>>,
    /// Number of complete frames.
    pub frames: Signal<In, Bits<32>>,
    /// A response was saturated.
    pub saturated: Signal<In, Bit>,
    /// Thresholds in use.
    pub threshold: [Signal<In, Response>; SCALE_PAIRS],
    /// A flipped bit was read.
    pub upset: Flag<In>,
    _map: Vec<Register>,
    _words: Vec<u32>,
    _read: u32,
    _clear: bool,
    /// `size` as the last frame captured it; 0 before the first.
    _captured_size: u32,
}

impl Csr {
    /// The slave of a register map.
    pub fn new(map: Vec<Register>) -> Self {
        let words = map.iter().map(Register::reset).collect();
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            address: Signal::default(),
            read: Signal::default(),
            readdata: Signal::default(),
            write: Signal::default(),
            writedata: Signal::default(),
            irq: Signal::default(),
            clear: Signal::default(),
            enable: Signal::default(),
            width: Signal::default(),
            height: Signal::default(),
            bank: Signal::default(),
            committed: Signal::default(),
            busy: Signal::default(),
            errors: Signal::default(),
            begun: Signal::default(),
            done: Signal::default(),
            count: Signal::default(),
            dropped: Signal::default(),
            frames: Signal::default(),
            saturated: Signal::default(),
            threshold: Default::default(),
            upset: Default::default(),
            _map: map,
            _words: words,
            _read: 0,
            _clear: false,
            _captured_size: 0,
        }
    }

    fn word(&self, name: &str) -> u32 {
        self._map.iter().position(|register| register.name == name).map_or(0, |i| self._words[i])
    }

    /// Returns the threshold of scale pair `k` that software sets: its register and its field.
    fn manual_threshold(&self, k: usize) -> Option<(&Register, &Field)> {
        let is_set = |field: &&Field| field.scale_pair == Some(k) && field.access == Access::ReadWrite;
        self._map.iter().find_map(|register| Some((register, register.fields.iter().find(is_set)?)))
    }

    /// Whether a write changes a register of the set.
    fn disturbs(&self, at: u32, data: u32) -> bool {
        match self._map.iter().find(|register| register.offset == at) {
            Some(register) if register.name == "control" => (data ^ self.word("control")) & 2 != 0,
            Some(register) => is_of_set(register),
            None => false,
        }
    }

    /// The status bits that hardware sets in a cycle.
    fn events(&self) -> u32 {
        let errors = self.errors.val().to_u32();
        let lost = self.done.val() && self.dropped.val().to_u32() != 0;
        u32::from(self.done.val())
            | errors << 1
            | u32::from(lost) << 5
            | u32::from(self.saturated.val()) << 6
            | u32::from(self.begun.val()) << 7
            | u32::from(self.upset.val()) << 8
    }

    /// The value that hardware drives in a read-only register.
    fn shown(&self, name: &str) -> Option<u32> {
        Some(match name {
            "status" => u32::from(self.busy.val()) << 31,
            "threshold_now" => in_halves(self.threshold.iter().take(2)),
            "threshold_now_2" => in_halves(self.threshold.iter().skip(2)),
            "frames" => self.frames.val().to_u32(),
            _ => return None,
        })
    }
}

/// Thresholds in 16 bits each, from the lowest.
fn in_halves<'a>(thresholds: impl Iterator<Item = &'a Signal<In, Response>>) -> u32 {
    (0..).zip(thresholds).fold(0, |word, (half, threshold)| word | threshold.val().to_u32() << (16 * half))
}

/// Whether a frame captures the register; a write to it then withdraws a commit.
fn is_of_set(register: &Register) -> bool {
    register.name != "control" && register.fields.iter().any(|field| field.access == Access::ReadWrite)
}

fn masked(register: &Register, access: Access) -> u32 {
    register.fields.iter().filter(|field| field.access == access).fold(0, |word, field| word | field.mask())
}

impl Logic for Csr {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            let clearing = std::mem::take(&mut self._clear);
            let at = self.address.val().to_u32() << 2;
            if self.read.val() {
                let found = self._map.iter().position(|register| register.offset == at);
                self._read = found.map_or(0, |i| self._words[i] | self.shown(&self._map[i].name).unwrap_or_default());
            }
            if self.reset.val() {
                self._words = self._map.iter().map(Register::reset).collect();
                self._clear = true;
                self._captured_size = 0;
            } else {
                let write = self.write.val().then(|| self.writedata.val().to_u32());
                let stays = !self.begun.val() && !write.is_some_and(|data| self.disturbs(at, data));
                if self.begun.val() && self.word("commit") != 0 {
                    self._captured_size = self.word("size");
                }
                // Events of the pipeline do not count while it is being reset.
                let (events, done, upset) =
                    if clearing { (0, false, false) } else { (self.events(), self.done.val(), self.upset.val()) };
                for (register, word) in self._map.iter().zip(&mut self._words) {
                    let data = write.filter(|_| register.offset == at);
                    if let Some(data) = data {
                        let kept = masked(register, Access::ReadWrite);
                        *word = *word & !kept | data & kept;
                        *word &= !(data & masked(register, Access::Clear));
                        self._clear |= data & masked(register, Access::Pulse) != 0;
                    }
                    match register.name.as_str() {
                        "status" => *word |= events,
                        "commit" => *word = *word & u32::from(stays) | data.unwrap_or_default() & 1,
                        "features" if done => *word = self.count.val().to_u32(),
                        "dropped" if done => *word = self.dropped.val().to_u32(),
                        "upsets" if upset => *word = (*word + 1).min(0xffff),
                        _ => {}
                    }
                }
            }
        }
        self.readdata.next = u64::from(self._read).into();
        self.clear.next = self._clear;
        let (control, status) = (self.word("control"), self.word("status"));
        let committed = self.word("commit") != 0;
        let size = if committed { self.word("size") } else { self._captured_size };
        self.committed.next = committed;
        self.enable.next = control & 1 != 0;
        self.irq.next = control & 4 != 0 && status & 1 != 0 || control & 8 != 0 && status & 0x17e != 0;
        self.width.next = low(u64::from(size), WIDTH_BITS).into();
        self.height.next = low(u64::from(size >> 16), HEIGHT_BITS).into();
        let mut bank = Fields::default();
        let coefficients = self._map.iter().zip(&self._words).filter(|(register, _)| register.is_coefficient());
        for (i, (_, word)) in coefficients.enumerate() {
            bank.set_bits(16 * i, Bits::<16>::from(u64::from(*word)));
        }
        for k in 0..SCALE_PAIRS {
            let threshold =
                self.manual_threshold(k).map_or(0, |(register, field)| self.word(&register.name) >> field.low);
            bank.set_bits(THRESHOLD_0_AT + 16 * k, Bits::<16>::from(low(u64::from(threshold), DOG_BITS)));
        }
        bank.set_bits(TARGET_AT, Bits::<16>::from(u64::from(self.word("target"))));
        bank.set_bits(MODE_AT, Bits::<16>::from(u64::from(control >> 1 & 1)));
        bank.set_bits(RECORD_LIMIT_AT, Bits::<16>::from(u64::from(self.word("record_limit"))));
        self.bank.next = bank;
    }

    fn connect(&mut self) {
        self.readdata.connect();
        self.irq.connect();
        self.clear.connect();
        self.enable.connect();
        self.width.connect();
        self.height.connect();
        self.bank.connect();
        self.committed.connect();
    }

    fn hdl(&self) -> Verilog {
        let (mut addresses, mut declarations) = (String::new(), String::new());
        let (mut resets, mut writes, mut cases) = (String::new(), String::new(), String::new());
        for register in &self._map {
            let word = address_name(register);
            addresses += &format!("localparam [5:0] {word} = 6'd{};\n", register.offset >> 2);
            let mut parts = Vec::new();
            let mut at = 32;
            for field in register.fields.iter().rev() {
                let high = field.low + field.bits;
                if high < at {
                    parts.push(format!("{}'d0", at - high));
                }
                at = field.low;
                let name = format!("{}_{}", register.name, field.name);
                let (bits, low, top) = (field.bits, field.low, field.low + field.bits - 1);
                let range = if bits == 1 { String::new() } else { format!("[{}:0] ", bits - 1) };
                let slice = if bits == 1 { format!("writedata[{low}]") } else { format!("writedata[{top}:{low}]") };
                parts.push(name.clone());
                match field.access {
                    Access::ReadWrite => {
                        declarations += &format!("reg  {range}{name};\n");
                        resets += &format!("    {name} <= {bits}'d{};\n", field.reset);
                        writes += &format!("    if (write & (address == {word}))\n      {name} <= {slice};\n");
                    }
                    Access::Clear => {
                        declarations += &format!("reg  {range}{name};\n");
                        resets += &format!("    {name} <= {bits}'d0;\n");
                        writes += &format!(
                            "    {name} <= ({name} & ~(write & (address == {word}) & {slice}))\n      \
                             | (~clear_now & {});\n",
                            event(&field.name)
                        );
                    }
                    Access::Pulse => {
                        declarations += &format!("reg  {range}clear_now;\nwire {range}{name} = 1'b0;\n");
                        resets += "    clear_now <= 1'b1;\n";
                        writes += &format!("    clear_now <= write & (address == {word}) & {slice};\n");
                    }
                    Access::Request => {
                        declarations += &format!("reg  {range}{name};\n");
                        resets += &format!("    {name} <= {bits}'d{};\n", field.reset);
                        writes += &format!(
                            "    {name} <= ({name} & ~disturbs & ~begun) \
                             | (write & (address == {word}) & {slice});\n"
                        );
                    }
                    Access::Read => match (register.name.as_str(), field.name.as_str()) {
                        ("features", _) | ("dropped", _) => {
                            let source = if register.name == "features" { "count" } else { "dropped" };
                            declarations += &format!("reg  {range}{name};\n");
                            resets += &format!("    {name} <= {bits}'d0;\n");
                            writes += &format!("    if (done & ~clear_now)\n      {name} <= {source};\n");
                        }
                        ("upsets", _) => {
                            declarations += &format!("reg  {range}{name};\n");
                            resets += &format!("    {name} <= {bits}'d0;\n");
                            writes += &format!(
                                "    if (upset & ~clear_now & ~&{name})\n      {name} <= {name} + {bits}'d1;\n"
                            );
                        }
                        ("status", _) => declarations += &format!("wire {range}{name} = busy;\n"),
                        ("threshold_now" | "threshold_now_2", _) => {
                            let pair = field.scale_pair.unwrap_or_default();
                            declarations += &format!("wire {range}{name} = threshold_{pair};\n");
                        }
                        ("frames", _) => declarations += &format!("wire {range}{name} = frames;\n"),
                        _ => declarations += &format!("wire {range}{name} = {bits}'h{:x};\n", field.reset),
                    },
                }
            }
            if at > 0 {
                parts.push(format!("{at}'d0"));
            }
            cases += &format!("      {word}: readdata <= {{{}}};\n", list(&parts));
        }
        let coefficients: Vec<String> = self
            ._map
            .iter()
            .filter(|register| register.is_coefficient())
            .map(|register| match 16 - COEFFICIENT_BITS {
                0 => format!("{}_value", register.name),
                pad => format!("{}, {}_value", zeros(pad), register.name),
            })
            .rev()
            .collect();
        let of_set = |coefficient: bool| {
            let registers = self._map.iter().filter(|register| is_of_set(register));
            registers.filter(move |register| register.is_coefficient() == coefficient)
        };
        let mut disturbing: Vec<String> =
            of_set(false).map(|register| format!("(address == {})", address_name(register))).collect();
        let (first, last) = (of_set(true).min_by_key(|it| it.offset), of_set(true).max_by_key(|it| it.offset));
        if let (Some(first), Some(last)) = (first.map(address_name), last.map(address_name)) {
            disturbing.push(format!("((address >= {first}) & (address <= {last}))"));
        }
        disturbing.push("((address == AT_CONTROL) & (writedata[1] ^ control_automatic))".into());
        Verilog::Custom(format!(
            "// module: csr
// Addresses in words.
{addresses}
{declarations}
// A write to a register of the set withdraws the commit.
wire disturbs = write & ({});
// The size as the last frame took it.
reg  [WIDTH_BITS-1:0] taken_width;
reg  [HEIGHT_BITS-1:0] taken_height;

always @(posedge clock)
  if (reset) begin
{resets}    taken_width <= WIDTH_BITS'd0;
    taken_height <= HEIGHT_BITS'd0;
  end else begin
{writes}    if (begun & commit_pending) begin
      taken_width <= size_width;
      taken_height <= size_height;
    end
  end

always @(posedge clock)
  if (read)
    case (address)
{cases}      default: readdata <= 32'd0;
    endcase

always @(*) begin
  irq = (control_interrupt_frame & status_frame)
      | (control_interrupt_error & (status_short_frame | status_long_frame | status_interrupted | status_refused
                                          | status_dropped | status_saturated{}));
  clear  = clear_now;
  enable = control_enable;
  committed = commit_pending;
  width  = commit_pending ? size_width : taken_width;
  height = commit_pending ? size_height : taken_height;
  bank   = {{record_limit_count, 15'd0, control_automatic, target_count,
            {},
            {}}};
end
",
            disturbing.join("\n  | "),
            if PARITY == 1 { " | status_upset" } else { "" },
            (0..SCALE_PAIRS)
                .rev()
                .filter_map(|k| self.manual_threshold(k))
                .map(|(register, field)| format!("{}, {}_{}", zeros(16 - DOG_BITS), register.name, field.name))
                .collect::<Vec<_>>()
                .join(", "),
            coefficients.join(",\n            ")
        ))
    }
}

/// A list with commas, in lines of a readable length.
fn list(parts: &[String]) -> String {
    let (mut text, mut room) = (String::new(), 80usize);
    for (i, part) in parts.iter().enumerate() {
        let separator = match room.checked_sub(part.len() + 2) {
            _ if i == 0 => "",
            Some(_) => ", ",
            None => ",\n        ",
        };
        room = if separator.ends_with("  ") { 100 } else { room }.saturating_sub(part.len() + 2);
        text += separator;
        text += part;
    }
    text
}

/// The name of a register's address.
fn address_name(register: &Register) -> String {
    format!("AT_{}", register.name.to_uppercase())
}

/// The event that sets a status field.
fn event(field: &str) -> &'static str {
    match field {
        "frame" => "done",
        "short_frame" => "errors[0]",
        "long_frame" => "errors[1]",
        "interrupted" => "errors[2]",
        "refused" => "errors[3]",
        "dropped" => "done & (dropped != 20'd0)",
        "begun" => "begun",
        "upset" => "upset",
        _ => "saturated",
    }
}
