//! `DOG = min((|narrow - wide| + 1) >> 1, 2^15 - 1)` and the sign of `narrow - wide` before rounding, in two steps.

use rust_hdl::prelude::*;

use super::{Response, State};

/// Steps from the smoothed samples to the response.
pub const DIFFERENCE_STEPS: u32 = 2;

/// The difference of Gaussians of one scale pair.
#[derive(LogicBlock, Default)]
pub struct Difference {
    /// Clock.
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
    /// The magnitude was saturated to `2^15 - 1`.
    pub saturated: Signal<Out, Bit>,
    _distance: (u64, bool),
}

impl Logic for Difference {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let (distance, positive) = self._distance;
            let rounded = (distance + 1) >> 1;
            self.magnitude.next = rounded.min(0x7fff).into();
            self.saturated.next = rounded > 0x7fff;
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
        Verilog::Custom(
            "\
// module: difference
wire [18:0] narrow_minus_wide = {1'b0, narrow} - {1'b0, wide};
wire [17:0] wide_minus_narrow = wide - narrow;

reg [17:0] distance;
reg        positive_1;
wire [18:0] rounded = {1'b0, distance} + 19'd1;
wire        over = |rounded[18:16];

always @(posedge clock)
  if (advance) begin
    distance   <= narrow_minus_wide[18] ? wide_minus_narrow : narrow_minus_wide[17:0];
    positive_1 <= ~narrow_minus_wide[18];

    magnitude <= over ? 15'h7fff : rounded[15:1];
    saturated <= over;
    positive  <= positive_1;
  end

wire unused = rounded[0];
"
            .into(),
        )
    }
}
