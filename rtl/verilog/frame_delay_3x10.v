// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 3 W - 10] for a marker, by counting: at least as long between markers.
// Latency: 3 lines and 10 steps.
module frame_delay_3x10 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire x,
  output reg  y
);

reg [11:0] total;
reg [11:0] left;

always @(posedge clock)
  total <= ({1'd0, width} << 2) - {1'd0, width} + 12'd9;

always @(posedge clock)
  if (reset) begin
    left <= 12'd0;
    y    <= 1'b0;
  end else if (advance) begin
    y <= left == 12'd1;
    if (x)
      left <= total;
    else if (left != 12'd0)
      left <= left - 12'd1;
  end

endmodule
