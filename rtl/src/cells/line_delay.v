// y[n] = x[n - k W] for each k of which bit k - 1 of TAPS is set, the newest lowest: ROWS rows of a column are one
// memory word, read, shifted by one row and written back.
// The address counts steps modulo W, so a frame may begin at any address. Only samples that the frame itself wrote are
// used.
// A read takes READ steps, 2 where logic follows: the word then comes from a register, and `write_address` is a step
// older.
// Latency: 1 to ROWS lines.
module line_delay #(
  parameter BITS = 16,
  parameter ROWS = 1,
  parameter [ROWS-1:0] TAPS = 1,
  parameter OUTPUTS = 1,
  parameter ADDRESS_BITS = 10,
  parameter READ = 1
) (
  input  wire clock,
  input  wire advance,
  input  wire [ADDRESS_BITS-1:0] address,
  input  wire [ADDRESS_BITS-1:0] write_address,
  input  wire [BITS-1:0] x,
  output wire [BITS*OUTPUTS-1:0] y
);

localparam WORDS = 1 << ADDRESS_BITS;
localparam WORD = BITS*ROWS;

// The number of taps below a row.
function integer taps_below(input integer row);
  integer i;
  begin
    taps_below = 0;
    for (i = 0; i < row; i = i + 1)
      taps_below = taps_below + (TAPS[i] ? 1 : 0);
  end
endfunction

initial if (taps_below(ROWS) != OUTPUTS) begin
  $error("%m: TAPS has %0d bits set, and OUTPUTS is %0d", taps_below(ROWS), OUTPUTS);
  $finish;
end

initial if (READ < 1 || READ > 2) begin
  $error("%m: READ is 1 or 2, not %0d", READ);
  $finish;
end

reg [WORD-1:0] memory [0:WORDS-1];
reg [WORD*READ-1:0] words;
wire [WORD-1:0] column = words[WORD*(READ-1) +: WORD];
wire [WORD+BITS-1:0] shifted = {column, x};

always @(posedge clock)
  if (advance) begin
    words[WORD-1:0] <= memory[address];
    memory[write_address] <= shifted[WORD-1:0];
  end

generate
  if (READ == 2) begin : registered
    always @(posedge clock)
      if (advance)
        words[WORD +: WORD] <= words[WORD-1:0];
  end
endgenerate

genvar k;
generate
  for (k = 0; k < ROWS; k = k + 1) begin : tap
    if (TAPS[k]) begin : used
      assign y[BITS*taps_below(k) +: BITS] = column[BITS*k +: BITS];
    end
  end
endgenerate

wire unused = ^shifted[WORD +: BITS];

endmodule
