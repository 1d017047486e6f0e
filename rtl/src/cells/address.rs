//! The address of all line memories, `address[n] = n mod W`, counted in steps, and the same address some steps ago.

use hoverlock_design::pipeline::{READ_STEPS, RECURSION_STEPS, REGISTERED_READ_STEPS};
use rust_hdl::prelude::*;

use super::{Address, Width, low};
use crate::design::{COLUMN_BITS, WIDTH_BITS};

/// The outputs of [`AddressCounter`] with their age in steps.
const OUTPUTS: [(&str, usize); 3] = [
    ("write_address", READ_STEPS as usize),
    ("registered_write_address", REGISTERED_READ_STEPS as usize),
    ("recursion_write_address", OLDEST),
];

/// Age of the oldest address, steps.
const OLDEST: usize = RECURSION_STEPS as usize;

/// The address counter that all line memories share.
///
/// The width changes between frames, while there is no step, and may become smaller than the address. The first step of
/// the next frame must not use an address that the counter never returns to, so the address returns to 0 before that
/// step. The last address is registered, which keeps a subtraction out of the path to the comparison: there is no step
/// in the clock after a change of the width either.
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
    /// Where a line memory is written.
    pub write_address: Signal<Out, Address>,
    /// Where a line memory with a register behind it is written.
    pub registered_write_address: Signal<Out, Address>,
    /// Where the memory of the recursion is written.
    pub recursion_write_address: Signal<Out, Address>,
    /// The address and its past, the newest first.
    _delayed: [u64; OLDEST + 1],
    /// `W - 1` of the clock before.
    _last: u64,
}

impl Logic for AddressCounter {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            let last = self._last;
            self._last = low(self.width.val().to_u64().wrapping_sub(1), WIDTH_BITS);
            if self.reset.val() {
                self._delayed.fill(0);
            } else if self.advance.val() {
                let address = self._delayed[0];
                self._delayed.rotate_right(1);
                self._delayed[0] = if address >= last { 0 } else { low(address + 1, COLUMN_BITS) };
            } else if self._delayed[0] > last {
                self._delayed[0] = 0;
            }
        }
        let delayed = &self._delayed;
        self.address.next = delayed[0].into();
        self.write_address.next = delayed[READ_STEPS as usize].into();
        self.registered_write_address.next = delayed[REGISTERED_READ_STEPS as usize].into();
        self.recursion_write_address.next = delayed[OLDEST].into();
    }

    fn connect(&mut self) {
        self.address.connect();
        self.write_address.connect();
        self.registered_write_address.connect();
        self.recursion_write_address.connect();
    }

    fn hdl(&self) -> Verilog {
        let taps: String = OUTPUTS
            .iter()
            .map(|(name, n)| format!("  {name} = delayed[{}:{}];\n", n * COLUMN_BITS - 1, (n - 1) * COLUMN_BITS))
            .collect();
        Verilog::Custom(format!(
            "// module: address_counter
reg [WIDTH_BITS-1:0] last; // of a stable width
reg [{top}:0] delayed;

always @(posedge clock) begin
  last <= width - WIDTH_BITS'd1;
  if (reset) begin
    address <= COLUMN_BITS'd0;
    delayed <= {bits}'d0;
  end else if (advance) begin
    address <= {{1'b0, address}} >= last ? COLUMN_BITS'd0 : address + COLUMN_BITS'd1;
    delayed <= {{delayed[{newer}:0], address}};
  end else if ({{1'b0, address}} > last)
    address <= COLUMN_BITS'd0; // the width became smaller since the last step
end

always @(*) begin
{taps}end
",
            top = OLDEST * COLUMN_BITS - 1,
            bits = OLDEST * COLUMN_BITS,
            newer = (OLDEST - 1) * COLUMN_BITS - 1,
        ))
    }
}
