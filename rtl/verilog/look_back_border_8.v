// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The operands of a row cell towards the past: q[c] = x[c], p[c] = x[max(c - 8, 0)].
// Latency: 1 step.
module look_back_border_8 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire first,
  input  wire [17:0] x,
  input  wire [17:0] past,
  output reg  [17:0] p,
  output reg  [17:0] q
);

reg [2:0] left;
reg [17:0] border;
wire outside = left != 3'd0;

always @(posedge clock)
  if (reset)
    left <= 3'd0;
  else if (advance) begin
    if (first)
      left <= 3'd7;
    else if (outside)
      left <= left - 3'd1;
  end

always @(posedge clock)
  if (advance) begin
    if (first)
      border <= x;
    p <= first ? x : outside ? border : past;
    q <= x;
  end

endmodule
