//! `y[n] = x[n - N]`: delays of samples, flags, pulses and frame markers.
//!
//! There are four cells, because the cheapest one depends on the data. [`Delay`] stores every sample, in registers up
//! to three steps and in a small memory beyond. [`FlagDelay`] stores a bit in registers, which reset clears.
//! [`PulseDelay`] and [`FrameDelay`] count steps for a pulse that comes at most once in the counted time.

use std::collections::VecDeque;

use rust_hdl::prelude::*;

use super::{Column, Height, Row, Width, low, of_family};
use crate::design::{COLUMN_BITS, LINE_WORDS, ROW_BITS, WIDTH_BITS};

/// Longest delay of one memory: an MLAB has 32 words, and the output register adds one step.
pub const LONGEST_DELAY: usize = 33;

/// Up to this length a delay is cheaper in registers.
pub(super) const LONGEST_IN_REGISTERS: usize = 3;

/// A sample `steps` steps later. The output is undefined for that many steps after a reset.
#[derive(LogicBlock)]
pub struct Delay<const N: usize> {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high, of the memory's address counter.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Input sample.
    pub x: Signal<In, Bits<N>>,
    /// The sample `steps` steps ago.
    pub y: Signal<Out, Bits<N>>,
    _memory: Vec<Bits<N>>,
    _position: usize,
}

impl<const N: usize> Delay<N> {
    /// A delay of `steps`, 1 to [`LONGEST_DELAY`].
    pub fn new(steps: usize) -> Self {
        debug_assert!((1..=LONGEST_DELAY).contains(&steps));
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            x: Signal::default(),
            y: Signal::default(),
            _memory: vec![0u64.into(); steps - 1],
            _position: 0,
        }
    }

    fn steps(&self) -> usize {
        self._memory.len() + 1
    }
}

impl<const N: usize> Default for Delay<N> {
    fn default() -> Self {
        Self::new(1)
    }
}

impl<const N: usize> Logic for Delay<N> {
    fn update(&mut self) {
        if !self.clock.pos_edge() {
            return;
        }
        if self.advance.val() {
            if self._memory.is_empty() {
                self.y.next = self.x.val();
            } else {
                self.y.next = self._memory[self._position];
                self._memory[self._position] = self.x.val();
                self._position = (self._position + 1) % self._memory.len();
            }
        }
        // A delay in registers has no address to reset.
        if self.reset.val() && self.steps() > LONGEST_IN_REGISTERS {
            self._position = 0;
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        of_family("delay", &[("BITS", N.to_string()), ("STEPS", self.steps().to_string())])
    }
}

pub(super) fn address_bits(words: usize) -> usize {
    (usize::BITS - (words - 1).leading_zeros()).max(1) as usize
}

/// A bit `steps` steps later, 0 after reset.
#[derive(LogicBlock)]
pub struct FlagDelay {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. It clears the delayed bits.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Input bit.
    pub x: Signal<In, Bit>,
    /// The bit `steps` steps ago.
    pub y: Signal<Out, Bit>,
    _delayed: VecDeque<bool>,
}

impl FlagDelay {
    /// A delay of `steps`, at least 1.
    pub fn new(steps: usize) -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            x: Signal::default(),
            y: Signal::default(),
            _delayed: vec![false; steps].into(),
        }
    }
}

impl Default for FlagDelay {
    fn default() -> Self {
        Self::new(1)
    }
}

impl Logic for FlagDelay {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            if self.reset.val() {
                self._delayed.iter_mut().for_each(|bit| *bit = false);
                self.y.next = false;
            } else if self.advance.val() {
                self._delayed.push_front(self.x.val());
                self._delayed.pop_back();
                self.y.next = *self._delayed.back().expect("a delay has at least one step");
            }
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        of_family("flag_delay", &[("STEPS", self._delayed.len().to_string())])
    }
}

/// A pulse `steps` steps later, by counting: pulses must be at least `steps` apart.
#[derive(LogicBlock)]
pub struct PulseDelay {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. It clears the delayed bits.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Input pulse.
    pub x: Signal<In, Bit>,
    /// The pulse `steps` steps later.
    pub y: Signal<Out, Bit>,
    _steps: u64,
    _remaining: u64,
}

impl PulseDelay {
    /// A delay of `steps`, at least 2.
    pub fn new(steps: u64) -> Self {
        debug_assert!(steps >= 2);
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            x: Signal::default(),
            y: Signal::default(),
            _steps: steps,
            _remaining: 0,
        }
    }
}

impl Default for PulseDelay {
    fn default() -> Self {
        Self::new(2)
    }
}

impl Logic for PulseDelay {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            if self.reset.val() {
                self._remaining = 0;
                self.y.next = false;
            } else if self.advance.val() {
                self.y.next = self._remaining == 1;
                self._remaining = if self.x.val() { self._steps - 1 } else { self._remaining.saturating_sub(1) };
            }
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        of_family("pulse_delay", &[("STEPS", self._steps.to_string())])
    }
}

