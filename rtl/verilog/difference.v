// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// DOG = min((|narrow - wide| + 1) >> 1, 2^15 - 1), and the sign of narrow - wide before rounding.
//   step 1  distance = |narrow - wide|   step 2  rounded, cut at the largest code
// Latency: 2 steps.
module difference (
  input  wire clock,
  input  wire advance,
  input  wire [17:0] narrow,
  input  wire [17:0] wide,
  output reg  [14:0] magnitude,
  output reg  positive,
  output reg  saturated
);

wire [18:0] up = {1'b0, narrow} - {1'b0, wide};
wire [17:0] down = wide - narrow;

reg [17:0] distance;
reg        positive_1;
wire [18:0] rounded = {1'b0, distance} + 19'd1;
wire        over = |rounded[18:16];

always @(posedge clock)
  if (advance) begin
    distance   <= up[18] ? down : up[17:0];
    positive_1 <= ~up[18];

    magnitude <= over ? 15'h7fff : rounded[15:1];
    saturated <= over;
    positive  <= positive_1;
  end

wire unused = rounded[0];

endmodule
