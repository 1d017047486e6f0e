// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Column x and row y of the sample that is here: counts from the marker one step before a frame's first, 0 <= x < W, 0 <= y < H.
// Latency: 1 step from `start` to the first sample's place; the edges are combinational.
module cursor (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire [11:0] height,
  input  wire start,
  output reg  active,
  output reg  [9:0] x,
  output reg  [10:0] y,
  output reg  first_column,
  output reg  last_column,
  output reg  first_row,
  output reg  last_row
);

wire [10:0] last_x = width - 11'd1;
wire [11:0] last_y = height - 12'd1;
wire        at_last_x = {1'b0, x} == last_x;
wire        at_last_y = {1'b0, y} == last_y;

always @(posedge clock)
  if (reset) begin
    active <= 1'b0;
    x      <= 10'd0;
    y      <= 11'd0;
  end else if (advance) begin
    if (start) begin
      active <= 1'b1;
      x      <= 10'd0;
      y      <= 11'd0;
    end else if (at_last_x) begin
      active <= active & ~at_last_y;
      x      <= 10'd0;
      y      <= y + 11'd1;
    end else
      x <= x + 10'd1;
  end

always @(*) begin
  first_column = active & (x == 10'd0);
  last_column  = active & at_last_x;
  first_row    = active & (y == 11'd0);
  last_row     = active & at_last_y;
end

endmodule
