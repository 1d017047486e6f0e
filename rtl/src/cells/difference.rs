//! `DOG = min((|narrow - wide| + 2^(s-1)) >> s, 2^N - 1)` and the sign of `narrow - wide` before rounding, in two
//! steps.

use rust_hdl::prelude::*;

use super::{Response, State};
use crate::design::{DOG_BITS, DOG_SHIFT};

/// The difference of Gaussians of one scale pair.
#[derive(LogicBlock, Default)]
pub struct Difference {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Sample of the narrower smoother.
    pub narrow: Signal<In, State>,
    /// Sample of the wider smoother.
    pub wide: Signal<In, State>,
    /// `DOG`.
    pub magnitude: Signal<Out, Response>,
    /// `narrow >= wide`.
    pub positive: Signal<Out, Bit>,
    /// The magnitude was saturated to `2^N - 1`.
    pub saturated: Signal<Out, Bit>,
    _distance: (u64, bool),
}

impl Logic for Difference {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let (distance, positive) = self._distance;
            let (half, most) = ((1 << DOG_SHIFT) >> 1, (1 << DOG_BITS) - 1);
            let rounded = (distance + half) >> DOG_SHIFT;
            self.magnitude.next = rounded.min(most).into();
            self.saturated.next = rounded > most;
            self.positive.next = positive;
            let (narrow, wide) = (self.narrow.val().to_u64(), self.wide.val().to_u64());
            self._distance = (narrow.abs_diff(wide), narrow >= wide);
        }
    }

    fn connect(&mut self) {
        self.magnitude.connect();
        self.positive.connect();
        self.saturated.connect();
    }

    fn hdl(&self) -> Verilog {
        let half = match DOG_SHIFT {
            0 => String::new(),
            shift => format!(" + DIFFERENCE_BITS'd{}", 1 << (shift - 1)),
        };
        let unused = match DOG_SHIFT {
            0 => String::new(),
            1 => "\nwire unused = rounded[0];\n".into(),
            shift => format!("\nwire unused = ^rounded[{}:0];\n", shift - 1),
        };
        let (low, top, most) = (DOG_SHIFT, DOG_SHIFT + DOG_BITS - 1, (1 << DOG_BITS) - 1);
        Verilog::Custom(format!(
            "\
// module: difference
wire [STATE_BITS:0] narrow_minus_wide = {{1'b0, narrow}} - {{1'b0, wide}};
wire [STATE_BITS-1:0] wide_minus_narrow = wide - narrow;

reg [STATE_BITS-1:0] distance;
reg        positive_1;
wire [STATE_BITS:0] rounded = {{1'b0, distance}}{half};
wire        over = |rounded[STATE_BITS:STATE_BITS-2];

always @(posedge clock)
  if (advance) begin
    distance   <= narrow_minus_wide[STATE_BITS] ? wide_minus_narrow : narrow_minus_wide[STATE_BITS-1:0];
    positive_1 <= ~narrow_minus_wide[STATE_BITS];

    magnitude <= over ? DOG_BITS'h{most:x} : rounded[{top}:{low}];
    saturated <= over;
    positive  <= positive_1;
  end
{unused}"
        ))
    }
}
