//! Maxima over columns and rows of a window, one comparison between two registers.
//!
//! [`ColumnMaximum`] takes seven samples of one column, `v_0` from the newest row, and gives the maxima of the parts
//! that the window tests need. [`WindowMaximum`] computes `y[n] = max(x[n], .., x[n - N + 1])` in `ceil(log2 N)` steps
//! by doubling: windows of two and four, then two overlapping windows of the largest power of two.

use rust_hdl::prelude::*;

use super::{Response, of_family};
use crate::design::{DOG_BITS, SIGNED_BITS, WINDOW_BITS};

/// Maxima of one column of the 7x7 window.
#[derive(LogicBlock, Default)]
pub struct ColumnMaximum {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `v_0`, the newest row.
    pub newest: Signal<In, Response>,
    /// `v_1 ..= v_6`, each below its sign, the newer lower; the signs are not used.
    pub older: Signal<In, Bits<WINDOW_BITS>>,
    /// `max(v_0 ..= v_2)`, the rows that come later than the middle.
    pub later: Signal<Out, Response>,
    /// `v_3`, the middle.
    pub middle: Signal<Out, Response>,
    /// `max(v_4 ..= v_6)`, the rows that come earlier.
    pub earlier: Signal<Out, Response>,
    /// `max(v_0 ..= v_4)`, the column of MaxDOG.
    pub five: Signal<Out, Response>,
    _first: [u64; 6],
    _second: [u64; 4],
}

impl Logic for ColumnMaximum {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let older = self.older.val();
            let v = |row: usize| older.get_bits::<DOG_BITS>(SIGNED_BITS * (row - 1)).to_u64();
            let [later, middle, earlier, three_four] = self._second;
            self.later.next = later.into();
            self.middle.next = middle.into();
            self.earlier.next = earlier.into();
            self.five.next = later.max(three_four).into();
            let [zero_one, two, three, four, five_six, three_four] = self._first;
            self._second = [zero_one.max(two), three, four.max(five_six), three_four];
            self._first = [self.newest.val().to_u64().max(v(1)), v(2), v(3), v(4), v(5).max(v(6)), v(3).max(v(4))];
        }
    }

    fn connect(&mut self) {
        self.later.connect();
        self.middle.connect();
        self.earlier.connect();
        self.five.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: column_maximum
wire [DOG_BITS-1:0] v1 = older[DOG_BITS-1:0];
wire [DOG_BITS-1:0] v2 = older[SIGNED_BITS+DOG_BITS-1:SIGNED_BITS];
wire [DOG_BITS-1:0] v3 = older[2*SIGNED_BITS+DOG_BITS-1:2*SIGNED_BITS];
wire [DOG_BITS-1:0] v4 = older[3*SIGNED_BITS+DOG_BITS-1:3*SIGNED_BITS];
wire [DOG_BITS-1:0] v5 = older[4*SIGNED_BITS+DOG_BITS-1:4*SIGNED_BITS];
wire [DOG_BITS-1:0] v6 = older[5*SIGNED_BITS+DOG_BITS-1:5*SIGNED_BITS];

reg [DOG_BITS-1:0] m01, v2_1, v3_1, v4_1, m56, m34;
reg [DOG_BITS-1:0] m012, v3_2, m456, m34_2;

always @(posedge clock)
  if (advance) begin
    m01  <= newest > v1 ? newest : v1;
    v2_1 <= v2;
    v3_1 <= v3;
    v4_1 <= v4;
    m56  <= v5 > v6 ? v5 : v6;
    m34  <= v3 > v4 ? v3 : v4;

    m012  <= m01 > v2_1 ? m01 : v2_1;
    v3_2  <= v3_1;
    m456  <= m56 > v4_1 ? m56 : v4_1;
    m34_2 <= m34;

    later   <= m012;
    middle  <= v3_2;
    earlier <= m456;
    five    <= m012 > m34_2 ? m012 : m34_2;
  end

wire unused = ^{older[SIGNED_BITS-1], older[2*SIGNED_BITS-1], older[3*SIGNED_BITS-1], \
               older[4*SIGNED_BITS-1], older[5*SIGNED_BITS-1], older[6*SIGNED_BITS-1]};
"
            .into(),
        )
    }
}

/// `y[n] = max(x[n], .., x[n - N + 1])`.
#[derive(LogicBlock)]
pub struct WindowMaximum {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// One sample per step.
    pub x: Signal<In, Response>,
    /// The running maximum.
    pub y: Signal<Out, Response>,
    _samples: usize,
    /// For each round the distance of the compared samples and the delayed inputs, newest first.
    _rounds: Vec<(usize, Vec<u64>)>,
}

impl WindowMaximum {
    /// A window of `samples`.
    pub fn new(samples: usize) -> Self {
        let rounds = shifts(samples).into_iter().map(|shift| (shift, vec![0; shift + 1])).collect();
        Self {
            clock: Signal::default(),
            advance: Signal::default(),
            x: Signal::default(),
            y: Signal::default(),
            _samples: samples,
            _rounds: rounds,
        }
    }
}

impl Default for WindowMaximum {
    fn default() -> Self {
        Self::new(2)
    }
}

/// The distance of the two compared values in each round: 1, 2, 4, .., and the rest in the last round.
fn shifts(samples: usize) -> Vec<usize> {
    let mut covered = 1;
    let mut shifts = Vec::new();
    while covered < samples {
        let shift = covered.min(samples - covered);
        shifts.push(shift);
        covered += shift;
    }
    shifts
}

impl Logic for WindowMaximum {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let mut input = self.x.val().to_u64();
            let last = self._rounds.len() - 1;
            let mut outputs = vec![];
            for (shift, delayed) in &self._rounds {
                outputs.push(input.max(delayed[shift - 1]));
                // The input of the next round is the register of this round, which still has the value of the previous
                // step.
                input = delayed[*shift];
            }
            self.y.next = outputs[last].into();
            let mut input = self.x.val().to_u64();
            for (round, output) in outputs.into_iter().enumerate() {
                let (shift, delayed) = &mut self._rounds[round];
                let register = delayed[*shift];
                delayed.insert(0, input);
                delayed.truncate(*shift);
                delayed.push(output);
                input = register;
            }
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        of_family("window_maximum", &[("BITS", DOG_BITS.to_string()), ("SAMPLES", self._samples.to_string())])
    }
}

/// `y = max(a, b)`, one step.
#[derive(LogicBlock, Default)]
pub struct Maximum {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// First operand.
    pub a: Signal<In, Response>,
    /// Second operand.
    pub b: Signal<In, Response>,
    /// The maximum, one step later.
    pub y: Signal<Out, Response>,
}

impl Logic for Maximum {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            self.y.next = self.a.val().to_u64().max(self.b.val().to_u64()).into();
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom("// module: maximum\nalways @(posedge clock)\n  if (advance)\n    y <= a > b ? a : b;\n".into())
    }
}
