// y[n] = x[n - LINES W - STEPS] for a marker, by a counter: at least as long between markers.
// Latency: LINES lines and STEPS steps.
module frame_delay #(
  parameter LINES = 1,
  parameter STEPS = 1,
  parameter WIDTH_BITS = 11
) (
  input  wire clock,
  input  wire reset,
  input  wire advance,
  input  wire [WIDTH_BITS-1:0] width,
  input  wire x,
  output reg  y
);

// What the widest frame needs, and more than a width has.
localparam NEEDED = $clog2((LINES << (WIDTH_BITS - 1)) + STEPS);
localparam BITS = NEEDED > WIDTH_BITS ? NEEDED : WIDTH_BITS + 1;
localparam LOAD = STEPS - 1;
// LINES as the shortest sum of powers of two with signs: 15 = 16 - 1.
localparam PLUS = (3 * LINES & ~LINES) >> 1;
localparam MINUS = (LINES & ~(3 * LINES)) >> 1;

initial if (LINES < 1 || STEPS < 1) begin
  $error("%m: LINES is %0d and STEPS is %0d, not 1 or more", LINES, STEPS);
  $finish;
end

wire [BITS-1:0] one_line = {{BITS-WIDTH_BITS{1'b0}}, width};
reg [BITS-1:0] sum;
reg [BITS-1:0] total;
reg [BITS-1:0] remaining;
integer i;

always @(*) begin
  sum = LOAD[BITS-1:0];
  for (i = 0; i < BITS; i = i + 1) begin
    if (PLUS[i])
      sum = sum + (one_line << i);
    if (MINUS[i])
      sum = sum - (one_line << i);
  end
end

always @(posedge clock)
  total <= sum;

always @(posedge clock)
  if (reset) begin
    remaining <= 0;
    y <= 1'b0;
  end else if (advance) begin
    y <= remaining == 1;
    if (x)
      remaining <= total;
    else if (remaining != 0)
      remaining <= remaining - 1;
  end

endmodule
