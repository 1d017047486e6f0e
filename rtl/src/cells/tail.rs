//! The held last row of a frame, which look-ahead stages still need while the next frame arrives.
//!
//! Column look-ahead stage `j` needs row `H - 1` in place of the arriving row for its last `2^j` rows. Counted in lines
//! `n` after that row, these are `2^j <= n < 2^(j+1)`. So no two stages need it at the same time, and one memory of one
//! line with one read port serves the chain. Every stage may use the row as it left the recursion, because a lerp of
//! equal samples is that sample.

use rust_hdl::prelude::*;

use super::{Address, State, Width, low};
use crate::design::{COLUMN_BITS, LINE_WORDS};

/// Selects the stage that needs the held row: stage `j` for `2^j <= n < 2^(j+1)` lines after `start`, delayed by `4 j`
/// steps.
#[derive(LogicBlock, Default)]
pub struct TailCounter {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`, the columns of the frame.
    pub width: Signal<In, Width>,
    /// Line 0 begins one step later; frames are at least 64 lines apart.
    pub start: Signal<In, Bit>,
    /// The stage that needs the row in the next step, one bit per stage.
    pub select: Signal<Out, Bits<6>>,
    /// The stage that needs the row in this step, one bit per stage.
    pub outside: Signal<Out, Bits<6>>,
    _at: (u64, u64, bool),
    /// The bits of the last 21 steps, the newest lowest; one element per stage.
    _delayed: [u64; 6],
}

impl Logic for TailCounter {
    fn update(&mut self) {
        let last_x = self.width.val().to_u64().wrapping_sub(1);
        if self.clock.pos_edge() {
            let (x, line, active) = self._at;
            if self.reset.val() {
                self._at = (0, 0, false);
                self._delayed = [0; 6];
            } else if self.advance.val() {
                for (stage, delayed_bits) in self._delayed.iter_mut().enumerate() {
                    *delayed_bits = *delayed_bits << 1 | band(active, line) >> stage & 1;
                }
                self._at = if self.start.val() {
                    (0, 0, true)
                } else if x == last_x {
                    (0, (line + 1) & 63, active && line != 63)
                } else {
                    (low(x + 1, COLUMN_BITS), line, active)
                };
            }
        }
        let (_, line, active) = self._at;
        // Bit i is i + 1 steps old.
        let bit = |stage: usize, steps: usize| match steps {
            0 => band(active, line) >> stage & 1,
            _ => self._delayed[stage] >> (steps - 1) & 1,
        };
        let pick = |later: usize| (0..6).fold(0, |bits, stage| bits | bit(stage, 4 * stage + later) << stage);
        self.select.next = pick(0).into();
        self.outside.next = pick(1).into();
    }

    fn connect(&mut self) {
        self.select.connect();
        self.outside.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: tail_counter
reg [COLUMN_BITS-1:0] x;
reg [5:0] line;
reg       active;
wire [WIDTH_BITS-1:0] last_x = width - WIDTH_BITS'd1;
wire [5:0] band;
assign band[5] = active & line[5];
assign band[4] = active & (line[5:4] == 2'd1);
assign band[3] = active & (line[5:3] == 3'd1);
assign band[2] = active & (line[5:2] == 4'd1);
assign band[1] = active & (line[5:1] == 5'd1);
assign band[0] = active & (line == 6'd1);

// Each stage's bit, delayed, the newest lowest.
reg        delayed_0;
reg [4:0]  delayed_1;
reg [8:0]  delayed_2;
reg [12:0] delayed_3;
reg [16:0] delayed_4;
reg [20:0] delayed_5;

always @(posedge clock)
  if (reset) begin
    delayed_0 <= 1'd0;
    delayed_1 <= 5'd0;
    delayed_2 <= 9'd0;
    delayed_3 <= 13'd0;
    delayed_4 <= 17'd0;
    delayed_5 <= 21'd0;
  end else if (advance) begin
    delayed_0 <= band[0];
    delayed_1 <= {delayed_1[3:0], band[1]};
    delayed_2 <= {delayed_2[7:0], band[2]};
    delayed_3 <= {delayed_3[11:0], band[3]};
    delayed_4 <= {delayed_4[15:0], band[4]};
    delayed_5 <= {delayed_5[19:0], band[5]};
  end

always @(posedge clock)
  if (reset) begin
    active <= 1'b0;
    line   <= 6'd0;
    x      <= COLUMN_BITS'd0;
  end else if (advance) begin
    if (start) begin
      active <= 1'b1;
      line   <= 6'd0;
      x      <= COLUMN_BITS'd0;
    end else if ({1'b0, x} == last_x) begin
      active <= active & (line != 6'd63);
      line   <= line + 6'd1;
      x      <= COLUMN_BITS'd0;
    end else
      x <= x + COLUMN_BITS'd1;
  end

always @(*) begin
  select  = {delayed_5[19], delayed_4[15], delayed_3[11], delayed_2[7], delayed_1[3], band[0]};
  outside = {delayed_5[20], delayed_4[16], delayed_3[12], delayed_2[8], delayed_1[4], delayed_0};
end
"
            .into(),
        )
    }
}

fn band(active: bool, line: u64) -> u64 {
    if active && line > 0 { 1 << line.ilog2() } else { 0 }
}

/// A memory of one line of states, read at the address of the stage that `select` names.
#[derive(LogicBlock)]
pub struct HeldRow {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// The sample belongs to the frame's last row.
    pub write: Signal<In, Bit>,
    /// The address one step ago.
    pub write_address: Signal<In, Address>,
    /// A sample of the recursion.
    pub x: Signal<In, State>,
    /// The stage that will need the row in the next step, one bit at most.
    pub select: Signal<In, Bits<6>>,
    /// Address for stage 0: delayed by the pipelines before the stage, as the following five.
    pub address_0: Signal<In, Address>,
    /// Address for stage 1.
    pub address_1: Signal<In, Address>,
    /// Address for stage 2.
    pub address_2: Signal<In, Address>,
    /// Address for stage 3.
    pub address_3: Signal<In, Address>,
    /// Address for stage 4.
    pub address_4: Signal<In, Address>,
    /// Address for stage 5.
    pub address_5: Signal<In, Address>,
    /// The held sample, for all stages.
    pub y: Signal<Out, State>,
    _memory: Vec<State>,
}

impl Default for HeldRow {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            advance: Signal::default(),
            write: Signal::default(),
            write_address: Signal::default(),
            x: Signal::default(),
            select: Signal::default(),
            address_0: Signal::default(),
            address_1: Signal::default(),
            address_2: Signal::default(),
            address_3: Signal::default(),
            address_4: Signal::default(),
            address_5: Signal::default(),
            y: Signal::default(),
            _memory: vec![State::default(); LINE_WORDS],
        }
    }
}

impl Logic for HeldRow {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let addresses =
                [&self.address_0, &self.address_1, &self.address_2, &self.address_3, &self.address_4, &self.address_5];
            let select = self.select.val();
            let address = addresses
                .iter()
                .enumerate()
                .filter(|(stage, _)| select.get_bit(*stage))
                .fold(0, |address, (_, this)| address | this.val().index());
            self.y.next = self._memory[address];
            if self.write.val() {
                self._memory[self.write_address.val().index()] = self.x.val();
            }
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: held_row
reg [STATE_BITS-1:0] memory [0:LINE_WORDS-1];
wire [COLUMN_BITS-1:0] address = ({COLUMN_BITS{select[0]}} & address_0) | ({COLUMN_BITS{select[1]}} & address_1) \
                             | ({COLUMN_BITS{select[2]}} & address_2)
                   | ({COLUMN_BITS{select[3]}} & address_3) | ({COLUMN_BITS{select[4]}} & address_4) \
                             | ({COLUMN_BITS{select[5]}} & address_5);

always @(posedge clock)
  if (advance) begin
    y <= memory[address];
    if (write)
      memory[write_address] <= x;
  end
"
            .into(),
        )
    }
}
