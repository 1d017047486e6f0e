// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Row stage 1 towards the future: y[c] = lerp(p = u[min(c + 2, W - 1)], q = u[c], g_1).
//   step 1  p, q   step 2  |q - p|   step 3  product   step 4  y, all of them 2 steps after u[c] came
// Latency: 2 + 4 steps.
module look_ahead_stage_1 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [17:0] x,
  input  wire last,
  input  wire load,
  input  wire [15:0] g,
  output wire [17:0] y,
  output wire last_out,
  output wire loads
);

wire [17:0] past_y;
wire [17:0] border_p;
wire [17:0] border_q;
wire mark_y;
wire marker_y;
wire [15:0] coefficient_g;
wire [17:0] lerp_y;

delay_18x2 past (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(x),
  .y(past_y)
);

look_ahead_border_2 border (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .last(last),
  .x(x),
  .past(past_y),
  .p(border_p),
  .q(border_q)
);

pulse_delay_6 mark (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(last),
  .y(mark_y)
);

pulse_delay_6 marker (
  .clock(clock),
  .reset(reset),
  .advance(advance),
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

assign last_out = mark_y;
assign loads = marker_y;
assign y = lerp_y;

endmodule
