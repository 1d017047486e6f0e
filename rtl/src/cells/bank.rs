//! The register values of one frame: the coefficients, a threshold for each scale pair, target,
//! mode and record limit.
//!
//! Fields of 16 bits from the lowest bit: `g, g_0 ..` of the narrowest smoother, the same of the wider ones, the manual
//! thresholds, the target count, the mode (bit 0: automatic), and the record limit. The next frame may enter the
//! pipeline while this one is still in it. So there are three banks, and each is loaded when a frame enters its part of
//! the pipeline.

use rust_hdl::prelude::*;

use super::Fields;

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
}

impl Logic for Bank {
    fn update(&mut self) {
        if self.clock.pos_edge() && self.load.val() {
            self.q.next = self.d.val();
        }
    }

    fn connect(&mut self) {
        self.q.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom("// module: bank\nalways @(posedge clock)\n  if (load)\n    q <= d;\n".into())
    }
}
