// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The operands of a row cell towards the past: q[c] = x[c], p[c] = x[max(c - 1, 0)].
// Latency: 1 step.
module look_back_border_1 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire first,
  input  wire [17:0] x,
  input  wire [17:0] past,
  output reg  [17:0] p,
  output reg  [17:0] q
);

always @(posedge clock)
  if (advance) begin
    p <= first ? x : past;
    q <= x;
  end

wire unused = reset;

endmodule
