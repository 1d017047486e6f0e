//! The register values of one frame: 19 coefficients, two thresholds, target and mode.
//!
//! Fields of 16 bits from the lowest bit: `g, g_0 .. g_4` of the narrow smoother, the same of the middle one,
//! `g, g_0 .. g_5` of the wide one, the two manual thresholds, the target count, and the mode (bit 0: automatic). The
//! next frame may enter the pipeline while this one is still in it. So there are three banks, and each is loaded when a
//! frame enters its part of the pipeline.

use rust_hdl::prelude::*;

/// Fields of a bank.
pub const BANK_FIELDS: usize = 23;

/// A bank of 23 fields with a load enable.
#[derive(LogicBlock, Default)]
pub struct Bank {
    /// Clock.
    pub clock: Signal<In, Clock>,
    /// Load enable.
    pub load: Signal<In, Bit>,
    /// Input, 23 fields of 16 bits.
    pub d: Signal<In, Bits<368>>,
    /// Fields of the frame.
    pub q: Signal<Out, Bits<368>>,
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
