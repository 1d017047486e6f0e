// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 1], 15 bits: registers up to 3 steps, beyond them a small memory written where it was read a step before.
// The memory may begin at any place; reset is for simulators that know X.
// Latency: 1 steps.
module delay_15x1 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [14:0] x,
  output reg  [14:0] y
);

always @(posedge clock)
  if (advance) begin
    y <= x;
  end

wire unused = reset;

endmodule
