// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y = max(a, b).
// Latency: 1 step.
module maximum (
  input  wire clock,
  input  wire advance,
  input  wire [14:0] a,
  input  wire [14:0] b,
  output reg  [14:0] y
);

always @(posedge clock)
  if (advance)
    y <= a > b ? a : b;

endmodule
