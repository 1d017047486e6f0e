//! The address of all line memories, `address[n] = n mod W`, counted in steps, and the same address some steps ago.

use std::collections::VecDeque;

use rust_hdl::prelude::*;

use super::{Address, Width, low};
use crate::design::COLUMN_BITS;

/// The delays of [`AddressCounter`] in steps: one to write a line memory, two to write one with a register behind it,
/// five to write the memory of the recursion.
pub const ADDRESS_DELAYS: [usize; 3] = [1, 2, 5];

/// The address counter that all line memories share.
///
/// The width changes between frames, while there is no step, and may become smaller than the address. The first step of
/// the next frame must not use an address that the counter never returns to, so the address returns to 0 before that
/// step.
#[derive(LogicBlock, Default)]
pub struct AddressCounter {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high. The address starts at 0.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`; changes only with a reset of the counter or while the pipeline is empty.
    pub width: Signal<In, Width>,
    /// `n mod W`.
    pub address: Signal<Out, Address>,
    /// The address one step ago.
    pub delayed_1: Signal<Out, Address>,
    /// The address two steps ago.
    pub delayed_2: Signal<Out, Address>,
    /// The address five steps ago.
    pub delayed_5: Signal<Out, Address>,
    _delayed: VecDeque<u64>,
}

impl Logic for AddressCounter {
    fn update(&mut self) {
        if self._delayed.is_empty() {
            self._delayed = vec![0; 6].into();
        }
        if self.clock.pos_edge() {
            let last = self.width.val().to_u64().wrapping_sub(1);
            if self.reset.val() {
                self._delayed.iter_mut().for_each(|address| *address = 0);
            } else if self.advance.val() {
                let address = self._delayed[0];
                self._delayed.push_front(if address >= last { 0 } else { low(address + 1, COLUMN_BITS) });
                self._delayed.pop_back();
            } else if self._delayed[0] > last {
                self._delayed[0] = 0;
            }
        }
        let delayed = &self._delayed;
        self.address.next = delayed[0].into();
        self.delayed_1.next = delayed[1].into();
        self.delayed_2.next = delayed[2].into();
        self.delayed_5.next = delayed[5].into();
    }

    fn connect(&mut self) {
        self.address.connect();
        self.delayed_1.connect();
        self.delayed_2.connect();
        self.delayed_5.connect();
    }

    fn hdl(&self) -> Verilog {
        let taps: String = ADDRESS_DELAYS
            .iter()
            .map(|n| format!("  delayed_{n} = delayed[{}:{}];\n", n * COLUMN_BITS - 1, (n - 1) * COLUMN_BITS))
            .collect();
        Verilog::Custom(format!(
            "// module: address_counter
wire [WIDTH_BITS-1:0] last = width - WIDTH_BITS'd1;
reg [5*COLUMN_BITS-1:0] delayed;

always @(posedge clock)
  if (reset) begin
    address <= COLUMN_BITS'd0;
    delayed <= {history}'d0;
  end else if (advance) begin
    address <= {{1'b0, address}} >= last ? COLUMN_BITS'd0 : address + COLUMN_BITS'd1;
    delayed <= {{delayed[4*COLUMN_BITS-1:0], address}};
  end else if ({{1'b0, address}} > last)
    address <= COLUMN_BITS'd0; // the width became smaller since the last step

always @(*) begin
{taps}end
",
            history = 5 * COLUMN_BITS
        ))
    }
}
