// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// One two-sided first-order smoother of look-ahead m = 6; every cell is a lerp, y = p + g (q - p).
//   recursion    s[r] = lerp(p = s[r-1], q = x[r], g)                          4 steps
//   column_j     u[r] = lerp(p = u[min(r + 2^j, H-1)], q = u[r], g_j)   2^j lines and 4 steps, j = 0 .. m-1
//   back_j       u[c] = lerp(p = u[max(c - 2^j, 0)], q = u[c], g_j)            4 steps
//   ahead_j      u[c] = lerp(p = u[min(c + 2^j, W-1)], q = u[c], g_j)    2^j + 4 steps
// Markers are one step before the sample they belong to.
// Latency: 63 lines and 139 steps.
module smoother_6 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire [11:0] height,
  input  wire [9:0] address,
  input  wire [9:0] address_1,
  input  wire [9:0] address_4,
  input  wire [9:0] address_5,
  input  wire [9:0] address_8,
  input  wire [9:0] address_12,
  input  wire [9:0] address_16,
  input  wire [9:0] address_20,
  input  wire start,
  input  wire [17:0] x,
  input  wire [15:0] g,
  input  wire [15:0] column_g_0,
  input  wire [15:0] column_g_1,
  input  wire [15:0] column_g_2,
  input  wire [15:0] column_g_3,
  input  wire [15:0] column_g_4,
  input  wire [15:0] column_g_5,
  input  wire [15:0] row_g_0,
  input  wire [15:0] row_g_1,
  input  wire [15:0] row_g_2,
  input  wire [15:0] row_g_3,
  input  wire [15:0] row_g_4,
  input  wire [15:0] row_g_5,
  output wire columns_done,
  output wire [17:0] y,
  output wire start_out
);

wire cursor_active;
wire [9:0] cursor_x;
wire [10:0] cursor_y;
wire cursor_first_column;
wire cursor_last_column;
wire cursor_first_row;
wire cursor_last_row;
wire recursion_load_y;
wire [15:0] recursion_coefficient_g;
wire [17:0] recursion_memory_y;
wire [17:0] recursion_border_p;
wire [17:0] recursion_border_q;
wire [17:0] recursion_y;
wire last_row_y;
wire tail_start_y;
wire [5:0] tail_select;
wire [5:0] tail_outside;
wire [17:0] held_y;
wire [17:0] column_0_y;
wire column_0_loads;
wire [17:0] column_1_y;
wire column_1_loads;
wire [17:0] column_2_y;
wire column_2_loads;
wire [17:0] column_3_y;
wire column_3_loads;
wire [17:0] column_4_y;
wire column_4_loads;
wire [17:0] column_5_y;
wire column_5_loads;
wire column_start_y;
wire row_cursor_active;
wire [9:0] row_cursor_x;
wire [10:0] row_cursor_y;
wire row_cursor_first_column;
wire row_cursor_last_column;
wire row_cursor_first_row;
wire row_cursor_last_row;
wire row_load_y;
wire [17:0] back_0_y;
wire back_0_first_out;
wire back_0_load_out;
wire [17:0] back_1_y;
wire back_1_first_out;
wire back_1_load_out;
wire [17:0] back_2_y;
wire back_2_first_out;
wire back_2_load_out;
wire [17:0] back_3_y;
wire back_3_first_out;
wire back_3_load_out;
wire [17:0] back_4_y;
wire back_4_first_out;
wire back_4_load_out;
wire [17:0] back_5_y;
wire back_5_first_out;
wire back_5_load_out;
wire row_end_y;
wire [17:0] ahead_0_y;
wire ahead_0_last_out;
wire ahead_0_loads;
wire [17:0] ahead_1_y;
wire ahead_1_last_out;
wire ahead_1_loads;
wire [17:0] ahead_2_y;
wire ahead_2_last_out;
wire ahead_2_loads;
wire [17:0] ahead_3_y;
wire ahead_3_last_out;
wire ahead_3_loads;
wire [17:0] ahead_4_y;
wire ahead_4_last_out;
wire ahead_4_loads;
wire [17:0] ahead_5_y;
wire ahead_5_last_out;
wire ahead_5_loads;
wire row_start_y;

