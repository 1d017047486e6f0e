// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The three smoothers on the same pixels, aligned: the two short ones wait 32 lines and 44 steps for the long one.
//   wait_lines, wait_one, wait_two   x[n - 32 W - 44], as pixels: 16 bits in place of two smoothed states
//   late_bank                        coefficients of the frame that leaves that wait
//   rows_bank                        coefficients of the frame that leaves the columns, for all rows and the window
// `start` and `start_out` are one step before a frame's first sample.
// Latency: 63 lines and 139 steps from `pixel` to `narrow`, `middle` and `wide`.
module smoothers (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire [11:0] height,
  input  wire start,
  input  wire [15:0] pixel,
  input  wire [367:0] frame_bank,
  output wire [367:0] window_bank,
  output wire [9:0] address,
  output wire [9:0] address_1,
  output wire [17:0] narrow,
  output wire [17:0] middle,
  output wire [17:0] wide,
  output wire start_out
);

wire [9:0] counter_now;
wire [9:0] counter_before_1;
wire [9:0] counter_before_4;
wire [9:0] counter_before_5;
wire [9:0] counter_before_8;
wire [9:0] counter_before_12;
wire [9:0] counter_before_16;
wire [9:0] counter_before_20;
wire [15:0] wait_lines_y;
wire [15:0] wait_one_y;
wire [15:0] wait_two_y;
wire wait_start_y;
wire [367:0] late_bank_q;
wire [367:0] rows_bank_q;
wire [17:0] late_state_y;
wire [17:0] state_y;
wire narrow_smoother_columns_done;
wire [17:0] narrow_smoother_y;
wire narrow_smoother_start_out;
wire middle_smoother_columns_done;
wire [17:0] middle_smoother_y;
wire middle_smoother_start_out;
wire wide_smoother_columns_done;
wire [17:0] wide_smoother_y;
wire wide_smoother_start_out;

address_counter counter (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .now(counter_now),
  .before_1(counter_before_1),
  .before_4(counter_before_4),
  .before_5(counter_before_5),
  .before_8(counter_before_8),
  .before_12(counter_before_12),
  .before_16(counter_before_16),
  .before_20(counter_before_20)
);

assign address = counter_now;
assign address_1 = counter_before_1;
// The wide smoother is 32 lines and 44 steps longer than the others, whose pixels wait for it.
line_delay_16x32 wait_lines (
  .clock(clock),
  .advance(advance),
  .address(counter_now),
  .write_address(counter_before_1),
  .x(pixel),
  .y(wait_lines_y)
);

delay_16x22 wait_one (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(wait_lines_y),
  .y(wait_one_y)
);

delay_16x22 wait_two (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(wait_one_y),
  .y(wait_two_y)
);

frame_delay_32x44 wait_start (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .x(start),
  .y(wait_start_y)
);

pixel_state late_state (
  .x(wait_two_y),
  .y(late_state_y)
);

pixel_state state (
  .x(pixel),
  .y(state_y)
);

// Coefficients: of the frame for the wide columns, then for the other columns, then for all rows.
bank late_bank (
  .clock(clock),
  .load(wait_start_y),
  .d(frame_bank),
  .q(late_bank_q)
);

bank rows_bank (
  .clock(clock),
  .load(wide_smoother_columns_done),
  .d(frame_bank),
  .q(rows_bank_q)
);

smoother_5 narrow_smoother (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .address(counter_now),
  .address_1(counter_before_1),
  .address_4(counter_before_4),
  .address_5(counter_before_5),
  .address_8(counter_before_8),
  .address_12(counter_before_12),
  .address_16(counter_before_16),
  .address_20(counter_before_20),
  .start(wait_start_y),
  .x(late_state_y),
  .g(late_bank_q[(32'h0)+:(16)]),
  .column_g_0(late_bank_q[(32'h10)+:(16)]),
  .column_g_1(late_bank_q[(32'h20)+:(16)]),
  .column_g_2(late_bank_q[(32'h30)+:(16)]),
  .column_g_3(late_bank_q[(32'h40)+:(16)]),
  .column_g_4(late_bank_q[(32'h50)+:(16)]),
  .row_g_0(rows_bank_q[(32'h10)+:(16)]),
  .row_g_1(rows_bank_q[(32'h20)+:(16)]),
  .row_g_2(rows_bank_q[(32'h30)+:(16)]),
  .row_g_3(rows_bank_q[(32'h40)+:(16)]),
  .row_g_4(rows_bank_q[(32'h50)+:(16)]),
  .columns_done(narrow_smoother_columns_done),
  .y(narrow_smoother_y),
  .start_out(narrow_smoother_start_out)
);

smoother_5 middle_smoother (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .address(counter_now),
  .address_1(counter_before_1),
  .address_4(counter_before_4),
  .address_5(counter_before_5),
  .address_8(counter_before_8),
  .address_12(counter_before_12),
  .address_16(counter_before_16),
  .address_20(counter_before_20),
  .start(wait_start_y),
  .x(late_state_y),
  .g(late_bank_q[(32'h60)+:(16)]),
  .column_g_0(late_bank_q[(32'h70)+:(16)]),
  .column_g_1(late_bank_q[(32'h80)+:(16)]),
  .column_g_2(late_bank_q[(32'h90)+:(16)]),
  .column_g_3(late_bank_q[(32'ha0)+:(16)]),
  .column_g_4(late_bank_q[(32'hb0)+:(16)]),
  .row_g_0(rows_bank_q[(32'h70)+:(16)]),
  .row_g_1(rows_bank_q[(32'h80)+:(16)]),
  .row_g_2(rows_bank_q[(32'h90)+:(16)]),
  .row_g_3(rows_bank_q[(32'ha0)+:(16)]),
  .row_g_4(rows_bank_q[(32'hb0)+:(16)]),
  .columns_done(middle_smoother_columns_done),
  .y(middle_smoother_y),
  .start_out(middle_smoother_start_out)
);

smoother_6 wide_smoother (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .address(counter_now),
  .address_1(counter_before_1),
  .address_4(counter_before_4),
  .address_5(counter_before_5),
  .address_8(counter_before_8),
  .address_12(counter_before_12),
  .address_16(counter_before_16),
  .address_20(counter_before_20),
  .start(start),
  .x(state_y),
  .g(frame_bank[(32'hc0)+:(16)]),
  .column_g_0(frame_bank[(32'hd0)+:(16)]),
  .column_g_1(frame_bank[(32'he0)+:(16)]),
  .column_g_2(frame_bank[(32'hf0)+:(16)]),
  .column_g_3(frame_bank[(32'h100)+:(16)]),
  .column_g_4(frame_bank[(32'h110)+:(16)]),
  .column_g_5(frame_bank[(32'h120)+:(16)]),
  .row_g_0(rows_bank_q[(32'hd0)+:(16)]),
  .row_g_1(rows_bank_q[(32'he0)+:(16)]),
  .row_g_2(rows_bank_q[(32'hf0)+:(16)]),
  .row_g_3(rows_bank_q[(32'h100)+:(16)]),
  .row_g_4(rows_bank_q[(32'h110)+:(16)]),
  .row_g_5(rows_bank_q[(32'h120)+:(16)]),
  .columns_done(wide_smoother_columns_done),
  .y(wide_smoother_y),
  .start_out(wide_smoother_start_out)
);

assign window_bank = rows_bank_q;
assign narrow = narrow_smoother_y;
assign middle = middle_smoother_y;
assign wide = wide_smoother_y;
assign start_out = wide_smoother_start_out;

endmodule
