// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 36] for a pulse, by counting: at least 36 steps between pulses.
// Latency: 36 steps.
module pulse_delay_36 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

reg [5:0] left;

always @(posedge clock)
  if (reset) begin
    left <= 6'd0;
    y    <= 1'b0;
  end else if (advance) begin
    y <= left == 6'd1;
    if (x)
      left <= 6'd35;
    else if (left != 6'd0)
      left <= left - 6'd1;
  end

endmodule
