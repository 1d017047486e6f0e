// y[n] = max(x[n] .. x[n - SAMPLES + 1]) by doubling: maxima of 2, of 4, then of two overlapping windows.
// Latency: ceil(log2 SAMPLES) steps.
module window_maximum #(
  parameter BITS = 15,
  parameter SAMPLES = 2
) (
  input  wire clock,
  input  wire advance,
  input  wire [BITS-1:0] x,
  output wire [BITS-1:0] y
);

localparam ROUNDS = $clog2(SAMPLES);

initial if (SAMPLES < 2) begin
  $error("%m: SAMPLES is %0d, not 2 or more", SAMPLES);
  $finish;
end

// What enters each round, the samples lowest, and what leaves the last.
wire [BITS*(ROUNDS+1)-1:0] maxima;
assign maxima[BITS-1:0] = x;

genvar k;
generate
  for (k = 0; k < ROUNDS; k = k + 1) begin : round
    // Windows of 2^k samples make one of twice as many; in the last round they overlap.
    localparam REST = SAMPLES - (1 << k);
    localparam SHIFT = REST < (1 << k) ? REST : 1 << k;
    wire [BITS-1:0] newest = maxima[BITS*k +: BITS];
    reg [BITS*SHIFT-1:0] delayed;
    wire [BITS*(SHIFT+1)-1:0] shifted = {delayed, newest};
    wire [BITS-1:0] oldest = shifted[BITS*SHIFT +: BITS];
    reg [BITS-1:0] larger;

    always @(posedge clock)
      if (advance) begin
        delayed <= shifted[BITS*SHIFT-1:0];
        larger <= newest > oldest ? newest : oldest;
      end

    assign maxima[BITS*(k+1) +: BITS] = larger;
  end
endgenerate

assign y = maxima[BITS*ROUNDS +: BITS];

endmodule
