//! The decision whether the centre of the window is a feature, and the threshold it uses.
//!
//! `hit = p > strict and p >= loose and p >= T` at an eligible pixel, one step. A frame's threshold is set at its
//! marker of the window stage. By then the count of the last frame is complete, whatever the gap between the frames.

use rust_hdl::prelude::*;

use super::{Column, Height, PixelPosition, Response, Row, Width, low};
use crate::design::{COLUMN_BITS, DOG_BITS, HEIGHT_BITS, WIDTH_BITS};

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
    /// A feature, one step later.
    pub hit: Signal<Out, Bit>,
}

impl Logic for Decision {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            if self.reset.val() {
                self.hit.next = false;
            } else if self.advance.val() {
                let p = self.p.val().to_u64();
                self.hit.next = self.eligible.val()
                    && p > self.strict.val().to_u64()
                    && p >= self.loose.val().to_u64()
                    && p >= self.threshold.val().to_u64();
            }
        }
    }

    fn connect(&mut self) {
        self.hit.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: decision
always @(posedge clock)
  if (reset)
    hit <= 1'b0;
  else if (advance)
    hit <= eligible & (p > strict) & (p >= loose) & (p >= threshold);
"
            .into(),
        )
    }
}

/// `T` of a frame: the manual threshold, or in automatic mode derived from the last frame's count `n` before drops and
/// the target `N`. For `n > 5 N / 4` it is `T + (T >> 3) + 1`, for `n < 3 N / 4` `T - (T >> 3) - 1`, clamped to
/// `1 ..= 2^N - 1`. The first automatic frame uses the manual threshold.
#[derive(LogicBlock, Default)]
pub struct Threshold {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// A frame begins at the window stage.
    pub start: Signal<In, Bit>,
    /// A feature was found (counted before drops).
    pub hit: Signal<In, Bit>,
    /// Automatic mode: the threshold follows the count.
    pub follow: Signal<In, Bit>,
    /// Threshold in manual mode.
    pub manual: Signal<In, Response>,
    /// Target number of features `N`.
    pub target: Signal<In, Bits<16>>,
    /// `T` of this frame.
    pub threshold: Signal<Out, Response>,
    /// Features of this frame so far.
    pub count: Signal<Out, Bits<20>>,
    _follows: bool,
    _step: u64,
    _more: bool,
    _less: bool,
}

impl Logic for Threshold {
    fn update(&mut self) {
        if !self.clock.pos_edge() {
            return;
        }
        let (threshold, count, target) =
            (self.threshold.val().to_u64(), self.count.val().to_u64(), self.target.val().to_u64());
        if self.reset.val() {
            self.count.next = 0u64.into();
            self._follows = false;
            self.threshold.next = 0u64.into();
        } else if self.advance.val() {
            if self.start.val() {
                self.count.next = 0u64.into();
                let manual = self.manual.val().to_u64().max(1);
                let next = match (self.follow.val() && self._follows, self._more, self._less) {
                    (false, ..) => manual,
                    (_, true, _) => (threshold + self._step).min((1 << DOG_BITS) - 1),
                    (_, _, true) => threshold.saturating_sub(self._step).max(1),
                    _ => threshold,
                };
                self.threshold.next = next.into();
                self._follows = self.follow.val();
            } else if self.hit.val() {
                self.count.next = ((count + 1) & 0xf_ffff).into();
            }
        }
        self._step = (threshold >> 3) + 1;
        self._more = 4 * count > 5 * target;
        self._less = 4 * count < 3 * target;
    }

    fn connect(&mut self) {
        self.threshold.connect();
        self.count.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: threshold
// The change of T, registered: it is ready before the next frame begins.
reg        follows;
reg [CHANGE_BITS-1:0] change;
reg        more;
reg        less;
wire [21:0] four_counts = {count, 2'b00};
wire [21:0] three_targets = {6'd0, target} + {5'd0, target, 1'b0};
wire [21:0] five_targets = {6'd0, target} + {4'd0, target, 2'b00};
wire [SIGNED_BITS-1:0] raised = {1'b0, threshold} + {3'd0, change};
wire [SIGNED_BITS-1:0] lowered = {1'b0, threshold} - {3'd0, change};
wire        at_floor = lowered[DOG_BITS] | (lowered == SIGNED_BITS'd0);

always @(posedge clock) begin
  change <= {1'b0, threshold[DOG_BITS-1:3]} + CHANGE_BITS'd1;
  more   <= four_counts > five_targets;
  less   <= four_counts < three_targets;
end

always @(posedge clock)
  if (reset) begin
    count     <= 20'd0;
    follows   <= 1'b0;
    threshold <= DOG_BITS'd0;
  end else if (advance) begin
    if (start) begin
      count   <= 20'd0;
      follows <= follow;
      if (~(follow & follows))
        threshold <= manual == DOG_BITS'd0 ? DOG_BITS'd1 : manual;
      else if (more)
        threshold <= raised[DOG_BITS] ? LARGEST : raised[DOG_BITS-1:0];
      else if (less)
        threshold <= at_floor ? DOG_BITS'd1 : lowered[DOG_BITS-1:0];
    end else if (hit)
      count <= count + 20'd1;
  end
"
            .replace("LARGEST", &format!("{DOG_BITS}'h{:x}", (1 << DOG_BITS) - 1)),
        )
    }
}
