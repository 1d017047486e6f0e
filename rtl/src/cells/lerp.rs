//! `y = p + round(c (q - p))`, `c = g / 2^16`: the cell that builds every filter, on sign and magnitude.
//!
//! With `d = |q - p|`, `t = (g d + 2^15) >> 16`: `y = p + t` where `q >= p`, else `p - t`. Three steps from input to
//! output. Adding `t` and its rounding bit is one carry chain: `p - h - b = p + !h + !b` in two's complement, with `h`
//! the product without its lower 16 bits and `b` the bit below `h`.

use rust_hdl::prelude::*;

use super::{Coefficient, STATE_BITS, State};

/// Steps from `p`, `q` to `y`. `g` is taken one step after them.
pub const LERP_STEPS: u32 = 3;

/// The lerp cell: one 18 x 18 multiplier.
#[derive(LogicBlock, Default)]
pub struct Lerp {
    /// Clock.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// Start of the interpolation.
    pub p: Signal<In, State>,
    /// End of the interpolation.
    pub q: Signal<In, State>,
    /// Coefficient `g`, u0.16. It belongs to the operands of the previous step.
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
            let (upper, half) = (product >> 16, product >> 15 & 1);
            let y = if minus { start.wrapping_sub(upper + half) } else { start + upper + half };
            self.y.next = (y & ((1 << STATE_BITS) - 1)).into();
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
wire [18:0] q_minus_p = {1'b0, q} - {1'b0, p};
wire [17:0] p_minus_q = p - q;

reg [17:0] distance;
reg        minus_1;
reg [17:0] p_1;
reg [33:0] product;
reg        minus_2;
reg [17:0] p_2;

always @(posedge clock)
  if (advance) begin
    distance <= q_minus_p[18] ? p_minus_q : q_minus_p[17:0];
    minus_1  <= q_minus_p[18];
    p_1      <= p;

    product <= {16'd0, distance} * {18'd0, g};
    minus_2 <= minus_1;
    p_2     <= p_1;

    y <= p_2 + (product[33:16] ^ {18{minus_2}}) + {17'd0, product[15] ^ minus_2};
  end
"
            .into(),
        )
    }
}