// Down the columns: the recursion, its state one line later through a memory.
cursor cursor (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .start(start),
  .active(cursor_active),
  .x(cursor_x),
  .y(cursor_y),
  .first_column(cursor_first_column),
  .last_column(cursor_last_column),
  .first_row(cursor_first_row),
  .last_row(cursor_last_row)
);

flag_delay_2 recursion_load (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(start),
  .y(recursion_load_y)
);

coefficient_register recursion_coefficient (
  .clock(clock),
  .advance(advance),
  .load(recursion_load_y),
  .d(g),
  .g(recursion_coefficient_g)
);

line_delay_18x1 recursion_memory (
  .clock(clock),
  .advance(advance),
  .address(address),
  .write_address(address_5),
  .x(recursion_y),
  .y(recursion_memory_y)
);

column_border recursion_border (
  .clock(clock),
  .advance(advance),
  .x(x),
  .neighbour(recursion_memory_y),
  .border(x),
  .outside(cursor_first_row),
  .p(recursion_border_p),
  .q(recursion_border_q)
);

lerp recursion (
  .clock(clock),
  .advance(advance),
  .p(recursion_border_p),
  .q(recursion_border_q),
  .g(recursion_coefficient_g),
  .y(recursion_y)
);

// The last row is held for the stages below.
flag_delay_4 last_row (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(cursor_last_row),
  .y(last_row_y)
);

flag_delay_2 tail_start (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(cursor_last_row & cursor_first_column),
  .y(tail_start_y)
);

tail_counter tail (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .start(tail_start_y),
  .select(tail_select),
  .outside(tail_outside)
);

held_row held (
  .clock(clock),
  .advance(advance),
  .write(last_row_y),
  .write_address(address_1),
  .x(recursion_y),
  .select(tail_select),
  .address_0(address),
  .address_1(address_4),
  .address_2(address_8),
  .address_3(address_12),
  .address_4(address_16),
  .address_5(address_20),
  .y(held_y)
);

// Up the columns: stage j leans on the row 2^j lines later.
column_stage_0 column_0 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .address(address),
  .write_address(address_1),
  .x(recursion_y),
  .held(held_y),
  .outside(tail_outside[0]),
  .load(recursion_load_y),
  .g(column_g_0),
  .y(column_0_y),
  .loads(column_0_loads)
);

column_stage_1 column_1 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .address(address),
  .write_address(address_1),
  .x(column_0_y),
  .held(held_y),
  .outside(tail_outside[1]),
  .load(column_0_loads),
  .g(column_g_1),
  .y(column_1_y),
  .loads(column_1_loads)
);

column_stage_2 column_2 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .address(address),
  .write_address(address_1),
  .x(column_1_y),
  .held(held_y),
  .outside(tail_outside[2]),
  .load(column_1_loads),
  .g(column_g_2),
  .y(column_2_y),
  .loads(column_2_loads)
);

column_stage_3 column_3 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .address(address),
  .write_address(address_1),
  .x(column_2_y),
  .held(held_y),
  .outside(tail_outside[3]),
  .load(column_2_loads),
  .g(column_g_3),
  .y(column_3_y),
  .loads(column_3_loads)
);

column_stage_4 column_4 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .address(address),
  .write_address(address_1),
  .x(column_3_y),
  .held(held_y),
  .outside(tail_outside[4]),
  .load(column_3_loads),
  .g(column_g_4),
  .y(column_4_y),
  .loads(column_4_loads)
);

column_stage_5 column_5 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .address(address),
  .write_address(address_1),
  .x(column_4_y),
  .held(held_y),
  .outside(tail_outside[5]),
  .load(column_4_loads),
  .g(column_g_5),
  .y(column_5_y),
  .loads(column_5_loads)
);

flag_delay_2 column_start (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(column_5_loads),
  .y(column_start_y)
);

