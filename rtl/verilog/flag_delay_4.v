// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 4]; reset clears what is under way.
// Latency: 4 steps.
module flag_delay_4 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

reg [2:0] past;

always @(posedge clock)
  if (reset) begin
    past <= 3'd0;
    y <= 1'b0;
  end else if (advance) begin
    past <= {past[1:0], x};
    y <= past[2];
  end

endmodule