/// A frame marker `lines W + steps` steps later, by counting: markers must be at least that far apart.
#[derive(LogicBlock)]
pub struct FrameDelay {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. It clears the delayed bits.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`; changes only while the pipeline is empty.
    pub width: Signal<In, Width>,
    /// Input marker.
    pub x: Signal<In, Bit>,
    /// The marker, `lines W + steps` steps later.
    pub y: Signal<Out, Bit>,
    _lines: u64,
    _steps: u64,
    _total: u64,
    _remaining: u64,
}

impl FrameDelay {
    /// A delay of `lines W + steps` steps, each at least 1.
    pub fn new(lines: u64, steps: u64) -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            width: Signal::default(),
            x: Signal::default(),
            y: Signal::default(),
            _lines: lines,
            _steps: steps,
            _total: 0,
            _remaining: 0,
        }
    }
}

impl Default for FrameDelay {
    fn default() -> Self {
        Self::new(1, 1)
    }
}

impl FrameDelay {
    /// Bits of the count: what the widest frame needs, and more than a width has.
    fn bits(&self) -> usize {
        address_bits(self._lines as usize * LINE_WORDS + self._steps as usize).max(WIDTH_BITS + 1)
    }
}

impl Logic for FrameDelay {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            if self.reset.val() {
                self._remaining = 0;
                self.y.next = false;
            } else if self.advance.val() {
                self.y.next = self._remaining == 1;
                self._remaining = if self.x.val() { self._total } else { self._remaining.saturating_sub(1) };
            }
            self._total = (self._lines * self.width.val().to_u64() + self._steps - 1) & ((1 << self.bits()) - 1);
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        let (lines, steps) = (self._lines.to_string(), self._steps.to_string());
        of_family("frame_delay", &[("LINES", lines), ("STEPS", steps), ("WIDTH_BITS", WIDTH_BITS.to_string())])
    }
}

/// Column and row of the current sample, counted from the marker one step before the first sample of a frame.
#[derive(LogicBlock, Default)]
pub struct Cursor {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`, the columns of the frame.
    pub width: Signal<In, Width>,
    /// `H`, the rows of the frame.
    pub height: Signal<In, Height>,
    /// One step before the frame's first sample.
    pub start: Signal<In, Bit>,
    /// The sample belongs to a frame.
    pub active: Signal<Out, Bit>,
    /// Column of the sample.
    pub x: Signal<Out, Column>,
    /// Row of the sample.
    pub y: Signal<Out, Row>,
    /// `x = 0`.
    pub first_column: Signal<Out, Bit>,
    /// `x = W - 1`.
    pub last_column: Signal<Out, Bit>,
    /// `y = 0`.
    pub first_row: Signal<Out, Bit>,
    /// `y = H - 1`.
    pub last_row: Signal<Out, Bit>,
    _at: (bool, u64, u64),
}

impl Logic for Cursor {
    fn update(&mut self) {
        let (last_x, last_y) = (self.width.val().to_u64().wrapping_sub(1), self.height.val().to_u64().wrapping_sub(1));
        if self.clock.pos_edge() {
            let (active, x, y) = self._at;
            if self.reset.val() {
                self._at = (false, 0, 0);
            } else if self.advance.val() {
                self._at = if self.start.val() {
                    (true, 0, 0)
                } else if x == last_x {
                    (active && y != last_y, 0, low(y + 1, ROW_BITS))
                } else {
                    (active, low(x + 1, COLUMN_BITS), y)
                };
            }
        }
        let (active, x, y) = self._at;
        self.active.next = active;
        self.x.next = x.into();
        self.y.next = y.into();
        self.first_column.next = active && x == 0;
        self.last_column.next = active && x == last_x;
        self.first_row.next = active && y == 0;
        self.last_row.next = active && y == last_y;
    }

    fn connect(&mut self) {
        self.active.connect();
        self.x.connect();
        self.y.connect();
        self.first_column.connect();
        self.last_column.connect();
        self.first_row.connect();
        self.last_row.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: cursor
wire [WIDTH_BITS-1:0] last_x = width - WIDTH_BITS'd1;
wire [HEIGHT_BITS-1:0] last_y = height - HEIGHT_BITS'd1;
wire        at_last_x = {1'b0, x} == last_x;
wire        at_last_y = {1'b0, y} == last_y;

always @(posedge clock)
  if (reset) begin
    active <= 1'b0;
    x      <= COLUMN_BITS'd0;
    y      <= ROW_BITS'd0;
  end else if (advance) begin
    if (start) begin
      active <= 1'b1;
      x      <= COLUMN_BITS'd0;
      y      <= ROW_BITS'd0;
    end else if (at_last_x) begin
      active <= active & ~at_last_y;
      x      <= COLUMN_BITS'd0;
      y      <= y + ROW_BITS'd1;
    end else
      x <= x + COLUMN_BITS'd1;
  end

always @(*) begin
  first_column = active & (x == COLUMN_BITS'd0);
  last_column  = active & at_last_x;
  first_row    = active & (y == ROW_BITS'd0);
  last_row     = active & at_last_y;
end
"
            .into(),
        )
    }
}
