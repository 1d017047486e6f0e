// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// maxlbp[i] = centre >= MaxDOG(o_i), sign[i] = sign(o_i), i = 0 .. 31.
// Latency: 1 step.
module ring_comparator (
  input  wire clock,
  input  wire advance,
  input  wire [14:0] centre,
  input  wire [511:0] points,
  output reg  [31:0] maxlbp,
  output reg  [31:0] sign
);

integer i;

always @(posedge clock)
  if (advance)
    for (i = 0; i < 32; i = i + 1) begin
      maxlbp[i] <= centre >= points[16 * i +: 15];
      sign[i]   <= points[16 * i + 15];
    end

endmodule
