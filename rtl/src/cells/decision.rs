//! The decision whether the centre of the window is a maximum and a feature.
//!
//! `maximum = p > strict and p >= loose` at an eligible pixel, `hit = maximum and p >= T`, one step.

use rust_hdl::prelude::*;

use super::{Column, Height, PixelPosition, Response, Row, Width, low};
use crate::design::{COLUMN_BITS, HEIGHT_BITS, WIDTH_BITS};

/// The ring of a centre closer to the border than this leaves the frame.
pub const MARGIN: u64 = 18;

/// `18 <= x < W - 18` and `18 <= y < H - 18`, and the position one step later. `W` and `H` must be stable for one cycle
/// before.
#[derive(LogicBlock, Default)]
pub struct Eligible {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// `W`, the columns of the frame.
    pub width: Signal<In, Width>,
    /// `H`, the rows of the frame.
    pub height: Signal<In, Height>,
    /// The sample belongs to a frame.
    pub active: Signal<In, Bit>,
    /// Column of the sample, from 0.
    pub x: Signal<In, Column>,
    /// Row of the sample, from 0.
    pub y: Signal<In, Row>,
    /// The position is eligible.
    pub eligible: Signal<Out, Bit>,
    /// Row above column, one step later.
    pub position: Signal<Out, PixelPosition>,
    _end: (u64, u64),
}

impl Logic for Eligible {
    fn update(&mut self) {
        let (x, y) = (self.x.val().to_u64(), self.y.val().to_u64());
        if self.clock.pos_edge() {
            let end = |size: u64, bits: usize| low(size.wrapping_sub(MARGIN), bits);
            self._end = (end(self.width.val().to_u64(), WIDTH_BITS), end(self.height.val().to_u64(), HEIGHT_BITS));
            if self.advance.val() {
                self.position.next = (y << COLUMN_BITS | x).into();
            }
        }
        let inside = |at: u64, end: u64| at >= MARGIN && at < end;
        self.eligible.next = self.active.val() && inside(x, self._end.0) && inside(y, self._end.1);
    }

    fn connect(&mut self) {
        self.eligible.connect();
        self.position.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: eligible
reg [WIDTH_BITS-1:0] end_x;
reg [HEIGHT_BITS-1:0] end_y;

always @(*)
  eligible = active & (x >= COLUMN_BITS'd18) & ({1'b0, x} < end_x) & (y >= ROW_BITS'd18) & ({1'b0, y} < end_y);

always @(posedge clock) begin
  end_x <= width - WIDTH_BITS'd18;
  end_y <= height - HEIGHT_BITS'd18;
  if (advance)
    position <= {y, x};
end
"
            .into(),
        )
    }
}

/// The comparisons at the centre of the window.
#[derive(LogicBlock, Default)]
pub struct Decision {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// The position is eligible.
    pub eligible: Signal<In, Bit>,
    /// Response of the centre.
    pub p: Signal<In, Response>,
    /// Maximum of what comes earlier in raster order.
    pub strict: Signal<In, Response>,
    /// Maximum of what comes later.
    pub loose: Signal<In, Response>,
    /// `T`.
    pub threshold: Signal<In, Response>,
    /// A maximum, one step later.
    pub maximum: Signal<Out, Bit>,
    /// A feature, one step later.
    pub hit: Signal<Out, Bit>,
}

impl Logic for Decision {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            if self.reset.val() {
                self.maximum.next = false;
                self.hit.next = false;
            } else if self.advance.val() {
                let p = self.p.val().to_u64();
                let maximum = self.eligible.val() && p > self.strict.val().to_u64() && p >= self.loose.val().to_u64();
                self.maximum.next = maximum;
                self.hit.next = maximum && p >= self.threshold.val().to_u64();
            }
        }
    }

    fn connect(&mut self) {
        self.maximum.connect();
        self.hit.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: decision
wire is_maximum = eligible & (p > strict) & (p >= loose);

always @(posedge clock)
  if (reset) begin
    maximum <= 1'b0;
    hit     <= 1'b0;
  end else if (advance) begin
    maximum <= is_maximum;
    hit     <= is_maximum & (p >= threshold);
  end
"
            .into(),
        )
    }
}
