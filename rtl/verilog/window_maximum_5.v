// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = max(x[n] .. x[n - 5 + 1]) by doubling: maxima of 2, of 4, and two of those overlapping.
// Latency: ceil(log2 5) steps.
module window_maximum_5 (
  input  wire clock,
  input  wire advance,
  input  wire [14:0] x,
  output reg  [14:0] y
);

reg [14:0] r0_past_1;
reg [14:0] r1;
reg [14:0] r1_past_1;
reg [14:0] r1_past_2;
reg [14:0] r2;
reg [14:0] r2_past_1;

always @(posedge clock)
  if (advance) begin
    r0_past_1 <= x;
    r1 <= x > r0_past_1 ? x : r0_past_1;
    r1_past_1 <= r1;
    r1_past_2 <= r1_past_1;
    r2 <= r1 > r1_past_2 ? r1 : r1_past_2;
    r2_past_1 <= r2;
    y <= r2 > r2_past_1 ? r2 : r2_past_1;
  end

endmodule