assign columns_done = column_start_y;
// Along the rows: first towards the past, then towards the future.
cursor row_cursor (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .width(width),
  .height(height),
  .start(column_start_y),
  .active(row_cursor_active),
  .x(row_cursor_x),
  .y(row_cursor_y),
  .first_column(row_cursor_first_column),
  .last_column(row_cursor_last_column),
  .first_row(row_cursor_first_row),
  .last_row(row_cursor_last_row)
);

flag_delay_2 row_load (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(column_start_y),
  .y(row_load_y)
);

look_back_stage_0 back_0 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(column_5_y),
  .first(row_cursor_first_column),
  .load(row_load_y),
  .g(row_g_0),
  .y(back_0_y),
  .first_out(back_0_first_out),
  .load_out(back_0_load_out)
);

look_back_stage_1 back_1 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(back_0_y),
  .first(back_0_first_out),
  .load(back_0_load_out),
  .g(row_g_1),
  .y(back_1_y),
  .first_out(back_1_first_out),
  .load_out(back_1_load_out)
);

look_back_stage_2 back_2 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(back_1_y),
  .first(back_1_first_out),
  .load(back_1_load_out),
  .g(row_g_2),
  .y(back_2_y),
  .first_out(back_2_first_out),
  .load_out(back_2_load_out)
);

look_back_stage_3 back_3 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(back_2_y),
  .first(back_2_first_out),
  .load(back_2_load_out),
  .g(row_g_3),
  .y(back_3_y),
  .first_out(back_3_first_out),
  .load_out(back_3_load_out)
);

look_back_stage_4 back_4 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(back_3_y),
  .first(back_3_first_out),
  .load(back_3_load_out),
  .g(row_g_4),
  .y(back_4_y),
  .first_out(back_4_first_out),
  .load_out(back_4_load_out)
);

look_back_stage_5 back_5 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(back_4_y),
  .first(back_4_first_out),
  .load(back_4_load_out),
  .g(row_g_5),
  .y(back_5_y),
  .first_out(back_5_first_out),
  .load_out(back_5_load_out)
);

pulse_delay_24 row_end (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(row_cursor_last_column),
  .y(row_end_y)
);

look_ahead_stage_0 ahead_0 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(back_5_y),
  .last(row_end_y),
  .load(back_4_load_out),
  .g(row_g_0),
  .y(ahead_0_y),
  .last_out(ahead_0_last_out),
  .loads(ahead_0_loads)
);

look_ahead_stage_1 ahead_1 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(ahead_0_y),
  .last(ahead_0_last_out),
  .load(ahead_0_loads),
  .g(row_g_1),
  .y(ahead_1_y),
  .last_out(ahead_1_last_out),
  .loads(ahead_1_loads)
);

look_ahead_stage_2 ahead_2 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(ahead_1_y),
  .last(ahead_1_last_out),
  .load(ahead_1_loads),
  .g(row_g_2),
  .y(ahead_2_y),
  .last_out(ahead_2_last_out),
  .loads(ahead_2_loads)
);

look_ahead_stage_3 ahead_3 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(ahead_2_y),
  .last(ahead_2_last_out),
  .load(ahead_2_loads),
  .g(row_g_3),
  .y(ahead_3_y),
  .last_out(ahead_3_last_out),
  .loads(ahead_3_loads)
);

look_ahead_stage_4 ahead_4 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(ahead_3_y),
  .last(ahead_3_last_out),
  .load(ahead_3_loads),
  .g(row_g_4),
  .y(ahead_4_y),
  .last_out(ahead_4_last_out),
  .loads(ahead_4_loads)
);

look_ahead_stage_5 ahead_5 (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(ahead_4_y),
  .last(ahead_4_last_out),
  .load(ahead_4_loads),
  .g(row_g_5),
  .y(ahead_5_y),
  .last_out(ahead_5_last_out),
  .loads(ahead_5_loads)
);

flag_delay_2 row_start (
  .clock(clock),
  .reset(reset),
  .advance(advance),
  .x(ahead_5_loads),
  .y(row_start_y)
);

assign y = ahead_5_y;
assign start_out = row_start_y;

endmodule
