// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 8]; reset clears what is under way.
// Latency: 8 steps.
module flag_delay_8 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

reg [6:0] past;

always @(posedge clock)
  if (reset) begin
    past <= 7'd0;
    y <= 1'b0;
  end else if (advance) begin
    past <= {past[5:0], x};
    y <= past[6];
  end

endmodule
