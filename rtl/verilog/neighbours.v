// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Left, right, upper and lower neighbour, 15 bits each from the lowest; signs are left out.
// Latency: none.
module neighbours (
  input  wire [15:0] left,
  input  wire [15:0] right,
  input  wire [15:0] up,
  input  wire [15:0] down,
  output reg  [59:0] y
);

always @(*)
  y = {down[14:0], up[14:0], right[14:0], left[14:0]};

wire unused = ^{down[15], up[15], right[15], left[15]};

endmodule
