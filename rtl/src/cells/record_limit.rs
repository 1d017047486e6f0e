//! The ceiling on the records of a frame: of too many features some are withheld, and counted.
//!
//! The law is that of [`hoverlock_fixed_point::model::record_limit`]: `left` features may still be sent, and a feature
//! of pair `k` must reach `gate_k`. The state of a frame is loaded at the end of row 17, the last without an eligible
//! pixel. A row ends 18 steps after its last eligible pixel and the next such pixel is 18 steps later, so a band never
//! ends in the step of a feature or the step before it. A response comes a step before it is known to be a feature, and
//! is compared then, with the gate and with the next higher one: a feature may raise the gates of the next step.

use rust_hdl::prelude::*;

use super::decision::MARGIN;
use super::queue::of_pairs;
use super::{Height, Response, Row, low, zeros};
use crate::design::{DOG_BITS, HEIGHT_BITS, SCALE_PAIRS};

/// Bits of the number of rows of a band: there are 64 bands.
const BAND_BITS: usize = HEIGHT_BITS - 6;

/// Passes features on or withholds them.
#[derive(LogicBlock, Default)]
pub struct RecordLimit {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `H`, the rows of the frame.
    pub height: Signal<In, Height>,
    /// Row of the sample at the centre of the window.
    pub y: Signal<In, Row>,
    /// The sample is the last of its row.
    pub last_column: Signal<In, Bit>,
    /// `L`, the largest number of features that the frame sends.
    pub limit: Signal<In, Bits<16>>,
    /// `T_k` of the frame, set before row 17 ends.
    pub threshold: [Signal<In, Response>; SCALE_PAIRS],
    /// Found at scale pair `k`.
    pub hit: [Signal<In, Bit>; SCALE_PAIRS],
    /// Response of scale pair `k`, one step before `hit`.
    pub p: [Signal<In, Response>; SCALE_PAIRS],
    /// The feature of scale pair `k` is sent.
    pub keep: [Signal<Out, Bit>; SCALE_PAIRS],
    /// Number of features withheld, one step later.
    pub withheld: Signal<Out, Bits<2>>,
    _left: u64,
    _quota: u64,
    /// Rows of the present band that have ended, and the last row of a band, counted from 0.
    _rows: u64,
    _last_row: u64,
    _gate: [u64; SCALE_PAIRS],
    /// The response of the step before reaches the gate of that step, and the next higher one.
    _reached: [bool; SCALE_PAIRS],
    _reached_higher: [bool; SCALE_PAIRS],
    /// The step before has raised the gates.
    _was_raised: bool,
}

/// Returns the gate after `gate`, if a feature that reaches it is withheld.
fn higher(gate: u64) -> u64 {
    (gate + (gate >> 2) + 1).min((1 << DOG_BITS) - 1)
}

impl RecordLimit {
    /// Returns which features reach their gates, and which of them are sent.
    fn decided(&self) -> ([bool; SCALE_PAIRS], [bool; SCALE_PAIRS]) {
        let reached = if self._was_raised { &self._reached_higher } else { &self._reached };
        let passes: [bool; SCALE_PAIRS] = std::array::from_fn(|k| self.hit[k].val() && reached[k]);
        let before = |k: usize| passes[..k].iter().filter(|passes| **passes).count() as u64;
        (passes, std::array::from_fn(|k| passes[k] && self._left > before(k)))
    }

    fn step(&mut self) {
        let (passes, keep) = self.decided();
        let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count() as u64;
        let hits = self.hit.each_ref().map(|hit| hit.val());
        self.withheld.next = (count(&hits) - count(&keep)).into();
        self._was_raised = count(&passes) > count(&keep);
        let reached = |gate: fn(u64) -> u64| std::array::from_fn(|k| self.p[k].val().to_u64() >= gate(self._gate[k]));
        (self._reached, self._reached_higher) = (reached(|gate| gate), reached(higher));
        let (limit, last_column) = (self.limit.val().to_u64(), self.last_column.val());
        if last_column && self.y.val().to_u64() == MARGIN - 1 {
            self._quota = limit >> 6;
            self._left = (limit & 63) + self._quota;
            self._rows = 0;
            self._gate = self.threshold.each_ref().map(|threshold| threshold.val().to_u64());
            return;
        }
        let band_ends = last_column && self._rows == self._last_row;
        self._left = low(self._left - count(&keep) + if band_ends { self._quota } else { 0 }, 17);
        if last_column {
            self._rows = if band_ends { 0 } else { low(self._rows + 1, BAND_BITS) };
        }
        for (gate, threshold) in self._gate.iter_mut().zip(&self.threshold) {
            if band_ends {
                *gate = low(gate.wrapping_sub(*gate >> 2).wrapping_sub(1), DOG_BITS).max(threshold.val().to_u64());
            } else if self._was_raised {
                *gate = higher(*gate);
            }
        }
    }
}

