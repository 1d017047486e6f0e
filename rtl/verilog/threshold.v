// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The threshold T of a frame: manual, at least 1; or by the count n of the frame before and the target N
//   n > 5 N / 4   T + (T >> 3) + 1, at most 2^15 - 1        n < 3 N / 4   T - (T >> 3) - 1, at least 1
// Taken over at the marker of the window stage, when the last frame's count is complete. The first frame that follows takes the manual one.
// Latency: 1 step from the marker; the count must rest two clocks before it.
module threshold (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire start,
  input  wire hit,
  input  wire follow,
  input  wire [14:0] manual,
  input  wire [15:0] target,
  output reg  [14:0] threshold,
  output reg  [19:0] count
);

// What the count asks for, ready long before the next frame begins.
reg        follows;
reg [12:0] change;
reg        more;
reg        less;
wire [21:0] four_counts = {count, 2'b00};
wire [21:0] three_targets = {6'd0, target} + {5'd0, target, 1'b0};
wire [21:0] five_targets = {6'd0, target} + {4'd0, target, 2'b00};
wire [15:0] up = {1'b0, threshold} + {3'd0, change};
wire [15:0] down = {1'b0, threshold} - {3'd0, change};
wire        at_floor = down[15] | (down == 16'd0);

always @(posedge clock) begin
  change <= {1'b0, threshold[14:3]} + 13'd1;
  more   <= four_counts > five_targets;
  less   <= four_counts < three_targets;
end

always @(posedge clock)
  if (reset) begin
    count     <= 20'd0;
    follows   <= 1'b0;
    threshold <= 15'd0;
  end else if (advance) begin
    if (start) begin
      count   <= 20'd0;
      follows <= follow;
      if (~(follow & follows))
        threshold <= manual == 15'd0 ? 15'd1 : manual;
      else if (more)
        threshold <= up[15] ? 15'h7fff : up[14:0];
      else if (less)
        threshold <= at_floor ? 15'd1 : down[14:0];
    end else if (hit)
      count <= count + 20'd1;
  end

endmodule
