// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 2], 18 bits: registers up to 3 steps, beyond them a small memory written where it was read a step before.
// The memory may begin at any place; reset is for simulators that know X.
// Latency: 2 steps.
module delay_18x2 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [17:0] x,
  output reg  [17:0] y
);

reg [17:0] past_1;

always @(posedge clock)
  if (advance) begin
    past_1 <= x;
    y <= past_1;
  end

wire unused = reset;

endmodule
