// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The operands of a row cell towards the future: q[c] = x[c], p[c] = x[min(c + 4, W - 1)].
// Latency: 1 step from `x` and `past` to p and q.
module look_ahead_border_4 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire last,
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
    if (last)
      left <= 3'd4;
    else if (outside)
      left <= left - 3'd1;
  end

always @(posedge clock)
  if (advance) begin
    if (last)
      border <= x;
    p <= outside ? border : x;
    q <= past;
  end

endmodule
