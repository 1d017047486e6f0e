//! `address[n] = n mod W`, counted in steps, and the same some steps before.

use std::collections::VecDeque;

use rust_hdl::prelude::*;

use super::{Address, Width};

/// The delays of [`AddressCounter`] in steps: one to write a line memory, five to write a recursion's, and four for each look-ahead
/// stage that reads the held row.
pub const ADDRESS_DELAYS: [usize; 7] = [1, 4, 5, 8, 12, 16, 20];

/// The one address counter of all line memories.
///
/// The width changes between frames, while no step is made, and may fall below the address: the first step of the next frame must not
/// use an address that the counter does not come back to, so `now` returns to 0 before it.
#[derive(LogicBlock, Default)]
pub struct AddressCounter {
    /// The one clock.
    pub clock: Signal<In, Clock>,
    /// Starts at 0.
    pub reset: Signal<In, Bit>,
    /// One step.
    pub advance: Signal<In, Bit>,
    /// `W`; changes only together with a reset of the counter or while no frame is under way.
    pub width: Signal<In, Width>,
    /// `n mod W`.
    pub now: Signal<Out, Address>,
    /// One step before.
    pub before_1: Signal<Out, Address>,
    /// Four steps before.
    pub before_4: Signal<Out, Address>,
    /// Five steps before.
    pub before_5: Signal<Out, Address>,
    /// Eight steps before.
    pub before_8: Signal<Out, Address>,
    /// Twelve steps before.
    pub before_12: Signal<Out, Address>,
    /// Sixteen steps before.
    pub before_16: Signal<Out, Address>,
    /// Twenty steps before.
    pub before_20: Signal<Out, Address>,
    _past: VecDeque<u64>,
}

impl Logic for AddressCounter {
    fn update(&mut self) {
        if self._past.is_empty() {
            self._past = vec![0; 21].into();
        }
        if self.clock.pos_edge() {
            let last = self.width.val().to_u64().wrapping_sub(1);
            if self.reset.val() {
                self._past.iter_mut().for_each(|address| *address = 0);
            } else if self.advance.val() {
                let now = self._past[0];
                self._past.push_front(if now >= last { 0 } else { (now + 1) & 0x3ff });
                self._past.pop_back();
            } else if self._past[0] > last {
                self._past[0] = 0;
            }
        }
        let past = &self._past;
        self.now.next = past[0].into();
        self.before_1.next = past[1].into();
        self.before_4.next = past[4].into();
        self.before_5.next = past[5].into();
        self.before_8.next = past[8].into();
        self.before_12.next = past[12].into();
        self.before_16.next = past[16].into();
        self.before_20.next = past[20].into();
    }

    fn connect(&mut self) {
        self.now.connect();
        self.before_1.connect();
        self.before_4.connect();
        self.before_5.connect();
        self.before_8.connect();
        self.before_12.connect();
        self.before_16.connect();
        self.before_20.connect();
    }

    fn hdl(&self) -> Verilog {
        let taps: String =
            ADDRESS_DELAYS.iter().map(|n| format!("  before_{n} = past[{}:{}];\n", n * 10 - 1, (n - 1) * 10)).collect();
        Verilog::Custom(format!(
            "// module: address_counter
wire [10:0] last = width - 11'd1;
reg [199:0] past;

always @(posedge clock)
  if (reset) begin
    now  <= 10'd0;
    past <= 200'd0;
  end else if (advance) begin
    now  <= {{1'b0, now}} >= last ? 10'd0 : now + 10'd1;
    past <= {{past[189:0], now}};
  end else if ({{1'b0, now}} > last)
    now  <= 10'd0; // the width fell since the last step

always @(*) begin
{taps}end
"
        ))
    }
}
