// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Row stage 2 towards the past: y[c] = lerp(p = u[max(c - 4, 0)], q = u[c], g_2).
//   step 1  p, q   step 2  |q - p|   step 3  product   step 4  y
// Latency: 4 steps.
module look_back_stage_2 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [17:0] x,
  input  wire first,
  input  wire load,
  input  wire [15:0] g,
  output wire [17:0] y,
  output wire first_out,
  output wire load_out
);

wire [17:0] past_y;
wire [17:0] border_p;
wire [17:0] border_q;
wire mark_y;
wire marker_y;
wire [15:0] coefficient_g;
wire [17:0] lerp_y;

delay_18x4 past (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(x),
  .y(past_y)
);

look_back_border_4 border (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .first(first),
  .x(x),
  .past(past_y),
  .p(border_p),
  .q(border_q)
);

flag_delay_4 mark (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(first),
  .y(mark_y)
);

flag_delay_4 marker (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(load),
  .y(marker_y)
);

coefficient_register coefficient (
  .clock(clock),
  .advance(advance),
  .load(load),
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

assign first_out = mark_y;
assign load_out = marker_y;
assign y = lerp_y;

endmodule
