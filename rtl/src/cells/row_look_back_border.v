// The operands of a row look-back cell: q[c] = x[c], p[c] = x[max(c - DISTANCE, 0)].
// Latency: 1 step.
module row_look_back_border #(
  parameter BITS = 18,
  parameter DISTANCE = 1
) (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire first,
  input  wire [BITS-1:0] x,
  input  wire [BITS-1:0] delayed,
  output reg  [BITS-1:0] p,
  output reg  [BITS-1:0] q
);

localparam COUNT_BITS = DISTANCE > 1 ? $clog2(DISTANCE) : 1;
localparam LOAD = DISTANCE - 1;

// Samples of the row that have none DISTANCE columns before them, without the first.
reg [COUNT_BITS-1:0] remaining;
reg [BITS-1:0] border;
wire outside = remaining != 0;

always @(posedge clock)
  if (reset)
    remaining <= 0;
  else if (advance) begin
    if (first)
      remaining <= LOAD[COUNT_BITS-1:0];
    else if (outside)
      remaining <= remaining - 1;
  end

always @(posedge clock)
  if (advance) begin
    if (first)
      border <= x;
    p <= first ? x : outside ? border : delayed;
    q <= x;
  end

endmodule
