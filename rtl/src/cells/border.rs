//! The operands of a filter cell at the border of the frame, and the coefficient register of a stage.
//!
//! `y = lerp(p, q, g)`: `q` is the filtered sample and `p` the sample at the other end of the lerp. Both leave one step
//! after they came. A lerp of two equal samples is that sample, so the border sample is the same after every stage and
//! look-ahead stages share one.

use rust_hdl::prelude::*;

use super::{Coefficient, Pixel, PixelRows, STATE_BITS, State, of_family};
use crate::design::PIXEL_BITS;

/// Column border: `p` is the neighbour, or the border sample where the neighbour lies outside the frame.
#[derive(LogicBlock, Default)]
pub struct ColumnBorder {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Sample that becomes `q`.
    pub x: Signal<In, State>,
    /// Sample that becomes `p` inside the frame.
    pub neighbour: Signal<In, State>,
    /// Sample that becomes `p` at the border.
    pub border: Signal<In, State>,
    /// Select the border sample.
    pub outside: Signal<In, Bit>,
    /// Operand `p` of the lerp.
    pub p: Signal<Out, State>,
    /// Operand `q` of the lerp.
    pub q: Signal<Out, State>,
}

impl Logic for ColumnBorder {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            self.p.next = if self.outside.val() { self.border.val() } else { self.neighbour.val() };
            self.q.next = self.x.val();
        }
    }

    fn connect(&mut self) {
        self.p.connect();
        self.q.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: column_border
always @(posedge clock)
  if (advance) begin
    p <= outside ? border : neighbour;
    q <= x;
  end
"
            .into(),
        )
    }
}

/// The rows of a column that the first two stages of a smoother use, with the last row of the frame in place of rows
/// outside it.
#[derive(LogicBlock, Default)]
pub struct RepeatedRows {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Pixels of rows `r`, `r + q`, `r + 2 q` and `r + 3 q`.
    pub rows: [Signal<In, Pixel>; 4],
    /// Pixel of the last row.
    pub held: Signal<In, Pixel>,
    /// Rows `r + q`, `r + 2 q` and `r + 3 q` lie outside the frame.
    pub outside: Signal<In, Bits<3>>,
    /// The four pixels one step later, that of row `r` lowest.
    pub y: Signal<Out, PixelRows>,
}

impl Logic for RepeatedRows {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let mut rows = PixelRows::default();
            for (i, row) in self.rows.iter().enumerate() {
                let outside = i > 0 && self.outside.val().get_bit(i - 1);
                rows.set_bits(i * PIXEL_BITS, if outside { self.held.val() } else { row.val() });
            }
            self.y.next = rows;
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: repeated_rows
always @(posedge clock)
  if (advance)
    y <= {outside[2] ? held : rows_3, outside[1] ? held : rows_2, outside[0] ? held : rows_1, rows_0};
"
            .into(),
        )
    }
}

/// Row look-back border: `q[c] = x[c]`, `p[c] = x[max(c - N, 0)]`.
#[derive(LogicBlock)]
pub struct RowLookBackBorder {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// The sample is the row's first.
    pub first: Signal<In, Bit>,
    /// The sample.
    pub x: Signal<In, State>,
    /// The sample `N` steps ago.
    pub delayed: Signal<In, State>,
    /// Operand `p` of the lerp.
    pub p: Signal<Out, State>,
    /// Operand `q` of the lerp.
    pub q: Signal<Out, State>,
    _reach: u64,
    _remaining: u64,
    _border: State,
}

/// Row look-ahead border: `p[c] = x[min(c + N, W - 1)]`, `q[c] = x[c]`.
#[derive(LogicBlock)]
pub struct RowLookAheadBorder {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// The arriving sample is the row's last.
    pub last: Signal<In, Bit>,
    /// The arriving sample.
    pub x: Signal<In, State>,
    /// The sample `N` steps ago, which is filtered.
    pub delayed: Signal<In, State>,
    /// Operand `p` of the lerp.
    pub p: Signal<Out, State>,
    /// Operand `q` of the lerp.
    pub q: Signal<Out, State>,
    _reach: u64,
    _remaining: u64,
    _border: State,
}

macro_rules! row_border {
    ($border:ident) => {
        impl $border {
            /// The border of a stage with neighbours `reach` samples away, less than a row.
            pub fn new(reach: u64) -> Self {
                Self { _reach: reach, ..Self::default() }
            }
        }
    };
}
row_border!(RowLookBackBorder);
row_border!(RowLookAheadBorder);

impl Default for RowLookBackBorder {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            first: Signal::default(),
            x: Signal::default(),
            delayed: Signal::default(),
            p: Signal::default(),
            q: Signal::default(),
            _reach: 1,
            _remaining: 0,
            _border: State::default(),
        }
    }
}

impl Default for RowLookAheadBorder {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            last: Signal::default(),
            x: Signal::default(),
            delayed: Signal::default(),
            p: Signal::default(),
            q: Signal::default(),
            _reach: 1,
            _remaining: 0,
            _border: State::default(),
        }
    }
}

impl Logic for RowLookBackBorder {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            let outside = self._remaining != 0;
            let (first, advance) = (self.first.val(), self.advance.val());
            if self.reset.val() {
                self._remaining = 0;
            } else if advance {
                self._remaining = if first { self._reach - 1 } else { self._remaining.saturating_sub(1) };
            }
            if advance {
                let sample = self.x.val();
                self.q.next = sample;
                self.p.next = match (first, outside) {
                    (true, _) => sample,
                    (false, true) => self._border,
                    (false, false) => self.delayed.val(),
                };
                if first {
                    self._border = sample;
                }
            }
        }
    }

    fn connect(&mut self) {
        self.p.connect();
        self.q.connect();
    }

    fn hdl(&self) -> Verilog {
        of_family("row_look_back_border", &[("BITS", STATE_BITS.to_string()), ("DISTANCE", self._reach.to_string())])
    }
}

impl Logic for RowLookAheadBorder {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            let outside = self._remaining != 0;
            let (last, advance) = (self.last.val(), self.advance.val());
            if self.reset.val() {
                self._remaining = 0;
            } else if advance {
                self._remaining = if last { self._reach } else { self._remaining.saturating_sub(1) };
            }
            if advance {
                self.q.next = self.delayed.val();
                self.p.next = if outside { self._border } else { self.x.val() };
                if last {
                    self._border = self.x.val();
                }
            }
        }
    }

    fn connect(&mut self) {
        self.p.connect();
        self.q.connect();
    }

    fn hdl(&self) -> Verilog {
        of_family("row_look_ahead_border", &[("BITS", STATE_BITS.to_string()), ("DISTANCE", self._reach.to_string())])
    }
}

/// The coefficient of a stage, loaded when the marker of a frame passes.
#[derive(LogicBlock, Default)]
pub struct CoefficientRegister {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// The frame's marker.
    pub load: Signal<In, Bit>,
    /// The frame's coefficient.
    pub d: Signal<In, Coefficient>,
    /// The stage's coefficient.
    pub g: Signal<Out, Coefficient>,
}

impl Logic for CoefficientRegister {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() && self.load.val() {
            self.g.next = self.d.val();
        }
    }

    fn connect(&mut self) {
        self.g.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "// module: coefficient_register\nalways @(posedge clock)\n  if (advance & load)\n    g <= d;\n".into(),
        )
    }
}
