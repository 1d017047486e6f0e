//! From Avalon-ST beats to steps of the datapath: every frame that enters the datapath is complete.
//!
//! | state | beats | steps |
//! |---|---|---|
//! | idle | start of packet begins a frame; others are dropped | without pixels, until the pipeline has drained |
//! | frame | one beat per step; no step without a beat | one pixel each |
//! | pad | none | the last pixel again, until the frame is complete |
//!
//! A frame that is cut short (its end, or the start of another frame, comes too early) is padded, so the datapath never
//! sees part of a frame; the error bits of its trailer say so. Beats after the last pixel are dropped up to the next
//! start of packet. A frame of another size waits until the pipeline is empty, for [`DRAIN_LINES`] lines at most. The
//! datapath stalls while the record FIFO has no space.

use std::collections::VecDeque;

use hoverlock_design::MIN_SIDE;
use rust_hdl::prelude::*;

use super::{Height, Pixel, Width, low};
use crate::design::{COLUMN_BITS, MAX_HEIGHT, MAX_WIDTH, ROW_BITS};

/// Lines of steps after which the pipeline is empty. It needs fewer than 88.
pub const DRAIN_LINES: u64 = 96;

/// Error bits of a frame.
pub mod error {
    /// End of packet before the last pixel.
    pub const SHORT: u64 = 1;
    /// No end of packet at the last pixel.
    pub const LONG: u64 = 1 << 1;
    /// Start of packet before the last pixel.
    pub const INTERRUPTED: u64 = 1 << 2;
    /// A beat outside any frame, or a frame of a size that is not possible: never part of a frame's own bits.
    pub const REFUSED: u64 = 1 << 3;
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum State {
    #[default]
    Idle,
    Frame,
    Pad,
}

/// The sequencer with a skid buffer of two beats.
#[derive(LogicBlock, Default)]
pub struct Sequencer {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Frames are accepted; otherwise whole frames are dropped.
    pub enable: Signal<In, Bit>,
    /// `W` of frames that begin now.
    pub new_width: Signal<In, Width>,
    /// `H` of frames that begin now.
    pub new_height: Signal<In, Height>,
    /// 1 while the next frame captures the committed set, of which `new_width` and `new_height` are the size; 0 while
    /// it keeps the set of the previous frame. No frame begins in the cycle in which this changes: the sequencer's
    /// comparison of the size is one cycle old, and a frame captures size and bank from one set.
    pub committed: Signal<In, Bit>,
    /// The datapath must stall.
    pub stall: Signal<In, Bit>,
    /// Avalon-ST sink: ready.
    pub ready: Signal<Out, Bit>,
    /// A beat is offered.
    pub valid: Signal<In, Bit>,
    /// Pixel of the beat, DN.
    pub data: Signal<In, Pixel>,
    /// Start of packet.
    pub start_of_packet: Signal<In, Bit>,
    /// End of packet.
    pub end_of_packet: Signal<In, Bit>,
    /// `W` in the pipeline.
    pub width: Signal<Out, Width>,
    /// `H` in the pipeline.
    pub height: Signal<Out, Height>,
    /// A frame begins at the next clock edge and captures the committed set.
    pub capture: Signal<Out, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<Out, Bit>,
    /// The step's pixel is a frame's first.
    pub start: Signal<Out, Bit>,
    /// The pixel of the step.
    pub pixel: Signal<Out, Pixel>,
    /// Data is in the pipeline.
    pub busy: Signal<Out, Bit>,
    /// Error bits of this cycle.
    pub errors: Signal<Out, Bits<4>>,
    /// Pulse: the oldest frame in the pipeline is complete.
    pub frame_done: Signal<In, Bit>,
    /// Error bits of the oldest frame in the pipeline.
    pub frame_errors: Signal<Out, Bits<4>>,
    _beats: VecDeque<(u64, bool, bool)>,
    _state: State,
    _at: (u64, u64),
    _ignoring: bool,
    _offered: (u64, u64),
    _settle: u64,
    _drain: u64,
    _drain_from: u64,
    _own: u64,
    _done: bool,
    _kept: VecDeque<u64>,
    _committed_delayed: bool,
}

impl Sequencer {
    /// Whether the first beat of a frame makes its step in this cycle.
    fn begins(&self) -> bool {
        let (width, height) = self._offered;
        let possible = is_possible(width, height);
        let settled = self._offered == (self.width.val().to_u64(), self.height.val().to_u64()) && self._settle == 0;
        let start = self._state == State::Idle && self._beats.front().is_some_and(|(_, start, _)| *start);
        let steady = self.committed.val() == self._committed_delayed;
        start && self.enable.val() && possible && settled && steady && !self.stall.val() && !self.reset.val()
    }

