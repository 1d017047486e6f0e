// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The newest row of the coarse ring below its older ones: y = {older, newest}.
// Latency: none.
module ring_rows (
  input  wire [15:0] newest,
  input  wire [223:0] older,
  output reg  [239:0] y
);

always @(*)
  y = {older, newest};

endmodule
