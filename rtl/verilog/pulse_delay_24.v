// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 24] for a pulse, by counting: at least 24 steps between pulses.
// Latency: 24 steps.
module pulse_delay_24 (
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
      left <= 5'd23;
    else if (left != 5'd0)
      left <= left - 5'd1;
  end

endmodule
