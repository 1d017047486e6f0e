// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The 32 points of a ring side by side: o_i = round(R (cos, sin)(2 pi i / 32)), row by row from a line delay, then as many steps as
// each point's column asks for; points of one row share a chain.
// Latency: 1 step for the point furthest right, 2 R + 1 for the one furthest left.
module ring_taps_0 (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [239:0] rows,
  output reg  [511:0] points
);

// 4 lines before the newest
reg [15:0] point_7;
reg [15:0] point_7_memory [0:12];
reg [3:0] point_7_place;

always @(posedge clock)
  if (reset)
    point_7_place <= 4'd0;
  else if (advance)
    point_7_place <= point_7_place == 4'd12 ? 4'd0 : point_7_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_7 <= point_7_memory[point_7_place];
    point_7_memory[point_7_place] <= rows[15:0];
  end
reg [15:0] point_8_past_1;
reg [15:0] point_8;

always @(posedge clock)
  if (advance) begin
    point_8_past_1 <= point_7;
    point_8 <= point_8_past_1;
  end
reg [15:0] point_9_past_1;
reg [15:0] point_9;

always @(posedge clock)
  if (advance) begin
    point_9_past_1 <= point_8;
    point_9 <= point_9_past_1;
  end
// 5 lines before the newest
reg [15:0] point_6;
reg [15:0] point_6_memory [0:9];
reg [3:0] point_6_place;

always @(posedge clock)
  if (reset)
    point_6_place <= 4'd0;
  else if (advance)
    point_6_place <= point_6_place == 4'd9 ? 4'd0 : point_6_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_6 <= point_6_memory[point_6_place];
    point_6_memory[point_6_place] <= rows[31:16];
  end
reg [15:0] point_10;
reg [15:0] point_10_memory [0:8];
reg [3:0] point_10_place;

always @(posedge clock)
  if (reset)
    point_10_place <= 4'd0;
  else if (advance)
    point_10_place <= point_10_place == 4'd8 ? 4'd0 : point_10_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_10 <= point_10_memory[point_10_place];
    point_10_memory[point_10_place] <= point_6;
  end
// 6 lines before the newest
reg [15:0] point_5;
reg [15:0] point_5_memory [0:7];
reg [2:0] point_5_place;

always @(posedge clock)
  if (reset)
    point_5_place <= 3'd0;
  else if (advance)
    point_5_place <= point_5_place == 3'd7 ? 3'd0 : point_5_place + 3'd1;

always @(posedge clock)
  if (advance) begin
    point_5 <= point_5_memory[point_5_place];
    point_5_memory[point_5_place] <= rows[47:32];
  end
reg [15:0] point_11;
reg [15:0] point_11_memory [0:12];
reg [3:0] point_11_place;

always @(posedge clock)
  if (reset)
    point_11_place <= 4'd0;
  else if (advance)
    point_11_place <= point_11_place == 4'd12 ? 4'd0 : point_11_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_11 <= point_11_memory[point_11_place];
    point_11_memory[point_11_place] <= point_5;
  end
// 8 lines before the newest
reg [15:0] point_4;
reg [15:0] point_4_memory [0:6];
reg [2:0] point_4_place;

always @(posedge clock)
  if (reset)
    point_4_place <= 3'd0;
  else if (advance)
    point_4_place <= point_4_place == 3'd6 ? 3'd0 : point_4_place + 3'd1;

always @(posedge clock)
  if (advance) begin
    point_4 <= point_4_memory[point_4_place];
    point_4_memory[point_4_place] <= rows[63:48];
  end
reg [15:0] point_12;
reg [15:0] point_12_memory [0:14];
reg [3:0] point_12_place;

always @(posedge clock)
  if (reset)
    point_12_place <= 4'd0;
  else if (advance)
    point_12_place <= point_12_place == 4'd14 ? 4'd0 : point_12_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_12 <= point_12_memory[point_12_place];
    point_12_memory[point_12_place] <= point_4;
  end
// 9 lines before the newest
reg [15:0] point_3;
reg [15:0] point_3_memory [0:4];
reg [2:0] point_3_place;

always @(posedge clock)
  if (reset)
    point_3_place <= 3'd0;
  else if (advance)
    point_3_place <= point_3_place == 3'd4 ? 3'd0 : point_3_place + 3'd1;

always @(posedge clock)
  if (advance) begin
    point_3 <= point_3_memory[point_3_place];
    point_3_memory[point_3_place] <= rows[79:64];
  end
reg [15:0] point_13;
reg [15:0] point_13_memory [0:18];
reg [4:0] point_13_place;

always @(posedge clock)
  if (reset)
    point_13_place <= 5'd0;
  else if (advance)
    point_13_place <= point_13_place == 5'd18 ? 5'd0 : point_13_place + 5'd1;

always @(posedge clock)
  if (advance) begin
    point_13 <= point_13_memory[point_13_place];
    point_13_memory[point_13_place] <= point_3;
  end
