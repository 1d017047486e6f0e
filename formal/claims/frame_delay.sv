// frame_delay: a marker leaves LINES lines and STEPS steps after it entered, and no other marker leaves.
// Nothing is reset: the first state is arbitrary, which includes every state after a reset.

// The inputs of one delay, and its rules. Each delay has a width and markers of its own: with common ones the sums of
// all lengths meet in one problem, which is too much for the solver.
module frame_delay_checked #(parameter LINES = 1, STEPS = 4) (
  input clock, output advance, output x, output [`W-1:0] width, input [`W+5:0] remaining, input [`W+5:0] total, input y
);
  (* anyseq *) reg any_advance, any_x;
  (* anyconst *) reg [`W-1:0] any_width;
  assign advance = any_advance;
  assign x = any_x;
  assign width = any_width;

  // Steps since the last marker.
  reg [`W+5:0] since = 0;
  reg begun = 0, seen = 0;
  wire [`W+5:0] lines_64 = {width, 6'd0};
  always @(posedge clock) begin
    begun <= 1;
    if (advance) begin
      since <= x ? 1 : since != lines_64 ? since + 1 : since;
      seen <= seen | x;
    end
  end

  wire [`W+5:0] whole = LINES * {6'd0, width} + STEPS;
  always @(posedge clock) begin
    assume (width >= 64 && width <= `COLUMNS);
    // One marker per frame; the first length comes from the width before the first marker.
    if (advance && x) assume (begun && (!seen || since == lines_64));
    spaced: assert (since <= lines_64 && (!seen || since != 0) && (begun || !seen));
    length: assert (!begun || total == whole - 1);
    // By the length of the module, which keeps the sum above out of the induction.
    counts: assert (!seen || remaining == (since <= total ? total + 1 - since : 0));
    leaves: assert (!seen || since == 1 || y == (since == total + 1));
    arrives: cover (seen && since == 2 && !y);
  end
endmodule

module frame_delay_properties (input clock);
for {lines} {steps} {bits}: each frame_delay
  wire advance_{lines}x{steps}, x_{lines}x{steps}, y_{lines}x{steps};
  wire [{bits}-1:0] width_{lines}x{steps};
  frame_delay #(.LINES({lines}), .STEPS({steps}), .WIDTH_BITS({bits})) dut_{lines}x{steps} (
    .clock(clock), .reset(1'b0), .advance(advance_{lines}x{steps}), .width(width_{lines}x{steps}), .x(x_{lines}x{steps}),
    .y(y_{lines}x{steps})
  );
  // What the largest sum needs, and more than a width has.
  localparam NEEDED_{lines}x{steps} = $clog2(({lines} << ({bits} - 1)) + {steps});
  localparam BITS_{lines}x{steps} = NEEDED_{lines}x{steps} > {bits} ? NEEDED_{lines}x{steps} : {bits} + 1;
  (* hierconn *) wire [BITS_{lines}x{steps}-1:0] \dut_{lines}x{steps}.remaining ;
  (* hierconn *) wire [BITS_{lines}x{steps}-1:0] \dut_{lines}x{steps}.total ;
  wire [`W+5:0] remaining_{lines}x{steps} = \dut_{lines}x{steps}.remaining ;
  wire [`W+5:0] total_{lines}x{steps} = \dut_{lines}x{steps}.total ;
  frame_delay_checked #(.LINES({lines}), .STEPS({steps})) checked_{lines}x{steps} (
    .clock(clock), .advance(advance_{lines}x{steps}), .x(x_{lines}x{steps}), .width(width_{lines}x{steps}),
    .remaining(remaining_{lines}x{steps}), .total(total_{lines}x{steps}), .y(y_{lines}x{steps})
  );
end
endmodule
