// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 12] for a pulse, by counting: at least 12 steps between pulses.
// Latency: 12 steps.
module pulse_delay_12 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

reg [3:0] left;

always @(posedge clock)
  if (reset) begin
    left <= 4'd0;
    y    <= 1'b0;
  end else if (advance) begin
    y <= left == 4'd1;
    if (x)
      left <= 4'd11;
    else if (left != 4'd0)
      left <= left - 4'd1;
  end

endmodule