// 11 lines before the newest
reg [15:0] point_2;
reg [15:0] point_2_memory [0:3];
reg [1:0] point_2_place;

always @(posedge clock)
  if (reset)
    point_2_place <= 2'd0;
  else if (advance)
    point_2_place <= point_2_place == 2'd3 ? 2'd0 : point_2_place + 2'd1;

always @(posedge clock)
  if (advance) begin
    point_2 <= point_2_memory[point_2_place];
    point_2_memory[point_2_place] <= rows[95:80];
  end
reg [15:0] point_14;
reg [15:0] point_14_memory [0:20];
reg [4:0] point_14_place;

always @(posedge clock)
  if (reset)
    point_14_place <= 5'd0;
  else if (advance)
    point_14_place <= point_14_place == 5'd20 ? 5'd0 : point_14_place + 5'd1;

always @(posedge clock)
  if (advance) begin
    point_14 <= point_14_memory[point_14_place];
    point_14_memory[point_14_place] <= point_2;
  end
// 14 lines before the newest
reg [15:0] point_1;
reg [15:0] point_1_memory [0:2];
reg [1:0] point_1_place;

always @(posedge clock)
  if (reset)
    point_1_place <= 2'd0;
  else if (advance)
    point_1_place <= point_1_place == 2'd2 ? 2'd0 : point_1_place + 2'd1;

always @(posedge clock)
  if (advance) begin
    point_1 <= point_1_memory[point_1_place];
    point_1_memory[point_1_place] <= rows[111:96];
  end
reg [15:0] point_15;
reg [15:0] point_15_memory [0:22];
reg [4:0] point_15_place;

always @(posedge clock)
  if (reset)
    point_15_place <= 5'd0;
  else if (advance)
    point_15_place <= point_15_place == 5'd22 ? 5'd0 : point_15_place + 5'd1;

always @(posedge clock)
  if (advance) begin
    point_15 <= point_15_memory[point_15_place];
    point_15_memory[point_15_place] <= point_1;
  end
// 16 lines before the newest
reg [15:0] point_0;
reg [15:0] point_0_memory [0:2];
reg [1:0] point_0_place;

always @(posedge clock)
  if (reset)
    point_0_place <= 2'd0;
  else if (advance)
    point_0_place <= point_0_place == 2'd2 ? 2'd0 : point_0_place + 2'd1;

always @(posedge clock)
  if (advance) begin
    point_0 <= point_0_memory[point_0_place];
    point_0_memory[point_0_place] <= rows[127:112];
  end
reg [15:0] point_16;
reg [15:0] point_16_memory [0:22];
reg [4:0] point_16_place;

always @(posedge clock)
  if (reset)
    point_16_place <= 5'd0;
  else if (advance)
    point_16_place <= point_16_place == 5'd22 ? 5'd0 : point_16_place + 5'd1;

always @(posedge clock)
  if (advance) begin
    point_16 <= point_16_memory[point_16_place];
    point_16_memory[point_16_place] <= point_0;
  end
// 18 lines before the newest
reg [15:0] point_31;
reg [15:0] point_31_memory [0:2];
reg [1:0] point_31_place;

always @(posedge clock)
  if (reset)
    point_31_place <= 2'd0;
  else if (advance)
    point_31_place <= point_31_place == 2'd2 ? 2'd0 : point_31_place + 2'd1;

always @(posedge clock)
  if (advance) begin
    point_31 <= point_31_memory[point_31_place];
    point_31_memory[point_31_place] <= rows[143:128];
  end
reg [15:0] point_17;
reg [15:0] point_17_memory [0:22];
reg [4:0] point_17_place;

always @(posedge clock)
  if (reset)
    point_17_place <= 5'd0;
  else if (advance)
    point_17_place <= point_17_place == 5'd22 ? 5'd0 : point_17_place + 5'd1;

always @(posedge clock)
  if (advance) begin
    point_17 <= point_17_memory[point_17_place];
    point_17_memory[point_17_place] <= point_31;
  end
// 21 lines before the newest
reg [15:0] point_30;
reg [15:0] point_30_memory [0:3];
reg [1:0] point_30_place;

always @(posedge clock)
  if (reset)
    point_30_place <= 2'd0;
  else if (advance)
    point_30_place <= point_30_place == 2'd3 ? 2'd0 : point_30_place + 2'd1;

always @(posedge clock)
  if (advance) begin
    point_30 <= point_30_memory[point_30_place];
    point_30_memory[point_30_place] <= rows[159:144];
  end
reg [15:0] point_18;
reg [15:0] point_18_memory [0:20];
reg [4:0] point_18_place;

always @(posedge clock)
  if (reset)
    point_18_place <= 5'd0;
  else if (advance)
    point_18_place <= point_18_place == 5'd20 ? 5'd0 : point_18_place + 5'd1;

always @(posedge clock)
  if (advance) begin
    point_18 <= point_18_memory[point_18_place];
    point_18_memory[point_18_place] <= point_30;
  end
