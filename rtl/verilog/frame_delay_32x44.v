// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// y[n] = x[n - 32 W - 44] for a marker, by counting: at least as long between markers.
// Latency: 32 lines and 44 steps.
module frame_delay_32x44 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire x,
  output reg  y
);

reg [15:0] total;
reg [15:0] left;

always @(posedge clock)
  total <= ({5'd0, width} << 5) + 16'd43;

always @(posedge clock)
  if (reset) begin
    left <= 16'd0;
    y    <= 1'b0;
  end else if (advance) begin
    y <= left == 16'd1;
    if (x)
      left <= total;
    else if (left != 16'd0)
      left <= left - 16'd1;
  end

endmodule
