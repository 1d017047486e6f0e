// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// What a frame takes with it, 16 bits each from the lowest: 19 coefficients, two thresholds, target, mode.
// Latency: 1 clock from `load`.
module bank (
  input  wire clock,
  input  wire load,
  input  wire [367:0] d,
  output reg  [367:0] q
);

always @(posedge clock)
  if (load)
    q <= d;

endmodule
