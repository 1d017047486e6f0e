// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The operands of a row cell towards the future: q[c] = x[c], p[c] = x[min(c + 1, W - 1)].
// Latency: 1 step from `x` and `past` to p and q.
module look_ahead_border_1 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire last,
  input  wire [17:0] x,
  input  wire [17:0] past,
  output reg  [17:0] p,
  output reg  [17:0] q
);

reg [0:0] left;
reg [17:0] border;
wire outside = left != 1'd0;

always @(posedge clock)
  if (reset)
    left <= 1'd0;
  else if (advance) begin
    if (last)
      left <= 1'd1;
    else if (outside)
      left <= left - 1'd1;
  end

always @(posedge clock)
  if (advance) begin
    if (last)
      border <= x;
    p <= outside ? border : x;
    q <= past;
  end

endmodule
