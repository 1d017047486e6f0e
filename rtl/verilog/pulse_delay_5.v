// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 5] for a pulse, by counting: at least 5 steps between pulses.
// Latency: 5 steps.
module pulse_delay_5 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

reg [2:0] left;

always @(posedge clock)
  if (reset) begin
    left <= 3'd0;
    y    <= 1'b0;
  end else if (advance) begin
    y <= left == 3'd1;
    if (x)
      left <= 3'd4;
    else if (left != 3'd0)
      left <= left - 3'd1;
  end

endmodule
