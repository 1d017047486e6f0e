//! What a frame takes with it: 19 coefficients, thresholds and how they are found, handed on from part to part of the pipeline.
//!
//! From the lowest bit, 16 bits each: `g, g_0 .. g_4` of the narrow smoother, the same of the middle one, `g, g_0 .. g_5` of the
//! wide one, the two manual thresholds, the count they are to reach, and the mode, automatic in its lowest bit. The rows of
//! the next frame may arrive while this one is still in the pipeline, hence three banks, each loaded when a frame enters its part.

use rust_hdl::prelude::*;

/// Words of a bank.
pub const BANK_WORDS: usize = 23;

/// See the module.
#[derive(LogicBlock, Default)]
pub struct Bank {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// Take the words over.
    pub load: Signal<In, Bit>,
    /// The words.
    pub d: Signal<In, Bits<368>>,
    /// The words of the frame.
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
