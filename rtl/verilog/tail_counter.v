// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// Which column stage needs the held last row: stage j for 2^j <= n < 2^(j+1) lines n after that row, its pipeline 4 j steps later.
// Latency: `select` 1 step before the sample that needs the row, `outside` together with it.
module tail_counter (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  input  wire start,
  output reg  [5:0] select,
  output reg  [5:0] outside
);

reg [9:0] x;
reg [5:0] line;
reg       active;
wire [10:0] last_x = width - 11'd1;
wire [5:0] band;
assign band[5] = active & line[5];
assign band[4] = active & (line[5:4] == 2'd1);
assign band[3] = active & (line[5:3] == 3'd1);
assign band[2] = active & (line[5:2] == 4'd1);
assign band[1] = active & (line[5:1] == 5'd1);
assign band[0] = active & (line == 6'd1);

// Each stage's bit and its past, the newest lowest.
reg        past_0;
reg [4:0]  past_1;
reg [8:0]  past_2;
reg [12:0] past_3;
reg [16:0] past_4;
reg [20:0] past_5;

always @(posedge clock)
  if (reset) begin
    past_0 <= 1'd0;
    past_1 <= 5'd0;
    past_2 <= 9'd0;
    past_3 <= 13'd0;
    past_4 <= 17'd0;
    past_5 <= 21'd0;
  end else if (advance) begin
    past_0 <= band[0];
    past_1 <= {past_1[3:0], band[1]};
    past_2 <= {past_2[7:0], band[2]};
    past_3 <= {past_3[11:0], band[3]};
    past_4 <= {past_4[15:0], band[4]};
    past_5 <= {past_5[19:0], band[5]};
  end

always @(posedge clock)
  if (reset) begin
    active <= 1'b0;
    line   <= 6'd0;
    x      <= 10'd0;
  end else if (advance) begin
    if (start) begin
      active <= 1'b1;
      line   <= 6'd0;
      x      <= 10'd0;
    end else if ({1'b0, x} == last_x) begin
      active <= active & (line != 6'd63);
      line   <= line + 6'd1;
      x      <= 10'd0;
    end else
      x <= x + 10'd1;
  end

always @(*) begin
  select  = {past_5[19], past_4[15], past_3[11], past_2[7], past_1[3], band[0]};
  outside = {past_5[20], past_4[16], past_3[12], past_2[8], past_1[4], past_0};
end

endmodule
