//! Words made of words: no logic, only wires.

use rust_hdl::prelude::*;

use super::{Response, State};

/// `x << 2`: a camera word as a state.
#[derive(LogicBlock, Default)]
pub struct PixelState {
    /// u16.0.
    pub x: Signal<In, Bits<16>>,
    /// u16.2.
    pub y: Signal<Out, State>,
}

impl Logic for PixelState {
    fn update(&mut self) {
        self.y.next = (self.x.val().to_u64() << 2).into();
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom("// module: pixel_state\nalways @(*)\n  y = {x, 2'b00};\n".into())
    }
}

/// A response with its sign above it.
#[derive(LogicBlock, Default)]
pub struct SignedResponse {
    /// Magnitude.
    pub magnitude: Signal<In, Response>,
    /// Not negative.
    pub positive: Signal<In, Bit>,
    /// Sign and magnitude.
    pub y: Signal<Out, Bits<16>>,
}

impl Logic for SignedResponse {
    fn update(&mut self) {
        self.y.next = (self.magnitude.val().to_u64() | u64::from(self.positive.val()) << 15).into();
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom("// module: signed_response\nalways @(*)\n  y = {positive, magnitude};\n".into())
    }
}

/// The four neighbours of a centre, 15 bits each: left, right, upper, lower from the lowest bit.
#[derive(LogicBlock, Default)]
pub struct Neighbours {
    /// Left, its sign above it.
    pub left: Signal<In, Bits<16>>,
    /// Right.
    pub right: Signal<In, Bits<16>>,
    /// Upper.
    pub up: Signal<In, Bits<16>>,
    /// Lower.
    pub down: Signal<In, Bits<16>>,
    /// All, without signs.
    pub y: Signal<Out, Bits<60>>,
}

impl Logic for Neighbours {
    fn update(&mut self) {
        let words = [self.left.val(), self.right.val(), self.up.val(), self.down.val()];
        let joined = words.iter().rev().fold(0, |joined, word| joined << 15 | word.to_u64() & 0x7fff);
        self.y.next = joined.into();
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: neighbours
always @(*)
  y = {down[14:0], up[14:0], right[14:0], left[14:0]};

wire unused = ^{down[15], up[15], right[15], left[15]};
"
            .into(),
        )
    }
}

/// The rows of the wide ring: the newest before the older ones.
#[derive(LogicBlock, Default)]
pub struct RingRows {
    /// The newest row.
    pub newest: Signal<In, Bits<16>>,
    /// The others.
    pub older: Signal<In, Bits<224>>,
    /// All.
    pub y: Signal<Out, Bits<240>>,
}

impl Logic for RingRows {
    fn update(&mut self) {
        let mut rows = Bits::<240>::default();
        rows.set_bits(0, self.newest.val());
        rows.set_bits(16, self.older.val());
        self.y.next = rows;
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom("// module: ring_rows\nalways @(*)\n  y = {older, newest};\n".into())
    }
}
