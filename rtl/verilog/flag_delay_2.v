// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 2]; reset clears what is under way.
// Latency: 2 steps.
module flag_delay_2 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

reg past;

always @(posedge clock)
  if (reset) begin
    past <= 1'd0;
    y <= 1'b0;
  end else if (advance) begin
    past <= x;
    y <= past;
  end

endmodule
