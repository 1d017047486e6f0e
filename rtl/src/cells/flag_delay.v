// y[n] = x[n - STEPS]; reset clears the bits in flight.
// Latency: STEPS steps.
module flag_delay #(
  parameter STEPS = 1
) (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output wire y
);

reg [STEPS-1:0] delayed;
wire [STEPS:0] shifted = {delayed, x};

always @(posedge clock)
  if (reset)
    delayed <= 0;
  else if (advance)
    delayed <= shifted[STEPS-1:0];

assign y = delayed[STEPS-1];
wire unused = shifted[STEPS];

endmodule
