//! `y = p + round(c (q - p))`, `c = g / 2^C`: the cell that builds every filter, on sign and magnitude.
//!
//! With `d = |q - p|`, `t = (g d + 2^(C-1)) >> C`: `y = p + t` where `q >= p`, else `p - t`. Three steps from input to
//! output. Adding `t` and its rounding bit is one carry chain: `p - h - b = p + !h + !b` in two's complement, with `h`
//! the product without its lower `C` bits and `b` the bit below `h`.

use rust_hdl::prelude::*;

use super::{Coefficient, State, low};
use crate::design::{COEFFICIENT_BITS, STATE_BITS};

/// The lerp cell: one 18 x 18 multiplier.
#[derive(LogicBlock, Default)]
pub struct Lerp {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Start of the interpolation.
    pub p: Signal<In, State>,
    /// End of the interpolation.
    pub q: Signal<In, State>,
    /// Coefficient `g`, u0.C. It belongs to the operands of the previous step.
    pub g: Signal<In, Coefficient>,
    /// The result, three steps after `p` and `q`.
    pub y: Signal<Out, State>,
    _distance: (u64, u64, bool),
    _product: (u64, u64, bool),
}

impl Logic for Lerp {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.advance.val() {
            let (p, q) = (self.p.val().to_u64(), self.q.val().to_u64());
            let (product, start, minus) = self._product;
            let (upper, half) = (product >> COEFFICIENT_BITS, product >> (COEFFICIENT_BITS - 1) & 1);
            let y = if minus { start.wrapping_sub(upper + half) } else { start + upper + half };
            self.y.next = low(y, STATE_BITS).into();
            let (distance, start, minus) = self._distance;
            self._product = (distance * self.g.val().to_u64(), start, minus);
            self._distance = (p.abs_diff(q), p, q < p);
        }
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: lerp
wire [STATE_BITS:0] q_minus_p = {1'b0, q} - {1'b0, p};
wire [STATE_BITS-1:0] p_minus_q = p - q;

reg [STATE_BITS-1:0] distance;
reg        minus_1;
reg [STATE_BITS-1:0] p_1;
reg [PRODUCT_BITS-1:0] product;
reg        minus_2;
reg [STATE_BITS-1:0] p_2;

always @(posedge clock)
  if (advance) begin
    distance <= q_minus_p[STATE_BITS] ? p_minus_q : q_minus_p[STATE_BITS-1:0];
    minus_1  <= q_minus_p[STATE_BITS];
    p_1      <= p;

    product <= {COEFFICIENT_BITS'd0, distance} * {STATE_BITS'd0, g};
    minus_2 <= minus_1;
    p_2     <= p_1;

    y <= p_2 + (product[PRODUCT_BITS-1:COEFFICIENT_BITS] ^ {STATE_BITS{minus_2}}) \
         + {STATE_TOP'd0, product[COEFFICIENT_BITS-1] ^ minus_2};
  end
"
            .into(),
        )
    }
}