    fn clock_edge(&mut self) {
        let taken = self.valid.val() && self._beats.len() != 2;
        let beat = self._beats.front().copied();
        let (width, height) = (self.width.val().to_u64(), self.height.val().to_u64());
        let (new_width, new_height) = self._offered;
        let possible = is_possible(new_width, new_height);
        let same = new_width == width && new_height == height;
        let stall = self.stall.val();
        let last = self._at == (low(width.wrapping_sub(1), COLUMN_BITS), low(height.wrapping_sub(1), ROW_BITS));
        let (mut pop, mut step, mut begin, mut errors, mut own) = (false, false, false, 0, self._own);
        let mut pixel = self.pixel.val().to_u64();
        let mut real = false;
        match (self._state, beat) {
            (State::Idle, Some((_, false, end))) => {
                (pop, step) = (true, !stall && self._drain != 0);
                if !self._ignoring && self.enable.val() {
                    errors = error::REFUSED;
                }
                self._ignoring = !end;
            }
            (State::Idle, Some((data, true, end))) if self.enable.val() && possible => {
                if same && self._settle == 0 && self.committed.val() == self._committed_delayed {
                    if self.begins() {
                        (pop, step, begin, real, pixel) = (true, true, true, true, data);
                        own = if end { error::SHORT } else { 0 };
                        errors = own;
                        self._state = if end { State::Pad } else { State::Frame };
                        self._at = (1, 0);
                    }
                } else if self._drain == 0 && !same {
                    self.width.next = new_width.into();
                    self.height.next = new_height.into();
                    self._settle = 3;
                } else if self._drain == 0 {
                    self._settle = self._settle.saturating_sub(1);
                } else {
                    step = !stall;
                }
            }
            (State::Idle, Some((_, true, end))) => {
                (pop, step) = (true, !stall && self._drain != 0);
                self._ignoring = !end;
                errors = if self.enable.val() { error::REFUSED } else { 0 };
            }
            (State::Idle, None) => step = !stall && self._drain != 0,
            (State::Frame, Some((_, true, _))) => {
                errors = error::INTERRUPTED;
                own |= errors;
                self._state = State::Pad;
            }
            (State::Frame, Some((data, false, end))) if !stall => {
                (pop, step, real, pixel) = (true, true, true, data);
                if last {
                    errors = if end { 0 } else { error::LONG };
                    self._state = State::Idle;
                    self._ignoring = !end;
                } else if end {
                    errors = error::SHORT;
                    self._state = State::Pad;
                }
                own |= errors;
            }
            (State::Pad, _) if !stall => {
                (step, real) = (true, true);
                if last {
                    self._state = State::Idle;
                    self._ignoring = false;
                }
            }
            _ => {}
        }
        if real && !begin {
            let (x, y) = self._at;
            let end_of_row = x == low(width.wrapping_sub(1), COLUMN_BITS);
            self._at = if end_of_row { (0, low(y + 1, ROW_BITS)) } else { (low(x + 1, COLUMN_BITS), y) };
        }
        if self._done {
            self._kept.pop_front();
        }
        self._done = self.frame_done.val();
        if real && last && !begin && self._kept.len() < 4 {
            self._kept.push_back(own);
        }
        self._own = own;
        self._drain = if real {
            self._drain_from
        } else if step {
            self._drain - 1
        } else {
            self._drain
        };
        self._drain_from = DRAIN_LINES * width;
        if pop {
            self._beats.pop_front();
        }
        if taken {
            let beat = (self.data.val().to_u64(), self.start_of_packet.val(), self.end_of_packet.val());
            self._beats.push_back(beat);
        }
        self.advance.next = step;
        if step {
            self.start.next = begin;
            self.pixel.next = pixel.into();
        }
        self.errors.next = errors.into();
    }
}

impl Logic for Sequencer {
    fn update(&mut self) {
        if self.clock.pos_edge() {
            if self.reset.val() {
                self._beats.clear();
                self._state = State::Idle;
                (self._ignoring, self._settle, self._drain, self._own, self._done) = (false, 0, 0, 0, false);
                self._kept.clear();
                self.width.next = 0u64.into();
                self.height.next = 0u64.into();
                self.advance.next = false;
                self.start.next = false;
                self.errors.next = 0u64.into();
            } else {
                self.clock_edge();
            }
            self._offered = (self.new_width.val().to_u64(), self.new_height.val().to_u64());
            self._committed_delayed = self.committed.val();
        }
        self.capture.next = self.begins();
        self.ready.next = self._beats.len() != 2;
        self.busy.next = self._drain != 0;
        self.frame_errors.next = self._kept.front().copied().unwrap_or_default().into();
    }

