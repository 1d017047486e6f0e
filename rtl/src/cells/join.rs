//! Concatenation of signals: wiring without logic.

use rust_hdl::prelude::*;

use super::{Response, State};

/// `x << 2`: a camera sample as a filter state.
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

/// A response with its sign in bit 15.
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
    /// Left, sign in bit 15.
    pub left: Signal<In, Bits<16>>,
    /// Right.
    pub right: Signal<In, Bits<16>>,
    /// Upper.
    pub upper: Signal<In, Bits<16>>,
    /// Lower.
    pub lower: Signal<In, Bits<16>>,
    /// All four magnitudes.
    pub y: Signal<Out, Bits<60>>,
}

impl Logic for Neighbours {
    fn update(&mut self) {
        let samples = [self.left.val(), self.right.val(), self.upper.val(), self.lower.val()];
        let joined = samples.iter().rev().fold(0, |joined, sample| joined << 15 | sample.to_u64() & 0x7fff);
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
  y = {lower[14:0], upper[14:0], right[14:0], left[14:0]};

wire unused = ^{lower[15], upper[15], right[15], left[15]};
"
            .into(),
        )
    }
}

/// The rows of the coarse ring: the newest row in the lowest bits, the older ones above it.
#[derive(LogicBlock, Default)]
pub struct RingRows {
    /// The newest row.
    pub newest: Signal<In, Bits<16>>,
    /// The others.
    pub older: Signal<In, Bits<224>>,
    /// All rows.
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
