// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The operands of a column cell: q = x, p = its neighbour, or the border's sample where that lies outside the frame.
// Latency: 1 step.
module column_border (
  input  wire clock,
  input  wire advance,
  input  wire [17:0] x,
  input  wire [17:0] neighbour,
  input  wire [17:0] border,
  input  wire outside,
  output reg  [17:0] p,
  output reg  [17:0] q
);

always @(posedge clock)
  if (advance) begin
    p <= outside ? border : neighbour;
    q <= x;
  end

endmodule
