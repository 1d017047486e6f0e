// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Column look-ahead stage 3: y[r] = lerp(p = u[min(r + 8, H - 1)], q = u[r], g_3).
// `x` is u[r + 8], arriving; u[r] comes from the line memory; `held` is row H - 1 for the last 8 rows.
//   step 1  p, q   step 2  |q - p|   step 3  product   step 4  y
// Latency: 8 lines and 4 steps from a sample to its y.
module column_stage_3 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire [9:0] address,
  input  wire [9:0] write_address,
  input  wire [17:0] x,
  input  wire [17:0] held,
  input  wire outside,
  input  wire load,
  input  wire [15:0] g,
  output wire [17:0] y,
  output wire loads
);

wire [17:0] past_y;
wire [17:0] border_p;
wire [17:0] border_q;
wire marker_y;
wire [15:0] coefficient_g;
wire [17:0] lerp_y;

line_delay_18x8 past (
  .clock(clock),
  .advance(advance),
  .address(address),
  .write_address(write_address),
  .x(x),
  .y(past_y)
);

column_border border (
  .clock(clock),
  .advance(advance),
  .x(past_y),
  .neighbour(x),
  .border(held),
  .outside(outside),
  .p(border_p),
  .q(border_q)
);

frame_delay_8x4 marker (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .x(load),
  .y(marker_y)
);

coefficient_register coefficient (
  .clock(clock),
  .advance(advance),
  .load(marker_y),
  .d(g),
  .g(coefficient_g)
);

lerp lerp (
  .clock(clock),
  .advance(advance),
  .p(border_p),
  .q(border_q),
  .g(coefficient_g),
  .y(lerp_y)
);

assign loads = marker_y;
assign y = lerp_y;

endmodule