    fn connect(&mut self) {
        self.ready.connect();
        self.width.connect();
        self.height.connect();
        self.capture.connect();
        self.advance.connect();
        self.start.connect();
        self.pixel.connect();
        self.busy.connect();
        self.errors.connect();
        self.frame_errors.connect();
    }

    fn hdl(&self) -> Verilog {
        Verilog::Custom(
            "\
// module: sequencer
localparam IDLE = 2'd0, FRAME = 2'd1, PAD = 2'd2;

// Skid buffer of two beats: ready depends on registers only.
reg [BEAT_BITS-1:0] skid_front;
reg [BEAT_BITS-1:0] skid_back;
reg [1:0]  skid_count;
wire        not_empty = skid_count != 2'd0;
wire [PIXEL_BITS-1:0] beat     = skid_front[PIXEL_BITS-1:0];
wire        is_start = skid_front[PIXEL_BITS];
wire        is_end   = skid_front[PIXEL_BITS+1];

reg [1:0]  state;
reg [COLUMN_BITS-1:0]  x;
reg [ROW_BITS-1:0] y;
reg        ignoring;
reg [1:0]  settle;
reg [DRAIN_BITS-1:0] drain;
reg [DRAIN_BITS-1:0] drain_from;
reg [2:0]  own;

// The size from the registers and its comparisons are registered, which keeps comparators out of the control path.
reg [WIDTH_BITS-1:0] offered_width;
reg [HEIGHT_BITS-1:0] offered_height;
reg        possible;
reg        same;
reg        drained;
reg        committed_delayed;
reg [COLUMN_BITS-1:0]  last_x; // of a stable size
reg [ROW_BITS-1:0] last_y;
wire at_last_x = x == last_x;
wire last      = at_last_x & (y == last_y);

// Actions of this cycle.
wire idle    = state == IDLE;
wire first   = idle & not_empty & is_start;
wire accept  = first & enable & possible;
wire refuse  = first & ~(enable & possible);
wire stray   = idle & not_empty & ~is_start;
wire steady  = committed == committed_delayed;
wire ready_to_begin = same & (settle == 2'd0) & steady;
wire begins  = accept & ready_to_begin & ~stall;
// Dropped beats do not stop the drain: the last frame leaves the pipeline while the stream goes on.
wire drains  = ~stall & ~drained & idle & ~begins;
wire resize  = accept & ~same & drained;
wire settles = accept & same & (settle != 2'd0) & drained;
wire breaks  = (state == FRAME) & not_empty & is_start;
wire takes   = (state == FRAME) & not_empty & ~is_start & ~stall;
wire pads    = (state == PAD) & ~stall;
wire real_step = begins | takes | pads;
wire pop     = stray | refuse | begins | takes;
wire push    = valid & ready;

wire short_frame = (begins & is_end) | (takes & is_end & ~last);
wire long_frame  = takes & last & ~is_end;
wire [2:0] own_now = (begins ? 3'd0 : own) | {breaks, long_frame, short_frame};
wire keep        = (takes | pads) & last;

always @(posedge clock)
  if (reset)
    skid_count <= 2'd0;
  else
    skid_count <= skid_count + {1'b0, push} - {1'b0, pop};

always @(posedge clock) begin
  if (pop)
    skid_front <= skid_count == 2'd2 ? skid_back : {end_of_packet, start_of_packet, data};
  else if (~not_empty)
    skid_front <= {end_of_packet, start_of_packet, data};
  if (push)
    skid_back <= {end_of_packet, start_of_packet, data};
end

always @(posedge clock)
  if (reset) begin
    state    <= IDLE;
    ignoring <= 1'b0;
    settle   <= 2'd0;
    drain    <= DRAIN_BITS'd0;
    drained  <= 1'b1;
    same     <= 1'b0;
    own      <= 3'd0;
    width    <= WIDTH_BITS'd0;
    height   <= HEIGHT_BITS'd0;
    advance  <= 1'b0;
    start    <= 1'b0;
    errors   <= 4'd0;
    x        <= COLUMN_BITS'd0;
    y        <= ROW_BITS'd0;
  end else begin
    if (begins)
      state <= is_end ? PAD : FRAME;
    else if (keep)
      state <= IDLE;
    else if (breaks | short_frame)
      state <= PAD;
    if (stray | refuse)
      ignoring <= ~is_end;
    else if (long_frame)
      ignoring <= 1'b1;
    else if (keep)
      ignoring <= 1'b0;
    if (resize) begin
      width  <= offered_width;
      height <= offered_height;
      settle <= 2'd3;
    end else if (settles)
      settle <= settle - 2'd1;
    if (begins) begin
      x <= COLUMN_BITS'd1;
      y <= ROW_BITS'd0;
    end else if (real_step) begin
      x <= at_last_x ? COLUMN_BITS'd0 : x + COLUMN_BITS'd1;
      y <= at_last_x ? y + ROW_BITS'd1 : y;
    end
    own     <= own_now;
    drain   <= real_step ? drain_from : drain - {DRAIN_TOP'd0, drains};
    drained <= ~real_step & (drained | (drains & (drain == DRAIN_BITS'd1)));
    same    <= resize ? (new_width == offered_width) & (new_height == offered_height)
                      : (new_width == width) & (new_height == height);
    advance <= real_step | drains;
    errors  <= {((stray & ~ignoring) | refuse) & enable, breaks, long_frame, short_frame};
    if (real_step | drains)
      start <= begins;
  end

always @(posedge clock) begin
  offered_width  <= new_width;
  offered_height <= new_height;
  committed_delayed <= committed;
  possible <= (new_width >= WIDTH_BITS'd64) & (new_width <= WIDTH_BITS'dMAX_WIDTH) \
              & (new_height >= HEIGHT_BITS'd64) & (new_height <= HEIGHT_BITS'dMAX_HEIGHT);
  last_x <= width[COLUMN_BITS-1:0] - COLUMN_BITS'd1;
  last_y <= height[ROW_BITS-1:0] - ROW_BITS'd1;
  drain_from <= ({6'd0, width} << 6) + ({6'd0, width} << 5);
  if (begins | takes)
    pixel <= beat;
end

// Error bits of the frames in the pipeline, the oldest frame lowest. An entry is removed one cycle after frame_done.
reg        done_before;
reg [11:0] kept;
reg [2:0]  frames;
wire       kept_out = done_before & (frames != 3'd0);
wire [2:0] frames_left = frames - {2'd0, kept_out};

always @(posedge clock)
  if (reset) begin
    done_before <= 1'b0;
    frames <= 3'd0;
    kept   <= 12'd0;
  end else begin
    done_before <= frame_done;
    frames <= frames_left + {2'd0, keep & ~frames_left[2]};
    kept   <= (kept_out ? {3'd0, kept[11:3]} : kept)
            | (keep & ~frames_left[2] ? {9'd0, own_now} << (frames_left == 3'd1 ? 4'd3 : frames_left == 3'd2 ? 4'd6 :
                                                          frames_left == 3'd3 ? 4'd9 : 4'd0) : 12'd0);
  end

always @(*) begin
  ready        = ~skid_count[1];
  busy         = ~drained;
  capture      = begins & ~reset;
  frame_errors = {1'b0, kept[2:0]};
end
"
            .replace("'dMAX_WIDTH", &format!("'d{MAX_WIDTH}"))
            .replace("'dMAX_HEIGHT", &format!("'d{MAX_HEIGHT}")),
        )
    }
}

/// Whether a frame may have this size.
fn is_possible(width: u64, height: u64) -> bool {
    (u64::from(MIN_SIDE)..=MAX_WIDTH as u64).contains(&width)
        && (u64::from(MIN_SIDE)..=MAX_HEIGHT as u64).contains(&height)
}
