// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// One scale pair: DOG, the maxima of its 7x7 window apart by raster order, and MaxDOG of 5x5.
//   step 2   response        step 5   maxima of a column      step 9   strict, loose and p of the centre (3 lines, 3 columns back)
//   step 8   ring (2 lines, 2 columns back)                  step 10  centre and its neighbours
// Latency: 2 steps to the response, 3 lines and 12 steps from a pixel's states to the operands of its decision.
module layer (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [9:0] address,
  input  wire [9:0] address_1,
  input  wire [17:0] narrow,
  input  wire [17:0] wide,
  output wire [15:0] response,
  output wire saturated,
  output wire [14:0] strict,
  output wire [14:0] loose,
  output wire [15:0] p,
  output wire [15:0] centre,
  output wire [59:0] neighbours,
  output wire [15:0] ring
);

wire [14:0] difference_magnitude;
wire difference_positive;
wire difference_saturated;
wire [15:0] signed_response_y;
wire [95:0] lines_y;
wire [14:0] column_later;
wire [14:0] column_middle;
wire [14:0] column_earlier;
wire [14:0] column_five;
wire [14:0] later_y;
wire [14:0] earlier_y;
wire [14:0] same_row_y;
wire [14:0] max_dog_y;
wire [14:0] preceding_y;
wire [14:0] following_y;
wire [14:0] strict_maximum_y;
wire [14:0] loose_maximum_y;
wire [15:0] right_y;
wire [15:0] middle_y;
wire [15:0] left_y;
wire [15:0] upper_y;
wire [15:0] lower_y;
wire [59:0] around_y;
wire sign_y;
wire [15:0] ring_word_y;

difference difference (
  .clock(clock),
  .advance(advance),
  .narrow(narrow),
  .wide(wide),
  .magnitude(difference_magnitude),
  .positive(difference_positive),
  .saturated(difference_saturated)
);

signed_response signed_response (
  .magnitude(difference_magnitude),
  .positive(difference_positive),
  .y(signed_response_y)
);

assign saturated = difference_saturated;
assign response = signed_response_y;
// Seven rows of one column, their maxima, and the maxima of those along the rows.
line_delay_16x6_all lines (
  .clock(clock),
  .advance(advance),
  .address(address),
  .write_address(address_1),
  .x(signed_response_y),
  .y(lines_y)
);

column_maximum column (
  .clock(clock),
  .advance(advance),
  .newest(difference_magnitude),
  .older(lines_y),
  .later(column_later),
  .middle(column_middle),
  .earlier(column_earlier),
  .five(column_five)
);

window_maximum_7 later (
  .clock(clock),
  .advance(advance),
  .x(column_later),
  .y(later_y)
);

window_maximum_7 earlier (
  .clock(clock),
  .advance(advance),
  .x(column_earlier),
  .y(earlier_y)
);

window_maximum_3 same_row (
  .clock(clock),
  .advance(advance),
  .x(column_middle),
  .y(same_row_y)
);

window_maximum_5 max_dog (
  .clock(clock),
  .advance(advance),
  .x(column_five),
  .y(max_dog_y)
);

// In the centre row: three before the centre, three after it.
delay_15x5 preceding (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(same_row_y),
  .y(preceding_y)
);

delay_15x1 following (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(same_row_y),
  .y(following_y)
);

maximum strict_maximum (
  .clock(clock),
  .advance(advance),
  .a(earlier_y),
  .b(preceding_y),
  .y(strict_maximum_y)
);

maximum loose_maximum (
  .clock(clock),
  .advance(advance),
  .a(later_y),
  .b(following_y),
  .y(loose_maximum_y)
);

assign strict = strict_maximum_y;
assign loose = loose_maximum_y;
// The centre and its neighbours.
delay_16x10 right (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(lines_y[(32'h20)+:(16)]),
  .y(right_y)
);

delay_16x1 middle (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(right_y),
  .y(middle_y)
);

delay_16x1 left (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(middle_y),
  .y(left_y)
);

delay_16x11 upper (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(lines_y[(32'h30)+:(16)]),
  .y(upper_y)
);

delay_16x11 lower (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(lines_y[(32'h10)+:(16)]),
  .y(lower_y)
);

neighbours around (
  .left(left_y),
  .right(right_y),
  .up(upper_y),
  .down(lower_y),
  .y(around_y)
);

assign p = right_y;
assign centre = middle_y;
assign neighbours = around_y;
// MaxDOG and the sign at the centre of its window.
flag_delay_8 sign (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(lines_y[32'h1f]),
  .y(sign_y)
);

signed_response ring_word (
  .magnitude(max_dog_y),
  .positive(sign_y),
  .y(ring_word_y)
);

assign ring = ring_word_y;

endmodule
