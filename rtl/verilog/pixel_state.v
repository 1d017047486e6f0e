// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// A camera word u16.0 as a state u16.2: y = 4 x.
// Latency: none.
module pixel_state (
  input  wire [15:0] x,
  output reg  [17:0] y
);

always @(*)
  y = {x, 2'b00};

endmodule
