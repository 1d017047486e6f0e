// y[n] = x[n - k W] for each k of which bit k - 1 of TAPS is set, the newest lowest: ROWS rows of a column are one
// memory word, read, shifted by one row and written back.
// The address counts steps modulo W, so a frame may begin at any address. Only samples that the frame itself wrote are
// used.
// Latency: 1 to ROWS lines.
module line_delay #(
  parameter BITS = 16,
  parameter ROWS = 1,
  parameter [ROWS-1:0] TAPS = 1,
  parameter OUTPUTS = 1,
  parameter ADDRESS_BITS = 10
) (
  input  wire clock,
  input  wire advance,
  input  wire [ADDRESS_BITS-1:0] address,
  input  wire [ADDRESS_BITS-1:0] write_address,
  input  wire [BITS-1:0] x,
  output wire [BITS*OUTPUTS-1:0] y
);

localparam WORDS = 1 << ADDRESS_BITS;

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

reg [BITS*ROWS-1:0] memory [0:WORDS-1];
reg [BITS*ROWS-1:0] column;
wire [BITS*(ROWS+1)-1:0] shifted = {column, x};

always @(posedge clock)
  if (advance) begin
    column <= memory[address];
    memory[write_address] <= shifted[BITS*ROWS-1:0];
  end

genvar k;
generate
  for (k = 0; k < ROWS; k = k + 1) begin : tap
    if (TAPS[k]) begin : used
      assign y[BITS*taps_below(k) +: BITS] = column[BITS*k +: BITS];
    end
  end
endgenerate

wire unused = ^shifted[BITS*(ROWS+1)-1:BITS*ROWS];

endmodule
