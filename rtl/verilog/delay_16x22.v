// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 22], 16 bits: registers up to 3 steps, beyond them a small memory written where it was read a step before.
// The memory may begin at any place; reset is for simulators that know X.
// Latency: 22 steps.
module delay_16x22 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [15:0] x,
  output reg  [15:0] y
);

reg [15:0] memory [0:20];
reg [4:0] place;

always @(posedge clock)
  if (reset)
    place <= 5'd0;
  else if (advance)
    place <= place == 5'd20 ? 5'd0 : place + 5'd1;

always @(posedge clock)
  if (advance) begin
    y <= memory[place];
    memory[place] <= x;
  end

endmodule
