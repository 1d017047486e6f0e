// The operands of a row look-ahead cell: q[c] = x[c], p[c] = x[min(c + DISTANCE, W - 1)].
// Latency: 1 step from `x` and `delayed` to p and q.
module row_look_ahead_border #(
  parameter BITS = 18,
  parameter DISTANCE = 1
) (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire last,
  input  wire [BITS-1:0] x,
  input  wire [BITS-1:0] delayed,
  output reg  [BITS-1:0] p,
  output reg  [BITS-1:0] q
);

localparam COUNT_BITS = $clog2(DISTANCE + 1);

// Samples of the row that have none DISTANCE columns after them.
reg [COUNT_BITS-1:0] remaining;
reg [BITS-1:0] border;
wire outside = remaining != 0;

always @(posedge clock)
  if (reset)
    remaining <= 0;
  else if (advance) begin
    if (last)
      remaining <= DISTANCE[COUNT_BITS-1:0];
    else if (outside)
      remaining <= remaining - 1;
  end

always @(posedge clock)
  if (advance) begin
    if (last)
      border <= x;
    p <= outside ? border : x;
    q <= delayed;
  end

endmodule
