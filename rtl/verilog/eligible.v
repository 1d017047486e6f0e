// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// 18 <= x < W - 18 and 18 <= y < H - 18: no ring of such a centre leaves the frame.
// Latency: none for `eligible`, 1 step for `place`.
module eligible (
  input  wire clock,
  input  wire advance,
  input  wire [10:0] width,
  input  wire [11:0] height,
  input  wire active,
  input  wire [9:0] x,
  input  wire [10:0] y,
  output reg  eligible,
  output reg  [20:0] place
);

reg [10:0] end_x;
reg [11:0] end_y;

always @(*)
  eligible = active & (x >= 10'd18) & ({1'b0, x} < end_x) & (y >= 11'd18) & ({1'b0, y} < end_y);

always @(posedge clock) begin
  end_x <= width - 11'd18;
  end_y <= height - 12'd18;
  if (advance)
    place <= {y, x};
end

endmodule
