//! Concatenation of signals: wiring without logic.

use rust_hdl::prelude::*;

use super::{FourNeighbours, Pixel, Response, State, low};
use crate::design::{DOG_BITS, OLDER_BITS, RING_BITS, SIGNED_BITS, STATE_FRACTION_BITS};

/// `x << f`: a camera sample as a filter state.
#[derive(LogicBlock, Default)]
pub struct PixelState {
    /// The sample.
    pub x: Signal<In, Pixel>,
    /// The state.
    pub y: Signal<Out, State>,
}

impl Logic for PixelState {
    fn update(&mut self) {
        self.y.next = (self.x.val().to_u64() << STATE_FRACTION_BITS).into();
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        let state = match STATE_FRACTION_BITS {
            0 => "x".to_owned(),
            bits => format!("{{x, {bits}'b{}}}", "0".repeat(bits)),
        };
        Verilog::Custom(format!("// module: pixel_state\nalways @(*)\n  y = {state};\n"))
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
    pub y: Signal<Out, super::SignedResponse>,
}

impl Logic for SignedResponse {
    fn update(&mut self) {
        self.y.next = (self.magnitude.val().to_u64() | u64::from(self.positive.val()) << DOG_BITS).into();
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom("// module: signed_response\nalways @(*)\n  y = {positive, magnitude};\n".into())
    }
}

/// The magnitudes of the four neighbours of a centre: left, right, upper, lower from the lowest bit.
#[derive(LogicBlock, Default)]
pub struct Neighbours {
    /// Left, the sign above it.
    pub left: Signal<In, super::SignedResponse>,
    /// Right.
    pub right: Signal<In, super::SignedResponse>,
    /// Upper.
    pub upper: Signal<In, super::SignedResponse>,
    /// Lower.
    pub lower: Signal<In, super::SignedResponse>,
    /// All four magnitudes.
    pub y: Signal<Out, FourNeighbours>,
}

impl Logic for Neighbours {
    fn update(&mut self) {
        let samples = [self.left.val(), self.right.val(), self.upper.val(), self.lower.val()];
        let joined = samples.iter().rev().fold(0, |joined, sample| joined << DOG_BITS | low(sample.to_u64(), DOG_BITS));
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
  y = {lower[DOG_BITS-1:0], upper[DOG_BITS-1:0], right[DOG_BITS-1:0], left[DOG_BITS-1:0]};

wire unused = ^{lower[DOG_BITS], upper[DOG_BITS], right[DOG_BITS], left[DOG_BITS]};
"
            .into(),
        )
    }
}

/// The rows of a ring of 16 px: the newest row in the lowest bits, the older ones above it.
#[derive(LogicBlock, Default)]
pub struct RingRows {
    /// The newest row.
    pub newest: Signal<In, super::SignedResponse>,
    /// The others.
    pub older: Signal<In, Bits<OLDER_BITS>>,
    /// All rows.
    pub y: Signal<Out, Bits<RING_BITS>>,
}

impl Logic for RingRows {
    fn update(&mut self) {
        let mut rows = Bits::<RING_BITS>::default();
        rows.set_bits(0, self.newest.val());
        rows.set_bits(SIGNED_BITS, self.older.val());
        self.y.next = rows;
    }

    fn connect(&mut self) {
        self.y.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom("// module: ring_rows\nalways @(*)\n  y = {older, newest};\n".into())
    }
}
