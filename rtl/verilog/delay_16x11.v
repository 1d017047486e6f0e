// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 11], 16 bits: registers up to 3 steps, beyond them a small memory written where it was read a step before.
// The memory may begin at any place; reset is for simulators that know X.
// Latency: 11 steps.
module delay_16x11 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [15:0] x,
  output reg  [15:0] y
);

reg [15:0] memory [0:9];
reg [3:0] place;

always @(posedge clock)
  if (reset)
    place <= 4'd0;
  else if (advance)
    place <= place == 4'd9 ? 4'd0 : place + 4'd1;

always @(posedge clock)
  if (advance) begin
    y <= memory[place];
    memory[place] <= x;
  end

endmodule
