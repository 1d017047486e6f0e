// frame_delay_NxK: a marker leaves N lines and K steps after it entered, and no other marker leaves.
// Nothing is reset: the first state is arbitrary, which includes every state after a reset.

// The inputs of one delay, and its rules. Each delay has a width and markers of its own: with common ones the sums of
// all lengths meet in one problem, which is too much for the solver.
module frame_delay_checked #(parameter LINES = 1, STEPS = 4) (
  input clock, output advance, output x, output [10:0] width, input [16:0] remaining, input [16:0] total, input y
);
  (* anyseq *) reg any_advance, any_x;
  (* anyconst *) reg [10:0] any_width;
  assign advance = any_advance;
  assign x = any_x;
  assign width = any_width;

  // Steps since the last marker.
  reg [16:0] since = 17'd0;
  reg begun = 0, seen = 0;
  wire [16:0] lines_64 = {width, 6'd0};
  always @(posedge clock) begin
    begun <= 1;
    if (advance) begin
      since <= x ? 17'd1 : since != lines_64 ? since + 17'd1 : since;
      seen <= seen | x;
    end
  end

  wire [16:0] whole = LINES * {6'd0, width} + STEPS;
  always @(posedge clock) begin
    assume (width >= 11'd64 && width <= 11'd1024);
    // One marker per frame; the first length comes from the width before the first marker.
    if (advance && x) assume (begun && (!seen || since == lines_64));
    spaced: assert (since <= lines_64 && (!seen || since != 17'd0) && (begun || !seen));
    length: assert (!begun || total == whole - 17'd1);
    // By the length of the module, which keeps the sum above out of the induction.
    counts: assert (!seen || remaining == (since <= total ? total + 17'd1 - since : 17'd0));
    leaves: assert (!seen || since == 17'd1 || y == (since == total + 17'd1));
    arrives: cover (seen && since == 17'd2 && !y);
  end
endmodule

module frame_delay_properties (input clock);
  wire advance_1x4, x_1x4, y_1x4;
  wire [10:0] width_1x4;
  frame_delay_1x4 dut_1x4 (
    .clock(clock), .reset(1'b0), .advance(advance_1x4), .width(width_1x4), .x(x_1x4), .y(y_1x4)
  );
  (* hierconn *) wire [11:0] \dut_1x4.remaining ;
  (* hierconn *) wire [11:0] \dut_1x4.total ;
  frame_delay_checked #(.LINES(1), .STEPS(4)) checked_1x4 (
    .clock(clock), .advance(advance_1x4), .x(x_1x4), .width(width_1x4),
    .remaining({5'd0, \dut_1x4.remaining }), .total({5'd0, \dut_1x4.total }), .y(y_1x4)
  );

  wire advance_2x4, x_2x4, y_2x4;
  wire [10:0] width_2x4;
  frame_delay_2x4 dut_2x4 (
    .clock(clock), .reset(1'b0), .advance(advance_2x4), .width(width_2x4), .x(x_2x4), .y(y_2x4)
  );
  (* hierconn *) wire [11:0] \dut_2x4.remaining ;
  (* hierconn *) wire [11:0] \dut_2x4.total ;
  frame_delay_checked #(.LINES(2), .STEPS(4)) checked_2x4 (
    .clock(clock), .advance(advance_2x4), .x(x_2x4), .width(width_2x4),
    .remaining({5'd0, \dut_2x4.remaining }), .total({5'd0, \dut_2x4.total }), .y(y_2x4)
  );

  wire advance_4x4, x_4x4, y_4x4;
  wire [10:0] width_4x4;
  frame_delay_4x4 dut_4x4 (
    .clock(clock), .reset(1'b0), .advance(advance_4x4), .width(width_4x4), .x(x_4x4), .y(y_4x4)
  );
  (* hierconn *) wire [12:0] \dut_4x4.remaining ;
  (* hierconn *) wire [12:0] \dut_4x4.total ;
  frame_delay_checked #(.LINES(4), .STEPS(4)) checked_4x4 (
    .clock(clock), .advance(advance_4x4), .x(x_4x4), .width(width_4x4),
    .remaining({4'd0, \dut_4x4.remaining }), .total({4'd0, \dut_4x4.total }), .y(y_4x4)
  );

  wire advance_8x4, x_8x4, y_8x4;
  wire [10:0] width_8x4;
  frame_delay_8x4 dut_8x4 (
    .clock(clock), .reset(1'b0), .advance(advance_8x4), .width(width_8x4), .x(x_8x4), .y(y_8x4)
  );
  (* hierconn *) wire [13:0] \dut_8x4.remaining ;
  (* hierconn *) wire [13:0] \dut_8x4.total ;
  frame_delay_checked #(.LINES(8), .STEPS(4)) checked_8x4 (
    .clock(clock), .advance(advance_8x4), .x(x_8x4), .width(width_8x4),
    .remaining({3'd0, \dut_8x4.remaining }), .total({3'd0, \dut_8x4.total }), .y(y_8x4)
  );

  wire advance_8x7, x_8x7, y_8x7;
  wire [10:0] width_8x7;
  frame_delay_8x7 dut_8x7 (
    .clock(clock), .reset(1'b0), .advance(advance_8x7), .width(width_8x7), .x(x_8x7), .y(y_8x7)
  );
  (* hierconn *) wire [13:0] \dut_8x7.remaining ;
  (* hierconn *) wire [13:0] \dut_8x7.total ;
  frame_delay_checked #(.LINES(8), .STEPS(7)) checked_8x7 (
    .clock(clock), .advance(advance_8x7), .x(x_8x7), .width(width_8x7),
    .remaining({3'd0, \dut_8x7.remaining }), .total({3'd0, \dut_8x7.total }), .y(y_8x7)
  );

  wire advance_48x1, x_48x1, y_48x1;
  wire [10:0] width_48x1;
  frame_delay_48x1 dut_48x1 (
    .clock(clock), .reset(1'b0), .advance(advance_48x1), .width(width_48x1), .x(x_48x1), .y(y_48x1)
  );
  (* hierconn *) wire [15:0] \dut_48x1.remaining ;
  (* hierconn *) wire [15:0] \dut_48x1.total ;
  frame_delay_checked #(.LINES(48), .STEPS(1)) checked_48x1 (
    .clock(clock), .advance(advance_48x1), .x(x_48x1), .width(width_48x1),
    .remaining({1'd0, \dut_48x1.remaining }), .total({1'd0, \dut_48x1.total }), .y(y_48x1)
  );

  wire advance_3x10, x_3x10, y_3x10;
  wire [10:0] width_3x10;
  frame_delay_3x10 dut_3x10 (
    .clock(clock), .reset(1'b0), .advance(advance_3x10), .width(width_3x10), .x(x_3x10), .y(y_3x10)
  );
  (* hierconn *) wire [11:0] \dut_3x10.remaining ;
  (* hierconn *) wire [11:0] \dut_3x10.total ;
  frame_delay_checked #(.LINES(3), .STEPS(10)) checked_3x10 (
    .clock(clock), .advance(advance_3x10), .x(x_3x10), .width(width_3x10),
    .remaining({5'd0, \dut_3x10.remaining }), .total({5'd0, \dut_3x10.total }), .y(y_3x10)
  );

  wire advance_15x13, x_15x13, y_15x13;
  wire [10:0] width_15x13;
  frame_delay_15x13 dut_15x13 (
    .clock(clock), .reset(1'b0), .advance(advance_15x13), .width(width_15x13), .x(x_15x13), .y(y_15x13)
  );
  (* hierconn *) wire [13:0] \dut_15x13.remaining ;
  (* hierconn *) wire [13:0] \dut_15x13.total ;
  frame_delay_checked #(.LINES(15), .STEPS(13)) checked_15x13 (
    .clock(clock), .advance(advance_15x13), .x(x_15x13), .width(width_15x13),
    .remaining({3'd0, \dut_15x13.remaining }), .total({3'd0, \dut_15x13.total }), .y(y_15x13)
  );
endmodule
