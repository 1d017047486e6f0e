// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// A feature: p > strict, what comes earlier in the window; p >= loose, what comes later; p >= threshold; and eligible.
// Latency: 1 step.
module decision (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire eligible,
  input  wire [14:0] p,
  input  wire [14:0] strict,
  input  wire [14:0] loose,
  input  wire [14:0] threshold,
  output reg  hit
);

always @(posedge clock)
  if (reset)
    hit <= 1'b0;
  else if (advance)
    hit <= eligible & (p > strict) & (p >= loose) & (p >= threshold);

endmodule
