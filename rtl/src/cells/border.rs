//! What a filter stage takes instead of a sample that lies outside the frame, and the coefficient it takes with it.
//!
//! `p` is the sample the stage leans on and `q` the one it moves towards `p`; both leave one step after they came.
//! A lerp of two equal words is that word, so the border sample is the same after every stage: look-ahead stages share one.

use rust_hdl::prelude::*;

use super::{Code, State};

/// Steps from the samples to `p` and `q`.
pub const BORDER_STEPS: u32 = 1;

/// Along columns: `p` is the sample, or the border's.
#[derive(LogicBlock, Default)]
pub struct ColumnBorder {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// What becomes `q`.
    pub x: Signal<In, State>,
    /// What becomes `p` inside the frame.
    pub neighbour: Signal<In, State>,
    /// What becomes `p` at the border.
    pub border: Signal<In, State>,
    /// Take the border's.
    pub outside: Signal<In, Bit>,
    /// One operand of the lerp.
    pub p: Signal<Out, State>,
    /// The other.
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

/// Along rows, towards the past: `q[c] = x[c]`, `p[c] = x[max(c - N, 0)]`.
#[derive(LogicBlock)]
pub struct LookBackBorder {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No row is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// The sample is the row's first.
    pub first: Signal<In, Bit>,
    /// The sample.
    pub x: Signal<In, State>,
    /// The sample `N` steps before.
    pub past: Signal<In, State>,
    /// One operand of the lerp.
    pub p: Signal<Out, State>,
    /// The other.
    pub q: Signal<Out, State>,
    _reach: u64,
    _left: u64,
    _border: State,
}

/// Along rows, towards the future: `p[c] = x[min(c + N, W - 1)]`, `q[c] = x[c]`.
#[derive(LogicBlock)]
pub struct LookAheadBorder {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// No row is under way.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// The arriving sample is the row's last.
    pub last: Signal<In, Bit>,
    /// The arriving sample.
    pub x: Signal<In, State>,
    /// The sample `N` steps before, the one to be smoothed.
    pub past: Signal<In, State>,
    /// One operand of the lerp.
    pub p: Signal<Out, State>,
    /// The other.
    pub q: Signal<Out, State>,
    _reach: u64,
    _left: u64,
    _border: State,
}

macro_rules! row_border {
    ($border:ident) => {
        impl $border {
            /// A stage that reaches `reach` samples, less than a row.
            pub fn new(reach: u64) -> Self {
                Self { _reach: reach, ..Self::default() }
            }
        }
    };
}
row_border!(LookBackBorder);
row_border!(LookAheadBorder);

impl Default for LookBackBorder {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            first: Signal::default(),
            x: Signal::default(),
            past: Signal::default(),
            p: Signal::default(),
            q: Signal::default(),
            _reach: 1,
            _left: 0,
            _border: State::default(),
        }
    }
}

impl Default for LookAheadBorder {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            last: Signal::default(),
            x: Signal::default(),
            past: Signal::default(),
            p: Signal::default(),
            q: Signal::default(),
            _reach: 1,
            _left: 0,
            _border: State::default(),
        }
    }
}

fn bits_for(largest: u64) -> usize {
    (64 - largest.leading_zeros()) as usize
}

impl Logic for LookBackBorder {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            let outside = self._left != 0;
            let (first, advance) = (self.first.val(), self.advance.val());
            if self.reset.val() {
                self._left = 0;
            } else if advance {
                self._left = if first { self._reach - 1 } else { self._left.saturating_sub(1) };
            }
            if advance {
                let sample = self.x.val();
                self.q.next = sample;
                self.p.next = match (first, outside) {
                    (true, _) => sample,
                    (false, true) => self._border,
                    (false, false) => self.past.val(),
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
        let reach = self._reach;
        if reach == 1 {
            // Only the first sample itself has no past: nothing to count or to hold.
            return Verilog::Custom(
                "\
// module: look_back_border_1
always @(posedge clock)
  if (advance) begin
    p <= first ? x : past;
    q <= x;
  end

wire unused = reset;
"
                .into(),
            );
        }
        let bits = bits_for(reach - 1);
        Verilog::Custom(format!(
            "// module: look_back_border_{reach}
reg [{top}:0] left;
reg [17:0] border;
wire outside = left != {bits}'d0;

always @(posedge clock)
  if (reset)
    left <= {bits}'d0;
  else if (advance) begin
    if (first)
      left <= {bits}'d{load};
    else if (outside)
      left <= left - {bits}'d1;
  end

always @(posedge clock)
  if (advance) begin
    if (first)
      border <= x;
    p <= first ? x : outside ? border : past;
    q <= x;
  end
",
            top = bits - 1,
            load = reach - 1
        ))
    }
}

impl Logic for LookAheadBorder {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            let outside = self._left != 0;
            let (last, advance) = (self.last.val(), self.advance.val());
            if self.reset.val() {
                self._left = 0;
            } else if advance {
                self._left = if last { self._reach } else { self._left.saturating_sub(1) };
            }
            if advance {
                self.q.next = self.past.val();
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
        let reach = self._reach;
        let bits = bits_for(reach);
        Verilog::Custom(format!(
            "// module: look_ahead_border_{reach}
reg [{top}:0] left;
reg [17:0] border;
wire outside = left != {bits}'d0;

always @(posedge clock)
  if (reset)
    left <= {bits}'d0;
  else if (advance) begin
    if (last)
      left <= {bits}'d{reach};
    else if (outside)
      left <= left - {bits}'d1;
  end

always @(posedge clock)
  if (advance) begin
    if (last)
      border <= x;
    p <= outside ? border : x;
    q <= past;
  end
",
            top = bits - 1
        ))
    }
}

/// The coefficient a stage works with, taken over when the frame's marker passes.
#[derive(LogicBlock, Default)]
pub struct CoefficientRegister {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// The frame's marker.
    pub load: Signal<In, Bit>,
    /// The frame's coefficient.
    pub d: Signal<In, Code>,
    /// The stage's coefficient.
    pub g: Signal<Out, Code>,
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