impl Logic for RecordLimit {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            let last_row = ((self.height.val().to_u64() + 27) >> 6).wrapping_sub(1);
            if self.reset.val() {
                (self._left, self._quota, self._rows, self._gate) = (0, 0, 0, [0; SCALE_PAIRS]);
                self.withheld.next = 0u64.into();
            } else if self.advance.val() {
                self.step();
            }
            self._last_row = low(last_row, BAND_BITS);
        }
        let (_, keep) = self.decided();
        self.keep.iter_mut().zip(keep).for_each(|(signal, keep)| signal.next = keep);
    }

    fn connect(&mut self) {
        self.keep.iter_mut().for_each(|keep| keep.connect());
        self.withheld.connect();
    }

    fn hdl(&self) -> Verilog {
        let each = |text: &str| of_pairs(|k| text.replace("_k", &format!("_{k}")), "");
        // Whether more are left than features of the pixel come before that of pair k.
        let enough = |k: usize| match k {
            0 => "over_0",
            1 => "(passes_0 ? over_1 : over_0)",
            _ => "((passes_0 & passes_1) ? over_2 : (passes_0 | passes_1) ? over_1 : over_0)",
        };
        let sum = |port: &str| of_pairs(|k| format!("{{1'b0, {port}_{k}}}"), " + ");
        Verilog::Custom(format!(
            "\
// module: record_limit
reg [16:0] left;
reg [9:0]  quota;
reg [{top}:0]  rows;
reg [{top}:0]  last_row;
{gates}{reached}reg was_raised;

wire begins = last_column & (y == ROW_BITS'd17);
wire band_ends = last_column & (rows == last_row);
{over}{passing}{kept}{moved}wire [1:0] hits = {hits};
wire [1:0] passing = {passings};
wire [1:0] keeping = {keepings};

always @(posedge clock) begin
  last_row <= height[{height_top}:6] - {{{rest}, height[5:0] < 6'd37}};
  if (advance) begin
    was_raised <= passing != keeping;
{compared}  end
end

always @(posedge clock)
  if (reset) begin
    left     <= 17'd0;
    quota    <= 10'd0;
    rows     <= {band_bits}'d0;
    withheld <= 2'd0;
{resets}  end else if (advance) begin
    withheld <= hits - keeping;
    if (begins) begin
      quota <= limit[15:6];
      left  <= {{11'd0, limit[5:0]}} + {{7'd0, limit[15:6]}};
      rows  <= {band_bits}'d0;
{loads}    end else begin
      left <= left - {{15'd0, keeping}} + (band_ends ? {{7'd0, quota}} : 17'd0);
      if (last_column)
        rows <= band_ends ? {band_bits}'d0 : rows + {band_bits}'d1;
      if (band_ends) begin
{lowers}      end else if (passing != keeping) begin
{raises}      end
    end
  end

always @(*) begin
{outputs}end
",
            top = BAND_BITS - 1,
            height_top = HEIGHT_BITS - 1,
            rest = zeros(BAND_BITS - 1),
            band_bits = BAND_BITS,
            gates = each("reg [DOG_BITS-1:0] gate_k;\n"),
            reached = each("reg reached_k;\nreg reached_higher_k;\n"),
            compared = each("    reached_k <= p_k >= gate_k;\n    reached_higher_k <= p_k >= higher_k;\n"),
            passing = each("wire passes_k = hit_k & (was_raised ? reached_higher_k : reached_k);\n"),
            over = of_pairs(|k| format!("wire over_{k} = left > 17'd{k};\n"), ""),
            kept = of_pairs(|k| format!("wire keeps_{k} = passes_{k} & {};\n", enough(k)), ""),
            hits = sum("hit"),
            passings = sum("passes"),
            keepings = sum("keeps"),
            moved = each(
                "wire [SIGNED_BITS-1:0] raised_k = {1'b0, gate_k} + {3'd0, gate_k[DOG_BITS-1:2]} + SIGNED_BITS'd1;\n\
                 wire [DOG_BITS-1:0] higher_k = raised_k[DOG_BITS] ? LARGEST : raised_k[DOG_BITS-1:0];\n\
                 wire [DOG_BITS-1:0] lowered_k = gate_k - {2'd0, gate_k[DOG_BITS-1:2]} - DOG_BITS'd1;\n"
            )
            .replace("LARGEST", &format!("{DOG_BITS}'h{:x}", (1 << DOG_BITS) - 1)),
            resets = each("    gate_k   <= DOG_BITS'd0;\n"),
            loads = each("      gate_k <= threshold_k;\n"),
            lowers = each("        gate_k <= lowered_k > threshold_k ? lowered_k : threshold_k;\n"),
            raises = each("        gate_k <= higher_k;\n"),
            outputs = each("  keep_k = keeps_k;\n"),
        ))
    }
}
