// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// A response with its sign above it: y = {positive, magnitude}.
// Latency: none.
module signed_response (
  input  wire [14:0] magnitude,
  input  wire positive,
  output reg  [15:0] y
);

always @(*)
  y = {positive, magnitude};

endmodule
