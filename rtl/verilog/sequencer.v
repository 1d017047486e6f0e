// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// From Avalon-ST beats to steps: every frame that enters the datapath is whole, a short one is padded with its last pixel.
//   IDLE   waits for a start of packet; empty steps drain the pipeline, 96 lines at most; beats without a start are dropped
//   FRAME  a step a beat, until the last pixel
//   PAD    a step a clock, until the last pixel
// A frame of the size before begins at once, one of another size when the pipeline has drained. Two beats of skid make `ready` a register.
// Latency: 2 clocks from a beat to its step.
module sequencer (
  input  wire clock,
  input  wire reset,
  input  wire enable,
  input  wire [10:0] new_width,
  input  wire [11:0] new_height,
  input  wire committed,
  input  wire stop,
  output reg  ready,
  input  wire valid,
  input  wire [15:0] data,
  input  wire start_of_packet,
  input  wire end_of_packet,
  output reg  [10:0] width,
  output reg  [11:0] height,
  output reg  capture,
  output reg  advance,
  output reg  start,
  output reg  [15:0] pixel,
  output reg  busy,
  output reg  [3:0] errors,
  input  wire frame_done,
  output reg  [3:0] frame_errors
);

localparam IDLE = 2'd0, FRAME = 2'd1, PAD = 2'd2;

// Two beats, so that ready is a register.
reg [17:0] head;
reg [17:0] behind;
reg [1:0]  beats;
wire        some     = beats != 2'd0;
wire [15:0] beat     = head[15:0];
wire        is_start = head[16];
wire        is_end   = head[17];

reg [1:0]  state;
reg [9:0]  x;
reg [10:0] y;
reg        ignoring;
reg [1:0]  settle;
reg [16:0] drain;
reg [16:0] drain_from;
reg [2:0]  own;

// The size from the registers, a cycle later, with what it allows: no comparison of words stands before a decision.
reg [10:0] offered_width;
reg [11:0] offered_height;
reg        possible;
reg        same;
reg        drained;
reg        committed_before;
reg [9:0]  last_x; // of a size that has settled
reg [10:0] last_y;
wire at_last_x = x == last_x;
wire last      = at_last_x & (y == last_y);

// What this cycle does.
wire go      = ~stop;
wire idle    = state == IDLE;
wire first   = idle & some & is_start;
wire accept  = first & enable & possible;
wire refuse  = first & ~(enable & possible);
wire stray   = idle & some & ~is_start;
wire steady  = committed == committed_before;
wire ready_to_begin = same & (settle == 2'd0) & steady;
wire begins  = accept & ready_to_begin & go;
// Beats that are dropped do not stop the drain: the last frame comes out although the stream goes on.
wire empty   = go & ~drained & idle & ~begins;
wire resize  = accept & ~same & drained;
wire settles = accept & same & (settle != 2'd0) & drained;
wire breaks  = (state == FRAME) & some & is_start;
wire takes   = (state == FRAME) & some & ~is_start & go;
wire pads    = (state == PAD) & go;
wire real_step = begins | takes | pads;
wire pop     = stray | refuse | begins | takes;
wire push    = valid & ready;

wire short_frame = (begins & is_end) | (takes & is_end & ~last);
wire long_frame  = takes & last & ~is_end;
wire [2:0] own_now = (begins ? 3'd0 : own) | {breaks, long_frame, short_frame};
wire keep        = (takes | pads) & last;

always @(posedge clock)
  if (reset)
    beats <= 2'd0;
  else
    beats <= beats + {1'b0, push} - {1'b0, pop};

always @(posedge clock) begin
  if (pop)
    head <= beats == 2'd2 ? behind : {end_of_packet, start_of_packet, data};
  else if (~some)
    head <= {end_of_packet, start_of_packet, data};
  if (push)
    behind <= {end_of_packet, start_of_packet, data};
end

always @(posedge clock)
  if (reset) begin
    state    <= IDLE;
    ignoring <= 1'b0;
    settle   <= 2'd0;
    drain    <= 17'd0;
    drained  <= 1'b1;
    same     <= 1'b0;
    own      <= 3'd0;
    width    <= 11'd0;
    height   <= 12'd0;
    advance  <= 1'b0;
    start    <= 1'b0;
    errors   <= 4'd0;
    x        <= 10'd0;
    y        <= 11'd0;
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
      x <= 10'd1;
      y <= 11'd0;
    end else if (real_step) begin
      x <= at_last_x ? 10'd0 : x + 10'd1;
      y <= at_last_x ? y + 11'd1 : y;
    end
    own     <= own_now;
    drain   <= real_step ? drain_from : drain - {16'd0, empty};
    drained <= ~real_step & (drained | (empty & (drain == 17'd1)));
    same    <= resize ? (new_width == offered_width) & (new_height == offered_height)
                      : (new_width == width) & (new_height == height);
    advance <= real_step | empty;
    errors  <= {((stray & ~ignoring) | refuse) & enable, breaks, long_frame, short_frame};
    if (real_step | empty)
      start <= begins;
  end

always @(posedge clock) begin
  offered_width  <= new_width;
  offered_height <= new_height;
  committed_before <= committed;
  possible <= (new_width >= 11'd64) & (new_width <= 11'd1024) & (new_height >= 12'd64) & (new_height <= 12'd2048);
  last_x <= width[9:0] - 10'd1;
  last_y <= height[10:0] - 11'd1;
  drain_from <= ({6'd0, width} << 6) + ({6'd0, width} << 5);
  if (begins | takes)
    pixel <= beat;
end

// Errors of the frames in the pipeline, the oldest lowest; it goes a cycle after it is done.
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
  ready        = ~beats[1];
  busy         = ~drained;
  capture      = begins & ~reset;
  frame_errors = {1'b0, kept[2:0]};
end

endmodule
