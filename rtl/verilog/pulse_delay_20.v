// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 20] for a pulse, by counting: at least 20 steps between pulses.
// Latency: 20 steps.
module pulse_delay_20 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

reg [4:0] left;

always @(posedge clock)
  if (reset) begin
    left <= 5'd0;
    y    <= 1'b0;
  end else if (advance) begin
    y <= left == 5'd1;
    if (x)
      left <= 5'd19;
    else if (left != 5'd0)
      left <= left - 5'd1;
  end

endmodule
