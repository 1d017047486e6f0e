// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - N], N the number after the x: registers up to 3 steps, a small memory beyond.
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
