// frame_delay_NxK: a marker leaves N lines and K steps after it entered, and no other marker leaves.
// Nothing is reset: the first state is arbitrary, which includes every state after a reset.

module frame_delay_checked #(parameter LINES = 1, STEPS = 4) (
  input clock, input [10:0] width, input seen, input [16:0] since, input begun, input [16:0] remaining,
  input [16:0] total, input y
);
  wire [16:0] whole = LINES * {6'd0, width} + STEPS;
  always @(posedge clock) begin
    length: assert (!begun || total == whole - 17'd1);
    counts: assert (!seen || remaining == (since < whole ? whole - since : 17'd0));
    leaves: assert (!seen || since == 17'd1 || y == (since == whole));
  end
endmodule

module frame_delay_properties (input clock);
  (* anyseq *) reg advance, x;
  (* anyconst *) reg [10:0] width;
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
  always @(posedge clock) begin
    // A free width from 64 to 1024 makes the lengths symbolic, which is too much for the solver.
    assume (width == 11'd64 || width == 11'd65 || width == 11'd640 || width == 11'd1023 || width == 11'd1024);
    // One marker per frame; the first length comes from the width before the first marker.
    if (advance && x) assume (begun && (!seen || since == lines_64));
    spaced: assert (since <= lines_64 && (!seen || since != 17'd0) && (begun || !seen));
    arrives: cover (seen && since == 17'd2 && !y_1x4);
  end

  wire y_1x4;
  frame_delay_1x4 dut_1x4 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_1x4)
  );
  (* hierconn *) wire [11:0] \dut_1x4.remaining ;
  (* hierconn *) wire [11:0] \dut_1x4.total ;
  frame_delay_checked #(.LINES(1), .STEPS(4)) checked_1x4 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({5'd0, \dut_1x4.remaining }), .total({5'd0, \dut_1x4.total }), .y(y_1x4)
  );

  wire y_2x4;
  frame_delay_2x4 dut_2x4 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_2x4)
  );
  (* hierconn *) wire [11:0] \dut_2x4.remaining ;
  (* hierconn *) wire [11:0] \dut_2x4.total ;
  frame_delay_checked #(.LINES(2), .STEPS(4)) checked_2x4 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({5'd0, \dut_2x4.remaining }), .total({5'd0, \dut_2x4.total }), .y(y_2x4)
  );

  wire y_4x4;
  frame_delay_4x4 dut_4x4 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_4x4)
  );
  (* hierconn *) wire [12:0] \dut_4x4.remaining ;
  (* hierconn *) wire [12:0] \dut_4x4.total ;
  frame_delay_checked #(.LINES(4), .STEPS(4)) checked_4x4 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({4'd0, \dut_4x4.remaining }), .total({4'd0, \dut_4x4.total }), .y(y_4x4)
  );

  wire y_8x4;
  frame_delay_8x4 dut_8x4 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_8x4)
  );
  (* hierconn *) wire [13:0] \dut_8x4.remaining ;
  (* hierconn *) wire [13:0] \dut_8x4.total ;
  frame_delay_checked #(.LINES(8), .STEPS(4)) checked_8x4 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({3'd0, \dut_8x4.remaining }), .total({3'd0, \dut_8x4.total }), .y(y_8x4)
  );

  wire y_8x7;
  frame_delay_8x7 dut_8x7 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_8x7)
  );
  (* hierconn *) wire [13:0] \dut_8x7.remaining ;
  (* hierconn *) wire [13:0] \dut_8x7.total ;
  frame_delay_checked #(.LINES(8), .STEPS(7)) checked_8x7 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({3'd0, \dut_8x7.remaining }), .total({3'd0, \dut_8x7.total }), .y(y_8x7)
  );

  wire y_48x1;
  frame_delay_48x1 dut_48x1 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_48x1)
  );
  (* hierconn *) wire [15:0] \dut_48x1.remaining ;
  (* hierconn *) wire [15:0] \dut_48x1.total ;
  frame_delay_checked #(.LINES(48), .STEPS(1)) checked_48x1 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({1'd0, \dut_48x1.remaining }), .total({1'd0, \dut_48x1.total }), .y(y_48x1)
  );

  wire y_3x10;
  frame_delay_3x10 dut_3x10 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_3x10)
  );
  (* hierconn *) wire [11:0] \dut_3x10.remaining ;
  (* hierconn *) wire [11:0] \dut_3x10.total ;
  frame_delay_checked #(.LINES(3), .STEPS(10)) checked_3x10 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({5'd0, \dut_3x10.remaining }), .total({5'd0, \dut_3x10.total }), .y(y_3x10)
  );

  wire y_15x13;
  frame_delay_15x13 dut_15x13 (
    .clock(clock), .reset(1'b0), .advance(advance), .width(width), .x(x), .y(y_15x13)
  );
  (* hierconn *) wire [13:0] \dut_15x13.remaining ;
  (* hierconn *) wire [13:0] \dut_15x13.total ;
  frame_delay_checked #(.LINES(15), .STEPS(13)) checked_15x13 (
    .clock(clock), .width(width), .seen(seen), .since(since), .begun(begun),
    .remaining({3'd0, \dut_15x13.remaining }), .total({3'd0, \dut_15x13.total }), .y(y_15x13)
  );
endmodule
