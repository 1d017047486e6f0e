//! The held last row of a frame, which column look-ahead stages still need while the next frame arrives.
//!
//! A lerp of two equal samples is that sample, so row `H - 1` of the picture is row `H - 1` of every column look-ahead
//! stage: one line of pixels serves all stages of all smoothers.
//!
//! Let `n` be the number of lines since row `H - 1`, `M` the longest look-ahead. A row that is used with `k` lines of
//! delay beside one with `K > k` is outside the frame for `k < n <= K`, where the other one is inside. With
//! `q = 2^(m-2)`, `K = 2^M - q`, the rows `r + i q`, `i = 1 .. 3`, of the first two stages of a smoother of look-ahead
//! `m` have `k = K - i q`. The row that arrives at stage `j` has `k = 2^M - 2^(j+1)`, the filtered one `K = 2^M - 2^j`.

use rust_hdl::prelude::*;

use super::{Address, Pixel, Width, flag::Flag, low, protected};
use crate::design::{BANDS, COLUMN_BITS, LINE_WORDS, LOOK_AHEAD, MAX_LOOK_AHEAD, PARITY, PIXEL_BITS};

/// Returns for each row that may lie outside the frame the lines `k`, `K` of the module documentation: three rows for
/// each different look-ahead, the shortest first, then the stages from `j = 0`.
fn bands() -> Vec<(u64, u64)> {
    let all = 1u64 << MAX_LOOK_AHEAD;
    let mut look_ahead = LOOK_AHEAD.to_vec();
    look_ahead.dedup();
    let rows = look_ahead.iter().flat_map(|m| {
        let q = 1u64 << (m - 2);
        (1..=3).map(move |i| (all - q - i * q, all - q))
    });
    rows.chain((0..MAX_LOOK_AHEAD - 2).map(|j| (all - (2 << j), all - (1 << j)))).collect()
}

/// Counts the lines after the last row of a frame, and returns which rows lie outside it.
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
    /// The last pixel of a frame: line 1 begins one step later. Frames are at least 64 lines apart.
    pub start: Signal<In, Bit>,
    /// The row lies outside the frame, one bit for each of [`BANDS`] rows.
    pub outside: Signal<Out, Bits<BANDS>>,
    _at: (u64, u64, bool),
}

impl Logic for TailCounter {
    fn update(&mut self) {
        let last_x = self.width.val().to_u64().wrapping_sub(1);
        if self.clock.pos_edge() {
            let (x, line, active) = self._at;
            if self.reset.val() {
                self._at = (0, 0, false);
            } else if self.advance.val() {
                self._at = if self.start.val() {
                    (0, 1, true)
                } else if x == last_x {
                    (0, (line + 1) & 63, active && line != 63)
                } else {
                    (low(x + 1, COLUMN_BITS), line, active)
                };
            }
        }
        let (_, line, active) = self._at;
        let outside = |(from, to): (u64, u64)| u64::from(active && line > from && line <= to);
        let bits = bands().into_iter().enumerate().fold(0, |bits, (i, band)| bits | outside(band) << i);
        self.outside.next = bits.into();
    }

    fn connect(&mut self) {
        self.outside.connect();
    }

    fn hdl(&self) -> Verilog {
        let outside: String = bands()
            .into_iter()
            .enumerate()
            .map(|(i, (from, to))| match to {
                63 => format!("  outside[{i}] = active & (line > 6'd{from});\n"),
                _ => format!("  outside[{i}] = active & (line > 6'd{from}) & (line <= 6'd{to});\n"),
            })
            .collect();
        Verilog::Custom(format!(
            "\
// module: tail_counter
reg [COLUMN_BITS-1:0] x;
reg [5:0] line;
reg       active;
wire [WIDTH_BITS-1:0] last_x = width - WIDTH_BITS'd1;

always @(posedge clock)
  if (reset) begin
    active <= 1'b0;
    line   <= 6'd0;
    x      <= COLUMN_BITS'd0;
  end else if (advance) begin
    if (start) begin
      active <= 1'b1;
      line   <= 6'd1;
      x      <= COLUMN_BITS'd0;
    end else if ({{1'b0, x}} == last_x) begin
      active <= active & (line != 6'd63);
      line   <= line + 6'd1;
      x      <= COLUMN_BITS'd0;
    end else
      x <= x + COLUMN_BITS'd1;
  end

always @(*) begin
{outside}end
"
        ))
    }
}

/// A memory of one line of pixels.
#[derive(LogicBlock)]
pub struct HeldRow {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// The pixel belongs to the frame's last row.
    pub write: Signal<In, Bit>,
    /// Line memory address: the number of steps modulo `W`.
    pub address: Signal<In, Address>,
    /// The address one step ago.
    pub write_address: Signal<In, Address>,
    /// One pixel per step.
    pub x: Signal<In, Pixel>,
    /// The pixel of the last row in the column of `x`.
    pub y: Signal<Out, Pixel>,
    /// A pixel with a flipped bit was read, one step later.
    pub upset: Flag<Out>,
    _memory: Vec<Pixel>,
}

impl Default for HeldRow {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            advance: Signal::default(),
            write: Signal::default(),
            address: Signal::default(),
            write_address: Signal::default(),
            x: Signal::default(),
            y: Signal::default(),
            upset: Default::default(),
            _memory: vec![Pixel::default(); LINE_WORDS],
        }
    }
}

impl Logic for HeldRow {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            self.y.next = self._memory[self.address.val().index()];
            if self.write.val() {
                self._memory[self.write_address.val().index()] = self.x.val();
            }
        }
        self.upset.next = false;
    }

    fn connect(&mut self) {
        self.y.connect();
        self.upset.connect();
    }

    fn hdl(&self) -> Verilog {
        if PARITY == 1 {
            let text = "\
// module: held_row
reg [PIXEL_BITS:0] memory [0:LINE_WORDS-1];
reg [PIXEL_BITS:0] column;

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    if (write)
      memory[write_address] <= {^x, x};
  end

always @(*)
  y = column[PIXEL_BITS-1:0];
";
            return Verilog::Custom(text.to_owned() + &protected(PIXEL_BITS + 1, "^column"));
        }
        Verilog::Custom(
            "\
// module: held_row
reg [PIXEL_BITS-1:0] memory [0:LINE_WORDS-1];

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