// 23 lines before the newest
reg [15:0] point_29;
reg [15:0] point_29_memory [0:4];
reg [2:0] point_29_place;

always @(posedge clock)
  if (reset)
    point_29_place <= 3'd0;
  else if (advance)
    point_29_place <= point_29_place == 3'd4 ? 3'd0 : point_29_place + 3'd1;

always @(posedge clock)
  if (advance) begin
    point_29 <= point_29_memory[point_29_place];
    point_29_memory[point_29_place] <= rows[175:160];
  end
reg [15:0] point_19;
reg [15:0] point_19_memory [0:18];
reg [4:0] point_19_place;

always @(posedge clock)
  if (reset)
    point_19_place <= 5'd0;
  else if (advance)
    point_19_place <= point_19_place == 5'd18 ? 5'd0 : point_19_place + 5'd1;

always @(posedge clock)
  if (advance) begin
    point_19 <= point_19_memory[point_19_place];
    point_19_memory[point_19_place] <= point_29;
  end
// 24 lines before the newest
reg [15:0] point_28;
reg [15:0] point_28_memory [0:6];
reg [2:0] point_28_place;

always @(posedge clock)
  if (reset)
    point_28_place <= 3'd0;
  else if (advance)
    point_28_place <= point_28_place == 3'd6 ? 3'd0 : point_28_place + 3'd1;

always @(posedge clock)
  if (advance) begin
    point_28 <= point_28_memory[point_28_place];
    point_28_memory[point_28_place] <= rows[191:176];
  end
reg [15:0] point_20;
reg [15:0] point_20_memory [0:14];
reg [3:0] point_20_place;

always @(posedge clock)
  if (reset)
    point_20_place <= 4'd0;
  else if (advance)
    point_20_place <= point_20_place == 4'd14 ? 4'd0 : point_20_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_20 <= point_20_memory[point_20_place];
    point_20_memory[point_20_place] <= point_28;
  end
// 26 lines before the newest
reg [15:0] point_27;
reg [15:0] point_27_memory [0:7];
reg [2:0] point_27_place;

always @(posedge clock)
  if (reset)
    point_27_place <= 3'd0;
  else if (advance)
    point_27_place <= point_27_place == 3'd7 ? 3'd0 : point_27_place + 3'd1;

always @(posedge clock)
  if (advance) begin
    point_27 <= point_27_memory[point_27_place];
    point_27_memory[point_27_place] <= rows[207:192];
  end
reg [15:0] point_21;
reg [15:0] point_21_memory [0:12];
reg [3:0] point_21_place;

always @(posedge clock)
  if (reset)
    point_21_place <= 4'd0;
  else if (advance)
    point_21_place <= point_21_place == 4'd12 ? 4'd0 : point_21_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_21 <= point_21_memory[point_21_place];
    point_21_memory[point_21_place] <= point_27;
  end
// 27 lines before the newest
reg [15:0] point_26;
reg [15:0] point_26_memory [0:9];
reg [3:0] point_26_place;

always @(posedge clock)
  if (reset)
    point_26_place <= 4'd0;
  else if (advance)
    point_26_place <= point_26_place == 4'd9 ? 4'd0 : point_26_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_26 <= point_26_memory[point_26_place];
    point_26_memory[point_26_place] <= rows[223:208];
  end
reg [15:0] point_22;
reg [15:0] point_22_memory [0:8];
reg [3:0] point_22_place;

always @(posedge clock)
  if (reset)
    point_22_place <= 4'd0;
  else if (advance)
    point_22_place <= point_22_place == 4'd8 ? 4'd0 : point_22_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_22 <= point_22_memory[point_22_place];
    point_22_memory[point_22_place] <= point_26;
  end
// 28 lines before the newest
reg [15:0] point_25;
reg [15:0] point_25_memory [0:12];
reg [3:0] point_25_place;

always @(posedge clock)
  if (reset)
    point_25_place <= 4'd0;
  else if (advance)
    point_25_place <= point_25_place == 4'd12 ? 4'd0 : point_25_place + 4'd1;

always @(posedge clock)
  if (advance) begin
    point_25 <= point_25_memory[point_25_place];
    point_25_memory[point_25_place] <= rows[239:224];
  end
reg [15:0] point_24_past_1;
reg [15:0] point_24;

always @(posedge clock)
  if (advance) begin
    point_24_past_1 <= point_25;
    point_24 <= point_24_past_1;
  end
reg [15:0] point_23_past_1;
reg [15:0] point_23;

always @(posedge clock)
  if (advance) begin
    point_23_past_1 <= point_24;
    point_23 <= point_23_past_1;
  end

always @(*)
  points = {point_31, point_30, point_29, point_28, point_27, point_26, point_25, point_24, point_23, point_22, point_21, point_20, point_19, point_18, point_17, point_16, point_15, point_14, point_13, point_12, point_11, point_10, point_9, point_8, point_7, point_6, point_5, point_4, point_3, point_2, point_1, point_0};

endmodule
