// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The coefficient of a stage, taken over when the marker of a frame passes.
// Latency: 1 step.
module coefficient_register (
  input  wire clock,
  input  wire advance,
  input  wire load,
  input  wire [15:0] d,
  output reg  [15:0] g
);

always @(posedge clock)
  if (advance & load)
    g <= d;

endmodule
