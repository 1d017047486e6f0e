//! The register values of one frame: the coefficients, a threshold for each scale pair, target,
//! mode and record limit.
//!
//! Fields of 16 bits from the lowest bit: `g, g_0 ..` of the narrowest smoother, the same of the wider ones, the manual
//! thresholds, the target count, the mode (bit 0: automatic), and the record limit. The next frame may enter the
//! pipeline while this one is still in it. So there are two banks: one captures the set as a frame begins, the other is
//! loaded just before the frame reaches its first column stage and serves all stages and the window.
//!
//! A bank keeps its values until the next commit, so a flipped bit in it would change every frame from then on. In a
//! protected design a parity bit is loaded with the values and compared in each clock.

use rust_hdl::prelude::*;

use super::{Fields, flag::Flag};
use crate::design::PARITY;

/// A bank with a load enable.
#[derive(LogicBlock, Default)]
pub struct Bank {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Load enable.
    pub load: Signal<In, Bit>,
    /// Input, fields of 16 bits.
    pub d: Signal<In, Fields>,
    /// Fields of the frame.
    pub q: Signal<Out, Fields>,
    /// A bit of `q` has flipped, one clock later.
    pub upset: Flag<Out>,
}

impl Logic for Bank {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.load.val() {
            self.q.next = self.d.val();
        }
        self.upset.next = false;
    }

    fn connect(&mut self) {
        self.q.connect();
        self.upset.connect();
    }

    fn hdl(&self) -> Verilog {
        if PARITY == 1 {
            let text = "\
// module: bank
reg parity;
reg loaded;
initial loaded = 1'b0;

always @(posedge clock) begin
  if (load) begin
    q      <= d;
    parity <= ^d;
    loaded <= 1'b1;
  end
  upset <= loaded & (^{parity, q});
end
";
            return Verilog::Custom(text.into());
        }
        Verilog::Custom("// module: bank\nalways @(posedge clock)\n  if (load)\n    q <= d;\n".into())
    }
}
