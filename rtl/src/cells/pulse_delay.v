// y[n] = x[n - STEPS] for a pulse, by a counter: at least STEPS steps between pulses.
// Latency: STEPS steps, 2 or more.
module pulse_delay #(
  parameter STEPS = 2
) (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire x,
  output reg  y
);

localparam BITS = $clog2(STEPS);
localparam LOAD = STEPS - 1;

initial if (STEPS < 2) begin
  $error("%m: STEPS is %0d, not 2 or more", STEPS);
  $finish;
end

reg [BITS-1:0] remaining;

always @(posedge clock)
  if (reset) begin
    remaining <= 0;
    y <= 1'b0;
  end else if (advance) begin
    y <= remaining == 1;
    if (x)
      remaining <= LOAD[BITS-1:0];
    else if (remaining != 0)
      remaining <= remaining - 1;
  end

endmodule
