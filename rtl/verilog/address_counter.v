// Made by `hoverlock rtl emit` from the Rust sources in rtl/src. Do not edit: the check would find it stale.

// The address of all line memories: now[n] = n mod W, counted in steps, and before_k[n] = now[n - k].
// Latency: none; the counter is a register.
module address_counter (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [10:0] width,
  output reg  [9:0] now,
  output reg  [9:0] before_1,
  output reg  [9:0] before_4,
  output reg  [9:0] before_5,
  output reg  [9:0] before_8,
  output reg  [9:0] before_12,
  output reg  [9:0] before_16,
  output reg  [9:0] before_20
);

wire [10:0] last = width - 11'd1;
reg [199:0] past;

always @(posedge clock)
  if (reset) begin
    now  <= 10'd0;
    past <= 200'd0;
  end else if (advance) begin
    now  <= {1'b0, now} >= last ? 10'd0 : now + 10'd1;
    past <= {past[189:0], now};
  end else if ({1'b0, now} > last)
    now  <= 10'd0; // the width fell since the last step

always @(*) begin
  before_1 = past[9:0];
  before_4 = past[39:30];
  before_5 = past[49:40];
  before_8 = past[79:70];
  before_12 = past[119:110];
  before_16 = past[159:150];
  before_20 = past[199:190];
end

endmodule
