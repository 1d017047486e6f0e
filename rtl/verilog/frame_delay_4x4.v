// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 4 W - 4] for a marker, by counting: at least as long between markers.
// Latency: 4 lines and 4 steps.
module frame_delay_4x4 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire x,
  output reg  y
);

reg [12:0] total;
reg [12:0] left;

always @(posedge clock)
  total <= ({2'd0, width} << 2) + 13'd3;

always @(posedge clock)
  if (reset) begin
    left <= 13'd0;
    y    <= 1'b0;
  end else if (advance) begin
    y <= left == 13'd1;
    if (x)
      left <= total;
    else if (left != 13'd0)
      left <= left - 13'd1;
  end

endmodule
