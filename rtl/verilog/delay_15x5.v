// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 5], 15 bits: registers up to 3 steps, beyond them a small memory written where it was read a step before.
// The memory may begin at any place; reset is for simulators that know X.
// Latency: 5 steps.
module delay_15x5 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [14:0] x,
  output reg  [14:0] y
);

reg [14:0] memory [0:3];
reg [1:0] place;

always @(posedge clock)
  if (reset)
    place <= 2'd0;
  else if (advance)
    place <= place == 2'd3 ? 2'd0 : place + 2'd1;

always @(posedge clock)
  if (advance) begin
    y <= memory[place];
    memory[place] <= x;
  end

endmodule
